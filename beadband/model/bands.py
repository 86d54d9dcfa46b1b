"""Rubber bands: sections, what a band is made of, and the catalogue (``bands.toml``)."""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from beadband.errors import UsageError, explain
from beadband.model.laws import LAWS, Law, law_of
from beadband.parameters import TABLE, checked, key_of

SIZES = ("circumference_m", "section", "width_m", "thickness_m", "wall_m", "area_m2", "second_moment_m4")
"""Keys of a band's shape."""
PROPERTIES = (*SIZES, "density_kg_m3", "modulus_pa")
"""Keys of a band beside its name and the constants of its law."""
_NEEDED = ("circumference_m", "thickness_m", "density_kg_m3")

_SECTION_KEYS = {
    "rectangle": ("width_m",),
    "circle": (),
    "square": (),
    "tube": ("wall_m",),
    "given": ("area_m2", "second_moment_m4"),
}
"""What each section needs beside the thickness; what the others need it refuses."""


@dataclass(frozen=True)
class Section:
    """Cross section of the unstretched band; lengths in m. It bends in the plane of the ring, across the thickness."""

    kind: str
    """"rectangle", "circle" and "tube" (the thickness is the outer diameter), "square", or "given"."""
    thickness_m: float
    width_m: float | None = None
    wall_m: float | None = None
    given_area_m2: float | None = None
    given_second_moment_m4: float | None = None

    @property
    def area_m2(self) -> float:
        """Area A."""
        h = self.thickness_m
        if self.kind == "circle":
            return math.pi / 4.0 * h**2
        if self.kind == "tube":
            assert self.wall_m is not None
            return math.pi / 4.0 * (h**2 - (h - 2.0 * self.wall_m) ** 2)
        if self.kind == "given":
            assert self.given_area_m2 is not None
            return self.given_area_m2
        return (h if self.width_m is None else self.width_m) * h

    @property
    def second_moment_m4(self) -> float:
        """Second moment I: b h^3/12 of a rectangle, pi d^4/64 of a circle."""
        h = self.thickness_m
        if self.kind == "circle":
            return math.pi / 64.0 * h**4
        if self.kind == "tube":
            assert self.wall_m is not None
            return math.pi / 64.0 * (h**4 - (h - 2.0 * self.wall_m) ** 4)
        if self.kind == "given":
            assert self.given_second_moment_m4 is not None
            return self.given_second_moment_m4
        return (h if self.width_m is None else self.width_m) * h**3 / 12.0


@dataclass(frozen=True)
class Band:
    """A closed band in its unstretched state; SI units throughout."""

    name: str
    circumference_m: float
    section: Section
    density_kg_m3: float
    modulus_pa: float
    """Young's modulus E as it is stated of the band: in EI, in the loss, and as one of the three C of V/C."""
    rubber: Law
    """The law of its rubber; its modulus at rest is E0."""

    @property
    def thickness_m(self) -> float:
        """Thickness h, or the diameter."""
        return self.section.thickness_m

    @property
    def width_m(self) -> float | None:
        """Width b of a rectangle; None for other sections."""
        return self.section.width_m

    @property
    def area_m2(self) -> float:
        """Area of the section, A."""
        return self.section.area_m2

    @property
    def second_moment_m4(self) -> float:
        """Second moment of the section, I."""
        return self.section.second_moment_m4

    @property
    def mass_per_length_kg_m(self) -> float:
        """Mass of one metre of unstretched band."""
        return self.density_kg_m3 * self.area_m2

    @property
    def mass_kg(self) -> float:
        """Mass of the whole band."""
        return self.mass_per_length_kg_m * self.circumference_m

    @property
    def rest_modulus_pa(self) -> float:
        """E0, the modulus at rest of its rubber; not the stated E."""
        return self.rubber.rest_modulus_pa

    @property
    def bar_speed_m_s(self) -> float:
        """sqrt(E/density) with the stated E."""
        return math.sqrt(self.modulus_pa / self.density_kg_m3)

    @property
    def rest_speed_m_s(self) -> float:
        """sqrt(E0/density)."""
        return math.sqrt(self.rest_modulus_pa / self.density_kg_m3)

    def properties(self) -> dict[str, Any]:
        """Its own values by their keys, those of its law left out."""
        section = self.section
        values = {
            "circumference_m": self.circumference_m,
            "section": section.kind,
            "width_m": section.width_m,
            "thickness_m": section.thickness_m,
            "wall_m": section.wall_m,
            "area_m2": section.given_area_m2,
            "second_moment_m4": section.given_second_moment_m4,
            "density_kg_m3": self.density_kg_m3,
            "modulus_pa": self.modulus_pa,
        }
        return {key: value for key, value in values.items() if value is not None}


def section_of(values: Mapping[str, Any]) -> Section:
    """The section of a band's values; UsageError for a size that is missing or that the section does not have."""
    kind = values.get("section") or "rectangle"
    for key in ("width_m", "wall_m", "area_m2", "second_moment_m4"):
        value, one = values.get(key), TABLE[key]
        if value is not None and key not in _SECTION_KEYS[kind]:
            size = "the diameter" if kind in ("circle", "tube") else "the side" if kind == "square" else "the height"
            raise UsageError(
                explain(
                    f"a section that is a {kind} has no {one.option.replace('_', ' ')}"
                    if kind != "given"
                    else f"a section of given area and second moment has no {one.option}",
                    f"{one.flag} {value}",
                    f"--thickness, {size}",
                    f"leave {one.flag} out or change --section",
                )
            )
        if value is None and key in _SECTION_KEYS[kind]:
            raise UsageError(
                explain(f"a section of kind {kind} needs a size", f"no {key}", one.allowed, f"add {one.flag}")
            )
    thickness = values["thickness_m"]
    if kind == "tube" and 2.0 * values["wall_m"] > thickness:
        raise UsageError(
            explain(
                "the wall of the tube is thicker than the tube",
                f"a wall of {values['wall_m']:g} m, diameter {thickness:g} m",
                "at most half the diameter",
                "change --wall",
            )
        )
    return Section(
        kind,
        thickness,
        values.get("width_m"),
        values.get("wall_m"),
        values.get("area_m2"),
        values.get("second_moment_m4"),
    )


@cache
def _catalogue_tables() -> dict[str, dict[str, Any]]:
    return tomllib.loads(files("beadband.model").joinpath("bands.toml").read_text(encoding="utf-8"))


@cache
def catalogue_values() -> dict[str, dict[str, Any]]:
    """The catalogue as flat values by their keys, band by band, the constants of its law among them."""
    return {name: flattened({"name": name, **table}) for name, table in _catalogue_tables().items()}


def read_bands(path: str | os.PathLike[str], flag: str = "--band-file") -> dict[str, dict[str, Any]]:
    """Bands of a TOML file as flat values by their keys: a table each, named for the band, as in the catalogue's.

    A file with one ``[band]`` table that has a name, as scene files have it, is a file of that band. UsageError for a
    file that can't be read, or that holds something else.
    """
    tables = read_toml(path, "band", flag)
    own = tables.get("band")
    if isinstance(own, Mapping) and "name" in own:
        tables = {str(own["name"]): {**own, "law": tables.get("law", own.get("law", {}))}}
    found: dict[str, dict[str, Any]] = {}
    for name, table in tables.items():
        if not isinstance(table, Mapping):
            wrong = f"{name!r} in {str(path)!r} is no table of a band"
            raise UsageError(explain(wrong, repr(table), "[NAME] with its sizes below", "correct it"))
        found[name] = {}
        for key, value in flattened({**table, "name": name}).items():
            known = key if key == "covariance" else key_of(key)
            if known is None:
                allowed = ", ".join(PROPERTIES)
                raise UsageError(explain(f"unknown key in {str(path)!r}", repr(key), f"{allowed}, law", "correct it"))
            found[name][known] = value
        found[name] = with_paths(found[name], path)
    if not found:
        raise UsageError(explain("a band file without a band", repr(str(path)), "[NAME] and its sizes", "add one"))
    return found


def with_paths(values: Mapping[str, Any], source: str | os.PathLike[str]) -> dict[str, Any]:
    """Values whose names of files are found from the folder of ``source``, the file that names them."""
    return {
        key: str(Path(source).parent / value)
        if key in TABLE and TABLE[key].kind == "path" and isinstance(value, str)
        else value
        for key, value in values.items()
    }


def read_toml(path: str | os.PathLike[str], what: str, flag: str) -> dict[str, Any]:
    """The tables of a TOML file; UsageError for one that can't be read or is malformed."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise UsageError(
            explain(f"the {what} file can't be read", f"{str(path)!r} ({reason})", "a TOML file", f"check {flag}")
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise UsageError(
            explain(f"the {what} file is malformed", f"{str(path)!r}: {error}", "TOML: key = value lines", "correct it")
        ) from error


def as_printed(name: str) -> dict[str, float]:
    """Unit of the last printed digit of each number of a band of the catalogue; UsageError for another band."""
    if name not in _catalogue_tables():
        allowed = ", ".join(_catalogue_tables())
        raise UsageError(explain("only the catalogue's bands are printed", repr(name), allowed, "give errors instead"))
    return dict(_catalogue_tables()[name]["digit"])


def flattened(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table of a band, its ``law`` a table within it, as flat values: ``name`` becomes ``band``."""
    law = table.get("law", {})
    if not isinstance(law, Mapping):
        raise UsageError(explain("the law of a band is no table", repr(law), 'law = { name = "gent", … }', "change it"))
    flat = {key: value for key, value in table.items() if key not in ("law", "name", "digit")}
    if "name" in table:
        flat["band"] = table["name"]
    for key, value in law.items():
        flat["law" if key == "name" else key] = value
    return flat


def made_band(name: str, values: Mapping[str, Any], rubber: Law) -> Band:
    """A band of checked values; UsageError where one is missing."""
    for key in _NEEDED:
        if values.get(key) is None:
            one = TABLE[key]
            raise UsageError(
                explain(f"the band {name!r} lacks its {one.option}", f"no {key}", one.allowed, f"add {one.flag}")
            )
    numbers = {key: checked(key, values[key]) for key in PROPERTIES if values.get(key) is not None}
    return Band(
        name=name,
        circumference_m=numbers["circumference_m"],
        section=section_of(numbers),
        density_kg_m3=numbers["density_kg_m3"],
        modulus_pa=numbers.get("modulus_pa", rubber.rest_modulus_pa),
        rubber=rubber,
    )


def band_of(name: str, changes: Mapping[str, Any] | None = None) -> Band:
    """A band of the catalogue with some values changed; UsageError for a name that it has not, or a wrong value."""
    values = {**known_values(name), **(changes or {})}
    return made_band(name, values, law_of(values["law"], values))


def known_values(name: str) -> dict[str, Any]:
    """Values of a band of the catalogue; UsageError for an unknown name."""
    known = catalogue_values().get(name)
    if known is None:
        raise UsageError(
            explain(
                "unknown band", repr(name), ", ".join(catalogue_values()), "choose one with --band, or give its sizes"
            )
        )
    return dict(known)


CATALOGUE: dict[str, Band] = {name: band_of(name) for name in catalogue_values()}
"""The bands of the catalogue by name."""


def laws_of(name: str) -> list[str]:
    """Laws whose constants the catalogue has for a band."""
    known = known_values(name)
    return [law for law, kind in LAWS.items() if all(one.key in known for one in kind.constants())]


def band_rows(bands: Iterable[Band]) -> list[dict[str, Any]]:
    """Bands with derived values, SI; ``peak_strain`` is where the tension of the band's rubber peaks, or null."""
    rows = []
    for band in bands:
        peak = band.rubber.peak_stretch()
        row = {"name": band.name, "width_m": None, **band.properties(), "law": band.rubber.name, **band.rubber.values()}
        for key in ("area_m2", "second_moment_m4", "mass_per_length_kg_m", "rest_modulus_pa", "bar_speed_m_s"):
            row[key] = getattr(band, key)
        row["bending_stiffness_n_m2"] = band.modulus_pa * band.second_moment_m4
        rows.append(row | {"rest_speed_m_s": band.rest_speed_m_s, "peak_strain": None if peak is None else peak - 1.0})
    return rows
