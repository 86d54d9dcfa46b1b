"""How large the errors of the levels of `beadband ask` are: their measurement, their likelihood, and what they cover.

    python tests/validation/level_errors.py levels.json [--scenes 110] [--seed 501] [--fit]

Random scenes are released with a quarter of an octave of beads from level to level, up to a predicted 3 s. The true V
of a scene is that of its finest levels, carried on to no spacing. ``--fit`` finds the constants of
``beadband.planning.ladder.LEVEL_ERRORS`` by maximum likelihood, in some minutes. In any case the ladder is then climbed
on the levels of the file: how many stated errors hold the true ones, and how many bead-steps they took.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from ladder import draw
from numpy.typing import NDArray

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning import ladder
from beadband.planning.ladder import AIM, COVERS, LEVEL_ERRORS, THREE_FROM, LevelErrors, Question
from beadband.runs.rear_run import follow_rear

Array = NDArray[np.float64]
MOST_SECONDS = 3.0
FINEST = 7
"""Levels that say what the true V is."""
SCATTER = np.exp(0.35 * np.linspace(-2.0, 2.7, 8))
"""Noise of a scene over that of most scenes, in the likelihood."""


def measure(scenes: int, seed: int, path: Path) -> None:
    """Release every level of random scenes, and write what they gave after each scene."""
    rng = random.Random(seed)
    rows: list[dict[str, Any]] = []
    with Session() as session:
        for number in range(scenes):
            values = draw(rng)
            question = question_of(values)
            levels = []
            for level in range(48):
                if question.seconds(level) > MOST_SECONDS:
                    break
                try:
                    plan = question.plan(level)
                    speed = follow_rear(plan, session).fitted_speed_m_s.value
                except BeadbandError:
                    continue
                levels.append((plan.beads, speed, plan.bead_steps))
            rows.append({"values": values, "levels": levels})
            path.write_text(json.dumps(rows), encoding="utf-8")
            print(f"\r{number + 1} of {scenes}", end="", file=sys.stderr, flush=True)


def question_of(values: dict[str, Any]) -> Question:
    return Question(replace(scene_of(values), tolerance=2e-4), "speed", 2e-4)


def true_speed(beads: Array, speeds: Array, order: float) -> tuple[float, float]:
    """V for beads without end and its relative standard error, from the finest levels; coarsest first."""
    coarse = beads[-1] / beads[-FINEST:]
    weight = coarse**-1.5
    matrix = np.stack([np.ones(FINEST), coarse**order], axis=1) * weight[:, None]
    found, *_ = np.linalg.lstsq(matrix, speeds[-FINEST:] * weight, rcond=None)
    apart = speeds[-FINEST:] * weight - matrix @ found
    variance = np.linalg.inv(matrix.T @ matrix)[0, 0] * float(apart @ apart) / (FINEST - 2)
    return float(found[0]), math.sqrt(variance) / float(found[0])


def constants(rows: list[dict[str, Any]], order: float) -> LevelErrors:
    """The sizes and powers of the errors of one order by maximum likelihood."""
    from scipy.optimize import minimize

    scenes = []
    for row in rows:
        question = question_of(row["values"])
        if question.order == order and len(row["levels"]) > FINEST + 4:
            beads, speeds, _ = np.array(row["levels"]).T
            speed, doubt = true_speed(beads, speeds, order)
            scenes.append((question, beads[:-3], speeds[:-3] / speed - 1.0, doubt))
    kept = LEVEL_ERRORS[order]

    def errors_of(parameters: Array) -> LevelErrors:
        return LevelErrors(*np.exp(parameters[:3]).tolist(), *parameters[3:].tolist())

    def cost(parameters: Array) -> float:
        LEVEL_ERRORS[order] = errors_of(parameters)
        total = 0.0
        for question, beads, errors, doubt in scenes:
            noisy = question.covariance(beads)
            LEVEL_ERRORS[order] = replace(errors_of(parameters), noise=0.0)
            smooth = question.covariance(beads)
            LEVEL_ERRORS[order] = errors_of(parameters)
            likely = []
            for scatter in SCATTER:
                covariance = smooth + scatter**2 * (noisy - smooth) + doubt**2
                apart = float(errors @ np.linalg.solve(covariance, errors))
                likely.append(-0.5 * (apart + np.linalg.slogdet(covariance)[1]))
            total += float(np.logaddexp.reduce(likely))
        return -total

    start = np.array([*np.log([kept.smooth, kept.higher, kept.noise]), kept.noise_order, *_powers(kept)])
    found = minimize(cost, start, method="Nelder-Mead", options={"maxfev": 600, "adaptive": True})
    LEVEL_ERRORS[order] = kept
    return errors_of(found.x)


def _powers(errors: LevelErrors) -> tuple[float, float, float]:
    return errors.unresolved, errors.resolved, errors.rear


def climb(question: Question, beads: Array, speeds: Array, tolerance: float) -> tuple[float, float, list[int]] | None:
    """V, its stated relative error, and the levels of an answer; None where the levels of the file do not suffice."""
    octave, half = ladder._OCTAVE, ladder._OCTAVE // 2

    def state(levels: list[int], values: Array) -> tuple[float, float]:
        limit = question.limit(beads[levels], values)
        return limit.value, COVERS * limit.error / limit.value

    for top in range(octave, len(beads)):
        levels = [top, top - octave] if tolerance >= THREE_FROM else [top, top - half, top - octave]
        if state(levels, np.ones(len(levels)))[1] <= AIM * tolerance:
            break
    while levels[0] < len(beads):
        value, error = state(levels, speeds[levels])
        if error <= tolerance:
            return value, error, levels
        if levels[0] + half >= len(beads):
            break
        levels = [levels[0] + half, *levels]
    return None


def report(rows: list[dict[str, Any]], tolerance: float) -> str:
    """One line on the answers that the levels of the file give."""
    held, steps, errors, asked = [], [], [], 0
    for row in rows:
        if len(row["levels"]) <= FINEST + 4:
            continue
        asked += 1
        question = question_of(row["values"])
        beads, speeds, work = np.array(row["levels"]).T
        true, doubt = true_speed(beads, speeds, question.order)
        if (found := climb(question, beads, speeds, tolerance)) is None:
            continue
        value, stated, levels = found
        errors.append(abs(value / true - 1.0))
        held.append(errors[-1] <= math.hypot(stated, 2.0 * doubt))
        steps.append(float(work[levels].sum()))
    return (
        f"{tolerance:g}: answered {len(held)} of {asked}, true error inside the stated one {sum(held)}; "
        f"median true error {np.median(errors):.1e}, bead-steps {np.median(steps):.2g}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--scenes", type=int, default=110)
    parser.add_argument("--seed", type=int, default=501)
    parser.add_argument("--fit", action="store_true")
    arguments = parser.parse_args()
    if not arguments.file.exists():
        measure(arguments.scenes, arguments.seed, arguments.file)
    rows = json.loads(arguments.file.read_text(encoding="utf-8"))
    if arguments.fit:
        for order in LEVEL_ERRORS:
            print(f"order {order:g}: {constants(rows, order)}", flush=True)
    for tolerance in (1e-3, 2e-4, 1e-4):
        print(report(rows, tolerance))


if __name__ == "__main__":
    main()
