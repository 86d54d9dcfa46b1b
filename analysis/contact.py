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
TO_COME = (0.02, 0.12)
"""Shares of the impulse still to come between which the end of the load is fitted."""
_LATER, _EARLIER = (0.02, 0.06), (0.06, 0.2)
"""The same for two more fits, whose difference says how well the end of the load is defined."""
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
    """When the finger became free, with the error of the fit."""
    last_load: Measured | None
    """When it was last loaded before that pause; the error is the interval of the lines."""
    rear_arrival_s: float | None
    touches: tuple[Touch, ...]
    line: int
    """Of finger.dat, at which the throw is read: the last, or the last before a touch that the arrival finds under way,
    which is the beginning of the rear's blow (up to a tenth of the momentum)."""
    impulse_n_s: float
    """Of the finger on the band until then."""
    momentum_n_s: float
    """Of the band then."""
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
    def last_load_s(self) -> float | None:
        return None if self.last_load is None else self.last_load.value

    @property
    def pause_s(self) -> float | None:
        if self.finger_free_s is None or self.rear_arrival_s is None:
            return None
        return self.rear_arrival_s - self.finger_free_s


def impulse_n_s(watch: Watch, timestep_s: float, line: int = -1) -> float:
    """Impulse of the finger on the band until a line, by the rule of the integrator itself."""
    until = slice(None, len(watch.steps) + line + 1 if line < 0 else line + 1)
    return verlet_integral(watch.steps[until], watch.mean_force_n[until], watch.force_n[until], timestep_s)


def verlet_integral(steps: NDArray[np.int64], means: Array, values: Array, timestep_s: float) -> float:
    """What velocity Verlet adds up of a quantity, from its means between lines and its values at them, each (lines,).

    It takes half a step of the value before and half of the one after: the sum over all steps less half of the
    difference of the last to the first value.
    """
    total = float(np.sum(means * np.diff(steps, prepend=0)))
    return timestep_s * (total - 0.5 * (float(values[-1]) - float(values[0])))


def last_load(times_s: Array, mean_force_n: Array, held_n: float, idle_s: float) -> int | None:
    """Line of the last load before the finger carries nothing for ``idle_s``, or for a quarter of it at the end.

    ``mean_force_n`` (lines,) are means over the intervals that end at ``times_s``. None if the load never ends.
    """
    load = np.abs(mean_force_n) / held_n
    load[0] = 1.0
    loaded = np.flatnonzero(load > LOADED)
    for last, after in zip(loaded, [*loaded[1:], len(load)], strict=True):
        # A shorter pause counts where the rear's arrival cuts it off.
        if times_s[after - 1] - times_s[last] >= (idle_s if after < len(load) else 0.25 * idle_s):
            return int(last)
    return None


def finger_free(times_s: Array, mean_force_n: Array, last: int, pull_n: float, turning_1_s: float) -> Measured:
    """When the finger has become free, whose load ends with line ``last``.

    Bending waves make the band rattle on the finger, so the time of the very last load is chance. The impulse still to
    come, J, is not. Where a front takes the band off the finger, the load is F = pull sin(theta), with ``pull_n`` twice
    the tension, and the angle theta of what still lies on the finger falls at the rate ``turning_1_s``
    (:mod:`beadband.model.launch_string`); hence theta = arccos(1 - J turning/pull), a straight line in time, which is
    fitted where J is between 12 and 2 % of the whole. The error is half of the difference of two other fits, of what
    comes earlier and later, and an interval of the lines at least.
    """
    given = np.cumsum(mean_force_n * np.diff(times_s, prepend=0.0))[: last + 1]
    left = given[-1] - given
    angle = np.arccos(np.clip(1.0 - left * turning_1_s / pull_n, -1.0, 1.0))
    end_s, interval = float(times_s[last]), float(times_s[last] - times_s[last - 1])

    def root_s(least: float, most: float) -> float | None:
        first = int(np.flatnonzero(left > most * given[-1])[-1]) + 1
        end = int(np.flatnonzero(left > least * given[-1])[-1]) + 1
        if end - first < 4:
            return None
        slope, offset = np.polyfit(times_s[first:end] - end_s, angle[first:end], 1)
        return end_s - float(offset / slope)

    root, later, earlier = (root_s(*window) for window in (TO_COME, _LATER, _EARLIER))
    if root is None or later is None or earlier is None:
        return Measured(end_s, interval)
    # A root beyond the last load measures the error; it does not mean that a load is still to come.
    return Measured(min(root, end_s), max(0.5 * abs(later - earlier), root - end_s, interval))


def touches_of(times_s: Array, mean_force_n: Array, held_n: float, free_s: float, idle_s: float) -> tuple[Touch, ...]:
    """Loads on a finger that carries nothing from ``free_s`` on; those less than ``idle_s`` apart are one touch."""
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
    watch: Watch,
    timestep_s: float,
    mass_kg: float,
    spacing_m: float,
    margin_m: float,
    idle_s: float,
    pull_n: float,
    turning_1_s: float,
) -> LaunchMeasurement:
    """The results of a launch from its finger.dat.

    ``mass_kg`` is the band's, ``spacing_m`` the reference distance of its beads; ``margin_m`` is that of
    :func:`rear_arrival_s`, ``idle_s`` that of :func:`last_load`, ``pull_n`` and ``turning_1_s`` of :func:`finger_free`.
    """
    times, held = watch.times_s(timestep_s), float(watch.force_n[0])
    last = last_load(times, watch.mean_force_n, held, idle_s)
    free = None if last is None else finger_free(times, watch.mean_force_n, last, pull_n, turning_1_s)
    ended = None if last is None else Measured(float(times[last]), float(times[last] - times[last - 1]))
    arrival = rear_arrival_s(times, watch.gap_m, margin_m)
    touches = () if ended is None else touches_of(times, watch.mean_force_n, held, ended.value, idle_s)
    line = len(times) - 1
    if touches and arrival is not None and touches[-1].start_s < arrival < touches[-1].end_s + idle_s:
        line = int(np.searchsorted(times, touches[-1].start_s))
        touches = touches[:-1]
    momentum = float(watch.momentum_n_s[line])
    translation = momentum**2 / (2.0 * mass_kg)
    stored = float(watch.stretching_j[0] + watch.bending_j[0])
    return LaunchMeasurement(
        free=free,
        last_load=ended,
        rear_arrival_s=arrival,
        touches=touches,
        line=line,
        impulse_n_s=impulse_n_s(watch, timestep_s, line),
        momentum_n_s=momentum,
        centre_of_mass_speed_m_s=momentum / mass_kg,
        efficiency=translation / stored,
        depth_m=float(watch.depth_m.max()),
        shortest_stretch=float(watch.shortest_bond_m.min()) / spacing_m,
        translation_j=translation,
        vibration_j=float(watch.kinetic_j[line]) - translation,
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


def touching_m(positions_m: Array, distance_m: float, near: int) -> Array:
    """Places (places, 2) where parts of a closed chain of beads (beads, 2) are closer than ``distance_m``.

    Beads up to ``near`` apart along the chain are left out. A place is the middle between two beads, one in each
    square of the distance.
    """
    from scipy.spatial import cKDTree

    count = len(positions_m)
    pairs = cKDTree(positions_m).query_pairs(distance_m, output_type="ndarray")
    apart = pairs[:, 1] - pairs[:, 0]
    pairs = pairs[np.minimum(apart, count - apart) > near]
    middles: Array = 0.5 * (positions_m[pairs[:, 0]] + positions_m[pairs[:, 1]])
    return middles[np.unique(np.floor(middles / distance_m), axis=0, return_index=True)[1]]


def _cross(first: Array, second: Array) -> Array:
    product: Array = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return product
