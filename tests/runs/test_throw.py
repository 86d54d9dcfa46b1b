"""The flight in the results of a launch."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from beadband.model.flight import GRAVITY_M_S2, fly
from beadband.model.scene import scene_of
from beadband.runs import dispatch, launch
from beadband.runs import folder as files

THROWN = {"until": "launch", "beads": 160, "for": "speed", "finger": "clears", "elevation_deg": 40.0, "height_m": 1.0}


def test_a_launch_flies_to_the_ground(tmp_path: Path) -> None:
    done = launch.run(scene_of(THROWN), tmp_path / "throw")
    found = json.loads((tmp_path / "throw" / files.RESULTS).read_text())["launch"]
    flight, band, speed = found["flight"], done.scene.band, found["centre_of_mass_speed_m_s"]
    length = 2.0 * band.mass_kg / (1.2 * flight["drag_area_m2"])
    assert flight["drag_length_m"] == pytest.approx(length)
    assert flight["terminal_speed_m_s"] == pytest.approx(math.sqrt(GRAVITY_M_S2 * length))
    assert flight["range_m"] == fly(speed, math.radians(40.0), 1.0, length).range_m
    assert flight["vacuum_range_m"] == fly(speed, math.radians(40.0), 1.0).range_m
    # All attitudes lie within the error of the one that is used, twice over.
    areas = [flight[f"drag_area{name}_m2"] for name in ("", "_in_plane", "_broadside")]
    reached = [fly(speed, math.radians(40.0), 1.0, 2.0 * band.mass_kg / (1.2 * area)).range_m for area in areas]
    assert max(abs(one - flight["range_m"]) for one in reached) < 2.0 * flight["range_error_m"]
    assert 0.2 < flight["across"] < 0.6
    assert 1e-3 < flight["launch_drag"] < 0.05
    assert "flight.png" in [path.name for path in done.plot()]
    assert dispatch.analyze(tmp_path / "throw").as_dict()["launch"]["flight"] == flight


def test_what_is_not_thrown_does_not_fly() -> None:
    values = {"until": "launch", "beads": 120, "for": "speed", "strain": 1.2, "half_angle_deg": 20.0}
    done = launch.run(scene_of({**values, "elevation_deg": 20.0}))
    assert done.flight is None
    assert "no-flight" in [one.code for one in done.notices]
    assert done.as_dict()["launch"]["flight"] is None


def test_without_air_nothing_drags() -> None:
    done = launch.run(scene_of({**THROWN, "beads": 120, "air_density_kg_m3": 0.0}))
    assert done.flight is not None
    assert done.flight.flight == done.flight.vacuum
    assert done.flight.drag_length_m is None
    assert done.flight.launch_drag == 0.0
