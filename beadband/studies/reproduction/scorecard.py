"""The scorecard: the paper's statements, the numbers that test them, and the verdicts that follow from the numbers."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from beadband.analysis.fits import Measured


class Verdict(StrEnum):
    """What the numbers say of a statement; see :attr:`Entry.verdict` for the rule."""

    CONFIRMED = "confirmed"
    MISPRINT = "misprint"
    CHOICE = "modelling choice"
    DISAGREEMENT = "disagreement"
    NOT_TESTABLE = "not testable"


@dataclass(frozen=True)
class Criterion:
    """The interval in which a number of an entry supports a statement."""

    of: str
    """Name of the number."""
    words: str
    """The comparison in words: "agrees with 1.09 within 0.05"."""
    low: float = -math.inf
    high: float = math.inf
    paper: float | None = None
    """The paper's number, where there is one to compare with; the error of the measured one widens the interval."""

    def holds(self, number: Measured) -> bool:
        """Whether the number lies in the interval; false for nan."""
        slack = number.error if self.paper is not None else 0.0
        return self.low - slack <= number.value <= self.high + slack


def agrees(of: str, paper: float, within: float = 0.0) -> Criterion:
    """The number is the paper's, within this and its own error."""
    words = f"agrees with {paper:.5g}" + (f" within {within:.2g}" if within else " within its error")
    return Criterion(of, words, paper - within, paper + within, paper)


def between(of: str, low: float, high: float) -> Criterion:
    """The number lies in a range, both ends included."""
    return Criterion(of, f"from {low:g} to {high:g}", low, high)


def at_least(of: str, low: float) -> Criterion:
    """The number is not below a limit."""
    return Criterion(of, f"at least {low:g}", low)


def small(of: str, limit: float) -> Criterion:
    """The number is at most so large, of either sign."""
    return Criterion(of, f"at most {limit:g} in size", -limit, limit)


def rises(of: str) -> Criterion:
    """The number is positive; the least step of a series where the series must rise throughout."""
    return Criterion(of, "positive", math.ulp(0.0))


def falls(of: str) -> Criterion:
    """The number is negative; the largest step of a series where the series must fall throughout."""
    return Criterion(of, "negative", high=-math.ulp(0.0))


class _Filled:
    """A number in a template: ``{x:.2f}``, with its error ``{x:±.2f}``, or words by its criterion ``{x:?yes|no}``."""

    def __init__(self, number: Measured, holds: bool | None) -> None:
        self.number, self.holds = number, holds

    def __format__(self, form: str) -> str:
        if form.startswith("?"):
            if self.holds is None:
                raise ValueError(f"no criterion chooses the words {form[1:]!r}")
            return form[1:].split("|")[0 if self.holds else 1]
        if form.startswith("±"):
            return f"{self.number.value:{form[1:]}} ± {self.number.error:{form[1:]}}"
        return format(self.number.value, form)


@dataclass(frozen=True)
class Entry:
    """One figure, table or equation: change a number, and the verdict and the sentences change with it."""

    item: str
    claim: str
    """What the paper says or shows."""
    numbers: Mapping[str, float | Measured]
    """What was computed, SI unless the name says otherwise."""
    template: str
    """The finding, to be filled with the numbers."""
    printed: tuple[Criterion, ...]
    """What the numbers must be for the statement to hold as printed."""
    corrected: tuple[Criterion, ...] = ()
    """The same for the statement with its misprint corrected."""
    otherwise: tuple[Criterion, ...] = ()
    """The same for the statement under another choice of model than the paper's."""
    remarks: tuple[Criterion, ...] = ()
    """Criteria that choose words of the finding, not the verdict."""
    differences: Mapping[Verdict, str] = field(default_factory=dict)
    """Template of the difference for the verdicts where more can be said than which comparison fails."""

    def number(self, name: str) -> Measured:
        """A number with its error, zero where none was given."""
        value = self.numbers[name]
        return Measured(*map(float, value)) if isinstance(value, Measured) else Measured(float(value), 0.0)

    def holds(self, criterion: Criterion) -> bool:
        """Whether the number that the criterion names lies in its interval."""
        return criterion.holds(self.number(criterion.of))

    def criteria(self) -> Iterator[tuple[str, Criterion]]:
        """The criteria that decide the verdict, each with its role."""
        for role in ("printed", "corrected", "otherwise"):
            for criterion in getattr(self, role):
                yield role, criterion

    @property
    def verdict(self) -> Verdict:
        """Confirmed: it holds, under the other choice too. Choice: it holds, but not under the other choice.

        Misprint: it holds as corrected only. Disagreement: it holds in no form. Not testable: a number is missing.
        """
        if any(math.isnan(self.number(criterion.of).value) for _, criterion in self.criteria()):
            return Verdict.NOT_TESTABLE
        if all(map(self.holds, self.printed)):
            return Verdict.CONFIRMED if all(map(self.holds, self.otherwise)) else Verdict.CHOICE
        return Verdict.MISPRINT if self.corrected and all(map(self.holds, self.corrected)) else Verdict.DISAGREEMENT

    @property
    def finding(self) -> str:
        """What was computed, in a sentence."""
        return self.filled(self.template)

    @property
    def difference(self) -> str:
        """Finding against claim: the words for this verdict, or the comparisons that fail."""
        verdict = self.verdict
        if verdict in self.differences:
            return self.filled(self.differences[verdict])
        if verdict is Verdict.CONFIRMED:
            return "none"
        failing = [self.comparison(c) for role, c in self.criteria() if role != "corrected" and not self.holds(c)]
        return "not so: " + "; ".join(failing)

    def comparison(self, criterion: Criterion) -> str:
        """A number with its error, and what it is compared with."""
        value, error = self.number(criterion.of)
        return f"{criterion.of.replace('_', ' ')} = {value:.4g}{f' ± {error:.2g}' if error else ''} ({criterion.words})"

    def filled(self, template: str) -> str:
        """A template with the numbers in their places."""
        chosen: dict[str, bool] = {}
        for criterion in (*self.printed, *self.corrected, *self.otherwise, *self.remarks):
            chosen.setdefault(criterion.of, self.holds(criterion))
        return template.format_map({name: _Filled(self.number(name), chosen.get(name)) for name in self.numbers})

    def as_dict(self) -> dict[str, Any]:
        """For scorecard.json; null for what is not a finite number."""
        return {
            "item": self.item,
            "claim": self.claim,
            "finding": self.finding,
            "difference": self.difference,
            "verdict": self.verdict.value,
            "numbers": {name: dict(zip(("value", "error"), map(_finite, self.number(name)), strict=True))
                        for name in self.numbers},
            "criteria": [
                {
                    "role": role,
                    "number": criterion.of,
                    "criterion": criterion.words,
                    "low": _finite(criterion.low),
                    "high": _finite(criterion.high),
                    "paper": criterion.paper,
                    "holds": self.holds(criterion),
                }
                for role, criterion in self.criteria()
            ],
        }  # fmt: skip


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def as_dict(entries: list[Entry], extra: dict[str, Any]) -> dict[str, Any]:
    """The scorecard for programs."""
    return {"entries": [entry.as_dict() for entry in entries], **extra}


def counts(entries: list[Entry]) -> str:
    """How many entries have each verdict, in words."""
    found = Counter(entry.verdict for entry in entries)
    return f"{len(entries)} items: " + ", ".join(f"{found[verdict]} {verdict}" for verdict in Verdict if found[verdict])


_ROLES = {"printed": "", "corrected": "corrected: ", "otherwise": "with another choice: "}


def as_markdown(entries: list[Entry], note: str = "") -> str:
    """The scorecard for a reader; ``note`` says how it was made."""
    head = [
        "# Scorecard",
        "",
        f"{counts(entries)}. {note}".strip(),
        "",
        "Each verdict follows from the numbers and limits in the column before it. Confirmed: the statement holds.",
        "Misprint: it holds once corrected. Modelling choice: it holds as modelled there, not otherwise.",
        "Disagreement: it holds in no form. Not testable: a number is missing.",
        "",
        "The experimental points of the paper's figures are not in its text; none are drawn here.",
        "",
        "| item | the paper | beadband | difference | decided by | verdict |",
        "|---|---|---|---|---|---|",
    ]
    rows = []
    for entry in entries:
        decided = "; ".join(
            f"{_ROLES[role]}{entry.comparison(criterion)}{'' if entry.holds(criterion) else ': no'}"
            for role, criterion in entry.criteria()
        )
        cells = (entry.item, entry.claim, entry.finding, entry.difference, decided, entry.verdict.value)
        rows.append("| " + " | ".join(text.replace("|", "\\|") for text in cells) + " |")
    return "\n".join([*head, *rows]) + "\n"
