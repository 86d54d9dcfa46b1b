"""The page to play with: in a real browser it gives the numbers of ``beadband ask``, by keyboard and from a link."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser
import pytest

from beadband.cli import main
from beadband.errors import BeadbandError
from beadband.model.bands import catalogue_values
from beadband.model.formula import formula
from beadband.model.scene import scene_of
from conftest import REQUIRE_ALL, WITHOUT

MOST_BYTES = 300_000
LAWS: dict[str, dict[str, tuple[float, float]]] = {
    "linear": {"modulus_pa": (5e5, 3e6)},
    "mooney-rivlin": {"c10_pa": (5e4, 4e5), "c01_pa": (2e4, 4e5)},
    "neo-hookean": {"mu_pa": (2e5, 1e6)},
    "yeoh": {"c1_pa": (1e5, 4e5), "c2_pa": (-4e3, 4e3), "c3_pa": (0.0, 2e3)},
    "gent": {"mu_pa": (2e5, 1e6), "jm": (10.0, 100.0)},
}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page, written by its command."""
    path = tmp_path_factory.mktemp("explore") / "explore, é.html"
    assert main(["explore", "--out", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def shown(page: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[browser.Browser]:
    program = browser.find()
    if program is None:
        if REQUIRE_ALL and "chromium" not in WITHOUT:
            pytest.fail("Chromium is missing")
        pytest.skip("needs a Chromium")
    with browser.Browser(program, tmp_path_factory.mktemp("profile")) as opened:
        opened.size(1280, 900)
        opened.open(page)
        yield opened


def settings(count: int, seed: int) -> list[dict[str, Any]]:
    """Random bands, laws and pulls; half of them bands of the catalogue with their own law."""
    draw, found = random.Random(seed), []
    for number in range(count):
        name = draw.choice(list(catalogue_values()))
        values: dict[str, Any] = dict(catalogue_values()[name])
        if number % 2:
            law = draw.choice(list(LAWS))
            for key in ("c10_pa", "c01_pa"):
                values.pop(key, None)
            values |= {"law": law, **{key: draw.uniform(*ends) for key, ends in LAWS[law].items()}}
            values["thickness_m"] *= draw.uniform(0.5, 1.5)
            values["circumference_m"] *= draw.uniform(0.7, 1.5)
        found.append(values | {"strain": draw.uniform(0.1, 1.6), "half_angle_deg": draw.uniform(4.0, 32.0)})
    return found


def asked(shown: browser.Browser, values: dict[str, Any], rest_modulus_pa: float = 1.0) -> dict[str, Any]:
    """What the script answers."""
    constants = {key: values[key] for key in LAWS[values["law"]]}
    more = {"section": values.get("section", "rectangle"), "rest_modulus_pa": rest_modulus_pa}
    sent = {**values, **more, "constants": constants}
    found: dict[str, Any] = shown.ask(f"window.beadband.answer({json.dumps(sent)})")
    return found


def test_it_is_one_small_file_that_needs_no_network(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < MOST_BYTES
    assert "default-src 'none'" in text
    assert "http://" not in text
    assert "https://" not in text


def test_the_answers_are_those_of_ask(shown: browser.Browser) -> None:
    """200 random settings: value and error to the digits that the page carries, the same scenes refused or outside."""
    answered = refused = 0
    for values in settings(200, 7):
        try:
            expected = formula(scene_of(values), "speed")
            value, error = float(expected.value), float(expected.error)
        except BeadbandError:
            assert "refused" in asked(shown, values), values
            refused += 1
            continue
        scene = scene_of(values)
        found = asked(shown, values, scene.band.rest_modulus_pa)
        assert found["string"] == pytest.approx(scene.string.rear_speed_m_s, rel=1e-9), values
        assert found["inside"] == math.isfinite(error), values
        if found["inside"]:
            assert found["value"] == pytest.approx(value, rel=1e-6), values
            assert found["error"] == pytest.approx(error, rel=1e-3), values
            answered += 1
        speeds = scene.wave_speeds(scene.string.front_speed_m_s)
        assert found["speeds"] == {
            "bar": pytest.approx(speeds["bar"]),
            "rest": pytest.approx(speeds["rest"]),
            "front": pytest.approx(speeds["front_horizontal"]),
        }
    assert answered > 100
    assert refused > 3


def test_a_slider_moves_the_answer_and_a_link_keeps_it(shown: browser.Browser) -> None:
    before = shown.ask("document.getElementById('speed').textContent")
    shown.ask("document.querySelector('input[aria-label=strain]').focus()")
    for _ in range(5):
        shown.press("ArrowRight")
    after = shown.ask("document.getElementById('speed').textContent")
    assert before != after
    assert after.startswith("V = ")
    link = shown.ask("document.getElementById('link').getAttribute('href')")
    shown.ask(f"location.hash = ''; location.hash = {json.dumps(link)}")
    shown.wait(f"document.getElementById('speed').textContent === {json.dumps(after)}")
    seconds = shown.ask(
        "(() => { const r = document.querySelector('input[aria-label=strain]'); const t = performance.now();"
        " r.dispatchEvent(new Event('input')); return performance.now() - t; })()"
    )
    assert seconds >= 0.0
    assert shown.complaints == []
    assert [url for url in shown.requests if not url.startswith(("file:", "data:"))] == []


def test_its_command_gives_its_number(shown: browser.Browser, capsys: pytest.CaptureFixture[str]) -> None:
    shown.ask("location.hash = '#band=II&law=gent&strain=0.7&half_angle_deg=11&mu_pa=400000&jm=40'")
    shown.wait("document.getElementById('command').textContent.includes('gent')")
    command = shown.ask("document.getElementById('command').textContent")
    said = shown.ask("document.getElementById('speed').textContent")
    assert main([*command.split()[1:], "--tolerance", "0.1", "--json"]) == 0
    value = json.loads(capsys.readouterr().out)["value"]
    shown_value, shown_error = (float(word) for word in said.removeprefix("V = ").removesuffix(" m/s").split(" ± "))
    assert abs(shown_value - value) <= 0.5 * shown_error


def test_it_fits_a_phone(shown: browser.Browser) -> None:
    shown.size(360, 740, 2.0, mobile=True)
    assert shown.ask("document.documentElement.scrollWidth <= document.documentElement.clientWidth")
    shown.size(1280, 900)
