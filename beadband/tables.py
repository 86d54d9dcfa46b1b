"""Results as a person reads them on a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from beadband.band import CATALOGUE
from beadband.law import law_of
from beadband.plan import Plan
from beadband.results import Run, as_dict

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


def band_rows() -> list[dict[str, Any]]:
    """The catalogue with derived values, SI; ``peak_strain`` is where the Mooney-Rivlin tension peaks, or null."""
    rows = []
    for band in CATALOGUE.values():
        peak = law_of("mooney-rivlin", band).peak_stretch()
        rows.append(
            {
                "name": band.name,
                "section": band.section,
                "circumference_m": band.circumference_m,
                "width_m": band.width_m,
                "thickness_m": band.thickness_m,
                "density_kg_m3": band.density_kg_m3,
                "modulus_pa": band.modulus_pa,
                "c10_pa": band.c10_pa,
                "c01_pa": band.c01_pa,
                "area_m2": band.area_m2,
                "second_moment_m4": band.second_moment_m4,
                "bending_stiffness_n_m2": band.modulus_pa * band.second_moment_m4,
                "mass_per_length_kg_m": band.mass_per_length_kg_m,
                "rest_modulus_pa": band.rest_modulus_pa,
                "bar_speed_m_s": band.bar_speed_m_s,
                "rest_speed_m_s": band.rest_speed_m_s,
                "peak_strain": None if peak is None else peak - 1.0,
            }
        )
    return rows


def bands(rows: list[dict[str, Any]]) -> str:
    """The catalogue as a table, a column for each band."""
    lines = [["band", "", *(row["name"] for row in rows)], ["section", "", *(row["section"] for row in rows)]]
    for key, heading, unit, factor, form in _BAND_COLUMNS:
        cells = ["-" if row[key] is None else f"{row[key] * factor:{form}}" for row in rows]
        lines.append([heading, unit, *cells])
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    text = [
        "  ".join(
            cell.ljust(width) if i < 2 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        for line in lines
    ]
    notes = (
        "h is the diameter of the circular section. E is the table's; E0 = 6 (C10 + C01) is the Mooney-Rivlin modulus",
        "at rest. Peak strain: where the Mooney-Rivlin tension peaks and a uniform hold ends.",
    )
    return "\n".join([*(line.rstrip() for line in text), *notes])


def plan_values(plan: Plan) -> dict[str, Any]:
    """The plan for programs."""
    return {
        "scene": plan.scene.as_dict(),
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
            "seconds": plan.seconds,
        },
        "reasons": list(plan.reasons),
        "warnings": list(plan.warnings),
    }


def plan(plan: Plan) -> str:
    """The plan for a person: what was chosen and why."""
    scene = plan.scene
    lines = [
        f"Band {scene.band.name}, strain {scene.strain:g}, half-angle {scene.half_angle_deg:g} deg, {scene.law}, "
        f"for {scene.purpose} to {scene.tolerance:.2%}",
        *(f"  {reason}" for reason in plan.reasons),
        f"  predicted error: {plan.speed_error:.2g} of V"
        + (
            "" if plan.curvature_error is None else f", {plan.curvature_error:.2g} of the window-averaged tip curvature"
        ),
        f"  predicted cost: {plan.bead_steps:.2g} bead-steps, {plan.seconds:.2g} s",
        *(f"  note: {warning}" for warning in plan.warnings),
    ]
    return "\n".join(lines)


def result_rows(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What results.json says, as names and texts with errors."""
    scene = values["scene"]
    speed, error = values["rebound_speed_m_s"], values["rebound_speed_error_m_s"]
    string = values["string_speed_m_s"]
    names = {"bar": "C = sqrt(E/rho)", "rest": "C = sqrt(E0/rho)", "front_horizontal": "C of the front"}
    energy = values["energy"]
    return [
        ("rebound speed V", f"{with_error(speed, error)} m/s"),
        (
            "string limit (EI -> 0)",
            f"{string:.4g} m/s; V is {abs(speed / string - 1.0):.2%} {'above' if speed > string else 'below'}",
        ),
        *(
            (
                f"V/C, {names[key]}",
                f"{values['rebound_ratio'][key]:.4f} with C = {wave:.2f} m/s; alpha = {values['alpha'][key]:.3f}",
            )
            for key, wave in values["wave_speeds_m_s"].items()
        ),
        ("tip curvature", _curvature_text(values)),
        (
            "energy",
            f"{energy['stored_j'] * 1e3:.4g} mJ stored; at the end "
            + ", ".join(
                f"{energy[key + '_j'] / energy['stored_j']:.1%} {key}"
                for key in ("kinetic", "stretching", "bending", "dissipated")
            )
            + f"; balanced to {energy['balance_error']:.1g}",
        ),
        ("beads, steps", f"{scene['beads']}, {scene['steps']} of {scene['timestep_s']:.3g} s"),
        (
            "time spent",
            ", ".join(f"{part} {seconds:.2f}" for part, seconds in values["wall_s"].items())
            + f" s; {sum(values['wall_s'].values()):.2f} s in all",
        ),
    ]


def sweep(summary: dict[str, Any]) -> str:
    """A finished sweep in a few lines."""
    status, run = summary["status"], summary["run"]
    lines = [
        f"{summary['scenes']} scenes: " + ", ".join(f"{count} {name}" for name, count in sorted(status.items())),
    ]
    if run["released"]:
        lines.append(
            f"  {run['released']} released in {run['wall_s']:.1f} s, {run['scenes_per_s']:.0f} a second with "
            f"{run['jobs']} jobs; {run['lammps_share'] or 0.0:.0%} of the work inside LAMMPS"
        )
    if summary["relative_error"]:
        error = summary["relative_error"]
        lines.append(f"  error of V: {error['median']:.2%} in the middle, {error['largest']:.2%} at most")
    names = {"bar": "C = sqrt(E/rho)", "rest": "C = sqrt(E0/rho)", "front_horizontal": "C of the front"}
    for law, factors in summary["alpha"].items():
        for wave, found in factors.items():
            low, high = found["slope_interval_95"]
            lines.append(
                f"  {law}, {names[wave]}: alpha {found['mean']:.3f}, from scene to scene +/- "
                f"{found['standard_deviation']:.3f}; slope {found['slope']:.3f} ({low:.3f} to {high:.3f})"
            )
    return "\n".join(lines)


def run(done: Run) -> str:
    """A finished run in a dozen lines."""
    values, scene = as_dict(done), done.plan.scene
    rows = result_rows(values)
    width = max(len(name) for name, _ in rows)
    head = (
        f"Band {scene.band.name}, strain {scene.strain:g}, half-angle {scene.half_angle_deg:g} deg, {scene.law}: "
        f"{scene.until} over {done.plan.front_arrival_s * 1e3:.3f} ms"
    )
    notes = [f"note: {sentence}" for sentence in values["warnings"]]
    return "\n".join([head, *(f"  {name.ljust(width)}  {text}" for name, text in rows), *notes]) + "\n"


def with_error(value: float, error: float) -> str:
    """A value to the second digit of its error."""
    digits = max(0, 1 - math.floor(math.log10(error))) if error > 0.0 else 6
    return f"{value:.{digits}f} +/- {error:.{digits}f}"


def _curvature_text(values: Mapping[str, Any]) -> str:
    curvature = values["curvature"]
    if curvature is None:
        return f"no figure: {values['reason']}"
    start, end = curvature["window_s"]
    return (
        f"falls as t^({with_error(curvature['exponent'], curvature['exponent_error'])}) from {start * 1e3:.3g} to "
        f"{end * 1e3:.3g} ms, {with_error(curvature['eq7_ratio'], curvature['eq7_ratio_error'])} of Eq. 7"
    )
