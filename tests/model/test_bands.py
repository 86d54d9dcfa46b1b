"""Bands of one's own: sections, files of bands, labels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from beadband.cli import main
from beadband.errors import UsageError
from beadband.model.bands import CATALOGUE, read_bands
from beadband.model.scene import scene_of
from beadband.model.scenefile import read_scene, scene_text

BANDS = """
[latex]
circumference_m = 0.160
width_m = 3.1e-3
thickness_m = "1.2e-3 +/- 2%"
density_kg_m3 = 940
law = { name = "mooney-rivlin", c10_pa = 1.6e5, c01_pa = { value = 3e4, error = 2e3 } }

["O-ring, $70$ & more"]
circumference = 0.1
section = "circle"
thickness = 2e-3
density_kg_m3 = 1200
law = { name = "linear", modulus_pa = 2e6 }
"""


@pytest.fixture
def bands(tmp_path: Path) -> str:
    path = tmp_path / "my bands, $HOME & é.toml"
    path.write_text(BANDS, encoding="utf-8")
    return str(path)


def test_a_file_of_bands_is_a_catalogue(bands: str, capsys: pytest.CaptureFixture[str]) -> None:
    latex = scene_of({"band_file": bands, "band": "latex"})
    assert latex.band.modulus_pa == latex.band.rest_modulus_pa == pytest.approx(6.0 * 1.9e5)
    assert latex.errors == (("c01_pa", 2e3), ("thickness_m", pytest.approx(2.4e-5)))
    assert latex.label == "latex"
    ring = scene_of({"band_file": bands, "band": "O-ring, $70$ & more", "strain": 0.3})
    assert ring.band.section.kind == "circle"
    assert ring.material.name == "linear"
    assert scene_of({"band_file": bands, "band": "latex", "law": "linear"}).material.rest_modulus_pa == pytest.approx(
        1.14e6
    )
    assert main(["bands", "--file", bands]) == 0
    assert "O-ring, $70$ & more" in capsys.readouterr().out
    with pytest.raises(UsageError, match="unknown band"):
        scene_of({"band_file": bands, "band": "III"})


def test_a_scene_with_a_band_of_its_own_repeats_itself(bands: str, tmp_path: Path) -> None:
    for name in read_bands(bands):
        scene = scene_of({"band_file": bands, "band": name})
        (tmp_path / "scene.toml").write_text(scene_text(scene), encoding="utf-8")
        assert scene_of(read_scene(tmp_path / "scene.toml")) == scene


@pytest.mark.parametrize("text", ["", "x = 1", "[a]\nwidht_m = 1", "[a]\nlaw = 3", "[a", "[a]\ncircumference_m = 0.1"])
def test_files_that_hold_no_band_are_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "bands.toml"
    path.write_text(text)
    with pytest.raises(UsageError):
        scene_of({"band_file": str(path)})


def test_sections() -> None:
    def section(**values: Any) -> tuple[float, float]:
        band = scene_of(values).band
        return band.area_m2, band.second_moment_m4

    d, w = 2.0e-3, 4.0e-4
    inner = d - 2.0 * w
    assert section() == pytest.approx((3.2e-6, 1.6e-3 * d**3 / 12.0))
    assert section(section="square") == pytest.approx((d**2, d**4 / 12.0))
    assert section(section="circle") == pytest.approx((math.pi / 4.0 * d**2, math.pi / 64.0 * d**4))
    tube = (math.pi / 4.0 * (d**2 - inner**2), math.pi / 64.0 * (d**4 - inner**4))
    assert section(section="tube", wall_m=w) == pytest.approx(tube)
    assert section(section="tube", wall_m=d / 2.0) == pytest.approx(section(section="circle"))
    assert section(section="given", area_m2=3e-6, second_moment_m4=1e-12) == (3e-6, 1e-12)
    for wrong in ({"wall_m": w}, {"section": "tube"}, {"section": "tube", "wall_m": d}, {"section": "given"}):
        with pytest.raises(UsageError):
            section(**wrong)


@pytest.mark.parametrize(
    ("values", "label"),
    [
        ({}, "III"),
        ({"thickness_m": 1.9e-3}, "III, thickness 1.9 mm"),
        ({"thickness_m": 2.0e-3}, "III"),
        ({"c10_pa": 2e5, "density_kg_m3": 1000.0}, "III, density 1000 kg/m3, c10 0.2 MPa"),
        ({"section": "square"}, "III, section square"),
        (
            {"circumference_m": 0.18, "width_m": 3e-3, "thickness_m": 1e-3, "density_kg_m3": 930.0},
            "of 180 mm circumference",
        ),
    ],
)
def test_the_label_says_what_was_changed(values: dict[str, Any], label: str) -> None:
    assert scene_of(values).label == label


def test_the_catalogue_is_the_paper_s() -> None:
    assert list(CATALOGUE) == ["I", "II", "III", "IV", "circular"]
    assert CATALOGUE["circular"].circumference_m == math.pi * 0.064
    assert [round(band.rest_modulus_pa * 1e-6, 3) for band in CATALOGUE.values()] == [3.93, 1.494, 1.854, 1.896, 1.854]
