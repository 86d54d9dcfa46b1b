"""Figures 9 to 14 and Eqs. 6, 8 and 9: curvature, moment and shear force of the paper's beam."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from beadband.studies.reproduction.closed_forms import (
    INSTANTS,
    PLACES,
    REACH,
    ROUNDING,
    STIFFNESS,
    along_band,
    draw_along,
    draw_over_time,
    draw_surface,
    kappa,
    misfit,
    moment,
    rate_ratio,
    shear,
    shear_mn,
    theta,
)
from beadband.studies.reproduction.drawing import Sheet
from beadband.studies.reproduction.runs import Runs
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, rises, small


def fig9(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature along the band at three times."""
    times = (1e-3, 3e-3, 5e-3)
    title = "Fig. 9: curvature along the band (Eq. 6)"
    draw_along(sheet, "fig9", kappa, times, "curvature κ (1/m)", title)
    ratio = float(along_band(theta, 0.0, 1e-3) / along_band(theta, 0.0, 4e-3))
    tip = [float(kappa(0.0, t)) for t in times]
    return [
        Entry(
            "Eq. 6",
            "κ ∝ t^(1/2) as printed",
            {"curvature_ratio": ratio, "exponent": -math.log(ratio) / math.log(4.0)},
            "−∂θ/∂s of Eq. 4 (by differences): κ(0, 1 ms)/κ(0, 4 ms) = {curvature_ratio:.4f}, t^({exponent:.3f})",
            printed=(agrees("exponent", 0.5, 0.01),),
            corrected=(agrees("exponent", -0.5, 0.01),),
            differences={Verdict.MISPRINT: "exponent of the wrong sign"},
        ),
        Entry(
            "Fig. 9",
            "κ changes more sharply with s, less with t",
            {
                **{f"tip_{round(t * 1e3)}ms": value for t, value in zip(times, tip, strict=True)},
                "change_with_s_over_change_with_t": float(np.ptp(kappa(REACH, 1e-3))) / (tip[0] - tip[-1]),
            },
            "κ(0) = {tip_1ms:.1f}, {tip_3ms:.1f}, {tip_5ms:.1f} 1/m at 1, 3, 5 ms; over s at 1 ms it changes "
            "by {change_with_s_over_change_with_t:.1f} times as much",
            printed=(at_least("change_with_s_over_change_with_t", 1.0),),
        ),
    ]


def fig10(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature over time at two places."""
    title = "Fig. 10: curvature over time (Eq. 6)"
    draw_over_time(sheet, "fig10", kappa, (1e-3, 1e-4), "curvature κ (1/m)", title)
    return [
        Entry(
            "Fig. 10",
            "κ falls steeply, then flat",
            {
                "early": float(kappa(1e-4, 1e-4)),
                "late": float(kappa(1e-4, 6e-3)),
                "early_over_late_rate": rate_ratio(kappa, 1e-4, (1e-4, 1e-3), (3e-3, 6e-3)),
                "fall": float(-np.diff(kappa(1e-4, np.geomspace(1e-4, 6e-3, 401))).max()),
            },
            "κ(0.1 mm) {fall:?falls steadily|does not fall steadily} from {early:.0f} at 0.1 ms to {late:.0f} "
            "1/m at 6 ms, {early_over_late_rate:.0f} times as fast before 1 ms as after 3 ms",
            printed=(rises("fall"), at_least("early_over_late_rate", 10.0)),
        )
    ]


def fig11(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature over place and time."""
    draw_surface(sheet, "fig11", kappa, "κ (1/m)", "Fig. 11: curvature over place and time (Eq. 6)", 5e-4)
    return [
        Entry(
            "Fig. 11",
            "curvature is largest at the tip and 'finally decreases to zero'",
            {
                "place_of_largest_mm": max(float(REACH[np.argmax(kappa(REACH, t))]) for t in (1e-3, 3e-3, 5e-3)) * 1e3,
                "tip_after_1000_s": float(kappa(0.0, 1e3)),
                "of_tip_at_1_ms": float(kappa(0.0, 1e3) / kappa(0.0, 1e-3)),
            },
            "largest at s = {place_of_largest_mm:.3g} mm; after 1000 s the tip has {of_tip_at_1_ms:.3%} of κ at 1 ms",
            printed=(small("place_of_largest_mm", 0.01), small("of_tip_at_1_ms", 0.01)),
            remarks=(rises("tip_after_1000_s"),),
            differences={Verdict.CONFIRMED: "wording: κ {tip_after_1000_s:?tends to zero and is never zero|is zero}"},
        )
    ]


def fig12(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force along the band at three times."""
    title = "Fig. 12: shear force along the band (Eq. 9)"
    draw_along(sheet, "fig12", shear_mn, (1e-3, 2e-3, 3e-3), "shear force Q (mN)", title)
    s, t = 4e-3, 1e-3
    slope = -float(along_band(moment, s, t))
    size = np.abs(shear(REACH, t))
    peaks = size[1:-1][(size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])]
    return [
        Entry(
            "Eq. 8",
            "M = −EI ∂θ/∂s = EI κ",
            {"misfit": misfit(moment(PLACES, INSTANTS), -STIFFNESS * along_band(theta, PLACES, INSTANTS))},
            "M of Eq. 6 with t^(−1/2) {misfit:?is|is not} −EI ∂θ/∂s by differences, to {misfit:.0e}",
            printed=(small("misfit", ROUNDING),),
        ),
        Entry(
            "Eq. 9",
            "Q = −∂M/∂s with the prefactor (2φ − π)/(2√(2π))",
            {"printed_over_slope": -float(shear(s, t)) / slope, "other_sign_over_slope": float(shear(s, t)) / slope},
            "over −∂M/∂s by differences the printed form is {printed_over_slope:.6f}, with (π − 2φ) "
            "{other_sign_over_slope:.6f}",
            printed=(agrees("printed_over_slope", 1.0, ROUNDING),),
            corrected=(agrees("other_sign_over_slope", 1.0, ROUNDING),),
            differences={Verdict.MISPRINT: "sign"},
        ),
        Entry(
            "Fig. 12",
            "Q(0) = 0 and |Q| grows with s",
            {
                "Q_at_tip": float(shear(0.0, t)),
                "least_growth": min(float(b / a) for a, b in pairwise(peaks)) - 1.0,
                "peaks": len(peaks),
            },
            "Q(0) = {Q_at_tip:.1f}; from each of {peaks:.0f} maxima of |Q| at 1 ms to the next it "
            "{least_growth:?grows|does not always grow}, by {least_growth:.1%} at least",
            printed=(small("Q_at_tip", 1e-12), rises("least_growth")),
        ),
    ]


def fig13(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force over time at two places."""
    title = "Fig. 13: shear force over time (Eq. 9)"
    draw_over_time(sheet, "fig13", shear_mn, (1e-3, 2e-3), "shear force Q (mN)", title)
    return [
        Entry(
            "Fig. 13",
            "Q changes sharply at first and fades",
            {
                "late_mn": float(shear_mn(2e-3, 6e-3)),
                "late_over_largest": float(shear(2e-3, 6e-3) / shear(2e-3, np.geomspace(2e-5, 6e-3, 4000)).max()),
                "early_over_late_rate": rate_ratio(shear, 2e-3, (1e-4, 1e-3), (3e-3, 6e-3)),
            },
            "Q(2 mm) = {late_mn:.3f} mN at 6 ms, {late_over_largest:.0e} of its largest; it changes "
            "{early_over_late_rate:.2g} times as fast before 1 ms as after 3 ms",
            printed=(at_least("early_over_late_rate", 10.0), small("late_over_largest", 0.05)),
        )
    ]


def fig14(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force over place and time."""
    draw_surface(sheet, "fig14", shear_mn, "Q (mN)", "Fig. 14: shear force over place and time (Eq. 9)", 5e-4)
    return [
        Entry(
            "Fig. 14",
            "surface Q(s, t)",
            {"misfit": misfit(shear(PLACES, INSTANTS), -along_band(moment, PLACES, INSTANTS))},
            "drawn with the sign of −∂M/∂s, from which it differs by {misfit:.0e} (by differences)",
            printed=(small("misfit", ROUNDING),),
        )
    ]
