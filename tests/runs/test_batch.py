"""Many legs in one instance: each is what it is alone, to the last digit, and one that fails takes no other down."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from beadband.errors import BeadbandError, RunError
from beadband.lammps.engine import Session
from beadband.lammps.scripts import script_text
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs import batch
from beadband.runs.batch import follow_rears
from beadband.runs.held import hold_leg, hold_legs
from beadband.runs.measurement import Measurement
from beadband.runs.rear_run import follow_rear, rear_run, rear_runs


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def a_plan(rng: random.Random) -> Plan:
    """A leg that is cheap to release: any band of the catalogue, both of its laws or one that locks, thin or thick."""
    values = {
        "band": rng.choice(["I", "II", "III", "IV"]),
        "law": rng.choice(["linear", "mooney-rivlin", "mooney-rivlin"]),
        "strain": rng.uniform(0.15, 1.0),
        "half_angle_deg": rng.uniform(6.0, 25.0),
        "beads": 4 * rng.randrange(20, 40),
        "for": rng.choice(["speed", "curvature"]),
    }
    if rng.random() < 0.2:
        values |= {"band": "III", "law": "gent", "mu_pa": 3e5, "jm": 30.0}
    elif rng.random() < 0.3:
        values["thickness_m"] = rng.uniform(5e-4, 2e-3)
    return plan_of(scene_of(values), "leg")


def numbers(found: Measurement | BeadbandError) -> list[bytes]:
    """All that was measured, to the last bit."""
    assert isinstance(found, Measurement)
    rear = found.rear
    return [
        np.array(found.fitted_speed_m_s).tobytes(),
        *(getattr(rear, name).tobytes() for name in ("times_s", "tip_x_m", "tip_speed_m_s", "tip_curvature_1_m")),
    ]


def test_a_leg_does_not_depend_on_its_companions(session: Session) -> None:
    rng = random.Random(5)
    plans = [a_plan(rng) for _ in range(24)]
    assert all(plan.model == "leg" for plan in plans)
    alone = [numbers(follow_rear(plan, session)) for plan in plans]
    # Fewer batches than legs, or this shows nothing.
    assert len(list(batch._batches(plans, range(len(plans))))) < 16
    for _ in range(3):
        some = rng.sample(range(len(plans)), rng.randrange(8, len(plans)))
        found = follow_rears([plans[place] for place in some], session)
        assert [numbers(one) for one in found] == [alone[place] for place in some]


def test_held_legs_do_not_depend_on_their_companions() -> None:
    rng = random.Random(6)
    plans = [a_plan(rng) for _ in range(12)]
    for plan, leg in zip(plans, hold_legs(plans), strict=True):
        assert not isinstance(leg, RunError)
        assert leg.net_force < 1e-11
        assert np.array_equal(leg.positions_m, hold_leg(plan).positions_m)


def test_a_leg_that_fails_takes_no_other_down(session: Session) -> None:
    plans = [
        plan_of(scene_of({"beads": 100, "for": "speed", "half_angle_deg": angle}), "leg") for angle in (12, 13, 14)
    ]
    plans[1] = replace(plans[1], timestep_s=4.0 * plans[1].largest_timestep_s)
    first, broken, last = follow_rears(plans, session)
    assert isinstance(broken, RunError)
    assert broken.code == "diverged"
    for plan, found in ((plans[0], first), (plans[2], last)):
        assert numbers(found) == numbers(follow_rear(plan, session))


def test_a_leg_that_cannot_be_held_takes_no_other_down(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    plans = [plan_of(scene_of({"beads": 100, "for": "speed", "strain": strain}), "leg") for strain in (0.4, 0.41)]
    refused = RunError("no equilibrium", "no-equilibrium")
    held = hold_legs(plans)
    monkeypatch.setattr(batch, "hold_legs", lambda _: [refused, held[1]])
    found = follow_rears(plans, session)
    assert found[0] is refused
    assert isinstance(found[1], Measurement)


def test_rear_runs_are_rear_runs(session: Session) -> None:
    """With their coarse runs, and a ring among them."""
    values = [{"beads": 96, "half_angle_deg": 11.0}, {"beads": 88, "law": "linear"}, {"beads": 92, "loss_time_s": 3e-4}]
    plans = [plan_of(scene_of({"for": "speed", **one}), "leg") for one in values]
    assert [plan.model for plan in plans] == ["leg", "leg", "ring"]
    for plan, found in zip(plans, rear_runs(plans, session), strict=True):
        assert not isinstance(found, BeadbandError)
        single = rear_run(plan, session)
        assert found.speed == single.speed
        assert found.estimate == single.estimate


def test_the_script_runs_from_top_to_bottom(session: Session) -> None:
    """As it does in plain LAMMPS, with the variables that the session gives it in two parts."""
    from beadband.lammps.batch import _room, points_of, write_legs

    plan = plan_of(scene_of({"beads": 100, "for": "speed"}), "leg")
    leg, variables = hold_leg(plan), _room(points_of(plan))
    rest = write_legs(session.folder, [(plan, leg)], {})
    for name in variables | rest:
        assert "${" + name + "}" in script_text("legs.in")
    session.run(script_text("legs.in"), variables | rest)
    first = (session.folder / "legs.bin").read_bytes()
    follow_rear(plan, session)
    assert (session.folder / "legs.bin").read_bytes() == first
