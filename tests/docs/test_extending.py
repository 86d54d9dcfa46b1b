"""The page on extending beadband, executed: a law and an observable of a user's own in every command."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pages import DOCS, blocks

PAGE = blocks(DOCS / "extending.md")
FILES = {block.file: block.text for block in PAGE if block.file}
FUNG = ["--law", "fung", "--mu", "3e5", "--b", "0.05"]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files of the page, in which its commands were run as they are printed there."""
    folder = tmp_path_factory.mktemp("extending")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    for number, block in enumerate(block for block in PAGE if block.language == "sh"):
        with (folder / f"printed {number}").open("w", encoding="utf-8") as printed:
            subprocess.run(
                ["sh", "-e", "-c", block.text], cwd=folder, env={**os.environ, "PATH": path}, stdout=printed, check=True
            )
    return folder


def beadband(place: Path, *arguments: str, code: int = 0) -> str:
    """What a command prints with the law of the page."""
    done = subprocess.run(
        [sys.executable, "-m", "beadband", *arguments],
        cwd=place,
        env={**os.environ, "BEADBAND_PLUGINS": "fung.py"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def stored(folder: Path) -> Any:
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "sweep.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_files_of_the_page_are_short() -> None:
    assert set(FILES) == {"loop.toml", "fung.py", "fastest.py"}
    assert len(FILES["fung.py"].strip().splitlines()) <= 25
    assert len(FILES["fastest.py"].strip().splitlines()) <= 8


def test_a_band_from_a_scene_file(place: Path) -> None:
    found = stored(place / "loop")
    assert found["scene"]["label"] == "latex loop"
    assert [one["name"] for one in found["inputs"]] == ["thickness_m"]
    assert found["scene"]["modulus_pa"] == pytest.approx(6 * (1.5e5 + 2.0e4))


def test_a_law_from_a_file_runs_in_every_command(place: Path) -> None:
    planned = json.loads(beadband(place, "plan", *FUNG, "--json"))
    assert (planned["scene"]["law"], planned["scene"]["mu_pa"], planned["scene"]["b"]) == ("fung", 3e5, 0.05)
    found = stored(place / "my-run")
    assert found["rebound_speed_m_s"] == pytest.approx(found["string_speed_m_s"], rel=0.03)
    assert found["wave_speeds_m_s"]["rest"] == pytest.approx((9e5 / 1300.0) ** 0.5)
    again = json.loads(beadband(place, "analyze", "my-run", "--json"))
    assert again["rebound_speed_m_s"] == found["rebound_speed_m_s"]
    assert (place / "my-run" / "report.html").is_file()
    assert [row["status"] for row in rows(place / "my-sweep")] == ["done", "done"]


def test_an_observable_from_a_file_stands_everywhere(place: Path) -> None:
    found = stored(place / "fast")
    printed = "".join(path.read_text(encoding="utf-8") for path in place.glob("printed *"))
    assert found["fastest_m_s"] == max(found["series"]["tip_speed_m_s"])
    assert f"largest speed of the rear tip  {found['fastest_m_s']:.4g} m/s" in printed
    assert f'"fastest_m_s": {found["fastest_m_s"]}' in printed  # measured again by analyze
    speeds = [(float(row["fastest_m_s"]), float(row["rebound_speed_m_s"])) for row in rows(place / "fast-sweep")]
    assert len(speeds) == 2
    assert all(0.95 < fastest / rebound < 1.5 for fastest, rebound in speeds)
    dictionary = (place / "my-pages" / "results.md").read_text(encoding="utf-8")
    assert "| `fastest_m_s` | m/s | largest speed of the rear tip" in dictionary
    schema = json.loads((place / "my-pages" / "results.schema.json").read_text(encoding="utf-8"))
    assert schema["properties"]["fastest_m_s"]["description"] == "largest speed of the rear tip, m/s"


def test_its_constants_are_checked(place: Path) -> None:
    assert "lacks a constant" in beadband(place, "plan", "--law", "fung", "--mu", "3e5", code=2)
    assert "above 0" in beadband(place, "plan", *FUNG[:4], "--b", "-1", code=2)
    assert "not used by the law linear" in beadband(place, "plan", "--law", "linear", "--b", "0.1", code=2)


def test_a_plug_in_that_can_not_be_loaded_is_one_line(place: Path) -> None:
    (place / "fung.py").rename(place / "away.py")
    said = beadband(place, "plan", code=2)
    (place / "away.py").rename(place / "fung.py")
    assert said.count("\n") == 1
    assert "a plug-in can't be loaded" in said
