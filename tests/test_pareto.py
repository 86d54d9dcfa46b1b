"""The work-precision diagram: its frontier, its judgement, and that every method solves the same problem."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from beadband import pareto
from beadband.engine import Session
from beadband.errors import RunError, UsageError
from beadband.follow import follow_rear
from beadband.pareto import cores, frontier, report
from beadband.pareto.folds import FOLDS, angle_table
from beadband.pareto.judgement import BLEW_UP, ELSEWHERE, OK, Row, judged, pairs, row_of
from beadband.pareto.methods import LINEAR, LOSSY, MAIN, STRING, Method, leg_plan, methods, ring_plan, with_step
from beadband.pareto.reference import Reference, extrapolated, references
from beadband.pareto.runs import Answer, Cost, hold_by, run_once
from beadband.scene import scene_of

SCENE = scene_of({})


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def naive(points: list[tuple[float, float]]) -> set[tuple[float, float]]:
    """Points that no other is as good as in both and better than in one, by the definition."""
    good = [p for p in points if all(map(math.isfinite, p)) and p[0] > 0.0]
    return {p for p in good if not any(q[0] <= p[0] and q[1] <= p[1] and q != p for q in good)}


def test_frontier_is_the_non_dominated_set() -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        # Small whole numbers: full of ties.
        points = [(float(c), float(e)) for c, e in rng.integers(1, 8, (30, 2))]
        points += [(math.nan, 0.0), (1.0, math.nan), (math.inf, 0.0), (0.0, 0.0), (1.0, math.inf)]
        chosen = [points[i] for i in frontier.non_dominated(points)]
        assert set(chosen) == naive(points)
        assert len(chosen) == len(set(chosen))
        assert chosen == sorted(chosen)
        assert [error for _, error in chosen] == sorted((error for _, error in chosen), reverse=True)


def test_frontier_of_equal_points_is_the_first_of_them() -> None:
    assert frontier.non_dominated([(1.0, 1.0), (1.0, 1.0), (2.0, 1.0), (1.0, 2.0)]) == [0]
    assert frontier.non_dominated([]) == []
    assert frontier.non_dominated([(math.nan, 1.0)]) == []


TRUTH = {MAIN: Reference(MAIN, (10.0, 5.0, 2.0), (1e-4, 1e-3, 1e-3), (1, 2, 3))}


def made_up(variant: str, beads: int, speed: float | None, seconds: float, family: str = "beads") -> Row:
    """A row without a run behind it."""
    plan = leg_plan(SCENE, beads)
    answer = None if speed is None else Answer(speed, (5.0, 2.0))
    costs = [] if speed is None else [Cost(1e-3, 2e-3, seconds * share) for share in (0.9, 1.0, 1.3)]
    return row_of(Method(family, variant, plan, level=beads), costs, answer, "" if answer else "it blew up")


def test_lucky_errors_are_not_relied_on() -> None:
    rows = judged(
        [made_up("production", n, v, n / 1e3) for n, v in ((96, 10.4), (192, 10.0), (384, 9.8), (768, 9.9))], TRUTH
    )
    assert rows[1].errors[0] == pytest.approx(0.0, abs=1e-15)
    assert [row.sure_errors[0] for row in rows] == pytest.approx([0.04, 0.02, 0.02, 0.01])


def test_failures_and_strays_are_listed_and_no_frontier() -> None:
    production = [made_up("production", n, 10.0 * (1.0 + 2.0 / n), n / 1e3) for n in (96, 192, 384)]
    elsewhere = [made_up("other", n, 10.0 * (1.01 + 0.1 / n), n / 1e5, "loss") for n in (96, 192, 384)]
    blown = [made_up("wild", n, None, math.nan, "integrator") for n in (96, 192)]
    rows = judged([*production, *elsewhere, *blown], TRUTH)
    assert [row.status for row in rows] == [OK] * 3 + [ELSEWHERE] * 3 + [BLEW_UP] * 2
    front = frontier.frontier(rows, 0)
    assert [row.family for row in front] == ["beads"] * 3
    listed = {(entry["variant"], entry["status"]) for entry in report.strays(rows)}
    assert listed == {("other", ELSEWHERE), ("wild", BLEW_UP)}
    table = list(csv.DictReader(io.StringIO(report.csv_text(rows))))
    assert len(table) == len(rows)
    assert tuple(table[0]) == report.COLUMNS
    assert table[-1]["error_speed"] == table[-1]["integrate_median_s"] == ""
    assert table[-1]["reason"] == "it blew up"


def test_pairs_cost_both_runs_and_cancel_the_first_order() -> None:
    rows = [made_up("production", n, 10.0 * (1.0 + 3.0 / n), n / 1e3) for n in (96, 192)]
    (pair,) = pairs(rows)
    assert pair.answer is not None
    assert pair.answer.speed_m_s == pytest.approx(10.0, rel=1e-14)
    assert pair.median_s == pytest.approx(0.288)
    assert pair.bead_steps == sum(row.bead_steps for row in rows)


def test_reference_is_exact_for_the_order_that_it_assumes() -> None:
    beads = (100, 140, 200)
    answers = [(10.0 + 2.0 / n, 5.0 - 7.0 / n**2, 2.0 + 9.0 / n**2) for n in beads]
    found = extrapolated("made up", beads, answers, (1, 2, 2))
    assert found.values == pytest.approx((10.0, 5.0, 2.0), rel=1e-13)
    assert found.uncertainties[0] == pytest.approx(0.5 * 2.0 / 200, rel=1e-9)


@pytest.mark.parametrize("name", list(FOLDS))
def test_angle_energies_have_their_derivatives_and_one_limit(name: str) -> None:
    psi, step = np.linspace(0.05, 2.0, 40), 1e-6
    energy, slope, curve = FOLDS[name](psi)
    above, below = FOLDS[name](psi + step), FOLDS[name](psi - step)
    assert (above[0] - below[0]) / (2.0 * step) == pytest.approx(slope, rel=1e-7)
    assert (above[1] - below[1]) / (2.0 * step) == pytest.approx(curve, rel=1e-7, abs=1e-8)
    small = np.array([1e-3])
    assert FOLDS[name](small)[0] == pytest.approx(0.5 * small**2, rel=1e-6)
    assert energy.min() > 0.0


def test_angle_table_is_the_energy_and_its_force() -> None:
    rows = [line.split() for line in angle_table(3.0).split("TIP")[0].splitlines() if line[:1].isdigit()]
    theta, energy, force = np.array(rows, dtype=float)[1200:, 1:].T
    turning = np.pi - np.radians(theta)
    assert energy == pytest.approx(3.0 * FOLDS["rod"](turning)[0], rel=1e-9, abs=1e-15)
    assert -np.gradient(energy, theta)[1:-1] == pytest.approx(force[1:-1], rel=1e-4, abs=1e-6)


def test_production_variant_is_the_production_script(session: Session) -> None:
    plan = leg_plan(SCENE, 160)
    answer, cost = run_once(Method("beads", "production", plan), session)
    assert answer.speed_m_s == follow_rear(plan, session).speed_m_s.value
    assert 0.0 < cost.integrate_s < 1.0


# Largest deviations of V and of the tip curvature around 0.1 of the arrival from the production run of as many beads;
# what other angles and integrators differ by is of the second order in spacing and step.
SAME = {
    ("bond", "spline, 51 points"): (1e-6, 1e-5),
    ("bond", "spline, 2001 points"): (1e-8, 1e-7),
    ("bond", "linear, 201 points"): (5e-5, 1e-4),
    ("bond", "linear, 2001 points"): (1e-6, 1e-5),
    ("bond", "lepton"): (1e-8, 1e-7),
    ("angle", "harmonic"): (2e-4, 2e-3),
    ("angle", "cosine"): (2e-4, 4e-3),
    ("angle", "rod table"): (2e-4, 2e-3),
    ("loss", "dpd/ext/tstat"): (1e-8, 1e-7),
    ("loss", "numerical 0.1"): (1e-3, 2e-3),
    ("output", "samples, not means"): (1e-5, 2e-3),
    ("output", "text dump"): (1e-9, 1e-9),
    ("output", "numpy, step by step"): (1e-5, 2e-3),
    ("integrator", "bonds inside, 2 a step"): (2e-4, 1e-2),
    ("integrator", "angles inside, 2 a step"): (2e-4, 5e-3),
    ("model", "ring, rear alone written"): (1e-4, 3e-3),
    ("model", "ring with contact"): (1e-4, 3e-3),
}
ELSE = {
    ("bond", "harmonic"): LINEAR,
    ("bond", "spline of linear law"): LINEAR,
    ("loss", "physical"): LOSSY,
    ("model", "leg without bending"): STRING,
}


@pytest.fixture(scope="module")
def moderate() -> dict[tuple[str, str], Method]:
    """Each variant of the quick diagram with 384 beads."""
    return {(m.family, m.variant): m for m in methods(SCENE, True) if m.plan.beads == 384 and m.family != "step"}


def test_every_method_is_named_here(moderate: dict[tuple[str, str], Method]) -> None:
    others = {
        ("beads", "production"),
        ("angle", "rod"),  # the table's energy as an expression, forty times slower
        ("loss", "none"),
        ("loss", "numerical 0.8"),
        ("integrator", "bonds inside, 4 a step"),
        ("integrator", "angles inside, 4 a step"),
        ("model", "ring, all files"),
    }
    assert set(moderate) == set(SAME) | set(ELSE) | others
    assert {key: method.own for key, method in moderate.items() if method.own != MAIN} == ELSE


@pytest.mark.parametrize("key", list(SAME), ids=lambda key: ": ".join(key))
def test_method_solves_the_same_problem(
    key: tuple[str, str], moderate: dict[tuple[str, str], Method], session: Session
) -> None:
    ours, _ = run_once(moderate["beads", "production"], session)
    other, _ = run_once(moderate[key], session)
    for_speed, for_curvature = SAME[key]
    assert other.speed_m_s == pytest.approx(ours.speed_m_s, rel=for_speed)
    assert other.curvature_1_m[0] == pytest.approx(ours.curvature_1_m[0], rel=for_curvature)


def test_other_limits_are_reached(moderate: dict[tuple[str, str], Method], session: Session) -> None:
    """Harmonic bonds solve the linear law as its spline does; without bending the string's exact speed comes out."""
    harmonic, spline = (run_once(moderate["bond", name], session)[0] for name in ("harmonic", "spline of linear law"))
    assert harmonic.speed_m_s == pytest.approx(spline.speed_m_s, rel=1e-7)
    bare, _ = run_once(moderate["model", "leg without bending"], session)
    assert bare.speed_m_s == pytest.approx(SCENE.string.rear_speed_m_s, rel=2e-3)
    lossy, _ = run_once(moderate["loss", "physical"], session)
    ours, _ = run_once(moderate["beads", "production"], session)
    assert abs(lossy.speed_m_s / ours.speed_m_s - 1.0) > 2e-3


@pytest.mark.parametrize("angle", ["harmonic", "cosine", "rod"])
def test_leg_is_held_by_the_angles_that_it_is_released_with(angle: str) -> None:
    plan = leg_plan(SCENE, 384)
    own = hold_by(Method("angle", angle, plan, choices={"angle": angle}))
    house = hold_by(Method("angle", "house", plan))
    assert own.net_force < 1e-11
    assert np.abs(own.positions_m - house.positions_m).max() > 1e-3 * plan.scene.strand(384).spacing_m


def test_too_long_a_step_blows_up_with_a_reason(session: Session) -> None:
    plan = with_step(leg_plan(SCENE, 96), 1.3)
    with pytest.raises(RunError, match="blew up"):
        run_once(Method("step", "beyond", plan), session)


def test_step_keeps_the_end_of_the_run() -> None:
    plan = leg_plan(SCENE, 272)
    for share, inner in ((0.1, 1), (0.95, 1), (0.5, 4)):
        other = with_step(plan, share, inner)
        assert other.steps * other.timestep_s == pytest.approx(plan.steps * plan.timestep_s, rel=1e-12)
        assert other.timestep_s <= share * inner * plan.largest_timestep_s * (1.0 + 1e-12)
        assert other.steps % other.rear_steps == 0


def test_reference_of_the_string_is_exact_and_others_tell_their_spread(session: Session) -> None:
    found = references(SCENE, True, session, [STRING])[STRING]
    assert found.values[0] == SCENE.string.rear_speed_m_s
    assert math.isnan(found.values[1])


def test_scene_too_stiff_for_a_leg_is_refused() -> None:
    with pytest.raises(UsageError, match="leg"):
        leg_plan(scene_of({"bending_scale": 400.0}), 96)


def test_second_core_pays_where_it_stays_quicker() -> None:
    times = [cores.Timing("one core", n, 10, (1.0, 1.1)) for n in (100, 1000, 10000)]
    times += [cores.Timing("two ranks", n, 10, (t,)) for n, t in ((100, 0.5), (1000, 2.0), (10000, 0.5))]
    times += [cores.Timing("two threads", n, 10, (2.0,)) for n in (100, 1000)]
    start = cores.pays_from(times, "two ranks")
    assert start == pytest.approx(math.sqrt(1000 * 10000))
    assert cores.pays_from(times, "two threads") is None


def test_tiny_diagram(session: Session) -> None:
    few = [Method("beads", "production", leg_plan(SCENE, n), level=n) for n in (48, 96, 192)]
    few += [Method("model", "ring", ring_plan(SCENE, 96), model="ring", level=96)]
    few += [Method("step", "beyond", with_step(leg_plan(SCENE, 96), 1.3), level=1 / 1.3)]
    rows = pareto.measured([*few, *pareto.plans(SCENE)[:2]], session, repeats=2)
    truth = {MAIN: Reference(MAIN, (17.325, 325.6, 111.3), (0.002, 0.1, 0.05), (1536,))}
    rows = judged([*rows, *pairs(rows)], truth)
    assert [row.status for row in rows if row.family == "step"] == [BLEW_UP]
    assert all(len(row.integrate_s) == 2 for row in rows if row.answer)
    result = report.finite(frontier.as_dict(rows, truth[MAIN]))
    assert {entry["family"] for entry in result["frontier"]["speed"]} <= {"beads", "pair", "model"}
    plan = next(entry for entry in result["plan"] if entry["quantity"] == "speed" and entry["tolerance"] == 0.02)
    assert plan["error"] < 0.02
    assert plan["cost_over_frontier_at_tolerance"] is not None
    ring = next(row for row in rows if row.family == "model")
    assert ring.bead_steps > 3 * next(row for row in rows if row.beads == 96).bead_steps


def test_without_bending_there_is_no_curvature_to_chart() -> None:
    truth = Reference(MAIN, (10.0, math.nan, math.nan), (1e-4, math.nan, math.nan), (1,))
    rows = judged([replace(made_up("production", 96, 10.1, 0.1), level=96.0)], {MAIN: truth})
    assert list(frontier.as_dict(rows, truth)["frontier"]) == ["speed"]
