"""The page of the correction says what the shipped map's own record says."""

from __future__ import annotations

from pages import DOCS

from beadband.model.correction import record
from beadband.studies.correction.report import tables


def test_the_tables_are_those_of_the_record() -> None:
    assert tables(record()) in (DOCS / "correction.md").read_text(encoding="utf-8")
