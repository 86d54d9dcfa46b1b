"""OpenMM: custom forces for the law, one leg on its mirror axis, the Reference platform (double precision)."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from beadband.analysis.rear import rear_of
from beadband.model.angle_forms import ANGLE_FORMS
from beadband.model.scene import Scene
from beadband.planning.plan import LOSS_BEADS
from beadband.statics.leg import held_leg
from beadband.studies.pareto.peers.protocol import Trace, leg_strand, steps_of

STEP_SHARE = 0.65
"""Share of the largest stable step."""


_CLAMPED = 1e9
"""Mass of the end, in beads."""
_REACH = 2.0
"""Cutoff of the friction over the spacing: that of relaxed second neighbours."""


class OpenMM:
    """Beads in units of their spacing and mass."""

    name = "OpenMM"
    package: str | None = "openmm"
    laws: tuple[str, ...] | None = None
    ladder = (25, 50, 100, 200, 400)
    quick = (25, 50, 100)
    note = (
        "one leg to the finger, the law as a CustomBondForce, cosine angles, Reference platform; Verlet, for a shock "
        "DPD at no temperature"
    )

    def run(self, scene: Scene, elements: int) -> Trace:
        """Release one leg: the terms at the tip hold no y of its own, so it stays on the axis."""
        import openmm

        strand = leg_strand(scene, elements)
        leg = held_leg(strand, elements, scene.strain, scene.half_angle_rad, ANGLE_FORMS["cosine"])
        samples, between, step = steps_of(scene, STEP_SHARE * strand.largest_step_s(0.0, scene.strain, 0.9))
        start = time.perf_counter()
        # Units of length a, mass m and time a sqrt(density/E0), so that energies are over A a E0.
        a, modulus = strand.spacing_m, strand.law.rest_modulus_pa
        unit_s = a * (strand.density_kg_m3 / modulus) ** 0.5
        bending = strand.angle_coefficient_j / (strand.area_m2 * a * modulus)
        law = f"({strand.law.lammps_expression()})/{modulus:.17g}"
        system = openmm.System()
        for i in range(elements + 1):
            # Half of the tip belongs to the mirror image; DPD can't bear a particle without mass as a clamped end.
            system.addParticle(0.5 if i == 0 else _CLAMPED if i == elements else 1.0)
        bonds = openmm.CustomBondForce(f"{law}; s=r")
        angles = openmm.CustomAngleForce(f"{bending:.17g}*(1+cos(theta))")
        for i in range(1, elements):
            bonds.addBond(i, i + 1)
        for i in range(2, elements):
            angles.addAngle(i - 1, i, i + 1)
        # On the axis 1 - cos psi = 2 (dx/s)^2, and half of it belongs to this leg.
        first = openmm.CustomCompoundBondForce(2, f"{law}+{bending:.17g}*((x2-x1)/s)^2; s=sqrt((x2-x1)^2+y2^2)")
        first.addBond([0, 1])
        second = openmm.CustomCompoundBondForce(
            3,
            f"{bending:.17g}*(1-(ax*bx+ay*by)/sqrt((ax^2+ay^2)*(bx^2+by^2)));ax=x2-x1;ay=y2;bx=x3-x2;by=y3-y2",
        )
        second.addBond([0, 1, 2])
        for force in (bonds, angles, first, second):
            system.addForce(force)
        integrator = _integrator(openmm, scene, elements, step / unit_s)
        context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
        context.setPositions(np.column_stack([leg.positions_m / a, np.zeros(elements + 1)]))
        # A leapfrog holds the velocities of half a step before.
        force_0 = context.getState(getForces=True).getForces(asNumpy=True)._value[0]
        velocities = np.zeros((elements + 1, 3))
        velocities[0] = -0.5 * (step / unit_s) * force_0 / 0.5
        context.setVelocities(velocities)
        ready = time.perf_counter()
        places = np.zeros((samples + 1, 2, 2))
        places[0] = leg.positions_m[:2]
        for k in range(1, samples + 1):
            integrator.step(between)
            now = context.getState(getPositions=True).getPositions(asNumpy=True)._value
            places[k] = now[:2, :2] * a
        done = time.perf_counter()
        mirrored = places[:, 1] * np.array([1.0, -1.0])
        times = step * np.arange(0.0, between * (samples + 0.5), between)
        rear = rear_of(times, mirrored, places[:, 0], places[:, 1], a)
        return Trace(rear.times_s, rear.tip_x_m, rear.tip_curvature_1_m, done - ready, done - start)


def _integrator(openmm: Any, scene: Scene, elements: int, step: float) -> Any:
    """Verlet's; where a shock needs a loss, the friction of DPD without its noise, as strong as beadband's dashpots.

    It acts with (1 - r/cutoff)^2, taken at a stretch half way down; not at the tip, whose mirror image is left out.
    """
    if not scene.string.wave.shocks:
        return openmm.VerletIntegrator(step)
    front = scene.string.front_speed_m_s / scene.band.density_kg_m3**-0.5 / scene.material.rest_modulus_pa**0.5
    friction = LOSS_BEADS * front / (1.0 - (1.0 + 0.5 * scene.strain) / _REACH) ** 2
    integrator = openmm.DPDIntegrator(0.0, friction, _REACH, step)
    integrator.setParticleType(0, 1)
    integrator.addTypePair(0, 1, 0.0, _REACH)
    return integrator
