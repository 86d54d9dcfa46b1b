"""beadband from Python: the commands as functions, their options as keywords with the flags' names."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import flat_scene

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.planning.plan import Plan
    from beadband.runs.ask import Answer
    from beadband.runs.ask_many import Answers
    from beadband.runs.launch_results import Launch
    from beadband.runs.results import Run
    from beadband.studies.design.optimum import Design
    from beadband.studies.design.sensitivity import Sensitivity
    from beadband.studies.find import Found


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
    force: bool = False,
    **parameters: Any,
) -> Run | Launch:
    """Release a scene, measured: a scene, or the keywords of one, as in ``run(band="II", strain=0.6)``.

    Everything stays in memory unless ``out`` names a new or empty folder. ``progress`` is called now and then with the
    steps done and the steps in all. UsageError for a scene or folder that can't be used, and, without ``force``, for a
    run that is predicted to take too long or too much disk space. RunError when LAMMPS fails.
    """
    from beadband.planning import plan_scene
    from beadband.runs import dispatch

    chosen = _scene(given, parameters)
    if not force:
        dispatch.refuse_absurd(plan_scene(chosen), chosen.frames)
    return dispatch.run(chosen, out, progress)


def ask(given: Scene | None = None, *, quantity: str = "speed", **parameters: Any) -> Answer | Answers:
    """One number of a release with its error, at the least cost: ``.value``, ``.error``, ``.unit``, ``.model``.

    A scene, or the keywords of one, as in ``ask(band="III", strain=0.476, tolerance=0.001)``; with arrays among them
    the answer is one of arrays. ``quantity`` is "speed" (V, m/s) or "curvature" (mean tip curvature in its window over
    that of Eq. 7). UsageError for a scene that can't be used, RunError when LAMMPS fails.
    """
    from beadband.runs import ask as asking
    from beadband.runs.ask_many import arrays_among, ask_many, ask_one

    if given is not None:
        return asking.ask(_scene(given, parameters), quantity)
    values = flat_scene(parameters, "the keywords")
    return (ask_many if arrays_among(values) else ask_one)(values, quantity)


def find(parameter: str, *, speed: float, **parameters: Any) -> Found:
    """The value of "strain", "half-angle", "thickness" or "circumference" for which a release has a speed, m/s.

    The other keywords are those of a scene. UsageError, with the reachable range, where there is none.
    """
    from beadband.studies.find import find as search

    return search(flat_scene(parameters, "the keywords"), parameter.replace("_", "-"), speed)


def sensitivity(
    *,
    vary: Mapping[str, Any] | None = None,
    spans: Sequence[str] = (),
    quantity: str = "speed",
    points: int = 4096,
    seed: int = 0,
    **parameters: Any,
) -> Sensitivity:
    """Sobol' indices of first and total order of a quantity over ranges of inputs, with 95 % intervals.

    ``vary`` names inputs and what each varies over: ``{"strain": (0.2, 0.8), "thickness": "2e-3 +/- 5e-5",
    "band": ["I", "III"]}``. Bands in ``spans`` vary what they span, and the rubber. The other keywords are those of a
    scene; inputs with errors vary too. ``.rows()``, ``.indices`` and ``.as_dict()`` hold the result, ``.write(folder)``
    keeps it. UsageError where a scene in the ranges has no answer, RunError when LAMMPS fails.
    """
    from beadband.studies.design.sensitivity import sensitivity as study

    values = flat_scene(parameters, "the keywords")
    return study(values, vary=vary, spanned=spans, quantity=quantity, points=points, seed=seed)


def design(
    goal: str,
    *,
    vary: Mapping[str, Any],
    keep: Mapping[str, Any] | None = None,
    least: bool = False,
    **parameters: Any,
) -> Design:
    """The inputs for which a goal is largest, or ``least``: ``.values``, ``.value``, ``.error``, ``.scene``.

    ``goal`` is "speed", "curvature" or a closed form as in "throw-speed". ``vary`` gives ranges by the names of inputs,
    ``{"strain": (0.2, 1.2), "band": ["I", "III"]}``, and ``keep`` conditions by the names of quantities,
    ``{"stored-energy": 0.1, "pull": (None, 5)}``. The other keywords are those of a scene. UsageError where the
    conditions can't be met, RunError when LAMMPS fails.
    """
    from beadband.studies.design.optimum import design as study

    return study(flat_scene(parameters, "the keywords"), goal, vary, keep, least=least)


def _scene(given: Scene | None, parameters: dict[str, Any]) -> Scene:
    if given is None:
        return scene(**parameters)
    if parameters:
        raise TypeError(f"a scene and keywords ({', '.join(parameters)}): give one or the other")
    return given
