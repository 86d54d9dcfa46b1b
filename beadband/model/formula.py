"""Answers without a run, for many scenes at once: the exact string limit times the measured correction."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.model import correction
from beadband.model.laws import Law
from beadband.model.scales import FORGOTTEN_AFTER, WINDOW_BEFORE
from beadband.model.scene import Scene
from beadband.model.string_arrays import arrays_of, softens, string_limits, strip_limits
from beadband.model.validity import check_validity
from beadband.parameters import Parameter

Array = NDArray[np.float64]

VARIED = ("strain", "half_angle_deg", "circumference_m", "thickness_m", "width_m", "density_kg_m3")
"""Inputs that may be arrays: with one law they make scenes that share all else."""


STATED = "modulus_pa"
"""The stated E, which may be an array where EI is made of it."""
_EXACT = 1e-9
"""Relative error of an exact solution: of the search for its envelope, and of the integral over a fan."""


class Formula(NamedTuple):
    """Answers by formula; arrays of one shape."""

    value: Array
    error: Array
    """Bound that holds 98 % of the true errors, in the unit of the value; infinite where there is no correction."""


def formula(scene: Scene, quantity: str, varied: Mapping[str, Any] | None = None) -> Formula:
    """Answers for a scene, or for copies of it with other values of :data:`VARIED` (floats or arrays that broadcast).

    Copies of a scene with a peg are asked for one by one.

    "speed" is V in m/s, "curvature" the mean tip curvature in its window over that of Eq. 7. Constants of the law and
    the stated modulus may vary too, as far as :func:`varies_together` says. A strip has no bending: its formula is
    exact. UsageError where one of the scenes has no answer.
    """
    law, given = scenes_of(scene, varied or {})
    if scene.is_strip:
        exact = strip_limits(law, given["density_kg_m3"], given["strain"]).rear_speed_m_s
        return Formula(exact, (_EXACT if quantity == "speed" else math.inf) * exact)
    numbers, speed = _numbers(scene, law, given)
    shape = speed.shape
    found = (correction.speed_correction if quantity == "speed" else correction.curvature_correction)(numbers)
    value = (1.0 + found.delta.reshape(shape)) * (speed if quantity == "speed" else 1.0)
    inside = found.inside & (scene.peg is None)
    return Formula(value, np.where(inside, found.error, math.inf).reshape(shape) * np.abs(value))


def shares_law(scene: Scene) -> bool:
    """Whether the scene's law is the same for every held stretch, so that scenes of other strains may be made of it."""
    return type(scene.material).__name__ not in ("Softened", "Unloading")


def own_constants(scene: Scene) -> dict[str, Parameter]:
    """Constants of a scene's law by their keys; none of one that remembers its held stretch."""
    return {one.key: one for one in scene.material.constants()} if shares_law(scene) else {}


def varies_together(scene: Scene, varied: Mapping[str, Array]) -> bool:
    """Whether copies of a scene with these constants of its law are one evaluation of :func:`formula`.

    They are where EI has the stated modulus, and where every law softens up to its held strain: then all of them unload
    through one front, whose equation is the same for arrays of constants.
    """
    constants = [key for key in varied if key not in VARIED]
    own = {STATED, *(key for key, one in own_constants(scene).items() if one.kind == "number")}
    if not constants:
        return True
    if scene.is_strip or scene.bending_modulus != "table" or not shares_law(scene) or not own.issuperset(constants):
        return False
    try:
        given = _broadcast(scene, varied)
        law = _law_of(scene, given)
        return not arrays_of(law) or softens(law, given["strain"])
    except (TypeError, ValueError):
        return False  # a law of somebody's that takes no arrays for its constants


def _broadcast(scene: Scene, varied: Mapping[str, Any]) -> dict[str, Array]:
    """All of :data:`VARIED` that the scene has, and what else varies, as arrays of one shape."""
    own = {"strain": scene.strain, "half_angle_deg": scene.half_angle_deg, **scene.band.properties()}
    names = [key for key in VARIED if own.get(key) is not None or key in varied]
    names += [key for key in varied if key not in VARIED]
    arrays = np.broadcast_arrays(*(np.asarray(varied.get(key, own.get(key)), dtype=np.float64) for key in names))
    return dict(zip(names, arrays, strict=True))


def _law_of(scene: Scene, given: Mapping[str, Array]) -> Law:
    """The law, with arrays for those of its constants that vary."""
    constants = {key: given[key] for key in scene.material.values() if key in given}
    return replace(scene.material, **constants) if constants else scene.material  # type: ignore[type-var]


def answered(scene: Scene, varied: Mapping[str, Any]) -> NDArray[np.bool_]:
    """Which copies of a scene, varied as for :func:`formula`, have an answer at all."""
    found: NDArray[np.bool_] = room(scene, varied) > 0.0
    return found


def scenes_of(scene: Scene, varied: Mapping[str, Any]) -> tuple[Law, dict[str, Array]]:
    """The law, and what :data:`VARIED` and the other keys are for each scene; beside them the legs and angles.

    Arrays of one shape, with ``leg_m``, the reference leg, and ``half_angle_rad`` among them. UsageError where one of
    the scenes has no answer.
    """
    law, given = _described(scene, varied)
    refused = _room(scene, law, given) <= 0.0
    if np.any(refused):
        from beadband.model.scene import scene_of

        at = int(np.flatnonzero(refused)[0])
        changed = {key: float(given[key].ravel()[at]) for key in varied}
        check_validity(scene_of({**scene.as_dict(), **changed}))
        raise UsageError(explain("a scene has no answer", changed, "a wedge that can be held", "leave it out"))
    return law, given


def room(scene: Scene, varied: Mapping[str, Any]) -> Array:
    """How far scenes are from one without an answer: smooth, positive where there is one, else 0 or less."""
    return _room(scene, *_described(scene, varied))


def _described(scene: Scene, varied: Mapping[str, Any]) -> tuple[Law, dict[str, Array]]:
    given = _broadcast(scene, varied)
    phi = np.radians(given["half_angle_deg"])
    whole = given["circumference_m"]
    leg = whole if scene.is_strip else whole / (2.0 + np.tan(phi) * (math.pi + 2.0 * phi))
    return _law_of(scene, given), {**given, "leg_m": leg, "half_angle_rad": phi}


def _room(scene: Scene, law: Law, given: Mapping[str, Array]) -> Array:
    held, phi = 1.0 + given["strain"], given["half_angle_rad"]
    # A law that softens, as those of arrays do, carries more and more up to where its tangent is gone.
    carried = law.tangent(held) / law.tangent(1.0) if arrays_of(law) else longest_held(scene.material) - held
    found = np.minimum(1.0 - held * np.sin(phi), carried)
    if scene.bending_scale > 0.0:
        leg, thickness = given["leg_m"], given["thickness_m"]
        half = 0.5 * thickness / np.sqrt(held)
        found = np.minimum(found, np.minimum(held * leg * np.tan(phi) / half, leg / thickness) - 1.0)
    least: Array = np.asarray(found, dtype=np.float64)
    return least


@lru_cache(maxsize=256)
def longest_held(law: Law) -> float:
    """Stretch from which on a law can't be held: its tension peaks or it ends; infinite without."""
    peak, longest = law.peak_stretch(), law.longest_stretch()
    return min(math.inf if peak is None else peak, math.inf if longest is None else longest)


def section_of(scene: Scene, given: Mapping[str, Array]) -> Any:
    """The section of the scenes, its sizes arrays."""
    sizes: dict[str, Any] = {"thickness_m": given["thickness_m"], "width_m": given.get("width_m")}
    return replace(scene.band.section, **sizes)


def _numbers(scene: Scene, law: Law, given: Mapping[str, Array]) -> tuple[Array, Array]:
    """The features of :mod:`beadband.model.correction`, shape (scenes, features), and V of the string limits, m/s."""
    band, section = scene.band, section_of(scene, given)
    strain, phi, density, leg = (given[key] for key in ("strain", "half_angle_rad", "density_kg_m3", "leg_m"))
    string = string_limits(law, density, strain, phi)
    modulus = given.get(STATED, band.modulus_pa)
    stiffness = scene.bending_stiffness_n_m2 / band.second_moment_m4 * section.second_moment_m4
    stiffness = stiffness * (modulus / band.modulus_pa)
    diffusivity = np.sqrt(stiffness / (density * section.area_m2))
    held, behind = 1.0 + strain, 1.0 + string.residual_strain
    stress = np.asarray(law.stress(held), dtype=np.float64)
    arrival = leg / string.front_speed_m_s
    layer2 = stiffness / (section.area_m2 * stress * held)
    crossover = diffusivity * density * behind / string.residual_stress_pa
    bent = diffusivity > 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        forgotten = np.maximum(
            given["thickness_m"] / np.sqrt(modulus / density), FORGOTTEN_AFTER * layer2 / diffusivity
        )
    numbers = correction.features_of(
        strain=strain,
        half_angle_rad=phi,
        leg_m=leg,
        density_kg_m3=density,
        diffusivity_m2_s=diffusivity,
        front_speed_m_s=string.front_speed_m_s,
        mean_speed_ratio=string.mean_speed_ratio,
        residual_strain=string.residual_strain,
        residual_stress_pa=string.residual_stress_pa,
        held_stress_pa=stress,
        held_tangent_pa=law.tangent(held),
        residual_tangent_pa=law.tangent(behind),
        window_start_s=np.where(bent, forgotten, math.nan),
        window_end_s=np.where(bent, np.minimum(WINDOW_BEFORE * crossover, arrival), math.nan),
    )
    return numbers.reshape(-1, numbers.shape[-1]), string.rear_speed_m_s
