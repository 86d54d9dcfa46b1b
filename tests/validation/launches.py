"""Launches by beads against the same launches by finite elements (launch_elements.py), each of its figures.

    python tests/validation/launches.py [--bands I II III IV circular] [--laws mooney-rivlin linear]
        [--strain 0.476] [--half-angle 14] [--elements N]

The elements have a loss time of their own, and so their answer is carried on to no loss: linearly in the loss time,
and what is read of the throw linearly in its root where the front is no shock and spreads by diffusion. A line for each
figure: the planned run with its bar, the elements' limit with what it was carried on by, and the error.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from launch_elements import Launched, launch

import beadband
from beadband.analysis.contact import finger_free, last_load, touches_of
from beadband.model.launch_string import string_launch
from beadband.model.scene import Scene, scene_of
from beadband.planning.launch_plan import launch_plan_of
from beadband.studies.pareto.peers.elements import Rod

FIGURES = ("rear_arrival_s", "centre_of_mass_speed_m_s", "efficiency", "finger_free_s", "last_load_s")
GOALS = dict(zip(FIGURES, (0.005, 0.007, 0.013, 0.013, math.inf), strict=True))
LOSS = {True: (0.06, 0.03), False: (0.008, 0.002)}
"""Loss times over h/c0: with a shock, and without."""
_LINES = 2000


def by_elements(scene: Scene, elements: int, loss_time_s: float) -> dict[str, float]:
    """The figures of a launch, by elements with this loss time."""
    band, law, string = scene.band, scene.material, string_launch(scene)
    viscosity = band.modulus_pa * loss_time_s
    rod = Rod(law.stress, law.tangent, band.area_m2, band.density_kg_m3, scene.bending_stiffness_n_m2, viscosity)
    plan = launch_plan_of(scene)
    nose_m = plan.nose_beads * plan.strand.spacing_m
    end_s = 1.15 * max(string.rear_arrival_s, string.finger_free_s)
    stretch, angle = 1.0 + scene.strain, scene.half_angle_rad
    found = launch(rod, law.energy, stretch, angle, band.circumference_m, elements, end_s, nose_m, lines=_LINES)
    return figures(found, scene)


def figures(found: Launched, scene: Scene) -> dict[str, float]:
    """Its figures, read as those of beads are: the throw before the rear's blow."""
    string = string_launch(scene)
    times, impulse = found.times_s, found.impulse_n_s[:, 0]
    idle_s = 0.03 * string.finger_free_s
    # Means over a few lines: a line of these is shorter than one of finger.dat.
    every = 3
    picked, force = times[::every], np.diff(impulse[::every], prepend=0.0) / (every * times[1])
    held = 2.0 * string.tension_n * math.cos(scene.half_angle_rad)
    force[0] = held
    arrival_s = float(np.interp(0.0, -found.gap_m[-2:], times[-2:]))
    last = last_load(picked, force, held, idle_s)
    free_s = ended_s = math.nan
    read = len(times) - 4
    if last is not None:
        free_s = finger_free(picked, force, last, 2.0 * string.tension_n, string.turning_1_s).value
        ended_s = float(picked[last])
        touches = touches_of(picked, force, held, ended_s, idle_s)
        if touches and touches[-1].end_s + idle_s > arrival_s:
            read = min(read, int(np.searchsorted(times, touches[-1].start_s)))
    momentum = float(found.momentum_n_s[read])
    balance = float(np.ptp(found.energy_j)) / found.stored_j
    print(f"# energy kept to {balance:.1e}, momentum to {abs(impulse[-1] / found.momentum_n_s[-1] - 1.0):.1e}")
    values = (arrival_s, momentum / found.mass_kg, 0.5 * momentum**2 / found.mass_kg / found.stored_j, free_s, ended_s)
    return dict(zip(FIGURES, values, strict=True))


def limit(scene: Scene, elements: int) -> dict[str, tuple[float, float]]:
    """Each figure without loss, and by how much it was carried on from the smaller loss."""
    shocks = bool(scene.string.wave.shocks)
    unit_s = scene.band.thickness_m / math.sqrt(scene.band.modulus_pa / scene.band.density_kg_m3)
    more, less = LOSS[shocks]
    coarse, fine = (by_elements(scene, elements, share * unit_s) for share in (more, less))
    found = {}
    for name in FIGURES:
        power = 1.0 if shocks or name == "rear_arrival_s" else 0.5
        # The last load is chance: no limit is taken of it.
        carried = 0.0 if name == "last_load_s" else (fine[name] - coarse[name]) / ((more / less) ** power - 1.0)
        found[name] = fine[name] + carried, carried
    return found


def elements_for(scene: Scene) -> int:
    """A fifth of the thickness to an element, from 300 to 1000."""
    return round(min(max(300.0, 2.5 * scene.band.circumference_m / scene.band.thickness_m), 1000.0))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--bands", nargs="+", default=["I", "II", "III", "circular", "IV"])
    parser.add_argument("--laws", nargs="+", default=["mooney-rivlin", "linear"])
    parser.add_argument("--strain", type=float, default=0.476)
    parser.add_argument("--half-angle", type=float, default=14.0)
    parser.add_argument("--elements", type=int)
    given = parser.parse_args()
    print("| band | law | figure | beads | elements | error | bar | inside |\n|---|---|---|---|---|---|---|---|")
    for law in given.laws:
        for band in given.bands:
            values = {"band": band, "law": law, "strain": given.strain, "half_angle": given.half_angle}
            keys = {"band": band, "law": law, "strain": given.strain, "half_angle_deg": given.half_angle}
            scene = scene_of({**keys, "until": "launch"})
            begin = time.perf_counter()
            run = beadband.run(**values, until="launch")
            true = limit(scene, given.elements or elements_for(scene))
            for name in FIGURES:
                stated, (value, carried) = run.figures[name], true[name]
                error = stated.value / value - 1.0
                inside = abs(error) < stated.error / stated.value
                wrong = "" if abs(error) <= GOALS[name] else ", beyond the goal"
                beads, bar = f"{stated.value:.5g} ± {stated.error:.2g}", stated.error / stated.value
                cells = band, law, name, beads, f"{value:.5g} ({carried:+.1g})", f"{error:+.2%}", f"{bar:.2%}"
                print("|", " | ".join(cells), "|", "yes" if inside else "NO", wrong, "|", flush=True)
            print(f"# {band} {law}: {time.perf_counter() - begin:.0f} s, {run.plan.beads} beads", flush=True)


if __name__ == "__main__":
    main()
