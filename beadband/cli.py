"""The command line: parse, hand over to a command, and turn what goes wrong into one line and an exit code.

Nothing heavy is imported before a command needs it.
"""

from __future__ import annotations

import argparse
import atexit
import gc
import os
import sys
import threading
from collections.abc import Callable, Sequence
from typing import NoReturn

from beadband import __version__
from beadband.errors import BeadbandError


class _Parser(argparse.ArgumentParser):
    """A parser that complains in one line, and takes the options of a scene only when its command was chosen."""

    scene_command = ""
    takes_grid = False

    def add_scene(self) -> None:
        """Add the options of a scene, if the command takes one."""
        if self.scene_command:
            from beadband import parameters
            from beadband.model import laws  # noqa: F401  a law adds its constants to the table

            parameters.add_arguments(self, self.scene_command, self.takes_grid)
            self.scene_command = ""

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        self.add_scene()
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: {' '.join(message.split())}; see '{self.prog} --help'", file=sys.stderr)
        raise SystemExit(2)


class _Completion(argparse.Action):
    """Print a shell's completion of all commands with all of their options, and exit."""

    def __call__(self, parser, namespace, values, option_string=None):  # type: ignore[no-untyped-def]
        shells = ("bash", "zsh", "tcsh")
        if values not in shells:
            parser.error(f"unknown shell: given {values!r}; allowed: {', '.join(shells)}; change {option_string}")
        try:
            import shtab
        except ImportError:
            parser.error("completion needs shtab: given none; allowed: shtab; pip install 'beadband[completion]'")
        for one in _commands(parser).values():
            one.add_scene()
        print(shtab.complete(parser, values))
        parser.exit()


def _commands(parser: argparse.ArgumentParser) -> dict[str, _Parser]:
    (commands,) = (one for one in parser._actions if isinstance(one, argparse._SubParsersAction))
    return dict(commands.choices)


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands; each leaves its handler in ``handler``."""
    parser = _Parser(
        prog="beadband",
        description="A stretched rubber band released, as a ring of beads in LAMMPS.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"beadband {__version__}")
    parser.add_argument(
        "--print-completion",
        metavar="bash|zsh|tcsh",
        action=_Completion,
        help="print a script that completes commands and options in this shell (needs shtab)",
    )
    commands = parser.add_subparsers(
        title="commands", metavar="COMMAND", dest="command", required=True, parser_class=_Parser
    )

    def command(name: str, text: str, scene: bool = False, folder: bool = False, folders: str = "") -> _Parser:
        added = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
        added.add_argument("--json", action="store_true", help="print JSON instead of a table")
        added.scene_command = name if scene else ""
        if folder:
            added.add_argument("dir", metavar="DIR", help="folder of a run")
        if folders:
            added.add_argument("dir", metavar="DIR", nargs="+", help=f"folders of {folders}")
        added.set_defaults(handler=name)
        return added

    bands = command("bands", "the catalogue of bands, with what is derived from it")
    bands.add_argument("--file", metavar="FILE.toml", help="your own bands instead of the catalogue")
    command("plan", "what a scene needs, and why", scene=True)
    run = command("run", "one release, measured", scene=True)
    run.add_argument("--out", metavar="DIR", help="new or empty folder for the run (default: named after the scene)")
    run.add_argument("--force", action="store_true", help="start even if the predicted time or disk space is too large")
    ask = command("ask", "one number of a release with its error, at the least cost", scene=True)
    ask.add_argument(
        "--quantity",
        choices=("speed", "curvature"),
        default="speed",
        help="V in m/s, or the mean tip curvature in its self-similar window over that of Eq. 7 (default: speed)",
    )
    find = command("find", "the strain, angle or size that gives a wanted speed", scene=True)
    find.add_argument("parameter", choices=("strain", "half-angle", "thickness", "circumference"), help="what to find")
    find.add_argument("--speed", metavar="M_S", type=float, required=True, help="the wanted rebound speed V, m/s")
    fit = command("fit", "constants of every law from a tensile test, with errors and a picture")
    fit.add_argument("file", metavar="FILE.csv", help="the test: stretch or strain, and the nominal stress")
    fit.add_argument("--law", metavar="NAME", nargs="+", help="laws to fit (default: all)")
    fit.add_argument("--strain", metavar="X", type=float, help="strain up to which it matters (default: the test's)")
    fit.add_argument("--out", metavar="DIR", help="new or empty folder of picture and scene files (default: fit)")
    command("analyze", "measure a run again, from the files in its folder", folder=True)
    plot = command("plot", "the pictures of a run, or of several on the same axes", folders="run")
    plot.add_argument(
        "--out", metavar="DIR", help="folder of the pictures (default: that of the run, or comparison for several)"
    )
    plot.add_argument("--format", metavar="png|pdf|svg", default="png", help="of the files (default: png)")
    plot.add_argument("--columns", metavar="1|2", type=int, help="width in columns of a journal (default: a screen's)")
    compare = command("compare", "runs side by side: what differs, in a table and pictures", folders="two or more runs")
    compare.add_argument("--out", metavar="DIR", help="new or empty folder of the pictures (default: comparison)")
    report = command("report", "a page that plays a run, with its curves and tables", folder=True)
    report.add_argument("--out", metavar="FILE", help="the page (default: DIR/report.html)")
    explore = command("explore", "a page to play with, which computes V of any band in the browser")
    explore.add_argument("--out", metavar="FILE", default="explore.html", help="the page (default: explore.html)")
    movie = command("movie", "a GIF or MP4 of a run", folder=True)
    movie.add_argument("--out", metavar="FILE", help="a .gif or .mp4 (default: DIR/movie.gif)")
    movie.add_argument("--fps", metavar="N", type=int, default=20, help="frames a second, 1 to 50 (default: 20)")
    movie.add_argument("--colour", choices=("stretch", "curvature"), default="stretch", help="(default: stretch)")
    verify = command("verify", "independent checks against exact answers")
    verify.add_argument("--only", metavar="NAME", help="one rung of the ladder")
    reproduce = command("reproduce", "the paper, figure by figure, with a scorecard")
    reproduce.add_argument("--out", metavar="DIR", help="new or empty folder (default: reproduction)")
    reproduce.add_argument("--only", metavar="ITEM", help="one figure or table, as in fig18, table1 or appendix")
    reproduce.add_argument("--quick", action="store_true", help="coarser grids of scenes")
    sweep = command("sweep", "a grid of scenes, or random ones, in one table", scene=True)
    sweep.takes_grid = True
    sweep.add_argument(
        "--out", metavar="DIR", help="folder of the table; a killed sweep continues there (default: sweep)"
    )
    sweep.add_argument("--jobs", metavar="N", type=int, help="processes (default: one per core)")
    sweep.add_argument(
        "--random", metavar="N", type=int, help="draw N scenes from the ranges instead of the whole grid"
    )
    sweep.add_argument(
        "--sample",
        metavar="KIND",
        help="how they are drawn: random, latin-hypercube or sobol (with --random; default: random)",
    )
    sweep.add_argument("--seed", metavar="S", type=int, help="seed of the draws (with --random; default: 0)")
    sweep.add_argument(
        "--by", metavar="WAY", help="cheapest (default): the formula where it will do; runs: every scene is released"
    )
    sweep.add_argument("--parquet", action="store_true", help="write sweep.parquet too (needs pyarrow)")
    sweep.add_argument(
        "--executor", metavar="MODULE:FACTORY", help="what runs the scenes: any executor of concurrent.futures"
    )
    sweep.add_argument(
        "--hang-after", metavar="S", type=float, help="seconds beyond the expected ones until a worker is given up"
    )
    sensitivity = command("sensitivity", "which input's range decides the answer: Sobol' indices", scene=True)
    _vary(sensitivity)
    sensitivity.add_argument(
        "--spans",
        metavar="BANDS",
        help="vary what these bands of the catalogue span, as in I,II,III,IV, and the rubber",
    )
    sensitivity.add_argument(
        "--quantity",
        metavar="NAME",
        default="speed",
        help="speed, curvature, or a closed form such as stored-energy, pull or throw-momentum (default: speed)",
    )
    sensitivity.add_argument(
        "--points", metavar="N", type=int, help="points of each of two samples, a power of 2 (default: 4096)"
    )
    sensitivity.add_argument("--seed", metavar="S", type=int, default=0, help="seed of the points (default: 0)")
    sensitivity.add_argument(
        "--out", metavar="DIR", help="new or empty folder of table and picture (default: sensitivity)"
    )
    design = command("design", "the best band for a goal, under conditions", scene=True)
    _vary(design)
    design.add_argument(
        "--goal",
        metavar="NAME",
        required=True,
        help="speed, curvature, or a closed form such as throw-speed, stored-energy or mass",
    )
    design.add_argument("--least", action="store_true", help="make the goal small instead of large")
    design.add_argument(
        "--keep",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="a condition: stored-energy=0.1, pull=:5 (at most), mass=1e-3: (at least) or LOW:HIGH; several times",
    )
    launch_map = command("launch-map", "pause and efficiency of launches over strain and half-angle")
    launch_map.add_argument("--out", metavar="DIR", help="new or empty folder (default: launch-map)")
    launch_map.add_argument("--jobs", metavar="N", type=int, help="processes (default: one per core)")
    launch_map.add_argument("--quick", action="store_true", help="a coarser grid of scenes with fewer beads")
    launch_map.add_argument("--band", metavar="NAME", help="with --hand-mass: the band (default: III)")
    axis = "values A,B,C or FIRST:LAST:COUNT, even in the logarithm"
    launch_map.add_argument("--hand-mass", metavar="VALUES", help=f"a map over hands instead: masses in kg, {axis}")
    launch_map.add_argument("--hand-stiffness", metavar="VALUES", help="with --hand-mass: springs in N/m (default: 0)")
    stability = command("stability", "where the methods fail: the step limit measured, and a catalogue of failures")
    stability.add_argument("--out", metavar="DIR", help="new or empty folder (default: stability)")
    stability.add_argument("--only", metavar="NAME", help="one entry of the catalogue, or map or releases")
    stability.add_argument("--quick", action="store_true", help="fewer specimens and shorter runs")
    pareto = command("pareto", "error against cost of every method, on the same axes", scene=True)
    pareto.add_argument("--out", metavar="DIR", help="new or empty folder (default: pareto)")
    pareto.add_argument("--quick", action="store_true", help="fewer methods and sizes")
    return parser


def _vary(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--vary",
        metavar="NAME=RANGE",
        action="append",
        default=[],
        help="an input and its range, as in strain=0.2:1.2, thickness='2e-3 +/- 5e-5' or band=I,III; several times",
    )


def reference() -> str:
    """The page of all commands, for the documents: what each does and its own options, made of the parser itself."""
    from beadband import parameters

    commands = _commands(build_parser())
    lines = [
        "# Commands",
        "",
        "Made by `make docs` from the parser of the command line. Every command prints its part with `--help`.",
        "Exit codes: 0 done, 1 failed, 2 wrong usage or a scene that has no answer, 3 a physics check failed.",
        "Results go to stdout; progress and prose go to stderr. `--json` prints JSON.",
    ]
    scene = ", ".join(name for name in commands if parameters.used_by(name))
    lines += ["", f"The options of a scene, which {scene} take: [parameters](parameters.md)."]
    for name, parser in commands.items():
        options = [one for one in parser._actions if one.dest not in ("help", "json")]
        words = "".join(f" {one.metavar}{' …' if one.nargs else ''}" for one in options if not one.option_strings)
        lines += ["", f"## beadband {name}{words}{' [scene]' if parameters.used_by(name) else ''}", ""]
        lines += [f"{str(parser.description)[0].upper()}{str(parser.description)[1:]}.", ""]
        for one in options:
            flag = " ".join([*one.option_strings, *([str(one.metavar)] if one.metavar else [])])
            lines.append(f"* `{flag}`: {one.help % {'default': one.default} if one.help else ''}")
    return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"


def program() -> NoReturn:
    """The command line as a process of its own, which starts and ends as quickly as it can."""
    # Arrays here are small: threads for them take longer to start than they save. A user's own setting stands.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Most of what a command makes is modules, which are no garbage; it is looked for seldom.
    gc.set_threshold(100_000, 50, 50)
    if sys.argv[1:2] == ["run"]:
        from beadband.lammps import library

        library.load_ahead()
    try:
        code = main()
    except SystemExit as end:  # of the parser
        code = end.code if isinstance(end.code, int) else 1
    _end(code)


def _end(code: int) -> NoReturn:
    """Leave with this exit code, without taking apart what the process holds: that takes as long as a short release.

    What was registered to be done at exit is done, and output is flushed. Several ranks end together, as MPI wants.
    """
    parallel = sys.modules.get("mpi4py.MPI")
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError):
        parallel = sys  # Python's own end deals with a reader that has gone
    if parallel is None and threading.active_count() == 1:
        atexit._run_exitfuncs()
        os._exit(code)
    sys.exit(code)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code: 0 done, 1 failed, 2 wrong usage, 3 a physics check failed."""
    parser = build_parser()
    try:
        arguments, unknown = parser.parse_known_args(argv)
    except BeadbandError as error:  # a plug-in that can't be loaded
        return _report(parser.prog, str(error), error.exit_code)
    if unknown:
        return guarded(lambda: _refuse(unknown, arguments.command), f"beadband {arguments.command}")
    return guarded(lambda: _handler(arguments.handler)(arguments), f"beadband {arguments.command}")


def _refuse(unknown: Sequence[str], command: str) -> int:
    """Refuse unknown options, with the commands that know them; raises UsageError."""
    from beadband import parameters
    from beadband.errors import UsageError, explain
    from beadband.model import laws  # noqa: F401

    values: dict[str, str] = {}
    for text in unknown:
        flag, _, value = text.partition("=")
        if flag.startswith("--"):
            values[flag] = value
        elif values:
            values[list(values)[-1]] = text
    known = {one.flag: one.key for one in parameters.TABLE.values()}
    parameters.refuse_unused(command, {known[flag]: value for flag, value in values.items() if flag in known})
    near = parameters.nearest_flags(values, command)
    raise UsageError(
        explain("unrecognized arguments", " ".join(unknown), f"the options of 'beadband {command} --help'", near)
    )


def _handler(name: str) -> Callable[[argparse.Namespace], int]:
    from beadband import commands

    handler: Callable[[argparse.Namespace], int] = getattr(commands, name.replace("-", "_"))
    return handler


def guarded(action: Callable[[], int], name: str) -> int:
    """Call ``action`` and turn every way in which it can fail into one line on stderr and an exit code."""
    code = _guarded(action, name)
    parallel = sys.modules.get("beadband.lammps.ranks")
    if parallel and code:
        parallel.stop_others(code)
    return code


def _guarded(action: Callable[[], int], name: str) -> int:
    try:
        code = action()
        sys.stdout.flush()
        return code
    except BeadbandError as error:
        return _report(name, str(error), error.exit_code)
    except KeyboardInterrupt:
        return _report(name, "interrupted; an unfinished run has no results.json", 1)
    except BrokenPipeError:
        # The reader of our output has gone; keep Python from complaining when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except MemoryError:
        return _report(name, "out of memory; use fewer --beads or --frames", 1)
    except OSError as error:
        return _report(name, f"a file could not be used: {error}; check the disk and permissions", 1)
    except Exception as error:
        if os.environ.get("BEADBAND_DEBUG"):
            raise
        text = " ".join(str(error).split())
        return _report(
            name, f"a fault of beadband's own ({type(error).__name__}: {text}); set BEADBAND_DEBUG=1 to see where", 1
        )


def _report(name: str, text: str, code: int) -> int:
    print(f"{name}: {' '.join(text.split())}", file=sys.stderr)
    return code
