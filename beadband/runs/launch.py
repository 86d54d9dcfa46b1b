"""A launch from the scene to the results: the release of the whole ring, with its finger, to the rear's arrival."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from beadband.analysis.contact import LaunchMeasurement, crossings, measure_launch
from beadband.analysis.energy import launch_balance
from beadband.analysis.readers import Watch, read, read_overlaps, read_watch
from beadband.errors import BeadbandError
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_launch
from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import read_scene, scene_text
from beadband.planning.launch_plan import LaunchPlan, launch_plan_of
from beadband.planning.plan import Plan
from beadband.runs import folder as files
from beadband.runs.clock import Clock
from beadband.runs.finish import Reader, unchanged, written
from beadband.runs.hand import HandRun, hand_run
from beadband.runs.input_errors import budget_of
from beadband.runs.launch_results import Launch, LaunchEstimate, stored_launch_estimate
from beadband.runs.measurement import measure
from beadband.runs.rear_run import reading_own_files, reading_users_files
from beadband.runs.release import Progress
from beadband.runs.results import Estimate, NoEstimate, stored_estimate
from beadband.statics.finger import Support
from beadband.statics.ring import Ring

_HALVE_FROM = 160
"""Beads from which on a launch is compared with one of half as many; with fewer, with one of twice as many."""
Estimates = tuple[Estimate | NoEstimate, LaunchEstimate | NoEstimate]


def run(scene: Scene, out: str | os.PathLike[str] | None = None, progress: Progress | None = None) -> Launch:
    """Launch a scene; see :func:`beadband.runs.dispatch.run`."""
    clock = Clock()
    with clock.part("plan"):
        plan = launch_plan_of(scene)
    with clock.part("relax"):
        ring, support = plan.held()
    with clock.part("write"):
        folder, scratch = files.create_or_scratch(out)
        files.claim(folder, scene_text(plan.scene))
        write_launch(folder, plan, ring, support)
    expected = plan.expected_steps
    with clock.part("integrate"):
        at = (lambda done: progress(min(done, expected), expected)) if progress else None
        version = run_script(folder, files.LAUNCH_SCRIPT, at)
    with clock.part("estimate"):
        estimates = estimate_of(plan)
    with clock.part("measure"), reading_own_files():
        more = {"lammps_version": version, "fingerprints": files.fingerprints(folder), "scratch": scratch}
        done = _measured(folder, plan, ring, support, read, estimates, wall_s=clock.wall_s, **more)
    return written(done, clock)


def remeasure(folder: str | os.PathLike[str], reader: Reader = read) -> Launch:
    """Measure a launch again from the files in its folder; see :func:`beadband.runs.dispatch.analyze`."""
    path = files.require(folder, files.SCENE, files.REAR, files.FINGER, files.TRAJECTORY)
    stored, prints = unchanged(path)
    # A scene that does not name it is older than the contact of the band with itself.
    plan = launch_plan_of(scene_of({"self_contact": "off", **read_scene(path / files.SCENE)}))
    if plan.self_contact is not None:
        files.require(folder, files.TOUCH)
    clock = Clock()
    with clock.part("relax"):
        ring, support = plan.held()
    estimates = stored_estimate(stored), stored_launch_estimate(stored)
    with clock.part("measure"), reading_users_files():
        return _measured(path, plan, ring, support, reader, estimates, wall_s=clock.wall_s, fingerprints=prints)


def follow_launch(scene: Scene) -> tuple[LaunchPlan, LaunchMeasurement, Watch]:
    """Launch a scene and measure its finger and its centre of mass; no file is kept."""
    plan = launch_plan_of(scene)
    with files.scratch() as folder:
        watch = _watched(folder, plan, *plan.held())
    return plan, _launch_of(plan, watch), watch


def follow_hand(scene: Scene) -> tuple[LaunchPlan, LaunchMeasurement, Watch, HandRun]:
    """Launch a scene with a hand and measure both; no file is kept."""
    plan = launch_plan_of(scene)
    ring, support = plan.held()
    with files.scratch() as folder:
        watch = _watched(folder, plan, ring, support)
        hand = hand_run(folder, plan, ring, support, watch)
    if hand is None:
        raise ValueError(f"{scene!r} has no hand")
    return plan, _launch_of(plan, watch), watch, hand


def estimate_of(plan: LaunchPlan) -> Estimates:
    """The launch again with half the beads, or twice as many; the reason where that is impossible."""
    beads = plan.beads // 2 if plan.beads >= _HALVE_FROM else 2 * plan.beads
    try:
        coarse = launch_plan_of(plan.scene.with_beads(beads))
        with files.scratch() as folder, reading_own_files():
            ring, support = coarse.held()
            watch = _watched(folder, coarse, ring, support)
            hand = hand_run(folder, coarse, ring, support, watch)
            rear = measure(ended(coarse, watch), read(folder / files.REAR))
    except BeadbandError as error:
        failed = NoEstimate(error.code, str(error))
        return failed, failed
    return Estimate.of(beads, rear), LaunchEstimate.of(beads, _launch_of(coarse, watch), hand.found if hand else None)


def _watched(folder: Path, plan: LaunchPlan, ring: Ring, support: Support) -> Watch:
    """Launch a held ring in a folder, without the trajectory; the lines of finger.dat."""
    write_launch(folder, plan, ring, support, pictures=False)
    run_script(folder, files.LAUNCH_SCRIPT)
    with reading_own_files():
        return read_watch(folder / files.FINGER)


def ended(plan: LaunchPlan, watch: Watch) -> Plan:
    """The plan of the release with the steps that the launch took."""
    return replace(plan.release, steps=int(watch.steps[-1]))


def _launch_of(plan: LaunchPlan, watch: Watch) -> LaunchMeasurement:
    band, step, string = plan.scene.band, plan.timestep_s, plan.string
    mass = band.mass_per_length_kg_m * band.circumference_m
    shape = 2.0 * string.tension_n, string.turning_1_s
    return measure_launch(watch, step, mass, plan.strand.spacing_m, plan.gap_margin_m, plan.idle_steps * step, *shape)


def _measured(
    folder: Path, plan: LaunchPlan, ring: Ring, support: Support, reader: Reader, estimates: Estimates, **more: Any
) -> Launch:
    watch = read_watch(folder / files.FINGER)
    release = ended(plan, watch)
    measured = measure(release, reader(folder / files.REAR))
    whole = read(folder / files.TRAJECTORY)
    times = whole.times_s(plan.timestep_s)
    crossed_s = times[[crossings(frame) > 0 for frame in whole.positions_m]]
    overlaps = read_overlaps(folder / files.TOUCH) if plan.self_contact is not None else None
    hand = hand_run(folder, plan, ring, support, watch)
    tip = np.interp(watch.times_s(plan.timestep_s), measured.rear.times_s, measured.rear.tip_x_m)
    surface = support.centre_m - support.radius_m + (hand.path.x_m if hand else 0.0)
    energy = launch_balance(watch, plan.timestep_s, hand.energy_j if hand else None)
    return Launch(
        release, measured, estimates[0], budget_of(plan.scene, measured.fitted_speed_m_s.value), held=ring,
        energy=energy, folder=folder, launch_plan=plan, support=support, watch=watch,
        found=_launch_of(plan, watch), clearance_m=surface - tip, crossings_s=crossed_s, overlaps=overlaps,
        launch_estimate=estimates[1], hand=hand, **more,
    )  # fmt: skip
