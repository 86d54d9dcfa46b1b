"""Constants of every law from a tensile test, by least squares, with their covariance.

Most laws are linear in their moduli: for given dimensionless constants these follow at once. A grid of the others
gives the starts, from the best of which all constants are refined together. The noise of the test is taken as
constant, as proportional to the stress, or between the two, whichever makes the test most likely. Laws are compared
by the information criterion AICc (Hurvich and Tsai, Biometrika 76, 1989, 297).
"""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.model.laws import LAWS, Law
from beadband.model.laws.smoothing import smoothed
from beadband.model.tensile_test import TensileTest, read_test
from beadband.notices import Notice, notice
from beadband.parameters import Parameter

Array = NDArray[np.float64]

MOST_TERMS = 3
"""Terms up to which a law whose constants are lists is fitted."""
CONSTANT_SHARES = (0.3, 0.03, 0.003, 30.0)
"""Constant part of the noise, over that which is proportional to the stress, at the largest stress."""
_STARTS = (-5.0, -2.0, 0.03, 0.3, 1.3, 3.0, 8.0, 30.0, 200.0)
"""Values of constants without a unit from which the search starts, where their range allows them."""
_MOST_REFINED = 4
POOR = 0.02
"""Share of the stress beyond which the misfit at the stretches that matter is reported, if noise can't explain it."""
UNDETERMINED = 0.5
"""Relative standard error beyond which a constant counts as not determined by the test."""


@dataclass(frozen=True)
class Fit:
    """One law fitted to a test; arrays over its constants are in the order of ``names``."""

    law: Law
    names: tuple[str, ...]
    """Keys of the constants; of a list with the place in it, as in ``mu_pa[1]``."""
    values: Array
    """Shape (constants,)."""
    covariance: Array
    """Shape (constants, constants); that of the noise alone, whatever the law can't describe left out."""
    points: int
    scatter_pa: float
    """Standard deviation of the points about the law at the largest stress."""
    constant_share: float
    """Constant part of the noise over the proportional one."""
    relative_misfit: float
    """Root mean square of the misfit, each point over its stress; points below 2 % of the largest left out."""
    aicc: float
    notices: tuple[Notice, ...] = ()

    @property
    def label(self) -> str:
        """The law's name, with the number of its terms where it may have several."""
        lists = [value for value in self.law.values().values() if isinstance(value, tuple)]
        terms = len(lists[0]) if lists else 0
        return self.law.name if not terms else f"{self.law.name}, {terms} term{'s' if terms > 1 else ''}"

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the noise: points, less the constants and the shape of the noise itself."""
        return self.points - len(self.values) - 1

    @property
    def errors(self) -> Array:
        """Standard errors, shape (constants,)."""
        return np.sqrt(np.diag(self.covariance))

    def interval_95(self) -> Array:
        """Ends of the 95 % interval of each constant alone, shape (constants, 2)."""
        from scipy.stats import t

        reach = float(t.ppf(0.975, self.freedom)) * self.errors
        return np.stack([self.values - reach, self.values + reach], axis=1)

    def holds(self, values: Array) -> bool:
        """Whether the joint 95 % region holds these constants (F distribution)."""
        from scipy.stats import f

        apart = np.asarray(values) - self.values
        count = len(apart)
        return bool(apart @ np.linalg.solve(self.covariance, apart) <= count * f.ppf(0.95, count, self.freedom))

    def scene_values(self) -> dict[str, Any]:
        """The law for a scene: its name, its constants and their covariance."""
        return {"name": self.law.name, **self.law.values(), "covariance": self.covariance.tolist()}

    def as_dict(self) -> dict[str, Any]:
        """The fit as JSON takes it."""
        return {
            "law": self.law.name,
            "label": self.label,
            "constants": {key: list(v) if isinstance(v, tuple) else v for key, v in self.law.values().items()},
            "names": list(self.names),
            "errors": self.errors.tolist(),
            "covariance": self.covariance.tolist(),
            "interval_95": self.interval_95().tolist(),
            "rest_modulus_pa": self.law.rest_modulus_pa,
            "scatter_pa": self.scatter_pa,
            "relative_misfit": self.relative_misfit,
            "aicc": self.aicc,
            "warnings": [one.sentence for one in self.notices],
            "warning_codes": [one.code for one in self.notices],
        }


@dataclass(frozen=True)
class Fits:
    """All laws that were fitted to a test, the best by AICc first."""

    test: TensileTest
    strain: float
    """Strain up to which the fits are judged."""
    fits: tuple[Fit, ...]
    left_out: tuple[tuple[str, str], ...]
    """Laws that could not be fitted, each with the reason."""

    @property
    def best(self) -> Fit:
        return self.fits[0]

    @property
    def weights(self) -> Array:
        """Weight of each fit by AICc: how likely it is the best of these, shape (fits,)."""
        apart = np.array([fit.aicc for fit in self.fits]) - self.best.aicc
        likely = np.exp(-0.5 * apart)
        return np.asarray(likely / likely.sum(), dtype=np.float64)

    def __getitem__(self, label: str) -> Fit:
        """The best fit of a law, by its name, or one of its fits, by its label."""
        for fit in self.fits:
            if label in (fit.law.name, fit.label):
                return fit
        raise KeyError(label)

    def as_dict(self) -> dict[str, Any]:
        """The fits as JSON takes them."""
        rows = [fit.as_dict() | {"weight": float(w)} for fit, w in zip(self.fits, self.weights, strict=True)]
        return {
            "file": self.test.source,
            "points": len(self.test.stretch),
            "strain": self.strain,
            "fits": rows,
            "left_out": dict(self.left_out),
        }

    def __repr__(self) -> str:
        rows = (f"{fit.label}: misfit {fit.relative_misfit:.2%}, AICc {fit.aicc:.1f}" for fit in self.fits)
        return f"<Fits of {self.test.source!r}, best first:\n " + "\n ".join(rows) + ">"

    def _repr_html_(self) -> str:
        cells = "".join(
            f"<tr><td>{fit.label}</td><td>{fit.relative_misfit:.2%}</td><td>{fit.aicc - self.best.aicc:.1f}</td></tr>"
            for fit in self.fits
        )
        return f"<table><tr><th>law</th><th>misfit</th><th>AICc above the best</th></tr>{cells}</table>"


def fit(
    path: str | os.PathLike[str] | TensileTest,
    law: str | Sequence[str] | None = None,
    strain: float | None = None,
) -> Fits:
    """Fit laws to a tensile test.

    Parameters
    ----------
    path
        A CSV file as ``--tensile`` takes it, or a test that was read.
    law
        Names of laws; all registered ones but ``tensile`` if left out.
    strain
        Strain up to which a good fit matters, at most that of the test's last point, which is the default.

    Raises
    ------
    UsageError
        The file can't be used, a law is unknown, none can be fitted, or the strain lies beyond the test.
    """
    test = path if isinstance(path, TensileTest) else read_test(path)
    last = float(test.stretch[-1]) - 1.0
    if strain is not None and not 0.0 < strain <= last * (1.0 + 1e-9):
        raise UsageError(
            explain("the test does not reach the strain that matters", f"{strain:g}", f"above 0 and up to {last:.4g}",
                    "lower --strain, or measure further")
        )  # fmt: skip
    names = [law] if isinstance(law, str) else list(law or (name for name in LAWS if name != "tensile"))
    fits, left_out = [], []
    for name in names:
        if name not in LAWS or name == "tensile":
            known = ", ".join(one for one in LAWS if one != "tensile")
            raise UsageError(explain("no law that can be fitted", repr(name), known, "change --law"))
        for shape in _shapes(LAWS[name]):
            problem = Problem(test, LAWS[name], shape)
            found = problem.solve()
            if isinstance(found, str):
                left_out.append((problem.label, found))
            else:
                fits.append(found)
    if not fits:
        reasons = "; ".join(f"{name}: {why}" for name, why in left_out)
        raise UsageError(explain("no law can be fitted to this test", reasons, "more points", "measure more points"))
    mattering = last if strain is None else strain
    judged = [replace(one, notices=_judged(one, test, mattering)) for one in fits]
    return Fits(test, mattering, tuple(sorted(judged, key=lambda one: one.aicc)), tuple(left_out))


def _shapes(law: type[Law]) -> Iterator[int]:
    """Numbers of terms to try: one for a law of numbers, several for one of lists."""
    many = any(one.kind == "numbers" for one in law.constants())
    yield from range(1, MOST_TERMS + 1) if many else (1,)


class Problem:
    """The least squares of one law with a given number of terms."""

    def __init__(self, test: TensileTest, law: type[Law], terms: int) -> None:
        # The point at rest is met by every law.
        some = np.abs(test.stretch - 1.0) > 1e-9
        self.stretch, self.stress, self.repeats = test.stretch[some], test.stress_pa[some], test.repeats[some]
        self.law, self.terms = law, terms
        self.inputs: list[tuple[Parameter, str]] = []
        for one in law.constants():
            count = terms if one.kind == "numbers" else 1
            self.inputs += [(one, f"{one.key}[{i}]" if one.kind == "numbers" else one.key) for i in range(count)]
        self.moduli = [i for i, (one, _) in enumerate(self.inputs) if one.unit == "Pa"]
        self.pure = [i for i, (one, _) in enumerate(self.inputs) if one.unit != "Pa"]
        self.size = float(np.abs(self.stress).max() / np.ptp(test.stretch))

    @property
    def label(self) -> str:
        many = any(one.kind == "numbers" for one, _ in self.inputs)
        return f"{self.law.name}, {self.terms} terms" if many else self.law.name

    def made(self, values: Array) -> Law:
        """The law with these constants."""
        given: dict[str, Any] = {}
        for (one, _), value in zip(self.inputs, values.tolist(), strict=True):
            if one.kind == "numbers":
                given.setdefault(one.key, []).append(value)
            else:
                given[one.key] = value
        return self.law(**{key: tuple(v) if isinstance(v, list) else v for key, v in given.items()})

    def model(self, values: Array) -> Array | None:
        """Stresses at the test's stretches; None outside the law's range."""
        try:
            with np.errstate(all="ignore"):
                law = self.made(values)
                longest = law.longest_stretch()
                if longest is not None and longest <= float(self.stretch[-1]):
                    return None
                found = np.asarray(law.stress(self.stretch), dtype=np.float64)
        except (ValueError, ArithmeticError):
            return None
        return found if np.isfinite(found).all() else None

    def solve(self) -> Fit | str:
        """The best fit of all models of the noise, or why there is none."""
        count, points = len(self.inputs), len(self.stretch)
        if points < count + 3:
            return f"{count} constants for {points} points; {count + 3} are needed"
        found: list[Fit] = []
        for share in CONSTANT_SHARES:
            # The best constants hardly depend on the noise: those of one model of it start the next.
            one = self._fitted(share, [found[-1].values] if found else None)
            if one is not None:
                found.append(one)
        if not found:
            return "no constants in its range describe the test"
        return min(found, key=lambda one: one.aicc)

    def _noise(self, share: float) -> Array:
        """Noise of each point over that of the largest stress."""
        most = float(np.abs(self.stress).max())
        return np.asarray(
            np.sqrt((share**2 + (self.stress / most) ** 2) / (share**2 + 1.0)) / np.sqrt(self.repeats), dtype=np.float64
        )

    def _fitted(self, share: float, starts: list[Array] | None) -> Fit | None:
        from scipy.optimize import least_squares

        noise = self._noise(share)
        low, high = (np.array([getattr(one, end) for one, _ in self.inputs]) for end in ("above", "below"))
        scale = np.array([self.size if i in self.moduli else 1.0 for i in range(len(self.inputs))])
        most = float(np.abs(self.stress).max())

        def residual(scaled: Array) -> Array:
            stress = self.model(scaled * scale)
            if stress is None:
                return np.full(len(self.stress), 1e3)
            return (stress - self.stress) / (noise * most)

        best = None
        for start in self._starts(noise)[:_MOST_REFINED] if starts is None else starts:
            inside = np.clip(start / scale, low / scale + 1e-9, high / scale - 1e-9)
            x_scale = np.maximum(np.abs(inside), 1e-6)
            try:
                one = least_squares(residual, inside, bounds=(low / scale, high / scale), x_scale=x_scale, xtol=1e-13,
                                    ftol=1e-13, gtol=1e-13, max_nfev=400)  # fmt: skip
            except ValueError:
                continue
            if best is None or one.cost < best.cost:
                best = one
        if best is None or not best.cost < 1e5:
            return None
        values = best.x * scale
        if not self.made(values).rest_modulus_pa > 0.0:
            return None
        return self._stated(values, best.jac / scale, best.fun, noise, share)

    def _stated(self, values: Array, slopes: Array, residual: Array, noise: Array, share: float) -> Fit | None:
        points, count = len(residual), len(values)
        square = float(np.sum(residual**2))
        try:
            covariance = np.linalg.inv(slopes.T @ slopes) * square / (points - count - 1)
        except np.linalg.LinAlgError:
            return None
        free = count + 1  # the noise's size is estimated too
        unlikely = points * math.log(square / points + 1e-300) + 2.0 * float(np.sum(np.log(noise)))
        aicc = unlikely + 2.0 * free + 2.0 * free * (free + 1.0) / (points - free - 1.0)
        if not (np.isfinite(covariance).all() and (np.diag(covariance) > 0.0).all()):
            return None
        most = float(np.abs(self.stress).max())
        large = np.abs(self.stress) > 0.02 * most
        apart = (residual * noise * most / self.stress)[large]
        return Fit(
            self.made(values),
            tuple(name for _, name in self.inputs),
            values,
            0.5 * (covariance + covariance.T),
            points,
            most * math.sqrt(square / (points - count - 1)),
            share,
            float(np.sqrt(np.mean(apart**2))),
            aicc,
        )

    def _starts(self, noise: Array) -> list[Array]:
        """Constants to start from, the best first: moduli by linear least squares for a grid of the others."""
        grids = []
        for i in self.pure:
            one = self.inputs[i][0]
            grids.append([value for value in self._candidates(one) if one.above < value < one.below])
        found = []
        for point in itertools.product(*grids):
            if any(one == other for one, other in itertools.pairwise(point)) or list(point) != sorted(point):
                continue
            values = np.zeros(len(self.inputs))
            values[self.pure] = point
            columns = []
            for i in self.moduli:
                unit = values.copy()
                unit[i] = self.size
                columns.append(self.model(unit))
            if any(column is None for column in columns):
                continue
            matrix = np.stack([np.asarray(column) for column in columns], axis=1) / noise[:, None]
            share, *_ = np.linalg.lstsq(matrix, self.stress / noise, rcond=1e-12)
            values[self.moduli] = share * self.size
            misfit = float(np.sum((matrix @ share - self.stress / noise) ** 2))
            found.append((misfit, values))
        return [values for _, values in sorted(found, key=lambda one: one[0])]

    def _candidates(self, one: Parameter) -> list[float]:
        """Values of a constant without a unit; those of a limit begin just beyond what the test reaches."""
        most = float(self.stretch[-1]) ** 2 + 2.0 / float(self.stretch[-1]) - 3.0
        return sorted({*_STARTS, *(most * factor for factor in (1.02, 1.2, 2.0, 5.0, 30.0))})


def _judged(one: Fit, test: TensileTest, strain: float) -> tuple[Notice, ...]:
    """What a user of this fit should know."""
    found = []
    relative = one.errors / np.abs(one.values)
    for name, share in zip(one.names, relative, strict=True):
        if share > UNDETERMINED:
            found.append(notice("fit-undetermined", name=name, value=float(share)))
    peak = one.law.peak_stretch()
    last = float(test.stretch[-1])
    if peak is not None and peak < last:
        found.append(notice("fit-peak", value=peak, limit=last))
    curve = smoothed(test)
    at = np.linspace(1.0 + 0.5 * strain, 1.0 + strain, 21)
    measured = np.interp(at, curve.stretch, curve.stress_pa)
    apart = np.asarray(one.law.stress(at)) / measured - 1.0
    worst = int(np.argmax(np.abs(apart)))
    noise = 3.0 * curve.scatter_pa / float(curve.stress_pa.max())
    if abs(apart[worst]) > max(POOR, noise):
        found.append(notice("fit-poor", value=float(apart[worst]), stretch=float(at[worst]), limit=max(POOR, noise)))
    return tuple(found)
