"""What each command does: results to stdout, prose and progress to stderr."""

from __future__ import annotations

import json
import sys
from argparse import Namespace

from beadband.options import scene_values
from beadband.scene import Scene, scene_of


def bands(arguments: Namespace) -> int:
    """List the catalogue."""
    from beadband import tables

    rows = tables.band_rows()
    print(json.dumps(rows, indent=1) if arguments.json else tables.bands(rows))
    return 0


def plan(arguments: Namespace) -> int:
    """Say what a scene needs."""
    from beadband import tables
    from beadband.plan import plan_of

    chosen = plan_of(scene_of(scene_values(arguments)))
    print(json.dumps(tables.plan_values(chosen), indent=1) if arguments.json else tables.plan(chosen))
    return 0


def run(arguments: Namespace) -> int:
    """Release a scene."""
    from beadband import folder, release, results, tables

    scene = scene_of(scene_values(arguments))
    out = arguments.out if arguments.out is not None else folder.next_free(_name(scene))
    done = release.run(scene, out, _Progress() if sys.stderr.isatty() else None)
    print(results.to_json(results.as_dict(done)) if arguments.json else tables.run(done), end="")
    print(f"files in {out}", file=sys.stderr)
    return _verdict(results.failed_checks(done))


def analyze(arguments: Namespace) -> int:
    """Measure a run again."""
    from beadband import release, results, tables

    done = release.analyze(arguments.dir)
    print(results.to_json(results.as_dict(done)) if arguments.json else tables.run(done), end="")
    return _verdict(results.failed_checks(done))


def plot(arguments: Namespace) -> int:
    """Draw the pictures of a run into its folder."""
    from beadband import release
    from beadband.analysis import pictures

    done = release.remeasure(arguments.dir)
    _, ring = release.frames(arguments.dir)
    written = [str(path) for path in pictures.draw(done, ring, arguments.dir)]
    print(json.dumps(written, indent=1) if arguments.json else "\n".join(written))
    return 0


def _name(scene: Scene) -> str:
    return f"{scene.until}-{scene.band.name}-{scene.strain:g}-{scene.half_angle_deg:g}deg-{scene.law}"


def _verdict(failures: list[str]) -> int:
    for sentence in failures:
        print(f"physics check failed: {sentence}", file=sys.stderr)
    return 3 if failures else 0


class _Progress:
    """A line on the terminal that says how far LAMMPS is, once a run takes long enough to wonder."""

    def __call__(self, done: int, steps: int) -> None:
        end = "\n" if done >= steps else ""
        print(f"\rreleasing: step {done} of {steps} ({done / steps:.0%})", end=end, file=sys.stderr, flush=True)
