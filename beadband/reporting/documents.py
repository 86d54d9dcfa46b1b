"""The reference pages, made of the tables: ``python -m beadband.reporting.documents DIR`` writes them into a folder.

Laws and observables of plug-ins (:mod:`beadband.plugins`) are in them too.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from beadband import observables, parameters
from beadband.model import laws  # noqa: F401  a law adds its constants to the table


def documents() -> dict[str, str]:
    """The text of each page, by the name of its file."""
    return {
        "parameters.md": parameters.as_markdown(),
        "results.md": observables.as_markdown(),
        "results.schema.json": json.dumps(observables.json_schema(), indent=1) + "\n",
    }


def write(folder: str | Path) -> None:
    """Write the pages into a folder, which is made where it is missing."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name, text in documents().items():
        (Path(folder) / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(sys.argv[1] if len(sys.argv) > 1 else "docs")
