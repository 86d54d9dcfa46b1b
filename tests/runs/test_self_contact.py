"""Contact of the band with itself: nothing before the first touch, no crossing after it, momentum and energy kept."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.analysis.contact import crossings, touching_m
from beadband.analysis.readers import read
from beadband.errors import UsageError
from beadband.model.scene import scene_of
from beadband.planning.launch_plan import launch_plan_of
from beadband.planning.self_contact import NEAR, OVERLAP_BOUND, tip_pairs
from beadband.reporting.report_data import read_story
from beadband.runs import folder as files
from beadband.runs import launch
from beadband.runs.launch_results import Launch
from beadband.statics.ring import stretched_ring

# The rear of a slim wedge, pulled far, overtakes the front of the flying band.
OVERTAKES: dict[str, Any] = {
    "until": "launch", "band": "I", "strain": 1.3, "half_angle_deg": 5.0, "for": "speed", "finger": "clears",
    "flight_s": 7e-4, "beads": 141,
}  # fmt: skip


@pytest.fixture(scope="module")
def touches(tmp_path_factory: pytest.TempPathFactory) -> Launch:
    return launch.run(scene_of(OVERTAKES), tmp_path_factory.mktemp("contact") / "on")


@pytest.fixture(scope="module")
def passes(tmp_path_factory: pytest.TempPathFactory) -> Launch:
    return launch.run(scene_of({**OVERTAKES, "self_contact": "off"}), tmp_path_factory.mktemp("contact") / "off")


def test_nothing_changes_before_the_first_touch(touches: Launch, passes: Launch) -> None:
    """Not a digit of the finger's file, and none of the trajectory's ten."""
    first = touches.self_touch_s
    assert first is not None
    for name, fewest in ((files.FINGER, 300), (files.ENERGY, 50)):
        lines = [(run.folder / name).read_text().splitlines() for run in (touches, passes)]
        same = [one == other for one, other in zip(*lines, strict=True)]
        assert same.index(False) > fewest
    line = next(i for i, step in enumerate(touches.watch.steps) if step * touches.plan.timestep_s >= first)
    assert np.array_equal(touches.watch.kinetic_j[: line - 1], passes.watch.kinetic_j[: line - 1])
    on, off = (read(run.folder / files.TRAJECTORY) for run in (touches, passes))
    before = on.steps * touches.plan.timestep_s < first  # a frame is the mean of the steps up to its own
    assert np.array_equal(on.positions_m[before], off.positions_m[before])
    assert np.abs(on.positions_m[-1] - off.positions_m[-1]).max() > touches.scene.band.thickness_m
    # Whatever LAMMPS needs to tell neighbours apart, the files hold the four kinds of beads.
    heads = [(run.folder / files.TRAJECTORY).read_text()[:2000] for run in (touches, passes)]
    assert heads[0] == heads[1]


def test_what_crossed_no_longer_does(touches: Launch, passes: Launch) -> None:
    """By the distances of all beads in all frames, which know nothing of the contact."""
    thickness, spacing = touches.scene.band.thickness_m, touches.plan.strand.spacing_m
    near = int(np.ceil((NEAR + 1.0) * thickness / spacing))
    closest = {}
    for name, run in (("on", touches), ("off", passes)):
        frames = read(run.folder / files.TRAJECTORY).positions_m[2:]
        apart = np.abs(np.subtract.outer(*2 * (np.arange(run.plan.beads),)))
        apart = np.minimum(apart, run.plan.beads - apart)
        distance = np.linalg.norm(frames[:, :, None] - frames[:, None], axis=-1)[:, apart > near]
        closest[name] = distance.min() / thickness
    assert closest["on"] > 1.0 - OVERLAP_BOUND
    assert closest["off"] < 0.1
    assert touches.crossed_s is None
    assert passes.crossed_s is not None
    assert [one.code for one in passes.notices if "itself" in one.sentence] == ["crosses-itself"]
    codes = [one.code for one in touches.notices]
    assert "touches-itself" in codes
    assert "crosses-itself" not in codes
    assert not touches.failed_checks


def test_contact_inside_the_band_keeps_momentum_and_energy(touches: Launch) -> None:
    found = touches.self_contact
    assert found is not None
    assert found["energy_j"] > 1e-6 * touches.energy.stored_j
    flying = touches.watch.times_s(touches.plan.timestep_s) > touches.found.rear_arrival_s
    assert np.ptp(touches.watch.momentum_n_s[flying]) < 1e-12 * touches.found.momentum_n_s
    assert touches.energy.error < 2e-3
    # Energy of one touch, k d^2/2, gives a depth that the overlaps of all beads stay below.
    bound = np.sqrt(2.0 * found["energy_j"] / found["stiffness_n_m"])
    assert 0.0 < found["overlap_m"] <= np.sqrt(2.0) * bound


def test_files_hold_the_contact(touches: Launch) -> None:
    values = json.loads((touches.folder / files.RESULTS).read_text())["launch"]
    assert values["self_touch_s"] == touches.self_touch_s
    assert values["self_contact"] == touches.self_contact
    assert max(values["series"]["overlap_m"]) == values["self_contact"]["overlap_m"]
    assert json.dumps(launch.remeasure(touches.folder).as_dict()["launch"]) == json.dumps(values)
    story = read_story(touches.folder)
    drawn = [len(places) for places in story.touches_m]
    first = np.flatnonzero(drawn)[0]
    assert touches.self_touch_s is not None
    assert abs(story.times_s[first] - touches.self_touch_s) < 3.0 * np.diff(story.times_s).max()
    assert "overlap" in [chart.key for chart in story.charts]
    assert any("Rings" in note for note in story.notes)


def test_older_launches_are_measured_without_it(passes: Launch, tmp_path: Path) -> None:
    for name in (files.SCENE, files.DATA, files.REAR, files.ENERGY, files.FINGER, files.TRAJECTORY):
        shutil.copy(passes.folder / name, tmp_path)
    lines = (passes.folder / files.SCENE).read_text().splitlines(keepends=True)
    (tmp_path / files.SCENE).write_text("".join(line for line in lines if "self_contact" not in line))
    again = launch.remeasure(tmp_path)
    assert again.overlaps is None
    assert again.crossed_s == passes.crossed_s


def test_places_of_touches() -> None:
    """A ring squeezed to two straight strands a distance apart touches along them, not round its ends."""
    angle = np.linspace(0.0, 2.0 * np.pi, 401)[:-1]
    ring = np.stack([np.cos(angle) * 5.0, np.clip(np.sin(angle) * 5.0, -0.5, 0.5)], axis=1)
    places = touching_m(ring, 1.01, 40)
    assert np.abs(places[:, 1]).max() < 0.1
    assert np.ptp(places[:, 0]) > 8.0
    assert len(touching_m(ring, 0.99, 40)) == 0
    assert crossings(ring) == 0


def test_the_plan_says_where_it_can_happen() -> None:
    def reasons(**values: Any) -> set[str]:
        plan = launch_plan_of(scene_of({"until": "launch", **values}))
        codes = {one.code for one in plan.reasons if one.code.startswith("self-contact")}
        assert (plan.self_contact is not None) == (codes == {"self-contact"})
        return codes

    assert reasons() == {"self-contact"}
    assert reasons(beads=80) == {"self-contact-coarse"}
    assert reasons(beads=3100) == {"self-contact-many"}
    assert reasons(strain=1.2, half_angle_deg=24.0) == {"self-contact-never"}
    assert reasons(self_contact="off") == set()
    with pytest.raises(UsageError, match="--self-contact is not used with until release"):
        scene_of({"self_contact": "off"})
    plan = launch_plan_of(scene_of({"until": "launch"}))
    assert plan.self_contact is not None
    begins = plan.self_contact.from_steps * plan.timestep_s
    assert plan.release.front_arrival_s < begins < plan.string.finger_free_s


def test_legs_that_overlap_beside_the_tip_are_left_alone() -> None:
    """In a slim wedge they lie within the thickness over a length that beads only resolve; others lie apart."""
    scene = scene_of({"half_angle_deg": 2.0, "strain": 1.0})
    for beads in (400, 800):
        ring = stretched_ring(scene.strand(beads), beads, 1.0, scene.half_angle_rad)
        pairs = tip_pairs(ring, scene.band.thickness_m)
        leg = 2.0 * ring.positions_m[: beads // 4, 1] / scene.band.thickness_m
        assert leg[2 * pairs :].min() > 1.0 >= leg[2 * pairs - 2 : 2 * pairs].min()
