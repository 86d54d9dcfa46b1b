"""Figures 18, 21 and 23: V/C against strain, angle, thickness and section."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from beadband.analysis.fits import Measured
from beadband.model.wedge import published_ratio
from beadband.studies.reproduction.drawing import COLOURS, SERIES, Sheet
from beadband.studies.reproduction.runs import Found, Runs, Values
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, between, rises, small

BANDS = ("I", "II", "III", "IV")
WAVES = {"bar": "√(E/ρ)", "rest": "√(E0/ρ)", "front_horizontal": "horizontal front"}
_STRAINS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
_ANGLES = (5.0, 10.0, 14.0, 20.0, 25.0, 30.0)
ALPHA = 1.09
"""The paper's alpha of Eq. 10."""


def scene(band: str, strain: float, angle: float, **more: Any) -> Values:
    """A scene of which only V is asked."""
    return {"band": band, "strain": strain, "half_angle_deg": angle, "for": "speed", **more}


def scenes18(quick: bool) -> list[Values]:
    return [scene(band, s, 14.0) for band in BANDS for s in _STRAINS] + [
        scene(band, 0.476, a) for band in BANDS for a in _ANGLES
    ]


def fig18(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """V/C against strain at 14 degrees and against the half-angle at 0.476."""
    figure, axes = sheet.axes(columns=3, width=4.8)
    steps: dict[str, list[float]] = {"strain": [], "angle": []}
    for band in BANDS:
        by_strain = [runs.of(scene(band, s, 14.0)) for s in _STRAINS]
        by_angle = [runs.of(scene(band, 0.476, a)) for a in _ANGLES]
        for panel, xs, found, wave in (
            (axes[0], _STRAINS, by_strain, "bar"),
            (axes[1], _STRAINS, by_strain, "rest"),
            (axes[2], _ANGLES, by_angle, "rest"),
        ):
            draw_ratios(panel, xs, found, wave, COLOURS[band], f"band {band}")
        steps["strain"] += list(np.diff([f.ratio("rest") for f in by_strain]))
        steps["angle"] += list(np.diff([f.ratio("rest") for f in by_angle]))
    for panel, wave in zip(axes[:2], ("bar", "rest"), strict=True):
        draw_formula(panel, strains=np.linspace(0.1, 1.3, 100), angles=14.0, wave=wave)
    draw_formula(axes[2], strains=0.476, angles=np.linspace(4.0, 31.0, 100), wave="rest")
    axes[0].legend(fontsize=8)
    figure.suptitle("Fig. 18: rebound speed of bands I–IV (Mooney–Rivlin)")
    sheet.save(figure, "fig18")
    everything = runs.all_of(scenes18(quick))
    alphas = {wave: np.array([f.alpha(wave) for f in everything]) for wave in WAVES}
    return [
        Entry(
            "Fig. 18",
            "simulation and experiment agree; V/C rises with ε and φ a little above the formula",
            {
                "least_step_with_strain": min(steps["strain"]),
                "least_step_with_angle": min(steps["angle"]),
                **{f"least_{wave}": float(alphas[wave].min()) for wave in WAVES},
                **{f"most_{wave}": float(alphas[wave].max()) for wave in WAVES},
                "mean_with_rest_modulus": float(alphas["rest"].mean()),
                "mean_with_bar_over_mean_with_front": float(alphas["bar"].mean() / alphas["front_horizontal"].mean()),
            },
            "V/C {least_step_with_strain:?rises|does not always rise} with ε and "
            "{least_step_with_angle:?with φ|not always with φ}; over the formula it is "
            "{least_bar:.2f}–{most_bar:.2f} with √(E/ρ), {least_rest:.2f}–{most_rest:.2f} with √(E0/ρ), "
            "{least_front_horizontal:.2f}–{most_front_horizontal:.2f} with the front's horizontal speed",
            printed=(
                rises("least_step_with_strain"),
                rises("least_step_with_angle"),
                between("mean_with_rest_modulus", 1.0, 1.2),
            ),
            otherwise=(agrees("mean_with_bar_over_mean_with_front", 1.0, 0.05),),
            differences={
                Verdict.CHOICE: "how far above depends on C, by a factor of "
                "{mean_with_bar_over_mean_with_front:.2f}; the experimental points are not in the text"
            },
        )
    ]


def scenes21(quick: bool) -> list[Values]:
    decade = np.round(np.geomspace(0.6e-3, 6e-3, 6 if quick else 11), 7)
    return [{"band": "III", "thickness_m": float(h)} for h in (*decade, 1.9e-3, 2.0e-3)]


def fig21(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """V against thickness over a decade."""
    found = sorted(runs.all_of(scenes21(quick)), key=lambda f: f.values["thickness_m"])
    thick = np.array([f.values["thickness_m"] for f in found])
    over = np.array([f.speed.value / f.string_speed for f in found])
    errors = np.array([f.speed.error / f.string_speed for f in found])
    figure, (axes,) = sheet.axes()
    axes.errorbar(thick * 1e3, over, errors, fmt="o-", color=SERIES[1], capsize=3, label="Band III, ε = 0.476, φ = 14°")
    axes.axhline(1.0, color="#888888", linestyle="--", label="string limit")
    axes.set(xscale="log", xlabel="thickness h (mm)", ylabel="V over the string limit", title="Fig. 21: thickness")
    ticks = (0.6, 1.0, 2.0, 3.0, 4.0, 6.0)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.legend()
    sheet.save(figure, "fig21")
    sheet.tables["thickness"] = [
        {"thickness_m": float(h), "speed_over_string": float(v), "error": float(e)}
        for h, v, e in zip(thick, over, errors, strict=True)
    ]
    table = dict(zip(thick.tolist(), over.tolist(), strict=True))
    return [
        Entry(
            "Fig. 21",
            "h has little influence on V",
            {
                "thinnest_mm": thick[0] * 1e3,
                "thickest_mm": thick[-1] * 1e3,
                "at_thinnest": Measured(over[0], errors[0]),
                "at_thickest": Measured(over[-1], errors[-1]),
                "least": over.min(),
                "largest_error": errors.max(),
                "tenth": table[1.9e-3] / table[2.0e-3] - 1.0,
                "spread": Measured(over.max() - over.min(), errors.max()),
            },
            "V/V_string goes from {at_thinnest:.4f} at {thinnest_mm:.1f} mm through a least {least:.4f} to "
            "{at_thickest:.4f} at {thickest_mm:.1f} mm (errors {largest_error:.4f} at most); 1.9 against 2.0 "
            "mm: {tenth:+.2%}",
            printed=(small("spread", 0.02),),
            differences={Verdict.CONFIRMED: "{spread:.1%} over a decade"},
        )
    ]


def scenes23(quick: bool) -> list[Values]:
    places = [(s, 11.6) for s in _STRAINS] + [(0.476, a) for a in _ANGLES]
    return [scene("circular", s, a, bending_scale=k) for k in (1e-4, 1.0) for s, a in places]


def fig23(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """The circular section with and without bending."""
    figure, axes = sheet.axes(columns=2)
    for factor, colour, label in ((1.0, SERIES[1], "with bending"), (1e-4, SERIES[0], "without (EI × 10⁻⁴)")):
        for panel, places, xs in (
            (axes[0], [(s, 11.6) for s in _STRAINS], _STRAINS),
            (axes[1], [(0.476, a) for a in _ANGLES], _ANGLES),
        ):
            found = [runs.of(scene("circular", s, a, bending_scale=factor)) for s, a in places]
            draw_ratios(panel, xs, found, "rest", colour, label)
    draw_formula(axes[0], strains=np.linspace(0.1, 1.3, 100), angles=11.6, wave="rest")
    draw_formula(axes[1], strains=0.476, angles=np.linspace(4.0, 31.0, 100), wave="rest")
    for panel in axes:
        panel.legend(fontsize=8)
    figure.suptitle("Fig. 23: circular section")
    sheet.save(figure, "fig23")
    pairs = [(runs.of({**v, "bending_scale": 1.0}), runs.of(v)) for v in scenes23(quick) if v["bending_scale"] != 1.0]
    changes = [on.speed.value / off.speed.value - 1.0 for on, off in pairs]
    return [
        Entry(
            "Fig. 23",
            "the correction by α = 1.09 'for the bending moment' improves the fit for a circular section",
            {"least": min(changes), "most": max(changes), "mean_change": float(np.mean(changes))},
            "bending itself changes V by {least:+.1%} to {most:+.1%} over these scenes, {mean_change:+.1%} in the mean",
            printed=(agrees("mean_change", ALPHA - 1.0, 0.03),),
            remarks=(at_least("least", 0.0),),
            differences={Verdict.DISAGREEMENT: "too far from a factor of 1.09{least:?|, and of either sign}"},
        )
    ]


def draw_ratios(panel: Any, xs: Sequence[float], found: list[Found], wave: str, colour: str, label: str) -> None:
    """V/C with one wave speed, with its error bars."""
    values, errors = [f.ratio(wave) for f in found], [f.speed.error / f.wave_speeds[wave] for f in found]
    panel.errorbar(xs, values, errors, fmt="o-", markersize=4, color=colour, label=label)


def draw_formula(panel: Any, strains: Any, angles: Any, wave: str) -> None:
    """The published formula, alone and with alpha, over the one of strain and half-angle (degrees) that is an array."""
    over_strain = np.ndim(strains) > 0
    xs = strains if over_strain else angles
    ys = np.array([published_ratio(s, math.radians(a)) for s, a in np.broadcast(strains, angles)])
    panel.plot(xs, ys, "k--", label="published formula")
    panel.plot(xs, ALPHA * ys, "k:", label=f"times {ALPHA}")
    panel.set(
        xlabel=f"strain ε (φ = {angles:g}°)" if over_strain else f"half-angle φ (°), ε = {strains:g}",
        ylabel=f"V/C with C = {WAVES[wave]}",
        title=f"against {'strain' if over_strain else 'the half-angle'}, C = {WAVES[wave]}",
    )
