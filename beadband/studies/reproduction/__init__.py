"""The paper reproduced, figure by figure, with a scorecard of what holds."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beadband.errors import UsageError, explain
from beadband.studies.reproduction import alpha, angle, bending, curving, materials, releases, scaling, speeds
from beadband.studies.reproduction.drawing import Sheet
from beadband.studies.reproduction.runs import Runs, Values
from beadband.studies.reproduction.scorecard import Entry, as_dict, as_markdown


def _none(quick: bool) -> list[Values]:
    return []


@dataclass(frozen=True)
class Item:
    """A figure or table: how it is drawn, and the releases that it needs."""

    draw: Callable[[Sheet, Runs, bool], list[Entry]]
    scenes: Callable[[bool], list[Values]] = _none


ITEMS: dict[str, Item] = {
    "table1": Item(materials.table1),
    "fig4": Item(angle.fig4),
    "fig5": Item(angle.fig5),
    "fig6": Item(angle.fig6),
    "fig7": Item(angle.fig7),
    "fig8": Item(angle.fig8),
    "fig9": Item(bending.fig9),
    "fig10": Item(bending.fig10),
    "fig11": Item(bending.fig11),
    "fig12": Item(bending.fig12),
    "fig13": Item(bending.fig13),
    "fig14": Item(bending.fig14),
    "fig15": Item(materials.fig15),
    "fig16": Item(releases.fig16),
    "fig17": Item(releases.fig17, lambda quick: [releases.PAPER]),
    "fig18": Item(speeds.fig18, speeds.scenes18),
    "fig19": Item(curving.fig19, curving.scenes),
    "fig20": Item(releases.fig20),
    "fig21": Item(speeds.fig21, speeds.scenes21),
    "fig22": Item(alpha.fig22, alpha.scenes22),
    "fig23": Item(speeds.fig23, speeds.scenes23),
    "appendix": Item(scaling.appendix, scaling.scenes),
}
"""Everything that can be reproduced, in the paper's order."""


def check_item(only: str | None) -> None:
    """UsageError for an item that there is not."""
    if only is not None and only not in ITEMS:
        raise UsageError(explain("unknown item to reproduce", repr(only), ", ".join(ITEMS), "change --only"))


def reproduce(
    folder: Path, only: str | None = None, quick: bool = False, progress: Callable[[int, int], None] | None = None
) -> dict[str, Any]:
    """Draw every item (or one) into the folder and write scorecard.json and scorecard.md, last; return the former.

    UsageError for an item that there is not.
    """
    check_item(only)
    from beadband.runs.folder import write_text
    from beadband.runs.results import versions

    start = time.perf_counter()
    chosen = ITEMS if only is None else {only: ITEMS[only]}
    runs, sheet = Runs(), Sheet(folder)
    runs.prepare([values for item in chosen.values() for values in item.scenes(quick)], progress)
    entries: list[Entry] = []
    for item in chosen.values():
        found = item.draw(sheet, runs, quick)
        sheet.publish(found)
        entries += found
    card = as_dict(
        entries,
        {
            "quick": quick,
            "scenes": len(runs),
            "scenes_without_answer": runs.refused(),
            "tables": sheet.tables,
            "wall_s": time.perf_counter() - start,
            "processors": os.cpu_count(),
            "versions": versions("see lammps_package"),
        },
    )
    note = f"From the {'quick ' if quick else ''}grids ({len(runs)} scenes)." if len(runs) else ""
    write_text(folder / "scorecard.md", as_markdown(entries, note), durable=True)
    write_text(
        folder / "scorecard.json", json.dumps(card, indent=1, allow_nan=False, ensure_ascii=False) + "\n", durable=True
    )
    return card
