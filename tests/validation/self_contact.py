"""Contact of a launched band with itself: a ladder in its stiffness and one in its beads, and what it costs.

    python tests/validation/self_contact.py [--band I] [--strain 1.3] [--half-angle 5] [--beads 280]

The rear overtakes the front of the flying band. A step half as long makes the finger, and with it this contact, four
times as stiff: the overlap is to halve. The places of all beads shortly after the first touch are compared with those
of the stiffest contact, and those of bands with other numbers of beads at the same points along them; later on a
buckled band is chaotic.

A second formulation: the two sides of a symmetric launch touch on the axis, so each may touch a rigid plane along it
instead (LAMMPS' fix wall/region). The cost is the processor time of whole launches in turns, with contact and without.
"""

from __future__ import annotations

import argparse
import math
import resource
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.analysis.contact import crossings
from beadband.analysis.energy import launch_balance
from beadband.analysis.readers import read, read_overlaps, read_watch
from beadband.lammps import files
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_launch
from beadband.model.launch_string import string_launch
from beadband.model.scene import scene_of
from beadband.planning.launch_plan import LaunchPlan, launch_plan_of
from beadband.planning.self_contact import NEAR

AFTER = 0.05
"""Time after the first touch at which shapes are compared, over that touch."""


@dataclass(frozen=True)
class Met:
    """One launch."""

    first_s: float
    overlap: float
    """Deepest, over the thickness."""
    balance: float
    crossed: int
    times_s: np.ndarray
    positions_m: np.ndarray
    cpu_s: float

    def shape_m(self, time_s: float, points: int = 400) -> np.ndarray:
        """Places (points, 2) along the band at a time."""
        later = min(max(int(np.searchsorted(self.times_s, time_s)), 1), len(self.times_s) - 1)
        share = (time_s - self.times_s[later - 1]) / (self.times_s[later] - self.times_s[later - 1])
        frame = (1.0 - share) * self.positions_m[later - 1] + share * self.positions_m[later]
        along, closed = np.linspace(0.0, 1.0, len(frame) + 1), np.concatenate([frame, frame[:1]])
        return np.stack([np.interp(np.linspace(0.0, 1.0, points), along, axis) for axis in closed.T], axis=1)


def mirrored(plan: LaunchPlan, text: str, stiffness_n_m: float) -> str:
    """The script of a launch whose sides touch a plane on the axis, but for the beads round its tip and its front.

    Two beads at the height y push each other by k (h - 2 y): the plane pushes each by 2 k (h/2 - y).
    """
    half, front = 0.5 * plan.scene.band.thickness_m, plan.beads // 2 + 1
    round_front = math.ceil(0.5 * NEAR * plan.scene.band.thickness_m / plan.strand.spacing_m)
    lines = []
    for name, first, last, way in (
        ("up", 20, front - round_front, 1),
        ("low", front + round_front, plan.beads - 18, -1),
    ):
        lines += [
            f"group {name} id {first}:{last}",
            f"region {name} plane 0 0 0 0 {way} 0 units box",
            f"fix {name} {name} wall/region {name} harmonic {stiffness_n_m} 1.0 {half}",
        ]
    return text.replace("fix             move all nve", "\n".join([*lines, "fix move all nve"]))


def launched(values: dict[str, Any], mirror: bool = False) -> Met:
    plan = launch_plan_of(scene_of({"until": "launch", "for": "speed", "finger": "clears", "frames": 400, **values}))
    with files.scratch() as folder:
        ring, support = plan.held()
        write_launch(folder, plan, ring, support)
        if mirror:
            script = folder / files.LAUNCH_SCRIPT
            script.write_text(mirrored(plan, script.read_text(), 0.25 * support.stiffness_n_m))
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        run_script(folder, files.LAUNCH_SCRIPT)
        cpu = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
        frames, watch = read(folder / files.TRAJECTORY), read_watch(folder / files.FINGER)
        overlaps = read_overlaps(folder / files.TOUCH) if plan.self_contact else None
    first = (overlaps.first_step or 0) if overlaps else 0
    return Met(
        first * plan.timestep_s,
        float(overlaps.overlap_m.max(initial=0.0)) / plan.scene.band.thickness_m if overlaps else 0.0,
        launch_balance(watch, plan.timestep_s).error,
        sum(crossings(frame) > 0 for frame in frames.positions_m),
        frames.times_s(plan.timestep_s),
        frames.positions_m,
        cpu,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--band", default="I")
    parser.add_argument("--strain", type=float, default=1.3)
    parser.add_argument("--half-angle", type=float, default=5.0)
    parser.add_argument("--beads", type=int, default=280)
    given = parser.parse_args()
    bare = {"band": given.band, "strain": given.strain, "half_angle_deg": given.half_angle}
    thickness, free_s = scene_of(bare).band.thickness_m, string_launch(scene_of(bare)).finger_free_s
    scene = {**bare, "beads": given.beads, "flight_s": free_s}
    step = launch_plan_of(scene_of({**scene, "until": "launch", "for": "speed", "finger": "clears"})).timestep_s
    ladder = [launched({**scene, "timestep_s": step / part}) for part in (1, 2, 4)]
    time_s = ladder[-1].first_s * (1.0 + AFTER)
    print("stiffness   first touch   overlap   balance   frames crossed   from the stiffest")
    for part, met in zip((1, 2, 4), ladder, strict=True):
        off = np.abs(met.shape_m(time_s) - ladder[-1].shape_m(time_s)).max() / thickness
        print(f"x {part**2:<9d} {met.first_s * 1e3:8.4f} ms {met.overlap:9.3%} {met.balance:9.1e} {met.crossed:10d} "
              f"{off:18.4f} h")  # fmt: skip
    print("beads       first touch   overlap   balance   frames crossed   from the finest")
    counts = [given.beads // 2, given.beads, 2 * given.beads]
    finer = [launched({**scene, "beads": beads}) for beads in counts]
    for beads, met in zip(counts, finer, strict=True):
        off = np.abs(met.shape_m(time_s) - finer[-1].shape_m(time_s)).max() / thickness
        print(f"{beads:<11d} {met.first_s * 1e3:8.4f} ms {met.overlap:9.3%} {met.balance:9.1e} {met.crossed:10d} "
              f"{off:18.4f} h")  # fmt: skip
    # Band IV's front folds in on the axis: there its two sides touch.
    folds = {"band": "IV", "strain": 0.476, "half_angle_deg": 14.0, "beads": 800}
    pairs, plane = launched(folds), launched({**folds, "self_contact": "off"}, mirror=True)
    none, wide = launched({**folds, "self_contact": "off"}), scene_of({"band": "IV"}).band.thickness_m
    print("IV          from pairs: a plane on the axis   no contact")
    for later_s in (0.5e-3, 1.5e-3, 2.5e-3):
        shape = pairs.shape_m(pairs.first_s + later_s, 800)
        off, apart = (np.abs(met.shape_m(pairs.first_s + later_s, 800) - shape).max() / wide for met in (plane, none))
        print(f"+{later_s * 1e3:.1f} ms {off:26.4f} h {apart:19.4f} h")
    turns = [[launched({**scene, "self_contact": contact}).cpu_s for contact in ("on", "off")] for _ in range(3)]
    on, off_s = (min(turn[i] for turn in turns) for i in (0, 1))
    print(f"a launch with contact took {on / off_s:.2f} times the processor time of one without")


if __name__ == "__main__":
    main()
