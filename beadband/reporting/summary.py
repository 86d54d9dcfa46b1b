"""Results as a person reads them on a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from beadband import observables
from beadband.analysis.fits import Measured
from beadband.model.scene import Scene
from beadband.notices import percent, sentences
from beadband.parameters import TABLE
from beadband.planning.plan import Plan
from beadband.runs.results import Run

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan

# key of the row, heading, unit, factor from SI, format
_BAND_COLUMNS: tuple[tuple[str, str, str, float, str], ...] = (
    ("circumference_m", "Cb", "mm", 1e3, ".1f"),
    ("width_m", "b", "mm", 1e3, ".2f"),
    ("thickness_m", "h", "mm", 1e3, ".2f"),
    ("density_kg_m3", "rho", "kg/m3", 1.0, ".0f"),
    ("modulus_pa", "E", "MPa", 1e-6, ".3f"),
    ("c10_pa", "C10", "MPa", 1e-6, ".3f"),
    ("c01_pa", "C01", "MPa", 1e-6, ".3f"),
    ("area_m2", "A", "mm2", 1e6, ".3f"),
    ("second_moment_m4", "I", "mm4", 1e12, ".4f"),
    ("bending_stiffness_n_m2", "EI", "N mm2", 1e6, ".3f"),
    ("rest_modulus_pa", "E0", "MPa", 1e-6, ".3f"),
    ("bar_speed_m_s", "sqrt(E/rho)", "m/s", 1.0, ".3f"),
    ("rest_speed_m_s", "sqrt(E0/rho)", "m/s", 1.0, ".3f"),
    ("peak_strain", "peak strain", "", 1.0, ".4f"),
)


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of cells as lines of columns: the first two to the left, numbers to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  ".join(
            cell.ljust(width) if i < 2 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]


def bands(rows: list[dict[str, Any]]) -> str:
    """The catalogue as a table, a column for each band."""
    lines = [["band", "", *(row["name"] for row in rows)], ["section", "", *(row["section"] for row in rows)]]
    for key, heading, unit, factor, form in _BAND_COLUMNS:
        cells = ["-" if row.get(key) is None else f"{row[key] * factor:{form}}" for row in rows]
        if set(cells) != {"-"} or key in ("width_m", "peak_strain"):
            lines.append([heading, unit, *cells])
    shown = {key for key, *_ in _BAND_COLUMNS}
    for key in dict.fromkeys(key for row in rows for key in row if key in TABLE and key not in shown):
        if TABLE[key].kind in ("number", "numbers"):
            cells = ["-" if row.get(key) is None else _constant_text(row[key]) for row in rows]
            lines.append([TABLE[key].symbol or key, TABLE[key].unit, *cells])
    lines.append(["law", "", *(row["law"] for row in rows)])
    text = aligned(lines)
    notes = (
        "h is the diameter of a circular section. E is the stated modulus; E0 is that of the law at rest, for",
        "Mooney-Rivlin 6 (C10 + C01). Peak strain: where the tension peaks and a uniform hold ends.",
    )
    return "\n".join([*(line.rstrip() for line in text), *notes])


def _constant_text(value: Any) -> str:
    return ", ".join(f"{each:.4g}" for each in (value if isinstance(value, (tuple, list)) else (value,)))


def plan_values(chosen: Plan | LaunchPlan) -> dict[str, Any]:
    """The plan for programs."""
    plan = chosen if isinstance(chosen, Plan) else chosen.release
    return {
        "scene": plan.scene.as_dict(),
        "label": plan.scene.label,
        "beads": plan.beads,
        "timestep_s": plan.timestep_s,
        "largest_timestep_s": plan.largest_timestep_s,
        "loss_time_s": plan.loss_time_s,
        "steps": plan.steps,
        "frames": plan.frames,
        "front_arrival_s": plan.front_arrival_s,
        "model": plan.model,
        "bead_steps": plan.bead_steps,
        "predicted": {
            "speed_error": plan.speed_error,
            "curvature_error": plan.curvature_error,
            "seconds": chosen.seconds,
            "bytes": chosen.disk_bytes,
        },
        "reasons": sentences(plan.reasons),
        "warnings": sentences(plan.warnings),
    }


def plan(chosen: Plan | LaunchPlan) -> str:
    """The plan for a person: what was chosen and why."""
    plan = chosen if isinstance(chosen, Plan) else chosen.release
    scene = plan.scene
    lines = [
        f"{heading(scene)}, for {scene.purpose} to {percent(scene.tolerance)}",
        *(f"  {reason}" for reason in plan.reasons),
        f"  predicted error: {plan.speed_error:.2g} of V"
        + (
            "" if plan.curvature_error is None else f", {plan.curvature_error:.2g} of the window-averaged tip curvature"
        ),
        f"  predicted cost: {plan.bead_steps:.2g} bead-steps, {chosen.seconds:.2g} s, {chosen.disk_bytes / 1e6:.2g} MB",
        *(f"  note: {warning}" for warning in plan.warnings),
    ]
    return "\n".join(lines)


def result_rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What results.json says, as names and texts with errors."""
    return observables.rows(values, _SPECIAL)


def _string_text(values: Mapping[str, Any]) -> str:
    speed, string = values["rebound_speed_m_s"], values["string_speed_m_s"]
    side = "above" if speed > string else "below"
    if "strip" in values:
        return f"{string:.6g} m/s, exact for a strip; V is {percent(abs(speed / string - 1.0))} {side}"
    return f"{string:.4g} m/s; V is {abs(speed / string - 1.0):.2%} {side}"


def _late_text(values: Mapping[str, Any]) -> str | None:
    """Of interest where a peg lets the rear gain speed for long."""
    return observables.text_of(values, "late_speed_m_s") if values["scene"].get("tip_radius_m") else None


def _ratio_text(wave: str) -> Callable[[Mapping[str, Any]], str]:
    def text(values: Mapping[str, Any]) -> str:
        return (
            f"{values['rebound_ratio'][wave]:.4f} with C = {values['wave_speeds_m_s'][wave]:.2f} m/s; "
            f"alpha = {values['alpha'][wave]:.3f}"
        )

    return text


def _curvature_text(values: Mapping[str, Any]) -> str | None:
    curvature = values["curvature"]
    if "strip" in values:
        return None
    if curvature is None:
        return f"not given: {values['reason']}"
    start, end = curvature["window_s"]
    return (
        f"falls as t^({Measured(curvature['exponent'], curvature['exponent_error'])}) from {start * 1e3:.3g} to "
        f"{end * 1e3:.3g} ms, {Measured(curvature['eq7_ratio'], curvature['eq7_ratio_error'])} of Eq. 7"
    )


def _energy_text(values: Mapping[str, Any]) -> str:
    energy = values["energy"]
    parts = ("kinetic", "stretching", "bending", "dissipated")
    shares = ", ".join(f"{energy[f'{part}_j'] / energy['stored_j']:.1%} {part}" for part in parts)
    return f"{energy['stored_j'] * 1e3:.4g} mJ stored; at the end {shares}; balanced to {energy['balance_error']:.1g}"


def _steps_text(values: Mapping[str, Any]) -> str:
    scene = values["scene"]
    return f"{scene['beads']}, {scene['steps']} of {scene['timestep_s']:.3g} s"


def _wall_text(values: Mapping[str, Any]) -> str:
    wall = values["wall_s"]
    parts = ", ".join(f"{part} {seconds:.2f}" for part, seconds in wall.items())
    # An analysis takes its own time, which the plan of the run does not predict.
    predicted = values.get("predicted") if "integrate" in wall else None
    more = f" (predicted {predicted['seconds']:.2g} s, {predicted['bytes'] / 1e6:.2g} MB)" if predicted else ""
    return f"{parts} s; {sum(wall.values()):.2f} s in all{more}"


def _with(key: str, more: Callable[[Mapping[str, Any]], str]) -> Callable[[Mapping[str, Any]], str | None]:
    """The row of a value, and what belongs to it, where both are there."""

    def text(values: Mapping[str, Any]) -> str | None:
        row = observables.text_of(values, key)
        try:
            return row and f"{row}{more(values)}"
        except KeyError:
            return row

    return text


def _beside_exact(name: str, scale: float) -> Callable[[Mapping[str, Any]], str | None]:
    """The row of a value of a strip, and the exact one."""
    return _with(f"strip.{name}", lambda values: f"; exact {scale * values['strip']['exact'][name]:.5g}")


def _shares_text(values: Mapping[str, Any]) -> str | None:
    shares = values["launch"].get("shares")
    return shares and ", ".join(f"{share:z.1%} {name}" for name, share in shares.items())


def _inputs_text(values: Mapping[str, Any]) -> str | None:
    """The error of V from the inputs, the largest shares first, next to the numerical error."""
    error, speed = values.get("rebound_speed_input_error_m_s"), values["rebound_speed_m_s"]
    if error is None:
        return None
    shares = _shares_together(values)
    parts = ", ".join(f"{share:.0%} {name}" for name, share in sorted(shares.items(), key=lambda one: -one[1])
                      if share >= 0.005)  # fmt: skip
    numerical = values[observables.error_key("rebound_speed_m_s")]
    drawn = values.get("input_samples")
    more = f"; {drawn['error_m_s']:.2g} m/s over {drawn['draws'] - drawn['refused']} draws" if drawn else ""
    both = math.hypot(error, numerical)
    return f"+/- {error:.2g} m/s ({error / abs(speed):.2g} of V): {parts}{more}; with the numerical one {both:.2g} m/s"


def _shares_together(values: Mapping[str, Any]) -> dict[str, float]:
    """Share of each input in the variance; constants whose errors are correlated count together."""
    shares: dict[str, float] = {}
    for one in values["inputs"]:
        fitted = values["scene"].get("covariance") and TABLE[one["name"].partition("[")[0]].section == "law"
        name = "constants of the law together" if fitted else one["name"]
        shares[name] = shares.get(name, 0.0) + one["share"]
    return shares


_SPECIAL: observables.Special = {
    "rebound_speed_input_error_m_s": _inputs_text,
    "late_speed_m_s": _late_text,
    "string_speed_m_s": _string_text,
    **{f"rebound_ratio.{wave}": _ratio_text(wave) for wave in observables.WAVES},
    "curvature": _curvature_text,
    "energy.stored_j": _energy_text,
    "plan.beads": _steps_text,
    "wall_s": _wall_text,
    "launch.efficiency": _with("launch.efficiency", lambda values: f" of {values['energy']['stored_j'] * 1e3:.4g} mJ"),
    "launch.escape_speed_m_s": _with(
        "launch.escape_speed_m_s", lambda values: f" for R = {values['launch']['finger']['radius_m'] * 1e3:.4g} mm"
    ),
    "launch.finger_impulse_n_s": _with(
        "launch.finger_impulse_n_s",
        lambda values: f"; deepest in the finger {values['checks']['penetration']['value']:.2%} of the thickness",
    ),
    "launch.shares": _shares_text,
    **{f"strip.{name}": _beside_exact(name, scale) for name, scale in (("front_speed_m_s", 1.0), ("arrival_s", 1e3))},
}
"""Rows that say more than one value."""


def sweep_estimate(expected: Any) -> str:
    """What a sweep is expected to cost, in a line."""
    return (
        f"{expected.scenes} scenes, about {expected.runs} to release: some {_duration(expected.seconds)}, and a table "
        f"of {_bytes(expected.disk_bytes)}"
    )


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600.0 else f"{seconds / 3600.0:.1f} h"


def _bytes(size: float) -> str:
    return f"{size / 1e6:.1f} MB" if size > 2e5 else f"{size / 1e3:.0f} kB"


def sweep(summary: dict[str, Any]) -> str:
    """A finished sweep in a few lines."""
    status, run = summary["status"], summary["run"]
    lines = [f"{summary['scenes']} scenes: " + ", ".join(f"{count} {name}" for name, count in sorted(status.items()))]
    if run["released"] or run["by_formula"]:
        where = f"with {run['jobs']} jobs" if run["jobs"] else "on the given executor"
        inside = f"; {run['lammps_share']:.0%} of the work inside LAMMPS" if run["lammps_share"] else ""
        rate = f"{run['scenes_per_s']:.{0 if run['scenes_per_s'] >= 10.0 else 1}f} a second"
        answered = f", {run['by_formula']} by formula" if run["by_formula"] else ""
        lines.append(f"  {run['released']} new scenes{answered} in {run['wall_s']:.1f} s, {rate} {where}{inside}")
    peak, worker = run["peak_bytes"]["first_process"], run["peak_bytes"]["largest_worker"]
    workers = f", {worker / 1e6:.0f} MB in the largest worker" if worker else ""
    lines.append(f"  memory {peak / 1e6:.0f} MB in the first process{workers}; table of {_bytes(run['disk_bytes'])}")
    for code, found in summary["without_result"].items():
        lines.append(f"  no result for {found['scenes']} ({code}), the first: {found['first']}")
    if summary["relative_error"]:
        error = summary["relative_error"]
        lines.append(
            f"  error of V: median {error['median']:.2%}, largest {error['largest']:.2%}; in "
            f"{summary['above_tolerance']} of {status['done']} finished scenes above the tolerance"
        )
    names = {"bar": "C = sqrt(E/rho)", "rest": "C = sqrt(E0/rho)", "front_horizontal": "C of the front"}
    for law, factors in summary["alpha"].items():
        for wave, found in factors.items():
            low, high = found["slope_interval_95"]
            lines.append(
                f"  {law}, {names[wave]}: alpha {found['mean']:.3f}, scatter between scenes "
                f"{found['standard_deviation']:.3f}; slope {found['slope']:.3f} ({low:.3f} to {high:.3f})"
            )
    return "\n".join(lines)


def heading(scene: Scene, degrees: str = " deg") -> str:
    """What was asked for, in one line."""
    law = "" if scene.law in scene.label.split(", ") else f", {scene.law}"
    return f"Band {scene.label}, {scene.held(degrees)}{law}"


def title_of(scene: Scene) -> str:
    """The same above a picture: a name is plain text there, no formula."""
    return heading(scene, "°").replace("$", r"\$")


def run(done: Run) -> str:
    """A finished run in a dozen lines."""
    values, scene = done.as_dict(), done.scene
    rows = result_rows(values)
    width = max(len(name) for name, _ in rows)
    head = f"{heading(scene)}: {scene.until} over {done.energy.times_s[-1] * 1e3:.3f} ms"
    notes = [f"note: {sentence}" for sentence in values["warnings"]]
    return "\n".join([head, *(f"  {name.ljust(width)}  {text}" for name, text in rows), *notes]) + "\n"
