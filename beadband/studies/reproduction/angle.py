"""Figures 4 to 8 and Eqs. 1 to 5: the direction of the paper's beam, from its closed forms."""

from __future__ import annotations

import math

import numpy as np

from beadband.model import beam
from beadband.model.scene import scene_of
from beadband.studies.reproduction.closed_forms import (
    INSTANTS,
    PHI,
    PLACES,
    SPREAD,
    along_band,
    draw_along,
    draw_over_time,
    draw_surface,
    rate_ratio,
    theta,
)
from beadband.studies.reproduction.drawing import SERIES, Sheet
from beadband.studies.reproduction.runs import Runs
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, falls, rises, small

_SOLVED = 0.02
"""What :func:`beam.equation_defect` leaves of a solution at most."""


def fig4(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle along the band at three times."""
    title = "Fig. 4: direction along the band (Eq. 4)"
    draw_along(sheet, "fig4", theta, (1e-3, 2e-3, 3e-3), "direction θ (rad)", title)
    s = np.linspace(0.0, 0.1, 20001)
    angles = theta(s, 1e-3)
    forms = {"hypergeometric": (100.0, 0.0, 0.0, 0.0), "sine": (0.0, 1.0, 0.0, 0.0), "cosine": (0.0, 0.0, 1.0, 0.0)}
    defects = {
        form: beam.equation_defect(lambda s, t, c=c: beam.general_angle(s, t, SPREAD, c), PLACES, INSTANTS, SPREAD)  # type: ignore[misc]
        for form, c in forms.items()
    }
    # Derivatives of the angle at the tip, by central differences of the complement over the similarity variable.
    h = 0.01
    at = [float(beam.complement(i * h, PHI)) for i in range(-2, 3)]
    return [
        Entry(
            "Fig. 4",
            "θ(0, t) = π/2; θ 'increases' with s, then falls to zero and oscillates",
            {
                "slope_at_tip": float(along_band(theta, 1e-5, 1e-3)),
                "crossings_of_phi": int(np.count_nonzero(np.diff(np.sign(angles - PHI)))),
                "tip": float(angles[0]),
                "lowest": float(angles.min()),
                "xi": float(s[np.argmin(angles)]) / math.sqrt(SPREAD * 1e-3),
                "phi": PHI,
            },
            "θ {slope_at_tip:?increases|falls} from {tip:.4f} at once, to a minimum of {lowest:.3f} rad at ξ = "
            "{xi:.3f}, and {crossings_of_phi:?oscillates about|does not oscillate about} φ = {phi:.3f}",
            printed=(agrees("tip", math.pi / 2.0, 1e-6), rises("slope_at_tip"), at_least("crossings_of_phi", 3)),
            corrected=(agrees("tip", math.pi / 2.0, 1e-6), falls("slope_at_tip"), at_least("crossings_of_phi", 3)),
            differences={Verdict.MISPRINT: "the curves agree; the text's 'increases' does not"},
        ),
        Entry(
            "Eqs. 1, 2",
            "linear beam, EI θ_ssss + ρA θ_tt = 0",
            {
                "defect": beam.equation_defect(theta, PLACES, INSTANTS, SPREAD),
                "sine_over_turning": math.cos(PHI) / (math.pi / 2.0 - PHI),
            },
            "Eq. 4 {defect:?solves it, within|does not solve it:} {defect:.1%} (by differences). The tip turns "
            "by so much that its sine is {sine_over_turning:.3f} of the angle",
            printed=(small("defect", _SOLVED),),
            otherwise=(agrees("sine_over_turning", 1.0, 0.05),),
            differences={
                Verdict.CHOICE: "none within the linear beam; it leaves out the band's stretch and the large turning"
            },
        ),
        Entry(
            "Eq. 3",
            "general self-similar solution: 2F3, FresnelS, FresnelC, constant",
            defects,
            "Eq. 2 leaves {hypergeometric:.1%} of 2F3, {sine:.1%} of FresnelS, {cosine:.1%} of FresnelC "
            "(by differences)",
            printed=tuple(small(form, _SOLVED) for form in forms),
        ),
        Entry(
            "Eq. 4",
            "C1 = C2 = 0, C3 = 2φ − π, from θ_ss(0) = θ_sss(0) = 0",
            {
                "second_derivative": (at[1] - 2.0 * at[2] + at[3]) / h**2,
                "third_derivative": (at[4] - 2.0 * at[3] + 2.0 * at[1] - at[0]) / (2.0 * h**3),
                "at_rest_over_eq7": beam.at_rest_share(),
            },
            "the second and third derivatives by ξ at the tip are {second_derivative:.0e} and "
            "{third_derivative:.0e}; θ_sss(0) = 0 is a tip without force. A beam kink released at rest "
            "(FresnelC and FresnelS) has {at_rest_over_eq7:.4f} of this tip curvature",
            printed=(small("second_derivative", 1e-3), small("third_derivative", 1e-3)),
            otherwise=(agrees("at_rest_over_eq7", 1.0, 0.05),),
            differences={
                Verdict.CHOICE: "a release at rest has {at_rest_over_eq7:.3f} of the prefactor of κ without force"
            },
        ),
    ]


def fig5(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over time at four places."""
    title = "Fig. 5: direction over time (Eq. 4)"
    draw_over_time(sheet, "fig5", theta, (1e-12, 1e-4, 5e-3, 1e-2), "direction θ (rad)", title)
    return [
        Entry(
            "Fig. 5",
            "θ changes rapidly at first, then slowly",
            {
                "late_angle": float(theta(0.01, 1e3)),
                "right_angle": math.pi / 2.0,
                "early_over_late_rate": rate_ratio(theta, 0.01, (1e-4, 1e-3), (3e-3, 6e-3)),
            },
            "at 10 mm θ changes {early_over_late_rate:.0f} times as fast before 1 ms as after 3 ms; θ(10 mm, t "
            "→ ∞) = {late_angle:.4f}, π/2 = {right_angle:.4f}",
            printed=(at_least("early_over_late_rate", 2.0), agrees("late_angle", math.pi / 2.0, 0.01)),
        )
    ]


def fig6(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over place and time."""
    draw_surface(sheet, "fig6", theta, "θ (rad)", "Fig. 6: direction over place and time (Eq. 4)", 2e-4)
    s, t = np.meshgrid(np.linspace(0.0, 0.015, 161), np.linspace(2e-4, 5e-3, 161))
    return [
        Entry(
            "Fig. 6",
            "surface θ(s, t)",
            {"edge": float(np.abs(theta(s, t)[:, 0] - math.pi / 2.0).max()), "top": float(theta(s, t).max())},
            "drawn from Eq. 4: θ = π/2 at the tip to {edge:.0e}, and nowhere above {top:.4f}",
            printed=(small("edge", 1e-9), agrees("top", math.pi / 2.0, 1e-6)),
        )
    ]


def fig7(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over the similarity variable."""
    xi = np.linspace(0.0, 14.0, 1401)
    figure, (axes,) = sheet.axes()
    axes.plot(xi, math.pi / 2.0 - beam.complement(xi, PHI), color=SERIES[1], label="θ(ξ), Eq. 5")
    axes.axhline(PHI, color="#888888", linestyle="--", label="wedge φ")
    axes.set(xlabel="ξ = s/(a_b t)^½", ylabel="θ (rad)", title="Fig. 7: direction over the similarity variable")
    axes.legend()
    sheet.save(figure, "fig7")
    times = np.array([[1e-4], [1e-3], [5e-3]])
    return [
        Entry(
            "Fig. 7, Eq. 5",
            "θ depends on ξ alone",
            {"spread": float(np.ptp(theta(xi * np.sqrt(SPREAD * times), times), axis=0).max())},
            "at equal ξ the angles at 0.1, 1 and 5 ms {spread:?agree|differ}, to {spread:.0e} rad",
            printed=(small("spread", 1e-9),),
        )
    ]


def fig8(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Complementary angle and where it peaks."""
    xi = np.linspace(0.0, 14.0, 140001)
    values = beam.complement(xi, PHI)
    figure, (axes,) = sheet.axes()
    shown = xi[::100]
    axes.plot(shown, values[::100], color=SERIES[1], label="φ(ξ) = π/2 − θ")
    axes.plot(shown, beam.complement_slope(shown, PHI), color=SERIES[0], linewidth=1.0, label="φ'(ξ), with 1/√(2π)")
    axes.axvline(math.sqrt(2.0 * math.pi), color="#888888", linestyle="--", label="ξ = √(2π)")
    axes.set(xlabel="ξ", ylabel="rad", title="Fig. 8: complementary angle and its slope")
    axes.legend()
    sheet.save(figure, "fig8")
    peak = float(xi[np.argmax(values)])
    step = 1e-6
    slope = float((beam.complement(step, PHI) - beam.complement(-step, PHI)) / (2.0 * step))
    printed = (math.pi - 2.0 * PHI) / math.sqrt(math.pi)
    scenes = {law: scene_of({"law": law}) for law in ("mooney-rivlin", "linear")}
    residual = [scene.string.residual_strain for scene in scenes.values()]
    s = peak * math.sqrt(SPREAD * 1e-3)
    return [
        Entry(
            "Fig. 8",
            "maximum of φ(ξ) at ξ = √(2π) = 2.5066",
            {"peak": peak, "off": peak - math.sqrt(2.0 * math.pi)},
            "{peak:.4f}",
            printed=(agrees("peak", math.sqrt(2.0 * math.pi), 1e-3),),
            differences={Verdict.CONFIRMED: "{off:+.1e}"},
        ),
        Entry(
            "φ'(ξ)",
            f"(π − 2φ) cos(ξ²/4)/√π: {printed:.4f} at 0",
            {
                "slope": slope,
                "printed_over_slope": printed / slope,
                "with_root_two_pi_over_slope": float(beam.complement_slope(0.0, PHI)) / slope,
            },
            "the derivative of φ(ξ) at 0 is {slope:.4f} (by differences), of which the form with √(2π) gives "
            "{with_root_two_pi_over_slope:.4f}",
            printed=(agrees("printed_over_slope", 1.0, 1e-3),),
            corrected=(agrees("with_root_two_pi_over_slope", 1.0, 1e-3),),
            differences={Verdict.MISPRINT: "factor {printed_over_slope:.4f}; √2 = 1.4142"},
        ),
        Entry(
            "text at Fig. 8",
            "at the maximum the band has 'no bending moment and elastically retracts to its unstretched state'",
            {
                "curvature_over_tip": float(along_band(theta, s, 1e-3) / along_band(theta, 0.0, 1e-3)),
                "residual": residual[0],
                "linear_residual": residual[1],
                "residual_over_held_strain": min(residual) / scenes["linear"].strain,
            },
            "κ there is {curvature_over_tip:.0e} of that at the tip in the linear beam; the band behind the "
            "front keeps a residual strain ({residual:.4f} Mooney–Rivlin, {linear_residual:.4f} linear for "
            "Band III at ε = 0.476, φ = 14°), without which the kink could not travel",
            printed=(small("curvature_over_tip", 1e-3),),
            otherwise=(small("residual_over_held_strain", 0.01),),
            differences={Verdict.CHOICE: "residual tension neglected"},
        ),
    ]
