"""True errors of rows of a finished sweep, drawn at random, against converged runs.

python tests/validation/sweep_rows.py DIR [--rows 50] [--seed 50]
"""

from __future__ import annotations

import argparse
import csv
import json
import random
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear

MOST_BEAD_STEPS = 1.5e7


def judge(row: dict[str, str]) -> tuple[float, float, float]:
    """Relative error, its bar and the tolerance of a row; the truth comes from two fine runs, to first order."""
    values = json.loads(row["key"])
    beads = int(row["beads"] or plan_of(scene_of(values), "leg").beads)  # a row by formula has none
    fine = []
    with Session() as session:
        for factor in (2, 3, 4, 6, 8):
            plan = plan_of(scene_of({**values, "beads": factor * beads}), "leg")
            if plan.bead_steps > MOST_BEAD_STEPS and len(fine) >= 2:
                break
            fine.append((plan.beads, follow_rear(plan, session).fitted_speed_m_s.value))
    (coarse, slow), (finest, fast) = fine[-2:]
    true = fast + (fast - slow) * coarse / (finest - coarse)
    speed, bar = float(row["rebound_speed_m_s"]), float(row["rebound_speed_error_m_s"])
    return abs(speed / true - 1.0), bar / true, float(values.get("tolerance", 0.005))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dir")
    parser.add_argument("--rows", type=int, default=50)
    parser.add_argument("--seed", type=int, default=50)
    arguments = parser.parse_args()
    with open(Path(arguments.dir) / "sweep.csv", encoding="utf-8", newline="") as handle:
        done = [row for row in csv.DictReader(handle) if row["status"] == "done"]
    chosen = random.Random(arguments.seed).sample(done, min(arguments.rows, len(done)))
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        error, bar, tolerance = np.array(list(pool.map(judge, chosen))).T
    print(f"{len(chosen)} rows of {len(done)}, seed {arguments.seed}")
    print(f"true error of V: median {np.median(error):.2%}, largest {error.max():.2%}")
    within, covered = np.mean(error <= tolerance), np.mean(error <= bar)
    print(f"within the tolerance: {within:.0%}; within the row's own error: {covered:.0%}")


if __name__ == "__main__":
    main()
