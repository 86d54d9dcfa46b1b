"""Figures 16, 17 and 20: the release of Band III in pictures, its speed, and the string picture without bending."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.analysis.readers import Trajectory
from beadband.model.validity import SHARPEST
from beadband.studies.reproduction.drawing import SERIES, Sheet
from beadband.studies.reproduction.runs import Runs, Values
from beadband.studies.reproduction.scorecard import Entry, Verdict, agrees, at_least, falls, rises, small

PAPER: Values = {"band": "III", "thickness_m": 1.9e-3, "strain": 0.476, "half_angle_deg": 14.0}
"""The case of section 3.2, with the thickness of its text."""


def _whole(values: Values) -> tuple[Any, Trajectory]:
    """A release with frames of the whole ring."""
    from beadband.model.scene import scene_of
    from beadband.runs import finish, release
    from beadband.runs.folder import scratch

    with scratch() as place:
        done = release.run(scene_of(values), place / "run")
        return done, finish.frames(place / "run")


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
            Circle((done.held.finger_centre_m * 1e3, 0.0), done.held.finger_radius_m * 1e3, color="#e4e0da")
        )
        panel.plot(points[:, 0], points[:, 1], color=SERIES[1], linewidth=1.8)
        panel.set(
            xlabel="x (mm)", ylabel="y (mm)", title=f"{times[frame] * 1e3:.2f} ms", xlim=(-6, 136), ylim=(-60, 60)
        )
        panel.set_aspect("equal")
    figure.suptitle("Fig. 16: release of Band III (h = 1.9 mm, ε = 0.476, φ = 14°)")
    sheet.save(figure, "fig16")
    tip = done.measurement.rear.tip_curvature_1_m
    late = done.measurement.rear.times_s > 0.8 * done.plan.front_arrival_s
    at = ring.positions_m[[0, -1]]
    # The rear's width: distance between the two beads a twentieth of a leg to both sides of the tip.
    away = round(0.05 * done.plan.scene.wedge.reference_leg_m / done.plan.scene.band.circumference_m * done.plan.beads)
    width = np.linalg.norm(at[:, away] - at[:, -away], axis=1)
    bond = np.linalg.norm(at[:, away] - at[:, away - 1], axis=1)
    finger = np.hypot(ring.positions_m[-1, :, 0] - done.held.finger_centre_m, ring.positions_m[-1, :, 1])
    return [
        Entry(
            "Fig. 16",
            "a solid model on a rigid cylinder: the rear flattens and broadens while the legs unload",
            {
                "curvature_change": float(tip[late].mean() / tip[0]) - 1.0,
                "width_change": float(width[1] / width[0]) - 1.0,
                "length_change_of_bond": float(bond[1] / bond[0]) - 1.0,
                "half_thickness_times_curvature": 0.5 * done.plan.scene.band.thickness_m * float(tip[0]),
                "gap_mm": float(finger[:away].min() - done.held.finger_radius_m) * 1e3,
                "beads": done.plan.beads,
                "arrival_ms": done.plan.front_arrival_s * 1e3,
            },
            "with {beads:.0f} beads the curvature of the tip {curvature_change:?falls|does not fall} "
            "({curvature_change:+.0%}), the rear {width_change:?broadens|does not broaden} "
            "({width_change:+.0%}) and {length_change_of_bond:?unloads|does not unload} "
            "({length_change_of_bond:+.0%}) until the front arrives at {arrival_ms:.2f} ms; "
            "the rear is then {gap_mm:.1f} mm from the finger",
            printed=(falls("curvature_change"), rises("width_change"), falls("length_change_of_bond")),
            otherwise=(small("half_thickness_times_curvature", SHARPEST),),
            differences={
                Verdict.CHOICE: "C3D8R solids there, an Euler–Bernoulli chain here; the held "
                "tip's curvature times half the thickness is {half_thickness_times_curvature:.2f}"
            },
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
    share = found.times / found.arrival
    early, late = (float(found.tip_speed[(share > a) & (share < b)].mean()) for a, b in ((0.15, 0.35), (0.65, 0.85)))
    measured = found.tip_speed[(share > 0.4) & (share < 0.85)]
    ringing = float(measured.std() / measured.mean())
    return [
        Entry(
            "Fig. 17",
            "V rises with time, 'but the overall change was small'",
            {
                "early": early,
                "late": late,
                "change": late / early - 1.0,
                "change_over_ringing": (late / early - 1.0) / ringing,
                "reached_at": float(share[np.argmax(found.tip_speed >= 0.95 * found.speed.value)]),
            },
            "mean {early:.2f} m/s over 0.15–0.35 t_f, {late:.2f} m/s over 0.65–0.85 t_f ({change:+.1%}); 95 % "
            "of V is reached at {reached_at:.2f} t_f",
            printed=(small("change", 0.02),),
            remarks=(at_least("change_over_ringing", 1.0),),
            differences={
                Verdict.CONFIRMED: "little change, and {change_over_ringing:?a rise above|no rise above} the "
                "ringing of the tip; V is the slope over 0.4–0.85 t_f"
            },
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
    front = scene.wave_speeds(plan.string.front_speed_m_s)["front_horizontal"]
    published = plan.string.rear_speed_m_s / front / scene.published_ratio
    rear = upper[:bead][upper[:bead, 1] < 0.8 * height, 0]

    def closure(half_d: float) -> float:
        """(a + d/2)/l0 with the leg a that remains when the kink, on the leg, is d/2 off the axis."""
        return float((scene.wedge.leg_m - half_d / sine + half_d) / l0)

    return [
        Entry(
            "Fig. 20",
            "without bending the rear is a straight segment between two kinks",
            {
                "V_over_string": done.measurement.fitted_speed_m_s.value / plan.string.rear_speed_m_s,
                "bow_over_height": float(np.ptp(rear)) / height,
                "height_over_string": height / exact,
                "height_mm": height * 1e3,
                "string_mm": exact * 1e3,
                "published_mm": corrected * share * 1e3,
                "from_string": height / exact - 1.0,
                "from_published": height / (corrected * share) - 1.0,
            },
            "the rear {bow_over_height:?is straight|is not straight}, to {bow_over_height:.1%} of its half "
            "length; V is {V_over_string:.4f} of the exact string's; half the rear {height_mm:.2f} mm against "
            "{string_mm:.2f} mm (string) and {published_mm:.2f} mm (published)",
            printed=(
                small("bow_over_height", 0.05),
                agrees("V_over_string", 1.0, 0.01),
                agrees("height_over_string", 1.0, 0.1),
            ),
            differences={
                Verdict.CONFIRMED: "{from_string:+.1%} from the string, {from_published:+.1%} from the published"
            },
        ),
        Entry(
            "length d",
            "d = 2 ε l0 φ/(1 − sin φ)",
            {
                "corrected_mm": corrected * 1e3,
                "printed_mm": printed * 1e3,
                "closure_printed": closure(printed),
                "closure_with_sine": closure(corrected),
                "off": printed / corrected - 1.0,
            },
            "(a + d/2)/l0 is {closure_printed:.4f} as printed and {closure_with_sine:.4f} with sin φ for φ, "
            "and should be 1: d/2 = {corrected_mm:.3f} mm, printed {printed_mm:.3f} mm",
            printed=(agrees("closure_printed", 1.0, 1e-6),),
            corrected=(agrees("closure_with_sine", 1.0, 1e-6),),
            differences={Verdict.MISPRINT: "{off:+.1%}"},
        ),
        Entry(
            "geometry of V/C",
            "V/C = [ε/(1+ε)]/(1 − sin φ)",
            {
                "string_over_published": published,
                "residual": plan.string.residual_strain,
                "off": 1.0 / published - 1.0,
                "reach": (1.0 + scene.strain) * sine,
            },
            "the limit of no residual tension, with C the horizontal speed of the front; the exact string has "
            "ε1 = {residual:.4f} and V/C = {string_over_published:.3f} of it",
            printed=(agrees("string_over_published", 1.0, 0.01),),
            differences={Verdict.DISAGREEMENT: "{off:+.1%} at this scene; only for (1+ε) sin φ < 1 (here {reach:.2f})"},
        ),
    ]
