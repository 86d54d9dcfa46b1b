"""Fits of laws to a tensile test: a table, a picture of all of them over the data, and scene files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from beadband.model.fitting import Fit, Fits
from beadband.model.scenefile import law_text
from beadband.reporting.style import SCREEN, Style, line_of

_DRAWN = 6
"""Fits in the picture, the best first; more can't be told apart."""


def table(found: Fits) -> str:
    """The fits for a person, the best first."""
    lines = [
        f"{found.test.source}: {len(found.test.stretch)} points up to a stretch of {found.test.stretch[-1]:.4g}; fits "
        f"judged up to a strain of {found.strain:.4g}"
    ]
    for one, weight in zip(found.fits, found.weights, strict=True):
        lines.append(
            f"  {one.label}: misfit {one.relative_misfit:.2%}, AICc {one.aicc - found.best.aicc:.1f} above the best, "
            f"weight {weight:.2g}, E0 {one.law.rest_modulus_pa / 1e6:.4g} MPa"
        )
        for name, value, error in zip(one.names, one.values.tolist(), one.errors.tolist(), strict=True):
            lines.append(f"      {name.ljust(10)} {value:.6g} +/- {error:.2g}")
        lines += [f"      note: {notice}" for notice in one.notices]
    lines += [f"  {name}: not fitted, {why}" for name, why in found.left_out]
    return "\n".join(lines)


def write(found: Fits, folder: Path, style: Style = SCREEN) -> list[Path]:
    """Write fits.png, a scene file for each law and scene.toml, that of the best, into a folder; return the paths."""
    written = [_draw(found, folder / "fits", style)]
    best: dict[str, Fit] = {}
    for one in found.fits:
        best.setdefault(one.law.name, one)
    for name, one in best.items():
        written.append(_scene(one, found, folder / f"{name}.toml"))
    written.append(_scene(found.best, found, folder / "scene.toml"))
    return written


def _scene(one: Fit, found: Fits, path: Path) -> Path:
    source = " ".join(found.test.source.split())
    head = (
        f"# {one.label}, fitted to {source} up to a stretch of {found.test.stretch[-1]:.4g}.\n"
        "# The covariance is that of the noise of the test: what the law can't describe comes on top.\n"
        "# Add the band that it is for, as [band] with circumference_m, width_m, thickness_m and density_kg_m3, or\n"
        "# give its sizes by flags. Without them a run takes those of band III.\n"
    )
    path.write_text(head + "\n" + law_text(one.scene_values()), encoding="utf-8")
    return path


def _draw(found: Fits, path: Path, style: Style) -> Path:
    """Data and fits above, what the fits leave below."""
    test = found.test
    stretch = np.linspace(float(test.stretch[0]), float(test.stretch[-1]), 400)
    with style.applied() as pyplot:
        figure, (above, below) = pyplot.subplots(
            2, 1, figsize=style.size_in(7.2, 6.6), sharex=True, height_ratios=(2, 1), layout="constrained"
        )
        above.plot(test.stretch, test.stress_pa / 1e6, "o", color="black", markersize=3.5, label="test", zorder=5)
        for number, one in enumerate(found.fits[:_DRAWN]):
            line: dict[str, Any] = line_of(number)
            above.plot(stretch, np.asarray(one.law.stress(stretch)) / 1e6, linewidth=1.4, label=one.label, **line)
            some = np.abs(test.stress_pa) > 0.02 * np.abs(test.stress_pa).max()
            left = np.asarray(one.law.stress(test.stretch))[some] / test.stress_pa[some] - 1.0
            below.plot(test.stretch[some], 100.0 * left, linewidth=1.0, **line)
        below.axhline(0.0, color="black", linewidth=0.6)
        for axes in (above, below):
            axes.axvline(1.0 + found.strain, color="#999999", linewidth=0.8, linestyle=":")
        most, least = 1.1e-6 * float(test.stress_pa.max()), min(0.0, 1e-6 * float(test.stress_pa.min()))
        above.set(ylabel="nominal stress (MPa)", ylim=(least, most))
        below.set(xlabel="stretch", ylabel="fit over test − 1 (%)", ylim=(-30.0, 30.0))
        above.legend(frameon=False, fontsize=8)
        written = style.save(figure, path)
        pyplot.close(figure)
    return written
