"""Figures 4 to 14 and Eqs. 1 to 9: the paper's beam, drawn from its corrected closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband import beam
from beadband.band import CATALOGUE
from beadband.reproduction.drawing import SERIES, Sheet
from beadband.reproduction.runs import Runs
from beadband.reproduction.scorecard import CHOICE, CONFIRMED, MISPRINT, Entry
from beadband.scene import scene_of

# The paper's section 2: circular band, half-angle 11.6 degrees.
_BAND = CATALOGUE["circular"]
_PHI = math.radians(11.6)
_STIFFNESS = _BAND.modulus_pa * _BAND.second_moment_m4
_SPREAD = math.sqrt(_STIFFNESS / _BAND.mass_per_length_kg_m)
_REACH = np.linspace(0.0, 0.04, 1601)
_TIMES = np.geomspace(2e-5, 6e-3, 4000)


def _theta(s: Any, t: Any) -> Any:
    return beam.angle(s, t, _PHI, _SPREAD)


def _kappa(s: Any, t: Any) -> Any:
    return beam.curvature(s, t, _PHI, _SPREAD)


def _shear(s: Any, t: Any) -> Any:
    return beam.shear(s, t, _PHI, _SPREAD, _STIFFNESS)


def _over_length(sheet: Sheet, name: str, function: Any, times: tuple[float, ...], label: str, title: str) -> None:
    figure, (axes,) = sheet.axes()
    for time, colour in zip(times, SERIES, strict=False):
        axes.plot(_REACH * 1e3, function(_REACH, time), color=colour, label=f"t = {time * 1e3:g} ms")
    axes.set(xlabel="arc length from the tip s (mm)", ylabel=label, title=title, xlim=(0.0, 40.0))
    axes.legend()
    sheet.save(figure, name)


def _over_time(sheet: Sheet, name: str, function: Any, places: tuple[float, ...], label: str, title: str) -> None:
    figure, (axes,) = sheet.axes()
    for place, colour in zip(places, SERIES, strict=False):
        axes.plot(
            _TIMES * 1e3,
            function(place, _TIMES),
            color=colour,
            label=f"s = {place * 1e3:g} mm" if place > 1e-9 else "s = 0",
        )
    axes.set(xlabel="time t (ms)", ylabel=label, title=title, xscale="log", xlim=(0.02, 6.0))
    axes.legend()
    sheet.save(figure, name)


def _over_both(sheet: Sheet, name: str, function: Any, label: str, title: str, from_s: float) -> None:
    s, t = np.meshgrid(np.linspace(0.0, 0.015, 161), np.linspace(from_s, 5e-3, 161))
    figure, axes = sheet.surface()
    axes.plot_surface(s * 1e3, t * 1e3, function(s, t), cmap="viridis", linewidth=0, rcount=120, ccount=120)
    axes.set(xlabel="s (mm)", ylabel="t (ms)", zlabel=label, title=title)
    axes.view_init(elev=28, azim=-58)
    sheet.save(figure, name)


def fig4(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle along the band at three times."""
    _over_length(
        sheet, "fig4", _theta, (1e-3, 2e-3, 3e-3), "direction θ (rad)", "Fig. 4: direction along the band (Eq. 4)"
    )
    s = np.linspace(0.0, 0.1, 20001)
    low, first = float(_theta(s, 1e-3).min()), float(s[np.argmin(_theta(s, 1e-3))])
    xi = first / math.sqrt(_SPREAD * 1e-3)
    return [
        Entry(
            "Fig. 4",
            "θ(0, t) = π/2; θ 'increases' with s, then falls to zero and oscillates",
            f"θ falls from π/2 at once, to a minimum of {low:.3f} rad at ξ = {xi:.3f}, and oscillates about φ = "
            f"{_PHI:.3f}",
            "the curves agree; the text's 'increases' does not",
            MISPRINT,
        ),
        Entry(
            "Eqs. 1, 2",
            "linear beam, EI θ_ssss + ρA θ_tt = 0",
            "the self-similar forms satisfy it (tested by differences)",
            "none within the linear beam; the stretch of the band and the large turning are left out",
            CHOICE,
        ),
        Entry(
            "Eq. 3",
            "general self-similar solution: 2F3, FresnelS, FresnelC, constant",
            "all four satisfy Eq. 2 (tested)",
            "none",
            CONFIRMED,
        ),
        Entry(
            "Eq. 4",
            "C1 = C2 = 0, C3 = 2φ − π, from θ_ss(0) = θ_sss(0) = 0",
            "follows from these conditions; θ_sss(0) = 0 is a tip that feels no force. A beam kink released at rest "
            "(FresnelC and FresnelS) has exactly half of this tip curvature",
            "factor 2 in the prefactor of κ between the two releases",
            CHOICE,
        ),
    ]


def fig5(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over time at four places."""
    _over_time(
        sheet, "fig5", _theta, (1e-12, 1e-4, 5e-3, 1e-2), "direction θ (rad)", "Fig. 5: direction over time (Eq. 4)"
    )
    late = float(_theta(0.01, 1e3))
    return [
        Entry(
            "Fig. 5",
            "θ changes rapidly at first, then slowly",
            f"θ(10 mm, t → ∞) = {late:.4f} → π/2 = {math.pi / 2:.4f}",
            "none",
            CONFIRMED,
        )
    ]


def fig6(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over place and time."""
    _over_both(sheet, "fig6", _theta, "θ (rad)", "Fig. 6: direction over place and time (Eq. 4)", 2e-4)
    return [Entry("Fig. 6", "surface θ(s, t)", "drawn from Eq. 4", "none", CONFIRMED)]


def fig7(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Angle over the similarity variable."""
    xi = np.linspace(0.0, 14.0, 1401)
    figure, (axes,) = sheet.axes()
    axes.plot(xi, math.pi / 2.0 - beam.complement(xi, _PHI), color=SERIES[1], label="θ(ξ), Eq. 5")
    axes.axhline(_PHI, color="#888888", linestyle="--", label="wedge φ")
    axes.set(xlabel="ξ = s/(a_b t)^½", ylabel="θ (rad)", title="Fig. 7: direction over the similarity variable")
    axes.legend()
    sheet.save(figure, "fig7")
    return [Entry("Fig. 7, Eq. 5", "θ depends on ξ alone", "θ(s, t) at equal ξ agrees to rounding", "none", CONFIRMED)]


def fig8(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Complementary angle and where it peaks."""
    xi = np.linspace(0.0, 14.0, 140001)
    values = beam.complement(xi, _PHI)
    figure, (axes,) = sheet.axes()
    axes.plot(xi, values, color=SERIES[1], label="φ(ξ) = π/2 − θ")
    axes.plot(xi, beam.complement_slope(xi, _PHI), color=SERIES[0], linewidth=1.0, label="φ'(ξ), with 1/√(2π)")
    axes.axvline(math.sqrt(2.0 * math.pi), color="#888888", linestyle="--", label="ξ = √(2π)")
    axes.set(xlabel="ξ", ylabel="rad", title="Fig. 8: complementary angle and its slope")
    axes.legend()
    sheet.save(figure, "fig8")
    peak = float(xi[np.argmax(values)])
    step = 1e-6
    slope = float((beam.complement(step, _PHI) - beam.complement(-step, _PHI)) / (2.0 * step))
    printed = (math.pi - 2.0 * _PHI) / math.sqrt(math.pi)
    residual = [scene_of({"law": law}).string.residual_strain for law in ("mooney-rivlin", "linear")]
    return [
        Entry(
            "Fig. 8",
            "maximum of φ(ξ) at ξ = √(2π) = 2.5066",
            f"{peak:.4f}",
            f"{peak - math.sqrt(2 * math.pi):+.1e}",
            CONFIRMED,
        ),
        Entry(
            "φ'(ξ)",
            f"(π − 2φ) cos(ξ²/4)/√π: {printed:.4f} at 0",
            f"derivative of φ(ξ) at 0 is {slope:.4f}: 1/√(2π)",
            f"factor {printed / slope:.4f} = √2",
            MISPRINT,
        ),
        Entry(
            "text at Fig. 8",
            "at the maximum the band has 'no bending moment and elastically retracts to its unstretched state'",
            f"κ = 0 there in the linear beam; the band behind the front keeps a residual strain ({residual[0]:.4f} "
            f"Mooney–Rivlin, {residual[1]:.4f} linear for Band III at ε = 0.476, φ = 14°), without which the kink "
            "could not travel",
            "residual tension neglected",
            CHOICE,
        ),
    ]


def fig9(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature along the band at three times."""
    _over_length(
        sheet, "fig9", _kappa, (1e-3, 3e-3, 5e-3), "curvature κ (1/m)", "Fig. 9: curvature along the band (Eq. 6)"
    )
    ratio = float(_kappa(0.0, 1e-3) / _kappa(0.0, 4e-3))
    return [
        Entry(
            "Eq. 6",
            "κ ∝ t^(1/2) as printed",
            f"κ(0, 1 ms)/κ(0, 4 ms) = {ratio:.4f}: t^(−1/2)",
            "exponent of the wrong sign",
            MISPRINT,
        ),
        Entry(
            "Fig. 9",
            "κ changes more sharply with s, less with t",
            f"κ(0) = {_kappa(0.0, 1e-3):.1f}, {_kappa(0.0, 3e-3):.1f}, {_kappa(0.0, 5e-3):.1f} 1/m at 1, 3, 5 ms",
            "none",
            CONFIRMED,
        ),
    ]


def fig10(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature over time at two places."""
    _over_time(sheet, "fig10", _kappa, (1e-3, 1e-4), "curvature κ (1/m)", "Fig. 10: curvature over time (Eq. 6)")
    return [
        Entry(
            "Fig. 10",
            "κ falls steeply, then flat",
            f"κ(0.1 mm) = {_kappa(1e-4, 1e-4):.0f} at 0.1 ms, {_kappa(1e-4, 6e-3):.0f} 1/m at 6 ms",
            "none",
            CONFIRMED,
        )
    ]


def fig11(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Curvature over place and time."""
    _over_both(sheet, "fig11", _kappa, "κ (1/m)", "Fig. 11: curvature over place and time (Eq. 6)", 5e-4)
    return [
        Entry(
            "Fig. 11",
            "curvature is largest at the tip and 'finally decreases to zero'",
            "largest at s = 0; it tends to 0 as t^(−1/2) and never reaches it",
            "wording",
            CONFIRMED,
        )
    ]


def fig12(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force along the band at three times."""
    _over_length(
        sheet,
        "fig12",
        lambda s, t: _shear(s, t) * 1e3,
        (1e-3, 2e-3, 3e-3),
        "shear force Q (mN)",
        "Fig. 12: shear force along the band (Eq. 9)",
    )
    s, t, step = 4e-3, 1e-3, 1e-7
    slope = (
        beam.moment(s + step, t, _PHI, _SPREAD, _STIFFNESS) - beam.moment(s - step, t, _PHI, _SPREAD, _STIFFNESS)
    ) / (2 * step)
    ratio = float(_shear(s, t) / -slope)
    return [
        Entry("Eq. 8", "M = −EI ∂θ/∂s = EI κ", "follows from Eq. 6 with t^(−1/2)", "none", CONFIRMED),
        Entry(
            "Eq. 9",
            "Q = −∂M/∂s with the prefactor (2φ − π)/(2√(2π))",
            f"−∂M/∂s has the prefactor (π − 2φ)/(2√(2π)); ratio to the numerical derivative {ratio:.6f}",
            "sign",
            MISPRINT,
        ),
        Entry(
            "Fig. 12",
            "Q(0) = 0 and |Q| grows with s",
            f"Q(0) = {float(_shear(0.0, t)):.1f}; amplitude grows as s",
            "none",
            CONFIRMED,
        ),
    ]


def fig13(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force over time at two places."""
    _over_time(
        sheet,
        "fig13",
        lambda s, t: _shear(s, t) * 1e3,
        (1e-3, 2e-3),
        "shear force Q (mN)",
        "Fig. 13: shear force over time (Eq. 9)",
    )
    return [
        Entry(
            "Fig. 13",
            "Q changes sharply at first and fades",
            f"Q(2 mm) = {float(_shear(2e-3, 6e-3)) * 1e3:.3f} mN at 6 ms",
            "none",
            CONFIRMED,
        )
    ]


def fig14(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Shear force over place and time."""
    _over_both(
        sheet,
        "fig14",
        lambda s, t: _shear(s, t) * 1e3,
        "Q (mN)",
        "Fig. 14: shear force over place and time (Eq. 9)",
        5e-4,
    )
    return [Entry("Fig. 14", "surface Q(s, t)", "drawn from Eq. 9 with the sign of −∂M/∂s", "none", CONFIRMED)]
