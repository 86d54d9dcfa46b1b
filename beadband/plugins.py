"""Laws and observables from outside the package: files named in BEADBAND_PLUGINS, and installed entry points."""

from __future__ import annotations

import os
import sys
from importlib import import_module, util
from pathlib import Path

from beadband.errors import UsageError, explain

VARIABLE = "BEADBAND_PLUGINS"
"""Environment variable with the paths of Python files, or names of modules, between the system's path separators."""
GROUP = "beadband.laws"
"""Entry points whose modules are imported; what they register is their own affair."""

_loaded = False


def load_plugins() -> None:
    """Import every plug-in, once in a process; UsageError that names one which can't be imported."""
    global _loaded
    if _loaded:
        return
    _loaded = True
    for name in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        _load(name, f"{VARIABLE}={name}")
    if _some_package_has_one():
        from importlib import metadata

        for point in metadata.entry_points(group=GROUP):
            _load(point.value.partition(":")[0], f"the entry point {point.name} of {GROUP}")


def _some_package_has_one() -> bool:
    """Whether an installed package may have such an entry point.

    Files are searched for the group's name: to import what reads them takes longer than all of a short command.
    """
    for place in filter(None, sys.path):
        if os.path.isfile(place):
            return True  # a package in an archive
        names = os.listdir(place) if os.path.isdir(place) else []
        for name in (name for name in names if name.endswith(("-info", ".egg"))):
            try:
                text = Path(place, name, "entry_points.txt").read_text(encoding="utf-8", errors="replace")
            except FileNotFoundError:
                continue
            except OSError:
                return True
            if GROUP in text:
                return True
    return False


def _load(name: str, source: str) -> None:
    try:
        if name.endswith(".py"):
            path = Path(name).resolve()
            # Under a name of its own, so that worker processes and pickled laws find it again.
            module = f"beadband_plugin_{path.stem}"
            spec = util.spec_from_file_location(module, path)
            assert spec is not None
            assert spec.loader is not None
            sys.modules[module] = util.module_from_spec(spec)
            spec.loader.exec_module(sys.modules[module])
        else:
            import_module(name)
    except Exception as error:  # anything may go wrong in somebody else's file
        text = " ".join(str(error).split())
        raise UsageError(
            explain(
                "a plug-in can't be loaded",
                f"{source} ({type(error).__name__}: {text})",
                "a Python file that runs, or a module that can be imported",
                "correct it, or take it out",
            )
        ) from error
