"""Accurate releases of one leg: the string limit's correction without bead spacing, with its own error."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beadband.model.correction import Array, features
from beadband.model.scene import Scene
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear
from beadband.studies import pool
from beadband.studies.correction.scenes import any_band, catalogue_band, drawn

LEVELS = (1.0, 2.0**0.5, 2.0)
BEADS_IN_REAR = 80
"""Beads along what moves at the rear at the coarsest level: from there on errors are smooth and of the first order."""
MOST_BEADS_IN_REAR = 160
"""The same at most, where the curvature asks for more."""
COARSEST_SPACING = 0.85
"""Bead spacing over the bending layer up to which the curvature at the coarsest level is of the second order."""
_SPEED_ORDER, _CURVATURE_ORDER = 1, 2
_SCATTER, _SHARE = 5e-5, 0.2
"""Least scatter of a run, and the share of the way from the finest run that an extrapolation may be wrong by."""
_CHUNK = 4

Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Released:
    """One scene at all its levels; relative to the string limit and to Eq. 7, NaN where it was not measured."""

    beads: tuple[int, ...]
    deviations: tuple[float, ...]
    """V/V_string - 1 at each level."""
    eq7_ratios: tuple[float, ...]

    @property
    def delta(self) -> tuple[float, float]:
        """V/V_string - 1 without spacing, and its error."""
        return limit(self.beads, self.deviations, _SPEED_ORDER)

    @property
    def ratio(self) -> tuple[float, float]:
        """Mean curvature over Eq. 7 without spacing, and its error."""
        return limit(self.beads, self.eq7_ratios, _CURVATURE_ORDER)


@dataclass(frozen=True)
class Sample:
    """Released scenes; arrays of shape (scenes,), features (scenes, features)."""

    features: Array
    delta: Array
    delta_error: Array
    ratio: Array
    """Mean curvature over Eq. 7; NaN where it was not measured."""
    ratio_error: Array
    kind: NDArray[np.str_]
    """Of the unloading wave."""
    family: NDArray[np.str_]
    """Of the law; "catalogue" where the scene was drawn like the catalogue's."""

    @property
    def catalogue(self) -> Booleans:
        """Which scenes are like the catalogue's."""
        return np.asarray(self.family == "catalogue")

    def __len__(self) -> int:
        return len(self.delta)

    def where(self, chosen: Booleans) -> Sample:
        """Some of its scenes."""
        return Sample(*(getattr(self, one.name)[chosen] for one in fields(self)))

    @classmethod
    def joined(cls, parts: Iterable[Sample]) -> Sample:
        """All scenes of some samples."""
        known = list(parts)
        return cls(*(np.concatenate([getattr(part, one.name) for part in known]) for one in fields(cls)))

    def write(self, path: Path) -> None:
        """Keep the sample in a file of numpy's."""
        np.savez_compressed(path, **{one.name: getattr(self, one.name) for one in fields(self)})

    @classmethod
    def read(cls, path: Path) -> Sample:
        """A sample that was kept."""
        with np.load(path) as stored:
            return cls(*(stored[one.name] for one in fields(cls)))


def limit(beads: Iterable[int], values: Iterable[float], order: int) -> tuple[float, float]:
    """Value at no spacing of a straight line in beads^(-order), and its error; NaN where a value is.

    The error joins the scatter about the line, as it is worth at no spacing, and a share of the way from the finest
    run: what is left when the order is not quite the one assumed.
    """
    x, y = 1.0 / np.asarray(tuple(beads), dtype=np.float64) ** order, np.asarray(tuple(values), dtype=np.float64)
    if not np.all(np.isfinite(y)):
        return math.nan, math.nan
    matrix = np.stack([np.ones_like(x), x / x.max()], axis=1)
    gain = np.linalg.pinv(matrix)
    found = gain @ y
    scatter = math.hypot(_SCATTER, math.sqrt(float(np.sum((y - matrix @ found) ** 2)) / max(len(y) - 2, 1)))
    gap = float(found[0]) - float(y[-1])
    return float(found[0]), math.hypot(scatter * float(np.linalg.norm(gain[0])), _SHARE * gap)


def release(scene: Scene) -> Released:
    """Run one scene at all its levels, in the session of this process."""
    scales, length = scene.scales, scene.band.circumference_m
    coarsest = BEADS_IN_REAR / scales.rear_length_m
    if scales.window.exists:
        wanted = 1.0 / (COARSEST_SPACING * scales.bending_layer_m)
        coarsest = max(coarsest, min(wanted, MOST_BEADS_IN_REAR / scales.rear_length_m))
    beads = tuple(2 * round(0.5 * level * coarsest * length) for level in LEVELS)
    resolved = length / beads[0] <= 1.05 * COARSEST_SPACING * scales.bending_layer_m
    deviations, ratios = [], []
    for number in beads:
        found = follow_rear(plan_of(scene.with_beads(number), "leg"), pool.session())
        deviations.append(found.fitted_speed_m_s.value / scene.string.rear_speed_m_s - 1.0)
        ratios.append(found.decay.eq7_ratio.value if found.decay is not None and resolved else math.nan)
    return Released(beads, tuple(deviations), tuple(ratios))


def sample_of(
    anything: int, catalogue: int, seed: int, jobs: int | None, progress: pool.Progress | None = None
) -> Sample:
    """Draw and release so many scenes of any kind and so many like the catalogue's; failed runs are left out."""
    scenes = drawn(any_band, anything, seed) + drawn(catalogue_band, catalogue, seed)
    found = pool.run_all(release, scenes, jobs=jobs, progress=progress, chunk=_CHUNK)
    done = [
        (features(scene), *one.delta, *one.ratio, scene.string.wave.kind, family)
        for index, (scene, one) in enumerate(zip(scenes, found, strict=True))
        if isinstance(one, Released)
        for family in [scene.band.name.removeprefix("drawn, ") if index < anything else "catalogue"]
    ]
    return Sample(*(np.array(column) for column in zip(*done, strict=True)))
