"""Does the plan keep its word? Random scenes at three tolerances, against converged runs.

    python tests/validation/random_scenes.py [--scenes 40] [--seed 40] [--json FILE]

For each scene and tolerance the plan's leg is released, with the second run that judges its error. The true answer is
that of fine runs of the same scene, carried on to no spacing. The cheapest setting is the coarsest of a ladder of bead
counts, a factor of sqrt(2) apart, from which on every finer one is within the tolerance too: hindsight that no plan can
have. Cost is that of relaxation and integration as predicted from beads and steps, and in bead-steps.
"""

from __future__ import annotations

import argparse
import json
import random
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import estimate_of, follow_rear
from beadband.runs.results import joined_error_m_s

TOLERANCES = (0.02, 0.005, 0.001)
BEADS_A_LEG = (9, 12, 17, 24, 34, 48, 68, 96, 136, 192, 272, 384, 543)
FEWEST_FINE = 136
MOST_BEAD_STEPS = 1.2e7


def draw(rng: random.Random) -> dict[str, Any]:
    """Values of a random scene that has an answer."""
    while True:
        values: dict[str, Any] = {
            "band": rng.choice(["I", "II", "III", "IV", "circular"]),
            "law": rng.choice(["mooney-rivlin", "linear"]),
            "strain": rng.uniform(0.1, 1.4),
            "half_angle_deg": rng.uniform(5.0, 30.0),
            "for": "speed",
        }
        try:
            scene_of(values)
        except BeadbandError:
            continue
        return values


def judge(values: dict[str, Any]) -> list[dict[str, Any]]:
    """One row for each tolerance."""
    scene = scene_of(values)
    ratio = scene.band.circumference_m / scene.wedge.reference_leg_m
    ladder: list[tuple[Plan, float]] = []
    rows = []
    with Session() as session:
        for count in BEADS_A_LEG:
            plan = plan_of(scene_of({**values, "beads": max(24, round(count * ratio))}), "leg")
            if plan.bead_steps > MOST_BEAD_STEPS and count > FEWEST_FINE:
                break
            ladder.append((plan, follow_rear(plan, session).fitted_speed_m_s.value))
        (before, slow), (last, fast) = ladder[-2:]
        # Of the order of the loss.
        order = 1.0 if scene.string.wave.shocks else 2.0
        true = fast + (fast - slow) / ((last.beads / before.beads) ** order - 1.0)
        for tolerance in TOLERANCES:
            plan = plan_of(scene_of({**values, "tolerance": tolerance}), "leg")
            start = time.perf_counter()
            found = follow_rear(plan, session).fitted_speed_m_s
            middle = time.perf_counter()
            bar = joined_error_m_s(found, plan.beads, estimate_of(plan, session), plan.speed_error)
            end = time.perf_counter()
            cheapest = ladder[-1][0]
            for tried, speed in reversed(ladder):
                if abs(speed / true - 1.0) > tolerance:
                    break
                cheapest = tried
            rows.append(
                {
                    **values,
                    "tolerance": tolerance,
                    "model": plan.model,
                    "beads": plan.beads,
                    "steps": plan.steps,
                    "error": abs(found.value / true - 1.0),
                    "bar": bar / true,
                    "reference_uncertainty": abs(fast / true - 1.0),
                    "seconds_ratio": plan.seconds / cheapest.seconds,
                    "bead_steps_ratio": plan.bead_steps / cheapest.bead_steps,
                    "run_s": middle - start,
                    "estimate_s": end - middle,
                }
            )
    return rows


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One line for each tolerance."""
    lines = []
    for tolerance in TOLERANCES:
        of = [row for row in rows if row["tolerance"] == tolerance]
        error, bar = np.array([row["error"] for row in of]), np.array([row["bar"] for row in of])
        seconds = np.array([row["seconds_ratio"] for row in of])
        work = np.array([row["bead_steps_ratio"] for row in of])
        lines.append(
            {
                "tolerance": tolerance,
                "scenes": len(of),
                "within_tolerance": float(np.mean(error <= tolerance)),
                "within_bar": float(np.mean(error <= bar)),
                "median_error": float(np.median(error)),
                "worst_error": float(error.max()),
                "median_bar": float(np.median(bar)),
                "cost_at_most_twice": float(np.mean(seconds <= 2.0)),
                "median_cost_ratio": float(np.median(seconds)),
                "median_bead_steps_ratio": float(np.median(work)),
                "median_run_ms": 1e3 * float(np.median([row["run_s"] for row in of])),
                "median_estimate_ms": 1e3 * float(np.median([row["estimate_s"] for row in of])),
            }
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=40)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    scenes = [draw(rng) for _ in range(arguments.scenes)]
    start = time.perf_counter()
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for found in pool.map(judge, scenes):
            rows += found
    print(f"seed {arguments.seed}, {len(scenes)} scenes, {time.perf_counter() - start:.0f} s")
    lines = summary(rows)
    for name in lines[0]:
        print(name.ljust(26), *(f"{line[name]:12.4g}" for line in lines))
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as handle:
            json.dump({"seed": arguments.seed, "summary": lines, "rows": rows}, handle, indent=1)


if __name__ == "__main__":
    main()
