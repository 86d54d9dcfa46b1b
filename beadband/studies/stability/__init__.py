"""Where methods fail: the step limit measured against its theory, and a catalogue of failures, each reproduced."""

from __future__ import annotations

import json
import os
import time
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beadband.errors import UsageError, explain
from beadband.studies.pool import Failed, Progress, run_all

if TYPE_CHECKING:
    from beadband.studies.stability.catalogue_entry import Entry
    from beadband.studies.stability.limits import Limit
    from beadband.studies.stability.ring_trials import ReleaseLimit

MAP, RELEASES = "map", "releases"
"""Names of the two parts that are not entries."""

ENTRIES: dict[str, tuple[str, str]] = {
    "no-loss": ("loss", "no_loss"),
    "much-loss": ("loss", "much_loss"),
    "sharp-corner": ("tip", "sharp_corner"),
    "tip-ringing": ("tip", "ringing"),
    "few-beads": ("tip", "few_beads"),
    "sharp-bend": ("tip", "sharp_bend"),
    "angles-straight": ("angles", "straight"),
    "angles-folded": ("angles", "folded"),
    "past-peak": ("material", "past_peak"),
    "beyond-table": ("material", "beyond_table"),
    "thick-band": ("material", "thick_band"),
    "rebound": ("loss", "rebound"),
    "finger-stiffness": ("contact", "stiffness"),
    "through-finger": ("contact", "through"),
    "step-limit": ("stepping", "step_limit"),
    "respa-resonance": ("stepping", "resonance"),
    "energy-drift": ("stepping", "drift"),
    "single-precision": ("stepping", "single_precision"),
}
"""The catalogue in the order of its page: module and function of each entry."""


@dataclass(frozen=True)
class Found:
    """What the command found; parts that were not asked for are empty."""

    limits: tuple[Limit, ...]
    releases: tuple[ReleaseLimit, ...]
    entries: tuple[Entry, ...]
    broken: tuple[tuple[str, Failed], ...]
    """Parts that could not be finished, and why."""
    quick: bool
    wall_s: float

    @property
    def failed(self) -> tuple[str, ...]:
        """Names of what did not come out as described."""
        return (
            *(f"{MAP}: {limit.point.name}" for limit in self.limits if not limit.agrees),
            *(f"{RELEASES}: {limit.name}" for limit in self.releases if not limit.agrees),
            *(entry.name for entry in self.entries if not entry.reproduced),
            *(name for name, _ in self.broken),
        )


def check_name(only: str | None) -> None:
    """UsageError for an unknown name."""
    names = (MAP, RELEASES, *ENTRIES)
    if only is not None and only not in names:
        raise UsageError(explain("unknown failure", repr(only), ", ".join(names), "change --only"))


def _work(quick: bool, piece: tuple[str, Any]) -> Any:
    """One piece of work, in a worker process."""
    part, what = piece
    if part == MAP:
        from beadband.studies.stability.limits import measure

        return [measure(point) for point in what]
    if part == RELEASES:
        from beadband.studies.stability.ring_trials import release_limit

        return release_limit(what)
    module, function = ENTRIES[part]
    return getattr(import_module(f"beadband.studies.stability.{module}"), function)(quick)


def find(only: str | None = None, quick: bool = False, progress: Progress | None = None) -> Found:
    """Measure the map, the releases and the catalogue, or one of them; UsageError for an unknown name."""
    check_name(only)
    from beadband.studies.stability import limits
    from beadband.studies.stability import ring_trials as rings

    start = time.perf_counter()
    work: list[tuple[str, Any]] = [(name, None) for name in ENTRIES if only in (None, name)]
    if only in (None, RELEASES):
        work += [(RELEASES, values) for values in rings.scenes(quick)]
    if only in (None, MAP):
        points = limits.points(quick)
        work += [(MAP, points[first : first + 12]) for first in range(0, len(points), 12)]
    results = run_all(partial(_work, quick), work, jobs=1 if len(work) == 1 else None, progress=progress)
    measured, released, entries, broken = [], [], [], []
    for (part, _), result in zip(work, results, strict=True):
        if isinstance(result, Failed):
            broken.append((part, result))
        elif part == MAP:
            measured += result
        elif part == RELEASES:
            released.append(result)
        else:
            entries.append(result)
    seconds = time.perf_counter() - start
    return Found(tuple(measured), tuple(released), tuple(entries), tuple(broken), quick, seconds)


def as_dict(found: Found) -> dict[str, Any]:
    """Everything for programs."""
    from beadband.runs.results import versions
    from beadband.studies.stability.page import by_regime

    return {
        "quick": found.quick,
        "map": {
            "points": len(found.limits),
            "regimes": by_regime(found.limits),
            "limits": [limit.as_dict() for limit in found.limits],
        },
        "releases": [limit.as_dict() for limit in found.releases],
        "catalogue": [entry.as_dict() for entry in found.entries],
        "broken": {name: failed.reason for name, failed in found.broken},
        "broken_codes": {name: failed.code for name, failed in found.broken},
        "failed": list(found.failed),
        "wall_s": found.wall_s,
        "processors": os.cpu_count(),
        "versions": versions("see lammps_package"),
    }


def write(found: Found, folder: Path) -> None:
    """Write the pictures, stability.md and, last, stability.json into a folder."""
    from beadband.lammps.files import write_text
    from beadband.studies.stability import page

    page.draw(found, folder)
    write_text(folder / "stability.md", page.text(found), durable=True)
    write_text(
        folder / "stability.json",
        json.dumps(as_dict(found), indent=1, allow_nan=False, ensure_ascii=False) + "\n",
        durable=True,
    )
