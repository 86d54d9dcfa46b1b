"""Which inputs of a scene vary, and over what: ranges, errors and choices, and the scenes made of points in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.model.bands import known_values
from beadband.model.scene import Scene, scene_of
from beadband.model.uncertainty import inputs_of
from beadband.parameters import AUTO, PLANNED, TABLE, checked, key_of, parsed, uncertain

Array = NDArray[np.float64]

CHOICES = ("band", "law", "bending_modulus")
"""Words among which a study may choose."""
SPANNED = ("circumference_m", "width_m", "thickness_m", "density_kg_m3", "modulus_pa")
"""Numbers of the catalogue's bands that have a range of their own; the constants of the law go together."""

_SHOWN = {"m": (1e3, "mm"), "Pa": (1e-6, "MPa")}
"""Factor and unit in which a person reads numbers of these units."""


@dataclass(frozen=True)
class Range:
    """One input: evenly between two numbers, normal about one, or one of several words alike."""

    key: str
    low: float = 0.0
    high: float = 0.0
    error: float | None = None
    """Standard uncertainty of a normal input; ``low`` and ``high`` are then one of them below and above its mean."""
    words: tuple[str, ...] = ()
    label: str = ""
    """What it is called, where that is not its option."""

    @property
    def option(self) -> str:
        """Its name as flags have it."""
        return self.label or TABLE[self.key].option.replace("_", "-")

    def at(self, places: Array) -> NDArray[Any]:
        """Its values at places from 0 to 1, shape (scenes,)."""
        if self.words:
            chosen: NDArray[Any] = np.array(self.words)[(places * len(self.words)).astype(int)]
            return chosen
        if self.error is not None:
            from scipy.special import ndtri

            # Places stay within 8 standard deviations: a place of 0 has no value.
            found: NDArray[Any] = 0.5 * (self.low + self.high) + self.error * ndtri(np.clip(places, 1e-15, 1.0 - 1e-15))
            return found
        between: Array = self.low + (self.high - self.low) * places
        return between

    def __str__(self) -> str:
        if self.words:
            return ", ".join(self.words)
        factor, unit = _SHOWN.get(TABLE[self.key].unit, (1.0, TABLE[self.key].unit))
        if self.error is not None:
            text = f"{0.5 * factor * (self.low + self.high):.6g} +/- {factor * self.error:.3g}"
        else:
            text = f"{factor * self.low:.6g} to {factor * self.high:.6g}"
        return f"{text} {unit}".rstrip()

    def shown(self, value: Any) -> str:
        """One of its values as a person reads it."""
        if isinstance(value, str):
            return value
        factor, unit = _SHOWN.get(TABLE[self.key].unit, (1.0, TABLE[self.key].unit))
        return f"{factor * value:.6g} {unit}".rstrip()

    def as_dict(self) -> dict[str, Any]:
        """The range as JSON has it."""
        if self.words:
            return {"words": list(self.words)}
        if self.error is not None:
            return {"value": 0.5 * (self.low + self.high), "error": self.error}
        return {"low": self.low, "high": self.high}


def varied(given: Mapping[str, Any]) -> list[Range]:
    """Ranges by the names of options: text "0.2:1.2", "I,II" or "2e-3 +/- 5e-5", a pair (low, high), or listed words.

    UsageError for a name or range that can't be varied.
    """
    found = [_range(name, value) for name, value in given.items()]
    names = [one.key for one in found]
    for name in names:
        if names.count(name) > 1:
            raise _wrong("an input is varied twice", TABLE[name].flag, "each once", "leave one out")
    return found


def named(texts: Sequence[str], flag: str) -> dict[str, str]:
    """What several ``--vary NAME=RANGE`` or ``--keep NAME=VALUE`` give; UsageError for other texts, or a name twice."""
    found: dict[str, str] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or name in found:
            wrong = f"{flag} names one thing twice" if sign else f"{flag} names no value"
            raise _wrong(wrong, repr(text), "NAME=VALUE, each name once", "correct it")
        found[name] = value
    return found


def _wrong(what: str, given: object, allowed: str, advice: str) -> UsageError:
    return UsageError(explain(what, given, allowed, advice))


def _range(name: str, given: Any) -> Range:
    key = key_of(name.removeprefix("--"))
    one = TABLE.get(key or "")
    numeric = one is not None and one.kind in ("number", "numbers") and one.section in ("scene", "band", "law")
    if key is None or one is None or key in ("tolerance", "flight_s") or not (numeric or key in CHOICES):
        names = [each.option for each in TABLE.values() if each.kind == "number" and each.section in ("scene", "band")]
        names = [each for each in names if each not in ("tolerance", "flight")]
        raise _wrong(
            "this input can't be varied", repr(name), f"{', '.join(names)}, constants of the law, band", "change it"
        )
    if key in CHOICES:
        words = tuple(given.split(",")) if isinstance(given, str) else tuple(given)
        for word in words:
            checked(key, word)
            if key == "band":
                known_values(word)
        if len(set(words)) < max(2, len(words)):
            raise _wrong(f"{one.flag} has nothing to choose from", words, "two different words or more", "add some")
        return Range(key, words=words)
    value, error = uncertain(key, given) if isinstance(given, str) else (given, None)
    if error is not None:
        value = checked(key, value)
        if not error > 0.0:
            raise _wrong(f"{one.flag} does not vary", given, "an uncertainty above 0", "change it")
        return Range(key, value - error, value + error, error)
    ends = given.split(":") if isinstance(given, str) else given
    if not isinstance(ends, (list, tuple)) or len(ends) != 2:
        raise _wrong(f"{one.flag} is given no range", repr(given), "LOW:HIGH, or VALUE +/- ERROR", "change it")
    low, high = (parsed(key, end) if isinstance(end, str) else checked(key, end) for end in ends)
    low, high = (end[0] if isinstance(end, tuple) else end for end in (low, high))
    if not low < high:
        raise _wrong(f"the range of {one.flag} is empty", repr(given), "a lower end below the upper one", "swap them")
    return Range(key, float(low), float(high))


def spans(names: Sequence[str]) -> list[Range]:
    """What bands of the catalogue span: their sizes, density and E each from the least to the most, and the choice
    among their rubbers, whose constants go together. UsageError for an unknown band, or one alone."""
    bands = [known_values(name) for name in names]
    found = []
    for key in SPANNED:
        values = [band[key] for band in bands if band.get(key) is not None]
        if len(values) == len(bands) and min(values) < max(values):
            found.append(Range(key, min(values), max(values)))
    (band,) = varied({"band": list(names)})
    return [*found, replace(band, label="rubber")]


def errors_of(scene: Scene) -> list[Range]:
    """The inputs of a scene that have an error, normal; UsageError for a covariance: its inputs are not independent."""
    if scene.covariance:
        raise _wrong(
            "the inputs are not independent", "a covariance", "errors of single inputs", "leave the covariance out"
        )
    inputs = inputs_of(scene)
    if inputs is None:
        return []
    for name in inputs.names:
        if "[" in name:
            raise _wrong("one constant of a list can't be varied", name, "constants that are one number", "change it")
    triples = zip(inputs.names, inputs.values.tolist(), inputs.errors.tolist(), strict=True)
    return [Range(name, value - error, value + error, error) for name, value, error in triples]


@dataclass(frozen=True)
class Box:
    """A scene with some of its inputs varied."""

    values: Mapping[str, Any]
    """Those that stay, by their keys."""
    ranges: tuple[Range, ...]
    by_band: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """What each band that is chosen among brings with it, by its name."""

    def at(self, places: Array) -> dict[str, Any]:
        """Values of scenes at places from 0 to 1 in the ranges, shape (scenes, ranges): arrays for what varies."""
        columns = {one.key: one.at(places[:, index]) for index, one in enumerate(self.ranges)}
        for key in next(iter(self.by_band.values()), ()):
            brought = np.array([self.by_band[name][key] for name in self.by_band])
            columns[key] = brought[[list(self.by_band).index(name) for name in columns["band"]]]
        return {**self.values, **columns}


def box_of(values: Mapping[str, Any], ranges: Sequence[Range]) -> Box:
    """The scene of ``values`` with the ranges and its own errors varied; UsageError where an input is given twice."""
    ranges = list(ranges)
    chosen = {one.key: one.words[0] for one in ranges if one.words}
    for one in ranges:
        if values.get(one.key) is not None:
            flag = TABLE[one.key].flag
            raise _wrong(f"{flag} is varied", f"{flag} {values[one.key]}", "a value or a range", f"leave {flag} out")
    if values.get("tolerance") == AUTO:
        raise _wrong("a study has one tolerance for all of its scenes", AUTO, "a number", "change --tolerance")
    scene = scene_of({**values, **chosen})
    keys = [one.key for one in ranges]
    ranges += [one for one in errors_of(scene) if one.key not in keys]
    keys = [one.key for one in ranges]
    if not ranges:
        raise _wrong(
            "nothing varies",
            "a scene without ranges",
            "--vary NAME=LOW:HIGH, --spans BANDS, errors as in --strain '0.476 +/- 0.01', or --inputs as-printed",
            "add one",
        )
    given = {key: uncertain(key, one)[0] for key, one in values.items() if key in TABLE and key != "inputs"}
    if not chosen:
        # Every number of the band and of its law stands beside the varied ones: a modulus alone would be refused.
        full = {key: one for key, one in scene.as_dict().items() if key not in (*PLANNED, "planned", "samples")}
        return Box({key: one for key, one in full.items() if key not in keys}, tuple(ranges))
    by_band: dict[str, dict[str, Any]] = {}
    if "band" in chosen and "law" not in {**given, **chosen} and given.get("band_file") is None:
        for name in next(one.words for one in ranges if one.key == "band"):
            own = {"section": "rectangle", **known_values(name)}
            by_band[name] = {key: one for key, one in own.items() if key not in (*given, *keys)}
        if len({tuple(sorted(one)) for one in by_band.values()}) > 1:
            by_band = {}  # bands of different kinds, of which each brings what it has
    return Box(given, tuple(ranges), by_band)
