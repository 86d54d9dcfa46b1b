"""Whole releases for the rungs that need one: plan, hold, let go, read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from beadband import folder as files
from beadband import release
from beadband.analysis.measurement import Balance, Measurement, balance, measure
from beadband.analysis.trajectory import Trajectory, read, read_energies
from beadband.engine import run_script
from beadband.follow import hold, reading_own_files
from beadband.inputs import write_ring
from beadband.plan import Plan
from beadband.ring import Ring


@dataclass(frozen=True)
class Released:
    """What a release wrote."""

    plan: Plan
    frames: Trajectory
    """The whole ring."""
    rear: Trajectory
    measurement: Measurement
    balance: Balance


def let_go(plan: Plan, turned: Callable[[Ring], Ring] | None = None) -> Released:
    """Release a plan, of a held ring that may be ``turned`` first; RunError where LAMMPS or the measuring fails."""
    with files.scratch() as folder:
        ring = hold(plan)
        write_ring(folder, plan, turned(ring) if turned else ring)
        run_script(folder, files.SCRIPT)
        with reading_own_files():
            rear = read(folder / files.REAR)
            return Released(
                plan=plan,
                frames=release.frames(folder),
                rear=rear,
                measurement=measure(plan, rear),
                balance=balance(plan, read_energies(folder / files.ENERGY)),
            )
