"""Launches over many scenes and many beads: what the map says of each, and the orders of the ladder."""

from __future__ import annotations

import csv
import io
import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from beadband.errors import RunError
from beadband.model.scene import Scene, scene_of
from beadband.planning.launch_plan import launch_plan_of
from beadband.runs import launch
from beadband.studies import launch_ladder, launch_map
from beadband.studies.launch_ladder import Ladder, ladder
from beadband.studies.launch_map import MapPoint, as_csv, write_map


@pytest.fixture(scope="module")
def points() -> list[MapPoint]:
    """A map of six scenes: thrown, hit under load, and refused."""
    with pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(1) as executor:
        patch.setattr(launch_map, "QUICK_STRAINS", (0.3, 1.2, 1.45))
        patch.setattr(launch_map, "QUICK_HALF_ANGLES_DEG", (8.0, 26.0))
        return launch_map.launch_map(True, ["III"], executor=executor)


def test_every_point_of_a_map_has_numbers_or_a_reason(points: list[MapPoint]) -> None:
    thrown, hit, refused = points[0], points[3], points[5]
    assert thrown.reason_code == thrown.reason == ""
    assert thrown.pause_s is not None
    assert thrown.pause_s > 0.0
    assert hit.reason_code == "hit-before-free"
    assert hit.pause_s is not None
    assert hit.pause_s < 0.0
    assert hit.efficiency is None
    assert refused.reason_code == "usage"
    assert "wide" in refused.reason
    assert refused.finger_radius_m is None


def test_a_map_is_the_same_in_processes(monkeypatch: pytest.MonkeyPatch, points: list[MapPoint]) -> None:
    monkeypatch.setattr(launch_map, "QUICK_STRAINS", (0.3,))
    monkeypatch.setattr(launch_map, "QUICK_HALF_ANGLES_DEG", (8.0, 26.0))
    assert launch_map.launch_map(True, ["III"], jobs=2) == points[:2]


def test_a_launch_that_fails_is_a_point_with_its_code(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: MapPoint) -> MapPoint:
        raise RunError("the run failed", "diverged")

    monkeypatch.setattr(launch_map, "launch_point", fail)
    monkeypatch.setattr(launch_map, "QUICK_STRAINS", (0.3,))
    found = launch_map.launch_map(True, ["I"], jobs=1)
    assert {(point.reason_code, point.reason) for point in found} == {("diverged", "the run failed")}


def test_a_map_is_written_as_table_and_pictures(points: list[MapPoint], tmp_path: Path) -> None:
    assert [path.name for path in write_map(points, tmp_path)] == ["map.csv", "pause.png", "efficiency.png"]
    assert all((tmp_path / name).stat().st_size > 1000 for name in ("pause.png", "efficiency.png"))
    rows = list(csv.DictReader(io.StringIO(as_csv(points))))
    assert [row["reason_code"] for row in rows] == [point.reason_code for point in points]
    assert float(rows[0]["pause_s"]) == pytest.approx(points[0].pause_s, rel=1e-5)
    text = launch_map.summary(points)
    hit = sum(point.pause_s is not None and point.pause_s <= 0.0 for point in points)
    refused = sum(point.rear_arrival_s is None for point in points)
    assert text.startswith(f"band III: 6 scenes, {hit} hit before the finger is free, {refused} refused; best throw")


def test_efficiency_and_pause_converge() -> None:
    """With a loss of the material's own, of at least the first order and closer than 2 % from 240 beads on."""
    scene = scene_of({"until": "launch", "finger": "clears", "law": "linear", "loss_time_s": 2e-5, "for": "speed"})
    ladders = {one.quantity: one for one in ladder(scene, (120, 240, 480))}
    for name in ("efficiency", "rear_arrival_s", "centre_of_mass_speed_m_s", "pause_s"):
        assert ladders[name].order > 1.0
    for name in ("efficiency", "rear_arrival_s", "centre_of_mass_speed_m_s"):
        assert ladders[name].values[1] == pytest.approx(ladders[name].values[2], rel=0.02)


@pytest.mark.parametrize("order", [-1.0, 1.0, 2.5])
@pytest.mark.parametrize("beads", [(100, 200, 400), (100, 200, 300, 600), (120, 150, 600)])
def test_order_is_exact_whatever_the_ratios(order: float, beads: tuple[int, ...]) -> None:
    values = tuple(1.0 + 3.0 * (count / 100) ** -order for count in beads)
    assert Ladder("exact", beads, values).order == pytest.approx(order, rel=1e-9)


def test_no_order_without_differences() -> None:
    assert math.isnan(Ladder("short", (100, 200), (1.0, 1.1)).order)
    assert math.isnan(Ladder("equal", (100, 200, 400), (1.0, 1.0, 1.1)).order)


def test_a_loss_of_the_users_stays_on_the_ladder_and_a_planned_one_goes_with_the_mesh(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[tuple[int, Any]] = []
    nothing = SimpleNamespace(**dict.fromkeys(launch_ladder.QUANTITIES))

    def note(scene: Scene) -> tuple[None, SimpleNamespace]:
        plan = launch_plan_of(scene)
        seen.append((plan.beads, plan.scene.loss_time_s))
        return None, nothing

    monkeypatch.setattr(launch, "follow_launch", note)
    own = scene_of({"until": "launch", "loss_time_s": 2e-5})
    for scene in (own, launch_plan_of(scene_of({"until": "launch"})).scene):
        assert ladder(scene, (80, 160)) == []
    assert seen[:2] == [(80, 2e-5), (160, 2e-5)]
    assert seen[2][1] == pytest.approx(2.0 * seen[3][1], rel=1e-6)
