"""Random scenes that the correction is fitted to and tried on: every shape of law, size of band, strain and angle."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from beadband.errors import BeadbandError
from beadband.model.scales import LONGEST_LAYER
from beadband.model.scene import Scene, scene_of
from beadband.model.validity import check_validity

Values = dict[str, Any]
Draw = Callable[[np.random.Generator], Values]

STRAIN = (0.04, 2.5)
HALF_ANGLE_DEG = (2.5, 42.0)
SLENDERNESS = (0.0006, 0.12)
"""Thickness over circumference: band IV is below 0.002, band I above 0.02."""
STATED_MODULUS = (0.35, 1.1)
"""Stated modulus E over that of the law at rest; it enters through EI alone."""
_CIRCUMFERENCE_M = 0.2
_SHEAR_PA = 0.4e6


def _uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def _linear(rng: np.random.Generator) -> Values:
    return {"law": "linear", "modulus_pa": 3.0 * _SHEAR_PA}


def _neo_hookean(rng: np.random.Generator) -> Values:
    return {"law": "neo-hookean", "mu_pa": _SHEAR_PA}


def _mooney_rivlin(rng: np.random.Generator) -> Values:
    share = _uniform(rng, -0.15, 1.1)
    return {
        "law": "mooney-rivlin",
        "c10_pa": 0.5 * _SHEAR_PA * (1.0 - share),
        "c01_pa": 0.5 * _SHEAR_PA * share,
    }


def _yeoh(rng: np.random.Generator) -> Values:
    c1 = 0.5 * _SHEAR_PA
    second, third = _uniform(rng, -0.12, 0.08), _log(rng, 1e-4, 0.05)
    return {"law": "yeoh", "c1_pa": c1, "c2_pa": c1 * second, "c3_pa": c1 * third}


def _gent(rng: np.random.Generator) -> Values:
    return {"law": "gent", "mu_pa": _SHEAR_PA, "jm": _log(rng, 2.0, 100.0)}


def _ogden(rng: np.random.Generator) -> Values:
    """One to three terms; the exponents of fits to rubber lie around 1.3, 5 and -2 (Treloar's data)."""
    first = _uniform(rng, 0.6, 3.0)
    alpha, weight = [first], [1.0]
    if rng.random() < 0.7:
        alpha.append(_uniform(rng, 3.0, 7.0))
        weight.append(_log(rng, 3e-4, 0.1))
    if rng.random() < 0.7:
        alpha.append(-_uniform(rng, 0.5, 3.0))
        weight.append(_log(rng, 0.003, 0.4))
    rest = sum(weight)
    mu = [2.0 * _SHEAR_PA * w / rest / a for w, a in zip(weight, alpha, strict=True)]
    return {"law": "ogden", "mu_pa": tuple(mu), "alpha": tuple(alpha)}


def _softened(rng: np.random.Generator) -> Values:
    """The unloading of a stretched virgin band: Ogden and Roxburgh's constants over another law."""
    primary = (_neo_hookean, _mooney_rivlin, _yeoh, _gent, _ogden)[int(rng.integers(5))](rng)
    return {
        **primary,
        "softening_r": _uniform(rng, 1.2, 4.0),
        "softening_m_pa": _log(rng, 0.05, 2.0) * _SHEAR_PA,
        "softening_beta": _uniform(rng, 0.0, 0.4),
    }


LAW_DRAWS: dict[str, tuple[float, Callable[[np.random.Generator], Values]]] = {
    "linear": (0.10, _linear),
    "neo-hookean": (0.06, _neo_hookean),
    "mooney-rivlin": (0.22, _mooney_rivlin),
    "yeoh": (0.18, _yeoh),
    "gent": (0.16, _gent),
    "ogden": (0.14, _ogden),
    "softened": (0.14, _softened),
}
"""Families of laws, each with its share of the scenes."""


def any_band(rng: np.random.Generator) -> Values:
    """Values of a scene with a band of any size and a law of any shape."""
    names = list(LAW_DRAWS)
    family = names[int(rng.choice(len(names), p=[LAW_DRAWS[name][0] for name in names]))]
    law = LAW_DRAWS[family][1](rng)
    values = {
        "band": f"drawn, {family}",
        "circumference_m": _CIRCUMFERENCE_M,
        "thickness_m": _CIRCUMFERENCE_M * _log(rng, *SLENDERNESS),
        "section": "circle",
        "density_kg_m3": 1000.0,
        "strain": _log(rng, *STRAIN),
        "half_angle_deg": _uniform(rng, *HALF_ANGLE_DEG),
        **law,
    }
    # The linear law is its own stated modulus: there the thickness alone changes EI.
    return values if family == "linear" else values | {"modulus_pa": 3.0 * _SHEAR_PA * _uniform(rng, *STATED_MODULUS)}


def catalogue_band(rng: np.random.Generator) -> Values:
    """Values of a scene like those of the catalogue: its bands, half of them with another thickness, and both laws."""
    values: Values = {
        "band": ("I", "II", "III", "IV", "circular")[int(rng.integers(5))],
        "law": ("mooney-rivlin", "linear")[int(rng.integers(2))],
        "strain": _uniform(rng, 0.1, 1.2),
        "half_angle_deg": _uniform(rng, 5.0, 30.0),
    }
    return values | ({"thickness_m": _uniform(rng, 0.5e-3, 3e-3)} if rng.random() < 0.5 else {})


def drawn(draw: Draw, count: int, seed: int) -> list[Scene]:
    """So many scenes of a draw that have an answer and a leg that can be run alone."""
    rng = np.random.default_rng(seed)
    found: list[Scene] = []
    while len(found) < count:
        try:
            scene = scene_of(draw(rng) | {"for": "curvature"})
            check_validity(scene)
            layer = scene.scales.bending_layer_m
        except BeadbandError:
            continue
        if layer <= LONGEST_LAYER * scene.wedge.reference_leg_m:
            found.append(scene)
    return found
