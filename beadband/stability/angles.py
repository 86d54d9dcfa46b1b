"""Failures of angle forms, near straight and near folded."""

from __future__ import annotations

import math

import numpy as np

from beadband.stability import trials
from beadband.stability.entry import Array, Curve, Entry, Picture
from beadband.stability.forms import FORMS, Form
from beadband.verification.specimen import END, FREE, Specimen, strand_of


def _moments(form: Form, turns: Array) -> Array:
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


def _slopes(form: Form, turns: Array) -> Array:
    return np.asarray(-form.slope(np.cos(turns)) * np.sin(turns))


def straight(quick: bool) -> Entry:
    """Forces at turning angles that are next to nothing."""
    turns = np.logspace(-7.0, -1.0, 25)
    errors = {}
    for name, form in FORMS.items():
        moments = _moments(form, turns)
        errors[name] = np.maximum(np.abs(moments / (turns if name != "cosine" else np.sin(turns)) - 1.0), 1e-17)
    small = turns < 5e-4
    worst = {name: float(error[small].max()) for name, error in errors.items()}
    return Entry(
        "angles-straight",
        "Angle forms near straight",
        "Forms in the angle itself divide by its sine, which LAMMPS does not let fall below 0.001: at smaller "
        f"turning angles 'harmonic' and tables give too small a moment (off by {worst['harmonic']:.0%} and "
        f"{worst['tangent']:.0%}), so that a nearly straight band has no bending stiffness.",
        f"Polynomials in the cosine have no such division: beadband's u + u²/6 is right to {worst['beadband']:.0e} at "
        "these angles, as far as the cosine's own rounding lets any form be.",
        {f"worst_error_{name}": value for name, value in worst.items()},
        Picture(
            "error of the moment near straight",
            "turning angle (rad)",
            "relative error",
            tuple(Curve(turns, error, name) for name, error in errors.items()),
            logx=True,
            logy=True,
        ),
        worst["harmonic"] > 0.9 and worst["beadband"] < 1e-3,
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
    return Entry(
        "angles-folded",
        "Angle forms near a fold",
        f"At a turning angle of 150 degrees the cosine form has gone soft (moment {values['cosine']:.2f} K, falling "
        f"since 90 degrees: stiffness {softest:.2f} K, so that a fold stays folded), and 2 tan²(ψ/2) has blown up "
        f"({values['tangent']:.0f} K, {stiffest['tangent']:.0f} times as stiff as straight: the step falls by "
        f"{math.sqrt(stiffest['tangent']):.0f}).",
        f"u + u²/6 follows ψ²/2 to the fourth order and stays between the two ({values['beadband']:.2f} K at 150 "
        f"degrees against {values['harmonic']:.2f} K), its stiffness nowhere above {stiffest['beadband']:.2f} K: a "
        "bend never lowers the step.",
        {
            **{f"moment_at_150_deg_{name}_k": value for name, value in values.items()},
            "stiffest_tangent_k": stiffest["tangent"],
            "stiffest_beadband_k": stiffest["beadband"],
            "formula_error_beadband": exact["beadband"],
        },
        Picture(
            "moment of a hinge",
            "turning angle (degrees)",
            "moment / K",
            tuple(Curve(np.degrees(turns), moment, name) for name, moment in moments.items()),
            ylim=(0.0, 6.0),
        ),
        values["cosine"] < 0.6
        and values["tangent"] > 20.0
        and 0.9 < stiffest["beadband"] < 1.1
        and exact["beadband"] < 1e-6,
    )
