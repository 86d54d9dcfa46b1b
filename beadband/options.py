"""The options of a scene, once: as flags of the command line. Pure standard library, so that --help is quick."""

from __future__ import annotations

import argparse

from beadband.band import CATALOGUE
from beadband.scene import CHOICES

_FLAGS: tuple[tuple[str, str, type, str, str], ...] = (
    # key, flag, type, placeholder, help
    ("strain", "--strain", float, "X", "uniform strain of the held band (0.476)"),
    ("half_angle_deg", "--half-angle", float, "DEG", "half-angle of the wedge (14)"),
    ("tolerance", "--tolerance", float, "X", "relative error wanted of the rebound speed (0.005)"),
    ("bending_scale", "--bending-scale", float, "X", "factor on EI; 0 leaves bending out (1)"),
    ("beads", "--beads", int, "N", "beads of the whole ring, instead of the plan's"),
    ("timestep_s", "--timestep", float, "S", "time step, instead of the plan's"),
    ("loss_time_s", "--loss-time", float, "S", "loss time of the material, instead of a numerical one"),
    ("flight_s", "--flight", float, "S", "of a launch whose finger clears: time to fly on (0)"),
    ("frames", "--frames", int, "N", "frames of the whole ring in the trajectory (60)"),
    ("circumference_m", "--circumference", float, "M", "circumference of the unstretched band"),
    ("width_m", "--width", float, "M", "width of a rectangular section"),
    ("thickness_m", "--thickness", float, "M", "thickness, or diameter of a circular section"),
    ("density_kg_m3", "--density", float, "KG_M3", "density"),
    ("modulus_pa", "--modulus", float, "PA", "Young's modulus E of the table"),
    ("c10_pa", "--c10", float, "PA", "Mooney-Rivlin coefficient C10"),
    ("c01_pa", "--c01", float, "PA", "Mooney-Rivlin coefficient C01"),
)
_CHOICE_HELP = {
    "law": "material law (mooney-rivlin)",
    "until": "end of the run (release)",
    "for": "what the plan must get right (curvature)",
    "bending_modulus": "modulus in EI: E of the table, or E0 at rest (table)",
    "finger": "of a launch: it stays, or clears once it carries nothing (stays)",
}


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Give a command the options of a scene; unset ones stay out of the result."""
    group = parser.add_argument_group("scene")
    group.add_argument("--scene", metavar="FILE.toml", help="read the scene from a file; flags win over it")
    group.add_argument("--band", metavar="NAME", default=argparse.SUPPRESS, help=f"{', '.join(CATALOGUE)} (III)")
    for key, choices in CHOICES.items():
        group.add_argument(
            "--" + key.replace("_", "-"),
            dest=key,
            choices=choices,
            default=argparse.SUPPRESS,
            help=_CHOICE_HELP[key],
        )
    for key, flag, kind, placeholder, text in _FLAGS:
        group.add_argument(flag, dest=key, type=kind, metavar=placeholder, default=argparse.SUPPRESS, help=text)


def add_grid_options(parser: argparse.ArgumentParser) -> None:
    """Give a command the options of a scene, each a value, a list A,B,C or a range FIRST:LAST:COUNT."""
    group = parser.add_argument_group("grid", "each a value, a list A,B,C, or a range FIRST:LAST:COUNT with both ends")
    group.add_argument("--grid", metavar="FILE.toml", help="read the grid from a file; flags win over it")
    group.add_argument("--band", metavar="VALUES", default=argparse.SUPPRESS, help=f"{', '.join(CATALOGUE)} (III)")
    for key, choices in CHOICES.items():
        if key != "until":
            flag, text = "--" + key.replace("_", "-"), ", ".join(choices)
            group.add_argument(flag, dest=key, metavar="VALUES", default=argparse.SUPPRESS, help=text)
    for key, flag, _, _, text in _FLAGS:
        if key != "frames":
            group.add_argument(flag, dest=key, metavar="VALUES", default=argparse.SUPPRESS, help=text)


def grid_values(arguments: argparse.Namespace) -> dict[str, object]:
    """Values of the grid from its file, if there is one, and the flags over them."""
    from beadband.sweeping.grid import SWEPT, read_grid

    values = read_grid(arguments.grid) if arguments.grid is not None else {}
    values.update({key: value for key, value in vars(arguments).items() if key in SWEPT})
    return values


def scene_values(arguments: argparse.Namespace) -> dict[str, object]:
    """Values of the scene from its file, if there is one, and the flags over them."""
    from beadband.scenefile import read_scene

    values = read_scene(arguments.scene) if arguments.scene is not None else {}
    given = vars(arguments)
    keys = ["band", *CHOICES, *(flag[0] for flag in _FLAGS)]
    chosen = {key: given[key] for key in keys if key in given}
    if chosen:
        # What a plan chose for the scene of the file need not suit the one that the flags make of it.
        planned = values.pop("planned", None)
        for key in planned if isinstance(planned, list) else ():
            values.pop(key, None)
    values.update(chosen)
    return values
