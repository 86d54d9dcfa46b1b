"""Does an answer keep its word? Fixed and random scenes at five tolerances, against converged runs of their own.

    python tests/validation/ladder.py [--scenes 100] [--seed 77] [--tolerances 0.02,0.005,0.001] [--json FILE]

The true answer of a scene is that of whole legs with many more beads than any answer takes (its last four levels,
carried on by :func:`beadband.analysis.convergence.limit_of`); ``--second-method N`` compares the first N fixed scenes
with finite elements as well (elements.py of the peers). For each tolerance: answers within the tolerance, answers whose
true error is within the stated one, those that state that they could not, the time of a whole answer in a warm process,
and that over the time of the cheapest level that would have done, known in hindsight.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import Scene, scene_of
from beadband.planning.ladder import Question
from beadband.runs.ask import ask, question_of
from beadband.runs.rear_run import follow_rear

TOLERANCES = (0.02, 0.005, 0.001, 2e-4, 5e-5)
MOST_BEAD_STEPS = 1.2e7
FIXED: tuple[dict[str, Any], ...] = (
    {},
    {"law": "linear"},
    {"band": "I", "strain": 0.3, "half_angle_deg": 10.0},
    {"band": "I", "strain": 0.9, "half_angle_deg": 18.0, "law": "linear"},
    {"band": "II", "strain": 0.6, "half_angle_deg": 12.0},
    {"band": "II", "strain": 1.1, "half_angle_deg": 22.0},
    {"band": "III", "strain": 0.2, "half_angle_deg": 8.0},
    {"band": "III", "strain": 0.8, "half_angle_deg": 20.0, "thickness_m": 0.8e-3},
    {"band": "IV", "strain": 0.5, "half_angle_deg": 9.0},
    {"band": "IV", "strain": 1.2, "half_angle_deg": 15.0},
    {"band": "circular", "strain": 0.7, "half_angle_deg": 16.0},
    {"law": "gent", "mu_pa": 3.5e5, "jm": 30.0, "strain": 0.8, "half_angle_deg": 14.0},
    {"law": "ogden", "mu_pa": (1e5, 2e4), "alpha": (2.5, 4.5), "strain": 0.9, "half_angle_deg": 12.0},
)
"""Scenes of every band and shape of unloading wave: shocks, sharp fronts, and a fan with a shock behind it."""


def draw(rng: random.Random) -> dict[str, Any]:
    """Values of a random scene that has an answer: all bands, both laws, half of them of another thickness."""
    while True:
        values: dict[str, Any] = {
            "band": rng.choice(["I", "II", "III", "IV", "circular"]),
            "law": rng.choice(["mooney-rivlin", "linear"]),
            "strain": rng.uniform(0.1, 1.4),
            "half_angle_deg": rng.uniform(5.0, 30.0),
        }
        if rng.random() < 0.5:
            values["thickness_m"] = 10.0 ** rng.uniform(-3.3, -2.6)
        try:
            scene = scene_of(values)
            if question_of(scene, "speed").model == "leg":
                return values
        except BeadbandError:
            continue


def levels(scene: Scene, session: Session) -> tuple[float, float, list[tuple[int, float, float]]]:
    """True speed, its standard error, and beads, speed and seconds of each level, coarsest first."""
    question = Question(replace(scene, tolerance=2e-4), "speed", 2e-4)
    found: list[tuple[int, float, float]] = []
    for level in range(0, 60, 2):
        plan = question.plan(level)
        if plan.bead_steps > MOST_BEAD_STEPS and level > 12:
            break
        start = time.perf_counter()
        try:
            speed = follow_rear(plan, session).fitted_speed_m_s.value
        except BeadbandError:
            continue
        found.append((plan.beads, speed, time.perf_counter() - start))
    last = found[-4:][::-1]
    limit = question.limit(np.array([one[0] for one in last], dtype=np.float64), np.array([one[1] for one in last]))
    return limit.value, limit.error, found


def judge(values: dict[str, Any], tolerances: tuple[float, ...], session: Session) -> list[dict[str, Any]]:
    """One row for each tolerance."""
    scene = scene_of(values)
    true, uncertainty, ladder = levels(scene, session)
    rows = []
    for tolerance in tolerances:
        asked = replace(scene, tolerance=tolerance)
        answer = ask(asked, "speed", session)
        seconds = min(
            [answer.seconds, *(ask(asked, "speed", session).seconds for _ in range(2 if answer.seconds < 0.2 else 0))]
        )
        hindsight = ladder[-1][2]
        for _, speed, took in reversed(ladder):
            if abs(speed / true - 1.0) > tolerance:
                break
            hindsight = took
        rows.append(
            {
                **values,
                "tolerance": tolerance,
                "model": answer.model,
                "runs": answer.runs,
                "beads": answer.beads,
                "stated": answer.error / abs(answer.value),
                "error": abs(answer.value / true - 1.0),
                "reference": uncertainty / abs(true),
                "within_tolerance": answer.within_tolerance,
                "seconds": seconds,
                "over_hindsight": seconds / hindsight,
            }
        )
    return rows


def summary(rows: list[dict[str, Any]]) -> list[str]:
    """A line for each tolerance."""
    columns = (
        "tolerance",
        "scenes",
        "formula",
        "kept",
        "flagged",
        "in bar",
        "error",
        "bar",
        "ms",
        "95 % ms",
        "hindsight",
    )
    lines = ["".join(name.rjust(11) for name in columns)]
    for tolerance in sorted({row["tolerance"] for row in rows}, reverse=True):
        of = [row for row in rows if row["tolerance"] == tolerance]
        given = [row for row in of if row["within_tolerance"]]
        # The reference is not exact: what it leaves open is no fault of the answer.
        inside = sum(row["error"] <= math.hypot(row["stated"], 2.0 * row["reference"]) for row in of)

        def middle(name: str, of: list[dict[str, Any]] = of, share: float = 0.5) -> float:
            return float(np.quantile([row[name] for row in of], share))

        cells = (
            f"{tolerance:g}",
            f"{len(of)}",
            f"{sum(row['model'] == 'formula' for row in of)}",
            f"{sum(row['stated'] <= tolerance for row in given)}/{len(given)}",
            f"{len(of) - len(given)}",
            f"{inside}",
            f"{middle('error'):.1e}",
            f"{middle('stated'):.1e}",
            f"{1e3 * middle('seconds'):.2f}",
            f"{1e3 * middle('seconds', share=0.95):.1f}",
            f"{middle('over_hindsight'):.2f}",
        )
        lines.append("".join(cell.rjust(11) for cell in cells))
    return lines


def against_second_method(count: int, session: Session) -> None:
    """The first fixed scenes against finite elements in space with an implicit method in time."""
    from beadband.analysis.fits import path_slope
    from beadband.model.scales import SPEED_WINDOW
    from beadband.studies.pareto.peers import elements as second_method

    for values in FIXED[:count]:
        scene = scene_of({**values, "tolerance": 2e-4})
        answer = ask(scene, "speed", session)
        law, band, arrival = scene.material, scene.band, scene.scales.front_arrival_s
        speeds = []
        for elements, steps in ((300, 1200), (450, 1800)):
            viscosity = 0.2 * scene.wedge.reference_leg_m / elements * band.density_kg_m3 * scene.string.front_speed_m_s
            viscosity *= 1.0 if scene.string.wave.shocks else 0.1
            rod = second_method.Rod(
                law.stress, law.tangent, band.area_m2, band.density_kg_m3, scene.bending_stiffness_n_m2, viscosity
            )
            nodes = second_method.graded_nodes(scene.wedge.reference_leg_m, elements, 3.0)
            found = second_method.release(rod, 1.0 + scene.strain, scene.half_angle_rad, nodes, 0.87 * arrival, steps)
            start, end = (share * arrival for share in SPEED_WINDOW)
            speeds.append(path_slope(found.times_s, found.tip_x_m, start, end))
        limit = speeds[1] + (speeds[1] - speeds[0]) * 300.0 / 150.0
        print(
            f"{scene.label}, {scene.law}: asked {answer.value:.5f} +/- {answer.error:.5f}; elements {speeds[0]:.5f}, "
            f"{speeds[1]:.5f}, carried on {limit:.5f}: {limit / answer.value - 1.0:+.2e}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=77)
    parser.add_argument("--tolerances", default=",".join(map(str, TOLERANCES)))
    parser.add_argument("--second-method", type=int, default=0)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    tolerances = tuple(float(one) for one in arguments.tolerances.split(","))
    rng = random.Random(arguments.seed)
    scenes = [*FIXED, *(draw(rng) for _ in range(arguments.scenes))]
    rows: list[dict[str, Any]] = []
    with Session() as session:
        if arguments.second_method:
            against_second_method(arguments.second_method, session)
        for number, values in enumerate(scenes):
            rows += judge(values, tolerances, session)
            if arguments.json:
                Path(arguments.json).write_text(json.dumps(rows, indent=1), encoding="utf-8")
            print(f"\r{number + 1} of {len(scenes)}", end="", file=sys.stderr, flush=True)
    print(f"\nseed {arguments.seed}")
    for part, of in (("fixed", rows[: len(FIXED) * len(tolerances)]), ("random", rows[len(FIXED) * len(tolerances) :])):
        if of:
            print(part, *summary(of), sep="\n")
    for row in rows:
        if row["error"] > math.hypot(row["stated"], 2.0 * row["reference"]):
            print("outside", row)


if __name__ == "__main__":
    main()
