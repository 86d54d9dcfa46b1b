"""The catalogue as a page, with its pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beadband.studies.stability.catalogue_entry import text as text_of
from beadband.studies.stability.limits import BOUND, REGIMES, Limit
from beadband.studies.stability.ring_trials import MOST_AT_SHOCK, MOST_SMOOTH

if TYPE_CHECKING:
    from beadband.studies.stability import Found
    from beadband.studies.stability.ring_trials import ReleaseLimit

_HEAD = """\
# Stability: where the methods fail

Written by `beadband stability{quick}`, with the numbers of that run. `beadband stability --only NAME`
reproduces one entry; exit code 3 says that a finding was not the expected one.
"""
_THEORY = """\
LAMMPS takes the forces of dashpots from velocities half a step back. With masses M, stiffness K and dashpots C,
a step dt of velocity Verlet is stable if and only if 4 M − dt² K − 2 dt C is positive definite
(`beadband/studies/stability/frozen.py` derives it): exact for every shape, stretch, angle form and loss, and in closed
form for a straight strand (`Strand.state_step_s`). Each point is a specimen shaken by a billionth of a spacing;
bisection to 0.1 % finds where the shaking grows. A regime is what sets the limit: bonds (axial), angles
(bending), the tension across the strand, dashpots, the contact with a finger, or resonance with the inner loop
of rRESPA.
"""
_RELEASES = """\
A release passes through many states. The limit of a uniform strand at the worst stretch that it meets bounds the
release's from below; nearer is the smallest exact limit of the shapes that a run well below it went through. The
release itself may bear more: it may exceed a shape's limit for as few steps as the shape lasts. Smooth releases
may come out up to {smooth:g} times their worst shape, and up to {shock:g} times it behind a shock without loss, where
single bonds are compressed for a few steps at a time. The planned limit, of which a plan takes a share, is that of a
uniform strand at a compression expected before the run.
"""


def by_regime(limits: Sequence[Limit]) -> dict[str, dict[str, Any]]:
    """Points, least and greatest ratio of measured to predicted for each regime."""
    table = {}
    for regime in REGIMES:
        ratios = [limit.ratio for limit in limits if limit.regime == regime]
        if not ratios:
            continue
        finite = [ratio for ratio in ratios if math.isfinite(ratio)]
        table[regime] = {
            "points": len(ratios),
            "not_measured": len(ratios) - len(finite),
            "least_ratio": min(finite, default=None),
            "greatest_ratio": max(finite, default=None),
        }
    return table


def text(found: Found) -> str:
    """The page in Markdown; pictures stand beside it."""
    parts = [_HEAD.format(quick=" --quick" if found.quick else "")]
    if found.limits:
        parts += ["## The step limit of specimens\n", _THEORY, _limits(found.limits)]
    if found.releases:
        parts += [
            "## The step limit of releases\n",
            _RELEASES.format(smooth=MOST_SMOOTH, shock=MOST_AT_SHOCK),
            _released(found.releases),
        ]
    if found.entries:
        parts.append("## The catalogue\n")
    for entry in found.entries:
        verdict = "" if entry.reproduced else "\n**Not every finding is the expected one.**\n"
        parts.append(
            f"### {entry.title}\n\n{text_of(entry.failure)}\n\n**What beadband does.** "
            f"{text_of(entry.answer)}\n{verdict}\n![{entry.title}](stability-{entry.name}.png)\n\n"
            f"`beadband stability --only {entry.name}`\n"
        )
    for name, failed in found.broken:
        parts.append(f"### {name}\n\n**Could not be finished** ({failed.code}): {failed.reason}\n")
    return "\n".join(parts)


def _limits(limits: Sequence[Limit]) -> str:
    rows = ["| regime | points | measured / predicted |", "|---|---|---|"]
    for regime, row in by_regime(limits).items():
        span = (
            f"{row['least_ratio']:.4f} – {row['greatest_ratio']:.4f}"
            if row["least_ratio"] is not None
            else "not measured"
        )
        rows.append(f"| {regime} | {row['points']} | {span} |")
    worst = max(limits, key=lambda limit: abs(limit.ratio - 1.0) if math.isfinite(limit.ratio) else math.inf)
    agree = sum(limit.agrees for limit in limits)
    rows.append(
        f"\n{agree} of {len(limits)} points within {BOUND:.0%}; the worst is {worst.ratio:.4f} "
        f"({worst.point.name}).\n\n![measured over predicted](stability-map.png)\n"
    )
    return "\n".join(rows)


def _released(releases: Sequence[ReleaseLimit]) -> str:
    rows = [
        "| release | least stretch | measured / uniform bound | measured / worst shape | measured / planned |",
        "|---|---|---|---|---|",
        *(
            f"| {one.name} | {one.least_stretch:.3f} | {one.measured_s / one.uniform_s:.3f} | "
            f"{one.measured_s / one.frozen_s:.3f} | {one.measured_s / one.planned_s:.3f} |"
            for one in releases
        ),
        f"\n{sum(one.agrees for one in releases)} of {len(releases)} releases are within these bounds.",
    ]
    return "\n".join(rows) + "\n"


def summary(found: Found) -> str:
    """What a person reads on the terminal."""
    lines = []
    for regime, row in by_regime(found.limits).items():
        if row["least_ratio"] is None:
            lines.append(f"map, {regime}: {row['points']} points, not measured")
            continue
        lines.append(
            f"map, {regime}: {row['points']} points, measured/predicted {row['least_ratio']:.4f} to "
            f"{row['greatest_ratio']:.4f}"
        )
    for one in found.releases:
        lines.append(
            f"release, {one.name}: measured {one.measured_s / one.frozen_s:.3f} of its worst shape's limit, "
            f"{one.measured_s / one.planned_s:.3f} of the planned" + ("" if one.agrees else "  FAIL")
        )
    for entry in found.entries:
        lines.append(f"{entry.name}: {'held' if entry.reproduced else 'FAIL'}")
        if len(found.entries) == 1:
            lines += [f"  {text_of(entry.failure)}", f"  {text_of(entry.answer)}"]
            lines += [
                f"  {key} = {value if isinstance(value, str) else format(value, '.6g')}"
                for key, value in entry.numbers.items()
            ]
    lines += [f"{name}: FAIL ({failed.code}): {failed.reason}" for name, failed in found.broken]
    return "\n".join(lines)


def draw(found: Found, folder: Path) -> None:
    """Write stability-NAME.png for every entry, and the map's."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    style: dict[Any, Any] = {"font.size": 8, "axes.titlesize": 8}
    with matplotlib.rc_context(style):
        for entry in found.entries:
            figure, axes = pyplot.subplots(figsize=(4.6, 2.9), layout="constrained")
            entry.picture.draw(axes)
            figure.savefig(folder / f"stability-{entry.name}.png", dpi=72)
            pyplot.close(figure)
        if found.limits:
            figure, axes = pyplot.subplots(figsize=(7.0, 3.4), layout="constrained")
            _map(axes, found.limits)
            figure.savefig(folder / "stability-map.png", dpi=80)
            pyplot.close(figure)


def _map(axes: Any, limits: Sequence[Limit]) -> None:
    colours = ("#1f5fa8", "#c8601a", "#2c7d4f", "#b8322a", "#8a3d8f", "#6b6b6b")
    for regime, colour in zip(REGIMES, colours, strict=True):
        chosen = [limit for limit in limits if limit.regime == regime]
        if chosen:
            axes.semilogx(
                [limit.predicted_s for limit in chosen],
                [limit.ratio for limit in chosen],
                "o",
                color=colour,
                markersize=3.5,
                alpha=0.7,
                label=f"{regime} ({len(chosen)})",
            )
    for level in (1.0 - BOUND, 1.0 + BOUND):
        axes.axhline(level, color="#999999", linestyle="--", linewidth=0.8)
    axes.set(xlabel="predicted largest step (s)", ylabel="measured / predicted", ylim=(0.96, 1.04))
    axes.grid(alpha=0.25)
    axes.legend(fontsize=7, ncols=3, frameon=False)
