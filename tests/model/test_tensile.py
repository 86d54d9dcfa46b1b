"""A tensile test as the law: what is read and refused, the curve, the way back, and the softening."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.errors import UsageError
from beadband.model.laws import Law, Softened, law_of
from beadband.model.laws.curve import Curve
from beadband.model.laws.smoothing import smoothed
from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import read_scene, scene_text
from beadband.model.tensile_test import TensileTest, read_test
from beadband.notices import Notice
from beadband.planning.launch_plan import launch_plan_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear

Stress = Callable[[Any], Any]
BAND_III = law_of("mooney-rivlin", {"c10_pa": 0.187e6, "c01_pa": 0.122e6})
GENT = law_of("gent", {"mu_pa": 0.4e6, "jm": 40.0})
YEOH = law_of("yeoh", {"c1_pa": 0.25e6, "c2_pa": -0.012e6, "c3_pa": 0.9e3})


def write(path: Path, stress: Stress, stretches: Any, header: str = "stretch,nominal_stress_pa") -> Path:
    """A CSV of a law."""
    path.write_text(f"{header}\n" + "".join(f"{float(s)!r},{float(stress(s))!r}\n" for s in stretches))
    return path


def test_of(stretch: Any, stress: Any) -> TensileTest:
    return TensileTest("made up", np.asarray(stretch), np.asarray(stress), np.ones(len(stretch)))


test_of.__test__ = False  # type: ignore[attr-defined]

ROWS = "\n".join(f"{1 + i / 10},{i / 20}" for i in range(8))
HEADER = "stretch,nominal_stress_mpa\n"
READABLE = {
    "plain": HEADER + ROWS,
    "BOM and CRLF": "\ufeff" + (HEADER + ROWS).replace("\n", "\r\n"),
    "decimal commas": "stretch;nominal_stress_mpa\n" + ROWS.replace(",", ";").replace(".", ","),
    "tabs": (HEADER + ROWS).replace(",", "\t"),
    "strain in kPa": "strain,nominal_stress_kpa\n" + "\n".join(f"{i / 10},{i * 50}" for i in range(8)),
    "comments": f"# rubber\n{HEADER}\n# more, 1,2\n{ROWS}\n\n",
    "other columns": "t,Stretch,note,nominal_stress_mpa\n"
    + "\n".join(f'{i},{1 + i / 10},"a, b",{i / 20}' for i in range(8)),
    "repeated": HEADER + ROWS + "\n1.7,0.34\n1.7,0.36",
}


@pytest.mark.parametrize("text", READABLE.values(), ids=READABLE)
def test_files_that_are_read(tmp_path: Path, text: str) -> None:
    path = tmp_path / "test.csv"
    path.write_bytes(text.encode())
    test = read_test(path)
    assert test.stretch == pytest.approx(1.0 + np.arange(8) / 10.0)
    assert test.stress_pa == pytest.approx(5e4 * np.arange(8))


BAD = {
    "no header": (ROWS, "has no header (line 1)"),
    "wrong columns": ("time,force\n" + ROWS, "has no column of stretch or strain (line 1)"),
    "no stress": ("stretch,width\n" + ROWS, "has no column of nominal stress"),
    "no unit": ("stretch,nominal_stress\n" + ROWS, "the unit of the nominal stress is missing (line 1)"),
    "two strains": ("stretch,strain,nominal_stress_pa\n1,0,0", "more than one column of the same quantity"),
    "twice": ("stretch,stretch,nominal_stress_pa\n1,1,0", "two columns of one name"),
    "not monotone": (HEADER + "1,0\n1.2,0.1\n1.5,0.3\n1.4,0.2\n1.6,0.4\n1.7,0.5", "falls at line 5"),
    "two points": (HEADER + "1,0\n1.2,0.1", "too few points"),
    "NaN": (HEADER + ROWS.replace("0.2\n", "nan\n"), "line 6 is not finite"),
    "inf": (HEADER + ROWS.replace("0.2\n", "inf\n"), "line 6 is not finite"),
    "word": (HEADER + ROWS.replace("0.2\n", "n/a\n"), "line 6 has no number"),
    "short line": (HEADER + ROWS + "\n1.9", "line 10 has no number"),
    "compression only": (HEADER + "\n".join(f"{0.5 + i / 20},{i / 20 - 0.5}" for i in range(9)), "no point in tension"),
    "decimal commas": (HEADER + ROWS.replace(",", ",").replace(".", ","), "line 2 has more columns"),
    "thousands": ("stretch;nominal_stress_pa\n1;1.234,5\n", "line 2 has no number"),
    "percent": ("strain,nominal_stress_mpa\n0,0\n10,.1\n20,.2", "the stretch of line 4 is out of range"),
    "strain as stretch": (HEADER + "0,0\n0.1,0.1\n0.2,0.2", "the stretch of line 2 is out of range"),
    "huge": (HEADER + ROWS + "\n1.9,1e300", "the stress of line 10 is not that of rubber"),
    "pushing": (HEADER + ROWS.replace(",", ",-"), "tension is not positive"),
    "falling at once": (
        HEADER + "\n".join(f"{1 + i / 10},{1 - i / 20}" for i in range(8)),
        "the stress at rest is not zero (line 2)",
    ),
    "header alone": (HEADER, "has no points"),
    "empty": ("", "is empty"),
    "comments alone": ("# nothing\n", "is empty"),
    "binary": ("\x89PNG\x00\x00\x01", "is no text"),
}


@pytest.mark.parametrize(("text", "said"), BAD.values(), ids=BAD)
def test_bad_files_get_one_clear_line(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(text.encode())
    with pytest.raises(UsageError) as caught:
        scene_of({"file": str(path)})
    sentence = str(caught.value)
    assert said in sentence
    assert "bad.csv" in sentence
    assert "\n" not in sentence
    assert caught.value.code == "tensile-test"


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(UsageError, match="can't be read"):
            scene_of({"file": str(path)})


def test_a_million_rows_are_read_and_averaged(tmp_path: Path) -> None:
    draws = np.random.default_rng(1)
    stretch = np.linspace(1.0, 2.5, 1_000_000)
    stress = BAND_III.stress(stretch) * (1.0 + 0.05 * draws.standard_normal(len(stretch)))
    path = tmp_path / "long.csv"
    lines = [f"{s:.7f},{p:.2f}" for s, p in zip(stretch.tolist(), stress.tolist(), strict=True)]
    path.write_text("stretch,nominal_stress_pa\n" + "\n".join(lines))
    start = time.process_time()
    law = scene_of({"file": str(path)}).material
    assert time.process_time() - start < 6.0
    assert len(law.values()["stretch"]) < 200
    at = np.linspace(1.05, 2.5, 100)
    assert np.max(np.abs(law.stress(at) / BAND_III.stress(at) - 1.0)) < 1e-3


@pytest.mark.parametrize("law", [BAND_III, GENT, YEOH], ids=lambda law: law.name)
@pytest.mark.parametrize("points", [15, 40])
def test_exact_tables_give_the_law(tmp_path: Path, law: Law, points: int) -> None:
    path = write(tmp_path / "law.csv", law.stress, np.linspace(1.0, 2.6, points))
    values = {"circumference_m": 0.2, "thickness_m": 1e-3, "width_m": 2e-3, "density_kg_m3": 950.0, "band": "own"}
    given = {"law": law.name, **law.values()}
    for strain in (0.3, 1.2):
        scene = scene_of({**values, "file": str(path), "strain": strain})
        exact = scene_of({**values, **given, "strain": strain})
        assert scene.string.rear_speed_m_s == pytest.approx(exact.string.rear_speed_m_s, rel=2e-4)
    at = np.linspace(1.02, 2.6, 300)
    assert np.max(np.abs(scene.material.stress(at) / law.stress(at) - 1.0)) < 1e-3
    assert scene.material.rest_modulus_pa == pytest.approx(law.rest_modulus_pa, rel=3e-3)


def test_energy_stress_and_tangent_belong_together(tmp_path: Path) -> None:
    path = write(tmp_path / "law.csv", GENT.stress, np.linspace(1.0, 2.6, 20))
    back = write(
        tmp_path / "back.csv", lambda s: GENT.stress(2.0) * ((s - 1.06) / 0.94) ** 1.5, np.linspace(2, 1.1, 20)
    )
    both = scene_of({"file": str(path), "unloading": str(back), "strain": 1.0}).material
    laws = [scene_of({"file": str(path)}).material, both, Softened(GENT, 1.9, 2.0, 5e4, 0.1)]
    stretch = np.linspace(0.5, 2.9, 73) + 1e-4 + 0.0j
    for law in laws:
        scale = law.rest_modulus_pa
        stress, tangent = (np.imag(f(stretch + 1e-30j)) / 1e-30 for f in (law.energy, law.stress))
        assert np.allclose(stress, law.stress(stretch).real, rtol=1e-11, atol=1e-12 * scale)
        assert np.allclose(tangent, law.tangent(stretch).real, rtol=1e-11, atol=1e-12 * scale)
    for law in (laws[0], laws[2]):
        assert law.energy(1.0) == 0.0
        assert law.stress(1.0) == 0.0


def test_a_curve_passes_its_points_without_wiggles() -> None:
    x = np.array([0.0, 1.0, 2.0, 3.0, 3.1, 5.0, 6.0])
    y = np.array([0.0, 0.1, 0.2, 2.0, 2.05, 2.1, 2.1])
    curve, fine = Curve(x, y), np.linspace(-1.0, 6.0, 20001)
    assert curve.value(x) == pytest.approx(y, abs=1e-14)
    assert np.diff(curve.value(fine)).min() >= 0.0
    step = np.diff(curve.derivative(fine))
    assert np.abs(step).max() < 0.05  # the slope is continuous
    cubic = Curve(x, x**3 + x)
    assert cubic.value(2.7) == pytest.approx(2.7**3 + 2.7, rel=1e-12)


@pytest.mark.parametrize("constant", [False, True], ids=["relative", "absolute"])
def test_noise_is_smoothed_away(constant: bool) -> None:
    draws = np.random.default_rng(3)
    errors, scatters = [], []
    stretch, at = np.linspace(1.0, 2.5, 200), np.linspace(1.1, 2.45, 200)
    size = GENT.stress(2.5) if constant else GENT.stress(stretch)
    for _ in range(10):
        found = smoothed(test_of(stretch, GENT.stress(stretch) + 0.01 * size * draws.standard_normal(200)))
        curve = Curve(found.stretch, found.stress_pa)
        scale = GENT.stress(2.5) if constant else GENT.stress(at)
        errors.append(np.max(np.abs(curve.value(at) - GENT.stress(at)) / scale))
        scatters.append(found.scatter_pa / np.sqrt(np.mean((0.01 * size) ** 2)))
        assert np.all(np.diff(curve.value(np.linspace(0.8, 2.5, 2000))) > 0.0)
        assert found.freedom < 15.0
    assert np.median(errors) < 5e-3
    assert np.mean(scatters) == pytest.approx(1.0, abs=0.1)


def test_much_noise_on_few_points_still_rises() -> None:
    draws = np.random.default_rng(5)
    for _ in range(20):
        stretch = np.linspace(1.0, 2.0, 12)
        noisy = BAND_III.stress(stretch) * (1.0 + 0.15 * draws.standard_normal(12))
        assert np.all(np.diff(smoothed(test_of(stretch, noisy)).stress_pa) > 0.0)


def test_a_peak_of_the_tension_stays_and_is_refused_beyond(tmp_path: Path) -> None:
    four = scene_of({"band": "IV", "strain": 1.0}).material
    path = write(tmp_path / "iv.csv", four.stress, np.linspace(1.0, 3.2, 40))
    law = scene_of({"file": str(path), "strain": 0.5}).material
    assert law.peak_stretch() == pytest.approx(four.peak_stretch(), rel=0.01)
    with pytest.raises(UsageError, match="tension peaks"):
        scene_of({"file": str(path), "strain": 1.6})


def test_a_table_shorter_than_the_strain_is_refused_with_its_end(tmp_path: Path) -> None:
    path = write(tmp_path / "short.csv", BAND_III.stress, np.linspace(1.0, 1.4, 10))
    assert scene_of({"file": str(path), "strain": 0.4}).material.name == "tensile"
    with pytest.raises(UsageError, match=r"tensile test ends at a stretch of 1\.4: given strain 0\.476"):
        scene_of({"file": str(path)})


def test_a_band_of_a_tensile_test_is_called_by_its_law_alone(tmp_path: Path) -> None:
    """Not by the dozens of points of its curve."""
    csv = write(tmp_path / "test.csv", BAND_III.stress, np.linspace(1.0, 2.0, 20))
    assert scene_of({"law": "tensile", "file": str(csv)}).label == "III, tensile"


def test_beads_move_like_those_of_the_law(tmp_path: Path) -> None:
    path = write(tmp_path / "iii.csv", BAND_III.stress, np.linspace(1.0, 2.0, 30))

    def speed(**values: Any) -> float:
        return follow_rear(plan_of(scene_of({"beads": 300, **values}), "leg")).fitted_speed_m_s.value

    assert speed(file=str(path)) == pytest.approx(speed(), rel=3e-4)
    thin = plan_of(scene_of({"file": str(path), "bending_scale": 1e-4, "beads": 600}), "leg")
    assert follow_rear(thin).fitted_speed_m_s.value == pytest.approx(thin.string.rear_speed_m_s, rel=3e-3)


def codes(notices: tuple[Notice, ...]) -> set[str]:
    return {one.code for one in notices}


def test_what_lies_outside_the_data_is_said(tmp_path: Path) -> None:
    path = write(tmp_path / "late.csv", BAND_III.stress, np.linspace(1.2, 2.0, 30))
    plan = plan_of(scene_of({"file": str(path)}))
    assert "tensile-origin" in codes(plan.warnings)
    assert "tensile-curve" in codes(plan.reasons)
    launch = launch_plan_of(scene_of({"file": str(path), "until": "launch"}))
    found = next(one for one in launch.warnings if one.code == "tensile-compression")
    assert found.values["value"] < found.values["limit"] == 1.0
    both = write(tmp_path / "both.csv", BAND_III.stress, np.linspace(0.4, 2.0, 40))
    launch = launch_plan_of(scene_of({"file": str(both), "until": "launch"}))
    assert "tensile-compression" not in codes(launch.warnings)
    at = np.linspace(0.45, 1.9, 50)
    assert np.allclose(launch.scene.material.stress(at), BAND_III.stress(at), rtol=5e-3, atol=100.0)


def same(one: Scene, other: Scene) -> bool:
    return one.material == other.material and one.string == other.string


def test_a_scene_file_finds_its_test_and_the_complete_scene_needs_none(tmp_path: Path) -> None:
    path = write(tmp_path / "latex.csv", BAND_III.stress, np.linspace(1.0, 2.0, 30))
    back = write(tmp_path / "back.csv", lambda s: BAND_III.stress(1.476) * ((s - 1) / 0.476) ** 1.3,
                 np.linspace(1.476, 1.02, 20))  # fmt: skip
    (tmp_path / "scene.toml").write_text('[law]\nname = "tensile"\nfile = "latex.csv"\nunloading = "back.csv"\n')
    scene = scene_of(read_scene(tmp_path / "scene.toml"))
    sizes = "circumference_m = 0.2\nthickness_m = 1e-3\nwidth_m = 2e-3\ndensity_kg_m3 = 950\n"
    (tmp_path / "bands.toml").write_text(f'[loop]\n{sizes}law = {{ name = "tensile", file = "latex.csv" }}\n')
    assert scene_of({"band_file": str(tmp_path / "bands.toml"), "band": "loop"}).law == "tensile"
    (tmp_path / "full.toml").write_text(scene_text(scene))
    path.unlink()
    back.unlink()
    assert same(scene_of(read_scene(tmp_path / "full.toml")), scene)
    other = write(tmp_path / "other.csv", GENT.stress, np.linspace(1.0, 2.0, 30))
    changed = scene_of(read_scene(tmp_path / "full.toml") | {"file": str(other)})
    assert changed.material.lost_density_pa(1.476) == 0.0
    assert not same(changed, scene)


def test_softer_unloading_lowers_the_speed_and_loses_energy(tmp_path: Path) -> None:
    path = write(tmp_path / "up.csv", BAND_III.stress, np.linspace(1.0, 1.476, 30))
    primary = scene_of({"file": str(path)})

    def down(s: float) -> float:
        return float(BAND_III.stress(1.476)) * ((s - 1.04) / 0.436) ** 1.2

    back = write(tmp_path / "down.csv", down, np.linspace(1.476, 1.04, 40))
    scene = scene_of({"file": str(path), "unloading": str(back)})
    assert scene.string.rear_speed_m_s < 0.97 * primary.string.rear_speed_m_s
    assert scene.material.stress(1.476) == pytest.approx(primary.material.stress(1.476), rel=1e-9)
    kept = float(BAND_III.stress(1.476)) * 0.436 / 2.2
    assert scene.material.lost_density_pa(1.476) == pytest.approx(float(BAND_III.energy(1.476)) - kept, rel=2e-3)
    assert scene.material.energy(1.04) == pytest.approx(0.0, abs=1.0)  # the permanent set is the new rest
    assert "lost-in-material" in codes(plan_of(scene).reasons)
    thin = plan_of(scene_of({"file": str(path), "unloading": str(back), "bending_scale": 1e-4, "beads": 600}), "leg")
    assert follow_rear(thin).fitted_speed_m_s.value == pytest.approx(thin.string.rear_speed_m_s, rel=3e-3)


def test_unloading_curves_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    up = write(tmp_path / "up.csv", BAND_III.stress, np.linspace(1.0, 2.0, 30))

    def refused(law: Stress, start: float) -> str:
        back = write(tmp_path / "back.csv", law, np.linspace(start, 1.02, 20))
        with pytest.raises(UsageError) as caught:
            scene_of({"file": str(up), "unloading": str(back)})
        assert caught.value.code == "tensile-unloading"
        return str(caught.value)

    assert "do not meet at the held stretch: given 5.4847e+05 Pa and 4.3878e+05" in refused(
        lambda s: 0.8 * BAND_III.stress(s), 1.476
    )
    assert "does not reach the held stretch" in refused(BAND_III.stress, 1.4)
    assert "gives back more energy" in refused(lambda s: BAND_III.stress(1.476) * ((s - 1) / 0.476) ** 0.3, 1.476)


def test_ogden_roxburgh_softening() -> None:
    held, r, m = 1.476, 2.5, 1e5
    law = Softened(BAND_III, held, r, m, 0.0)
    stretch = np.linspace(1.0, held, 2001)
    assert np.all(law.stress(stretch[1:-1]) < BAND_III.stress(stretch[1:-1]))
    assert law.stress(held) == pytest.approx(BAND_III.stress(held), rel=1e-14)
    area = np.trapezoid(BAND_III.stress(stretch) - law.stress(stretch), stretch)
    assert law.lost_density_pa(held) == pytest.approx(area, rel=1e-5)
    primary = scene_of({})
    soft = scene_of({"softening_r": r, "softening_m_pa": m})
    assert soft.string.rear_speed_m_s < primary.string.rear_speed_m_s
    stiff = scene_of({"softening_r": 1e9, "softening_m_pa": m})
    assert stiff.string.rear_speed_m_s == pytest.approx(primary.string.rear_speed_m_s, rel=1e-7)
    thin = plan_of(scene_of({"softening_r": r, "softening_m_pa": m, "bending_scale": 1e-4, "beads": 600}), "leg")
    assert follow_rear(thin).fitted_speed_m_s.value == pytest.approx(thin.string.rear_speed_m_s, rel=3e-3)


def test_softening_belongs_to_the_scene(tmp_path: Path) -> None:
    soft = scene_of({"softening_r": 2.5, "softening_m_pa": 1e5, "strain": 0.6})
    (tmp_path / "scene.toml").write_text(scene_text(soft))
    again = scene_of(read_scene(tmp_path / "scene.toml"))
    assert same(again, soft)
    assert again.band.rest_modulus_pa == pytest.approx(1.854e6)
    for values in ({"softening_r": 2.0}, {"softening_m_pa": 1e5}, {"softening_r": 0.9, "softening_m_pa": 1e5}):
        with pytest.raises(UsageError):
            scene_of(values)
