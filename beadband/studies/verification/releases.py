"""Whole releases for the rungs that need one: plan, hold, release, read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from beadband.analysis.energy import Balance, balance
from beadband.analysis.readers import Trajectory, read, read_energies
from beadband.lammps import files
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_ring
from beadband.planning.plan import Plan
from beadband.runs.measurement import Measurement, measure
from beadband.runs.rear_run import hold, reading_own_files
from beadband.statics.ring import Ring


@dataclass(frozen=True)
class Released:
    """What a release wrote."""

    plan: Plan
    frames: Trajectory
    """The whole ring."""
    rear: Trajectory
    measurement: Measurement
    balance: Balance


def release(plan: Plan, turned: Callable[[Ring], Ring] | None = None) -> Released:
    """Release a plan, of a held ring that may be ``turned`` first; RunError where LAMMPS or the measuring fails."""
    with files.scratch() as folder:
        ring = hold(plan)
        write_ring(folder, plan, turned(ring) if turned else ring)
        run_script(folder, files.SCRIPT)
        with reading_own_files():
            rear = read(folder / files.REAR)
            return Released(
                plan=plan,
                frames=read(folder / files.TRAJECTORY),
                rear=rear,
                measurement=measure(plan, rear),
                balance=balance(read_energies(folder / files.ENERGY), plan.timestep_s),
            )
