"""Where things break: step limits against their theory, failures as described, and the guards that catch them."""

from __future__ import annotations

import json
import math
import os
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.lammps import scripts
from beadband.lammps.divergence import DivergenceError
from beadband.lammps.engine import run_script
from beadband.model.angle_forms import QUARTIC
from beadband.model.calibration import Strand
from beadband.model.scene import scene_of
from beadband.model.validity import check_validity, validity_notices
from beadband.planning.plan import plan_of
from beadband.runs import folder as files
from beadband.runs import release
from beadband.runs.rear_run import hold
from beadband.studies import stability
from beadband.studies.stability import frozen, limits, trials
from beadband.studies.stability.catalogue_entry import finding, text
from beadband.studies.verification.specimen import strand_of

POINTS = [
    limits.Point("III", "mooney-rivlin", 120, 0.7),
    limits.Point("III", "linear", 2000, 1.476),
    limits.Point("III", "linear", 2000, 1.2, "strong"),
    limits.Point("I", "mooney-rivlin", 2000, 1.0, "numerical", "bent", turning_beads=12),
    limits.Point("III", "mooney-rivlin", 240, 1.2, shape="pressed", finger=10.0),
    limits.Point("III", "linear", 120, 2.4, integrator="rRESPA"),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_measured_limit_is_the_predicted_one(point: limits.Point) -> None:
    found = limits.measure(point)
    assert found.ratio == pytest.approx(1.0, abs=3e-3)


def test_regimes_are_told_apart() -> None:
    assert [limits.predicted(point)[1] for point in POINTS] == [
        limits.AXIAL,
        limits.BENDING,
        limits.DASHPOT,
        limits.BENDING,
        limits.CONTACT,
        limits.RESONANCE,
    ]


def straight(strand: Strand, stretch: float, count: int = 80) -> tuple[frozen.Chain, np.ndarray]:
    free = np.ones(count, dtype=bool)
    free[[0, -1]] = False
    line = np.zeros((count, 2))
    line[:, 0] = strand.spacing_m * stretch * np.arange(count)
    return frozen.Chain(strand, QUARTIC, False, np.ones(count), free), line


@pytest.mark.parametrize("spacing", [2e-3, 1e-4])
@pytest.mark.parametrize("loss", [0.0, 2e-5])
@pytest.mark.parametrize("stretch", [1.0, 1.476])
def test_closed_form_of_a_straight_strand(spacing: float, loss: float, stretch: float) -> None:
    """Its shortest wave has sin^2(q/2) = cos^2(pi/2n) between held ends: 1 - 4e-4."""
    strand = strand_of("III", "mooney-rivlin", spacing)
    chain, line = straight(strand, stretch)
    exact = frozen.largest_step_s(chain, line, loss)
    assert exact == pytest.approx(strand.state_step_s(stretch, loss), rel=1e-3)
    assert exact > strand.state_step_s(stretch, loss)


def test_definiteness_is_what_decides() -> None:
    """A bent, unevenly stretched chain with dashpots, stepped by hand: quiet below the limit, growing above it."""
    strand = strand_of("III", "mooney-rivlin", 4e-4)
    count, loss = 12, 1e-5
    rng = np.random.default_rng(2)
    direction = np.cumsum(rng.uniform(-0.4, 0.4, count - 1))
    bonds = strand.spacing_m * rng.uniform(1.1, 1.4, count - 1)[:, None]
    points = np.concatenate(
        [np.zeros((1, 2)), np.cumsum(bonds * np.stack([np.cos(direction), np.sin(direction)], axis=1), axis=0)]
    )
    free = np.ones(count, dtype=bool)
    free[[0, 1, -2, -1]] = False
    chain = frozen.Chain(strand, QUARTIC, False, np.ones(count), free)
    limit = frozen.largest_step_s(chain, points, loss)

    def dense(bands: np.ndarray) -> np.ndarray:
        matrix = np.zeros((count, 2, count, 2))
        for i in range(count):
            for offset in range(-2, 3):
                if 0 <= i + offset < count:
                    matrix[i, :, i + offset, :] = bands[i, offset + 2]
        keep = np.repeat(free, 2)
        return matrix.reshape(2 * count, 2 * count)[np.ix_(keep, keep)] / strand.bead_mass_kg

    stiff, damping = dense(frozen.stiffness(chain, points)), dense(frozen.dashpots(chain, points, loss))
    np.testing.assert_allclose(stiff, stiff.T, atol=1e-6 * np.abs(stiff).max())
    for share, grows in ((0.999, False), (1.001, True)):
        dt = share * limit
        eye = np.eye(len(stiff))
        # x' = x + dt u, u' = u - dt (K x' + C u): one step of velocity Verlet with lagging dashpots.
        step = np.block([[eye, dt * eye], [-dt * stiff, eye - dt * damping - dt**2 * stiff]])
        assert (np.abs(np.linalg.eigvals(step)).max() > 1.0 + 1e-9) == grows


def test_worst_uniform_strand_bounds_every_shape() -> None:
    strand = strand_of("III", "mooney-rivlin", 4e-4)
    rng = np.random.default_rng(4)
    for loss in (0.0, 1e-5):
        for _ in range(5):
            chain, line = straight(strand, 1.0, 40)
            stretches = rng.uniform(0.9, 1.3, 39)
            line[1:, 0] = np.cumsum(strand.spacing_m * stretches)
            bound = strand.largest_step_s(loss, float(stretches.max()) - 1.0, float(stretches.min()))
            assert frozen.largest_step_s(chain, line, loss) >= bound * (1.0 - 1e-6)


def test_respa_without_an_inner_loop_is_verlet() -> None:
    rate2, none = np.array([4.0]), np.array([0.0])
    assert frozen.respa_growth(rate2, none, none, 0.999, 1)[0] == pytest.approx(1.0, abs=1e-12)
    assert frozen.respa_growth(rate2, none, none, 1.001, 1)[0] > 1.05
    loss = np.array([1.0])  # 2/(sqrt(w^2 + g^2) + g) with w = 2, g = c/2
    limit = 4.0 / (math.sqrt(1.0 + 16.0) + 1.0)
    assert frozen.respa_growth(rate2, none, loss, 0.999 * limit, 1)[0] < 1.0
    assert frozen.respa_growth(rate2, none, loss, 1.001 * limit, 1)[0] > 1.0


@pytest.mark.parametrize(
    "name",
    [
        *("angles-straight", "angles-folded", "past-peak", "beyond-table", "thick-band", "rebound"),
        *("through-finger", "sharp-bend", "single-precision", "finger-stiffness"),
    ],
)
def test_failures_are_as_described(name: str) -> None:
    found = stability.find(name, quick=True)
    assert not found.failed
    (entry,) = found.entries
    assert entry.name == name
    json.dumps(stability.as_dict(found), allow_nan=False)


def test_command_writes_its_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "found"
    assert main(["stability", "--only", "angles-folded", "--json", "--out", str(out)]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["catalogue"][0]["held"]
    assert values == json.loads((out / "stability.json").read_text(encoding="utf-8"))
    assert "--only angles-folded" in (out / "stability.md").read_text(encoding="utf-8")
    assert (out / "stability-angles-folded.png").read_bytes().startswith(b"\x89PNG")
    assert main(["stability", "--only", "nothing", "--out", str(tmp_path / "other")]) == 2
    assert not (tmp_path / "other").exists()


def test_what_does_not_come_out_is_exit_3(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from beadband.studies.stability import material

    entry = stability.find("thick-band", quick=True).entries[0]
    entry = replace(entry, failure=(*entry.failure, finding(1.0 > 2.0, "One is more.", "One is less.")))
    assert text(entry.failure).endswith("One is less.")
    monkeypatch.setattr(material, "thick_band", lambda quick: entry)
    assert main(["stability", "--only", "thick-band", "--out", str(tmp_path / "found")]) == 3
    assert "thick-band" in capsys.readouterr().err


def test_findings_change_with_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A form that LAMMPS gets right near straight contradicts what the catalogue says of it."""
    from beadband.studies.stability import angles

    before = stability.find("angles-straight", quick=True).entries[0]
    monkeypatch.setattr(angles, "_moments", lambda form, turns: turns)
    after = stability.find("angles-straight", quick=True).entries[0]
    assert before.reproduced
    assert not after.reproduced
    assert [one.expected for one in after.findings] == [False, True]
    assert before.findings[0].sentence != after.findings[0].sentence


def test_what_cannot_be_finished_has_its_error(monkeypatch: pytest.MonkeyPatch) -> None:
    from beadband.studies.stability import angles

    def fails(form: object, turns: object) -> None:
        raise RunError("no such style", "refused-script")

    monkeypatch.setattr(angles, "_moments", fails)
    found = stability.find("angles-straight", quick=True)
    assert found.failed == ("angles-straight",)
    values = stability.as_dict(found)
    assert values["broken"] == {"angles-straight": "no such style"}
    assert values["broken_codes"] == {"angles-straight": "refused-script"}
    # Only a divergence is growth; a script that LAMMPS refuses is a failure of the trial.
    monkeypatch.setattr(trials, "run", lambda *_: fails(None, None))
    with pytest.raises(RunError):
        trials.grows(limits.specimen_of(POINTS[0])[0], 1e-6, 10, trials.Options())


def test_bisection_finds_limits_far_from_the_guess() -> None:
    for limit in (0.3, 0.99, 1.0, 4.0):
        assert trials.bisect(lambda step, limit=limit: step > limit, 1.0) == pytest.approx(limit, rel=1e-3)
    with pytest.raises(RunError, match="no unstable step"):
        trials.bisect(lambda step: False, 1.0)


# Guards.


@pytest.mark.parametrize("share", [1.3, 8.0])
def test_divergence_is_caught_early_and_says_where(share: float, tmp_path: Path) -> None:
    plan = plan_of(scene_of({"beads": 200}))
    scripts.write_ring(tmp_path, replace(plan, timestep_s=share * plan.largest_timestep_s), hold(plan))
    with pytest.raises(DivergenceError) as failed:
        run_script(tmp_path, files.SCRIPT)
    found = failed.value.found
    assert found is not None
    assert found.cause.code == "step-beyond-limit"
    assert found.cause.values["value"] == pytest.approx(share)
    assert found.step <= scripts.GUARD_STEPS
    assert str(found) in str(failed.value)


def test_divergence_is_exit_1_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = Strand.largest_step_s
    monkeypatch.setattr(Strand, "largest_step_s", lambda self, *state: 2.5 * honest(self, *state))
    out = tmp_path / "run"
    assert main(["run", "--beads", "200", "--timestep", "3e-5", "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "likely cause" in said.err
    assert not (out / files.RESULTS).exists()
    assert main(["run", "--beads", "200", "--out", str(out)]) == 2
    assert "did not finish" in capsys.readouterr().err


def test_only_one_run_gets_a_folder(tmp_path: Path) -> None:
    """Two that both found it empty: the second is refused."""
    one, other = files.create(tmp_path / "run"), files.create(tmp_path / "run")
    files.claim(one, "strain = 0.3\n")
    with pytest.raises(UsageError, match="another run"):
        files.claim(other, "strain = 0.4\n")
    assert (one / files.SCENE).read_text(encoding="utf-8") == "strain = 0.3\n"


@pytest.mark.parametrize("kilobytes", [1, 60])
def test_full_disk_leaves_no_result(tmp_path: Path, kilobytes: int) -> None:
    """A bound on the size of any file stands for a disk that fills up, at the data file or the bond table."""
    out = tmp_path / "run"
    done = subprocess.run(
        [sys.executable, "-m", "beadband", "run", "--beads", "200", "--for", "speed", "--out", str(out)],
        capture_output=True,
        text=True,
        env={name: value for name, value in os.environ.items() if not name.startswith("COVERAGE")},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (kilobytes * 1024, kilobytes * 1024)),
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert not (out / files.RESULTS).exists()


def test_speed_that_is_not_converged_is_a_failed_check(tmp_path: Path) -> None:
    run = release.run(scene_of({"beads": 120, "for": "speed"}), tmp_path / "run")
    assert not run.failed_checks
    assert run.estimate is not None
    off = replace(run, estimate=replace(run.estimate, speed_m_s=1.1 * run.measurement.fitted_speed_m_s.value))
    assert [one.code for one in off.failed_checks] == ["not-converged"]


def test_validity_has_the_number_that_decides() -> None:
    assert any(
        one.code == "sharp-tip" and round(one.values["value"], 1) == 1.8 for one in validity_notices(scene_of({}))
    )
    with pytest.raises(UsageError, match="too thick for its finger"):
        check_validity(scene_of({"thickness_m": 0.01, "half_angle_deg": 1.0}))
    check_validity(scene_of({"thickness_m": 0.01, "half_angle_deg": 1.0, "bending_scale": 0.0}))
    for values, word in (
        ({"thickness_m": 0.01}, "not-slender"),
        ({"band": "IV", "strain": 1.45}, "soft-at-strain"),
        ({"loss_time_s": 1e-3}, "viscous-front"),
        ({"strain": 1.4, "half_angle_deg": 24.0}, "wedge-nearly-closed"),
        ({"band": "IV"}, "wide-band"),
    ):
        assert any(one.code == word for one in validity_notices(scene_of(values)))
        assert not any(one.code == word for one in validity_notices(scene_of({})))
