"""What the comparison comes to: at each tolerance, who reaches it on which scenes, and beadband's time beside it."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from statistics import median
from typing import Any

from beadband.studies.pareto.findings import Finding
from beadband.studies.pareto.outcomes import OK
from beadband.studies.pareto.peers.comparison import ASK, OTHER, OURS, PAIR, PLAN, TOLERANCES, Comparison, Point
from beadband.studies.pareto.peers.protocol import installed
from beadband.studies.pareto.peers.registry import INSTALL

TOPIC = "peers"
CODES = ("peers-compared", "peer-absent", "peer-other-laws", "peer-verdict", "peer-failures", "second-method")
"""Of its findings."""
_BEADBAND = (OURS, PLAN, ASK, PAIR, OTHER)


def findings(compared: Comparison) -> list[Finding]:
    """The verdicts as values; findings_text.py makes sentences of them."""
    found = [Finding(TOPIC, "peers-compared", _extent(compared))]
    for peer in compared.peers:
        if not installed(peer):
            found.append(Finding(TOPIC, "peer-absent", {"peer": peer.name, "install": INSTALL}))
            continue
        kept = [name for name, scene in compared.scenes.items() if peer.laws is None or scene.law in peer.laws]
        if not kept:
            found.append(Finding(TOPIC, "peer-other-laws", {"peer": peer.name, "laws": list(peer.laws or ())}))
            continue
        levels = [_level(compared.points, peer.name, kept, tolerance) for tolerance in TOLERANCES]
        values = {"peer": peer.name, "scenes": len(kept), "of": len(compared.scenes), "levels": levels}
        found.append(Finding(TOPIC, "peer-verdict", values))
        failed = [point for point in compared.points if point.tool == peer.name and math.isnan(point.errors[0])]
        if failed:
            values = {"peer": peer.name, "failed": len(failed), "reason": failed[-1].reason}
            found.append(Finding(TOPIC, "peer-failures", values))
    if compared.second:
        sizes = [abs(value) for value in compared.second.values()]
        bars = [one.relative(0) for one in compared.references.values()]
        values = {"scenes": len(sizes), "median": median(sizes), "most": max(sizes), "uncertainty": max(bars)}
        found.append(Finding(TOPIC, "second-method", values))
    return found


def _extent(compared: Comparison) -> dict[str, Any]:
    behind = exceptions(compared)
    return {
        "scenes": len(compared.scenes),
        "runs": len(compared.points),
        "failed": sum(math.isnan(point.errors[0]) for point in compared.points),
        "failed_own": sum(math.isnan(point.errors[0]) for point in compared.points if point.tool in _BEADBAND),
        "cases": len(cases(compared)),
        "behind": len(behind),
        "leg_ahead": sum(case["leg"]["ahead"] for case in behind if "leg" in case),
    }


def cheapest(points: Sequence[Point], tool: str, scene: str, tolerance: float) -> Point | None:
    """The quickest run of a tool that is within a tolerance together with all its finer ones."""
    within = [
        point
        for point in points
        if point.tool == tool and point.scene == scene and point.status == OK and point.bounds[0] <= tolerance
    ]
    return min(within, key=lambda point: point.whole_s, default=None)


def own(points: Sequence[Point], tool: str, scene: str, tolerance: float) -> Point | None:
    """What beadband chose for a tolerance: its plan for the speed, or what it answers when asked."""
    chosen = [
        point
        for point in points
        if point.tool == tool
        and point.scene == scene
        and point.level == tolerance
        and (tool != PLAN or "speed" in point.variant)
    ]
    return chosen[0] if chosen else None


def cases(compared: Comparison) -> list[dict[str, Any]]:
    """Every scene, peer and tolerance that the peer reaches, with beadband's own two answers beside it.

    An answer is ahead when it takes less time and its error is within the tolerance. The plan and the answer need no
    hindsight, while the peer's level is the cheapest that is known afterwards to be good enough; "leg" is the leg of
    beadband that is chosen as the peer's level is.
    """
    found = []
    for peer in compared.peers:
        for scene in compared.scenes:
            for tolerance in TOLERANCES:
                best = cheapest(compared.points, peer.name, scene, tolerance)
                if best is None:
                    continue
                entry: dict[str, Any] = {"peer": peer.name, "scene": scene, "tolerance": tolerance}
                entry |= {"elements": best.level, "whole_s": best.whole_s}
                answers = {
                    key: own(compared.points, tool, scene, tolerance) for key, tool in (("plan", PLAN), ("ask", ASK))
                }
                answers["leg"] = cheapest(compared.points, OURS, scene, tolerance)
                for key, one in answers.items():
                    if one is not None:
                        within = one.errors[0] <= tolerance
                        entry[key] = {
                            "whole_s": one.whole_s,
                            "times_as_fast": best.whole_s / one.whole_s,
                            "within": within,
                            "ahead": within and one.whole_s < best.whole_s,
                        }
                found.append(entry)
    return found


def exceptions(compared: Comparison) -> list[dict[str, Any]]:
    """The cases in which neither the plan nor the answer to a question is ahead."""
    return [
        case for case in cases(compared) if not any(case.get(key, {}).get("ahead", False) for key in ("plan", "ask"))
    ]


def _level(points: Sequence[Point], peer: str, scenes: Sequence[str], tolerance: float) -> dict[str, Any]:
    """A peer at a tolerance: on how many scenes it gets there, its times, and beadband's speed over its."""
    reached = {scene: one for scene in scenes if (one := cheapest(points, peer, scene, tolerance)) is not None}
    level: dict[str, Any] = {"tolerance": tolerance, "reached": len(reached), "tried": len(scenes)}
    if not reached:
        return level
    level["seconds"] = _spread([one.whole_s for one in reached.values()])
    for key, tool in (("plan", PLAN), ("ask", ASK), ("leg", OURS)):
        pairs = []
        for scene, one in reached.items():
            mine = cheapest(points, tool, scene, tolerance) if tool == OURS else own(points, tool, scene, tolerance)
            if mine is not None:
                pairs.append((one, mine))
        if pairs:
            level[key] = {
                "times_as_fast": _spread([theirs.whole_s / mine.whole_s for theirs, mine in pairs]),
                "missed": sum(mine.errors[0] > tolerance for _, mine in pairs),
                "of": len(pairs),
            }
    return level


def _spread(values: Sequence[float]) -> list[float]:
    """Least, median and greatest."""
    return [min(values), median(values), max(values)]


def as_dict(compared: Comparison) -> dict[str, Any]:
    """The comparison as frontier.json has it: scenes, references, peers, the points of all tools but variants."""
    return {
        "scenes": {
            name: {
                "band": scene.band.name,
                "law": scene.law,
                "thickness_m": scene.band.thickness_m,
                "strain": scene.strain,
                "half_angle_deg": scene.half_angle_deg,
                "speed_m_s": compared.references[name].values[0],
                "uncertainty": compared.references[name].relative(0),
                "second_method": compared.second.get(name),
            }
            for name, scene in compared.scenes.items()
        },
        "peers": [
            {"name": peer.name, "package": peer.package, "installed": installed(peer), "note": peer.note}
            for peer in compared.peers
        ],
        "behind": exceptions(compared),
    }


def csv_text(compared: Comparison) -> str:
    """Every point as a line of peers.csv."""
    names = ("speed", "curvature_01", "curvature_03")
    head = ["scene", "tool", "level", *(f"error_{one}" for one in names), *(f"bound_{one}" for one in names)]
    head += ["loop_s", "whole_s", "status", "reason", "variant"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for one in compared.points:
        numbers = [one.level, *one.errors, *one.bounds, one.loop_s, one.whole_s]
        shown = [f"{value:.6g}" if math.isfinite(value) else "" for value in numbers]
        writer.writerow([one.scene, one.tool, *shown, one.status, one.reason, one.variant])
    return text.getvalue()
