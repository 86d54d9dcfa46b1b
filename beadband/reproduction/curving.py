"""Figure 19 and what is behind it: the decay of the tip curvature, its window and its prefactor."""

from __future__ import annotations

import numpy as np

from beadband.beam import at_rest_curvature, eq7_curvature
from beadband.reproduction.corner import HALF_ANGLES_DEG, prefactor
from beadband.reproduction.drawing import SERIES, Sheet
from beadband.reproduction.releases import PAPER
from beadband.reproduction.runs import Runs, Values
from beadband.reproduction.scorecard import CHOICE, DISAGREEMENT, Entry

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
        label="beam kink at rest (half)",
    )
    axes[0].axvspan(
        found.window.start_s * 1e3, found.window.end_s * 1e3, color="#efe6d5", zorder=0, label="self-similar window"
    )
    axes[0].set(xlabel="time (ms)", ylabel="curvature at the tip (1/m)", title="curvature over time")
    axes[0].legend(fontsize=8)
    grid = runs.all_of(scenes(quick)[1:])
    rows = []
    markers = {1.0e-3: "v", 2.0e-3: "o", 4.0e-3: "^"}
    for angle, colour in zip(_ANGLES, SERIES, strict=False):
        for thickness, marker in markers.items():
            chosen = [
                f
                for f in grid
                if f.values["half_angle_deg"] == angle and f.values["thickness_m"] == thickness and f.decay
            ]
            label = f"φ = {angle:g}°, h = {thickness * 1e3:g} mm"
            strains = [f.values["strain"] for f in chosen]
            decays = [f.decay for f in chosen if f.decay]
            if not decays:
                continue
            for panel, shown in (
                (axes[1], [d.exponent for d in decays]),
                (axes[2], [d.eq7_ratio for d in decays]),
            ):
                panel.errorbar(
                    strains,
                    [value.value for value in shown],
                    [value.error for value in shown],
                    fmt=marker + "-",
                    markersize=4,
                    linewidth=0.8,
                    color=colour,
                    label=label,
                )
    for f in grid:
        rows.append(
            {
                **f.values,
                "window_s": None if f.decay is None else [f.window.start_s, f.window.end_s],
                "exponent": f.decay.exponent.value if f.decay else None,
                "exponent_error": f.decay.exponent.error if f.decay else None,
                "eq7_ratio": f.decay.eq7_ratio.value if f.decay else None,
                "reason": f.no_decay,
            }
        )
    sheet.tables["curvature"] = rows
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
    held = [f for f in grid if f.decay]
    axes[3].plot(
        [f.values["half_angle_deg"] for f in held],
        [f.decay.eq7_ratio.value for f in held if f.decay],
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

    measured = [f for f in grid if f.decay]
    none = [f for f in grid if f.decay is None]
    exponents = np.array([f.decay.exponent.value for f in measured if f.decay])
    ratios = np.array([f.decay.eq7_ratio.value for f in measured if f.decay])
    decay = found.decay
    here = (
        "no window"
        if decay is None
        else (
            f"t^({decay.exponent.value:.2f} ± {decay.exponent.error:.2f}) from {found.window.start_s * 1e3:.3f} "
            f"to {found.window.end_s * 1e3:.3f} ms, {decay.eq7_ratio.value:.3f} of Eq. 7"
        )
    )
    late = (times > 0.3 * found.arrival) & (times < 0.8 * found.arrival)
    slope = float(np.polyfit(np.log(times[late]), np.log(found.tip_curvature[later][late]), 1)[0])
    return [
        Entry(
            "Fig. 19, κ ~ t^(−1/2)",
            "the tip curvature falls as t^(−1/2) until it is zero",
            f"{here}; between 0.3 and 0.8 t_f it falls as t^({slope:.2f}), for the residual tension pulls the "
            f"rear straight; over the grid the exponent in the window is {exponents.mean():.3f} ± "
            f"{exponents.std(ddof=1):.3f}",
            "t^(−1/2) in a window only: after h/c0, before t_x",
            DISAGREEMENT,
        ),
        Entry(
            "Eq. 7, prefactor",
            "(π − 2φ)/√(2π) (ρA/EI)^(1/4)",
            f"{ratios.min():.2f}–{ratios.max():.2f} of it over ε, φ and h. Without stretch a corner released "
            "at rest has "
            + ", ".join(f"{value.value:.3f} at φ = {angle:g}°" for angle, value in free.items())
            + ": the linear beam's ½ for small turning, and more for large, where the inertia of the legs holds it",
            "Eq. 7 imposes θ_sss(0) = 0 and small turning",
            DISAGREEMENT,
        ),
        Entry(
            "window of κ ~ t^(−1/2)",
            "not mentioned",
            f"{len(none)} of {len(grid)} scenes have none"
            + (
                ": "
                + ", ".join(sorted({f"ε = {f.values['strain']:g}, φ = {f.values['half_angle_deg']:g}°" for f in none}))
                if none
                else ""
            ),
            "it closes where the residual tension is felt before the held shape is forgotten: large φ and ε",
            CHOICE,
        ),
    ]
