"""The plan: which model, how many beads, which step, loss and frames a scene needs, each with its reason."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from beadband.errors import UsageError, explain
from beadband.model.calibration import Strand
from beadband.model.laws.unloading import SHARP_FRONT
from beadband.model.peg import own_radius_m
from beadband.model.scales import LONGEST_LAYER, SPEED_WINDOW, viscous_front_m
from beadband.model.scene import Scene
from beadband.model.validity import law_reasons, validity_notices
from beadband.model.wedge import StringLimit
from beadband.notices import Notice, distinct_digits, notice, percent
from beadband.parameters import FEWEST_BEADS, PLANNED, TABLE
from beadband.planning import error_curves
from beadband.planning.sampling import leg_end_s, sample_leg, sample_ring

MOST_PLANNED_BEADS = 6000
FEWEST_LEG_BONDS = 8
FEWEST_STRIP_BONDS = 240
"""Bonds of a planned strip at least: they cost little, and its recoil speed is right to 0.1 % for nearly every law."""

STEP_SHARE = 0.65
"""Share of the largest stable step that is used."""
LOSS_BEADS = 0.2
"""Viscosity of the numerical loss over (spacing x density x front speed): what a shock needs at every spacing."""
SMOOTH_RESOLUTION = 24.0
"""Beads in the rear from which on a law that unloads without a shock gets less: the loss falls as the spacing does, and
what it makes of the answer with the second order. Below, beads of any law need the whole of it."""

# How far up a leg a disturbance can have run and come back from, beyond what the front alone reaches: bending waves run
# ahead of the front; so many bending layers, and that share of the leg, take their echo below 1e-4 of V.
_LAYERS_AHEAD = 6.0
_SHARE_AHEAD = 0.05
WIDEST_FRONT = 0.03
"""Width of a viscous front over the leg from which on disturbances outrun the front, if the beads resolve it."""


@dataclass(frozen=True)
class Plan:
    """Everything that a run needs to know beyond the physics; times in s."""

    scene: Scene
    """The scene with beads, step and loss filled in."""
    model: str
    """"ring" for the whole ring on its finger, "leg" for one leg of it, "strip" for a strip."""
    beads: int
    """Of the whole ring, whatever part of it is computed."""
    leg_bonds: int
    """Bonds of the part of a leg that lies within the domain of dependence of the rear."""
    timestep_s: float
    largest_timestep_s: float
    loss_time_s: float
    steps: int
    frame_steps: int
    """Steps from one frame of the whole ring to the next."""
    rear_steps: int
    """Steps from one frame of the rear to the next."""
    unresolved_curvature: bool
    """Whether the beads are too coarse for the bending layer of the held tip."""
    speed_error: float
    """Predicted relative error of the rebound speed (95 % of scenes stay below it)."""
    curvature_error: float | None
    """Predicted relative error of the window-averaged tip curvature, None where it is not resolved."""
    reasons: tuple[Notice, ...]
    warnings: tuple[Notice, ...]

    def __repr__(self) -> str:
        steps = f"{self.beads} beads, {self.steps} steps of {self.timestep_s:.3g} s"
        return f"<Plan of {self.scene!r}:\n {self.model}, {steps}, V to {percent(self.speed_error)} expected>"

    @property
    def string(self) -> StringLimit:
        """The string limit of the scene."""
        return self.scene.string

    @property
    def front_arrival_s(self) -> float:
        """When the front of the string limit reaches the finger, t_f."""
        return self.scene.scales.front_arrival_s

    @cached_property
    def strand(self) -> Strand:
        """What the chain of beads is made of."""
        return self.scene.strand(self.beads)

    @property
    def frames(self) -> int:
        return self.steps // self.frame_steps

    @property
    def computed_beads(self) -> int:
        """Beads that are integrated."""
        return self.leg_bonds + 2 if self.model == "leg" else self.beads

    @property
    def bead_steps(self) -> int:
        return self.computed_beads * self.steps

    @property
    def seconds(self) -> float:
        """Predicted wall time on one core, without the second run that judges the error."""
        frames = 0 if self.model == "leg" else self.frames
        return error_curves.seconds(self.model, self.computed_beads, self.steps, frames)

    @property
    def disk_bytes(self) -> float:
        """Predicted size of the files of a whole ring."""
        return error_curves.disk_bytes(self.beads, self.frames, self.steps // self.rear_steps)


def plan_of(scene: Scene, model: str = "ring", smooth: bool = True) -> Plan:
    """Plan a release: choose what the scene leaves open; UsageError for a choice of the user's that can't work.

    ``model`` is "ring" where the whole trajectory is wanted, and "leg" for numbers alone: where one leg won't do the
    ring is taken all the same. A strip is always computed whole. A law that unloads without a shock gets less loss,
    unless ``smooth`` is false. A launch is planned by :func:`beadband.planning.plan_scene`.
    """
    if scene.until == "launch":
        raise UsageError(explain("this plans releases only", "until launch", "until release", "use beadband.plan"))
    if scene.auto_tolerance:
        from beadband.model.uncertainty import with_auto_tolerance

        scene = with_auto_tolerance(scene)
    reasons: list[Notice] = []
    warnings: list[Notice] = []
    scales, length = scene.scales, scene.wedge.reference_leg_m
    if scene.is_strip:
        model = "strip"
    elif scales.bending_layer_m > LONGEST_LAYER * length:
        model = "ring"
    beads = scene.beads or _choose_beads(scene, model, reasons, warnings)
    strand = scene.strand(beads)
    if model == "leg" and viscous_front_m(scene) > max(WIDEST_FRONT * length, 2.0 * strand.spacing_m):
        model = "ring"
    loss_time, loss_beads = _choose_loss(scene, strand, smooth, reasons)
    compression = _compression(scene, loss_beads, warnings)
    largest = strand.largest_step_s(loss_time, scene.strain, compression)
    if scene.timestep_s is not None and scene.timestep_s > largest:
        raise UsageError(
            explain(
                "the time step is beyond the limit of stability",
                f"{scene.timestep_s:.4g} s",
                f"at most {largest:.4g} s for {beads} beads",
                "lower --timestep or --beads",
            )
        )
    arrival = scales.front_arrival_s
    target = scene.timestep_s or STEP_SHARE * largest
    if model == "leg":
        end = leg_end_s(scene)
        frames, rear_steps, steps = sample_leg(scene, end, target)
    else:
        end = arrival
        frames, rear_steps, steps = sample_ring(scene, end, target)
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
    share = _dependence_share(scene, end)
    leg_bonds = max(FEWEST_LEG_BONDS, math.ceil(share * length / strand.spacing_m))
    if scene.timestep_s is None:
        reasons.append(
            notice("step", step_s=timestep, value=timestep / largest, steps=steps, end=end / arrival, end_s=end)
        )
    if model != "strip":
        reasons.append(_bending_reason(scene))
    if scene.tip_radius_m:
        reasons.append(_peg_reason(scene, strand.spacing_m))
        warnings += [one for one in reasons[-1:] if one.code == "peg-unresolved" and scene.beads is not None]
    reasons += law_reasons(scene)
    reasons.append(
        {
            "leg": notice("one-leg", bonds=leg_bonds, beads=beads, value=share),
            "ring": notice("whole-ring", value=share),
            "strip": notice("strip"),
        }[model]
    )
    if model != "leg":
        reasons.append(notice("frames", frames=frames, rear=steps // rear_steps, value=rear_steps))
        if scene.frames not in (None, frames):
            warnings.append(notice("frames-adjusted", value=frames, limit=scene.frames, steps=steps))
    else:
        reasons.append(notice("samples", rear=steps // rear_steps, value=rear_steps))
    layer = scales.bending_layer_m
    unresolved = strand.spacing_m > error_curves.COARSEST_SPACING * layer
    warnings += validity_notices(scene)
    if unresolved and layer and scene.beads is not None:
        warnings.append(notice("unresolved-layer", layer_mm=layer * 1e3, spacing_mm=strand.spacing_m * 1e3))
    if scene.input_share is not None:
        usual = replace(scene, tolerance=TABLE["tolerance"].default, input_share=None)
        saved = error_curves.beads_for(usual, model) / error_curves.beads_for(scene, model)
        reasons.append(
            notice("tolerance-auto", value=100.0 * scene.tolerance, limit=100.0 * scene.input_share, saved=saved)
        )
    speed_error = error_curves.speed_error(scene, strand.spacing_m, model)
    stated, limit = error_curves.stated_error(scene, speed_error), scene.tolerance
    if stated > limit * (1.0 + 1e-9):
        warnings.append(
            notice("tolerance-not-expected", value=stated, limit=limit, digits=distinct_digits(stated, limit))
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
        unresolved_curvature=unresolved,
        speed_error=speed_error,
        curvature_error=error_curves.curvature_error(scene, strand.spacing_m),
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )


def _choose_beads(scene: Scene, model: str, reasons: list[Notice], warnings: list[Notice]) -> int:
    """Beads that the speed needs, and those that the curvature needs where it is asked for."""
    length, rear = scene.band.circumference_m, scene.scales.rear_length_m
    needed = error_curves.beads_for(scene, model)
    fewest = FEWEST_STRIP_BONDS if model == "strip" else FEWEST_LEG_BONDS * length / scene.wedge.reference_leg_m
    for_peg = length / error_curves.peg_spacing_m(scene)
    wanted = max(needed, fewest, FEWEST_BEADS, for_peg)
    layer = scene.scales.bending_layer_m
    if scene.purpose == "curvature" and layer > 0.0:
        spacing = error_curves.curvature_spacing_m(scene)
        for_curvature = length / spacing
        if wanted < for_curvature <= MOST_PLANNED_BEADS:
            beads = round_up(for_curvature)
            reasons.append(
                notice(
                    "beads-for-curvature",
                    beads=beads,
                    layer_mm=layer * 1e3,
                    value=spacing / layer,
                    spacing_mm=spacing * 1e3,
                    for_speed=round_up(wanted),
                )
            )
            return beads
        if for_curvature > MOST_PLANNED_BEADS:
            warnings.append(
                notice("layer-needs-more-beads", layer_mm=layer * 1e3, value=for_curvature, limit=MOST_PLANNED_BEADS)
            )
    if wanted > MOST_PLANNED_BEADS:
        warnings.append(
            notice("speed-needs-more-beads", value=wanted, tolerance=100.0 * scene.tolerance, limit=MOST_PLANNED_BEADS)
        )
    beads = round_up(min(wanted, MOST_PLANNED_BEADS))
    if wanted == for_peg:
        reasons.append(notice("beads-for-peg", beads=beads, value=1e3 * length / beads, for_speed=round_up(needed)))
        return beads
    code = "beads-for-strip" if model == "strip" else "beads-for-speed"
    value, limit = needed * rear / length, 100.0 * scene.tolerance
    reasons.append(notice(code, beads=beads, rear_mm=rear * 1e3, value=value, limit=limit))
    return beads


def round_up(beads: float) -> int:
    """To a number whose half is even, so that the coarse run has it too; a round one where that costs little."""
    step = 20 if beads > 200.0 else 4
    return step * math.ceil(beads / step)


def _choose_loss(scene: Scene, strand: Strand, smooth: bool, reasons: list[Notice]) -> tuple[float, float]:
    """Loss time in s, and the viscous stress of a front over that of its inertia between two beads.

    The loss time is defined by E, which need not be the law's.
    """
    band = scene.band
    front_loss_s = strand.spacing_m * band.density_kg_m3 * scene.string.wave.tail_speed_m_s / band.modulus_pa
    if scene.loss_time_s is not None:
        return scene.loss_time_s, scene.loss_time_s / front_loss_s
    resolution = scene.scales.rear_length_m / strand.spacing_m
    # Without a kink the loss does nothing to a sharp front but make it smooth, so that its middle can be told.
    sharp = scene.is_strip and scene.string.wave.kind == SHARP_FRONT
    if scene.string.wave.shocks or sharp or not smooth or resolution <= SMOOTH_RESOLUTION:
        reasons.append(notice("loss", value=LOSS_BEADS * front_loss_s, limit=LOSS_BEADS))
        return LOSS_BEADS * front_loss_s, LOSS_BEADS
    loss_beads = LOSS_BEADS * SMOOTH_RESOLUTION / resolution
    reasons.append(notice("loss-without-shock", value=loss_beads * front_loss_s, limit=loss_beads))
    return loss_beads * front_loss_s, loss_beads


def _dependence_share(scene: Scene, end_s: float) -> float:
    """Share of the leg within the domain of dependence of the tip up to ``end_s``.

    Out with the front, back at the speed of sound behind the wave; and what bending waves, which run ahead, need.
    Within a fan the way back is one of constant distance times time: it leaves the fan after sqrt(front/tail) of the
    time that the front took, at sqrt(tail/front) of the distance.
    """
    string = scene.string
    front, tail = string.front_speed_m_s, string.wave.tail_speed_m_s
    behind = math.sqrt(float(scene.material.tangent(1.0 + string.residual_strain)) / scene.band.density_kg_m3)
    leg = scene.wedge.reference_leg_m
    there_and_back = end_s / leg / (1.0 / math.sqrt(tail * front) + math.sqrt(tail / front) / behind)
    wrapped = scene.scales.remembered_m - scene.scales.bending_layer_m  # the front starts where the band leaves its peg
    return there_and_back + (wrapped + _LAYERS_AHEAD * scene.scales.bending_layer_m) / leg + _SHARE_AHEAD


def _bending_reason(scene: Scene) -> Notice:
    """Whether bending matters to what is asked."""
    if scene.bending_stiffness_n_m2 == 0.0:
        return notice("no-bending")
    sine = math.sin(scene.half_angle_rad)
    return notice(
        "bending-for-curvature" if scene.purpose == "curvature" else "bending-for-speed",
        value=scene.scales.bending_spread_m * 1e3,
        limit=scene.wedge.reference_leg_m * scene.strain * sine / (1.0 - sine) * 1e3,
        string=scene.string.rear_speed_m_s,
    )


def _peg_reason(scene: Scene, spacing_m: float) -> Notice:
    """How the peg holds the tip."""
    own = own_radius_m(scene.strand(1), scene.strain, scene.half_angle_rad)
    given, peg = {"radius_mm": scene.tip_radius_m * 1e3, "limit": own * 1e3}, scene.peg
    if peg is None:
        return notice("peg-at-tip", **given)
    if spacing_m > peg.widest_m:
        return notice("peg-unresolved", value=spacing_m * 1e3, **given | {"limit": peg.widest_m * 1e3})
    share = peg.wrapped_m / scene.wedge.reference_leg_m
    return notice("on-peg", value=share, angle=math.degrees(peg.lift_off_rad), **given)


def _compression(scene: Scene, loss_beads: float, warnings: list[Notice]) -> float:
    """Least stretch that bonds come through, from measured releases; it sets the stiffest modes.

    Behind a front that its loss keeps smooth bonds hardly overshoot; without loss they ring, behind a shock with an
    amplitude of order one that no refinement removes.
    """
    law, wave = scene.material, scene.string.wave
    shortest = law.shortest_stretch()
    least = 0.0 if shortest is None else 0.5 * (1.0 + shortest)
    if loss_beads >= 0.45 * LOSS_BEADS:
        return max(0.6, 1.0 - 0.2 * scene.strain, least)
    head_speed = math.sqrt(float(law.tangent(1.0 + scene.strain)) / scene.band.density_kg_m3)
    if wave.kind != "shock and fan" and wave.front_speed_m_s < 1.01 * head_speed:
        return max(0.75, least)
    warnings.append(notice("lossless-shock", value=loss_beads, limit=LOSS_BEADS))
    return max(0.5, least)
