"""Reading what a run wrote: frames of beads, and energies.

Two readers give the same :class:`Trajectory`, both in double precision: one of beadband's own, quick, and one through
MDAnalysis. MDAnalysis keeps positions in single precision; their rounding (up to 1e-8 m in a band of 0.2 m) would
enter the curvature divided by the square of the bead distance, so the columns are taken as additional data instead.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain

Array = NDArray[np.float64]

COLUMNS = ("id", "type", "xu", "yu", "zu")


@dataclass(frozen=True)
class Trajectory:
    """Frames of beads, ordered by id."""

    steps: NDArray[np.int64]
    """Shape (frames,)."""
    ids: NDArray[np.int64]
    """Shape (beads,)."""
    positions_m: Array
    """Shape (frames, beads, 2). All frames but the first are averages over the interval before them."""

    def times_s(self, timestep_s: float) -> Array:
        """Time of each frame: for averaged ones the middle of the steps that they average.

        The steps s-m+1 ... s of an interval of m steps have their mean at s - (m-1)/2.
        """
        intervals = np.diff(self.steps, prepend=self.steps[:1])
        middles: Array = self.steps - 0.5 * np.maximum(intervals - 1, 0)
        return timestep_s * middles


def read(path: str | os.PathLike[str]) -> Trajectory:
    """Read a text dump of beadband's; UsageError when it is not one, or is cut short."""
    try:
        raw = Path(path).read_bytes()
    except OSError as error:
        raise UsageError(
            explain("a trajectory can't be read", f"{str(path)!r} ({error.strerror})", "a dump", "check the path")
        ) from error
    steps: list[int] = []
    frames: list[Array] = []
    start = 0
    try:
        while start < len(raw):
            head_end = start
            lines: list[bytes] = []
            for _ in range(9):
                next_end = raw.index(b"\n", head_end)
                lines.append(raw[head_end:next_end])
                head_end = next_end + 1
            if lines[0] != b"ITEM: TIMESTEP" or not lines[8].startswith(b"ITEM: ATOMS "):
                raise ValueError("unexpected header")
            names = lines[8].decode().split()[2:]
            if tuple(names[: len(COLUMNS)]) != COLUMNS:
                raise ValueError(f"columns {names}")
            end = raw.find(b"ITEM: TIMESTEP", head_end)
            end = len(raw) if end < 0 else end
            block = np.fromstring(raw[head_end:end].decode(), sep=" ")
            frames.append(block.reshape(int(lines[3]), len(names)))
            steps.append(int(lines[1]))
            start = end
        if not frames:
            raise ValueError("no frame")
        table = np.stack([frame[:, :5] for frame in frames])
    except (ValueError, IndexError) as error:
        raise UsageError(
            explain("a trajectory can't be understood", f"{str(path)!r} ({error})", "a whole dump", "run it again")
        ) from error
    return Trajectory(np.array(steps), table[0, :, 0].astype(np.int64), np.ascontiguousarray(table[:, :, 2:4]))


def read_path(path: str | os.PathLike[str], held_m: Array, beads: int) -> Trajectory:
    """Read what leg.in wrote of the tip and the bead next to it, as a trajectory of the tip and both neighbours.

    ``held_m`` (at least 2, 2) are the held positions, the frame at step 0; the other neighbour, bead ``beads``, is the
    mirror image. UsageError when the file is missing or cut short.
    """
    try:
        text = Path(path).read_text(encoding="ascii").split("\n", 2)[2]
        table = np.fromstring(text, sep=" ").reshape(-1, 4)
    except (OSError, ValueError, IndexError) as error:
        raise UsageError(
            explain(
                "the path of the rear can't be read", f"{str(path)!r} ({error})", "a whole rear.dat", "run it again"
            )
        ) from error
    table = np.concatenate([[[0.0, held_m[0, 0], *held_m[1]]], table[table[:, 0] > 0.0]])
    steps, tip_x, next_x, next_y = table.T
    tip = np.stack([tip_x, np.zeros_like(tip_x)], axis=1)
    upper = np.stack([next_x, next_y], axis=1)
    positions = np.stack([tip, upper, upper * np.array([1.0, -1.0])], axis=1)
    return Trajectory(steps.astype(np.int64), np.array([1, 2, beads]), positions)


def read_mdanalysis(path: str | os.PathLike[str]) -> Trajectory:
    """Read the same dump through MDAnalysis, in double precision; UsageError when it can't."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it guesses elements and masses, which nothing here uses
        import MDAnalysis

        try:
            universe = MDAnalysis.Universe(
                str(path),
                topology_format="LAMMPSDUMP",
                format="LAMMPSDUMP",
                additional_columns=["id", "xu", "yu"],
                dt=1.0,
            )
            steps, positions = [], []
            for frame in universe.trajectory:
                steps.append(int(frame.data["step"]))
                positions.append(np.stack([frame.data["xu"], frame.data["yu"]], axis=1))
            ids = np.asarray(universe.trajectory[0].data["id"]).astype(np.int64)
        except (OSError, ValueError, KeyError, IndexError, EOFError) as error:
            raise UsageError(
                explain("a trajectory can't be read", f"{str(path)!r} ({error})", "a whole dump", "run it again")
            ) from error
    return Trajectory(np.array(steps), ids, np.array(positions))


@dataclass(frozen=True)
class Energies:
    """Energies of the ring at the frames, J; the frame at step 0 is left to the data file."""

    steps: NDArray[np.int64]
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    loss_w: Array
    """Mean power of the dashpots over the interval before each frame."""


def read_energies(path: str | os.PathLike[str]) -> Energies:
    """Read energy.dat; UsageError when it is missing or cut short."""
    try:
        table = np.loadtxt(path, ndmin=2)
        steps, stretching, bending, kinetic, loss = table.T
    except (OSError, ValueError) as error:
        raise UsageError(
            explain("the energies can't be read", f"{str(path)!r} ({error})", "a whole energy.dat", "run it again")
        ) from error
    return Energies(steps.astype(np.int64), stretching, bending, kinetic, loss)
