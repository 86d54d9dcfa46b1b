"""The strain, angle or size of which a release has a wanted speed: a root, on formula and runs as they are needed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import BeadbandError, RunError, UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.scales import LONGEST_LAYER
from beadband.model.scene import scene_of
from beadband.model.validity import SLENDER, check_validity
from beadband.notices import Notice, notice
from beadband.parameters import TABLE
from beadband.runs.ask import Answer, ask
from beadband.runs.ask_many import ask_one

Array = NDArray[np.float64]

FOUND = {
    "strain": "strain",
    "half-angle": "half_angle_deg",
    "thickness": "thickness_m",
    "circumference": "circumference_m",
}
"""What can be found, and the keys of it."""
_RANGES = {"strain": (0.02, 10.0), "half_angle_deg": (1.0, 89.0)}
"""Ranges that are searched, as far as scenes have an answer; of sizes, those that are usual for bands."""
_POINTS = 33
_COARSE = 0.02
"""Tolerance of the first look over the range."""
_LOOK_S = 0.3
"""Predicted seconds that a level of it may take."""
_CLOSE = 0.1
"""Distance from the wanted speed, over its error, at which a value counts as found."""
_MOST_STEPS = 12


@dataclass(frozen=True)
class Found:
    """A value that gives a wanted speed."""

    parameter: str
    value: float
    error: float
    """Bound from that of the speed over its slope, in the unit of the value."""
    unit: str
    answer: Answer
    """Speed of the value."""
    evaluations: int
    """Speeds that were asked for, by formula or by runs."""
    seconds: float
    found: tuple[Notice, ...] = ()

    @property
    def speed_m_s(self) -> float:
        """Its speed, m/s."""
        return self.answer.value

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Everything that a reader should know."""
        return (*self.answer.notices, *self.found)

    @property
    def warnings(self) -> list[str]:
        """The notices as sentences."""
        return [one.sentence for one in self.notices]

    def as_dict(self) -> dict[str, Any]:
        """The value as JSON has it; SI units, angles in degrees."""
        names = ("parameter", "value", "error", "unit", "speed_m_s", "evaluations", "seconds")
        values = {name: getattr(self, name) for name in names}
        return {**values, "speed_error_m_s": self.answer.error, "warnings": self.warnings}

    def __str__(self) -> str:
        from beadband.analysis.fits import Measured

        return f"{self.parameter} {Measured(self.value, self.error)} {self.unit}".removesuffix(" 1")


def find(values: Mapping[str, Any], parameter: str, speed_m_s: float, session: Session | None = None) -> Found:
    """The value of a parameter for which the scene that ``values`` make has the speed.

    The speed is looked up over the whole range first, roughly: by formula where it holds. Between two values around the
    wanted speed steps with the slope of that curve, kept in brackets, ask for speeds within the scene's tolerance.
    Where several values give the speed it is the lowest. UsageError with the reachable range where there is none.
    """
    start = time.perf_counter()
    key = FOUND.get(parameter)
    if key is None:
        raise UsageError(explain("unknown parameter to find", repr(parameter), ", ".join(FOUND), "choose one of them"))
    if values.get(key) is not None:
        raise UsageError(
            explain(f"{TABLE[key].flag} is what is to be found", values[key], "the rest of the scene", "leave it out")
        )
    if values.get("shape") == "strip" and key != "strain":
        given, allowed = f"--shape strip and {parameter}", "strain for a strip; any with --shape ring"
        raise UsageError(
            explain(f"the speed of a strip does not depend on its {parameter}", given, allowed, "find the strain")
        )
    if not (isinstance(speed_m_s, (int, float)) and math.isfinite(speed_m_s) and speed_m_s > 0.0):
        raise UsageError(
            explain("the speed is out of range", speed_m_s, "a finite number above 0 m/s", "change --speed")
        )
    if isinstance(values.get("tolerance"), str):
        raise UsageError(
            explain("a value is found to a tolerance", values["tolerance"], "a number", "change --tolerance")
        )
    with _session(session) as own:
        places = _answerable(values, key)
        tolerance = TABLE["tolerance"].default if values.get("tolerance") is None else values["tolerance"]
        places, speeds, errors = _look({**values, "tolerance": max(_COARSE, tolerance)}, key, places, own)
        over = speeds - speed_m_s
        starts = _crossings(over, errors)
        nearest = int(np.argmin(np.abs(over)))
        if not starts and abs(over[nearest]) > errors[nearest]:
            raise _unreachable(key, speed_m_s, places, speeds)
        # At the very end of what can be reached the error decides: the place next to it.
        at = starts[0] if starts else min(nearest, len(places) - 2)
        low, high = float(places[at]), float(places[at + 1])
        slope = float(speeds[at + 1] - speeds[at]) / (high - low)
        guess = low - float(over[at]) / slope if starts else float(places[nearest])
        # The first look errs: the brackets are wider by what that moves the root.
        room = float(max(errors[at], errors[at + 1])) / abs(slope)
        low, high = max(float(places[0]), low - room), min(float(places[-1]), high + room)
        evaluations = len(places)
        last: tuple[float, float] | None = None
        while True:
            answer = ask(scene_of({**values, key: guess}), "speed", own)
            evaluations += 1
            off = answer.value - speed_m_s
            if last is not None and abs(guess - last[0]) > 1e-3 * (high - low) and abs(off - last[1]) > answer.error:
                steeper = (off - last[1]) / (guess - last[0])
                slope = steeper if steeper * slope > 0.0 else slope
            if abs(off) <= _CLOSE * answer.error or evaluations >= len(places) + _MOST_STEPS:
                break
            low, high = (low, guess) if off * slope > 0.0 else (guess, high)
            last = guess, off
            better = guess - off / slope
            if not low < better < high:
                better = 0.5 * (low + high)
            if better == guess:
                break
            guess = better
    error = (answer.error + abs(off)) / abs(slope)
    if abs(off) > 2.0 * answer.error:
        raise _unreachable(key, speed_m_s, places, speeds)
    notices: tuple[Notice, ...] = ()
    if len(starts) > 1:
        notices = (notice("several-roots", value=len(starts), name=parameter, limit=float(places[starts[1]])),)
    unit = TABLE[key].unit or "1"
    return Found(parameter, guess, error, unit, answer, evaluations, time.perf_counter() - start, notices)


def _look(values: Mapping[str, Any], key: str, places: Array, session: Session) -> tuple[Array, Array, Array]:
    """Places, speeds and their errors over the range; places whose run fails are left out."""
    found = []
    for place in places.tolist():
        try:
            answer = ask_one({**values, key: place}, "speed", session, _LOOK_S)
        except BeadbandError:
            continue
        found.append((place, answer.value, answer.error))
    if len(found) < 2:
        raise RunError(
            explain("the range could not be looked over", f"{len(found)} speeds", "2 or more", "change the scene")
        )
    first, speeds, errors = np.array(found).T
    return first, speeds, errors


def _crossings(over: Array, errors: Array) -> list[int]:
    """Places after which a difference changes its sign: the lowest, and others that its error does not explain."""
    changes = np.flatnonzero(np.signbit(over[1:]) != np.signbit(over[:-1]))
    sure = np.flatnonzero(np.abs(over) > errors)
    turns = sure[:-1][np.signbit(over[sure[1:]]) != np.signbit(over[sure[:-1]])]
    starts = {int(changes[changes >= turn][0]) for turn in turns}
    return sorted(starts | {int(one) for one in changes[:1] if len(turns) == 0 or one < turns[0]})


def _session(session: Session | None) -> Any:
    return kept_session() if session is None else nullcontext(session)


def _answerable(values: Mapping[str, Any], key: str) -> Array:
    """Values over the range that is searched whose scenes have an answer, evenly spaced by ratio.

    Of slender bands, whose leg is straight but for a little at the tip, unless the scene's is thick throughout.
    """
    low, high = _RANGES.get(key) or TABLE[key].usual or (0.0, 0.0)

    def holds(value: float, slender: bool = True) -> bool:
        try:
            scene = scene_of({**values, key: value})
            check_validity(scene)
        except UsageError:
            return False
        leg = scene.wedge.reference_leg_m
        fits = leg >= SLENDER * scene.band.thickness_m and scene.scales.bending_layer_m <= LONGEST_LAYER * leg
        return fits or not slender

    places = np.geomspace(low, high, 4 * _POINTS)
    fits: Callable[[float], bool] = holds
    held = [one for one in places.tolist() if fits(one)]
    if len(held) < 2:
        fits = partial(holds, slender=False)
        held = [one for one in places.tolist() if fits(one)]
    if not held:
        check_validity(scene_of({**values, key: float(np.sqrt(low * high))}))
        raise UsageError(
            explain("no scene of this kind has an answer", f"{key} from {low:g} to {high:g}", "some", "change it")
        )
    least, most = held[0], held[-1]
    # The ends of what has an answer, between the last place that has and the first that has not.
    least, most = _edge(fits, least, low), _edge(fits, most, high)
    return np.geomspace(least, most, _POINTS)


def _edge(holds: Callable[[float], bool], inside: float, outside: float) -> float:
    if holds(outside):
        return outside
    for _ in range(12):
        middle = math.sqrt(inside * outside)
        inside, outside = (middle, outside) if holds(middle) else (inside, middle)
    return inside


def _unreachable(key: str, speed_m_s: float, places: Array, speeds: Array) -> UsageError:
    least, most = int(np.argmin(speeds)), int(np.argmax(speeds))
    one = TABLE[key]
    unit = f" {one.unit}" if one.unit else ""
    return UsageError(
        explain(
            f"no {one.option.replace('_', '-')} gives this speed",
            f"--speed {speed_m_s:g}",
            f"{speeds[least]:.4g} to {speeds[most]:.4g} m/s, at {places[least]:.4g} and {places[most]:.4g}{unit}",
            "change --speed or the rest of the scene",
        ),
        "unreachable",
    )
