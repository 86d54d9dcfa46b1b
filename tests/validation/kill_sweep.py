"""Kill a sweep ten times in its middle, a worker or all of it, and see that nothing is lost and nothing is there twice.

python tests/validation/kill_sweep.py [--kills 10] [--seed 1]
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

FLAGS = [
    "--band",
    "I,II,III,IV",
    "--strain",
    "0.1:1.4:6",
    "--half-angle",
    "6:26:3",
    "--law",
    "mooney-rivlin,linear",
    "--jobs",
    "2",
]


def workers_of(pid: int) -> list[int]:
    """Process ids of the spawned workers of a sweep."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                line = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if parent == pid and b"spawn_main" in line:
                found.append(int(entry.name))
    return found


def rows_in(folder: Path) -> int:
    """Whole rows of the table."""
    table = folder / "sweep.csv"
    return max(table.read_bytes().count(b"\n") - 1, 0) if table.exists() else 0


def wait_for_rows(process: subprocess.Popen[bytes], folder: Path, rows: int) -> None:
    """Until the table has so many rows, or the sweep has ended."""
    while process.poll() is None and rows_in(folder) < rows:
        time.sleep(0.002)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    draws = random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as place:
        whole = Path(place) / "whole"
        sweep = [sys.executable, "-m", "beadband", "sweep", *FLAGS, "--out"]
        subprocess.run([*sweep, str(whole)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        expected = (whole / "sweep.csv").read_bytes()
        bad = 0
        for number in range(arguments.kills):
            folder = Path(place) / f"killed {number}"
            process = subprocess.Popen(
                [*sweep, str(folder)], start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
            wait_for_rows(process, folder, draws.randint(1, 130))
            workers = workers_of(process.pid)
            if number % 2 and workers:
                what = "a worker"
                os.kill(draws.choice(workers), signal.SIGKILL)
                process.wait()
            else:
                what = "the sweep"
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            rows = rows_in(folder)
            whole_rows = rows == expected.count(b"\n") - 1
            read_as_finished = not whole_rows and process.returncode != 0 and (folder / "sweep.json").exists()
            subprocess.run([*sweep, str(folder)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            same = (folder / "sweep.csv").read_bytes() == expected
            bad += not same or read_as_finished
            print(f"{number}: killed {what} with {rows} rows there, exit {process.returncode}; same in the end: {same}")
        print(f"seed {arguments.seed}: {arguments.kills} kills, {bad} bad")


if __name__ == "__main__":
    main()
