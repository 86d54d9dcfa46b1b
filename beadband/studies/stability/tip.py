"""Failures at the rear tip: a sharp start, ringing and its aliases, beads too few, a bend too sharp."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.model.angle_forms import QUARTIC
from beadband.model.scene import scene_of
from beadband.model.validity import SHARPEST, validity_notices
from beadband.planning.error_curves import CURVATURE_SPACING
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import follow_rear, hold
from beadband.statics.ring import WRAPPED, Ring
from beadband.studies.stability import ring_trials as rings
from beadband.studies.stability.catalogue_entry import Array, Curve, Entry, Picture, carries, finding

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
        ring = hold(plan)
        strand = plan.scene.strand(beads)
        turn = math.pi - 2.0 * plan.scene.half_angle_rad
        sharp.append(strand.angle_coefficient_j * float(QUARTIC.by_angle(np.array(turn))[0]))
        rounded.append(ring.bending_j - _wrapped_j(plan, ring))
        if beads in released:
            scatter[beads] = (_scatter(plan, _straightened(plan, ring)), _scatter(plan, ring))
    growth = (sharp[-1] / sharp[0]) ** (1.0 / math.log2(counts[-1] / counts[0]))
    change = rounded[-1] / rounded[-2] - 1.0
    (first_rough, first_calm), (rough, calm) = scatter[released[0]], scatter[released[-1]]
    return Entry(
        "sharp-corner",
        "A sharp-cornered start",
        (
            f"Straight legs that meet in one bead store {sharp[0] * 1e3:.2g} mJ of bending in it with {counts[0]} "
            "beads.",
            finding(
                1.9 < growth < 2.1,
                f"With every doubling it is {growth:.2f} times as much: the corner's energy has no limit, and half of "
                "it stays in oscillations at the scale of the beads.",
                f"With every doubling it is {growth:.2f} times as much.",
            ),
            finding(
                rough > 1.5 * max(calm, first_calm),
                f"The tip curvature scatters by {rough:.0f} /m with {released[-1]} beads, {first_rough:.0f} /m with "
                f"{released[0]}, against {max(calm, first_calm):.0f} /m from equilibrium.",
                f"The tip curvature scatters by {rough:.0f} /m with {released[-1]} beads, hardly more than the "
                f"{max(calm, first_calm):.0f} /m from equilibrium.",
            ),
        ),
        (
            "The shape of the held band is solved for, in equilibrium of the energies that LAMMPS integrates.",
            finding(
                abs(change) < 0.06,
                f"The energy of its tip converges: it is {rounded[-1] * 1e3:.3g} mJ and changes by {change:+.1%} on "
                "the last doubling.",
                f"Yet the energy of its tip still changes by {change:+.1%} on the last doubling.",
            ),
        ),
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
    )


def _scatter(plan: Plan, ring: Ring) -> float:
    """Standard deviation of the sampled tip curvature over 0.03 ... 0.1 of the front's arrival, 1/m."""
    course, times = rings.release(plan, ring, 0.5 * plan.timestep_s, 300)
    early = (times > 0.03 * plan.front_arrival_s) & (times < 0.1 * plan.front_arrival_s)
    return float(np.std(rings.tip_curvature_1_m(plan, course)[early]))


def _straightened(plan: Plan, ring: Ring) -> Ring:
    """The ring with its legs straight from the finger to a corner on the axis."""
    points = ring.positions_m.copy()
    last = int(np.flatnonzero(ring.types == WRAPPED)[0])
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
    energy = QUARTIC.by_cosine(cosine)[0]
    return plan.scene.strand(plan.beads).angle_coefficient_j * float(energy[ring.types == WRAPPED].sum())


def ringing(quick: bool) -> Entry:
    """Bead-scale bending modes at the tip, sampled and averaged."""
    plan = plan_of(scene_of({"beads": 400}))
    ring = hold(plan)
    step = plan.timestep_s
    course, times = rings.release(plan, ring, step, 10**9)  # every step
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
        (
            "The release of a point excites bending from bead to bead, which stays at the tip with a period of about "
            f"{period / step:.1f} steps. Frames {every} steps apart show it as an alias, a slower motion: the tip "
            f"curvature scatters by {rough:.2g} /m about its running mean.",
        ),
        (
            finding(
                rough > 1.5 * calm,
                f"Frames hold averages over the interval before them, which lowers the scatter to {calm:.2g} /m.",
                f"Frames hold averages over the interval before them, which leave a scatter of {calm:.2g} /m.",
            ),
            "V is the slope of the tip's path, and curvatures are compared as means over a window.",
        ),
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
    )


def _running(values: Array, width: int) -> Array:
    """Running mean, with shorter spans at the ends."""
    kernel = np.ones(width)
    return np.asarray(np.convolve(values, kernel, "same") / np.convolve(np.ones_like(values), kernel, "same"))


def few_beads(quick: bool) -> Entry:
    """Beads farther apart than the held tip's bend is long."""
    from beadband.analysis.fits import hann_mean

    counts = (60, 120, 240, 520) if quick else (60, 120, 240, 400, 520, 800, 1200)
    kappas, speeds, spacings = [], [], []
    for beads in counts:
        plan = plan_of(scene_of({"beads": beads, "law": "linear"}))
        found = follow_rear(plan)
        later = found.rear.times_s > 0.0
        arrival = plan.front_arrival_s
        kappas.append(
            hann_mean(found.rear.times_s[later], found.rear.tip_curvature_1_m[later], 0.1 * arrival, 0.03 * arrival)
        )
        speeds.append(found.fitted_speed_m_s.value)
        spacings.append(plan.scene.strand(beads).spacing_m / plan.scene.scales.bending_layer_m)
    errors = np.abs(np.array(kappas) / kappas[-1] - 1.0)[:-1]
    coarse = plan_of(scene_of({"beads": counts[0]}))
    layer_mm = coarse.scene.scales.bending_layer_m * 1e3
    return Entry(
        "few-beads",
        "Fewer beads than the bending layer needs",
        (
            f"The held tip bends over {layer_mm:.2g} mm.",
            finding(
                errors[0] > 0.1,
                f"With {counts[0]} beads the spacing is {spacings[0]:.1f} of that, and the tip curvature at 0.1 t_f is "
                f"off by {errors[0]:.0%}.",
                f"With {counts[0]} beads the spacing is {spacings[0]:.1f} of that, yet the tip curvature at 0.1 t_f is "
                f"off by only {errors[0]:.1%}.",
            ),
            finding(
                errors[-1] < 0.03,
                f"With {counts[-2]} beads ({spacings[-2]:.2g} of the layer) it is right to {errors[-1]:.1%}.",
                f"With {counts[-2]} beads ({spacings[-2]:.2g} of the layer) it is still off by {errors[-1]:.1%}.",
            ),
            f"V of the fewest beads is off by {abs(speeds[0] / speeds[-1] - 1.0):.1%}.",
        ),
        (
            f"A plan for the curvature puts beads closer than {CURVATURE_SPACING:g} of the layer.",
            finding(
                coarse.unresolved_curvature and carries(coarse.warnings, "unresolved-layer"),
                f"With --beads {counts[0]} no curvature is reported, and a warning says why.",
                f"With --beads {counts[0]} the curvature is reported without a warning.",
            ),
        ),
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
    )


def sharp_bend(quick: bool) -> Entry:
    """A curvature for which beam theory does not hold."""
    thicknesses = np.array([0.5e-3, 1e-3, 2e-3, 4e-3])
    strains = (0.05, 0.2, 0.476, 1.0)
    predicted, measured, warned = [], [], []
    for strain in strains:
        scene = scene_of({"strain": strain, "law": "linear"})
        plan = plan_of(replace(scene, beads=1000))
        ring = hold(plan)
        points = ring.positions_m
        first, second = points[0] - points[-1], points[1] - points[0]
        turn = abs(math.atan2(first[0] * second[1] - first[1] * second[0], float(first @ second)))
        measured.append(0.5 * scene.band.thickness_m * turn / plan.scene.strand(1000).spacing_m)
        predicted.append(scene.scales.tip_sharpness)
        warned.append(carries(validity_notices(scene), "sharp-tip"))
    same = [scene_of({"thickness_m": float(h)}).scales.tip_sharpness for h in thicknesses]
    apart = float(np.abs(np.array(measured) / predicted - 1.0).max())
    spread = max(same) / min(same) - 1.0
    return Entry(
        "sharp-bend",
        "A curvature too sharp for beam theory",
        (
            f"A band held at a point bends there until (curvature x half thickness) is {measured[2]:.2g} at a strain "
            f"of {strains[2]} ({measured[0]:.2g} at {strains[0]}). Plane sections do not stay plane there, and beyond "
            "1 the inner side would be turned inside out.",
            finding(
                spread < 1e-6,
                f"The number does not depend on the thickness (spread {spread:.0e}).",
                f"The number depends on the thickness: its spread is {spread:.0e}.",
            ),
        ),
        (
            finding(
                apart < 0.25,
                f"The number is predicted from the elastica before a run, to {apart:.0%} of the solved shape.",
                f"The prediction from the elastica is off by {apart:.0%} of the solved shape.",
            ),
            finding(
                all(flag == (value > SHARPEST) for flag, value in zip(warned, predicted, strict=True)),
                f"Scenes above {SHARPEST} carry a warning, others none.",
                f"Not every scene above {SHARPEST} carries a warning, or one below it does.",
            ),
            "Curvatures are fitted only once the held shape no longer affects them.",
        ),
        {"sharpness_at_0.476": measured[2], "prediction_error": apart},
        Picture(
            "sharpness of the held tip",
            "strain",
            "curvature x half thickness",
            (
                Curve(np.array(strains), np.array(measured), "solved shape", "o"),
                Curve(np.array(strains), np.array(predicted), "elastica"),
            ),
            levels=((SHARPEST, "warning from here on"),),
        ),
    )
