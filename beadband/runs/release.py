"""One release from the scene to the results: plan, hold_whole, release, measure, write.

What comes after the release is another module (:mod:`beadband.runs.finish`), imported while LAMMPS is at work.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from beadband.lammps.engine import run_script
from beadband.lammps.ranks import world
from beadband.lammps.scripts import write_ring
from beadband.model.scene import Scene
from beadband.model.scenefile import scene_text
from beadband.planning.plan import plan_of
from beadband.runs import folder as files
from beadband.runs.clock import Clock
from beadband.runs.held import hold_whole

if TYPE_CHECKING:
    from beadband.runs.results import Run

Progress = Callable[[int, int], None]
"""Called now and then with the steps done and the steps in all."""
_FINISH = "beadband.runs.finish"


def _import_finish() -> None:
    with suppress(ImportError):  # from a relative path: LAMMPS has changed the folder
        import_module(_FINISH)


def run(scene: Scene, out: str | os.PathLike[str] | None = None, progress: Progress | None = None) -> Run:
    """Release a scene; see :func:`beadband.runs.dispatch.run`."""
    clock = Clock()
    with clock.part("plan"):
        plan = plan_of(scene)
    with clock.part("relax"):
        ring = hold_whole(plan)
    with clock.part("write"):
        folder, scratch = files.create_or_scratch(out)
        files.claim(folder, scene_text(plan.scene))
        write_ring(folder, plan, ring)
    with clock.part("integrate"):
        at = (lambda done: progress(done, plan.steps)) if progress else None
        comm = world().comm
        if comm is not None:
            comm.bcast(str(folder.resolve()), root=0)
        version = run_script(folder, files.SCRIPT, at, comm, meanwhile=_import_finish)
    from beadband.runs.finish import finished

    return finished(plan, ring, folder, clock, lammps_version=version, scratch=scratch)


def help_along() -> None:
    """Share the work of a run that rank 0 has begun: the part of every other rank under mpirun."""
    comm = world().comm
    run_script(Path(comm.bcast(None, root=0)), files.SCRIPT, None, comm)
