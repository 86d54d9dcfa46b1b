"""What became of a run, as a value: a code, its name in tables, its mark in charts, and the cause."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from beadband.errors import BeadbandError, Complaint
from beadband.notices import Notice, notice

OK, OTHER_LIMIT, UNSETTLED, UNSTABLE = "ok", "other-limit", "unsettled", "unstable"
TOO_SLOW, NO_PROGRAM, NOT_FINITE = "too-slow", "program-missing", "not-finite"
_NAMES = {
    OTHER_LIMIT: "converges to another limit",
    UNSETTLED: "does not converge",
    "usage": "refused",
    "refused-script": "refused by LAMMPS",
    "run-failed": "failed",
}
"""Names that are not the code itself with spaces for hyphens."""
_MARKS = {
    OK: "o",
    OTHER_LIMIT: "s",
    UNSETTLED: "D",
    UNSTABLE: "+",
    "diverged": "x",
    "energy-rose": "1",
    "lost": "2",
    "no-equilibrium": "^",
    NOT_FINITE: "v",
}
_OTHER_MARK = "P"
HOLLOW = (OTHER_LIMIT, UNSETTLED)
"""Codes whose marks are drawn as outlines: runs that gave an answer, though not the common one."""


def name_of(code: str) -> str:
    """An outcome as a table or legend names it."""
    return _NAMES.get(code, code.replace("-", " "))


def mark_of(code: str) -> str:
    """The marker of an outcome in the charts."""
    return _MARKS.get(code, _OTHER_MARK)


@dataclass(frozen=True)
class Outcome:
    """What became of a run; ``code`` is that of the error, or one of this module's."""

    code: str = OK
    cause: Complaint | Notice | str = ""

    @property
    def brief(self) -> str:
        """The cause, without what is allowed and what to do."""
        cause = self.cause
        return f"{cause.wrong}: {cause.given}" if isinstance(cause, Complaint) else str(cause)


DONE = Outcome()
"""That of a run with nothing to report."""


def outcome_of(error: BeadbandError) -> Outcome:
    """The outcome of a run that raised ``error``."""
    return Outcome(error.code, error.complaint or str(error))


def noticed(outcome: str, code: str, **values: object) -> Outcome:
    """An outcome whose cause is a notice of the table."""
    return Outcome(outcome, notice(code, **values))


def counted(codes: Iterable[str]) -> str:
    """How many there are of each outcome, the most frequent first: ``3 diverged, 1 refused``."""
    return ", ".join(f"{count} {name_of(code)}" for code, count in Counter(codes).most_common())
