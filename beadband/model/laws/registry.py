"""The laws that there are: registered by a decorator, by the entry points ``beadband.laws``, or by a plug-in file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any, TypeVar

from beadband import parameters
from beadband.errors import UsageError, explain
from beadband.model.laws.base import Law

LAWS: dict[str, type[Law]] = {}
"""Every registered law by its name."""

_L = TypeVar("_L", bound=type[Law])


def register(law: _L) -> _L:
    """Make a law known to every command, with a flag for each of its constants; ValueError for a name that is taken.

    A class decorator, put above ``@dataclass(frozen=True)``.
    """
    known = LAWS.get(law.name)
    if known is not None and known.__qualname__ != law.__qualname__:
        raise ValueError(f"a law called {law.name!r} is registered already")
    for constant in law.inputs():
        parameters.add_constant(constant)
    LAWS[law.name] = law
    parameters.add_word("law", law.name)
    return law


def law_of(name: str, values: Mapping[str, Any]) -> Law:
    """The law called ``name`` with the constants in ``values``, by their keys.

    UsageError for an unknown law, a missing or wrong constant, or a law without stiffness at rest.
    """
    if name not in LAWS:
        raise UsageError(explain("unknown law", repr(name), ", ".join(LAWS), "change --law"))
    chosen = {}
    values = LAWS[name].prepared(values)
    optional = {one.name for one in fields(LAWS[name]) if one.default is not MISSING}  # type: ignore[arg-type]
    for one in LAWS[name].constants():
        if values.get(one.key) is None and one.key in optional:
            continue
        if values.get(one.key) is None:
            flags = " ".join(each.flag for each in LAWS[name].inputs())
            raise UsageError(
                explain(f"the law {name} lacks a constant", f"no {one.key}", f"all of {flags}", f"add {one.flag}")
            )
        chosen[one.key] = parameters.checked(one.key, values[one.key], one)
    law = LAWS[name](**chosen)
    if not law.rest_modulus_pa > 0.0:
        raise UsageError(
            explain(
                f"the law {name} has no stiffness at rest",
                f"a modulus at rest of {law.rest_modulus_pa:.4g} Pa",
                "a positive one",
                "change " + " or ".join(one.flag for one in law.inputs() if one.section != "record"),
            )
        )
    return law
