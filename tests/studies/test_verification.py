"""The ladder of checks: every rung holds, and says so in a table and to programs."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from beadband.errors import RunError, UsageError
from beadband.studies.verification import RUNGS, Check, report, verify
from beadband.studies.verification.specimen import decay_rate_1_s, frequency_rad_s


@pytest.mark.parametrize("rung", list(RUNGS))
def test_rung_holds(rung: str) -> None:
    checks = verify(rung)
    json.dumps(report.as_dict(checks), allow_nan=False)
    assert any(check.passed for check in checks)
    assert {check.rung for check in checks} == {rung}
    assert len({check.name for check in checks}) == len(checks)
    assert not [check for check in checks if check.failed], report.table(checks)


def test_unknown_rung_is_refused() -> None:
    with pytest.raises(UsageError, match=r"unknown rung.*bond, bending"):
        verify("bonds")


def test_errors_are_relative_unless_the_exact_value_is_zero() -> None:
    assert Check("r", "n", 1.1, 1.0, 0.2).error == pytest.approx(0.1)
    assert Check("r", "n", -2.2, -2.0, 0.05).failed
    assert Check("r", "n", 1e-3, 0.0, 1e-2).error == 1e-3
    assert not Check("r", "n", 1e-3, 0.0, 1e-2).relative
    lost = Check("r", "n", math.nan, 1.0, math.inf)
    assert lost.failed
    assert not lost.passed
    left_out = Check("r", "n", math.nan, 0.0, 1.0, skipped=True)
    assert not left_out.passed
    assert not left_out.failed


def test_a_rung_that_breaks_down_is_a_failed_check(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> list[Check]:
        raise RunError("the run diverged", "diverged")

    for name in list(RUNGS):
        monkeypatch.setitem(RUNGS, name, broken if name == "bond" else list)
    (check,) = verify()
    assert check.failed
    assert check.rung == "bond"
    assert (check.code, check.note) == ("diverged", "the run diverged")


def test_missing_programs_are_listed_as_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    from beadband.studies.verification import conservation

    monkeypatch.setattr(conservation, "program", lambda name: None if name == "mpirun" else name)
    monkeypatch.setattr(conservation, "_free_strand", list)
    monkeypatch.setattr(conservation, "_release", lambda plan: [])
    (check,) = verify("conservation")
    assert check.skipped
    assert "mpirun not found" in check.note
    assert "0 passed, 0 failed, 1 skipped" in report.table([check])


def test_report_for_people_and_programs() -> None:
    checks = [
        Check("bond", "tension (N)", 1.0001, 1.0, 1e-3),
        Check("bond", "tangent (N)", 1.5, 1.0, 1e-3, "why"),
        Check("waves", "speed (m/s)", math.nan, 1.0, 0.0, "gone"),
    ]
    lines = report.table(checks).splitlines()
    assert [line.split()[0] for line in lines if not line.startswith(" ")] == ["bond", "waves", "1"]
    assert lines[2].endswith("pass")
    assert lines[3].endswith("FAIL: why")
    values = json.loads(json.dumps(report.as_dict(checks, 1.0), allow_nan=False))
    assert values["totals"] == {"passed": 1, "failed": 2, "skipped": 0}
    assert values["checks"][2]["measured"] is None
    assert values["versions"]["lammps"]


def test_frequency_and_decay_of_known_oscillations() -> None:
    times = np.linspace(0.0, 3.0, 40)
    wave = np.exp(-0.2 * times) * np.sin(7.0 * times + 0.3)
    assert decay_rate_1_s(times, wave) == pytest.approx(0.2, rel=1e-9)
    assert frequency_rad_s(times, np.sin(7.0 * times + 0.3)) == pytest.approx(7.0, rel=1e-9)
