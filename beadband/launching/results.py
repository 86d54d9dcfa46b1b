"""Results of a launch: everything of a release's, and what the finger and the flight add; for programs and people."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from beadband import results
from beadband.analysis.launch import LaunchMeasurement, Watch
from beadband.analysis.tip import Array
from beadband.launching.contact import Support
from beadband.launching.plan import DEPTH_BOUND, LaunchPlan
from beadband.results import Run

MOMENTUM_BOUND = 1e-6
"""Largest difference of momentum and impulse over the momentum."""
ASIDE_BOUND = 0.01
"""Way of the rear off the axis, over the thickness, from which on it is worth a warning."""


@dataclass(frozen=True)
class LaunchEstimate:
    """The same launch with another number of beads, from which errors are judged."""

    beads: int
    centre_of_mass_speed_m_s: float
    efficiency: float
    momentum_n_s: float
    finger_free_s: float | None
    rear_arrival_s: float | None
    pause_s: float | None

    @classmethod
    def of(cls, beads: int, found: LaunchMeasurement) -> LaunchEstimate:
        """Note what a launch with so many beads found."""
        return cls(
            beads,
            found.centre_of_mass_speed_m_s,
            found.efficiency,
            found.momentum_n_s,
            found.finger_free_s,
            found.rear_arrival_s,
            found.pause_s,
        )


@dataclass(frozen=True)
class Launch:
    """A finished launch."""

    run: Run
    """The same as a release: its rear, its curvature, its energies."""
    plan: LaunchPlan
    support: Support
    watch: Watch
    found: LaunchMeasurement
    clearance_m: Array
    """Shape (lines,): from the rear tip to the finger's surface, along the axis."""
    crossed_s: float | None
    """First frame in which the band crosses itself, which beads do and bands don't."""
    aside_m: float
    """Largest distance of the rear tip from the axis of symmetry."""
    estimate: LaunchEstimate | None


def stored_launch_estimate(path: Path) -> LaunchEstimate | None:
    """The second run noted in a results.json; None where there is none."""
    try:
        noted = json.loads(path.read_text(encoding="utf-8"))["launch"]["estimate"]
        return None if noted is None else LaunchEstimate(**noted)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def failed_checks(done: Launch) -> list[str]:
    """Sentences about the laws of physics that this launch does not keep (exit code 3)."""
    failures = results.failed_checks(done.run)
    depth = _depth_share(done)
    if not depth <= DEPTH_BOUND:
        failures.append(
            f"beads sink into the finger by {depth:.2%} of the thickness, allowed {DEPTH_BOUND:.0%}: lower --timestep "
            "for a stiffer finger"
        )
    apart = _momentum_error(done)
    if not apart <= MOMENTUM_BOUND:
        failures.append(
            f"momentum and impulse of the finger differ by {apart:.2g} of the momentum, allowed {MOMENTUM_BOUND:.0e}"
        )
    return failures


def warnings_of(done: Launch) -> list[str]:
    """Everything that a reader of the numbers should know."""
    failures = failed_checks(done)
    known = results.failed_checks(done.run)
    sentences = [text for text in results.warnings_of(done.run) if text not in known]
    found, plan = done.found, done.plan
    if found.rear_arrival_s is None:
        sentences.append(f"the rear did not reach the finger within {plan.cap_s:.4g} s: there is no pause to report")
    elif found.finger_free_s is None:
        idle = 0.25 * plan.idle_steps * plan.timestep_s
        sentences.append(
            f"the rear reached the finger before it had carried nothing for {idle:.3g} s: there is no pause, the hand "
            "is hit"
        )
    if plan.scene.finger == "clears" and found.finger_free_s is None:
        sentences.append("the finger was not taken away, for it was never free: the flight is left out")
    if found.touches:
        pushed = sum(touch.impulse_n_s for touch in found.touches)
        first = found.touches[0].start_s
        sentences.append(
            f"the band touched the free finger again, {len(found.touches)} time(s) from {first:.4g} s on, and "
            f"{'lost' if pushed < 0.0 else 'won'} {abs(pushed) / abs(found.momentum_n_s):.2%} of its momentum by it"
        )
    if done.crossed_s is not None:
        sentences.append(
            f"the band crosses itself from {done.crossed_s:.4g} s on: beads of different parts do not feel each other"
        )
    if done.aside_m > ASIDE_BOUND * plan.scene.band.thickness_m:
        sentences.append(
            f"the compressed band buckled out of its symmetry: its rear left the axis by up to {done.aside_m:.3g} m"
        )
    return sentences + failures


def _depth_share(done: Launch) -> float:
    return max(done.found.depth_m, 0.0) / done.plan.scene.band.thickness_m


def error_key(name: str) -> str:
    """Name under which a figure's error stands: ``error`` before the unit, as in ``rebound_speed_error_m_s``."""
    for unit in ("_m_s", "_n_s", "_s"):
        if name.endswith(unit):
            return f"{name.removesuffix(unit)}_error{unit}"
    return f"{name}_error"


def _momentum_error(done: Launch) -> float:
    return abs(done.found.impulse_n_s - done.found.momentum_n_s) / abs(done.found.momentum_n_s)


def _errors(done: Launch, measured: dict[str, float | None], other: dict[str, Any]) -> dict[str, float | None]:
    """The differences to the other number of beads, and with them the error of the time at which the finger is free.

    Of whichever order the differences fall, the finer run is closer than that.
    """
    errors = {
        name: None if value is None or other.get(name) is None else abs(value - other[name])
        for name, value in measured.items()
    }
    free, pause = done.found.free, done.found.pause_s
    if free is not None:
        for name in ("finger_free_s", "pause_s"):
            error = errors[name]
            errors[name] = None if error is None else math.hypot(error, free.error)
        speed, error = measured["escape_speed_m_s"], errors["pause_s"]
        if speed is not None and pause is not None and error is not None:
            errors["escape_speed_m_s"] = speed * error / pause
    return errors


def as_dict(done: Launch) -> dict[str, Any]:
    """The whole of results.json."""
    found, plan, estimate, balance = done.found, done.plan, done.estimate, done.run.balance
    values = results.as_dict(done.run)
    radius = done.support.radius_m
    free, pause = found.finger_free_s, found.pause_s
    stored = balance.stored_j
    measured = {
        "centre_of_mass_speed_m_s": found.centre_of_mass_speed_m_s,
        "efficiency": found.efficiency,
        "finger_free_s": free,
        "rear_arrival_s": found.rear_arrival_s,
        "pause_s": pause,
        "escape_speed_m_s": radius / pause if pause is not None and pause > 0.0 else None,
        "momentum_n_s": found.momentum_n_s,
    }
    other = asdict(estimate) if estimate else {}
    errors = _errors(done, measured, other)
    shares = {
        "translation": found.translation_j / stored,
        "stretching": float(balance.stretching_j[-1]) / stored,
        "bending": float(balance.bending_j[-1]) / stored,
        "vibration": found.vibration_j / stored,
        "dissipated": float(balance.dissipated_j[-1]) / stored,
        "contact": float(done.watch.contact_j[-1]) / stored,
    }
    values["launch"] = {
        **measured,
        **{error_key(name): value for name, value in errors.items() if value is not None},
        "finger_impulse_n_s": found.impulse_n_s,
        "finger_force_n": float(done.watch.force_n[0]),
        "finger": {
            "radius_m": radius,
            "centre_x_m": done.support.centre_m,
            "stiffness_n_m": done.support.stiffness_n_m,
            "deepest_m": found.depth_m,
            "contact_energy_j": float(done.watch.contact_j.max()),
        },
        "touches": [asdict(touch) for touch in found.touches],
        "shares": shares,
        "shortest_stretch": found.shortest_stretch,
        "crossed_s": done.crossed_s,
        "rear_aside_m": done.aside_m,
        "string": {**asdict(plan.string), "pause_s": plan.string.pause_s},
        "estimate": None if estimate is None else asdict(estimate),
        "series": {
            "t_s": done.run.balance.times_s.tolist(),
            "finger_force_n": _means(done.watch).tolist(),
            "clearance_m": done.clearance_m.tolist(),
            "centre_x_m": done.watch.centre_x_m.tolist(),
            "centre_speed_m_s": (done.watch.momentum_n_s / _mass_kg(done)).tolist(),
        },
    }
    values["energy"]["contact_j"] = float(done.watch.contact_j[-1])
    values["held"]["finger_radius_m"] = radius
    values["checks"]["penetration"] = {"value": _depth_share(done), "bound": DEPTH_BOUND}
    values["checks"]["momentum"] = {"value": _momentum_error(done), "bound": MOMENTUM_BOUND}
    values["checks"]["failed"] = failed_checks(done)
    values["warnings"] = warnings_of(done)
    return values


def _means(watch: Watch) -> Array:
    """Mean force of each interval; that of the release, which has none before it, is the held one."""
    force = watch.mean_force_n.copy()
    force[0] = watch.force_n[0]
    return force


def _mass_kg(done: Launch) -> float:
    band = done.plan.scene.band
    return band.mass_per_length_kg_m * band.circumference_m


def text(done: Launch) -> str:
    """A finished launch for a person."""
    from beadband import tables

    values = as_dict(done)
    launch = values["launch"]

    def with_error(name: str, factor: float = 1.0) -> str:
        value, error = launch[name], launch.get(error_key(name))
        if error is None:
            return f"{value * factor:.4g}"
        digits = max(0, 1 - math.floor(math.log10(error * factor))) if error > 0.0 else 4
        return f"{value * factor:.{digits}f} +/- {error * factor:.{digits}f}"

    rows = [
        ("speed of the centre of mass", f"{with_error('centre_of_mass_speed_m_s')} m/s"),
        ("efficiency", f"{with_error('efficiency')} of {values['energy']['stored_j'] * 1e3:.4g} mJ"),
        ("force on the finger", f"{launch['finger_force_n']:.4g} N while held"),
        ("finger free", "never" if launch["finger_free_s"] is None else f"{with_error('finger_free_s', 1e3)} ms"),
        ("rear arrives", "never" if launch["rear_arrival_s"] is None else f"{with_error('rear_arrival_s', 1e3)} ms"),
    ]
    if launch["pause_s"] is not None:
        rows.append(("pause", f"{with_error('pause_s', 1e3)} ms"))
    if launch["escape_speed_m_s"] is not None:
        rows.append(("escape speed R/pause", f"{with_error('escape_speed_m_s')} m/s for R = {_mm(launch)} mm"))
    rows.append(("energy at the end", ", ".join(f"{share:.1%} {name}" for name, share in launch["shares"].items())))
    rows.append(
        (
            "momentum, impulse",
            f"{launch['momentum_n_s']:.6g}, {launch['finger_impulse_n_s']:.6g} N s; deepest in the finger "
            f"{values['checks']['penetration']['value']:.2%} of the thickness",
        )
    )
    head, *rest = tables.run(done.run).rstrip("\n").split("\n")
    body = [line for line in rest if not line.startswith("note: ")]
    width = max(len(name) for name, _ in rows)
    notes = [f"note: {sentence}" for sentence in values["warnings"]]
    lines = [f"  {name.ljust(width)}  {text}" for name, text in rows]
    end = float(done.run.balance.times_s[-1]) * 1e3
    return "\n".join([head.rsplit(":", 1)[0] + f": launch over {end:.3f} ms", *lines, *body, *notes]) + "\n"


def _mm(launch: dict[str, Any]) -> str:
    return f"{launch['finger']['radius_m'] * 1e3:.4g}"
