"""What comes out: one table of every result, from which all places that name results are made.

Each :class:`Observable` has a key of results.json, a unit, a sentence, and where its value comes from. The table gives
results.json and its JSON Schema, the columns of sweeps, the rows that a person reads and the dictionary of the
documents, which :mod:`beadband.reporting.documents` writes.

Your own result is added in one place and then appears in all of them::

    from beadband.observables import observable

    @observable("tip_way_m", "way of the rear tip until the front arrives", unit="m")
    def tip_way(run):
        return run.rear.tip_x_m[-1] - run.rear.tip_x_m[0]

Results are read by the names of their attributes; this module imports nothing of the rest of beadband.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

SCHEMA_VERSION = 2
"""Of results.json; 1 is the one without a ``schema_version``."""
LEVELS = {
    "rear": ("rear",),
    "release": ("rear", "release"),
    "launch": ("rear", "release", "launch"),
    "strip": ("rear", "release", "strip"),
}
"""What was run: any release (also one leg), one of the whole ring, a launch, a strip; and the results that each has."""
_SECTIONS = ("launch", "strip")
"""Levels whose results stand under a key of their own, which other runs lack."""
WAVES = {"bar": "sqrt(E/rho)", "rest": "sqrt(E0/rho)", "front_horizontal": "of the front"}
"""Wave speeds C to which the rebound speed is compared."""
_SCALARS = {"number": "number", "integer": "integer", "text": "string", "flag": "boolean", "object": "object"}
_ARRAYS = {"series": "number", "texts": "string", "objects": "object"}
_TYPES: dict[str, dict[str, Any]] = {
    **{kind: {"type": name} for kind, name in _SCALARS.items()},
    **{kind: {"type": "array", "items": {"type": name}} for kind, name in _ARRAYS.items()},
}

Source = str | Callable[[Any], Any]


@dataclass(frozen=True)
class Observable:
    """One result."""

    key: str  # its place in results.json, levels separated by dots
    sentence: str
    unit: str = ""  # SI; empty for pure numbers and for what is not a number
    source: Source = ""  # attributes of the result, separated by dots, or a function of it; may give (value, error)
    kind: str = "number"
    level: str = "rear"  # the least result that has it
    error: bool = False  # whether its error, where known, stands beside it under :func:`error_key`
    null: bool = False  # whether it may be null; what is below a null object is left out
    optional: bool = False  # whether it is left out where there is nothing
    column: str = ""  # in the table of a sweep
    label: str | None = None  # name of its row in a summary
    scale: float = 1.0  # factor from SI to ``shown``, the unit of the row where it is not the SI one
    shown: str | None = None
    absent: str | None = None  # text of its row where there is no value; without it there is no row then

    def value(self, result: Any) -> Any:
        """Its value for a result; AttributeError or KeyError where the result lacks what it is made of."""
        return self.source(result) if callable(self.source) else _attribute(result, self.source or self.key)

    def measured(self, result: Any) -> tuple[Any, float | None]:
        """Value and error for a result."""
        value = self.value(result)
        return value if self.error and isinstance(value, tuple) else (value, None)

    def text(self, value: Any, error: float | None) -> str:
        """Value and error as a person reads them."""
        unit = self.unit if self.shown is None else self.shown
        if self.kind == "flag":
            text = "yes" if value else "no"
        elif self.kind != "number":
            text = str(value)
        elif error:
            from beadband.analysis.fits import Measured

            text = str(Measured(value, error).scaled(self.scale))
        else:
            text = f"{value * self.scale:.4g}"
        return f"{text} {unit}".rstrip()


def _attribute(result: Any, path: str) -> Any:
    """A value by its path; None below a None."""
    for name in path.split("."):
        if result is not None:
            result = result[name] if isinstance(result, Mapping) else getattr(result, name)
    return result


def error_key(name: str) -> str:
    """Name under which an error stands: ``error`` before the unit, as in ``rebound_speed_error_m_s``."""
    for unit in ("_m_s", "_n_s", "_1_m", "_s", "_m", "_n", "_j"):
        if name.endswith(unit):
            return f"{name.removesuffix(unit)}_error{unit}"
    return f"{name}_error"


def _checks(result: Any) -> dict[str, Any]:
    found: dict[str, Any] = {name: {"value": one.value, "bound": one.limit} for name, one in result.checks.items()}
    return {**found, "failed": [one.sentence for one in result.failed_checks]}


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "__dataclass_fields__"):
        value = {name: getattr(value, name) for name in value.__dataclass_fields__}
    if isinstance(value, Mapping):
        return {name: _plain(one) for name, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, tuple | list) else value


def _coarse(name: str, failed: bool = False) -> Callable[[Any], Any]:
    """A coarse run, or why there is none."""

    def source(result: Any) -> Any:
        found = getattr(result, name)
        return found if hasattr(found, "beads") != failed else None

    return source


def _per_wave(stem: str, source: str, text: str, column: str = "", **more: Any) -> list[Observable]:
    """One observable for each wave speed."""
    names = {wave: f"{text}, C {'' if wave == 'front_horizontal' else '= '}{where}" for wave, where in WAVES.items()}
    return [
        Observable(f"{stem}.{wave}", name, source=source.format(wave), column=column.format(wave), **more)
        for wave, name in names.items()
    ]


def _ring(key: str, sentence: str, unit: str = "", source: Source = "", **more: Any) -> Observable:
    """A number of a release of the whole ring."""
    return Observable(key, sentence, unit, source, level="release", **more)


def _object(key: str, sentence: str, source: Source = "", level: str = "rear", **more: Any) -> Observable:
    """Several values under names of their own."""
    return Observable(key, sentence, "", source, "object", level, **more)


def _final_energy(name: str, level: str = "release") -> Observable:
    key = f"energy.{name}_j"
    return Observable(key, f"energy at the end: {name}", "J", lambda run: _attribute(run, key)[-1], level=level)


def _throw(name: str, sentence: str, unit: str, label: str, **more: Any) -> Observable:
    """One of the figures of a launch, with its error where there is a coarse launch."""
    key, source = f"launch.{name}", f"figures.{name}"
    return Observable(key, sentence, unit, source, "number", "launch", error=True, null=True, label=label, **more)


def _hand(name: str, sentence: str, unit: str, label: str, **more: Any) -> Observable:
    """One of the figures of a hand."""
    key, source = f"launch.hand.{name}", f"hand_figures.{name}"
    return Observable(key, sentence, unit, source, "number", "launch", error=True, null=True, label=label, **more)


def _figure(name: str, sentence: str, unit: str = "", **more: Any) -> Observable:
    """What a designer asks: a closed form of the held band, also in the table of a sweep."""
    return Observable(f"design.{name}", sentence, unit, f"design.{name}", column=name, **more)


def _launch(key: str, sentence: str, unit: str, source: Source, kind: str = "number", **more: Any) -> Observable:
    """A value of a launch, or its course over time."""
    return Observable(f"launch.{key}", sentence, unit, source, kind, "launch", **more)


def _strip(key: str, sentence: str, unit: str, source: Source = "", **more: Any) -> Observable:
    """A value of a strip, or its course over time."""
    return Observable(f"strip.{key}", sentence, unit, source or key, level="strip", **more)


_V = "rebound speed V of the rear tip, with its whole error"
_TIME: dict[str, Any] = {"scale": 1e3, "shown": "ms", "absent": "not reached"}
_TABLE: list[Observable] = [
    Observable("schema_version", "version of this file's form", source=lambda _: SCHEMA_VERSION, kind="integer"),
    _object("scene", "the scene, under the names of scene.toml; label is what the band is called",
            lambda run: {**run.scene.as_dict(), "label": run.scene.label}),
    Observable("leg_length_m", "reference length l0 of a leg, or of a strip", "m", "scene.wedge.reference_leg_m"),
    Observable("finger_radius_m", "radius of the finger in the scene; null for a strip", "m",
               lambda run: run.scene.wedge.finger_radius_m or None, null=True),
    Observable("front_arrival_s", "arrival of the string limit's front at the finger, or at the held end of a strip",
               "s", "plan.front_arrival_s"),
    Observable("bending_stiffness_n_m2", "bending stiffness EI", "N m2", "scene.bending_stiffness_n_m2"),
    Observable("mass_per_length_kg_m", "mass per reference length", "kg/m", "scene.band.mass_per_length_kg_m"),
    _ring("held.finger_radius_m", "radius of the finger under the held beads; null for a strip", "m", "held_radius_m",
          null=True),
    _ring("held.finger_centre_m", "x of the finger's centre; null for a strip", "m",
          lambda run: getattr(run.held, "finger_centre_m", None), null=True),
    _ring("held.tension_n", "tension of a held leg", "N"),
    _ring("held.net_force", "largest net force on a free bead of the held ring, over the tension"),
    Observable("rebound_speed_m_s", _V, "m/s", "speed", error=True, column="rebound_speed_m_s",
               label="rebound speed V"),
    Observable("late_speed_m_s", "speed of the rear tip from 0.7 to 0.85 of the front's arrival; null with few frames",
               "m/s", null=True, column="late_speed_m_s",
               label="late speed"),
    Observable("rebound_speed_input_error_m_s", "error of V from those of the inputs; null where none was given",
               "m/s", "input_error_m_s", null=True, label="error from the inputs"),
    Observable("inputs", "inputs with an error: name, value, error, sensitivity d ln V/d ln x, share of the variance",
               source=lambda run: [] if run.inputs is None else run.inputs.rows(), kind="objects"),
    _object("input_samples", "V over draws of the inputs: draws, refused, mean, standard deviation and 95 % interval",
            "inputs.sampled", optional=True),
    Observable("within_tolerance", "whether the error of V is within the tolerance", kind="flag",
               column="within_tolerance"),
    *_per_wave("wave_speeds_m_s", "wave_speeds_m_s.{}", "wave speed", unit="m/s"),
    Observable("string_speed_m_s", "rebound speed of the string limit of the same law", "m/s",
               "plan.string.rear_speed_m_s", column="string_speed_m_s", label="string limit (EI -> 0)"),
    Observable("string.residual_strain", "strain behind the front of that string",
               source="plan.string.residual_strain"),
    Observable("string.front_speed_m_s", "speed of that front", "m/s", "plan.string.front_speed_m_s"),
    Observable("string.published_ratio", "V/C by the published formula", "", "scene.published_ratio",
               column="published_ratio"),
    *(replace(one, label=one.sentence) for one in _per_wave("rebound_ratio", "ratios.{}.value", "V/C", "ratio_{}")),
    *_per_wave("alpha", "alphas.{}.value", "V/C over the published formula", "alpha_{}"),
    *_per_wave("alpha_error", "alphas.{}.error", "error of alpha", "alpha_{}_error"),
    _object("curvature", "decay of the tip curvature in its self-similar window", null=True, label="tip curvature"),
    Observable("reason", "why there is no decay of the curvature", "", "measurement.no_decay", "text", optional=True,
               column="no_curvature"),
    Observable("curvature.window_s", "start and end of the window", "s", kind="series"),
    Observable("curvature.exponent", "power of time by which the curvature falls", error=True, column="exponent"),
    Observable("curvature.eq7_ratio", "curvature over that of Eq. 7, mean", error=True, column="eq7_ratio"),
    Observable("curvature.exponent_input_error", "error of the exponent from those of the inputs",
               source="inputs.exponent_error", optional=True),
    Observable("curvature.eq7_ratio_input_error", "relative error of that ratio from those of the inputs",
               source="inputs.eq7_ratio_error", optional=True),
    Observable("series.t_s", "times of the rear's frames, each a mean over its interval", "s", "rear.times_s",
               "series"),
    Observable("series.tip_x_m", "position of the tip along the axis", "m", "rear.tip_x_m", "series"),
    Observable("series.tip_speed_m_s", "speed of the tip", "m/s", "rear.tip_speed_m_s", "series"),
    Observable("series.tip_curvature_1_m", "curvature at the tip", "1/m", "rear.tip_curvature_1_m", "series"),
    _figure("mass_kg", "mass of the band", "kg"),
    _figure("stored_energy_j", "energy of the held band in uniform stretch, bending left out", "J"),
    _figure("energy_density_j_kg", "stored energy over the mass", "J/kg"),
    _figure("tension_n", "tension of a leg of the held band, uniform stretch", "N"),
    _figure("pull_n", "force that holds the rear, 2 T cos(half-angle); of a strip T", "N"),
    _figure("held_length_m", "length of the held band, from the rear to the far side of the finger", "m"),
    _figure("throw_momentum_n_s", "momentum of the thrown band in the string limit; null where that has no closed form",
            "N s", null=True),
    _figure("throw_speed_m_s", "speed of its centre of mass in that limit", "m/s", null=True),
    _figure("throw_efficiency", "energy of that translation over the stored energy", null=True),
    _figure("peak_strain", "strain from which on the band can't be held, as its tension peaks or its law ends; or null",
            null=True),
    _ring("energy.stored_j", "energy of the held band", "J", label="energy"),
    _ring("energy.hysteresis_j", "energy lost in the rubber between loading and unloading; not part of stored_j", "J",
          "scene.hysteresis_j"),
    *(_final_energy(name) for name in ("kinetic", "bending", "stretching", "dissipated")),
    _final_energy("contact", "launch"),
    _ring("energy.balance_error", "largest unbalanced share of the stored energy", "", "energy.error"),
    _object("estimate", "the coarse run from which the error is judged", _coarse("estimate"), null=True),
    _object("estimate_failure", "code and reason where there is no coarse run", _coarse("estimate", True), null=True),
    _object("checks", "physics checks: value and bound of each; failed: sentences", _checks),
    Observable("plan.model", "what was computed: the ring, or one leg of it; in sweeps also formula, without a run",
               kind="text", column="model"),
    Observable("plan.beads", "beads of the whole ring", kind="integer", column="beads", label="beads, steps"),
    Observable("plan.steps", "time steps", kind="integer", column="steps"),
    Observable("plan.bead_steps", "computed beads times steps", kind="integer", column="bead_steps"),
    _object("predicted", "time in s and disk in bytes that the plan predicted for the run", level="release"),
    _object("wall_s", "seconds that each part of the run took", level="release", label="wall time"),
    _object("versions", "versions of what made the numbers", level="release"),
    _object("fingerprints", "size and SHA-256 of the files that were measured", level="release"),
    Observable("warnings", "notices as sentences", "", lambda run: [one.sentence for one in run.notices], "texts"),
    Observable("warning_codes", "the code of each notice", "", lambda run: [one.code for one in run.notices], "texts"),
    _throw("centre_of_mass_speed_m_s", "its speed before the rear hits", "m/s", "speed of the centre of mass"),
    _throw("efficiency", "energy of translation over the stored energy", "", "efficiency", scale=100.0, shown="%"),
    _throw("finger_free_s", "when the finger is free: the end of its load, by a fit to its impulse", "s", "finger free",
           **_TIME),
    _throw("last_load_s", "when a finger on which the band rattles was loaded last before it is free", "s",
           "last load before it", **_TIME),
    _throw("rear_arrival_s", "when the rear reaches the finger", "s", "rear at the finger", **_TIME),
    _throw("pause_s", "time between the two", "s", "pause between them", **_TIME),
    _throw("escape_speed_m_s", "radius of the finger over the pause, a scale of speed", "m/s", "scale R/pause"),
    _throw("momentum_n_s", "momentum of the band before the rear hits", "N s", "momentum of the band"),
    _launch("hand", "what a finger that moves felt; null where it stays", "", "hand_figures", "object", null=True),
    _launch("hand.hit", "whether the rear hits it before three times the arrival at a fixed finger", "",
            "hand_figures.hit", "flag", label="hand hit"),
    _launch("hand.hit_s", "when", "s", "hand_figures.hit_s", null=True),
    _hand("hit_speed_m_s", "speed of the rear against it at the hit", "m/s", "speed of the hit", absent="not hit"),
    _hand("peak_force_n", "largest force on it up to the hit, Hann mean of 0.03 t_f to either side", "N",
          "peak force on the hand"),
    _hand("impulse_n_s", "impulse of the band on it from the release to the hit", "N s", "impulse on the hand"),
    _hand("displacement_m", "its way along the throw up to the hit", "m", "way of the hand", scale=1e3, shown="mm"),
    _hand("velocity_m_s", "its velocity at the hit", "m/s", "velocity of the hand"),
    _launch("finger_impulse_n_s", "impulse of the finger until then", "N s", "found.impulse_n_s", label="impulse"),
    _launch("finger_force_n", "force on the held finger", "N", "held_force_n", label="held force"),
    _launch("finger", "the finger, and how deep beads went into it", "", "finger", "object"),
    _launch("touches", "loads on a finger that was free already", "", "found.touches", "objects"),
    _launch("shares", "where the stored energy is then", "", "shares", "object", label="energy before the hit"),
    _launch("shortest_stretch", "least stretch of a bond", "", "found.shortest_stretch"),
    _launch("self_touch_s", "when the band first touches itself", "s", "self_touch_s", null=True, scale=1e3, shown="ms",
            label="touches itself"),
    _launch("self_contact", "contact of the band with itself, and the deepest overlap; null where it is off", "",
            "self_contact", "object", null=True),
    _launch("crossed_s", "first frame in which the band crosses itself", "s", "crossed_s", null=True),
    _launch("flight", "the flight to the ground; null without --elevation, or without a throw", "", "flight", "object",
            null=True),
    _launch("flight.range_m", "way along the ground", "m", "flight.range", error=True, label="range"),
    _launch("flight.time_s", "time to the ground", "s", "flight.flight.time_s", label="time of flight"),
    _launch("flight.top_m", "highest point above the ground", "m", "flight.flight.top_m"),
    _launch("flight.landing_speed_m_s", "speed at the ground", "m/s", "flight.flight.landing_speed_m_s",
            label="landing speed"),
    _launch("flight.vacuum_range_m", "the range without air", "m", "flight.vacuum.range_m", label="range without air"),
    _launch("flight.drag_length_m", "way over which the air takes the speed down to 1/e; null without air", "m",
            "flight.drag_length_m", null=True),
    _launch("flight.terminal_speed_m_s", "speed at which drag balances the weight; null without air", "m/s",
            "flight.terminal_speed_m_s", null=True),
    _launch("flight.drag_area_m2", "drag coefficient times area of the tumbling band, which is used", "m2",
            "flight.areas.tumbling"),
    _launch("flight.drag_area_in_plane_m2", "the same of the band in its plane", "m2", "flight.areas.in_plane"),
    _launch("flight.drag_area_broadside_m2", "the same along the axis of its ring", "m2", "flight.areas.broadside"),
    _launch("flight.across", "share of the circumference that lies across the flight in the plane, by the cube of the "
            "cosine", "", "flight.across"),
    _launch("flight.launch_drag", "momentum that the air would take during the launch, over that of the band", "",
            "flight.launch_drag"),
    _launch("rear_aside_m", "largest distance of the rear from the axis", "m", "aside_m"),
    _launch("string", "the launch of a string without bending", "", "string", "object"),
    _launch("estimate", "the coarse launch", "", _coarse("launch_estimate"), "object", null=True),
    _launch("series.t_s", "times", "s", "energy.times_s", "series"),
    _launch("series.overlap_m", "what the deepest overlap of two parts of the band is at most", "m",
            "overlap_m", "series", optional=True),
    _launch("series.finger_force_n", "force of the finger, mean over each interval", "N", "force_n", "series"),
    _launch("series.clearance_m", "from the rear tip to the finger's surface", "m", "clearance_m", "series"),
    _launch("series.hand_x_m", "place of the hand along the throw", "m", "hand.path.x_m", "series", optional=True),
    _launch("series.centre_x_m", "position of the centre of mass", "m", "watch.centre_x_m", "series"),
    _launch("series.centre_speed_m_s", "speed of the centre of mass", "m/s", "centre_speed_m_s", "series"),
    _strip("front_speed_m_s", "speed of the front in reference length: of the stretch halfway through the foremost "
           "part of the wave", "m/s", "front_speed", error=True, null=True, label="front speed", absent="not measured"),
    _strip("arrival_s", "when the path of that front reaches the held end", "s", "arrival", error=True, null=True,
           label="front at the held end", **_TIME | {"absent": "not measured"}),
    _strip("reason", "why there is no front", "", "strip.no_front", kind="text", optional=True),
    _strip("exact.wave", "what the unloading wave is made of", "", "plan.string.wave.kind", kind="text", label="wave"),
    _strip("exact.recoil_speed_m_s", "recoil speed of the exact solution", "m/s", "plan.string.rear_speed_m_s"),
    _strip("exact.front_speed_m_s", "speed of that front in it", "m/s", "exact_front_speed_m_s"),
    _strip("exact.arrival_s", "arrival of that front in it", "s", "exact_arrival_s"),
    _strip("momentum_n_s", "momentum of the strip at the end", "N s", label="momentum at the end"),
    _strip("impulse_n_s", "impulse of the held end until then", "N s"),
    _strip("series.t_s", "times", "s", "strip.times_s", kind="series"),
    _strip("series.pull_n", "pull of the held end, mean over each interval", "N", "strip.pull_n", kind="series"),
    _strip("series.momentum_n_s", "momentum of the strip", "N s", "strip.momentum_n_s", kind="series"),
]  # fmt: skip


def register(one: Observable) -> Observable:
    """Add a result to the table; ValueError for a key or column that it holds already, or for an unknown kind."""
    if one.kind not in _TYPES or one.level not in LEVELS:
        raise ValueError(
            f"{one.key!r}: kind {one.kind!r} and level {one.level!r}; known: {sorted(_TYPES)}, {(*LEVELS,)}"
        )
    if any(one.key == other.key or (one.column and one.column == other.column) for other in _TABLE):
        raise ValueError(f"there is a result {one.key!r} already")
    _TABLE.append(one)
    return one


def observable(
    key: str, sentence: str, unit: str = "", level: str = "rear", error: bool = False, label: str | None = None
) -> Callable[[Callable[[Any], Any]], Callable[[Any], Any]]:
    """Add a scalar of your own: a function of the result that gives a number, None, or a value with its error.

    What a rear alone gives (``level="rear"``) has a column in sweeps, named like the key.
    """

    def add(source: Callable[[Any], Any]) -> Callable[[Any], Any]:
        more: dict[str, Any] = {"column": key.replace(".", "_") if level == "rear" else "", "label": label or sentence}
        register(Observable(key, sentence, unit, source, "number", level, error, True, **more))
        return source

    return add


def forget(key: str) -> None:
    """Take a result out of the table again; nothing happens where it is not in it."""
    _TABLE[:] = [one for one in _TABLE if one.key != key]


def table(level: str | None = None) -> tuple[Observable, ...]:
    """The observables of a result of this level, or all."""
    return tuple(one for one in _TABLE if level is None or one.level in LEVELS[level])


def as_dict(result: Any) -> dict[str, Any]:
    """What results.json holds of a result."""
    values: dict[str, Any] = {}
    for one in table(result.level):
        *path, name = one.key.split(".")
        place: Any = values
        for step in path:
            place = None if place is None else place.setdefault(step, {})
        if place is None:
            continue
        value, error = one.measured(result)
        if value is None and one.optional:
            continue
        if one.kind == "object" and value is not None and any(other.key.startswith(f"{one.key}.") for other in _TABLE):
            place[name] = {}
            continue
        place[name] = _plain(value)
        if error is not None:
            place[error_key(name)] = error
    return values


@dataclass(frozen=True)
class Column:
    """A column in the table of a sweep."""

    name: str
    kind: str  # "number", "integer" or "text"
    sentence: str
    unit: str = ""


def columns() -> tuple[Column, ...]:
    """Columns of what a release gave in the table of a sweep, each error behind its value."""
    found = []
    for one in (one for one in table("rear") if one.column):
        name, *errors = _names(one, one.column)
        flag = one.kind == "flag"
        found.append(Column(name, "text" if flag else one.kind, one.sentence + (": yes or no" * flag), one.unit))
        found += [Column(error, "number", f"error of {name}", one.unit) for error in errors]
    return tuple(found)


def _names(one: Observable, name: str) -> list[str]:
    return [name, error_key(name)] if one.error else [name]


def row(result: Any) -> dict[str, Any]:
    """The columns of a result: numbers, texts, yes or no; what it does not have is left out."""
    found: dict[str, Any] = {}
    for one in (one for one in table("rear") if one.column):
        value, error = one.measured(result)
        if one.kind == "flag":
            value = "yes" if value else "no"
        if value is not None or one.kind == "text":
            found[one.column] = "" if value is None else value
        if error is not None:
            found[error_key(one.column)] = error
    return found


def get(values: Mapping[str, Any], key: str) -> Any:
    """A value of results.json by its key; None where it is missing."""
    found: Any = values
    for name in key.split("."):
        found = found.get(name) if isinstance(found, Mapping) else None
    return found


Special = Mapping[str, Callable[[Mapping[str, Any]], "str | None"]]
"""Texts of rows that say more than one value, by the key of the first."""


def rows(values: Mapping[str, Any], special: Special | None = None) -> list[tuple[str, str]]:
    """What results.json says, as names and texts with errors; a launch's own rows first."""
    found = []
    for one in sorted((one for one in _TABLE if one.label), key=lambda one: one.level not in _SECTIONS):
        if one.level in _SECTIONS and one.level not in values:
            continue
        text = special[one.key](values) if special and one.key in special else text_of(values, one.key)
        if text is not None:
            found.append((str(one.label), text))
    return found


def text_of(values: Mapping[str, Any], key: str) -> str | None:
    """The row of one value of results.json; None where there is none to show."""
    one = next(one for one in _TABLE if one.key == key)
    value = get(values, key)
    if value is None:
        return one.absent
    return None if one.kind == "object" else one.text(value, get(values, error_key(key)))


def as_html(result: Any) -> str:
    """A result as a table, for notebooks."""

    values = as_dict(result)
    listed = [*rows(values), *(("note", sentence) for sentence in values["warnings"])]
    from html import escape

    body = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in listed)
    return f"<table>{body}</table>"


def json_schema() -> dict[str, Any]:
    """JSON Schema of results.json."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "results.json of beadband"}
    schema: dict[str, Any] = {**head, "type": "object"}
    for one in _TABLE:
        *path, name = one.key.split(".")
        place = schema
        for step in path:
            if one.level not in _SECTIONS:
                _require(place, step)
            place = place.setdefault("properties", {}).setdefault(step, {"type": "object"})
        unit = f", {one.unit}" if one.unit else ""
        kind = _TYPES[one.kind]
        null = {"type": [kind["type"], "null"]} if one.null else {}
        given = place.setdefault("properties", {})
        given[name] = {**kind, **null, "description": one.sentence + unit}
        if one.error:
            given[error_key(name)] = {"type": "number", "description": f"error of {name}{unit}"}
        if not one.optional and (one.level not in _SECTIONS or path[:1] == [one.level]):
            _require(place, name)
    return schema


def _require(place: dict[str, Any], name: str) -> None:
    required = place.setdefault("required", [])
    if name not in required:
        required.append(name)


_HEAD = """# Results

Made by `make docs` from the table in `beadband/observables.py`. The same table gives
[the JSON Schema](results.schema.json) of `results.json`, the columns of a sweep and the summaries.
An observable of your own is one function: see [extending](extending.md).

Keys of `results.json`; dots separate its levels. An error stands beside its value, under the same name
with `error` before the unit. `launch` and `energy.contact_j` are present only with `--until launch`, `strip`
only with `--shape strip`, whose rebound speed is the recoil speed of its released end.

| key | unit | what it is | column of a sweep |
|---|---|---|---|"""


_COLUMNS_HEAD = """
## Columns of a sweep

Before them stand `key`, the scene as JSON, and a column for each option of the grid; behind them `status`,
`reason` and `reason_code` (text). `manifest.json` in the folder of a sweep describes all of them.

| column | kind | unit | what it is |
|---|---|---|---|"""


def as_markdown() -> str:
    """The dictionary of results and columns, for the documents."""
    lines = [_HEAD]
    for one in _TABLE:
        name, column = (
            ", ".join(f"`{each}`" for each in _names(one, of)) if of else ""
            for of in (one.key, one.column if one.level == "rear" else "")
        )
        remark = " (may be null)" if one.null else ""
        remark = remark or (" (left out where there is none)" if one.optional else "")
        lines.append(f"| {name} | {one.unit} | {one.sentence}{remark} | {column} |")
    lines.append(_COLUMNS_HEAD)
    lines += [f"| `{one.name}` | {one.kind} | {one.unit} | {one.sentence} |" for one in columns()]
    return "\n".join(lines) + "\n"
