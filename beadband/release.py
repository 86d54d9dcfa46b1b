"""One release from the scene to the results: plan, hold, let go, measure, write."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from beadband import folder as files
from beadband.analysis.measurement import balance, measure
from beadband.analysis.trajectory import Trajectory, read, read_energies, read_mdanalysis
from beadband.engine import run_script
from beadband.follow import estimate_of, hold, reading_own_files
from beadband.inputs import write_ring
from beadband.parallel import world
from beadband.plan import Plan, plan_of
from beadband.results import Run, as_dict, stored_estimate, to_json
from beadband.scene import Scene, scene_of
from beadband.scenefile import read_scene, scene_text

Progress = Callable[[int, int], None]
"""Called now and then with the steps done and the steps in all."""


class Clock:
    """Seconds spent on each part of a run."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[name] = self.wall_s.get(name, 0.0) + time.perf_counter() - start


def run(scene: Scene, out: str | os.PathLike[str], progress: Progress | None = None) -> Run:
    """Release a scene and write everything about it into the new or empty folder ``out``.

    ``results.json`` is written last: where it is missing, the run did not finish. Raises UsageError for a scene or
    folder that can't be used, RunError when LAMMPS fails.
    """
    clock = Clock()
    with clock.part("plan"):
        plan = plan_of(scene)
    with clock.part("relax"):
        ring = hold(plan)
    with clock.part("write"):
        folder = files.create(out)
        files.claim(folder, scene_text(plan.scene))
        write_ring(folder, plan, ring)
    with clock.part("integrate"):
        follow = (lambda done: progress(done, plan.steps)) if progress else None
        here = world()
        if here.comm is not None:
            here.comm.bcast(str(folder.resolve()), root=0)
        version = run_script(folder, files.SCRIPT, follow, here.comm)
    with clock.part("estimate"):
        estimate = estimate_of(plan)
    with clock.part("measure"), reading_own_files():
        measurement = measure(plan, read(folder / files.REAR))
        energies = balance(plan, read_energies(folder / files.ENERGY))
    done = Run(plan, ring, measurement, energies, estimate, clock.wall_s, version)
    with clock.part("write"):
        text = to_json(as_dict(done))
    files.write_text(folder / files.RESULTS, text, durable=True)
    return done


def help_along() -> None:
    """Share the work of a run that rank 0 has begun: the part of every other rank under mpirun."""
    here = world()
    run_script(Path(here.comm.bcast(None, root=0)), files.SCRIPT, None, here.comm)


def stored_plan(folder: str | os.PathLike[str]) -> Plan:
    """The plan of a run's folder, from its scene.toml."""
    path = files.require(folder, files.SCENE)
    return plan_of(scene_of(read_scene(path / files.SCENE)))


def analyze(folder: str | os.PathLike[str]) -> Run:
    """Measure a run again from the files in its folder alone, read through MDAnalysis in double precision.

    The second run from which the error of discretisation is judged is taken from results.json, and left out where
    that is missing; nothing is written. UsageError when the folder is not that of a whole run.
    """
    return remeasure(folder, read_mdanalysis)


def remeasure(folder: str | os.PathLike[str], reader: Callable[[Path], Trajectory] = read) -> Run:
    """The like of :func:`analyze` with a reader of choice."""
    plan = stored_plan(folder)
    path = files.require(folder, files.REAR, files.ENERGY)
    clock = Clock()
    with clock.part("measure"):
        found = measure(plan, reader(path / files.REAR))
        energies = balance(plan, read_energies(path / files.ENERGY))
    with clock.part("relax"):
        ring = hold(plan)
    return Run(plan, ring, found, energies, stored_estimate(path / files.RESULTS), clock.wall_s)


def frames(folder: str | os.PathLike[str]) -> Trajectory:
    """The whole ring over time, from the files of a run; UsageError when it is not there or can't be read."""
    return read(files.require(folder, files.TRAJECTORY) / files.TRAJECTORY)
