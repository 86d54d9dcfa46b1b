"""What beadband says when it can't go on: one sentence for the user, one exit code for scripts."""

from __future__ import annotations


class BeadbandError(Exception):
    """Base of every error that a user may see; ``exit_code`` is what the command line returns."""

    exit_code = 1


class UsageError(BeadbandError, ValueError):
    """The request is malformed, or the scene has no answer: nothing was computed (exit 2)."""

    exit_code = 2


class RunError(BeadbandError, RuntimeError):
    """The request was sound and the run failed: there is no result (exit 1)."""

    exit_code = 1


def explain(wrong: str, given: object, allowed: str, advice: str) -> str:
    """Put a complaint in its one form: what was wrong, what was given, what is allowed, what to do."""
    return f"{wrong}: given {given}; allowed: {allowed}; {advice}"
