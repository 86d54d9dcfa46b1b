"""The held ring: derivatives, equilibrium by beadband's forces and by LAMMPS' own, and the exact held shape."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from beadband.errors import UsageError
from beadband.lammps.engine import load
from beadband.lammps.scripts import bin_m, dashpot_cutoff_m, write_ring
from beadband.model.scene import Scene, scene_of
from beadband.planning.plan import plan_of
from beadband.runs import folder as files
from beadband.runs.held import hold
from beadband.statics.chain import LONG_CHAIN, HalfRing, solve_blocks
from beadband.statics.ring import LOWER, TIP, UPPER, WRAPPED, Ring, stretched_ring


def ring_of(scene: Scene, beads: int) -> Ring:
    return stretched_ring(scene.strand(beads), beads, scene.strain, scene.half_angle_rad)


def full_matrix(blocks: np.ndarray) -> np.ndarray:
    count = blocks.shape[1]
    matrix = np.zeros((count, 2, count, 2))
    for k in range(3):
        for i in range(count - k):
            matrix[i, :, i + k, :] = blocks[k, i]
            matrix[i + k, :, i, :] = blocks[k, i].T
    return matrix.reshape(2 * count, 2 * count)


@pytest.mark.parametrize("crossing", [False, True])
def test_gradient_and_hessian_are_derivatives_of_the_energy(crossing: bool) -> None:
    strand = scene_of({}).strand(60)
    ring = HalfRing(strand, crossing)
    angle = np.linspace(0.98 * math.pi, 0.05 if crossing else 0.0, 12)
    noise = np.random.default_rng(1).normal(size=(12, 2))
    points = strand.spacing_m * (5.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + 0.1 * noise)
    gradient, blocks = ring.derivatives(points)
    step = 1e-5 * strand.spacing_m
    numeric, hessian = np.zeros_like(gradient), np.zeros((24, 24))
    for i in range(12):
        for axis in range(2):
            shift = np.zeros_like(points)
            shift[i, axis] = step
            numeric[i, axis] = (sum(ring.energies(points + shift)) - sum(ring.energies(points - shift))) / (2 * step)
            hessian[2 * i + axis] = (ring.gradient(points + shift) - ring.gradient(points - shift)).ravel() / (2 * step)
    assert np.abs(gradient - numeric).max() < 1e-7 * np.abs(gradient).max()
    assert np.abs(full_matrix(blocks) - hessian).max() < 1e-7 * np.abs(hessian).max()


@pytest.mark.parametrize("count", [2, 15, 16, 17, 50])
def test_block_solver_agrees_with_a_dense_one(count: int) -> None:
    random = np.random.default_rng(count)
    blocks = random.normal(size=(3, count, 2, 2))
    blocks[0] = blocks[0] + blocks[0].transpose(0, 2, 1) + 12.0 * np.eye(2)
    for k in (1, 2):
        blocks[k, count - k :] = 0.0
    right = random.normal(size=(count, 2, 3))
    dense = np.linalg.solve(full_matrix(blocks), right.reshape(2 * count, 3))
    assert np.allclose(solve_blocks(blocks, right).reshape(2 * count, 3), dense, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("beads", [60, 61, 120, 401, 800, 3200])
def test_no_free_bead_feels_a_force(beads: int) -> None:
    ring = ring_of(scene_of({}), beads)
    assert ring.net_force < 1e-8
    assert ring.beads == beads
    x, y = ring.positions_m.T
    assert np.array_equal(ring.positions_m[0], [0.0, 0.0])
    assert np.array_equal(x[1:], x[1:][::-1])
    assert np.array_equal(y[1:], -y[1:][::-1])
    wrapped = ring.types == WRAPPED
    assert np.allclose(np.hypot(x - ring.finger_centre_m, y)[wrapped], ring.finger_radius_m, rtol=1e-12)
    assert np.hypot(x - ring.finger_centre_m, y)[~wrapped].min() >= ring.finger_radius_m * (1.0 - 1e-12)
    assert (ring.types == TIP).sum() == 1
    assert (ring.types == UPPER).sum() == (ring.types == LOWER).sum()


@pytest.mark.parametrize(
    "values",
    [
        {"band": "I", "strain": 0.1, "half_angle_deg": 5.0},
        {"band": "IV", "strain": 1.4, "half_angle_deg": 20.0},
        {"band": "circular", "law": "linear", "strain": 1.2, "half_angle_deg": 25.0},
        {"band": "II", "bending_scale": 0.0},
        {"band": "III", "bending_scale": 16.0, "half_angle_deg": 30.0, "strain": 0.2},
        {"band": "I", "law": "linear", "strain": 0.149, "half_angle_deg": 38.0},
    ],
)
def test_equilibrium_at_the_corners_of_the_scenes(values: dict[str, object]) -> None:
    for beads in (200, 333):
        assert ring_of(scene_of(values), beads).net_force < 1e-8


def test_legs_hold_the_strain_and_the_angle_of_the_scene() -> None:
    scene = scene_of({})
    ring = ring_of(scene, 800)
    middle = ring.positions_m[130:132]
    bond = middle[1] - middle[0]
    assert math.atan2(bond[1], bond[0]) == pytest.approx(scene.half_angle_rad, abs=1e-9)
    assert np.hypot(*bond) / scene.strand(800).spacing_m == pytest.approx(1.476, rel=1e-9)


def test_lammps_feels_the_same_equilibrium(tmp_path: Path) -> None:
    """The forces of the engine itself, from the files that it reads, vanish on every free bead."""
    for values in ({"beads": 200}, {"beads": 401, "law": "linear", "band": "circular"}):
        plan = plan_of(scene_of(values))
        ring = hold(plan)
        folder = tmp_path / str(plan.beads)
        folder.mkdir()
        write_ring(folder, plan, ring)
        text = (folder / files.SCRIPT).read_text()
        instance = load().lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
        try:
            # A line by itself can't hold the folder's name; the script up to its first run can be pointed there.
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(folder)
                instance.commands_string(text[: text.index("undump          held")])
            force = instance.numpy.extract_atom("f")[: plan.beads]
            ids = instance.numpy.extract_atom("id")[: plan.beads]
            by_bead = force[np.argsort(ids)]
        finally:
            instance.close()
        free = (ring.types == UPPER) | (ring.types == LOWER)
        assert np.abs(by_bead[free]).max() < 1e-8 * ring.tension_n
        # The tip hold carries both legs: 2 T cos(phi).
        hold_force = 2.0 * ring.tension_n * math.cos(plan.scene.half_angle_rad)
        assert by_bead[0, 0] == pytest.approx(hold_force, rel=1e-8)


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_held_tip_converges_to_the_exact_elastica(law: str) -> None:
    """EI/2 kappa0^2 = W*(T) - W*(T sin phi), W* the complementary energy: second order in the spacing."""
    scene = scene_of({"law": law})
    material, area = scene.material, scene.band.area_m2
    tension = area * material.stress(1.476)

    def complementary(force: float) -> float:
        stretch = material.stretch_at(force / area, 1.476)
        return force * stretch - area * float(material.energy(stretch))

    drop = complementary(tension) - complementary(tension * math.sin(scene.half_angle_rad))
    exact = math.sqrt(2.0 * drop / scene.bending_stiffness_n_m2)
    errors = []
    for beads in (800, 1600, 3200):
        ring = ring_of(scene, beads)
        bond = ring.positions_m[1] - ring.positions_m[0]
        turning = math.pi - 2.0 * math.atan2(bond[1], bond[0])
        errors.append(abs(turning / scene.strand(beads).spacing_m / exact - 1.0))
    assert errors[-1] < 2e-3
    orders = [math.log2(coarse / fine) for coarse, fine in pairwise(errors)]
    assert orders[-1] > 1.9


def test_without_bending_the_ring_is_the_string() -> None:
    scene = scene_of({"bending_scale": 0.0})
    ring = ring_of(scene, 2000)
    assert ring.finger_radius_m == pytest.approx(scene.wedge.finger_radius_m, rel=1e-4)
    stored = scene.band.area_m2 * scene.band.circumference_m * float(scene.material.energy(1.476))
    assert ring.stretching_j == pytest.approx(stored, rel=1e-6)


def test_too_few_beads_are_refused() -> None:
    with pytest.raises(UsageError, match="too few beads"):
        ring_of(scene_of({}), 5)
    with pytest.raises(UsageError, match="finger"):
        ring_of(scene_of({"band": "IV", "half_angle_deg": 1.0}), 60)


def test_both_solvers_agree() -> None:
    count = LONG_CHAIN + 1
    random = np.random.default_rng(count)
    blocks = random.normal(size=(3, count, 2, 2))
    blocks[0] += blocks[0].transpose(0, 2, 1) + 40.0 * np.eye(2)
    right = random.normal(size=(count, 2, 2))
    long, short = solve_blocks(blocks, right), solve_blocks(blocks[:, :-1], right[:-1])
    # The last bead's effect dies away within a few beads of it.
    assert np.abs(long[: count // 2] - short[: count // 2]).max() < 1e-14


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_a_long_ring_is_the_limit_of_short_ones(law: str) -> None:
    """It begins from a coarse one and finds its contact by the finger's reaction, not bead by bead.

    Of the second order in the bead distance: twice the beads come near its radius by more than half.
    """
    scene = scene_of({"law": law})
    short, twice, long = (ring_of(scene, beads) for beads in (1000, 2000, 16_001))
    off = [abs(ring.finger_radius_m / long.finger_radius_m - 1.0) for ring in (short, twice)]
    assert off[1] < 0.35 * off[0] < 2e-5
    wrapped = [float((ring.types == WRAPPED).mean()) for ring in (twice, long)]
    assert wrapped[1] == pytest.approx(wrapped[0], abs=4.0 / 2000)  # two beads at each side
    assert long.net_force < 1e-6
    radius = np.hypot(long.positions_m[:, 0] - long.finger_centre_m, long.positions_m[:, 1])
    assert radius.min() > long.finger_radius_m * (1.0 - 1e-9)


def test_bins_are_of_a_size_of_their_own_for_long_rings_only() -> None:
    """LAMMPS would want more bins than it can count."""
    short, long = (ring_of(scene_of({}), beads) for beads in (520, 16_000))
    assert bin_m(short.positions_m, dashpot_cutoff_m(short)) == 0.0
    assert np.ptp(long.positions_m[:, 0]) / bin_m(long.positions_m, dashpot_cutoff_m(long)) < 4000.0
