"""Which scenes of a sweep the formula answers, many at once, and their rows; the others are released."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband import observables
from beadband.analysis.fits import Measured
from beadband.errors import BeadbandError, UsageError, explain
from beadband.model.figures import figures
from beadband.model.formula import STATED, VARIED, answered, formula, scenes_of, varies_together
from beadband.model.scene import Scene, scene_of
from beadband.model.string_arrays import arrays_of, string_limits, strip_limits
from beadband.model.wedge import published_ratio, wave_speeds
from beadband.parameters import TABLE
from beadband.runs.ask_many import has_formula, kinds_among
from beadband.studies.sweep.grid import Grid, Values

WAYS = ("cheapest", "runs")
"""Where the values of a sweep may come from: the formula where its error is within the tolerance, or releases alone."""
BLOCK = 2048
"""Scenes that are looked at together. Blocks are the same however a sweep is run: a result may depend on its block in
the last digit."""
_MOST_TRIES = 64
"""Scenes of a kind that are tried before it counts as one without an answer."""
_MOST_KINDS = 512


def check_way(by: str | None) -> None:
    """UsageError for a way that there is not."""
    if by is not None and by not in WAYS:
        raise UsageError(explain("unknown way to the values of a sweep", repr(by), ", ".join(WAYS), "change --by"))


@dataclass(frozen=True)
class Block:
    """Neighbouring scenes of a sweep."""

    first: int
    """Place of its first scene."""
    scenes: list[Values]
    known: NDArray[np.bool_]
    """Which of them the formula answers."""
    columns: Mapping[str, NDArray[Any]]
    """What it gives them, shape (scenes,), by columns of the table; meaningless for the others."""


class Rungs:
    """Sorts the scenes of one sweep."""

    def __init__(self, by: str | None = None) -> None:
        check_way(by)
        self._by = by
        self._kinds: dict[tuple[Any, ...], Scene | None] = {}

    def blocks(self, grid: Grid) -> Iterator[Block]:
        """All scenes of a grid, in order."""
        scenes, first = grid.scenes(), 0
        while some := list(islice(scenes, BLOCK)):
            yield self.block(some, first)
            first += len(some)

    def block(self, scenes: list[Values], first: int = 0) -> Block:
        """These scenes, which have the same keys."""
        known, columns = np.zeros(len(scenes), dtype=bool), dict[str, NDArray[Any]]()
        asked = [one.get("tolerance", TABLE["tolerance"].default) for one in scenes]
        tolerance = np.array([one if isinstance(one, float) else 0.0 for one in asked])
        if self._by == "runs":
            return Block(first, scenes, known, columns)
        constants = [key for key in scenes[0] if key == STATED or TABLE[key].section == "law"]
        varied = {
            key: np.array([one[key] for one in scenes], dtype=np.float64)
            for key in (*VARIED, *constants)
            if key in scenes[0] and all(isinstance(one[key], (int, float)) for one in scenes)
        }
        others = [key for key in scenes[0] if key not in varied and key != "tolerance"]
        kinds = kinds_among([_texts(scenes, key) for key in others], len(scenes))
        while kinds:
            chosen = kinds.pop(0)
            base = self._base([scenes[at] for at in chosen.tolist()], (*others, *constants))
            if base is None:
                continue
            own = {key: one[chosen] for key, one in varied.items()}
            # A linear law with just the modulus of its band stands in for that band's rubber.
            if not varies_together(base, own) or (base.law == "linear" and STATED in own):
                parts = kinds_among([own[key] for key in constants if key in own], len(chosen))
                if len(parts) > 1:
                    kinds[:0] = [chosen[part] for part in parts]
                    continue
                own = {key: one for key, one in own.items() if key in VARIED}
            held = answered(base, own) & _in_range(base, own)
            chosen, own = chosen[held], {key: one[held] for key, one in own.items()}
            if len(chosen) == 0:
                continue
            value, error = (np.broadcast_to(one, chosen.shape) for one in formula(base, "speed", own))
            good = error <= tolerance[chosen] * np.abs(value)
            speed: Any = Measured(value, error)  # type: ignore[arg-type]
            row = _row(base, own, speed)
            if row is None:
                continue
            known[chosen[good]] = True
            for name, one in row.items():
                column = columns.setdefault(name, _column(one, len(scenes)))
                column[chosen] = one
        return Block(first, scenes, known, columns)

    def _base(self, scenes: Sequence[Values], others: Sequence[str]) -> Scene | None:
        """One scene that stands for a kind; None where the formula has no answer for it."""
        kind = tuple(repr(scenes[0][key]) for key in others)
        if kind not in self._kinds:
            if len(self._kinds) >= _MOST_KINDS:
                self._kinds.clear()
            self._kinds[kind] = _first(scenes)
        return self._kinds[kind]


def _first(scenes: Sequence[Values]) -> Scene | None:
    for values in scenes[:: -(-len(scenes) // _MOST_TRIES)]:
        try:
            scene = scene_of(dict(values))
            return scene if scene.purpose == "speed" and has_formula(scene) else None
        except BeadbandError:
            continue
    return None


def _texts(scenes: Sequence[Values], key: str) -> NDArray[np.str_]:
    return np.array([repr(one[key]) for one in scenes])


def _in_range(scene: Scene, varied: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """Where the law takes the constants: it may ask more of them than the table of parameters does."""
    good = np.ones(np.broadcast_shapes(*(one.shape for one in varied.values())), dtype=bool)
    for one in scene.material.constants():
        if one.key in varied:
            good &= np.array([one.holds(value) for value in varied[one.key].tolist()])
    return good


def _column(like: Any, size: int) -> NDArray[Any]:
    kind = np.asarray(like).dtype.kind
    return np.full(size, np.nan) if kind in "fiu" else np.full(size, "", dtype=object)


def _row(scene: Scene, varied: Mapping[str, Any], speed: Measured) -> dict[str, Any] | None:
    """Columns of many scenes, by the table of observables, from what stands in the place of their runs.

    None where a column asks for what only a run gives.
    """
    try:
        return observables.row(_found(scene, varied, speed))
    except (AttributeError, KeyError, TypeError, ValueError):
        return None


def _found(scene: Scene, varied: Mapping[str, Any], speed: Measured) -> Any:
    """What a :class:`beadband.runs.results.RearRun` has, as far as there is any of it without a run; arrays."""
    law, given = scenes_of(scene, varied)
    density, strain, phi = (given[key] for key in ("density_kg_m3", "strain", "half_angle_rad"))
    string = strip_limits(law, density, strain) if scene.is_strip else string_limits(law, density, strain, phi)
    band: Any = SimpleNamespace(
        bar_speed_m_s=np.sqrt(given.get(STATED, scene.band.modulus_pa) / density),
        rest_speed_m_s=np.sqrt((law.tangent(1.0) if arrays_of(law) else scene.band.rest_modulus_pa) / density),
    )
    speeds = wave_speeds(band, string.front_speed_m_s, strain, phi)
    published = published_ratio(strain, phi)
    ratios = {wave: Measured(speed.value / one, speed.error / one) for wave, one in speeds.items()}
    return SimpleNamespace(
        speed=speed,
        within_tolerance=True,
        wave_speeds_m_s=speeds,
        ratios=ratios,
        alphas={wave: Measured(one.value / published, one.error / published) for wave, one in ratios.items()},
        scene=SimpleNamespace(published_ratio=published),
        plan=SimpleNamespace(string=string, model="formula", beads=None, steps=None, bead_steps=None),
        measurement=SimpleNamespace(no_decay="answered by the formula, without a run"),
        curvature=None,
        late_speed_m_s=None,
        design=figures(scene, varied),
    )
