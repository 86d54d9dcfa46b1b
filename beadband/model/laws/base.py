"""What a material law is: energy, nominal stress and tangent of a strand in uniaxial tension, and how it unloads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, field, fields
from typing import Any, ClassVar

import numpy as np

from beadband.model.laws import unloading
from beadband.model.laws.unloading import UnloadingWave
from beadband.model.roots import root
from beadband.parameters import Parameter

# Stretches scanned for a tension peak; rubber breaks well before the upper end.
_SCAN_UP_TO = 12.0
_SCAN_STEP = 0.01
_SECTIONS = 40
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def constant(
    symbol: str,
    unit: str,
    help: str,
    *,
    above: float = -math.inf,
    below: float = math.inf,
    many: bool = False,
    default: Any = MISSING,
) -> Any:
    """A constant of a law, as a field of its class: symbol, unit, one line of help, and the open ends of its range.

    ``many`` lets it be a list; one with a ``default`` may be left out. The field's name is the key in
    scene files, with the unit (``mu_pa``); the flag is that
    name without it (``--mu``).
    """
    about = {"symbol": symbol, "unit": unit, "help": help, "above": above, "below": below, "many": many}
    return field(default=default, metadata=about)


class Law:
    """One uniaxial law; stretches are dimensionless, stresses (nominal) and energies in Pa = J/m3.

    A subclass is a frozen dataclass whose fields are its constants (:func:`constant`). It has a ``name``, an
    ``expression`` of its energy for LAMMPS, and ``energy``, ``stress`` and ``tangent`` written with plain arithmetic,
    so that floats and numpy arrays both pass.
    """

    name: ClassVar[str]
    expression: ClassVar[str] = ""
    """Energy density in Pa as LAMMPS writes it: a formula in ``s``, the stretch, with {constants} in braces."""
    ends_because: ClassVar[str] = "its law ends"
    """Why there is no stretch beyond :meth:`longest_stretch`, as in "its law locks"."""
    table_error: ClassVar[float] = 1e-6
    """Largest error of the force between the points of its bond table, over the force itself or the held one."""

    one_formula: ClassVar[bool] = True
    """Whether one smooth formula holds for all stretches, however far the strand was stretched."""

    @classmethod
    def constants(cls) -> tuple[Parameter, ...]:
        """Its constants, as the table of parameters has them."""
        return tuple(
            Parameter(
                key=one.name,
                kind="numbers" if one.metadata["many"] else "number",
                help=one.metadata["help"],
                symbol=one.metadata["symbol"],
                unit=one.metadata["unit"],
                section="law",
                above=one.metadata["above"],
                below=one.metadata["below"],
                laws=(cls.name,),
                metavar=one.metadata["unit"].upper() or "X",
            )
            for one in fields(cls)  # type: ignore[arg-type]
        )

    @classmethod
    def inputs(cls) -> tuple[Parameter, ...]:
        """What a scene may give for it: its constants, and what :meth:`prepared` makes them of."""
        return cls.constants()

    @classmethod
    def prepared(cls, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Values with the constants that are made of other inputs put in."""
        return values

    def released_from(self, stretch: float) -> Law:
        """The law of a strand that unloads from a held stretch; most laws are the same both ways."""
        return self

    def lost_density_pa(self, held: float) -> float:
        """Energy that the material keeps on the way up to ``held`` and back, J/m3."""
        return 0.0

    def values(self) -> dict[str, Any]:
        """Its constants by their keys."""
        return {one.name: getattr(self, one.name) for one in fields(self)}  # type: ignore[arg-type]

    def lammps_expression(self) -> str:
        """Energy density in Pa as an expression of the stretch ``s``, numbers to their last digit.

        ValueError for a law that states none: LAMMPS then takes it as a table.
        """
        if not self.expression:
            raise ValueError(f"the law {self.name} has no expression for LAMMPS")
        return self.expression.format(**{key: f"({value:.17g})" for key, value in self.values().items()})

    def energy(self, stretch: Any) -> Any:
        """Strain energy density W, zero at stretch 1."""
        raise NotImplementedError

    def stress(self, stretch: Any) -> Any:
        """Nominal stress dW/dstretch."""
        raise NotImplementedError

    def tangent(self, stretch: Any) -> Any:
        """Tangent modulus d(stress)/dstretch."""
        raise NotImplementedError

    @property
    def rest_modulus_pa(self) -> float:
        """Tangent modulus of the unstretched material."""
        return float(self.tangent(1.0))

    @property
    def unstressed_stretch(self) -> float:
        """Stretch without stress: above 1 where a permanent set is left."""
        return 1.0

    def longest_stretch(self) -> float | None:
        """Stretch in tension that the law can't reach; None where it has no such limit."""
        return None

    def shortest_stretch(self) -> float | None:
        """The same in compression, below 1; None where it has no such limit."""
        return None

    def table_ends(self, held: float, shortest: float, longest: float) -> tuple[float, float]:
        """Ends of a bond table around the held stretch, asked for from ``shortest`` to ``longest``.

        They keep half of the way to the longest stretch of the law, and a tenth of that to the shortest.
        """
        above, below = self.longest_stretch(), self.shortest_stretch()
        if above is not None:
            longest = min(longest, 0.5 * (held + above))
        if below is not None:
            shortest = max(shortest, below + 0.1 * (1.0 - below))
        return shortest, longest

    def peak_stretch(self) -> float | None:
        """Stretch at which the tension first stops to rise, or None below a stretch of 12.

        Beyond it a uniformly held stretch is refused: where the tension falls it is unstable. Where it rises again, as
        that of a Yeoh law with a dip may, a band would have come through two stretches side by side, and what it is
        held by need not be uniform.
        """
        above = self.longest_stretch()
        steps = int((min(_SCAN_UP_TO, above or _SCAN_UP_TO) - 1.0) / _SCAN_STEP)
        stretches = 1.0 + _SCAN_STEP * np.arange(steps + 1)
        if above is not None:
            stretches = stretches[stretches < above]
        tangents = self.tangent(stretches)
        falling = np.flatnonzero(tangents <= 0.0)
        first = int(falling[0]) if len(falling) else len(stretches)
        # A tension that falls over less than a step: at the bottom of a dip of the tangent.
        dips = 1 + np.flatnonzero((tangents[1:-1] < tangents[:-2]) & (tangents[1:-1] <= tangents[2:]))
        for dip in dips[dips < first]:
            bottom = self._bottom(float(stretches[dip - 1]), float(stretches[dip + 1]))
            if self.tangent(bottom) <= 0.0:
                return root(self.tangent, float(stretches[dip - 1]), bottom)
        if first == len(stretches):
            return None
        return root(self.tangent, float(stretches[first - 1]), float(stretches[first])) if first else 1.0

    def _bottom(self, low: float, high: float) -> float:
        """Stretch of the least tangent between two others (golden section)."""
        for _ in range(_SECTIONS):
            span = _GOLDEN * (high - low)
            if self.tangent(high - span) < self.tangent(low + span):
                high = low + span
            else:
                low = high - span
        return 0.5 * (low + high)

    def stretch_at(self, stress_pa: float, at_most: float) -> float:
        """Stretch that carries a nominal stress between 0 and that of ``at_most`` (Newton, bracketed)."""
        low, high = 1.0, at_most
        stretch = 1.0 + (at_most - 1.0) * stress_pa / float(self.stress(at_most))
        for _ in range(100):
            excess = float(self.stress(stretch)) - stress_pa
            if excess > 0.0:
                high = stretch
            else:
                low = stretch
            step = excess / float(self.tangent(stretch))
            stretch -= step
            if abs(step) <= 1e-15 * stretch:
                break
            if not low <= stretch <= high:
                stretch = 0.5 * (low + high)
        return stretch

    def unloading_wave(self, ahead: float, behind: float, density_kg_m3: float) -> UnloadingWave:
        """The wave that takes the stretch from ``ahead`` down to ``behind`` in a strand at rest.

        The admissible wave runs along the lower convex envelope of the stress between the two stretches: a concave
        law (Mooney-Rivlin) gives one shock along the chord, a stiffening one a fan along the curve itself, and one
        that softens before it stiffens a fan with a shock behind it.
        """
        return unloading.unloading_wave(self, ahead, behind, density_kg_m3)
