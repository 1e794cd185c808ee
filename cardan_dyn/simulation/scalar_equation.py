"""Scalar equation: the motion of a mechanism with one free coordinate under any forces.

Inertia, force and velocity ratios are functions of the drive's position, tabulated once as Fourier
series. What is left to integrate is I φ̈ + I' φ̇² / 2 = Q(φ, φ̇, t).
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..problem.samples import Targets
from ..results.collect import motion_at
from .constrained_model import ConstrainedModel
from .energy_functions import EnergyFunctions, NotSuitableError
from .forces import Forces, Named, StateNames
from .fourier import Fourier

_RESOLVED = 1e-10
"""Greatest of the last harmonics of a joint position, relative to the position, or of a ratio."""


class ScalarEquation:
    """The equation of motion of the only drive."""

    def __init__(
        self,
        solver: ProblemSolver,
        functions: EnergyFunctions,
        forces: Forces,
        model: ConstrainedModel,
    ) -> None:
        """Tabulate what the equation needs.

        Args:
            solver: of the scene.
            functions: inertia, and the force of the weight alone.
            forces: all else that acts.
            model: whose configurations the forces know.
        """
        self._model, self._forces = model, forces
        self._names = StateNames(solver.problem.mechanism.coordinates)
        self._period = 2.0 * np.pi / functions.inertia.frequency
        self.turns = np.zeros(2)
        inertia, force = functions.inertia, functions.force
        both = np.zeros((3, max(inertia.coefficients.shape[1], 1)), dtype=complex)
        both[0], both[1] = inertia.coefficients[0], inertia.derivative().coefficients[0]
        both[2] = force.coefficients[0]
        self._table = Fourier(both, inertia.frequency).shortened(1e-18)
        self._motion = _motion_table(solver, inertia.frequency, both.shape[1])

    def derivative(self, time: float, y: Array) -> Array:
        """Return the derivative of position and speed `(2,)`."""
        position, speed = y
        inertia, slope, force = self._table.at(position)
        x, ratios = self._motion.joints(position, float(self.turns[0]))
        model = self._model
        efforts = self._forces.efforts(model.model, model.data, time, x, ratios * speed)
        push = force + ratios @ efforts - 0.5 * slope * speed**2
        return np.array([speed, push / inertia])

    def restored(self, time: float, y: Array) -> Array:
        """Return a row as it is: it obeys no constraints but the tables'."""
        return y

    def wrap(self, y: Array) -> Array:
        """Return a row without whole periods of the mechanism, which `turns` counts as angles."""
        periods = np.round(y[0] / self._period)
        if periods:
            y = np.array([y[0] - periods * self._period, y[1]])
            self.turns = self.turns + np.array([periods * self._period / (2.0 * np.pi), 0.0])
        return y

    def named(self, y: Array, turns: Array) -> tuple[Named, Named]:
        """Return positions and speeds by name of a row."""
        x, ratios = self._motion.joints(y[0], float(turns[0]))
        return self._names.positions(x), self._names.speeds(ratios * y[1])


class _JointTable:
    """Positions and velocity ratios of all joints over the drive's position."""

    def __init__(self, functions: Fourier, size: int) -> None:
        self._functions, self._size = functions, size

    def joints(self, position: float, turns: float) -> tuple[Array, Array]:
        """Return coordinates `(size,)` and velocity ratios `(nv,)` at a position of the drive.

        Args:
            position: within some periods [rad].
            turns: of the drive, that it lacks.
        """
        values = self._functions.at(position) + self._functions.slope * 2.0 * np.pi * turns
        return values[: self._size], values[self._size :]


def _motion_table(solver: ProblemSolver, frequency: float, count: int) -> _JointTable:
    """Return the joint positions and velocity ratios over the drive's position.

    Raises:
        NotSuitableError: so many positions do not resolve them.
    """
    period = 2.0 * np.pi / frequency
    number = 2 * count
    grid = period / number * np.arange(number + 1)[:, None]
    motion = motion_at(solver, Targets.of_positions(grid), np.ones_like(grid), np.zeros_like(grid))
    x = motion._x + 2.0 * np.pi * motion._turns
    rows = np.concatenate([x, motion.v], axis=1)
    slope = np.concatenate([(x[-1] - x[0]) / period, np.zeros(motion.v.shape[1])])
    table = Fourier.of((rows[:-1] - grid[:-1] * slope).T, period)
    sizes = np.max(np.abs(table.coefficients), axis=1), np.max(np.abs(rows), axis=0)
    if np.any(table.tail() * sizes[0] > _RESOLVED * sizes[1]):
        raise NotSuitableError("joint positions are not resolved by the positions of the inertia")
    return _JointTable(Fourier(table.coefficients, frequency, slope), x.shape[1])
