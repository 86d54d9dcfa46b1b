"""Pictures of a map: one panel for each band, half-angle across, strain up, the value as colour and as a number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

Cells = Mapping[tuple[float, float], float | None]
"""Values by (strain, half-angle in degrees); None where there is none."""


def draw(panels: Mapping[str, Cells], path: Path, title: str, diverging: bool = False) -> Path:
    """Write the picture of one quantity, its values by band; ``diverging`` shades are centred on 0, up to 1 at most."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    size = 3.4 * len(panels), 4.2
    figure, places = pyplot.subplots(1, len(panels), figsize=size, layout="constrained", squeeze=False)
    known = [value for cells in panels.values() for value in cells.values() if value is not None]
    most = max(map(abs, known), default=1.0)
    low, high = (-min(most, 1.0), min(most, 1.0)) if diverging else (min(known, default=0.0), most)
    shades = "RdBu" if diverging else "viridis"
    image = None
    for axes, (band, cells) in zip(places[0], panels.items(), strict=True):
        strains, angles = (sorted(set(values)) for values in zip(*cells, strict=True))
        grid = np.full((len(strains), len(angles)), math.nan)
        for (strain, angle), value in cells.items():
            row, column = strains.index(strain), angles.index(angle)
            text, ink = "–", "#6b6b6b"
            if value is not None:
                grid[row, column] = value
                dark = abs(value) > 0.6 if diverging else value < 0.5 * (low + high)
                text, ink = f"{value:.2f}", "#ffffff" if dark else "#202020"
            axes.text(column, row, text, ha="center", va="center", fontsize=7, color=ink)
        image = axes.imshow(grid, origin="lower", aspect="auto", cmap=shades, vmin=low, vmax=high)
        axes.set_xticks(range(len(angles)), [f"{angle:g}" for angle in angles])
        axes.set_yticks(range(len(strains)), [f"{strain:g}" for strain in strains])
        axes.set(title=f"band {band}", xlabel="half-angle (deg)")
    places[0][0].set_ylabel("strain")
    figure.suptitle(title)
    if image is not None:
        figure.colorbar(image, ax=places.ravel().tolist(), shrink=0.8)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return path
