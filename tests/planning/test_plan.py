"""The plan keeps its word: errors within the tolerance and within the error bar, over very different scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest

from beadband.errors import UsageError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning import error_curves
from beadband.planning.plan import MOST_PLANNED_BEADS, Plan, plan_of
from beadband.runs.rear_run import estimate_of, follow_rear
from beadband.runs.results import joined_error_m_s

SCENES: list[dict[str, Any]] = [
    {"band": "I", "law": "linear", "strain": 0.0856, "half_angle_deg": 20.3, "bending_scale": 1e-4},
    {"band": "II", "law": "linear", "strain": 0.0588, "half_angle_deg": 16.0, "bending_scale": 0.0},
    {"band": "circular", "strain": 0.0747, "half_angle_deg": 31.6},
    {"band": "IV", "law": "linear", "strain": 0.052, "half_angle_deg": 27.5, "bending_scale": 4.0},
    {"band": "I", "strain": 0.1, "half_angle_deg": 5.0},
    {"band": "III", "strain": 1.2, "half_angle_deg": 5.0},
    {"band": "II", "law": "linear", "strain": 1.0, "half_angle_deg": 28.0},
]


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def codes(plan: Plan) -> set[str]:
    """Codes of a plan's warnings."""
    return {one.code for one in plan.warnings}


@pytest.mark.parametrize("values", SCENES, ids=lambda values: f"{values['band']}-{values['strain']}")
def test_planned_speed_is_within_tolerance_and_error_bar(values: dict[str, Any], session: Session) -> None:
    plan = plan_of(scene_of({**values, "for": "speed"}), "leg")
    found = follow_rear(plan, session).fitted_speed_m_s
    bar = joined_error_m_s(found, plan.beads, estimate_of(plan, session), plan.speed_error)
    finer = plan_of(scene_of({**values, "for": "speed", "beads": min(6 * plan.beads, 4000)}), "leg")
    error = abs(found.value - follow_rear(finer, session).fitted_speed_m_s.value)
    assert error < plan.scene.tolerance * found.value
    assert error < bar


@pytest.mark.parametrize("model", ["leg", "ring"])
def test_error_curve_falls_and_is_inverted(model: str) -> None:
    for tolerance in (0.1, 0.02, 0.005, 0.001, 1e-4):
        scene = scene_of({"tolerance": tolerance})
        spacing = scene.band.circumference_m / error_curves.beads_for(scene, model)
        assert error_curves.speed_error(scene, spacing, model) == pytest.approx(
            error_curves.SHARE_OF_TOLERANCE * tolerance, rel=1e-9
        )
    # First order in the spacing where the numerical loss is all that is left.
    assert error_curves.leg_speed_error(2000.0, 4000.0) / error_curves.leg_speed_error(1000.0, 2000.0) == pytest.approx(
        0.5, rel=1e-3
    )


def test_tighter_tolerances_take_more_beads_and_say_why() -> None:
    plans = [plan_of(scene_of({"tolerance": tolerance})) for tolerance in (0.02, 0.005, 0.001)]
    beads = [plan.beads for plan in plans]
    assert beads == sorted(set(beads))
    assert beads[2] / beads[1] == pytest.approx(math.sqrt(5.0), rel=0.06)  # second order in the spacing
    assert plans[1].reasons[0].code == "beads-for-curvature"
    assert "layer-needs-more-beads" in codes(plan_of(scene_of({"bending_scale": 1e-6})))


def test_a_tolerance_that_is_not_expected_is_reported_before_the_run() -> None:
    plan = plan_of(scene_of({"tolerance": 1e-6, "for": "speed"}))
    assert plan.beads == MOST_PLANNED_BEADS
    assert {"speed-needs-more-beads", "tolerance-not-expected"} <= codes(plan)
    found = next(one for one in plan.warnings if one.code == "tolerance-not-expected")
    assert found.values["value"] >= plan.speed_error > found.values["limit"] == plan.scene.tolerance
    assert "tolerance-not-expected" not in codes(plan_of(scene_of({"for": "speed"})))


@pytest.mark.parametrize("frames", [1, 7, 60, 100, 480, 5000])
def test_a_number_of_frames_never_changes_the_step(frames: int) -> None:
    usual, asked = plan_of(scene_of({})), plan_of(scene_of({"frames": frames}))
    assert (asked.timestep_s, asked.steps, asked.rear_steps) == (usual.timestep_s, usual.steps, usual.rear_steps)
    assert asked.steps % asked.frames == 0
    assert 0.5 <= asked.frames / min(frames, asked.steps) <= 2.0
    assert ("frames-adjusted" in codes(asked)) == (asked.frames != frames)


@pytest.mark.parametrize(
    ("values", "code"),
    [
        ({"circumference_m": 180.0, "width_m": 3.0, "thickness_m": 1.0}, "unusual-size"),
        ({"density_kg_m3": 1.3}, "unusual-size"),
        ({"thickness_m": 0.2e-3}, ""),
    ],
)
def test_sizes_in_another_unit_get_a_notice(values: dict[str, Any], code: str) -> None:
    assert ("unusual-size" in codes(plan_of(scene_of(values)))) == bool(code)


def test_plan_computes_no_more_than_is_asked_for() -> None:
    ring, leg = (plan_of(scene_of({"for": "speed"}), model) for model in ("ring", "leg"))
    assert (ring.model, leg.model) == ("ring", "leg")
    assert leg.beads <= ring.beads
    assert leg.bead_steps < 0.25 * ring.bead_steps
    assert leg.seconds < ring.seconds
    # A layer that reaches as far as the finger is held by it: the leg alone won't do.
    assert plan_of(scene_of({"band": "I", "bending_scale": 40.0}), "leg").model == "ring"


def test_step_ends_with_the_front_and_stays_below_the_limit() -> None:
    for values in SCENES:
        plan = plan_of(scene_of(values))
        assert plan.steps * plan.timestep_s == pytest.approx(plan.front_arrival_s, rel=1e-12)
        assert plan.timestep_s < 0.66 * plan.largest_timestep_s
        assert plan.steps % plan.frame_steps == 0
        assert plan.frame_steps % plan.rear_steps == 0


def test_a_step_of_the_users_is_kept() -> None:
    plan = plan_of(scene_of({"timestep_s": 1.3e-6}))
    assert plan.timestep_s == 1.3e-6
    assert plan.front_arrival_s <= plan.steps * 1.3e-6 < 1.03 * plan.front_arrival_s


def test_loss_without_which_a_shock_rings_is_warned_about() -> None:
    assert "lossless-shock" in codes(plan_of(scene_of({"loss_time_s": 0.0})))
    assert "lossless-shock" not in codes(plan_of(scene_of({"loss_time_s": 0.0, "law": "linear"})))


def test_bending_layer_and_window_scale_with_the_band() -> None:
    base, double = scene_of({}), scene_of({"thickness_m": 4.0e-3})
    assert double.scales.bending_layer_m == pytest.approx(2.0 * base.scales.bending_layer_m, rel=1e-12)
    window, wider = base.scales.window, double.scales.window
    assert wider.start_s == pytest.approx(2.0 * window.start_s, rel=1e-9)
    wide = scene_of({"strain": 0.9, "half_angle_deg": 30.0})
    assert wide.scales.window.reason is not None


def test_steps_that_do_not_divide_are_refused() -> None:
    with pytest.raises(UsageError, match="do not divide"):
        plan_of(scene_of({"steps": 101, "frames": 10, "rear_steps": 4, "timestep_s": 1e-7}))
    with pytest.raises(UsageError, match="too short"):
        plan_of(scene_of({"steps": 100, "frames": 10, "rear_steps": 5, "timestep_s": 1e-7}))
