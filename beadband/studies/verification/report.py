"""Checks as a person reads them, and as a program does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from beadband.studies.verification.check import Check


def verdict(check: Check) -> str:
    """``pass``, ``FAIL`` or ``skipped``."""
    return "skipped" if check.skipped else "pass" if check.passed else "FAIL"


def totals(checks: Sequence[Check]) -> dict[str, int]:
    """How many checks passed, failed and were skipped."""
    return {
        "passed": sum(check.passed for check in checks),
        "failed": sum(check.failed for check in checks),
        "skipped": sum(check.skipped for check in checks),
    }


def table(checks: Sequence[Check]) -> str:
    """One line for each check under its rung, and the totals."""
    heads = ("", "measured", "exact", "error", "bound", "")
    rows: list[tuple[str, ...]] = []
    rung = ""
    for check in checks:
        if check.rung != rung:
            rung = check.rung
            rows.append((rung, "", "", "", "", ""))
        made = math.isfinite(check.measured)
        rows.append(
            (
                "  " + check.name,
                f"{check.measured:.6g}" if made else "-",
                f"{check.exact:.6g}" if made else "-",
                f"{check.error:.1e}" if made else "-",
                f"{check.bound:.2g}" if made else "-",
                verdict(check) + (f": {check.note}" if check.note else ""),
            )
        )
    widths = [max(len(row[i]) for row in [heads, *rows]) for i in range(len(heads))]
    lines = [
        "  ".join(
            cell.ljust(width) if i in (0, len(heads) - 1) else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in [heads, *rows]
    ]
    count = totals(checks)
    summary = f"{count['passed']} passed, {count['failed']} failed, {count['skipped']} skipped"
    return "\n".join([*lines, f"{summary}; errors are relative, and absolute where the exact value is 0"])


def as_dict(checks: Sequence[Check], wall_s: float | None = None) -> dict[str, Any]:
    """The checks for programs, with totals and the versions of what made them; numbers not finite are null."""
    from beadband.lammps.engine import load
    from beadband.runs.results import versions

    return {
        "checks": [
            {
                "rung": check.rung,
                "name": check.name,
                "measured": _number(check.measured),
                "exact": float(check.exact),
                "error": _number(check.error),
                "relative": check.relative,
                "bound": check.bound,
                "verdict": verdict(check).lower(),
                "note": check.note,
                "code": check.code,
            }
            for check in checks
        ],
        "totals": totals(checks),
        "wall_s": wall_s,
        "versions": versions(str(load().__version__)),
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
