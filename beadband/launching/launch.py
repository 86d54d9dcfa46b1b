"""A launch from the scene to the results: the release of the whole ring, with its finger, to the rear's arrival."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from beadband import folder as files
from beadband import inputs
from beadband.analysis.launch import LaunchMeasurement, Watch, balance_of, crossings, measure_launch, read_watch
from beadband.analysis.measurement import measure
from beadband.analysis.trajectory import Trajectory, read, read_mdanalysis
from beadband.engine import Follow, run_script
from beadband.errors import BeadbandError, RunError, explain
from beadband.follow import reading_own_files
from beadband.launching.contact import Support
from beadband.launching.plan import CORE_DEPTH, SHORTEST_STRETCH, LaunchPlan, launch_plan_of
from beadband.launching.results import Launch, LaunchEstimate, as_dict, stored_launch_estimate
from beadband.plan import Plan
from beadband.release import Clock, Progress
from beadband.results import Estimate, Run, stored_estimate, to_json
from beadband.ring import Ring
from beadband.scene import Scene, scene_of
from beadband.scenefile import read_scene, scene_text

_HALVE_FROM = 160
_NEVER = 2_000_000_000
_IDLE_FORCE = 1e-6
"""Share of the held load below which the finger carries nothing."""


def run(scene: Scene, out: str | os.PathLike[str], progress: Progress | None = None) -> Launch:
    """Launch a scene and write everything about it into the new or empty folder ``out``.

    ``results.json`` is written last: where it is missing, the run did not finish. Raises UsageError for a scene or
    folder that can't be used, RunError when LAMMPS fails or a bead breaks through the finger.
    """
    clock = Clock()
    with clock.part("plan"):
        plan = launch_plan_of(scene)
    with clock.part("relax"):
        ring, support = plan.held()
    with clock.part("write"):
        folder = files.create(out)
        files.claim(folder, scene_text(plan.scene))
        write_inputs(folder, plan, ring, support)
    expected = round(max(plan.string.rear_arrival_s, plan.string.finger_free_s) / plan.timestep_s) + plan.flight_steps
    with clock.part("integrate"):
        version = _integrate(folder, (lambda done: progress(min(done, expected), expected)) if progress else None)
    with clock.part("estimate"):
        estimates = estimate_of(plan)
    with clock.part("measure"), reading_own_files():
        done = _measured(folder, plan, ring, support, read, estimates)
    done = replace(done, run=replace(done.run, wall_s=clock.wall_s, lammps_version=version))
    with clock.part("write"):
        text = to_json(as_dict(done))
    files.write_text(folder / files.RESULTS, text, durable=True)
    return done


def analyze(folder: str | os.PathLike[str]) -> Launch:
    """Measure a launch again from the files in its folder alone, read through MDAnalysis in double precision."""
    return remeasure(folder, read_mdanalysis)


def remeasure(folder: str | os.PathLike[str], reader: Callable[[Path], Trajectory] = read) -> Launch:
    """The like of :func:`analyze` with a reader of choice; UsageError when the folder is not that of a whole launch."""
    path = files.require(folder, files.SCENE, files.REAR, files.FINGER, files.TRAJECTORY)
    plan = launch_plan_of(scene_of(read_scene(path / files.SCENE)))
    clock = Clock()
    with clock.part("relax"):
        ring, support = plan.held()
    results = path / files.RESULTS
    with clock.part("measure"):
        done = _measured(path, plan, ring, support, reader, (stored_estimate(results), stored_launch_estimate(results)))
    return replace(done, run=replace(done.run, wall_s=clock.wall_s))


def _integrate(folder: Path, follow: Follow | None = None) -> str:
    """Run the script; RunError in the project's own words when a bead breaks through the finger."""
    try:
        return run_script(folder, files.LAUNCH_SCRIPT, follow)
    except RunError as error:
        if "outside surface of region" not in str(error):
            raise
        raise RunError(
            explain(
                "a bead broke through the finger",
                f"a depth beyond {CORE_DEPTH} of the thickness",
                "beads that stay outside",
                "raise --beads or lower --timestep",
            )
        ) from error


def follow_launch(scene: Scene) -> tuple[LaunchPlan, LaunchMeasurement, Watch]:
    """Launch a scene without keeping anything but what its finger and its centre of mass do: the cheap way."""
    plan = launch_plan_of(scene)
    with files.scratch() as folder:
        write_inputs(folder, plan, *plan.held(), pictures=False)
        _integrate(folder)
        watch = read_watch(folder / files.FINGER)
    return plan, _launch_of(plan, watch), watch


def estimate_of(plan: LaunchPlan) -> tuple[Estimate | None, LaunchEstimate | None]:
    """The launch again with half the beads (or twice as many), without pictures; None where that can't be."""
    beads = plan.beads // 2 if plan.beads >= _HALVE_FROM else 2 * plan.beads
    try:
        coarse = launch_plan_of(plan.scene.with_beads(beads))
        with files.scratch() as folder:
            write_inputs(folder, coarse, *coarse.held(), pictures=False)
            _integrate(folder)
            watch = read_watch(folder / files.FINGER)
            rear = measure(ended(coarse, watch), read(folder / files.REAR))
    except BeadbandError:
        return None, None
    return Estimate.of(beads, rear), LaunchEstimate.of(beads, _launch_of(coarse, watch))


def ended(plan: LaunchPlan, watch: Watch) -> Plan:
    """The plan of the release with the steps that the launch took."""
    return replace(plan.twin, steps=int(watch.steps[-1]))


def _launch_of(plan: LaunchPlan, watch: Watch) -> LaunchMeasurement:
    band = plan.scene.band
    return measure_launch(
        watch,
        plan.timestep_s,
        band.mass_per_length_kg_m * band.circumference_m,
        plan.strand.spacing_m,
        plan.gap_margin_m,
        plan.idle_steps * plan.timestep_s,
    )


def _measured(
    folder: Path,
    plan: LaunchPlan,
    ring: Ring,
    support: Support,
    reader: Callable[[Path], Trajectory],
    estimates: tuple[Estimate | None, LaunchEstimate | None],
) -> Launch:
    watch = read_watch(folder / files.FINGER)
    twin = ended(plan, watch)
    followed = reader(folder / files.REAR)
    rear = measure(twin, followed)
    # A band that is compressed buckles, and what is unstable finds its way out of symmetry from the last digit on: the
    # check is for the time before.
    before = rear.rear.times_s <= plan.twin.front_arrival_s
    aside = np.abs(followed.positions_m[:, followed.ids == 1, 1]).max(axis=1)
    rear = replace(rear, rear=replace(rear.rear, asymmetry_m=float(aside[before].max())))
    whole = read(folder / files.TRAJECTORY)
    times = whole.times_s(plan.timestep_s)
    crossed = next((float(t) for t, frame in zip(times, whole.positions_m, strict=True) if crossings(frame)), None)
    tip = np.interp(watch.times_s(plan.timestep_s), rear.rear.times_s, rear.rear.tip_x_m)
    return Launch(
        run=Run(twin, ring, rear, balance_of(watch, plan.timestep_s), estimates[0]),
        plan=plan,
        support=support,
        watch=watch,
        found=_launch_of(plan, watch),
        clearance_m=support.centre_m - support.radius_m - tip,
        crossed_s=crossed,
        aside_m=float(aside.max()),
        estimate=estimates[1],
    )


def write_inputs(folder: Path, plan: LaunchPlan, ring: Ring, support: Support, pictures: bool = True) -> None:
    """Write what LAMMPS needs: data file, bond table and script. Without ``pictures`` only the finger is followed."""
    scene = plan.scene
    ahead = 1.5 * plan.string.centre_of_mass_speed_m_s * (plan.cap_s / 3.0 + scene.flight_s)
    files.write_text(folder / files.DATA, inputs.data_file(ring, plan.strand, ahead))
    files.write_text(folder / files.TABLE, inputs.bond_table(plan.strand, scene.strain, shortest=SHORTEST_STRETCH))
    files.write_text(folder / files.LAUNCH_SCRIPT, script(plan, ring, support, pictures))


def script(plan: LaunchPlan, ring: Ring, support: Support, pictures: bool) -> str:
    """The launch script under the variables of this plan."""
    scene, strand = plan.scene, plan.strand
    cutoff = inputs.dashpot_cutoff_m(ring)
    core = min(CORE_DEPTH * scene.band.thickness_m, 0.5 * support.radius_m)
    loss_every, lost_every = (
        inputs.sample_every(plan.frame_steps, inputs.LOSS_SAMPLES),
        inputs.sample_every(plan.rear_steps, plan.rear_steps // 4),
    )
    held_n = 2.0 * ring.tension_n * float(np.cos(scene.half_angle_rad))
    variables: dict[str, int | float] = {
        "beads": plan.beads,
        "table_points": inputs.TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        "bead_radius": 0.5 * scene.band.thickness_m,
        "dashpot": strand.dashpot_n_s_m(plan.twin.loss_time_s),
        "dashpot_cutoff": cutoff,
        "skin": 0.01 * cutoff,
        "timestep": plan.timestep_s,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
        "idle_steps": plan.idle_steps,
        "flight_steps": plan.flight_steps,
        "finger_clears": int(scene.finger == "clears"),
        "finger_x": support.centre_m,
        "finger_radius": support.radius_m,
        "half_stiffness": 0.5 * support.stiffness_n_m,
        "core_radius": support.radius_m - core,
        "core_depth": core,
        "nose": plan.nose_beads,
        "gap_margin": plan.gap_margin_m,
        "idle_force": _IDLE_FORCE * held_n,
        "frame_steps": plan.frame_steps if pictures else _NEVER,
        "frame_average": plan.frame_steps if pictures else 1,
        "loss_every": loss_every if pictures else 1,
        "loss_average": plan.frame_steps // loss_every if pictures else 1,
        "lost_every": lost_every,
        "lost_average": plan.rear_steps // lost_every,
    }
    return inputs.with_variables(files.LAUNCH_SCRIPT, variables)


def frames(folder: str | os.PathLike[str]) -> Trajectory:
    """The whole ring over time, from the files of a launch."""
    return read(files.require(folder, files.TRAJECTORY) / files.TRAJECTORY)
