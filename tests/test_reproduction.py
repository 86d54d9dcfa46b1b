"""The reproduction: items that take no time are drawn, grids give what they must, and the scorecard is whole."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.tip import Measured
from beadband.cli import main
from beadband.reproduction import ITEMS, reproduce
from beadband.reproduction.runs import Found, Runs
from beadband.reproduction.scorecard import Entry, as_markdown
from beadband.reproduction.speeds import fit_alpha, scenes22
from beadband.scales import SimilarityWindow

INSTANT = [name for name, item in ITEMS.items() if not item.scenes(True) and name not in ("fig16", "fig20")]


def found(published: float, speed: float) -> Found:
    """A made-up release with a wave speed of 1 m/s."""
    waves = dict.fromkeys(("bar", "rest", "front_horizontal"), 1.0)
    nothing = np.zeros(0)
    return Found({}, Measured(speed, 0.0), 1.0, published, waves, 1.0, 0.2, 1.0, SimilarityWindow(0.0, 0.0, "none"),
                 None, "none", nothing, nothing, nothing)  # fmt: skip


def test_every_figure_and_table_of_the_paper_is_there() -> None:
    assert list(ITEMS) == ["table1", *(f"fig{n}" for n in range(4, 24)), "appendix"]


@pytest.mark.parametrize("name", INSTANT)
def test_items_are_drawn_and_scored(name: str, tmp_path: Path) -> None:
    card = reproduce(tmp_path, name)
    assert card["entries"]
    assert (tmp_path / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert "<svg" in (tmp_path / f"{name}.svg").read_text()[:1000]
    assert json.loads((tmp_path / "scorecard.json").read_text())["entries"] == card["entries"]


def test_the_command_reproduces_one_figure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "--only", "fig20", "--quick", "--out", str(tmp_path / "out")]) == 0
    assert "Fig. 20" in capsys.readouterr().out
    assert main(["reproduce", "--only", "fig99", "--out", str(tmp_path / "other")]) == 2
    assert not (tmp_path / "other").exists()
    assert capsys.readouterr().err.count("\n") == 1


def test_equal_groups_and_the_missing_one(tmp_path: Path) -> None:
    """Through two worker processes: V/C to rounding at equal groups, and not without h/Cb."""
    changes = reproduce(tmp_path, "appendix", quick=True)["tables"]["scaling"]
    for law in ("mooney-rivlin", "linear"):
        assert abs(changes[law]["size × 3, E × 2, ρ / 2"]) < 1e-6
        assert abs(changes[law]["width × 4 (h/b / 4)"]) < 1e-6
        assert abs(changes[law]["thickness × 2, circumference × 2"]) < 1e-6
        assert abs(changes[law]["circumference × 2 (h/Cb / 2)"]) > 1e-4


def test_alpha_is_fitted_through_the_origin() -> None:
    random = np.random.default_rng(3)
    inside = 0
    for _ in range(200):
        published = random.uniform(0.2, 1.0, size=30)
        fit = fit_alpha([found(x, 1.2 * x + 0.02 * random.normal()) for x in published], "bar")
        inside += abs(fit["alpha"] - 1.2) < fit["interval"]
    assert 180 <= inside <= 199  # 95 % of them, within the scatter of 200


def test_the_grid_of_alpha_is_large_enough() -> None:
    base = [values for values in scenes22(True) if "bending_scale" not in values]
    assert len(base) >= 60
    assert {values["band"] for values in base} == {"I", "II", "III", "IV"}
    assert {values["law"] for values in base} == {"mooney-rivlin", "linear"}


def test_scenes_without_an_answer_are_kept_with_their_reason() -> None:
    runs = Runs()
    runs.prepare([{"band": "IV", "strain": 2.0}])
    assert "tension peaks" in next(iter(runs.refused().values()))
    assert runs.all_of([{"band": "IV", "strain": 2.0}]) == []


def test_scorecard_entries_are_judged() -> None:
    with pytest.raises(ValueError, match="no such verdict"):
        Entry("a", "b", "c", "d", "fine")
    assert "a \\| b" in as_markdown([Entry("a | b", "c", "d", "e", "confirmed")])
