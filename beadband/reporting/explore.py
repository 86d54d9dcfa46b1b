"""A page to play with: the numbers of ``beadband ask`` by formula, in one HTML file that needs no network.

The script computes the exact string limit and the correction for bending from the same tables as the program. Laws that
a script can't know, those of tests and plug-ins, are left out.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from beadband import __version__
from beadband.model import correction
from beadband.model.bands import CATALOGUE
from beadband.model.laws import LAWS
from beadband.model.scales import LONGEST_LAYER
from beadband.parameters import TABLE, defaults
from beadband.reporting.page import filled
from beadband.runs import folder as files

NAME = "explore.html"
_LAWS = ("linear", "mooney-rivlin", "neo-hookean", "yeoh", "gent")
"""Laws that the script has; the lists of the Ogden law would need a form of their own."""
_STARTS = {"mu_pa": 4e5, "jm": 50.0, "c1_pa": 2e5, "c2_pa": -2e3, "c3_pa": 100.0, "c10_pa": 1.87e5, "c01_pa": 1.22e5}
"""Constants that a law begins with where the band has none."""
_SIZES = ("circumference_m", "width_m", "thickness_m", "density_kg_m3", "modulus_pa")


def write(out: str | os.PathLike[str]) -> Path:
    """Write the page; UsageError when ``out`` can't be, RunError when the disk refuses."""
    path = files.outfile(out)
    files.write_text(path, page())
    return path


def page() -> str:
    """The page as text."""
    return filled("explore", tables())


def tables() -> dict[str, Any]:
    """What the script computes with: bands, laws, and the map of the correction."""
    chosen = defaults()
    return {
        "version": __version__,
        "default": chosen["band"],
        "strain": chosen["strain"],
        "half_angle_deg": chosen["half_angle_deg"],
        "longest_layer": LONGEST_LAYER,
        "bands": {
            name: {
                **{key: value for key, value in band.properties().items() if key in _SIZES},
                "section": band.section.kind,
                "law": band.rubber.name,
                "constants": band.rubber.values(),
            }
            for name, band in CATALOGUE.items()
        },
        "laws": {
            name: [
                {"key": one.key, "label": one.symbol or one.key, "unit": one.unit, "flag": TABLE[one.key].flag,
                 "start": _STARTS.get(one.key)}
                for one in LAWS[name].constants()
            ]
            for name in _LAWS
        },
        "flags": {key: TABLE[key].flag for key in _SIZES},
        "map": _short(correction.table("speed")),
    }  # fmt: skip


def _short(value: Any) -> Any:
    """Numbers to eight digits: the map's own errors are four orders larger."""
    return json.loads(json.dumps(value), parse_float=lambda number: float(f"{float(number):.8g}"))
