"""The page of the peg says what runs say."""

from __future__ import annotations

import re

import pytest
from pages import DOCS

from beadband.model.peg import own_radius_m
from beadband.model.scene import scene_of
from beadband.runs.ask import ask

PAGE = (DOCS / "peg.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("band", ["I", "II", "III", "IV"])
def test_the_catalogue_is_that_of_runs(band: str) -> None:
    """Exact columns to their last digit, speeds within both bars."""
    line = re.findall(rf"^\| {band} \| (.*) \|$", PAGE, re.MULTILINE)[0]
    own, radius, sharp, blunt, *speeds, _ = line.split(" | ")
    scenes = [scene_of({"band": band, "tip_radius_m": r, "tolerance": 2e-3}) for r in (0.0, 5e-3)]
    point = scenes[0]
    assert float(own) == pytest.approx(
        1e3 * own_radius_m(point.strand(1), point.strain, point.half_angle_rad), abs=6e-4
    )
    assert [float(sharp), float(blunt)] == pytest.approx([one.scales.tip_sharpness for one in scenes], abs=6e-3)
    there = scene_of({"band": band, "tip_radius_m": 1e-3 * float(radius)})
    assert there.scales.tip_sharpness == pytest.approx(0.3, rel=3e-3)
    for scene, text in zip(scenes, speeds, strict=True):
        value, error = map(float, text.split(" ± "))
        found = ask(scene)
        assert abs(found.value - value) < found.error + error
