"""Scenes as TOML files: what a user writes, and the complete scene.toml of a run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from beadband.errors import UsageError, explain
from beadband.model.bands import flattened, read_toml, with_paths
from beadband.model.scene import Scene
from beadband.parameters import TABLE, key_of

_HEAD = """\
# A release, complete, in SI units: 'beadband run --scene' on this file repeats it. To change it, add flags to that
# command, or edit this file and delete the lines that 'planned' names: they were chosen for this very scene.
"""


def read_scene(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Values of a TOML scene under their full names; UsageError for what is unreadable, malformed or unknown.

    Files that it names are found from its own folder.
    """
    values = flat_scene(read_toml(path, "scene", "--scene"), str(path))
    return with_paths(values, path)


def flat_scene(table: Mapping[str, Any], source: str) -> dict[str, Any]:
    """Values of a scene by their keys, from a table whose ``band`` and ``law`` may be tables within it.

    Names are keys or, like the flags, keys without their units. UsageError for an unknown name, or one given twice.
    """
    values: dict[str, Any] = {}

    def put(name: str, value: Any, among: set[str]) -> None:
        key = name if name in ("planned", "covariance") else key_of(name)
        if key is None:
            raise UsageError(
                explain(f"unknown key in {source!r}", repr(name), ", ".join(TABLE), "correct or remove it")
            )
        if key in among or (key in values and values[key] != value):
            raise UsageError(
                explain(f"a key stands twice in {source!r}", repr(name), f"{key} once", "remove one of them")
            )
        among.add(key)
        values[key] = value

    top: set[str] = set()
    for name, value in table.items():
        if name == "band" and isinstance(value, Mapping):
            inner = flattened(value)
        elif name == "law" and isinstance(value, Mapping):
            inner = flattened({"law": value})
        else:
            put(name, value, top)
            continue
        own: set[str] = set()
        for each, item in inner.items():
            put(each, item, own)
    return values


def scene_text(scene: Scene) -> str:
    """The scene as TOML, every number to its last digit: the release, then its band, then its law."""
    values = _values_with_errors(scene)
    band = {"name": values.pop("band"), **{key: values.pop(key) for key in scene.band.properties()}}
    law = {"name": values.pop("law")}
    for key in scene.material.values():
        if key in values:
            law[key] = values.pop(key)
    if "covariance" in values:
        law["covariance"] = values.pop("covariance")
    lines = [_lines(values), f"[band]\n{_lines(band)}", law_text(law)]
    return _HEAD + "\n".join(lines)


def law_text(values: Mapping[str, Any]) -> str:
    """The part of a scene file that is the law, from its values by their keys, ``name`` among them."""
    return f"[law]\n{_lines(values)}"


def _values_with_errors(scene: Scene) -> dict[str, Any]:
    """Values of a scene by their keys, as scene files have them: a table of value and error where there is one."""
    values = scene.as_dict()
    for key, error in scene.errors:
        values[key] = {"value": values[key], "error": error}
    if scene.covariance:
        values["covariance"] = [list(row) for row in scene.covariance]
    return values


def _lines(values: Mapping[str, Any]) -> str:
    return "".join(f"{key} = {_toml(value)}\n" for key, value in values.items())


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return '"' + "".join(_escaped(sign) for sign in value) + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return repr(value)


def _escaped(sign: str) -> str:
    if sign in '"\\':
        return "\\" + sign
    return f"\\u{ord(sign):04x}" if ord(sign) < 32 or ord(sign) == 127 else sign
