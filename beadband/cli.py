"""The command line: parse, hand over to a command, and turn what goes wrong into one line and an exit code.

Nothing heavy is imported before a command needs it.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from beadband import __version__
from beadband.errors import BeadbandError


class _Parser(argparse.ArgumentParser):
    """A parser that complains in one line, and takes the options of a scene only when its command was chosen."""

    scene_command = ""
    takes_grid = False

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        if self.scene_command:
            from beadband import parameters
            from beadband.model import laws  # noqa: F401  a law adds its constants to the table

            parameters.add_arguments(self, self.scene_command, self.takes_grid)
            self.scene_command = ""
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        print(f"{self.prog}: {' '.join(message.split())}; see '{self.prog} --help'", file=sys.stderr)
        raise SystemExit(2)


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands; each leaves its handler in ``handler``."""
    parser = _Parser(
        prog="beadband",
        description="A stretched rubber band released, as a ring of beads in LAMMPS.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"beadband {__version__}")
    commands = parser.add_subparsers(
        title="commands", metavar="COMMAND", dest="command", required=True, parser_class=_Parser
    )

    def command(name: str, text: str, scene: bool = False, folder: bool = False) -> _Parser:
        added = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
        added.add_argument("--json", action="store_true", help="print JSON instead of a table")
        added.scene_command = name if scene else ""
        if folder:
            added.add_argument("dir", metavar="DIR", help="folder of a run")
        added.set_defaults(handler=name)
        return added

    bands = command("bands", "the catalogue of bands, with what is derived from it")
    bands.add_argument("--file", metavar="FILE.toml", help="bands of one's own instead of the catalogue")
    command("plan", "what a scene needs, and why", scene=True)
    run = command("run", "one release, measured", scene=True)
    run.add_argument("--out", metavar="DIR", help="new or empty folder for the run (default: named after the scene)")
    run.add_argument("--force", action="store_true", help="start even where the predicted time or disk is absurd")
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
    command("analyze", "measure a run again, from the files in its folder", folder=True)
    command("plot", "the pictures of a run", folder=True)
    report = command("report", "a page that plays a run, with its curves and tables", folder=True)
    report.add_argument("--out", metavar="FILE", help="the page (default: DIR/report.html)")
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
        "--out", metavar="DIR", help="folder of the table; a killed sweep goes on there (default: sweep)"
    )
    sweep.add_argument("--jobs", metavar="N", type=int, help="processes (default: one per core)")
    sweep.add_argument(
        "--random", metavar="N", type=int, help="draw so many scenes from the ranges instead of the grid"
    )
    sweep.add_argument("--seed", metavar="S", type=int, default=0, help="of the draws (0)")
    launch_map = command("launch-map", "pause and efficiency of launches over strain and half-angle")
    launch_map.add_argument("--out", metavar="DIR", help="new or empty folder (default: launch-map)")
    launch_map.add_argument("--jobs", metavar="N", type=int, help="processes (default: one per core)")
    launch_map.add_argument("--quick", action="store_true", help="a coarser grid of scenes with fewer beads")
    stability = command("stability", "where the methods fail: the step limit measured, and a catalogue of failures")
    stability.add_argument("--out", metavar="DIR", help="new or empty folder (default: stability)")
    stability.add_argument("--only", metavar="NAME", help="one entry of the catalogue, or map or releases")
    stability.add_argument("--quick", action="store_true", help="fewer specimens and shorter runs")
    pareto = command("pareto", "error against cost of every method, on the same axes", scene=True)
    pareto.add_argument("--out", metavar="DIR", help="new or empty folder (default: pareto)")
    pareto.add_argument("--quick", action="store_true", help="fewer methods and sizes")
    return parser


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
    """Say of options that a command does not know whether another one does; raises UsageError."""
    from beadband import parameters
    from beadband.errors import UsageError, explain
    from beadband.model import laws  # noqa: F401

    flags = [one.partition("=")[0] for one in unknown]
    parameters.refuse_unused(command, [one.key for one in parameters.TABLE.values() if one.flag in flags])
    near = parameters.nearest_flags(flags, command)
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
        return _report(name, "interrupted; what was not finished has no results.json", 1)
    except BrokenPipeError:
        # The reader of our output has gone; keep Python from complaining when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except MemoryError:
        return _report(name, "out of memory; use fewer --beads or --frames", 1)
    except OSError as error:
        return _report(name, f"the system refused: {error}; check disk and permissions", 1)
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
