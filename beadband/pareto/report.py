"""The diagram in words and numbers: tidy tables, five sentences, and what a program reads."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

from beadband.pareto.cores import WAYS, Timing, pays_from
from beadband.pareto.frontier import cheapest, frontier
from beadband.pareto.judgement import OK, Row
from beadband.pareto.reference import QUANTITIES, Reference

COLUMNS = (
    "family",
    "variant",
    "model",
    "beads",
    "steps",
    "bead_steps",
    "relax_s",
    "setup_s",
    "integrate_median_s",
    "integrate_min_s",
    "integrate_max_s",
    "repeats",
    "speed_m_s",
    *(f"error_{name}" for name in QUANTITIES),
    *(f"sure_error_{name}" for name in QUANTITIES),
    "own_limit",
    "own_error_speed",
    "status",
    "reason",
)
CORE_COLUMNS = ("way", "beads", "steps", "min_ns_per_bead_step", "median_ns_per_bead_step", "repeats", "reason")


def csv_text(rows: Sequence[Row]) -> str:
    """One line for each run; what there is not stays empty."""
    lines = []
    for row in rows:
        seconds = row.integrate_s
        speed = row.answer.speed_m_s if row.answer else math.nan
        lines.append(
            (
                row.family,
                row.variant,
                row.model,
                row.beads,
                row.steps,
                row.bead_steps,
                row.relax_s,
                row.setup_s,
                row.median_s,
                min(seconds, default=math.nan),
                max(seconds, default=math.nan),
                len(seconds),
                speed,
                *row.errors,
                *row.sure_errors,
                row.own,
                row.own_errors[0],
                row.status,
                row.reason,
            )
        )
    return _csv(COLUMNS, lines)


def cores_csv(times: Sequence[Timing]) -> str:
    """One line for each size and way."""
    return _csv(
        CORE_COLUMNS,
        [(t.way, t.beads, t.steps, t.least_ns, t.median_ns, len(t.seconds), t.reason) for t in times],
    )


def _csv(heads: Sequence[str], lines: Sequence[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows([[_cell(value) for value in line] for line in lines])
    return text.getvalue()


def _cell(value: object) -> object:
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return value


def finite(value: Any) -> Any:
    """The same with null for what is no number."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def reference_dict(reference: Reference) -> dict[str, Any]:
    """A reference that some methods converge to by construction."""
    return {
        "beads": list(reference.beads),
        **{
            name: {"value": value, "uncertainty": spread}
            for name, value, spread in zip(QUANTITIES, reference.values, reference.uncertainties, strict=True)
        },
    }


def strays(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Variants that blow up somewhere, do not converge, or converge to something else, each with its reason."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.status != OK:
            found.setdefault((row.family, row.variant, row.status), []).append(row)
    return [
        {
            "family": family,
            "variant": variant,
            "status": status,
            "beads": sorted({row.beads for row in those}),
            "reason": those[-1].reason,
        }
        for (family, variant, status), those in found.items()
    ]


def cores_dict(times: list[Timing]) -> dict[str, Any]:
    """Nanoseconds a bead and step by way and size, and from where on a second core pays."""
    return {
        "least_ns_per_bead_step": {
            way: {str(t.beads): t.least_ns for t in times if t.way == way and t.seconds} for way in WAYS
        },
        "median_ns_per_bead_step": {
            way: {str(t.beads): t.median_ns for t in times if t.way == way and t.seconds} for way in WAYS
        },
        "pays_from_beads": {way: pays_from(times, way) for way in WAYS[1:]},
        "failed": [{"way": t.way, "beads": t.beads, "reason": t.reason} for t in times if not t.seconds],
    }


def name_of(row: Row) -> str:
    """A row as a reader knows it."""
    words = {"beads": "production", "pair": "Richardson pair"}.get(row.family)
    return words if words else f"{row.family} {row.variant}"


def percent(value: float) -> str:
    return f"{100.0 * value:.2g} %"


def sentences(rows: Sequence[Row], reference: Reference, times: Sequence[Timing], result: dict[str, Any]) -> list[str]:
    """What the charts say, in five sentences made of their numbers."""
    return [
        _speed_sentence(rows, reference),
        _curvature_sentence(rows, reference),
        _plan_sentence(result),
        _integrator_sentence(rows),
        _cores_sentence(times),
    ]


def _steps_of(rows: Sequence[Row], reference: Reference, index: int, errors: Sequence[float]) -> list[str]:
    floor = reference.relative(index)
    front = frontier(rows, index, floor)
    found = []
    for error in errors:
        best = cheapest(front, index, error)
        if best is None:
            found.append(f"{percent(error)} was not reached")
        else:
            found.append(f"{percent(error)} in {1e3 * best.median_s:.2g} ms ({name_of(best)}, {best.beads} beads)")
    return found


def _speed_sentence(rows: Sequence[Row], reference: Reference) -> str:
    leg = [row for row in rows if row.family == "beads" and row.answer]
    ring = [row for row in rows if row.model == "ring files" and row.answer]
    text = "V can be had to " + ", to ".join(_steps_of(rows, reference, 0, (0.02, 0.005, 0.001)))
    if leg and ring:
        same = [(r, one) for r in ring for one in leg if one.beads == r.beads]
        ratios = [r.median_s / one.median_s for r, one in same]
        text += (
            f"; the whole ring with all files costs {min(ratios):.0f} to {max(ratios):.0f} times as much at equal "
            "beads and is no nearer"
        )
    return text + "."


def _curvature_sentence(rows: Sequence[Row], reference: Reference) -> str:
    if not math.isfinite(reference.values[1]):
        return "The scene has no tip curvature."
    near = " and ".join(
        f"at {when} t_f to " + ", to ".join(_steps_of(rows, reference, index, (0.05, 0.01)))
        for index, when in ((1, "0.1"), (2, "0.3"))
    )
    return f"The windowed tip curvature needs more beads, whatever the method: {near}."


def _plan_sentence(result: dict[str, Any]) -> str:
    own = [entry for entry in result["plan"] if (entry["quantity"] == "speed") == (entry["for"] == "speed")]
    ratios = [entry["cost_over_frontier_at_its_error"] for entry in own if entry["cost_over_frontier_at_its_error"]]
    kept = sum(entry["error"] <= entry["tolerance"] for entry in own if entry["quantity"] == "speed")
    made = sum(entry["quantity"] == "speed" for entry in own)
    ratio = f"{min(ratios):.2g} to {max(ratios):.2g} times" if ratios else "an unknown multiple of"
    return (
        f"The plan keeps V within {kept} of {made} tolerances and costs {ratio} the cheapest run of the whole diagram "
        "that can be relied on for the same error."
    )


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
            gains.append((plain.median_s / row.median_s, row))
    slow = [
        (row.median_s / production[row.beads].median_s, row)
        for row in rows
        if row.variant == "lepton" and row.answer and row.beads in production
    ]
    text = "Table points and the form of the angle hardly move a run along either axis"
    if slow:
        text += f", an expression (lepton) costs {min(slow)[0]:.0f} to {max(slow)[0]:.0f} times as much"
    if gains:
        best, row = max(gains, key=lambda gain: gain[0])
        text += f", and rRESPA gains at best {best:.2g} times ({row.variant}, {row.beads} beads)"
    return text + f", with {blown} of its runs blown up by resonance."


def _cores_sentence(times: Sequence[Timing]) -> str:
    alone = [t for t in times if t.way == WAYS[0] and t.seconds]
    parts = []
    for way in WAYS[1:]:
        start = pays_from(list(times), way)
        parts.append(
            f"{way} pay from {start:.2g} beads on" if start else f"{way} never pay up to {times[-1].beads} beads"
        )
    cost = (
        f"a bead and step cost {alone[0].least_ns:.0f} ns at {alone[0].beads} beads and "
        f"{alone[-1].least_ns:.0f} ns at {alone[-1].beads}"
        if alone
        else "one core could not be timed"
    )
    return f"On one core {cost}; {' and '.join(parts)}."


def _full_name(entry: dict[str, Any]) -> str:
    return f"{entry['family']}: {entry['variant']}"


def table(result: dict[str, Any]) -> str:
    """The frontier of V and the plan beside it, for the terminal."""
    lines = []
    for name, title in (
        ("speed", "V"),
        ("curvature_01", "curvature at 0.1 t_f"),
        ("curvature_03", "curvature at 0.3 t_f"),
    ):
        front = result["frontier"].get(name)
        if front is None:
            continue
        lines.append(f"frontier, {title}".ljust(46) + "beads    steps     ms   error   sure")
        lines += [
            f"  {_full_name(entry):42.42s} {entry['beads']:6d} {entry['steps']:8d} "
            f"{1e3 * entry['integrate_s']:6.2f} {100 * entry['error']:6.2f}% {100 * entry['sure_error']:5.2f}%"
            for entry in front
        ]
    lines.append("plan".ljust(46) + "beads    steps     ms   error   sure  cost over frontier")
    for entry in result["plan"]:
        ratio = entry["cost_over_frontier_at_its_error"]
        name = f"for {entry['for']}, {100 * entry['tolerance']:g} %: {entry['quantity']}"
        lines.append(
            f"  {name:42.42s} {entry['beads']:6d} {entry['steps']:8d} {1e3 * entry['integrate_s']:6.2f} "
            f"{100 * entry['error']:6.2f}% {100 * entry['sure_error']:5.2f}%  "
            + ("-" if ratio is None else f"{ratio:.2f}")
        )
    lines.append("no convergence to the same answer")
    lines += [
        f"  {entry['family']}: {entry['variant']}, {', '.join(map(str, entry['beads']))} beads: {entry['status']}"
        for entry in result["not_converging"]
    ]
    return "\n".join(lines)


def markdown(rows: Sequence[Row], reference: Reference, result: dict[str, Any]) -> str:
    """pareto.md: the sentences, the frontier, the plan, and everything that went elsewhere."""
    del rows
    scene = result["scene"]
    parts = [
        "# Error against cost\n",
        f"Band {scene['band']}, strain {scene['strain']:g}, half-angle {scene['half_angle_deg']:g} degrees, "
        f"{scene['law']} law.\n\nError: against {reference.values[0]:.6g} ± {reference.uncertainties[0]:.1g} m/s for "
        f"V, the limit of runs with {', '.join(map(str, reference.beads))} beads carried on to no spacing. Cost: "
        f"seconds of the LAMMPS steps alone, on one core, median of {result['repeats']} repeats taken in turns (load "
        f"average {result['load_average'][0]:.1f} to {result['load_average'][1]:.1f} on {result['processors']} "
        "processors). An error is relied on (sure) if no finer run of the same method has a greater one.\n",
    ]
    parts += [f"{number}. {sentence}" for number, sentence in enumerate(result["sentences"], 1)]
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
            f"| {entry['family']}: {entry['variant']} | {entry['beads']} | {entry['steps']} | "
            f"{1e3 * entry['integrate_s']:.2f} | {100 * entry['error']:.3f} % | {100 * entry['sure_error']:.3f} % |"
            for entry in front
        ]
    parts += [
        "\n## The plan\n",
        "| for | tolerance | of | beads | steps | ms | error | sure error "
        "| cost over frontier at this error, at tolerance |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for entry in result["plan"]:
        ratios = [entry["cost_over_frontier_at_its_error"], entry["cost_over_frontier_at_tolerance"]]
        shown = ", ".join("none" if ratio is None else f"{ratio:.2f}" for ratio in ratios)
        parts.append(
            f"| {entry['for']} | {100 * entry['tolerance']:g} % | {entry['quantity']} | {entry['beads']} | "
            f"{entry['steps']} | {1e3 * entry['integrate_s']:.2f} | {100 * entry['error']:.3f} % | "
            f"{100 * entry['sure_error']:.3f} % | {shown} |"
        )
    parts += ["\n## Not to the same answer\n", "| method | beads | what happens | why |", "|---|---|---|---|"]
    parts += [
        f"| {entry['family']}: {entry['variant']} | {', '.join(map(str, entry['beads']))} | {entry['status']} | "
        f"{entry['reason'].split(';')[0] if entry['status'] == 'blew up' else entry['reason']} |"
        for entry in result["not_converging"]
    ]
    return "\n".join(parts) + "\n"
