"""Bands whose law beadband has never seen, given by a tensile test alone, against runs that know the law.

    python tests/validation/held_out_bands.py [--noise 0.0]

Five rubbers of five laws that are not in the package, each a table of 30 points; for each, V and the windowed tip
curvature of a run on the table at a tolerance of 0.002 against a finer run on the law itself.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from beadband.analysis.fits import hann_mean
from beadband.lammps.engine import Session
from beadband.model.laws import Law, register
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import RearRun, rear_run

POINTS = 30
TOLERANCE = 0.002
_STEP = 1e-30


@dataclass(frozen=True)
class Rubber(Law):
    """A law of one function, its energy; stress and tangent by complex and central differences."""

    name = "held-out"
    which: str = "biderman"

    @classmethod
    def constants(cls) -> tuple[Any, ...]:
        """None that a user could give."""
        return ()

    def energy(self, stretch: Any) -> Any:
        return ENERGIES[self.which](stretch)

    def stress(self, stretch: Any) -> Any:
        shifted = np.asarray(stretch) + 1j * _STEP
        found = np.imag(ENERGIES[self.which](shifted)) / _STEP
        return float(found) if np.ndim(stretch) == 0 else found

    def tangent(self, stretch: Any) -> Any:
        return (self.stress(stretch + 1e-6) - self.stress(stretch - 1e-6)) / 2e-6


def invariants(s: Any) -> tuple[Any, Any]:
    """I1 and I2 less 3."""
    return s**2 + 2.0 / s - 3.0, 2.0 * s + 1.0 / s**2 - 3.0


def biderman(s: Any) -> Any:
    """I1 up to the third power, and I2 (Biderman 1958)."""
    one, two = invariants(s)
    return 1.5e5 * one + 4e4 * two - 1.2e3 * one**2 + 60.0 * one**3


def arruda_boyce(s: Any) -> Any:
    """Eight chains, five terms (Arruda and Boyce 1993), locking stretch 5."""
    first = invariants(s)[0] + 3.0
    weights = (0.5, 1.0 / 20.0, 11.0 / 1050.0, 19.0 / 7000.0, 519.0 / 673750.0)
    return 2.8e5 * sum(w / 25.0**k * (first ** (k + 1) - 3.0 ** (k + 1)) for k, w in enumerate(weights))


def fung(s: Any) -> Any:
    """Exponential (Fung 1967, Demiray 1972)."""
    return 3e5 / (2.0 * 0.06) * (np.exp(0.06 * invariants(s)[0]) - 1.0)


def gent_gent(s: Any) -> Any:
    """Gent's law with ln I2 (Pucci and Saccomandi 2002)."""
    one, two = invariants(s)
    return -0.5 * 2.4e5 * 40.0 * np.log(1.0 - one / 40.0) + 1.3e5 * np.log((two + 3.0) / 3.0)


def carroll(s: Any) -> Any:
    """I1, its fourth power and the root of I2 (Carroll 2011)."""
    one, two = invariants(s)
    return 1.5e5 * one + 3e-1 * ((one + 3.0) ** 4 - 81.0) + 9e4 * (np.sqrt(two + 3.0) - math.sqrt(3.0))


ENERGIES: dict[str, Callable[[Any], Any]] = {
    one.__name__: one for one in (biderman, arruda_boyce, fung, gent_gent, carroll)
}
BANDS: dict[str, dict[str, Any]] = {
    "biderman": {"circumference_m": 0.16, "width_m": 3.1e-3, "thickness_m": 1.2e-3, "density_kg_m3": 940.0,
                 "strain": 0.9, "half_angle_deg": 12.0},
    "arruda_boyce": {"circumference_m": 0.25, "width_m": 6e-3, "thickness_m": 1.6e-3, "density_kg_m3": 1050.0,
                     "strain": 1.6, "half_angle_deg": 9.0},
    "fung": {"circumference_m": 0.12, "width_m": 2e-3, "thickness_m": 1.5e-3, "density_kg_m3": 1100.0,
             "strain": 1.1, "half_angle_deg": 15.0},
    "gent_gent": {"circumference_m": 0.30, "width_m": 4e-3, "thickness_m": 1.0e-3, "density_kg_m3": 930.0,
                  "strain": 2.2, "half_angle_deg": 8.0},
    "carroll": {"circumference_m": 0.18, "width_m": 2.5e-3, "thickness_m": 2.0e-3, "density_kg_m3": 1200.0,
                "strain": 0.5, "half_angle_deg": 18.0},
}  # fmt: skip


def table(which: str, strain: float, noise: float, folder: Path) -> Path:
    """The tensile test of a rubber, to 1.2 times the strain."""
    stretch = 1.0 + 1.2 * strain * np.linspace(0.0, 1.0, POINTS)
    draws = np.random.default_rng(7).normal(size=POINTS)
    stress = Rubber(which).stress(stretch) * (1.0 + noise * draws)
    path = folder / f"{which}.csv"
    rows = "".join(f"{s:.6f},{1e-6 * p:.9f}\n" for s, p in zip(stretch, stress, strict=True))
    path.write_text(f"stretch,nominal_stress_mpa\n{rows}", encoding="utf-8")
    return path


def means(run: RearRun) -> list[float]:
    """Tip curvature at 0.1 and 0.3 of the front's arrival, each a mean under a Hann window."""
    arrival = run.plan.front_arrival_s
    rear = run.rear
    return [hann_mean(rear.times_s, rear.tip_curvature_1_m, at * arrival, 0.03 * arrival) for at in (0.1, 0.3)]


def compare(noise: float) -> list[tuple[str, float, float, float, float]]:
    """Name, error of V, its bar, and the errors of the two curvature means, all relative."""
    rows = []
    register(Rubber)
    with tempfile.TemporaryDirectory() as place, Session() as session:
        for which, values in BANDS.items():
            given = {"band": which, **values}
            csv = table(which, values["strain"], noise, Path(place))
            test = scene_of({**given, "law": "tensile", "file": str(csv), "tolerance": TOLERANCE})
            exact = scene_of({**given, "law": "tensile", "file": str(csv), "modulus_pa": test.band.modulus_pa})
            law = Rubber(which)
            exact = type(exact)(**{**{f: getattr(exact, f) for f in exact.__dataclass_fields__}, "material": law})
            found = rear_run(plan_of(test, "leg"), session)
            fine = rear_run(plan_of(exact.with_beads(2400), "leg"), session)
            error = found.speed.value / fine.speed.value - 1.0
            curved = [a / b - 1.0 for a, b in zip(means(found), means(fine), strict=True)]
            rows.append((which, error, found.relative_error, *curved))
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--noise", type=float, default=0.0)
    for name, error, bar, early, late in compare(parser.parse_args().noise):
        kept = "inside" if abs(error) <= bar else "OUTSIDE"
        print(
            f"{name:13s} V {error:+.3%}, bar {bar:.3%} ({kept}); curvature {early:+.2%} at 0.1, {late:+.2%} at 0.3 t_f"
        )
