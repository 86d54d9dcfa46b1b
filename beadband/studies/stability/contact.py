"""Failures of a contact: too soft, too stiff, and beads that go through a finger."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.errors import RunError, UsageError
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import hold
from beadband.statics.ring import TOO_FEW_ON_FINGER
from beadband.studies.stability import trials
from beadband.studies.stability.catalogue_entry import Curve, Entry, Picture, finding
from beadband.studies.verification.specimen import FIXED, FREE, Specimen, chain, strand_of

_SPEED = 17.0
_RADIUS_M = 5e-3
_SPACING_M = 1e-3


def _thrown(bonds: int, spacing_m: float, offset: float = 0.0) -> Specimen:
    """A strand thrown flat at a finger above it, its ends held."""
    strand = strand_of("III", "linear", spacing_m)
    line = np.zeros((bonds + 1, 2))
    line[:, 0] = spacing_m * (np.arange(bonds + 1) - 0.5 * bonds + offset)
    line[:, 1] = -1.05 * _RADIUS_M
    types = np.full(bonds + 1, FREE)
    types[[0, -1]] = FIXED
    speeds = np.zeros_like(line)
    speeds[1:-1, 1] = _SPEED
    return replace(chain(strand, line, types, strain=3.0), velocities_m_s=speeds, cutoff_m=3.8 * spacing_m)


def _bond_stiffness() -> float:
    strand = strand_of("III", "linear", _SPACING_M)
    return strand.modulus_pa * strand.area_m2 / _SPACING_M


def stiffness(quick: bool) -> Entry:
    """A finger of several stiffnesses hit by a band at the speed of a rebound."""
    piece = _thrown(60, _SPACING_M)
    strand = piece.strand
    bond = _bond_stiffness()
    shares = np.array([0.001, 0.03, 1.0, 30.0] if quick else [0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 1.0, 10.0, 100.0])
    base = strand.largest_step_s(1e-5, 1.0, 0.8)
    depths, steps = [], []
    for share in shares:
        # Force K d^2: as stiff as so many bonds at a depth of a tenth of a millimetre.
        hardness = share * bond / (2.0 * 1e-4)
        options = trials.Options(loss_time_s=1e-5, finger_stiffness_pa=hardness, finger_radius_m=_RADIUS_M)

        def deepest(step: float, options: trials.Options = options) -> float:
            count = max(40, int(2.5 * _RADIUS_M / _SPEED / step))
            course = trials.run(piece, step, count, max(1, count // 60), options)
            return float((_RADIUS_M - np.hypot(course.positions_m[..., 0], course.positions_m[..., 1])).max())

        fine = base / 8.0 / math.sqrt(1.0 + share)
        depths.append(deepest(fine))
        # The stiffness of the contact at the depth that it reaches, in the limit of the step.
        rate2 = 2.0 * hardness * min(depths[-1], _RADIUS_M) / strand.bead_mass_kg
        steps.append(2.0 / math.sqrt((2.0 / base) ** 2 + rate2))
    share_of_radius = np.array(depths) / _RADIUS_M
    fall = np.array(steps) / base
    return Entry(
        "finger-stiffness",
        "A finger too soft, or too stiff",
        (
            finding(
                share_of_radius[0] > 0.5,
                f"A strand that hits a finger at {_SPEED:g} m/s sinks into it by {share_of_radius[0]:.0%} of its "
                f"radius with a contact of {shares[0]:g} bonds' stiffness (at a depth of 0.1 mm).",
                f"A strand that hits a finger at {_SPEED:g} m/s sinks into it by no more than {share_of_radius[0]:.0%} "
                f"of its radius, even with a contact of {shares[0]:g} bonds' stiffness (at a depth of 0.1 mm).",
            ),
            finding(
                share_of_radius[-1] < 0.1,
                f"With {shares[-1]:g} it is stopped at {share_of_radius[-1]:.1%}.",
                f"With {shares[-1]:g} it still sinks in by {share_of_radius[-1]:.1%}.",
            ),
            finding(
                fall[-1] < 0.6,
                f"The stiff contact lowers the largest step to {fall[-1]:.2f} of the chain's.",
                f"The stiff contact hardly lowers the largest step, to {fall[-1]:.2f} of the chain's.",
            ),
        ),
        (
            "Up to the front's arrival a release needs no contact: beads on the finger stay where they are. The limit "
            "of the step with a contact is exact (regime 'contact' of the map): a stiffness can be chosen for its "
            "step.",
        ),
        {
            "depth_over_radius_soft": float(share_of_radius[0]),
            "depth_over_radius_stiff": float(share_of_radius[-1]),
            "step_share_stiff": float(fall[-1]),
        },
        Picture(
            "a strand on a finger",
            "stiffness of the contact / that of a bond",
            "",
            (
                Curve(shares, share_of_radius, "depth / radius", "o-"),
                Curve(shares, fall, "largest step / the chain's", "s-"),
            ),
            logx=True,
            logy=True,
        ),
    )


def through(quick: bool) -> Entry:
    """A finger thinner than the beads are apart, or passed within one step."""
    strand = strand_of("III", "linear", 4e-3)
    thin = 1.0e-3  # radius
    outcomes = {}
    paths, failures = [], []
    for name, spacing, offset, step_share in (
        ("spacing 4 radii", 4e-3, 0.5, 0.1),
        ("spacing 0.5 radii", 0.5e-3, 0.5, 0.1),
    ):
        bonds = max(8, 2 * round(16e-3 / spacing)) + 1
        piece = _thrown(bonds, spacing, offset=0.0 if offset == 0.5 else offset)
        line = piece.points_m.copy()
        line[:, 1] = -1.3 * thin
        piece = replace(piece, points_m=line)
        bond = strand.modulus_pa * strand.area_m2 / 4e-3
        options = trials.Options(loss_time_s=1e-5, finger_stiffness_pa=30.0 * bond / 2e-4, finger_radius_m=thin)
        step = step_share * piece.strand.largest_step_s(1e-5, 1.5, 0.7) / 3.0
        count = int(2.6 * thin / _SPEED / step)
        try:
            course = trials.run(piece, step, count, max(1, count // 50), options)
        except RunError as error:
            outcomes[name] = math.nan
            failures.append(f"With {name} the run failed ({error.code}): {error}.")
            continue
        # Does a bond cross the middle of the finger? Height of the strand at x = 0.
        heights = np.array([np.interp(0.0, points[:, 0], points[:, 1]) for points in course.positions_m])
        outcomes[name] = float(heights.max()) / thin
        paths.append(Curve(step * course.steps * 1e6, heights / thin, name))
    coarse, fine = (outcomes[name] for name in ("spacing 4 radii", "spacing 0.5 radii"))
    return Entry(
        "through-finger",
        "A band through the finger",
        (
            "Contact acts on beads alone.",
            finding(
                coarse > 0.3,
                "Where they are 4 finger radii apart the finger passes between two of them: the middle of the strand "
                f"reaches {coarse:+.2f} radii, the far side.",
                f"Where they are 4 finger radii apart the middle of the strand reaches {coarse:+.2f} radii, which is "
                "not the far side.",
            ),
            finding(
                fine < -0.5,
                f"Beads half a radius apart stop at {fine:+.2f} radii, the near side being -1.",
                f"Beads half a radius apart reach {fine:+.2f} radii, the near side being -1.",
            ),
            *failures,
        ),
        (
            finding(
                _sparse_refused(),
                "A ring with fewer than three beads of a half on the finger is refused.",
                "A ring with fewer than three beads of a half on the finger is not refused.",
            ),
            "No bead on the finger moves during a release.",
        ),
        {"highest_over_radius_coarse": coarse, "highest_over_radius_fine": fine},
        Picture(
            "height of the strand under the middle of the finger",
            "time (µs)",
            "height / radius",
            tuple(paths),
            levels=((0.0, "middle of the finger"),),
        ),
    )


def _sparse_refused() -> bool:
    """Whether a ring with too few beads on its finger is refused for that reason."""
    try:
        hold(plan_of(scene_of({"beads": 24, "half_angle_deg": 1.0, "for": "speed"})))
    except UsageError as error:
        return error.code == TOO_FEW_ON_FINGER
    return False
