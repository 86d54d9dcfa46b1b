"""Sweeps on each engine that are killed, lose a worker or have one hang at random: nothing is lost or there twice.

python tests/validation/kill_sweep.py [--engines processes mpi dask parsl] [--kills 20] [--seed 1]

In turn the whole sweep is killed, one of its workers is killed, and one is stopped for ever. Whatever has not finished
by itself is started again, and the table must have the bytes of a sweep in one process. The files of docs/engines.md
are used as they are printed there.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from beadband.lammps.engine import program

SWEEP = [sys.executable, "-m", "beadband", "sweep"]
FLAGS = ["--band", "I,II,III,IV", "--strain", "0.1:1.4:6", "--half-angle", "6:26:3", "--by", "runs"]
FLAGS += ["--law", "mooney-rivlin,linear", "--hang-after", "8"]
ENGINES = {
    "processes": [*SWEEP, "--jobs", "2"],
    "mpi": [str(program("mpirun")), "-np", "3", *SWEEP],
    "dask": [*SWEEP, "--executor", "dask_engine:workers"],
    "parsl": [*SWEEP, "--executor", "parsl_engine:workers"],
}
MARK = "BEADBAND_KILL_SWEEP"
WHAT = ("the sweep", "a worker", "a hanging worker")


def started_by(mark: str) -> dict[int, str]:
    """Command line of each process of a sweep: with a mark in its environment, or below one that has it.

    Some processes are nobody's children by now, and others have overwritten their environment with a title.
    """
    parents, lines, found = {}, {}, set()
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                pid = int(entry.name)
                parents[pid] = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                lines[pid] = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                if f"{MARK}={mark}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                    found.add(pid)
            except (OSError, ValueError):
                continue
    while new := {one for one, parent in parents.items() if parent in found} - found:
        found |= new
    return {one: lines.get(one, "") for one in found}


def workers_of(engine: str, mark: str) -> list[int]:
    """Process ids of those that release scenes."""
    signs = {
        "processes": "spawn_main",
        "dask": "dask worker",
        "parsl": "spawn_main",
        "mpi": "-m beadband sweep",
    }
    found = sorted(one for one, line in started_by(mark).items() if signs[engine] in line and "mpirun" not in line)
    # The first rank is the sweep itself, and Parsl's first process keeps its queues.
    return found[1:] if engine in ("mpi", "parsl") else found


def kill_all(process: subprocess.Popen[bytes], mark: str, seen: set[int]) -> None:
    """End a sweep with all that it has started, at once; ``seen`` are processes that were its own before."""
    for one in (process.pid, *started_by(mark), *seen):
        try:
            os.kill(one, signal.SIGKILL)
        except ProcessLookupError:
            continue
    process.wait()


def rows_in(folder: Path) -> int:
    """Whole rows of the table."""
    table = folder / "sweep.csv"
    return max(table.read_bytes().count(b"\n") - 1, 0) if table.exists() else 0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--what", nargs="+", choices=WHAT, default=WHAT)
    arguments = parser.parse_args()
    draws = random.Random(arguments.seed)
    page = (Path(__file__).parents[2] / "docs" / "engines.md").read_text(encoding="utf-8")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    with tempfile.TemporaryDirectory() as place:
        for block in page.split("```python\n")[1:]:
            text = block.split("```")[0]
            (Path(place) / text.split()[1]).write_text(text, encoding="utf-8")

        def begin(words: list[str], folder: str) -> subprocess.Popen[bytes]:
            return subprocess.Popen(
                [*words, *FLAGS, "--out", folder], cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env={**os.environ, "PATH": path, MARK: f"{place} {folder}"},
            )  # fmt: skip

        assert begin([*SWEEP, "--jobs", "1"], "whole").wait() == 0
        expected = (Path(place) / "whole" / "sweep.csv").read_bytes()
        for engine in arguments.engines:
            bad, finished = 0, 0
            for number in range(arguments.kills):
                what, name = arguments.what[number % len(arguments.what)], f"{engine} {number}"
                mark = f"{place} {name}"
                process, folder = begin(ENGINES[engine], name), Path(place) / name
                rows = draws.randint(0, 130)
                while process.poll() is None and rows_in(folder) < rows:
                    time.sleep(0.002)
                time.sleep(draws.uniform(0.0, 0.2))
                workers = workers_of(engine, mark)
                seen = set(started_by(mark))
                if what == "the sweep" or not workers:
                    what = "the sweep"
                    kill_all(process, mark, seen)
                else:
                    stop = signal.SIGKILL if what == "a worker" else signal.SIGSTOP
                    one = draws.choice(workers)
                    os.kill(one, stop)
                    try:
                        process.wait(timeout=180.0)
                    except subprocess.TimeoutExpired:
                        what += ", and it did not end"
                        bad += 1
                    kill_all(process, mark, seen)
                there = rows_in(folder)
                alone = process.returncode == 0
                finished += alone
                if not alone and (folder / "sweep.json").exists():
                    what += ", and it looks finished"
                    bad += there != expected.count(b"\n") - 1
                again = begin(ENGINES[engine], name)
                again.wait()
                kill_all(again, mark, set())
                same = (folder / "sweep.csv").read_bytes() == expected and (folder / "sweep.json").exists()
                bad += not same
                print(
                    f"{name}: {what}, exit {process.returncode} with {there} rows; same in the end: {same}", flush=True
                )
            print(
                f"{engine}, seed {arguments.seed}: {arguments.kills} kills, {finished} ended alone, {bad} bad",
                flush=True,
            )


if __name__ == "__main__":
    main()
