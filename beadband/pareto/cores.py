"""What a second core is worth: one leg of 100 to a million beads on one rank, on two, and on two threads."""

from __future__ import annotations

import math
import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median

from beadband import folder as files
from beadband.engine import program
from beadband.errors import BeadbandError, RunError
from beadband.leg import held_leg, smooth_leg
from beadband.pareto.methods import Method, leg_plan
from beadband.pareto.runs import leg_script, leg_variables, read_clock, with_clock, write_leg
from beadband.scene import Scene

SIZES = (100, 316, 1_000, 3_162, 10_000, 31_623, 100_000, 1_000_000)
QUICK_SIZES = (100, 1_000, 10_000)
WAYS = ("one core", "two ranks", "two threads")
_BEAD_STEPS = 2e5
_FEWEST_STEPS, _MOST_STEPS = 5, 300
_RUNS, _RUNS_OF_LARGE = 12, 5
"""In each process, short ones, for the quickest counts; the processes of the three ways take turns."""
_LARGE = 200_000
_FINEST_SOLVED = 3000
_LONGEST_S = 120.0


@dataclass(frozen=True)
class Timing:
    """Seconds of a run of so many steps, of each repeat."""

    way: str
    beads: int
    steps: int
    seconds: tuple[float, ...]
    reason: str = ""
    """Why there are none."""

    @property
    def least_ns(self) -> float:
        """Nanoseconds a bead and step, of the quickest repeat."""
        return 1e9 * min(self.seconds) / (self.beads * self.steps) if self.seconds else math.nan

    @property
    def median_ns(self) -> float:
        return 1e9 * median(self.seconds) / (self.beads * self.steps) if self.seconds else math.nan


def timings(scene: Scene, quick: bool, progress: Callable[[], None] | None = None) -> list[Timing]:
    """Time every size in every way; what can't be run here carries the reason."""
    found = []
    for beads in QUICK_SIZES if quick else SIZES:
        rounds = 1 if quick else 2 if beads > _LARGE else 3
        steps = int(min(max(_BEAD_STEPS / beads, _FEWEST_STEPS), _MOST_STEPS))
        with files.scratch() as folder:
            texts = _prepare(folder, scene, beads, steps)
            seconds: dict[str, list[float]] = {way: [] for way in WAYS}
            reasons = dict.fromkeys(WAYS, "")
            for _ in range(rounds):
                for way in WAYS:
                    try:
                        seconds[way] += _run(folder, way, texts)
                    except BeadbandError as error:
                        reasons[way] = str(error)
        found += [Timing(way, beads, steps, tuple(seconds[way]), reasons[way]) for way in WAYS]
        if progress:
            progress()
    return found


def _prepare(folder: Path, scene: Scene, beads: int, steps: int) -> dict[bool, str]:
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
        again = "run ${steps} pre no post no\n" * ((_RUNS_OF_LARGE if beads > _LARGE else _RUNS) - 1)
        text = with_clock(leg_script(chosen)) + again
        heads = "".join(f"variable {name} index {format(value, '.17g')}\n" for name, value in variables.items())
        # A script of its own process has nothing to delete.
        texts[spread] = heads + "".join(line for line in text.splitlines(True) if not line.endswith(" delete\n"))
    return texts


def _run(folder: Path, way: str, texts: dict[bool, str]) -> list[float]:
    """Seconds of each run of one process (or one pair of ranks); RunError when it fails."""
    lmp, mpirun = program("lmp"), program("mpirun")
    if lmp is None:
        raise RunError("no program lmp was found")
    if way == "two ranks" and mpirun is None:
        raise RunError("no program mpirun was found")
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
        raise RunError(f"{way} took longer than {_LONGEST_S:.0f} s") from error
    if done.returncode:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise RunError(f"{way} failed: {said[-1] if said else done.returncode}")
    return read_clock(folder)


def pays_from(found: list[Timing], way: str) -> float | None:
    """Beads from which on another way is quicker than one core at every larger size; None when it never is.

    Interpolated on logarithms between the last size at which it does not pay and the next.
    """
    ratio = {}
    for timing in found:
        if timing.way == way and timing.seconds:
            alone = next((t for t in found if t.way == WAYS[0] and t.beads == timing.beads and t.seconds), None)
            if alone is not None:
                ratio[timing.beads] = timing.least_ns / alone.least_ns
    sizes = sorted(ratio)
    paying = len(sizes)
    while paying and ratio[sizes[paying - 1]] < 1.0:
        paying -= 1
    if paying == len(sizes):
        return None
    if paying == 0:
        return float(sizes[0])
    low, high = sizes[paying - 1], sizes[paying]
    share = math.log(ratio[low]) / (math.log(ratio[low]) - math.log(ratio[high]))
    return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
