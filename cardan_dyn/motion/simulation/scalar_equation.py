"""Scalar equation: the motion of a mechanism with one free coordinate under any forces.

Inertia, force and velocity ratios are functions of the drive's position, tabulated once as Fourier
series. What is left to integrate is I φ̈ + I' φ̇² / 2 = Q(φ, φ̇, t).
"""

from __future__ import annotations

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.samples import Targets
from ...core.results.collect import motion_at
from ...kit.arrays import ROUNDED, Array
from ...kit.periodic import Fourier
from .energy_functions import EnergyFunctions, NotSuitableError
from .forces import Forces, State
from .integration import Equations
from .turning_model import turning_model


class ScalarEquation(Equations):
    """The equation of motion of the only drive."""

    def __init__(
        self,
        solver: ProblemSolver,
        functions: EnergyFunctions,
        forces: Forces,
    ) -> None:
        """Tabulate what the equation needs.

        Args:
            solver: of the scene.
            functions: inertia, and the force of the weight alone.
            forces: all else that acts.
        """
        self._forces = forces
        self._model = turning_model(solver.problem.mechanism)
        self._data = self._model.createData()
        self._period = 2.0 * np.pi / functions.inertia.frequency
        self.turns, self.evaluations = np.zeros(2), 0
        self._size = solver.problem.mechanism.coordinates.size
        self._table = _table(solver, functions)
        self._energy = Fourier(self._table.coefficients[:3], self._table.frequency)

    def _at(self, position: float, turns: float) -> tuple[Array, Array, Array]:
        """Return inertia, its slope and force `(3,)`, coordinates and velocity ratios."""
        values = self._table.at(position)
        if turns:
            values += self._table.slope * (2.0 * np.pi * turns)
        return values[:3], values[3 : 3 + self._size], values[3 + self._size :]

    def derivative(self, time: float, y: Array) -> Array:
        """Return the derivative of position and speed `(2,)`."""
        self.evaluations += 1
        position, speed = y.tolist()
        if self._forces.is_nothing:
            inertia, slope, force = self._energy.at(position)
        else:
            (inertia, slope, force), x, ratios = self._at(position, float(self.turns[0]))
            v = ratios * speed
            force += ratios @ self._forces.efforts(self._model, self._data, time, x, v)
        push = force - 0.5 * slope * speed * speed
        return np.array([speed, push / inertia])

    def wrap(self, y: Array) -> Array:
        """Return a row without whole periods of the mechanism, which `turns` counts as angles."""
        periods = np.round(y[0] / self._period)
        if periods:
            y = np.array([y[0] - periods * self._period, y[1]])
            self.turns = self.turns + np.array([periods * self._period / (2.0 * np.pi), 0.0])
        return y

    def read(self, y: Array, turns: Array) -> tuple[Array, Array]:
        """Return the coordinates, all turns counted, and velocities of a row that forces read."""
        _, x, ratios = self._at(float(y[0]), float(turns[0]))
        return x, ratios * y[1]

    def named(self, y: Array, turns: Array) -> State:
        """Return positions and speeds by name of a row."""
        return self._forces.names.of(*self.read(y, turns))


def _table(solver: ProblemSolver, functions: EnergyFunctions) -> Fourier:
    """Return inertia, its slope, force, joint positions and velocity ratios over the position."""
    inertia, force = functions.inertia, functions.force
    count, period = inertia.coefficients.shape[1], 2.0 * np.pi / inertia.frequency
    grid = period / (2 * count) * np.arange(2 * count + 1)[:, None]
    motion = motion_at(solver, Targets.of_positions(grid), 1.0)
    x = motion.rows
    slope = np.concatenate([(x[-1] - x[0]) / period, np.zeros(motion.v.shape[1])])
    joints = Fourier.of((np.concatenate([x, motion.v], axis=1) - grid * slope)[:-1].T, period)
    # Relative to the positions themselves, of which the linear part was taken off.
    sizes = np.max(np.abs(joints.coefficients), axis=1), np.max(np.abs(x), axis=0, initial=0.0)
    unresolved = joints.tail() * sizes[0]
    greatest = np.concatenate([sizes[1], np.max(np.abs(motion.v), axis=0)])
    if np.any(unresolved > max(ROUNDED, functions.error) * greatest):
        raise NotSuitableError("joint positions are less even than the inertia")
    rows = [inertia.coefficients, inertia.derivative().coefficients, force.coefficients]
    table = np.concatenate([*rows, joints.coefficients])
    return Fourier(table, inertia.frequency, np.concatenate([np.zeros(3), slope]))
