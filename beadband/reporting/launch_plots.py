"""The pictures of a launch: shapes, load of the finger, clearance, energies; each on axes of its own and together."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beadband.analysis.readers import Trajectory
from beadband.model.launch_string import finger_force_n
from beadband.reporting.plots import Panels, draw_panels
from beadband.reporting.style import SCREEN, Style
from beadband.reporting.summary import title_of

if TYPE_CHECKING:
    from beadband.runs.launch_results import Launch

_BLUE, _ORANGE, _GREEN, _GREY, _SAND = "#1f5fa8", "#c8601a", "#2c7d4f", "#6b6b6b", "#efe6d5"
_SNAPSHOTS = 7


def draw(done: Launch, ring: Trajectory, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Write pictures of shapes, finger, clearance and energy, and an overview, into the folder; return their paths."""
    scene = done.plan.scene
    title = f"{title_of(scene)}, {done.plan.beads} beads: the finger {scene.finger}"
    panels: Panels = {
        "shapes": lambda axes: shapes(axes, done, ring),
        "finger": lambda axes: finger(axes, done),
        "clearance": lambda axes: clearance(axes, done),
        "energy": lambda axes: energy(axes, done),
    }
    return draw_panels(panels, title, folder, style)


def _pause(axes: Any, done: Launch) -> None:
    """Shade the time from the finger's freedom to the rear's arrival."""
    found = done.found
    if found.finger_free_s is not None and found.rear_arrival_s is not None:
        span = found.finger_free_s * 1e3, found.rear_arrival_s * 1e3
        axes.axvspan(*span, color=_SAND, zorder=0, label=f"pause: {span[1] - span[0]:.3g} ms")


def shapes(axes: Any, done: Launch, ring: Trajectory) -> None:
    """Snapshots of the ring, from held (light) to the end (dark)."""
    from matplotlib import colormaps
    from matplotlib.patches import Circle

    times = ring.times_s(done.plan.timestep_s)
    chosen = np.unique(np.linspace(0, len(times) - 1, _SNAPSHOTS).round().astype(int))
    shades = colormaps["viridis_r"](np.linspace(0.15, 1.0, len(chosen)))
    support = done.support
    axes.add_patch(Circle((support.centre_m * 1e3, 0.0), support.radius_m * 1e3, color="#e4e0da", label="finger"))
    for frame, shade in zip(chosen, shades, strict=True):
        points = ring.positions_m[frame] * 1e3
        closed = np.concatenate([points, points[:1]])
        axes.plot(closed[:, 0], closed[:, 1], color=shade, linewidth=1.4, label=f"{times[frame] * 1e3:.2f} ms")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (mm)", ylabel="y (mm)", title="shape of the band")
    axes.legend(fontsize=7, ncols=2, loc="upper left", frameon=False)


def finger(axes: Any, done: Launch) -> None:
    """Force between finger and band over time, with the string's."""
    watch = done.watch
    times = watch.times_s(done.plan.timestep_s)
    middles = times.copy()
    middles[1:] = 0.5 * (times[1:] + times[:-1])
    _pause(axes, done)
    axes.plot(middles * 1e3, done.force_n, color=_BLUE, linewidth=1.0, label="force of the finger")
    axes.plot(
        times * 1e3,
        finger_force_n(done.plan.scene, times),
        color=_GREY,
        linestyle="--",
        linewidth=1.2,
        label="string (EI → 0)" if done.launch_plan.string.exact else "string, beyond its premises",
    )
    axes.axhline(0.0, color=_GREY, linewidth=0.5)
    axes.set(
        xlabel="time (ms)", ylabel="force (N)", title="force of the finger on the band", xlim=(0.0, times[-1] * 1e3)
    )
    axes.legend(fontsize=8, loc="lower left", frameon=False)


def clearance(axes: Any, done: Launch) -> None:
    """Way from the rear to the finger's surface, and the speed of the centre of mass."""
    times = done.watch.times_s(done.plan.timestep_s) * 1e3
    speed = done.centre_speed_m_s
    _pause(axes, done)
    axes.plot(times, done.clearance_m * 1e3, color=_BLUE, linewidth=1.2, label="rear to finger (left)")
    axes.axhline(0.0, color=_GREY, linewidth=0.5)
    axes.set(xlabel="time (ms)", ylabel="clearance (mm)", title="clearance and flight", xlim=(0.0, times[-1]))
    right = axes.twinx()
    right.plot(times, speed, color=_ORANGE, linewidth=1.2, label="centre of mass (right)")
    right.axhline(done.launch_plan.string.centre_of_mass_speed_m_s, color=_GREY, linestyle="--", linewidth=1.0)
    right.set_ylabel("speed (m/s)")
    right.set_ylim(0.0, 1.15 * max(speed.max(), done.launch_plan.string.centre_of_mass_speed_m_s))
    lines = [line for part in (axes, right) for line in part.get_legend_handles_labels()[0]]
    axes.legend(lines, [line.get_label() for line in lines], fontsize=8, loc="center left", frameon=False)


def energy(axes: Any, done: Launch) -> None:
    """Where the stored energy goes; the kinetic one split into translation and vibration."""
    balance, band = done.energy, done.plan.scene.band
    mass = band.mass_per_length_kg_m * band.circumference_m
    translation = done.watch.momentum_n_s**2 / (2.0 * mass)
    times, stored = balance.times_s * 1e3, balance.stored_j
    _pause(axes, done)
    for values, name, color in (
        (balance.stretching_j, "stretching", _BLUE),
        (translation, "translation", _ORANGE),
        (balance.kinetic_j - translation, "vibration", "#e0a878"),
        (balance.dissipated_j, "dissipated", _GREY),
        (balance.bending_j, "bending", _GREEN),
    ):
        axes.plot(times, values / stored, color=color, label=name)
    axes.set(
        xlabel="time (ms)",
        ylabel="share of the stored energy",
        title=f"energies (stored: {stored * 1e3:.4g} mJ)",
        xlim=(0.0, times[-1]),
        ylim=(0.0, 1.02),
    )
    axes.legend(fontsize=8, loc="center left", frameon=False)
