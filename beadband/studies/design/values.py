"""What a study of many scenes is about: the speed or the curvature as ``ask`` has them, or a figure in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband import observables
from beadband.analysis.fits import Measured
from beadband.errors import BeadbandError, UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.figures import FIGURES, figures, figures_of_scene
from beadband.model.formula import shares_law
from beadband.model.scene import Scene, scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.ask import QUANTITIES, UNITS, ask, question_of
from beadband.runs.ask_many import alike, arrays_among, looked_up
from beadband.runs.rear_run import rear_runs
from beadband.runs.results import RearRun

Array = NDArray[np.float64]

_SENTENCES = {"speed": "rebound speed V", "curvature": "tip curvature over that of Eq. 7"}
MOST_RUNS = 2000
"""Scenes beyond the formula's reach that a study runs at once: some seconds for a speed, minutes for a curvature."""
TOO_MANY_RUNS = "too-many-runs"
"""Code of the error for more of them."""
_BATCH = 48
"""Scenes whose legs are released together."""


@dataclass(frozen=True)
class Quantity:
    """One number of a scene."""

    name: str
    """As options have it, as in "speed" or "stored-energy"."""
    key: str
    """Its key among the figures; the name itself of what is asked for."""
    sentence: str
    unit: str

    @property
    def asked(self) -> bool:
        """Whether it takes the formula or runs, and has an error."""
        return self.name in QUANTITIES


def _figure(key: str) -> Quantity:
    one = next(one for one in observables.table() if one.key in (f"design.{key}", key))
    name = key.removesuffix("_" + one.unit.replace("/", "_").replace(" ", "_").lower()) if one.unit else key
    return Quantity(name.replace("_", "-"), key, one.sentence.split(";")[0], one.unit)


NAMES: dict[str, Quantity] = {
    one.name: one
    for one in (
        *(Quantity(name, name, _SENTENCES[name], UNITS[name].removesuffix("1")) for name in QUANTITIES),
        *(_figure(key) for key in FIGURES),
    )
}
"""Every quantity by its name."""


def quantity_of(name: str, flag: str = "--quantity") -> Quantity:
    """The quantity of a name; UsageError for an unknown one."""
    found = NAMES.get(name.replace("_", "-"))
    if found is None:
        raise UsageError(explain("unknown quantity", repr(name), ", ".join(NAMES), f"change {flag}"))
    return found


@dataclass(frozen=True)
class Values:
    """A quantity of many scenes; arrays of shape (scenes,)."""

    value: Array
    error: Array
    """Bound of the numerical error; 0 for closed forms."""
    by_run: NDArray[np.bool_]
    """Scenes that the formula did not reach."""

    @property
    def runs(self) -> int:
        """How many they are."""
        return int(np.count_nonzero(self.by_run))


def evaluate(values: Mapping[str, Any], quantity: Quantity, session: Session | None = None) -> Values:
    """A quantity of the scenes that values with arrays of shape (scenes,) among them make.

    UsageError where one of them has no answer, or no closed form, and where the formula does not reach more than
    :data:`MOST_RUNS`.
    """
    if quantity.asked:
        return _asked(values, quantity, session)
    arrays = arrays_among(values)
    value = closed({key: one for key, one in values.items() if key not in arrays}, arrays)[quantity.key]
    if not np.isfinite(value).all():
        at = int(np.flatnonzero(~np.isfinite(value))[0])
        raise UsageError(
            explain(
                f"{quantity.name} has no closed form there",
                ", ".join(f"{key} {one[at]}" for key, one in arrays.items()),
                "rings of half-angles below 30 degrees, and a law that unloads by one front",
                "narrow the ranges, or change --law or --shape",
            )
        )
    return Values(value, np.zeros_like(value), np.zeros(value.shape, dtype=bool))


def _asked(values: Mapping[str, Any], quantity: Quantity, session: Session | None) -> Values:
    """Values by formula, and by legs in batches where that does not hold; scene by scene where a leg won't do."""
    looked = looked_up(values, quantity.name)
    value, error, by_run = looked.value, looked.error, np.zeros(looked.value.shape, dtype=bool)
    by_run[looked.left] = True
    if len(looked.left) > MOST_RUNS:
        question_of(looked.scene(int(looked.left[0])), quantity.name)
        given, allowed = f"{len(looked.left)} of {len(value)} scenes", f"at most {MOST_RUNS} scenes by runs"
        advice = "narrow the ranges, raise --tolerance, or take fewer points"
        raise UsageError(explain("the formula does not reach the tolerance", given, allowed, advice), TOO_MANY_RUNS)
    if len(looked.left) == 0:
        return Values(value, error, by_run)
    with kept_session() if session is None else nullcontext(session) as own:
        for start in range(0, len(looked.left), _BATCH):
            places = looked.left[start : start + _BATCH].tolist()
            scenes = [question_of(looked.scene(at), quantity.name).scene for at in places]
            plans = [_leg(replace(one, purpose=quantity.name)) for one in scenes]
            ran = iter(rear_runs([one for one in plans if one is not None], own))
            for at, scene, plan in zip(places, scenes, plans, strict=True):
                one = None if plan is None else _of(next(ran), quantity)
                if one is None or not one.error <= scene.tolerance * abs(one.value):
                    answer = ask(scene, quantity.name, own)
                    one = Measured(answer.value, answer.error)
                value[at], error[at] = one.value, one.error
    return Values(value, error, by_run)


def _leg(scene: Scene) -> Plan | None:
    try:
        return plan_of(scene, "leg")
    except BeadbandError:
        return None


def _of(found: RearRun | BeadbandError, quantity: Quantity) -> Measured | None:
    return None if isinstance(found, BeadbandError) else measured(found, quantity)


def measured(found: RearRun, quantity: Quantity) -> Measured | None:
    """What a run gives for the speed or the curvature, with its error; None where there is none."""
    if quantity.name == "speed":
        return found.speed
    return None if found.curvature is None else found.curvature.eq7_ratio


def closed(plain: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> dict[str, Array]:
    """All figures in closed form of scenes with arrays of shape (scenes,); NaN for a throw that has none."""
    size = len(next(iter(arrays.values())))
    found = {key: np.empty(size) for key in FIGURES}
    for chosen, scene, varied in alike(plain, arrays, size):
        if shares_law(scene):
            part: Mapping[str, Any] = figures(scene, varied)
        else:
            own = [scene_of({**plain, **{key: one[at].item() for key, one in arrays.items()}}) for at in chosen]
            rows = [figures_of_scene(one) for one in own]
            part = {key: [np.nan if row[key] is None else row[key] for row in rows] for key in FIGURES}
        for key in FIGURES:
            found[key][chosen] = part[key]
    return found
