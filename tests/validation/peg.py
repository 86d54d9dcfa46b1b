"""What docs/peg.md says of tips held by pegs, measured: some minutes on one core.

python tests/validation/peg.py [shapes|limits|ladder|bars|heldout|ring|catalogue]
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np

from beadband.analysis.fits import Array, hann_mean
from beadband.errors import UsageError
from beadband.lammps.engine import Session
from beadband.model.peg import own_radius_m
from beadband.model.scene import Scene, scene_of
from beadband.planning.plan import plan_of
from beadband.runs.ask import ask
from beadband.runs.held import hold
from beadband.runs.rear_run import follow_rear, rear_run
from beadband.statics.leg import LegRequest
from beadband.statics.peg import peg_leg
from beadband.studies.pareto.peers.elements import Rod, held_shape
from beadband.studies.pareto.peers.finite_elements import FiniteElements
from beadband.studies.pareto.peers.protocol import answer_of

RADII_MM = (1.0, 2.0, 4.0)


def own_mm(scene: Scene) -> float:
    return 1e3 * own_radius_m(scene.strand(1), scene.strain, scene.half_angle_rad)


def exact(scene: Scene, places: Array) -> Array:
    """Positions of the continuous leg, by the second method's own integration."""
    strand = scene.strand(1)
    rod = Rod(
        strand.law.stress, strand.law.tangent, strand.area_m2, strand.density_kg_m3, strand.bending_stiffness_n_m2, 0.0
    )
    return held_shape(rod, 1.0 + scene.strain, scene.half_angle_rad, places, scene.tip_radius_m)[0]


def shapes() -> None:
    """Held leg against the exact shape, over the leg."""
    print(
        "| law | radius (mm) | beads | on the peg | largest distance over the leg | order |\n|---|---|---|---|---|---|"
    )
    for law in ("mooney-rivlin", "linear"):
        for radius in RADII_MM:
            scene = scene_of({"law": law, "tip_radius_m": 1e-3 * radius})
            last = math.nan
            for beads in (500, 1000, 2000, 4000, 8000):
                strand, bonds = scene.strand(beads), beads // 4
                held, on_peg = peg_leg(LegRequest(strand, bonds, scene.strain, scene.half_angle_rad), scene.peg)
                apart = held.positions_m - exact(scene, np.arange(bonds + 1) * strand.spacing_m)
                error = float(np.hypot(*apart.T).max()) / scene.wedge.leg_m
                order = "" if math.isnan(last) else f"{math.log2(last / error):.2f}"
                print(f"| {law} | {radius:g} | {beads} | {on_peg} | {error:.1e} | {order} |")
                last = error


def limits() -> None:
    """V and the curvature as the radius comes down to that of the point-held tip."""
    print("| radius over its own | V (m/s) | V over the point's - 1 | curvature at 0.1 t_f over the point's - 1 |\n"
          "|---|---|---|---|")  # fmt: skip
    point: tuple[float, float] | None = None
    with Session() as session:
        for share in (0.0, 0.5, 1.0, 1.001, 1.01, 1.1, 1.5, 2.0):
            scene = scene_of({})
            scene = scene_of({"tip_radius_m": share * 1e-3 * own_mm(scene), "beads": 1600})
            found, arrival = follow_rear(plan_of(scene, "leg"), session), scene.scales.front_arrival_s
            rear = found.rear
            bent = hann_mean(rear.times_s, rear.tip_curvature_1_m, 0.1 * arrival, 0.03 * arrival)
            speed = found.fitted_speed_m_s.value
            point = point or (speed, bent)
            print(f"| {share:g} | {speed:.4f} | {speed / point[0] - 1.0:+.1e} | {bent / point[1] - 1.0:+.1e} |")


def ladder() -> None:
    """Stated bars against true errors, at every number of beads."""
    print("| radius (mm) | beads | V (m/s) | bar | true error | over the bar |\n|---|---|---|---|---|---|")
    with Session() as session:
        for radius in (1.0, 3.0, 8.0):
            scene = scene_of({"tip_radius_m": 1e-3 * radius, "for": "speed"})
            speeds = {
                beads: follow_rear(plan_of(scene.with_beads(beads), "leg"), session).fitted_speed_m_s.value
                for beads in (2000, 4000)
            }
            true = 2.0 * speeds[4000] - speeds[2000]
            for beads in (100, 140, 200, 280, 400, 560, 800, 1600):
                found = rear_run(plan_of(scene.with_beads(beads), "leg"), session).speed
                off = found.value - true
                print(
                    f"| {radius:g} | {beads} | {found.value:.3f} | {found.error / true:.2%} | {off / true:+.3%} | "
                    f"{abs(off) / found.error:.2f} |"
                )


def bars() -> None:
    """Answers and runs of random scenes against the limit of legs of 1200 and 2400 beads: how often the bar holds."""
    rng, found = np.random.default_rng(7), {"ask, 0.5 %": [], "ask, 0.2 %": [], "run, 0.5 %": []}
    with Session() as session:
        while len(found["run, 0.5 %"]) < 60:
            values = {
                "band": ("I", "II", "III", "IV")[rng.integers(4)],
                "law": ("mooney-rivlin", "linear")[rng.integers(2)],
                "strain": float(rng.uniform(0.15, 1.0)),
                "half_angle_deg": float(rng.uniform(6.0, 26.0)),
                "tip_radius_m": float(rng.uniform(0.5e-3, 9e-3)),
                "for": "speed",
            }
            try:
                scene = scene_of(values)
            except UsageError:
                continue  # too much of it on the peg
            if scene.peg is None:
                continue
            plans = (plan_of(scene.with_beads(beads), "leg") for beads in (1200, 2400))
            coarse, fine = (follow_rear(plan, session).fitted_speed_m_s.value for plan in plans)
            true = fine + (fine - coarse) / (1.0 if scene.string.wave.shocks else 3.0)
            for share in (0.005, 0.002):
                answer = ask(replace(scene, tolerance=share), session=session)
                found[f"ask, {share:.1%}".replace("%", " %")].append((abs(answer.value - true), answer.error, true))
            speed = rear_run(plan_of(scene, "leg"), session).speed
            found["run, 0.5 %"].append((abs(speed.value - true), speed.error, true))
    print("| | within its bar | largest error over the bar | median error | median bar |\n|---|---|---|---|---|")
    for name, rows in found.items():
        off, bar, true = np.array(rows).T
        print(
            f"| {name} | {(off <= bar).sum()} of {len(off)} | {(off / bar).max():.2f} | {np.median(off / true):.3%} | "
            f"{np.median(bar / true):.2%} |"
        )


def by_elements(scene: Scene) -> tuple[float, float]:
    """V by finite elements from their own held shape, carried on to no spacing, and what that adds."""
    coarse, fine = (answer_of(scene, FiniteElements().run(scene, count)).speed_m_s for count in (80, 160))
    first = scene.string.wave.shocks
    added = (fine - coarse) if first else (fine - coarse) / 3.0
    return fine + added, added


def heldout() -> None:
    """Scenes that were chosen by chance, by the second method."""
    rng = np.random.default_rng(15)
    print("| band | law | strain | half-angle (deg) | radius (mm) | V asked for (m/s) | V by elements (m/s) | "
          "difference | over the bar |\n|---|---|---|---|---|---|---|---|---|")  # fmt: skip
    with Session() as session:
        for place in range(16):
            values = {
                "band": ("II", "III")[place % 2],
                "law": ("mooney-rivlin", "linear")[place // 2 % 2],
                "strain": round(float(rng.uniform(0.3, 0.9)), 3),
                "half_angle_deg": round(float(rng.uniform(8.0, 22.0)), 1),
                "tip_radius_m": 1e-3 * (0.0, 0.8, 1.5, 2.5, 3.5, 5.0, 6.5, 8.0)[place // 2],
                "tolerance": 1e-3,
            }
            scene = scene_of(values)
            found = ask(scene, session=session)
            other, _ = by_elements(scene)
            off = found.value - other
            print(
                f"| {values['band']} | {values['law']} | {values['strain']} | {values['half_angle_deg']} | "
                f"{1e3 * scene.tip_radius_m:g} | {found.value:.3f} | {other:.3f} | {off / other:+.3%} | "
                f"{abs(off) / found.error:.2f} |",
                flush=True,
            )


def ring() -> None:
    """One leg against the whole ring, and the ring's net force."""
    print("| band | radius (mm) | net force over the tension | V of the ring (m/s) | leg over ring - 1 |\n"
          "|---|---|---|---|---|")  # fmt: skip
    with Session() as session:
        for band in ("I", "II", "III", "IV"):
            for radius in (1.0, 3.0, 5.0, *((8.0, 12.0) if band == "III" else ())):
                scene = scene_of({"band": band, "tip_radius_m": 1e-3 * radius, "beads": 520, "for": "speed"})
                plans = plan_of(scene), plan_of(scene, "leg")
                whole, leg = (follow_rear(plan, session).fitted_speed_m_s.value for plan in plans)
                print(
                    f"| {band} | {radius:g} | {hold(plans[0]).net_force:.0e} | {whole:.3f} | {leg / whole - 1.0:+.1e} |"
                )


def catalogue() -> None:
    """The catalogue's scenes, held at a point and by a peg of 5 mm."""
    print("| band | own radius (mm) | radius for kappa h/2 = 0.3 (mm) | kappa h/2, point | kappa h/2, 5 mm | "
          "V, point (m/s) | V, 5 mm (m/s) | late V, 5 mm (m/s) |\n|---|---|---|---|---|---|---|---|")  # fmt: skip
    with Session() as session:
        for band in ("I", "II", "III", "IV"):
            point = scene_of({"band": band, "tolerance": 1e-3})
            peg = replace(point, tip_radius_m=5e-3)
            asked = [ask(scene, session=session) for scene in (point, peg)]
            late = rear_run(plan_of(replace(peg, purpose="speed").with_beads(1600), "leg"), session).late_speed_m_s
            low, high = 1e-3, 20e-3
            while high - low > 1e-6:
                middle = 0.5 * (low + high)
                sharp = replace(point, tip_radius_m=middle).scales.tip_sharpness > 0.3
                low, high = (middle, high) if sharp else (low, middle)
            print(
                f"| {band} | {own_mm(point):.3f} | {1e3 * high:.2f} | {point.scales.tip_sharpness:.2f} | "
                f"{peg.scales.tip_sharpness:.3f} | {asked[0].value:.3f} +/- {asked[0].error:.3f} | "
                f"{asked[1].value:.3f} +/- {asked[1].error:.3f} | {late:.2f} |"
            )


PARTS = {
    "shapes": shapes,
    "limits": limits,
    "ladder": ladder,
    "bars": bars,
    "heldout": heldout,
    "ring": ring,
    "catalogue": catalogue,
}

if __name__ == "__main__":
    for name in sys.argv[1:] or PARTS:
        print(f"\n## {name}\n")
        PARTS[name]()
