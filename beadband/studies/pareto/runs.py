"""One method run once in LAMMPS: its answer and its cost."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from beadband.analysis.fits import hann_mean
from beadband.analysis.readers import Trajectory, read, read_path
from beadband.analysis.rear import Rear
from beadband.errors import RunError
from beadband.lammps import files, scripts
from beadband.lammps.bond_table import bond_table
from beadband.lammps.datafile import leg_data
from beadband.lammps.engine import Session
from beadband.model.angle_forms import ANGLE_FORMS, AngleForm
from beadband.planning.plan import Plan
from beadband.runs.measurement import measure, measure_rear
from beadband.runs.rear_run import hold, reading_own_files
from beadband.statics.leg import TIP_WEIGHT, Leg, held_leg
from beadband.statics.ring import WRAPPED, Ring
from beadband.studies.pareto.methods import Method
from beadband.studies.pareto.outcomes import NOT_FINITE

SHARES = (0.1, 0.3)
"""Times at which the tip curvature is taken, in shares of the front's arrival."""
HALF_WIDTH = 0.03
"""Half width of the window over which it is averaged."""

VARIANTS = "leg_variants.in"
CONTACT = "ring_contact.in"
_CLOCK = "clock.dat"
# The wall time of the steps alone, as LAMMPS reports it at the last step.
_CLOCK_LINES = f"""
variable        clock equal cpu
fix             clock all print ${{steps}} "${{clock}}" file {_CLOCK} screen no title ""
"""
PAIR_POINTS = 4001
_CHOICES = ("bond", "interpolation", "dashpot_by", "stepping", "inner", "output", "spread")
"""Choices of leg_variants.in, which a run may leave changed behind it."""
_CONTACT_STIFFNESS = 0.5
"""Stiffness of the contact of a bead, over that of a bond."""


@dataclass(frozen=True)
class Answer:
    """What was measured of a release."""

    speed_m_s: float
    curvature_1_m: tuple[float, float]
    """Tip curvature around the two times, NaN where it can't be measured."""


@dataclass(frozen=True)
class Cost:
    """Seconds of one repeat."""

    relax_s: float
    setup_s: float
    """Writing input, reading it, neighbour lists: everything in LAMMPS but the steps."""
    integrate_s: float


def run_once(method: Method, session: Session) -> tuple[Answer, Cost]:
    """Hold, release and measure; RunError with the reason when it can't be done."""
    start = time.perf_counter()
    if method.model == "leg":
        return _run_leg(method, session, start)
    plan = method.plan
    ring = hold(plan)
    held = time.perf_counter()
    pictures = method.model == "ring files"
    scripts.write_ring(session.folder, plan, ring, pictures)
    variables = scripts.ring_variables(plan, ring, pictures)
    name = files.SCRIPT
    if method.model == "contact":
        name = CONTACT
        variables.update(_contact(plan, ring))
    session.run(with_clock(scripts.script_text(name)), variables)
    done = time.perf_counter()
    integrate = read_clock(session.folder)[-1]
    with reading_own_files():
        answer = answer_of(plan, read(session.folder / files.REAR))
    return answer, Cost(held - start, done - held - integrate, integrate)


def _run_leg(method: Method, session: Session, start: float) -> tuple[Answer, Cost]:
    plan, output = method.plan, method.choices.get("output")
    leg = hold_by(method)
    held = time.perf_counter()
    write_leg(session.folder, method, leg)
    text = leg_script(method)
    variables = leg_variables(method, leg)
    if output == "nothing":
        session.run(text.rpartition("\nrun ")[0] + "\nrun 0 post no\n", variables)
        before = time.perf_counter()
        trajectory = _gather(session, plan, leg)
        integrate = time.perf_counter() - before
    else:
        session.run(with_clock(text), variables)
        integrate = read_clock(session.folder)[-1]
    done = time.perf_counter()
    if output == "dump":
        with reading_own_files():
            trajectory = _mirrored(read(session.folder / files.REAR), leg, plan.beads)
    elif output != "nothing":
        with reading_own_files():
            trajectory = read_path(session.folder / files.PATH, leg.positions_m, plan.beads)
    averaged = output not in ("nothing", "samples")
    return answer_of(plan, trajectory, averaged), Cost(held - start, done - held - integrate, integrate)


def hold_by(method: Method) -> Leg:
    """The held leg, in equilibrium of the angle energy that it will be released with."""
    plan = method.plan
    strand = plan.scene.strand(plan.beads)
    return held_leg(strand, plan.leg_bonds, plan.scene.strain, plan.scene.half_angle_rad, form_of(method))


def form_of(method: Method) -> AngleForm:
    """The angle form of a method."""
    return ANGLE_FORMS[str(method.choices.get("angle", "quartic"))]


def write_leg(folder: Path, method: Method, leg: Leg) -> None:
    """Data file and tables of a leg."""
    strand = method.plan.scene.strand(method.plan.beads)
    (folder / files.DATA).write_text(leg_data(leg, strand), encoding="utf-8")
    table = bond_table(strand, method.plan.scene.strain, method.table_points)
    (folder / files.TABLE).write_text(table, encoding="utf-8")
    if method.choices.get("stepping") == "angles_inside":
        # The same rows between the same ends; a pair table has no slopes at its ends.
        first, rows = table.split("\n\n")[1:]
        (folder / "pair.table").write_text(f"# bonds as pairs\n\nBAND\n{' '.join(first.split()[1:3])}\n\n{rows}")
    form = form_of(method)
    if form.tabulated:
        (folder / files.ANGLE_TABLE).write_text(form.table(_coefficients(method)), encoding="utf-8")


def _coefficients(method: Method) -> dict[str, float]:
    """Angle coefficients of the leg and, weighted, of its tip, J."""
    k = method.plan.scene.strand(method.plan.beads).angle_coefficient_j
    return {"LEG": k, "TIP": TIP_WEIGHT * k}


def leg_script(method: Method) -> str:
    """leg_variants.in under the choices of a method."""
    form = form_of(method)
    leg, tip = (form.coefficients(k, section) for section, k in _coefficients(method).items())
    chosen: scripts.Variables = {
        "angle_style": form.style,
        "angle_numbers": leg,
        "tip_numbers": tip,
        "pair_points": PAIR_POINTS,
        **{name: value for name, value in method.choices.items() if name != "angle"},
    }
    if method.choices.get("bond") == "lepton":
        chosen["law_energy"] = method.plan.scene.material.lammps_expression().replace(" ", "")
    defaults = "".join(f"variable {name} delete\n" for name in _CHOICES)
    return defaults + scripts.assignments(chosen, again=True) + scripts.script_text(VARIANTS)


def leg_variables(method: Method, leg: Leg) -> scripts.Variables:
    """What leg_variants.in needs to know beyond the choices."""
    plan = method.plan
    strand = plan.scene.strand(plan.beads)
    return {
        **scripts.leg_variables(plan, leg),
        "table_points": method.table_points,
        "bin": 0.0,
        "spacing": strand.spacing_m,
        "area": strand.area_m2,
        "modulus": plan.scene.band.modulus_pa,
    }


def with_clock(text: str) -> str:
    """A script with a fix before its last run that writes how many seconds the steps took."""
    head, run, tail = text.rpartition("\nrun ")
    return head + _CLOCK_LINES + run.lstrip("\n") + tail


def read_clock(folder: Path) -> list[float]:
    """Seconds of each timed run; RunError when there is none."""
    try:
        read = [float(word) for word in (folder / _CLOCK).read_text(encoding="ascii").split()]
        seconds = [value for value in read if value > 0.0]  # 0 is written before the first step
        if not seconds:
            raise ValueError("only zeros")
        return seconds
    except (OSError, ValueError) as error:
        raise RunError(f"LAMMPS wrote no time of its steps: {error}") from error


def _contact(plan: Plan, ring: Ring) -> scripts.Variables:
    """Finger of ring_contact.in: F = K d^2 at a depth d, so the stiffness is 2 K d; the arc is in equilibrium."""
    strand = plan.scene.strand(plan.beads)
    wrapped = ring.positions_m[ring.types == WRAPPED]
    middle = len(wrapped) // 2
    bond = float(np.hypot(*(wrapped[middle] - wrapped[middle - 1])))
    push = ring.tension_n * bond / ring.finger_radius_m
    stiffness = _CONTACT_STIFFNESS * strand.area_m2 * strand.law.rest_modulus_pa / strand.spacing_m
    depth = 2.0 * push / stiffness
    return {
        "contact_stiffness": push / depth**2,
        "finger_x": ring.finger_centre_m,
        "finger_radius": ring.finger_radius_m + depth,
    }


def _gather(session: Session, plan: Plan, leg: Leg) -> Trajectory:
    """Steps from Python, which reads the positions between them."""
    lammps = session.instance
    positions = [leg.positions_m[:2].copy()]
    for _ in range(plan.steps // plan.rear_steps):
        lammps.command(f"run {plan.rear_steps} pre no post no")
        ids, x = lammps.numpy.extract_atom("id"), lammps.numpy.extract_atom("x")
        positions.append(np.array([x[int(np.flatnonzero(ids == bead)[0]), :2] for bead in (1, 2)]))
    steps = plan.rear_steps * np.arange(len(positions))
    return _mirrored(Trajectory(steps, np.array([1, 2]), np.array(positions)), leg, plan.beads)


def _mirrored(trajectory: Trajectory, leg: Leg, beads: int) -> Trajectory:
    """With the image of bead 2, and the held leg as the first frame."""
    positions, steps = trajectory.positions_m, trajectory.steps
    positions, steps = positions[steps > 0], steps[steps > 0]
    positions = np.concatenate([leg.positions_m[None, :2], positions])
    below = positions[:, 1] * np.array([1.0, -1.0])
    whole = np.concatenate([positions, below[:, None]], axis=1)
    return Trajectory(np.concatenate([[0], steps]), np.array([1, 2, beads]), whole)


def answer_of(plan: Plan, trajectory: Trajectory, averaged: bool = True) -> Answer:
    """Rebound speed and windowed curvatures; RunError when the speed is not finite.

    Samples belong to the time of their step; means to half an interval before it.
    """
    if not np.all(np.isfinite(trajectory.positions_m)):
        raise RunError("the positions are not finite", NOT_FINITE)
    with reading_own_files():
        if averaged:
            found = measure(plan, trajectory)
            speed, rear = found.fitted_speed_m_s.value, found.rear
        else:
            # As means over single steps, so that their times are those of the steps.
            rear = measure_rear(plan, trajectory)
            rear = replace(rear, times_s=np.asarray(trajectory.steps * plan.timestep_s, dtype=np.float64))
            speed = _slope(plan, rear)
    arrival = plan.front_arrival_s
    means = []
    for share in SHARES:
        try:
            means.append(hann_mean(rear.times_s, rear.tip_curvature_1_m, share * arrival, HALF_WIDTH * arrival))
        except ValueError:
            means.append(math.nan)
    if not math.isfinite(speed):
        raise RunError("the rebound speed is not finite", NOT_FINITE)
    return Answer(speed, (means[0], means[1]))


def _slope(plan: Plan, rear: Rear) -> float:
    from beadband.analysis.fits import slope
    from beadband.model.scales import SPEED_WINDOW

    start, end = (share * plan.front_arrival_s for share in SPEED_WINDOW)
    try:
        return slope(rear.times_s, rear.tip_x_m, start, end).value
    except ValueError as error:
        raise RunError(str(error)) from error
