"""How often the stated 95 % regions of fitted constants hold the true ones.

    python tests/validation/fit_coverage.py [--draws 1000] [--points 40]

Tests of each law are made with a noise of 1 %, of the stress or of the largest one, and fitted again. With 1,000 draws
the share that is found has a standard error of 0.7 %.
"""

from __future__ import annotations

import argparse

import numpy as np

from beadband.model.fitting import Fit, Problem
from beadband.model.laws import Gent, Law, Linear, MooneyRivlin, NeoHookean, Ogden, Yeoh
from beadband.model.tensile_test import TensileTest

LAWS: dict[str, tuple[Law, float]] = {
    "linear": (Linear(1.1e6), 1.5),
    "neo-hookean": (NeoHookean(4e5), 2.5),
    "mooney-rivlin": (MooneyRivlin(1.87e5, 1.22e5), 2.5),
    "yeoh": (Yeoh(2e5, -4e3, 3e2), 5.0),
    "gent": (Gent(4e5, 30.0), 5.0),
    "ogden": (Ogden((6.3e5, 1.2e3), (1.3, 5.0)), 6.0),
}
"""Laws, and the stretch up to which they are tested."""


def drawn(law: Law, last: float, points: int, noise: str, random: np.random.Generator) -> TensileTest:
    """A test of a law with a noise of 1 %."""
    stretch = 1.0 + (last - 1.0) * np.arange(points + 1) / points
    stress = np.asarray(law.stress(stretch))
    size = stress if noise == "of the stress" else stress.max()
    noisy = stress + 0.01 * size * random.normal(size=len(stress))
    noisy[0] = 0.0
    return TensileTest("drawn", stretch, noisy, np.ones(len(stretch)))


def coverage(name: str, noise: str, draws: int, points: int = 40, seed: int = 0) -> tuple[float, float]:
    """Share of the draws whose joint region holds the constants, and mean share of the intervals that do."""
    law, last = LAWS[name]
    random = np.random.default_rng(seed)
    true = _values(law)
    terms = max((len(value) for value in law.values().values() if isinstance(value, tuple)), default=1)
    joint, alone = 0, 0.0
    for _ in range(draws):
        one = Problem(drawn(law, last, points, noise, random), type(law), terms).solve()
        assert isinstance(one, Fit), one
        joint += one.holds(true)
        low, high = one.interval_95().T
        alone += float(np.mean((low <= true) & (true <= high)))
    return joint / draws, alone / draws


def _values(law: Law) -> np.ndarray:
    return np.concatenate([np.atleast_1d(value) for value in law.values().values()]).astype(float)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=1000)
    parser.add_argument("--points", type=int, default=40)
    parser.add_argument("--law", nargs="+", default=list(LAWS))
    options = parser.parse_args()
    for name in options.law:
        for noise in ("of the stress", "of the largest stress"):
            joint, alone = coverage(name, noise, options.draws, options.points)
            print(f"{name:14s} 1 % {noise:22s} joint region {joint:.1%}, intervals {alone:.1%}", flush=True)


if __name__ == "__main__":
    main()
