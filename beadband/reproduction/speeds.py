"""Figures 18, 21, 22 and 23: V/C against strain, angle, thickness and section; what alpha of Eq. 10 is made of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.reproduction.drawing import COLOURS, SERIES, Sheet
from beadband.reproduction.runs import Found, Runs, Values
from beadband.reproduction.scorecard import CHOICE, CONFIRMED, DISAGREEMENT, Entry
from beadband.wedge import published_ratio

BANDS = ("I", "II", "III", "IV")
LAWS = ("mooney-rivlin", "linear")
WAVES = {"bar": "√(E/ρ)", "rest": "√(E0/ρ)", "front_horizontal": "horizontal front"}
_STRAINS = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
_ANGLES = (5.0, 10.0, 14.0, 20.0, 25.0, 30.0)
_GRID = [(strain, angle) for strain in (0.2, 0.476, 0.9, 1.3) for angle in (8.0, 14.0, 22.0)]
_SCALES = (1e-4, 1.0, 2.0, 4.0)
"""Factors on EI: the first is as good as none."""


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
    for band in BANDS:
        for panel, wave in zip(axes[:2], ("bar", "rest"), strict=True):
            found = [runs.of(scene(band, s, 14.0)) for s in _STRAINS]
            panel.errorbar(
                _STRAINS,
                [f.ratio(wave) for f in found],
                [f.speed.error / f.wave_speeds[wave] for f in found],
                fmt="o-",
                markersize=4,
                color=COLOURS[band],
                label=f"band {band}",
            )
        found = [runs.of(scene(band, 0.476, a)) for a in _ANGLES]
        axes[2].errorbar(
            _ANGLES,
            [f.ratio("rest") for f in found],
            [f.speed.error / f.wave_speeds["rest"] for f in found],
            fmt="o-",
            markersize=4,
            color=COLOURS[band],
            label=f"band {band}",
        )
    fine = np.linspace(0.1, 1.3, 100)
    angles = np.linspace(4.0, 31.0, 100)
    for panel, wave in zip(axes[:2], ("bar", "rest"), strict=True):
        panel.plot(fine, [published_ratio(s, math.radians(14.0)) for s in fine], "k--", label="published formula")
        panel.plot(fine, [1.09 * published_ratio(s, math.radians(14.0)) for s in fine], "k:", label="times 1.09")
        panel.set(
            xlabel="strain ε (φ = 14°)",
            ylabel=f"V/C with C = {WAVES[wave]}",
            title=f"against strain, C = {WAVES[wave]}",
        )
    axes[2].plot(angles, [published_ratio(0.476, math.radians(a)) for a in angles], "k--", label="published formula")
    axes[2].set(xlabel="half-angle φ (°), ε = 0.476", ylabel="V/C with C = √(E0/ρ)", title="against the half-angle")
    axes[0].legend(fontsize=8)
    figure.suptitle("Fig. 18: rebound speed of bands I–IV (Mooney–Rivlin)")
    sheet.save(figure, "fig18")
    everything = runs.all_of(scenes18(quick))
    spread = {wave: (min(f.alpha(wave) for f in everything), max(f.alpha(wave) for f in everything)) for wave in WAVES}
    return [
        Entry(
            "Fig. 18",
            "simulation and experiment agree; V/C rises with ε and φ a little above the formula",
            f"V/C rises with both; over the formula it is {spread['bar'][0]:.2f}–{spread['bar'][1]:.2f} with "
            f"√(E/ρ), {spread['rest'][0]:.2f}–{spread['rest'][1]:.2f} with √(E0/ρ), "
            f"{spread['front_horizontal'][0]:.2f}–{spread['front_horizontal'][1]:.2f} with the front's horizontal "
            f"speed",
            "how far above depends on C; the experimental points are not in the text",
            CHOICE,
        )
    ]


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
    # Bending switched: the same scenes for every factor, so that nothing but EI differs.
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
        for name, key, choices in (
            ("strain", "strain", (0.2, 0.476, 0.9, 1.3)),
            ("half-angle", "half_angle_deg", (8.0, 14.0, 22.0)),
        )
        for value in choices
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
        panel.plot(line, 1.09 * line, "k:", label="α = 1.09")
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
    axes[2].axhline(1.09, color="k", linestyle=":")
    axes[2].set(xlabel="EI over the band's own (0: × 10⁻⁴)", ylabel="fitted α", title="α with bending off, on, ×2, ×4")
    axes[2].legend(fontsize=7)
    figure.suptitle("Fig. 22: α of Eq. 10 is set by the wave speed that V is divided by, hardly by bending")
    sheet.save(figure, "fig22")

    mr = fits["mooney-rivlin"]
    change = {wave: scaled[1.0]["mooney-rivlin"][wave] / scaled[1e-4]["mooney-rivlin"][wave] - 1.0 for wave in WAVES}
    four = scaled[4.0]["mooney-rivlin"]["rest"] / scaled[1e-4]["mooney-rivlin"]["rest"] - 1.0
    return [
        Entry(
            "Fig. 22, Eq. 10",
            "α = 1.09 by linear fit",
            f"over {mr['bar']['scenes']} Mooney–Rivlin scenes α = {_text(mr['bar'])} with √(E/ρ), "
            f"{_text(mr['rest'])} with √(E0/ρ), {_text(mr['front_horizontal'])} with the front's horizontal speed; "
            f"linear law: {_text(fits['linear']['bar'])}, {_text(fits['linear']['rest'])}, "
            f"{_text(fits['linear']['front_horizontal'])}",
            f"1.09 is what √(E0/ρ) gives ({mr['rest']['alpha'] - 1.09:+.3f}); the appendix's √(E/ρ) gives "
            f"{mr['bar']['alpha'] - 1.09:+.3f}",
            DISAGREEMENT,
        ),
        Entry(
            "α as a bending effect",
            "α corrects for bending",
            f"switching EI on changes α by {change['rest']:+.2%}, quadrupling it by {four:+.2%} (Mooney–Rivlin); "
            f"the choice of C changes it from {mr['front_horizontal']['alpha']:.2f} to {mr['bar']['alpha']:.2f}",
            "α is a choice of C together with the shape of the law, not bending",
            DISAGREEMENT,
        ),
        Entry(
            "α as a constant",
            "one α for all scenes",
            "Mooney–Rivlin, √(E0/ρ): "
            + ", ".join(
                f"{drift[f'mooney-rivlin, strain {s:g}']['rest']:.3f} at ε = {s:g}" for s in (0.2, 0.476, 0.9, 1.3)
            )
            + "; "
            + ", ".join(
                f"{drift[f'mooney-rivlin, half-angle {a:g}']['rest']:.3f} at φ = {a:g}°" for a in (8.0, 14.0, 22.0)
            ),
            f"from {mr['rest']['least']:.2f} to {mr['rest']['most']:.2f} over the grid",
            DISAGREEMENT,
        ),
    ]


def _place(values: Values) -> tuple[Any, ...]:
    return values["band"], values["law"], values["strain"], values["half_angle_deg"]


def _text(fit: dict[str, float]) -> str:
    return f"{fit['alpha']:.3f} ± {fit['interval']:.3f}"


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
    table = {float(h): float(v) for h, v in zip(thick, over, strict=True)}
    tenth = table[1.9e-3] / table[2.0e-3] - 1.0
    return [
        Entry(
            "Fig. 21",
            "h has little influence on V",
            f"V/V_string goes from {over[0]:.4f} at {thick[0] * 1e3:.1f} mm through a least {over.min():.4f} to "
            f"{over[-1]:.4f} at {thick[-1] * 1e3:.1f} mm (errors {errors.max():.4f} at most); 1.9 against 2.0 mm: "
            f"{tenth:+.2%}",
            f"{over.max() - over.min():.1%} over a decade",
            CONFIRMED,
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
            panel.errorbar(
                xs,
                [f.ratio("rest") for f in found],
                [f.speed.error / f.wave_speeds["rest"] for f in found],
                fmt="o-",
                markersize=4,
                color=colour,
                label=label,
            )
    fine, angles = np.linspace(0.1, 1.3, 100), np.linspace(4.0, 31.0, 100)
    for panel, line, ys in (
        (axes[0], fine, [published_ratio(s, math.radians(11.6)) for s in fine]),
        (axes[1], angles, [published_ratio(0.476, math.radians(a)) for a in angles]),
    ):
        panel.plot(line, ys, "k--", label="published formula")
        panel.plot(line, 1.09 * np.array(ys), "k:", label="times 1.09")
        panel.legend(fontsize=8)
    axes[0].set(xlabel="strain ε (φ = 11.6°)", ylabel="V/C with C = √(E0/ρ)", title="against strain")
    axes[1].set(xlabel="half-angle φ (°), ε = 0.476", ylabel="V/C with C = √(E0/ρ)", title="against the half-angle")
    figure.suptitle("Fig. 23: circular section")
    sheet.save(figure, "fig23")
    pairs = [(runs.of({**v, "bending_scale": 1.0}), runs.of(v)) for v in scenes23(quick) if v["bending_scale"] != 1.0]
    changes = [on.speed.value / off.speed.value - 1.0 for on, off in pairs]
    return [
        Entry(
            "Fig. 23",
            "the correction by α = 1.09 'for the bending moment' improves the fit for a circular section",
            f"bending itself changes V by {min(changes):+.1%} to {max(changes):+.1%} over these scenes",
            "too little for a factor of 1.09, and of either sign",
            DISAGREEMENT,
        )
    ]
