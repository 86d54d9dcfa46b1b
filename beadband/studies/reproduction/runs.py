"""The releases that the figures need: gathered first, run once each, on the studies' pool."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from beadband.analysis.curvature import Decay
from beadband.analysis.fits import Array, Measured
from beadband.errors import UsageError
from beadband.model.scales import SimilarityWindow
from beadband.studies.pool import Failed, Progress, run_all

Values = dict[str, Any]
"""A scene as :func:`beadband.model.scene.scene_of` takes it."""


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
        self._found: dict[str, Found | Failed] = {}

    def prepare(self, scenes: Iterable[Values], progress: Progress | None = None) -> None:
        """Run every scene that is not known yet; those that have no answer keep the reason."""
        missing = {
            key: values for key, values in ((_key(values), values) for values in scenes) if key not in self._found
        }
        if not missing:
            return
        # Long scenes first, so that all processes end together.
        order = sorted(missing, key=lambda key: _weight(missing[key]), reverse=True)
        found = run_all(_release, [missing[key] for key in order], progress=progress)
        self._found.update(zip(order, found, strict=True))

    def of(self, values: Values) -> Found:
        """A release that was prepared; UsageError with the reason when the scene had no answer."""
        found = self._found[_key(values)]
        if isinstance(found, Failed):
            raise UsageError(found.reason, found.code)
        return found

    def all_of(self, scenes: Iterable[Values]) -> list[Found]:
        """The releases among the scenes that had an answer."""
        known = [self._found[_key(values)] for values in scenes]
        return [found for found in known if isinstance(found, Found)]

    def refused(self) -> dict[str, str]:
        """Scenes without an answer, and why."""
        return {key: found.reason for key, found in self._found.items() if isinstance(found, Failed)}

    def __len__(self) -> int:
        return len(self._found)


def _key(values: Values) -> str:
    return json.dumps(values, sort_keys=True)


def _weight(values: Values) -> float:
    """Rough cost of a scene, for the order alone."""
    long_band = {"IV": 20.0, "circular": 2.0, "III": 1.5}.get(str(values.get("band", "III")), 1.0)
    return long_band if values.get("for", "curvature") == "curvature" else 0.5


def _release(values: Values) -> Found:
    """Release a scene, and once more with half the beads, in a worker process."""
    from beadband.model.scene import scene_of
    from beadband.planning.plan import plan_of
    from beadband.runs.rear_run import rear_run

    done = rear_run(plan_of(scene_of(values), "leg"))
    plan, found, scene = done.plan, done.measurement, done.scene
    return Found(
        values=values,
        speed=done.speed,
        string_speed=plan.string.rear_speed_m_s,
        published=scene.published_ratio,
        wave_speeds=done.wave_speeds_m_s,
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
