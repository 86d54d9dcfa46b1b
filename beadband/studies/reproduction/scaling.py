"""The appendix: is V/C a function of strain, half-angle and h/b?"""

from __future__ import annotations

from beadband.model.bands import CATALOGUE
from beadband.model.scene import scene_of
from beadband.studies.reproduction.drawing import SERIES, Sheet
from beadband.studies.reproduction.runs import Runs, Values
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, small

_BAND = CATALOGUE["III"]
_SAME = 1e-6
"""Relative change of V/C that is rounding."""


def _values(
    law: str,
    *,
    size: float = 1.0,
    modulus: float = 1.0,
    density: float = 1.0,
    around: float = 1.0,
    width: float = 1.0,
    thickness: float = 1.0,
    c01: float = 1.0,
) -> Values:
    assert _BAND.width_m is not None
    rubber = _BAND.rubber.values()
    constants = {"c10_pa": rubber["c10_pa"] * modulus, "c01_pa": rubber["c01_pa"] * modulus * c01}
    return {
        "band": "III",
        "law": law,
        "beads": 400,
        "for": "speed",
        "circumference_m": _BAND.circumference_m * size * around,
        "width_m": _BAND.width_m * size * width,
        "thickness_m": _BAND.thickness_m * size * thickness,
        "density_kg_m3": _BAND.density_kg_m3 * density,
        "modulus_pa": _BAND.modulus_pa * modulus,
        **(constants if law == "mooney-rivlin" else {}),
    }


_CASES = {
    "size × 3, E × 2, ρ / 2": {"size": 3.0, "modulus": 2.0, "density": 0.5},
    "width × 4 (h/b / 4)": {"width": 4.0},
    "circumference × 2 (h/Cb / 2)": {"around": 2.0},
    "thickness × 2 (h/Cb × 2)": {"thickness": 2.0},
    "thickness × 2, circumference × 2": {"thickness": 2.0, "around": 2.0},
}


def scenes(quick: bool) -> list[Values]:
    """The base scene and its variations, both laws, and one with another C01/C10."""
    laws = ("mooney-rivlin", "linear")
    return (
        [_values(law) for law in laws]
        + [_values(law, **case) for law in laws for case in _CASES.values()]
        + [_values("mooney-rivlin", c01=0.5)]
    )


def appendix(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Change of V/C under each variation, and the three meanings of C."""
    changes: dict[str, dict[str, float]] = {}
    for law in ("mooney-rivlin", "linear"):
        base = runs.of(_values(law)).ratio("bar")
        changes[law] = {name: runs.of(_values(law, **case)).ratio("bar") / base - 1.0 for name, case in _CASES.items()}
    shape = (
        runs.of(_values("mooney-rivlin", c01=0.5)).ratio("bar") / runs.of(_values("mooney-rivlin")).ratio("bar") - 1.0
    )
    changes["mooney-rivlin"]["C01 / 2"] = shape
    sheet.tables["scaling"] = changes
    figure, (axes,) = sheet.axes(width=8.0)
    for offset, (law, colour) in enumerate(zip(changes, (SERIES[1], SERIES[4]), strict=True)):
        names = list(changes[law])
        places = [i + 0.18 * (2 * offset - 1) for i in range(len(names))]
        axes.barh(places, [max(abs(changes[law][name]), 1e-16) for name in names], height=0.34, color=colour, label=law)
    axes.set_yticks(range(len(changes["mooney-rivlin"])), list(changes["mooney-rivlin"]))
    axes.axvline(_SAME, color="k", linestyle="--", label=f"{_SAME:g}")
    axes.set(
        xscale="log",
        xlabel="relative change of V/C, C = √(E/ρ)",
        title="Appendix: which groups V/C depends on",
        xlim=(1e-16, 1.0),
    )
    axes.invert_yaxis()
    axes.legend(loc="upper right", fontsize=8)
    sheet.save(figure, "appendix")
    largest = {name: max((changes[law][name] for law in changes), key=abs) for name in _CASES}
    waves = runs.of(_values("mooney-rivlin")).wave_speeds
    gentle = scene_of({"law": "linear", "strain": 0.01, "half_angle_deg": 2.0})
    gentle_waves = gentle.wave_speeds(gentle.string.front_speed_m_s)
    return [
        Entry(
            "Appendix, C",
            "C = √(E/ρ), while the geometry of section 3.3 takes C as the speed at which the front nears the finger",
            {
                **waves,
                "front_over_bar": waves["front_horizontal"] / waves["bar"],
                "front_over_bar_of_small_linear_strain": gentle_waves["front_horizontal"] / gentle_waves["bar"],
            },
            "for Band III √(E/ρ) = {bar:.2f} m/s, √(E0/ρ) = {rest:.2f} m/s and the front's horizontal speed "
            "{front_horizontal:.2f} m/s; the linear law at ε = 0.01, φ = 2° has "
            "{front_over_bar_of_small_linear_strain:.3f} √(E/ρ)",
            printed=(agrees("front_over_bar_of_small_linear_strain", 1.0, 0.02),),
            otherwise=(agrees("front_over_bar", 1.0, 0.02),),
            differences={Verdict.CHOICE: "factor {front_over_bar:.3f} between the two meanings"},
        ),
        Entry(
            "Appendix, scaling",
            "V/C is the same for equal groups",
            {"change": largest["size × 3, E × 2, ρ / 2"]},
            "size × 3, E × 2 and ρ / 2 change V/C by {change:.0e}",
            printed=(small("change", _SAME),),
        ),
        Entry(
            "Appendix, Eq. 14",
            "V/C = f(ε, φ, h/b)",
            {
                "by_width": largest["width × 4 (h/b / 4)"],
                "by_circumference": changes["mooney-rivlin"]["circumference × 2 (h/Cb / 2)"],
                "by_both": largest["thickness × 2, circumference × 2"],
                "by_C01": shape,
            },
            "h/b {by_width:?changes nothing|changes V/C} ({by_width:.0e}); h/Cb {by_circumference:?does "
            "not|does} ({by_circumference:+.2%} for twice the circumference); with h and Cb doubled together "
            "V/C changes by {by_both:.0e}; C01/C10 and E0/E {by_C01:?do not matter|matter too} (C01 halved: "
            "{by_C01:+.1%})",
            printed=(small("by_circumference", 1e-4), small("by_C01", 1e-4)),
            remarks=(small("by_width", _SAME),),
            differences={
                Verdict.DISAGREEMENT: "the list lacks {by_circumference:?nothing of the shape|h/Cb}{by_C01:?|, "
                "and the constants of the law}; h/b {by_width:?does not belong to it|belongs to it}"
            },
        ),
    ]
