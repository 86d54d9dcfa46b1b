"""Design studies: samples that fill their ranges, indices against exact ones and the linear budget, figures."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beadband
from beadband.cli import main
from beadband.errors import UsageError
from beadband.lammps.engine import Session
from beadband.model.figures import FIGURES, figures, figures_of_scene
from beadband.model.launch_string import string_launch
from beadband.model.scene import scene_of
from beadband.runs.input_errors import budget_of
from beadband.studies.design import search
from beadband.studies.design.ranges import box_of, spans
from beadband.studies.design.values import closed, evaluate, quantity_of
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
    rubbers = {"c10_pa": np.array([-2.4e4, 1e5, -2e4]), "c01_pa": np.array([3.4e5, 2e5, 2e5]), "strain": 0.4}
    peaks = figures(scene_of({"strain": 0.4}), rubbers)["peak_strain"]
    for at, (c10, c01) in enumerate(zip(rubbers["c10_pa"], rubbers["c01_pa"], strict=True)):
        own = figures_of_scene(scene_of({"c10_pa": float(c10), "c01_pa": float(c01), "strain": 0.4}))["peak_strain"]
        assert peaks[at] == pytest.approx(np.nan if own is None else own, rel=1e-9, nan_ok=True)
    assert {key: float(many[key][0]) for key in FIGURES} == pytest.approx(found, rel=1e-12)
    assert figures_of_scene(scene_of({"half_angle_deg": 35.0}))["throw_speed_m_s"] is None
    assert np.isnan(many["throw_speed_m_s"][1])
    assert figures_of_scene(scene_of({"band": "IV"}))["peak_strain"] == pytest.approx(1.475, abs=1e-3)


def test_a_strip_has_neither_finger_nor_throw() -> None:
    """It is pulled at one end alone; the goal of a recoil speed under that pull is its exact solution."""
    strip, ring = ({"strain": 0.4, "shape": shape, "for": "speed"} for shape in ("strip", "ring"))
    found, other = figures_of_scene(scene_of(strip)), figures_of_scene(scene_of(ring))
    assert found["pull_n"] == found["tension_n"] == other["tension_n"]
    assert found["held_length_m"] == pytest.approx(1.4 * 0.204, rel=1e-12)
    assert found["finger_radius_m"] is found["throw_speed_m_s"] is None
    pulled = beadband.design("speed", shape="strip", vary={"strain": (0.2, 0.8)}, keep={"pull": (None, 1.5)})
    assert pulled.figures["tension_n"] == pytest.approx(1.5, rel=1e-4)
    exact = scene_of({**strip, "strain": pulled.values["strain"]}).string.rear_speed_m_s
    assert pulled.value == pytest.approx(exact, rel=1e-6)


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
        ({"strain": "0.3:0.9"}, {"tolerance": "auto"}, "one tolerance for all"),
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


def test_what_the_formula_does_not_reach_is_run() -> None:
    """Pegs and thick bands, in batches of legs or one by one: the same as asked for one by one."""
    values = {"circumference_m": np.array([0.204, 0.204, 0.06, 0.06]), "tip_radius_m": np.array([0.0, 1e-3, 0.0, 1e-3]),
              "thickness_m": np.array([2e-3, 2e-3, 6e-3, 3e-3])}  # fmt: skip
    found = evaluate({**values, "tolerance": 0.02}, quantity_of("speed"))
    assert found.by_run.tolist() == [False, True, True, True]
    for at in range(4):
        own = {key: float(one[at]) for key, one in values.items()}
        single = beadband.ask(**own, tolerance=0.02)
        assert abs(found.value[at] - single.value) <= found.error[at] + single.error
        assert found.error[at] <= 0.02 * found.value[at]


def test_figures_of_a_law_that_remembers_its_stretch() -> None:
    """Its stress on the way up is that of the first loading, whatever it unloads along."""
    softened = {"softening_r": 2.0, "softening_beta": 0.5}
    many = closed(softened, {"strain": np.array([0.3, 0.6])})
    for at, strain in enumerate((0.3, 0.6)):
        alone = figures_of_scene(scene_of({**softened, "strain": strain}))
        assert many["tension_n"][at] == alone["tension_n"]
        plain = figures_of_scene(scene_of({"strain": strain}))
        assert alone["tension_n"] == pytest.approx(plain["tension_n"], rel=1e-9)


# The best band for a goal


def test_a_search_by_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """A band too thick for the formula: fewer places and longer steps; V rises with the strain up to its end."""
    monkeypatch.setattr(search, "_LOOK", 8)
    found = beadband.design("speed", vary={"strain": (0.4, 0.7)}, circumference=0.06, thickness=6e-3)
    assert found.runs > 8
    assert found.values["strain"] == pytest.approx(0.7, rel=1e-6)
    assert found.slopes["strain"] == pytest.approx(0.75, abs=0.15)
    assert found.confirmed is not None
    assert found.confirmed.value == found.value


def test_the_best_band_is_that_of_a_grid() -> None:
    """Three inputs, an energy to be met and a pull not to be exceeded: the width follows from the energy."""
    keep = {"stored-energy": 0.1, "pull": ":2.5"}
    vary = {"strain": (0.2, 1.2), "half-angle": "5:25", "width": (5e-4, 4e-3)}
    found = beadband.design("speed", vary=vary, keep=keep, thickness=1e-3)
    strain, angle = (one.ravel() for one in np.meshgrid(np.linspace(0.2, 1.2, 161), np.linspace(5.0, 25.0, 81)))
    plain, columns = {"thickness_m": 1e-3, "width_m": 1e-3}, {"strain": strain, "half_angle_deg": angle}
    figures = closed(plain, columns)
    width = 1e-3 * 0.1 / figures["stored_energy_j"]
    pull = figures["pull_n"] * width / 1e-3
    met = (width >= 5e-4) & (width <= 4e-3) & (pull <= 2.5)
    speed = beadband.ask(tolerance=0.02, **plain, **columns).value
    best = np.argmax(np.where(met, speed, 0.0))
    # The grid's best is no better, but for the error with which conditions are met, and is next to it.
    assert speed[best] * (1.0 - 1e-5) <= found.value <= speed[best] * 1.01
    assert found.values["strain"] == pytest.approx(strain[best], abs=0.013)
    assert found.figures["stored_energy_j"] == pytest.approx(0.1, rel=1e-4)
    assert found.figures["pull_n"] <= 2.5 * (1.0 + 1e-4)
    assert found.confirmed is not None
    assert abs(found.confirmed.value - found.value) <= found.confirmed.error + found.error
    assert "--strain" in found.options
    assert "design-not-confirmed" not in {one.code for one in found.notices}


def test_a_linear_string_under_a_pull_and_a_mass() -> None:
    """V rises with the strain: pull and mass decide, strain = F density Cb/(2 m E cos(angle)), in closed form."""
    found = beadband.design(
        "speed", vary={"strain": "0.1:2", "width": "1e-4:5e-2"}, keep={"pull": ":4", "mass": "1e-3:"},
        law="linear", bending_scale=0,
    )  # fmt: skip
    band, phi = beadband.CATALOGUE["III"], math.radians(14.0)
    strain = 4.0 * band.density_kg_m3 * band.circumference_m / (2.0 * 1e-3 * band.modulus_pa * math.cos(phi))
    width = 1e-3 / (band.density_kg_m3 * band.thickness_m * band.circumference_m)
    assert found.values == pytest.approx({"strain": strain, "width_m": width}, rel=1e-5)
    string = scene_of({"law": "linear", "strain": strain}).string
    assert found.value == pytest.approx(string.rear_speed_m_s, rel=1e-5)
    assert not {one.code for one in found.notices} & {"design-on-bound", "design-at-edge", "design-indifferent"}


def test_what_a_design_says_of_its_optimum() -> None:
    """At an end of a range, next to scenes without an answer, or without effect."""
    found = beadband.design("speed", vary={"strain": (0.3, 0.6), "width": (1e-3, 2e-3), "band": ["II", "IV"]})
    codes = {one.code: one for one in found.notices}
    assert codes["design-on-bound"].values["name"] == "strain"
    assert codes["design-indifferent"].values["name"] == "width"
    assert found.values["band"] == "II"
    alone = beadband.ask(band="II", strain=0.6)
    assert found.value == pytest.approx(alone.value, rel=1e-6)
    edge = beadband.design("stored-energy", vary={"strain": (0.3, 3.0)}, band="IV")
    assert edge.values["strain"] == pytest.approx(1.475, abs=2e-3)
    assert "design-at-edge" in {one.code for one in edge.notices}
    least = beadband.design("mass", vary={"width": (1e-3, 5e-3)}, keep={"stored-energy": "0.1:"}, least=True)
    assert least.figures["stored_energy_j"] == pytest.approx(0.1, rel=1e-5)
    assert least.confirmed is None


def test_a_throw_is_run_with_bending() -> None:
    found = beadband.design("throw-speed", vary={"strain": (0.3, 0.6)}, keep={"tension": ":1.5"})
    assert found.confirmed is not None
    assert abs(found.confirmed.value - found.value) < found.error < 0.1 * found.value
    assert "throw-without-bending" in {one.code for one in found.notices}
    assert found.figures["tension_n"] == pytest.approx(1.5, rel=1e-4)


def test_the_command_and_what_it_refuses(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["design", "--goal", "speed", "--vary", "strain=0.2:1.2"]
    assert main([*command, "--keep", "stored-energy=0.1", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["inputs"][0]["value"] == pytest.approx(0.4818, abs=1e-3)
    assert said["run"]["value"] == pytest.approx(said["value"], abs=said["error"] + said["run"]["error"])
    assert main([*command, "--keep", "pull=:2"]) == 0
    assert "kept: pull at most 2 N" in capsys.readouterr().out
    for wrong, why in (
        (["--keep", "stored-energy=50"], "can't be met together in these ranges.*stored-energy from 0.02"),
        (["--keep", "stored-energy=a"], "is given no condition"),
        (["--keep", "colour=3"], "unknown quantity"),
        (["--keep", "mass"], "--keep names no value"),
        (["--strain", "0.3"], "--strain is varied"),
    ):
        assert main([*command, *wrong]) == 2
        assert re.search(why, capsys.readouterr().err)
    assert main(["design", "--goal", "speed", "--vary", "strain=0.4 +/- 0.1"]) == 2
    with pytest.raises(UsageError, match="does not use errors of inputs"):
        beadband.design("speed", vary={"strain": (0.3, 0.6)}, thickness="2e-3 +/- 5e-5")
    assert main(["design", "--goal", "speed", "--vary", "band=I,II"]) == 2
    assert main(["design", "--goal", "speed", "--vary", "half-angle=50:80"]) == 2
    assert "no scene in the ranges has an answer" in capsys.readouterr().err
