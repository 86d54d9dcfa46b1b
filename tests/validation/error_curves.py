"""Measure the error curves of beadband.planning: random scenes, each released on one leg at many bead spacings.

    python tests/validation/error_curves.py OUT.csv [--scenes 160] [--seed 1] [--edges]

Each scene's error is taken against its finest run, carried on to no spacing at all by the last two (first order).
``--edges`` draws from a wider space: strains from 0.03, half-angles up to the closing of the wedge, EI times 0 to 4.
Prints the percentiles of the error over the number of beads in what moves at the rear.
"""

from __future__ import annotations

import argparse
import csv
import math
import random
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from multiprocessing import get_context
from typing import Any

import numpy as np

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning import error_curves
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear

BEADS_A_LEG = (12, 16, 22, 32, 45, 64, 90, 128, 180, 256, 360, 512, 720)
MOST_BEAD_STEPS = 1.2e7
FINE_ENOUGH = 0.3
"""Spacing over the bending layer below which nothing finer is run."""


def draw(rng: random.Random, edges: bool) -> dict[str, Any]:
    """Values of a random scene that has an answer."""
    while True:
        values: dict[str, Any] = {
            "band": rng.choice(["I", "II", "III", "IV", "circular"]),
            "law": rng.choice(["mooney-rivlin", "linear"]),
            "strain": rng.uniform(0.03, 1.45) if edges else rng.uniform(0.1, 1.4),
            "half_angle_deg": rng.uniform(2.0, 50.0) if edges else rng.uniform(5.0, 30.0),
            "for": "speed",
        }
        if edges:
            values["bending_scale"] = rng.choice([0.0, 1e-4, 0.01, 0.2, 1.0, 4.0])
        try:
            scene_of(values)
        except BeadbandError:
            continue
        return values


def curve(values: dict[str, Any]) -> list[dict[str, Any]]:
    """One row for each spacing: what was run, what it gave, what the plan predicts."""
    scene = scene_of(values)
    string, rear = scene.string, error_curves.rear_length_m(scene, scene.string)
    leg, length = scene.wedge.reference_leg_m, scene.band.circumference_m
    layer = plan_layer(scene)
    rows: list[dict[str, Any]] = []
    with Session() as session:
        for count in BEADS_A_LEG:
            beads = round(count * length / leg)
            spacing = length / beads
            plan = plan_of(scene_of({**values, "beads": beads}), "leg")
            finer_than_needed = layer > 0.0 and count > 256 and spacing < FINE_ENOUGH * layer
            if plan.bead_steps > MOST_BEAD_STEPS or finer_than_needed:
                break
            row = {
                **values,
                "string_speed_m_s": string.rear_speed_m_s,
                "beads": beads,
                "beads_in_rear": rear / spacing,
                "spacing_in_layers": spacing / layer if layer else math.inf,
                "model": plan.model,
                "bead_steps": plan.bead_steps,
                "predicted": plan.speed_error,
            }
            try:
                found = follow_rear(plan, session).fitted_speed_m_s
                rows.append({**row, "speed_m_s": found.value, "fit_m_s": found.error, "failed": ""})
            except BeadbandError as error:
                rows.append({**row, "speed_m_s": math.nan, "fit_m_s": math.nan, "failed": str(error)})
    good = [row for row in rows if not row["failed"]]
    if len(good) < 3:
        return rows
    last, before = good[-1], good[-2]
    ahead = (last["speed_m_s"] - before["speed_m_s"]) * before["beads"] / (last["beads"] - before["beads"])
    limit = last["speed_m_s"] + ahead
    for row in rows:
        row["error"] = row["speed_m_s"] / limit - 1.0
        row["limit_m_s"] = limit
    return rows


def plan_layer(scene: Any) -> float:

    return scene.scales.bending_layer_m


def table(rows: list[dict[str, Any]]) -> str:
    """Percentiles of the error, in per cent, against the prediction."""
    edges = [8, 12, 16, 20, 25, 32, 40, 56, 80, 112, 160, 250, 1000]
    good = [row for row in rows if not row["failed"] and "error" in row]
    count = np.array([row["beads_in_rear"] for row in good])
    error = 100.0 * np.abs([row["error"] for row in good])
    predicted = 100.0 * np.array([row["predicted"] for row in good])
    lines = ["beads in rear   runs   50 %    80 %    95 %    100 %   predicted  within"]
    for low, high in pairwise(edges):
        chosen = (count >= low) & (count < high)
        if chosen.sum() < 5:
            continue
        percentiles = " ".join(f"{value:7.3f}" for value in np.percentile(error[chosen], [50, 80, 95, 100]))
        within = float(np.mean(error[chosen] <= predicted[chosen]))
        lines.append(
            f"{low:5d}-{high:<5d} {chosen.sum():8d} {percentiles} {np.median(predicted[chosen]):8.3f} {within:9.3f}"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("--scenes", type=int, default=160)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--edges", action="store_true")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    scenes = [draw(rng, arguments.edges) for _ in range(arguments.scenes)]
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        for found in pool.map(curve, scenes):
            rows += found
    names = list(dict.fromkeys(key for row in rows for key in row))
    with open(arguments.out, "w", newline="", encoding="utf-8") as handle:
        writer = csv.DictWriter(handle, names)
        writer.writeheader()
        writer.writerows(rows)
    print(table(rows))
    failed = [row for row in rows if row["failed"]]
    print(f"{len(scenes)} scenes, {len(rows)} runs, seed {arguments.seed}; {len(failed)} failed")
    for row in failed[:20]:
        print({key: row[key] for key in ("band", "law", "strain", "half_angle_deg", "beads", "failed")})


if __name__ == "__main__":
    main()
