"""LAMMPS' own error messages, turned into the errors of this package: the one place that reads their words."""

from __future__ import annotations

import re
from typing import Any

from beadband.errors import Complaint, RunError, explain
from beadband.lammps.divergence import CODES, DIVERGED, ENERGY_ROSE, LOST, DivergenceError, examine
from beadband.lammps.scripts import MOST_ENERGY

BROKE_THROUGH, DISK, REFUSED = "broke-through-finger", "disk", "refused-script"

_WORDS = (
    (BROKE_THROUGH, r"outside surface of region"),
    (ENERGY_ROSE, r"fix-id guard"),
    (LOST, r"lost atoms|atoms? .*missing"),
    (DIVERGED, r"bond length|illegal bond|table (inner|outer) cutoff|non-numeric|not finite"),
    (DISK, r"no space left|writing|cannot open|permission"),
)
"""What happened, by what LAMMPS says of it; the first that fits."""

_TABLE = "bonds within the table of the law"
_DIVERGED = {
    DIVERGED: ("the run diverged", "LAMMPS: {}", _TABLE),
    LOST: ("the run lost beads", "LAMMPS: {}", _TABLE),
    ENERGY_ROSE: (
        "the energy rose above that of the held band",
        f"more than {MOST_ENERGY} of it",
        "an energy that the dashpots lower",
    ),
}
"""What was wrong, what was given and what is allowed."""


def failure(text: str, instance: Any = None) -> RunError:
    """The error of a LAMMPS run, from its message and from what is left in the instance.

    The code says what happened: ``diverged``, ``energy-rose`` or ``lost`` (all :class:`DivergenceError`),
    ``broke-through-finger``, ``disk``, or ``refused-script`` for everything else.
    """
    first = text.strip().splitlines()[0]
    # As one line, without the place in LAMMPS' source.
    message = re.sub(r"\s*\(\S+:\d+\)$", "", re.sub(r"^ERROR( on proc \d+)?:\s*", "", first))
    code = next((code for code, words in _WORDS if re.search(words, message, re.IGNORECASE)), REFUSED)
    if code in CODES:
        found = examine(instance) if instance is not None else None
        wrong, given, allowed = _DIVERGED[code]
        wrong = wrong if found is None else f"{wrong}: {found}"
        advice = "lower --timestep, or give the shock a loss with --loss-time"
        return DivergenceError(explain(wrong, given.format(message), allowed, advice), code, found)
    return RunError(_complaint(code, message), code)


def _complaint(code: str, message: str) -> Complaint:
    if code == BROKE_THROUGH:
        return explain(
            "a bead broke through the finger",
            f"LAMMPS: {message}",
            "beads that stay outside its core",
            "raise --beads or lower --timestep",
        )
    if code == DISK:
        return explain("LAMMPS could not use a file", message, "a folder with room that can be written", "free some")
    return explain("LAMMPS refused the script", message, "a script it can run", "see log.lammps in the run's folder")
