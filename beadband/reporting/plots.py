"""The pictures of a run: shapes, speed, curvature and energies, each drawn on axes of its own and together."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from beadband.analysis.readers import Trajectory
from beadband.model.beam import at_rest_curvature, eq7_curvature
from beadband.model.scales import SPEED_WINDOW
from beadband.reporting.style import SCREEN, Style
from beadband.reporting.summary import title_of
from beadband.statics.ring import Ring

if TYPE_CHECKING:
    from beadband.runs.results import Run

BLUE, ORANGE, GREEN, GREY = "#1f5fa8", "#c8601a", "#2c7d4f", "#6b6b6b"
_SNAPSHOTS = 7

Panels = dict[str, Callable[[Any], None]]
"""What draws each picture into its axes, by name."""


def draw(run: Run, ring: Trajectory, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Write pictures of shapes, speed, curvature and energy, and an overview, into the folder; return their paths."""
    scene = run.plan.scene
    title = f"{title_of(scene)}, {run.plan.beads} beads"
    panels: Panels = {
        "shapes": lambda axes: shapes(axes, run, ring),
        "speed": lambda axes: speed(axes, run),
        "curvature": lambda axes: curvature(axes, run),
        "energy": lambda axes: energy(axes, run),
    }
    return draw_panels(panels, title, folder, style)


def draw_panels(
    panels: Panels, title: str, folder: str | os.PathLike[str], style: Style = SCREEN, overview: str = "overview"
) -> list[Path]:
    """Write panels as pictures of their own, and together under the title as an overview; return their paths."""
    written = []
    with style.applied() as pyplot:
        for name, panel in panels.items():
            figure, axes = pyplot.subplots(figsize=style.size_in(6.4, 4.2), layout="constrained")
            panel(axes)
            written.append(style.save(figure, Path(folder) / name))
            pyplot.close(figure)
        rows = -(-len(panels) // 2)
        size = style.size_in(12.0, 4.0 * rows)
        if style.columns == 1:  # below each other
            size = size[0], 2.0 * len(panels)
        figure, grid = pyplot.subplots(*((len(panels), 1) if style.columns == 1 else (rows, 2)), figsize=size,
                                       layout="constrained", squeeze=False)  # fmt: skip
        for panel, axes in zip(panels.values(), grid.flat, strict=False):
            panel(axes)
        figure.suptitle(title)
        written.append(style.save(figure, Path(folder) / overview))
        pyplot.close(figure)
    return written


def shapes(axes: Any, run: Run, ring: Trajectory) -> None:
    """Snapshots of the ring around the finger, from held (light) to the end (dark)."""
    from matplotlib import colormaps
    from matplotlib.patches import Circle

    assert isinstance(run.held, Ring)
    times = ring.times_s(run.plan.timestep_s)
    chosen = np.unique(np.linspace(0, len(times) - 1, _SNAPSHOTS).round().astype(int))
    shades = colormaps["viridis_r"](np.linspace(0.15, 1.0, len(chosen)))
    centre = (run.held.finger_centre_m * 1e3, 0.0)
    axes.add_patch(Circle(centre, (run.held_radius_m or 0.0) * 1e3, color="#e4e0da", label="finger"))
    if peg := run.scene.tip_radius_m * 1e3:
        axes.add_patch(Circle((peg, 0.0), peg, fill=False, color="#a09a90", linestyle="--", label="peg"))
    for frame, shade in zip(chosen, shades, strict=True):
        points = ring.positions_m[frame] * 1e3
        closed = np.concatenate([points, points[:1]])
        axes.plot(closed[:, 0], closed[:, 1], color=shade, linewidth=1.4, label=f"{times[frame] * 1e3:.2f} ms")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (mm)", ylabel="y (mm)", title="shape of the band")
    axes.legend(fontsize=7, ncols=2, loc="upper left", frameon=False)


def speed(axes: Any, run: Run, end: str = "rear tip", limit: str = "string limit (EI → 0)") -> None:
    """Speed of the rear over time, with the string limit and the fitted rebound speed over its window."""
    rear, plan = run.measurement.rear, run.plan
    arrival = plan.front_arrival_s
    value = run.speed.value
    axes.plot(rear.times_s * 1e3, rear.tip_speed_m_s, color=BLUE, linewidth=0.9, label=end)
    axes.axhline(plan.string.rear_speed_m_s, color=GREY, linestyle="--", linewidth=1.2, label=limit)
    window = [share * arrival * 1e3 for share in SPEED_WINDOW]
    axes.plot(window, [value, value], color=ORANGE, linewidth=2.5, label=f"V = {run.speed} m/s")
    axes.set(xlabel="time (ms)", ylabel="speed (m/s)", title=f"speed of the {end}", xlim=(0.0, arrival * 1e3))
    axes.set_ylim(0.0, 1.5 * max(value, plan.string.rear_speed_m_s))
    axes.legend(fontsize=8, loc="lower right", frameon=False)


def curvature(axes: Any, run: Run) -> None:
    """Tip curvature over time, log-log, with Eq. 7, the beam released at rest and the self-similar window."""
    found, plan = run.measurement, run.plan
    later = found.rear.times_s > 0.0
    times = found.rear.times_s[later]
    axes.loglog(times * 1e3, found.rear.tip_curvature_1_m[later], color=BLUE, linewidth=1.1, label="rear tip")
    if plan.scene.bending_stiffness_n_m2 > 0.0:
        diffusivity = plan.scene.bending_diffusivity_m2_s
        angle = plan.scene.half_angle_rad
        axes.loglog(times * 1e3, eq7_curvature(times, angle, diffusivity), "--", color=ORANGE, label="Eq. 7")
        axes.loglog(
            times * 1e3, at_rest_curvature(times, angle, diffusivity), ":", color=GREEN, label="beam kink at rest"
        )
    if found.decay is not None:
        axes.axvspan(
            found.window.start_s * 1e3,
            found.window.end_s * 1e3,
            color="#efe6d5",
            zorder=0,
            label=f"window: t^({found.decay.exponent.value:.2f})",
        )
    axes.set(xlabel="time (ms)", ylabel="curvature (1/m)", title="curvature at the rear tip")
    axes.legend(fontsize=8, loc="lower left", frameon=False)


def energy(axes: Any, run: Run) -> None:
    """Where the stored energy goes."""
    shares(axes, run, {"kinetic": (run.energy.kinetic_j, ORANGE)})


def shares(axes: Any, run: Run, moving: Mapping[str, tuple[Any, str]]) -> None:
    """Energies over time as shares of the stored one; ``moving`` has the parts of the kinetic one and their colours."""
    balance = run.energy
    times, stored = balance.times_s * 1e3, balance.stored_j
    parts = {
        "stretching": (balance.stretching_j, BLUE),
        **moving,
        "dissipated": (balance.dissipated_j, GREY),
        "bending": (balance.bending_j, GREEN),
    }
    for name, (values, color) in parts.items():
        axes.plot(times, values / stored, color=color, label=name)
    axes.set(
        xlabel="time (ms)",
        ylabel="share of the stored energy",
        title=f"energies (stored: {stored * 1e3:.4g} mJ)",
        xlim=(0.0, times[-1]),
        ylim=(0.0, 1.02),
    )
    axes.legend(fontsize=8, loc="center left", frameon=False)
