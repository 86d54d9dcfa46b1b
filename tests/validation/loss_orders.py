"""How V converges with a loss of the first and of the second order, for each kind of unloading wave.

    python tests/validation/loss_orders.py

Whole legs. The loss of the first order is that of a shock at every spacing; the other falls as the spacing does beside
it. Relative errors are those to the limit of the loss that the plan takes; orders are those of the last three levels.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from beadband.analysis.convergence import observed_order
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning.plan import LOSS_BEADS, SMOOTH_RESOLUTION
from beadband.runs.ask import question_of
from beadband.runs.rear_run import follow_rear

SCENES: dict[str, dict[str, Any]] = {
    "sharp front (linear)": {"law": "linear"},
    "sharp front (linear, thin)": {"law": "linear", "strain": 0.9, "half_angle_deg": 20.0, "thickness_m": 1.2e-3},
    "fan (Ogden, alpha 6)": {"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,), "strain": 0.8, "half_angle_deg": 12.0},
    "shock (Mooney-Rivlin)": {},
    "shock and fan (Gent)": {"law": "gent", "mu_pa": 3.5e5, "jm": 9.0, "strain": 1.2, "half_angle_deg": 12.0},
}
LEVELS = (4, 6, 8, 10, 12, 14)


def main() -> None:
    with Session() as session:
        for name, values in SCENES.items():
            question = question_of(scene_of({**values, "tolerance": 5e-4}), "speed")
            band, wave = question.scene.band, question.scene.string.wave
            beads = [question.beads(level) for level in LEVELS]
            speeds: dict[str, list[float]] = {"first": [], "second": []}
            for level in LEVELS:
                plan = question.plan(level)
                front = plan.strand.spacing_m * band.density_kg_m3 * wave.tail_speed_m_s / band.modulus_pa
                resolution = plan.scene.scales.rear_length_m / plan.strand.spacing_m
                losses = {"first": LOSS_BEADS, "second": LOSS_BEADS * min(1.0, SMOOTH_RESOLUTION / resolution)}
                for order, loss in losses.items():
                    found = follow_rear(replace(plan, loss_time_s=loss * front), session)
                    speeds[order].append(found.fitted_speed_m_s.value)
            chosen = "first" if wave.shocks else "second"
            finest = np.array(beads[:2:-1], dtype=np.float64)
            true = question.limit(finest, np.array(speeds[chosen][:2:-1])).value
            print(f"{name}: the plan takes the {chosen} order; beads {beads}")
            for order, found in speeds.items():
                errors = " ".join(f"{100.0 * (one / true - 1.0):+.4f}" for one in found)
                p = observed_order(1.0 / finest, np.array(found[:2:-1]))
                print(f"  {order:6s}  errors, % {errors}  order {'none' if p is None else f'{p:.1f}'}")


if __name__ == "__main__":
    main()
