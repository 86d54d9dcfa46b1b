"""beadband: a stretched rubber band released, as a ring of beads in LAMMPS."""

from __future__ import annotations

import os
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "run": "api",
    "plan": "api",
    "scene": "api",
    "ask": "api",
    "find": "api",
    "sensitivity": "api",
    "design": "api",
    "fit": "model.fitting",
    "load": "runs.dispatch",
    "analyze": "runs.dispatch",
    "sweep": "studies.sweep",
    "Scene": "model.scene",
    "scene_of": "model.scene",
    "Band": "model.bands",
    "CATALOGUE": "model.bands",
    "band_of": "model.bands",
    "Law": "model.laws",
    "register": "model.laws",
    "constant": "model.laws",
    "Plan": "planning.plan",
    "plan_of": "planning.plan",
    "Ring": "statics.ring",
    "stretched_ring": "statics.ring",
    "Run": "runs.results",
    "Launch": "runs.launch_results",
    "Observable": "observables",
    "observable": "observables",
    "BeadbandError": "errors",
    "RunError": "errors",
    "UsageError": "errors",
}
__all__ = ["__version__", *_PUBLIC]

# In a clone the folders of beadband.analysis and beadband.lmp_inputs stand beside this package, not in it. With this
# line the clone's own folder works too, installed or not.
_here = os.path.dirname(os.path.abspath(__file__))
if not os.path.isdir(os.path.join(_here, "analysis")):
    __path__.append(os.path.dirname(_here))


def __dir__() -> list[str]:
    return sorted(__all__)


def __getattr__(name: str) -> Any:
    """Import public names when they are asked for: numpy and LAMMPS stay out of ``beadband --help``."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'beadband' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"beadband.{_PUBLIC[name]}"), name)
