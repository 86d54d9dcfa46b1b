"""Random scenes, a third of them at or past some edge: each ends in a sound answer, or in a refusal with a reason.

    python tests/validation/thousand_scenes.py [--count 1000] [--seed 1] [--timeout 120] [--keep FILE.json]

Two processes work through the scenes; each is given ``--timeout`` seconds. A scene ends as

* answered: the run finished, every number in its results is finite, its physics checks hold, and its speed and its
  curvature's figures are within their own error bars of converged ones;
* failed check: the run finished and says itself which check it does not keep (exit code 3);
* refused: a UsageError (exit 2) or RunError (exit 1) with its reason in one line;
* set aside: its plan asks for more steps than there is time for here;

or it is a fault: a number that is not finite, no end in time, any other exception, or a wrong answer that its error bar
does not admit. The converged values come from two finer runs (about 2 and 4 times the beads, as far as time allows) and
Richardson's extrapolation for errors of the second order; half of their difference counts as their own error. A loss
time of the scene's is physics and stays; a numerical one goes with the mesh.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

KINDS = ("inside", "edge")
_DEAREST = 6e7
"""Beads times steps of the finest run that a scene is compared with, and half of what is released at all."""


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def inside(rng: random.Random) -> dict[str, Any]:
    """A scene well within the model."""
    values: dict[str, Any] = {
        "band": rng.choice(["I", "II", "III", "IV", "circular"]),
        "law": rng.choice(["linear", "mooney-rivlin"]),
        "strain": rng.uniform(0.05, 1.2),
        "for": rng.choice(["curvature", "speed", "speed"]),
        "tolerance": rng.choice([0.005, 0.01, 0.02]),
    }
    widest = math.degrees(math.asin(0.85 / (1.0 + values["strain"])))
    values["half_angle_deg"] = rng.uniform(4.0, min(40.0, widest))
    if rng.random() < 0.3:
        values["beads"] = rng.randrange(80, 600)
    if rng.random() < 0.2:
        values["loss_time_s"] = log_uniform(rng, 1e-6, 1e-4)
    if rng.random() < 0.2:
        values["bending_modulus"] = "rest"
    return values


def edge(rng: random.Random) -> dict[str, Any]:
    """A scene at or past one edge or two."""
    values = inside(rng)
    for _ in range(rng.choice([1, 1, 2])):
        which = rng.randrange(14)
        if which == 0:  # near and past the tension peak
            values |= {"band": "IV", "law": "mooney-rivlin", "strain": rng.uniform(1.3, 1.6), "half_angle_deg": 5.0}
        elif which == 1:  # near and past the wedge's closing
            closing = rng.uniform(0.95, 1.02)
            sine = min(closing / (1.0 + values["strain"]), 0.999)
            values["half_angle_deg"] = math.degrees(math.asin(sine))
        elif which == 2:
            values["bending_scale"] = rng.choice([0.0, 1e-8, 1e-3, 30.0, 1e3, 1e6])
        elif which == 3:
            values["beads"] = rng.choice([1, 23, 24, 25, 31, 40, 41])
        elif which == 4:
            values["timestep_s"] = log_uniform(rng, 1e-7, 1e-4)
        elif which == 5:
            values["loss_time_s"] = rng.choice([0.0, 0.0, 1e-9, 1e-3, 1e-2, 1.0])
        elif which == 6:
            values[rng.choice(["strain", "half_angle_deg", "tolerance", "beads", "law", "band"])] = rng.choice(
                [math.nan, math.inf, -1.0, 0, "x", None, [], True]
            )
        elif which == 7:
            values["half_angle_deg"] = rng.choice([0.01, 0.3, 1.0, 60.0, 80.0, 89.9])
        elif which == 8:
            values["strain"] = rng.choice([1e-6, 1e-4, 0.01, 2.0, 4.0, 9.9])
        elif which == 9:
            values["thickness_m"] = log_uniform(rng, 1e-5, 5e-2)
        elif which == 10:
            values["circumference_m"] = log_uniform(rng, 5e-3, 10.0)
        elif which == 11:
            values |= {"c10_pa": rng.uniform(-3e5, 3e5), "c01_pa": rng.uniform(-1e5, 6e5)}
        elif which == 12:
            values["tolerance"] = rng.choice([1e-4, 0.3])
        else:
            values["frames"] = rng.choice([1, 2, 7, 400])
    return values


def finite(value: Any, place: str = "") -> list[str]:
    """Places of numbers that are not finite."""
    if isinstance(value, dict):
        return [bad for key, item in value.items() for bad in finite(item, f"{place}.{key}")]
    if isinstance(value, list):
        return [bad for item in value for bad in finite(item, place)]
    return [place] if isinstance(value, float) and not math.isfinite(value) else []


def work(values: dict[str, Any]) -> dict[str, Any]:
    """Release one scene and judge it; called in a process of its own, which the parent may end."""
    from beadband.errors import BeadbandError
    from beadband.model.scene import scene_of
    from beadband.planning.plan import plan_of
    from beadband.runs import release

    with tempfile.TemporaryDirectory(prefix="beadband-scene-") as place:
        folder = Path(place) / "run"
        try:
            plan = plan_of(scene_of(values))
            if plan.beads * plan.steps > 2.0 * _DEAREST:
                return {"end": "set aside", "why": f"{plan.beads} beads, {plan.steps} steps"}
            run = release.run(scene_of(values), folder)
            found = run.as_dict()
        except BeadbandError as error:
            said = str(error)
            if (folder / "results.json").exists():
                return {"end": "fault", "why": f"results.json beside the error {said}"}
            if "\n" in said or "given" not in said:
                return {"end": "fault", "why": f"an error that explains nothing: {said}"}
            return {"end": "refused", "code": error.exit_code, "why": said}
        bad = finite(found)
        if bad:
            return {"end": "fault", "why": f"not finite: {bad[:3]}"}
        if json.loads((folder / "results.json").read_text(encoding="utf-8"))["scene"] != json.loads(
            json.dumps(found["scene"])
        ):
            return {"end": "fault", "why": "results.json is not that of the run"}
    speed, bar = found["rebound_speed_m_s"], found["rebound_speed_error_m_s"]
    outcome: dict[str, Any] = {"beads": found["scene"]["beads"]}
    if found["checks"]["failed"]:
        return {**outcome, "end": "failed check", "why": "; ".join(found["checks"]["failed"])}
    warned = [text for text in found["warnings"] if "rings" in text]
    if warned:
        return {**outcome, "end": "answered", "why": "not compared: without loss it rings, as the warning says"}
    try:
        exact = converged(run.plan)
    except BeadbandError as error:
        return {**outcome, "end": "answered", "why": f"not compared: {error}"}
    given = {"V": (speed, bar)}
    if found["curvature"]:
        for name in ("exponent", "eq7_ratio"):
            given[name] = (found["curvature"][name], found["curvature"][f"{name}_error"])
    wrong = []
    for name, (value, error) in given.items():
        if name not in exact:
            continue
        true, doubt = exact[name]
        outcome[name] = {"value": value, "bar": error, "true": true, "doubt": doubt}
        if abs(value - true) > error + doubt:
            wrong.append(f"{name} = {value:.6g} +/- {error:.2g}, converged {true:.6g} ({doubt:.1g})")
    return {**outcome, "end": "fault" if wrong else "answered", "why": "; ".join(wrong)}


def converged(plan: Any) -> dict[str, tuple[float, float]]:
    """Speed and curvature figures of the same scene on finer rings, and how far each may be off."""
    from beadband.errors import UsageError
    from beadband.lammps.engine import Session
    from beadband.planning.plan import plan_of
    from beadband.runs.rear_run import follow_rear

    finer = []
    for factor in (4.0, 3.0, 2.0, 1.5):
        chosen = plan_of(
            plan.scene.with_beads(int(factor * plan.beads)),
            "leg",
        )
        if chosen.bead_steps <= _DEAREST:
            finer.append(chosen)
    if len(finer) < 2:
        raise UsageError("finer runs would take too long")
    coarse, fine = finer[-1] if len(finer) == 2 else finer[-2], finer[0]
    with Session() as session:
        pair = [follow_rear(coarse, session), follow_rear(fine, session)]
    measured = {"V": [one.fitted_speed_m_s for one in pair]}
    if all(one.decay for one in pair):
        measured["exponent"] = [one.decay.exponent for one in pair if one.decay]
        measured["eq7_ratio"] = [one.decay.eq7_ratio for one in pair if one.decay]
    square = (fine.beads / coarse.beads) ** 2 - 1.0
    return {
        name: (
            last.value + (last.value - first.value) / square,
            math.hypot(0.5 * (last.value - first.value), last.error),
        )
        for name, (first, last) in measured.items()
    }


def judged(values: dict[str, Any], timeout_s: float) -> dict[str, Any]:
    """One scene in a process of its own: a hang or a crash is its own and nobody else's."""
    began = time.perf_counter()
    try:
        done = subprocess.run(
            [sys.executable, __file__, "--one"],
            input=json.dumps(values),
            capture_output=True,
            text=True,
            timeout=timeout_s,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        outcome = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 and done.stdout else None
        if outcome is None:
            last = (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1]
            outcome = {"end": "fault", "why": f"traceback or crash: {last}"}
    except subprocess.TimeoutExpired:
        outcome = {"end": "fault", "why": f"hang: no end within {timeout_s:.0f} s"}
    return {"scene": values, **outcome, "wall_s": time.perf_counter() - began}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--timeout", type=float, default=120.0)
    parser.add_argument("--keep", metavar="FILE.json", help="write every scene and how it ended")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(work(json.loads(sys.stdin.read()))))
        return 0
    rng = random.Random(arguments.seed)
    scenes = [(KINDS[number % 3 == 2], (edge if number % 3 == 2 else inside)(rng)) for number in range(arguments.count)]
    began = time.perf_counter()
    outcomes = []
    with ThreadPoolExecutor(2) as pool:
        for number, outcome in enumerate(pool.map(lambda item: judged(item[1], arguments.timeout), scenes), 1):
            outcomes.append({"kind": scenes[number - 1][0], **outcome})
            if sys.stderr.isatty() or outcome["end"] == "fault":
                print(f"{number}: {outcome['end']}: {outcome['why']}", file=sys.stderr)
    seconds = time.perf_counter() - began
    print(f"seed {arguments.seed}: {len(outcomes)} scenes in {seconds:.0f} s on two processes")
    for kind in KINDS:
        ends = [outcome["end"] for outcome in outcomes if outcome["kind"] == kind]
        print(f"  {kind}: " + ", ".join(f"{ends.count(end)} {end}" for end in sorted(set(ends))))
    for name in ("V", "exponent", "eq7_ratio"):
        pairs = [outcome[name] for outcome in outcomes if name in outcome]
        if pairs:
            shares = sorted(abs(pair["value"] - pair["true"]) / (pair["bar"] + 1e-300) for pair in pairs)
            print(
                f"  {name}: {len(pairs)} compared with finer runs; true error over error bar, median "
                f"{shares[len(shares) // 2]:.2f}, greatest {shares[-1]:.2f}; {sum(share > 1.0 for share in shares)} "
                f"above 1"
            )
    faults = [outcome for outcome in outcomes if outcome["end"] == "fault"]
    for word, name in (
        ("not finite", "NaN"),
        ("hang", "hang"),
        ("traceback", "traceback"),
        ("converged", "wrong answer"),
    ):
        print(f"  {name}: {sum(word in fault['why'] for fault in faults)}")
    for fault in faults:
        print(f"  FAULT {fault['why']}\n        {json.dumps(fault['scene'])}")
    if arguments.keep:
        Path(arguments.keep).write_text(json.dumps(outcomes, indent=1), encoding="utf-8")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
