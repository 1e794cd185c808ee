"""Exudyn: rigid bodies in generic joints, solved statically for every position of the drive."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.metadata import version

import exudyn as exu
import numpy as np
from exudyn.itemInterface import GenericJoint, MarkerBodyRigid, ObjectGround, Torque
from exudyn.rigidBodyUtilities import (
    InertiaCuboid,
    RotationMatrix2EulerParameters,
    RotationMatrixX,
    RotationMatrixY,
    RotationMatrixZ,
)

from .common import Method, pin_angles


def _rotations(beta: float, phi: float) -> list[np.ndarray]:
    """Return the rotations of input shaft, cross and output shaft with the loop closed."""
    theta, psi = (float(angle[0]) for angle in pin_angles(beta, np.array([phi])))
    first = RotationMatrixX(phi)
    second = first @ RotationMatrixY(theta)
    return [first, second, second @ RotationMatrixZ(psi)]


def _settings(tight: bool) -> exu.SimulationSettings:
    """Return the settings of the static solver, with its default or tight tolerances."""
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.staticSolver.numberOfLoadSteps = 1
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.numericalDifferentiation.forODE2 = False
    settings.linearSolverType = exu.LinearSolverType.EXUdense
    if tight:
        settings.staticSolver.newton.relativeTolerance = 1e-14
        settings.staticSolver.newton.absoluteTolerance = 1e-13
    return settings


def _prepare(beta: float, phi: np.ndarray, tight: bool) -> Callable[[], np.ndarray]:
    container = exu.SystemContainer()
    system = container.AddSystem()
    ground = system.AddMarker(MarkerBodyRigid(bodyNumber=system.AddObject(ObjectGround())))
    rotations = _rotations(beta, float(phi[0]))
    reference = np.array([RotationMatrix2EulerParameters(matrix) for matrix in rotations])
    markers = []
    for matrix in rotations:
        body = system.CreateRigidBody(
            inertia=InertiaCuboid(1000.0, [0.1, 0.1, 0.1]),
            nodeType=exu.NodeType.RotationEulerParameters,
            referencePosition=[0.0, 0.0, 0.0],
            referenceRotationMatrix=matrix,
            returnDict=True,
        )
        markers.append(system.AddMarker(MarkerBodyRigid(bodyNumber=body["bodyNumber"])))
    shaft_in, cross, shaft_out = markers

    def hinge(first: int, second: int, axes: list[int], turn: np.ndarray) -> int:
        return system.AddObject(
            GenericJoint(
                markerNumbers=[first, second],
                constrainedAxes=axes,
                rotationMarker0=turn,
            )
        )

    drive = hinge(ground, shaft_in, [1] * 6, np.eye(3))
    hinge(shaft_in, cross, [1, 1, 1, 1, 0, 1], np.eye(3))
    hinge(cross, shaft_out, [1, 1, 1, 1, 1, 0], np.eye(3))
    bearing = hinge(ground, shaft_out, [0, 0, 0, 0, 1, 1], RotationMatrixZ(beta))
    axis = [float(np.cos(beta)), float(np.sin(beta)), 0.0]
    system.AddLoad(Torque(markerNumber=shaft_out, loadVector=[-value for value in axis]))
    system.Assemble()
    settings = _settings(tight)
    solver = exu.MainSolverStatic()
    torque = exu.OutputVariableType.TorqueLocal
    start = np.zeros((3, 7))

    def run() -> np.ndarray:
        result = np.empty((len(phi), 4))
        before = reference
        for sample, position in enumerate(phi):
            system.SetObjectParameter(drive, "rotationMarker0", RotationMatrixX(position))
            parameters = np.array(
                [RotationMatrix2EulerParameters(matrix) for matrix in _rotations(beta, position)]
            )
            # Both signs are the same rotation; the solver needs the nearer one.
            parameters *= np.sign(np.sum(parameters * before, axis=1, keepdims=True))
            before, start[:, 3:] = parameters, parameters - reference
            system.systemData.SetODE2Coordinates(start.ravel(), exu.ConfigurationType.Initial)
            if not solver.SolveSystem(system, settings):
                raise ArithmeticError(f"no static solution at {position}")
            first = system.GetObjectOutput(drive, torque)
            last = system.GetObjectOutput(bearing, torque)
            result[sample] = first[0], np.hypot(first[1], first[2]), -1.0, np.hypot(*last[1:])
        return result

    return run


def methods() -> list[Method]:
    """Return default and tight tolerances."""
    installed = version("exudyn")
    return [
        Method(
            f"Exudyn, static, {name}",
            installed,
            f"MainSolverStatic, Euler parameters, {name} Newton tolerance; "
            "starts from the loop as closed by the user",
            partial(_prepare, tight=name == "tight"),
        )
        for name in ("default", "tight")
    ]
