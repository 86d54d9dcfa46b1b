"""The diagram in words: five sentences made of its numbers, and pareto.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from beadband.pareto.cores import WAYS, Timing, pays_from
from beadband.pareto.frontier import cheapest, reliable
from beadband.pareto.judgement import Row
from beadband.pareto.reference import Reference
from beadband.pareto.report import full_name


def name_of(row: Row) -> str:
    """A row as a reader knows it."""
    if row.family == "step":
        return f"a step of {1.0 / row.level:.2g} of the limit"
    words = {"beads": "production", "pair": "Richardson pair", "integrator": f"rRESPA, {row.variant}"}.get(row.family)
    return words if words else f"{row.family}: {row.variant}"


def percent(value: float) -> str:
    return f"{100.0 * value:.2g} %"


def sentences(rows: Sequence[Row], reference: Reference, times: Sequence[Timing], result: dict[str, Any]) -> list[str]:
    """What the charts say, in five sentences made of their numbers."""
    return [
        _speed_sentence(rows, reference),
        _curvature_sentence(rows, reference),
        _plan_sentence(result),
        _integrator_sentence(rows),
        _cores_sentence(times, result["load_average"][0]),
    ]


_ALIKE = 1.3


def _steps_of(rows: Sequence[Row], reference: Reference, index: int, errors: Sequence[float]) -> list[str]:
    floor = reference.relative(index)
    others = reliable(rows)
    production = [row for row in others if row.family == "beads"]
    found = []
    for error in errors:
        best, usual = cheapest(others, index, error, floor), cheapest(production, index, error, floor)
        if best is not None and usual is not None and usual.least_s < _ALIKE * best.least_s:
            best = usual  # what is nearly as quick is not worth another name
        if best is None:
            found.append(f"{percent(error)} was not reached")
        else:
            found.append(f"{percent(error)} in {1e3 * best.least_s:.2g} ms ({best.beads} beads, {name_of(best)})")
    return found


def _speed_sentence(rows: Sequence[Row], reference: Reference) -> str:
    leg = [row for row in rows if row.family == "beads" and row.answer]
    ring = [row for row in rows if row.model == "ring files" and row.answer]
    text = "V can be had to " + ", to ".join(_steps_of(rows, reference, 0, (0.02, 0.005, 0.001)))
    if leg and ring:
        same = [(r, one) for r in ring for one in leg if one.beads == r.beads]
        ratios = [r.least_s / one.least_s for r, one in same]
        text += (
            f"; the whole ring with all files costs {min(ratios):.0f} to {max(ratios):.0f} times as much at equal "
            "beads and is no nearer"
        )
    return text + "."


def _curvature_sentence(rows: Sequence[Row], reference: Reference) -> str:
    near = " and ".join(
        f"at {when} t_f to " + ", to ".join(_steps_of(rows, reference, index, (0.05, 0.01)))
        for index, when in ((1, "0.1"), (2, "0.3"))
        if math.isfinite(reference.values[index])
    )
    if not near:
        return "The tip curvature is not known well enough from the finest runs to compare methods by it."
    return f"The windowed tip curvature needs more beads, whatever the method: {near}."


def _plan_sentence(result: dict[str, Any]) -> str:
    own = [entry for entry in result["plan"] if (entry["quantity"] == "speed") == (entry["for"] == "speed")]
    ratios = [entry["cost_over_frontier_at_its_error"] for entry in own if entry["cost_over_frontier_at_its_error"]]
    kept = sum(entry["error"] <= entry["tolerance"] for entry in own if entry["quantity"] == "speed")
    made = sum(entry["quantity"] == "speed" for entry in own)
    same = [entry["cost_over_production_at_its_error"] for entry in own if entry["cost_over_production_at_its_error"]]
    return (
        f"The plan keeps V within {kept} of {made} tolerances; it costs {_range(same)} the cheapest run by its own "
        "method that can be relied on for the same error, "
        f"and {_range(ratios)} that by any method, picked in hindsight."
    )


def _range(ratios: Sequence[float]) -> str:
    return f"{min(ratios):.2g} to {max(ratios):.2g} times" if ratios else "an unknown multiple of"


def _integrator_sentence(rows: Sequence[Row]) -> str:
    gains = []
    production = {row.beads: row for row in rows if row.family == "beads" and row.answer}
    blown = 0
    for row in rows:
        if row.family != "integrator":
            continue
        plain = production.get(row.beads)
        if row.answer is None:
            blown += 1
        elif plain is not None and row.errors[0] <= max(1.5 * plain.errors[0], 1e-3):
            gains.append((plain.least_s / row.least_s, row))
    slow = [
        (row.least_s / production[row.beads].least_s, row)
        for row in rows
        if row.variant == "lepton" and row.answer and row.beads in production
    ]
    text = "Table points and the form of the angle hardly move a run along either axis"
    if slow:
        text += f", an expression (lepton) costs {min(slow)[0]:.0f} to {max(slow)[0]:.0f} times as much"
    if gains:
        best, row = max(gains, key=lambda gain: gain[0])
        text += f", and rRESPA gains at best {best:.2g} times ({row.variant}, {row.beads} beads)"
    return text + f"; {blown} of its runs blew up, their outer step in tune with a mode."


_BUSY = 0.5
"""Load average of others from which a second core was not free to be measured."""


def _round(count: float) -> str:
    """A count to one digit, with its thousands apart."""
    digits = 10 ** (len(str(int(count))) - 1)
    return f"{round(count / digits) * digits:,}".replace(",", " ")


def _cores_sentence(times: Sequence[Timing], load: float) -> str:
    alone = [t for t in times if t.way == WAYS[0] and t.seconds]
    parts = []
    for way in WAYS[1:]:
        start = pays_from(list(times), way)
        parts.append(
            f"{way} pay from {_round(start)} beads on" if start else f"{way} never pay up to {times[-1].beads} beads"
        )
    cost = (
        f"a bead and step cost {alone[0].least_ns:.0f} ns at {alone[0].beads} beads and "
        f"{alone[-1].least_ns:.0f} ns at {alone[-1].beads}"
        if alone
        else "one core could not be timed"
    )
    busy = f" (other work was running, load average {load:.1f}: no second core was free)" if load > _BUSY else ""
    return f"On one core {cost}; {' and '.join(parts)}{busy}."


def markdown(rows: Sequence[Row], reference: Reference, result: dict[str, Any]) -> str:
    """pareto.md: the charts, the sentences, the frontier, the plan, and everything that went elsewhere."""
    scene = result["scene"]
    values = zip(("V", "κ at 0.1 t_f", "κ at 0.3 t_f"), ("m/s", "1/m", "1/m"), range(3), strict=True)
    known = ", ".join(
        f"{name} {reference.values[i]:.6g} ± {reference.uncertainties[i]:.1g} {unit}"
        for name, unit, i in values
        if math.isfinite(reference.values[i])
    )
    seconds = [row for row in rows if row.integrate_s]
    parts = [
        "# Error against cost\n",
        f"Band {scene['band']}, strain {scene['strain']:g}, half-angle {scene['half_angle_deg']:g} degrees, "
        f"{scene['law']} law: {len(rows)} methods and sizes, {len(rows) - len(seconds)} of which ended in a blow-up.\n",
        "![V](pareto.png)\n",
        *[f"{number}. {sentence}" for number, sentence in enumerate(result["sentences"], 1)],
        "\n![Curvature](pareto-curvature.png)\n" if any(map(math.isfinite, reference.values[1:])) else "",
        "![A second core](pareto-cores.png)\n",
        "## How it was measured\n",
        f"Errors are against the limit of runs with {', '.join(map(str, reference.beads))} beads on a leg that reaches "
        f"the finger, carried on to no spacing: {known}. Curvature is a mean under a Hann window of ±0.03 t_f. Cost is "
        f"the time of the LAMMPS steps alone, on one core, the median of {result['repeats']} repeats taken in turns "
        f"(load average {result['load_average'][0]:.1f} to {result['load_average'][1]:.1f} on {result['processors']} "
        "processors; a bar spans all repeats); sentences and ratios take the quickest repeat, for other work on the "
        "machine only adds. A lucky error, where the curve of a method crosses the truth, is no merit: the frontier "
        "counts the largest error of a run and of all finer ones of its method (sure error), and "
        "leaves out what does not converge to the same answer. Every run is in `pareto.csv`; `beadband pareto` repeats "
        "them all.\n",
    ]
    for name, title in (("speed", "V"), ("curvature_01", "κ at 0.1 t_f"), ("curvature_03", "κ at 0.3 t_f")):
        front = result["frontier"].get(name)
        if front is None:
            continue
        parts += [
            f"\n## Frontier of {title}\n",
            "| method | beads | steps | ms | error | sure error |",
            "|---|---|---|---|---|---|",
        ]
        parts += [
            f"| {full_name(entry)} | {entry['beads']} | {entry['steps']} | "
            f"{1e3 * entry['integrate_s']:.2f} | {100 * entry['error']:.3f} % | {100 * entry['sure_error']:.3f} % |"
            for entry in front
        ]
    parts += [
        "\n## The plan\n",
        "Cost over that of the cheapest run of any method with the same sure error, of its own method with the same "
        "sure error, and of any method within the tolerance. No plan can have such hindsight.\n",
        "| for | tolerance | error of | beads | steps | ms | error | sure error | any | own | within tolerance |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for entry in result["plan"]:
        if entry["for"] == "speed" and entry["quantity"] != "speed":
            continue
        ratios = [
            entry[f"cost_over_{of}"]
            for of in ("frontier_at_its_error", "production_at_its_error", "frontier_at_tolerance")
        ]
        shown = " | ".join("-" if ratio is None else f"{ratio:.2f}" for ratio in ratios)
        quantity = {"speed": "V", "curvature_01": "κ, 0.1 t_f", "curvature_03": "κ, 0.3 t_f"}[entry["quantity"]]
        parts.append(
            f"| {entry['for']} | {100 * entry['tolerance']:g} % | {quantity} | {entry['beads']} | "
            f"{entry['steps']} | {1e3 * entry['integrate_s']:.2f} | {100 * entry['error']:.3f} % | "
            f"{100 * entry['sure_error']:.3f} % | {shown} |"
        )
    parts += ["\n## Not to the same answer\n", "| method | beads | what happens | why |", "|---|---|---|---|"]
    for entry in result["not_converging"]:
        why = entry["reason"].split("LAMMPS: ")[-1].split("; allowed")[0]
        parts.append(f"| {full_name(entry)} | {', '.join(map(str, entry['beads']))} | {entry['status']} | {why} |")
    return "\n".join(parts) + "\n"
