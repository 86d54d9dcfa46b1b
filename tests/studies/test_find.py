"""What gives a wanted speed: the speed of the found value is the wanted one, and what can't be reached is refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import beadband
from beadband.cli import main
from beadband.errors import UsageError
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import rear_run
from beadband.studies.find import FOUND, _crossings, find


@pytest.mark.parametrize(
    ("parameter", "speed", "values"),
    [
        ("strain", 15.0, {}),
        ("half-angle", 17.0, {"law": "linear"}),
        ("circumference", 15.2, {"band": "I", "strain": 0.2}),
    ],
    ids=str,
)
def test_a_run_of_the_value_has_the_speed(parameter: str, speed: float, values: dict[str, object]) -> None:
    found = find(values, parameter, speed)
    assert found.parameter == parameter
    again = rear_run(
        plan_of(scene_of({**values, FOUND[parameter]: found.value, "for": "speed", "tolerance": 2e-3}), "leg")
    )
    assert abs(again.speed.value - speed) <= again.speed.error + found.answer.error
    assert abs(found.speed_m_s - speed) <= found.answer.error
    assert found.error > 0.0


def test_the_error_is_that_of_the_speed_over_its_slope() -> None:
    """d ln V/d ln strain is 0.80 for the default scene."""
    found = find({}, "strain", 17.317)
    assert found.value == pytest.approx(0.476, abs=found.error)
    stated = found.answer.error / 17.317 / 0.80 * 0.476
    assert stated <= found.error <= 1.6 * stated


def test_a_finer_tolerance_gives_a_finer_value() -> None:
    coarse, fine = find({"tolerance": 0.01}, "strain", 16.0), find({"tolerance": 3e-4}, "strain", 16.0)
    assert fine.error < 0.5 * coarse.error
    assert abs(fine.value - coarse.value) <= fine.error + coarse.error


def test_a_speed_out_of_reach_is_refused_with_the_range(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(
        UsageError, match=r"no strain gives this speed: given --speed 500; allowed: .* m/s, at"
    ) as refused:
        find({}, "strain", 500.0)
    assert refused.value.code == "unreachable"
    assert main(["find", "thickness", "--speed", "3"]) == 2
    assert "allowed" in capsys.readouterr().err


def test_requests_that_make_no_sense_are_refused() -> None:
    with pytest.raises(UsageError, match="--strain is what is to be found"):
        find({"strain": 0.4}, "strain", 15.0)
    with pytest.raises(UsageError, match="speed is out of range"):
        find({}, "strain", math.nan)
    with pytest.raises(UsageError, match="unknown parameter to find"):
        find({}, "density", 15.0)


def test_roots_are_counted_where_the_error_lets_them() -> None:
    over = np.array([-3.0, -1.0, 1.0, 3.0, 1.0, -1.0, -3.0])
    assert _crossings(over, np.full(7, 0.5)) == [1, 4]
    assert _crossings(over, np.full(7, 2.0)) == [1, 4]
    # A difference that its error hides changes its sign once.
    assert _crossings(np.array([-0.1, 0.1, -0.1, 0.1]), np.full(4, 1.0)) == [0]
    assert _crossings(np.array([1.0, 2.0]), np.full(2, 0.1)) == []


def test_command_line_and_python(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["find", "strain", "--speed", "15", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"parameter", "value", "error", "unit", "speed_m_s", "evaluations"} <= said.keys()
    found = beadband.find("strain", speed=15)
    assert found.value == pytest.approx(said["value"], rel=1e-9)
    assert str(found).startswith("strain 0.3")
    assert main(["find", "half-angle", "--speed", "18"]) == 0
    assert "speeds were asked for" in capsys.readouterr().out
