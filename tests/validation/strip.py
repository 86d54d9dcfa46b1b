"""A released strip against its exact solution: planned runs, orders of convergence, and whether the bars hold.

    python tests/validation/strip.py [planned|orders|bars [SCENES [SEED]]]

``planned`` runs the laws of docs/strip.md as they are planned; ``orders`` refines them with the losses of docs/loss.md
and without; ``bars`` releases random strips with 24 to 800 bonds, and counts which of their errors lie within the
stated ones. The curves of the plan were drawn from the scenes of seed 7.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

from beadband import api
from beadband.analysis.convergence import observed_order
from beadband.errors import RunError, UsageError
from beadband.model.scene import scene_of
from beadband.planning.plan import LOSS_BEADS, SMOOTH_RESOLUTION, plan_of
from beadband.runs.strip_results import StripRun

LAWS: dict[str, dict[str, Any]] = {
    "linear": {"law": "linear"},
    "Mooney-Rivlin": {},
    "neo-Hookean": {"law": "neo-hookean", "mu_pa": 3e5, "strain": 2.0},
    "Ogden, alpha 6": {"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,), "strain": 0.8},
    "Gent": {"law": "gent", "mu_pa": 3.5e5, "jm": 9.0, "strain": 1.2},
    "Gent, far": {"law": "gent", "mu_pa": 3.5e5, "jm": 30.0, "strain": 3.0},
    "Mooney-Rivlin, softened": {"softening_r": 2.0, "softening_beta": 0.3},
    "Gent, softened": {"law": "gent", "mu_pa": 3.5e5, "jm": 30.0, "strain": 3.0, "softening_r": 1.5,
                       "softening_beta": 0.3},
}  # fmt: skip
LEVELS = (50, 100, 200, 400, 800)


def released(**values: Any) -> StripRun:
    """A strip, released in memory."""
    found = api.run(scene_of({"shape": "strip", **values}))
    assert isinstance(found, StripRun)
    return found


def errors(run: StripRun) -> tuple[float, float, float]:
    """Relative errors of recoil speed, front speed and arrival."""
    assert run.front_speed is not None
    assert run.arrival is not None
    pairs = (
        (run.speed.value, run.plan.string.rear_speed_m_s),
        (run.front_speed.value, run.exact_front_speed_m_s),
        (run.arrival.value, run.exact_arrival_s),
    )
    speed, front, arrival = (found / exact - 1.0 for found, exact in pairs)
    return speed, front, arrival


def bars(run: StripRun) -> tuple[float, float, float]:
    """The relative errors that are stated for them."""
    speed, front, arrival = (
        one.error / one.value for one in (run.speed, run.front_speed, run.arrival) if one is not None
    )
    return speed, front, arrival


def planned() -> None:
    """Recoil and front of planned runs beside the exact ones."""
    for name, values in LAWS.items():
        for tolerance in (0.005, 0.0005):
            run = released(**values, tolerance=tolerance)
            wave, exact = run.plan.string.wave, run.plan.string.rear_speed_m_s
            off = " ".join(
                f"{100.0 * one:+8.4f} ({100.0 * bar:6.4f})" for one, bar in zip(errors(run), bars(run), strict=True)
            )
            stored = run.energy.stored_j
            lost = run.energy.dissipated_j[-1] / stored
            # Of the volume that each shock has passed when the foremost point of the wave arrives.
            density = sum(part.loss_j_m3 * part.front_speed_m_s for part in wave.parts) / wave.front_speed_m_s
            exact_lost = density * run.scene.band.area_m2 * run.scene.wedge.reference_leg_m / stored
            print(
                f"{name:24s} {wave.kind:14s} {run.plan.beads:4d} bonds, V {run.speed.value:8.4f} exact {exact:8.4f}, "
                f"% {off}; "
                f"lost {100 * lost:5.2f} exact {100 * exact_lost:5.2f} %, "
                f"balance {run.energy.error:.1e}, momentum {run.checks['momentum'].value:.1e}"
            )


def loss_time_s(values: dict[str, Any], beads: int, order: str) -> float:
    """A loss that falls as the spacing does ("first"), beside it once more ("second"), or "none"."""
    plan = plan_of(scene_of({"shape": "strip", **values, "beads": beads}))
    band, wave = plan.scene.band, plan.string.wave
    share = {"first": 1.0, "second": min(1.0, SMOOTH_RESOLUTION / beads), "none": 0.0}[order]
    return LOSS_BEADS * share * plan.strand.spacing_m * band.density_kg_m3 * wave.tail_speed_m_s / band.modulus_pa


def orders() -> None:
    """Errors over the bonds with a loss of the first and of the second order, and without."""
    spacing = 1.0 / np.array(LEVELS[::-1], dtype=np.float64)
    for name, values in LAWS.items():
        for loss in ("first", "second", "none"):
            try:
                found = np.array(
                    [
                        errors(released(**values, loss_time_s=loss_time_s(values, beads, loss), beads=beads))
                        for beads in LEVELS
                    ]
                )
            except RunError as error:
                print(f"{name}, loss {loss}: {str(error)[:90]}")
                continue
            print(f"{name}, loss {loss}:")
            for what, column in zip(("recoil", "front", "arrival"), found.T, strict=True):
                order = observed_order(spacing, column[::-1])
                listed = " ".join(f"{100.0 * one:+.5f}" for one in column)
                print(f"  {what:8s} {listed}  order {'none' if order is None else f'{order:.1f}'}")


def scenes(count: int, seed: int) -> Iterator[dict[str, Any]]:
    """Random strips of every kind of wave."""
    draw = np.random.default_rng(seed)
    while count:
        law = str(draw.choice(["linear", "mooney-rivlin", "neo-hookean", "gent", "ogden", "yeoh"]))
        values: dict[str, Any] = {"law": law, "strain": float(np.exp(draw.uniform(np.log(0.1), np.log(4.0))))}
        if law == "mooney-rivlin":
            values["band"] = str(draw.choice(["I", "II", "III", "IV"]))
        elif law == "neo-hookean":
            values["mu_pa"] = 3e5
        elif law == "gent":
            values |= {"mu_pa": 3e5, "jm": float(draw.uniform(5.0, 60.0))}
        elif law == "ogden":
            values |= {"mu_pa": (2e5,), "alpha": (float(draw.uniform(1.5, 6.0)),)}
        elif law == "yeoh":
            values |= {
                "c1_pa": 1.5e5,
                "c2_pa": float(draw.uniform(-3e3, 3e3)),
                "c3_pa": float(draw.uniform(0.0, 300.0)),
            }
        if law != "linear" and draw.uniform() < 0.3:
            values |= {"softening_r": float(draw.uniform(1.3, 3.0)), "softening_beta": float(draw.uniform(0.1, 1.0))}
        try:
            scene_of({"shape": "strip", **values})
        except UsageError:
            continue
        count -= 1
        yield values


def coverage(count: int = 60, seed: int = 11) -> None:
    """95 % envelopes of the errors over the bonds, by the kind of wave, and the share within the bars."""
    table: dict[tuple[str, int], list[tuple[float, ...]]] = {}
    for values in scenes(count, seed):
        for beads in (24, *LEVELS):
            run = released(**values, beads=beads)
            kind = run.plan.string.wave.kind
            table.setdefault((kind, beads), []).append((*errors(run), *bars(run)))
    for (kind, beads), rows in sorted(table.items()):
        found = np.abs(np.array(rows))
        high = np.quantile(found[:, :3], 0.95, axis=0)
        held = (found[:, :3] <= found[:, 3:]).mean(axis=0)
        most = found[:, :3].max(axis=0)
        print(
            f"{kind:14s} {beads:4d} bonds, {len(rows):3d} strips: 95 % below "
            + " ".join(f"{100.0 * one:.4f}" for one in high)
            + " most " + " ".join(f"{100.0 * one:.4f}" for one in most)
            + " bars " + " ".join(f"{100.0 * one:.4f}" for one in np.median(found[:, 3:], axis=0))
            + " %; within the bar " + " ".join(f"{one:.0%}" for one in held)
        )  # fmt: skip


def main() -> None:
    wanted = sys.argv[1] if len(sys.argv) > 1 else ""
    if wanted in ("", "planned"):
        planned()
    if wanted in ("", "orders"):
        orders()
    if wanted in ("", "bars"):
        coverage(*map(int, sys.argv[2:]))


if __name__ == "__main__":
    main()
