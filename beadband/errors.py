"""Errors that a user may meet: a code for programs, one sentence for people, one exit code for scripts."""

from __future__ import annotations

from typing import Any


class Complaint:
    """What was wrong, what was given, what is allowed, and what to do; ``str`` makes the one sentence of it.

    A plain class: a NamedTuple would cost ``--help`` a millisecond.
    """

    __slots__ = ("advice", "allowed", "given", "wrong")

    def __init__(self, wrong: str, given: str, allowed: str, advice: str) -> None:
        self.wrong, self.given, self.allowed, self.advice = wrong, given, allowed, advice

    def __str__(self) -> str:
        return f"{self.wrong}: given {self.given}; allowed: {self.allowed}; {self.advice}"


def explain(wrong: str, given: object, allowed: str, advice: str) -> Complaint:
    """Put a complaint in its one form."""
    return Complaint(wrong, str(given), allowed, advice)


class BeadbandError(Exception):
    """Base of every error that a user may see.

    ``exit_code`` is what the command line returns; ``code`` is a fixed word for the kind of failure, on which programs
    may decide (the sentence may change, the code does not).
    """

    exit_code = 1
    code = "failed"

    def __init__(self, complaint: Complaint | str, code: str | None = None) -> None:
        super().__init__(str(complaint))
        self.complaint = complaint if isinstance(complaint, Complaint) else None
        if code is not None:
            self.code = code

    def __reduce__(self) -> Any:
        return type(self), (self.complaint or str(self), self.code)


class UsageError(BeadbandError, ValueError):
    """The request is malformed, or the scene has no answer: nothing was computed (exit 2)."""

    exit_code = 2
    code = "usage"


class RunError(BeadbandError, RuntimeError):
    """The request was sound and the run failed: there is no result (exit 1)."""

    exit_code = 1
    code = "run-failed"
