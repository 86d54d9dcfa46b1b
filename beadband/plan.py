"""The plan: how many beads, which step, loss and frames a scene needs, each with its reason.

The rules come from measured errors; tests/test_release.py and tests/test_plan.py hold them to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from beadband.errors import UsageError, explain
from beadband.ring import FEWEST_BEADS
from beadband.scales import SPEED_WINDOW, bending_layer_m, front_arrival_s, similarity_window
from beadband.scene import PLANNED, Scene
from beadband.wedge import StringLimit

# Where the errors of the rebound speed and of the tip curvature reach half a per cent:
# bead spacing over the length of the held bending layer; and, without bending, beads of the ring and of that half of
# the rear which the kink has left behind it when the front arrives.
TOLERANCE_OF_RULES = 0.005
CURVATURE_SPACING = 0.6
SPEED_SPACING = 0.8
FRONT_BEADS = 400
REAR_BEADS = 12
LEAST_BEADS = 240
COARSEST_SPACING = 1.5
"""Beyond this share of the bending layer the tip curvature is not measured at all."""
MOST_PLANNED_BEADS = 6000

FRAMES = 60
MOST_STEPS = 2_000_000_000
STEP_SHARE = 0.65
"""Share of the largest stable step that is used."""
LOSS_BEADS = 0.2
"""Viscosity of the numerical loss over (spacing x density x front speed)."""
_REAR_FRAMES = 240
_FEWEST_REAR_FRAMES = 120
_FEWEST_REAR_STEPS = 4  # the fastest bending mode has a period of pi largest steps: averages must span it


@dataclass(frozen=True)
class Plan:
    """Everything that a run needs to know beyond the physics; times in s."""

    scene: Scene
    """The scene with beads, step and loss filled in."""
    beads: int
    timestep_s: float
    largest_timestep_s: float
    loss_time_s: float
    steps: int
    frame_steps: int
    """Steps from one frame of the whole ring to the next."""
    rear_steps: int
    """Steps from one frame of the rear to the next."""
    string: StringLimit
    front_arrival_s: float
    unresolved_curvature: bool
    """Whether the beads are too coarse for the bending layer of the held tip."""
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def frames(self) -> int:
        return self.steps // self.frame_steps


def plan_of(scene: Scene) -> Plan:
    """Choose what the scene leaves open; UsageError for a choice of the user's that can't work."""
    if scene.until == "launch":
        raise UsageError(
            explain("the launch is not part of this version", "--until launch", "--until release", "leave --until out")
        )
    string = scene.string
    reasons: list[str] = []
    warnings: list[str] = []
    beads = scene.beads or _choose_beads(scene, reasons, warnings)
    if beads < FEWEST_BEADS:
        raise UsageError(explain("too few beads", beads, f"{FEWEST_BEADS} or more", "raise --beads"))
    strand = scene.strand(beads)

    # Viscous stress of a front over that of its inertia: the loss time is defined by E, which need not be the law's.
    band = scene.band
    front_loss_s = strand.spacing_m * band.density_kg_m3 * string.front_speed_m_s / band.modulus_pa
    loss_time = scene.loss_time_s
    if loss_time is None:
        loss_time = LOSS_BEADS * front_loss_s
        reasons.append(
            f"loss time {loss_time:.3g} s: {LOSS_BEADS} of the front's time from bead to bead, enough to give it a "
            "smooth profile of a few beads, and vanishing with the mesh"
        )
    loss_beads = loss_time / front_loss_s
    compression = _compression(scene, string, loss_beads, warnings)
    largest = strand.largest_step_s(loss_time, scene.strain, compression)
    arrival = front_arrival_s(scene, string)
    if scene.timestep_s is not None and scene.timestep_s > largest:
        raise UsageError(
            explain(
                "the time step is beyond the limit of stability",
                f"{scene.timestep_s:.4g} s",
                f"at most {largest:.4g} s for {beads} beads",
                "lower --timestep or --beads",
            )
        )
    target = scene.timestep_s or STEP_SHARE * largest
    frames, rear_steps, steps = _sampling(scene, string, arrival, target)
    # The last step ends at the front's arrival unless the user fixed the step.
    timestep = scene.timestep_s or arrival / steps
    if scene.timestep_s is None:
        reasons.append(
            f"step {timestep:.3g} s: {timestep / largest:.2f} of the largest stable one, {steps} steps to the "
            f"front's arrival at {arrival:.4g} s"
        )
    if steps * timestep < SPEED_WINDOW[1] * arrival:
        raise UsageError(
            explain(
                "the run is too short to measure the rebound speed",
                f"{steps} steps of {timestep:.4g} s",
                f"at least {SPEED_WINDOW[1]} of the front's arrival at {arrival:.4g} s",
                "leave steps to the plan",
            )
        )
    reasons.append(
        f"{frames} frames of the ring, and {steps // rear_steps} of its rear, each an average over {rear_steps} steps"
    )
    layer = bending_layer_m(scene)
    unresolved = strand.spacing_m > COARSEST_SPACING * layer
    if not unresolved:
        _beam_warnings(scene, warnings)
    elif layer and scene.beads is not None:
        warnings.append(
            f"the bending layer of the held tip ({layer:.3g} m) is finer than the beads "
            f"({strand.spacing_m:.3g} m): the tip curvature is not resolved"
        )
    return Plan(
        scene=replace(
            scene,
            beads=beads,
            timestep_s=timestep,
            loss_time_s=loss_time,
            frames=frames,
            steps=steps,
            rear_steps=rear_steps,
            planned=tuple(key for key in PLANNED if getattr(scene, key) is None or key in scene.planned),
        ),
        beads=beads,
        timestep_s=timestep,
        largest_timestep_s=largest,
        loss_time_s=loss_time,
        steps=steps,
        frame_steps=steps // frames,
        rear_steps=rear_steps,
        string=string,
        front_arrival_s=arrival,
        unresolved_curvature=unresolved,
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )


def _choose_beads(scene: Scene, reasons: list[str], warnings: list[str]) -> int:
    """Beads from the bending layer and from the front; the errors behind the numbers are of second order in a."""
    layer, length = bending_layer_m(scene), scene.band.circumference_m
    finer = math.sqrt(TOLERANCE_OF_RULES / scene.tolerance)
    sine = math.sin(scene.half_angle_rad)
    rear_share = scene.wedge.reference_leg_m / length * scene.strain * sine / (1.0 - sine)
    front = finer * max(FRONT_BEADS, REAR_BEADS / rear_share)
    if scene.purpose == "curvature" and layer > 0.0:
        wanted = max(finer * length / (CURVATURE_SPACING * layer), LEAST_BEADS)
        if wanted <= MOST_PLANNED_BEADS:
            beads = _round_up(wanted)
            reasons.append(
                f"{beads} beads: the held tip bends over a layer of {layer:.3g} m, and the tip curvature needs beads "
                f"closer than {CURVATURE_SPACING / finer:.2g} of it"
            )
            return beads
        warnings.append(
            f"the bending layer of the held tip is only {layer:.3g} m: the tip curvature would need {wanted:.0f} beads "
            "and is not resolved (set --beads to insist)"
        )
    wanted = finer * length / (SPEED_SPACING * layer) if layer > 0.0 else math.inf
    wanted = min(max(wanted, finer * LEAST_BEADS), front)
    if wanted > MOST_PLANNED_BEADS:
        warnings.append(
            f"the rebound speed would need {wanted:.0f} beads for this tolerance; the plan stops at "
            f"{MOST_PLANNED_BEADS} (set --beads to insist)"
        )
    beads = _round_up(min(wanted, MOST_PLANNED_BEADS))
    reasons.append(
        f"{beads} beads: the front and the kinks need them for the rebound speed, which a finer bending layer would "
        "not move"
    )
    return beads


def _round_up(beads: float) -> int:
    return 20 * math.ceil(beads / 20.0)


def _sampling(scene: Scene, string: StringLimit, arrival: float, target: float) -> tuple[int, int, int]:
    """Frames of the ring, steps between frames of the rear, and steps in all; UsageError when they don't divide."""
    if scene.steps is not None:
        frames, rear_steps = scene.frames or 1, scene.rear_steps or 1
        if scene.steps % frames or (scene.steps // frames) % rear_steps:
            raise UsageError(
                explain(
                    "steps and frames do not divide",
                    f"steps {scene.steps}, frames {frames}, rear_steps {rear_steps}",
                    "steps a multiple of frames x rear_steps",
                    "leave steps and rear_steps to the plan",
                )
            )
        return frames, rear_steps, scene.steps
    interval = arrival / _REAR_FRAMES
    window = similarity_window(scene, string)
    if window.reason is None:
        interval = min(interval, (window.end_s - window.start_s) / 12.0)
    rear_steps = scene.rear_steps or max(_FEWEST_REAR_STEPS, int(interval / target))
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


def _compression(scene: Scene, string: StringLimit, loss_beads: float, warnings: list[str]) -> float:
    """Least stretch that bonds come through, from measured releases; it sets the stiffest modes.

    Behind a front that its loss keeps smooth bonds hardly overshoot; without loss they ring, behind a shock with an
    amplitude of order one that no refinement removes.
    """
    if loss_beads >= 0.5 * LOSS_BEADS:
        return max(0.6, 1.0 - 0.2 * scene.strain)
    head_speed = math.sqrt(float(scene.material.tangent(1.0 + scene.strain)) / scene.band.density_kg_m3)
    if string.front_speed_m_s < 1.01 * head_speed:
        return 0.75
    warnings.append(
        f"this law unloads through a shock, and a loss of {loss_beads:.2g} of the front's time from bead to bead does "
        "not resolve it: it rings, and the rebound speed is about 1 % too low whatever the number of beads"
    )
    return 0.5


def _beam_warnings(scene: Scene, warnings: list[str]) -> None:
    """Say where the held tip is bent more sharply than beam theory bears."""
    layer = bending_layer_m(scene)
    sharpness = math.sin((math.pi / 2.0 - scene.half_angle_rad) / 2.0) * scene.band.thickness_m / layer
    if sharpness > 0.5:
        warnings.append(
            f"the held tip has (curvature x half thickness) = {sharpness:.2g}: beam theory is not accurate for it "
            "until the curvature has fallen"
        )
