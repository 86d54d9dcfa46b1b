"""Answers to one question as a person reads them on a terminal."""

from __future__ import annotations

from beadband.analysis.fits import Measured
from beadband.notices import percent
from beadband.runs.ask import Answer
from beadband.studies.find import Found

_NAMES = {"speed": "rebound speed V", "curvature": "tip curvature over that of Eq. 7"}


def answer(found: Answer, quantity: str) -> str:
    """The answer, and how it was had."""
    unit = "" if found.unit == "1" else f" {found.unit}"
    how = "by formula, without a run"
    if found.runs:
        how = f"{found.runs} runs of one {found.model}, the finest as of {found.beads} beads"
    lines = [
        f"{_NAMES[quantity]}  {Measured(found.value, found.error)}{unit} ({percent(found.error / abs(found.value))})"
    ]
    if found.input_error is not None:
        share = percent(found.input_error / abs(found.value))
        lines.append(f"  error from the inputs  {found.input_error:.2g}{unit} ({share})")
    return "\n".join([*lines, f"  {how}; {1e3 * found.seconds:.3g} ms"])


def value(found: Found) -> str:
    """The value found, its speed, and how it was had."""
    unit = "" if found.unit == "1" else f" {found.unit}"
    speed = Measured(found.answer.value, found.answer.error)
    return (
        f"{found.parameter}  {Measured(found.value, found.error)}{unit}\n"
        f"  rebound speed V  {speed} m/s\n"
        f"  {found.evaluations} speeds were asked for, the last by {found.answer.model}; {found.seconds:.2g} s"
    )
