"""Figures 16, 17 and 20: the release of Band III in pictures, its speed, and the string picture without bending."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.analysis.trajectory import Trajectory
from beadband.reproduction.drawing import SERIES, Sheet
from beadband.reproduction.runs import Runs, Values
from beadband.reproduction.scorecard import CHOICE, CONFIRMED, DISAGREEMENT, MISPRINT, Entry

PAPER: Values = {"band": "III", "thickness_m": 1.9e-3, "strain": 0.476, "half_angle_deg": 14.0}
"""The case of section 3.2, with the thickness of its text."""


def _whole(values: Values) -> tuple[Any, Trajectory]:
    """A release with frames of the whole ring."""
    from beadband import release
    from beadband.folder import scratch
    from beadband.scene import scene_of

    with scratch() as place:
        done = release.run(scene_of(values), place / "run")
        return done, release.frames(place / "run")


def fig16(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Snapshots of the release."""
    from matplotlib.patches import Circle

    done, ring = _whole(PAPER)
    times = ring.times_s(done.plan.timestep_s)
    figure, axes = sheet.axes(columns=3, width=4.4, height=3.6)
    for panel, share in zip(axes, (0.0, 0.5, 1.0), strict=True):
        frame = int(np.argmin(np.abs(times - share * done.plan.front_arrival_s)))
        points = np.vstack([ring.positions_m[frame], ring.positions_m[frame, :1]]) * 1e3
        panel.add_patch(
            Circle((done.ring.finger_centre_m * 1e3, 0.0), done.ring.finger_radius_m * 1e3, color="#e4e0da")
        )
        panel.plot(points[:, 0], points[:, 1], color=SERIES[1], linewidth=1.8)
        panel.set(
            xlabel="x (mm)", ylabel="y (mm)", title=f"{times[frame] * 1e3:.2f} ms", xlim=(-6, 136), ylim=(-60, 60)
        )
        panel.set_aspect("equal")
    figure.suptitle("Fig. 16: release of Band III (h = 1.9 mm, ε = 0.476, φ = 14°)")
    sheet.save(figure, "fig16")
    return [
        Entry(
            "Fig. 16",
            "a solid model on a rigid cylinder: the rear flattens and broadens while the legs unload",
            f"the same shapes from {done.plan.beads} beads; no contact is computed before the front arrives at "
            f"{done.plan.front_arrival_s * 1e3:.2f} ms",
            "C3D8R solids there, an Euler–Bernoulli chain here",
            CHOICE,
        )
    ]


def fig17(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """Speed of the rear over time."""
    found = runs.of(PAPER)
    figure, (axes,) = sheet.axes()
    axes.plot(found.times * 1e3, found.tip_speed, color=SERIES[1], linewidth=1.0, label="rear tip")
    axes.axhline(
        found.string_speed, color="#888888", linestyle="--", label=f"string limit {found.string_speed:.2f} m/s"
    )
    axes.axhline(found.speed.value, color=SERIES[4], label=f"V = {found.speed.value:.2f} ± {found.speed.error:.2f} m/s")
    axes.set(
        xlabel="time (ms)",
        ylabel="speed (m/s)",
        title="Fig. 17: speed of the rear",
        ylim=(0.0, 24.0),
        xlim=(0.0, found.arrival * 1e3),
    )
    axes.legend(loc="lower right")
    sheet.save(figure, "fig17")
    means = [
        float(found.tip_speed[(found.times > a * found.arrival) & (found.times < b * found.arrival)].mean())
        for a, b in ((0.15, 0.35), (0.65, 0.85))
    ]
    creep = means[1] / means[0] - 1.0
    return [
        Entry(
            "Fig. 17",
            "V rises with time, 'but the overall change was small'",
            f"mean {means[0]:.2f} m/s over 0.15–0.35 t_f, {means[1]:.2f} m/s over 0.65–0.85 t_f ({creep:+.1%}), "
            f"after reaching speed within 0.1 t_f",
            "little change indeed, and within the ringing of the tip no rise; V is the slope over 0.4–0.85 t_f",
            CONFIRMED,
        )
    ]


def fig20(sheet: Sheet, runs: Runs, quick: bool) -> list[Entry]:
    """The trapezoid without bending, against the exact string and the published geometry."""
    values = {**PAPER, "bending_scale": 0.0, "beads": 400 if quick else 800}
    done, ring = _whole(values)
    plan, scene = done.plan, done.plan.scene
    frame = len(ring.steps) - 1
    time = float(ring.times_s(plan.timestep_s)[frame])
    upper = ring.positions_m[frame, : plan.beads // 2 + 1]
    bonds = np.diff(upper, axis=0)
    # The kink is spread over some beads: it lies where the direction is half-way from the rear's to the leg's.
    direction = np.arctan2(bonds[:, 1], bonds[:, 0])
    bead = int(np.argmax(direction < 0.5 * (0.5 * math.pi + scene.half_angle_rad)))
    height = float(upper[bead, 1])
    slope = math.tan(scene.half_angle_rad)
    exact = plan.string.rear_speed_m_s * time * slope
    l0, sine, phi = scene.wedge.reference_leg_m, math.sin(scene.half_angle_rad), scene.half_angle_rad
    corrected, printed = scene.strain * l0 * sine / (1.0 - sine), scene.strain * l0 * phi / (1.0 - sine)
    share = time / plan.front_arrival_s
    figure, (axes,) = sheet.axes(width=7.6)
    axes.plot(upper[:, 0] * 1e3, upper[:, 1] * 1e3, color=SERIES[1], label=f"ring without bending, {plan.beads} beads")
    x = plan.string.rear_speed_m_s * time
    end = scene.wedge.leg_m * math.cos(phi)
    axes.plot(
        np.array([x, x, end]) * 1e3,
        np.array([0.0, exact, end * slope]) * 1e3,
        "--",
        color=SERIES[0],
        label="exact string",
    )
    axes.plot([x * 1e3], [corrected * share * 1e3], "o", color=SERIES[5], label="published geometry, d/2 with sin φ")
    axes.plot([x * 1e3], [printed * share * 1e3], "x", color=SERIES[3], label="as printed, with φ")
    axes.set(xlabel="x (mm)", ylabel="y (mm)", title="Fig. 20: bending left out, at the front's arrival")
    axes.legend(loc="lower right", fontsize=8)
    sheet.save(figure, "fig20")
    ratio = done.measurement.speed_m_s.value / plan.string.rear_speed_m_s
    front = scene.wave_speeds(plan.string.front_speed_m_s)["front_horizontal"]
    of_published = plan.string.rear_speed_m_s / front / scene.published_ratio
    return [
        Entry(
            "Fig. 20",
            "without bending the rear is a straight segment between two kinks",
            f"so it is: V is {ratio:.4f} of the exact string's, half the rear {height * 1e3:.2f} mm against "
            f"{exact * 1e3:.2f} mm (string) and {corrected * share * 1e3:.2f} mm (published)",
            f"{height / exact - 1.0:+.1%} from the string, {height / (corrected * share) - 1.0:+.1%} from the "
            f"published",
            CONFIRMED,
        ),
        Entry(
            "length d",
            "d = 2 ε l0 φ/(1 − sin φ)",
            f"a + d/2 = l0 holds with sin φ for φ: d/2 = {corrected * 1e3:.3f} mm, printed {printed * 1e3:.3f} mm",
            f"{printed / corrected - 1.0:+.1%}",
            MISPRINT,
        ),
        Entry(
            "geometry of V/C",
            "V/C = [ε/(1+ε)]/(1 − sin φ)",
            f"the limit of no residual tension, with C the horizontal speed of the front; the exact string has ε1 "
            f"= {plan.string.residual_strain:.4f} and V/C = {of_published:.3f} of it",
            f"{1.0 / of_published - 1.0:.1%} too fast at this scene; valid for (1+ε) sin φ < 1 alone",
            DISAGREEMENT,
        ),
    ]
