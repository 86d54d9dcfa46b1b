"""Folders and files: nothing unfinished looks finished, and what is damaged is refused."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from beadband.analysis.readers import ReadError, read, read_mdanalysis
from beadband.errors import UsageError
from beadband.model.scene import KEYS, scene_of
from beadband.model.scenefile import read_scene, scene_text
from beadband.runs import dispatch, finish
from beadband.runs import folder as files
from beadband.runs.results import Run, to_json

LONG = [sys.executable, "-m", "beadband", "run", "--beads", "4000", "--out"]


def start(folder: Path) -> subprocess.Popen[str]:
    """A run that takes long, once LAMMPS has begun to write."""
    process = subprocess.Popen(
        [*LONG, str(folder)],
        cwd=folder.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
    )
    deadline = time.monotonic() + 60.0
    while not (folder / files.ENERGY).exists():
        assert process.poll() is None, process.stderr.read() if process.stderr else ""
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return process


def test_interrupted_run_says_so_and_leaves_no_results(tmp_path: Path) -> None:
    process = start(tmp_path / "run")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert out == ""
    predicted, said = err.splitlines()
    assert predicted.startswith("predicted: ")
    assert "interrupted" in said
    assert not (tmp_path / "run" / files.RESULTS).exists()


def test_killed_run_is_recognised(tmp_path: Path) -> None:
    process = start(tmp_path / "run")
    os.kill(process.pid, signal.SIGKILL)
    process.wait(timeout=60)
    assert not (tmp_path / "run" / files.RESULTS).exists()
    with pytest.raises(UsageError, match="did not finish"):
        files.create(tmp_path / "run")
    with pytest.raises(UsageError):
        dispatch.analyze(tmp_path / "run")


def test_folders_in_the_way(tmp_path: Path, default_run: tuple[Run, Path]) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="can't be used"):
        files.create(tmp_path / "file")
    with pytest.raises(UsageError, match="can't be used"):
        files.create("/proc/nowhere/at/all")
    with pytest.raises(UsageError, match="with 1 other file"):
        files.create(tmp_path)
    with pytest.raises(UsageError, match="a finished run"):
        files.create(default_run[1])
    assert files.create(tmp_path / "new" / "deep").is_dir()


def test_free_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert files.next_free("run") == Path("run")
    Path("run").mkdir()
    Path("run-2").mkdir()
    assert files.next_free("run") == Path("run-3")


@pytest.mark.parametrize("cut", [0.3, 0.999])
def test_damaged_trajectories_are_refused(default_run: tuple[Run, Path], tmp_path: Path, cut: float) -> None:
    run, folder = default_run
    for name in (files.REAR, files.ENERGY, files.SCENE):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    whole = (folder / files.REAR).read_bytes()
    (tmp_path / files.REAR).write_bytes(whole[: int(cut * len(whole))])
    with pytest.raises(UsageError):
        dispatch.analyze(tmp_path)
    with pytest.raises(UsageError):
        finish.remeasure(tmp_path)
    assert run.plan.steps > 0


def test_what_is_no_trajectory_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("ITEM: NOTHING\n" * 20)
    for reader in (read, read_mdanalysis):
        for path in (tmp_path / "x", tmp_path / "missing"):
            with pytest.raises(ReadError):
                reader(path)
    with pytest.raises(UsageError, match=r"scene\.toml"):
        dispatch.analyze(tmp_path)


def test_no_result_is_ever_nan() -> None:
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json({"value": float("nan")})


def test_scene_files(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    path.write_text('band = "II"\nstrain = 0.3\nhalf-angle = 10\nthickness = 1e-3\nfor = "speed"\nbeads = 200\n')
    scene = scene_of(read_scene(path))
    assert (scene.band.name, scene.half_angle_deg, scene.band.thickness_m, scene.beads) == ("II", 10.0, 1e-3, 200)
    path.write_text(scene_text(scene))
    assert scene_of(read_scene(path)) == scene
    for text in (
        "strain = ",
        'strain = "x"',
        "straim = 1",
        "beads = 2.5",
        "strain = true",
        "band = 3",
        "half_angle = 1\nhalf_angle_deg = 1",
    ):
        path.write_text(text)
        with pytest.raises(UsageError):
            scene_of(read_scene(path))
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="UTF-8"):
        read_scene(path)
    assert len(set(KEYS)) == len(KEYS)
