"""The plan of a launch: the release's, and what the finger, the meeting of the fronts and the flight add to it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

from beadband.errors import UsageError, explain
from beadband.launching.contact import Support, finger_loads_n, settle_on
from beadband.launching.string import StringLaunch, string_launch
from beadband.plan import STEP_SHARE, Plan, plan_of
from beadband.ring import Ring, stretched_ring
from beadband.sampling import MOST_STEPS, given, interval_s
from beadband.scene import PLANNED, Scene
from beadband.strand import Strand

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
_LEAST_COMPRESSION = 0.35  # measured: the deepest of the linear law at a strain of 1.4, whose beads buckle aside
CAP = 3.0
"""Longest run, in units of what the string takes to be free and for its rear to arrive."""
FRAMES = 100
_FEWEST_REAR_STEPS = 4
_MOST_REAR_STEPS = 16  # the contact bounces in no less: its depth must not be missed
_IDLE_SHARE = 0.03
_APPROACH = 1.5
_NOSE = 0.5
_GRAZE = 0.4  # speed of a graze over that of the rear; measured depths then stay below the bound


@dataclass(frozen=True)
class LaunchPlan:
    """Everything that a launch needs to know beyond the physics; times in s."""

    twin: Plan
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
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        return self.twin.scene

    @property
    def beads(self) -> int:
        return self.twin.beads

    @property
    def timestep_s(self) -> float:
        return self.twin.timestep_s

    @cached_property
    def strand(self) -> Strand:
        return self.scene.strand(self.beads)

    @property
    def cap_s(self) -> float:
        return self.steps * self.timestep_s

    @property
    def gap_margin_m(self) -> float:
        """Distance of the rear at which the next look might come too late."""
        return _APPROACH * self.twin.string.rear_speed_m_s * self.rear_steps * self.timestep_s

    @property
    def nose_beads(self) -> int:
        """Beads to either side of the tip that count as the rear which arrives.

        Half of what the string's kink has left behind when the rear arrives, x tan(phi)/stretch1 with
        x = L/cos(phi) - R: the waves in the legs that run before it may touch the finger and are no arrival.
        """
        wedge, phi = self.scene.wedge, self.scene.half_angle_rad
        way = wedge.leg_m / math.cos(phi) - wedge.finger_radius_m
        behind = way * math.tan(phi) / (1.0 + self.twin.string.residual_strain)
        return max(1, round(_NOSE * behind / self.strand.spacing_m))

    def held(self) -> tuple[Ring, Support]:
        """The held ring at rest on its finger."""
        scene = self.scene
        ring = stretched_ring(self.strand, self.beads, scene.strain, scene.half_angle_rad)
        return settle_on(ring, self.strand, self.contact_stiffness_n_m)


def launch_plan_of(scene: Scene) -> LaunchPlan:
    """Choose what the scene leaves open; UsageError for a choice of the user's that can't work."""
    # Beads and loss as the release takes them; a step that the launch chose is no business of the release's plan.
    twin = plan_of(
        replace(
            scene,
            until="release",
            finger="stays",
            flight_s=0.0,
            timestep_s=None,
            frames=None,
            steps=None,
            rear_steps=None,
        )
    )
    strand, string = scene.strand(twin.beads), string_launch(scene)
    reasons = [text for text in twin.reasons if not text.startswith("step ") and " frames of " not in text]
    warnings = list(twin.warnings)

    compression = min(_meeting_stretch(scene), 1.0)
    largest = strand.largest_step_s(twin.loss_time_s, scene.strain, compression)
    target = scene.timestep_s or min(twin.timestep_s, STEP_SHARE * largest)
    stiffness, limit = _contact(scene, strand, twin.beads, target, largest, scene.timestep_s is None)
    timestep = scene.timestep_s or min(target, STEP_SHARE * limit)
    if timestep > limit:
        raise UsageError(
            explain(
                "the time step is beyond the limit of stability",
                f"{timestep:.4g} s",
                f"at most {limit:.4g} s for {twin.beads} beads on a finger",
                "lower --timestep or --beads",
            )
        )
    reasons.append(
        f"step {timestep:.3g} s: {timestep / limit:.2f} of the largest stable one for bonds as short as "
        f"{compression:.2f} of their length, where the two fronts meet, and beads on the finger"
    )
    reasons.append(
        f"finger: {stiffness:.3g} N/m a bead, {math.sqrt(stiffness / strand.bead_mass_kg) * timestep:.2f} of a radian "
        "in a step"
    )
    duration = max(string.finger_free_s, string.rear_arrival_s)
    steps, frame_steps, rear_steps = _sampling(scene, twin, timestep, duration, CAP * duration)
    flight = rear_steps * math.ceil(scene.flight_s / timestep / rear_steps)
    if steps + flight > MOST_STEPS:
        raise UsageError(
            explain("the run would be too long", f"{steps + flight} steps", f"at most {MOST_STEPS}", "raise --timestep")
        )
    reasons.append(
        f"{duration / (frame_steps * timestep):.0f} frames of the ring, and {duration / (rear_steps * timestep):.0f} "
        f"of its rear and of the finger, until the string's rear arrives; at most {steps} steps"
    )
    if string.pause_s < 0.0:
        warnings.append(
            f"without bending the rear would arrive {-string.pause_s:.3g} s before the finger is free: the hand is hit"
        )
    planned = tuple(key for key in PLANNED if getattr(scene, key) is None or key in scene.planned)
    whole = replace(
        scene,
        beads=twin.beads,
        timestep_s=timestep,
        loss_time_s=twin.loss_time_s,
        frames=steps // frame_steps,
        steps=steps,
        rear_steps=rear_steps,
        planned=planned,
    )
    return LaunchPlan(
        twin=replace(
            twin,
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
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )


def _meeting_stretch(scene: Scene) -> float:
    """Stretch to which two strands running at each other at u are compressed, if they stay straight.

    The jump condition density u^2 = (stress1 - stress)(stretch1 - stretch) with the string's state behind the fronts.
    Measured bonds come within some hundredths of it, and stay longer where they can buckle aside.
    """
    string, law, density = scene.string, scene.material, scene.band.density_kg_m3
    behind = 1.0 + string.residual_strain
    for i in range(200):
        stretch = behind - (behind - _LEAST_COMPRESSION) * i / 199.0
        jump = (string.residual_stress_pa - float(law.stress(stretch))) * (behind - stretch)
        if jump > density * string.leg_speed_m_s**2:
            return stretch
    return _LEAST_COMPRESSION


def _contact(
    scene: Scene, strand: Strand, beads: int, step_s: float, largest_s: float, free: bool
) -> tuple[float, float]:
    """Stiffness of the finger for one bead, N/m, and the largest step with it.

    As stiff as the step bears at no cost, and never so soft that the held ring sinks in by more than its share, or
    that a graze goes deeper than the bound. On coarse chains of a thin band that takes a shorter step.
    """
    ring = stretched_ring(strand, beads, scene.strain, scene.half_angle_rad)
    needed = float(finger_loads_n(ring, strand).max()) / (HELD_DEPTH * scene.band.thickness_m)
    mass, held = strand.bead_mass_kg, 1.0 + scene.strain
    # A wave in a leg throws beads against the finger: one at the speed v goes in by v sqrt(mass/stiffness).
    graze = _GRAZE * scene.string.rear_speed_m_s
    needed = max(needed, mass * (graze / (DEPTH_BOUND * scene.band.thickness_m)) ** 2)
    # A bead on the finger moves across the strand, which resists by its bending and by its tension.
    bending = (4.0 * strand.bending_diffusivity_m2_s / (strand.spacing_m**2 * min(1.0, held))) ** 2
    pull = 4.0 * strand.law.stress(held) / (held * strand.density_kg_m3 * strand.spacing_m**2)
    across = bending + pull
    bearable = (2.0 * (STEP_SHARE if free else 0.95) / step_s) ** 2
    stiffness = max(needed, mass * min(CONTACT_SHARE * bearable, bearable - across))
    return stiffness, min(largest_s, 2.0 / math.sqrt(across + stiffness / mass))


def _sampling(scene: Scene, twin: Plan, step_s: float, duration_s: float, cap_s: float) -> tuple[int, int, int]:
    """Steps in all, from frame to frame, and from look to look at the rear; UsageError when they don't divide."""
    if scene.steps is not None:
        frames, rear_steps, steps = given(scene, scene.steps)
        return steps, steps // frames, rear_steps
    interval = interval_s(scene, twin.string, twin.front_arrival_s)
    rear_steps = scene.rear_steps or min(max(_FEWEST_REAR_STEPS, int(interval / step_s)), _MOST_REAR_STEPS)
    frames = scene.frames or FRAMES
    frame_steps = rear_steps * max(1, round(duration_s / (frames * rear_steps * step_s)))
    return frame_steps * math.ceil(cap_s / (frame_steps * step_s)), frame_steps, rear_steps
