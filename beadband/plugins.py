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
    if _announced():
        from importlib import metadata

        for point in metadata.entry_points(group=GROUP):
            _load(point.value.partition(":")[0], f"the entry point {point.name} of {GROUP}")


def _announced() -> bool:
    """Whether an installed package names the group: a quick look before importlib.metadata parses all packages."""
    for folder in sys.path:
        try:
            names = os.listdir(folder or os.curdir)
        except OSError:
            continue
        for name in names:
            if name.endswith((".dist-info", ".egg-info")):
                try:
                    with open(os.path.join(folder, name, "entry_points.txt"), encoding="utf-8") as file:
                        if GROUP in file.read():
                            return True
                except (OSError, UnicodeDecodeError):
                    continue
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
