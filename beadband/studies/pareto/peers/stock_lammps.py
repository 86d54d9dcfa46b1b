"""Stock LAMMPS as a user would write it: both legs, harmonic bonds, cosine angles, clamped at the finger."""

from __future__ import annotations

import time

import numpy as np

from beadband.analysis.rear import rear_of
from beadband.lammps.engine import kept_session
from beadband.model.angle_forms import ANGLE_FORMS
from beadband.model.scene import Scene
from beadband.statics.leg import held_leg
from beadband.studies.pareto.peers.protocol import Trace, leg_strand, steps_of
from beadband.studies.pareto.runs import read_clock, with_clock

STEP_SHARE = 0.65
"""Share of the largest stable step."""

SCRIPT = """units           si
dimension       2
boundary        f f p
atom_style      angle
atom_modify     sort 0 0
bond_style      harmonic
angle_style     cosine
pair_style      zero ${cutoff}
comm_modify     cutoff ${cutoff}
read_data       wedge.data
pair_coeff      * *
bond_coeff      1 ${stiffness} ${spacing}
angle_coeff     1 ${bending}
neighbor        ${skin} bin
neigh_modify    every 1000000 delay 0 check no
group           ends type 2
fix             move all nve
fix             hold ends setforce 0.0 0.0 0.0
timestep        ${timestep}
variable        ax equal x[${before}]
variable        ay equal y[${before}]
variable        bx equal x[${tip}]
variable        by equal y[${tip}]
variable        cx equal x[${after}]
variable        cy equal y[${after}]
fix             rear all ave/time ${every} 1 ${every} v_ax v_ay v_bx v_by v_cx v_cy file rear.txt format " %.15g"
thermo          ${steps}
thermo_modify   lost error
run             ${steps} post no
"""


class StockLammps:
    """LAMMPS without beadband's tables, dashpots, mirror axis or absorbing end."""

    name = "stock LAMMPS"
    package: str | None = "lammps"
    laws: tuple[str, ...] | None = ("linear",)
    ladder = (25, 50, 100, 200, 400)
    quick = (25, 50, 100)
    note = "both legs to the finger, bond_style harmonic (linear law alone), angle_style cosine, fix nve"

    def run(self, scene: Scene, elements: int) -> Trace:
        """Release both legs."""
        strand = leg_strand(scene, elements)
        leg = held_leg(strand, elements, scene.strain, scene.half_angle_rad, ANGLE_FORMS["cosine"])
        below = leg.positions_m[:0:-1] * np.array([1.0, -1.0])
        points = np.concatenate([below, leg.positions_m])
        samples, every, step = steps_of(scene, STEP_SHARE * strand.largest_step_s(0.0, scene.strain, 0.9))
        with kept_session() as session:
            start = time.perf_counter()
            (session.folder / "wedge.data").write_text(_data(points, strand.bead_mass_kg), encoding="utf-8")
            tip = elements + 1
            variables: dict[str, int | float | str] = {
                "cutoff": 3.0 * strand.spacing_m * (1.0 + scene.strain),
                "skin": 0.1 * strand.spacing_m,
                "stiffness": 0.5 * strand.area_m2 * strand.law.rest_modulus_pa / strand.spacing_m,
                "spacing": strand.spacing_m,
                "bending": strand.angle_coefficient_j,
                "timestep": step,
                "every": every,
                "steps": samples * every,
                "before": tip - 1,
                "tip": tip,
                "after": tip + 1,
            }
            session.run(with_clock(SCRIPT), variables)
            loop = read_clock(session.folder)[-1]
            table = np.loadtxt(session.folder / "rear.txt")
            done = time.perf_counter()
        before, at, after = table[:, 1:3], table[:, 3:5], table[:, 5:7]
        rear = rear_of(table[:, 0] * step, before, at, after, strand.spacing_m)
        return Trace(rear.times_s, rear.tip_x_m, rear.tip_curvature_1_m, loop, done - start)


def _data(points_m: np.ndarray, mass_kg: float) -> str:
    """A data file: beads in one row, those at both ends of a type of their own."""
    count = len(points_m)
    low, high = points_m.min() - np.ptp(points_m), points_m.max() + np.ptp(points_m)
    kinds = [2 if i in (0, count - 1) else 1 for i in range(count)]
    atoms = [f"{i + 1} 1 {kinds[i]} {x:.17g} {y:.17g} 0.0" for i, (x, y) in enumerate(points_m)]
    bonds = [f"{i} 1 {i} {i + 1}" for i in range(1, count)]
    angles = [f"{i} 1 {i} {i + 1} {i + 2}" for i in range(1, count - 1)]
    thick = 0.5 * float(np.hypot(*(points_m[1] - points_m[0])))
    return "\n".join(
        [
            "a wedge",
            "",
            f"{count} atoms",
            f"{len(bonds)} bonds",
            f"{len(angles)} angles",
            "2 atom types",
            "1 bond types",
            "1 angle types",
            f"{low:.17g} {high:.17g} xlo xhi",
            f"{low:.17g} {high:.17g} ylo yhi",
            f"{-thick:.17g} {thick:.17g} zlo zhi",
            "",
            "Masses",
            "",
            *(f"{kind} {mass_kg:.17g}" for kind in (1, 2)),
            "",
            "Atoms # angle",
            "",
            *atoms,
            "",
            "Bonds",
            "",
            *bonds,
            "",
            "Angles",
            "",
            *angles,
            "",
        ]
    )
