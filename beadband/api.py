"""beadband from Python: the commands as functions, their options as keywords with the flags' names."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import flat_scene

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.planning.plan import Plan
    from beadband.runs.launch_results import Launch
    from beadband.runs.results import Run


def scene(**parameters: Any) -> Scene:
    """A scene of keywords, named like the flags without dashes (``half_angle=14``) or like the keys of a scene file.

    ``band`` and ``law`` may be tables as in a scene file. UsageError for a name or value that it can't have.
    """
    return scene_of(flat_scene(parameters, "the keywords"))


def plan(given: Scene | None = None, **parameters: Any) -> Plan | LaunchPlan:
    """What a scene needs: beads, step, loss and frames, each with its reason; a scene, or the keywords of one."""
    from beadband.planning import plan_scene

    return plan_scene(_scene(given, parameters))


def run(
    given: Scene | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
    **parameters: Any,
) -> Run | Launch:
    """Release a scene, measured: a scene, or the keywords of one, as in ``run(band="II", strain=0.6)``.

    Everything stays in memory unless ``out`` names a new or empty folder. ``progress`` is called now and then with the
    steps done and the steps in all. UsageError for a scene or folder that can't be used, RunError when LAMMPS fails.
    """
    from beadband.runs import dispatch

    return dispatch.run(_scene(given, parameters), out, progress)


def _scene(given: Scene | None, parameters: dict[str, Any]) -> Scene:
    if given is None:
        return scene(**parameters)
    if parameters:
        raise TypeError(f"a scene and keywords ({', '.join(parameters)}): give one or the other")
    return given
