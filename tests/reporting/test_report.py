"""The page and the movie of a run: they show what was computed, need nothing else, and take words as words."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import browser
import numpy as np
import pytest

from beadband.analysis.curvature import bond_stretch, ring_curvature
from beadband.cli import main
from beadband.model.scene import scene_of
from beadband.reporting import colour, movie, page
from beadband.reporting.report_data import Finger, Story, read_story, tell
from beadband.runs import folder as files
from beadband.runs import release
from beadband.runs.results import Run
from conftest import REQUIRE_ALL, WITHOUT

EVIL = "</script><script>window.broken = 1</script><!-- {{script}} <img src=x onerror='window.broken=1'> \u2028 & \"é\""
LAUNCH = {
    "centre_of_mass_speed_m_s": 12.5,
    "centre_of_mass_speed_error_m_s": 0.02,
    "efficiency": 0.69,
    "finger_free_s": 0.0034,
    "rear_arrival_s": 0.0046,
    "pause_s": 0.0012,
    "series": {
        "t_s": [0.0, 0.002, 0.0034, 0.0046],
        "finger_force_n": [3.26, 3.26, 0.0, 0.0],
        "clearance_m": [0.08, 0.05, 0.02, 0.0],
        "centre_x_m": [0.06, 0.07, 0.08, 0.1],
        "centre_speed_m_s": [0.0, 6.0, 12.0, 12.5],
    },
}


@pytest.fixture(scope="module")
def told(default_run: tuple[Run, Path]) -> Story:
    return read_story(default_run[1])


@pytest.fixture(scope="module")
def results(default_run: tuple[Run, Path]) -> dict[str, Any]:
    return dict(json.loads((default_run[1] / files.RESULTS).read_text(encoding="utf-8")))


@pytest.fixture(scope="module")
def launched(told: Story, results: dict[str, Any], default_run: tuple[Run, Path]) -> Story:
    """A launch with evil words; its frames are those of the release."""
    scene = {**results["scene"], "label": EVIL, "finger": "clears"}
    changed = {**results, "scene": scene, "launch": LAUNCH, "warnings": [EVIL, *results["warnings"]]}
    return tell(changed, told.times_s, told.positions_m, default_run[0].energy, EVIL)


def stored(html: str) -> dict[str, Any]:
    """What a page tells its script."""
    found = re.search(r'<script id="story" type="application/json">(.*?)</script>', html, re.DOTALL)
    assert found
    return dict(json.loads(found[1]))


def unpacked(data: str, *shape: int) -> np.ndarray[Any, Any]:
    return np.frombuffer(base64.b64decode(data), "<u2").astype(float).reshape(shape)


# ---- the story


@pytest.mark.parametrize("way", [1, -1])
def test_stretch_and_curvature_of_a_polygon(way: int) -> None:
    beads, radius, spacing = 50, 0.03, 0.003
    angle = way * 2.0 * math.pi * np.arange(beads) / beads
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)[None]
    assert np.allclose(bond_stretch(ring, spacing), 2.0 * radius * math.sin(math.pi / beads) / spacing, rtol=1e-12)
    assert np.allclose(ring_curvature(ring, spacing), 2.0 * math.pi / beads / spacing, rtol=1e-12)


def test_the_colours_carry_the_energy_that_lammps_found(default_run: tuple[Run, Path], told: Story) -> None:
    """Stretch and curvature as drawn, put into the law and into EI/2 k^2, against the energies of the held ring."""
    run = default_run[0]
    strand = run.plan.scene.strand(run.plan.beads)
    stretching = strand.spacing_m * strand.area_m2 * float(np.sum(strand.law.energy(told.stretch[0])))
    assert stretching == pytest.approx(run.energy.stretching_j[0], rel=1e-8)
    bent = told.curvature_1_m[0] ** 2
    bending = 0.5 * strand.bending_stiffness_n_m2 * strand.spacing_m * float(np.sum(bent))
    assert bending == pytest.approx(run.energy.bending_j[0], rel=1e-3)
    tip = run.measurement.rear.tip_curvature_1_m
    assert told.curvature_1_m[0, 0] == pytest.approx(tip[0], rel=1e-6)


def test_energies_stack_up_to_what_was_stored(told: Story, default_run: tuple[Run, Path]) -> None:
    chart = next(chart for chart in told.charts if chart.stacked)
    total = np.sum([curve.values for curve in chart.curves], axis=0)
    assert total[0] == pytest.approx(100.0, rel=1e-12)
    assert np.abs(total - 100.0).max() == pytest.approx(100.0 * default_run[0].energy.error, rel=1e-9)


def test_a_launch_brings_its_curves_and_rows(launched: Story) -> None:
    charts = {chart.key: chart for chart in launched.charts}
    assert list(charts) == ["speed", "curvature", "finger_force_n", "clearance_m", "energy"]
    assert charts["finger_force_n"].window_s == (0.0034, 0.0046)
    assert charts["clearance_m"].curves[0].values[0] == pytest.approx(80.0)
    assert [curve.name for curve in charts["speed"].curves][:2] == ["rear tip", "centre of mass"]
    rows = dict(launched.results)
    assert rows["speed of the centre of mass"] == "12.500 +/- 0.020 m/s"
    assert rows["pause between them"] == "1.2 ms"
    assert launched.finger.until_s == 0.0034
    assert launched.headline.endswith("a pause of 1.2 ms.")


def test_a_launch_that_did_not_get_there(results: dict[str, Any], told: Story, default_run: tuple[Run, Path]) -> None:
    some = {**LAUNCH, "rear_arrival_s": None, "pause_s": None, "series": {}}
    story = tell({**results, "launch": some}, told.times_s, told.positions_m, default_run[0].energy, "x")
    assert dict(story.results)["rear at the finger"] == "not reached"
    assert [chart.key for chart in story.charts] == ["speed", "curvature", "energy"]
    assert story.finger.until_s is None
    assert "pause" not in story.headline


def test_a_peg_is_drawn_where_it_held_the_band(tmp_path: Path) -> None:
    scene = scene_of({"tip_radius_m": 6e-3, "beads": 200, "for": "speed", "frames": 2})
    run = release.run(scene, tmp_path / "run")
    story = read_story(tmp_path / "run")
    assert story.peg == Finger(6e-3, 6e-3, 0.0)
    away = np.hypot(story.positions_m[0, :, 0] - 6e-3, story.positions_m[0, :, 1])
    assert (np.abs(away / 6e-3 - 1.0) < 1e-9).sum() >= 7
    told = stored(page.page(story))
    assert {"centre_m": 6e-3, "radius_m": 6e-3, "until_s": 0.0, "way_m": None}.items() <= told["peg"].items()
    for each in (story, replace(story, peg=None)):
        movie.film(each, tmp_path / f"{bool(each.peg)}.gif", 20, "curvature")
    assert (tmp_path / "True.gif").read_bytes() != (tmp_path / "False.gif").read_bytes()
    assert run.plot(tmp_path)


def test_scales_run_from_end_to_end() -> None:
    bent = colour.curvature_scale(np.array([-200.0, 1500.0]), 0.025)
    assert np.allclose(bent.place(np.array([-1500.0, 0.0, 1500.0, 9e9])), [0.0, 0.5, 1.0, 1.0])
    rising = bent.place(np.linspace(-1500.0, 1500.0, 99))
    assert np.all(np.diff(rising) > 0.0)
    assert np.allclose(rising + rising[::-1], 1.0)
    # Half way from straight to the finger's curvature shows as clearly as from there to its fivefold.
    assert bent.place(np.array([40.0]))[0] - 0.5 > 0.1
    even = colour.stretch_scale(np.array([1.0, 1.5]))
    assert np.allclose(even.place(np.array([1.0, 1.25, 1.5])), [0.0, 0.5, 1.0])


# ---- the page


def test_positions_come_back_within_the_stated_error(told: Story) -> None:
    values = stored(page.page(told))
    places = values["positions"]
    shape = (len(values["times_s"]), values["beads"])
    back = places["low_m"] + places["step_m"] * unpacked(places["data"], *shape, 2)
    worst = float(np.abs(back - told.positions_m).max())
    assert worst <= 0.5001 * places["step_m"]
    assert f"{0.5e6 * places['step_m']:.2g} µm" in values["notes"][-1]
    for given, exact in zip(values["colours"], (told.stretch, told.curvature_1_m), strict=True):
        step = (given["high"] - given["low"]) / 65535
        assert np.abs(given["low"] + step * unpacked(given["data"], *shape) - exact).max() <= 0.5001 * step


def grown(told: Story, frames: int, beads: int) -> Story:
    """As many frames and beads as asked for, of noise: nothing that base64 could hide."""
    random = np.random.default_rng(7)
    return replace(
        told,
        times_s=np.linspace(0.0, 2e-3, frames),
        positions_m=random.normal(size=(frames, beads, 2)),
        stretch=random.uniform(1.0, 1.5, size=(frames, beads)),
        curvature_1_m=random.normal(size=(frames, beads)),
    )


def test_pages_stay_small(told: Story) -> None:
    assert len(page.page(told).encode()) < 500_000
    fine = grown(told, 61, 2000)
    text = page.page(fine)
    assert len(text.encode()) < 3_000_000
    assert stored(text)["beads"] == 2000
    large = page.page(grown(told, 600, 6000))
    assert len(large.encode()) < 3_000_000
    kept = stored(large)
    assert kept["times_s"][-1] == 2e-3
    assert any("bead in" in note for note in kept["notes"])
    assert any("of 600 frames" in note for note in kept["notes"])


class _Tags(HTMLParser):
    """Elements of a page with what stands in its scripts."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.inside: list[str] = []
        self.open = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.open = tag in ("script", "style")
        if self.open:
            self.inside.append("")

    def handle_endtag(self, tag: str) -> None:
        self.open = False

    def handle_data(self, data: str) -> None:
        if self.open:
            self.inside[-1] += data


def test_the_page_needs_no_network_and_allows_none(told: Story) -> None:
    html = page.page(told)
    assert not re.search(r"https?://|//cdn|@import|url\(", html)
    parsed = _Tags()
    parsed.feed(html)
    sources = [value for _, given in parsed.tags for key, value in given.items() if key in ("src", "href")]
    assert sources == ["data:,"]
    policy = next(given["content"] for tag, given in parsed.tags if given.get("http-equiv"))
    assert policy is not None
    assert policy.startswith("default-src 'none';")
    assert "unsafe" not in policy
    style, _, script = parsed.inside
    for text in (style, script):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy


def test_words_stay_words(launched: Story) -> None:
    html = page.page(launched)
    assert html.count("<script") == 2
    assert "<!--" not in html
    assert "<img" not in html
    values = stored(html)
    assert values["name"] == EVIL
    assert values["warnings"][0] == EVIL
    assert EVIL in values["title"]


def test_report_command(default_run: tuple[Run, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, out = default_run[1], tmp_path / "a page é.html"
    assert main(["report", str(folder), "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [str(out)]
    assert stored(out.read_text(encoding="utf-8"))["name"] == folder.name
    assert [path.name for path in tmp_path.iterdir()] == [out.name]


@pytest.mark.parametrize("command", ["report", "movie"])
def test_what_is_no_finished_run_is_refused(
    command: str, default_run: tuple[Run, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*more: str) -> str:
        assert main([command, str(tmp_path), *more]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert not list(tmp_path.glob("*.html")) + list(tmp_path.glob("*.gif"))
        return said.err

    for name in (files.SCENE, files.TRAJECTORY, files.REAR, files.ENERGY):
        (tmp_path / name).write_bytes((default_run[1] / name).read_bytes())
    assert "without results.json" in refused()
    (tmp_path / files.RESULTS).write_text("{")
    assert "can't be read" in refused()
    (tmp_path / files.RESULTS).write_text('{"scene": {"beads": 520}}')
    assert "can't be understood" in refused()
    (tmp_path / files.RESULTS).write_bytes((default_run[1] / files.RESULTS).read_bytes())
    assert "--out" in refused("--out", str(tmp_path / "missing" / "x.gif"))
    cut = (default_run[1] / files.TRAJECTORY).read_bytes()[:200_000]
    (tmp_path / files.TRAJECTORY).write_bytes(cut)
    assert "trajectory" in refused()


# ---- the movie


def test_the_movie_shows_the_band_at_its_size(
    default_run: tuple[Run, Path], told: Story, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Coloured pixels over the square of the pixels in a metre are length times thickness."""
    from PIL import Image

    out = tmp_path / "x.gif"
    assert main(["movie", str(default_run[1]), "--out", str(out), "--fps", "25", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == [str(out)]
    assert out.stat().st_size < 1_000_000
    with Image.open(out) as film:
        assert film.n_frames == told.frames
        assert film.info["duration"] == 40
        for frame in (0, told.frames // 2, told.frames - 1):
            film.seek(frame)
            pixels = np.asarray(film.convert("RGB")).astype(int)
            vivid = np.abs(pixels[:-60, :, 0] - pixels[:-60, :, 2]) > 100  # half orange at least; above the row
            columns = np.flatnonzero(vivid.any(axis=0))
            x = told.positions_m[frame, :, 0]
            wide = float(x.max() - x.min()) + told.thickness_m
            pixel = wide / (columns[-1] - columns[0] + 1)
            length = float(told.stretch[frame].mean()) * default_run[0].plan.scene.band.circumference_m
            assert vivid.sum() * pixel**2 == pytest.approx(length * told.thickness_m, rel=0.03)


def test_an_mp4_without_ffmpeg_is_refused(
    default_run: tuple[Run, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["movie", str(default_run[1]), "--out", str(tmp_path / "x.mp4")]) == 2
    assert "ffmpeg" in capsys.readouterr().err
    assert main(["movie", str(default_run[1]), "--out", str(tmp_path / "x.avi")]) == 2
    assert main(["movie", str(default_run[1]), "--fps", "0"]) == 2
    assert list(tmp_path.iterdir()) == []


def test_a_hand_moves_its_finger_and_the_hit_is_marked(
    told: Story, results: dict[str, Any], default_run: tuple[Run, Path], tmp_path: Path
) -> None:
    """Its way at the frames, in story, page and movie; the star at the surface is in the last frame alone."""
    from PIL import Image

    felt = {"hit": True, "hit_s": 0.0046, "hit_speed_m_s": 17.2}
    ends = told.times_s[[0, -1]].tolist()
    series = {**LAUNCH["series"], "t_s": [ends[0], *ends, ends[1]], "hand_x_m": [0.0, 0.0, 0.02, 0.02]}
    changed = {**results, "launch": {**LAUNCH, "series": series, "hand": felt}}
    story = tell(changed, told.times_s, told.positions_m, default_run[0].energy, "hand")
    still = told.finger
    assert story.finger.at(0) == still.centre_m
    assert story.finger.at(story.frames - 1) == pytest.approx(still.centre_m + 0.02)
    assert story.finger.reach_m() == pytest.approx((still.reach_m()[0], still.reach_m()[1] + 0.02))
    assert "hits the hand at 17.2 m/s" in story.headline
    assert "hand_x_m" in [chart.key for chart in story.charts]
    drawn = stored(page.page(story))["finger"]
    assert (drawn["way_m"][0], drawn["way_m"][-1], drawn["hit_s"]) == (0.0, 0.02, 0.0046)
    keep = [0, 1, -1]
    short = replace(
        story,
        **{name: getattr(story, name)[keep] for name in ("times_s", "positions_m", "stretch", "curvature_1_m")},
        finger=replace(story.finger, way_m=story.finger.way_m[keep]),
    )
    movie.film(short, tmp_path / "x.gif", 20, "curvature")
    with Image.open(tmp_path / "x.gif") as film:
        stars = []
        for frame in range(3):
            film.seek(frame)
            red, green, blue = np.moveaxis(np.asarray(film.convert("RGB"), dtype=int)[:400], 2, 0)
            stars.append(int(((red > 180) & (green < 120) & (blue < 60)).sum()))
    assert stars[2] > stars[1] + 40


def test_a_withdrawn_finger_leaves_the_movie(launched: Story, tmp_path: Path) -> None:
    from PIL import Image

    short = replace(
        launched,
        times_s=launched.times_s[:2],
        positions_m=launched.positions_m[:2],
        stretch=launched.stretch[:2],
        curvature_1_m=launched.curvature_1_m[:2],
        finger=replace(launched.finger, until_s=1e-9),
    )
    movie.film(short, tmp_path / "x.gif", 20, "curvature")
    with Image.open(tmp_path / "x.gif") as film:
        counts = []
        for frame in range(2):
            film.seek(frame)
            counts.append(int(np.all(np.asarray(film.convert("RGB")) == 255, axis=2).sum()))
    assert counts[1] - counts[0] > 40_000  # the disc has become white


# ---- the page in a browser


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    program = browser.find()
    if program is None:
        if REQUIRE_ALL and "chromium" not in WITHOUT:
            pytest.fail("a Chromium is missing")
        pytest.skip("needs Chromium")
    with browser.Browser(program, tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def shown(chromium: browser.Browser, told: Story, tmp_path: Path) -> browser.Browser:
    """The page of the default run, freshly opened on a desktop."""
    return show(chromium, told, tmp_path)


def show(chromium: browser.Browser, story: Story, place: Path, width: int = 1280) -> browser.Browser:
    path = place / "report.html"
    files.write_text(path, page.page(story))
    chromium.complaints.clear()
    chromium.requests.clear()
    chromium.size(width, 900, mobile=width < 700)
    chromium.open(path)
    return chromium


def cursors(shown: browser.Browser) -> list[float]:
    return list(shown.ask("[...document.querySelectorAll('.cursor')].map((line) => Number(line.getAttribute('x1')))"))


def frame(shown: browser.Browser) -> int:
    return int(shown.ask("document.getElementById('time').textContent.match(/frame (\\d+)/)[1]"))


def set_clock(shown: browser.Browser, share: float) -> None:
    shown.ask(
        "(() => { const clock = document.getElementById('clock');"
        f"clock.value = {share} * clock.max; clock.dispatchEvent(new Event('input')); }})()"
    )


def test_it_loads_and_asks_for_nothing(shown: browser.Browser, told: Story) -> None:
    assert shown.complaints == []
    assert [url.split(":")[0] for url in shown.requests if not url.startswith("data:")] == ["file"]
    assert shown.ask("document.getElementById('title').textContent") == told.title
    assert shown.ask("document.querySelectorAll('#results tr').length") == len(told.results)
    assert shown.ask("document.querySelectorAll('.chart').length") == 3
    # What the page may not do, should words ever turn into markup.
    shown.ask("fetch('data:,x').catch(() => 0)")
    shown.ask("document.body.append(Object.assign(document.createElement('script'), {textContent: 'window.x = 1'}))")
    assert shown.ask("window.x === undefined")
    assert len(shown.complaints) >= 2


def test_play_moves_clock_curves_and_band(shown: browser.Browser) -> None:
    before, picture = cursors(shown), shown.ask("document.getElementById('stage').toDataURL()")
    shown.press(" ")
    assert shown.ask("document.getElementById('play').textContent") == "Pause"
    shown.wait("document.getElementById('clock').value > 0.05 * document.getElementById('clock').max")
    shown.press(" ")
    assert shown.ask("document.getElementById('play').textContent") == "Play"
    after = cursors(shown)
    assert len(after) == 3
    assert all(a > b for a, b in zip(after, before, strict=True))
    assert shown.ask("document.getElementById('stage').toDataURL()") != picture
    value = shown.ask("document.getElementById('clock').value")
    shown.ask("new Promise((done) => setTimeout(done, 100))")
    assert shown.ask("document.getElementById('clock').value") == value
    assert shown.complaints == []


def test_slider_moves_the_cursors_to_its_time(shown: browser.Browser, told: Story) -> None:
    """Linear axes: equal shares of time move cursors by equal lengths. Logarithmic: by equal ones for equal ratios."""
    found = []
    for share in (0.2, 0.4, 0.8):
        set_clock(shown, share)
        found.append(cursors(shown))
        time = share * told.times_s[-1]
        speed = float(np.interp(time, told.tip_times_s, told.tip_speed_m_s))
        reading = shown.ask("document.querySelector('[data-key=speed] b').textContent")
        assert float(reading) == pytest.approx(speed, rel=6e-3)
    first, second, third = np.array(found)
    for linear in (0, 2):
        assert (third - second)[linear] == pytest.approx(2.0 * (second - first)[linear], rel=1e-6)
    assert (third - second)[1] == pytest.approx((second - first)[1], rel=1e-6)
    shown.ask("document.querySelector('[data-key=curvature] input').click()")
    linear_now = cursors(shown)[1]
    assert linear_now != pytest.approx(third[1], abs=1.0)


def test_keyboard(shown: browser.Browser, told: Story) -> None:
    last = told.frames - 1
    for key, expected in (
        ("ArrowRight", 1),
        ("ArrowRight", 2),
        ("ArrowLeft", 1),
        ("End", last),
        ("ArrowRight", last),
        ("ArrowLeft", last - 1),
        ("Home", 0),
    ):
        shown.press(key)
        assert frame(shown) == expected
    reached = []
    for _ in range(5):
        shown.press("Tab")
        reached.append(shown.ask("document.activeElement.id || document.activeElement.type"))
        assert shown.ask("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    assert reached == ["radio", "play", "clock", "speed", "checkbox"]
    # A button that has the focus is pressed once, not twice; the slider steps by frames like the rest of the page.
    shown.ask("document.getElementById('play').focus()")
    shown.press(" ")
    assert shown.ask("document.getElementById('play').textContent") == "Pause"
    shown.press(" ")
    shown.press("Home")
    shown.ask("document.getElementById('clock').focus()")
    shown.press("ArrowRight")
    assert frame(shown) == 1
    assert shown.ask("document.getElementById('clock').getAttribute('aria-valuetext')").endswith("frame 1 of 60")


def test_charts_can_be_dragged(shown: browser.Browser) -> None:
    shown.ask("document.querySelector('[data-key=energy]').scrollIntoView()")
    left, top, width, height = shown.ask(
        "(() => { const r = document.querySelector('[data-key=energy] > svg').getBoundingClientRect();"
        "return [r.left, r.top, r.width, r.height]; })()"
    )
    shown.click(left + 0.5 * width, top + 0.4 * height)
    assert cursors(shown)[2] == pytest.approx(0.5 * width, abs=2.0)
    assert 20 < frame(shown) < 40


def test_every_control_has_a_name(shown: browser.Browser) -> None:
    shown.send("Accessibility.enable")
    nodes = shown.send("Accessibility.getFullAXTree")["nodes"]
    wanted = {"button", "slider", "combobox", "radio", "checkbox", "image", "RadioButton"}
    seen = [node for node in nodes if not node["ignored"] and node["role"]["value"] in wanted]
    assert len(seen) >= 10
    assert all(node.get("name", {}).get("value") for node in seen)


@pytest.mark.parametrize("width", [360, 800])
def test_nothing_sticks_out(chromium: browser.Browser, launched: Story, tmp_path: Path, width: int) -> None:
    shown = show(chromium, launched, tmp_path, width)
    assert shown.ask("document.documentElement.scrollWidth") <= width
    over = shown.ask(
        f"[...document.querySelectorAll('main *')].filter((e) => e.getBoundingClientRect().right > {width})"
        ".map((e) => e.tagName + e.id)"
    )
    assert over == []


def test_a_launch_with_evil_words(chromium: browser.Browser, launched: Story, tmp_path: Path) -> None:
    shown = show(chromium, launched, tmp_path)
    assert shown.complaints == []
    assert shown.ask("window.broken === undefined")
    assert shown.ask("document.querySelectorAll('img, script').length") == 2
    assert EVIL in shown.ask("document.getElementById('title').textContent")
    assert shown.ask("document.querySelector('#warnings li').textContent") == EVIL
    before = cursors(shown)
    assert len(before) == 5
    shown.press("End")
    assert all(a > b for a, b in zip(cursors(shown), before, strict=True))


def contrast(shown: browser.Browser, element: str) -> float:
    """Contrast of an element's text against the ground of the page (WCAG 2)."""

    def light(colour: str) -> float:
        parts = [int(part) / 255.0 for part in re.findall(r"\d+", colour)[:3]]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    ink = light(shown.ask(f"getComputedStyle(document.querySelector('{element}')).color"))
    ground = light(shown.ask("getComputedStyle(document.body).backgroundColor"))
    return (max(ink, ground) + 0.05) / (min(ink, ground) + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_readable_in_light_and_dark(shown: browser.Browser, scheme: str) -> None:
    shown.send("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    ground = shown.ask("getComputedStyle(document.body).backgroundColor")
    assert (int(re.findall(r"\d+", ground)[0]) > 128) == (scheme == "light")
    for element in ("h1", "#headline", "th", "td", ".hint", "label"):
        assert contrast(shown, element) >= 4.5
    shown.send("Emulation.setEmulatedMedia", features=[])


def test_on_paper_pictures_stand_for_the_controls(shown: browser.Browser) -> None:
    shown.send("Emulation.setEmulatedMedia", media="print")
    hidden = "getComputedStyle(document.querySelector('{}')).display"
    assert shown.ask(hidden.format(".controls")) == "none"
    assert shown.ask(hidden.format("#stage")) == "none"
    painted = shown.ask(
        "[...document.querySelectorAll('#prints canvas')].map((c) => c.getBoundingClientRect().width > 50 &&"
        "c.getContext('2d').getImageData(0, 0, c.width, c.height).data.some((v, i) => i % 4 === 0 && v > 200))"
    )
    assert painted == [True] * 6
    shown.send("Emulation.setEmulatedMedia", media="")
    assert shown.paper().startswith(b"%PDF")
