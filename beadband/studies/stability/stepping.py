"""Failures of time stepping: beyond the limit, resonance of rRESPA, drift over very many steps, single precision."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.analysis.curvature import curvatures
from beadband.lammps.divergence import DivergenceError
from beadband.lammps.scripts import GUARD_STEPS
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import hold
from beadband.statics.ring import WRAPPED
from beadband.studies.stability import frozen, limits, trials
from beadband.studies.stability import ring_trials as rings
from beadband.studies.stability.catalogue_entry import Curve, Entry, Picture, finding
from beadband.studies.verification.specimen import strand_of
from beadband.studies.verification.statics import circle


def step_limit(quick: bool) -> Entry:
    """A release at 0.9, 1.0 and 1.1 of its measured limit."""
    values = {"beads": 120} if quick else {"beads": 240}
    found = rings.release_limit(values)
    plan = plan_of(scene_of(dict(values)))
    ring = hold(plan)
    curves, kept = [], {}
    diverged: dict[float, DivergenceError | None] = {}
    specimen, options = rings.specimen_of(plan, ring), rings.options_of(plan)
    for share in (0.9, 1.0, 1.1):
        step = share * found.measured_s
        steps = int(0.97 * plan.front_arrival_s / step)
        course, done, diverged[share] = trials.run_to_divergence(
            specimen, step, steps, 60, options, found.measured_s, shorter=0.95
        )
        kept[share] = done / steps
        energy = course.total_j / course.total_j[0]
        curves.append(Curve(step * course.energy_steps * 1e3, energy, f"{share:g} of the limit"))
    steady = float(curves[0].y.max())
    torn = next((error for error in diverged.values() if error), None)
    where = torn.found if torn else None
    return Entry(
        "step-limit",
        "A step at 0.9, 1.0 and 1.1 of the limit",
        (
            finding(
                steady < 1.001,
                f"At 0.9 of the limit the energy never rises above {steady:.4f} of the held one.",
                f"At 0.9 of the limit the energy rises to {steady:.4f} of the held one.",
            ),
            finding(
                kept[1.1] < 1.0,
                f"At 1.1 it grows without bound, and bonds leave their table after {kept[1.1]:.0%} of the run. The "
                "growth alternates from bead to bead and from step to step.",
                "At 1.1 the run still reaches its end.",
            ),
        ),
        (
            finding(
                found.measured_s >= 0.97 * found.uniform_s,
                "A plan stays well within a limit that lies below the measured one, which is "
                f"{found.measured_s / found.planned_s:.2f} times the planned.",
                "The measured limit lies below that of a uniform strand at the worst stretch, at "
                f"{found.measured_s / found.uniform_s:.2f} of it.",
            ),
            f"A larger --timestep than that limit is refused, and a run that gains energy stops within {GUARD_STEPS} "
            "steps.",
            finding(
                where is not None and where.cause.code in ("step-beyond-limit", "step-at-limit"),
                f"The message says where and why: '{where}'.",
                f"The message does not name the step as the cause: '{where}'.",
            ),
        ),
        {
            "energy_at_0.9": steady,
            "survived_share_at_1.1": kept[1.1],
            "measured_over_planned": found.measured_s / found.planned_s,
        },
        Picture(
            "energy of a release without what the dashpots took",
            "time (ms)",
            "energy / held energy",
            tuple(curves),
            ylim=(0.8, 1.3),
        ),
    )


def resonance(quick: bool) -> Entry:
    """Multiple time steps: the outer kicks meet the phase of the inner motion."""
    point = limits.Point("III", "linear", 120, 2.4, integrator="rRESPA")
    strand = point.strand
    specimen, options, across = limits.specimen_of(point)
    modes = np.sin(0.5 * math.pi * np.arange(1, 24) / 24) ** 2
    bending, tension = limits.transverse_rate2(strand, point.stretch, modes)
    axial = 4.0 * float(strand.law.tangent(point.stretch)) / (strand.density_kg_m3 * strand.spacing_m**2) * modes
    inner, outer = np.concatenate([tension, axial]), np.concatenate([bending, 0.0 * modes])
    verlet = strand.state_step_s(point.stretch)
    first, _ = limits.predicted(point)
    steps = first * np.linspace(0.6, 2.2, 400)
    growth = np.array([frozen.respa_growth(outer, inner, 0.0 * outer, float(s), 4).max() for s in steps])
    tried = first * np.linspace(0.7, 2.1, 9 if quick else 29)
    unstable = []
    for step in tried:
        moved = replace(specimen, velocities_m_s=trials.shaken(specimen, float(step), across))
        unstable.append(trials.grows(moved, float(step), 2000, options))
    exact = [
        bool(frozen.respa_growth(outer, inner, 0.0 * outer, float(s), 4).max() > limits.RESPA_GROWTH) for s in tried
    ]
    fastest = math.sqrt(float(inner.max()))
    agree = float(np.mean(np.array(exact) == np.array(unstable)))
    return Entry(
        "respa-resonance",
        "Resonance of rRESPA",
        (
            finding(
                any(unstable) and not unstable[0],
                "With bonds in an inner loop of 4 steps and angles outside, the outer step does not reach 4 times "
                f"Verlet's: from {first / verlet:.2f} of Verlet's limit on, kicks at every half period of an inner "
                f"motion (period of the fastest: {2.0 * math.pi / fastest / verlet:.2f} of Verlet's limit) drive it, "
                "in windows of the step.",
                "With bonds in an inner loop of 4 steps and angles outside, "
                + ("even the least outer step tried is unstable." if any(unstable) else "no outer step tried grows."),
            ),
        ),
        (
            "beadband uses plain velocity Verlet, which has one limit and no windows beyond it.",
            finding(
                agree >= 0.85,
                f"The exact map of rRESPA's growth agrees with {agree:.0%} of the trials.",
                f"The exact map of rRESPA's growth agrees with only {agree:.0%} of the trials.",
            ),
        ),
        {"first_unstable_over_verlet": first / verlet, "agreement": agree},
        Picture(
            "growth by rRESPA",
            "outer step / Verlet's limit",
            "factor per step",
            (
                Curve(steps / verlet, growth, "exact"),
                Curve(tried / verlet, np.where(unstable, 1.1, 1.0), "trial: 1.1 = grew", "o"),
            ),
            ylim=(0.98, 1.5),
        ),
    )


def drift(quick: bool) -> Entry:
    """Energy of a small ring without loss over very many steps."""
    strand = strand_of("III", "mooney-rivlin", 2e-3)
    count = 12
    ring = circle(strand, count)
    reach = float(np.hypot(*(ring.points_m[4] - ring.points_m[0])))
    rng = np.random.default_rng(3)
    moved = 2.0 * rng.standard_normal(ring.points_m.shape)
    moved -= moved.mean(axis=0)
    # Taken to rest as a whole, turning included: what is left is vibration.
    arm = ring.points_m - ring.points_m.mean(axis=0)
    spin = float(np.sum(arm[:, 0] * moved[:, 1] - arm[:, 1] * moved[:, 0]) / np.sum(arm**2))
    moved -= spin * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    ring = replace(ring, velocities_m_s=moved, cutoff_m=0.9 * reach, strain=1.0)
    steps = 200_000 if quick else 10_000_000
    step = 0.3 * strand.largest_step_s(0.0, 0.5, 0.5)
    # An odd interval, so that samples do not keep step with a mode.
    every = max(1, steps // 2000) | 1
    steps = every * (steps // every)
    course = trials.run(ring, step, steps, steps, trials.Options(), energy_steps=every)
    energy = course.total_j / course.total_j[0] - 1.0
    half = len(energy) // 2
    change = float(energy[half:].mean() - energy[:half].mean())
    swing = float(energy.std())
    error = 2.0 * swing * math.sqrt(2.0 / half)
    return Entry(
        "energy-drift",
        "Drift of the energy over very many steps",
        (
            finding(
                swing < 0.02,
                f"Over {steps:.3g} steps without loss the energy of a ring of {count} shaken beads swings by "
                f"{swing:.1e} of itself, as velocity Verlet's does.",
                f"Over {steps:.3g} steps without loss the energy of a ring of {count} shaken beads swings by "
                f"{swing:.1e} of itself, more than velocity Verlet's should.",
            ),
            finding(
                abs(change) < max(3.0 * error, 1e-5),
                f"It does not drift: its mean changes by {change:+.1e} from the first half to the second (twice its "
                f"standard error is {error:.0e}).",
                f"It drifts: its mean changes by {change:+.1e} from the first half to the second (twice its standard "
                f"error is {error:.0e}).",
            ),
        ),
        ("A release takes some thousand steps, and the balance of energy is checked after every run.",),
        {"steps": float(steps), "swing": swing, "change_of_mean": change},
        Picture(
            "energy of a ring of 12 beads",
            "steps",
            "energy / first - 1",
            (Curve(course.energy_steps.astype(float), energy, "", ","),),
        ),
    )


def single_precision(quick: bool) -> Entry:
    """Positions in single precision, and the curvature from them."""
    counts = (240, 520) if quick else (240, 520, 1000, 2000)
    rng = np.random.default_rng(11)
    noises, spacings, doubles = [], [], []
    for beads in counts:
        plan = plan_of(scene_of({"beads": beads}))
        ring = hold(plan)
        points = ring.positions_m
        last = int(np.flatnonzero(ring.types == WRAPPED)[0])
        # The middle of a leg is straight: what curvature is found there is rounding. Carried along as in a release.
        far = np.arange(last // 3, 2 * last // 3)
        spacing = plan.scene.strand(beads).spacing_m
        exact = curvatures(points[far - 1], points[far], points[far + 1], spacing)
        found = []
        for shift in rng.uniform(0.0, 0.05, 60):
            rounded = (points + np.array([shift, 0.0])).astype(np.float32).astype(np.float64)
            found.append(curvatures(rounded[far - 1], rounded[far], rounded[far + 1], spacing) - exact)
        noises.append(float(np.sqrt(np.mean(np.array(found) ** 2))))
        doubles.append(float(np.abs(exact).max()))
        spacings.append(spacing)
    order_found = math.log(noises[-1] / noises[0]) / math.log(spacings[-1] / spacings[0])
    return Entry(
        "single-precision",
        "Single precision in the analysis",
        (
            "Rounded to 24 bits, positions of a band of 0.2 m are off by some 1e-9 m, and a curvature divides that by "
            f"the square of the spacing: {noises[counts.index(520)]:.2g} /m of noise with 520 beads.",
            finding(
                -2.2 < order_found < -1.8,
                f"It grows as the spacing to the power {order_found:.1f}.",
                f"It changes as the spacing to the power {order_found:.1f}, not -2.",
            ),
        ),
        (
            "Positions are written with 12 to 15 digits and read in double precision, through MDAnalysis too, which "
            "would round its own copy: the columns are taken as additional data.",
            finding(
                doubles[-1] < 0.1 * noises[-1],
                f"In double precision the noise is at most {doubles[-1]:.1e} /m.",
                f"In double precision the noise is still {doubles[-1]:.1e} /m.",
            ),
        ),
        {"noise_520_beads_1_m": noises[counts.index(520)], "order": order_found},
        Picture(
            "curvature of a straight leg",
            "spacing (m)",
            "noise (1/m)",
            (
                Curve(np.array(spacings), np.array(noises), "single precision", "o-"),
                Curve(np.array(spacings), np.maximum(doubles, 1e-13), "double precision, largest", "s-"),
            ),
            logx=True,
            logy=True,
        ),
    )
