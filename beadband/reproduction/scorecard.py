"""The scorecard: what the paper claims, what beadband finds, and what the difference is."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

CONFIRMED, MISPRINT, CHOICE, DISAGREEMENT = "confirmed", "misprint", "modelling choice", "disagreement"


@dataclass(frozen=True)
class Entry:
    """One figure, table or equation."""

    item: str
    claim: str
    """What the paper says or shows."""
    finding: str
    """What was computed, with its number."""
    difference: str
    """Finding minus claim, in words or numbers."""
    verdict: str
    """One of confirmed, misprint, modelling choice, disagreement."""

    def __post_init__(self) -> None:
        if self.verdict not in (CONFIRMED, MISPRINT, CHOICE, DISAGREEMENT):
            raise ValueError(f"no such verdict: {self.verdict}")


def as_dict(entries: list[Entry], extra: dict[str, Any]) -> dict[str, Any]:
    """The scorecard for programs."""
    return {"entries": [asdict(entry) for entry in entries], **extra}


def as_markdown(entries: list[Entry]) -> str:
    """The scorecard for a reader."""
    counts = {
        verdict: sum(entry.verdict == verdict for entry in entries)
        for verdict in (CONFIRMED, MISPRINT, CHOICE, DISAGREEMENT)
    }
    head = [
        "# Scorecard",
        "",
        f"{len(entries)} items: " + ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) + ".",
        "",
        "The experimental points of the paper's figures are not in its text; none are drawn here.",
        "",
        "| item | the paper | beadband | difference | verdict |",
        "|---|---|---|---|---|",
    ]
    rows = [
        "| "
        + " | ".join(
            text.replace("|", "\\|")
            for text in (entry.item, entry.claim, entry.finding, entry.difference, entry.verdict)
        )
        + " |"
        for entry in entries
    ]
    return "\n".join([*head, *rows]) + "\n"
