"""A run's folder: which files stand in it, and how those that LAMMPS reads are written."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path

import numpy as np

from beadband.errors import RunError, UsageError, explain
from beadband.plan import Plan
from beadband.ring import Ring
from beadband.strand import Strand

SCENE = "scene.toml"
DATA = "band.data"
TABLE = "bond.table"
SCRIPT = "release.in"
TRAJECTORY = "trajectory.lammpstrj"
REAR = "rear.lammpstrj"
ENERGY = "energy.dat"
RESULTS = "results.json"
LOG = "log.lammps"

TABLE_POINTS = 2001
DEEPEST_STRETCH = 0.3
"""Where the bond table begins."""
MOST_ENERGY = 1.05
"""Share of the held energy above which a run has blown up; sound ones stay within a per cent."""
GUARD_STEPS = 200
"""Steps between looks at the energy."""
WIDEST_STRAIN = 1.6
"""Where the bond table ends, over the held strain."""
_NEVER = 2_000_000_000
_LOSS_SAMPLES = 8
"""Times in a frame at which the power of the dashpots is taken."""


def create(out: str | os.PathLike[str]) -> Path:
    """Make the folder, or take an empty one; UsageError when something stands there or it can't be written."""
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = sorted(entry.name for entry in folder.iterdir())
        if not found:
            probe = folder / f".{SCENE}.tmp"
            probe.touch()
            probe.unlink()
    except OSError as error:
        raise UsageError(
            explain(
                "the output folder can't be used",
                f"{str(out)!r} ({error.strerror})",
                "a folder that can be made and written",
                "choose another with --out",
            )
        ) from error
    if not found:
        return folder
    if RESULTS in found:
        state = "a finished run"
    elif SCENE in found:
        state = "a run that did not finish"
    else:
        state = f"{len(found)} other file{'s' if len(found) > 1 else ''}"
    raise UsageError(
        explain(
            "the output folder is not empty",
            f"{str(out)!r} with {state}",
            "a new or empty folder",
            "choose another with --out, or remove it first",
        )
    )


def claim(folder: Path, text: str) -> None:
    """Put scene.toml into a folder that has none: of two runs that found it empty, one gets it.

    UsageError for the other, RunError when the disk refuses.
    """
    try:
        handle = os.open(folder / SCENE, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError as error:
        raise UsageError(
            explain(
                "another run has just taken the output folder",
                f"{str(folder)!r} with a {SCENE}",
                "a folder for each run",
                "choose another with --out",
            )
        ) from error
    except OSError as error:
        raise _refused(folder / SCENE, error) from error
    os.close(handle)
    write_text(folder / SCENE, text)


def _refused(path: Path, error: OSError) -> RunError:
    return RunError(
        explain("a file could not be written", f"{str(path)!r} ({error.strerror})", "a disk with room", "free some")
    )


def next_free(name: str) -> Path:
    """``name`` in the current folder, with -2, -3 ... behind it when something stands there already."""
    path, number = Path(name), 1
    while path.exists():
        number += 1
        path = Path(f"{name}-{number}")
    return path


def require(folder: str | os.PathLike[str], *names: str) -> Path:
    """The folder as a path; UsageError when it lacks one of the files."""
    path = Path(folder)
    missing = [name for name in names if not (path / name).is_file()]
    if missing:
        raise UsageError(
            explain(
                "not the folder of a run",
                f"{str(folder)!r} without {', '.join(missing)}",
                "a folder that 'beadband run' wrote",
                "check the path",
            )
        )
    return path


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for the time of a run."""
    with tempfile.TemporaryDirectory(prefix="beadband-") as place:
        yield Path(place)


def write_text(path: Path, text: str, durable: bool = False) -> None:
    """Write a file so that it is there whole or not at all; RunError when the disk refuses.

    ``durable`` waits for the disk: for what says that a run is finished, not for what a run can write again.
    """
    partial = path.with_name(f".{path.name}.tmp")
    try:
        with open(partial, "w", encoding="utf-8") as handle:
            handle.write(text)
            if durable:
                handle.flush()
                os.fsync(handle.fileno())
        os.replace(partial, path)
    except OSError as error:
        raise _refused(path, error) from error


def write_inputs(folder: Path, plan: Plan, ring: Ring, pictures: bool = True) -> None:
    """Write what LAMMPS needs: data file, bond table and script. Without ``pictures`` only the rear is followed."""
    strand = plan.scene.strand(plan.beads)
    write_text(folder / DATA, data_file(ring, strand))
    write_text(folder / TABLE, bond_table(strand, plan.scene.strain))
    write_text(folder / SCRIPT, script(plan, ring, pictures))


def data_file(ring: Ring, strand: Strand) -> str:
    """LAMMPS data file of the held ring: a box that the release can't leave, beads, bonds and angles."""
    x, y = ring.positions_m[:, 0], ring.positions_m[:, 1]
    count = ring.beads
    margin = 0.5 * (x.max() - x.min())
    index = np.arange(1, count + 1)
    after, before = np.roll(index, -1), np.roll(index, 1)
    head = f"""beadband: a held ring of {count} beads, units = si

{count} atoms
{count} bonds
{count} angles
4 atom types
1 bond types
1 angle types

{x.min() - margin:.17g} {x.max() + margin:.17g} xlo xhi
{y.min() - margin:.17g} {y.max() + margin:.17g} ylo yhi
{-0.5 * strand.spacing_m:.17g} {0.5 * strand.spacing_m:.17g} zlo zhi

Masses

"""
    masses = "".join(f"{kind} {strand.bead_mass_kg:.17g}\n" for kind in range(1, 5))
    atoms = "".join(
        f"{i} 1 {kind} {px:.17g} {py:.17g} 0\n"
        for i, kind, px, py in zip(index.tolist(), ring.types.tolist(), x.tolist(), y.tolist(), strict=True)
    )
    bonds = "".join(f"{i} 1 {i} {j}\n" for i, j in zip(index.tolist(), after.tolist(), strict=True))
    angles = "".join(
        f"{i} 1 {h} {i} {j}\n" for h, i, j in zip(before.tolist(), index.tolist(), after.tolist(), strict=True)
    )
    return f"{head}{masses}\nAtoms # angle\n\n{atoms}\nBonds\n\n{bonds}\nAngles\n\n{angles}"


def bond_table(strand: Strand, strain: float) -> str:
    """Energy and force of a bond from deep compression to well beyond the held strain.

    Ahead of a shock without loss bonds ring about the held stretch, and more where the finger throws them back.
    """
    law, a, area = strand.law, strand.spacing_m, strand.area_m2
    stretch = np.linspace(DEEPEST_STRETCH, 1.0 + WIDEST_STRAIN * strain, TABLE_POINTS)
    energy, force = a * area * law.energy(stretch), -area * law.stress(stretch)
    slopes = [-area * float(law.tangent(stretch[end])) / a for end in (0, -1)]
    rows = "".join(
        f"{i} {r:.17g} {e:.17g} {f:.17g}\n"
        for i, (r, e, f) in enumerate(zip((stretch * a).tolist(), energy.tolist(), force.tolist(), strict=True), 1)
    )
    return (
        f"# {law.name} bond: length m, energy J, force N\n\nBAND\n"
        f"N {TABLE_POINTS} FP {slopes[0]:.17g} {slopes[1]:.17g} EQ {a:.17g}\n\n{rows}"
    )


def with_variables(name: str, variables: Mapping[str, int | float | str]) -> str:
    """A script of :mod:`beadband.lmp_inputs` under the variables that it needs, numbers to the last digit.

    Texts are words of the scripts' own (a style, its coefficients), never a user's.
    """
    text = files("beadband.lmp_inputs").joinpath(name).read_text(encoding="utf-8")
    values = {
        key: f'"{value}"' if isinstance(value, str) else format(value, ".17g") for key, value in variables.items()
    }
    lines = (f"variable        {key} index {value}\n" for key, value in values.items())
    return "".join(lines) + "\n" + text


def script(plan: Plan, ring: Ring, pictures: bool) -> str:
    """The release script under the variables of this plan."""
    strand = plan.scene.strand(plan.beads)
    cutoff = dashpot_cutoff_m(ring)
    loss_every = max(1, plan.frame_steps // _LOSS_SAMPLES)
    while plan.frame_steps % loss_every:
        loss_every -= 1
    variables: dict[str, int | float] = {
        "beads": plan.beads,
        "table_points": TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        "bead_radius": 0.5 * plan.scene.band.thickness_m,
        "dashpot": strand.dashpot_n_s_m(plan.loss_time_s),
        "dashpot_cutoff": cutoff,
        "skin": 0.01 * cutoff,
        "timestep": plan.timestep_s,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
        "frame_steps": plan.frame_steps if pictures else _NEVER,
        "frame_average": plan.frame_steps if pictures else 1,
        "spacing": strand.spacing_m,
        "largest_timestep": plan.largest_timestep_s,
        "most_energy": MOST_ENERGY * (ring.stretching_j + ring.bending_j),
        "guard_steps": GUARD_STEPS,
        "loss_every": loss_every if pictures else 1,
        "loss_average": plan.frame_steps // loss_every if pictures else 1,
    }
    return with_variables(SCRIPT, variables)


def dashpot_cutoff_m(ring: Ring) -> float:
    """Cutoff of the dashpots: as wide as other beads allow, for their strength is 1 - (r/cutoff)^8.

    Bonded neighbours count; the second and third are left out by ``special_bonds``. The fourth along the strand and
    the beads across the finger are the closest others.
    """
    upper = ring.positions_m[: ring.beads // 2 + 1]
    apart = upper[4:] - upper[:-4]
    return 0.95 * min(float(np.hypot(apart[:, 0], apart[:, 1]).min()), ring.finger_radius_m)
