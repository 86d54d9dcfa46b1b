"""Findings of the work-precision study from made-up rows: frontier, outcomes, and each sentence with its numbers."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.errors import RunError, explain
from beadband.model.scene import scene_of
from beadband.studies import pareto
from beadband.studies.pareto import cores, frontier, page, plot_elements, report
from beadband.studies.pareto.convergence import Row, pairs, row_of, with_errors
from beadband.studies.pareto.findings import findings
from beadband.studies.pareto.findings_text import SENTENCES, sentence
from beadband.studies.pareto.methods import MAIN, Method, leg_plan
from beadband.studies.pareto.outcomes import DONE, OK, OTHER_LIMIT, UNSETTLED, UNSTABLE, name_of, outcome_of
from beadband.studies.pareto.peers.verdicts import CODES as PEER_CODES
from beadband.studies.pareto.reference import Reference, extrapolated
from beadband.studies.pareto.runs import Answer, Cost

SCENE = scene_of({})
LIMITS = {MAIN: Reference(MAIN, (10.0, 5.0, 2.0), (1e-4, 1e-3, 1e-3), (1, 2, 3))}
BEADS = (96, 192, 384)
COLUMNS = (
    "family variant model beads steps bead_steps relax_s setup_s integrate_median_s integrate_min_s integrate_max_s "
    "repeats speed_m_s error_speed error_curvature_01 error_curvature_03 sure_error_speed sure_error_curvature_01 "
    "sure_error_curvature_03 own_limit own_error_speed status reason"
)


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


def made_up(
    variant: str,
    beads: int,
    speed: float | None,
    seconds: float,
    family: str = "beads",
    curvature: tuple[float, float] = (5.0, 2.0),
    code: str = "diverged",
    **changes: Any,
) -> Row:
    """A row without a run behind it; without a speed it failed with the code."""
    plan = leg_plan(SCENE, beads)
    answer = None if speed is None else Answer(speed, curvature)
    costs = [] if speed is None else [Cost(1e-3, 2e-3, seconds * share) for share in (1.0, 1.0, 1.3)]
    failure = outcome_of(RunError(explain("it diverged", "a stretch of 9", "less", "wait"), code))
    row = row_of(Method(family, variant, plan, level=beads), costs, answer, DONE if answer else failure)
    return replace(row, **changes)


def test_lucky_errors_are_not_relied_on() -> None:
    rows = with_errors(
        [made_up("production", n, v, n / 1e3) for n, v in ((96, 10.4), (192, 10.0), (384, 9.8), (768, 9.9))], LIMITS
    )
    assert rows[1].errors[0] == pytest.approx(0.0, abs=1e-15)
    assert [row.error_bounds[0] for row in rows] == pytest.approx([0.04, 0.02, 0.02, 0.01])


def test_each_outcome_is_listed_by_its_name_and_off_the_frontier() -> None:
    production = [made_up("production", n, 10.0 * (1.0 + 2.0 / n), n / 1e3) for n in (96, 192, 384)]
    elsewhere = [made_up("other", n, 10.0 * (1.01 + 0.1 / n), n / 1e5, "loss") for n in (96, 192, 384)]
    unsettled = [made_up("worse", n, 10.0 * (1.0 + n / 1e4), n / 1e5, "loss") for n in (96, 192, 384)]
    failed = [
        made_up("wild", n, None, math.nan, "integrator", code=code)
        for n, code in ((96, "diverged"), (192, "no-equilibrium"), (384, "usage"))
    ]
    unstable = made_up("96 beads", 96, 15.0, 0.1, "step", level=1.0 / 1.3)
    rows = with_errors([*production, *elsewhere, *unsettled, *failed, unstable], LIMITS)
    codes = [OK] * 3 + [OTHER_LIMIT] * 3 + [UNSETTLED] * 3 + ["diverged", "no-equilibrium", "usage"] + [UNSTABLE]
    assert [row.outcome.code for row in rows] == codes
    assert [row.family for row in frontier.frontier(rows, 0)] == ["beads"] * 3
    listed = {(entry["variant"], entry["status"]): entry["reason"] for entry in report.not_converging(rows)}
    assert set(listed) == {
        ("other", OTHER_LIMIT),
        ("worse", UNSETTLED),
        ("wild", "diverged"),
        ("wild", "no-equilibrium"),
        ("wild", "usage"),
        ("96 beads", UNSTABLE),
    }
    assert listed["wild", "diverged"] == "it diverged: a stretch of 9"
    assert "50%" in listed["96 beads", UNSTABLE]
    names = [name_of(code) for code in dict.fromkeys(codes)]
    assert len({*names}) == len(names)
    assert name_of("usage") == "refused"
    assert name_of("no-equilibrium") == "no equilibrium"
    from matplotlib import pyplot

    figure, axis = pyplot.subplots()
    plot_elements.outcome_legend(axis, rows)
    assert [text.get_text() for text in axis.get_legend().get_texts()] == names[1:]
    pyplot.close(figure)
    table = list(csv.DictReader(io.StringIO(report.csv_text(rows))))
    assert [line["status"] for line in table] == codes
    assert " ".join(table[0]) == COLUMNS
    assert table[-2]["error_speed"] == table[-2]["integrate_median_s"] == ""
    assert "wait" in table[-2]["reason"]


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


def test_second_core_pays_where_it_stays_quicker() -> None:
    times = [cores.Timing("one core", n, 10, (1.0, 1.1)) for n in (100, 1000, 10000)]
    times += [cores.Timing("two ranks", n, 10, (t,)) for n, t in ((100, 0.5), (1000, 2.0), (10000, 0.5))]
    times += [cores.Timing("two threads", n, 10, (2.0,)) for n in (100, 1000)]
    start = cores.pays_from(times, "two ranks")
    assert start == pytest.approx(math.sqrt(1000 * 10000))
    assert cores.pays_from(times, "two threads") is None


def production(speed: float = 0.4, curvature: float = 0.0, power: int = 1, cost: float = 1.0) -> list[Row]:
    """Production runs whose errors of V and of the first curvature are these over a power of the bead count."""
    return [
        made_up(
            "production",
            n,
            10.0 + 10.0 * speed / n**power,
            cost * n / 1e5,
            "beads",
            (5.0 + 5.0 * curvature / n**power, 2.0),
        )
        for n in BEADS
    ]


BASE = production(curvature=8.0)


def beside(variant: str, family: str, cost: float, off: float = 0.0, **changes: Any) -> list[Row]:
    """Production, and a variant at ``cost`` times its cost with V off by ``off``."""
    rows = [made_up(variant, n, (10.0 + 4.0 / n) * (1.0 + off), cost * n / 1e5, family) for n in BEADS]
    return [*BASE, *(replace(row, **changes) for row in rows)]


def respa(cost: float, off: float = 0.0, failed: int = 0) -> list[Row]:
    lost = made_up("bonds inside, 4 a step", 96, None, math.nan, "integrator")
    return [*beside("bonds inside, 2 a step", "integrator", cost, off), *[replace(lost, step_share=1.9)] * failed]


def ring(off: float) -> list[Row]:
    return beside("ring, all files", "model", 9.0, off, model="ring files")


POINTS = ("spline, 21 points", "bond")
FROM_ROWS = [
    ("cost-of-speed", BASE, "to 2 % after 0.96 ms (96 beads, production)"),
    ("cost-of-speed", production(cost=3.0), "to 2 % after 2.9 ms"),
    ("cost-of-speed", production(speed=4.0), "does not reach 0.5 %, 0.1 % with any method"),
    ("cost-of-speed", beside("cosine", "angle", 0.5), "(96 beads, angle: cosine)"),
    ("cost-of-speed", beside("cosine", "angle", 0.9), "(96 beads, production)"),
    ("whole-ring", ring(0.0), "takes 9 times as long at equal beads and is no more accurate"),
    ("whole-ring", ring(0.02), "is less accurate (median"),
    ("whole-ring", ring(-0.002), "is more accurate (median"),
    ("cost-of-curvature", BASE, "curvature around 0.1 t_f is accurate to 5 % after 1.9 ms (192 beads, production)"),
    ("cost-of-curvature", production(), "around 0.1 t_f is accurate to 5 % after 0.96 ms"),
    ("curvature-beads", production(), "needs as many beads as V"),
    ("curvature-beads", production(curvature=200.0, power=2), "needs 1 to 2 times as many beads"),
    ("curvature-beads", production(speed=1000.0, power=2), "needs fewer beads than V (0.25 times as many)"),
    ("table-points", beside(*POINTS, 1.0), "hardly changes V (by at most 0 % with 384 beads) or the time"),
    ("table-points", beside(*POINTS, 1.0, 0.01), "changes V (by at most 1 % with 384 beads), but hardly the time"),
    ("table-points", beside(*POINTS, 2.0), "changes the time (median 2.00 times as long), but hardly V"),
    ("angle-form", beside("cosine", "angle", 2.0, 0.01), "changes V (by at most 1 % with 384 beads) and the time"),
    ("expression", beside("lepton", "bond", 60.0), "takes 60 times as long as its table"),
    ("expression", beside("lepton", "bond", 1.0), "costs nothing extra"),
    ("expression", beside("lepton", "bond", 0.5), "saves time"),
    ("respa-gain", respa(0.5), "at best 2 times as fast (bonds inside, 2 a step, "),
    ("respa-gain", respa(0.9), "gains nothing: at best it is 1.1 times"),
    ("respa-gain", respa(0.5, 0.1), "No run of rRESPA has"),
    ("respa-failures", respa(0.5), "None of its 3 runs failed"),
    ("respa-failures", respa(0.5, 0.0, 2), "Of its 5 runs 2 failed (2 diverged), from an outer step of 1.9 times"),
]


@pytest.mark.parametrize(("code", "rows", "phrase"), FROM_ROWS)
def test_sentences_change_with_the_rows(code: str, rows: list[Row], phrase: str) -> None:
    found = findings(with_errors(rows, LIMITS), LIMITS[MAIN], [], [], 0.0)
    assert phrase in " ".join(sentence(one) for one in found if one["code"] == code)


def planned(error: float, ratio: float | None = 1.0, quantity: str = "speed") -> dict[str, Any]:
    ratios = {f"cost_over_{key}_at_its_error": ratio for key in ("production", "frontier")}
    purpose = "speed" if quantity == "speed" else "curvature"
    entry = {"quantity": quantity, "for": purpose, "tolerance": 0.01, "error": error}
    return {**entry, **ratios, "relax_s": 1e-3, "integrate_min_s": 2e-3}


FROM_PLANS = [
    ([planned(0.001)] * 2, "in all 2 cases"),
    ([planned(0.001), planned(0.02)], "in 1 of 2 cases"),
    ([planned(0.02)] * 2, "in none of 2 cases"),
    ([planned(0.001), planned(0.008, 1.0, "curvature_01")], "always within the tolerance (0.8 times"),
    ([planned(0.001), planned(0.03, 1.0, "curvature_01")], "never within the tolerance (3 times"),
    (
        [planned(0.001), *(planned(error, 1.0, "curvature_01") for error in (0.005, 0.03))],
        "not always within the tolerance (0.5 to 3",
    ),
    ([planned(0.001, 1.5)], "takes 1.5 times as long as the cheapest production run"),
    ([planned(0.001, None)], "takes an unknown multiple"),
    ([planned(0.001)], "together take 3 ms at 1 % for the speed"),
]


@pytest.mark.parametrize(("plan", "phrase"), FROM_PLANS)
def test_sentences_change_with_the_plans(plan: list[dict[str, Any]], phrase: str) -> None:
    found = findings(with_errors(BASE, LIMITS), LIMITS[MAIN], [], plan, 0.0)
    assert phrase in " ".join(sentence(one) for one in found if one["topic"] == "plan")


def timed(two: float | None, code: str = "program-missing") -> list[cores.Timing]:
    """Timings on one core, and on two ranks (as quick as one core at 100 beads), or the code of why there are none."""
    times = [cores.Timing("one core", n, 10, (1e-4,)) for n in (100, 1000)]
    failed = outcome_of(RunError("there is none", code))
    for n, seconds in ((100, 1e-4), (1000, two)):
        times.append(cores.Timing("two ranks", n, 10, (seconds,) if two and seconds else (), DONE if two else failed))
    return times


FROM_TIMES = [
    (timed(None), 0.0, "cost 100 ns at 100 beads and 10 ns at 1 000"),
    ([], 0.0, "One core could not be timed"),
    (timed(None), 0.0, "Two ranks could not be timed (2 program missing)"),
    (timed(None, "too-slow"), 0.0, "Two ranks could not be timed (2 too slow)"),
    (timed(5e-5), 0.0, "at best 2 times as fast (1 000 beads)."),
    (timed(2e-4), 0.0, "Two ranks do not pay up to 1 000 beads"),
    (timed(5e-5), 1.3, "other work was running (load average 1.3)"),
]


@pytest.mark.parametrize(("times", "load", "phrase"), FROM_TIMES)
def test_sentences_change_with_the_timings(times: list[cores.Timing], load: float, phrase: str) -> None:
    found = findings(with_errors(BASE, LIMITS), LIMITS[MAIN], times, [], load)
    assert phrase in " ".join(sentence(one) for one in found if one["topic"] == "cores")


def test_every_finding_is_tested() -> None:
    elsewhere = {
        "curvature-unknown",
        "plan-keeps",
        "plan-costs",
        "plan-seconds",
        "bead-step",
        "not-timed",
        "second-core",
        *PEER_CODES,  # test_peers.py
    }
    assert {code for code, _, _ in FROM_ROWS} | elsewhere == set(SENTENCES)


def test_without_bending_there_is_no_curvature_to_chart() -> None:
    limit = Reference(MAIN, (10.0, math.nan, math.nan), (1e-4, math.nan, math.nan), (1,))
    rows = with_errors([made_up("production", 96, 10.1, 0.1)], {MAIN: limit})
    assert list(frontier.as_dict(rows, limit)["frontier"]) == ["speed"]
    assert "curvature-unknown" in [one["code"] for one in findings(rows, limit, [], [], 0.0)]


ROOT = Path(pareto.__file__).parents[3]


def test_the_document_is_made_of_its_stored_numbers() -> None:
    stored = json.loads((ROOT / "docs/pareto.json").read_text(encoding="utf-8"))
    assert (ROOT / "docs/pareto.md").read_text(encoding="utf-8") == page.markdown(stored)


def test_a_result_is_stored_with_its_page_and_charts(tmp_path: Path) -> None:
    stored = json.loads((ROOT / "docs/pareto.json").read_text(encoding="utf-8"))
    result, docs = tmp_path / "result", tmp_path / "docs"
    result.mkdir()
    docs.mkdir()
    stored["findings"] = [one for one in stored["findings"] if one["topic"] == "speed"]
    (result / "frontier.json").write_text(json.dumps(stored), encoding="utf-8")
    (result / "pareto-peers.png").write_bytes(b"a picture")
    page.store(result, docs)
    assert (docs / "pareto.md").read_text(encoding="utf-8") == page.markdown(stored)
    assert (docs / "pareto-peers.png").read_bytes() == b"a picture"
