"""Failures of the loss: none at a shock, and too much."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband import follow
from beadband.plan import plan_of
from beadband.scene import scene_of
from beadband.stability import rings
from beadband.stability.entry import Curve, Entry, Picture
from beadband.validity import validity_warnings

_AT = 0.6
"""Share of the front's arrival at which the leg is looked at."""


def no_loss(quick: bool) -> Entry:
    """A shock without dashpots: ringing at the scale of the beads, whatever their number."""
    counts = (300, 600) if quick else (300, 600, 1200)
    curves, ringing, speeds = [], {}, {}
    for loss in (0.0, None):
        for beads in counts:
            plan = plan_of(scene_of({"beads": beads, "loss_time_s": loss} if loss == 0.0 else {"beads": beads}))
            ring = follow.hold(plan)
            course, times = rings.let_go(plan, ring, plan.timestep_s, 120)
            frame = int(np.argmin(np.abs(times - _AT * plan.front_arrival_s)))
            stretches = rings.upper_stretches(plan, ring, course.positions_m[frame])
            share = (np.arange(len(stretches)) + 0.5) / beads * plan.scene.band.circumference_m
            share /= plan.scene.wedge.reference_leg_m
            behind = (share > 0.25) & (share < 0.5)
            ringing[loss, beads] = float(np.std(stretches[behind]))
            speeds[loss, beads] = follow.follow_rear(plan).speed_m_s.value
            if beads == counts[-1]:
                name = "no loss" if loss == 0.0 else "numerical loss"
                curves.append(Curve(share, stretches - 1.0, f"{name}, {beads} beads"))
    fine = counts[-1]
    error = speeds[0.0, fine] / speeds[None, fine] - 1.0
    kept = ringing[0.0, fine] / ringing[0.0, counts[0]]
    damped = ringing[None, fine] / ringing[0.0, fine]
    spread = abs(speeds[None, fine] / speeds[None, counts[-2]] - 1.0)
    warned = any("rings" in text for text in plan_of(scene_of({"loss_time_s": 0.0})).warnings)
    return Entry(
        "no-loss",
        "No loss at a shock",
        "A Mooney-Rivlin band unloads through a shock, which must dissipate; without dashpots the energy goes into "
        f"ringing from bead to bead of strain {ringing[0.0, fine]:.2g} (rms), {kept:.2f} times as large with "
        f"{fine // counts[0]} times the beads, and V is off by {error:+.2%}. No refinement cures it: the limit of "
        "beads without loss is not the band.",
        f"A plan gives every bond a dashpot that vanishes with the spacing (ringing {ringing[None, fine]:.1g}, V "
        f"moves by {spread:.2%} on doubling the beads); --loss-time 0 with such a law is run, and warned about.",
        {
            "ringing_no_loss": ringing[0.0, fine],
            "ringing_over_that_of_fewest_beads": kept,
            "ringing_numerical_loss": ringing[None, fine],
            "speed_error_no_loss": error,
            "speed_change_on_doubling": spread,
        },
        Picture("strain along the leg at 0.6 t_f", "distance from the tip / leg", "strain", tuple(curves)),
        kept > 0.5 and damped < 0.2 and abs(error) > 0.004 and spread < 0.003 and warned,
    )


def much_loss(quick: bool) -> Entry:
    """A loss that smears the front over the leg."""
    losses = np.array([1e-5, 1e-4, 1e-3, 4e-3] if quick else [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 2e-3, 4e-3])
    beads = 160
    free = follow.follow_rear(plan_of(scene_of({"beads": beads, "for": "speed"}))).speed_m_s.value
    speeds, steps = [], []
    for loss in losses:
        plan = plan_of(scene_of({"beads": beads, "for": "speed", "loss_time_s": float(loss)}))
        speeds.append(follow.follow_rear(plan).speed_m_s.value)
        steps.append(plan.steps)
    change = np.array(speeds) / free - 1.0
    warned = [any("viscous" in text for text in validity_warnings(scene_of({"loss_time_s": float(x)}))) for x in losses]
    return Entry(
        "much-loss",
        "Too much loss",
        f"A loss time of {losses[-1]:.0e} s spreads the front over more than a leg: V changes by {change[-1]:+.1%} "
        f"(at {losses[0]:.0e} s by {change[0]:+.2%}), and what is computed is a viscous band. The step falls as one "
        f"over the loss time: {steps[-1] / steps[0]:.0f} times the steps.",
        "The planned loss is a fifth of the front's time from bead to bead. A loss of the user's is taken as "
        "physics, and warned about once it spreads the front over a tenth of a leg.",
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
        abs(change[-1]) > 0.03 and abs(change[0]) < 0.01 and warned[-1] and not warned[0],
    )


def rebound(quick: bool) -> Entry:
    """A strand that rebounds on its held end is pressed, and buckles."""
    from beadband.stability import trials
    from beadband.verification.specimen import END, FREE, HELD, chain, strand_of

    strand = strand_of("III", "linear", 1e-3)
    count, strain = 41, 0.3
    line = np.zeros((count, 2))
    line[:, 0] = strand.spacing_m * (1.0 + strain) * np.arange(count)
    line[1:-1, 1] = 1e-3 * strand.spacing_m * np.sin(np.arange(1, count - 1) * 0.9)
    types = np.full(count, FREE)
    types[0], types[-1] = HELD, END
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
        f"A strand of strain {strain} let go at one end is slack when the front reaches the other, and thrown back it "
        f"is pressed to a stretch of {least:.2f}; a push that bending can't bear buckles it, and an imperfection of "
        f"{before:.1e} bonds grows to {after:.2g} bonds. The shape of the buckles comes from noise and is nobody's "
        "answer.",
        "A release ends when the front arrives at the finger, before anything is thrown back; the step allows for "
        f"the compression that bonds meet until then (the default is planned for {plan.largest_timestep_s:.3g} s at "
        "most).",
        {"least_stretch": least, "sideways_before_bonds": before, "sideways_after_bonds": after},
        Picture(
            "a strand let go at one end",
            "time / (length / wave speed)",
            "",
            (
                Curve(times, stretches.min(axis=1), "least stretch"),
                Curve(times, np.maximum(sideways, 1e-6), "largest height (bonds)"),
            ),
            logy=True,
        ),
        least < 0.9 and after > 30.0 * before and after > 0.1,
    )
