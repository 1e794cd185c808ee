"""Exudyn spins: a kinematic tree with a hinge between two of its links, by generalised alpha.

The tree has three coordinates, the hinge adds two multipliers: the least system that Exudyn offers.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.metadata import version

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    GenericJoint,
    MarkerKinematicTreeRigid,
    NodeGenericODE2,
    ObjectKinematicTree,
)
from exudyn.rigidBodyUtilities import RotationMatrixZ

from ..spin import CROSS, SHAFT, Spin
from .spinning import Spinner

LEVELS = (60.0, 200.0, 600.0, 2000.0, 6000.0)


def _settings(spin: Spin, count: int, index_2: bool) -> exu.SimulationSettings:
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 10.0 * spin.duration
    settings.linearSolverType = exu.LinearSolverType.EXUdense
    integration = settings.timeIntegration
    integration.endTime = spin.duration
    integration.numberOfSteps = count
    integration.adaptiveStep = False
    integration.generalizedAlpha.useIndex2Constraints = index_2
    integration.generalizedAlpha.useNewmark = index_2
    integration.newton.relativeTolerance = 1e-10
    integration.newton.absoluteTolerance = 1e-12
    return settings


def _system(spin: Spin) -> tuple[exu.SystemContainer, exu.MainSystem, int]:
    container = exu.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * 3,
            initialCoordinates=[0.0] * 3,
            initialCoordinates_t=list(spin.start_speeds),
            numberOfODE2Coordinates=3,
        )
    )
    kinds = exu.JointType
    turns = [np.eye(3), np.eye(3), RotationMatrixZ(spin.beta)]
    inertias = [value * np.eye(3) for value in (SHAFT, CROSS, SHAFT)]
    tree = system.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[kinds.RevoluteX, kinds.RevoluteY, kinds.RevoluteX],
            linkParents=[-1, 0, -1],
            jointTransformations=exu.Matrix3DList(turns),
            jointOffsets=exu.Vector3DList([[0.0] * 3] * 3),
            linkInertiasCOM=exu.Matrix3DList(inertias),
            linkCOMs=exu.Vector3DList([[0.0] * 3] * 3),
            linkMasses=[1.0] * 3,
        )
    )
    cross, shaft = (
        system.AddMarker(
            MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=link, localPosition=[0.0] * 3)
        )
        for link in (1, 2)
    )
    axes = [0, 0, 0, 1, 1, 0]
    system.AddObject(GenericJoint(markerNumbers=[cross, shaft], constrainedAxes=axes))
    system.Assemble()
    return container, system, node


def _prepare(spin: Spin, per_revolution: float, index_2: bool) -> Callable[[], float]:
    container, system, node = _system(spin)
    settings = _settings(spin, round(per_revolution * spin.revolutions), index_2)

    def run() -> float:
        # The container owns the system.
        assert container is not None
        if not exu.SolveDynamic(system, settings, showHints=False, storeSolver=False):
            raise ArithmeticError("the dynamic solver failed")
        return float(system.GetNodeOutput(node, exu.OutputVariableType.Coordinates)[0])

    return run


def methods() -> list[Spinner]:
    """Return the method with constraints of positions, and with constraints of velocities."""
    return [
        Spinner(
            f"Exudyn, {name}",
            version("exudyn"),
            f"kinematic tree, {settings}, dense solver",
            LEVELS,
            partial(_prepare, index_2=index_2),
        )
        for name, settings, index_2 in (
            ("generalised alpha", "index 3, spectral radius 0.9", False),
            ("trapezoidal", "index 2, Newmark", True),
        )
    ]
