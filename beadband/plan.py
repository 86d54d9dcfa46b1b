"""The plan: which model, how many beads, which step, loss and frames a scene needs, each with its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from beadband import accuracy
from beadband.errors import UsageError, explain
from beadband.ring import FEWEST_BEADS
from beadband.sampling import leg_end_s, sample_leg, sample_ring
from beadband.scales import SPEED_WINDOW, bending_layer_m, front_arrival_s, viscous_front_m
from beadband.scene import PLANNED, Scene
from beadband.validity import validity_warnings
from beadband.wedge import StringLimit

MOST_PLANNED_BEADS = 6000
FEWEST_LEG_BONDS = 8

STEP_SHARE = 0.65
"""Share of the largest stable step that is used."""
LOSS_BEADS = 0.2
"""Viscosity of the numerical loss over (spacing x density x front speed)."""

# How far up a leg news can have gone and come back from, beyond what the front alone makes of it: bending waves run
# ahead of the front; so many bending layers, and that share of the leg, take their echo below 1e-4 of V.
_LAYERS_AHEAD = 6.0
_SHARE_AHEAD = 0.05
LONGEST_LAYER = 0.08
"""Bending layer over the leg beyond which the finger is felt at the tip, so that a leg alone won't do."""
WIDEST_FRONT = 0.03
"""Width of a viscous front over the leg from which on news no longer comes with the front, if the beads resolve it."""


@dataclass(frozen=True)
class Plan:
    """Everything that a run needs to know beyond the physics; times in s."""

    scene: Scene
    """The scene with beads, step and loss filled in."""
    model: str
    """"ring" for the whole ring on its finger, "leg" for one leg of it."""
    beads: int
    """Of the whole ring, whatever part of it is computed."""
    leg_bonds: int
    """Bonds of the part of a leg that the rear can hear of."""
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
    speed_error: float
    """Predicted relative error of the rebound speed (95 % of scenes stay below it)."""
    curvature_error: float | None
    """Predicted relative error of the window-averaged tip curvature, None where it is not resolved."""
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def frames(self) -> int:
        return self.steps // self.frame_steps

    @property
    def computed_beads(self) -> int:
        """Beads that are integrated."""
        return self.beads if self.model == "ring" else self.leg_bonds + 2

    @property
    def bead_steps(self) -> int:
        return self.computed_beads * self.steps

    @property
    def seconds(self) -> float:
        """Predicted wall time on one core, without the second run that judges the error."""
        frames = self.frames if self.model == "ring" else 0
        return accuracy.seconds(self.model, self.computed_beads, self.steps, frames)


def plan_of(scene: Scene, model: str = "ring") -> Plan:
    """Choose what the scene leaves open; UsageError for a choice of the user's that can't work.

    ``model`` is "ring" for what somebody will look at, and "leg" for numbers alone: where the leg alone won't do the
    ring is taken all the same.
    """
    if scene.until == "launch":
        raise UsageError(
            explain("this plans releases only", "until launch", "until release", "launch_plan_of plans launches")
        )
    string = scene.string
    reasons: list[str] = []
    warnings: list[str] = []
    layer, length = bending_layer_m(scene), scene.wedge.reference_leg_m
    if layer > LONGEST_LAYER * length:
        model = "ring"
    beads = scene.beads or _choose_beads(scene, string, model, reasons, warnings)
    if beads < FEWEST_BEADS:
        raise UsageError(explain("too few beads", beads, f"{FEWEST_BEADS} or more", "raise --beads"))
    strand = scene.strand(beads)
    if viscous_front_m(scene, string) > max(WIDEST_FRONT * length, 2.0 * strand.spacing_m):
        model = "ring"
    loss_time, loss_beads = _choose_loss(scene, string, beads, reasons)
    compression = _compression(scene, string, loss_beads, warnings)
    largest = strand.largest_step_s(loss_time, scene.strain, compression)
    arrival = front_arrival_s(scene, string)
    end = arrival if model == "ring" else leg_end_s(scene, string, arrival)
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
    if model == "ring":
        frames, rear_steps, steps = sample_ring(scene, string, end, target)
    else:
        frames, rear_steps, steps = sample_leg(scene, string, end, target)
    # The last step ends at the front's arrival unless the user fixed the step.
    timestep = scene.timestep_s or end / steps
    if steps * timestep < SPEED_WINDOW[1] * arrival:
        raise UsageError(
            explain(
                "the run is too short to measure the rebound speed",
                f"{steps} steps of {timestep:.4g} s",
                f"at least {SPEED_WINDOW[1]} of the front's arrival at {arrival:.4g} s",
                "leave steps to the plan",
            )
        )
    leg_bonds = max(FEWEST_LEG_BONDS, math.ceil(_heard_share(scene, string, end) * length / strand.spacing_m))
    if scene.timestep_s is None:
        reasons.append(
            f"step {timestep:.3g} s: {timestep / largest:.2f} of the largest stable one, {steps} steps to "
            + (f"the front's arrival at {arrival:.4g} s" if end == arrival else f"{end / arrival:.2f} of its arrival")
        )
    reasons.append(_bending_reason(scene, string))
    reasons.append(_model_reason(model, scene, string, end / arrival, beads, leg_bonds))
    reasons.append(
        (f"{frames} frames of the ring, and {steps // rear_steps}" if model == "ring" else f"{steps // rear_steps}")
        + f" of its rear, each an average over {rear_steps} steps, for bead-scale modes would alias"
    )
    unresolved = strand.spacing_m > accuracy.COARSEST_SPACING * layer
    warnings += validity_warnings(scene)
    if unresolved and layer and scene.beads is not None:
        warnings.append(
            f"the bending layer of the held tip ({layer * 1e3:.3g} mm) is finer than the beads "
            f"({strand.spacing_m * 1e3:.3g} mm): the tip curvature is not resolved"
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
        model=model,
        beads=beads,
        leg_bonds=leg_bonds,
        timestep_s=timestep,
        largest_timestep_s=largest,
        loss_time_s=loss_time,
        steps=steps,
        frame_steps=steps // frames,
        rear_steps=rear_steps,
        string=string,
        front_arrival_s=arrival,
        unresolved_curvature=unresolved,
        speed_error=accuracy.speed_error(scene, string, strand.spacing_m, model),
        curvature_error=accuracy.curvature_error(scene, strand.spacing_m),
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )


def _choose_beads(scene: Scene, string: StringLimit, model: str, reasons: list[str], warnings: list[str]) -> int:
    """Beads that the speed needs, and those that the curvature needs where it is asked for."""
    length, rear = scene.band.circumference_m, accuracy.rear_length_m(scene, string)
    needed = accuracy.beads_for(scene, string, model)
    in_rear = needed * rear / length
    wanted = max(needed, FEWEST_LEG_BONDS * length / scene.wedge.reference_leg_m, FEWEST_BEADS)
    layer = bending_layer_m(scene)
    if scene.purpose == "curvature" and layer > 0.0:
        spacing = accuracy.curvature_spacing_m(scene)
        for_curvature = length / spacing
        if wanted < for_curvature <= MOST_PLANNED_BEADS:
            beads = _round_up(for_curvature)
            reasons.append(
                f"{beads} beads: the held tip bends over a layer of {layer * 1e3:.3g} mm, and the tip curvature needs "
                f"beads closer than {spacing / layer:.2g} of it ({spacing * 1e3:.3g} mm); the speed alone would do "
                f"with {_round_up(wanted)}"
            )
            return beads
        if for_curvature > MOST_PLANNED_BEADS:
            warnings.append(
                f"the bending layer of the held tip is only {layer * 1e3:.3g} mm: the tip curvature would need "
                f"{for_curvature:.0f} beads and is not resolved (set --beads to insist)"
            )
    if wanted > MOST_PLANNED_BEADS:
        warnings.append(
            f"the rebound speed would need {wanted:.0f} beads for this tolerance; the plan stops at "
            f"{MOST_PLANNED_BEADS} (set --beads to insist)"
        )
    beads = _round_up(min(wanted, MOST_PLANNED_BEADS))
    reasons.append(
        f"{beads} beads: what moves at the rear is {rear * 1e3:.3g} mm long, and the rebound speed needs {in_rear:.3g} "
        f"beads in it for {scene.tolerance:.2%}"
    )
    return beads


def _round_up(beads: float) -> int:
    """To a number whose half is even, so that the second run has it too; a round one where that costs little."""
    step = 20 if beads > 200.0 else 4
    return step * math.ceil(beads / step)


def _choose_loss(scene: Scene, string: StringLimit, beads: int, reasons: list[str]) -> tuple[float, float]:
    """Loss time in s, and the viscous stress of a front over that of its inertia between two beads.

    The loss time is defined by E, which need not be the law's.
    """
    band = scene.band
    front_loss_s = scene.strand(beads).spacing_m * band.density_kg_m3 * string.front_speed_m_s / band.modulus_pa
    if scene.loss_time_s is not None:
        return scene.loss_time_s, scene.loss_time_s / front_loss_s
    reasons.append(
        f"loss time {LOSS_BEADS * front_loss_s:.3g} s: {LOSS_BEADS} of the front's time from bead to bead, enough to "
        "give it a smooth profile of a few beads, and vanishing with the mesh"
    )
    return LOSS_BEADS * front_loss_s, LOSS_BEADS


def _heard_share(scene: Scene, string: StringLimit, end_s: float) -> float:
    """Share of the leg from which news can be back at the tip by ``end_s``.

    Out with the front, back at the speed of sound behind it; and what bending waves, which run ahead, need.
    """
    behind = math.sqrt(float(scene.material.tangent(1.0 + string.residual_strain)) / scene.band.density_kg_m3)
    leg = scene.wedge.reference_leg_m
    there_and_back = end_s / leg / (1.0 / string.front_speed_m_s + 1.0 / behind)
    return there_and_back + _LAYERS_AHEAD * bending_layer_m(scene) / leg + _SHARE_AHEAD


def _bending_reason(scene: Scene, string: StringLimit) -> str:
    """Whether bending matters to what is asked."""
    if scene.bending_stiffness_n_m2 == 0.0:
        return "no bending: the scene leaves it out"
    spread = math.sqrt(scene.bending_diffusivity_m2_s * front_arrival_s(scene, string))
    sine = math.sin(scene.half_angle_rad)
    rear = scene.wedge.reference_leg_m * scene.strain * sine / (1.0 - sine)
    kept = "the tip curvature is nothing but bending" if scene.purpose == "curvature" else "it rounds the kinks"
    return (
        f"bending is kept: {kept}, and it spreads over {spread * 1e3:.3g} mm by the front's arrival, against "
        f"{rear * 1e3:.3g} mm of rear; without it the speed would be the string's, {string.rear_speed_m_s:.4g} m/s"
    )


def _model_reason(model: str, scene: Scene, string: StringLimit, end: float, beads: int, leg_bonds: int) -> str:
    """What is computed of the scene, and what is not."""
    heard = _heard_share(scene, string, end * front_arrival_s(scene, string))
    if model == "leg":
        return (
            f"one leg, {leg_bonds} of the {beads} bonds: the other is its mirror image, and from beyond {heard:.2f} of "
            "the leg nothing comes back in time; no finger, no wrapped arc, no contact"
        )
    return (
        f"the whole ring, because its files are looked at; the beads on the finger stay where they are and no contact "
        f"is computed, for the news reaches them with the front (the rear alone would need one leg up to {heard:.2f})"
    )


def _compression(scene: Scene, string: StringLimit, loss_beads: float, warnings: list[str]) -> float:
    """Least stretch that bonds come through, from measured releases; it sets the stiffest modes.

    Behind a front that its loss keeps smooth bonds hardly overshoot; without loss they ring, behind a shock with an
    amplitude of order one that no refinement removes.
    """
    if loss_beads >= 0.45 * LOSS_BEADS:
        return max(0.6, 1.0 - 0.2 * scene.strain)
    head_speed = math.sqrt(float(scene.material.tangent(1.0 + scene.strain)) / scene.band.density_kg_m3)
    if string.front_speed_m_s < 1.01 * head_speed:
        return 0.75
    warnings.append(
        f"this law unloads through a shock, and a loss of {loss_beads:.2g} of the front's time from bead to bead does "
        "not resolve it: it rings, and the rebound speed is about 1 % too low whatever the number of beads"
    )
    return 0.5
