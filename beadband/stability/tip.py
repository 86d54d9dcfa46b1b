"""Failures at the rear tip: a sharp start, ringing and its aliases, beads too few, a bend too sharp."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband import follow
from beadband.plan import Plan, plan_of
from beadband.ring import Ring
from beadband.scales import bending_layer_m
from beadband.scene import scene_of
from beadband.stability import rings
from beadband.stability.entry import Array, Curve, Entry, Picture
from beadband.stability.forms import FORMS
from beadband.validity import SHARPEST, held_tip_sharpness, validity_warnings

_FRAMES = 60
"""Of the whole ring, as a plan has them."""


def sharp_corner(quick: bool) -> Entry:
    """Straight legs that meet in one bead."""
    counts = (100, 200, 400, 800, 1600)
    released = (100, 400) if quick else (100, 200, 400, 800)
    sharp, rounded = [], []
    scatter: dict[int, tuple[float, float]] = {}
    for beads in counts:
        plan = plan_of(scene_of({"beads": beads, "law": "linear"}))
        ring = follow.hold(plan)
        strand = plan.scene.strand(beads)
        turn = math.pi - 2.0 * plan.scene.half_angle_rad
        sharp.append(strand.angle_coefficient_j * float(FORMS["beadband"].energy(np.array(math.cos(turn)))))
        rounded.append(ring.bending_j - _wrapped_j(plan, ring))
        if beads in released:
            scatter[beads] = (_scatter(plan, _straightened(plan, ring)), _scatter(plan, ring))
    growth = (sharp[-1] / sharp[0]) ** (1.0 / math.log2(counts[-1] / counts[0]))
    change = rounded[-1] / rounded[-2] - 1.0
    rough, calm = scatter[released[-1]]
    return Entry(
        "sharp-corner",
        "A sharp-cornered start",
        f"Straight legs that meet in one bead store {sharp[0] * 1e3:.2g} mJ of bending in it with {counts[0]} beads "
        f"and {growth:.2f} times as much on every doubling: the corner's energy has no limit. Half of it rings at the "
        f"scale of the beads for good, and the tip curvature scatters by {rough:.0f} /m with {released[-1]} beads, "
        f"{scatter[released[0]][0]:.0f} /m with {released[0]}.",
        "The held shape is solved for, in equilibrium of the very energies that LAMMPS integrates: the energy of its "
        f"tip is {rounded[-1] * 1e3:.3g} mJ and changes by {change:+.1%} on the last doubling.",
        {
            "corner_energy_growth_on_doubling": growth,
            "held_energy_change_on_doubling": change,
            "curvature_scatter_sharp_1_m": rough,
            "curvature_scatter_held_1_m": calm,
        },
        Picture(
            "bending energy of the tip",
            "beads",
            "J",
            (
                Curve(np.array(counts), np.array(sharp), "sharp corner", "o-"),
                Curve(np.array(counts), np.array(rounded), "held in equilibrium", "s-"),
            ),
            logx=True,
            logy=True,
        ),
        1.9 < growth < 2.1 and abs(change) < 0.06 and rough > 1.5 * max(calm, scatter[released[0]][0]),
    )


def _scatter(plan: Plan, ring: Ring) -> float:
    """Standard deviation of the sampled tip curvature over 0.03 ... 0.1 of the front's arrival, 1/m."""
    course, times = rings.let_go(plan, ring, 0.5 * plan.timestep_s, 300)
    early = (times > 0.03 * plan.front_arrival_s) & (times < 0.1 * plan.front_arrival_s)
    return float(np.std(rings.tip_curvature_1_m(plan, course)[early]))


def _straightened(plan: Plan, ring: Ring) -> Ring:
    """The ring with its legs straight from the finger to a corner on the axis."""
    points = ring.positions_m.copy()
    last = int(np.flatnonzero(ring.types == 4)[0])
    touch = points[last]
    # As far as the leg's bonds reach at the held stretch, on the line at the half-angle.
    length = last * plan.scene.strand(plan.beads).spacing_m * (1.0 + plan.scene.strain)
    corner = np.array([touch[0] - math.sqrt(max(length**2 - touch[1] ** 2, 0.0)), 0.0])
    along = corner + np.linspace(0.0, 1.0, last + 1)[:, None] * (touch - corner)
    points[: last + 1] = along
    points[-last:] = along[1:][::-1] * np.array([1.0, -1.0])
    return replace(ring, positions_m=points)


def _wrapped_j(plan: Plan, ring: Ring) -> float:
    """Bending energy of the beads on the finger."""
    points = ring.positions_m
    bonds = np.roll(points, -1, axis=0) - points
    unit = bonds / np.hypot(bonds[:, 0], bonds[:, 1])[:, None]
    cosine = np.sum(unit * np.roll(unit, 1, axis=0), axis=1)
    energy = FORMS["beadband"].energy(cosine)
    return plan.scene.strand(plan.beads).angle_coefficient_j * float(energy[ring.types == 4].sum())


def ringing(quick: bool) -> Entry:
    """Bead-scale bending modes at the tip, sampled and averaged."""
    plan = plan_of(scene_of({"beads": 400}))
    ring = follow.hold(plan)
    step = plan.timestep_s
    course, times = rings.let_go(plan, ring, step, 10**9)  # every step
    kappa = rings.tip_curvature_1_m(plan, course)
    every = len(kappa) // _FRAMES
    whole = len(kappa) // every * every
    sampled, sampled_times = kappa[:whole:every], times[:whole:every]
    averaged = kappa[:whole].reshape(-1, every).mean(axis=1)
    averaged_times = times[:whole].reshape(-1, every).mean(axis=1)
    window = (sampled_times > 0.2 * plan.front_arrival_s) & (sampled_times < 0.9 * plan.front_arrival_s)
    rough, calm = (float(np.std((values - _running(values, 9))[window])) for values in (sampled, averaged))
    strand = plan.scene.strand(plan.beads)
    period = 2.0 * math.pi * strand.spacing_m**2 / (4.0 * plan.scene.bending_diffusivity_m2_s)
    shown, frames, means = (
        (x > 0.5 * times[-1]) & (x < 0.7 * times[-1]) for x in (times, sampled_times, averaged_times)
    )
    return Entry(
        "tip-ringing",
        "Ringing of the released tip, and aliases of it",
        "Letting go of a point excites bending from bead to bead, which stays at the tip with a period of about "
        f"{period / step:.1f} steps. Frames {every} steps apart show it as a slower motion that is not there: the tip "
        f"curvature scatters by {rough:.2g} /m about its running mean.",
        f"Frames hold averages over the interval before them (scatter {calm:.2g} /m), V is the slope of the tip's "
        "path, and curvatures are compared as means over a window.",
        {"scatter_sampled_1_m": rough, "scatter_averaged_1_m": calm, "mode_period_steps": period / step},
        Picture(
            "curvature of the tip",
            "time (ms)",
            "1/m",
            (
                Curve(times[shown] * 1e3, kappa[shown], "every step"),
                Curve(sampled_times[frames] * 1e3, sampled[frames], "sampled frames", "o-"),
                Curve(averaged_times[means] * 1e3, averaged[means], "averaged frames", "s-"),
            ),
        ),
        rough > 1.5 * calm,
    )


def _running(values: Array, width: int) -> Array:
    """Running mean, with shorter spans at the ends."""
    kernel = np.ones(width)
    return np.asarray(np.convolve(values, kernel, "same") / np.convolve(np.ones_like(values), kernel, "same"))


def few_beads(quick: bool) -> Entry:
    """Beads farther apart than the held tip's bend is long."""
    from beadband.analysis.tip import hann_mean

    counts = (60, 120, 240, 520) if quick else (60, 120, 240, 400, 520, 800, 1200)
    kappas, speeds, spacings = [], [], []
    for beads in counts:
        plan = plan_of(scene_of({"beads": beads, "law": "linear"}))
        found = follow.follow_rear(plan)
        later = found.rear.times_s > 0.0
        arrival = plan.front_arrival_s
        kappas.append(
            hann_mean(found.rear.times_s[later], found.rear.tip_curvature_1_m[later], 0.1 * arrival, 0.03 * arrival)
        )
        speeds.append(found.speed_m_s.value)
        spacings.append(plan.scene.strand(beads).spacing_m / bending_layer_m(plan.scene))
    errors = np.abs(np.array(kappas) / kappas[-1] - 1.0)[:-1]
    coarse = plan_of(scene_of({"beads": counts[0]}))
    return Entry(
        "few-beads",
        "Fewer beads than the bending layer needs",
        f"The held tip bends over {bending_layer_m(coarse.scene) * 1e3:.2g} mm; with {counts[0]} beads the spacing is "
        f"{spacings[0]:.1f} of that and the tip curvature at 0.1 t_f is off by {errors[0]:.0%}, with {counts[-2]} "
        f"beads ({spacings[-2]:.2g}) by {errors[-1]:.1%}. V forgives it: {abs(speeds[0] / speeds[-1] - 1.0):.1%}.",
        "A plan for the curvature puts beads closer than 0.6 of the layer; where the user insists on fewer, no "
        "curvature is reported beyond 1.5 of it, with the reason.",
        {
            "curvature_error_fewest": float(errors[0]),
            "curvature_error_last": float(errors[-1]),
            "spacing_over_layer_fewest": spacings[0],
            "speed_error_fewest": speeds[0] / speeds[-1] - 1.0,
        },
        Picture(
            "error of the tip curvature at 0.1 t_f",
            "spacing / bending layer",
            "relative error",
            (Curve(np.array(spacings[:-1]), errors, "linear law", "o-"),),
            logx=True,
            logy=True,
        ),
        errors[0] > 0.1
        and errors[-1] < 0.03
        and coarse.unresolved_curvature
        and any("resolved" in w for w in coarse.warnings),
    )


def sharp_bend(quick: bool) -> Entry:
    """A curvature that beam theory does not bear."""
    thicknesses = np.array([0.5e-3, 1e-3, 2e-3, 4e-3])
    strains = (0.05, 0.2, 0.476, 1.0)
    predicted, measured, told = [], [], []
    for strain in strains:
        scene = scene_of({"strain": strain, "law": "linear"})
        plan = plan_of(replace(scene, beads=1000))
        ring = follow.hold(plan)
        points = ring.positions_m
        first, second = points[0] - points[-1], points[1] - points[0]
        turn = abs(math.atan2(first[0] * second[1] - first[1] * second[0], float(first @ second)))
        measured.append(0.5 * scene.band.thickness_m * turn / plan.scene.strand(1000).spacing_m)
        predicted.append(held_tip_sharpness(scene))
        told.append(any("curvature x half thickness" in text for text in validity_warnings(scene)))
    same = [held_tip_sharpness(scene_of({"thickness_m": float(h)})) for h in thicknesses]
    apart = float(np.abs(np.array(measured) / predicted - 1.0).max())
    return Entry(
        "sharp-bend",
        "A curvature too sharp for beam theory",
        f"A band held at a point bends there until (curvature x half thickness) is {measured[2]:.2g} at a strain of "
        f"{strains[2]} ({measured[0]:.2g} at {strains[0]}), where plane sections are not plane and the inner side "
        "would be turned inside out beyond 1. The number does not depend on the thickness (spread "
        f"{max(same) / min(same) - 1.0:.0e}): a real thumb has a radius.",
        f"The number is predicted from the elastica (to {apart:.0%} of the solved shape) before a run, and a scene "
        f"above {SHARPEST} carries a warning; curvatures are fitted only once the held shape is forgotten.",
        {"sharpness_at_0.476": measured[2], "prediction_error": apart},
        Picture(
            "sharpness of the held tip",
            "strain",
            "curvature x half thickness",
            (
                Curve(np.array(strains), np.array(measured), "solved shape", "o"),
                Curve(np.array(strains), np.array(predicted), "elastica"),
            ),
            levels=((SHARPEST, "warned about from here"),),
        ),
        apart < 0.25 and all(flag == (value > SHARPEST) for flag, value in zip(told, predicted, strict=True)),
    )
