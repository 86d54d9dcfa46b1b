"""The appendix: is V/C a function of strain, half-angle and h/b?"""

from __future__ import annotations

from beadband.band import CATALOGUE
from beadband.reproduction.drawing import SERIES, Sheet
from beadband.reproduction.runs import Runs, Values
from beadband.reproduction.scorecard import CHOICE, CONFIRMED, DISAGREEMENT, Entry

_BAND = CATALOGUE["III"]


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
        "c10_pa": _BAND.c10_pa * modulus,
        "c01_pa": _BAND.c01_pa * modulus * c01,
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
    axes.axvline(1e-6, color="k", linestyle="--", label="1e-6")
    axes.set(
        xscale="log",
        xlabel="relative change of V/C, C = √(E/ρ)",
        title="Appendix: which groups V/C depends on",
        xlim=(1e-16, 1.0),
    )
    axes.invert_yaxis()
    axes.legend(loc="upper right", fontsize=8)
    sheet.save(figure, "appendix")
    scale = max(abs(changes[law]["size × 3, E × 2, ρ / 2"]) for law in changes)
    width = max(abs(changes[law]["width × 4 (h/b / 4)"]) for law in changes)
    around = changes["mooney-rivlin"]["circumference × 2 (h/Cb / 2)"]
    both = max(abs(changes[law]["thickness × 2, circumference × 2"]) for law in changes)
    speeds = runs.of(_values("mooney-rivlin")).wave_speeds
    return [
        Entry(
            "Appendix, C",
            "C = √(E/ρ), while the geometry of section 3.3 takes C as the speed at which the front nears the finger",
            f"for Band III √(E/ρ) = {speeds['bar']:.2f} m/s, √(E0/ρ) = {speeds['rest']:.2f} m/s and the front's "
            f"horizontal speed {speeds['front_horizontal']:.2f} m/s",
            f"factor {speeds['front_horizontal'] / speeds['bar']:.3f} between the two meanings",
            CHOICE,
        ),
        Entry(
            "Appendix, scaling",
            "V/C is the same for equal groups",
            f"size, E and ρ changed at will: V/C equal to {scale:.0e}",
            "none",
            CONFIRMED,
        ),
        Entry(
            "Appendix, Eq. 14",
            "V/C = f(ε, φ, h/b)",
            f"h/b changes nothing ({width:.0e}); h/Cb does ({around:+.2%} for twice the circumference) and is "
            f"missing from the list: with h and Cb doubled together V/C is equal to {both:.0e}; "
            f"with Mooney–Rivlin C01/C10 and E0/E belong to it too (C01 halved: {shape:+.1%})",
            "h/Cb for h/b, and the constants of the law",
            DISAGREEMENT,
        ),
    ]
