"""Constants from a tensile test: exact ones come back, and regions hold them as often as they say."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from beadband.cli import main
from beadband.errors import UsageError
from beadband.model.fitting import fit
from beadband.model.laws import Gent, Law, MooneyRivlin, Ogden, Yeoh
from beadband.model.scene import scene_of
from beadband.model.scenefile import read_scene
from beadband.model.tensile_test import TensileTest
from beadband.model.uncertainty import inputs_of

sys.path.insert(0, str(Path(__file__).parents[1] / "validation"))
from fit_coverage import coverage

TRELOAR = Path(__file__).parents[2] / "docs" / "data" / "treloar-1944.csv"


def exact(law: Law, last: float, points: int = 30) -> TensileTest:
    stretch = np.linspace(1.0, last, points)
    return TensileTest("exact", stretch, np.asarray(law.stress(stretch)), np.ones(points))


@pytest.mark.parametrize(
    ("law", "last"),
    [
        (MooneyRivlin(1.87e5, 1.22e5), 2.2),
        (Yeoh(2e5, -4e3, 3e2), 4.0),
        (Gent(4e5, 30.0), 5.0),
        (Ogden((6.3e5, 1.2e3), (1.3, 5.0)), 5.0),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_exact_constants_come_back(law: Law, last: float) -> None:
    found = fit(exact(law, last), law=law.name)
    one = next(each for each in found.fits if len(each.values) == sum(np.size(v) for v in law.values().values()))
    stretch = np.linspace(1.0, last, 97)
    assert np.abs(one.law.stress(stretch) - law.stress(stretch)).max() < 1e-5 * law.stress(last)
    if law.name != "ogden":  # terms may come in any order
        assert one.values == pytest.approx(list(law.values().values()), rel=1e-4)


@pytest.mark.parametrize("noise", ["of the stress", "of the largest stress"])
def test_regions_hold_as_often_as_they_say(noise: str) -> None:
    """95 %, within three standard errors of 50 draws; 1,000 draws of every law: tests/validation/fit_coverage.py."""
    joint, alone = coverage("gent", noise, 50)
    assert 0.86 <= joint <= 1.0
    assert 0.88 <= alone <= 1.0


def test_real_rubber() -> None:
    """Treloar's test: what is known of it. Without an upturn no law follows it, and three Ogden terms do."""
    found = fit(TRELOAR)
    assert found.best.label == "ogden, 3 terms"
    assert found.best.relative_misfit < 0.02
    assert found["neo-hookean"].relative_misfit > 0.2
    assert "fit-poor" in [one.code for one in found["neo-hookean"].notices]
    assert found["gent"].law.longest_stretch() > 7.6
    assert float(found.weights.sum()) == pytest.approx(1.0)


def test_the_command_writes_scenes_that_run_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a fit, $HOME é"
    assert main(["fit", str(TRELOAR), "--law", "gent", "yeoh", "--strain", "2", "--json", "--out", str(out)]) == 0
    values = json.loads(capsys.readouterr().out)
    assert [one["law"] for one in values["fits"]] == sorted(
        ("gent", "yeoh"), key=lambda name: next(one["aicc"] for one in values["fits"] if one["law"] == name)
    )
    assert (out / "fits.png").read_bytes().startswith(b"\x89PNG")
    for name in ("gent", "yeoh"):
        written = tomllib.loads((out / f"{name}.toml").read_text(encoding="utf-8"))["law"]
        one = next(each for each in values["fits"] if each["law"] == name)
        assert written["covariance"] == one["covariance"]
        inputs = inputs_of(scene_of(read_scene(out / f"{name}.toml")))
        assert inputs is not None
        assert inputs.errors == pytest.approx(one["errors"])
    assert main(["run", "--scene", str(out / "gent.toml"), "--strain", "1", "--for", "speed", "--json",
                 "--beads", "120", "--out", str(tmp_path / "run")]) == 0  # fmt: skip
    done = json.loads(capsys.readouterr().out)
    assert done["rebound_speed_input_error_m_s"] > 0.0
    assert sum(one["share"] for one in done["inputs"]) == pytest.approx(1.0)


def test_what_can_not_be_fitted_is_refused() -> None:
    with pytest.raises(UsageError, match="no law that can be fitted"):
        fit(TRELOAR, law="tensile")
    with pytest.raises(UsageError, match="does not reach the strain"):
        fit(TRELOAR, strain=8.0)
    short = exact(MooneyRivlin(1.87e5, 1.22e5), 2.0, 6)
    assert dict(fit(short, law=["linear", "ogden"]).left_out).keys() == {"ogden, 2 terms", "ogden, 3 terms"}
    with pytest.raises(UsageError, match="7 are needed"):
        fit(exact(MooneyRivlin(1.87e5, 1.22e5), 2.0, 4), law=["ogden"])
