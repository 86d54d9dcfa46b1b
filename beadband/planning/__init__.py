"""From a scene to a plan: error curves, sampling, and every choice with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from beadband.model.scene import Scene
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.planning.plan import Plan


def plan_scene(scene: Scene) -> Plan | LaunchPlan:
    """The plan of a release or of a launch, as the scene has it; UsageError for a choice that can't work."""
    if scene.until == "launch":
        from beadband.planning.launch_plan import launch_plan_of

        return launch_plan_of(scene)
    from beadband.planning.plan import plan_of

    return plan_of(scene)
