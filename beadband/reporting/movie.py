"""The movie of a run, by matplotlib's writers: GIF through Pillow, MP4 through ffmpeg.

What stays is drawn once and kept as pixels; a frame lays the band and the clock over them.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import RunError, UsageError, explain
from beadband.reporting import colour
from beadband.reporting.report_data import Story, read_story
from beadband.runs import folder as files

Array = NDArray[np.float64]

NAME = "movie.gif"
FORMATS = (".gif", ".mp4")
FRAMES_PER_SECOND = 20
_FPS_RANGE = (1, 50)  # a GIF counts in hundredths of a second, and players slow down what is faster than two
_WIDTH_INCHES, _DPI = 8.0, 100
_GIF_COLOURS = 255
_NEARLY_WHITE = 246  # Pillow looks up colours in coarse boxes: what shares one with the white sheet must be white
_INK, _SOFT, _FINGER, _EDGE, _GHOST = "#1d2126", "#59616b", "#e6dfd4", "#b9ad9a", "#b5b0a8"
_HIT = "#D55E00"


def write(
    folder: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    fps: int = FRAMES_PER_SECOND,
    coloured_by: str = "stretch",
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the movie of a finished run, by default into its folder as movie.gif; return its path.

    UsageError when the folder is not that of a finished run, and as :func:`film` has it.
    """
    files.require(folder, files.RESULTS)
    path = files.outfile(out if out is not None else Path(folder) / NAME)
    return film(read_story(folder), path, fps, coloured_by, progress)


def film(
    story: Story,
    path: Path,
    fps: int = FRAMES_PER_SECOND,
    coloured_by: str = "stretch",
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the movie of a story, whole or not at all; the suffix of ``path`` chooses the format.

    UsageError when the format, its program, the rate or the colour can't be; RunError when the writer fails.
    """
    if path.suffix.lower() not in FORMATS:
        raise UsageError(
            explain("unknown format of a movie", repr(path.name), ", ".join(FORMATS), "choose a suffix with --out")
        )
    if not _FPS_RANGE[0] <= fps <= _FPS_RANGE[1]:
        raise UsageError(
            explain("no such rate of frames", fps, "{} to {} a second".format(*_FPS_RANGE), "change --fps")
        )
    if coloured_by not in colour.NAMES:
        raise UsageError(explain("unknown colour", repr(coloured_by), ", ".join(colour.NAMES), "change --colour"))
    if story.open and coloured_by == "curvature":
        raise UsageError(explain("a strip has no curvature", coloured_by, "stretch", "change --colour"))
    writer = _writer(path.suffix.lower(), fps)
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")
    try:
        _film(story, writer, partial, coloured_by, progress)
        os.replace(partial, path)
    except (OSError, RuntimeError, ValueError) as error:
        raise RunError(
            explain("the movie could not be written", f"{str(path)!r} ({error})", "a disk with room", "free some")
        ) from error
    finally:
        partial.unlink(missing_ok=True)
    return path


def _writer(suffix: str, fps: int) -> Any:
    from matplotlib.animation import FFMpegWriter

    if suffix == ".gif":
        return _gif_writer(fps)
    if not FFMpegWriter.isAvailable():
        raise UsageError(
            explain("an MP4 needs the program ffmpeg", "none on the path", "a GIF without it", "install ffmpeg")
        )
    return FFMpegWriter(fps=fps, codec="h264", extra_args=["-crf", "20", "-pix_fmt", "yuv420p"])


def _gif_writer(fps: int) -> Any:
    """matplotlib's writer of GIFs, with the same colours in all frames.

    Colours chosen frame by frame took twice as long as the drawing, flickered, and made files three times as large.
    """
    from matplotlib.animation import PillowWriter
    from PIL import Image

    class Writer(PillowWriter):
        def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
            super().setup(fig, outfile, dpi)
            self.pages: list[Image.Image] = []

        def grab_frame(self, **asked: Any) -> None:
            pixels = io.BytesIO()
            self.fig.savefig(pixels)
            page = Image.frombuffer("RGBA", self.frame_size, pixels.getvalue(), "raw", "RGBA", 0, 1)
            self.pages.append(page.convert("RGB"))

        def finish(self) -> None:
            wide, high = self.frame_size
            sample = Image.new("RGB", (wide, 3 * high))
            for place, page in enumerate((self.pages[0], self.pages[len(self.pages) // 2], self.pages[-1])):
                sample.paste(page, (0, place * high))
            palette = sample.quantize(_GIF_COLOURS, dither=Image.Dither.NONE)
            colours = np.array(palette.getpalette()).reshape(-1, 3)
            colours[colours.min(axis=1) >= _NEARLY_WHITE] = 255
            palette.putpalette(colours.ravel().tolist())
            first, *others = (page.quantize(palette=palette, dither=Image.Dither.NONE) for page in self.pages)
            first.save(self.outfile, save_all=True, append_images=others, duration=round(1000.0 / self.fps), loop=0)

    return Writer(fps=fps)


def _film(story: Story, writer: Any, path: Path, coloured_by: str, progress: Callable[[int, int], None] | None) -> None:
    """Draw what stays once, as a picture; each frame lays the band and the clock over it."""
    from matplotlib.collections import LineCollection

    scale, values = _colours(story, coloured_by)
    row = _row(scale)
    figure = _figure(story)
    axes = _axes(figure, story)
    _draw_still(figure, axes, story, scale, row)
    finger = _draw_finger(axes, story)
    closed = _joined(story)
    band = LineCollection([], linewidths=_points(figure, axes, story.thickness_m), capstyle="round", animated=True)
    axes.add_collection(band, autolim=False)
    (rings,) = axes.plot([], [], "o", markersize=11, markerfacecolor="none", markeredgecolor=_SOFT, animated=True)
    title = figure.text(0.5, 0.955, "", ha="center", va="center", fontsize=13, color=_INK, animated=True)
    speeds = np.interp(story.times_s, story.tip_times_s, story.tip_speed_m_s)
    with writer.saving(figure, str(path), _DPI):
        figure.hold_still([*finger, band, rings, title])
        for frame, time in enumerate(story.times_s.tolist()):
            points = closed[frame]
            for artist in finger:
                artist.set_visible(story.finger.until_s is None or time < story.finger.until_s)
            _move_finger(finger, story, frame)
            band.set_segments(list(np.stack([points[:-1], points[1:]], axis=1)))
            band.set_color(row(scale.place(values[frame, : len(points) - 1])))
            if story.touches_m:
                rings.set_data(*story.touches_m[frame].T)
            speed = f"V = {speeds[frame]:5.2f} m/s" if frame else "held"
            title.set_text(f"t = {time * 1e3:.2f} ms    {speed}")
            writer.grab_frame()
            if progress:
                progress(frame + 1, story.frames)


def _joined(story: Story) -> Array:
    """Positions, shape (frames, bonds + 1, 2): those of a closed band with the first bead once more."""
    return story.positions_m if story.open else np.concatenate([story.positions_m, story.positions_m[:, :1]], axis=1)


def _colours(story: Story, coloured_by: str) -> tuple[colour.Scale, Array]:
    """The scale, and the value of each bond, shape (frames, beads)."""
    if coloured_by == "stretch":
        return colour.stretch_scale(story.stretch), story.stretch
    bent = story.curvature_1_m
    return colour.curvature_scale(bent, story.finger.radius_m), 0.5 * (bent + np.roll(bent, -1, axis=1))


def _row(scale: colour.Scale) -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list(scale.name, scale.anchors, N=64)


def _box(story: Story) -> tuple[Array, Array]:
    """Corners of what is seen: band and finger at all times, m."""
    edge, radius = 1.5 * story.thickness_m, story.finger.radius_m
    nearest, farthest = story.finger.reach_m()
    low = np.minimum(story.positions_m.min(axis=(0, 1)), [nearest, -radius])
    high = np.maximum(story.positions_m.max(axis=(0, 1)), [farthest, radius])
    # A strip is flat: room for the bar below it.
    beside = np.array([0.0, 0.06 * float(high[0] - low[0]) if story.open else 0.0])
    return low - edge - beside, high + edge + beside


def _figure(story: Story) -> Any:
    """An empty sheet with room for a heading and a row of colours; an even number of pixels, as MP4 wants it.

    The writers ask a figure to save itself as raw pixels. This one lays its moving parts over the kept pixels of the
    rest, where another would redraw all of it.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    class Sheet(Figure):
        @property
        def pen(self) -> Any:
            return self.canvas

        def hold_still(self, moving: list[Any]) -> None:
            self.moving = moving
            self.pen.draw()
            self.still = self.pen.copy_from_bbox(self.bbox)

        def savefig(self, fname: Any, *, transparent: bool | None = None, **kwargs: Any) -> None:
            self.pen.restore_region(self.still)
            for artist in self.moving:
                self.draw_artist(artist)
            fname.write(self.pen.buffer_rgba())

    low, high = _box(story)
    shape = float((high - low)[1] / (high - low)[0])
    height = 2 * round(0.5 * _DPI * (_WIDTH_INCHES * min(max(shape, 0.25), 0.75) + 1.0)) / _DPI
    figure = Sheet(figsize=(_WIDTH_INCHES, height), dpi=_DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _axes(figure: Any, story: Story) -> Any:
    low, high = _box(story)
    tall = figure.get_figheight()
    axes = figure.add_axes((0.01, 0.55 / tall, 0.98, 1.0 - 0.95 / tall))
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal")
    axes.set_axis_off()
    return axes


def _points(figure: Any, axes: Any, length_m: float) -> float:
    """A length of the scene in points of the figure, for line widths."""
    axes.apply_aspect()
    ends = axes.transData.transform([[0.0, 0.0], [length_m, 0.0]])
    return float(max((ends[1, 0] - ends[0, 0]) * 72.0 / figure.dpi, 1.5))


def _draw_finger(axes: Any, story: Story) -> list[Any]:
    """The finger up to the inner face of the band, with its name: moving parts, for it may be withdrawn."""
    from matplotlib.patches import Circle

    if story.open:
        return []
    centre, inner = (story.finger.centre_m, 0.0), story.finger.radius_m - 0.5 * story.thickness_m
    circle = axes.add_patch(Circle(centre, inner, facecolor=_FINGER, edgecolor=_EDGE, animated=True))
    name = axes.text(*centre, "finger", ha="center", va="center", color=_SOFT, fontsize=10, animated=True)
    (mark,) = axes.plot([], [], marker="*", markersize=16, color=_HIT, zorder=5, animated=True)
    return [circle, name, mark]


def _move_finger(parts: list[Any], story: Story, frame: int) -> None:
    """Take the finger to its place at a frame, and mark the hit in the last one before it."""
    circle, name, mark = parts
    x = story.finger.at(frame)
    circle.set_center((x, 0.0))
    name.set_position((x, 0.0))
    hit = story.finger.hit_s is not None and frame == story.frames - 1
    mark.set_data([x - story.finger.radius_m] if hit else [], [0.0] if hit else [])


def _draw_still(figure: Any, axes: Any, story: Story, scale: colour.Scale, row: Any) -> None:
    """The held shape and its peg, a bar to measure with, the row of colours, and what the scene is."""
    if story.peg:
        from matplotlib.patches import Circle

        inner = max(story.peg.radius_m - 0.5 * story.thickness_m, 0.0)
        axes.add_patch(Circle((story.peg.centre_m, 0.0), inner, fill=False, edgecolor=_EDGE, linewidth=0.8))
    axes.plot(*_joined(story)[0].T, color=_GHOST, linewidth=0.8, linestyle=(0, (4, 4)))
    low, high = _box(story)
    power = 10.0 ** np.floor(np.log10((high - low)[0] / 5.0))
    bar = max(m * power for m in (1.0, 2.0, 5.0) if m * power <= (high - low)[0] / 5.0)
    left, bottom = low + 0.02 * (high - low)
    axes.plot([left, left + bar], [bottom, bottom], color=_SOFT, linewidth=1.5)
    axes.text(left, bottom + 0.015 * (high - low)[1], f"{bar * 1e3:g} mm", fontsize=9, color=_SOFT, va="bottom")

    tall = figure.get_figheight()
    strip = figure.add_axes((0.62, 0.34 / tall, 0.34, 0.12 / tall))
    ends = np.linspace(0.0, 1.0, 65)
    strip.pcolormesh(ends, [0.0, 1.0], 0.5 * (ends[1:] + ends[:-1])[None, :], cmap=row, vmin=0.0, vmax=1.0)
    marks = [-1000.0, -100.0, 0.0, 100.0, 1000.0] if scale.soft else _even(scale.low, scale.high)
    marks = [mark for mark in marks if scale.low <= mark <= scale.high]
    strip.set_xticks(scale.place(np.array(marks)), [f"{mark:g}" for mark in marks], fontsize=8)
    strip.set_yticks([])
    strip.tick_params(length=2, pad=1.5)
    unit = f" ({scale.unit})" if scale.unit else ""
    strip.text(-0.02, 0.5, scale.label + unit, transform=strip.transAxes, ha="right", va="center", fontsize=9)
    figure.text(0.02, 0.40 / tall, story.title, fontsize=9, color=_SOFT, va="center", parse_math=False)


def _even(low: float, high: float) -> list[float]:
    from matplotlib.ticker import MaxNLocator

    return [float(f"{tick:.6g}") for tick in MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(low, high)]
