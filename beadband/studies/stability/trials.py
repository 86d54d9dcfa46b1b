"""Trials: strands and rings run in LAMMPS with a form, an integrator and a finger of choice; growth or no growth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband.errors import RunError
from beadband.lammps.divergence import DivergenceError
from beadband.lammps.files import ANGLE_TABLE
from beadband.model.angle_forms import ANGLE_FORMS, QUARTIC, TABLE_POINTS, AngleForm
from beadband.studies.verification.specimen import FIXED, Specimen, run_files

Array = NDArray[np.float64]
SCRIPT = "trial.in"
FORMS = {name: ANGLE_FORMS[name] for name in ("quartic", "cosine", "harmonic", "rod_table")}
"""The angle forms under trial, beadband's own first."""
_SHARPEST_RAD = math.pi * (1.0 - 1.0 / (TABLE_POINTS - 1))
"""At a whole fold tan^2 has no value: tables end one point before it."""
NOISE = 1e-9
"""Amplitude of the noise that a trial starts with, over the spacing."""
_FEWEST_STEPS = 8
_GROWN = 1e4
"""Growth of the noise that tells an unstable step: stable ones, near the limit, stay far below it."""


@dataclass(frozen=True)
class Options:
    """What a trial adds to its specimen."""

    form: AngleForm = QUARTIC
    integrator: str = "verlet"
    loss_time_s: float = 0.0
    load_n: float = 0.0
    """Force on every free bead along y."""
    finger_stiffness_pa: float = 0.0
    """Force of the finger over the square of a bead's depth, N/m2."""
    finger_radius_m: float = 0.0
    """0 for a half-space."""
    finger_centre_m: tuple[float, float] = (0.0, 0.0)
    legs: tuple[int, int] = (1, 1)
    """Ids of the last bead of the upper leg and the first of the lower one, for a ring in a wedge."""


@dataclass(frozen=True)
class Course:
    """How a trial went; arrays over frames, the first at 0."""

    first_forces_n: Array
    """Forces of frame 0, shape (beads, 2)."""
    steps: NDArray[np.int64]
    positions_m: Array
    """Shape (frames, beads, 2)."""
    energy_steps: NDArray[np.int64]
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array

    @property
    def total_j(self) -> Array:
        return self.stretching_j + self.bending_j + self.kinetic_j


def run(
    specimen: Specimen,
    timestep_s: float,
    steps: int,
    frame_steps: int,
    options: Options | None = None,
    energy_steps: int | None = None,
    largest_step_s: float | None = None,
) -> Course:
    """Run a specimen; RunError when LAMMPS stops it, whose cause is judged by the step limit ``largest_step_s``."""
    options = options or Options()
    form, coefficient = options.form, specimen.strand.angle_coefficient_j
    variables: dict[str, int | float | str] = {
        "angle_style": form.style,
        "angle_numbers": form.coefficients(coefficient),
        "load": options.load_n,
        "finger_stiffness": options.finger_stiffness_pa,
        "finger_radius": options.finger_radius_m,
        "finger_x": options.finger_centre_m[0],
        "finger_y": options.finger_centre_m[1],
        "beads": len(specimen.points_m),
        "upper_last": options.legs[0],
        "lower_first": options.legs[1],
        "spacing": specimen.strand.spacing_m,
        "largest_timestep": largest_step_s or timestep_s,
        "integrator": options.integrator,
        "steps": steps,
        "frame_steps": frame_steps,
        "energy_steps": energy_steps or frame_steps,
    }
    tables = {ANGLE_TABLE: form.table({"ANGLE": coefficient}, _SHARPEST_RAD)} if form.tabulated else {}
    frames, energies, forces = run_files(specimen, SCRIPT, variables, timestep_s, options.loss_time_s, tables)
    return Course(forces, frames.steps, frames.positions_m, energies[:, 0].astype(np.int64), *energies[:, 1:4].T)


def run_to_divergence(
    specimen: Specimen,
    timestep_s: float,
    steps: int,
    frames: int,
    options: Options,
    largest_step_s: float | None = None,
    shorter: float = 0.9,
) -> tuple[Course, int, DivergenceError | None]:
    """Run a specimen for as many of ``steps`` as it bears; its course, those steps, and how the whole run diverged.

    Each attempt takes the share ``shorter`` of the one before; DivergenceError where hardly a step is left.
    """
    first, done = None, steps
    while True:
        try:
            course = run(specimen, timestep_s, done, max(1, done // frames), options, None, largest_step_s)
            return course, done, first
        except DivergenceError as error:
            first, done = first or error, int(shorter * done)
            if done <= _FEWEST_STEPS:
                raise


def first_forces(specimen: Specimen, options: Options) -> Array:
    """Forces on the beads of a specimen as it stands, N, shape (beads, 2)."""
    return run(specimen, 1e-12, 0, 1, options).first_forces_n


def grows(specimen: Specimen, timestep_s: float, steps: int, options: Options) -> bool:
    """Whether what was small at first is large after so many steps, or the run diverged before."""
    try:
        course = run(specimen, timestep_s, steps, steps, options)
    except DivergenceError:
        return True
    moved = float(np.abs(course.positions_m[-1] - course.positions_m[0]).max())
    return not moved < _GROWN * NOISE * specimen.strand.spacing_m


def shaken(specimen: Specimen, timestep_s: float, across: bool, seed: int = 5) -> Array:
    """Velocities that move free beads by the noise in one step, along x alone or in the plane; shape (beads, 2)."""
    rng = np.random.default_rng(seed)
    noise = rng.choice([-1.0, 1.0], size=specimen.points_m.shape) * rng.uniform(0.5, 1.0, specimen.points_m.shape)
    noise[specimen.types == FIXED] = 0.0
    if not across:
        noise[:, 1] = 0.0
    return np.asarray(NOISE * specimen.strand.spacing_m / timestep_s * noise, dtype=np.float64)


def bisect(unstable: Callable[[float], bool], guess: float, sharpness: float = 1e-3, reach: float = 0.03) -> float:
    """Largest stable step near a guess; looked for further away where it is not within ``reach`` of it.

    RunError (``no-step-limit``) when neither end is found within a factor of 8.
    """
    low, high = guess * (1.0 - reach), guess * (1.0 + reach)
    for _ in range(8):
        if not unstable(low):
            break
        low, high = low / 1.3, low
    else:
        raise RunError(f"no stable step found down to {low:.3g} s", "no-step-limit")
    for _ in range(8):
        if unstable(high):
            break
        low, high = high, high * 1.3
    else:
        raise RunError(f"no unstable step found up to {high:.3g} s", "no-step-limit")
    while high - low > sharpness * low:
        middle = 0.5 * (low + high)
        if unstable(middle):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
