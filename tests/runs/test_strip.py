"""A strip released at one end: exact waves, momentum, energy, loss, its folder, and what it refuses."""

from __future__ import annotations

import json
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import erf

import beadband
from beadband.analysis.convergence import observed_order
from beadband.cli import main
from beadband.errors import UsageError
from beadband.model.scene import scene_of
from beadband.model.scenefile import read_scene
from beadband.model.strip import profile
from beadband.planning.plan import plan_of
from beadband.runs import folder as files
from beadband.runs.rear_run import follow_rear
from beadband.runs.strip_results import StripRun
from beadband.statics.strip import stretched_strip

LAWS: dict[str, dict[str, Any]] = {
    "sharp front": {"law": "linear"},
    "shock": {},
    "fan": {"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,), "strain": 0.8},
    "shock and fan": {"law": "gent", "mu_pa": 3.5e5, "jm": 9.0, "strain": 1.2},
    "shock and fan, softened": {"softening_r": 2.0, "softening_beta": 0.3},
}


@cache
def released(kind: str) -> StripRun:
    """The planned release of a law."""
    found = beadband.run(scene_of({"shape": "strip", **LAWS[kind]}))
    assert isinstance(found, StripRun)
    return found


@pytest.mark.parametrize("kind", LAWS)
def test_recoil_and_front_are_those_of_the_exact_wave(kind: str) -> None:
    """V within 0.1 % and within its bar; speed and arrival of the front within theirs."""
    run = released(kind)
    assert kind.startswith(run.plan.string.wave.kind)
    assert run.speed.value == pytest.approx(run.plan.string.rear_speed_m_s, rel=1e-3)
    assert run.front_speed is not None
    assert run.arrival is not None
    for found, exact in (
        (run.speed, run.plan.string.rear_speed_m_s),
        (run.front_speed, run.exact_front_speed_m_s),
        (run.arrival, run.exact_arrival_s),
    ):
        assert abs(found.value - exact) <= found.error
        assert found.error < 0.03 * exact
    assert run.within_tolerance
    assert not run.notices


@pytest.mark.parametrize("kind", LAWS)
def test_momentum_is_the_impulse_of_the_held_end(kind: str) -> None:
    """To rounding, at every line; the pull is the held tension until the front is near, so both grow as T t."""
    run = released(kind)
    found = run.strip
    assert found.impulse_n_s == pytest.approx(found.momentum_n_s, abs=1e-12 * run.momentum_n_s)
    early = found.times_s < 0.8 * run.plan.front_arrival_s
    assert found.momentum_n_s[early] == pytest.approx(run.held.tension_n * found.times_s[early], rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("kind", LAWS)
def test_energy_is_balanced_and_goes_where_the_exact_wave_says(kind: str) -> None:
    """Behind the wave there is motion alone; what is lost exceeds the shocks' loss by what the beads need."""
    run = released(kind)
    assert run.energy.error < min(4e-3, run.checks["energy_balance"].limit)
    wave = run.plan.string.wave
    share = sum(part.loss_j_m3 * part.front_speed_m_s for part in wave.parts) / wave.front_speed_m_s
    volume = run.scene.band.area_m2 * run.scene.wedge.reference_leg_m
    lost = share * volume / run.energy.stored_j
    assert -0.002 < run.energy.dissipated_j[-1] / run.energy.stored_j - lost < 0.04


def test_profiles_are_the_exact_ones_but_for_the_corners_of_the_fan() -> None:
    """The stretch over distance/time, at three times."""
    run = released("fan")
    frames, spacing = run.frames, run.plan.strand.spacing_m
    speeds, stretches = profile(run.scene)
    places = spacing * (np.arange(run.plan.beads) + 0.5)
    for share in (0.4, 0.6, 0.8):
        frame = int(np.argmin(np.abs(frames.times_s - share * run.plan.front_arrival_s)))
        exact = np.interp(places / frames.times_s[frame], speeds[::-1], stretches[::-1])
        off = np.abs(frames.stretch[frame] - exact) / run.scene.strain
        assert np.quantile(off, 0.9) < 0.02
        assert off.max() < 0.1


def test_recoil_converges_with_the_second_order_behind_a_shock() -> None:
    beads = np.array([200.0, 100.0, 50.0])
    plans = [plan_of(scene_of({"shape": "strip", "beads": int(one)})) for one in beads]
    speeds = np.array([follow_rear(plan).fitted_speed_m_s.value for plan in plans])
    order = observed_order(1.0 / beads, speeds)
    assert order is not None
    assert 1.6 < order < 2.4


def test_loss_of_the_material_delays_the_end_as_kelvin_and_voigt_have_it() -> None:
    """Linear law: the end of a half-infinite strip has the speed V erf(sqrt(t/tau)), exactly."""
    loss = 1e-3
    run = beadband.run(scene_of({"shape": "strip", "law": "linear", "loss_time_s": loss, "beads": 120}))
    times = run.rear.times_s
    chosen = (times > 0.2 * loss) & (times < 0.35 * run.plan.front_arrival_s)
    exact = run.plan.string.rear_speed_m_s * erf(np.sqrt(times[chosen] / loss))
    assert chosen.sum() > 20
    assert run.rear.tip_speed_m_s[chosen] == pytest.approx(exact, rel=3e-3)
    assert "viscous-front" in [one.code for one in run.plan.warnings]


def test_small_strains_recoil_at_c_times_strain() -> None:
    """V -> c0 strain for every law, c0 = sqrt(E0/rho)."""
    for kind, values in LAWS.items():
        if "softened" in kind:  # its slope at the held stretch is not that at rest, however small the strain
            continue
        scene = scene_of({"shape": "strip", **values, "strain": 1e-4})
        slow = np.sqrt(float(scene.material.tangent(1.0)) / scene.band.density_kg_m3)
        assert scene.string.rear_speed_m_s == pytest.approx(slow * 1e-4, rel=1e-3)


def test_the_formula_of_a_strip_is_exact_for_one_and_for_many() -> None:
    strains = np.linspace(0.1, 1.4, 7)
    for values in ({"law": "linear"}, {"law": "gent", "mu_pa": 3.5e5, "jm": 9.0}, {"law": "yeoh", "c1_pa": 2e5,
                   "c2_pa": -8e3, "c3_pa": 900.0}):  # fmt: skip
        found = beadband.ask(shape="strip", strain=strains, tolerance=1e-6, **values)
        exact = [
            scene_of({"shape": "strip", "strain": one, **values}).string.rear_speed_m_s for one in strains.tolist()
        ]
        assert found.value == pytest.approx(exact, rel=1e-9)
        assert set(np.asarray(found.model).tolist()) == {"formula"}
    constants = np.array([1.5e5, 1.8e5, 2.2e5])
    many = beadband.ask(shape="strip", strain=0.6, c10=constants, tolerance=1e-6)
    each = [scene_of({"shape": "strip", "strain": 0.6, "c10_pa": c}).string.rear_speed_m_s for c in constants.tolist()]
    assert many.value == pytest.approx(each, rel=1e-9)
    one = beadband.ask(shape="strip", law="linear", strain="0.4 +/- 0.01")
    assert one.value == pytest.approx(0.4 * scene_of({}).band.bar_speed_m_s, rel=1e-9)
    assert one.input_error == pytest.approx(0.025 * one.value, rel=1e-3)
    back = beadband.find("strain", speed=float(one.value), shape="strip", law="linear")
    assert back.value == pytest.approx(0.4, rel=1e-6)


def test_errors_of_inputs_need_no_run_but_where_the_material_has_a_loss() -> None:
    """V ~ strain sqrt(E/density) for the linear law: the derivatives are 1, 1/2 and -1/2, by formula and by runs."""
    given = {"shape": "strip", "law": "linear", "beads": 60, "strain": "0.4 +/- 2%", "modulus_pa": "1.1e6 +/- 3%"}
    for own, most in (({}, 0), ({"loss_time_s": 3e-5}, 8)):
        run = beadband.run(scene_of({**given, **own, "density_kg_m3": "1300 +/- 2%"}))
        assert run.inputs is not None
        assert run.inputs.legs <= most
        found = dict(zip(run.inputs.inputs.names, run.inputs.sensitivities.tolist(), strict=True))
        expected = {"strain": 1.0, "modulus_pa": 0.5, "density_kg_m3": -0.5}
        assert found == pytest.approx(expected, abs=0.02 if own else 1e-3)


def test_a_permanent_set_ends_the_unloading_above_rest(tmp_path: Path) -> None:
    """An unloading curve that reaches zero at a stretch of 1.1: there the wave ends, and the released end stays so."""
    stretch = np.linspace(1.0, 2.0, 21)
    up = "".join(f"{s!r},{4e5 * (s - 1.0)!r}\n" for s in stretch.tolist())
    back = "".join(f"{s!r},{4e5 * (s - 1.1) / 0.9!r}\n" for s in np.linspace(1.1, 2.0, 19).tolist())
    for name, text in (("up", up), ("back", back)):
        (tmp_path / f"{name}.csv").write_text(f"stretch,nominal_stress_pa\n{text}")
    given = {"file": str(tmp_path / "up.csv"), "unloading": str(tmp_path / "back.csv"), "strain": 1.0}
    run = beadband.run(scene_of({"shape": "strip", **given}))
    assert run.plan.string.residual_strain == pytest.approx(0.1, abs=2e-3)
    assert run.speed.value == pytest.approx(run.plan.string.rear_speed_m_s, rel=1e-3)
    assert run.frames.stretch[-1, :20] == pytest.approx(1.1, abs=5e-3)


def test_the_held_strip_is_in_equilibrium() -> None:
    plan = plan_of(scene_of({"shape": "strip"}))
    held = stretched_strip(plan.strand, plan.beads, plan.scene.strain)
    assert held.net_force < 1e-11
    energy = plan.scene.material.energy(1.0 + plan.scene.strain)
    band = plan.scene.band
    assert held.stretching_j == pytest.approx(energy * band.area_m2 * band.circumference_m, rel=1e-12)


def test_a_folder_repeats_and_measures_itself(tmp_path: Path, lmp: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Plain LAMMPS on release.in gives the same files; analyze, load, the scene file, and results.json agree."""
    place = tmp_path / "strip"
    assert main(["run", "--shape", "strip", "--beads", "60", "--out", str(place)]) == 0
    own = {name: (place / name).read_bytes() for name in (files.TRAJECTORY, files.REAR, files.HELD, files.ENERGY)}
    subprocess.run([lmp, "-in", files.SCRIPT], cwd=place, check=True, capture_output=True)
    assert own == {name: (place / name).read_bytes() for name in own}
    capsys.readouterr()
    assert main(["analyze", str(place), "--json"]) == 0
    again, written = json.loads(capsys.readouterr().out), json.loads((place / files.RESULTS).read_text())
    values = beadband.load(place).as_dict()
    assert again["strip"] == written["strip"] == values["strip"]
    assert again["rebound_speed_m_s"] == written["rebound_speed_m_s"] == values["rebound_speed_m_s"]
    assert values["finger_radius_m"] is None
    assert values["held"]["finger_radius_m"] is None
    assert "half_angle_deg" not in values["scene"]
    scene = read_scene(place / files.SCENE)
    assert plan_of(scene_of(scene)).scene.as_dict() == beadband.load(place).scene.as_dict()
    (place / files.HELD).write_bytes(own[files.HELD][:-30])
    assert main(["analyze", str(place)]) == 2
    assert "held.dat is cut short" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--half-angle", "14"], "--half-angle is not used with shape strip"),
        (["--until", "launch"], "--until is not used with shape strip"),
        (["--bending-scale", "0.5"], "--bending-scale is not used with shape strip"),
        (["--bending-modulus", "rest"], "--bending-modulus is not used with shape strip"),
        (["--for", "curvature"], "a strip has no tip curvature"),
        (["--finger", "clears"], "--finger is not used with until release"),
        (["--shape", "rod"], "unknown value of --shape"),
    ],
)
def test_what_a_strip_does_not_use_is_refused(
    options: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["plan", "--shape", "strip", *options]) == 2
    said = capsys.readouterr().err
    assert named in said
    assert said.count("\n") == 1


def test_commands_that_a_strip_is_not_for_refuse_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["pareto", "--shape", "strip"]) == 2
    assert "--shape is not used by 'beadband pareto'" in capsys.readouterr().err
    with pytest.raises(UsageError, match="no answer"):
        beadband.ask(shape="strip", quantity="curvature")
    with pytest.raises(UsageError, match="does not depend on its thickness"):
        beadband.find("thickness", speed=10.0, shape="strip")


def test_too_few_frames_leave_the_front_out_and_say_so() -> None:
    values = beadband.run(shape="strip", beads=40, frames=2).as_dict()
    assert values["strip"]["front_speed_m_s"] is None
    assert "a slope needs 4" in values["strip"]["reason"]


def test_pictures_page_and_comparison_take_a_strip(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    for place, law in ((one, "linear"), (other, "mooney-rivlin")):
        assert main(["run", "--shape", "strip", "--law", law, "--beads", "40", "--out", str(place)]) == 0
    assert main(["plot", str(one)]) == 0
    assert {path.stem for path in one.glob("*.png")} == {"stretch", "speed", "front", "energy", "overview"}
    assert main(["report", str(one)]) == 0
    page = (one / "report.html").read_text()
    assert '"open":true' in page
    assert "released end recoils" in page
    assert main(["movie", str(one), "--colour", "curvature"]) == 2
    capsys.readouterr()
    assert main(["compare", str(one), str(other), "--out", str(tmp_path / "both")]) == 0
    assert "front speed" in capsys.readouterr().out
    assert not (tmp_path / "both" / "curvature.png").exists()


def test_a_sweep_takes_strips_beside_rings() -> None:
    done = beadband.sweep(shape=["ring", "strip"], law="linear", strain=[0.3, 0.6])
    assert set(done["status"]) == {"done"}
    strips = done["shape"] == "strip"
    bar = scene_of({}).band.bar_speed_m_s
    assert done["rebound_speed_m_s"][strips] == pytest.approx(bar * done["strain"][strips], rel=1e-5)
    assert done["ratio_front_horizontal"][strips] == pytest.approx(done["published_ratio"][strips], rel=1e-9)
