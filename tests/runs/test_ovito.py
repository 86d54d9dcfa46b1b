"""OVITO reads data file and dump as they come."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.readers import read
from beadband.runs import folder as files
from beadband.runs.results import Run
from conftest import REQUIRE_ALL

if not REQUIRE_ALL:
    pytest.importorskip("ovito")


@pytest.mark.ovito
def test_ovito_reads_beads_bonds_and_columns(default_run: tuple[Run, Path]) -> None:
    from ovito.io import import_file
    from ovito.modifiers import LoadTrajectoryModifier

    run, folder = default_run
    pipeline = import_file(str(folder / files.DATA), atom_style="angle")
    modifier = LoadTrajectoryModifier()
    modifier.source.load(str(folder / files.TRAJECTORY))
    pipeline.modifiers.append(modifier)
    assert pipeline.num_frames == run.plan.frames + 1
    last = pipeline.compute(run.plan.frames).particles
    assert last.count == run.plan.beads
    assert last.bonds.count == run.plan.beads
    assert np.allclose(last["Radius"], 1e-3)
    assert {"Velocity", "stretching", "bending", "Mass"} <= set(last.keys())
    ours = read(folder / files.TRAJECTORY).positions_m[-1]
    assert np.allclose(np.asarray(last.positions)[:, :2], ours, rtol=0.0, atol=1e-12)
    total = float(np.sum(last["stretching"]) + np.sum(last["bending"]))
    assert total == pytest.approx(run.energy.stretching_j[-1] + run.energy.bending_j[-1], rel=1e-5)
