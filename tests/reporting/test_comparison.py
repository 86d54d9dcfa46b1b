"""Runs side by side: what differs is listed, what does not is left out, and the pictures have the size asked for."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from beadband.cli import main
from beadband.errors import UsageError
from beadband.reporting import comparison
from beadband.reporting.style import Style, line_of
from beadband.runs.results import Run


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two coarse runs that differ in the strain, and one that repeats the first."""
    place = tmp_path_factory.mktemp("side by side")
    made = []
    for name, strain in (("one", "0.4"), ("other", "0.5"), ("again", "0.4")):
        made.append(place / name)
        options = ["--strain", strain, "--beads", "120", "--for", "speed"]
        assert main(["run", *options, "--out", str(made[-1])]) == 0
    return made


def test_what_differs_is_listed_and_nothing_else(folders: list[Path], default_run: tuple[Run, Path]) -> None:
    found = comparison.compare(folders[:2])
    assert found.scene["strain"] == [0.4, 0.5]
    assert not {"band", "law", "density_kg_m3", "beads"} & found.scene.keys()
    assert "rebound speed V" in found.results
    first, other = (run.speed for run in found.runs)
    apart = found.speeds[1]
    assert apart["relative_difference"] == pytest.approx(other.value / first.value - 1.0)
    assert apart["bars"] == pytest.approx((other.value - first.value) / (first.error**2 + other.error**2) ** 0.5)
    assert "bars" not in found.speeds[0]


def test_a_repeated_run_is_the_same(folders: list[Path]) -> None:
    found = comparison.compare([folders[0], folders[2]])
    assert found.scene == {}
    assert found.results == {}
    assert found.speeds[1]["bars"] == 0.0
    assert "scene    the same  the same" in comparison.table(found)


def test_the_command_prints_and_draws(folders: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "side by side"
    assert main(["compare", *map(str, folders[:2]), "--json", "--out", str(out)]) == 0
    assert json.loads(capsys.readouterr().out)["scene"]["strain"] == [0.4, 0.5]
    names = {path.name for path in out.iterdir()}
    assert names == {f"{name}.png" for name in ("speed", "path", "curvature", "kinetic", "comparison")}
    assert main(["compare", str(folders[0])]) == 2
    assert main(["compare", str(folders[0]), str(folders[0])]) == 2


def test_pictures_have_the_width_of_the_columns(folders: list[Path], tmp_path: Path) -> None:
    from PIL import Image

    narrow = comparison.compare(folders[:2]).runs[0].plot(tmp_path, columns=1)
    with Image.open(narrow[0]) as picture:
        assert picture.width / 300.0 * 25.4 == pytest.approx(85.0, abs=0.2)
    assert main(["plot", str(folders[0]), "--format", "svg", "--columns", "2", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "speed.svg").read_text(encoding="utf-8")
    assert "<text" in text  # text, not outlines
    assert f'width="{6.89 * 72:.2f}' in text


def test_lines_are_told_apart() -> None:
    styles = [tuple(sorted(line_of(number).items())) for number in range(comparison.MOST_RUNS)]
    assert len(set(styles)) == comparison.MOST_RUNS
    with pytest.raises(UsageError, match="png, pdf, svg"):
        Style("jpg")
    with pytest.raises(UsageError, match="1 or 2"):
        Style(columns=3)
