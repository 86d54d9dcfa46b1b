"""Failures of the loss: none at a shock, and too much."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.model.scene import scene_of
from beadband.model.validity import validity_notices
from beadband.planning.plan import LOSS_BEADS, plan_of
from beadband.runs.rear_run import follow_rear, hold
from beadband.studies.stability import ring_trials as rings
from beadband.studies.stability import trials
from beadband.studies.stability.catalogue_entry import Curve, Entry, Picture, carries, finding
from beadband.studies.verification.specimen import END, FIXED, FREE, chain, strand_of

_AT = 0.6
"""Share of the front's arrival at which the strains of the leg are compared."""


def no_loss(quick: bool) -> Entry:
    """A shock without dashpots: ringing at the scale of the beads, whatever their number."""
    counts = (300, 600) if quick else (300, 600, 1200)
    curves, ringing, speeds = [], {}, {}
    for loss in (0.0, None):
        for beads in counts:
            plan = plan_of(scene_of({"beads": beads, "loss_time_s": loss} if loss == 0.0 else {"beads": beads}))
            ring = hold(plan)
            course, times = rings.release(plan, ring, plan.timestep_s, 120)
            frame = int(np.argmin(np.abs(times - _AT * plan.front_arrival_s)))
            stretches = rings.upper_stretches(plan, ring, course.positions_m[frame])
            share = (np.arange(len(stretches)) + 0.5) / beads * plan.scene.band.circumference_m
            share /= plan.scene.wedge.reference_leg_m
            behind = (share > 0.25) & (share < 0.5)
            ringing[loss, beads] = float(np.std(stretches[behind]))
            speeds[loss, beads] = follow_rear(plan).fitted_speed_m_s.value
            if beads == counts[-1]:
                name = "no loss" if loss == 0.0 else "numerical loss"
                curves.append(Curve(share, stretches - 1.0, f"{name}, {beads} beads"))
    fine = counts[-1]
    error = speeds[0.0, fine] / speeds[None, fine] - 1.0
    kept = ringing[0.0, fine] / ringing[0.0, counts[0]]
    damped = ringing[None, fine] / ringing[0.0, fine]
    spread = abs(speeds[None, fine] / speeds[None, counts[-2]] - 1.0)
    warned = carries(plan_of(scene_of({"loss_time_s": 0.0})).warnings, "lossless-shock")
    return Entry(
        "no-loss",
        "No loss at a shock",
        (
            "A Mooney-Rivlin band unloads through a shock, which must dissipate; without dashpots the energy goes "
            f"into ringing from bead to bead of strain {ringing[0.0, fine]:.2g} (rms).",
            finding(
                kept > 0.5,
                f"With {fine // counts[0]} times the beads it is {kept:.2f} times as large: refinement does not "
                "remove it.",
                f"With {fine // counts[0]} times the beads it falls to {kept:.2f} of itself: refinement removes it.",
            ),
            finding(
                abs(error) > 0.004,
                f"V is off by {error:+.2%}: the limit of beads without loss is not the band.",
                f"V is off by only {error:+.2%}.",
            ),
        ),
        (
            "A plan gives every bond a dashpot that vanishes with the spacing.",
            finding(
                damped < 0.2,
                f"It damps the ringing to {ringing[None, fine]:.1g}.",
                f"It leaves a ringing of {ringing[None, fine]:.1g}.",
            ),
            finding(
                spread < 0.003,
                f"V changes by {spread:.2%} on doubling the beads.",
                f"V still changes by {spread:.2%} on doubling the beads.",
            ),
            finding(
                warned,
                "A run with --loss-time 0 and such a law carries a warning.",
                "A run with --loss-time 0 and such a law carries no warning.",
            ),
        ),
        {
            "ringing_no_loss": ringing[0.0, fine],
            "ringing_over_that_of_fewest_beads": kept,
            "ringing_numerical_loss": ringing[None, fine],
            "speed_error_no_loss": error,
            "speed_change_on_doubling": spread,
        },
        Picture("strain along the leg at 0.6 t_f", "distance from the tip / leg", "strain", tuple(curves)),
    )


def much_loss(quick: bool) -> Entry:
    """A loss that smears the front over the leg."""
    losses = np.array([1e-5, 1e-4, 1e-3, 4e-3] if quick else [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 2e-3, 4e-3])
    beads = 160
    free = follow_rear(plan_of(scene_of({"beads": beads, "for": "speed"}))).fitted_speed_m_s.value
    speeds, steps = [], []
    for loss in losses:
        plan = plan_of(scene_of({"beads": beads, "for": "speed", "loss_time_s": float(loss)}))
        speeds.append(follow_rear(plan).fitted_speed_m_s.value)
        steps.append(plan.steps)
    change = np.array(speeds) / free - 1.0
    warned = [carries(validity_notices(scene_of({"loss_time_s": float(x)})), "viscous-front") for x in losses]
    return Entry(
        "much-loss",
        "Too much loss",
        (
            finding(
                abs(change[-1]) > 0.03 and abs(change[0]) < 0.01,
                f"A loss time of {losses[-1]:.0e} s changes V by {change[-1]:+.1%} (one of {losses[0]:.0e} s by "
                f"{change[0]:+.2%}): the result is that of a viscous band.",
                f"A loss time of {losses[-1]:.0e} s changes V by {change[-1]:+.1%}, one of {losses[0]:.0e} s by "
                f"{change[0]:+.2%}.",
            ),
            f"The larger loss takes {steps[-1] / steps[0]:.0f} times the steps.",
        ),
        (
            f"The planned loss time is {LOSS_BEADS:g} of the front's time from bead to bead; --loss-time is taken as "
            "physics.",
            finding(
                warned[-1] and not warned[0],
                "The largest loss carries a warning, the least none.",
                f"The largest loss carries {'a' if warned[-1] else 'no'} warning, the least "
                f"{'one too' if warned[0] else 'none'}.",
            ),
        ),
        {
            "speed_change_least_loss": float(change[0]),
            "speed_change_most_loss": float(change[-1]),
            "steps_over_least": steps[-1] / steps[0],
        },
        Picture(
            "rebound speed against the loss time",
            "loss time (s)",
            "V (m/s)",
            (Curve(losses, np.array(speeds), "material loss", "o-"),),
            logx=True,
            levels=((free, "numerical loss alone"),),
        ),
    )


def rebound(quick: bool) -> Entry:
    """A strand that rebounds on its held end is compressed, and buckles."""
    strand = strand_of("III", "linear", 1e-3)
    count, strain = 41, 0.3
    line = np.zeros((count, 2))
    line[:, 0] = strand.spacing_m * (1.0 + strain) * np.arange(count)
    line[1:-1, 1] = 1e-3 * strand.spacing_m * np.sin(np.arange(1, count - 1) * 0.9)
    types = np.full(count, FREE)
    types[0], types[-1] = FIXED, END
    specimen = replace(chain(strand, line, types, strain=strain), cutoff_m=3.8 * strand.spacing_m)
    speed = math.sqrt(strand.modulus_pa / strand.density_kg_m3)
    crossing = (count - 1) * strand.spacing_m / speed
    step = 0.5 * strand.largest_step_s(1e-5, strain, 0.6)
    steps = int(3.0 * crossing / step)
    course = trials.run(specimen, step, steps, max(1, steps // 120), trials.Options(loss_time_s=1e-5))
    times = step * course.steps / crossing
    bonds = np.diff(course.positions_m, axis=1)
    stretches = np.hypot(bonds[..., 0], bonds[..., 1]) / strand.spacing_m
    sideways = np.abs(course.positions_m[..., 1]).max(axis=1) / strand.spacing_m
    before = float(sideways[times < 1.0].max())
    after = float(sideways.max())
    least = float(stretches.min())
    plan = plan_of(scene_of({}))
    return Entry(
        "rebound",
        "Compression after the rebound",
        (
            finding(
                least < 0.9,
                f"A strand of strain {strain} released at one end rebounds at the other and is compressed to a stretch "
                f"of {least:.2f}.",
                f"A strand of strain {strain} released at one end is hardly compressed: its least stretch is "
                f"{least:.2f}.",
            ),
            finding(
                after > 30.0 * before and after > 0.1,
                f"It buckles: an imperfection of {before:.1e} bonds grows to {after:.2g} bonds. The shape of the "
                "buckles depends on noise.",
                f"It does not buckle: an imperfection of {before:.1e} bonds becomes {after:.2g} bonds.",
            ),
        ),
        (
            "A release ends when the front arrives at the finger, before any rebound; the step allows for the "
            f"compression that bonds meet until then (for the default at most {plan.largest_timestep_s:.3g} s).",
        ),
        {"least_stretch": least, "sideways_before_bonds": before, "sideways_after_bonds": after},
        Picture(
            "a strand released at one end",
            "time / (length / wave speed)",
            "",
            (
                Curve(times, stretches.min(axis=1), "least stretch"),
                Curve(times, np.maximum(sideways, 1e-6), "largest height (bonds)"),
            ),
            logy=True,
        ),
    )
