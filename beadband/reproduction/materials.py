"""Table 1 with what follows from it, and Figure 15: the stress-strain curves of the four bands."""

from __future__ import annotations

import numpy as np

from beadband.band import CATALOGUE
from beadband.law import law_of
from beadband.reproduction.drawing import COLOURS, Sheet
from beadband.reproduction.runs import Runs
from beadband.reproduction.scorecard import CHOICE, CONFIRMED, MISPRINT, Entry
from beadband.tables import band_rows

_BANDS = ("I", "II", "III", "IV")
_STRAIN = 0.476


def table1(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Table 1 with derived moduli, as a picture and in scorecard.json."""
    rows = band_rows()
    for row in rows:
        law = law_of("mooney-rivlin", CATALOGUE[row["name"]])
        row["secant_modulus_pa"] = float(law.stress(1.0 + _STRAIN)) / _STRAIN
    sheet.tables["table1"] = rows
    figure, (axes,) = sheet.axes(width=9.0, height=3.6)
    axes.axis("off")
    columns = (
        ("Cb (mm)", "circumference_m", 1e3, ".1f"),
        ("b (mm)", "width_m", 1e3, ".1f"),
        ("h (mm)", "thickness_m", 1e3, ".1f"),
        ("ρ (kg/m³)", "density_kg_m3", 1.0, ".0f"),
        ("E (MPa)", "modulus_pa", 1e-6, ".2f"),
        ("C10 (MPa)", "c10_pa", 1e-6, ".3f"),
        ("C01 (MPa)", "c01_pa", 1e-6, ".3f"),
        ("E0 (MPa)", "rest_modulus_pa", 1e-6, ".3f"),
        ("secant at 0.476 (MPa)", "secant_modulus_pa", 1e-6, ".3f"),
        ("peak strain", "peak_strain", 1.0, ".3f"),
    )
    cells = [
        ["–" if row[key] is None else f"{row[key] * factor:{form}}" for row in rows] for _, key, factor, form in columns
    ]
    table = axes.table(
        cells, rowLabels=[name for name, *_ in columns], colLabels=[row["name"] for row in rows], loc="center"
    )
    table.scale(1.0, 1.35)
    axes.set_title("Table 1 with derived moduli")
    sheet.save(figure, "table1")
    moduli = ", ".join(f"{row['rest_modulus_pa'] * 1e-6:.3f}" for row in rows[:4])
    secants = ", ".join(f"{row['secant_modulus_pa'] * 1e-6:.3f}" for row in rows[:4])
    peak = rows[3]["peak_strain"]
    return [
        Entry(
            "Table 1, moduli",
            "E = 1.5, 1.1, 1.1, 1.1 MPa beside C10 and C01 (unit not printed: MPa)",
            f"E0 = 6(C10 + C01) = {moduli} MPa; secant at ε = 0.476: {secants} MPa",
            "two stiffnesses for one band: E of Band III is near its secant at 0.476, not its modulus at rest",
            CHOICE,
        ),
        Entry(
            "Table 1, Band IV",
            "C10 = −0.024 MPa",
            f"tension peaks at ε = {peak:.4f}",
            f"no uniform hold beyond ε = {peak:.3f}",
            CHOICE,
        ),
        Entry(
            "Section 3.2, thickness",
            "h = 1.9 mm for Band III in the text, 2.0 mm in Table 1",
            "both run: see Fig. 21 for what a tenth of a millimetre does",
            "0.1 mm",
            MISPRINT,
        ),
    ]


def fig15(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Nominal stress of the four bands, Mooney-Rivlin and linear."""
    stretch = np.linspace(1.0, 3.5, 501)
    figure, (axes,) = sheet.axes()
    stresses = {}
    for name in _BANDS:
        law = law_of("mooney-rivlin", CATALOGUE[name])
        stress = np.asarray(law.stress(stretch)) * 1e-6
        stresses[name] = float(law.stress(1.0 + _STRAIN)) * 1e-6
        axes.plot(stretch - 1.0, stress, color=COLOURS[name], label=f"band {name}")
        axes.plot(
            stretch[:101] - 1.0,
            CATALOGUE[name].modulus_pa * 1e-6 * (stretch[:101] - 1.0),
            ":",
            color=COLOURS[name],
            linewidth=1.0,
        )
        peak = law.peak_stretch()
        if peak is not None:
            axes.plot(
                peak - 1.0, float(law.stress(peak)) * 1e-6, "v", color=COLOURS[name], label=f"tension peak of {name}"
            )
    axes.set(
        xlabel="strain", ylabel="nominal stress (MPa)", title="Fig. 15: Mooney–Rivlin (dotted: E ε with the table's E)"
    )
    axes.legend()
    sheet.save(figure, "fig15")
    text = ", ".join(f"{name} {value:.3f}" for name, value in stresses.items())
    return [
        Entry(
            "Fig. 15",
            "stress–strain curves of bands I–IV, two-parameter Mooney–Rivlin",
            f"at ε = 0.476: {text} MPa; all concave, so unloading is a shock",
            "the measured points are not in the text",
            CONFIRMED,
        )
    ]
