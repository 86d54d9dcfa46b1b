"""Whatever is asked, in whatever form: an answer, or one line that says why not."""

from __future__ import annotations

import contextlib
import io
import math
import string
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from beadband.cli import main
from beadband.errors import BeadbandError, UsageError
from beadband.lammps import divergence as blowup
from beadband.model.bands import CATALOGUE, laws_of
from beadband.model.calibration import Strand
from beadband.model.scene import KEYS, Scene, scene_of
from beadband.model.scenefile import read_scene, scene_text
from beadband.model.validity import validity_notices
from beadband.parameters import words as words_of
from beadband.planning.plan import plan_of
from beadband.runs import rear_run as follow

quick = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
slow = settings(parent=quick, max_examples=25)

anything = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=True, allow_infinity=True),
    st.text(max_size=8),
    st.lists(st.integers(), max_size=2),
)
sizes = {
    "circumference_m": st.floats(0.01, 2.0),
    "thickness_m": st.floats(1e-5, 2e-2),
    "density_kg_m3": st.floats(1.0, 1e4),
    "modulus_pa": st.floats(1e2, 1e9),
}
scenes = st.fixed_dictionaries(
    {
        "band": st.sampled_from(list(CATALOGUE)),
        "law": st.sampled_from(laws_of("III")),
        "strain": st.floats(0.005, 1.6),
        "half_angle_deg": st.floats(0.5, 60.0),
    },
    optional={
        **sizes,
        "for": st.sampled_from(words_of("for")),
        "tolerance": st.floats(1e-4, 0.4),
        "bending_scale": st.one_of(st.just(0.0), st.floats(1e-6, 100.0)),
        "bending_modulus": st.sampled_from(words_of("bending_modulus")),
        "loss_time_s": st.one_of(st.just(0.0), st.floats(1e-9, 1e-2)),
        "tip_radius_m": st.one_of(st.just(0.0), st.floats(1e-5, 2e-2)),
        "beads": st.integers(1, 3000),
        "frames": st.integers(1, 500),
    },
)


def scene_or_none(values: dict[str, Any]) -> Scene | None:
    try:
        return scene_of(values)
    except UsageError as error:
        said = str(error)
    assert "given" in said
    assert "\n" not in said
    return None


@quick
@given(st.dictionaries(st.one_of(st.sampled_from(KEYS), st.text(max_size=5)), anything, max_size=5))
def test_any_values_are_a_scene_or_refused(values: dict[str, Any]) -> None:
    scene_or_none(values)


@quick
@given(scenes)
def test_a_scene_survives_its_file(values: dict[str, Any]) -> None:
    scene = scene_or_none(values)
    assume(scene is not None)
    assert scene is not None
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "scene.toml"
        path.write_text(scene_text(scene), encoding="utf-8")
        assert scene_of(read_scene(path)) == scene


@quick
@given(scenes)
def test_a_plan_is_whole_or_refused(values: dict[str, Any]) -> None:
    scene = scene_or_none(values)
    assume(scene is not None)
    assert scene is not None
    try:
        warnings = validity_notices(scene)
        plan = plan_of(scene)
    except UsageError:
        return
    assert all(one.sentence and "nan" not in one.sentence for one in (*warnings, *plan.warnings, *plan.reasons))
    numbers = (plan.timestep_s, plan.largest_timestep_s, plan.front_arrival_s, plan.string.rear_speed_m_s)
    assert all(math.isfinite(number) and number > 0.0 for number in numbers)
    assert plan.timestep_s < plan.largest_timestep_s
    assert plan.steps * plan.timestep_s >= 0.85 * plan.front_arrival_s
    assert plan.steps % plan.frame_steps == 0
    again = plan_of(plan.scene)
    assert (again.beads, again.timestep_s, again.steps) == (plan.beads, plan.timestep_s, plan.steps)


@slow
@given(scenes, st.integers(24, 160))
def test_a_ring_is_held_or_refused(values: dict[str, Any], beads: int) -> None:
    scene = scene_or_none({**values, "beads": beads})
    assume(scene is not None)
    assert scene is not None
    try:
        ring = follow.hold(plan_of(scene))
    except BeadbandError:
        return
    assert np.isfinite(ring.positions_m).all()
    assert ring.net_force < (1e-8 if scene.peg is None else 1e-5)
    mirrored = ring.positions_m[1:][::-1] * np.array([1.0, -1.0])
    assert np.abs(mirrored - ring.positions_m[1:]).max() < 1e-12 * scene.band.circumference_m


lines = st.text(alphabet=string.printable, max_size=60)
tables = st.one_of(
    lines,
    st.builds(
        lambda key, value: f"{key} = {value}\n",
        st.sampled_from([*KEYS, "half-angle", "thickness"]),
        st.one_of(lines, st.floats().map(repr), st.integers().map(repr), st.just("[1, 2]"), st.just('"III"')),
    ),
)


@quick
@given(st.lists(tables, max_size=4).map("\n".join), st.booleans())
def test_any_file_is_a_scene_or_refused(text: str, cut: bool) -> None:
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "scene.toml"
        raw = text.encode("utf-8")
        path.write_bytes(raw[: len(raw) // 2] + b"\xff" if cut else raw)
        try:
            values = read_scene(path)
        except UsageError:
            return
        scene_or_none(values)


flags = st.sampled_from(
    [
        *(
            "--band",
            "--strain",
            "--half-angle",
            "--law",
            "--for",
            "--tolerance",
            "--beads",
            "--timestep",
            "--loss-time",
        ),
        *(
            "--frames",
            "--thickness",
            "--width",
            "--modulus",
            "--c10",
            "--bending-scale",
            "--until",
            "--scene",
            "--json",
        ),
        *("--bending-modulus", "--density", "--circumference", "--nonsense", "-x", ""),
    ]
)
words = st.one_of(
    st.floats().map(repr),
    st.integers(-5, 10**7).map(str),
    st.sampled_from(
        ["III", "IV", "linear", "speed", "table", "nan", "1e999", "0x10", "launch", "rest", "--", "é", "/"]
    ),
    st.text(alphabet=string.printable, max_size=6),
)


@quick
@given(
    st.sampled_from(["plan", "bands", "analyze", "plot", "report", "movie", "what"]),
    st.lists(st.tuples(flags, words), max_size=4),
)
def test_any_command_line_ends_in_an_answer_or_one_line(command: str, pairs: list[tuple[str, str]]) -> None:
    argv = [command, *(word for pair in pairs for word in pair)]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(argv)
        except SystemExit as stop:
            code = int(str(stop.code))
    assert code in (0, 2)
    if code:
        assert out.getvalue() == ""
        assert err.getvalue().count("\n") == 1, err.getvalue()
    assert "Traceback" not in err.getvalue()
    assert "fault of beadband" not in err.getvalue()


@quick
@given(
    st.sampled_from(list(CATALOGUE)),
    st.sampled_from(laws_of("III")),
    st.integers(24, 5000),
    st.floats(0.0, 1e-3),
    st.floats(0.01, 1.3),
    st.floats(0.35, 1.0),
)
def test_step_limits_fall_with_loss_and_with_the_range(
    band: str, law: str, beads: int, loss: float, strain: float, compression: float
) -> None:
    strand: Strand = scene_of({"band": band, "law": law, "strain": 0.1}).strand(beads)
    step = strand.largest_step_s(loss, strain, compression)
    assert 0.0 < step < math.inf
    assert strand.largest_step_s(2.0 * loss + 1e-7, strain, compression) <= step
    assert strand.largest_step_s(loss, strain, 0.9 * compression) <= step * (1.0 + 1e-9)


@quick
@given(
    st.lists(st.tuples(st.floats(), st.floats()), min_size=2, max_size=30),
    st.floats(1e-9, 1.0),
    st.floats(1e-12, 1.0),
    st.floats(1e-12, 1.0),
)
def test_a_wreck_of_any_shape_is_described(
    points: list[tuple[float, float]], spacing: float, step: float, largest: float
) -> None:
    count = len(points)
    bonds = np.stack([np.arange(1, count), np.arange(2, count + 1)], axis=1)
    with np.errstate(all="ignore"):
        found = blowup.find(np.array(points), bonds, spacing, 7, step, largest)
    assert found is not None
    assert "likely cause" in str(found)
