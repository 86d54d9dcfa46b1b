"""Sobol' indices of V over Table 1: how far they scatter with the seed, and the same indices from runs alone.

    python tests/validation/design_indices.py [POINTS]

First the study of docs/design.md with 32 seeds: the scatter of every index over the half width of its interval. Then
the scenes of POINTS points (default 128) are released one by one, without the formula, and their indices compared with
those of the formula at the same scenes. Some minutes.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from beadband.analysis.sobol import indices
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import rear_runs
from beadband.runs.results import RearRun
from beadband.studies.design.ranges import box_of, spans, varied
from beadband.studies.design.sensitivity import sensitivity
from beadband.studies.design.values import evaluate, quantity_of
from beadband.studies.samples import unit_points

BANDS = ["I", "II", "III", "IV"]
VARY = {"strain": "0.2:0.8", "half_angle": "8:20"}
SEEDS = 32
BATCH = 48


def main(points: int) -> None:
    found = [sensitivity({}, vary=VARY, spanned=BANDS, seed=seed) for seed in range(SEEDS)]
    names = [one.option for one in found[0].ranges]
    for order in ("first", "total"):
        values = np.array([getattr(one.indices, order) for one in found])
        half = np.array([np.diff(getattr(one.indices, f"{order}_interval"))[:, 0] / 2.0 for one in found])
        scatter = values.std(axis=0, ddof=1)
        print(f"{order} order over {SEEDS} seeds: mean, standard deviation, half width of the interval")
        for row in zip(names, values.mean(axis=0), scatter, half.mean(axis=0), strict=True):
            print(f"  {row[0]:14s} {row[1]:8.4f} {row[2]:8.4f} {row[3]:8.4f}")

    box = box_of({"tolerance": 0.02}, [*varied(VARY), *spans(BANDS)])
    inputs = len(box.ranges)
    samples = unit_points("sobol", points, 2 * inputs, 0)
    places = np.repeat(samples[None, :, :inputs], inputs + 2, axis=0)
    places[1] = samples[:, inputs:]
    for at in range(inputs):
        places[2 + at, :, at] = samples[:, inputs + at]
    values = box.at(places.reshape(-1, inputs))
    formula = evaluate(values, quantity_of("speed")).value
    columns = {key: one for key, one in values.items() if isinstance(one, np.ndarray)}
    rest = {key: one for key, one in values.items() if key not in columns and key != "tolerance"}
    start, speeds, errors = time.perf_counter(), [], []
    with Session() as session:
        for first in range(0, len(formula), BATCH):
            rows = range(first, min(first + BATCH, len(formula)))
            scenes = [scene_of({**rest, **{key: one[at].item() for key, one in columns.items()}, "for": "speed"})
                      for at in rows]  # fmt: skip
            for run in rear_runs([plan_of(scene, "leg") for scene in scenes], session):
                assert isinstance(run, RearRun), run
                speeds.append(run.speed.value)
                errors.append(run.speed.error)
    ran = np.array(speeds)
    print(f"{len(ran)} runs in {time.perf_counter() - start:.0f} s; V by formula over V by runs, less 1: "
          f"median {np.median(np.abs(formula / ran - 1.0)):.2e}, largest {np.abs(formula / ran - 1.0).max():.2e}; "
          f"largest error of a run {np.max(np.array(errors) / ran):.2e}")  # fmt: skip
    both = []
    for speed in (formula, ran):
        by_sample = speed.reshape(inputs + 2, points)
        both.append(indices(by_sample[0], by_sample[1], by_sample[2:]))
    print("index by formula, by runs (first, total)")
    for at, name in enumerate(names):
        print(f"  {name:14s} {both[0].first[at]:8.4f} {both[1].first[at]:8.4f}   "
              f"{both[0].total[at]:8.4f} {both[1].total[at]:8.4f}")  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 128)
