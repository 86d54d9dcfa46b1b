"""Figure 19 and what is behind it: the decay of the tip curvature, its window and its prefactor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from beadband.analysis.fits import Array, Measured
from beadband.model.beam import at_rest_curvature, eq7_curvature
from beadband.studies.reproduction.drawing import SERIES, Sheet
from beadband.studies.reproduction.releases import PAPER
from beadband.studies.reproduction.runs import Found, Runs, Values
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, rises
from beadband.studies.reproduction.sharp_tip import HALF_ANGLES_DEG, prefactor

_ANGLES = (5.0, 14.0, 25.0)


def scenes(quick: bool) -> list[Values]:
    """Strain, half-angle and thickness around the paper's case."""
    strains = (0.2, 0.476, 1.0) if quick else (0.1, 0.2, 0.3, 0.476, 0.7, 1.0, 1.3)
    thick = (1.0e-3, 2.0e-3) if quick else (1.0e-3, 2.0e-3, 4.0e-3)
    return [PAPER] + [
        {"band": "III", "strain": s, "half_angle_deg": a, "thickness_m": h}
        for s in strains
        for a in _ANGLES
        for h in thick
    ]


def fig19(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature over time with Eq. 7; exponent and prefactor over strain, angle and thickness."""
    found = runs.of(PAPER)
    later = found.times > 0.0
    times = found.times[later]
    figure, axes = sheet.axes(columns=4, width=4.2)
    eq7 = eq7_curvature(times, found.half_angle, found.diffusivity)
    axes[0].loglog(times * 1e3, found.tip_curvature[later], color=SERIES[1], linewidth=1.0, label="rear tip, Band III")
    axes[0].loglog(times * 1e3, eq7, "--", color=SERIES[0], label="Eq. 7")
    axes[0].loglog(
        times * 1e3,
        at_rest_curvature(times, found.half_angle, found.diffusivity),
        ":",
        color=SERIES[5],
        label="beam kink released at rest",
    )
    axes[0].axvspan(
        found.window.start_s * 1e3, found.window.end_s * 1e3, color="#efe6d5", zorder=0, label="self-similar window"
    )
    axes[0].set(xlabel="time (ms)", ylabel="curvature at the tip (1/m)", title="curvature over time")
    axes[0].legend(fontsize=8)
    grid = runs.all_of(scenes(quick)[1:])
    measured = [(f, f.decay) for f in grid if f.decay]
    markers = {1.0e-3: "v", 2.0e-3: "o", 4.0e-3: "^"}
    for angle, colour in zip(_ANGLES, SERIES, strict=False):
        for thickness, marker in markers.items():
            chosen = [
                (f.values["strain"], d.exponent, d.eq7_ratio)
                for f, d in measured
                if f.values["half_angle_deg"] == angle and f.values["thickness_m"] == thickness
            ]
            if not chosen:
                continue
            strains, *shown = zip(*chosen, strict=True)
            look = {"fmt": marker + "-", "markersize": 4, "linewidth": 0.8, "color": colour}
            for panel, values in zip(axes[1:3], shown, strict=True):
                label = f"φ = {angle:g}°, h = {thickness * 1e3:g} mm"
                panel.errorbar(strains, *zip(*values, strict=True), **look, label=label)
    sheet.tables["curvature"] = [
        {
            **f.values,
            "window_s": None if f.decay is None else [f.window.start_s, f.window.end_s],
            "exponent": f.decay.exponent.value if f.decay else None,
            "exponent_error": f.decay.exponent.error if f.decay else None,
            "eq7_ratio": f.decay.eq7_ratio.value if f.decay else None,
            "reason": f.no_decay,
        }
        for f in grid
    ]
    axes[1].axhline(-0.5, color="k", linestyle="--")
    axes[1].set(xlabel="strain ε", ylabel="exponent inside the window", title="exponent (claimed: −1/2)")
    axes[2].axhline(1.0, color="k", linestyle="--")
    axes[2].axhline(0.5, color="k", linestyle=":")
    axes[2].set(
        xlabel="strain ε", ylabel="κ over Eq. 7", title="prefactor (dashed Eq. 7, dotted at rest)", ylim=(0.4, 1.05)
    )
    axes[2].legend(fontsize=6, ncols=2, loc="upper right")
    free = {angle: prefactor(angle) for angle in HALF_ANGLES_DEG}
    sheet.tables["prefactor_without_stretch"] = {f"{angle:g}": value._asdict() for angle, value in free.items()}
    axes[3].errorbar(
        list(free),
        [value.value for value in free.values()],
        [value.error for value in free.values()],
        fmt="s-",
        color=SERIES[3],
        markersize=5,
        label="corner without stretch",
    )
    axes[3].plot(
        [f.values["half_angle_deg"] for f, _ in measured],
        [d.eq7_ratio.value for _, d in measured],
        "o",
        color=SERIES[1],
        markersize=3,
        label="stretched wedges",
    )
    axes[3].axhline(1.0, color="k", linestyle="--")
    axes[3].axhline(0.5, color="k", linestyle=":")
    axes[3].set(xlabel="half-angle φ (°)", title="prefactor against the turning", ylim=(0.4, 1.05), xlim=(0.0, 90.0))
    axes[3].legend(fontsize=7)
    figure.suptitle("Fig. 19: curvature at the rear tip")
    sheet.save(figure, "fig19")

    return _entries(found, grid, free)


def _entries(found: Found, grid: list[Found], free: dict[float, Measured]) -> list[Entry]:
    """The verdicts on the decay: at the paper's case, over the grid, and without stretch."""
    measured = [f.decay for f in grid if f.decay]
    with_window, without = ([f.values for f in grid if (f.decay is None) == lacks] for lacks in (False, True))
    exponents = np.array([d.exponent.value for d in measured])
    ratios = np.array([d.eq7_ratio.value for d in measured])
    late = (found.times > 0.3 * found.arrival) & (found.times < 0.8 * found.arrival)
    fit, covariance = np.polyfit(np.log(found.times[late]), np.log(found.tip_curvature[late]), 1, cov=True)
    nowhere = Measured(math.nan, math.nan)
    decay = found.decay
    gap = {
        key: _mean([v[key] for v in without]) - _mean([v[key] for v in with_window])
        for key in ("half_angle_deg", "strain")
    }
    places = sorted({f"ε = {v['strain']:g}, φ = {v['half_angle_deg']:g}°" for v in without})
    in_order = [value.value for _, value in sorted(free.items())]
    return [
        Entry(
            "Fig. 19, κ ~ t^(−1/2)",
            "the tip curvature falls as t^(−1/2) until it is zero",
            {
                "exponent_in_window": decay.exponent if decay else nowhere,
                "exponent_after_window": Measured(float(fit[0]), math.sqrt(float(covariance[0, 0]))),
                "exponent_over_grid": Measured(_mean(exponents), _scatter(exponents)),
                "from_ms": found.window.start_s * 1e3,
                "to_ms": found.window.end_s * 1e3,
                "of_eq7": decay.eq7_ratio if decay else nowhere,
            },
            (
                "t^({exponent_in_window:±.2f}) from {from_ms:.3f} to {to_ms:.3f} ms, {of_eq7:.3f} of Eq. 7"
                if decay
                else "no window"
            )
            + "; between 0.3 and 0.8 t_f it falls as t^({exponent_after_window:.2f}), "
            "{exponent_after_window:?as claimed|for the residual tension pulls the rear straight}"
            + ("; over the grid the exponent in the window is {exponent_over_grid:±.3f}" if measured else ""),
            printed=(agrees("exponent_after_window", -0.5, 0.1), agrees("exponent_in_window", -0.5, 0.1)),
            differences={
                Verdict.DISAGREEMENT: "t^(−1/2) {exponent_in_window:?in a window only: after h/c0, before "
                "t_x|not even in the window}"
            },
        ),
        Entry(
            "Eq. 7, prefactor",
            "(π − 2φ)/√(2π) (ρA/EI)^(1/4)",
            {
                "least": ratios.min(initial=math.inf),
                "most": ratios.max(initial=-math.inf),
                "mean_over_eq7": Measured(_mean(ratios), _scatter(ratios)),
                **{f"free_{angle:g}": value for angle, value in free.items()},
                "growth_with_turning": float(-np.diff(in_order).max()),
            },
            ("{least:.2f}–{most:.2f} of it over ε, φ and h" if measured else "no scene has a window")
            + ". Without stretch a corner released at rest has "
            + ", ".join(f"{{free_{angle:g}:.3f}} at φ = {angle:g}°" for angle in free)
            + ": the linear beam's ½ {free_85:?for small turning|is not reached}"
            "{growth_with_turning:?, and more for large, where the inertia of the legs holds it|}",
            printed=(agrees("mean_over_eq7", 1.0),),
            remarks=(agrees("free_85", 0.5, 0.02), rises("growth_with_turning")),
            differences={Verdict.DISAGREEMENT: "Eq. 7 imposes θ_sss(0) = 0 and small turning"},
        ),
        Entry(
            "window of κ ~ t^(−1/2)",
            "not mentioned",
            {
                "scenes_with_window": len(with_window),
                "scenes_without_window": len(without),
                "scenes": len(grid),
                "angle_gap": gap["half_angle_deg"],
                "strain_gap": gap["strain"],
            },
            "{scenes_without_window:.0f} of {scenes:.0f} scenes have none"
            + (": " + ", ".join(places) if places else ""),
            printed=(at_least("scenes_with_window", 1.0),),
            otherwise=(at_least("scenes_with_window", float(len(grid))),),
            remarks=(rises("angle_gap"), rises("strain_gap")),
            differences={
                Verdict.CHOICE: "it closes where the residual tension arrives before the held shape is "
                "forgotten: {angle_gap:?large|small} φ and {strain_gap:?large|small} ε"
            },
        ),
    ]


def _mean(values: Sequence[float] | Array) -> float:
    return float(np.mean(values)) if len(values) else math.nan


def _scatter(values: Array) -> float:
    return float(values.std(ddof=1)) if len(values) > 1 else math.nan
