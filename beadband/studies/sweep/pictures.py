"""The pictures of a sweep: V/C over the published formula, the scatter of alpha, and maps over two options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from beadband.observables import WAVES
from beadband.parameters import TABLE
from beadband.studies.palette import PALETTE
from beadband.studies.sweep.row import Row
from beadband.studies.sweep.summary import Factor, Totals

_WAVE_NAMES = {"bar": "C = sqrt(E/ρ)", "rest": "C = sqrt(E0/ρ)", "front_horizontal": "C of the front, horizontal"}
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_MAP_AXES = ("strain", "half_angle_deg")
_LABELS = {"strain": "strain", "half_angle_deg": "half-angle (degrees)"}


def draw(totals: Totals, folder: Path) -> list[Path]:
    """Write collapse.png, residuals.png and map.png (where the scenes span strain and half-angle); return the paths.

    Slopes and means are those of all rows, the points those of :meth:`Totals.sample`.
    """
    done = totals.sample()
    if len(done) < 2:
        return []
    import matplotlib

    matplotlib.use("Agg")
    factors = {wave: totals.factors[None, wave] for wave in WAVES}
    written = [_collapse(done, factors, folder / "collapse.png"), _residuals(done, folder / "residuals.png")]
    picture = _maps(done, folder / "map.png")
    return [*written, picture] if picture else written


def _groups(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by band and law, as far as they differ."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        name = ", ".join(str(row[key]) for key in ("band", "law") if row.get(key))
        groups.setdefault(name, []).append(row)
    return groups


def _looks(groups: dict[str, list[Row]]) -> dict[str, dict[str, Any]]:
    """Colour by band and marker by law; those of one law are filled, the others hollow."""
    first = [of[0] for of in groups.values()]
    bands, laws = (list(dict.fromkeys(str(row.get(key)) for row in first)) for key in ("band", "law"))
    looks = {}
    for name, row in zip(groups, first, strict=True):
        band, law = bands.index(str(row.get("band"))), laws.index(str(row.get("law")))
        colour = PALETTE[band % len(PALETTE)]
        looks[name] = {"color": colour, "marker": _MARKERS[law % len(_MARKERS)], "linestyle": "none",
                       "markerfacecolor": colour if law == 0 else "none", "markeredgewidth": 0.7}  # fmt: skip
    return looks


def _save(figure: Any, path: Path) -> Path:
    from matplotlib import pyplot

    figure.savefig(path, dpi=120)
    pyplot.close(figure)
    return path


def _numbers(rows: Sequence[Row], column: str) -> Any:
    return np.array([row[column] for row in rows], dtype=np.float64)


def _collapse(rows: Sequence[Row], factors: Mapping[str, Factor], path: Path) -> Path:
    """V/C against the published formula, for each of the three C."""
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, 3, figsize=(14.0, 4.8), layout="constrained")
    groups = _groups(rows)
    looks = _looks(groups)
    for wave, axes in zip(WAVES, panels, strict=True):
        for name, of in groups.items():
            axes.errorbar(
                _numbers(of, "published_ratio"),
                _numbers(of, f"ratio_{wave}"),
                yerr=_numbers(of, f"alpha_{wave}_error") * _numbers(of, "published_ratio"),
                markersize=3.0,
                elinewidth=0.6,
                label=name or "all",
                **looks[name],
            )
        fit, spread = factors[wave].line.slope, factors[wave].alpha.spread
        reach = np.array([0.0, 1.05 * _numbers(rows, "published_ratio").max()])
        axes.plot(reach, reach, "--", color="#8a8a8a", linewidth=1.0, label="published formula")
        axes.plot(reach, fit.value * reach, color="#202020", linewidth=1.2, label=f"slope {fit.value:.3f}")
        assert spread is not None
        axes.set(
            xlabel="[ε/(1+ε)]/(1 − sin φ)",
            ylabel="V/C",
            title=f"{_WAVE_NAMES[wave]}\nα = {spread.value:.3f} ± {spread.error:.3f} (scatter between scenes)",
            xlim=(0.0, reach[1]),
            ylim=(0.0, None),
        )
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].legend(fontsize=7, frameon=False, loc="upper left")
    return _save(figure, path)


def _residuals(rows: Sequence[Row], path: Path) -> Path:
    """Alpha of each scene over what it should not depend on."""
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, 2, figsize=(12.0, 4.6), layout="constrained", sharey=True)
    groups = _groups(rows)
    looks = _looks(groups)
    for key, axes in zip(_MAP_AXES, panels, strict=True):
        for name, of in groups.items():
            axes.plot(
                _scene_numbers(of, key),
                _numbers(of, "alpha_front_horizontal"),
                markersize=3.0,
                label=name or "all",
                **looks[name],
            )
        axes.axhline(1.0, color="#8a8a8a", linestyle="--", linewidth=1.0)
        axes.set(xlabel=_LABELS[key])
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("α with the horizontal speed of the front")
    panels[0].legend(fontsize=7, frameon=False)
    figure.suptitle("remaining dependence of α")
    return _save(figure, path)


def _scene_numbers(rows: Sequence[Row], key: str) -> Any:
    """An option of the scenes; the default where it was not swept."""
    default = TABLE[key].default
    return np.array([float(row[key]) if row.get(key) not in ("", None) else default for row in rows])


def _maps(rows: Sequence[Row], path: Path) -> Path | None:
    """V/C over strain and half-angle, a panel for each band and law; None where one of the two does not vary."""
    from matplotlib import pyplot

    groups = {
        name: of
        for name, of in _groups(rows).items()
        if all(len(set(_scene_numbers(of, key))) > 1 for key in _MAP_AXES) and len(of) > 3
    }
    if not groups:
        return None
    across = min(4, len(groups))
    down = -(-len(groups) // across)
    figure, panels = pyplot.subplots(
        down, across, figsize=(3.6 * across + 1.0, 3.1 * down + 0.6), layout="constrained", squeeze=False,
        sharex=True, sharey=True,
    )  # fmt: skip
    values = _numbers([row for of in groups.values() for row in of], "ratio_rest")
    points: Any = None
    for axes, (name, of) in zip(panels.flat, groups.items(), strict=False):
        points = axes.scatter(
            _scene_numbers(of, "strain"),
            _scene_numbers(of, "half_angle_deg"),
            c=_numbers(of, "ratio_rest"),
            vmin=values.min(),
            vmax=values.max(),
            s=34,
            marker="s",
            cmap="viridis",
        )
        axes.set_title(name or "all", fontsize=9)
    for axes in panels.flat[len(groups) :]:
        axes.set_visible(False)
    figure.supxlabel(_LABELS["strain"])
    figure.supylabel(_LABELS["half_angle_deg"])
    figure.colorbar(points, ax=panels, label="V / sqrt(E0/ρ)")
    return _save(figure, path)
