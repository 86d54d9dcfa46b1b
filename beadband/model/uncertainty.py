"""What the inputs' errors do to an answer: their covariance, and the similarity that saves most of the runs.

Without a word of mechanics every input would take two runs. The rebound speed of a release depends on less:

* all times scale with sqrt(density), so d ln V/d ln density = -1/2 for every law;
* all stresses together scale V by their square root: the elasticities of E and of the law's moduli add up to 1/2;
* the width (of a rectangle: all of A at given EI/A) drops out, and the lengths h, Cb and the radius of a peg enter by
  their ratios alone;
* E, the thickness and the circumference enter, beside the law, through a_b = sqrt(EI/(density A)) over the size of the
  scene alone: one derivative by bending serves all three.

The curvature ratios are numbers without dimension, to which the first two give 0 for density and for the sum of the
moduli. :func:`basis` says which derivatives are left to run for, and :func:`elasticities` puts the others together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.model.bands import section_of
from beadband.model.scene import Scene, scene_of
from beadband.parameters import TABLE

Array = NDArray[np.float64]

BENDING = "bending_scale"
"""The derivative by EI that serves E, thickness and circumference."""
PEG = "tip_radius_m"
_SHAPE = ("width_m", "thickness_m", "wall_m", "area_m2", "second_moment_m4")


@dataclass(frozen=True)
class Inputs:
    """Inputs that have an error: names, values, and their covariance."""

    names: tuple[str, ...]
    """Keys of parameters; of a list of constants with the place in it, as in ``mu_pa[1]``."""
    values: Array
    """Shape (inputs,)."""
    covariance: Array
    """Shape (inputs, inputs), in the units of the values."""

    @property
    def errors(self) -> Array:
        """Standard uncertainties, shape (inputs,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def relative_covariance(self) -> Array:
        """Covariance of the logarithms of the values, shape (inputs, inputs)."""
        return self.covariance / np.outer(self.values, self.values)


def inputs_of(scene: Scene) -> Inputs | None:
    """Inputs of a scene that have an error; None where none has. UsageError for a covariance that can't be one."""
    errors = dict(scene.errors)
    constants = _constants(scene)
    own = dict(constants)
    names = [key for key in errors if key not in own and errors[key] > 0.0]
    values = scene.as_dict()
    plain = np.diag([errors[key] ** 2 for key in names])
    if scene.covariance:
        block = np.array(scene.covariance, dtype=np.float64)
        _check_covariance(block, [name for name, _ in constants], errors)
        law = [name for name, _ in constants]
    else:
        law = [name for name, _ in constants if errors.get(name, 0.0) > 0.0]
        block = np.diag([errors[name] ** 2 for name in law])
    if not names and not law:
        return None
    size = len(names) + len(law)
    covariance = np.zeros((size, size))
    covariance[: len(names), : len(names)] = plain
    covariance[len(names) :, len(names) :] = block
    numbers = [float(values[key]) for key in names] + [own[name] for name in law]
    if 0.0 in numbers:
        name = (*names, *law)[numbers.index(0.0)]
        raise UsageError(
            explain(f"{name} has an error but the value 0", "0", "another value", "leave the error out, or change it")
        )
    return Inputs((*names, *law), np.array(numbers), covariance)


def _constants(scene: Scene) -> list[tuple[str, float]]:
    """Constants of the law, one by one."""
    found: list[tuple[str, float]] = []
    for key, value in scene.material.values().items():
        if key not in TABLE or TABLE[key].kind not in ("number", "numbers"):
            continue
        many = isinstance(value, tuple)
        found += [(f"{key}[{i}]", v) for i, v in enumerate(value)] if many else [(key, value)]
    return found


def _check_covariance(block: Array, names: list[str], errors: Mapping[str, float]) -> None:
    wrong = ""
    if block.shape != (len(names), len(names)):
        wrong = f"a matrix of shape {block.shape} for {len(names)} constants"
    elif not np.isfinite(block).all() or not np.allclose(block, block.T, rtol=1e-6, atol=0.0):
        wrong = "a matrix that is not symmetric, or not finite"
    elif np.linalg.eigvalsh(block).min() < -1e-9 * abs(np.trace(block)):
        wrong = "a matrix with a negative eigenvalue"
    else:
        for i, name in enumerate(names):
            if name in errors and abs(math.sqrt(block[i, i]) - errors[name]) > 0.02 * errors[name]:
                wrong = f"a variance of {name} of {block[i, i]:.4g}, where its error is {errors[name]:.4g}"
    if wrong:
        raise UsageError(
            explain("the covariance of the law's constants is none", wrong, "symmetric, positive", "correct it")
        )


def changed(scene: Scene, changes: Mapping[str, float]) -> Scene:
    """The scene with some inputs changed, and with no errors; UsageError where it has no answer."""
    values = {**scene.as_dict()}
    for name, value in changes.items():
        key, _, place = name.partition("[")
        if place:
            listed = list(values[key])
            listed[int(place[:-1])] = value
            values[key] = tuple(listed)
        else:
            values[key] = value
    return scene_of(values)


def basis(scene: Scene, names: Sequence[str]) -> list[str]:
    """Derivatives that must be had by running, of those by ``names``; the rest follows by similarity."""
    if not _similar(scene):
        return list(names)
    moduli, others = _law_names(scene)
    wanted = [name for name in names if name in ("strain", "half_angle_deg", BENDING, PEG) or name in others]
    if "circumference_m" in names and scene.peg is not None and PEG not in wanted:
        wanted.append(PEG)
    touched = [name for name in names if name in moduli]
    whole = bool(touched) and len(touched) == len(moduli)
    by_shape = any(name in ("modulus_pa", "circumference_m") or name in _SHAPE for name in names if name not in moduli)
    if scene.bending_stiffness_n_m2 > 0.0 and BENDING not in wanted and (by_shape or (whole and _stated(scene))):
        wanted.append(BENDING)
    # Where all moduli are wanted, the last follows from the sum rule.
    return wanted + (touched[:-1] if whole else touched)


def elasticities(scene: Scene, names: Sequence[str], had: Mapping[str, float], total: float) -> Array:
    """d ln Q/d ln of each input, shape (names,), from those of :func:`basis`.

    ``total`` is the sum over all moduli: 1/2 for a speed, 0 for a number without dimension.
    """
    bending = had.get(BENDING, 0.0)
    moduli, _ = _law_names(scene)
    found = dict(had)
    for name in names:
        if name in found:
            continue
        if name == "density_kg_m3":
            found[name] = -total
        elif name == "circumference_m":
            found[name] = -2.0 * bending - had.get(PEG, 0.0)
        elif name in _SHAPE:
            found[name] = bending * _slenderness(scene, name)
        elif name == "modulus_pa" and name not in moduli:
            found[name] = bending if _stated(scene) else 0.0
        else:
            found[name] = total - sum(had[one] for one in moduli if one != name) - (bending if _stated(scene) else 0.0)
    return np.array([found[name] for name in names])


def _similar(scene: Scene) -> bool:
    """Whether the rules above hold: a loss time of the user's is another scale of time."""
    return scene.loss_time_s is None or "loss_time_s" in scene.planned


def _stated(scene: Scene) -> bool:
    """Whether EI has a modulus of its own, beside the law's."""
    return scene.bending_modulus == "table" and "modulus_pa" not in scene.material.values()


def _slenderness(scene: Scene, key: str) -> float:
    """d ln(I/A)/d ln of a size of the section, by central differences of closed forms."""
    step = 1e-5
    ends = []
    for sign in (-1.0, 1.0):
        values = scene.band.properties()
        values[key] *= math.exp(sign * step)
        section = section_of(values)
        ends.append(math.log(section.second_moment_m4 / section.area_m2))
    return (ends[1] - ends[0]) / (2.0 * step)


def _law_names(scene: Scene) -> tuple[list[str], list[str]]:
    """Constants of the law that are moduli, and those without dimension."""
    constants = [name for name, _ in _constants(scene)]
    moduli = [name for name in constants if TABLE[name.partition("[")[0]].unit == "Pa"]
    return moduli, [name for name in constants if name not in moduli]


LEAST_TOLERANCE, MOST_TOLERANCE = 1e-4, 0.05
_WORTH = 0.2
"""Share of the inputs' error that a numerical one may have before it is worth computing better."""


def with_auto_tolerance(scene: Scene) -> Scene:
    """The scene with a tolerance of a fifth of the inputs' error; UsageError where no input has one."""
    error = estimated_error(scene)
    if error is None or not error > 0.0:
        raise UsageError(
            explain(
                "a tolerance of auto needs inputs whose errors change V",
                "none" if error is None else "only errors that do not change the string limit of V",
                "a value with +/- on some input, or --inputs as-printed",
                "give errors, or a tolerance as a number",
            )
        )
    tolerance = min(max(_WORTH * error, LEAST_TOLERANCE), MOST_TOLERANCE)
    return replace(scene, tolerance=tolerance, auto_tolerance=False, input_share=error)


def estimated_error(scene: Scene) -> float | None:
    """Relative error of V from the inputs without a run: derivatives of the string limit, bending left out."""
    inputs = inputs_of(scene)
    if inputs is None:
        return None
    bare = replace(scene.unplanned(), errors=(), covariance=(), samples=0)
    step = 1e-4

    def speed(name: str, factor: float) -> float:
        if name == BENDING:
            return 0.0
        key, _, place = name.partition("[")
        value = bare.as_dict()[key]
        value = value[int(place[:-1])] if place else value
        return math.log(changed(bare, {name: value * factor}).string.rear_speed_m_s)

    had = {
        name: (speed(name, math.exp(step)) - speed(name, math.exp(-step))) / (2.0 * step)
        for name in basis(bare, inputs.names)
    }
    found = elasticities(bare, inputs.names, had, 0.5)
    return math.sqrt(max(float(found @ inputs.relative_covariance @ found), 0.0))
