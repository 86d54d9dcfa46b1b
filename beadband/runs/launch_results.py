"""Results of a launch: everything of a release's, and what the finger and the flight add."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from beadband.analysis.contact import LaunchMeasurement
from beadband.analysis.convergence import plain_error
from beadband.analysis.energy import LaunchBalance
from beadband.analysis.fits import Array, Measured
from beadband.analysis.hand import HandMeasurement
from beadband.analysis.readers import Overlaps, Watch
from beadband.notices import Notice, notice
from beadband.planning.launch_plan import DEPTH_BOUND, LaunchPlan
from beadband.planning.self_contact import OVERLAP_BOUND
from beadband.runs.checks import Check, momentum_limit
from beadband.runs.flight import Throw, throw_of
from beadband.runs.hand import HandRun
from beadband.runs.results import NoEstimate, Run, known_fields
from beadband.statics.finger import Support

LEAST_ORDER = 0.8
"""Order of convergence of a launch that is taken for granted: the least that was measured, of the linear law."""
SCATTER = 0.005
"""Relative error of the throw, at least: a band that rattles on its finger leaves it so differently with another number
of beads (twice the root of the mean square over 34 scenes), and its freedom is uncertain by as much."""
WEIGHTS = {"efficiency": 2.0, "rear_arrival_s": 0.25}
"""The same of the other figures over that of the throw, where it is not 1."""
ASIDE_SHARE = 0.01
"""Distance of the rear from the axis, over the thickness, above which there is a notice."""


@dataclass(frozen=True)
class LaunchEstimate:
    """The same launch with another number of beads, from which errors are judged."""

    beads: int
    centre_of_mass_speed_m_s: float | None = None
    efficiency: float | None = None
    momentum_n_s: float | None = None
    finger_free_s: float | None = None
    last_load_s: float | None = None
    rear_arrival_s: float | None = None
    pause_s: float | None = None
    hand: HandMeasurement | None = None

    @classmethod
    def of(cls, beads: int, found: LaunchMeasurement, hand: HandMeasurement | None = None) -> LaunchEstimate:
        """From what a launch with so many beads found."""
        return cls(beads, **{name: getattr(found, name) for name in _COMPARED}, hand=hand)


_COMPARED = tuple(one.name for one in fields(LaunchEstimate) if one.name not in ("beads", "hand"))


@dataclass(frozen=True, kw_only=True, repr=False)
class Launch(Run):
    """A finished launch: a release that goes on until the rear reaches the finger."""

    energy: LaunchBalance
    launch_plan: LaunchPlan
    support: Support
    watch: Watch
    found: LaunchMeasurement
    clearance_m: Array
    """Shape (lines,): from the rear tip to the finger's surface, along the axis."""
    crossings_s: Array
    """Times of the frames in which the band crosses itself, which beads do and bands don't."""
    overlaps: Overlaps | None
    """Of parts of the band that touch each other; None without contact between them."""
    launch_estimate: LaunchEstimate | NoEstimate
    hand: HandRun | None = None
    """The finger that moves; None where it stays."""

    level: ClassVar[str] = "launch"

    @property
    def held_radius_m(self) -> float:
        return self.support.radius_m

    @property
    def predicted(self) -> dict[str, float]:
        return {"seconds": self.launch_plan.seconds, "bytes": self.launch_plan.disk_bytes}

    @property
    def aside_m(self) -> float:
        """Largest distance of the rear tip from the axis of symmetry."""
        return self.rear.asymmetry_m

    @property
    def crossed_s(self) -> float | None:
        """First frame in which the band crosses itself."""
        return float(self.crossings_s[0]) if len(self.crossings_s) else None

    @property
    def self_touch_s(self) -> float | None:
        """When the band first touches itself; None where it does not."""
        first = None if self.overlaps is None else self.overlaps.first_step
        return None if first is None else first * self.plan.timestep_s

    @property
    def overlap_m(self) -> Array | None:
        """Largest overlap in each interval of ``watch``; None where the band does not touch itself."""
        if self.overlaps is None or self.overlaps.first_step is None:
            return None
        return self.overlaps.at(self.watch.steps)[1]

    @cached_property
    def flight(self) -> Throw | None:
        """The flight to the ground; None where none is asked for, or where the band is not thrown."""
        return throw_of(self)

    @property
    def self_contact(self) -> dict[str, float] | None:
        """The contact of the band with itself; None where its parts may pass through each other."""
        touching, overlaps = self.launch_plan.self_contact, self.overlaps
        if touching is None or overlaps is None:
            return None
        return {
            "from_s": touching.from_steps * self.plan.timestep_s,
            "distance_m": self.scene.band.thickness_m,
            "stiffness_n_m": touching.stiffness_n_m,
            "overlap_m": float(overlaps.overlap_m.max(initial=0.0)),
            "energy_j": float(overlaps.energy_j.max(initial=0.0)),
        }

    @cached_property
    def quiet_s(self) -> float:
        """Time before which no disturbance from the finger can reach the tip.

        Waves ahead of the front reach the finger early. Beads that rattle on it amplify rounding until the two sides
        differ by the amplitude of those waves. The fastest wave of the chain is at most as fast as its shortest
        bending waves (2 a_b/a for each unit of reference length) or as sound; it has to go to the finger and back.
        """
        strand, band = self.launch_plan.strand, self.scene.band
        stretches = np.linspace(1.0, 1.0 + self.scene.strain, 33)
        sound = math.sqrt(max(float(np.max(strand.law.tangent(stretches))), 0.0) / band.density_kg_m3)
        bending = 2.0 * strand.bending_diffusivity_m2_s / strand.spacing_m
        across = math.sqrt(max(float(np.max(strand.law.stress(stretches) / stretches)), 0.0) / band.density_kg_m3)
        echo = 2.0 * self.scene.wedge.reference_leg_m / max(sound, bending + across)
        return min(echo, self.plan.front_arrival_s)

    @property
    def _touch_j(self) -> Array | float:
        return 0.0 if self.overlaps is None else self.overlaps.at(self.watch.steps)[0]

    @property
    def _mass_kg(self) -> float:
        band = self.scene.band
        return band.mass_per_length_kg_m * band.circumference_m

    @cached_property
    def figures(self) -> dict[str, Measured | float | None]:
        """What the launch gave, by the names of results.json, with errors where they are known.

        The errors come from the other number of beads (:func:`beadband.analysis.convergence.plain_error` with
        :data:`LEAST_ORDER`), with a floor: the error expected of the rebound speed, or :data:`SCATTER`. The fit of the
        freedom, and the chance in the last load, have errors of their own.
        """
        found, other = self.found, self.launch_estimate
        values = {name: getattr(found, name) for name in _COMPARED}
        errors: dict[str, float] = {}
        if isinstance(other, LaunchEstimate):
            spacing = 1.0 / np.array([self.plan.beads, other.beads])
            for name, value in values.items():
                beside = getattr(other, name)
                if value is not None and beside is not None:
                    floor = WEIGHTS.get(name, 1.0) * max(SCATTER, self.plan.speed_error) * abs(value)
                    errors[name] = plain_error(spacing, np.array([value, beside]), floor, LEAST_ORDER)
        pause = found.pause_s
        if found.free is not None and found.last_load is not None and "finger_free_s" in errors:
            errors["finger_free_s"] = math.hypot(errors["finger_free_s"], found.free.error)
            # A band that rattles may come back within the time that counts as idle, and has come so late by chance.
            chance = found.last_load.value - found.free.value, self.launch_plan.idle_steps * self.launch_plan.timestep_s
            errors["last_load_s"] = math.hypot(errors["last_load_s"], *chance)
            if "pause_s" in errors:
                errors["pause_s"] = math.hypot(errors["finger_free_s"], errors["rear_arrival_s"])
        values["escape_speed_m_s"] = self.support.radius_m / pause if pause is not None and pause > 0.0 else None
        if values["escape_speed_m_s"] is not None and "pause_s" in errors:
            errors["escape_speed_m_s"] = values["escape_speed_m_s"] * errors["pause_s"] / pause
        return {name: Measured(value, errors[name]) if name in errors else value for name, value in values.items()}

    @property
    def _coarse_hand(self) -> tuple[int, HandMeasurement] | None:
        other = self.launch_estimate
        return (other.beads, other.hand) if isinstance(other, LaunchEstimate) and other.hand else None

    @cached_property
    def hand_figures(self) -> dict[str, Any] | None:
        """What the hand felt, by the names of results.json, with errors; None where the finger stays."""
        hand = self.hand
        return None if hand is None else hand.figures(self.plan.beads, self._coarse_hand, self.plan.speed_error)

    @property
    def shares(self) -> dict[str, float]:
        """Where the stored energy is when the throw is read, as shares of it."""
        found, energy, line = self.found, self.energy, self.found.line
        parts = {
            "translation": found.translation_j,
            "stretching": energy.stretching_j[line],
            "bending": energy.bending_j[line],
            "vibration": found.vibration_j,
            "dissipated": energy.dissipated_j[line],
            "contact": energy.contact_j[line],
            **({"hand": energy.hand_j[line]} if self.hand else {}),
        }
        return {name: float(value) / energy.stored_j for name, value in parts.items()}

    @property
    def finger(self) -> dict[str, float]:
        """The finger and how deep the band pressed into it."""
        return {
            "radius_m": self.support.radius_m,
            "centre_x_m": self.support.centre_m,
            "stiffness_n_m": self.support.stiffness_n_m,
            "deepest_m": self.found.depth_m,
            "contact_energy_j": float((self.watch.contact_j - self._touch_j).max()),
        }

    @property
    def string(self) -> dict[str, Any]:
        """The same launch of a string without bending."""
        string = self.launch_plan.string
        return {**asdict(string), "pause_s": string.pause_s}

    @property
    def held_force_n(self) -> float:
        """Force on the finger while the band is held."""
        return float(self.watch.force_n[0])

    @property
    def force_n(self) -> Array:
        """Mean force of each interval; that of the release, which has none before it, is the held one."""
        force = self.watch.mean_force_n.copy()
        force[0] = self.watch.force_n[0]
        return force

    @property
    def centre_speed_m_s(self) -> Array:
        """Speed of the centre of mass, shape (lines,)."""
        return self.watch.momentum_n_s / self._mass_kg

    @property
    def checks(self) -> dict[str, Check]:
        found = self.found
        depth = max(found.depth_m, 0.0) / self.scene.band.thickness_m
        apart = abs(found.impulse_n_s - found.momentum_n_s) / abs(found.momentum_n_s)
        checks = {
            **super().checks,
            "penetration": Check("too-deep", depth, DEPTH_BOUND),
            "momentum": Check("momentum-unbalanced", apart, momentum_limit(self.plan.steps)),
            **(self.hand.checks(float(self.watch.momentum_n_s[-1])) if self.hand else {}),
        }
        if self.overlaps is not None:
            overlap = float(self.overlaps.overlap_m.max(initial=0.0)) / self.scene.band.thickness_m
            checks["self_overlap"] = Check("overlaps-itself", overlap, OVERLAP_BOUND)
            checks["self_crossing"] = Check("crossed-itself", float(len(self.crossings_s)), 0.0)
        return checks

    def remarks(self) -> tuple[Notice, ...]:
        found, plan = self.found, self.launch_plan
        more = []
        if found.rear_arrival_s is None:
            more.append(notice("no-arrival", value=plan.cap_s))
        elif found.finger_free_s is None:
            more.append(notice("hit-while-loaded", value=0.25 * plan.idle_steps * plan.timestep_s))
        if plan.scene.finger == "clears" and found.finger_free_s is None:
            more.append(notice("finger-not-cleared"))
        if found.touches:
            pushed = sum(touch.impulse_n_s for touch in found.touches)
            count, start, share = len(found.touches), found.touches[0].start_s, abs(pushed / found.momentum_n_s)
            way = "lost" if pushed < 0.0 else "gained"
            more.append(notice("touched-again", count=count, start_s=start, way=way, value=share))
        more += self.hand.remarks(self._coarse_hand) if self.hand else []
        if self.scene.elevation_deg is not None and found.free is None:
            more.append(notice("no-flight"))
        if self.self_touch_s is not None:
            more.append(notice("touches-itself", value=self.self_touch_s))
        if self.crossed_s is not None and self.overlaps is None:
            more.append(notice("crosses-itself", value=self.crossed_s))
        if self.aside_m > ASIDE_SHARE * self.scene.band.thickness_m:
            more.append(notice("buckled-aside", value=self.aside_m))
        return (*super().remarks(), *more)

    def __repr__(self) -> str:
        figures = self.figures
        speed, pause = figures["centre_of_mass_speed_m_s"], self.found.pause_s
        flight = "no pause" if pause is None else f"pause {pause * 1e3:.3g} ms"
        return f"{super().__repr__()[:-1]},\n centre of mass {speed} m/s, {flight}>"


def stored_launch_estimate(values: Mapping[str, Any]) -> LaunchEstimate | NoEstimate:
    """The coarse launch noted in results, of whichever version; what it does not hold is left open."""
    noted = (values.get("launch") or {}).get("estimate")
    if isinstance(noted, Mapping) and "beads" in noted:
        hand = noted.get("hand")
        felt = {"hand": hand and HandMeasurement(**known_fields(HandMeasurement, hand))}
        return LaunchEstimate(**known_fields(LaunchEstimate, noted) | felt)
    return NoEstimate("not-stored", "the results hold none")
