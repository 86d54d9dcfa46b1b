"""Everything that a scene is made of, once: names, units, ranges, flags, help, and who uses what.

From this table come the options of the command line, the keys of a scene file and of a grid, the checks with their
messages, and the table of parameters in the documents. A law adds its constants when it is registered
(:mod:`beadband.model.laws`). Pure standard library, so that ``--help`` is quick.
"""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from beadband.errors import UsageError, explain

COMMANDS = ("plan", "run", "ask", "find", "sweep", "sensitivity", "design", "pareto")
"""Commands that take a scene."""
_RUNS = ("plan", "run")
_PLANNED = ("plan", "run", "sweep")
_TOLERANT = ("plan", "run", "ask", "find", "sweep", "sensitivity", "design")
UNUSED = "unused-parameter"
"""Code of the error for a parameter that was given and that nothing uses."""
FEWEST_BEADS = 24
"""Beads of a ring below which it can't be wrapped around its finger."""
MOST_STEPS = 2_000_000_000
AUTO = "auto"
"""Tolerance of a fifth of what the inputs' errors make of the speed."""
GIVEN = "given"
"""What a parameter must be that another needs to have a value, whichever."""
_UNITS = ("_kg_m3", "_n_s_m", "_m_s", "_deg", "_rad", "_pa", "_m2", "_m4", "_n_m", "_n", "_kg", "_m", "_s")


@dataclass(frozen=True)
class Parameter:
    """One value of a scene."""

    key: str
    """Its name in scene files, results and Python: with its unit."""
    kind: str
    """"number", "numbers" (one or several), "count" (a whole number), "word" (one of a list), "name" (any text) or
    "path" (of a file)."""
    help: str
    symbol: str = ""
    unit: str = ""
    default: Any = None
    """Value of a scene that does not give it; None where the band, the law or the plan has one."""
    section: str = "scene"
    """"scene", "hand", "flight", "band", "law", "plan" (left open, the plan chooses it) or "record" (only in files)."""
    above: float = -math.inf
    below: float = math.inf
    least: float = -math.inf
    most: float = math.inf
    """Open (``above``, ``below``) and closed ends of the allowed range."""
    usual: tuple[float, float] | None = None
    """Values outside are computed, with a note: they are rarely meant."""
    words: tuple[str, ...] = ()
    commands: tuple[str, ...] = COMMANDS
    """Commands that use it; the others refuse it."""
    only: Mapping[str, str] | None = None
    """What other parameters must be for this one to be used, as in {"until": "launch"}."""
    laws: tuple[str, ...] = ()
    """Of a constant: the laws that use it."""
    metavar: str = "X"
    name: str = ""
    """Its option, where that is not the key without its unit."""

    @property
    def option(self) -> str:
        """Its name without the unit, as flags and Python keywords have it."""
        if self.name:
            return self.name
        for unit in _UNITS:
            if self.key.endswith(unit):
                return self.key.removesuffix(unit)
        return self.key

    @property
    def flag(self) -> str:
        """Its flag on the command line."""
        return "--" + self.option.replace("_", "-")

    @property
    def allowed(self) -> str:
        """Its range in words."""
        if self.kind in ("name", "path"):
            return "a name" if self.kind == "name" else "a file"
        if self.kind == "word":
            return ", ".join(words(self.key))
        unit = f" {self.unit}" if self.unit else ""
        ends = [
            *([f"above {self.above:g}{unit}"] if math.isfinite(self.above) else []),
            *([f"{self.least:.12g}{unit} or more"] if self.least > -math.inf and self.most == math.inf else []),
            *([f"below {self.below:g}{unit}"] if math.isfinite(self.below) else []),
        ]
        if math.isfinite(self.least) and math.isfinite(self.most):
            ends.append(f"{self.least:.12g} to {self.most:.12g}{unit}")
        noun = "a whole number" if self.kind == "count" else "a finite number"
        return f"{noun}{', ' if ends else ''}{' and '.join(ends)}"

    def holds(self, value: float) -> bool:
        """Whether a number lies in the range; NaN does not."""
        return self.above < value < self.below and self.least <= value <= self.most and math.isfinite(value)


_RING: Mapping[str, str] = {"shape": "ring"}


def _launch(**more: Any) -> Mapping[str, str]:
    return {"until": "launch", **more}


def _hand(key: str, text: str, symbol: str, unit: str, **more: Any) -> Parameter:
    """A number of a finger that moves in a launch."""
    metavar = unit.upper().replace("/", "_").replace(" ", "_")
    about: dict[str, Any] = {"section": "hand", "commands": _RUNS, "only": _launch(finger="stays"), "metavar": metavar}
    return Parameter(f"hand_{key}", "number", text, symbol, unit, **about, **more)


@dataclass(frozen=True)
class Uncertain:
    """A number with its standard uncertainty, in the same unit."""

    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.value:g} +/- {self.error:g}"


_UNCERTAIN = re.compile(r"^\s*(?P<value>\S+?)\s*(?:\+/-|\+-|±)\s*(?P<error>\S+?)\s*(?P<share>%?)\s*$")


def uncertain(key: str, given: Any) -> tuple[Any, float | None]:
    """A value and its standard uncertainty, None where it was given without one.

    Numbers with an uncertainty are :class:`Uncertain`, tables {value, error}, and texts "2.0e-3 +/- 5e-5" or
    "2.0e-3 +/- 2.5%"; everything else comes back as it is. UsageError for a malformed uncertainty, or where this
    parameter can't have one.
    """
    found = _UNCERTAIN.match(given) if isinstance(given, str) else None
    if isinstance(given, Uncertain):
        value, error = given.value, given.error
    elif isinstance(given, Mapping):
        if given.keys() != {"value", "error"}:
            raise UsageError(explain(f"{key} is not a number with an error", given, "{value, error}", "correct it"))
        value, error = given["value"], given["error"]
    elif found:
        try:
            value, error = float(found["value"]), float(found["error"])
        except ValueError:
            raise UsageError(
                explain(f"{key} is not a number with an error", repr(given), "V +/- E or V +/- P%", "correct it")
            ) from None
        error *= 0.01 * abs(value) if found["share"] else 1.0
    else:
        return given, None
    one = TABLE[key]
    if one.kind not in ("number", "numbers") or one.section not in ("scene", "band", "law") or one.key == "tolerance":
        raise UsageError(explain(f"{one.flag} takes no uncertainty", given, one.allowed, "give the value alone"))
    if isinstance(error, bool) or not isinstance(error, (int, float)) or not 0.0 <= error < math.inf:
        raise UsageError(
            explain(f"the uncertainty of {key} is out of range", error, "a finite number, 0 or more", "correct it")
        )
    return value, float(error)


TABLE: dict[str, Parameter] = {
    one.key: one
    for one in (
        Parameter("band", "name", "a band of the catalogue", default="III", metavar="NAME"),
        Parameter("band_file", "name", "a file of your own bands, one of which --band chooses", metavar="FILE.toml"),
        Parameter("shape", "word", "a band around a finger, or a straight strip that is held at both ends and released "
                  "at one", default="ring", words=("ring", "strip"), commands=_TOLERANT),
        Parameter("strain", "number", "uniform strain of the held band", "ε", default=0.476, above=0.0, below=10.0),
        Parameter("half_angle_deg", "number", "half-angle of the wedge", "φ", "deg", 14.0,
                  above=0.0, below=90.0, only=_RING, metavar="DEG"),
        Parameter("law", "word", "material law", default="mooney-rivlin", metavar="NAME"),
        Parameter("until", "word", "end of the run", default="release", words=("release", "launch"), commands=_RUNS,
                  only=_RING),
        Parameter("tolerance", "number", "wanted relative error of V; auto: a fifth of its error from the inputs",
                  default=0.005, above=0.0, below=0.5, commands=_TOLERANT),
        Parameter("inputs", "word", "errors of a catalogue band: those given, or also the rounding of its printed "
                  "digits", default="given", words=("given", "as-printed"),
                  commands=("plan", "run", "ask", "sensitivity")),
        Parameter("samples", "count", "random draws of the inputs, in addition to derivatives, for large errors",
                  default=0, least=0, most=100_000, commands=("run",), metavar="N"),
        Parameter("for", "word", "what the plan must get right; of a strip always the speed", default="curvature",
                  words=("curvature", "speed"), commands=_PLANNED),
        Parameter("bending_modulus", "word", "modulus in EI: E of the table, or E0 at rest", default="table",
                  words=("table", "rest"), only=_RING),
        Parameter("bending_scale", "number", "factor on EI; 0 leaves bending out", default=1.0, least=0.0, only=_RING),
        Parameter("tip_radius_m", "number", "radius of the round peg that holds the tip, to the middle of the band; "
                  "0 for a point", "r", "m", default=0.0, least=0.0, commands=_TOLERANT,
                  only={"until": "release", **_RING}, metavar="M"),
        Parameter("finger", "word", "it stays, or is taken away once it carries no load", default="stays",
                  words=("stays", "clears"), commands=_RUNS, only=_launch()),
        Parameter("flight_s", "number", "time of flight after the rear has reached the place of the finger", unit="s",
                  section="flight", default=0.0, least=0.0, commands=_RUNS, only=_launch(finger="clears"), metavar="S"),
        Parameter("self_contact", "word", "contact between parts of the band that meet; off: they pass through "
                  "each other", default="on", words=("on", "off"), commands=_RUNS, only=_launch()),
        Parameter("elevation_deg", "number", "angle of the throw above the horizontal; with it the flight is computed, "
                  "to the ground and in air", unit="deg", section="flight", above=-90.0, below=90.0, commands=_RUNS,
                  only=_launch(), metavar="DEG"),
        Parameter("height_m", "number", "height of the throw above the ground", unit="m", section="flight", default=0.0,
                  least=0.0, commands=_RUNS, only=_launch(elevation_deg=GIVEN), metavar="M"),
        Parameter("air_density_kg_m3", "number", "density of the air; 0 leaves it out", unit="kg/m3", section="flight",
                  default=1.2, least=0.0, commands=_RUNS, only=_launch(elevation_deg=GIVEN), metavar="KG_M3"),
        Parameter("drag_coefficient", "number", "drag coefficient across the band; by default that of its section",
                  "Cd", section="flight", least=0.0, commands=_RUNS, only=_launch(elevation_deg=GIVEN)),
        _hand("mass_kg", "mass of a finger that the band moves", "M", "kg", above=0.0),
        _hand("stiffness_n_m", "spring of that finger, slack before the release", "K", "N/m", least=0.0),
        _hand("damping_n_s_m", "damper of that finger", "D", "N s/m", least=0.0),
        _hand("preload_n", "constant push of that finger (default: the band's pull at rest)", "F", "N"),
        _hand("velocity_m_s", "velocity of the finger along the throw, kept from the release on", "", "m/s"),
        Parameter("circumference_m", "number", "circumference of the unstretched band, or length of a strip", "Cb", "m",
                  section="band", above=0.0, usual=(5e-3, 5.0), metavar="M"),
        Parameter("section", "word", "cross section", section="band", default=None,
                  words=("rectangle", "circle", "square", "tube", "given")),
        Parameter("width_m", "number", "width of a rectangular section", "b", "m", section="band",
                  above=0.0, usual=(1e-4, 0.2), metavar="M"),
        Parameter("thickness_m", "number", "thickness, or outer diameter", "h", "m", section="band",
                  above=0.0, usual=(5e-5, 0.03), metavar="M"),
        Parameter("wall_m", "number", "wall of a tube", "", "m", section="band", above=0.0, usual=(5e-5, 0.01),
                  metavar="M"),
        Parameter("area_m2", "number", "area of a given section", "A", "m2", section="band", above=0.0,
                  usual=(1e-9, 1e-3), metavar="M2"),
        Parameter("second_moment_m4", "number", "second moment of a given section", "I", "m4", section="band",
                  above=0.0, usual=(1e-18, 1e-7), metavar="M4"),
        Parameter("density_kg_m3", "number", "density", "ρ", "kg/m3", section="band",
                  above=0.0, usual=(300.0, 4000.0), metavar="KG_M3"),
        Parameter("modulus_pa", "number", "Young's modulus E of the table; of the linear law, its only constant", "E",
                  "Pa", section="band", above=0.0, usual=(1e4, 1e9), metavar="PA"),
        Parameter("softening_r", "number", "Mullins softening of Ogden and Roxburgh: the smaller, the softer", "r",
                  section="law", above=1.0),
        Parameter("softening_m_pa", "number", "energy density over which the rubber softens", "m", "Pa", section="law",
                  least=0.0, metavar="PA"),
        Parameter("softening_beta", "number", "the same as a share of the energy density at the held stretch", "β",
                  section="law", least=0.0),
        Parameter("beads", "count", "beads of the whole ring, or bonds of the strip", section="plan",
                  least=FEWEST_BEADS, most=2_000_000, commands=_PLANNED, metavar="N"),
        Parameter("timestep_s", "number", "time step", "Δt", "s", section="plan", above=0.0, commands=_PLANNED,
                  metavar="S"),
        Parameter("loss_time_s", "number", "loss time of the material, instead of a numerical one", "τ", "s",
                  section="plan", least=0.0, commands=_PLANNED, metavar="S"),
        Parameter("frames", "count", "frames of the whole ring in the trajectory", section="plan", least=1,
                  most=100_000, commands=_RUNS, metavar="N"),
        Parameter("steps", "count", "steps of the run", section="record", least=1, most=MOST_STEPS, commands=_RUNS),
        Parameter("rear_steps", "count", "steps between frames of the rear", section="record", least=1,
                  most=MOST_STEPS, commands=_RUNS),
    )
}  # fmt: skip
"""Every parameter by its key, in the order of help and files."""

PLANNED = tuple(one.key for one in TABLE.values() if one.section == "plan" or one.key in ("steps", "rear_steps"))
"""What a plan chooses where a scene leaves it open."""

_words: dict[str, list[str]] = {"law": []}
"""Words that are registered while the program runs: the names of the laws."""


def words(key: str) -> tuple[str, ...]:
    """Words that a parameter allows at this moment."""
    return TABLE[key].words or tuple(_words.get(key, ()))


def add_word(key: str, word: str) -> None:
    """Allow another word."""
    if word not in _words[key]:
        _words[key].append(word)


def add_constant(constant: Parameter) -> None:
    """Add a constant of a law; one that several laws share lists them all, and its range is wide enough for each."""
    known = TABLE.get(constant.key)
    if known is None:
        TABLE[constant.key] = constant
        return
    if known.section not in ("law", "band") or known.unit != constant.unit:
        raise ValueError(f"the constant {constant.key!r} means something else already ({known.help}, {known.unit})")
    both = tuple(dict.fromkeys((*known.laws, *constant.laws)))
    kind = "numbers" if "numbers" in (known.kind, constant.kind) else known.kind
    own = known.help if known.section == "band" or constant.help in known.help else f"{known.help}; {constant.help}"
    above, below = min(known.above, constant.above), max(known.below, constant.below)
    TABLE[constant.key] = replace(known, laws=both, kind=kind, help=own, above=above, below=below)


def defaults() -> dict[str, Any]:
    """Values of a scene that gives nothing."""
    return {one.key: one.default for one in TABLE.values() if one.default is not None}


def key_of(name: str) -> str | None:
    """The key that a name stands for: the key itself or the key without its unit, with - or _; None if unknown."""
    plain = name.replace("-", "_")
    if plain in TABLE:
        return plain
    return next((one.key for one in TABLE.values() if one.option == plain), None)


def checked(key: str, value: Any, one: Parameter | None = None) -> Any:
    """The value of a parameter as its kind has it; UsageError for one of another kind or out of range.

    ``one`` stands for the table's entry: a law may ask more of a constant than the table, which serves all laws.
    """
    one = one or TABLE[key]
    if key == "tolerance" and value == AUTO:
        return value
    if one.kind in ("word", "name"):
        if not isinstance(value, str) or (one.kind == "word" and value not in words(key)):
            raise UsageError(explain(f"unknown value of {one.flag}", repr(value), one.allowed, f"change {one.flag}"))
        return value
    if one.kind == "path":
        if not isinstance(value, (str, os.PathLike)) or not os.fspath(value):
            raise UsageError(explain(f"{one.flag} names no file", repr(value), one.allowed, f"change {one.flag}"))
        return os.fspath(value)
    if isinstance(value, (list, tuple)):
        many = one.kind == "numbers"
        if many and value:
            return tuple(_number(one, each) for each in value)
        if len(value) != 1:
            count = "one number or more" if many else "one number"
            under = f" under the law {one.laws[0]}" if len(one.laws) == 1 else ""
            raise UsageError(
                explain(f"{one.key} takes {count}{under}", list(value), one.allowed, f"give {one.flag} {count}")
            )
        value = value[0]
    return _number(one, value)


def _number(one: Parameter, value: Any) -> float | int:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise UsageError(explain(f"{one.key} is not a number", repr(value), one.allowed, f"change {one.flag}"))
    if not one.holds(value) or (one.kind == "count" and value != int(value)):
        raise UsageError(explain(f"{one.key} is out of range", f"{value:.12g}", one.allowed, f"change {one.flag}"))
    return int(value) if one.kind == "count" else float(value)


def parsed(key: str, text: str) -> Any:
    """The value of a flag's text, :class:`Uncertain` where it has an error; UsageError as :func:`checked`."""
    one = TABLE[key]
    if one.kind == "path":
        return checked(key, text)
    value, error = uncertain(key, text)
    if error is not None:
        return Uncertain(checked(key, value), error)
    if one.kind in ("word", "name") or (key == "tolerance" and text == AUTO):
        return checked(key, text)
    parts = text.split(",") if one.kind == "numbers" else [text]
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise UsageError(explain(f"{one.key} is not a number", repr(text), one.allowed, f"change {one.flag}")) from None
    return checked(key, numbers[0] if len(numbers) == 1 else numbers)


def used_by(command: str) -> list[Parameter]:
    """Parameters that are options of a command."""
    return [one for one in TABLE.values() if command in one.commands and one.section != "record"]


def refuse_unused(command: str, given: Mapping[str, Any]) -> None:
    """Refuse what a command does not use; UsageError that names it."""
    for key, value in given.items():
        one = TABLE.get(key)
        if one is not None and command not in one.commands:
            raise UsageError(
                explain(
                    f"{one.flag} is not used by 'beadband {command}'",
                    f"{one.flag} {value}",
                    f"{one.flag} with {', '.join(one.commands)}",
                    "leave it out",
                ),
                UNUSED,
            )


def refuse_errors(command: str, values: Mapping[str, Any]) -> None:
    """Refuse numbers with an error for a command that does not use it; UsageError that names the first."""
    if command in TABLE["inputs"].commands:
        return
    if values.get("covariance") is not None:
        allowed = f"{', '.join(TABLE['inputs'].commands)} take errors"
        raise UsageError(
            explain(f"'beadband {command}' does not use errors of inputs", "a covariance", allowed, "leave it out")
        )
    for key, value in values.items():
        for each in value if isinstance(value, (list, tuple)) else (value,):
            if key in TABLE and uncertain(key, each)[1] is not None:
                flag, allowed = TABLE[key].flag, f"{', '.join(TABLE['inputs'].commands)} take errors"
                raise UsageError(
                    explain(
                        f"'beadband {command}' does not use errors of inputs", f"{flag} {each}", allowed, "leave it out"
                    )
                )


def nearest_flags(flags: Iterable[str], command: str) -> str:
    """Advice on flags that a command does not know: those that are spelt most like them."""
    import difflib

    known = [one.flag for one in used_by(command)]
    near = [match for flag in flags for match in difflib.get_close_matches(flag, known, 1)]
    return f"did you mean {' '.join(near)}?" if near else "leave them out"


def add_arguments(parser: argparse.ArgumentParser, command: str, grid: bool = False) -> None:
    """Give a command the options of a scene; with ``grid`` each takes many values. Unset ones leave no attribute.

    Texts are taken as they are: :func:`parsed` makes values of them, with the messages of this table.
    """
    # A number like -2.4e4 is a value, not a flag.
    parser._negative_number_matcher = re.compile(r"^-(\d|\.\d)[\d.eE+:,-]*$")
    about = "each a value, a list A,B,C, or a range FIRST:LAST:COUNT with both ends" if grid else None
    groups: dict[str, Any] = {}
    titles = {
        "scene": "grid" if grid else "scene",
        "hand": "a finger that moves",
        "flight": "the flight of a launch",
        "band": "band",
        "law": "constants of a law",
        "plan": "plan",
    }
    for section, title in titles.items():
        groups[section] = parser.add_argument_group(title, about if section == "scene" else None)
    name = "grid" if grid else "scene"
    groups["scene"].add_argument(f"--{name}", metavar="FILE.toml", help=f"read the {name} from a file; flags win")
    for one in used_by(command):
        groups[one.section].add_argument(
            one.flag,
            dest=f"parameter {one.key}",
            metavar="VALUES" if grid else one.metavar if one.kind != "word" else "|".join(words(one.key)),
            default=argparse.SUPPRESS,
            help=_help(one),
        )


def _help(one: Parameter) -> str:
    notes = [
        *(["one number or a list A,B,…"] if one.kind == "numbers" else []),
        *([f"laws: {', '.join(one.laws)}"] if one.laws else []),
        *([f"with {', '.join(f'{k} {v}' for k, v in one.only.items())}"] if one.only else []),
        *([f"default: {one.default}"] if one.default not in (None, 0.0) else []),
        *(["default: chosen by the plan"] if one.section == "plan" else []),
    ]
    return (one.help + (f" ({'; '.join(notes)})" if notes else "")).replace("%", "%%")


def given(arguments: argparse.Namespace) -> dict[str, str]:
    """The options of a scene that were given, as texts by their keys."""
    mark = "parameter "
    return {name.removeprefix(mark): text for name, text in vars(arguments).items() if name.startswith(mark)}


def by_key(options: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments by the keys of the table; UsageError for an unknown name."""
    values = {}
    for name, value in options.items():
        key = key_of(name)
        if key is None:
            import difflib

            names = [one.option for one in TABLE.values()]
            near = difflib.get_close_matches(name, names, 1)
            advice = f"did you mean {near[0]}?" if near else "correct the name"
            raise UsageError(explain("unknown parameter", repr(name), ", ".join(names), advice))
        values[key] = value
    return values


def as_markdown() -> str:
    """The table for the documents."""
    lines = [
        "# Parameters",
        "",
        "Made by `make docs` from the table in `beadband/parameters.py`, which also gives the options of the command",
        "line, the keys of scene files and grids, and every check. Python keywords are the flags without dashes, as in",
        "`half_angle=14`, or the keys. In a scene file `[band]` and `[law]` may be tables of their own.",
        "",
        'Numbers of a scene, a band or a law may have a standard uncertainty: `"2.0e-3 +/- 5e-5"` or',
        '`"2.0e-3 +/- 2.5%"`, in a file also `{ value = 2.0e-3, error = 5e-5 }`. An option that the command, the law',
        "or the rest of the scene does not use is refused.",
        "",
        "| flag | key in files | meaning | unit | allowed | default | used by |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in TABLE.values():
        default = "the plan's" if one.section == "plan" else "" if one.default is None else f"{one.default}"
        users = [
            ", ".join(one.commands),
            *([f"laws: {', '.join(one.laws)}"] if one.laws else []),
            *([f"only with {', '.join(f'`{k} = {v}`' for k, v in one.only.items())}"] if one.only else []),
        ]
        flag = "" if one.section == "record" else f"`{one.flag}`"
        symbol = f", {one.symbol}" if one.symbol and one.symbol not in one.help.split() else ""
        lines.append(
            f"| {flag} | `{one.key}` | {one.help}{symbol} | {one.unit} | {one.allowed} | {default} | "
            f"{'; '.join(users)} |"
        )
    return "\n".join(lines) + "\n"
