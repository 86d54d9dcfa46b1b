"""Where things break: step limits against their theory, failures as described, and the guards that catch them."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beadband import blowup, follow, inputs, release, stability
from beadband import folder as files
from beadband.cli import main
from beadband.engine import run_script
from beadband.errors import RunError, UsageError
from beadband.plan import plan_of
from beadband.results import failed_checks
from beadband.scene import scene_of
from beadband.stability import frozen, limits, trials
from beadband.stability.forms import FORMS
from beadband.strand import Strand
from beadband.validity import check_validity, validity_warnings
from beadband.verification.specimen import strand_of

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
    return frozen.Chain(strand, FORMS["beadband"], False, np.ones(count), free), line


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
    chain = frozen.Chain(strand, FORMS["beadband"], False, np.ones(count), free)
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
    from beadband.stability import material

    entry = replace(stability.find("thick-band", quick=True).entries[0], held=False)
    monkeypatch.setattr(material, "thick_band", lambda quick: entry)
    assert main(["stability", "--only", "thick-band", "--out", str(tmp_path / "found")]) == 3
    assert "thick-band" in capsys.readouterr().err


def test_bisection_finds_limits_far_from_the_guess() -> None:
    for limit in (0.3, 0.99, 1.0, 4.0):
        assert trials.bisect(lambda step, limit=limit: step > limit, 1.0) == pytest.approx(limit, rel=1e-3)
    with pytest.raises(RunError, match="no unstable step"):
        trials.bisect(lambda step: False, 1.0)


# Guards.


@pytest.mark.parametrize(("share", "cause"), [(1.3, "time step beyond the limit"), (8.0, "time step beyond the limit")])
def test_blow_up_is_caught_early_and_says_where(share: float, cause: str, tmp_path: Path) -> None:
    plan = plan_of(scene_of({"beads": 200}))
    inputs.write_ring(tmp_path, replace(plan, timestep_s=share * plan.largest_timestep_s), follow.hold(plan))
    with pytest.raises(RunError, match=rf"bond of beads \d+ and \d+ has the strain .* \(step (\d+)\).*{cause}") as said:
        run_script(tmp_path, files.SCRIPT)
    step = int(str(said.value).split("(step ")[1].split(")")[0])
    assert step <= inputs.GUARD_STEPS


def test_blow_up_is_exit_1_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = Strand.largest_step_s
    monkeypatch.setattr(Strand, "largest_step_s", lambda self, *state: 2.5 * honest(self, *state))
    out = tmp_path / "run"
    assert main(["run", "--beads", "200", "--timestep", "3e-5", "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "blew up" in said.err
    assert not (out / files.RESULTS).exists()
    assert main(["run", "--beads", "200", "--out", str(out)]) == 2
    assert "did not finish" in capsys.readouterr().err


def test_causes_are_read_from_the_pattern() -> None:
    count = 40
    bonds = np.stack([np.arange(1, count), np.arange(2, count + 1)], axis=1)

    def chain(stretches: np.ndarray) -> np.ndarray:
        return np.stack([np.concatenate([[0.0], np.cumsum(stretches)]), np.zeros(count)], axis=1)

    zigzag = 1.0 + 0.3 * (-1.0) ** np.arange(count - 1) * np.exp(-0.1 * (np.arange(count - 1) - 20) ** 2)
    found = blowup.find(chain(zigzag), bonds, 1.0, 100, 0.95e-6, 1e-6)
    assert found is not None
    assert abs(found.bead - 21) <= 1
    assert found.time_s == pytest.approx(0.95e-4)
    assert "alternate in length" in found.cause
    assert "beyond" in blowup.find(chain(zigzag), bonds, 1.0, 100, 1.2e-6, 1e-6).cause  # type: ignore[union-attr]
    assert "loss" in blowup.find(chain(zigzag), bonds, 1.0, 100, 0.5e-6, 1e-6).cause  # type: ignore[union-attr]
    torn = np.ones(count - 1)
    torn[7] = 3.0
    found = blowup.find(chain(torn), bonds, 1.0, 1, 0.5e-6, 1e-6)
    assert found is not None
    assert (found.bead, found.other) == (8, 9)
    assert found.strain == pytest.approx(2.0)
    nowhere = chain(torn)
    nowhere[10:] = math.nan
    assert "no finite length" in blowup.find(nowhere, bonds, 1.0, 1, 1e-6, 1e-6).sentence()  # type: ignore[union-attr]


def test_only_one_run_gets_a_folder(tmp_path: Path) -> None:
    """Two that both found it empty: the second is told."""
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
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (kilobytes * 1024, kilobytes * 1024)),
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert not (out / files.RESULTS).exists()


def test_speed_that_is_not_converged_is_a_failed_check(tmp_path: Path) -> None:
    run = release.run(scene_of({"beads": 120, "for": "speed"}), tmp_path / "run")
    assert not failed_checks(run)
    assert run.estimate is not None
    off = replace(run, estimate=replace(run.estimate, speed_m_s=1.1 * run.measurement.speed_m_s.value))
    assert any("not converged" in sentence for sentence in failed_checks(off))


def test_validity_has_the_number_that_decides() -> None:
    assert any("curvature x half thickness) = 1.8" in text for text in validity_warnings(scene_of({})))
    with pytest.raises(UsageError, match="too thick for its finger"):
        check_validity(scene_of({"thickness_m": 0.01, "half_angle_deg": 1.0}))
    check_validity(scene_of({"thickness_m": 0.01, "half_angle_deg": 1.0, "bending_scale": 0.0}))
    for values, word in (
        ({"thickness_m": 0.01}, "slender"),
        ({"band": "IV", "strain": 1.45}, "tension peak"),
        ({"loss_time_s": 1e-3}, "viscous"),
        ({"strain": 1.4, "half_angle_deg": 24.0}, "hardly unloads"),
        ({"band": "IV"}, "plate"),
    ):
        assert any(word in text for text in validity_warnings(scene_of(values)))
        assert not any(word in text for text in validity_warnings(scene_of({})))
