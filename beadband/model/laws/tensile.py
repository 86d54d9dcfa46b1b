"""A tensile test as the law: a monotone curve of continuous slope through its points, and one for the way back."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from beadband.errors import UsageError, explain
from beadband.model.laws.base import Law, constant
from beadband.model.laws.curve import Curve
from beadband.model.laws.registry import register
from beadband.model.roots import root
from beadband.parameters import Parameter

if TYPE_CHECKING:
    from beadband.model.laws.smoothing import Smoothed

MEETING = 0.05
"""Share by which loading and unloading stress at the held stretch may differ: the unloading curve is scaled by it."""
REACH = 0.02
"""Share of the held strain that an unloading curve may lack at its upper end."""
_CURVES = (("stretch", "nominal_stress_pa"), ("unloading_stretch", "unloading_stress_pa"))


@register
@dataclass(frozen=True)
class Tensile(Law):
    """A cubic curve through the knots of a smoothed tensile test; straight on below its first point.

    Beyond its last point a scene is refused; bonds that ring above it are continued with the slope there.
    """

    name = "tensile"
    ends_because = "its tensile test ends"
    table_error = 1e-4
    stretch: tuple[float, ...] = constant("", "", "stretches of the smoothed test", above=0.0, many=True)
    nominal_stress_pa: tuple[float, ...] = constant("", "Pa", "nominal stresses at those stretches", many=True)
    unloading_stretch: tuple[float, ...] = constant(
        "", "", "stretches of the smoothed unloading", above=0.0, many=True, default=()
    )
    unloading_stress_pa: tuple[float, ...] = constant(
        "", "Pa", "nominal stresses of the unloading", many=True, default=()
    )
    measured_from: float = constant("", "", "lowest measured stretch", above=0.0, default=1.0)
    smoothing: float = constant("", "", "strength of the smoothing", default=0.0)
    freedom: float = constant("", "", "degrees of freedom that the smoothing leaves the curve", default=0.0)
    scatter_pa: float = constant("", "Pa", "scatter of the points about the curve", default=0.0)

    @classmethod
    def constants(cls) -> tuple[Parameter, ...]:
        """Its numbers: they stand in files, and no flag gives them."""
        return tuple(replace(one, section="record") for one in super().constants())

    @classmethod
    def inputs(cls) -> tuple[Parameter, ...]:
        """The files, and the numbers that are made of them."""
        return (
            Parameter("file", "path", "tensile test, a CSV file", section="law", laws=(cls.name,), name="tensile",
                      metavar="FILE.csv"),
            Parameter("unloading", "path", "tensile test of the unloading from the held stretch, a CSV file",
                      section="law", laws=(cls.name,), name="tensile_unloading", metavar="FILE.csv"),
            *cls.constants(),
        )  # fmt: skip

    @classmethod
    def prepared(cls, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values with files read and smoothed into knots; UsageError for what is no curve."""
        made = dict(values)
        if made.get("file") is not None:
            made |= dict.fromkeys(_CURVES[1])  # those of an earlier test do not belong to this one
            found = _curve_of(made["file"], _stamp(made["file"]), False)
            made |= {
                "stretch": _plain(found.stretch),
                "nominal_stress_pa": _plain(found.stress_pa),
                "measured_from": found.measured_from,
                "smoothing": found.strength,
                "freedom": found.freedom,
                "scatter_pa": found.scatter_pa,
            }
        if made.get("unloading") is not None:
            found = _curve_of(made["unloading"], _stamp(made["unloading"]), True)
            made |= {"unloading_stretch": _plain(found.stretch), "unloading_stress_pa": _plain(found.stress_pa)}
        if made.get("stretch") is None:
            raise UsageError(
                explain("the law tensile has no test", "no file", "a CSV file", "add --tensile, or file to [law]")
            )
        for along, stress in _CURVES:
            if made.get(along):
                _check_knots(made[along], made.get(stress) or (), along, stress)
        if 1.0 not in made["stretch"] or made["nominal_stress_pa"][made["stretch"].index(1.0)] != 0.0:
            raise UsageError(
                explain("the tensile curve does not pass through rest", "no point (1, 0)", "stress 0 at stretch 1",
                        "add the point")
            )  # fmt: skip
        return made

    def values(self) -> dict[str, Any]:
        """Its numbers by their keys, those of a missing unloading left out."""
        return {key: value for key, value in super().values().items() if value != ()}

    @cached_property
    def _curve(self) -> Curve:
        return Curve(np.array(self.stretch), np.array(self.nominal_stress_pa))

    def energy(self, stretch: Any) -> Any:
        return self._curve.integral(stretch) - self._curve.integral(1.0)

    def stress(self, stretch: Any) -> Any:
        return self._curve.value(stretch)

    def tangent(self, stretch: Any) -> Any:
        return self._curve.derivative(stretch)

    def longest_stretch(self) -> float:
        """Just above the last stretch of the test, which a scene may be held at."""
        return self.stretch[-1] * (1.0 + 1e-9)

    def table_ends(self, held: float, shortest: float, longest: float) -> tuple[float, float]:
        """As asked for: bonds that ring above the test have the slope of its end."""
        return shortest, longest

    def released_from(self, stretch: float) -> Law:
        """The law of the unloading from a held stretch; UsageError where the two curves do not meet there."""
        known = self.unloading_stretch and stretch <= self.longest_stretch()
        return Unloading.of(self, stretch) if known else self


@dataclass(frozen=True)
class Unloading(Law):
    """The way back of a tensile test from the held stretch: elastic along the unloading curve, in both directions.

    Above the held stretch, and below its first point, it is continued with the slope there. Its energy is what the
    band gives back, zero where the unloading stress is; that stretch exceeds 1 where a permanent set is left.
    """

    loading: Tensile
    held: float
    """The held stretch, where both curves meet."""
    stretches: tuple[float, ...]
    stresses_pa: tuple[float, ...]
    name = "tensile"
    ends_because = Tensile.ends_because
    table_error = Tensile.table_error

    @classmethod
    def of(cls, loading: Tensile, held: float) -> Unloading:
        """The unloading of a test that was loaded to ``held``; UsageError where it begins elsewhere."""
        curve = Curve(np.array(loading.unloading_stretch), np.array(loading.unloading_stress_pa))
        if curve.x[-1] < held - REACH * (held - 1.0) or curve.x[0] >= held:
            raise UsageError(
                explain(
                    "the unloading curve does not reach the held stretch",
                    f"a held stretch of {held:.5g}, unloading from {curve.x[-1]:.5g}",
                    "an unloading that starts at the held stretch",
                    "change --strain, or measure the unloading from there",
                ),
                code="tensile-unloading",
            )
        up, down = float(loading.stress(held)), float(curve.value(held))
        if abs(down / up - 1.0) > MEETING:
            raise UsageError(
                explain(
                    "loading and unloading curve do not meet at the held stretch",
                    f"{up:.5g} Pa and {down:.5g} Pa at a stretch of {held:.5g}",
                    f"stresses within {MEETING:.0%} of each other",
                    "change --strain, or measure the unloading from there",
                ),
                code="tensile-unloading",
            )
        below = curve.x[curve.x < held - 1e-9]
        along = np.append(below, held)
        made = cls(loading, held, _plain(along), _plain(curve.value(along) * up / down))
        if made.lost_density_pa(held) < 0.0:
            raise UsageError(
                explain(
                    "the unloading curve gives back more energy than the loading curve takes",
                    f"{float(made.energy(held)):.5g} J/m3 of {float(loading.energy(held)):.5g} J/m3",
                    "an unloading curve below the loading curve",
                    "exchange --tensile and --tensile-unloading if they are swapped",
                ),
                code="tensile-unloading",
            )
        return made

    @cached_property
    def _curve(self) -> Curve:
        return Curve(np.array(self.stretches), np.array(self.stresses_pa))

    @cached_property
    def unstressed_stretch(self) -> float:
        """Where the unloading stress is zero: 1 and the permanent set."""
        curve = self._curve
        if curve.y[0] >= 0.0:  # straight on to zero
            return float(curve.x[0] - curve.y[0] / curve.slope[0])
        return root(lambda at: float(curve.value(at)), float(curve.x[0]), self.held)

    def values(self) -> dict[str, Any]:
        """Those of the whole test: the held stretch is the scene's."""
        return self.loading.values()

    def energy(self, stretch: Any) -> Any:
        return self._curve.integral(stretch) - self._curve.integral(self.unstressed_stretch)

    def stress(self, stretch: Any) -> Any:
        return self._curve.value(stretch)

    def tangent(self, stretch: Any) -> Any:
        return self._curve.derivative(stretch)

    def longest_stretch(self) -> float:
        """That of the loading: the held one is reached along it."""
        return self.loading.longest_stretch()

    def table_ends(self, held: float, shortest: float, longest: float) -> tuple[float, float]:
        """As asked for."""
        return shortest, longest

    def peak_stretch(self) -> float | None:
        """The loading's."""
        return self.loading.peak_stretch()

    def lost_density_pa(self, held: float) -> float:
        """Energy between loading and unloading curve up to the held stretch, J/m3."""
        return float(self.loading.energy(held) - self.energy(held))


def _stamp(path: str) -> tuple[int, int] | None:
    """Its hash, by which a changed file is recognised."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size


@lru_cache(maxsize=16)
def _curve_of(path: str, stamp: tuple[int, int] | None, unloading: bool) -> Smoothed:
    """The smoothed curve of a file: studies of many scenes read it once."""
    from beadband.model.laws.smoothing import smoothed
    from beadband.model.tensile_test import read_test

    return smoothed(read_test(path, unloading), from_rest=not unloading)


def _plain(numbers: Any) -> tuple[float, ...]:
    """Numbers to ten digits: more are noise, and a scene file holds them all. The ends stay as they are."""
    given = [float(each) for each in numbers]
    return (given[0], *(float(f"{each:.10g}") for each in given[1:-1]), given[-1])


def _check_knots(stretch: Any, stress: Any, along: str, beside: str) -> None:
    if len(stretch) != len(stress) or len(stretch) < 3 or not np.all(np.diff(stretch) > 0.0):
        raise UsageError(
            explain(
                "the tensile curve is malformed",
                f"{len(stretch)} numbers in {along}, {len(stress)} in {beside}",
                "three or more of each, with rising stretch",
                "correct them, or give the file",
            )
        )
