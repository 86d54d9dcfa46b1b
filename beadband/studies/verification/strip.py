"""Rung ``strip``: strips released at one end against their exact waves, as they are planned."""

from __future__ import annotations

from typing import Any

from beadband.lammps import files
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_ring
from beadband.model import strip as exact
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.held import hold_whole
from beadband.runs.measurement import measured, reading_own_files
from beadband.studies.verification.check import Check

_STRIPS: dict[str, tuple[dict[str, Any], float, float]] = {
    "linear, 0.476": ({"law": "linear"}, 1e-6, 1e-4),
    "mooney-rivlin, 0.476": ({}, 1e-4, 2e-4),
    "mooney-rivlin, 1.2": ({"strain": 1.2}, 1e-4, 2e-4),
    "gent, 1.2": ({"law": "gent", "mu_pa": 3.5e5, "jm": 9.0, "strain": 1.2}, 5e-4, 1e-2),
    "ogden, 0.8": ({"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,), "strain": 0.8}, 3e-4, 2e-4),
    "mooney-rivlin softened, 0.476": ({"softening_r": 2.0, "softening_beta": 0.3}, 5e-4, 2e-4),
}
"""Scenes, and the bounds of recoil and front."""
_MOMENTUM = 1e-12


def strip() -> list[Check]:
    """Recoil speed and front of a sharp front, shocks, a fan and both together; momentum against impulse.

    Exact for every law (:func:`beadband.model.wedge.strip_limit`): the wave along the lower convex envelope of the
    stress, with V the integral of its speed over the stretch. The front is the middle of its foremost part.
    """
    checks = []
    for name, (values, speed_bound, front_bound) in _STRIPS.items():
        plan = plan_of(scene_of({"shape": "strip", **values}))
        with files.scratch() as folder:
            write_ring(folder, plan, hold_whole(plan))
            run_script(folder, files.SCRIPT)
            with reading_own_files():
                found = measured(plan, folder)
        beside = found.strip
        assert beside is not None
        assert beside.front is not None
        speed, front = found.fitted_speed_m_s.value, beside.front.speed_m_s.value
        momentum, impulse = float(beside.momentum_n_s[-1]), float(beside.impulse_n_s[-1])
        checks += [
            Check("strip", f"{name}: V (m/s)", speed, plan.string.rear_speed_m_s, speed_bound),
            Check("strip", f"{name}: front speed (m/s)", front, exact.front_speed_m_s(plan.scene), front_bound),
            Check("strip", f"{name}: impulse of the held end (N s)", impulse, momentum, _MOMENTUM),
        ]
    return checks
