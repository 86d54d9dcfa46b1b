"""Peers: each adapter converges to the same answer, a stub proves the protocol, verdicts follow from numbers."""

from __future__ import annotations

import csv
import io
import json
import math
import os
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.analysis.fits import Array
from beadband.errors import UsageError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.studies.pareto import page, report
from beadband.studies.pareto.findings_text import sentence
from beadband.studies.pareto.methods import MAIN
from beadband.studies.pareto.outcomes import OK, OTHER_LIMIT
from beadband.studies.pareto.peers import (
    PEERS,
    Comparison,
    Peer,
    Trace,
    add_peer,
    answer_of,
    charts,
    compare,
    end_s,
    verdicts,
)
from beadband.studies.pareto.peers.comparison import ASK, OURS, PAIR, PLAN, SCENES, SCENES_QUICK, Point, climbed
from beadband.studies.pareto.peers.protocol import SAMPLES, installed, leg_strand, steps_of
from beadband.studies.pareto.reference import Reference, references

LINEAR = scene_of(SCENES["linear, thick and slim"])
SHOCK = scene_of({})
LEVELS = {"finite elements": (15, 30), "stock LAMMPS": (25, 100), "OpenMM": (25, 100), "Exudyn": (12, 25)}
"""Coarse and fine of each adapter; the fine one is within 0.2 % of V."""


@pytest.fixture(scope="module")
def limits() -> dict[str, Reference]:
    with Session() as session:
        return {scene.law: references(scene, 272, session, [MAIN])[MAIN] for scene in (LINEAR, SHOCK)}


def available(name: str) -> Peer:
    peer = PEERS[name]
    if not installed(peer):
        pytest.skip(f"{name} is not installed: pip install 'beadband[peers]'")
    return peer


@pytest.mark.parametrize("name", list(PEERS))
def test_an_adapter_converges_to_the_reference(name: str, limits: dict[str, Reference]) -> None:
    peer, limit = available(name), limits["linear"]
    traces = [peer.run(LINEAR, elements) for elements in LEVELS[name]]
    coarse, fine = (limit.errors(answer_of(LINEAR, trace)) for trace in traces)
    assert fine[0] < 2e-3
    assert fine[0] < 0.5 * coarse[0] or coarse[0] < 2e-3
    assert fine[1] < coarse[1]  # the tip curvature as well, with the right sign
    assert fine[1] < 0.07
    for trace in traces:
        assert 0.0 < trace.loop_s <= trace.whole_s
        assert trace.times_s[-1] == pytest.approx(end_s(LINEAR), rel=2e-2)


def test_openmm_with_friction_follows_the_shock(limits: dict[str, Reference]) -> None:
    """Without a loss V of a law with a shock would be 1.1 % off."""
    peer = available("OpenMM")
    assert limits["mooney-rivlin"].errors(answer_of(SHOCK, peer.run(SHOCK, 60)))[0] < 4e-3


def test_the_elements_of_a_leg_have_its_mass() -> None:
    strand = leg_strand(LINEAR, 40)
    band = LINEAR.band
    leg_kg = band.mass_per_length_kg_m * LINEAR.wedge.reference_leg_m
    assert 40 * strand.bead_mass_kg == pytest.approx(leg_kg, rel=1e-12)
    assert strand.angle_coefficient_j * strand.spacing_m == pytest.approx(LINEAR.bending_stiffness_n_m2, rel=1e-12)


@pytest.mark.parametrize("share", [0.3, 1.0, 30.0])
def test_steps_end_where_they_should(share: float) -> None:
    largest = share * end_s(LINEAR) / SAMPLES
    samples, between, step = steps_of(LINEAR, largest)
    assert samples * between * step == pytest.approx(end_s(LINEAR), rel=1e-12)
    assert step <= largest * (1.0 + 1e-12)


class Straight:
    """A stub: the tip moves evenly, ``off`` of the right speed."""

    package: str | None = None
    laws: tuple[str, ...] | None = None
    ladder = (10, 20)
    quick = (10, 20)
    note = "a stub"

    def __init__(self, name: str, speed_m_s: float, off: tuple[float, float] = (0.0, 0.0), **changes: Any) -> None:
        self.name, self.speed_m_s, self.off = name, speed_m_s, dict(zip(self.ladder, off, strict=True))
        self.__dict__.update(changes)

    def run(self, scene: Any, elements: int) -> Trace:
        times: Array = np.linspace(0.0, end_s(scene), 60)
        x = (1.0 + self.off[elements]) * self.speed_m_s * times
        return Trace(times, x, np.full(60, 5.0), loop_s=1e-6 * elements, whole_s=2e-6 * elements)


class Failing(Straight):
    def run(self, scene: Any, elements: int) -> Trace:
        if elements == 20:
            raise ValueError("a complaint\nof its own")
        return super().run(scene, elements)


LIMIT = Reference(MAIN, (10.0, 5.0, 2.0), (1e-4, 1e-3, 1e-3), (1, 2, 3))


def test_the_errors_of_a_stub_are_those_that_it_was_given() -> None:
    points, speeds = climbed(Straight("stub", 10.0, (0.03, -0.004)), "a scene", LINEAR, False, 2, LIMIT)
    assert [point.errors[0] for point in points] == pytest.approx([0.03, 0.004])
    assert [point.bounds[0] for point in points] == pytest.approx([0.03, 0.004])
    assert [point.whole_s for point in points] == pytest.approx([2e-5, 4e-5])
    assert speeds == pytest.approx({10: 10.3, 20: 9.96})
    assert all(point.status == OK for point in points)


def test_an_error_that_is_small_by_chance_is_bounded_by_the_finer_one() -> None:
    points, _ = climbed(Straight("stub", 10.0, (1e-4, 0.02)), "a scene", LINEAR, False, 1, LIMIT)
    assert [point.bounds[0] for point in points] == pytest.approx([0.02, 0.02])


def test_what_settles_elsewhere_and_what_fails_is_listed() -> None:
    points, _ = climbed(Straight("stub", 10.0, (0.0105, 0.01)), "a scene", LINEAR, False, 1, LIMIT)
    assert {point.status for point in points} == {OTHER_LIMIT}
    points, speeds = climbed(Failing("stub", 10.0), "a scene", LINEAR, False, 1, LIMIT)
    assert list(speeds) == [10]
    assert points[1].reason == "ValueError: a complaint of its own"
    assert math.isnan(points[1].errors[0])
    not_finite = Straight("stub", math.nan)
    assert {point.status for point in climbed(not_finite, "a scene", LINEAR, False, 1, LIMIT)[0]} == {"not-finite"}


def test_a_peer_is_checked_and_has_a_name_of_its_own() -> None:
    with pytest.raises(UsageError, match=r"no adapter.*no name, package"):
        add_peer(object())  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="two peers of one name"):
        add_peer(Straight("OpenMM", 1.0))


def test_a_plug_in_adds_a_peer(tmp_path: Path) -> None:
    """The adapter of the page, in a file of the user's."""
    text = (Path(__file__).parents[2] / "docs/peers.md").read_text(encoding="utf-8")
    code = text.split("```python\n")[1].split("```")[0].split("\n\nscene = ")[0]
    code = code.replace("import Trace,", "import Trace, add_peer,") + "\n\nadd_peer(StringLimit())\n"
    (tmp_path / "mine.py").write_text(code, encoding="utf-8")
    script = "import beadband.model.laws; from beadband.studies.pareto.peers import PEERS; print(list(PEERS)[-1])"
    env = {**os.environ, "BEADBAND_PLUGINS": str(tmp_path / "mine.py")}
    done = subprocess.run([sys.executable, "-c", script], env=env, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "string limit"


@pytest.fixture(scope="module")
def compared() -> Comparison:
    """One scene, small, with stubs for peers."""
    speed = scene_of(SCENES["linear, thin and wide"]).string.rear_speed_m_s
    peers = [
        Straight("string", speed),
        Failing("failing", speed),
        Straight("absent", speed, package="no_such_package_at_all"),
        Straight("rubber alone", speed, laws=("mooney-rivlin",)),
    ]
    extent = replace(
        SCENES_QUICK, beads=(48, 96), variants=(), respa=(), spline_points=(), linear_points=(), losses=(), repeats=1
    )
    return compare(True, {"thin": SCENES["linear, thin and wide"]}, peers, extent)


def test_everything_is_compared_on_the_same_axes(compared: Comparison, tmp_path: Path) -> None:
    counts = {tool: sum(point.tool == tool for point in compared.points) for tool in (OURS, PAIR, PLAN, ASK)}
    assert counts == {OURS: 2, PAIR: 1, PLAN: 6, ASK: 4}
    limit = compared.references["thin"]
    off = abs(compared.scenes["thin"].string.rear_speed_m_s / limit.values[0] - 1.0)
    stub = [point for point in compared.points if point.tool == "string"]
    assert [point.errors[0] for point in stub] == pytest.approx([off, off], rel=1e-9)
    assert compared.absent == ["absent"]
    assert not any(point.tool in ("absent", "rubber alone") for point in compared.points)
    texts = [sentence(asdict(one)) for one in verdicts.findings(compared)]
    assert "Absent is not installed: pip install 'beadband[peers]'." in texts
    assert "Rubber alone takes mooney-rivlin alone: no scene was for it." in texts
    assert "1 of its runs failed (ValueError: a complaint of its own)." in texts
    table = list(csv.DictReader(io.StringIO(verdicts.csv_text(compared))))
    assert len(table) == len(compared.points)
    assert [row["reason"] for row in table if row["tool"] == "failing"] == ["", "ValueError: a complaint of its own"]
    written = charts.draw(compared, tmp_path)
    assert {path.name for path in written if path.stat().st_size > 5000 and path.suffix == ".png"} == {
        "pareto-peers.png",
        "pareto-peers-scenes.png",
        "pareto-peers-curvature.png",
    }
    stored = json.loads(json.dumps(report.finite(verdicts.as_dict(compared)), allow_nan=False))
    found = [asdict(one) for one in verdicts.findings(compared)]
    made = "\n".join(page._peers({"peers": stored, "findings": found}))
    assert "| thin | III | linear | 0.6 | 0.8 | 28° |" in made
    assert "* **absent**: a stub. Not installed: `pip install 'beadband[peers]'`." in made
    assert "| string | 0.02 % | 0 of 1 | - | - | - | - |" in made


def made_up(peer_ms: float, plan_ms: float, ask_ms: float, plan_error: float = 1e-3) -> Comparison:
    """A peer that reaches 0.5 % and no more, beside a plan and an answer."""

    def point(tool: str, level: float, ms: float, error: float, variant: str = "") -> Point:
        three = (error, math.nan, math.nan)
        return Point("s", tool, level, three, three, 1e-3 * ms, 1e-3 * ms, variant=variant)

    points = [point("string", 20, peer_ms, 4e-3), point("string", 10, 0.5 * peer_ms, 0.1)]
    for tolerance in (0.02, 0.005):
        points += [
            point(PLAN, tolerance, plan_ms, plan_error, f"plan: speed {100 * tolerance:g} %, 9 beads"),
            point(PLAN, tolerance, 1e-3, 1e-9, "plan: curvature, 9 beads"),
            point(ASK, tolerance, ask_ms, 1e-4),
        ]
    points.append(point(OURS, 96, 1.0, 1e-4, "beads: production, 96 beads"))
    return Comparison(tuple(points), {"s": LINEAR}, {"s": LIMIT}, (Straight("string", 1.0),), {"s": 2e-4})


@pytest.mark.parametrize(
    ("times", "behind", "phrases"),
    [
        (
            (8.0, 4.0, 2.0),
            0,
            ["in all 2 cases", "0.5 % on 1 of 1 (the plan 2; asking 4 times", "not reach 0.1 %, 0.02 %"],
        ),
        ((8.0, 16.0, 2.0), 0, ["in all 2 cases", "the plan 0.5; asking 4 times"]),
        ((8.0, 16.0, 32.0), 2, ["in 0 of 2 cases", "In the other 2", "quicker than the program in 2 of them"]),
        ((0.5, 4.0, 2.0), 2, ["quicker than the program in 0 of them"]),
    ],
)
def test_verdicts_follow_from_the_times(times: tuple[float, float, float], behind: int, phrases: list[str]) -> None:
    compared = made_up(*times)
    assert len(verdicts.exceptions(compared)) == behind
    text = " ".join(sentence(asdict(one)) for one in verdicts.findings(compared))
    assert [phrase for phrase in phrases if phrase not in text] == []
    assert "agree with the reference to 0.02 % in the median" in text
    assert {one.code for one in verdicts.findings(compared)} <= set(verdicts.CODES)


def test_a_plan_beyond_its_tolerance_is_not_ahead() -> None:
    compared = made_up(8.0, 1.0, 100.0, plan_error=6e-3)
    assert [case["tolerance"] for case in verdicts.exceptions(compared)] == [0.005]
    text = " ".join(sentence(asdict(one)) for one in verdicts.findings(compared))
    assert "though beyond the tolerance on 1" in text


def test_the_median_frontier_is_reached_on_more_than_half_of_the_scenes() -> None:
    points = [
        Point(scene, OURS, 1, bounds=(error, math.nan, math.nan), whole_s=1e-3 * ms, variant="beads: production")
        for scene, ms, error in (("a", 1.0, 0.1), ("a", 4.0, 0.01), ("b", 2.0, 0.1), ("b", 8.0, 0.01), ("c", 3.0, 0.1))
    ]
    front = charts.median_frontier(points, ["a", "b", "c"], 0)
    assert front == [(8.0, 0.01), (2.0, 0.1)]
