"""How long a release runs, and how often it is sampled: frames of the ring, means of its rear, and steps in all."""

from __future__ import annotations

import math

from beadband.errors import UsageError, explain
from beadband.model.scene import Scene
from beadband.parameters import MOST_STEPS

FRAMES = 60
_REAR_FRAMES = 240
_FEWEST_REAR_FRAMES = 120
_FEWEST_REAR_STEPS = 4  # the fastest bending mode has a period of pi largest steps: averages must span it
_SPEED_END = 0.87
"""Share of the front's arrival at which the speed is known, so that a leg may stop."""


def leg_end_s(scene: Scene) -> float:
    """When all that is asked of a leg has been measured: the speed, and the curvature in its window."""
    window = scene.scales.window
    asked = _SPEED_END * scene.scales.front_arrival_s
    return max(asked, window.end_s) if scene.purpose == "curvature" and window.exists else asked


def sample_leg(scene: Scene, end: float, target: float) -> tuple[int, int, int]:
    """Frames (one), steps between means of the rear, and steps in all, of a leg."""
    rear_steps = max(1, int(interval_s(scene, end) / target))
    return 1, rear_steps, rear_steps * math.ceil(end / (rear_steps * target) * (1.0 - 1e-12))


def interval_s(scene: Scene, end: float) -> float:
    """Longest time between frames of the rear."""
    window = scene.scales.window
    interval = end / _REAR_FRAMES
    return interval if not window.exists else min(interval, (window.end_s - window.start_s) / 12.0)


def given(scene: Scene, steps: int) -> tuple[int, int, int]:
    """Frames, steps between frames of the rear, and all steps, as given; UsageError when they do not divide."""
    frames, rear_steps = scene.frames or 1, scene.rear_steps or 1
    if steps % frames or steps % rear_steps:
        raise UsageError(
            explain(
                "steps and frames do not divide",
                f"steps {steps}, frames {frames}, rear_steps {rear_steps}",
                "steps a multiple of frames and of rear_steps",
                "leave steps and rear_steps to the plan",
            )
        )
    return frames, rear_steps, steps


def sample_ring(scene: Scene, arrival: float, target: float) -> tuple[int, int, int]:
    """Frames of the ring, steps between frames of the rear, and steps in all; UsageError when they don't divide.

    The number of frames never changes the step: frames share out the steps evenly, so their number is a divisor of
    the steps, the nearest to what was asked for.
    """
    if scene.steps is not None:
        return given(scene, scene.steps)
    rear_steps = scene.rear_steps or max(_FEWEST_REAR_STEPS, int(interval_s(scene, arrival) / target))
    rear_frames = math.ceil(arrival / (rear_steps * target) * (1.0 - 1e-12))
    if scene.timestep_s is None:
        rear_frames = max(rear_frames, _FEWEST_REAR_FRAMES)
    frames = min(FRAMES, rear_frames)
    every = math.ceil(rear_frames / frames)
    if scene.timestep_s is not None:
        # A given step can't be stretched to end with the front: as few steps beyond as the frames allow.
        every = max(1, rear_frames // frames)
        frames = math.ceil(rear_frames / every)
    steps = every * rear_steps * frames
    if steps > MOST_STEPS:
        raise UsageError(
            explain("the run would be too long", f"{steps} steps", f"at most {MOST_STEPS}", "raise --timestep")
        )
    return (frames if scene.frames is None else nearest_divisor(steps, scene.frames)), rear_steps, steps


def nearest_divisor(number: int, wanted: int) -> int:
    """The divisor of a number that is nearest to another, by ratio; the smaller of two as near."""
    low = [one for one in range(1, math.isqrt(number) + 1) if number % one == 0]
    return min((*low, *(number // one for one in low)), key=lambda one: (abs(math.log(one / wanted)), one))
