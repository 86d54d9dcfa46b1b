"""The record of a map as tables for people: docs/correction.md has them as they are printed here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_HEAD = "| scenes | number | inside | median | 90 % | 99 % | worst | bar, median | bar, 95 % | within bar |"
_LINE = "|---|---|---|---|---|---|---|---|---|---|"
_QUANTILES = ("median", "p90", "p99", "worst", "bar_median", "bar_p95")


def tables(record: Mapping[str, Any]) -> str:
    """Held-out errors and bars of each map, by group, in per cent."""
    parts = []
    for kind, rows in record["held_out"].items():
        lines = [_HEAD, _LINE]
        for name, row in rows.items():
            shares = [f"{100.0 * row[key]:.3f}" for key in _QUANTILES]
            cells = [
                name,
                str(row["scenes"]),
                f"{100.0 * row['inside']:.1f}",
                *shares,
                f"{100.0 * row['within_bar']:.1f}",
            ]
            lines.append("| " + " | ".join(cells) + " |")
        parts.append(f"{_TITLES[kind]}\n\n" + "\n".join(lines))
    return "\n\n".join(parts)


_TITLES = {
    "speed": "Rebound speed, errors and bars in % of V:",
    "curvature": "Mean curvature in its window, in % of it:",
    "left_out": "Rebound speed of a family of laws that the map was not shown, in % of V:",
}
