"""What a second core is worth: one leg of 100 to a million beads on one rank, on two, and on two threads."""

from __future__ import annotations

import math
import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from beadband.errors import BeadbandError, RunError
from beadband.lammps.engine import program
from beadband.lammps.scripts import assignments
from beadband.model.scene import Scene
from beadband.runs import folder as files
from beadband.statics.leg import held_leg, smooth_leg
from beadband.studies.pareto.methods import Extent, Method, leg_plan
from beadband.studies.pareto.outcomes import DONE, NO_PROGRAM, TOO_SLOW, Outcome, outcome_of
from beadband.studies.pareto.runs import leg_script, leg_variables, read_clock, with_clock, write_leg

WAYS = ("one core", "two ranks", "two threads")
_BEAD_STEPS = 2e5
_FEWEST_STEPS, _MOST_STEPS = 5, 300
_RUNS_OF_LARGE = 5
_ROUNDS_OF_LARGE = 2
_LARGE = 200_000
_FINEST_SOLVED = 3000
_LONGEST_S = 120.0


@dataclass(frozen=True)
class Timing:
    """Seconds of each repeat of a run of so many steps."""

    way: str
    beads: int
    steps: int
    seconds: tuple[float, ...]
    outcome: Outcome = DONE
    """Why there are none, or fewer than intended."""

    @property
    def least_ns(self) -> float:
        """Nanoseconds a bead and step, of the quickest repeat."""
        return 1e9 * min(self.seconds) / (self.beads * self.steps) if self.seconds else math.nan

    @property
    def median_ns(self) -> float:
        return 1e9 * median(self.seconds) / (self.beads * self.steps) if self.seconds else math.nan


def timings(scene: Scene, extent: Extent) -> list[Timing]:
    """Time every size in every way; the outcome of a way that can't be run here says why."""
    found = []
    for beads in extent.cores:
        rounds, runs = extent.core_rounds, extent.core_runs
        if beads > _LARGE:
            rounds, runs = min(rounds, _ROUNDS_OF_LARGE), min(runs, _RUNS_OF_LARGE)
        steps = int(min(max(_BEAD_STEPS / beads, _FEWEST_STEPS), _MOST_STEPS))
        with files.scratch() as folder:
            texts = _prepare(folder, scene, beads, steps, runs)
            seconds: dict[str, list[float]] = {way: [] for way in WAYS}
            outcomes = dict.fromkeys(WAYS, DONE)
            for _ in range(rounds):
                for way in WAYS:
                    try:
                        seconds[way] += _run(folder, way, texts)
                    except BeadbandError as error:
                        outcomes[way] = outcome_of(error)
        found += [Timing(way, beads, steps, tuple(seconds[way]), outcomes[way]) for way in WAYS]
    return found


def _prepare(folder: Path, scene: Scene, beads: int, steps: int, runs: int) -> dict[bool, str]:
    """Write data and tables of a leg of so many beads; its script, on one rank and spread over two."""
    trial = leg_plan(scene, 1000)
    plan = leg_plan(scene, math.ceil(1000 * beads / trial.leg_bonds))
    plan = replace(plan, leg_bonds=beads - 2, steps=steps)
    strand, hold = plan.scene.strand(plan.beads), held_leg if beads <= _FINEST_SOLVED else smooth_leg
    leg = hold(strand, plan.leg_bonds, scene.strain, scene.half_angle_rad)
    method = Method("cores", "leg", plan)
    write_leg(folder, method, leg)
    variables = leg_variables(method, leg)
    # Bins of the size of the cutoff would fill the box with more of them than can be counted.
    extent = 4.0 * float(leg.positions_m[-1, 0])
    variables["bin"] = max(0.5 * float(variables["dashpot_cutoff"]), extent / 3000.0)
    texts = {}
    for spread in (False, True):
        chosen = Method("cores", "leg", plan, choices={"spread": "yes"} if spread else {})
        again = "run ${steps} pre no post no\n" * (runs - 1)
        text = with_clock(leg_script(chosen)) + again
        heads = assignments(variables)
        # A script of its own process has nothing to delete.
        texts[spread] = heads + "".join(line for line in text.splitlines(True) if not line.endswith(" delete\n"))
    return texts


def _run(folder: Path, way: str, texts: dict[bool, str]) -> list[float]:
    """Seconds of each run of one process (or one pair of ranks); RunError when it fails."""
    lmp, mpirun = program("lmp"), program("mpirun")
    if lmp is None:
        raise RunError("no program lmp was found", NO_PROGRAM)
    if way == "two ranks" and mpirun is None:
        raise RunError("no program mpirun was found", NO_PROGRAM)
    inputs_name = "cores.in"
    (folder / inputs_name).write_text(texts[way == "two ranks"], encoding="utf-8")
    command = [lmp, "-in", inputs_name, "-screen", "none", "-log", "none", "-nocite"]
    if way == "two ranks":
        command = [str(mpirun), "-np", "2", *command]
    if way == "two threads":
        command += ["-sf", "omp", "-pk", "omp", "2"]
    threads = "2" if way == "two threads" else "1"
    (folder / "clock.dat").unlink(missing_ok=True)
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env={**os.environ, "OMP_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            timeout=_LONGEST_S,
        )
    except subprocess.TimeoutExpired as error:
        raise RunError(f"{way} took longer than {_LONGEST_S:.0f} s", TOO_SLOW) from error
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise RunError(f"{way} failed: {said[-1] if said else done.returncode}")
    return read_clock(folder)


def speedups(found: Sequence[Timing], way: str) -> dict[int, float]:
    """Speed of another way over that of one core, by beads, where both were timed."""
    alone = {t.beads: t.least_ns for t in found if t.way == WAYS[0] and t.seconds}
    return {t.beads: alone[t.beads] / t.least_ns for t in found if t.way == way and t.seconds and t.beads in alone}


def pays_from(found: Sequence[Timing], way: str) -> float | None:
    """Beads from which on another way is quicker than one core at every larger size; None when it never is.

    Interpolated on logarithms between the last size at which it does not pay and the next.
    """
    gains = speedups(found, way)
    sizes = sorted(gains)
    paying = len(sizes)
    while paying and gains[sizes[paying - 1]] > 1.0:
        paying -= 1
    if paying == len(sizes):
        return None
    if paying == 0:
        return float(sizes[0])
    low, high = sizes[paying - 1], sizes[paying]
    share = math.log(gains[low]) / (math.log(gains[low]) - math.log(gains[high]))
    return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
