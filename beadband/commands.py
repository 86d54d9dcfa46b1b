"""What each command does: results to stdout, prose and progress to stderr."""

from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from beadband.options import grid_values, scene_values
from beadband.scene import Scene, scene_of

if TYPE_CHECKING:
    from beadband.launching.results import Launch
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
    from beadband.launching.plan import launch_plan_of
    from beadband.plan import plan_of

    scene = scene_of(scene_values(arguments))
    chosen = launch_plan_of(scene).twin if scene.until == "launch" else plan_of(scene)
    print(json.dumps(tables.plan_values(chosen), indent=1) if arguments.json else tables.plan(chosen))
    return 0


def run(arguments: Namespace) -> int:
    """Release a scene."""
    from beadband import driver, folder
    from beadband.parallel import world

    scene = scene_of(scene_values(arguments))
    if world().rank > 0:
        driver.help_along(scene)
        return 0
    out = arguments.out if arguments.out is not None else folder.next_free(_name(scene))
    follow = _Progress("releasing: step") if sys.stderr.isatty() else None
    done = driver.run(scene, out, follow)
    code = _report(done, arguments.json)
    print(f"files in {out}", file=sys.stderr)
    return code


def analyze(arguments: Namespace) -> int:
    """Measure a run again."""
    from beadband import driver

    return _report(driver.analyze(arguments.dir), arguments.json)


def plot(arguments: Namespace) -> int:
    """Draw the pictures of a run into its folder."""
    from beadband import driver

    return _written([str(path) for path in driver.plot(arguments.dir)], arguments.json)


def report(arguments: Namespace) -> int:
    """Write the page of a run."""
    from beadband.reporting import page

    return _written([str(page.write(arguments.dir, arguments.out))], arguments.json)


def movie(arguments: Namespace) -> int:
    """Film a run."""
    from beadband.reporting import movie

    follow = _Progress("frame") if sys.stderr.isatty() else None
    path = movie.write(arguments.dir, arguments.out, arguments.fps, arguments.colour, follow)
    return _written([str(path)], arguments.json)


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


def sweep(arguments: Namespace) -> int:
    """Release a grid of scenes."""
    from beadband import sweeping, tables
    from beadband.parallel import world
    from beadband.sweeping.grid import grid_of

    grid = grid_of(grid_values(arguments), arguments.random, arguments.seed)
    out = arguments.out if arguments.out is not None else "sweep"
    with _bar("scene") as follow:
        done = sweeping.run_grid(grid, jobs=arguments.jobs, out=out, follow=follow)
    if world().rank == 0:
        print(json.dumps(done.summary, indent=1) if arguments.json else tables.sweep(done.summary))
        print(f"table, summary and pictures in {out}", file=sys.stderr)
    return 0


@contextmanager
def _bar(unit: str) -> Iterator[Callable[[int, int], None] | None]:
    """A bar with rate and time left, on a terminal only."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(unit=f" {unit}s", smoothing=0.1) as bar:

        def follow(done: int, total: int) -> None:
            if bar.total is None:
                bar.initial = done
            bar.total = total
            bar.update(done - bar.n)

        yield follow


def launch_map(arguments: Namespace) -> int:
    """Launch a grid of scenes for each band."""
    from beadband import folder
    from beadband.launching import map as maps

    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("launch-map"))
    start = time.perf_counter()
    points = maps.launch_map(arguments.quick, follow=_Progress("scene") if sys.stderr.isatty() else None)
    maps.write_map(points, out)
    print(json.dumps(maps.rows(points), indent=1) if arguments.json else maps.summary(points))
    print(f"files in {out}; {len(points)} launches in {time.perf_counter() - start:.0f} s", file=sys.stderr)
    return 0


def stability(arguments: Namespace) -> int:
    """Measure step limits and reproduce failures."""
    from beadband import folder
    from beadband import stability as failures
    from beadband.stability import page

    failures.check_name(arguments.only)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("stability"))
    follow = _Progress("part") if sys.stderr.isatty() else None
    found = failures.find(arguments.only, arguments.quick, follow)
    failures.write(found, out)
    print(json.dumps(failures.as_dict(found), indent=1) if arguments.json else page.summary(found))
    print(f"files in {out}; {found.wall_s:.0f} s", file=sys.stderr)
    for name in found.failed:
        print(f"did not come out as described: {name}", file=sys.stderr)
    return 3 if found.failed else 0


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


def _written(paths: list[str], as_json: bool) -> int:
    print(json.dumps(paths, indent=1) if as_json else "\n".join(paths))
    return 0


def _report(done: Run | Launch, as_json: bool) -> int:
    """Print a finished run and what it does not keep of physics; return the exit code."""
    from beadband import results, tables
    from beadband.launching import results as launch_results

    if isinstance(done, results.Run):
        values, failures = results.as_dict(done), results.failed_checks(done)
        print(results.to_json(values) if as_json else tables.run(done), end="")
    else:
        values, failures = launch_results.as_dict(done), launch_results.failed_checks(done)
        print(results.to_json(values) if as_json else launch_results.text(done), end="")
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
