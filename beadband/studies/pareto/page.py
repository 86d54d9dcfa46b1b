"""pareto.md: charts, findings, frontiers, plans and what does not converge, all from frontier.json."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

from beadband.studies.pareto.findings_text import count, digits, percent, sentences
from beadband.studies.pareto.outcomes import name_of
from beadband.studies.pareto.peers.registry import INSTALL
from beadband.studies.pareto.report import TITLES, full_name

_UNITS = {"speed": "m/s", "curvature_01": "1/m", "curvature_03": "1/m"}


def numbered_findings(result: dict[str, Any]) -> str:
    """The findings as a numbered list in Markdown."""
    return "\n".join(f"{number}. {text}" for number, text in enumerate(sentences(result["findings"]), 1))


def markdown(result: dict[str, Any]) -> str:
    """The page of a result, given as in frontier.json."""
    scene, reference = result["scene"], result["reference"]
    outcomes = ", ".join(f"{name_of(code)} {number}" for code, number in result["outcomes"].items())
    runs = sum(result["outcomes"].values())
    known = ", ".join(
        f"{title} {reference[name]['value']:.6g} ± {reference[name]['uncertainty']:.1g} {_UNITS[name]}"
        for name, title in TITLES.items()
        if name in reference
    )
    low, high = result["load_average"]
    parts = [
        "# Error against cost\n",
        *_peers_first(result),
        f"What each way to compute a release costs for the error that it leaves: band {scene['band']}, strain "
        f"{scene['strain']:g}, half-angle {scene['half_angle_deg']:g} degrees, {scene['law']} law. "
        f"{runs} methods and sizes, by outcome: {outcomes}.\n",
        "![Error of V against cost, every method](pareto.png)\n",
        "![Error of V against cost, one family at a time](pareto-methods.png)\n",
        "## Findings\n",
        numbered_findings(result),
        "\n![Error of the tip curvature against cost](pareto-curvature.png)\n" if "curvature_01" in reference else "",
        "![Cost of a bead and step on one core, and speed-up by a second](pareto-cores.png)\n",
        "## How it was measured\n",
        f"* **Error.** Relative to the limit of no spacing, extrapolated from runs with "
        f"{', '.join(map(count, reference['beads']))} beads on a leg that reaches the finger: {known}. The curvature "
        "is a mean under a Hann window of ±0.03 t_f; t_f is the arrival of the front at the finger.",
        "* **Error bound.** An error can be small by chance, where the errors of a method change sign. The bound is "
        "the largest error of a run and of all finer runs of its method. The frontier is made of bounds, and of "
        "methods that converge to the common limit.",
        f"* **Cost.** The time of the LAMMPS steps alone, on one core: the median of {result['repeats']} repeats taken "
        f"in turns (load average {low:.1f} to {high:.1f} on {result['processors']} processors; a bar in a chart spans "
        "all repeats). Findings and ratios use the quickest repeat, because other work on the machine only adds.",
        "* **Repeat it.** `beadband pareto"
        + (" --quick" if result["quick"] else "")
        + "` runs everything again; `pareto.csv` holds every run, `cores.csv` every timing of the cores, and "
        "`frontier.json` all that this page is made of.",
    ]
    parts += _peers(result)
    for name, front in result["frontier"].items():
        parts += [
            f"\n## Frontier of {TITLES[name]}\n",
            "| method | beads | steps | ms | error | error bound |",
            "|---|---|---|---|---|---|",
            *[f"| {full_name(entry)} | {_numbers(entry)} |" for entry in front],
        ]
    parts += [
        "\n## The plan\n",
        "The last three columns are costs over that of the cheapest run: of any method with the same error bound, of "
        "the production method with the same error bound, and of any method within the tolerance. They are known "
        "only in hindsight.\n",
        "| for | tolerance | error of | beads | steps | ms | error | error bound | any | own | within tolerance |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for entry in result["plan"]:
        if entry["for"] == "speed" and entry["quantity"] != "speed":
            continue
        ratios = [entry[f"cost_over_{of}"] for of in _RATIOS]
        shown = " | ".join("-" if ratio is None else f"{ratio:.2f}" for ratio in ratios)
        tolerance = f"{100 * entry['tolerance']:g} %"
        parts.append(f"| {entry['for']} | {tolerance} | {TITLES[entry['quantity']]} | {_numbers(entry)} | {shown} |")
    parts += ["\n## Not converging to the common limit\n", "| method | beads | outcome | cause |", "|---|---|---|---|"]
    parts += [
        f"| {full_name(entry)} | {', '.join(map(str, entry['beads']))} | {name_of(entry['status'])} | "
        f"{entry['reason']} |"
        for entry in result["not_converging"]
    ]
    return "\n".join(parts) + "\n"


def _peers_first(result: dict[str, Any]) -> list[str]:
    """The first picture and what it shows."""
    if "peers" not in result:
        return []
    return [
        "## Beadband and what else could be used\n",
        "![Error of V against the time of the whole answer, beadband and other programs](pareto-peers.png)\n",
        f"Error of V against the time of the whole answer, set-up included, in a warm process on one core: medians "
        f"over the scenes of a law, bars from the least to the greatest. {len(result['peers']['scenes'])} scenes, the "
        "same for every program, in the same run. A program that can't be given a law is not in its panel. Grey: below "
        "the uncertainty of the reference.\n",
        "## Every method of beadband, on one scene\n",
    ]


def _peers(result: dict[str, Any]) -> list[str]:
    """Times of the peers at each tolerance, the cases where beadband is behind, and how each peer is set up."""
    if "peers" not in result:
        return []
    found = result["peers"]
    parts = [
        "\n## Other programs\n",
        "For each tolerance: the scenes on which a program gets there, the median of its time, and how many times as "
        "fast beadband is (the median): by its plan, when it is asked, and by a leg chosen in hindsight. The level of "
        "a program is always chosen in hindsight: the quickest that is within the tolerance, as all its finer ones.\n",
        "| program | tolerance | scenes | ms | plan | asked | leg in hindsight |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in result["findings"]:
        if one["code"] != "peer-verdict":
            continue
        values = one["values"]
        for level in values["levels"]:
            where = f"| {values['peer']} | {100 * level['tolerance']:g} % | {level['reached']} of {values['scenes']} |"
            if not level["reached"]:
                parts.append(f"{where} - | - | - | - |")
                continue
            cells = [digits(level[key]["times_as_fast"][1]) if key in level else "-" for key in ("plan", "ask", "leg")]
            parts.append(f"{where} {digits(1e3 * level['seconds'][1])} | {' | '.join(cells)} |")
    parts += [
        "\n![The same, scene by scene](pareto-peers-scenes.png)\n",
        "![Error of the tip curvature against the time of the whole answer](pareto-peers-curvature.png)\n",
    ]
    if found["behind"]:
        parts += [
            "Where neither the plan nor the answer to a question is quicker than a program within the tolerance:\n",
            "| scene | tolerance | program | elements | its ms | plan, ms | asked, ms | leg in hindsight, ms |",
            "|---|---|---|---|---|---|---|---|",
        ]
        for case in found["behind"]:
            own = [digits(1e3 * case[key]["whole_s"]) if key in case else "-" for key in ("plan", "ask", "leg")]
            parts.append(
                f"| {case['scene']} | {100 * case['tolerance']:g} % | {case['peer']} | {case['elements']:g} | "
                f"{digits(1e3 * case['whole_s'])} | {' | '.join(own)} |"
            )
    parts += [
        "\nThe scenes:\n",
        "| scene | band | law | thickness, mm | strain | half-angle | V, m/s |",
        "|" + "---|" * 7,
    ]
    parts += [
        f"| {name} | {one['band']} | {one['law']} | {1e3 * one['thickness_m']:g} | {one['strain']:g} | "
        f"{one['half_angle_deg']:g}° | {one['speed_m_s']:.6g} ± {percent(one['uncertainty'])} |"
        for name, one in found["scenes"].items()
    ]
    parts += ["\nHow each program is set up (the adapters, and how to add one: [peers](peers.md)):\n"]
    parts += [
        f"* **{peer['name']}**: {peer['note']}." + ("" if peer["installed"] else f" Not installed: `{INSTALL}`.")
        for peer in found["peers"]
    ]
    return parts


_RATIOS = ("frontier_at_its_error", "production_at_its_error", "frontier_at_tolerance")


def _numbers(entry: dict[str, Any]) -> str:
    return (
        f"{entry['beads']} | {entry['steps']} | {1e3 * entry['integrate_s']:.2f} | {100 * entry['error']:.3f} % | "
        f"{100 * entry['sure_error']:.3f} %"
    )


def store(result: Path, docs: Path) -> None:
    """Keep a result: docs/pareto.json with six digits, the page made of it, and its charts."""
    text = (result / "frontier.json").read_text(encoding="utf-8")
    values = json.loads(text, parse_float=lambda number: float(f"{float(number):.6g}"))
    compact = json.dumps(values, ensure_ascii=False, separators=(",", ":"))
    (docs / "pareto.json").write_text(compact + "\n", encoding="utf-8")
    (docs / "pareto.md").write_text(markdown(values), encoding="utf-8")
    for chart in result.glob("pareto*.png"):
        shutil.copy(chart, docs)


if __name__ == "__main__":
    store(Path(sys.argv[1]), Path(sys.argv[2]))
