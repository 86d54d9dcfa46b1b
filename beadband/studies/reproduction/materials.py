"""Table 1 with what follows from it, and Figure 15: the stress-strain curves of the four bands."""

from __future__ import annotations

import math

import numpy as np

from beadband.model.bands import CATALOGUE, band_rows, catalogue_values
from beadband.studies.reproduction.drawing import COLOURS, Sheet
from beadband.studies.reproduction.releases import PAPER
from beadband.studies.reproduction.runs import Runs
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, falls, small

_BANDS = ("I", "II", "III", "IV")
_STRAIN = 0.476
_LARGEST_HELD = 1.3
"""Largest strain of the releases."""
LARGEST_STRAIN = 2.5
"""Right end of Fig. 15."""


def table1(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Table 1 with derived moduli, as a picture and in scorecard.json."""
    rows = band_rows(CATALOGUE.values())
    for row in rows:
        law = CATALOGUE[row["name"]].rubber
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
    by_band = {row["name"]: row for row in rows[:4]}
    peak = by_band["IV"]["peak_strain"]
    megapascals = {
        f"{name}_{band}": row[key] * 1e-6
        for name, key in (("rest", "rest_modulus_pa"), ("secant", "secant_modulus_pa"))
        for band, row in by_band.items()
    }
    paper, table = PAPER["thickness_m"] * 1e3, CATALOGUE["III"].thickness_m * 1e3
    return [
        Entry(
            "Table 1, moduli",
            "E = 1.5, 1.1, 1.1, 1.1 MPa beside C10 and C01 (unit not printed: MPa)",
            {
                **megapascals,
                "E_over_secant": by_band["III"]["modulus_pa"] / by_band["III"]["secant_modulus_pa"],
                "E0_over_E": by_band["III"]["rest_modulus_pa"] / by_band["III"]["modulus_pa"],
            },
            f"E0 = 6(C10 + C01) = {_listed('rest')} MPa; secant at ε = 0.476: {_listed('secant')} MPa",
            printed=(agrees("E_over_secant", 1.0, 0.1),),
            otherwise=(agrees("E0_over_E", 1.0, 0.1),),
            differences={
                Verdict.CHOICE: "two stiffnesses for one band: E of Band III is {E_over_secant:.2f} of its "
                "secant at 0.476, and its modulus at rest is {E0_over_E:.2f} E"
            },
        ),
        Entry(
            "Table 1, Band IV",
            "C10 = −0.024 MPa",
            {"peak_strain": math.inf if peak is None else peak},
            "the tension peaks at ε = {peak_strain:.4f}",
            printed=(at_least("peak_strain", _LARGEST_HELD),),
            otherwise=(at_least("peak_strain", LARGEST_STRAIN),),
            differences={Verdict.CHOICE: "no uniform hold beyond ε = {peak_strain:.3f}"},
        ),
        Entry(
            "Section 3.2, thickness",
            "h = 1.9 mm for Band III in the text, 2.0 mm in Table 1",
            {"difference_mm": paper - table},
            "both are run: Fig. 21 has the effect of a tenth of a millimetre",
            printed=(agrees("difference_mm", 0.0, 0.05),),
            corrected=(agrees("difference_mm", 0.0, 0.15),),
            differences={Verdict.MISPRINT: "{difference_mm:+.1f} mm, one unit of the last digit"},
        ),
    ]


def _listed(name: str) -> str:
    return ", ".join(f"{{{name}_{band}:.3f}}" for band in _BANDS)


def fig15(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Nominal stress of the four bands, Mooney-Rivlin and linear."""
    stretch = np.linspace(1.0, 1.0 + LARGEST_STRAIN, 501)
    figure, (axes,) = sheet.axes()
    stresses = {}
    for name in _BANDS:
        law = CATALOGUE[name].rubber
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
    form = {  # 2 (λ − 1/λ²)(C10 + C01/λ)
        name: 2.0 * (stretch - stretch**-2.0) * (known["c10_pa"] + known["c01_pa"] / stretch)
        for name, known in catalogue_values().items()
        if name in _BANDS
    }
    laws = {name: np.asarray(CATALOGUE[name].rubber.stress(stretch)) for name in _BANDS}
    return [
        Entry(
            "Fig. 15",
            "stress–strain curves of bands I–IV, two-parameter Mooney–Rivlin",
            {
                **stresses,
                "misfit": max(float(np.abs(laws[name] - form[name]).max() / form[name].max()) for name in _BANDS),
                "largest_bend": max(float(np.diff(s, 2).max() / np.ptp(s)) for s in laws.values()),
            },
            f"at ε = {_STRAIN}: {', '.join(f'{name} {{{name}:.3f}}' for name in _BANDS)} MPa; "
            "{largest_bend:?all concave, so unloading is a shock|not all concave}",
            printed=(small("misfit", 1e-9),),
            remarks=(falls("largest_bend"),),
            differences={Verdict.CONFIRMED: "the measured points are not in the text"},
        )
    ]
