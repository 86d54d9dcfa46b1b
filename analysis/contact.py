"""A launch, measured: load and freedom of the finger, arrival of the rear, momentum, energy; arrays in, values out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband.analysis.fits import Array, Measured
from beadband.analysis.readers import Watch

LOADED = 0.01
"""Share of the held load below which the finger counts as free."""
TOUCHED = 1e-3
"""Share of the held load above which a free finger counts as touched."""
_TO_COME = (0.01, 0.06)
"""Shares of the impulse still to come between which its root is fitted."""
_GROUP = 16
"""Bonds whose bounding boxes are compared as one."""


@dataclass(frozen=True)
class Touch:
    """A time at which a finger that was free already is touched again."""

    start_s: float
    end_s: float
    impulse_n_s: float
    """Negative where the finger slows the band down."""


@dataclass(frozen=True)
class LaunchMeasurement:
    """Results of a launch; None for what did not happen."""

    free: Measured | None
    """When the finger became free, with the error of that time."""
    rear_arrival_s: float | None
    touches: tuple[Touch, ...]
    impulse_n_s: float
    """Of the finger on the band over the whole run."""
    momentum_n_s: float
    """Of the band at the end."""
    centre_of_mass_speed_m_s: float
    efficiency: float
    depth_m: float
    """Largest depth of a bead in the finger."""
    shortest_stretch: float
    translation_j: float
    vibration_j: float
    """Kinetic energy beyond that of the centre of mass."""

    @property
    def finger_free_s(self) -> float | None:
        return None if self.free is None else self.free.value

    @property
    def pause_s(self) -> float | None:
        if self.finger_free_s is None or self.rear_arrival_s is None:
            return None
        return self.rear_arrival_s - self.finger_free_s


def impulse_n_s(watch: Watch, timestep_s: float) -> float:
    """Impulse of the finger on the band by the rule of the integrator itself."""
    return verlet_integral(watch.steps, watch.mean_force_n, watch.force_n, timestep_s)


def verlet_integral(steps: NDArray[np.int64], means: Array, values: Array, timestep_s: float) -> float:
    """What velocity Verlet adds up of a quantity, from its means between lines and its values at them, each (lines,).

    It takes half a step of the value before and half of the one after: the sum over all steps less half of the
    difference of the last to the first value.
    """
    total = float(np.sum(means * np.diff(steps, prepend=0)))
    return timestep_s * (total - 0.5 * (float(values[-1]) - float(values[0])))


def finger_free(times_s: Array, mean_force_n: Array, held_n: float, idle_s: float) -> Measured | None:
    """When the finger has become free: without load for ``idle_s``, or for a quarter of it at the end; None if never.

    ``mean_force_n`` (lines,) are means over the intervals that end at ``times_s``. Bending waves make the band rattle
    on the finger, so the time of the very last touch is random. The impulse still to come is not: it is a parabola
    where the load falls linearly, and its root is fitted and extrapolated. The error is the distance to the last
    interval with a load.
    """
    load = np.abs(mean_force_n) / held_n
    load[0] = 1.0
    loaded = np.flatnonzero(load > LOADED)
    for last, after in zip(loaded, [*loaded[1:], len(load)], strict=True):
        # A shorter pause counts where the rear's arrival cuts it off.
        enough = idle_s if after < len(load) else 0.25 * idle_s
        if times_s[after - 1] - times_s[last] < enough:
            continue
        given = np.cumsum(mean_force_n * np.diff(times_s, prepend=0.0))[: last + 1]
        to_come = 1.0 - given / given[-1]
        inside = np.flatnonzero(to_come > _TO_COME[1])
        first, end = int(inside[-1]) + 1, int(np.flatnonzero(to_come > _TO_COME[0])[-1]) + 1
        end_s, interval = float(times_s[last]), float(times_s[last] - times_s[last - 1])
        if end - first < 4:
            return Measured(end_s, interval)
        root = np.sqrt(np.maximum(to_come[first:end], 0.0))
        slope, offset = np.polyfit(times_s[first:end] - end_s, root, 1)
        root_s = end_s - float(offset / slope)
        # A root beyond the last load measures the error; it does not mean that a load is still to come.
        return Measured(min(root_s, end_s), max(abs(end_s - root_s), interval))
    return None


def touches_of(times_s: Array, mean_force_n: Array, held_n: float, free_s: float, idle_s: float) -> tuple[Touch, ...]:
    """Loads on a finger that has become free at ``free_s``; those less than ``idle_s`` apart are one touch."""
    touched = (np.abs(mean_force_n) > TOUCHED * held_n) & (np.concatenate([[0.0], times_s[:-1]]) >= free_s)
    # The end of the load from which the finger becomes free is not a touch.
    after = np.flatnonzero((times_s > free_s) & ~touched)
    touched[: after[0] if len(after) else len(touched)] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touched.astype(int), [0]])))
    found: list[Touch] = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        impulse = float(np.sum(np.diff(times_s[start - 1 : end]) * mean_force_n[start:end]))
        touch = Touch(float(times_s[start - 1]), float(times_s[end - 1]), impulse)
        if found and touch.start_s - found[-1].end_s < idle_s:
            touch = Touch(found[-1].start_s, touch.end_s, found[-1].impulse_n_s + touch.impulse_n_s)
            found.pop()
        found.append(touch)
    return tuple(found)


def rear_arrival_s(times_s: Array, gap_m: Array, margin_m: float) -> float | None:
    """When the rear reaches the finger's surface; None when it never comes within ``margin_m``.

    The run compares the gap with that margin every few steps and then stops; the rest is extrapolated at the last rate.
    """
    near = np.flatnonzero(gap_m < margin_m)
    if len(near) == 0 or near[0] == 0:
        return None
    here = int(near[0])
    rate = (gap_m[here - 1] - gap_m[here]) / (times_s[here] - times_s[here - 1])
    if not rate > 0.0:
        return float(times_s[here])
    return float(times_s[here] + gap_m[here] / rate)


def measure_launch(
    watch: Watch, timestep_s: float, mass_kg: float, spacing_m: float, margin_m: float, idle_s: float
) -> LaunchMeasurement:
    """The results of a launch from its finger.dat.

    ``mass_kg`` is the band's, ``spacing_m`` the reference distance of its beads; ``margin_m`` and ``idle_s`` are those
    of :func:`rear_arrival_s` and :func:`finger_free`.
    """
    times, held = watch.times_s(timestep_s), float(watch.force_n[0])
    free = finger_free(times, watch.mean_force_n, held, idle_s)
    momentum = float(watch.momentum_n_s[-1])
    translation = momentum**2 / (2.0 * mass_kg)
    stored = float(watch.stretching_j[0] + watch.bending_j[0])
    return LaunchMeasurement(
        free=free,
        rear_arrival_s=rear_arrival_s(times, watch.gap_m, margin_m),
        touches=() if free is None else touches_of(times, watch.mean_force_n, held, sum(free), idle_s),
        impulse_n_s=impulse_n_s(watch, timestep_s),
        momentum_n_s=momentum,
        centre_of_mass_speed_m_s=momentum / mass_kg,
        efficiency=translation / stored,
        depth_m=float(watch.depth_m.max()),
        shortest_stretch=float(watch.shortest_bond_m.min()) / spacing_m,
        translation_j=translation,
        vibration_j=float(watch.kinetic_j[-1]) - translation,
    )


def crossings(positions_m: Array) -> int:
    """Number of pairs of bonds, neighbours left out, that intersect in a closed chain of beads (beads, 2)."""
    start = positions_m
    bond = np.roll(positions_m, -1, axis=0) - start
    count = len(start)
    low, high = np.minimum(start, start + bond), np.maximum(start, start + bond)
    # Boxes around groups of bonds first: few overlap others than their neighbours.
    groups = np.minimum(np.arange(-(-count // _GROUP) * _GROUP), count - 1).reshape(-1, _GROUP)
    group_low, group_high = low[groups].min(axis=1), high[groups].max(axis=1)
    near = np.all((group_low[:, None] <= group_high[None]) & (group_low[None] <= group_high[:, None]), axis=2)
    first, second = np.nonzero(np.triu(near))
    numbers = np.arange(groups.size).reshape(groups.shape)
    i = np.repeat(numbers[first], _GROUP, axis=1).ravel()
    j = np.tile(numbers[second], (1, _GROUP)).ravel()
    chosen = (j < count) & (j - i > 1) & (j - i < count - 1)
    i, j = i[chosen], j[chosen]
    chosen = np.all((low[i] <= high[j]) & (low[j] <= high[i]), axis=1)
    i, j = i[chosen], j[chosen]
    between = start[j] - start[i]
    across = _cross(bond[i], bond[j])
    with np.errstate(divide="ignore", invalid="ignore"):
        s, u = _cross(between, bond[j]) / across, _cross(between, bond[i]) / across
    return int(np.count_nonzero((s >= 0.0) & (s <= 1.0) & (u >= 0.0) & (u <= 1.0)))


def _cross(first: Array, second: Array) -> Array:
    product: Array = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return product
