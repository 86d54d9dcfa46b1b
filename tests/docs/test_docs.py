"""What the pages in docs/ say is what the program does: their code is run, their tables are compared."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.readers import read_energies
from beadband.runs import folder as files
from beadband.runs.results import Run
from conftest import REQUIRE_ALL, WITHOUT

DOCS = Path(__file__).parents[2] / "docs"


def test_the_table_of_variables_is_whole(default_run: tuple[Run, Path]) -> None:
    script = (default_run[1] / files.SCRIPT).read_text(encoding="utf-8")
    given = set(re.findall(r"^variable +(\w+) index", script, re.MULTILINE))
    page = (DOCS / "lammps.md").read_text(encoding="utf-8")
    rows = re.search(r"\| variable \|.*?\n(?=\n)", page, re.DOTALL)
    assert rows
    listed = {name for row in rows[0].splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert listed == given


def test_a_run_without_python_and_without_loss(default_run: tuple[Run, Path], lmp: str, tmp_path: Path) -> None:
    """The three files that the page names are enough, and a variable on the command line wins."""
    run, folder = default_run
    for name in (files.DATA, files.TABLE, files.SCRIPT):
        shutil.copy(folder / name, tmp_path)
    command = [lmp, "-log", "none", "-screen", "none", "-var", "dashpot", "0", "-in", files.SCRIPT]
    subprocess.run(command, cwd=tmp_path, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    energies = read_energies(tmp_path / files.ENERGY)
    total = energies.stretching_j + energies.bending_j + energies.kinetic_j
    assert np.all(energies.loss_w == 0.0)
    assert np.abs(total / total[0] - 1.0).max() < 5e-3
    assert run.energy.dissipated_j[-1] > 0.05 * run.energy.stored_j  # as the plan had it


def test_the_tutorial(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(DOCS / "tutorial.py")], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    lines = done.stdout.splitlines()
    assert len(lines) == 3
    speed, error, string = (float(number) for number in re.findall(r"\d+\.\d+", lines[1])[:3])
    again = float(re.findall(r"\d+\.\d+", lines[2])[0])
    assert 0.0 < error < 0.005 * speed
    assert speed == pytest.approx(string, rel=0.02)
    assert again == pytest.approx(speed, rel=1e-3)
    assert (tmp_path / "speed.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "tutorial-run" / files.RESULTS).is_file()


def test_the_lesson(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The notebook's cells in order, in one name space, as a kernel would run them."""
    cells = json.loads((DOCS / "lesson.ipynb").read_text(encoding="utf-8"))["cells"]
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    said = capsys.readouterr().out
    free, arrival = map(float, re.findall(r"after ([\d.]+) ms", said))
    assert 3.0 < free < arrival < 5.0
    assert (tmp_path / "lesson" / "shapes.png").is_file()


@pytest.mark.ovito
def test_ovito_draws_the_band_at_its_size(default_run: tuple[Run, Path], tmp_path: Path) -> None:
    """The radius column, at SI scale: legs in the picture are as thick as the band."""
    from PIL import Image

    if not REQUIRE_ALL:
        pytest.importorskip("ovito")
    run, folder = default_run
    done = subprocess.run(
        [sys.executable, str(DOCS / "ovito_render.py"), str(folder), str(tmp_path / "x.png"), "0"],
        capture_output=True,
        text=True,
    )
    if done.returncode and "Vulkan" in done.stderr and (not REQUIRE_ALL or "vulkan" in WITHOUT):
        pytest.skip("needs Vulkan: libvulkan1 and mesa-vulkan-drivers")
    assert done.returncode == 0, done.stderr
    pixels = np.asarray(Image.open(tmp_path / "x.png").convert("RGB")).astype(int)
    drawn = pixels.min(axis=2)[:425] < 160  # above the legend, darker than half covered
    columns = np.flatnonzero(drawn.any(axis=0))
    thickness = run.plan.scene.band.thickness_m
    pixel = (float(np.ptp(run.held.positions_m[:, 0])) + thickness) / (columns[-1] - columns[0] + 1)
    middle = drawn[:, (columns[0] + columns[-1]) // 2]
    legs = np.flatnonzero(np.diff(middle.astype(int)))
    across = (legs[1] - legs[0]) * pixel * np.cos(run.plan.scene.half_angle_rad)
    assert len(legs) == 4
    assert across == pytest.approx(thickness, abs=1.5 * pixel)
