"""Where and why a run diverged: which bond, when, how far it was stretched, and what most likely caused it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import Complaint, RunError
from beadband.notices import Notice, notice

Array = NDArray[np.float64]

DIVERGED, ENERGY_ROSE, LOST = CODES = ("diverged", "energy-rose", "lost")
"""How LAMMPS finds that a run has diverged: bonds outside their table, too much energy, beads out of the box."""
_PAST = 1.0
"""Share of the predicted limit beyond which a step needs no other cause."""
_NEAR = 6
"""Bonds to each side of the worst one in which a pattern is looked for."""


@dataclass(frozen=True)
class Divergence:
    """Where and when a chain was found broken; ``str`` makes one clause for a message."""

    bead: int
    """Id of the first bead of the worst bond; the next one along the band is its other end."""
    other: int
    time_s: float
    step: int
    strain: float
    """Of that bond; not finite where its beads have no finite positions."""
    cause: Notice
    """The likely cause: ``step-beyond-limit``, ``step-at-limit``, ``bead-scale-ringing`` or ``overstretched``."""

    def __str__(self) -> str:
        strain = f"has the strain {self.strain:.3g}" if math.isfinite(self.strain) else "has no finite length"
        return (
            f"the bond of beads {self.bead} and {self.other} {strain} at {self.time_s:.4g} s (step {self.step}); "
            f"likely cause: {self.cause}"
        )


class DivergenceError(RunError):
    """A run that diverged; the code says how LAMMPS found it, ``found`` where and why, None if that can't be said."""

    def __init__(self, complaint: Complaint | str, code: str | None = None, found: Divergence | None = None) -> None:
        super().__init__(complaint, code or DIVERGED)
        self.found = found

    def __reduce__(self) -> Any:
        return type(self), (self.complaint or str(self), self.code, self.found)


def find(
    positions_m: Array,
    bonds: NDArray[np.int64],
    spacing_m: float,
    step: int,
    timestep_s: float,
    largest_step_s: float = math.inf,
) -> Divergence | None:
    """The worst bond of a chain; None where there is no bond.

    ``positions_m`` (beads, 2) by id, ``bonds`` (bonds, 2) ids from 1 in the order of the chain.
    """
    if not len(bonds):
        return None
    vectors = positions_m[bonds[:, 1] - 1] - positions_m[bonds[:, 0] - 1]
    with np.errstate(all="ignore"):
        stretches = np.hypot(vectors[:, 0], vectors[:, 1]) / spacing_m
        badness = np.abs(np.log(stretches))
    broken = ~np.isfinite(stretches)
    badness[broken] = np.inf
    # Where several are broken, the one in their midst was the first.
    worst_ones = np.flatnonzero(badness == badness.max())
    worst = int(worst_ones[len(worst_ones) // 2])
    return Divergence(
        bead=int(bonds[worst, 0]),
        other=int(bonds[worst, 1]),
        time_s=step * timestep_s,
        step=step,
        strain=float(stretches[worst]) - 1.0,
        cause=_cause(vectors, stretches, worst, timestep_s / largest_step_s),
    )


def _cause(vectors: Array, stretches: Array, worst: int, share: float) -> Notice:
    """Read the pattern around the worst bond: what grows beyond a step limit alternates from bead to bead.

    So does what a shock without loss leaves behind; ``share`` of the largest stable step tells the two apart.
    """
    near = slice(max(0, worst - _NEAR), worst + _NEAR + 1)
    lengths, local = stretches[near], vectors[near]
    if not np.isfinite(lengths).all() or share > _PAST:
        return notice("step-beyond-limit", value=share)
    changes = np.diff(lengths)
    turns = local[:-1, 0] * local[1:, 1] - local[:-1, 1] * local[1:, 0]
    along = float(np.mean(changes[1:] * changes[:-1] < 0.0)) if len(changes) > 2 else 0.0
    across = float(np.mean(turns[1:] * turns[:-1] < 0.0)) if len(turns) > 2 else 0.0
    if share > 0.9 and max(along, across) > 0.7:
        return notice("step-at-limit", value=share, way="length" if along >= across else "direction")
    if along > 0.5 or stretches[worst] < 1.0:
        return notice("bead-scale-ringing", along=along, strain=float(stretches[worst]) - 1.0)
    return notice("overstretched", strain=float(stretches[worst]) - 1.0)


def examine(instance: Any) -> Divergence | None:
    """The worst bond of a LAMMPS instance that stopped; None where it can't be found (lost beads, several ranks)."""
    try:
        spacing = float(instance.extract_variable("spacing"))
        count = int(instance.get_natoms())
        flat = np.array(instance.gather_atoms("x", 1, 3), dtype=np.float64)
        _, bonds = instance.gather_bonds()
        table = np.array(bonds, dtype=np.int64).reshape(-1, 3)[:, 1:]
        positions = flat.reshape(count, 3)[:, :2]
        # Every bond once, from the bead of the lower id to the next; the one that closes a ring comes last.
        table = np.sort(table, axis=1)
        closing = table[:, 1] - table[:, 0] > 1
        table = table[np.lexsort((table[:, 0], closing))]
        table[table[:, 1] - table[:, 0] > 1] = table[table[:, 1] - table[:, 0] > 1][:, ::-1]
        step = int(instance.extract_global("ntimestep"))
        largest = float(instance.extract_variable("largest_timestep"))
        return find(positions, table, spacing, step, float(instance.extract_global("dt")), largest)
    except Exception:  # noqa: BLE001  a broken instance must not hide what broke it
        return None
