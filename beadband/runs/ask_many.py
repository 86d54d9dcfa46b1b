"""The same question for many scenes: arrays in, arrays out; by formula all at once, the rest by runs."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.formula import STATED, VARIED, formula, own_constants, shares_law, varies_together
from beadband.model.laws import LAWS
from beadband.model.scene import Scene, scene_of
from beadband.parameters import TABLE, Parameter, checked
from beadband.planning.ladder import MOST_SECONDS
from beadband.runs.ask import UNITS, Answer, answer_by_formula, ask, question_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Answers:
    """Numbers with their errors; arrays of the shape to which the inputs broadcast."""

    value: Array
    error: Array
    """Bounds that hold 98 % of the true errors, in the unit of the values."""
    unit: str
    model: NDArray[np.str_]
    """"formula", "leg" or "ring"."""
    runs: NDArray[np.int64]
    beads: NDArray[np.int64]
    seconds: float
    """Of all of them."""
    within_tolerance: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.value)


def arrays_among(values: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """Those values of a scene, by their keys, that stand for many scenes.

    Lists do, but for constants that a law may have several of: there only numpy arrays do.
    """
    return {
        key: np.asarray(value)
        for key, value in values.items()
        if key in TABLE
        and (isinstance(value, np.ndarray) or (isinstance(value, (list, tuple)) and TABLE[key].kind != "numbers"))
    }


class Looked(NamedTuple):
    """What the formula says of many scenes."""

    plain: Mapping[str, Any]
    flat: Mapping[str, NDArray[Any]]
    """Values that are the same for all scenes, and the others as arrays of shape (scenes,)."""
    shape: tuple[int, ...]
    """To which the arrays broadcast."""
    value: Array
    error: Array
    """Of shape (scenes,); the error is infinite where there is no formula."""
    left: NDArray[np.int64]
    """Places of the scenes whose error is above their tolerance."""

    def scene(self, at: int) -> Scene:
        """The scene at a place; UsageError where it has no answer."""
        return scene_of({**self.plain, **{key: each[at].item() for key, each in self.flat.items()}})


def looked_up(values: Mapping[str, Any], quantity: str) -> Looked:
    """Answers by formula for the scenes that values with arrays among them make; UsageError as :func:`ask_many`."""
    arrays = arrays_among(values)
    shape = np.broadcast_shapes(*(one.shape for one in arrays.values()))
    flat = {key: np.broadcast_to(one, shape).ravel() for key, one in arrays.items()}
    plain = {key: value for key, value in values.items() if key not in arrays}
    size = int(np.prod(shape))
    if size == 0:
        raise UsageError(explain("there is nothing to ask", f"arrays of shape {shape}", "one scene or more", "add one"))
    value, error = np.zeros(size), np.full(size, np.inf)
    for chosen, scene, varied in alike(plain, flat, size):
        if has_formula(scene):
            found = formula(scene, quantity, varied)
            value[chosen], error[chosen] = found.value, found.error
    tolerance = _checked(TABLE["tolerance"], flat["tolerance"]) if "tolerance" in flat else scene.tolerance
    return Looked(plain, flat, shape, value, error, np.flatnonzero(error > tolerance * np.abs(value)))


def ask_many(values: Mapping[str, Any], quantity: str = "speed", session: Session | None = None) -> Answers:
    """Answers for the scenes that values with arrays among them make, in the order of the arrays.

    Sizes, strains, angles and densities may vary within one evaluation of the formula, and so may the constants of a
    law that softens; for every other value with several entries the scenes are taken one kind after another. What the
    formula does not reach is run, scene by scene.
    UsageError as :func:`beadband.runs.ask.ask`, for the first scene that has no answer.
    """
    start = time.perf_counter()
    looked = looked_up(values, quantity)
    shape, value, error, size = looked.shape, looked.value, looked.error, len(looked.value)
    model, runs, beads = np.full(size, "formula"), np.zeros(size, dtype=np.int64), np.zeros(size, dtype=np.int64)
    within = np.ones(size, dtype=bool)
    if len(looked.left):
        with kept_session() if session is None else nullcontext(session) as shared:
            for at in looked.left.tolist():
                one = ask(looked.scene(at), quantity, shared)
                value[at], error[at], model[at], runs[at], beads[at] = (
                    one.value,
                    one.error,
                    one.model,
                    one.runs,
                    one.beads,
                )
                within[at] = one.within_tolerance
    return Answers(
        value=value.reshape(shape),
        error=error.reshape(shape),
        unit=UNITS[quantity],
        model=model.reshape(shape),
        runs=runs.reshape(shape),
        beads=beads.reshape(shape),
        seconds=time.perf_counter() - start,
        within_tolerance=within.reshape(shape),
    )


def alike(
    plain: Mapping[str, Any], flat: Mapping[str, NDArray[Any]], size: int
) -> Iterator[tuple[NDArray[np.int64], Scene, dict[str, Array]]]:
    """Scenes of ``plain`` values and arrays of shape (size,), parted into those that one evaluation of a formula makes.

    Gives for each part the places of its scenes, one of them, and what varies among them. UsageError for a value out of
    range, and a first scene that has no answer.
    """
    constants = [
        key
        for key in flat
        if key == STATED or (TABLE[key].section == "law" and TABLE[key].kind in ("number", "numbers"))
    ]
    kinds = kinds_among([one for key, one in flat.items() if key not in (*VARIED, *constants, "tolerance")], size)
    while kinds:
        chosen = kinds.pop(0)
        scene = scene_of({**plain, **{key: one[chosen[0]].item() for key, one in flat.items()}})
        ranges = {**TABLE, **own_constants(scene)}
        varied = {key: _checked(ranges[key], flat[key][chosen]) for key in (*VARIED, *constants) if key in flat}
        if not varies_together(scene, varied):
            parts = kinds_among([flat[key][chosen] for key in constants], len(chosen))
            if len(parts) > 1:
                kinds[:0] = [chosen[part] for part in parts]
                continue
            varied = {key: one for key, one in varied.items() if key in VARIED}
        yield chosen, scene, varied


def kinds_among(others: Sequence[NDArray[Any]], size: int) -> list[NDArray[np.int64]]:
    """Places of the scenes that share the values of ``others``, one array for each kind."""
    if not others:
        return [np.arange(size)]
    codes = np.stack([np.unique(one, return_inverse=True)[1] for one in others])
    kind = np.unique(codes, axis=1, return_inverse=True)[1].ravel()
    return [np.flatnonzero(kind == number) for number in range(int(kind.max()) + 1)]


def _checked(one: Parameter, values: NDArray[Any]) -> Array:
    """Numbers of a parameter, each in its range; UsageError for the first that is not."""
    if values.dtype.kind not in "fiu":
        checked(one.key, values[0].item(), one)
    numbers = values.astype(np.float64)
    least, most = float(numbers.min()), float(numbers.max())
    if not (one.holds(least) and one.holds(most)):
        wrong = next(each for each in numbers.tolist() if not one.holds(each))
        checked(one.key, wrong, one)
    return numbers


def ask_one(
    values: Mapping[str, Any],
    quantity: str = "speed",
    session: Session | None = None,
    most_seconds: float = MOST_SECONDS,
) -> Answer:
    """The answer for one scene, given by its values.

    As :func:`beadband.runs.ask.ask`; where the formula will do, scenes that differ in :data:`VARIED` alone share the
    checks of all the rest.
    """
    start = time.perf_counter()
    varied = {key: checked(key, one) for key, one in values.items() if key in VARIED and isinstance(one, (int, float))}
    rest = {key: one for key, one in values.items() if key not in varied}
    base = _base(tuple(sorted(rest.items())), tuple(sorted(varied.items()))) if _plain(rest) else None
    if base is not None:
        value, error = formula(base, quantity, varied)
        if float(error) <= base.tolerance * abs(float(value)):
            return answer_by_formula(base, quantity, float(value), float(error), varied, start)
    return ask(scene_of(values), quantity, session, most_seconds)


_bases: dict[tuple[Any, ...], Scene | None] = {}
"""Scenes that stand for all of a kind."""
_MOST_BASES = 512


def _plain(rest: Mapping[str, Any]) -> bool:
    """Whether the values say all about a kind of scene: none is a list, or names a file, which may change."""
    files = ("band_file", *(key for key in rest if key in TABLE and TABLE[key].kind == "path"))
    return all(isinstance(one, (str, int, float)) for one in rest.values()) and not any(key in rest for key in files)


def _base(rest: tuple[tuple[str, Any], ...], varied: tuple[tuple[str, Any], ...]) -> Scene | None:
    """The scene of these values, or another of the same kind; None for a kind whose scenes share no formula."""
    # A law may be registered again under its name.
    key = (rest, tuple(name for name, _ in varied), LAWS.get(dict(rest).get("law", "")))
    if key not in _bases:
        if len(_bases) >= _MOST_BASES:
            _bases.clear()
        scene = scene_of(dict((*rest, *varied)))
        _bases[key] = scene if has_formula(scene) else None
    return _bases[key]


def has_formula(scene: Scene) -> bool:
    """Whether scenes that differ from this one in sizes, strain and angle have answers by one evaluation."""
    question_of(scene, "speed")
    return shares_law(scene) and not (scene.errors or scene.covariance or scene.auto_tolerance or scene.tip_radius_m)
