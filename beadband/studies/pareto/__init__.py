"""The work-precision study: the cost of each method for the error that it leaves, all on the same axes."""

from __future__ import annotations

import json
import os
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from beadband.lammps.engine import Session
from beadband.model.scene import Scene
from beadband.parameters import TABLE, refuse_unused
from beadband.studies.pareto.convergence import pairs, with_errors
from beadband.studies.pareto.methods import FULL, MAIN, Extent, methods
from beadband.studies.pareto.repeats import Progress, measured, plans


def pareto(
    scene: Scene, folder: Path, extent: Extent = FULL, progress: Progress | None = None, with_peers: bool = False
) -> dict[str, Any]:
    """Run every method, find its errors, and write tables and charts into the folder, frontier.json last; return that.

    ``with_peers`` compares beadband with other programs as well, on scenes of their own.
    UsageError for a scene that one leg can't model or that sets what the study varies, RunError when a reference fails.
    """
    from beadband.runs.folder import write_text
    from beadband.runs.results import versions
    from beadband.studies.pareto import charts, cores, frontier, page, report
    from beadband.studies.pareto.findings import findings
    from beadband.studies.pareto.findings_text import sentences
    from beadband.studies.pareto.peers import charts as peer_charts
    from beadband.studies.pareto.peers import compare, verdicts
    from beadband.studies.pareto.reference import references

    given = {key: value for key, value in scene.as_dict().items() if key in TABLE and key not in scene.planned}
    refuse_unused("pareto", {key: value for key, value in given.items() if value != TABLE[key].default})
    start = time.perf_counter()
    tried = [*methods(scene, extent), *plans(scene)]
    kinds = list(dict.fromkeys([MAIN, *(method.own for method in tried)]))
    load_before = os.getloadavg()[0]
    with Session() as session:
        limits = references(scene, max(extent.beads), session, kinds)
        rows = measured(tried, session, progress, extent.repeats)
    rows = with_errors([*rows, *pairs(rows)], limits)
    other_work = max(load_before, os.getloadavg()[0] - 1.0)  # without this process
    times = cores.timings(scene, extent)
    result = frontier.as_dict(rows, limits[MAIN])
    found = findings(rows, limits[MAIN], times, result["plan"], other_work)
    compared = compare(extent != FULL, progress=progress) if with_peers else None
    if compared is not None:
        found += [asdict(one) for one in verdicts.findings(compared)]
        result["peers"] = verdicts.as_dict(compared)
    result.update(
        {
            "scene": scene.as_dict(),
            "quick": extent != FULL,
            "repeats": extent.repeats,
            "outcomes": dict(Counter(row.outcome.code for row in rows).most_common()),
            "findings": found,
            "other_references": {name: one.as_dict() for name, one in limits.items() if name != MAIN},
            "not_converging": report.not_converging(rows),
            "cores": report.cores_dict(times),
            "load_average": [load_before, os.getloadavg()[0]],
            "processors": os.cpu_count(),
            "wall_s": time.perf_counter() - start,
            "versions": versions("see lammps_package"),
        }
    )
    result = dict(report.finite(result))
    result["sentences"] = sentences(result["findings"])
    write_text(folder / "pareto.csv", report.csv_text(rows))
    write_text(folder / "cores.csv", report.cores_csv(times))
    charts.draw(rows, limits[MAIN], times, folder, scene)
    if compared is not None:
        write_text(folder / "peers.csv", verdicts.csv_text(compared))
        peer_charts.draw(compared, folder)
    write_text(folder / "pareto.md", page.markdown(result))
    text = json.dumps(result, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    write_text(folder / "frontier.json", text, durable=True)
    return result
