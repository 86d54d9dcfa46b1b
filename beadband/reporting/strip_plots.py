"""The pictures of a strip: stretch along it, speed of its end, path of its front, energies; and all together."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beadband.model.strip import profile
from beadband.reporting.plots import BLUE, GREY, ORANGE, Panels, draw_panels, energy, speed
from beadband.reporting.style import SCREEN, Style
from beadband.reporting.summary import title_of

if TYPE_CHECKING:
    from beadband.runs.strip_results import StripRun

_SNAPSHOTS = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Shares of the front's arrival."""


def draw(done: StripRun, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Write pictures of stretch, speed, front and energy, and an overview, into the folder; return their paths."""
    panels: Panels = {
        "stretch": lambda axes: stretch(axes, done),
        "speed": lambda axes: speed(axes, done, "released end", "exact"),
        "front": lambda axes: front(axes, done),
        "energy": lambda axes: energy(axes, done),
    }
    return draw_panels(panels, f"{title_of(done.scene)}, {done.plan.beads} bonds", folder, style)


def stretch(axes: Any, done: StripRun) -> None:
    """Stretch along the strip at some times, light to dark, with the exact profiles."""
    from matplotlib import colormaps

    frames, length = done.frames, done.scene.wedge.reference_leg_m
    bonds = frames.stretch.shape[1]
    places = 1e3 * length * (np.arange(bonds) + 0.5) / bonds
    speeds, stretches = profile(done.scene)
    held, free = 1.0 + done.scene.strain, 1.0 + done.plan.string.residual_strain
    shades = colormaps["viridis_r"](np.linspace(0.15, 1.0, len(_SNAPSHOTS)))
    for share, shade in zip(_SNAPSHOTS, shades, strict=True):
        frame = int(np.argmin(np.abs(frames.times_s - share * done.plan.front_arrival_s)))
        time = float(frames.times_s[frame])
        axes.plot(places, frames.stretch[frame], color=shade, linewidth=1.4, label=f"{time * 1e3:.2f} ms")
        exact = np.concatenate([[length], np.minimum(speeds * time, length), [0.0]])
        along = np.concatenate([[held], stretches, [free]])
        axes.plot(
            exact * 1e3, along, color=GREY, linestyle="--", linewidth=0.8, label="exact" if share == 0.9 else None
        )
    axes.set(xlabel="place in the unstretched strip (mm)", ylabel="stretch", title="stretch, from the released end")
    axes.legend(fontsize=7, frameon=False)


def front(axes: Any, done: StripRun) -> None:
    """Path of the front to the held end, with the exact one."""
    found, exact = done.strip, done.exact_front_speed_m_s
    seen = np.isfinite(found.path_m)
    times = done.frames.times_s
    axes.plot(times[seen] * 1e3, found.path_m[seen] * 1e3, ".", color=BLUE, markersize=4, label="front of the beads")
    ends = np.array([0.0, done.exact_arrival_s])
    axes.plot(
        ends * 1e3, exact * ends * 1e3, color=GREY, linestyle="--", linewidth=1.2, label=f"exact: {exact:.4g} m/s"
    )
    if done.arrival is not None and done.front_speed is not None:
        axes.plot(
            [done.arrival.value * 1e3], [done.scene.wedge.reference_leg_m * 1e3], "o", color=ORANGE,
            label=f"{done.front_speed} m/s, arrives at {done.arrival.scaled(1e3)} ms",
        )  # fmt: skip
    axes.set(xlabel="time (ms)", ylabel="place in the unstretched strip (mm)", title="front")
    axes.legend(fontsize=8, loc="lower right", frameon=False)
