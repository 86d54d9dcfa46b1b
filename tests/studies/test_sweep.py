"""A sweep: the same rows however it is run, whatever is killed, and what it says of the paper's formula."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import beadband
from beadband.errors import UsageError
from beadband.lammps.engine import Session, program
from beadband.model.scene import scene_of
from beadband.observables import forget, observable
from beadband.planning.plan import plan_of
from beadband.reporting import summary as printed
from beadband.runs import results
from beadband.runs.rear_run import follow_rear
from beadband.studies.sweep import Swept, rungs, summary
from beadband.studies.sweep.grid import grid_of, read_grid
from beadband.studies.sweep.store import MANIFEST, SUMMARY, TABLE, Store
from beadband.studies.sweep.summary import Line
from conftest import REQUIRE_ALL

OPTIONS = {"band": "I,IV", "strain": "0.4:1.6:3", "law": "mooney-rivlin,linear", "tolerance": 0.02, "by": "runs"}
FLAGS = ["--band", "I,IV", "--strain", "0.4:1.6:3", "--law", "mooney-rivlin,linear"]
FLAGS += ["--tolerance", "0.02", "--by", "runs"]


def command(*words: str) -> list[str]:
    return [sys.executable, "-m", "beadband", *words]


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sweep") / "a folder, $HOME é"
    beadband.sweep(out=folder, jobs=1, **OPTIONS)
    return folder


def test_ranges_lists_and_single_values() -> None:
    grid = grid_of({"strain": "0.1:1.4:14", "band": "I, III", "half_angle_deg": [10, 20.5], "beads": "100:400:4"})
    values = {axis.key: axis.values for axis in grid.axes}
    assert values["strain"][0] == 0.1
    assert values["strain"][-1] == 1.4
    assert np.diff(values["strain"]) == pytest.approx(np.full(13, 0.1), rel=1e-9)
    assert values["band"] == ("I", "III")
    assert values["half_angle_deg"] == (10.0, 20.5)
    assert values["beads"] == (100, 200, 300, 400)
    assert values["for"] == ("speed",)
    assert len(grid) == len(list(grid.scenes())) == 14 * 2 * 2 * 4


def test_whole_numbers_may_be_written_with_an_exponent() -> None:
    axes = {axis.key: axis.values for axis in grid_of({"beads": "1e3,120", "strain": "0.1:0.2:1e1"}).axes}
    assert axes["beads"] == (1000, 120)
    assert len(axes["strain"]) == 10


def test_random_draws_are_in_range_and_repeat_with_their_seed() -> None:
    options = {"strain": "0.1:1.4", "law": "linear,mooney-rivlin"}
    first, again, other = (list(grid_of(options, 50, seed).scenes()) for seed in (1, 1, 2))
    assert first == again != other
    strains = [values["strain"] for values in first]
    assert 0.1 <= min(strains) < 0.4 < 1.1 < max(strains) <= 1.4
    assert {values["law"] for values in first} == {"linear", "mooney-rivlin"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"strain": "0.1:1.4"}, "FIRST:LAST:COUNT"),
        ({"strain": "a"}, "not a number"),
        ({"strain": "0.1:0.2:0"}, "FIRST:LAST:COUNT"),
        ({"strain": []}, "no value"),
        ({"band": "V"}, "unknown band"),
        ({"frames": 3}, "is not used by 'beadband sweep'"),
        ({"until": "launch"}, "is not used by 'beadband sweep'"),
        ({"finger": "clears"}, "is not used by 'beadband sweep'"),
        ({"strain": float("nan")}, "out of range"),
        ({"beads": 100.5}, "a whole number"),
        ({"strain": "0.1:1:100000", "half_angle_deg": "1:2:100000"}, "too large"),
    ],
)
def test_bad_grids_are_refused_in_one_line(options: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        grid_of(options)


def test_grid_from_toml(tmp_path: Path) -> None:
    path = tmp_path / "grid.toml"
    path.write_text('strain = "0.1:0.3:3"\nband = ["I", "II"]\nhalf_angle_deg = 14\n')
    assert len(grid_of(read_grid(path))) == 6
    path.write_text("strain = [")
    with pytest.raises(UsageError, match="can't be read"):
        read_grid(path)


def test_rows_are_what_single_releases_give(table: Path) -> None:
    rows = list(csv.DictReader((table / TABLE).open(encoding="utf-8")))
    assert len(rows) == 12
    with Session() as session:
        for row in rows[:3]:
            scene = scene_of(
                {
                    "band": row["band"],
                    "law": row["law"],
                    "strain": float(row["strain"]),
                    "tolerance": 0.02,
                    "for": "speed",
                }
            )
            alone = follow_rear(plan_of(scene, "leg"), session).fitted_speed_m_s.value
            assert float(row["rebound_speed_m_s"]) == alone
            assert float(row["alpha_rest"]) == pytest.approx(
                alone / scene.band.rest_speed_m_s / scene.published_ratio, rel=1e-12
            )


def test_scenes_without_an_answer_are_rows_with_a_reason(table: Path) -> None:
    rows = list(csv.DictReader((table / TABLE).open(encoding="utf-8")))
    refused = [row for row in rows if row["status"] == "refused"]
    assert [(row["band"], row["strain"], row["law"]) for row in refused] == [("IV", "1.6", "mooney-rivlin")]
    assert "tension peaks" in refused[0]["reason"]
    assert refused[0]["rebound_speed_m_s"] == refused[0]["within_tolerance"] == ""
    assert refused[0]["reason_code"] == "usage"


def test_errors_above_the_tolerance_are_marked_and_counted(table: Path) -> None:
    rows = list(csv.DictReader((table / TABLE).open(encoding="utf-8")))
    done = [row for row in rows if row["status"] == "done"]
    shares = [float(row["rebound_speed_error_m_s"]) / float(row["rebound_speed_m_s"]) for row in done]
    assert [row["within_tolerance"] for row in done] == ["yes" if share <= 0.02 else "no" for share in shares]
    totals = json.loads((table / SUMMARY).read_text())
    above = sum(share > 0.02 for share in shares)
    assert totals["above_tolerance"] == above > 0
    assert totals["relative_error"] == {"median": float(np.median(shares)), "largest": max(shares)}
    text = printed.sweep(totals)
    assert f"in {above} of 11 finished scenes above the tolerance" in text


def test_a_release_without_a_finite_speed_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "joined_error_m_s", lambda *_: math.nan)
    (row,) = beadband.sweep(strain=0.4, tolerance=0.02, by="runs").rows
    assert (row["status"], row["reason_code"]) == ("failed", "not-finite")


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, partial(ProcessPoolExecutor, mp_context=get_context("spawn"))])
def test_a_given_executor_gives_the_same_bytes(table: Path, tmp_path: Path, kind: Callable[[int], Executor]) -> None:
    with kind(2) as executor:
        beadband.sweep(out=tmp_path / "given", executor=executor, jobs=2, **OPTIONS)
    assert (tmp_path / "given" / TABLE).read_bytes() == (table / TABLE).read_bytes()


def test_speeds_are_the_strings_within_a_few_per_cent(table: Path) -> None:
    """Band IV is long and thin: bending hardly matters to V, and the string's is exact."""
    for row in csv.DictReader((table / TABLE).open(encoding="utf-8")):
        if row["band"] == "IV" and row["status"] == "done":
            assert float(row["rebound_speed_m_s"]) == pytest.approx(float(row["string_speed_m_s"]), rel=0.03)


def test_two_jobs_give_the_same_bytes(table: Path, tmp_path: Path) -> None:
    subprocess.run(command("sweep", *FLAGS, "--jobs", "2", "--out", str(tmp_path / "two")), check=True)
    assert (tmp_path / "two" / TABLE).read_bytes() == (table / TABLE).read_bytes()
    totals = json.loads((tmp_path / "two" / SUMMARY).read_text())
    assert totals["status"] == {"done": 11, "refused": 1}
    assert totals["run"]["jobs"] == 2


def test_two_ranks_give_the_same_bytes(table: Path, tmp_path: Path) -> None:
    if not REQUIRE_ALL:
        pytest.importorskip("mpi4py", reason="sweeping over ranks needs mpi4py")
    mpirun = program("mpirun")
    assert mpirun is not None
    words = command("sweep", *FLAGS, "--out", str(tmp_path / "ranks"))
    subprocess.run([mpirun, "-np", "2", *words], check=True, stdout=subprocess.DEVNULL)
    assert (tmp_path / "ranks" / TABLE).read_bytes() == (table / TABLE).read_bytes()


def test_a_cut_table_is_finished_without_repeating_rows(table: Path, tmp_path: Path) -> None:
    whole = (table / TABLE).read_bytes()
    folder = tmp_path / "cut"
    folder.mkdir()
    (folder / TABLE).write_bytes(whole[: int(0.6 * len(whole))])  # within a row
    kept = whole[: int(0.6 * len(whole))].count(b"\n") - 1
    again = beadband.sweep(out=folder, **OPTIONS)
    assert (folder / TABLE).read_bytes() == whole
    assert again.summary["run"]["released"] == 12 - kept


def test_a_killed_sweep_goes_on(table: Path, tmp_path: Path) -> None:
    folder = tmp_path / "killed"
    words = command("sweep", *FLAGS, "--jobs", "2", "--out", str(folder))
    process = subprocess.Popen(words, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 30.0
    while not (folder / TABLE).exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.3)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    assert (folder / TABLE).read_bytes() == (table / TABLE).read_bytes()


def test_another_grid_in_the_same_folder_is_refused_and_a_larger_one_goes_on(table: Path, tmp_path: Path) -> None:
    folder = tmp_path / "grown"
    beadband.sweep(out=folder, strain="0.4,0.5", tolerance=0.02)
    with pytest.raises(UsageError, match="another grid"):
        beadband.sweep(out=folder, strain="0.4,0.6", tolerance=0.02)
    assert len(beadband.sweep(out=folder, strain="0.4,0.5,0.6", tolerance=0.02)) == 3
    (tmp_path / "else").mkdir()
    (tmp_path / "else" / "thesis.txt").write_text("words")
    with pytest.raises(UsageError, match="something else"):
        beadband.sweep(out=tmp_path / "else", strain=0.4)


def test_two_sweeps_do_not_share_a_folder(tmp_path: Path) -> None:
    grid = grid_of({"strain": 0.4})
    with Store(tmp_path, grid), pytest.raises(UsageError, match="another sweep"):
        Store(tmp_path, grid)


def test_arrays_in_python() -> None:
    done = beadband.sweep(strain=[0.3, 0.4, 0.5], tolerance=0.02, by="runs")
    speeds = done["rebound_speed_m_s"]
    assert speeds.shape == (3,)
    assert np.all(np.diff(speeds) > 0.0)
    assert list(done["status"]) == ["done"] * 3
    alpha = done.summary["alpha"]["all"]["front_horizontal"]
    assert alpha["mean"] == pytest.approx(float(np.mean(done["alpha_front_horizontal"])))


def test_slope_through_zero_is_exact_for_a_line_and_covers_noise() -> None:
    x = np.linspace(0.1, 1.0, 40)
    assert Line().add(x, 1.3 * x).slope.value == pytest.approx(1.3)
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(200):
        fit = Line().add(x, 1.3 * x + 0.1 * rng.standard_normal(40)).slope
        inside += abs(fit.value - 1.3) <= fit.error
    assert 180 <= inside <= 199
    assert math.isfinite(fit.error)


CHEAP = {"band": "I,III", "strain": "0.2:1.0:5", "law": "mooney-rivlin,linear", "half_angle": "6,60", "tolerance": 0.02}


@pytest.fixture(scope="module")
def cheap() -> Swept:
    return beadband.sweep(**CHEAP)


def test_at_a_loose_tolerance_the_formula_answers_as_ask_does(cheap: Swept) -> None:
    """One by one the law is unloaded by another algorithm: equal to rounding, not to the last digit."""
    by_formula = [row for row in cheap if row["model"] == "formula"]
    assert len(by_formula) > 15
    for row in by_formula[::6]:
        answer = beadband.ask(**{key: row[key] for key in ("band", "strain", "law", "tolerance", "half_angle_deg")})
        assert row["rebound_speed_m_s"] == pytest.approx(answer.value, rel=1e-9)
        assert row["rebound_speed_error_m_s"] == pytest.approx(answer.error, rel=1e-6)
        assert row["within_tolerance"] == "yes"
        assert row["beads"] is row["exponent"] is None


def test_formula_and_runs_differ_by_less_than_their_errors_and_agree_on_all_else(cheap: Swept) -> None:
    runs = beadband.sweep(**{**CHEAP, "half_angle": "6", "by": "runs"})
    cheaply = {row["key"]: row for row in cheap}
    for run in runs:
        row = cheaply[run["key"]]
        apart = abs(row["rebound_speed_m_s"] - run["rebound_speed_m_s"])
        assert apart <= math.hypot(row["rebound_speed_error_m_s"], run["rebound_speed_error_m_s"])
        for name in ("string_speed_m_s", "published_ratio"):
            assert row[name] == pytest.approx(run[name], rel=1e-9)
        for wave in ("bar", "rest", "front_horizontal"):
            speed = run["rebound_speed_m_s"] / run[f"ratio_{wave}"]
            assert row["rebound_speed_m_s"] / row[f"ratio_{wave}"] == pytest.approx(speed, rel=1e-9)
            assert row[f"ratio_{wave}"] / row[f"alpha_{wave}"] == pytest.approx(row["published_ratio"], rel=1e-9)


def test_scenes_beyond_the_formula_are_released_or_refused(cheap: Swept) -> None:
    assert set(cheap.summary["status"]) == {"done", "refused"}
    assert all("too wide" in row["reason"] for row in cheap if row["status"] == "refused")
    assert all(row["model"] != "formula" for row in beadband.sweep(strain="0.3,0.4", loss_time=1e-5, tolerance=0.02))
    assert all(row["model"] != "formula" for row in beadband.sweep(strain="0.3,0.4", by="runs"))
    with pytest.raises(UsageError, match="--by"):
        beadband.sweep(strain=0.4, by="guess")


def test_a_column_that_only_a_run_gives_makes_every_scene_run() -> None:
    observable("late_tip_m", "where the tip is at last", unit="m")(lambda run: float(run.rear.tip_x_m[-1]))
    try:
        (row,) = beadband.sweep(strain=0.4, tolerance=0.02)
    finally:
        forget("late_tip_m")
    assert row["model"] == "leg"
    assert row["late_tip_m"] > 0.0


def test_a_cut_table_of_formula_and_runs_ends_with_the_same_bytes(cheap: Swept, tmp_path: Path) -> None:
    assert cheap.path is not None
    whole = cheap.path.read_bytes()
    (tmp_path / TABLE).write_bytes(whole[: int(0.7 * len(whole))])
    beadband.sweep(out=tmp_path, **CHEAP)
    assert (tmp_path / TABLE).read_bytes() == whole
    described = json.loads((tmp_path / MANIFEST).read_text())
    assert [one["name"] for one in described["columns"]] == whole.decode().splitlines()[0].split(",")
    assert described["estimate"]["scenes"] == len(cheap)


def test_the_totals_of_many_blocks_are_those_of_the_whole_table(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rungs, "BLOCK", 7)
    found = beadband.sweep(strain="0.1:1.0:40", tolerance=0.02)
    alpha = found["alpha_rest"]
    said = found.summary["alpha"]["all"]["rest"]
    assert said["mean"] == pytest.approx(float(alpha.mean()), rel=1e-12)
    assert said["standard_deviation"] == pytest.approx(float(alpha.std(ddof=1)), rel=1e-9)
    shares = found["rebound_speed_error_m_s"] / found["rebound_speed_m_s"]
    assert found.summary["relative_error"]["median"] == float(np.median(shares))
    assert np.all(np.diff(found["strain"]) > 0.0)


def test_parquet_holds_the_same_table_with_types_and_units(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet needs pyarrow")
    done = beadband.sweep(out=tmp_path, parquet=True, **CHEAP)
    read = parquet.read_table(tmp_path / "sweep.parquet")
    assert read.to_pylist() == list(done.rows)
    assert [str(field.type) for field in read.schema][:4] == ["string", "string", "double", "double"]
    assert read.schema.field("rebound_speed_m_s").metadata[b"unit"] == b"m/s"


def test_memory_does_not_grow_with_the_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is kept of a scene is some bytes: a hundredth of what its row takes in memory."""
    monkeypatch.setattr(rungs, "BLOCK", 256)
    monkeypatch.setattr(summary, "SHOWN", 100)
    beadband.sweep(strain="0.1:0.5:4", half_angle=[8, 9], tolerance=0.02)  # what is imported is not what is kept
    tracemalloc.start()
    try:
        peaks = []
        for count in (16, 80):
            tracemalloc.reset_peak()
            beadband.sweep(strain="0.1:1.0:64", half_angle=f"5:20:{count}", tolerance=0.02)
            peaks.append(tracemalloc.get_traced_memory()[1])
    finally:
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < 60 * 64 * (80 - 16)


def test_constants_of_the_law_may_vary_within_the_formula() -> None:
    options = {"c10": "1.2e5:3e5", "c01": "1e5:2e5", "strain": "0.3:0.8", "tolerance": 0.02, "random": 300, "seed": 4}
    drawn = beadband.sweep(**options)
    assert drawn.summary["models"]["formula"] > 280
    for row in [row for row in drawn if row["model"] == "formula"][::60]:
        scene = scene_of({key: row[key] for key in ("c10_pa", "c01_pa", "strain", "tolerance")})
        answer = beadband.ask(scene)
        assert row["rebound_speed_m_s"] == pytest.approx(answer.value, rel=1e-9)
        speeds = scene.wave_speeds(scene.string.front_speed_m_s)
        assert row["ratio_rest"] == pytest.approx(answer.value / speeds["rest"], rel=1e-9)
        assert row["ratio_front_horizontal"] == pytest.approx(answer.value / speeds["front_horizontal"], rel=1e-9)
