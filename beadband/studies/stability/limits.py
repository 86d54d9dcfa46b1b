"""The step limit measured: the largest stable step of many specimens by bisection, beside the predicted one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beadband.errors import BeadbandError
from beadband.model.calibration import Strand
from beadband.model.scene import scene_of
from beadband.studies.pool import Failed
from beadband.studies.stability import frozen, trials
from beadband.studies.verification.specimen import FIXED, FREE, Specimen, chain
from beadband.studies.verification.statics import circle

BOUND = 0.03
"""How far measured and predicted may be apart."""
_BONDS = 24
_STEPS, _LOSSY_STEPS = 2500, 9000  # a lossy chain grows slowly beyond its limit: by 2 (dt/dt_max - 1) a step
_RESPA_STEPS = 2000
RESPA_GROWTH = 1.0 + math.log(1e5) / _RESPA_STEPS  # what such a trial can tell from none
_INNER_STEPS = 4
_STRONG_LOSS_S = 2e-5
_LOSS_BEADS = 0.2  # as a plan has it: of the time in which a front goes from bead to bead

AXIAL, BENDING, TENSION, DASHPOT, CONTACT, RESONANCE = "axial", "bending", "tension", "dashpot", "contact", "resonance"
REGIMES = (AXIAL, BENDING, TENSION, DASHPOT, CONTACT, RESONANCE)


@dataclass(frozen=True)
class Point:
    """One specimen whose limit is measured."""

    band: str
    law: str
    beads: int
    """Of the whole ring: they set the spacing."""
    stretch: float
    loss: str = "none"
    """none, numerical (a plan's) or strong (20 microseconds)."""
    shape: str = "straight"
    """straight, bent (a ring at rest) or pressed against a finger."""
    form: str = "quartic"
    integrator: str = "verlet"
    turning_beads: int = 0
    """Beads of the bent ring."""
    finger: float = 0.0
    """Stiffness of the contact over that of a bond."""

    @property
    def name(self) -> str:
        parts = [f"band {self.band}", self.law, f"{self.beads} beads", f"stretch {self.stretch:g}", f"loss {self.loss}"]
        if self.shape == "bent":
            parts.append(f"turning {360.0 / self.turning_beads:.0f} deg, form {self.form}")
        if self.shape == "pressed":
            parts.append(f"contact {self.finger:g} bonds")
        if self.integrator != "verlet":
            parts.append(self.integrator)
        return ", ".join(parts)

    @property
    def loss_time_s(self) -> float:
        if self.loss == "none":
            return 0.0
        if self.loss == "strong":
            return _STRONG_LOSS_S
        # As a plan has it at a moderate strain: of the time from bead to bead of the front, in units of the table's E.
        strand = self.strand
        front = math.sqrt(strand.law.rest_modulus_pa / strand.density_kg_m3)
        return _LOSS_BEADS * strand.spacing_m * strand.density_kg_m3 * front / strand.modulus_pa

    @property
    def strand(self) -> Strand:
        return scene_of({"band": self.band, "law": self.law}).strand(self.beads)


@dataclass(frozen=True)
class Limit:
    """A measured limit beside the predicted one, s."""

    point: Point
    predicted_s: float
    measured_s: float
    regime: str
    failure: Failed | None = None
    """Why there is no measured one, if there is none."""

    @property
    def ratio(self) -> float:
        return self.measured_s / self.predicted_s

    @property
    def agrees(self) -> bool:
        """Whether measured and predicted limit are within :data:`BOUND`."""
        return abs(self.ratio - 1.0) <= BOUND

    def as_dict(self) -> dict[str, Any]:
        return {
            "specimen": self.point.name,
            "regime": self.regime,
            "predicted_s": self.predicted_s,
            "measured_s": self.measured_s if math.isfinite(self.measured_s) else None,
            "ratio": self.ratio if math.isfinite(self.ratio) else None,
            "reason": self.failure.reason if self.failure else "",
            "code": self.failure.code if self.failure else None,
        }


def points(quick: bool) -> list[Point]:
    """The specimens of the map."""
    return list(_quick() if quick else _full())


def _quick() -> Iterator[Point]:
    for law in ("linear", "mooney-rivlin"):
        for beads in (120, 2000):
            for stretch, loss in ((0.7, "none"), (1.0, "numerical"), (1.476, "none"), (2.4, "strong")):
                yield Point("III", law, beads, stretch, loss)
    yield from _special(quick=True)


def _full() -> Iterator[Point]:
    for band in ("I", "III", "IV"):
        for law in ("linear", "mooney-rivlin"):
            for beads in (60, 240, 520, 2000):
                for stretch in (0.6, 0.8, 1.0, 1.476, 2.4):
                    for loss in ("none", "numerical", "strong"):
                        yield Point(band, law, beads, stretch, loss)
    yield from _special(quick=False)


def _special(quick: bool) -> Iterator[Point]:
    for form in trials.FORMS:
        for turning in (12,) if quick else (8, 12, 24):
            for beads, loss in (
                ((2000, "none"),) if quick else ((400, "numerical"), (2000, "none"), (2000, "numerical"))
            ):
                # Near straight all forms are one; a bent ring tells them apart.
                yield Point("III", "mooney-rivlin", beads, 1.0, loss, "bent", form, turning_beads=turning)
    for finger in (0.5, 10.0) if quick else (0.1, 0.5, 2.0, 10.0, 100.0):
        for loss in ("none",) if quick else ("none", "numerical"):
            yield Point("III", "mooney-rivlin", 240, 1.2, loss, "pressed", finger=finger)
    # LAMMPS lets bonds be inside angles, not the other way round.
    for stretch in (1.476,) if quick else (1.0, 1.2, 1.476, 2.4):
        for beads in (240,) if quick else (60, 120, 240, 400):
            yield Point("III", "linear", beads, stretch, "none", integrator="rRESPA")


def predicted(point: Point) -> tuple[float, str]:
    """The exact limit of velocity Verlet (or rRESPA) for a specimen, s, and what sets it."""
    strand, loss = point.strand, point.loss_time_s
    if point.shape == "bent":
        ring = circle(strand, point.turning_beads)
        count = point.turning_beads
        model = frozen.Chain(strand, trials.FORMS[point.form], True, np.ones(count), np.ones(count, dtype=bool))
        step = frozen.largest_step_s(model, ring.points_m, loss)
        soft = frozen.largest_step_s(frozen.softened(model, 0.5), ring.points_m, loss)
        return step, BENDING if soft > 1.1 * step else _axial_regime(strand, 1.0, loss)
    modes = math.sin(0.5 * math.pi * (_BONDS - 1) / _BONDS) ** 2  # the shortest wave between held ends
    bond = float(strand.law.tangent(point.stretch)) * strand.area_m2 / strand.spacing_m
    mass = strand.bead_mass_kg
    if point.integrator != "verlet":
        return _respa(point, strand), RESONANCE
    damping = 2.0 * strand.dashpot_n_s_m(loss) / mass * modes
    along = 2.0 / (math.sqrt(max(4.0 * bond / mass * modes + damping**2, 0.0)) + damping) if bond > 0.0 else math.inf
    bending, tension = transverse_rate2(strand, point.stretch, modes)
    contact = point.finger * float(strand.law.rest_modulus_pa) * strand.area_m2 / strand.spacing_m / mass
    rate2 = bending + tension + contact
    across = 2.0 / math.sqrt(rate2) if rate2 > 0.0 and not _buckles(strand, point.stretch) else math.inf
    if along <= across:
        return along, _axial_regime(strand, point.stretch, loss)
    return across, max(((contact, CONTACT), (bending, BENDING), (tension, TENSION)))[1]


def _axial_regime(strand: Strand, stretch: float, loss_time_s: float) -> str:
    """Whether bonds or dashpots limit the step along the strand."""
    stiff = 4.0 * float(strand.law.tangent(stretch)) / (strand.density_kg_m3 * strand.spacing_m**2)
    return DASHPOT if (2.0 * strand.dashpot_n_s_m(loss_time_s) / strand.bead_mass_kg) ** 2 > stiff else AXIAL


def transverse_rate2(strand: Strand, stretch: float, modes: Any) -> tuple[Any, Any]:
    """w^2 of bending and of tension across a straight strand, for waves of sin^2(q/2) = ``modes``."""
    bending = (4.0 * strand.bending_diffusivity_m2_s / (strand.spacing_m**2 * stretch)) ** 2 * modes**2
    tension = 4.0 * float(strand.law.stress(stretch)) / (stretch * strand.density_kg_m3 * strand.spacing_m**2) * modes
    return bending, tension


def _buckles(strand: Strand, stretch: float) -> bool:
    """Whether a specimen under a push gives way sideways: then it is kept on its line."""
    longest = math.sin(0.5 * math.pi / _BONDS) ** 2
    bending, tension = transverse_rate2(strand, stretch, longest)
    return bool(bending + tension <= 0.0)


def _respa(point: Point, strand: Strand) -> float:
    """First step at which any mode of the specimen grows under rRESPA by what a trial can tell; bonds inside."""
    modes = np.sin(0.5 * math.pi * np.arange(1, _BONDS) / _BONDS) ** 2
    bending, tension = transverse_rate2(strand, point.stretch, modes)
    axial = 4.0 * float(strand.law.tangent(point.stretch)) / (strand.density_kg_m3 * strand.spacing_m**2) * modes
    zero = np.zeros_like(modes)
    inner, outer = np.concatenate([tension, axial]), np.concatenate([bending, zero])
    least = 2.0 / math.sqrt(float((inner + outer).max()))
    steps = least * np.geomspace(0.3, 1.5 * _INNER_STEPS, 6000)
    for step in steps:
        growth = frozen.respa_growth(outer, inner, 0.0 * outer, float(step), _INNER_STEPS)
        if growth.max() > RESPA_GROWTH:
            return float(step)
    return float(steps[-1])


def specimen_of(point: Point) -> tuple[Specimen, trials.Options, bool]:
    """The specimen, what acts on it, and whether it may move across its line."""
    strand, a = point.strand, point.strand.spacing_m
    if point.shape == "bent":
        ring = circle(strand, point.turning_beads)
        # The cutoff of the dashpots lies below the distance of fourth neighbours along the polygon.
        reach = float(np.hypot(*(ring.points_m[4 % point.turning_beads] - ring.points_m[0])))
        ring = replace(ring, cutoff_m=0.95 * reach, strain=0.3)
        return ring, trials.Options(trials.FORMS[point.form], loss_time_s=point.loss_time_s), True
    line = np.stack([a * point.stretch * np.arange(_BONDS + 1), np.zeros(_BONDS + 1)], axis=1)
    types = np.full(_BONDS + 1, FREE)
    types[[0, -1]] = FIXED
    strip = chain(strand, line, types, strain=max(point.stretch - 1.0, 0.3))
    strip = replace(strip, cutoff_m=3.8 * a * point.stretch)
    options = trials.Options(trials.FORMS[point.form], loss_time_s=point.loss_time_s)
    if point.shape == "pressed":
        # Force K d^2 at the depth d has the stiffness 2 K d; a depth of a tenth of a bond, borne by the load.
        depth = 0.1 * a
        wanted = point.finger * float(strand.law.rest_modulus_pa) * strand.area_m2 / a
        options = replace(
            options,
            finger_stiffness_pa=0.5 * wanted / depth,
            finger_centre_m=(0.0, depth),
            load_n=-0.5 * wanted * depth,
        )
    if point.integrator != "verlet":
        options = replace(options, integrator=f"respa 2 {_INNER_STEPS} bond 1 angle 2 pair 2")
    return strip, options, not _buckles(strand, point.stretch)


def measure(point: Point) -> Limit:
    """Bisect the limit of one specimen to 0.1 per cent."""
    step, regime = predicted(point)
    specimen, options, across = specimen_of(point)
    respa = point.integrator != "verlet"
    steps = _RESPA_STEPS if respa else _LOSSY_STEPS if point.loss != "none" else _STEPS

    def unstable(tried_s: float) -> bool:
        moved = replace(specimen, velocities_m_s=trials.shaken(specimen, tried_s, across))
        return trials.grows(moved, tried_s, steps, options)

    try:
        # A resonance may be narrower than the reach of the search: begin just within it.
        found = trials.bisect(unstable, step, reach=0.004 if respa else 0.03)
    except BeadbandError as error:
        return Limit(point, step, math.nan, regime, Failed.of(error))
    return Limit(point, step, found, regime)
