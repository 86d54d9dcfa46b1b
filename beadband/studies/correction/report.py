"""The record of a map as tables for people: docs/correction.md has them as they are printed here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_COLUMNS = (
    ("inside", "inside", 1),
    ("median", "50 %", 3),
    ("p90", "90 %", 3),
    ("p99", "99 %", 3),
    ("worst", "worst", 3),
    ("bar_median", "bar 50 %", 3),
    ("bar_p95", "bar 95 %", 3),
    ("within_bar", "within", 1),
    ("bar_below_0.1_percent", "≤ 0.1", 1),
    ("bar_below_0.5_percent", "≤ 0.5", 1),
)
"""Keys of a row, their headings, and decimals of the per cent."""


def tables(record: Mapping[str, Any]) -> str:
    """Held-out errors and bars of each map, by group, in per cent."""
    parts = []
    for kind, rows in record["held_out"].items():
        head = ["scenes", "n", *(heading for _, heading, _ in _COLUMNS)]
        lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
        for name, row in rows.items():
            cells = [name, str(row["scenes"]), *(f"{100.0 * row[key]:.{digits}f}" for key, _, digits in _COLUMNS)]
            lines.append("| " + " | ".join(cells) + " |")
        parts.append(f"{_TITLES[kind]}\n\n" + "\n".join(lines))
    return "\n\n".join(parts)


_TITLES = {
    "speed": "Rebound speed, errors and bars in % of V:",
    "curvature": "Mean curvature in its window, in % of it:",
    "left_out": "Rebound speed of a family of laws that the map was not shown, in % of V:",
}
