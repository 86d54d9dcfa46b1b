"""From the files of a release to its results: estimate, measure, write; and the same again later."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from beadband.analysis.energy import Balance, balance
from beadband.analysis.readers import Trajectory, read, read_energies
from beadband.model.scene import scene_of
from beadband.model.scenefile import read_scene
from beadband.planning.plan import Plan, plan_of
from beadband.runs import folder as files
from beadband.runs.clock import Clock
from beadband.runs.held import hold_whole
from beadband.runs.measurement import measured, reading_own_files, reading_users_files
from beadband.runs.rear_run import estimate_of
from beadband.runs.results import Run, stored_estimate, to_json
from beadband.runs.strip_results import StripRun
from beadband.statics.ring import Ring
from beadband.statics.strip import Strip

Reader = Callable[[Path], Trajectory]
AnyRun = TypeVar("AnyRun", bound=Run)


def finished(plan: Plan, ring: Ring | Strip, folder: Path, clock: Clock, **about: Any) -> Run:
    """The results of a release whose files stand in a folder, written there; ``about`` goes into the :class:`Run`."""
    scene = plan.scene
    with clock.part("estimate"):
        estimate = estimate_of(plan)
    with clock.part("measure"), reading_own_files():
        found = measured(plan, folder)
    inputs = None
    if scene.errors or scene.covariance:
        from beadband.runs.input_errors import budget_of

        with clock.part("inputs"):
            inputs = budget_of(scene, found.fitted_speed_m_s.value)
    with clock.part("measure"), reading_own_files():
        done = _kind(plan)(
            plan, found, estimate, inputs, held=ring, energy=_energies(plan, folder), folder=folder,
            wall_s=clock.wall_s, fingerprints=files.fingerprints(folder), **about,
        )  # fmt: skip
    return written(done, clock)


def _kind(plan: Plan) -> type[Run]:
    return StripRun if plan.scene.is_strip else Run


def written(done: AnyRun, clock: Clock) -> AnyRun:
    """Write the results of a run into its folder, last of all: where they are missing the run did not finish."""
    with clock.part("write"):
        text = to_json(done.as_dict())
    files.write_text(done.folder / files.RESULTS, text, durable=done.scratch is None)
    return done


def remeasure(folder: str | os.PathLike[str], reader: Reader = read) -> Run:
    """Measure a release again from the files in its folder; see :func:`beadband.runs.dispatch.analyze`."""
    from beadband.runs.input_errors import budget_of

    path = files.require(folder, files.SCENE, files.REAR, files.ENERGY)
    stored, prints = unchanged(path)
    plan = plan_of(scene_of(read_scene(path / files.SCENE)))
    clock = Clock()
    with clock.part("measure"), reading_users_files():
        if not stored and (path / files.TRAJECTORY).is_file():
            read(path / files.TRAJECTORY).require_steps(plan.steps)
        found = measured(plan, path, reader)
        energies = _energies(plan, path)
    with clock.part("relax"):
        ring = hold_whole(plan)
    return _kind(plan)(
        plan, found, stored_estimate(stored), budget_of(plan.scene, found.fitted_speed_m_s.value), held=ring,
        energy=energies, folder=path, wall_s=clock.wall_s, fingerprints=prints,
    )  # fmt: skip


def unchanged(folder: Path) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """The stored results, if any, and the fingerprints; UsageError where a file is not the one that they came from."""
    stored = files.stored_results(folder) or {}
    return stored, files.require_unchanged(folder, stored)


def frames(folder: str | os.PathLike[str]) -> Trajectory:
    """The whole ring over time, from the files of a run; UsageError when it is not there or can't be read."""
    with reading_users_files():
        return read(files.require(folder, files.TRAJECTORY) / files.TRAJECTORY)


def _energies(plan: Plan, folder: Path) -> Balance:
    """The balance of energy from the files of a release; ReadError when they do not cover the run."""
    energies = read_energies(folder / files.ENERGY)
    energies.require_steps(plan.steps)
    return balance(energies, plan.timestep_s)
