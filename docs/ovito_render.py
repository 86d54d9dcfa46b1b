"""Picture of a run by OVITO, without a screen: python ovito_render.py DIR OUT.png [FRAME] [stretching|bending]"""

from __future__ import annotations

import sys

import numpy as np
from ovito.io import import_file
from ovito.modifiers import ColorCodingModifier, LoadTrajectoryModifier
from ovito.pipeline import Pipeline
from ovito.vis import ColorLegendOverlay, TachyonRenderer, Viewport


def load(folder: str, frame: int = -1, column: str = "stretching") -> tuple[Pipeline, ColorCodingModifier, int]:
    """Pipeline of a run with beads coloured by an energy, its colours, and the frame (negative: from the end)."""
    pipeline = import_file(f"{folder}/band.data", atom_style="angle")  # beads and bonds
    frames = LoadTrajectoryModifier()
    frames.source.load(f"{folder}/trajectory.lammpstrj")  # where the beads go, their radius and their energies
    pipeline.modifiers.append(frames)

    frame %= pipeline.num_frames
    energy = np.asarray(pipeline.compute(frame).particles[column])
    colours = ColorCodingModifier(
        property=column,
        gradient=ColorCodingModifier.Viridis(),
        start_value=0.0,
        end_value=1.3 * float(np.quantile(energy, 0.98)),  # its palest colours would be lost on white
    )
    pipeline.modifiers.append(colours)
    return pipeline, colours, frame


def render(folder: str, out: str, frame: int = -1, column: str = "stretching") -> None:
    """Write the picture of a frame."""
    pipeline, colours, frame = load(folder, frame, column)
    scene = pipeline.compute(frame)
    scene.particles.bonds.vis.enabled = False  # beads overlap: they look like a tube already
    scene.cell.vis.enabled = False  # the box is there for LAMMPS
    pipeline.add_to_scene()

    view, size = Viewport(type=Viewport.Type.Top), (1000, 480)
    view.zoom_all(size)
    legend = ColorLegendOverlay(
        modifier=colours, title=f"{column} (J per bead)", format_string="%.2g", legend_size=0.28, offset_y=0.03
    )
    view.overlays.append(legend)
    view.render_image(
        filename=out, size=size, frame=frame, background=(1.0, 1.0, 1.0), renderer=TachyonRenderer(shadows=False)
    )
    pipeline.remove_from_scene()


if __name__ == "__main__":
    given = sys.argv[1:]
    render(given[0], given[1], int(given[2]) if len(given) > 2 else -1, given[3] if len(given) > 3 else "stretching")
