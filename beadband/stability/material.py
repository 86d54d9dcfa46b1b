"""Failures of the material and of the section: past the tension peak, outside the bond table, too thick."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband import follow
from beadband.errors import RunError, UsageError
from beadband.inputs import DEEPEST_STRETCH, WIDEST_STRAIN
from beadband.plan import plan_of
from beadband.scene import scene_of
from beadband.stability import trials
from beadband.stability.entry import Curve, Entry, Picture
from beadband.validity import check_validity
from beadband.verification.specimen import FREE, HELD, chain, strand_of


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
        types[[0, -1]] = HELD
        piece = replace(
            chain(strand, line, types, strain=9.0 / WIDEST_STRAIN), cutoff_m=3.0 * strand.spacing_m * stretch
        )
        step = 0.3 * strand.state_step_s(1.0, 1e-5)
        done = steps
        while True:
            try:
                course = trials.run(piece, step, done, max(1, done // 100), trials.Options(loss_time_s=1e-5))
                break
            except RunError:
                # It tears: look at it a little earlier.
                done = int(0.9 * done)
                if done < 50:
                    raise
        stretches = np.diff(course.positions_m[..., 0], axis=1) / strand.spacing_m
        spreads[stretch] = np.ptp(stretches, axis=1)
        times[stretch] = step * course.steps
        last = stretches[-1]
    grown = float(spreads[2.8][-1] / spreads[2.8][0])
    kept = float(spreads[2.3][-1] / spreads[2.3][0])
    narrow = int(np.sum(last > peak))
    try:
        scene_of({"band": "IV", "strain": 1.8})
        refusal = ""
    except UsageError as error:
        refusal = str(error)
    return Entry(
        "past-peak",
        "Band IV past its tension peak",
        f"Band IV's tension peaks at a stretch of {peak:.3f} (C10 < 0). Held at 2.8, unevenness of a thousandth grows "
        f"{grown:.0f} times within {times[2.8][-1] * 1e3:.1f} ms: the strand necks in single bonds ({narrow} of "
        f"{count - 1} above the peak, up to a stretch of {last.max():.2f}, on their way to tear; the others unload to "
        f"{last.min():.2f}), so that the answer hangs on the number of beads. At 2.3 the same unevenness dies to "
        f"{kept:.2f} of itself.",
        "Such a scene is refused before anything is computed: " + refusal.split(";")[0] + ".",
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
        grown > 30.0 and kept < 1.0 and "tension peaks" in refusal,
    )


def beyond_table(quick: bool) -> Entry:
    """A bond torn out of the table of its law."""
    strand = strand_of("III", "mooney-rivlin", 1e-3)
    count, strain = 31, 0.476
    line = np.zeros((count, 2))
    line[:, 0] = strand.spacing_m * np.arange(count)
    types = np.full(count, FREE)
    types[0] = HELD
    speeds = (5.0, 40.0)
    said, reached = [], []
    for speed in speeds:
        piece = replace(chain(strand, line, types, strain=strain), velocities_m_s=np.zeros_like(line))
        piece.velocities_m_s[-4:, 0] = speed
        limit = strand.largest_step_s(1e-5, WIDEST_STRAIN * strain, 0.7)
        try:
            course = trials.run(piece, 0.5 * limit, 400, 4, trials.Options(loss_time_s=1e-5), largest_step_s=limit)
            reached.append(float(np.diff(course.positions_m[..., 0], axis=1).max()) / strand.spacing_m)
            said.append("")
        except RunError as error:
            reached.append(math.inf)
            said.append(str(error))
    ends = (DEEPEST_STRETCH, 1.0 + WIDEST_STRAIN * strain)
    stretch = np.linspace(*ends, 200)
    return Entry(
        "beyond-table",
        "A stretch outside the bond table",
        f"The law is tabulated from a stretch of {ends[0]:g} to {ends[1]:.3f} for a strain of {strain}; four beads "
        f"torn off at {speeds[1]:g} m/s leave it, where a spline knows nothing (at {speeds[0]:g} m/s they reach "
        f"{reached[0]:.2f} and stay inside). Within one interval beyond the end LAMMPS reads memory behind the table, "
        "so that the forces there, and the end of a run that blows up, differ from one run to the next.",
        f"LAMMPS checks every bond at every step and stops; the line says which: '{said[1].split(': given')[0]}'. The "
        f"table reaches {WIDEST_STRAIN:g} times the held strain, which no sound release comes near.",
        {"table_from": ends[0], "table_to": ends[1], "reached_slow": reached[0]},
        Picture(
            "tension of a bond over its table",
            "stretch",
            "nominal stress (MPa)",
            (Curve(stretch, np.asarray(strand.law.stress(stretch)) / 1e6, "Mooney-Rivlin, band III"),),
        ),
        not said[0] and "has the strain" in said[1] and "bond of beads" in said[1],
    )


def thick_band(quick: bool) -> Entry:
    """A band thicker than the finger that it is wound round."""
    thicknesses = np.array([2e-3, 4e-3, 6e-3, 8e-3, 10e-3])
    radii, speeds, refused = [], [], []
    angle = 1.0
    for thickness in thicknesses:
        scene = scene_of({"thickness_m": float(thickness), "half_angle_deg": angle, "beads": 200, "for": "speed"})
        radii.append(scene.wedge.finger_radius_m)
        try:
            check_validity(scene)
            refused.append("")
        except UsageError as error:
            refused.append(str(error))
        try:
            speeds.append(follow.follow_rear(plan_of(scene)).speed_m_s.value)
        except (RunError, UsageError):
            speeds.append(math.nan)
    first = next((i for i, text in enumerate(refused) if text), len(refused) - 1)
    half = 0.5 * thicknesses / math.sqrt(1.476)
    answered = math.isfinite(speeds[first])
    return Entry(
        "thick-band",
        "A thick band on a small finger",
        f"At a half-angle of {angle:g} degree the finger's circle has a radius of {radii[0] * 1e3:.1f} mm to the "
        f"middle of the band; a band of {thicknesses[first] * 1e3:g} mm has a half thickness of "
        f"{half[first] * 1e3:.1f} mm when stretched, and "
        + (
            "no room for a finger, yet a chain of beads is wound round it all the same and gives V = "
            f"{speeds[first]:.1f} m/s."
            if answered
            else "no room for a finger."
        ),
        f"Refused with the numbers: {refused[first].split(';')[0]}. Above half of that a warning says that beam "
        "theory is not accurate on the finger.",
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
        not refused[0]
        and bool(refused[-1])
        and all((h >= r) == bool(t) for h, r, t in zip(half, radii, refused, strict=True)),
    )
