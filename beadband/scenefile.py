"""Scenes as TOML files: what a user writes, and the complete scene.toml of a run."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

from beadband.errors import UsageError, explain
from beadband.scene import KEYS, Scene

_UNITS = ("_kg_m3", "_deg", "_pa", "_m", "_s")


_HEAD = """\
# A release, complete, in SI units: 'beadband run --scene' on this file repeats it. To change it, add flags to that
# command, or edit this file and delete the lines that 'planned' names: they were chosen for this very scene.
"""


def _aliases() -> dict[str, str]:
    """Spellings under which a key is known: as it is, and like the flag, without its unit."""
    known = {key: key for key in KEYS}
    for key in KEYS:
        bare = key
        for unit in _UNITS:
            bare = bare.removesuffix(unit)
        known.setdefault(bare, key)
    return known


def read_scene(path: str | os.PathLike[str]) -> dict[str, object]:
    """Values of a TOML scene under their full names; UsageError for what is unreadable, malformed or unknown."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise UsageError(
            explain("the scene file can't be read", f"{str(path)!r} ({reason})", "a TOML file", "check --scene")
        ) from error
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(
            explain(
                "the scene file is malformed", f"{str(path)!r}: {error}", "TOML, one 'key = value' a line", "mend it"
            )
        ) from error
    known = _aliases()
    values: dict[str, object] = {}
    for name, value in table.items():
        key = known.get(name.replace("-", "_"))
        if key is None:
            raise UsageError(
                explain(f"unknown key in {str(path)!r}", repr(name), ", ".join(KEYS), "correct or remove it")
            )
        if key in values:
            raise UsageError(
                explain(f"a key stands twice in {str(path)!r}", repr(name), f"{key} once", "remove one of them")
            )
        values[key] = value
    return values


def scene_text(scene: Scene) -> str:
    """The scene as TOML, every number to its last digit."""
    lines = [f"{key} = {_toml(value)}" for key, value in scene.as_dict().items()]
    return _HEAD + "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    if isinstance(value, str):
        return '"' + re.sub(r'(["\\])', r"\\\1", value) + '"'
    if isinstance(value, list):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return repr(value)
