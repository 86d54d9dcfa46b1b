"""Large rings: seconds to hold, to write and to read them, and the cost of a bead and step on one rank and on two.

    python tests/validation/large_ring.py [--beads 1000 20000 200000] [--steps 1000] [--ranks 1 2]

Every size runs the same number of steps of release.in by plain lmp, without frames of the ring. The steps are repeated
and the quickest repeat counts: other work on the machine makes a run slower, never quicker.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import tempfile
import time
from pathlib import Path

from beadband.lammps.engine import program
from beadband.lammps.scripts import write_ring
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import hold


def released(folder: Path, steps: int, ranks: int) -> tuple[float, float]:
    """Seconds in which LAMMPS reads the data file, and of its loop over the steps."""
    command = [str(program("lmp")), "-in", "release.in", "-screen", "none", "-log", "log.lammps", "-nocite"]
    command += ["-var", "steps", str(steps), "-var", "rear_steps", str(steps)]
    if ranks > 1:
        command = [str(program("mpirun")), "-np", str(ranks), *command]
    subprocess.run(command, cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"}, check=True, capture_output=True)
    log = (folder / "log.lammps").read_text(encoding="utf-8")
    loops = re.findall(r"Loop time of (\S+) on", log)
    read = re.search(r"read_data CPU = (\S+) seconds", log)
    assert read
    return float(read[1]), float(loops[-1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beads", type=int, nargs="+", default=[1000, 20_000, 200_000])
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--ranks", type=int, nargs="+", default=[1])
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    print("beads  ranks  hold s  net force/T  write s  read s  loop s  us per bead and step")
    for beads in options.beads:
        plan = plan_of(scene_of({"beads": beads}))
        start = time.perf_counter()
        ring = hold(plan)
        held = time.perf_counter() - start
        with tempfile.TemporaryDirectory() as place:
            start = time.perf_counter()
            write_ring(Path(place), plan, ring, pictures=False)
            written = time.perf_counter() - start
            for ranks in options.ranks:
                runs = [released(Path(place), options.steps, ranks) for _ in range(options.repeats)]
                read, loop = min(run[0] for run in runs), min(run[1] for run in runs)
                cost = 1e6 * loop / (beads * options.steps)
                print(
                    f"{beads:6d}  {ranks:5d}  {held:6.2f}  {ring.net_force:11.1e}  {written:7.2f}  {read:6.2f}  "
                    f"{loop:6.2f}  {cost:.3f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
