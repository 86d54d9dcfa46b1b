"""The pictures of a launch: shapes, load of the finger, clearance, energies; each on axes of its own and together."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beadband.analysis.readers import Trajectory
from beadband.model.flight import path_m
from beadband.model.launch_string import finger_force_n
from beadband.reporting.plots import BLUE, GREEN, GREY, ORANGE, Panels, draw_panels, shapes, shares
from beadband.reporting.style import SCREEN, Style
from beadband.reporting.summary import title_of

if TYPE_CHECKING:
    from beadband.runs.launch_results import Launch

_SAND = "#efe6d5"


def draw(done: Launch, ring: Trajectory, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Write pictures of shapes, finger, clearance and energy, and an overview, into the folder; return their paths."""
    scene = done.plan.scene
    moves = "moves" if done.hand else scene.finger
    title = f"{title_of(scene)}, {done.plan.beads} beads: the finger {moves}"
    panels: Panels = {
        "shapes": lambda axes: _shapes(axes, done, ring),
        "finger": lambda axes: finger(axes, done),
        "clearance": lambda axes: clearance(axes, done),
        "energy": lambda axes: energy(axes, done),
    }
    if done.flight is not None:
        panels["flight"] = lambda axes: flight(axes, done)
    return draw_panels(panels, title, folder, style)


def _shapes(axes: Any, done: Launch, ring: Trajectory) -> None:
    """The shapes of the band; a finger that moves also where it ends, with a star where it is hit."""
    shapes(axes, done, ring)
    if done.hand is None:
        return
    from matplotlib.patches import Circle

    support, way = done.support, done.hand.found.displacement_m
    x, radius = 1e3 * (support.centre_m + way), 1e3 * support.radius_m
    axes.add_patch(Circle((x, 0.0), radius, fill=False, edgecolor=ORANGE, linestyle="--"))
    if done.hand.found.hit:
        axes.plot(x - radius, 0.0, marker="*", markersize=12, color=ORANGE)


def _pause(axes: Any, done: Launch) -> None:
    """Shade the time from the finger's freedom to the rear's arrival; a line marks when the band touches itself."""
    found = done.found
    if found.finger_free_s is not None and found.rear_arrival_s is not None:
        span = found.finger_free_s * 1e3, found.rear_arrival_s * 1e3
        axes.axvspan(*span, color=_SAND, zorder=0, label=f"pause: {span[1] - span[0]:.3g} ms")
    if done.self_touch_s is not None:
        axes.axvline(done.self_touch_s * 1e3, color=GREEN, linewidth=1.0, linestyle=":", label="touches itself")


def finger(axes: Any, done: Launch) -> None:
    """Force between finger and band over time, with the string's."""
    watch = done.watch
    times = watch.times_s(done.plan.timestep_s)
    middles = times.copy()
    middles[1:] = 0.5 * (times[1:] + times[:-1])
    _pause(axes, done)
    axes.plot(middles * 1e3, done.force_n, color=BLUE, linewidth=1.0, label="force of the finger")
    axes.plot(
        times * 1e3,
        finger_force_n(done.plan.scene, times),
        color=GREY,
        linestyle="--",
        linewidth=1.2,
        label="string (EI → 0)" if done.launch_plan.string.exact else "string, beyond its premises",
    )
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    axes.set(
        xlabel="time (ms)", ylabel="force (N)", title="force of the finger on the band", xlim=(0.0, times[-1] * 1e3)
    )
    axes.legend(fontsize=8, loc="lower left", frameon=False)


def clearance(axes: Any, done: Launch) -> None:
    """Way from the rear to the finger's surface, and the speed of the centre of mass."""
    times = done.watch.times_s(done.plan.timestep_s) * 1e3
    speed = done.centre_speed_m_s
    _pause(axes, done)
    axes.plot(times, done.clearance_m * 1e3, color=BLUE, linewidth=1.2, label="rear to finger (left)")
    if done.hand is not None:
        axes.plot(
            times, done.hand.path.x_m * 1e3, color=BLUE, linewidth=1.0, linestyle=":", label="way of the hand (left)"
        )
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    axes.set(xlabel="time (ms)", ylabel="clearance (mm)", title="clearance and flight", xlim=(0.0, times[-1]))
    right = axes.twinx()
    right.plot(times, speed, color=ORANGE, linewidth=1.2, label="centre of mass (right)")
    right.axhline(done.launch_plan.string.centre_of_mass_speed_m_s, color=GREY, linestyle="--", linewidth=1.0)
    right.set_ylabel("speed (m/s)")
    right.set_ylim(0.0, 1.15 * max(speed.max(), done.launch_plan.string.centre_of_mass_speed_m_s))
    lines = [line for part in (axes, right) for line in part.get_legend_handles_labels()[0]]
    axes.legend(lines, [line.get_label() for line in lines], fontsize=8, loc="center left", frameon=False)


def flight(axes: Any, done: Launch) -> None:
    """The path to the ground, in air and without."""
    throw, scene = done.flight, done.scene
    assert throw is not None
    assert scene.elevation_deg is not None
    thrown = (throw.speed_m_s, math.radians(scene.elevation_deg), scene.height_m)
    if throw.drag_length_m is not None:
        text = f"in air: {throw.range} m"
        axes.plot(*path_m(*thrown, throw.drag_length_m).T, color=BLUE, label=text)
        axes.errorbar([throw.range.value], [0.0], xerr=[throw.range.error], color=BLUE, capsize=3)
    axes.plot(*path_m(*thrown).T, color=GREY, linestyle="--", label=f"without air: {throw.vacuum.range_m:.3g} m")
    axes.set(xlabel="way (m)", ylabel="height (m)", title=f"flight, thrown at {scene.elevation_deg:g}°")
    axes.legend(fontsize=8, frameon=False)


def energy(axes: Any, done: Launch) -> None:
    """Where the stored energy goes; the kinetic one split into translation and vibration."""
    band = done.plan.scene.band
    mass = band.mass_per_length_kg_m * band.circumference_m
    translation = done.watch.momentum_n_s**2 / (2.0 * mass)
    _pause(axes, done)
    vibration = done.energy.kinetic_j - translation
    shares(axes, done, {"translation": (translation, ORANGE), "vibration": (vibration, "#e0a878")})
