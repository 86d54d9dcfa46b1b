"""The runs that are compared: every method several times in turns, and the plan's own choices among them."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import Scene
from beadband.parameters import PLANNED
from beadband.studies.pareto.convergence import Row, row_of
from beadband.studies.pareto.methods import FULL, Method
from beadband.studies.pareto.outcomes import DONE, Outcome, outcome_of
from beadband.studies.pareto.runs import Answer, Cost, run_once

TOLERANCES = (0.02, 0.005, 0.001)
Progress = Callable[[int, int], None]


def plans(scene: Scene) -> list[Method]:
    """The plan's own choices for each purpose and tolerance, to be compared with the other methods."""
    from beadband.planning.plan import plan_of

    found = []
    for purpose in ("speed", "curvature"):
        for tolerance in TOLERANCES:
            free = replace(
                scene,
                purpose=purpose,
                tolerance=tolerance,
                planned=(),
                **dict.fromkeys(PLANNED),  # type: ignore[arg-type]
            )
            found.append(Method("plan", f"{purpose} {100.0 * tolerance:g} %", plan_of(free, "leg"), level=tolerance))
    return found


def measured(
    compared: Sequence[Method], session: Session, progress: Progress | None = None, repeats: int = FULL.repeats
) -> list[Row]:
    """Run every method ``repeats`` times in the session, in turns, so that what slows the machine slows all alike."""
    answers: dict[int, Answer] = {}
    failures: dict[int, Outcome] = {}
    costs: dict[int, list[Cost]] = {index: [] for index in range(len(compared))}
    order = list(range(len(compared)))
    shuffled = random.Random(1)
    for turn in range(repeats):
        shuffled.shuffle(order)
        for done, index in enumerate(order, 1):
            if index in failures:
                continue
            try:
                answers[index], cost = run_once(compared[index], session)
                costs[index].append(cost)
            except BeadbandError as error:
                failures[index] = outcome_of(error)
            if progress:
                progress(turn * len(order) + done, repeats * len(order))
    return [
        row_of(method, costs[index], answers.get(index), failures.get(index, DONE))
        for index, method in enumerate(compared)
    ]
