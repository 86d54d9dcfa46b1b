"""A first release from Python: run it, read it, compare it, look at it. python docs/tutorial.py [DIR]

Writes the run into DIR (default: tutorial-run, which must be new) and the picture speed.png beside it.
"""

from __future__ import annotations

import json
import sys
import warnings
from pathlib import Path

import numpy as np

import beadband

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "tutorial-run")

# 1. A scene is given by what differs from the default one: band III, strain 0.476, half-angle 14 degrees.
scene = beadband.scene_of({"band": "II", "strain": 0.6})
run = beadband.run(scene, folder)
print(f"rebound speed {run.speed:.2f} m/s from {run.plan.beads} beads")  # value and whole error

# 2. Everything that was found stands in results.json, in SI units, with a dictionary in docs/results.md.
results = json.loads((folder / "results.json").read_text())
speed, error = results["rebound_speed_m_s"], results["rebound_speed_error_m_s"]
string = results["string_speed_m_s"]  # the exact answer of a string without bending stiffness
print(f"V = {speed:.3f} +/- {error:.3f} m/s, string limit {string:.3f} m/s: {speed / string - 1:+.2%}")

# 3. The speed over time.
import matplotlib  # noqa: E402

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

series = results["series"]
figure, axes = pyplot.subplots(figsize=(6.4, 3.6), layout="constrained")
axes.plot(np.array(series["t_s"]) * 1e3, series["tip_speed_m_s"], label="rear tip")
axes.axhline(string, linestyle="--", color="grey", label="string limit")
axes.set(xlabel="time (ms)", ylabel="speed (m/s)", ylim=(0.0, 1.3 * string))
axes.legend()
figure.savefig(folder.parent / "speed.png", dpi=120)

# 4. The same from the dump, with MDAnalysis. It counts positions from the corner of the box, which stays where it is,
# and keeps them in single precision: good enough for a speed (for curvatures see 'beadband analyze').
import MDAnalysis  # noqa: E402

warnings.simplefilter("ignore")  # it guesses elements and masses, which nothing here uses
universe = MDAnalysis.Universe(
    str(folder / "trajectory.lammpstrj"), topology_format="LAMMPSDUMP", format="LAMMPSDUMP", dt=1.0
)
tip = universe.select_atoms("index 0")
steps, x = np.array([(frame.data["step"], tip.positions[0, 0]) for frame in universe.trajectory]).T
# All frames but the first are averages over the interval before them: their time is its middle.
every = steps[1] - steps[0]
times = (steps - (every - 1) / 2) * results["scene"]["timestep_s"]
late = (times > 0.4 * results["front_arrival_s"]) & (times < 0.85 * results["front_arrival_s"])
again = np.polyfit(times[late], x[late], 1)[0]
print(f"from the dump through MDAnalysis: V = {again:.3f} m/s")
