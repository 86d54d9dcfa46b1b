"""beadband: a stretched rubber band let go, as a ring of beads in LAMMPS."""

from __future__ import annotations

from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "Band": "band",
    "CATALOGUE": "band",
    "band_of": "band",
    "BeadbandError": "errors",
    "RunError": "errors",
    "UsageError": "errors",
    "Scene": "scene",
    "scene_of": "scene",
    "Plan": "plan",
    "plan_of": "plan",
    "Ring": "ring",
    "stretched_ring": "ring",
    "Run": "results",
    "Launch": "launching.results",
    "run": "driver",
    "analyze": "driver",
    "sweep": "sweeping",
}
__all__ = ["__version__", *_PUBLIC]


def __getattr__(name: str) -> Any:
    """Import public names when they are asked for: numpy and LAMMPS stay out of ``beadband --help``."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'beadband' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"beadband.{_PUBLIC[name]}"), name)
