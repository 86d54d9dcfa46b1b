"""A ladder of independent checks: each rung compares the beads with something that is known exactly."""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib import import_module

from beadband.errors import BeadbandError, UsageError, explain
from beadband.studies.verification.check import Check

__all__ = ["RUNGS", "Check", "verify"]


def _rung(name: str, module: str) -> Callable[[], list[Check]]:
    """The function ``name`` of a module that is imported when the rung is run."""

    def run() -> list[Check]:
        found = import_module(f"beadband.studies.verification.{module}")
        checks: list[Check] = getattr(found, name.replace("-", "_"))()
        return checks

    run.__name__ = name
    return run


RUNGS: dict[str, Callable[[], list[Check]]] = {
    name: _rung(name, module)
    for name, module in (
        ("bond", "statics"),
        ("bending", "statics"),
        ("waves", "vibrations"),
        ("ring", "vibrations"),
        ("kink", "kink"),
        ("string", "stringlimit"),
        ("strip", "strip"),
        ("orders", "orders"),
        ("conservation", "conservation"),
        ("peg", "peg"),
        ("self-contact", "self_contact"),
        ("flight", "flight"),
        ("hand", "hand"),
    )
}
"""The rungs in the order in which they build on each other."""


def verify(only: str | None = None) -> list[Check]:
    """Run all rungs, or one; UsageError for an unknown name.

    A rung that cannot be finished (LAMMPS fails, no held ring is found) counts as one failed check that says why.
    """
    if only is not None and only not in RUNGS:
        raise UsageError(explain("unknown rung", repr(only), ", ".join(RUNGS), "choose one with --only"))
    checks: list[Check] = []
    for name in RUNGS if only is None else (only,):
        try:
            checks += RUNGS[name]()
        except BeadbandError as error:
            checks.append(Check(name, "runs to its end", math.nan, 1.0, 0.0, str(error), error.code))
    return checks
