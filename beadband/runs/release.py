"""One release from the scene to the results: plan, hold, release, measure, write."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from beadband.analysis.energy import Balance, balance
from beadband.analysis.readers import Trajectory, read, read_energies
from beadband.lammps.engine import run_script
from beadband.lammps.ranks import world
from beadband.lammps.scripts import write_ring
from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import read_scene, scene_text
from beadband.planning.plan import Plan, plan_of
from beadband.runs import folder as files
from beadband.runs.measurement import measure
from beadband.runs.rear_run import estimate_of, hold, reading_own_files, reading_users_files
from beadband.runs.results import Run, stored_estimate, to_json

Progress = Callable[[int, int], None]
"""Called now and then with the steps done and the steps in all."""
Reader = Callable[[Path], Trajectory]
AnyRun = TypeVar("AnyRun", bound=Run)


class Clock:
    """Seconds that each part of a run took."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[name] = self.wall_s.get(name, 0.0) + time.perf_counter() - start


def run(scene: Scene, out: str | os.PathLike[str] | None = None, progress: Progress | None = None) -> Run:
    """Release a scene; see :func:`beadband.runs.dispatch.run`."""
    clock = Clock()
    with clock.part("plan"):
        plan = plan_of(scene)
    with clock.part("relax"):
        ring = hold(plan)
    with clock.part("write"):
        folder, scratch = files.create_or_scratch(out)
        files.claim(folder, scene_text(plan.scene))
        write_ring(folder, plan, ring)
    with clock.part("integrate"):
        at = (lambda done: progress(done, plan.steps)) if progress else None
        comm = world().comm
        if comm is not None:
            comm.bcast(str(folder.resolve()), root=0)
        version = run_script(folder, files.SCRIPT, at, comm)
    with clock.part("estimate"):
        estimate = estimate_of(plan)
    with clock.part("measure"), reading_own_files():
        measured = measure(plan, read(folder / files.REAR))
    inputs = None
    if scene.errors or scene.covariance:
        from beadband.runs.input_errors import budget_of

        with clock.part("inputs"):
            inputs = budget_of(scene, measured.fitted_speed_m_s.value)
    with clock.part("measure"), reading_own_files():
        done = Run(
            plan, measured, estimate, inputs, held=ring, energy=_energies(plan, folder), folder=folder,
            wall_s=clock.wall_s, lammps_version=version, fingerprints=files.fingerprints(folder), scratch=scratch,
        )  # fmt: skip
    return written(done, clock)


def written(done: AnyRun, clock: Clock) -> AnyRun:
    """Write the results of a run into its folder, last of all: where they are missing the run did not finish."""
    with clock.part("write"):
        text = to_json(done.as_dict())
    files.write_text(done.folder / files.RESULTS, text, durable=done.scratch is None)
    return done


def help_along() -> None:
    """Share the work of a run that rank 0 has begun: the part of every other rank under mpirun."""
    comm = world().comm
    run_script(Path(comm.bcast(None, root=0)), files.SCRIPT, None, comm)


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
        found = measure(plan, reader(path / files.REAR))
        energies = _energies(plan, path)
    with clock.part("relax"):
        ring = hold(plan)
    return Run(
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
