"""What once happened without a word: each is refused by name, or said where a user sees it, before time is spent."""

from __future__ import annotations

import ast
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import beadband
from beadband import commands, observables, parameters
from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.model.scene import scene_of
from beadband.planning.launch_plan import launch_plan_of
from beadband.planning.plan import plan_of
from beadband.runs import dispatch
from beadband.runs import folder as files
from beadband.runs.results import Run

CLONE = Path(__file__).parents[2]
OWN = "--circumference .18 --width .003 --thickness .001 --density 930"
Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def planned(capsys: Capture, options: str) -> dict[str, Any]:
    assert main(["plan", "--json", *options.split()]) == 0
    values: dict[str, Any] = json.loads(capsys.readouterr().out)
    return values


def refusal(capsys: Capture, command: str) -> str:
    """The one line with which a command is refused, before it writes anything."""
    before = sorted(Path.cwd().rglob("*"))
    assert main(command.split()) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert sorted(Path.cwd().rglob("*")) == before
    return said.err


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (f"run {OWN} --modulus 1.35e6", ["--modulus does not change the stress", "--c10 --c01", "--law linear"]),
        ("run --law linear --c10 1e5", ["--c10 is not used by the law linear", "given --c10 100000"]),
        ("pareto --loss-time 1e-6", ["--loss-time is not used by 'beadband pareto'"]),
        ("pareto --beads 100", ["--beads is not used by 'beadband pareto'"]),
        ("pareto --timestep 1e-7", ["--timestep is not used by 'beadband pareto'"]),
        ("pareto --tolerance 1e-3", ["--tolerance is not used by 'beadband pareto'"]),
        ("run --loss-time 5", ["too long", "251493900 steps", "10 min and 2 GB", "--force"]),
        ("run --frames 100000", ["too much disk", "6 GB", "100000 frames", "--force"]),
        ("run --until launch --frames 100000", ["too much disk", "100000 frames"]),
        ("run --beads 4", ["given 4; allowed: a whole number, 24 to 2000000"]),
        ("run --beads -10", ["given -10; allowed: a whole number, 24 to 2000000"]),
        ("run --beads nan", ["given nan; allowed: a whole number, 24 to 2000000"]),
        ("analyze nodir --strain 0.3", ["--strain is not used by 'beadband analyze': given --strain 0.3"]),
        ("sweep --strain 0.3 --frames 10", ["--frames is not used by 'beadband sweep': given --frames 10"]),
        ("sweep --strain 0.3 --seed 3", ["--seed is not used without --random"]),
        ("plan --bending-scale 0 --bending-modulus rest", ["--bending-modulus is not used without bending"]),
        ("plan --law linear --c10 187000", ["--c10 is not used by the law linear: given --c10 187000"]),
        ("plan --softening-r 1.5", ["the softening lacks a constant: given r 1.5;"]),
        ("bands --file none.toml", ["check --file"]),
        ("report nodir", ["not the folder of a run: given 'nodir' without results.json"]),
        ("plot nodir", ["not the folder of a run: given 'nodir'"]),
        ("movie nodir", ["not the folder of a run: given 'nodir'"]),
    ],
)
def test_what_would_be_ignored_or_absurd_is_refused_by_name(command: str, words: list[str], capsys: Capture) -> None:
    said = refusal(capsys, command)
    assert [word for word in words if word not in said] == []


@pytest.mark.parametrize("options", [{"loss_time": 5}, {"frames": 100_000}])
def test_python_refuses_absurd_runs_too(options: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="disk space") as refused:
        beadband.run(**options)
    assert refused.value.code == "absurd-run"


def test_a_modulus_that_reaches_the_stress_is_taken(capsys: Capture) -> None:
    """Under the linear law E is the stiffness: V goes as its square root."""
    soft, stiff = (planned(capsys, f"{OWN} --law linear --modulus {modulus}") for modulus in ("1e6", "4e6"))
    assert soft["front_arrival_s"] / stiff["front_arrival_s"] == pytest.approx(2.0, rel=1e-9)


def test_the_title_does_not_name_a_band_of_other_sizes(capsys: Capture) -> None:
    assert main(["plan", *OWN.split()]) == 0
    assert capsys.readouterr().out.startswith("Band of 180 mm circumference, strain")
    assert main(["plan", "--thickness", "0.0015"]) == 0
    assert capsys.readouterr().out.startswith("Band III, thickness 1.5 mm, strain")


def test_sizes_in_mm_are_noticed(capsys: Capture) -> None:
    warnings = planned(capsys, "--circumference 180 --width 3 --thickness 1")["warnings"]
    for flag in ("--circumference", "--width", "--thickness"):
        assert any(f"check {flag}" in one and "SI units" in one for one in warnings)
    assert not any("SI units" in one for one in planned(capsys, OWN)["warnings"])


def test_a_number_of_frames_never_changes_the_step(capsys: Capture) -> None:
    usual, many = planned(capsys, ""), planned(capsys, "--frames 5000")
    assert many["timestep_s"] == usual["timestep_s"]
    assert many["steps"] == usual["steps"] == many["frames"]
    assert any("960 frames instead of 5000" in one for one in many["warnings"])


@pytest.mark.parametrize(("given", "plain"), [("--beads 1e3", "--beads 1000"), ("--c10 -0.024e6", "--c10=-24000")])
def test_numbers_may_be_written_as_numbers_are(given: str, plain: str, capsys: Capture) -> None:
    assert planned(capsys, given) == planned(capsys, plain)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--beads 60 --for speed", ["the error expected of the rebound speed, 13 %, is above the tolerance of 0.50 %"]),
        ("--tolerance 1e-4", ["0.015 %, is above the tolerance of 0.010 %", "predicted: ", " MB on disk"]),
    ],
)
def test_a_tolerance_out_of_reach_is_said_before_the_time_is_spent(
    options: str, words: list[str], capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: Any) -> None:
        raise RunError("stopped at the start")

    monkeypatch.setattr(dispatch, "run", stop)
    assert main(["run", *options.split()]) == 1
    said = capsys.readouterr().err
    assert [word for word in words if word not in said] == []


def test_an_error_above_the_tolerance_is_said_per_row_and_in_the_totals(capsys: Capture) -> None:
    assert (
        main(["sweep", "--strain", "0.3,0.4", "--beads", "60", "--for", "speed", "--jobs", "1", "--out", "table"]) == 0
    )
    assert "in 2 of 2 finished scenes above the tolerance" in capsys.readouterr().out
    with Path("table/sweep.csv").open() as table:
        assert [row["within_tolerance"] for row in csv.DictReader(table)] == ["no", "no"]


def test_a_sweep_says_why_a_scene_has_no_result(capsys: Capture) -> None:
    unused = "--c10 is not used by the law linear"
    grid = ["sweep", "--strain", "0.3", "--c10", "2e5", "--beads", "60", "--jobs", "1"]
    assert main([*grid, "--law", "linear,mooney-rivlin", "--out", "both"]) == 0
    assert f"no result for 1 (unused-parameter), the first: {unused}" in capsys.readouterr().out
    assert main([*grid, "--law", "linear", "--out", "none"]) == 2
    assert f"no scene of the sweep has a result; the first: {unused}" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["bands", "analyze nodir", "plot nodir", "report nodir", "movie nodir", "verify",
                                     "reproduce", "launch-map", "stability", "find strain --speed 15",
                                     "design --goal speed",
                                     *sorted({*parameters.COMMANDS} - {"find", "design"})])  # fmt: skip
def test_every_option_of_a_scene_is_refused_where_it_is_not_used(command: str, capsys: Capture) -> None:
    name = command.partition(" ")[0]
    axes = ("band", "hand_mass_kg", "hand_stiffness_n_m") if name == "launch-map" else ()  # its own: test_hand_map.py
    for one in (each for each in list(parameters.TABLE.values()) if each.key not in axes):
        if one.section != "record" and name not in one.commands:
            assert f"{one.flag} is not used by 'beadband {name}'" in refusal(capsys, f"{command} {one.flag} 0.3")


def test_a_run_states_the_time_and_disk_that_were_predicted(default_run: tuple[Run, Path], capsys: Capture) -> None:
    """The size of the files is right to a third; the time depends on the machine, and more so on a busy one."""
    run, folder = default_run
    plan = plan_of(scene_of({}))
    values = json.loads((folder / files.RESULTS).read_text())
    assert values["predicted"] == {"seconds": plan.seconds, "bytes": plan.disk_bytes}
    size = sum(path.stat().st_size for path in folder.iterdir())
    assert 0.67 < plan.disk_bytes / size < 1.5
    assert commands._report(run, False) == 0
    wall = next(line for line in capsys.readouterr().out.splitlines() if "wall time" in line)
    assert wall.endswith(f"s in all (predicted {plan.seconds:.2g} s, {plan.disk_bytes / 1e6:.2g} MB)")
    assert main(["analyze", str(folder)]) == 0
    assert "(predicted" not in capsys.readouterr().out


@pytest.mark.parametrize("command", ["analyze", "plot", "report", "movie"])
def test_an_edited_scene_is_not_taken_for_that_of_the_run(
    command: str, default_run: tuple[Run, Path], capsys: Capture
) -> None:
    shutil.copytree(default_run[1], "copy")
    scene = Path("copy") / files.SCENE
    scene.write_text(scene.read_text().replace("strain = 0.476", "strain = 0.9"))
    assert "scene.toml has changed since the run" in refusal(capsys, f"{command} copy")


@pytest.mark.parametrize("command", ["analyze", "plot", "report", "movie"])
@pytest.mark.parametrize("name", [files.TRAJECTORY, files.REAR])
def test_a_trajectory_that_is_cut_short_is_named(
    command: str, name: str, default_run: tuple[Run, Path], capsys: Capture
) -> None:
    shutil.copytree(default_run[1], "copy")
    path = Path("copy") / name
    whole = path.stat().st_size
    with path.open("r+b") as handle:
        handle.truncate(whole // 3)
    said = refusal(capsys, f"{command} copy")
    assert f"{name} is cut short: given 'copy/{name}' with {whole // 3} bytes; allowed: {whole} bytes" in said


def test_the_clones_own_folder_works_where_the_package_is_installed_elsewhere() -> None:
    """As after ``pip install .``: Python started in the clone finds its ``beadband``, without the editable install."""
    for name in ("beadband", "analysis", "lmp_inputs"):
        shutil.copytree(CLONE / name, name, ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        "import sys\n"
        "sys.meta_path[:] = [one for one in sys.meta_path if 'Editable' not in getattr(one, '__name__', '')]\n"
        "import beadband, beadband.analysis.fits as fits\n"
        "run = beadband.run(beads=60, until='release', **{'for': 'speed'})\n"
        "print(beadband.__file__, fits.__file__, run.speed.value > 0.0, sep='\\n')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    package, measuring, moved = done.stdout.split()
    assert Path(package).resolve() == Path("beadband/__init__.py").resolve()
    assert Path(measuring).resolve() == Path("analysis/fits.py").resolve()
    assert moved == "True"


def test_a_sound_launch_ends_in_exit_0(capsys: Capture) -> None:
    """Its asymmetry, 1.7e-6 of the leg on some machines, is what rounding does in so many steps."""
    assert main(["run", "--json", "--band", "I", "--law", "linear", "--until", "launch", "--beads", "560"]) == 0
    asymmetry = json.loads(capsys.readouterr().out)["checks"]["asymmetry"]
    assert asymmetry["value"] < 0.01 * asymmetry["bound"]


def test_the_longest_launch_is_so_many_times_what_the_string_takes() -> None:
    plan = launch_plan_of(scene_of({"until": "launch", "beads": 160}))
    assert plan.cap_s == pytest.approx(3.0 * max(plan.string.rear_arrival_s, plan.string.finger_free_s), rel=0.02)


def test_no_message_names_a_function_of_the_program() -> None:
    """Names with an underscore in what a user reads are keys of files and results, or public names of beadband."""
    trees = [ast.parse(path.read_text()) for room in ("beadband", "analysis") for path in (CLONE / room).rglob("*.py")]
    functions = {
        node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and "_" in node.name
    }
    known = {name for one in observables.table() for name in one.key.split(".")} | {*beadband.__all__}
    known |= {*parameters.TABLE, "rear_steps"}
    said = {
        word
        for tree in trees
        for call in ast.walk(tree)
        if isinstance(call, ast.Call)
        and getattr(call.func, "id", "") in ("explain", "UsageError", "RunError", "notice")
        for part in ast.walk(call)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
        for word in part.value.replace("(", " ").replace(")", " ").split()
    }
    assert said & (functions - known) == set()


def test_what_python_shows_fits_a_screen() -> None:
    swept = beadband.sweep(strain=[0.3], beads=60)
    scene = beadband.scene(band="II")
    shown = [beadband.plan(scene), beadband.plan(until="launch", beads=160), scene, swept]
    assert all(len(line) < 120 for one in shown for line in repr(one).splitlines())
    assert all(repr(one).count("\n") < 3 for one in shown)
    assert repr(scene) == "<Scene: band II, strain 0.476, half-angle 14 deg, mooney-rivlin, until release>"
    assert repr(swept) == "<Sweep of 1 scenes: 1 done>"


def test_python_refuses_a_seed_without_draws() -> None:
    with pytest.raises(UsageError, match="--seed is not used without --random"):
        beadband.sweep(strain=[0.3], seed=4)
