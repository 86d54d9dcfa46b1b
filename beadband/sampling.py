"""How long a release runs, and how often it is looked at: frames of the ring, means of its rear, and steps in all."""

from __future__ import annotations

import math

from beadband.errors import UsageError, explain
from beadband.scales import similarity_window
from beadband.scene import Scene
from beadband.wedge import StringLimit

FRAMES = 60
MOST_STEPS = 2_000_000_000
_REAR_FRAMES = 240
_FEWEST_REAR_FRAMES = 120
_FEWEST_REAR_STEPS = 4  # the fastest bending mode has a period of pi largest steps: averages must span it
_SPEED_END = 0.87
"""Share of the front's arrival at which the speed is known, so that a leg may stop."""


def leg_end_s(scene: Scene, string: StringLimit, arrival: float) -> float:
    """When a leg has told all that is asked: the speed, and the curvature in its window."""
    window = similarity_window(scene, string)
    asked = _SPEED_END * arrival
    return max(asked, window.end_s) if scene.purpose == "curvature" and window.reason is None else asked


def sample_leg(scene: Scene, string: StringLimit, end: float, target: float) -> tuple[int, int, int]:
    """Frames (one), steps between means of the rear, and steps in all, of a leg."""
    rear_steps = max(1, int(interval_s(scene, string, end) / target))
    return 1, rear_steps, rear_steps * math.ceil(end / (rear_steps * target) * (1.0 - 1e-12))


def interval_s(scene: Scene, string: StringLimit, end: float) -> float:
    """Longest time between frames of the rear."""
    window = similarity_window(scene, string)
    interval = end / _REAR_FRAMES
    return interval if window.reason is not None else min(interval, (window.end_s - window.start_s) / 12.0)


def given(scene: Scene, steps: int) -> tuple[int, int, int]:
    """Frames, steps between frames of the rear, and all steps, as given; UsageError when they do not divide."""
    frames, rear_steps = scene.frames or 1, scene.rear_steps or 1
    if steps % frames or (steps // frames) % rear_steps:
        raise UsageError(
            explain(
                "steps and frames do not divide",
                f"steps {steps}, frames {frames}, rear_steps {rear_steps}",
                "steps a multiple of frames x rear_steps",
                "leave steps and rear_steps to the plan",
            )
        )
    return frames, rear_steps, steps


def sample_ring(scene: Scene, string: StringLimit, arrival: float, target: float) -> tuple[int, int, int]:
    """Frames of the ring, steps between frames of the rear, and steps in all; UsageError when they don't divide."""
    if scene.steps is not None:
        return given(scene, scene.steps)
    rear_steps = scene.rear_steps or max(_FEWEST_REAR_STEPS, int(interval_s(scene, string, arrival) / target))
    rear_frames = math.ceil(arrival / (rear_steps * target) * (1.0 - 1e-12))
    if scene.timestep_s is None:
        rear_frames = max(rear_frames, _FEWEST_REAR_FRAMES)
    frames = scene.frames or min(FRAMES, rear_frames)
    every = math.ceil(rear_frames / frames)
    if scene.timestep_s is not None and scene.frames is None:
        # A given step can't be stretched to end with the front: as few steps beyond as the frames allow.
        every = max(1, rear_frames // frames)
        frames = math.ceil(rear_frames / every)
    steps = every * rear_steps * frames
    if steps > MOST_STEPS:
        raise UsageError(
            explain("the run would be too long", f"{steps} steps", f"at most {MOST_STEPS}", "raise --timestep")
        )
    return frames, rear_steps, steps
