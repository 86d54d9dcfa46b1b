"""Figure 22: alpha of Eq. 10 with each wave speed and law, and with bending off, on, doubled and quadrupled."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.analysis.fits import Measured
from beadband.studies.reproduction.drawing import COLOURS, SERIES, Sheet
from beadband.studies.reproduction.runs import Found, Runs, Values
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, small
from beadband.studies.reproduction.speeds import ALPHA, BANDS, WAVES, scene

LAWS = ("mooney-rivlin", "linear")
_DRIFT = {"strain": (0.2, 0.476, 0.9, 1.3), "half-angle": (8.0, 14.0, 22.0)}
_GRID = [(strain, angle) for strain in _DRIFT["strain"] for angle in _DRIFT["half-angle"]]
_SCALES = (1e-4, 1.0, 2.0, 4.0)
"""Factors on EI: the first is as good as none."""


def scenes22(quick: bool) -> list[Values]:
    grid = [scene(band, s, a, law=law) for band in BANDS for law in LAWS for s, a in _GRID]
    scaled = [(s, a) for s, a in _GRID if a == 14.0] if quick else _GRID
    return grid + [
        scene(band, s, a, law=law, bending_scale=k)
        for k in _SCALES
        if k != 1.0
        for band in BANDS
        for law in LAWS
        for s, a in scaled
    ]


def fit_alpha(found: list[Found], wave: str) -> dict[str, float]:
    """alpha of V/C = alpha x (published ratio) by least squares through the origin, with its 95 % interval."""
    from scipy.stats import t as student

    x, y = np.array([f.published for f in found]), np.array([f.ratio(wave) for f in found])
    alpha = float(np.sum(x * y) / np.sum(x * x))
    residual = y - alpha * x
    error = math.sqrt(float(np.sum(residual**2)) / (len(x) - 1) / float(np.sum(x * x)))
    return {
        "alpha": alpha,
        "interval": float(student.ppf(0.975, len(x) - 1)) * error,
        "scenes": len(x),
        "least": min(f.alpha(wave) for f in found),
        "most": max(f.alpha(wave) for f in found),
    }


def fig22(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Fits of alpha with each wave speed and law, and with EI off, on, doubled and quadrupled."""
    base = {
        law: runs.all_of(v for v in scenes22(quick) if v["law"] == law and "bending_scale" not in v) for law in LAWS
    }
    fits = {law: {wave: fit_alpha(base[law], wave) for wave in WAVES} for law in LAWS}
    fits["both"] = {wave: fit_alpha(base[LAWS[0]] + base[LAWS[1]], wave) for wave in WAVES}
    by_band = {
        band: {
            law: {wave: fit_alpha([f for f in base[law] if f.values["band"] == band], wave)["alpha"] for wave in WAVES}
            for law in LAWS
        }
        for band in BANDS
    }
    # Bending switched: the same scenes for every factor, so that only EI differs.
    common = {_place(v) for v in scenes22(quick) if "bending_scale" in v}
    scaled: dict[float, dict[str, dict[str, float]]] = {}
    for factor in _SCALES:
        of_factor = [v for v in scenes22(quick) if v.get("bending_scale", 1.0) == factor and _place(v) in common]
        scaled[factor] = {
            law: {
                wave: fit_alpha(runs.all_of(v for v in of_factor if v["law"] == law), wave)["alpha"] for wave in WAVES
            }
            for law in LAWS
        }
    drift = {
        f"{law}, {name} {value:g}": {
            wave: float(np.mean([f.alpha(wave) for f in base[law] if f.values[key] == value])) for wave in WAVES
        }
        for law in LAWS
        for name, key in (("strain", "strain"), ("half-angle", "half_angle_deg"))
        for value in _DRIFT[name]
    }
    sheet.tables["alpha"] = {
        "fits": fits,
        "by_band": by_band,
        "bending_scale": {f"{k:g}": v for k, v in scaled.items()},
        "drift": drift,
    }

    figure, axes = sheet.axes(columns=3, width=4.8)
    for panel, wave in zip(axes[:2], ("bar", "rest"), strict=True):
        top = 0.0
        for law, marker in zip(LAWS, ("o", "s"), strict=True):
            for band in BANDS:
                found = [f for f in base[law] if f.values["band"] == band]
                panel.plot(
                    [f.published for f in found],
                    [f.ratio(wave) for f in found],
                    marker,
                    markersize=4,
                    color=COLOURS[band],
                    markerfacecolor="none" if law == "linear" else COLOURS[band],
                    label=f"{band}, {'MR' if law != 'linear' else law}",
                )
                top = max(top, *(f.published for f in found))
        fit = fits[LAWS[0]][wave]
        line = np.array([0.0, 1.05 * top])
        panel.plot(line, line, "k--", label="α = 1")
        panel.plot(line, ALPHA * line, "k:", label=f"α = {ALPHA}")
        panel.plot(
            line,
            fit["alpha"] * line,
            color=SERIES[0],
            linewidth=1.2,
            label=f"MR fit {fit['alpha']:.3f} ± {fit['interval']:.3f}",
        )
        panel.set(xlabel="published formula", ylabel=f"V/C, C = {WAVES[wave]}", title=f"C = {WAVES[wave]}")
        panel.legend(fontsize=7, ncols=2)
    for law, style in zip(LAWS, ("o-", "s--"), strict=True):
        for wave, colour in zip(WAVES, SERIES, strict=False):
            axes[2].plot(
                [0, 1, 2, 4],
                [scaled[k][law][wave] for k in _SCALES],
                style,
                color=colour,
                markersize=4,
                label=f"{WAVES[wave]}, {'MR' if law != 'linear' else law}",
            )
    axes[2].axhline(ALPHA, color="k", linestyle=":")
    axes[2].set(xlabel="EI over the band's own (0: × 10⁻⁴)", ylabel="fitted α", title="α with bending off, on, ×2, ×4")
    axes[2].set_ylim(None, 1.15 * axes[2].get_ylim()[1])  # room for the legend above the lines
    axes[2].legend(fontsize=7, ncols=2, loc="upper center")
    figure.suptitle("Fig. 22: α of Eq. 10 with each wave speed, and with bending changed")
    sheet.save(figure, "fig22")

    return _entries(fits, scaled, drift)


def _entries(fits: dict[str, Any], scaled: dict[float, Any], drift: dict[str, Any]) -> list[Entry]:
    """The verdicts on alpha: its value with each C, what bending does to it, and whether it is one number."""
    alphas = {
        f"{short}_{wave}": Measured(fits[law][wave]["alpha"], fits[law][wave]["interval"])
        for short, law in (("MR", "mooney-rivlin"), ("linear", "linear"))
        for wave in WAVES
    }
    rest = fits["mooney-rivlin"]["rest"]
    off, on, _, four = (scaled[factor]["mooney-rivlin"]["rest"] for factor in _SCALES)
    by_strain = {_key("strain", s): drift[f"mooney-rivlin, strain {s:g}"]["rest"] for s in _DRIFT["strain"]}
    by_angle = {_key("angle", a): drift[f"mooney-rivlin, half-angle {a:g}"]["rest"] for a in _DRIFT["half-angle"]}
    means = [*by_strain.values(), *by_angle.values()]
    return [
        Entry(
            "Fig. 22, Eq. 10",
            "α = 1.09 by linear fit",
            {
                "scenes": rest["scenes"],
                **alphas,
                "bar_off": alphas["MR_bar"].value - ALPHA,
                "rest_off": alphas["MR_rest"].value - ALPHA,
            },
            "over {scenes:.0f} Mooney–Rivlin scenes α = {MR_bar:±.3f} with √(E/ρ), {MR_rest:±.3f} with "
            "√(E0/ρ), {MR_front_horizontal:±.3f} with the front's horizontal speed; linear law: "
            "{linear_bar:±.3f}, {linear_rest:±.3f}, {linear_front_horizontal:±.3f}",
            printed=(agrees("MR_bar", ALPHA),),
            remarks=(agrees("MR_rest", ALPHA),),
            differences={
                Verdict.DISAGREEMENT: "√(E0/ρ) {MR_rest:?gives 1.09|does not give 1.09 either} "
                "({rest_off:+.3f}); the appendix's √(E/ρ) gives {bar_off:+.3f}"
            },
        ),
        Entry(
            "α as a bending effect",
            "α corrects for bending",
            {
                "by_bending": on / off - 1.0,
                "by_four_times_bending": four / off - 1.0,
                "least_by_C": min(alphas[f"MR_{wave}"].value for wave in WAVES),
                "most_by_C": max(alphas[f"MR_{wave}"].value for wave in WAVES),
            },
            "switching EI on changes α by {by_bending:+.2%}, quadrupling it by {by_four_times_bending:+.2%} "
            "(Mooney–Rivlin); the choice of C changes it from {least_by_C:.2f} to {most_by_C:.2f}",
            printed=(agrees("by_bending", ALPHA - 1.0, 0.03),),
            remarks=(small("by_four_times_bending", 0.02),),
            differences={
                Verdict.DISAGREEMENT: "α is {by_four_times_bending:?a choice of C together with the shape of "
                "the law, not bending|not bending of this size}"
            },
        ),
        Entry(
            "α as a constant",
            "one α for all scenes",
            {
                **by_strain,
                **by_angle,
                "spread_of_means": max(means) - min(means),
                "least": rest["least"],
                "most": rest["most"],
            },
            "Mooney–Rivlin, √(E0/ρ): "
            + ", ".join(f"{{{_key('strain', s)}:.3f}} at ε = {s:g}" for s in _DRIFT["strain"])
            + "; "
            + ", ".join(f"{{{_key('angle', a)}:.3f}} at φ = {a:g}°" for a in _DRIFT["half-angle"]),
            printed=(small("spread_of_means", 0.05),),
            differences={Verdict.DISAGREEMENT: "from {least:.2f} to {most:.2f} over the grid"},
        ),
    ]


def _key(name: str, value: float) -> str:
    """Name of a number of the entry: templates take no point in it."""
    return f"{name}_{value:g}".replace(".", "_")


def _place(values: Values) -> tuple[Any, ...]:
    return values["band"], values["law"], values["strain"], values["half_angle_deg"]
