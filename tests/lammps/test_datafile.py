"""Data files: what LAMMPS reads back is what was written, to the last digit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from beadband.lammps.datafile import data_file, leg_data, ring_data
from beadband.lammps.engine import load
from beadband.model.scene import scene_of
from beadband.statics.leg import held_leg
from beadband.statics.ring import stretched_ring


def test_lammps_reads_what_was_written(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    points, speeds = rng.normal(size=(5, 2)), rng.normal(size=(5, 2)) * 1e-17
    types = np.array([1, 2, 2, 2, 1])
    bonds, angles = np.array([[0, 1], [1, 2], [3, 4]]), np.array([[0, 1, 2]])
    box = ((-9.0, 9.0), (-8.0, 8.0), (-1.0, 1.0))
    text = data_file("five beads", points, types, (0.1, 0.3), bonds, angles, box, np.array([2]), speeds)
    (tmp_path / "five.data").write_text(text)
    instance = load().lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        instance.commands_string(
            "units si\ndimension 2\nboundary f f p\natom_style angle\natom_modify sort 0 0\nbond_style zero\n"
            "angle_style zero\nread_data five.data"
        )
    order = np.argsort(instance.numpy.extract_atom("id")[:5])
    assert np.array_equal(instance.numpy.extract_atom("x")[:5][order, :2], points)
    assert np.array_equal(instance.numpy.extract_atom("v")[:5][order, :2], speeds)
    assert np.array_equal(instance.numpy.extract_atom("type")[:5][order], types)
    masses = instance.extract_atom("mass")
    assert [masses[kind] for kind in (1, 2)] == [0.1, 0.3]
    assert [instance.extract_global(name) for name in ("nbonds", "nangles")] == [3, 1]
    instance.close()


def test_ring_and_leg_hold_the_mass_of_their_bands() -> None:
    scene = scene_of({"beads": 120})
    strand = scene.strand(120)
    leg = leg_data(held_leg(strand, 30, scene.strain, scene.half_angle_rad), strand)
    assert "32 atoms\n30 bonds\n30 angles\n4 atom types\n1 bond types\n2 angle types" in leg
    ring = ring_data(stretched_ring(strand, 120, scene.strain, scene.half_angle_rad), strand)
    assert "120 atoms\n120 bonds\n120 angles\n4 atom types\n1 bond types\n1 angle types" in ring
    assert "120 1 120 1\n" in ring
