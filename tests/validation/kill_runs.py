"""Kill runs at random moments: no folder that is left may read as a finished run.

    python tests/validation/kill_runs.py [--count 50] [--seed 1]

Each run is a process of its own, killed by SIGKILL at a random time from when it takes its folder to when it would end,
until so many were killed. Then each folder must either hold a whole results.json, of a run that the files beside it
repeat, or read as unfinished: `run` into it is refused with what it found, and `analyze` of it gives nothing unless all
that it needs was written.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from beadband.errors import UsageError
from beadband.runs import finish
from beadband.runs import folder as files

OPTIONS = ["--beads", "200", "--for", "speed"]


def start(folder: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "beadband", "run", *OPTIONS, "--out", str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=folder.parent,
    )


def follow(process: subprocess.Popen[bytes], folder: Path, after_s: float) -> tuple[bool, float]:
    """Kill a process some time after it took its folder (at once where that is negative).

    Whether it ended by itself, and how long it lived from then on.
    """
    while process.poll() is None and after_s >= 0.0 and not (folder / files.SCENE).exists():
        time.sleep(0.002)
    clock = time.perf_counter()
    try:
        process.wait(timeout=None if math.isinf(after_s) else max(after_s, 0.0))
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGKILL)
        process.wait()
    return process.returncode != -signal.SIGKILL, time.perf_counter() - clock


def look(folder: Path, ended: bool) -> tuple[str, str]:
    """What a folder reads as, and what is wrong with that ('' if nothing)."""
    if not folder.exists():
        return "no folder", ""
    names = {path.name for path in folder.iterdir()}
    if not names:
        return "empty folder", ""
    try:
        files.create(folder)
        return "unclear", f"run would take a folder with {sorted(names)}"
    except UsageError as error:
        said = str(error)
    if files.RESULTS in names:
        try:
            values = json.loads((folder / files.RESULTS).read_text(encoding="utf-8"))
            again = finish.remeasure(folder)
        except (ValueError, UsageError) as error:
            return "finished", f"results.json is there and the run is not whole: {error}"
        # A whole results.json: the work was done, if the process lived to say so or not.
        same = values["rebound_speed_m_s"] == again.measurement.fitted_speed_m_s.value
        return ("finished" if ended else "finished before the kill"), "" if same else "results.json is of another run"
    try:
        finish.remeasure(folder)
        measured = ", measurable"
    except UsageError:
        measured = ""
    wrong = "" if "did not finish" in said or "other file" in said else f"run says {said!r}"
    return f"unfinished{measured}", wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    began = time.perf_counter()
    counts: dict[str, int] = {}
    faults = []
    with tempfile.TemporaryDirectory(prefix="beadband-kill-") as place:
        whole = Path(place) / "whole"
        start(whole).wait()  # the first one fills caches
        names = [Path(place) / f"timed-{number}" for number in range(3)]
        length = min(follow(start(name), name, math.inf)[1] for name in names)
        killed = number = 0
        while killed < arguments.count:
            number += 1
            folder = Path(place) / f"run-{number}"
            share = rng.uniform(-0.05, 1.1)
            ended, _ = follow(start(folder), folder, share * length)
            killed += not ended
            kind, wrong = look(folder, ended)
            counts[kind] = counts.get(kind, 0) + 1
            if wrong:
                faults.append(f"run {number}, killed at {share:.2f} of a run: {wrong}")
    print(
        f"seed {arguments.seed}: {killed} of {number} runs of {length:.2f} s killed, in "
        f"{time.perf_counter() - began:.0f} s"
    )
    for kind, count in sorted(counts.items()):
        print(f"  {kind}: {count}")
    for fault in faults:
        print(f"  FAULT: {fault}")
    print(f"{len(faults)} folders read as what they are not")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
