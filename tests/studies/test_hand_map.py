"""The map over hands: the line between hit and not hit, its files, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.studies import hand_map
from beadband.studies.hand_map import HandPoint, LinePoint, values_of


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("map") / "hands"
    words = ["--hand-mass", "4e-4,6e-4,2e-2", "--hand-stiffness", "0,1000", "--quick", "--jobs", "1"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hand_map, "HALVINGS", 1)
        patch.setattr(hand_map, "QUICK_BEADS", 64)
        assert main(["launch-map", *words, "--out", str(folder)]) == 0
    return folder


def test_a_light_hand_escapes_and_a_spring_brings_it_back(written: Path) -> None:
    rows = list(csv.DictReader((written / "hand-map.csv").open()))
    hit = {(float(row["stiffness_n_m"]), float(row["mass_kg"])): row["hit"] for row in rows}
    assert hit == {(0.0, 4e-4): "False", (0.0, 6e-4): "True", (0.0, 2e-2): "True"} | {
        (1000.0, mass): "True" for mass in (4e-4, 6e-4, 2e-2)
    }
    speeds = [float(row["hit_speed_m_s"] or "nan") for row in rows]
    assert speeds[1] < 0.6 * speeds[2]
    # The line: around half of the mass of the band.
    (line,) = csv.DictReader((written / "hand-line.csv").open())
    assert float(line["stiffness_n_m"]) == 0.0
    assert 0.45 * 8.486e-4 < float(line["not_hit_kg"]) < float(line["hit_kg"]) < 0.72 * 8.486e-4
    assert float(line["hit_kg"]) / float(line["not_hit_kg"]) < 1.23
    assert (written / "hand-map.png").stat().st_size > 5000


def test_the_map_says_where_its_line_is() -> None:
    points = [
        HandPoint("III", mass, 0.0, 120, hit, None, 5.0 if hit else None) for mass, hit in ((1e-4, False), (1e-3, True))
    ]
    text = hand_map.summary(points, [LinePoint("III", 0.0, 0.00049, 0.0005)])
    assert text == "band III, 0 N/m: 1 of 2 hands are hit, at 5 to 5 m/s; from 0.495 g (+/- 1.0%)"
    json.dumps(hand_map.rows(points, []))


def test_a_launch_that_fails_is_a_point_with_its_code(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: HandPoint) -> HandPoint:
        raise RunError("the run failed", "diverged")

    monkeypatch.setattr(hand_map, "hand_point", fail)
    points, line = hand_map.hand_map([1e-2, 2e-2], jobs=1)
    assert {(one.reason_code, one.reason, one.hit) for one in points} == {("diverged", "the run failed", None)}
    assert line == []


def test_axes() -> None:
    assert values_of("hand_mass_kg", "1e-3:1e-1:3") == (1e-3, 1e-2, 1e-1)
    assert values_of("hand_stiffness_n_m", "0:10:3") == (0.0, 5.0, 10.0)
    assert values_of("hand_mass_kg", "0.02, 0.01") == (0.02, 0.01)
    for text in ("0,1", "1:2", "1:2:x", "1e-3:1:9999", "a"):
        with pytest.raises(UsageError):
            values_of("hand_mass_kg", text)
    with pytest.raises(UsageError, match="too large"):
        hand_map.hand_map([1e-2] * 100, [0.0] * 100)
    with pytest.raises(UsageError, match="unknown band"):
        hand_map.hand_map([1e-2], band="no such band")


def test_axes_without_masses_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["--hand-stiffness", "100"], ["--band", "II"]):
        assert main(["launch-map", *words]) == 2
        assert "not used without --hand-mass" in capsys.readouterr().err
