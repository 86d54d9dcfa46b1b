"""The files of a run as arrays: frames of beads, energies, the path of a leg's rear, the finger of a launch.

Two readers give the same :class:`Trajectory` in double precision: beadband's own, which is faster, and MDAnalysis.
MDAnalysis keeps positions in single precision; their rounding (up to 1e-8 m in a band of 0.2 m) would enter the
curvature divided by the square of the bead distance, so the columns are read as additional data instead.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.analysis.fits import Array

COLUMNS = ("id", "type", "xu", "yu", "zu")
"""First columns of every dump."""


class ReadError(ValueError):
    """A file is missing, cut short or not what it should be: ``wrong``, ``given`` and ``expected`` say how."""

    def __init__(self, wrong: str, given: str, expected: str) -> None:
        super().__init__(f"{wrong}: given {given}; expected {expected}")
        self.wrong, self.given, self.expected = wrong, given, expected

    @classmethod
    def of(cls, path: str | os.PathLike[str], reason: object, expected: str) -> ReadError:
        """Why a file can't be read."""
        text = getattr(reason, "strerror", None) or reason
        return cls(f"{Path(path).name} can't be read", f"{str(path)!r} ({text})", expected)

    def __reduce__(self) -> tuple[type[ReadError], tuple[str, str, str]]:
        return ReadError, (self.wrong, self.given, self.expected)


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

    def bead(self, number: int) -> Array:
        """Positions of the bead with this id, shape (frames, 2); ReadError when there is none."""
        place = np.flatnonzero(self.ids == number)
        if len(place) == 0:
            raise ReadError("the trajectory lacks a bead", f"no bead {number}", "all beads of the run")
        return self.positions_m[:, place[0]]

    def require_steps(self, last: int) -> None:
        """ReadError unless the frames go from step 0 to ``last``."""
        _require_steps("trajectory", self.steps, last)


def _require_steps(what: str, steps: NDArray[np.int64], last: int) -> None:
    if steps[0] != 0 or steps[-1] != last:
        raise ReadError(f"the {what} does not cover the run", f"steps {steps[0]} to {steps[-1]}", f"0 to {last}")


def read(path: str | os.PathLike[str]) -> Trajectory:
    """Read a text dump of beadband; ReadError when it is not one, or is cut short."""
    steps: list[int] = []
    frames: list[Array] = []
    start = 0
    try:
        raw = Path(path).read_bytes()
        while start < len(raw):
            head_end, lines = start, []
            for _ in range(9):
                next_end = raw.find(b"\n", head_end)
                if next_end < 0:
                    raise ValueError(f"cut short in the head of frame {len(frames)}")
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
            beads = int(lines[3])
            if len(block) != beads * len(names) or raw[end - 1 : end] != b"\n":
                raise ValueError(f"cut short in frame {len(frames)}, step {int(lines[1])}")
            frames.append(block.reshape(beads, len(names)))
            steps.append(int(lines[1]))
            start = end
        if not frames:
            raise ValueError("no frame")
        table = np.stack([frame[:, :5] for frame in frames])
    except (OSError, ValueError, IndexError) as error:
        raise ReadError.of(path, error, "a whole dump of beadband's") from error
    return Trajectory(np.array(steps), table[0, :, 0].astype(np.int64), np.ascontiguousarray(table[:, :, 2:4]))


def read_path(path: str | os.PathLike[str], held_m: Array, beads: int) -> Trajectory:
    """Read rear.dat of a leg, the tip and the bead next to it, as a trajectory of the tip and both neighbours.

    ``held_m`` (at least 2, 2) are the held positions, the frame at step 0; the other neighbour, bead ``beads``, is the
    mirror image. ReadError when the file is missing or cut short.
    """
    try:
        text = Path(path).read_text(encoding="ascii").split("\n", 2)[2]
        table = np.fromstring(text, sep=" ").reshape(-1, 4)
    except (OSError, ValueError, IndexError) as error:
        raise ReadError.of(path, error, "a whole rear.dat") from error
    table = np.concatenate([[[0.0, held_m[0, 0], *held_m[1]]], table[table[:, 0] > 0.0]])
    return _mirrored(table[:, 0].astype(np.int64), table[:, 1], table[:, 2:], beads)


def _mirrored(steps: NDArray[np.int64], tip_x: Array, upper: Array, beads: int) -> Trajectory:
    """The tip on the axis and both neighbours, of which bead ``beads`` is the mirror image of bead 2."""
    positions = np.zeros((len(steps), 3, 2))
    positions[:, 0, 0] = tip_x
    positions[:, 1] = positions[:, 2] = upper
    np.negative(upper[:, 1], out=positions[:, 2, 1])
    return Trajectory(steps, np.array([1, 2, beads]), positions)


def averaged_rear(positions_m: Array, rear_steps: int, beads: int) -> Trajectory:
    """The rear of a leg as a trajectory of means over ``rear_steps``.

    ``positions_m``, shape (steps + 1, 2, 2), are its tip and the bead next to it at every step. The first frame is
    that at step 0; the other neighbour, bead ``beads``, is the mirror image.
    """
    frames = (len(positions_m) - 1) // rear_steps
    means = positions_m[1:] if rear_steps == 1 else positions_m[1:].reshape(frames, rear_steps, 2, 2).mean(axis=1)
    table = np.concatenate([positions_m[:1], means])
    return _mirrored(rear_steps * np.arange(frames + 1), table[:, 0, 0], table[:, 1], beads)


_MAGIC = b"DUMPCUSTOM"
_STEP_AT = 8 + len(_MAGIC) + 8
"""Place of the step in a binary frame: behind the magic word with its length, the byte order and the revision."""


def read_rears(path: str | os.PathLike[str], frames: int, legs: int) -> Array:
    """Read legs.bin, a binary dump of x and y of two beads of each leg: (frames, legs, 2, 2), without a unit.

    ReadError unless it holds the frames of the steps from 0 to ``frames`` - 1.
    """
    try:
        raw = np.fromfile(path, dtype=np.uint8)
        size, numbers = len(raw) // frames, 4 * legs
        head = size - 8 * numbers
        if len(raw) != size * frames or head < _STEP_AT + 8 or _MAGIC not in raw[:_STEP_AT].tobytes():
            raise ValueError("cut short, or no binary dump")
        table = raw.reshape(frames, size)
        steps = np.ascontiguousarray(table[:, _STEP_AT : _STEP_AT + 8]).view(np.int64)[:, 0]
        if steps[0] != 0 or steps[-1] != frames - 1:
            raise ValueError(f"steps {steps[0]} to {steps[-1]}")
    except (OSError, ValueError) as error:
        raise ReadError.of(path, error, "a whole dump of legs") from error
    return np.ascontiguousarray(table[:, head:]).view(np.float64).reshape(frames, legs, 2, 2)


def read_mdanalysis(path: str | os.PathLike[str]) -> Trajectory:
    """Read the same dump through MDAnalysis, in double precision; ReadError when it can't."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about guessed elements and masses, which are not used here
        import MDAnalysis

        try:
            form: dict[str, Any] = {"format": "LAMMPSDUMP", "topology_format": "LAMMPSDUMP", "dt": 1.0}
            universe = MDAnalysis.Universe(str(path), additional_columns=["id", "xu", "yu"], **form)
            steps, positions = [], []
            for frame in universe.trajectory:
                steps.append(int(frame.data["step"]))
                positions.append(np.stack([frame.data["xu"], frame.data["yu"]], axis=1))
            ids = np.asarray(universe.trajectory[0].data["id"]).astype(np.int64)
        except (OSError, ValueError, KeyError, IndexError, EOFError) as error:
            raise ReadError.of(path, error, "a whole dump of beadband's") from error
    return Trajectory(np.array(steps), ids, np.array(positions))


@dataclass(frozen=True)
class Energies:
    """Energies of the ring at the frames, J; arrays of shape (frames,), the first at the release."""

    steps: NDArray[np.int64]
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    loss_w: Array
    """Mean power of the dashpots over the interval before each frame."""

    def require_steps(self, last: int) -> None:
        """ReadError unless the lines go from step 0 to ``last``."""
        _require_steps("file of energies", self.steps, last)


def read_energies(path: str | os.PathLike[str]) -> Energies:
    """Read energy.dat; ReadError when it is missing or cut short."""
    steps, *columns = _columns(path, len(fields(Energies)), 1)
    return Energies(steps.astype(np.int64), *columns)


@dataclass(frozen=True)
class Watch:
    """Lines of finger.dat, arrays of shape (lines,), the first at the release; SI units."""

    steps: NDArray[np.int64]
    mean_force_n: Array
    """Force of the finger on the band along its flight, mean over the steps since the line before."""
    force_n: Array
    """The same at this step."""
    momentum_n_s: Array
    centre_x_m: Array
    gap_m: Array
    """Distance from the finger's surface to the nearest bead of the rear."""
    depth_m: Array
    """Depth of the deepest bead in the finger, negative where none touches."""
    contact_j: Array
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    loss_w: Array
    """Mean power of the dashpots since the line before."""
    shortest_bond_m: Array

    def times_s(self, timestep_s: float) -> Array:
        """Time of each line."""
        return np.asarray(self.steps * timestep_s, dtype=np.float64)


def read_watch(path: str | os.PathLike[str]) -> Watch:
    """Read finger.dat; ReadError when it is missing or cut short."""
    steps, *columns = _columns(path, len(fields(Watch)), 3)
    return Watch(steps.astype(np.int64), *(np.ascontiguousarray(column) for column in columns))


@dataclass(frozen=True)
class Overlaps:
    """Lines of touch.dat, arrays of shape (lines,), none where the run ended before: the band's contact with itself."""

    steps: NDArray[np.int64]
    energy_j: Array
    overlap_m: Array
    """What the deepest overlap of two parts of the band is at most."""

    @property
    def first_step(self) -> int | None:
        """Step at which the first touch is seen; None without one."""
        touched = self.steps[self.overlap_m > 0.0]
        return int(touched[0]) if len(touched) else None

    def at(self, steps: NDArray[np.int64]) -> tuple[Array, Array]:
        """Energies at steps that have lines, and the largest overlap since the step before each; 0 before all lines."""
        energy, overlap = np.zeros(len(steps)), np.zeros(len(steps))
        place = np.minimum(np.searchsorted(steps, self.steps), len(steps) - 1)
        np.maximum.at(overlap, place, self.overlap_m)
        energy[place] = self.energy_j
        return energy, overlap


def read_overlaps(path: str | os.PathLike[str]) -> Overlaps:
    """Read touch.dat; ReadError when it is missing or damaged."""
    steps, energy, overlap = _columns(path, len(fields(Overlaps)), 0)
    return Overlaps(steps.astype(np.int64), np.ascontiguousarray(energy), np.ascontiguousarray(overlap))


@dataclass(frozen=True)
class HandPath:
    """Lines of hand.dat at the steps of finger.dat, arrays of shape (lines,); SI units, X along the throw."""

    steps: NDArray[np.int64]
    x_m: Array
    velocity_m_s: Array
    mean_x_m: Array
    """Mean over the steps since the line before; so are the next two."""
    mean_velocity_m_s: Array
    mean_square_m2_s2: Array


def read_hand(path: str | os.PathLike[str]) -> HandPath:
    """Read hand.dat; ReadError when it is missing or cut short."""
    steps, *columns = _columns(path, len(fields(HandPath)), 3)
    return HandPath(steps.astype(np.int64), *(np.ascontiguousarray(column) for column in columns))


@dataclass(frozen=True)
class Pull:
    """Lines of held.dat, arrays of shape (lines,), the first at the release; SI units."""

    steps: NDArray[np.int64]
    mean_force_n: Array
    """Force of the strip on its held end along x, mean over the steps since the line before."""
    force_n: Array
    """The same at this step."""
    momentum_n_s: Array

    def times_s(self, timestep_s: float) -> Array:
        """Time of each line."""
        return np.asarray(self.steps * timestep_s, dtype=np.float64)

    def require_steps(self, last: int) -> None:
        """ReadError unless the lines go from step 0 to ``last``."""
        _require_steps("file of the held end", self.steps, last)


def read_pull(path: str | os.PathLike[str]) -> Pull:
    """Read held.dat; ReadError when it is missing or cut short."""
    steps, *columns = _columns(path, len(fields(Pull)), 2)
    return Pull(steps.astype(np.int64), *(np.ascontiguousarray(column) for column in columns))


def _columns(path: str | os.PathLike[str], width: int, fewest: int) -> Array:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of a file without lines
            table = np.loadtxt(path, ndmin=2)
        if table.size == 0:
            table = table.reshape(0, width)
        if table.shape[1] != width or len(table) < fewest:
            raise ValueError(f"{table.shape[0]} lines of {table.shape[1]} columns")
    except (OSError, ValueError) as error:
        raise ReadError.of(path, error, f"{fewest} lines or more of {width} columns") from error
    return np.asarray(table.T, dtype=np.float64)
