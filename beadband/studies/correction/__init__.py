"""The correction of the string limit, made again from nothing: ``python -m beadband.studies.correction --out DIR``.

scenes (random draws) -> runs (accurate releases) -> fit (a sparse Gaussian process, its bar and region) -> the file.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

import beadband
from beadband.errors import UsageError, explain
from beadband.model.correction import FEATURES, features
from beadband.studies import pool
from beadband.studies.correction import runs
from beadband.studies.correction.fit import Sample, fitted, held_out
from beadband.studies.correction.scenes import any_band, catalogue_band, drawn

__all__ = ["make", "sample_of"]

FLOOR = 1e-4
"""Least bar: the errors of the releases themselves."""
_SETS = ("train", "calibration", "test")


def sample_of(anything: int, catalogue: int, seed: int, jobs: int | None, progress: pool.Progress | None) -> Sample:
    """Draw and release so many scenes of any kind and so many like the catalogue's; failed runs are left out."""
    scenes = drawn(any_band, anything, seed) + drawn(catalogue_band, catalogue, seed)
    found = runs.released(scenes, jobs, progress)
    done = [
        (features(scene), *one.delta, *one.ratio, scene.string.wave.kind, index >= anything)
        for index, (scene, one) in enumerate(zip(scenes, found, strict=True))
        if isinstance(one, runs.Released)
    ]
    return Sample(*(np.array(column) for column in zip(*done, strict=True)))


def make(
    out: str | os.PathLike[str],
    *,
    scenes: int = 2500,
    catalogue: int = 500,
    held: int = 700,
    seed: int = 1,
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
    held
        Scenes of either kind, once to calibrate the bar and once to report errors.
    """
    if min(scenes, catalogue, held) < 50:
        raise UsageError(
            explain("too few scenes for a map", min(scenes, catalogue, held), "50 or more", "raise the number")
        )
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    counts = {"train": (scenes, catalogue), "calibration": (held, held), "test": (held, held)}
    samples = {}
    for number, name in enumerate(_SETS):
        path = folder / f"{name}-{'-'.join(map(str, counts[name]))}-{seed}.npz"
        if path.is_file():
            samples[name] = _loaded(path)
        else:
            say(f"{name}: releasing {sum(counts[name])} scenes")
            samples[name] = sample_of(*counts[name], 1000 * seed + number, jobs, None)
            np.savez_compressed(path, **{one.name: getattr(samples[name], one.name) for one in fields(Sample)})
    maps, tried = {}, {}
    for kind in ("speed", "curvature"):
        say(f"{kind}: fitting")
        maps[kind] = fitted(kind, samples["train"], samples["calibration"], FLOOR, seed)
        tried[kind] = held_out(kind, maps[kind], samples["test"])
    record: dict[str, Any] = {
        "made_by": "python -m beadband.studies.correction",
        "version": beadband.__version__,
        "seed": seed,
        "scenes": {name: len(sample.delta) for name, sample in samples.items()},
        "curvatures": {name: int(np.isfinite(sample.ratio).sum()) for name, sample in samples.items()},
        "runs": len(runs.BEADS_IN_REAR) * sum(len(sample.delta) for sample in samples.values()),
        "beads_in_rear": list(runs.BEADS_IN_REAR),
        "features": list(FEATURES),
        "held_out": tried,
    }
    path = folder / "correction.json"
    path.write_text(json.dumps(record | {"maps": maps}, separators=(",", ":"), allow_nan=False) + "\n")
    return path


def _loaded(path: Path) -> Sample:
    with np.load(path) as stored:
        return Sample(*(stored[one.name] for one in fields(Sample)))
