"""The releases that the figures need: gathered first, run once each, on two processes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from beadband.analysis.tip import Array, Decay, Measured
from beadband.errors import BeadbandError, UsageError
from beadband.scales import SimilarityWindow

Values = dict[str, Any]
"""A scene as :func:`beadband.scene.scene_of` takes it."""

PROCESSES = 2


@dataclass(frozen=True)
class Found:
    """What one release gave; speeds in m/s, times in s."""

    values: Values
    speed: Measured
    """Rebound speed with the error of discretisation and fit."""
    string_speed: float
    published: float
    """V/C of the published formula."""
    wave_speeds: dict[str, float]
    arrival: float
    half_angle: float
    diffusivity: float
    window: SimilarityWindow
    decay: Decay | None
    no_decay: str | None
    times: Array
    tip_speed: Array
    tip_curvature: Array

    def ratio(self, wave: str) -> float:
        """V/C with one of the three wave speeds."""
        return self.speed.value / self.wave_speeds[wave]

    def alpha(self, wave: str) -> float:
        """V/C over the published formula."""
        return self.ratio(wave) / self.published


class Runs:
    """Releases by their scenes."""

    def __init__(self) -> None:
        self._found: dict[str, Found | str] = {}

    def prepare(self, scenes: Iterable[Values], progress: Callable[[int, int], None] | None = None) -> None:
        """Run every scene that is not known yet; those that have no answer keep the reason."""
        missing = {
            key: values for key, values in ((_key(values), values) for values in scenes) if key not in self._found
        }
        if not missing:
            return
        # Spawned, for LAMMPS and MPI do not survive a fork; long scenes first, so that both processes end together.
        order = sorted(missing, key=lambda key: _weight(missing[key]), reverse=True)
        with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
            results = pool.map(_release, [missing[key] for key in order])
            for done, (key, found) in enumerate(zip(order, results, strict=True), 1):
                self._found[key] = found
                if progress:
                    progress(done, len(missing))

    def of(self, values: Values) -> Found:
        """A release that was prepared; UsageError with the reason when the scene had no answer."""
        found = self._found[_key(values)]
        if isinstance(found, str):
            raise UsageError(found)
        return found

    def all_of(self, scenes: Iterable[Values]) -> list[Found]:
        """The releases among the scenes that had an answer."""
        known = [self._found[_key(values)] for values in scenes]
        return [found for found in known if isinstance(found, Found)]

    def refused(self) -> dict[str, str]:
        """Scenes without an answer, and why."""
        return {key: found for key, found in self._found.items() if isinstance(found, str)}

    def __len__(self) -> int:
        return len(self._found)


def _key(values: Values) -> str:
    return json.dumps(values, sort_keys=True)


def _weight(values: Values) -> float:
    """Rough cost of a scene, for the order alone."""
    long_band = {"IV": 20.0, "circular": 2.0, "III": 1.5}.get(str(values.get("band", "III")), 1.0)
    return long_band if values.get("for", "curvature") == "curvature" else 0.5


def _release(values: Values) -> Found | str:
    """Release a scene and its coarser twin in a worker process."""
    from beadband.follow import estimate_of, follow_rear
    from beadband.plan import plan_of
    from beadband.results import joined_error_m_s
    from beadband.scene import scene_of

    try:
        plan = plan_of(scene_of(values), "leg")
        found = follow_rear(plan)
    except BeadbandError as error:
        return str(error)
    speed = found.speed_m_s
    spread = joined_error_m_s(speed, estimate_of(plan), plan.speed_error)
    scene = plan.scene
    return Found(
        values=values,
        speed=Measured(speed.value, spread),
        string_speed=plan.string.rear_speed_m_s,
        published=scene.published_ratio,
        wave_speeds=scene.wave_speeds(plan.string.front_speed_m_s),
        arrival=plan.front_arrival_s,
        half_angle=scene.half_angle_rad,
        diffusivity=scene.bending_diffusivity_m2_s,
        window=found.window,
        decay=found.decay,
        no_decay=found.no_decay,
        times=found.rear.times_s,
        tip_speed=found.rear.tip_speed_m_s,
        tip_curvature=found.rear.tip_curvature_1_m,
    )
