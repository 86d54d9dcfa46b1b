"""Launches with a hand, by beads, against the same ones by finite elements (launch_elements.py).

    python tests/validation/hand.py [--scenes 1 2 …] [--elements N]

Held-out scenes: hands of 5 to 100 g, with and without spring and damper, on several bands. The elements share nothing
with the beads but the physics: their contact, their integrator, and how the figures are read, are others. They have a
loss time, and their answer is carried on to none, as in launches.py. A line for each figure: the planned run with its
bar, the elements' limit with the difference of their two levels, and the error against its goal.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from launch_elements import launch

import beadband
from beadband.model.launch_string import string_launch
from beadband.model.scene import Scene
from beadband.planning.launch_plan import launch_plan_of
from beadband.studies.pareto.peers.elements import Rod

SCENES: tuple[dict[str, float | str], ...] = (
    {"hand_mass": 0.005},
    {"hand_mass": 0.02, "hand_stiffness": 500.0, "hand_damping": 3.0},
    {"hand_mass": 0.1, "law": "linear"},
    {"hand_mass": 0.05, "hand_stiffness": 5000.0, "band": "II"},
    {"hand_mass": 0.01, "hand_damping": 5.0, "band": "I"},
    {"hand_mass": 0.01, "hand_stiffness": 1000.0, "band": "circular"},
    {"hand_mass": 0.01, "hand_stiffness": 20000.0, "law": "linear", "strain": 0.3},
    {"hand_mass": 0.02, "hand_preload": 6.0, "strain": 0.6},
)
GOALS = {"hit_speed_m_s": 0.01, "impulse_n_s": 0.01, "displacement_m": 0.03, "peak_force_n": 0.03}
LOSS = {True: (0.06, 0.03), False: (0.0075, 0.00375)}
"""Loss times over h/c0: with a shock, and without."""
_LINES = 2400


def by_elements(scene: Scene, elements: int, loss_time_s: float) -> dict[str, float]:
    """The figures of a hand, by elements with this loss time."""
    band, law, string, hand = scene.band, scene.material, string_launch(scene), scene.hand
    assert hand is not None
    assert hand.mass_kg is not None
    rod = Rod(
        law.stress, law.tangent, band.area_m2, band.density_kg_m3, scene.bending_stiffness_n_m2,
        band.modulus_pa * loss_time_s,
    )  # fmt: skip
    pull = 2.0 * string.tension_n * math.cos(scene.half_angle_rad)
    preload = pull if hand.preload_n is None else hand.preload_n

    def force(way: float, speed: float) -> float:
        return preload - hand.stiffness_n_m * way - hand.damping_n_s_m * speed

    plan = launch_plan_of(scene)
    end_s = 1.3 * max(string.rear_arrival_s, string.finger_free_s)
    found = launch(
        rod, law.energy, 1.0 + scene.strain, scene.half_angle_rad, band.circumference_m, elements, end_s,
        plan.nose_beads * plan.strand.spacing_m, mass_kg=hand.mass_kg, force_n=force, lines=_LINES,
    )  # fmt: skip
    times, arrival = found.times_s, scene.scales.front_arrival_s
    assert found.gap_m[-1] <= 0.0, "the elements' hand is not hit"
    hit_s = float(np.interp(0.0, -found.gap_m[-2:], times[-2:]))
    late = times >= hit_s - 0.25 * arrival
    # The blow of the rear has begun in the last lines.
    before = int(np.searchsorted(times, hit_s - 0.01 * arrival))
    middles, force_n = 0.5 * (times[1:] + times[:-1]), np.diff(found.impulse_n_s[:, 0]) / np.diff(times)
    half = 0.03 * arrival
    peak = 0.0
    for centre in middles[(middles > half) & (middles < hit_s - half)]:
        weight = np.where(abs(middles - centre) < half, 1.0 + np.cos(math.pi * (middles - centre) / half), 0.0)
        peak = max(peak, float(weight @ force_n / weight.sum()))
    return {
        "hit_speed_m_s": -float(np.polyfit(times[late], found.gap_m[late], 1)[0]),
        "impulse_n_s": float(found.impulse_n_s[before, 0]),
        "displacement_m": float(np.interp(hit_s, times, found.way_m[:, 0])),
        "peak_force_n": peak,
    }


def limit(scene: Scene, elements: int) -> dict[str, tuple[float, float]]:
    """Each figure without loss, carried on linearly in the loss time, and the difference of the last two levels."""
    unit_s = scene.band.thickness_m / math.sqrt(scene.band.modulus_pa / scene.band.density_kg_m3)
    levels = [by_elements(scene, elements, share * unit_s) for share in LOSS[bool(scene.string.wave.shocks)]]
    apart = {name: levels[1][name] - levels[0][name] for name in GOALS}
    return {name: (levels[1][name] + apart[name], apart[name]) for name in GOALS}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenes", nargs="+", type=int, default=list(range(1, len(SCENES) + 1)))
    parser.add_argument("--elements", type=int)
    given = parser.parse_args()
    print("| scene | figure | beads | elements | error | bar | inside |\n|---|---|---|---|---|---|---|")
    for number in given.scenes:
        values, start = SCENES[number - 1], time.perf_counter()
        done = beadband.run(**values, until="launch")
        wedge = done.scene.band
        count = given.elements or round(min(max(300.0, 2.5 * wedge.circumference_m / wedge.thickness_m), 800.0))
        true = limit(done.scene, count)
        name = ", ".join(f"{key.removeprefix('hand_')} {value}" for key, value in values.items())
        for key, goal in GOALS.items():
            stated, (value, apart) = done.hand_figures[key], true[key]
            error = stated.value / value - 1.0
            inside = "yes" if abs(stated.value - value) < stated.error else "NO"
            inside += "" if abs(error) <= goal else ", beyond the goal"
            print(
                f"| {name} | {key} | {stated.value:.5g} ± {stated.error:.2g} | {value:.5g} ({apart:+.1g}) | "
                f"{error:+.2%} | {stated.error / stated.value:.2%} | {inside} |",
                flush=True,
            )
        print(f"# {done.plan.beads} beads, {count} elements, {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
