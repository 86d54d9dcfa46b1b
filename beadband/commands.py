"""What each command does: results to stdout, prose and progress to stderr."""

from __future__ import annotations

import json
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from beadband import parameters
from beadband.errors import RunError, UsageError, explain
from beadband.model.scene import Scene, scene_of

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.planning.plan import Plan
    from beadband.runs.results import Run


_WORTH_SAYING_S = 5.0
_WORTH_SAYING_BYTES = 2e8
"""Predicted time and disk space above which they are printed before the start, not only with the results."""


def scene_values(arguments: Namespace) -> dict[str, Any]:
    """Values of the scene from its file, if there is one, and the flags over them; UsageError for unused ones."""
    from beadband.model.scenefile import read_scene

    command = arguments.command
    values = read_scene(arguments.scene) if arguments.scene is not None else {}
    given = {key: parameters.parsed(key, text) for key, text in parameters.given(arguments).items()}
    if given or command not in ("plan", "run"):
        # What a plan chose for the scene of the file need not suit the one that the flags make of it.
        for key in values.pop("planned", None) or ():
            values.pop(key, None)
    # What belongs to other values, and is no parameter of its own.
    attached = ("planned", "covariance")
    used = {key: value for key, value in values.items() if key in attached or command in parameters.TABLE[key].commands}
    unused = {key: value for key, value in values.items() if key not in used}
    parameters.refuse_unused(
        command, {key: value for key, value in unused.items() if value != parameters.TABLE[key].default}
    )
    parameters.refuse_errors(command, used | given)
    return used | given


def bands(arguments: Namespace) -> int:
    """List the catalogue, or the bands of a file."""
    from beadband.model.bands import CATALOGUE, band_rows, read_bands
    from beadband.reporting import summary as tables

    if arguments.file is None:
        rows = band_rows(CATALOGUE.values())
    else:
        path = arguments.file
        rows = band_rows(scene_of({"band": name, "band_file": path}).band for name in read_bands(path, "--file"))
    print(json.dumps(rows, indent=1) if arguments.json else tables.bands(rows))
    return 0


def plan(arguments: Namespace) -> int:
    """Say what a scene needs."""
    from beadband.planning import plan_scene
    from beadband.reporting import summary as tables

    chosen = plan_scene(scene_of(scene_values(arguments)))
    print(json.dumps(tables.plan_values(chosen), indent=1) if arguments.json else tables.plan(chosen))
    return 0


def run(arguments: Namespace) -> int:
    """Release a scene."""
    from beadband.lammps.ranks import world
    from beadband.planning import plan_scene
    from beadband.runs import dispatch as driver
    from beadband.runs import folder

    scene = scene_of(scene_values(arguments))
    if world().rank > 0:
        driver.help_along(scene)
        return 0
    planned = plan_scene(scene)
    if not arguments.force:
        driver.refuse_absurd(planned, scene.frames)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free(_name(scene)))
    _announce(planned)
    follow = _Progress("releasing: step") if sys.stderr.isatty() else None
    done = driver.run(scene, out, follow)
    code = _report(done, arguments.json)
    print(f"files in {out}", file=sys.stderr)
    return code


def ask(arguments: Namespace) -> int:
    """Answer one number."""
    from beadband.reporting import answers
    from beadband.runs.ask_many import ask_one

    found = ask_one(scene_values(arguments), arguments.quantity)
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else answers.answer(found, arguments.quantity))
    return _noted(found.warnings)


def find(arguments: Namespace) -> int:
    """Find what gives a speed."""
    from beadband.reporting import answers
    from beadband.studies.find import find as search

    found = search(scene_values(arguments), arguments.parameter, arguments.speed)
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else answers.value(found))
    return _noted(found.warnings)


def _noted(warnings: list[str]) -> int:
    for one in warnings:
        print(f"note: {one}", file=sys.stderr)
    return 0


_SAID_BEFORE = ("tolerance-not-expected", "speed-needs-more-beads", "frames-adjusted", "unusual-size")
"""Warnings of a plan that a user wants to read before the run, not after it."""


def _announce(planned: Plan | LaunchPlan) -> None:
    """Print the predicted time and disk space of a long run and the warnings of its plan to stderr."""
    from beadband.runs.dispatch import duration

    if planned.seconds > _WORTH_SAYING_S or planned.disk_bytes > _WORTH_SAYING_BYTES:
        print(f"predicted: {duration(planned.seconds)}, {planned.disk_bytes / 1e6:.2g} MB on disk", file=sys.stderr)
    for one in planned.warnings:
        if one.code in _SAID_BEFORE:
            print(f"note: {one}", file=sys.stderr)


def analyze(arguments: Namespace) -> int:
    """Measure a run again."""
    from beadband.runs import dispatch as driver

    return _report(driver.analyze(arguments.dir), arguments.json)


def fit(arguments: Namespace) -> int:
    """Fit laws to a tensile test."""
    from beadband.model.fitting import fit as fitted
    from beadband.reporting import fit_report
    from beadband.runs import folder

    found = fitted(arguments.file, arguments.law, arguments.strain)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("fit"))
    fit_report.write(found, out)
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else fit_report.table(found))
    print(f"picture and scene files in {out}", file=sys.stderr)
    return 0


def plot(arguments: Namespace) -> int:
    """Draw the pictures of a run into its folder, or those of several runs on the same axes."""
    from beadband.reporting.style import Style

    style = Style(arguments.format, arguments.columns)
    if len(arguments.dir) > 1:
        from beadband.reporting import comparison
        from beadband.runs import folder

        out = folder.create(arguments.out if arguments.out is not None else folder.next_free("comparison"))
        drawn = comparison.draw(comparison.compare(arguments.dir), out, style)
    else:
        from beadband.reporting.pictures import draw_result
        from beadband.runs.dispatch import remeasure

        drawn = draw_result(remeasure(arguments.dir[0]), arguments.out or arguments.dir[0], style)
    return _written([str(path) for path in drawn], arguments.json)


def compare(arguments: Namespace) -> int:
    """Print what differs between runs, and draw them on the same axes."""
    from beadband.reporting import comparison
    from beadband.reporting.style import Style
    from beadband.runs import folder

    found = comparison.compare(arguments.dir)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("comparison"))
    comparison.draw(found, out, Style())
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else comparison.table(found))
    print(f"pictures in {out}", file=sys.stderr)
    return 0


def report(arguments: Namespace) -> int:
    """Write the page of a run."""
    from beadband.reporting import page

    return _written([str(page.write(arguments.dir, arguments.out))], arguments.json)


def explore(arguments: Namespace) -> int:
    """Write the page to play with."""
    from beadband.reporting import explore as playing

    return _written([str(playing.write(arguments.out))], arguments.json)


def movie(arguments: Namespace) -> int:
    """Film a run."""
    from beadband.reporting import movie

    follow = _Progress("frame") if sys.stderr.isatty() else None
    path = movie.write(arguments.dir, arguments.out, arguments.fps, arguments.colour, follow)
    return _written([str(path)], arguments.json)


def verify(arguments: Namespace) -> int:
    """Make the checks against exact answers."""
    from beadband.studies import verification
    from beadband.studies.verification import report

    start = time.perf_counter()
    checks = verification.verify(arguments.only)
    seconds = time.perf_counter() - start
    print(json.dumps(report.as_dict(checks, seconds), indent=1) if arguments.json else report.table(checks))
    print(f"{len(checks)} checks in {seconds:.0f} s", file=sys.stderr)
    return 3 if any(check.failed for check in checks) else 0


def reproduce(arguments: Namespace) -> int:
    """Draw the paper's figures and write the scorecard."""
    from beadband.runs import folder
    from beadband.studies import reproduction

    reproduction.check_item(arguments.only)
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("reproduction"))
    follow = _Progress("scene") if sys.stderr.isatty() else None
    card = reproduction.reproduce(out, arguments.only, arguments.quick, follow)
    print(json.dumps(card, indent=1) if arguments.json else (out / "scorecard.md").read_text(encoding="utf-8"))
    print(f"files in {out}; {card['scenes']} scenes in {card['wall_s']:.0f} s", file=sys.stderr)
    return 0


def sweep(arguments: Namespace) -> int:
    """Release a grid of scenes."""
    from beadband.lammps.ranks import stop_others, world
    from beadband.reporting import summary as tables
    from beadband.studies import sweep as sweeping
    from beadband.studies.engines import engine_of, left_behind
    from beadband.studies.sweep.grid import grid_of, read_grid

    values = read_grid(arguments.grid) if arguments.grid is not None else {}
    grid = grid_of(values | parameters.given(arguments), arguments.random, arguments.seed, arguments.sample)
    out = arguments.out if arguments.out is not None else "sweep"
    patience = {} if arguments.hang_after is None else {"hang_after": arguments.hang_after}

    def announce(expected: Any) -> None:
        print(tables.sweep_estimate(expected), file=sys.stderr)

    with engine_of(arguments.executor) as executor, _bar("scene") as follow:
        done = sweeping.run_grid(
            grid,
            by=arguments.by,
            jobs=arguments.jobs,
            executor=executor,
            out=out,
            parquet=arguments.parquet,
            follow=follow,
            announce=announce,
            **patience,
        )
    if world().rank == 0:
        print(json.dumps(done.summary, indent=1) if arguments.json else tables.sweep(done.summary))
        print(f"table, summary and pictures in {out}", file=sys.stderr)
        if "done" not in done.summary["status"]:
            reasons = done.summary["without_result"].values()
            first = next((each["first"] for each in reasons), "the grid holds no scene")
            refused = "failed" not in done.summary["status"]
            raise (UsageError if refused else RunError)(f"no scene of the sweep has a result; the first: {first}")
        if left_behind():
            # Ranks that wait for one which hangs would never end.
            sys.stdout.flush()
            stop_others(0)
    return 0


def sensitivity(arguments: Namespace) -> int:
    """Say which input's range decides the answer."""
    from beadband.reporting import design_report
    from beadband.runs import folder
    from beadband.studies.design import ranges
    from beadband.studies.design import sensitivity as study

    found = study.sensitivity(
        scene_values(arguments),
        vary=ranges.named(arguments.vary, "--vary"),
        spanned=arguments.spans.split(",") if arguments.spans else (),
        quantity=arguments.quantity,
        points=study.POINTS if arguments.points is None else arguments.points,
        seed=arguments.seed,
    )
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("sensitivity"))
    found.write(out)
    design_report.draw_sensitivity(found, out)
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else design_report.sensitivity(found))
    print(f"table and picture in {out}", file=sys.stderr)
    return _noted(found.warnings)


def design(arguments: Namespace) -> int:
    """Find the best band for a goal."""
    from beadband.reporting import design_report
    from beadband.studies.design import optimum, ranges

    found = optimum.design(
        scene_values(arguments),
        arguments.goal,
        ranges.named(arguments.vary, "--vary"),
        ranges.named(arguments.keep, "--keep"),
        least=arguments.least,
    )
    print(json.dumps(found.as_dict(), indent=1) if arguments.json else design_report.design(found))
    return _noted(found.warnings)


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
    """Launch a grid of scenes for each band, or one of hands."""
    from beadband.runs import folder
    from beadband.studies import launch_map as maps

    if arguments.hand_mass is not None:
        return _hand_map(arguments)
    for flag, text in (("--hand-stiffness", arguments.hand_stiffness), ("--band", arguments.band)):
        if text is not None:
            alone = f"{flag} is not used without --hand-mass"
            raise UsageError(explain(alone, f"{flag} {text}", f"{flag} with --hand-mass", f"leave {flag} out"))
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("launch-map"))
    start = time.perf_counter()
    points = maps.launch_map(
        arguments.quick, jobs=arguments.jobs, follow=_Progress("scene") if sys.stderr.isatty() else None
    )
    maps.write_map(points, out)
    print(json.dumps(maps.rows(points), indent=1) if arguments.json else maps.summary(points))
    print(f"files in {out}; {len(points)} launches in {time.perf_counter() - start:.0f} s", file=sys.stderr)
    return 0


def _hand_map(arguments: Namespace) -> int:
    """Launch one band with a grid of hands."""
    from beadband.runs import folder
    from beadband.studies import hand_map as maps

    masses = maps.values_of("hand_mass_kg", arguments.hand_mass)
    springs = maps.values_of("hand_stiffness_n_m", arguments.hand_stiffness or "0")
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("hand-map"))
    start = time.perf_counter()
    follow = _Progress("hand") if sys.stderr.isatty() else None
    found = maps.hand_map(masses, springs, arguments.band or "III", arguments.quick, follow, jobs=arguments.jobs)
    maps.write_hand_map(*found, out)
    print(json.dumps(maps.rows(*found), indent=1) if arguments.json else maps.summary(*found))
    print(f"files in {out}; {len(found[0])} hands in {time.perf_counter() - start:.0f} s", file=sys.stderr)
    return 0


def stability(arguments: Namespace) -> int:
    """Measure step limits and reproduce failures."""
    from beadband.runs import folder
    from beadband.studies import stability as failures
    from beadband.studies.stability import page

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
    from beadband.runs import folder
    from beadband.studies import pareto
    from beadband.studies.pareto import report
    from beadband.studies.pareto.methods import FULL, QUICK

    scene = scene_of(scene_values(arguments))
    out = folder.create(arguments.out if arguments.out is not None else folder.next_free("pareto"))
    progress = _Progress("run") if sys.stderr.isatty() else None
    result = pareto.pareto(scene, out, QUICK if arguments.quick else FULL, progress, with_peers=True)
    print(json.dumps(result, indent=1) if arguments.json else report.table(result))
    print(f"files in {out}; {result['wall_s']:.0f} s", file=sys.stderr)
    return 0


def _name(scene: Scene) -> str:
    name = "".join(sign if sign.isalnum() or sign in "._" else "-" for sign in scene.band.name)
    if scene.is_strip:
        return f"strip-{name}-{scene.strain:g}-{scene.law}"
    return f"{scene.until}-{name}-{scene.strain:g}-{scene.half_angle_deg:g}deg-{scene.law}"


def _written(paths: list[str], as_json: bool) -> int:
    print(json.dumps(paths, indent=1) if as_json else "\n".join(paths))
    return 0


def _report(done: Run, as_json: bool) -> int:
    """Print a finished run and the physics checks that it fails; return the exit code."""
    from beadband.reporting import summary as tables
    from beadband.runs.results import to_json

    print(to_json(done.as_dict()) if as_json else tables.run(done), end="")
    for failure in done.failed_checks:
        print(f"physics check failed: {failure.sentence}", file=sys.stderr)
    return 3 if done.failed_checks else 0


class _Progress:
    """A line on the terminal that shows the progress of long work."""

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def __call__(self, done: int, total: int) -> None:
        end = "\n" if done >= total else ""
        print(f"\r{self.unit} {done} of {total} ({done / total:.0%})", end=end, file=sys.stderr, flush=True)
