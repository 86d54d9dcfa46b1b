"""Deliberate breaks of the model, each of which the ladder must notice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beadband.model.calibration import Strand
from beadband.planning.plan import Plan
from beadband.statics.ring import LOWER, UPPER, Ring
from beadband.studies.verification import releases, report, specimen, stringlimit, verify


def failures(rung: str) -> list[str]:
    """Names of the checks of a rung that fail."""
    return [check.name for check in verify(rung) if check.failed]


def scaled(monkeypatch: pytest.MonkeyPatch, name: str, factor: float) -> None:
    """Multiply a property of the strand."""
    true = getattr(Strand, name).fget
    monkeypatch.setattr(Strand, name, property(lambda strand: factor * true(strand)))


def test_angles_twice_as_stiff(monkeypatch: pytest.MonkeyPatch) -> None:
    scaled(monkeypatch, "angle_coefficient_j", 2.0)
    for rung in ("bending", "ring", "kink"):
        assert len(failures(rung)) >= 3, rung


def test_beads_a_tenth_too_heavy(monkeypatch: pytest.MonkeyPatch) -> None:
    scaled(monkeypatch, "bead_mass_kg", 1.1)
    for rung in ("waves", "ring", "kink"):
        assert len(failures(rung)) >= 3, rung


def test_dashpots_that_push(monkeypatch: pytest.MonkeyPatch) -> None:
    true = Strand.dashpot_n_s_m
    monkeypatch.setattr(Strand, "dashpot_n_s_m", lambda strand, loss_time_s: -true(strand, loss_time_s))
    assert failures("waves") == ["linear: decay by the dashpots (1/s)"]
    assert failures("conservation")
    assert not failures("kink")  # which has no dashpots


@pytest.mark.parametrize(("column", "factor"), [(1, 1e3), (2, 1e-3), (3, 1e-3)], ids=["length", "energy", "force"])
def test_bond_table_in_another_unit(monkeypatch: pytest.MonkeyPatch, column: int, factor: float) -> None:
    true = specimen.bond_table

    def wrong(strand: Strand, strain: float) -> str:
        *head, rows = true(strand, strain).split("\n\n")
        lines = [row.split() for row in rows.splitlines()]
        for line in lines:
            line[column] = f"{factor * float(line[column]):.17g}"
        return "\n\n".join([*head, "\n".join(" ".join(line) for line in lines) + "\n"])

    monkeypatch.setattr(specimen, "bond_table", wrong)
    assert failures("bond")


@pytest.mark.parametrize("kind", ["mirrored", "mixed legs"])
def test_ring_the_wrong_way_round(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    true = releases.hold

    def wrong(plan: Plan) -> Ring:
        ring = true(plan)
        if kind == "mirrored":
            return replace(ring, positions_m=ring.positions_m * np.array([-1.0, 1.0]))
        types = ring.types.copy()
        legs = np.flatnonzero((types == UPPER) | (types == LOWER))
        types[legs] = np.where(legs % 2, UPPER, LOWER)  # neighbours along a leg no longer see each other's dashpots
        return replace(ring, types=types)

    monkeypatch.setattr(releases, "hold", wrong)
    monkeypatch.setattr(stringlimit, "_WEDGES", ((0.476, 14.0),))
    checks = verify("string")
    assert [check for check in checks if check.failed], report.table(checks)
