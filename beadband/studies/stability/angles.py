"""Failures of angle forms, near straight and near folded."""

from __future__ import annotations

import math

import numpy as np

from beadband.model.angle_forms import AngleForm
from beadband.studies.stability import trials
from beadband.studies.stability.catalogue_entry import Array, Curve, Entry, Picture, finding
from beadband.studies.stability.trials import FORMS
from beadband.studies.verification.specimen import END, FREE, Specimen, strand_of


def _moments(form: AngleForm, turns: Array) -> Array:
    """Moment of one hinge over K at each turning angle, from the forces that LAMMPS gives; NaN where it gives none."""
    strand = strand_of("III", "linear", 1e-3)
    a = strand.spacing_m
    # Three beads for each angle, bonds at rest, far from each other: the end force times the bond is the moment.
    base = 6.0 * a * np.arange(len(turns))
    points = np.zeros((3 * len(turns), 2))
    points[0::3, 0], points[0::3, 1] = -a, base
    points[1::3, 1] = base
    points[2::3, 0], points[2::3, 1] = a * np.cos(turns), base + a * np.sin(turns)
    types = np.full(len(points), FREE)
    types[0::3] = types[2::3] = END
    first = 3 * np.arange(len(turns))
    bonds = np.concatenate([np.stack([first, first + 1], axis=1), np.stack([first + 1, first + 2], axis=1)])
    angles = np.stack([first, first + 1, first + 2], axis=1)
    piece = Specimen(strand, points, types, bonds, angles, np.zeros_like(points))
    force = trials.first_forces(piece, trials.Options(form))
    # The end bead's force across its bond, turning the hinge straight again.
    across = force[2::3, 0] * np.sin(turns) - force[2::3, 1] * np.cos(turns)
    return np.asarray(across * a / strand.angle_coefficient_j)


def _slopes(form: AngleForm, turns: Array) -> Array:
    return form.by_angle(turns)[1]


def straight(quick: bool) -> Entry:
    """Forces at turning angles that are next to nothing."""
    turns = np.logspace(-7.0, -1.0, 25)
    errors = {}
    for name, form in FORMS.items():
        moments = _moments(form, turns)
        errors[name] = np.maximum(np.abs(moments / (turns if name != "cosine" else np.sin(turns)) - 1.0), 1e-17)
    small = turns < 5e-4
    worst = {name: float(error[small].max()) for name, error in errors.items()}
    lost = f"{worst['harmonic']:.0%} and {worst['rod_table']:.0%}"
    return Entry(
        "angles-straight",
        "Angle forms near straight",
        (
            "Forms in the angle itself divide by its sine, which LAMMPS does not let fall below 0.001.",
            finding(
                worst["harmonic"] > 0.9,
                f"At smaller turning angles 'harmonic' and tables give too small a moment (off by {lost}), so that a "
                "nearly straight band has no bending stiffness.",
                f"Yet 'harmonic' and tables are off by no more than {lost} at smaller turning angles.",
            ),
        ),
        (
            "Polynomials in the cosine have no such division.",
            finding(
                worst["quartic"] < 1e-3,
                f"Beadband's u + u²/6 is right to {worst['quartic']:.0e} at these angles, as far as the rounding of "
                "the cosine allows.",
                f"Yet beadband's u + u²/6 is off by {worst['quartic']:.0e} at these angles.",
            ),
        ),
        {f"worst_error_{name}": value for name, value in worst.items()},
        Picture(
            "error of the moment near straight",
            "turning angle (rad)",
            "relative error",
            tuple(Curve(turns, error, name) for name, error in errors.items()),
            logx=True,
            logy=True,
        ),
    )


def folded(quick: bool) -> Entry:
    """Forces at turning angles near a fold, and what they ask of the step."""
    turns = np.radians(np.linspace(5.0, 175.0, 35))
    moments = {name: _moments(form, turns) for name, form in FORMS.items()}
    at = int(np.argmin(np.abs(turns - math.radians(150.0))))
    values = {name: float(moment[at]) for name, moment in moments.items()}
    exact = {name: float(np.abs(moments[name] / _slopes(form, turns) - 1.0).max()) for name, form in FORMS.items()}
    stiffest = {
        name: float(np.gradient(moment, turns)[turns < math.radians(151.0)].max()) for name, moment in moments.items()
    }
    softest = float(np.gradient(moments["cosine"], turns)[turns < math.radians(151.0)].min())
    steep = stiffest["rod_table"]
    return Entry(
        "angles-folded",
        "Angle forms near a fold",
        (
            finding(
                values["cosine"] < 0.6 and softest < 0.0,
                f"At a turning angle of 150 degrees the cosine form is soft (moment {values['cosine']:.2f} K, falling "
                f"since 90 degrees: stiffness {softest:.2f} K, so that a fold stays folded).",
                f"At a turning angle of 150 degrees the cosine form is not soft (moment {values['cosine']:.2f} K, "
                f"least stiffness {softest:.2f} K).",
            ),
            finding(
                values["rod_table"] > 20.0,
                f"There 2 tan²(ψ/2) has a moment of {values['rod_table']:.0f} K and is {steep:.0f} times as stiff as "
                f"straight: the step falls by {math.sqrt(steep):.0f}.",
                f"There 2 tan²(ψ/2) has a moment of only {values['rod_table']:.2g} K.",
            ),
        ),
        (
            "u + u²/6 equals ψ²/2 up to the fourth order.",
            finding(
                values["cosine"] < values["quartic"] < values["harmonic"] and 0.9 < stiffest["quartic"] < 1.1,
                f"It stays between the cosine and ψ²/2 ({values['quartic']:.2f} K at 150 degrees against "
                f"{values['harmonic']:.2f} K), its stiffness nowhere above {stiffest['quartic']:.2f} K: a bend never "
                "lowers the step.",
                f"Yet its moment at 150 degrees is {values['quartic']:.2f} K, and its stiffness reaches "
                f"{stiffest['quartic']:.2f} K.",
            ),
            finding(
                exact["quartic"] < 1e-6,
                "LAMMPS gives its moments as the formula has them.",
                f"LAMMPS' moments depart from its formula by {exact['quartic']:.0e}.",
            ),
        ),
        {
            **{f"moment_at_150_deg_{name}_k": value for name, value in values.items()},
            "stiffest_rod_table_k": steep,
            "stiffest_quartic_k": stiffest["quartic"],
            "formula_error_quartic": exact["quartic"],
        },
        Picture(
            "moment of a hinge",
            "turning angle (degrees)",
            "moment / K",
            tuple(Curve(np.degrees(turns), moment, name) for name, moment in moments.items()),
            ylim=(0.0, 6.0),
        ),
    )
