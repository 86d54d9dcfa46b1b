"""The plan of a launch: the release's, and what the finger, the meeting of the fronts and the flight add to it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from beadband.errors import UsageError, explain
from beadband.model.calibration import Strand
from beadband.model.launch_string import StringLaunch, string_launch
from beadband.model.scene import Scene
from beadband.model.validity import outside_test
from beadband.notices import Notice, notice
from beadband.parameters import MOST_STEPS, PLANNED
from beadband.planning import error_curves
from beadband.planning.plan import STEP_SHARE, Plan, plan_of, round_up
from beadband.planning.sampling import given, interval_s
from beadband.planning.self_contact import SelfContact, self_contact
from beadband.statics.chain import Array
from beadband.statics.finger import Support, finger_loads_n, settle_on
from beadband.statics.ring import Ring, stretched_ring

DEPTH_BOUND = 0.01
"""Deepest penetration of the finger that a sound launch may have, over the band's thickness."""
HELD_DEPTH = 0.0001
"""Depth of the most loaded bead in the held ring, over the thickness, at most; grazes of the band go deeper."""
CONTACT_SHARE = 0.3
"""Share of the square of the largest frequency that the step bears which the contact takes where it is free to."""
CORE_DEPTH = 0.5
"""Depth over the thickness beyond which the contact counts as broken through, and LAMMPS stops."""
SHORTEST_STRETCH = 0.05
"""Where the bond table of a launch begins: fronts that meet compress the band as no release does."""
_NEARLY_NOTHING = 0.2
_LEAST_COMPRESSION = 0.35  # measured: the deepest of the linear law at a strain of 1.4, whose beads buckle aside
SMOOTH_LOSS = 15.0
"""What the numerical loss takes from the efficiency where the law unloads without a shock, times beads^2 over the ratio
of circumference to thickness: 10 to 16 in launches of the linear law (all bands, strains 0.2 to 0.7)."""
BEADS_FOR_HAND = 560
"""Fewest planned beads where a hand moves: with 280 the peak force on it is 3 to 7 % too high on short thick bands."""
CAP = 3.0
"""Longest run, in units of what the string takes to be free and for its rear to arrive."""
FRAMES = 100
_FEWEST_REAR_STEPS = 4
_MOST_REAR_STEPS = 16  # the contact bounces in no less: its depth must not be missed
_IDLE_SHARE = 0.03
_APPROACH = 1.5
_NOSE = 0.5
_GRAZE, _MOST_GRAZE = 0.4, 1.2
"""Speed at which a bead is thrown against the finger, over the rear's: without a pause, and at most. The longer the
band flies beside the finger the faster is its hardest graze; measured over the launch map: up to 0.4 where there is no
pause, 0.6 in one of a quarter of the time on the finger, 1.15 in longer ones."""
_ON_AXIS = 1e-9
_REBOUND = 2.0  # speed of a bead that a faster finger throws ahead, over that of the finger
_SOFTEST = 0.1  # least modulus over that at rest by which the reach of a hand's pull is estimated


@dataclass(frozen=True)
class LaunchPlan:
    """Everything that a launch needs to know beyond the physics; times in s."""

    release: Plan
    """Plan of the release of the same beads, with the scene of the launch, its step and its samples."""
    string: StringLaunch
    contact_stiffness_n_m: float
    steps: int
    """Most steps until the rear arrives."""
    frame_steps: int
    rear_steps: int
    """Steps between lines of finger.dat and frames of the rear."""
    idle_steps: int
    """The finger is free when it has carried nothing for so many steps."""
    flight_steps: int
    self_contact: SelfContact | None
    """None where parts of the band may pass through each other."""

    def __repr__(self) -> str:
        return f"<Launch by {self.release!r}>"

    @property
    def reasons(self) -> tuple[Notice, ...]:
        return self.release.reasons

    @property
    def warnings(self) -> tuple[Notice, ...]:
        return self.release.warnings

    @property
    def scene(self) -> Scene:
        return self.release.scene

    @property
    def beads(self) -> int:
        return self.release.beads

    @property
    def timestep_s(self) -> float:
        return self.release.timestep_s

    @property
    def strand(self) -> Strand:
        return self.release.strand

    @property
    def expected_steps(self) -> int:
        """Steps until the string's rear arrives, and of the flight."""
        return round(max(self.string.rear_arrival_s, self.string.finger_free_s) / self.timestep_s) + self.flight_steps

    @property
    def seconds(self) -> float:
        """Predicted wall time on one core, without the second run that judges the error."""
        return error_curves.seconds("ring", self.beads, self.expected_steps, self.expected_steps // self.frame_steps)

    @property
    def disk_bytes(self) -> float:
        """Predicted size of the files."""
        rear, steps = self.rear_steps, self.expected_steps
        return error_curves.disk_bytes(self.beads, steps // self.frame_steps, 2 * steps // rear)

    @property
    def cap_s(self) -> float:
        return self.steps * self.timestep_s

    @property
    def gap_margin_m(self) -> float:
        """Distance of the rear at which the next look might come too late."""
        hand = self.scene.hand
        closing = self.release.string.rear_speed_m_s + (abs(hand.velocity_m_s) if hand else 0.0)
        return _APPROACH * closing * self.rear_steps * self.timestep_s

    @property
    def reach(self) -> float:
        """Strain for which the bond table is made: a hand that moves by itself pulls the band further than it was held.

        A speed v sends out a strain of v/c, doubled where it is reflected; a preload beyond the pull as much again as
        it strains the legs at rest.
        """
        scene, hand, law = self.scene, self.scene.hand, self.scene.material
        if hand is None:
            return scene.strain
        modulus = max(float(law.tangent(1.0 + scene.strain)), _SOFTEST * law.rest_modulus_pa)
        beyond = max(0.0, (hand.preload_n or 0.0) - 2.0 * self.string.tension_n * math.cos(scene.half_angle_rad))
        faster = 2.0 * abs(hand.velocity_m_s) * math.sqrt(scene.band.density_kg_m3 / modulus)
        return scene.strain + faster + beyond / (scene.band.area_m2 * modulus)

    @property
    def nose_beads(self) -> int:
        """Beads to either side of the tip that count as the rear which arrives.

        Half of what the string's kink has left behind when the rear arrives, x tan(phi)/stretch1 with
        x = L/cos(phi) - R: the waves in the legs that run before it may touch the finger and are no arrival.
        """
        wedge, phi = self.scene.wedge, self.scene.half_angle_rad
        way = wedge.leg_m / math.cos(phi) - wedge.finger_radius_m
        behind = way * math.tan(phi) / (1.0 + self.release.string.residual_strain)
        return max(1, round(_NOSE * behind / self.strand.spacing_m))

    def held(self) -> tuple[Ring, Support]:
        """The held ring at rest on its finger."""
        scene = self.scene
        ring = stretched_ring(self.strand, self.beads, scene.strain, scene.half_angle_rad)
        return settle_on(ring, self.strand, self.contact_stiffness_n_m)


def launch_plan_of(scene: Scene) -> LaunchPlan:
    """Choose what the scene leaves open; UsageError for a choice of the user's that can't work."""
    # Beads and loss as the release takes them; a step that was chosen for the launch does not suit the release.
    bare = replace(scene, until="release", finger="stays", flight_s=0.0)
    bare = replace(bare, timestep_s=None, frames=None, steps=None, rear_steps=None)
    smooth = not _collapses(scene)
    release = plan_of(bare, smooth=smooth)
    needed = SMOOTH_LOSS * scene.band.circumference_m / (scene.band.thickness_m * release.scene.tolerance)
    enough = [one for one in release.reasons if one.code.startswith("beads-for")]
    if scene.beads is None and not scene.string.wave.shocks and release.beads < math.sqrt(needed):
        release = plan_of(replace(bare, beads=round_up(math.sqrt(needed))), smooth=smooth)
        enough = [notice("beads-for-launch", beads=release.beads, limit=100.0 * release.scene.tolerance)]
    if scene.hand is not None and scene.beads is None and release.beads < BEADS_FOR_HAND:
        release = plan_of(replace(bare, beads=BEADS_FOR_HAND), smooth=smooth)
        enough = [notice("beads-for-hand", beads=BEADS_FOR_HAND)]
    strand, string = release.strand, string_launch(scene)
    reasons = [*enough, *(one for one in release.reasons if one not in enough and one.code not in ("step", "frames"))]
    warnings = list(release.warnings)

    compression = min(_meeting_stretch(scene), 1.0)
    warnings += outside_test(scene, compression)
    largest = strand.largest_step_s(release.loss_time_s, scene.strain, compression)
    target = scene.timestep_s or min(release.timestep_s, STEP_SHARE * largest)
    graze = min(_MOST_GRAZE, _GRAZE + max(0.0, string.pause_s / string.finger_free_s)) * scene.string.rear_speed_m_s
    stiffness, limit = _contact(scene, strand, release.beads, target, largest, graze, scene.timestep_s is None)
    timestep = scene.timestep_s or min(target, STEP_SHARE * limit)
    if timestep > limit:
        raise UsageError(
            explain(
                "the time step is beyond the limit of stability",
                f"{timestep:.4g} s",
                f"at most {limit:.4g} s for {release.beads} beads on a finger",
                "lower --timestep or --beads",
            )
        )
    reasons.append(notice("launch-step", step_s=timestep, value=timestep / limit, limit=compression))
    phase = math.sqrt(stiffness / strand.bead_mass_kg) * timestep
    reasons.append(notice("finger-stiffness", value=stiffness, phase=phase))
    duration = max(string.finger_free_s, string.rear_arrival_s)
    steps, frame_steps, rear_steps = _sampling(scene, timestep, duration, CAP * duration)
    flight = rear_steps * math.ceil(scene.flight_s / timestep / rear_steps)
    if steps + flight > MOST_STEPS:
        raise UsageError(
            explain("the run would be too long", f"{steps + flight} steps", f"at most {MOST_STEPS}", "raise --timestep")
        )
    frames, looks = duration / (frame_steps * timestep), duration / (rear_steps * timestep)
    reasons.append(notice("launch-frames", frames=frames, rear=looks, steps=steps))
    touching, reason = self_contact(scene, strand, string, stiffness, timestep, rear_steps)
    reasons += [reason] if reason else []
    if string.pause_s < 0.0:
        warnings.append(notice("hand-is-hit", value=-string.pause_s))
    planned = tuple(key for key in PLANNED if getattr(scene, key) is None or key in scene.planned)
    whole = replace(
        scene,
        beads=release.beads,
        timestep_s=timestep,
        loss_time_s=release.loss_time_s,
        frames=steps // frame_steps,
        steps=steps,
        rear_steps=rear_steps,
        planned=planned,
    )
    return LaunchPlan(
        release=replace(
            release,
            scene=whole,
            timestep_s=timestep,
            largest_timestep_s=limit,
            steps=steps,
            frame_steps=frame_steps,
            rear_steps=rear_steps,
            reasons=tuple(reasons),
            warnings=tuple(warnings),
        ),
        string=string,
        contact_stiffness_n_m=stiffness,
        steps=steps,
        frame_steps=frame_steps,
        rear_steps=rear_steps,
        idle_steps=rear_steps * max(2, math.ceil(_IDLE_SHARE * string.finger_free_s / (rear_steps * timestep))),
        flight_steps=flight,
        self_contact=touching,
    )


def _collapses(scene: Scene) -> bool:
    """Whether no bond at a stretch of :data:`_NEARLY_NOTHING` stops strands that run at each other: only loss helps.

    The linear law's stress stays finite down to no length: with little loss its launches collapsed at a strain of 1.0,
    and were sound at 0.8.
    """
    return _jump_pa(scene, _NEARLY_NOTHING) < scene.band.density_kg_m3 * scene.string.leg_speed_m_s**2


def _jump_pa(scene: Scene, stretch: float) -> float:
    """(stress1 - stress)(stretch1 - stretch), from the string's state behind the fronts."""
    behind = 1.0 + scene.string.residual_strain
    return (scene.string.residual_stress_pa - float(scene.material.stress(stretch))) * (behind - stretch)


def _meeting_stretch(scene: Scene) -> float:
    """Stretch to which two strands running at each other at u are compressed, if they stay straight.

    The jump condition density u^2 = (stress1 - stress)(stretch1 - stretch) with the string's state behind the fronts.
    Measured bonds come within some hundredths of it, and stay longer where they can buckle aside.
    """
    behind = 1.0 + scene.string.residual_strain
    for i in range(200):
        stretch = behind - (behind - _LEAST_COMPRESSION) * i / 199.0
        if _jump_pa(scene, stretch) > scene.band.density_kg_m3 * scene.string.leg_speed_m_s**2:
            return stretch
    return _LEAST_COMPRESSION


def _contact(
    scene: Scene, strand: Strand, beads: int, step_s: float, largest_s: float, graze_m_s: float, free: bool
) -> tuple[float, float]:
    """Stiffness of the finger for one bead, N/m, and the largest step with it.

    As stiff as the step bears at no cost, and never so soft that the held ring sinks in by more than its share, or
    that a graze goes deeper than the bound. On coarse chains of a thin band that takes a shorter step.
    """
    ring = stretched_ring(strand, beads, scene.strain, scene.half_angle_rad)
    loads = finger_loads_n(ring, strand)
    needed = float(loads.max()) / (HELD_DEPTH * scene.band.thickness_m)
    mass, held = strand.bead_mass_kg, 1.0 + scene.strain
    # A wave in a leg throws beads against the finger: one at the speed v goes in by v sqrt(mass/stiffness).
    # Against a hand as light as the band they come at up to the speed of the rear, and it may come at them.
    if scene.hand is not None:
        share = strand.bead_mass_kg * beads * scene.hand.inverse_mass_1_kg
        graze_m_s += max(0.0, scene.string.rear_speed_m_s - graze_m_s) * share / (1.0 + share)
        graze_m_s += _REBOUND * abs(scene.hand.velocity_m_s)
    needed = max(needed, mass * (graze_m_s / (DEPTH_BOUND * scene.band.thickness_m)) ** 2)
    # A bead on the finger moves across the strand, which resists by its bending and by its tension.
    bending = (4.0 * strand.bending_diffusivity_m2_s / (strand.spacing_m**2 * min(1.0, held))) ** 2
    pull = 4.0 * strand.law.stress(held) / (held * strand.density_kg_m3 * strand.spacing_m**2)
    across = bending + pull
    swinging = 0.0
    if scene.hand is not None:
        # Beads in contact against the hand: k (1/m + sum of cos^2/M), where one bead alone has k/m; and its spring.
        lighter, pull = scene.hand.inverse_mass_1_kg, _pull_n(ring, loads)
        needed *= max(1.0, abs(scene.hand.preload_n or 0.0) / pull[0])
        swinging = scene.hand.stiffness_n_m * lighter
        mass /= 1.0 + mass * lighter * pull[1]
    bearable = (2.0 * (STEP_SHARE if free else 0.95) / step_s) ** 2
    stiffness = max(needed, mass * min(CONTACT_SHARE * bearable, bearable - across - swinging))
    return stiffness, min(largest_s, 2.0 / math.sqrt(across + stiffness / mass + swinging))


def _pull_n(ring: Ring, loads_n: Array) -> tuple[float, float]:
    """Force of the held ring on its finger along the axis, N, and the sum of cos^2 of its loaded beads' directions.

    ``loads_n`` (beads//2 + 1,) are those of the upper half; the bead on the axis belongs to both.
    """
    x, y = ring.positions_m[: len(loads_n)].T
    cosines = (x - ring.finger_centre_m) / np.hypot(x - ring.finger_centre_m, y)
    sides = np.where(np.abs(y) < _ON_AXIS * ring.finger_radius_m, 1.0, 2.0)
    return float(np.sum(sides * loads_n * cosines)), float(np.sum(sides * np.where(loads_n > 0.0, cosines**2, 0.0)))


def _sampling(scene: Scene, step_s: float, duration_s: float, cap_s: float) -> tuple[int, int, int]:
    """Steps in all, from frame to frame, and from look to look at the rear; UsageError when they don't divide."""
    if scene.steps is not None:
        frames, rear_steps, steps = given(scene, scene.steps)
        return steps, steps // frames, rear_steps
    interval = interval_s(scene, scene.scales.front_arrival_s)
    rear_steps = scene.rear_steps or min(max(_FEWEST_REAR_STEPS, int(interval / step_s)), _MOST_REAR_STEPS)
    frames = scene.frames or FRAMES
    frame_steps = rear_steps * max(1, round(duration_s / (frames * rear_steps * step_s)))
    return frame_steps * math.ceil(cap_s / (frame_steps * step_s)), frame_steps, rear_steps
