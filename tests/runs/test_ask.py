"""Answers: within the tolerance, or flagged; true errors within the stated ones; arrays as one by one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beadband
from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning import ladder
from beadband.planning.plan import Plan
from beadband.runs import ask as asking
from beadband.runs.ask import Answer, ask, question_of
from beadband.runs.ask_many import Answers, ask_many, ask_one
from beadband.runs.measurement import Measurement
from beadband.runs.rear_run import follow_rear


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


@pytest.mark.parametrize(
    ("values", "tight"),
    [
        ({}, 7e-4),
        ({"law": "linear"}, 7e-4),
        ({"band": "I", "strain": 0.3, "half_angle_deg": 10.0}, 7e-4),
        ({"band": "IV", "strain": 0.9}, 5e-4),
    ],
    ids=str,
)
def test_an_answer_keeps_its_word_at_every_tolerance(values: dict[str, object], tight: float, session: Session) -> None:
    """Against whole legs with three times the beads of the finest level that was asked for."""
    answers = {
        tolerance: ask(scene_of({**values, "tolerance": tolerance}), session=session) for tolerance in (0.02, tight)
    }
    fine = question_of(scene_of({**values, "tolerance": 0.25 * tight}), "speed")
    levels = [level for level in range(40) if fine.beads(level) <= 3 * answers[tight].beads][-1:-10:-4]
    speeds = np.array([follow_rear(fine.plan(level), session).fitted_speed_m_s.value for level in levels])
    true = fine.limit(np.array([fine.beads(level) for level in levels], dtype=np.float64), speeds)
    assert answers[0.02].model == "formula"
    assert answers[0.02].runs == 0
    assert answers[tight].runs > 1
    for tolerance, answer in answers.items():
        assert answer.within_tolerance
        assert answer.error <= tolerance * answer.value
        assert abs(answer.value - true.value) <= answer.error
        assert true.error < 0.3 * answer.error


def test_what_can_not_be_had_is_flagged(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ladder, "MOST_BEADS", 300)
    answer = ask(scene_of({"tolerance": 1e-4}), session=session)
    assert answer.error > 1e-4 * answer.value
    assert not answer.within_tolerance
    assert answer.beads <= 300
    assert "ladder-ends" in [one.code for one in answer.notices]
    assert any("best to be had" in sentence for sentence in answer.warnings)


def test_the_curvature_is_a_number_of_its_own(session: Session) -> None:
    answer = ask(scene_of({"tolerance": 0.01}), "curvature", session)
    assert answer.unit == "1"
    assert answer.value == pytest.approx(0.637, abs=0.01)
    assert answer.error <= 0.01 * answer.value
    with pytest.raises(UsageError, match="no self-similar window"):
        ask(scene_of({"strain": 1.2, "half_angle_deg": 20.0, "thickness_m": 0.5e-3}), "curvature", session)
    with pytest.raises(UsageError, match="unknown quantity"):
        ask(scene_of({}), "colour", session)


def test_errors_of_the_inputs_are_stated_beside(session: Session) -> None:
    answer = ask(scene_of({"inputs": "as-printed", "tolerance": 0.02}), session=session)
    assert answer.input_error == pytest.approx(0.020 * answer.value, rel=0.08)
    assert ask_one({"tolerance": 0.02}, session=session).input_error is None


def test_arrays_are_answered_as_one_by_one(session: Session) -> None:
    """Sizes, words and tolerances; most by formula, some by runs; in the order in which they were given."""
    strain, bands = [0.3, 0.476, 0.9], [["I"], ["III"]]
    found = ask_many({"strain": strain, "band": bands, "tolerance": [0.02, 0.02, 2e-3]}, session=session)
    assert isinstance(found, Answers)
    assert found.value.shape == found.error.shape == found.model.shape == (2, 3)
    for i, (band,) in enumerate(bands):
        for j, (one, tolerance) in enumerate(zip(strain, (0.02, 0.02, 2e-3), strict=True)):
            single = ask(scene_of({"strain": one, "band": band, "tolerance": tolerance}), session=session)
            assert found.value[i, j] == pytest.approx(single.value, rel=1e-9)
            assert found.error[i, j] == pytest.approx(single.error, rel=1e-6)
            assert found.model[i, j] == single.model
    assert found.within_tolerance.all()


@pytest.mark.parametrize(
    "values",
    [
        {"c10": np.array([1.2e5, 1.9e5, -1e4]), "c01": np.array([2e5, 1e5, 3e5]), "modulus": np.array([1e6, 2e6, 3e6])},
        {"law": "linear", "modulus": np.array([[1e6, 2e6], [3e6, 4e6]]), "strain": [0.3, 0.6]},
        {"law": "gent", "mu": np.array([2e5, 4e5]), "jm": np.array([30.0, 4.0]), "strain": 1.1},
    ],
    ids=["softening", "linear", "stiffening"],
)
def test_constants_of_a_law_may_be_arrays(values: dict[str, Any], session: Session) -> None:
    """All of a softening law by one evaluation, others one kind after another: the same as one by one."""
    arrays = {key: np.asarray(one) for key, one in values.items() if not isinstance(one, (str, float))}
    many = beadband.ask(tolerance=0.02, **values)
    for at in np.ndindex(many.value.shape):
        own = {key: float(np.broadcast_to(one, many.value.shape)[at]) for key, one in arrays.items()}
        single = beadband.ask(tolerance=0.02, **{**values, **own})
        assert many.value[at] == pytest.approx(single.value, rel=1e-9)
        assert many.error[at] == pytest.approx(single.error, rel=1e-6)


def test_an_array_of_constants_without_an_answer_is_refused() -> None:
    with pytest.raises(UsageError, match="tension peaks"):
        beadband.ask(c10=np.array([1e5, -2.4e4]), c01=np.array([1e5, 4.6e4]))


def test_python_takes_the_flags_as_keywords() -> None:
    one = beadband.ask(band="III", strain=0.476, half_angle=14, tolerance=0.02)
    assert isinstance(one, Answer)
    assert (one.model, one.unit) == ("formula", "m/s")
    many = beadband.ask(strain=np.linspace(0.2, 0.9, 5), half_angle=14.0, tolerance=0.02)
    assert np.all(np.diff(many.value) > 0.0)
    assert beadband.ask(beadband.scene(tolerance=0.02)).value == pytest.approx(one.value, rel=1e-12)
    with pytest.raises(UsageError, match="strain is out of range"):
        beadband.ask(strain=np.array([0.3, -0.3]))
    with pytest.raises(UsageError, match="too wide for its strain"):
        beadband.ask(strain=np.array([0.3, 7.0]))
    with pytest.raises(UsageError, match="--beads is not used"):
        beadband.ask(beads=100)


def test_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["ask", "--strain", "0.6", "--tolerance", "0.02", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"value", "error", "unit", "model", "runs", "beads", "seconds", "input_error", "warnings"} <= said.keys()
    assert said["error"] <= 0.02 * said["value"]
    assert main(["ask", "--quantity", "curvature", "--tolerance", "0.05"]) == 0
    assert "tip curvature over that of Eq. 7" in capsys.readouterr().out
    assert main(["ask", "--beads", "100"]) == 2
    assert "--beads is not used by 'beadband ask'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_levels_that_fail_are_passed_over(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    """Too few beads for a finger, or for an equilibrium: the ladder goes on to finer ones, and gives up in the end."""
    followed = asking.follow_rear

    def fails_below(beads: int) -> None:
        def follow(plan: Plan, session: Session) -> Measurement:
            if plan.beads < beads:
                raise RunError("too few beads")
            return followed(plan, session)

        monkeypatch.setattr(asking, "follow_rear", follow)

    scene = scene_of({"tolerance": 6e-4})
    fails_below(400)
    answer = ask(scene, session=session)
    assert answer.within_tolerance
    assert answer.beads > 400
    fails_below(10**9)
    with pytest.raises(RunError, match="too few beads"):
        ask(scene, session=session)
