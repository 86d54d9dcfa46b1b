"""Shared runs: each scene is released once a session."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from beadband.lammps.engine import program
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs import release
from beadband.runs.measurement import Measurement
from beadband.runs.rear_run import follow_rear
from beadband.runs.results import Run

REQUIRE_ALL = os.environ.get("BEADBAND_TEST_ALL") == "1"
"""Set where nothing may be skipped but what is named in BEADBAND_TEST_WITHOUT."""
WITHOUT = frozenset(os.environ.get("BEADBAND_TEST_WITHOUT", "").split())
"""Programs of the system that may be missing: chromium, vulkan."""


@cache
def rear_of(**values: Any) -> tuple[Plan, Measurement]:
    """Plan and measured rear of a scene."""
    plan = plan_of(scene_of(values))
    return plan, follow_rear(plan)


@pytest.fixture(scope="session")
def default_run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Path]:
    """The default scene with all of its files."""
    folder = tmp_path_factory.mktemp("default") / "a folder, $HOME & 'quotes' \"é\""
    return release.run(scene_of({}), folder), folder


@pytest.fixture(scope="session")
def lmp() -> str:
    """Plain LAMMPS, which the lammps package installs."""
    found = program("lmp")
    assert found is not None
    return found


@pytest.fixture(scope="session")
def mpirun() -> str:
    """Starter of MPI ranks; skips where there is none."""
    found = program("mpirun")
    if found is None:
        if REQUIRE_ALL:
            pytest.fail("mpirun is missing")
        pytest.skip("needs mpirun")
    return found
