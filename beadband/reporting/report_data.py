"""What a page or movie shows of a run: the band over time, curves and tables, apart from how they are drawn.

:func:`read_story` reads a run's folder, :func:`tell` takes arrays; the page and the movie draw what they return.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.analysis.contact import touching_m
from beadband.analysis.curvature import bond_stretch, ring_curvature
from beadband.analysis.energy import Balance
from beadband.analysis.fits import Array, Measured
from beadband.analysis.readers import ReadError
from beadband.errors import UsageError, explain
from beadband.model.beam import at_rest_curvature, eq7_curvature
from beadband.model.scales import SPEED_WINDOW
from beadband.notices import percent
from beadband.planning.self_contact import NEAR
from beadband.runs import folder as files
from beadband.runs.rear_run import reading_users_files
from beadband.runs.strip_results import StripRun

_TOUCHING = 1.05
"""Distance over the thickness below which parts are drawn as touching: a frame is a mean over its interval."""

Rows = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Curve:
    """A quantity over time; arrays of shape (points,), values in the unit of its chart."""

    name: str
    times_s: Array
    values: Array
    style: str = "line"
    """``line`` for what was computed, ``dashed`` and ``dotted`` for theory, ``bold`` for a fit over its window."""


@dataclass(frozen=True)
class Chart:
    """Curves that share their axes."""

    key: str
    title: str
    unit: str
    curves: tuple[Curve, ...]
    window_s: tuple[float, float] | None = None
    """A span of time to be shaded."""
    window_name: str = ""
    logarithmic: bool = False
    """Whether it is read best on logarithmic axes."""
    stacked: bool = False
    """Whether the values are shares that lie on top of each other."""


@dataclass(frozen=True)
class Finger:
    """A cylinder in the band, with the radius at which it touches the centre line."""

    centre_m: float
    radius_m: float
    until_s: float | None = None
    """When it is withdrawn; None if it stays."""
    way_m: Array | None = None
    """How far a hand has moved it along x at each frame of the story, shape (frames,); None where it stays."""
    hit_s: float | None = None
    """When the rear hits a hand."""

    def at(self, frame: int) -> float:
        """x of its axis at a frame."""
        return self.centre_m + (0.0 if self.way_m is None else float(self.way_m[frame]))

    def reach_m(self) -> tuple[float, float]:
        """Lowest and highest x that it takes up over all frames."""
        ways = np.zeros(1) if self.way_m is None else self.way_m
        return self.centre_m + float(ways.min()) - self.radius_m, self.centre_m + float(ways.max()) + self.radius_m


@dataclass(frozen=True)
class Story:
    """A run, ready to be drawn; frames in order of time, beads in order along the closed band."""

    name: str
    title: str
    headline: str
    times_s: Array
    """Shape (frames,)."""
    positions_m: Array
    """Shape (frames, beads, 2)."""
    stretch: Array
    """Of the bond from each bead to the next, shape (frames, beads); of an open band the last one counts twice."""
    curvature_1_m: Array
    """Turning angle at each bead over reference spacing, positive where the ring turns as a circle does; same shape."""
    thickness_m: float
    finger: Finger
    peg: Finger | None
    """What holds the tip until the release; None for a point."""
    tip_times_s: Array
    """Times of the tip's speed, shape (points,)."""
    tip_speed_m_s: Array
    charts: tuple[Chart, ...]
    results: Rows
    scene: Rows
    versions: Rows
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    open: bool = False
    """Whether the last bead is not joined to the first: a strip, straight, without a finger."""
    touches_m: tuple[Array, ...] = ()
    """Places (places, 2) of each frame where parts of the band touch each other; empty where none ever do."""

    @property
    def frames(self) -> int:
        return len(self.times_s)

    @property
    def beads(self) -> int:
        return int(self.positions_m.shape[1])


def read_story(folder: str | os.PathLike[str]) -> Story:
    """The story of a finished run, from its folder alone; UsageError when it is not one, or can't be understood."""
    from beadband.runs.dispatch import remeasure

    path = files.require(folder, files.RESULTS, files.SCENE, files.TRAJECTORY, files.ENERGY)
    results = files.stored_results(path) or {}
    with reading_users_files():
        run = remeasure(path)
        ring = run.ring
        try:
            more = (_front_chart(run),) if isinstance(run, StripRun) else ()
            return tell(results, ring.times_s, ring.positions_m, run.energy, path.resolve().name, more)
        except ReadError:
            raise
        except (KeyError, TypeError, IndexError, ValueError) as error:
            raise UsageError(
                explain(
                    "the results of the run can't be understood",
                    f"{str(path / files.RESULTS)!r} ({type(error).__name__}: {error})",
                    "a whole results.json",
                    "run it again",
                )
            ) from error


def tell(
    results: Mapping[str, Any],
    times_s: Array,
    positions_m: Array,
    energies: Balance,
    name: str,
    more: tuple[Chart, ...] = (),
) -> Story:
    """Put a run's results and frames in order for drawing.

    Parameters
    ----------
    results : what results.json holds; ``launch`` or ``strip`` may be among it.
    times_s : shape (frames,).
    positions_m : shape (frames, beads, 2), beads in order along the closed band, or the open strip.
    energies : energies at the frames.
    name : what the run is called.
    more : further charts.

    Raises KeyError, TypeError or ValueError where ``results`` is not that of this ring.
    """
    from beadband.reporting.summary import result_rows

    scene, held = results["scene"], results["held"]
    launch, strip = results.get("launch"), results.get("strip")
    if positions_m.shape[1] != scene["beads"] + (strip is not None):
        raise ValueError(f"{positions_m.shape[1]} beads in the trajectory, {scene['beads']} in the scene")
    spacing = scene["circumference_m"] / scene["beads"]
    series = results["series"]
    radius = scene.get("tip_radius_m")
    free = launch.get("finger_free_s") if launch and scene.get("finger") == "clears" else None
    touches = _touches(launch or {}, scene["thickness_m"], spacing, times_s, positions_m)
    return Story(
        name=name,
        title=", ".join(
            [
                f"Band {scene.get('label', scene['band'])}",
                *(["strip"] if strip else []),
                f"strain {scene['strain']:g}",
                *([] if strip else [f"half-angle {scene['half_angle_deg']:g}°"]),
                scene["law"],
            ]
        ),
        headline=_headline(results),
        times_s=times_s,
        positions_m=positions_m,
        stretch=_stretch(positions_m, spacing, strip is None),
        curvature_1_m=np.zeros(positions_m.shape[:2]) if strip else ring_curvature(positions_m, spacing),
        thickness_m=scene["thickness_m"],
        finger=Finger(held["finger_centre_m"] or 0.0, held["finger_radius_m"] or 0.0, free, *_hand(launch, times_s)),
        peg=Finger(radius, radius, 0.0) if radius else None,
        tip_times_s=_array(series["t_s"]),
        tip_speed_m_s=_array(series["tip_speed_m_s"]),
        charts=(
            _speed_chart(results),
            *((_pull_chart(strip), *more) if strip else (_curvature_chart(results),)),
            *(_launch_charts(launch) if launch else ()),
            _energy_chart(energies),
        ),
        results=tuple(result_rows(results)),
        scene=scene_rows(scene),
        versions=tuple((str(key), str(value)) for key, value in results["versions"].items()),
        warnings=tuple(str(sentence) for sentence in results["warnings"]),
        notes=(
            "Every frame but the first is an average over the interval before it, drawn at its midpoint.",
            "The thickness of the band is to scale.",
            *(["Rings mark where parts of the band touch each other."] if touches else []),
        ),
        open=strip is not None,
        touches_m=touches,
    )


def _touches(
    launch: Mapping[str, Any], thickness_m: float, spacing_m: float, times_s: Array, positions_m: Array
) -> tuple[Array, ...]:
    first = launch.get("self_touch_s")
    if first is None:
        return ()
    near = math.ceil(NEAR * thickness_m / spacing_m)
    none = np.empty((0, 2))
    return tuple(
        touching_m(frame, _TOUCHING * thickness_m, near) if time >= first else none
        for time, frame in zip(times_s.tolist(), positions_m, strict=True)
    )


def _stretch(positions_m: Array, spacing_m: float, closed: bool) -> Array:
    found = bond_stretch(positions_m, spacing_m, closed)
    return found if closed else np.concatenate([found, found[:, -1:]], axis=1)


def _array(values: Sequence[float]) -> Array:
    return np.asarray(values, dtype=np.float64)


def _headline(results: Mapping[str, Any]) -> str:
    found = Measured(results["rebound_speed_m_s"], results["rebound_speed_error_m_s"])
    speed = found.value
    away = speed / results["string_speed_m_s"] - 1.0
    side = "above" if away > 0.0 else "below"
    if "strip" in results:
        return (
            f"The released end recoils at {str(found).replace('+/-', '±')} m/s, {percent(abs(away))} {side} the exact "
            f"speed. The wave: {results['strip']['exact']['wave']}."
        )
    text = (
        f"The rear rebounds at {str(found).replace('+/-', '±')} m/s, {abs(away):.2%} "
        f"{side} the limit of a string that does not resist bending."
    )
    launch = results.get("launch") or {}
    free, arrival, pause = (launch.get(key) for key in ("finger_free_s", "rear_arrival_s", "pause_s"))
    felt = launch.get("hand") or {}
    if felt.get("hit") and felt.get("hit_speed_m_s") is not None:
        text = f"{text} It hits the hand at {felt['hit_speed_m_s']:.3g} m/s."
    elif felt:
        text = f"{text} It does not hit the hand."
    if free is None or arrival is None or pause is None:
        return text
    return (
        f"{text} The finger is free after {free * 1e3:.3g} ms and the rear arrives after {arrival * 1e3:.3g} ms: "
        f"a pause of {pause * 1e3:.2g} ms."
        if pause > 0.0
        else f"{text} The rear arrives after {arrival * 1e3:.3g} ms, before the finger is free."
    )


def _speed_chart(results: Mapping[str, Any]) -> Chart:
    series, speed = results["series"], results["rebound_speed_m_s"]
    times = _array(series["t_s"])
    window = np.array(SPEED_WINDOW) * results["front_arrival_s"]
    ends = times[[0, -1]]
    end, limit = ("released end", "exact") if "strip" in results else ("rear tip", "string limit (EI → 0)")
    curves = [
        Curve(end, times, _array(series["tip_speed_m_s"])),
        Curve(limit, ends, np.full(2, results["string_speed_m_s"]), "dashed"),
        Curve("V, slope of the path", window, np.full(2, speed), "bold"),
    ]
    moving = (results.get("launch") or {}).get("series") or {}
    if moving.get("centre_speed_m_s"):
        curves.insert(1, Curve("centre of mass", _array(moving["t_s"]), _array(moving["centre_speed_m_s"])))
    return Chart("speed", f"Speed of the {end}", "m/s", tuple(curves))


def _curvature_chart(results: Mapping[str, Any]) -> Chart:
    series, found = results["series"], results["curvature"]
    times, values = _array(series["t_s"]), _array(series["tip_curvature_1_m"])
    curves = [Curve("rear tip", times, values)]
    diffusivity = math.sqrt(results["bending_stiffness_n_m2"] / results["mass_per_length_kg_m"])
    if diffusivity > 0.0:
        later = times[times > 0.0]
        span = np.geomspace(later[0], later[-1], 41)
        angle = math.radians(results["scene"]["half_angle_deg"])
        curves += [
            Curve("Eq. 7", span, _array(eq7_curvature(span, angle, diffusivity)), "dashed"),
            Curve("beam kink released at rest", span, _array(at_rest_curvature(span, angle, diffusivity)), "dotted"),
        ]
    return Chart(
        "curvature",
        "Tip curvature",
        "1/m",
        tuple(curves),
        window_s=tuple(found["window_s"]) if found else None,
        window_name=f"self-similar window, κ ~ t^({found['exponent']:.2f})" if found else "",
        logarithmic=True,
    )


def _pull_chart(strip: Mapping[str, Any]) -> Chart:
    times, pull = _array(strip["series"]["t_s"]), _array(strip["series"]["pull_n"])
    return Chart("pull", "Pull of the held end", "N", (Curve("pull", times, pull),))


def _front_chart(run: StripRun) -> Chart:
    seen = np.isfinite(run.strip.path_m)
    times = run.strip.frame_times_s
    ends = np.array([0.0, run.exact_arrival_s])
    curves = (
        Curve("front", times[seen], 1e3 * run.strip.path_m[seen]),
        Curve("exact", ends, 1e3 * run.exact_front_speed_m_s * ends, "dashed"),
    )
    return Chart("front", "Front, in the unstretched strip", "mm", curves)


def _energy_chart(energies: Balance) -> Chart:
    share = 100.0 / energies.stored_j
    parts = {
        "stretching": energies.stretching_j,
        "bending": energies.bending_j,
        "kinetic": energies.kinetic_j,
        "dissipated": energies.dissipated_j,
    }
    return Chart(
        "energy",
        f"Energies, {energies.stored_j * 1e3:.4g} mJ stored",
        "%",
        tuple(Curve(name, energies.times_s, share * values) for name, values in parts.items()),
        stacked=True,
    )


def _hand(launch: Mapping[str, Any] | None, times_s: Array) -> tuple[Array | None, float | None]:
    """The way of a hand at the frames, and when it is hit."""
    felt, series = (launch or {}).get("hand"), (launch or {}).get("series") or {}
    if not felt or not series.get("hand_x_m"):
        return None, None
    way: Array = np.interp(times_s, _array(series["t_s"]), _array(series["hand_x_m"]))
    return way, felt.get("hit_s")


def _launch_charts(launch: Mapping[str, Any]) -> list[Chart]:
    """Force of the finger and clearance, as far as the run has them."""
    series = launch.get("series") or {}
    free, arrival = launch.get("finger_free_s"), launch.get("rear_arrival_s")
    pause = (free, arrival) if free is not None and arrival is not None and free < arrival else None
    charts = []
    for key, title, unit, factor in (
        ("finger_force_n", "Force on the finger", "N", 1.0),
        ("clearance_m", "Clearance of the rear", "mm", 1e3),
        ("hand_x_m", "Way of the hand", "mm", 1e3),
    ):
        if series.get(key):
            curve = Curve(title.lower(), _array(series["t_s"]), factor * _array(series[key]))
            charts.append(Chart(key, title, unit, (curve,), pause, "pause: the finger is free" if pause else ""))
    if launch.get("self_touch_s") is not None:
        overlap = 100.0 * _array(series["overlap_m"]) / launch["self_contact"]["distance_m"]
        curve = Curve("overlap", _array(series["t_s"]), overlap)
        charts.append(Chart("overlap", "Overlap of parts of the band, at most", "% of its thickness", (curve,)))
    return charts


def scene_rows(scene: Mapping[str, Any]) -> Rows:
    """The scene under the names of scene.toml; what the plan chose is marked."""
    planned = scene.get("planned") or ()
    rows = []
    for key, value in scene.items():
        if key == "planned":
            continue
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
        rows.append((str(key), f"{text} (planned)" if key in planned else text))
    return tuple(rows)
