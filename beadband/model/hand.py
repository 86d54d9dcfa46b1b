"""The hand: the finger as a rigid cylinder that the band pushes, or that moves at a speed of its own.

    M X" = F_pre - K X - D X' - F,     X(0) = 0, X'(0) = 0,

X along the throw and F the push of the whole band. The spring carries nothing at X = 0; the preload stays, and is the
band's pull at rest unless it is given, so that everything rests before the release.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from beadband.errors import UsageError, explain
from beadband.parameters import TABLE, UNUSED

KEYS = tuple(one.key for one in TABLE.values() if one.section == "hand")
"""Parameters of a hand."""


@dataclass(frozen=True)
class Hand:
    """A finger that moves. With a velocity it keeps that, whatever the band does, and has nothing else."""

    mass_kg: float | None
    stiffness_n_m: float = 0.0
    damping_n_s_m: float = 0.0
    preload_n: float | None = None
    """None for the band's pull at rest."""
    velocity_m_s: float = 0.0

    @property
    def inverse_mass_1_kg(self) -> float:
        """0 for a velocity that is kept."""
        return 0.0 if self.mass_kg is None else 1.0 / self.mass_kg


def hand_of(values: Mapping[str, Any]) -> Hand | None:
    """The hand of a scene's values, by their keys; None where the finger stays.

    UsageError for a spring, damper or preload without a mass, and for a velocity beside any of them.
    """
    given = {key: values[key] for key in KEYS if values.get(key) is not None}
    if not given:
        return None
    mass, velocity = given.pop("hand_mass_kg", None), given.pop("hand_velocity_m_s", None)
    moved = TABLE["hand_velocity_m_s"].flag
    if velocity is not None and (mass is not None or given):
        key = "hand_mass_kg" if mass is not None else next(iter(given))
        raise UsageError(
            explain(
                f"a finger with {moved} moves as prescribed: {TABLE[key].flag} is not used",
                f"{moved} {velocity:g} and {TABLE[key].flag} {values[key]:g}",
                f"{moved} alone, or the hand's mass, spring, damper and preload",
                f"leave {moved} or {TABLE[key].flag} out",
            ),
            UNUSED,
        )
    if velocity is None and mass is None:
        key = next(iter(given))
        raise UsageError(
            explain(
                f"{TABLE[key].flag} acts on a hand, and there is none",
                f"{TABLE[key].flag} {given[key]:g} without {TABLE['hand_mass_kg'].flag}",
                f"{TABLE[key].flag} with {TABLE['hand_mass_kg'].flag} above 0",
                f"add {TABLE['hand_mass_kg'].flag}, or leave {TABLE[key].flag} out",
            ),
            UNUSED,
        )
    return Hand(
        mass,
        given.get("hand_stiffness_n_m", 0.0),
        given.get("hand_damping_n_s_m", 0.0),
        given.get("hand_preload_n"),
        velocity or 0.0,
    )
