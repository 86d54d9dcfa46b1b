"""How the pictures of a run are printed: file format, width in columns of a journal, one palette, sizes of text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beadband.errors import UsageError, explain
from beadband.studies.palette import PALETTE

FORMATS = ("png", "pdf", "svg")
COLUMNS = (1, 2)
_WIDTH_IN = {1: 3.35, 2: 6.89}
"""Widths of one and two columns: 85 and 175 mm, which most journals print."""
_LINES = ("-", "--", "-.", ":")


@dataclass(frozen=True)
class Style:
    """Format and size of pictures; without ``columns`` they have the size for a screen."""

    format: str = "png"
    columns: int | None = None

    def __post_init__(self) -> None:
        if self.format not in FORMATS:
            raise UsageError(
                explain("unknown picture format", repr(self.format), ", ".join(FORMATS), "change --format")
            )
        if self.columns not in (None, *COLUMNS):
            raise UsageError(explain("no width of that many columns", self.columns, "1 or 2", "change --columns"))

    def size_in(self, width: float, height: float) -> tuple[float, float]:
        """Size of a figure that is ``width`` by ``height`` inches on a screen."""
        if self.columns is None:
            return width, height
        column = _WIDTH_IN[self.columns]
        return column, column * height / width

    @contextmanager
    def applied(self) -> Iterator[Any]:
        """matplotlib's pyplot with this style, without a screen."""
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        # Text stays text in vector files; in a column of a journal it is printed at 7 to 8 points.
        settings: Any = {"pdf.fonttype": 42, "svg.fonttype": "none"}
        if self.columns is not None:
            settings |= {"font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "legend.fontsize": 7}
            settings |= {"xtick.labelsize": 7, "ytick.labelsize": 7, "axes.linewidth": 0.6, "lines.linewidth": 1.0}
        with matplotlib.rc_context():
            matplotlib.rcParams.update(settings)
            yield pyplot

    def save(self, figure: Any, path: Path) -> Path:
        """Save a figure under the path with this format's ending; a vector file carries no date."""
        written = path.with_suffix(f".{self.format}")
        more: dict[str, Any] = {"pdf": {"metadata": {"CreationDate": None}}, "svg": {"metadata": {"Date": None}}}.get(
            self.format, {"dpi": 130 if self.columns is None else 300}
        )
        figure.savefig(written, **more)
        return written


SCREEN = Style()


def line_of(number: int) -> dict[str, Any]:
    """Colour and dashes of the run with this number, for lines that black and white print keeps apart."""
    return {"color": PALETTE[number % len(PALETTE)], "linestyle": _LINES[number // len(PALETTE) % len(_LINES)]}
