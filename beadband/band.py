"""Rubber bands: what one is made of, and the catalogue (Table 1 of the paper and its circular band)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from beadband.errors import UsageError, explain


@dataclass(frozen=True)
class Band:
    """A closed band in its unstretched state; SI units throughout.

    ``width_m`` is None for a circular section, whose ``thickness_m`` is the diameter. Bending happens in the plane
    of the ring, across the thickness.
    """

    name: str
    circumference_m: float
    width_m: float | None
    thickness_m: float
    density_kg_m3: float
    modulus_pa: float
    c10_pa: float
    c01_pa: float

    def __post_init__(self) -> None:
        for key, flag in _POSITIVE.items():
            value = getattr(self, key)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise UsageError(
                    explain(f"the band's {key} must be positive", value, "a finite number above 0", f"mend {flag}")
                )
        for key, flag in _FINITE.items():
            if not math.isfinite(getattr(self, key)):
                raise UsageError(
                    explain(f"the band's {key} must be finite", getattr(self, key), "any finite number", f"mend {flag}")
                )

    @property
    def section(self) -> str:
        return "circle" if self.width_m is None else "rectangle"

    @property
    def area_m2(self) -> float:
        if self.width_m is None:
            return math.pi / 4.0 * self.thickness_m**2
        return self.width_m * self.thickness_m

    @property
    def second_moment_m4(self) -> float:
        """Second moment of the section, I = b h^3/12 or pi d^4/64."""
        if self.width_m is None:
            return math.pi / 64.0 * self.thickness_m**4
        return self.width_m * self.thickness_m**3 / 12.0

    @property
    def mass_per_length_kg_m(self) -> float:
        """Mass of one metre of unstretched band."""
        return self.density_kg_m3 * self.area_m2

    @property
    def rest_modulus_pa(self) -> float:
        """E0 = 6 (C10 + C01), the Mooney-Rivlin modulus at rest; not the E of Table 1."""
        return 6.0 * (self.c10_pa + self.c01_pa)

    @property
    def bar_speed_m_s(self) -> float:
        """sqrt(E/density) with the table's E."""
        return math.sqrt(self.modulus_pa / self.density_kg_m3)

    @property
    def rest_speed_m_s(self) -> float:
        """sqrt(E0/density); UsageError when E0 is not positive."""
        if not self.rest_modulus_pa > 0.0:
            raise UsageError(
                explain(
                    "the band has no stiffness at rest",
                    f"C10 + C01 = {self.c10_pa + self.c01_pa:.4g} Pa",
                    "a positive sum",
                    "raise --c10 or --c01",
                )
            )
        return math.sqrt(self.rest_modulus_pa / self.density_kg_m3)


_POSITIVE = {
    "circumference_m": "--circumference",
    "width_m": "--width",
    "thickness_m": "--thickness",
    "density_kg_m3": "--density",
    "modulus_pa": "--modulus",
}
_FINITE = {"c10_pa": "--c10", "c01_pa": "--c01"}
PROPERTIES = tuple(_POSITIVE) + tuple(_FINITE)
"""Names of the properties of a band that a scene may override."""

# Table 1; C10 and C01 are printed without a unit and are MPa. The circular band: r = 0.8 mm, D = 64 mm.
CATALOGUE: dict[str, Band] = {
    band.name: band
    for band in (
        Band("I", 0.054, 1.2e-3, 1.1e-3, 800.0, 1.5e6, 0.069e6, 0.586e6),
        Band("II", 0.102, 13.0e-3, 1.7e-3, 1200.0, 1.1e6, 0.203e6, 0.046e6),
        Band("III", 0.204, 1.6e-3, 2.0e-3, 1300.0, 1.1e6, 0.187e6, 0.122e6),
        Band("IV", 0.914, 25.4e-3, 1.7e-3, 1100.0, 1.1e6, -0.024e6, 0.34e6),
        Band("circular", math.pi * 0.064, None, 1.6e-3, 1300.0, 1.1e6, 0.187e6, 0.122e6),
    )
}


def band_of(name: str, overrides: dict[str, float] | None = None) -> Band:
    """A band of the catalogue with some properties replaced; UsageError for a name or property it hasn't."""
    if name not in CATALOGUE:
        raise UsageError(
            explain("unknown band", repr(name), ", ".join(CATALOGUE), "choose one with --band (see 'beadband bands')")
        )
    band = CATALOGUE[name]
    changes = overrides or {}
    if band.width_m is None and changes.get("width_m") is not None:
        raise UsageError(
            explain(
                "a circular section has no width",
                f"--width {changes['width_m']}",
                "--thickness, its diameter",
                "leave --width out or choose another band",
            )
        )
    return replace(band, **changes) if changes else band  # type: ignore[arg-type]
