"""What each command does: results to stdout, prose and progress to stderr."""

from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from typing import TYPE_CHECKING

from beadband.options import scene_values
from beadband.scene import Scene, scene_of

if TYPE_CHECKING:
    from beadband.results import Run


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
    from beadband import folder, release

    scene = scene_of(scene_values(arguments))
    out = arguments.out if arguments.out is not None else folder.next_free(_name(scene))
    done = release.run(scene, out, _Progress("releasing: step") if sys.stderr.isatty() else None)
    code = _report(done, arguments.json)
    print(f"files in {out}", file=sys.stderr)
    return code


def analyze(arguments: Namespace) -> int:
    """Measure a run again."""
    from beadband import release

    done = release.analyze(arguments.dir)
    return _report(done, arguments.json)


def plot(arguments: Namespace) -> int:
    """Draw the pictures of a run into its folder."""
    from beadband import release
    from beadband.analysis import pictures

    done = release.remeasure(arguments.dir)
    ring = release.frames(arguments.dir)
    written = [str(path) for path in pictures.draw(done, ring, arguments.dir)]
    print(json.dumps(written, indent=1) if arguments.json else "\n".join(written))
    return 0


def verify(arguments: Namespace) -> int:
    """Climb the ladder of checks."""
    from beadband import verification
    from beadband.verification import report

    start = time.perf_counter()
    checks = verification.verify(arguments.only)
    seconds = time.perf_counter() - start
    print(json.dumps(report.as_dict(checks, seconds), indent=1) if arguments.json else report.table(checks))
    print(f"{len(checks)} checks in {seconds:.0f} s", file=sys.stderr)
    return 3 if any(check.failed for check in checks) else 0


def reproduce(arguments: Namespace) -> int:
    """Draw the paper's figures and write the scorecard."""
    from beadband import folder, reproduction

    reproduction.check_item(arguments.only)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("reproduction"))
    follow = _Progress("scene") if sys.stderr.isatty() else None
    card = reproduction.reproduce(out, arguments.only, arguments.quick, follow)
    print(json.dumps(card, indent=1) if arguments.json else (out / "scorecard.md").read_text(encoding="utf-8"))
    print(f"files in {out}; {card['scenes']} scenes in {card['wall_s']:.0f} s", file=sys.stderr)
    return 0


def pareto(arguments: Namespace) -> int:
    """Draw the work-precision diagram."""
    from beadband import folder, pareto
    from beadband.pareto import report

    scene = scene_of(scene_values(arguments))
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("pareto"))
    result = pareto.pareto(scene, out, arguments.quick, _Progress("run") if sys.stderr.isatty() else None)
    print(json.dumps(report.finite(result), indent=1) if arguments.json else report.table(result))
    print(f"files in {out}; {result['wall_s']:.0f} s", file=sys.stderr)
    return 0


def _name(scene: Scene) -> str:
    return f"{scene.until}-{scene.band.name}-{scene.strain:g}-{scene.half_angle_deg:g}deg-{scene.law}"


def _report(done: Run, as_json: bool) -> int:
    """Print a finished run and what it does not keep of physics; return the exit code."""
    from beadband import results, tables

    print(results.to_json(results.as_dict(done)) if as_json else tables.run(done), end="")
    failures = results.failed_checks(done)
    for sentence in failures:
        print(f"physics check failed: {sentence}", file=sys.stderr)
    return 3 if failures else 0


class _Progress:
    """A line on the terminal that says how far the work is, once it takes long enough to wonder."""

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def __call__(self, done: int, total: int) -> None:
        end = "\n" if done >= total else ""
        print(f"\r{self.unit} {done} of {total} ({done / total:.0%})", end=end, file=sys.stderr, flush=True)
