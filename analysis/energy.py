"""Where the stored energy goes: the balance of a release, and that of a launch with its contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beadband.analysis.fits import Array
from beadband.analysis.readers import Energies, Watch


@dataclass(frozen=True)
class Balance:
    """Energies over a run, J; arrays of shape (frames,)."""

    times_s: Array
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    dissipated_j: Array

    @property
    def stored_j(self) -> float:
        """Energy of the held band."""
        return float(self.stretching_j[0] + self.bending_j[0])

    @property
    def total_j(self) -> Array:
        """Sum of all of them, shape (frames,)."""
        return self.stretching_j + self.bending_j + self.kinetic_j + self.dissipated_j

    @property
    def error(self) -> float:
        """Largest deviation of the sum from that of the held band, over the energy stored in the band."""
        total = self.total_j
        return float(np.abs(total - total[0]).max()) / self.stored_j


@dataclass(frozen=True)
class LaunchBalance(Balance):
    """Energies of a launch, with that of the contact: the finger gives way a little under its load."""

    contact_j: Array
    hand_j: Array
    """What a hand that moves has taken: motion, spring, damper, less the work of its preload; 0 where it stays."""

    @property
    def total_j(self) -> Array:
        """Sum of all of them, shape (lines,)."""
        return super().total_j + self.contact_j + self.hand_j


def balance(energies: Energies, timestep_s: float) -> Balance:
    """Energies of a release at its frames."""
    return Balance(**_parts(energies, timestep_s))


def launch_balance(watch: Watch, timestep_s: float, hand_j: Array | None = None) -> LaunchBalance:
    """Energies of a launch at the lines of its finger.dat; ``hand_j`` are those of a hand that moves."""
    hand = np.zeros(len(watch.steps)) if hand_j is None else hand_j
    return LaunchBalance(**_parts(watch, timestep_s), contact_j=watch.contact_j, hand_j=hand)


def _parts(lines: Energies | Watch, timestep_s: float) -> dict[str, Array]:
    """Times and energies, the loss summed up."""
    lost = np.cumsum(lines.loss_w * (np.diff(lines.steps, prepend=0) * timestep_s))
    energies = {name: getattr(lines, name) for name in ("stretching_j", "bending_j", "kinetic_j")}
    return {"times_s": np.asarray(lines.steps * timestep_s, dtype=np.float64), **energies, "dissipated_j": lost}
