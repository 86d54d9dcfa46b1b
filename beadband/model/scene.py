"""A scene: which band is pulled how far and how, by which law, and how well the answer must be known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from beadband import parameters
from beadband.errors import UsageError, explain
from beadband.model.bands import (
    PROPERTIES,
    SIZES,
    Band,
    as_printed,
    catalogue_values,
    known_values,
    made_band,
    read_bands,
)
from beadband.model.calibration import Strand
from beadband.model.hand import KEYS as HAND
from beadband.model.hand import Hand, hand_of
from beadband.model.laws import LAWS, Law, Linear, Softened, law_of
from beadband.model.wedge import StringLimit, Wedge, published_ratio, string_limit, strip_limit, wave_speeds, wedge_of
from beadband.parameters import AUTO, GIVEN, PLANNED, TABLE, UNUSED, checked, uncertain

if TYPE_CHECKING:
    from beadband.model.peg import Peg
    from beadband.model.scales import Scales


@dataclass(frozen=True)
class Scene:
    """A release, as asked for; None where the plan may choose.

    Build one with :func:`scene_of`, which checks it. Lengths in m, times in s, moduli in Pa.
    """

    band: Band
    material: Law
    """The law that the run follows."""
    strain: float
    half_angle_deg: float
    until: str
    tolerance: float
    purpose: str
    """What the plan must get right: "speed", or "curvature" with it."""
    bending_modulus: str
    bending_scale: float
    """Factor on EI: 0 leaves bending out."""
    finger: str
    """Of a launch: whether the finger stays, or is taken away once it carries nothing."""
    flight_s: float
    """Of a launch whose finger clears: time that the band flies on after its rear has come to the finger's place."""
    self_contact: str
    """Of a launch: whether parts of the band that meet push each other away, "on" or "off"."""
    elevation_deg: float | None
    """Of a launch: angle of the throw above the horizontal; None where no flight is computed."""
    height_m: float
    air_density_kg_m3: float
    drag_coefficient: float | None
    """Across the band; None for that of its section."""
    tip_radius_m: float = 0.0
    """Radius of the peg that holds the tip, to the middle of the band; 0 for a point."""
    hand_mass_kg: float | None = None
    hand_stiffness_n_m: float | None = None
    hand_damping_n_s_m: float | None = None
    hand_preload_n: float | None = None
    hand_velocity_m_s: float | None = None
    shape: str = "ring"
    """"ring", or "strip": one straight leg as long as the band, of half-angle 0 and without bending."""
    beads: int | None = None
    timestep_s: float | None = None
    loss_time_s: float | None = None
    frames: int | None = None
    """Frames of the whole ring after the first."""
    steps: int | None = None
    rear_steps: int | None = None
    """Steps between frames of the rear; ``steps`` and this one are the plan's, kept so that a run can be repeated."""
    planned: tuple[str, ...] = ()
    """Which of the values from ``beads`` on were chosen by a plan."""
    errors: tuple[tuple[str, float], ...] = ()
    """Standard uncertainties of inputs, by their keys."""
    covariance: tuple[tuple[float, ...], ...] = ()
    """Of the law's constants, in their order, those of a list one by one; empty where none was given."""
    samples: int = 0
    """Draws of the inputs, beside the derivatives."""
    auto_tolerance: bool = False
    """Whether the plan makes the tolerance of what the inputs' errors are worth."""
    input_share: float | None = None
    """Relative error of V from the inputs that a tolerance "auto" was made from."""

    def __repr__(self) -> str:
        return f"<Scene: band {self.label}, {self.held()}, {self.law}, until {self.until}>"

    def held(self, degrees: str = " deg") -> str:
        """How it is held, in words."""
        if self.is_strip:
            return f"strip, strain {self.strain:g}"
        return f"strain {self.strain:g}, half-angle {self.half_angle_deg:g}{degrees}"

    @property
    def is_strip(self) -> bool:
        """Whether it is a straight strip, not a band around a finger."""
        return self.shape == "strip"

    @property
    def legs(self) -> int:
        """Legs along which a front runs."""
        return 1 if self.is_strip else 2

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.material.name

    @property
    def half_angle_rad(self) -> float:
        return math.radians(self.half_angle_deg)

    @property
    def bending_stiffness_n_m2(self) -> float:
        """EI, from the stated E or from E0."""
        modulus = self.band.modulus_pa if self.bending_modulus == "table" else self.band.rest_modulus_pa
        return self.bending_scale * modulus * self.band.second_moment_m4

    @property
    def bending_diffusivity_m2_s(self) -> float:
        """a_b = sqrt(EI/(density A)); the same for any number of beads."""
        return self.strand(1).bending_diffusivity_m2_s

    @cached_property
    def hand(self) -> Hand | None:
        """Of a launch: the finger that moves; None where it stays."""
        return hand_of({key: getattr(self, key) for key in HAND})

    @cached_property
    def wedge(self) -> Wedge:
        """The string's wedge; a strip is one leg of it, without a finger."""
        if self.is_strip:
            length = self.band.circumference_m
            return Wedge((1.0 + self.strain) * length, length, 0.0)
        return wedge_of(self.band.circumference_m, self.strain, self.half_angle_rad)

    @cached_property
    def string(self) -> StringLimit:
        """The string limit, EI -> 0; of a strip the exact solution."""
        if self.is_strip:
            return strip_limit(self.material, self.band.density_kg_m3, self.strain)
        return string_limit(self.material, self.band.density_kg_m3, self.strain, self.half_angle_rad)

    @cached_property
    def peg(self) -> Peg | None:
        """Where the held band lies on its peg; None where it touches it with the tip alone."""
        from beadband.model.peg import peg_of

        return (
            peg_of(self.strand(1), self.strain, self.half_angle_rad, self.tip_radius_m) if self.tip_radius_m else None
        )

    @cached_property
    def scales(self) -> Scales:
        """Times and lengths that decide what can be measured, and how finely it must be computed."""
        from beadband.model.scales import scales_of

        return scales_of(self)

    @property
    def hysteresis_j(self) -> float:
        """Energy that the rubber keeps between loading and unloading, J; 0 for a law that unloads as it was loaded."""
        return self.material.lost_density_pa(1.0 + self.strain) * self.band.area_m2 * self.band.circumference_m

    @property
    def published_ratio(self) -> float:
        return float(published_ratio(self.strain, self.half_angle_rad))

    def wave_speeds(self, front_speed_m_s: float) -> dict[str, float]:
        """The three speeds that V is divided by, m/s (see :func:`beadband.model.wedge.wave_speeds`)."""
        return wave_speeds(self.band, front_speed_m_s, self.strain, self.half_angle_rad)

    def strand(self, beads: int) -> Strand:
        """What a chain of so many beads must be made of."""
        band = self.band
        return Strand(
            law=self.material,
            spacing_m=band.circumference_m / beads,
            area_m2=band.area_m2,
            density_kg_m3=band.density_kg_m3,
            modulus_pa=band.modulus_pa,
            bending_stiffness_n_m2=self.bending_stiffness_n_m2,
        )

    def with_beads(self, beads: int) -> Scene:
        """The same scene with another number of beads, and all that a plan chose for it left open again.

        A loss time of the user's is physics and stays; a numerical one goes with the mesh.
        """
        return replace(self.unplanned(), beads=beads)

    def unplanned(self, *keep: str) -> Scene:
        """The scene with its plan left open again, but for a loss time of the user's and what is named in ``keep``."""
        loss = None if "loss_time_s" in self.planned else self.loss_time_s
        plan: dict[str, Any] = {key: getattr(self, key) if key in keep else None for key in PLANNED}
        return replace(self, planned=(), **plan | {"loss_time_s": loss})

    def with_law(self, name: str) -> Scene:
        """The same scene under another law, with the constants that the catalogue has for its band.

        UsageError where it has none.
        """
        known = catalogue_values().get(self.band.name, {})
        return replace(self, material=law_of(name, {**known, **self.band.properties()}))

    @cached_property
    def label(self) -> str:
        """What the band is called: its name, and what was changed of the catalogue's band of that name."""
        known = catalogue_values().get(self.band.name)
        if known is None:
            return self.band.name
        known = {"section": "rectangle", **known}
        own = self.band.properties() | self.material.values()
        changed = [key for key, value in own.items() if known.get(key) not in (None, value)]
        if set(changed) >= {"circumference_m", "thickness_m"}:
            return f"of {_size('circumference_m', own)} circumference"
        # Constants of a law that the catalogue does not have for this band; a curve of many points has only its name.
        foreign = [key for key, value in self.material.values().items() if key not in known and value != 0.0]
        told = [key for key in foreign if TABLE[key].section != "record"]
        sizes = {key: f"{TABLE[key].option} {_size(key, own)}" for key in (*changed, *told)}
        law = [self.law, *(sizes[key] for key in told)] if foreign else []
        return ", ".join([self.band.name, *(sizes[key] for key in changed), *law])

    def as_dict(self) -> dict[str, Any]:
        """Every value by its key, as scene files and results have it; open choices are left out."""
        values: dict[str, Any] = {
            "band": self.band.name,
            "shape": self.shape,
            "strain": self.strain,
            "half_angle_deg": self.half_angle_deg,
            "law": self.law,
            "until": self.until,
            "tolerance": self.tolerance,
            "for": self.purpose,
            "bending_modulus": self.bending_modulus,
            "bending_scale": self.bending_scale,
            "tip_radius_m": self.tip_radius_m or None,
            "samples": self.samples or None,
            **{key: getattr(self, key) for key in PLANNED},
            "planned": list(self.planned) or None,
        }
        if self.until == "launch":
            flight = _FLIGHT if self.elevation_deg is not None else ()
            values.update({key: getattr(self, key) for key in ("finger", "flight_s", "self_contact", *HAND, *flight)})
        values |= self.band.properties() | self.material.values()
        unused = _OF_A_RING if self.is_strip else ()
        return {key: value for key, value in values.items() if value is not None and key not in unused}


def _size(key: str, values: Mapping[str, Any]) -> str:
    """A value as a person writes it: lengths in mm, moduli in MPa."""
    value, unit = values[key], TABLE[key].unit
    factor, name = {"m": (1e3, "mm"), "Pa": (1e-6, "MPa")}.get(unit, (1.0, unit))
    if unit == "m" and value >= 1.0:
        factor, name = 1.0, unit
    if isinstance(value, str):
        return value
    numbers = value if isinstance(value, tuple) else (value,)
    return " ".join([",".join(f"{factor * each:.4g}" for each in numbers), *([name] if name else [])])


_FLIGHT = ("elevation_deg", "height_m", "air_density_kg_m3", "drag_coefficient")
_PLAIN = (
    *("shape", "strain", "half_angle_deg", "until", "tolerance", "bending_modulus", "bending_scale", "tip_radius_m"),
    *("finger", "flight_s", "self_contact", *_FLIGHT),
    *HAND,
)
"""Parameters that are fields of a scene under the same name."""
MOST_ON_PEG = 0.3
"""Share of the reference leg that may lie on a peg: beyond, its end feels the finger before the speed is measured."""
_OF_A_RING = ("half_angle_deg", "bending_modulus", "bending_scale", "tip_radius_m", "for")
"""What a strip has no use for: its half-angle and bending are 0."""
_BESIDE = ("planned", "covariance")
"""Keys that no flag gives: they stand in files only."""
KEYS = (*TABLE, *_BESIDE)
"""Names under which :func:`scene_of` takes its values (those of laws that were registered later too)."""


def scene_of(values: Mapping[str, Any]) -> Scene:
    """Check the values of a scene, by the keys of the table of parameters, and put them together.

    UsageError for an unknown key, a value out of range, a value that this scene does not use, and a scene that has no
    answer.
    """
    given: dict[str, Any] = {}
    errors: dict[str, float] = {}
    for key, value in _with_band_file(values).items():
        if key not in TABLE and key not in _BESIDE:
            raise UsageError(explain("unknown scene option", repr(key), ", ".join(TABLE), "correct its name"))
        plain, error = uncertain(key, value) if key in TABLE else (value, None)
        if error is not None:
            errors[key] = error
        if plain is not None:
            given[key] = plain
    covariance = _matrix(given.pop("covariance", ()))
    full = {**parameters.defaults(), **given}
    planned = _planned(full.pop("planned", ()))
    for key in given.keys() - {"planned", "band"}:
        full[key] = checked(key, full[key])
    band, material = _band_and_law(given, full)
    rest: dict[str, Any] = {key: full.get(key) for key in (*_PLAIN, *PLANNED)}
    rest |= {"errors": tuple(sorted(errors.items())), "covariance": covariance, "samples": full["samples"]}
    if rest["tolerance"] == AUTO:
        rest |= {"tolerance": TABLE["tolerance"].default, "auto_tolerance": True}
    scene = Scene(band=band, material=material, planned=planned, purpose=full["for"], **rest)
    _refuse_unused(scene, given)
    hand_of(given)
    if scene.is_strip:
        scene = replace(scene, half_angle_deg=0.0, bending_scale=0.0, purpose="speed")
    _refuse_without_answer(scene)
    if scene.samples and not (errors or covariance or full["inputs"] == "as-printed"):
        allowed = "inputs with errors, as in --thickness '2.0e-3 +/- 5e-5', or --inputs as-printed"
        raise UsageError(explain("there is nothing to draw", f"--samples {scene.samples}", allowed, "add errors"))
    if full["inputs"] == "as-printed":
        scene = replace(scene, errors=tuple(sorted((printed_errors(scene) | errors).items())))
    return scene


def _with_band_file(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """The values with those of the band that was chosen from a file of bands, if there is one."""
    path = values.get("band_file")
    if path is None:
        return values
    bands = read_bands(checked("band_file", path))
    name = values.get("band") or (next(iter(bands)) if len(bands) == 1 else None)
    if name not in bands:
        raise UsageError(explain(f"unknown band in {path!r}", repr(name), ", ".join(bands), "change --band"))
    band = dict(bands[name])
    if band.get("modulus_pa") is None and band.get("law") in LAWS:
        plain = {key: uncertain(key, value)[0] if key in TABLE else value for key, value in band.items()}
        band["modulus_pa"] = law_of(band["law"], plain).rest_modulus_pa
    law = values.get("law")
    if law not in (None, band.get("law")):
        # Constants of the file's law mean nothing in another.
        band = {key: value for key, value in band.items() if key in PROPERTIES}
    return band | {key: value for key, value in values.items() if value is not None and key != "band_file"}


def printed_errors(scene: Scene) -> dict[str, float]:
    """Half a unit of the last printed digit of each number of a catalogue's band that the scene takes from it."""
    units, known = as_printed(scene.band.name), known_values(scene.band.name)
    own = scene.band.properties() | scene.material.values()
    return {key: 0.5 * unit for key, unit in units.items() if key in own and own[key] == known[key]}


def _band_and_law(given: Mapping[str, Any], full: Mapping[str, Any]) -> tuple[Band, Law]:
    """The band and the law of the run, from what was given and what the catalogue knows."""
    name = full["band"]
    if not isinstance(name, str):
        raise UsageError(explain("unknown band", repr(name), "a name", "change --band"))
    own = name not in catalogue_values() and {"circumference_m", "thickness_m"} <= given.keys()
    known = {} if own else known_values(name)
    if known and given.get("section") not in (None, known.get("section", "rectangle")):
        # Another shape: what the band of the catalogue has of the old one does not go with it.
        kept = known.keys() - set(SIZES) | {"circumference_m", "thickness_m"}
        known = {key: value for key, value in known.items() if key in kept}
    of_file = next(
        (TABLE[key].laws[0] for key in given if key in TABLE and TABLE[key].kind == "path" and TABLE[key].laws), None
    )
    law = given.get("law") or of_file or known.get("law") or full["law"]
    values = known | {
        key: full[key] for key in given if key in TABLE and (TABLE[key].section in ("band", "law") or TABLE[key].laws)
    }
    constants = dict(values)
    if law == "linear":
        constants.setdefault("modulus_pa", None)
    elif law in LAWS and known.get("law") != law:
        # Constants of the same name in another law mean something else.
        mine = {one.key for one in LAWS[law].constants()}
        constants = {key: value for key, value in constants.items() if key in given or key not in mine}
    material = law_of(law, constants)
    band = made_band(name, values, _rubber(material, known, values))
    _refuse_stiffness(material, known, given)
    return band, _released(material, given, 1.0 + full["strain"])


def _released(material: Law, given: Mapping[str, Any], held: float) -> Law:
    """The law of the unloading from the held stretch; UsageError for a softening that is incomplete or one too many."""
    unloading = material.released_from(held)
    r, m, beta = (given.get(key) for key in ("softening_r", "softening_m_pa", "softening_beta"))
    if r is None and m is None and beta is None:
        return unloading
    if r is None or not (m or beta):
        known = {"r": r, "m": m, "beta": beta}
        raise UsageError(
            explain(
                "the softening lacks a constant",
                ", ".join(f"{name} {value:g}" for name, value in known.items() if value is not None),
                "r, and m or beta above 0",
                "add --softening-r, and --softening-m or --softening-beta",
            )
        )
    if unloading is not material:
        raise UsageError(
            explain(
                "the unloading is given twice",
                "an unloading curve and --softening-r",
                "one of the two",
                "leave --tensile-unloading or --softening-r out",
            )
        )
    return Softened(material, held, r, m or 0.0, beta or 0.0)


def _rubber(material: Law, known: Mapping[str, Any], values: Mapping[str, Any]) -> Law:
    """The law that tells the modulus at rest.

    A linear law stands in for the rubber of the catalogue's band, as long as its modulus is that band's.
    """
    if isinstance(material, Linear) and known and values["modulus_pa"] == known["modulus_pa"]:
        return law_of(known["law"], known)
    return material


def _refuse_stiffness(material: Law, known: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Refuse constants that the law does not use, and a modulus that does not reach the stress."""
    mine = {one.key for one in material.inputs()}
    flags = " ".join(one.flag for one in material.inputs() if one.section != "record")
    for key in given:
        one = TABLE.get(key)
        other = one is not None and one.laws and one.section in ("law", "record")
        if one is None or not other or key in mine:
            continue
        wrong = f"{one.flag} is not used by the law {material.name}"
        value = f"{given[key]:g}" if isinstance(given[key], float) else f"{given[key]}"
        raise UsageError(explain(wrong, f"{one.flag} {value}", flags, "leave it out, or change --law"), UNUSED)
    modulus = given.get("modulus_pa")
    if known and modulus not in (None, known["modulus_pa"]) and not {"modulus_pa", *given} & mine:
        raise UsageError(
            explain(
                f"--modulus does not change the stress under the law {material.name}, only EI and C",
                f"--modulus {modulus:g} alone",
                f"--modulus with {flags}, or with --law linear",
                f"add {flags}, or --law linear",
            ),
            UNUSED,
        )


def _matrix(rows: Any) -> tuple[tuple[float, ...], ...]:
    """A covariance as a tuple of rows; UsageError for what is no square matrix of numbers."""
    try:
        found = tuple(tuple(float(each) for each in row) for row in rows)
    except (TypeError, ValueError):
        found = ((),)
    if any(len(row) != len(found) for row in found):
        raise UsageError(explain("the covariance is no matrix", repr(rows), "as many rows as columns", "correct it"))
    return found


def _planned(names: Any) -> tuple[str, ...]:
    if not isinstance(names, (list, tuple)) or not all(name in PLANNED for name in names):
        raise UsageError(
            explain("planned lists what is no choice of a plan", repr(names), ", ".join(PLANNED), "remove the line")
        )
    return tuple(names)


def _refuse_unused(scene: Scene, given: Mapping[str, Any]) -> None:
    """Refuse what was given and needs another value beside it to be used."""
    state = {"until": scene.until, "finger": scene.finger, "shape": scene.shape}
    state["elevation_deg"] = "missing" if scene.elevation_deg is None else GIVEN
    for one in (TABLE[key] for key in given if key in TABLE):
        for other, needed in (one.only or {}).items():
            # What says nothing may stand: the default, but for an angle, which a strip can't have.
            silent = getattr(scene, one.key) == one.default and one.key != "half_angle_deg"
            if state[other] != needed and not silent:
                partners = {key: f"{TABLE[key].flag} {word}" for key, word in (one.only or {}).items()}
                partners = {key: text.removesuffix(f" {GIVEN}") for key, text in partners.items()}
                wrong = f"without {partners[other]}" if needed == GIVEN else f"with {other} {state[other]}"
                raise UsageError(
                    explain(
                        f"{one.flag} is not used {wrong}",
                        f"{one.flag} {getattr(scene, one.key)}",
                        f"{' and '.join(partners.values())} with {one.flag}",
                        f"add {partners[other]}, or leave {one.flag} out",
                    ),
                    UNUSED,
                )
    if scene.is_strip and given.get("for") == "curvature":
        wrong, allowed = "a strip has no tip curvature to be right", "--for speed, or --shape ring"
        raise UsageError(explain(wrong, "--for curvature", allowed, "leave --for out"), UNUSED)
    if scene.bending_scale == 0.0 and scene.bending_modulus != TABLE["bending_modulus"].default:
        wrong, value = "--bending-modulus is not used without bending", f"{scene.bending_modulus} and --bending-scale 0"
        allowed, advice = "--bending-modulus with --bending-scale above 0", "leave one of the two out"
        raise UsageError(explain(wrong, f"--bending-modulus {value}", allowed, advice), UNUSED)
    if scene.bending_scale == 0.0 and scene.tip_radius_m > 0.0:
        wrong, value = "--tip-radius is not used without bending", f"{scene.tip_radius_m:g} m and --bending-scale 0"
        allowed, advice = "--tip-radius with --bending-scale above 0", "leave one of the two out"
        raise UsageError(explain(wrong, f"--tip-radius {value}", allowed, advice), UNUSED)
    if scene.tip_radius_m == 0.0 and dict(scene.errors).get("tip_radius_m"):
        wrong, allowed = "a tip held at a point has no radius to be uncertain", "a radius above 0 m with an error"
        value = f"--tip-radius 0 +/- {dict(scene.errors)['tip_radius_m']:g} m"
        raise UsageError(explain(wrong, value, allowed, "give the radius, or leave the error out"))


def _refuse_without_answer(scene: Scene) -> None:
    """Refuse what has no answer, with the number that decides."""
    if scene.elevation_deg is not None and scene.elevation_deg <= 0.0 and scene.height_m == 0.0:
        wrong, given = "there is no flight: the band is thrown at the ground", f"--elevation {scene.elevation_deg:g}"
        raise UsageError(explain(wrong, given, "above 0 without --height", "raise --elevation or --height"))
    closing = (1.0 + scene.strain) * math.sin(scene.half_angle_rad)
    if closing >= 1.0:
        raise UsageError(
            explain(
                "the wedge is too wide for its strain",
                f"(1 + strain) sin(half-angle) = {closing:.4g}",
                "below 1",
                "lower --strain or --half-angle",
            )
        )
    _refuse_strain(scene)
    peg, leg = scene.peg, scene.wedge.reference_leg_m
    if peg is not None and peg.wrapped_m > MOST_ON_PEG * leg:
        raise UsageError(
            explain(
                "too much of the leg lies on the peg",
                f"{peg.wrapped_m / leg:.3g} of it with --tip-radius {scene.tip_radius_m:g} m",
                f"at most {MOST_ON_PEG:g}",
                "lower --tip-radius",
            )
        )


def _refuse_strain(scene: Scene) -> None:
    """Refuse a strain at which the band can't be held."""
    longest, peak = scene.material.longest_stretch(), scene.material.peak_stretch()
    if longest is not None and 1.0 + scene.strain >= longest:
        raise UsageError(
            explain(
                f"band {scene.label} can't be held at this strain: {scene.material.ends_because} at a stretch of "
                f"{longest:.6g}",
                f"strain {scene.strain:g}",
                f"below {longest - 1.0:.6g}",
                "lower --strain or use another law",
            )
        )
    if peak is not None and 1.0 + scene.strain >= peak:
        raise UsageError(
            explain(
                f"band {scene.label} can't be held at this strain: its tension peaks at a stretch of {peak:.4g} "
                "and falls beyond it, where a uniform stretch is unstable",
                f"strain {scene.strain:g}",
                f"below {peak - 1.0:.4g}",
                "lower --strain or use --law linear",
            )
        )
