"""Failures of the material and of the section: past the tension peak, outside the bond table, too thick."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from beadband.errors import UsageError
from beadband.lammps.bond_table import DEEPEST_STRETCH, WIDEST_STRAIN
from beadband.lammps.divergence import DivergenceError
from beadband.model.scene import scene_of
from beadband.model.validity import check_validity
from beadband.studies.stability import trials
from beadband.studies.stability.catalogue_entry import Curve, Entry, Picture, finding
from beadband.studies.verification.specimen import FIXED, FREE, chain, strand_of


def past_peak(quick: bool) -> Entry:
    """Band IV held beyond the peak of its tension, against the refusal."""
    strand = strand_of("IV", "mooney-rivlin", 2e-3)
    law, count = strand.law, 41
    peak = law.peak_stretch()
    assert peak is not None
    rng = np.random.default_rng(7)
    spreads, times, last = {}, {}, np.empty(0)
    steps = 1500
    for stretch in (2.3, 2.8):
        line = np.zeros((count, 2))
        line[:, 0] = strand.spacing_m * stretch * np.arange(count)
        line[1:-1, 0] += 1e-3 * strand.spacing_m * rng.uniform(-1.0, 1.0, count - 2)
        types = np.full(count, FREE)
        types[[0, -1]] = FIXED
        piece = replace(
            chain(strand, line, types, strain=9.0 / WIDEST_STRAIN), cutoff_m=3.0 * strand.spacing_m * stretch
        )
        step = 0.3 * strand.state_step_s(1.0, 1e-5)
        # It tears in the end: its state a little before is what matters.
        course, _, _ = trials.run_to_divergence(piece, step, steps, 100, trials.Options(loss_time_s=1e-5))
        stretches = np.diff(course.positions_m[..., 0], axis=1) / strand.spacing_m
        spreads[stretch] = np.ptp(stretches, axis=1)
        times[stretch] = step * course.steps
        last = stretches[-1]
    grown = float(spreads[2.8][-1] / spreads[2.8][0])
    kept = float(spreads[2.3][-1] / spreads[2.3][0])
    narrow = int(np.sum(last > peak))
    refusal = _refusal({"band": "IV", "strain": 1.8})
    below = _refusal({"band": "IV", "strain": 1.3})
    return Entry(
        "past-peak",
        "Band IV past its tension peak",
        (
            f"Band IV's tension peaks at a stretch of {peak:.3f} (C10 < 0).",
            finding(
                grown > 30.0,
                f"Held at 2.8, unevenness of a thousandth grows {grown:.0f} times within {times[2.8][-1] * 1e3:.1f} "
                f"ms: the strand necks in single bonds ({narrow} of {count - 1} above the peak, up to a stretch of "
                f"{last.max():.2f}; the others unload to {last.min():.2f}), so that the answer depends on the number "
                "of beads.",
                f"Held at 2.8, unevenness of a thousandth becomes {grown:.2g} times as large within "
                f"{times[2.8][-1] * 1e3:.1f} ms: the strand does not neck.",
            ),
            finding(
                kept < 1.0,
                f"At 2.3 the same unevenness falls to {kept:.2f} of itself.",
                f"At 2.3 the same unevenness grows to {kept:.2f} of itself.",
            ),
        ),
        (
            finding(
                refusal is not None and below is None,
                f"A strain of 1.8 is refused before anything is computed ({_cause(refusal)}), one of 1.3 is not.",
                f"A strain of 1.8 is {'not ' if refusal is None else ''}refused, one of 1.3 is "
                f"{'not ' if below is None else ''}refused.",
            ),
        ),
        {
            "growth_at_2.8": grown,
            "growth_at_2.3": kept,
            "least_stretch": float(last.min()),
            "most_stretch": float(last.max()),
        },
        Picture(
            "spread of the bonds' stretches in a held strand of band IV",
            "time (ms)",
            "largest less smallest stretch",
            tuple(Curve(times[stretch] * 1e3, spread, f"held at {stretch}") for stretch, spread in spreads.items()),
            logy=True,
        ),
    )


def _refusal(values: dict[str, Any]) -> UsageError | None:
    """Why a scene is refused, None if it is not."""
    try:
        check_validity(scene_of(values))
    except UsageError as error:
        return error
    return None


def _cause(refusal: UsageError | None) -> str:
    """What was wrong and what was given, without the advice."""
    if refusal is None or refusal.complaint is None:
        return str(refusal)
    return f"{refusal.complaint.wrong}: {refusal.complaint.given}"


def beyond_table(quick: bool) -> Entry:
    """A bond torn out of the table of its law."""
    strand = strand_of("III", "mooney-rivlin", 1e-3)
    count, strain = 31, 0.476
    line = np.zeros((count, 2))
    line[:, 0] = strand.spacing_m * np.arange(count)
    types = np.full(count, FREE)
    types[0] = FIXED
    speeds = (5.0, 40.0)
    reached: list[float] = []
    errors: list[DivergenceError | None] = []
    for speed in speeds:
        piece = replace(chain(strand, line, types, strain=strain), velocities_m_s=np.zeros_like(line))
        piece.velocities_m_s[-4:, 0] = speed
        limit = strand.largest_step_s(1e-5, WIDEST_STRAIN * strain, 0.7)
        try:
            course = trials.run(piece, 0.5 * limit, 400, 4, trials.Options(loss_time_s=1e-5), largest_step_s=limit)
            reached.append(float(np.diff(course.positions_m[..., 0], axis=1).max()) / strand.spacing_m)
            errors.append(None)
        except DivergenceError as error:
            reached.append(math.inf)
            errors.append(error)
    torn = errors[1]
    ends = (DEEPEST_STRETCH, 1.0 + WIDEST_STRAIN * strain)
    stretch = np.linspace(*ends, 200)
    return Entry(
        "beyond-table",
        "A stretch outside the bond table",
        (
            f"The law is tabulated from a stretch of {ends[0]:g} to {ends[1]:.3f} for a strain of {strain}.",
            finding(
                not math.isfinite(reached[1]),
                f"Four beads torn off at {speeds[1]:g} m/s leave it.",
                f"Four beads torn off at {speeds[1]:g} m/s reach {reached[1]:.2f} and stay inside.",
            ),
            finding(
                math.isfinite(reached[0]),
                f"At {speeds[0]:g} m/s they reach {reached[0]:.2f} and stay inside.",
                f"At {speeds[0]:g} m/s they leave it too.",
            ),
            "Within one interval beyond the end LAMMPS reads memory behind the table, so that the forces there, and "
            "the end of a run that diverges, differ from one run to the next.",
        ),
        (
            "LAMMPS checks every bond at every step and stops.",
            finding(
                torn is not None and torn.found is not None,
                f"The message names the bond: '{torn and torn.found}'.",
                "The message does not name the bond.",
            ),
            f"The table reaches {WIDEST_STRAIN:g} times the held strain, which no sound release comes near.",
        ),
        {"table_from": ends[0], "table_to": ends[1], "reached_slow": reached[0]},
        Picture(
            "tension of a bond over its table",
            "stretch",
            "nominal stress (MPa)",
            (Curve(stretch, np.asarray(strand.law.stress(stretch)) / 1e6, "Mooney-Rivlin, band III"),),
        ),
    )


def thick_band(quick: bool) -> Entry:
    """A band thicker than the finger that it is wound round."""
    thicknesses = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])
    radii: list[float] = []
    refusals: list[UsageError | None] = []
    angle = 1.0
    for thickness in thicknesses:
        scene = scene_of({"thickness_m": float(thickness), "half_angle_deg": angle, "beads": 200, "for": "speed"})
        radii.append(scene.wedge.finger_radius_m)
        refusals.append(_refusal({"thickness_m": float(thickness), "half_angle_deg": angle}))
    first = next((i for i, refusal in enumerate(refusals) if refusal), len(refusals) - 1)
    half = 0.5 * thicknesses / math.sqrt(1.476)
    return Entry(
        "thick-band",
        "A thick band on a small finger",
        (
            f"At a half-angle of {angle:g} degree the finger's circle has a radius of {radii[0] * 1e3:.1f} mm to the "
            "middle of the band.",
            finding(
                half[first] >= radii[first],
                f"A band of {thicknesses[first] * 1e3:g} mm has a half thickness of {half[first] * 1e3:.1f} mm when "
                "stretched, which leaves no room for a finger.",
                f"A band of {thicknesses[first] * 1e3:g} mm has a half thickness of {half[first] * 1e3:.1f} mm when "
                "stretched, which leaves room for a finger.",
            ),
        ),
        (
            finding(
                not refusals[0]
                and bool(refusals[-1])
                and all((h >= r) == bool(error) for h, r, error in zip(half, radii, refusals, strict=True)),
                f"Refused are those bands alone that leave no room ({_cause(refusals[first])}).",
                "Refused are not those bands alone that leave no room.",
            ),
            "Above half of that a warning says that beam theory is not accurate on the finger.",
        ),
        {"radius_m": radii[first], "half_thickness_m": float(half[first])},
        Picture(
            "finger and band",
            "thickness (mm)",
            "mm",
            (
                Curve(thicknesses * 1e3, half * 1e3, "half thickness, stretched", "o-"),
                Curve(thicknesses * 1e3, np.array(radii) * 1e3, "radius to the middle of the band"),
            ),
        ),
    )
