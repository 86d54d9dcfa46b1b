"""What a study of many scenes is about: the speed or the curvature as ``ask`` has them, or a figure in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband import observables
from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session
from beadband.model.figures import FIGURES, THROWS, figures, figures_of_scene
from beadband.model.formula import shares_law
from beadband.model.scene import scene_of
from beadband.runs.ask import QUANTITIES, UNITS
from beadband.runs.ask_many import alike, arrays_among, ask_many

Array = NDArray[np.float64]

_SENTENCES = {"speed": "rebound speed V", "curvature": "tip curvature over that of Eq. 7"}
MOST_RUNS = 200
"""Scenes beyond the formula's reach that a study runs: a minute or a few."""


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
    runs: int
    """Scenes that the formula did not reach."""


def evaluate(values: Mapping[str, Any], quantity: Quantity, session: Session | None = None) -> Values:
    """A quantity of the scenes that values with arrays of shape (scenes,) among them make.

    UsageError where one of them has no answer, for figures of the throw also where their closed form does not hold, and
    where the formula does not reach more than :data:`MOST_RUNS`.
    """
    if quantity.asked:
        found = ask_many(values, quantity.name, session, MOST_RUNS)
        return Values(found.value, found.error, int(np.count_nonzero(found.model != "formula")))
    arrays = arrays_among(values)
    value = closed({key: one for key, one in values.items() if key not in arrays}, arrays)[quantity.key]
    if quantity.key in THROWS and not np.isfinite(value).all():
        at = int(np.flatnonzero(~np.isfinite(value))[0])
        raise UsageError(
            explain(
                f"{quantity.name} has no closed form there",
                ", ".join(f"{key} {one[at]}" for key, one in arrays.items()),
                "half-angles below 30 degrees, and a law that unloads by one front",
                "narrow the ranges, or change --law",
            )
        )
    return Values(value, np.zeros_like(value), 0)


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
