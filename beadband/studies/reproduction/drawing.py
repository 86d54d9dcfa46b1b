"""How the pictures of the reproduction look and where they go."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import Any

from beadband.studies.reproduction.scorecard import Entry

COLOURS = {"I": "#1f5fa8", "II": "#c8601a", "III": "#2c7d4f", "IV": "#8a3d8f", "circular": "#6b6b6b"}
"""One colour for each band."""
SERIES = ("#b8322a", "#1f5fa8", "#7a4fa0", "#222222", "#c8601a", "#2c7d4f")
"""Colours for curves of one picture, the paper's red, blue, purple and black first."""


class Sheet:
    """Makes figures and writes each as PNG and SVG into one folder."""

    def __init__(self, folder: Path) -> None:
        import matplotlib

        matplotlib.use("Agg")
        matplotlib.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.25, "svg.hashsalt": "beadband"})
        self.folder = folder
        self.tables: dict[str, Any] = {}
        """Numbers behind the pictures, for scorecard.json."""
        self.pending: list[tuple[Any, str]] = []

    def axes(self, columns: int = 1, width: float = 6.6, height: float = 4.4) -> tuple[Any, list[Any]]:
        """A figure with so many panels in a row."""
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(
            1, columns, figsize=(width * columns, height), layout="constrained", squeeze=False
        )
        return figure, list(axes[0])

    def surface(self) -> tuple[Any, Any]:
        """A figure with one three-dimensional panel."""
        from matplotlib import pyplot

        figure = pyplot.figure(figsize=(7.0, 5.4), layout="constrained")
        return figure, figure.add_subplot(projection="3d")

    def save(self, figure: Any, name: str) -> None:
        """Keep a finished figure under a name until its caption is known."""
        self.pending.append((figure, name))

    def publish(self, entries: list[Entry]) -> None:
        """Write the kept figures, each with the paper's claim and what was found beneath it."""
        for figure, name in self.pending:
            entry = next((entry for entry in entries if _names(entry, name)), entries[0])
            # Characters that fit in a line of the figure's width at the caption's size.
            width = int(15.5 * figure.get_figwidth())
            lines = [
                line
                for who, text in (("The paper: ", entry.claim), ("beadband: ", entry.finding))
                for line in wrap(who + text, width)
            ]
            figure.supxlabel("\n".join(lines), fontsize=8, x=0.01, ha="left", color="#333333")
            for ending in ("png", "svg"):
                undated = {"Date": None} if ending == "svg" else None
                figure.savefig(self.folder / f"{name}.{ending}", dpi=130, metadata=undated)
                figure.set_layout_engine("none")  # the panels stay where the first file has them
        self.close()

    def close(self) -> None:
        """Forget the kept figures."""
        from matplotlib import pyplot

        for figure, _ in self.pending:
            pyplot.close(figure)
        self.pending.clear()


def _names(entry: Entry, name: str) -> bool:
    """Whether an entry speaks of the figure of that name: 'Fig. 12' of fig12."""
    return entry.item.replace("Fig. ", "fig").replace("Appendix, Eq.", "appendix ").replace(",", "").split()[0] == name
