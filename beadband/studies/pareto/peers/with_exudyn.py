"""Exudyn: ANCF cable elements for one leg, an implicit generalized-alpha method."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Any

import numpy as np

from beadband.errors import RunError
from beadband.model.scene import Scene
from beadband.studies.pareto.peers.finite_elements import rod_of
from beadband.studies.pareto.peers.protocol import SAMPLES, Trace, end_s

STEPS_PER_ELEMENT = 4
SPECTRAL_RADIUS = 0.7
"""Damping of the fastest waves by the time stepping: 1 none, 0 all."""


class Exudyn:
    """ANCF cables are linear in stretch and curvature; another law would be a Python function at every point."""

    name = "Exudyn"
    package: str | None = "exudyn"
    laws: tuple[str, ...] | None = ("linear",)
    ladder = (12, 25, 50, 100, 200)
    quick = (12, 25, 50)
    note = "one leg to the finger, ANCFCable2D (linear law alone), generalized alpha, four steps an element"

    def run(self, scene: Scene, elements: int) -> Trace:
        """Release one leg whose tip keeps to the mirror axis, at right angles to it."""
        import exudyn
        from exudyn import itemInterface as items

        from beadband.studies.pareto.peers import elements as exact

        rod = rod_of(scene, elements)
        length = scene.wedge.reference_leg_m
        places = np.linspace(0.0, length, elements + 1)
        position, slope = exact.held_shape(rod, 1.0 + scene.strain, scene.half_angle_rad, places)
        start = time.perf_counter()
        container = exudyn.SystemContainer()
        mbs = container.AddSystem()
        stiffness = rod.area_m2 * float(rod.tangent_pa(np.array(1.0)))
        nodes = []
        for s, r, t in zip(places, position, slope, strict=True):
            reference = np.array([s, 0.0, 1.0, 0.0])
            nodes.append(
                mbs.AddNode(
                    items.NodePoint2DSlope1(
                        referenceCoordinates=reference.tolist(),
                        initialCoordinates=(np.concatenate([r, t]) - reference).tolist(),
                        initialVelocities=[0.0] * 4,
                    )
                )
            )
        for first, second in pairwise(nodes):
            mbs.AddObject(
                items.ObjectANCFCable2D(
                    length=length / elements,
                    massPerLength=rod.area_m2 * rod.density_kg_m3,
                    bendingStiffness=rod.bending_stiffness_n_m2,
                    axialStiffness=stiffness,
                    nodeNumbers=[first, second],
                    useReducedOrderIntegration=0,
                )
            )
        ground = mbs.AddNode(items.NodePointGround())
        still = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
        # The tip keeps its y and its upright slope, the end all four; offsets hold what the node has at the start.
        held = [(0, 1), (0, 2), *((elements, i) for i in range(4))]
        for node, coordinate in held:
            value = np.concatenate([position[node], slope[node]])[coordinate]
            offset = float(value - [places[node], 0.0, 1.0, 0.0][coordinate])
            marker = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[node], coordinate=coordinate))
            mbs.AddObject(items.CoordinateConstraint(markerNumbers=[still, marker], offset=offset))
        every = end_s(scene) / SAMPLES
        sensors = [
            mbs.AddSensor(
                items.SensorNode(
                    nodeNumber=nodes[i], storeInternal=True, outputVariableType=exudyn.OutputVariableType.Coordinates
                )
            )
            for i in (0, 1)
        ]
        mbs.Assemble()
        settings: Any = exudyn.SimulationSettings()
        stepping = settings.timeIntegration
        stepping.numberOfSteps = STEPS_PER_ELEMENT * elements
        stepping.endTime = end_s(scene)
        stepping.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
        stepping.newton.useModifiedNewton = True
        stepping.verboseMode = 0
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = min(every, end_s(scene) / stepping.numberOfSteps)
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        settings.parallel.numberOfThreads = 1
        settings.show.computationTime = False
        ready = time.perf_counter()
        if not mbs.SolveDynamic(settings, showHints=False):
            raise RunError("Exudyn's solver did not finish")
        done = time.perf_counter()
        tip, next_to = (mbs.GetSensorStoredData(sensor) for sensor in sensors)
        times = tip[:, 0]
        x = tip[:, 1] + places[0]
        size = length / elements
        # x'' of a cubic element at its end, over y' there, as the curvature on the axis.
        second = (
            6.0 * (next_to[:, 1] + places[1] - x) / size - 4.0 * (tip[:, 3] + 1.0) - 2.0 * (next_to[:, 3] + 1.0)
        ) / size
        return Trace(times, x, second / tip[:, 4], done - ready, done - start)
