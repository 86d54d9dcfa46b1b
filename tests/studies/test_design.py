"""Design studies: samples that fill their ranges, indices against exact ones and the linear budget, figures."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beadband
from beadband.cli import main
from beadband.errors import UsageError
from beadband.lammps.engine import Session
from beadband.model.figures import FIGURES, figures_of_scene
from beadband.model.launch_string import string_launch
from beadband.model.scene import scene_of
from beadband.runs.input_errors import budget_of
from beadband.studies.design.ranges import box_of, spans
from beadband.studies.design.values import closed
from beadband.studies.samples import unit_points
from beadband.studies.sweep.grid import grid_of


def test_samples_fill_the_box() -> None:
    """One point in each slice of a Latin hypercube; two in each of 16 x 16 cells of the first 512 Sobol' points."""
    square = unit_points("latin-hypercube", 50, 2, 3)
    assert np.array_equal(np.sort((square * 50).astype(int), axis=0), np.tile(np.arange(50)[:, None], 2))
    cells = (unit_points("sobol", 512, 2, 3) * 16).astype(int)
    assert set(np.bincount(cells[:, 0] * 16 + cells[:, 1], minlength=256)) == {2}


@pytest.mark.parametrize("kind", ["latin-hypercube", "sobol"])
def test_samples_of_a_sweep(kind: str) -> None:
    options = {"strain": "0.1:1.4", "law": "linear,mooney-rivlin", "half_angle": 12}
    first, again, other = (list(grid_of(options, 50, seed, kind).scenes()) for seed in (1, 1, 2))
    assert first == again != other
    strains = np.sort([values["strain"] for values in first])
    assert np.all(np.abs(strains - np.linspace(0.113, 1.387, 50)) < 0.06)
    assert [values["law"] for values in first].count("linear") in (24, 25, 26)
    assert {(values["half_angle_deg"], values["band"]) for values in first} == {(12.0, "III")}


def test_samples_that_make_no_sense_are_refused() -> None:
    with pytest.raises(UsageError, match="--sample is not used without --random"):
        grid_of({"strain": "0.1:1.4:3"}, sample="sobol")
    with pytest.raises(UsageError, match="unknown kind of sample"):
        grid_of({"strain": "0.1:1.4"}, 3, sample="halton")


def test_indices_of_a_product_of_powers() -> None:
    """A linear string has V = f(strain, angle) sqrt(E/density) exactly: the indices follow from four moments."""
    (e0, e1), (d0, d1) = (1e6, 3e6), (800.0, 1600.0)
    found = beadband.sensitivity(
        vary={"modulus": (e0, e1), "density": f"{d0}:{d1}"}, law="linear", bending_scale=0, points=8192
    )
    means = 2.0 / 3.0 * (e1**1.5 - e0**1.5) / (e1 - e0), 2.0 * (math.sqrt(d1) - math.sqrt(d0)) / (d1 - d0)
    squares = 0.5 * (e0 + e1), math.log(d1 / d0) / (d1 - d0)
    parts = [square / mean**2 - 1.0 for mean, square in zip(means, squares, strict=True)]
    whole = (1.0 + parts[0]) * (1.0 + parts[1]) - 1.0
    first, total = [one / whole for one in parts], [1.0 - one / whole for one in parts[::-1]]
    assert found.indices.first == pytest.approx(first, abs=1e-3)
    assert found.indices.total == pytest.approx(total, abs=1e-3)
    for at, (one, both) in enumerate(zip(first, total, strict=True)):
        assert found.indices.first_interval[at, 0] < one < found.indices.first_interval[at, 1]
        assert found.indices.total_interval[at, 0] < both < found.indices.total_interval[at, 1]
    assert (found.runs, found.error) == (0, 0.0)
    assert str(found) == f"rebound speed V: modulus {total[0]:.2f}, density {total[1]:.2f}"


def test_small_ranges_agree_with_the_linear_budget() -> None:
    """Derivatives from runs of legs, and indices from the formula: two ways to the same shares of the variance."""
    errors = {"strain": "0.476 +/- 0.004", "half_angle_deg": "14 +/- 1", "c10_pa": "1.87e5 +/- 3e3",
              "c01_pa": "1.22e5 +/- 3e3", "density_kg_m3": "1300 +/- 15", "thickness_m": "2e-3 +/- 5e-5"}  # fmt: skip
    with Session() as session:
        budget = budget_of(scene_of({**errors, "for": "speed"}), 17.3, session)
    assert budget is not None
    found = beadband.sensitivity(**errors)
    shares = dict(zip(budget.inputs.names, budget.shares, strict=True))
    assert {one.key for one in found.ranges} == shares.keys()
    for at, one in enumerate(found.ranges):
        assert found.indices.first[at] == pytest.approx(shares[one.key], abs=0.04), one.key
        assert found.indices.total[at] == pytest.approx(shares[one.key], abs=0.04), one.key
    assert found.deviation == pytest.approx(budget.speed_error_m_s, rel=0.05)


def test_what_bands_span() -> None:
    """The rubber of each band goes together: every scene has the constants of one of them."""
    box = box_of({}, spans(["I", "II", "III", "IV"]))
    values = box.at(unit_points("sobol", 64, len(box.ranges), 0))
    pairs = {(name, *beadband.CATALOGUE[name].rubber.values().values()) for name in ("I", "II", "III", "IV")}
    assert set(zip(values["band"], values["c10_pa"], values["c01_pa"], strict=True)) == pairs
    thickness = values["thickness_m"]
    assert 1.1e-3 <= thickness.min() < 1.2e-3 < 1.9e-3 < thickness.max() <= 2.0e-3


def test_figures_are_those_of_the_string_and_the_scene() -> None:
    scene = scene_of({"strain": 0.4, "half_angle_deg": 10.0})
    throw, found = string_launch(scene), figures_of_scene(scene)
    assert found["throw_momentum_n_s"] == throw.momentum_n_s
    assert found["throw_efficiency"] == pytest.approx(throw.efficiency, rel=1e-12)
    assert found["stored_energy_j"] == pytest.approx(throw.stored_j, rel=1e-12)
    assert found["pull_n"] == pytest.approx(2.0 * throw.tension_n * math.cos(math.radians(10.0)), rel=1e-12)
    many = closed({"strain": 0.4}, {"half_angle_deg": np.array([10.0, 35.0]), "band": np.array(["III", "III"])})
    assert found.pop("peak_strain") is None
    assert {key: float(many[key][0]) for key in FIGURES} == pytest.approx(found, rel=1e-12)
    assert figures_of_scene(scene_of({"half_angle_deg": 35.0}))["throw_speed_m_s"] is None
    assert np.isnan(many["throw_speed_m_s"][1])
    assert figures_of_scene(scene_of({"band": "IV"}))["peak_strain"] == pytest.approx(1.475, abs=1e-3)


@pytest.mark.parametrize(
    ("vary", "more", "said"),
    [
        ({"frames": "3:5"}, {}, "can't be varied"),
        ({"strain": "0.3"}, {}, "is given no range"),
        ({"strain": (0.5, 0.3)}, {}, "is empty"),
        ({"strain": "0.3:0.5"}, {"strain": 0.4}, "--strain is varied"),
        ({"strain": "0.3:0.5", "--strain": "0.4:0.6"}, {}, "varied twice"),
        ({"band": "III"}, {}, "nothing to choose from"),
        ({"strain": "0.3:1.6"}, {"band": "IV"}, "a scene without an answer.*tension peaks"),
        ({"width": "1e-3:2e-3"}, {}, "does not depend on what varies"),
        ({"half-angle": "20:40"}, {"quantity": "throw-speed"}, "no closed form"),
        ({"strain": "0.3:0.4"}, {"quantity": "colour"}, "unknown quantity"),
        ({"strain": "0.3:0.4"}, {"points": 100}, "power of 2"),
        ({"strain": "0.3:0.9"}, {"tolerance": 1e-5}, "does not reach the tolerance"),
        ({}, {}, "nothing varies"),
    ],
    ids=str,
)  # fmt: skip
def test_studies_that_make_no_sense_are_refused(vary: dict[str, Any], more: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        beadband.sensitivity(vary=vary, **more)


def test_the_command_writes_table_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sensitivity", "--spans", "I,III", "--vary", "strain=0.3:0.6", "--points", "256", "--seed", "5"]
    assert main([*command, "--out", str(tmp_path / "new")]) == 0
    said = capsys.readouterr().out
    assert "rubber" in said
    with (tmp_path / "new" / "sensitivity.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["input"]: row for row in csv.DictReader(file)}
    assert float(rows["strain"]["total_order"]) > 0.3 > float(rows["density_kg_m3"]["total_order"])
    stored = json.loads((tmp_path / "new" / "sensitivity.json").read_text(encoding="utf-8"))
    assert stored["scenes"] == 256 * (len(rows) + 2)
    assert (tmp_path / "new" / "sensitivity.png").read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--json", "--out", str(tmp_path / "again")]) == 0
    again = json.loads(capsys.readouterr().out)
    assert {**again, "seconds": 0.0} == {**stored, "seconds": 0.0}
    assert main(["sensitivity", "--vary", "strain", "--out", str(tmp_path / "none")]) == 2
    assert not (tmp_path / "none").exists()
