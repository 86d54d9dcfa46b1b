"""Rung ``conservation``: what must stay as it is, and what must not matter."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from beadband.analysis.readers import ReadError, read
from beadband.errors import RunError
from beadband.lammps import files
from beadband.lammps.engine import program, run_script
from beadband.lammps.scripts import write_ring
from beadband.model.bands import laws_of
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import hold
from beadband.statics.ring import LOWER, UPPER, Ring
from beadband.studies.verification import specimen as specimens
from beadband.studies.verification.check import Check
from beadband.studies.verification.releases import release
from beadband.studies.verification.specimen import END, FREE, Array, chain, strand_of

_TIMEOUT_S = 120.0


def conservation() -> list[Check]:
    """Energy, momentum and angular momentum; rotated, mirrored and parallel releases.

    * A free strand, stretched, bent and thrown: without loss its energy stays, and its momenta stay with and without.
    * A release with loss: what the dashpots take closes the balance.
    * A ring held at another angle, or upside down, moves as the first, and two MPI ranks move it as one does.
    """
    plan = plan_of(scene_of({"beads": 200}))
    return [*_free_strand(), *_release(plan), _two_ranks(plan)]


def _free_strand(count: int = 41, strain: float = 0.2) -> list[Check]:
    checks = []
    for law in laws_of("III"):
        for loss_time in (0.0, 1e-5):
            strand = strand_of("III", law, 1e-3)
            direction = 0.6 * np.sin(np.linspace(0.0, 2.5 * math.pi, count - 1))
            bonds = strand.spacing_m * (1.0 + strain) * np.stack([np.cos(direction), np.sin(direction)], axis=1)
            points = np.concatenate([np.zeros((1, 2)), np.cumsum(bonds, axis=0)])
            types = np.full(count, FREE)
            types[[0, -1]] = END
            thrown = np.array([1.0, -2.0]) + 50.0 * points[:, ::-1] * np.array([-1.0, 1.0])
            strip = replace(chain(strand, points, types, strain=0.5), velocities_m_s=thrown)
            step = 0.1 * strand.largest_step_s(loss_time, strain, 0.7)
            record = specimens.run(strip, step, 8000, 200, loss_time)
            energy = record.stretching_j + record.bending_j + record.kinetic_j
            name = f"{law}, {'with' if loss_time else 'no'} loss: "
            scale = float(np.hypot(*record.momentum_kg_m_s[0]))
            drift = float(np.abs(record.momentum_kg_m_s - record.momentum_kg_m_s[0]).max()) / scale
            spin = record.angular_momentum_kg_m2_s
            if not loss_time:
                worst = float(energy[np.argmax(np.abs(energy - energy[0]))])
                checks.append(Check("conservation", name + "energy, worst (J)", worst, float(energy[0]), 5e-4))
            checks += [
                Check("conservation", name + "change of momentum (of itself)", drift, 0.0, 1e-11),
                Check(
                    "conservation",
                    name + "angular momentum, worst (kg m2/s)",
                    float(spin[np.argmax(np.abs(spin - spin[0]))]),
                    float(spin[0]),
                    1e-11,
                ),
            ]
    return checks


def _release(plan: Plan) -> list[Check]:
    angle = math.radians(37.0)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    mirror = np.diag([1.0, -1.0])

    def moved(by: Array) -> Callable[[Ring], Ring]:
        def change(ring: Ring) -> Ring:
            types = ring.types.copy()
            if np.linalg.det(by) < 0.0:  # the leg that was upper is now the lower one
                types[ring.types == UPPER], types[ring.types == LOWER] = LOWER, UPPER
            return replace(ring, positions_m=ring.positions_m @ by, types=types)

        return change

    first = release(plan)
    leg = plan.scene.wedge.leg_m
    checks = [Check("conservation", "release: unbalanced energy (of the stored)", first.balance.error, 0.0, 4e-3)]
    for name, by in (("rotated by 37 degrees", turn), ("upside down", mirror)):
        again = release(plan, moved(by))
        apart = np.abs(again.rear.positions_m @ by.T - first.rear.positions_m).max() / leg
        checks.append(Check("conservation", f"release {name}: apart by (of a leg)", float(apart), 0.0, 1e-12))
    return checks


def _two_ranks(plan: Plan) -> Check:
    """The same files by LAMMPS' own program on two ranks, if the programs are there."""
    name = "release on 2 MPI ranks: apart by (of a leg)"
    lmp, mpirun = program("lmp"), program("mpirun")
    if lmp is None or mpirun is None:
        missing = "lmp" if lmp is None else "mpirun"
        return Check("conservation", name, math.nan, 0.0, 1e-12, f"{missing} not found", skipped=True)
    with files.scratch() as one, files.scratch() as two:
        for folder in (one, two):
            write_ring(folder, plan, hold(plan), pictures=False)
        run_script(one, files.SCRIPT)
        command = [mpirun, "-np", "2", lmp, "-in", files.SCRIPT, "-screen", "none"]
        try:
            subprocess.run(command, cwd=two, check=True, timeout=_TIMEOUT_S, capture_output=True)
            if "2 by 1 by 1 MPI processor grid" not in (two / files.LOG).read_text(encoding="utf-8"):
                raise RunError("two MPI ranks failed: mpirun did not start two ranks of one run", "two-ranks")
            pair = [read(folder / files.REAR).positions_m for folder in (one, two)]
        except (OSError, subprocess.SubprocessError, ReadError) as error:
            raise RunError(f"two MPI ranks failed: {str(error).splitlines()[0]}", "two-ranks") from error
    apart = float(np.abs(pair[1] - pair[0]).max()) / plan.scene.wedge.leg_m
    return Check("conservation", name, apart, 0.0, 1e-12)
