"""Energy functions: inertia and force of a mechanism with one drive, over its position."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.samples import Targets
from ...kit.arrays import EPS, NOTHING, Array
from ...kit.errors import CardanError
from ...kit.frozen import read_only
from ...kit.periodic import Fourier
from .forces import Forces
from .turning_model import turning_model

_FEWEST, _MOST = 64, 8192
"""Positions per period: the first number, which is doubled, and the greatest."""
_ROUNDING = 20.0
"""Errors of efforts, in eps times their condition number, below which coefficients are rounding."""
_COMPARED = 8
"""Further positions at which functions that repeat within the period are seen to do so."""


class NotSuitableError(Exception):
    """A method of simulation does not suit a scene; another one is taken. Never leaves here.

    Attributes:
        note: what is to be known of the scene whichever method is taken; mostly empty.
    """

    def __init__(self, reason: str, note: str = "") -> None:
        super().__init__(reason)
        self.note = note


class EnergyFunctions(NamedTuple):
    """Inertia and force along the only drive.

    Attributes:
        inertia: `I(φ)` [kg·m² or kg].
        force: `Q(φ)` of weight, loads and springs at rest [N·m or N].
        error: of both, relative to their greatest values.
    """

    inertia: Fourier
    force: Fourier
    error: float


def energy_functions(solver: ProblemSolver, forces: Forces | None = None) -> EnergyFunctions:
    """Return inertia and force over a period of the drive.

    The mechanism at position φ moves with the kinetic energy I(φ) φ̇² / 2, and
    I φ̈ + I' φ̇² / 2 = Q. Those of the weight alone follow from where loops are closed and where the
    start is, and are kept for other scenes of the mechanism.

    Args:
        solver: of a scene with one drive.
        forces: constant loads and springs that belong to the force; the weight alone if None.

    Raises:
        NotSuitableError: the drive does not turn through, or the functions are too uneven.
    """
    if forces is not None and not forces.is_nothing:
        return _found(solver, forces)
    problem, assembly = solver.problem, solver.assembly
    key = assembly.kinematics.key, assembly.start.tobytes(), problem.gravity.tobytes()
    kept = problem.mechanism.kept
    return kept.of("energy functions", key, lambda: _found(solver, None))


def _found(solver: ProblemSolver, forces: Forces | None) -> EnergyFunctions:
    """See `energy_functions`."""
    try:
        period = solver.assembly.period()
    except CardanError as error:
        raise NotSuitableError(str(error)) from error
    if period is None:
        raise NotSuitableError("the mechanism does not come back to itself")
    energies = _Energies(solver, forces)
    if solver.problem.elements and forces is not None:
        ends = energies.at(np.array([0.0, period]))[1]
        if abs(ends[1] - ends[0]) > NOTHING * np.max(np.abs(ends)):
            raise NotSuitableError("springs wind up as the drive turns")
    count, repeats, half = _FEWEST, 1, _FEWEST // 2
    values = energies.at(np.arange(count) * (period / count))
    apart = np.max(np.abs(values[:, half:] - values[:, :half]), axis=1)
    if np.all(apart <= energies.rounding * energies.sizes):
        values, repeats = values[:, :half], 2
    while True:
        tolerance, functions = energies.rounding, Fourier.of(values, period / repeats)
        greatest = np.max(np.abs(functions.coefficients), axis=1)
        # Weights that hold each other leave nothing but their rounding.
        sizes = np.maximum(greatest, energies.sizes)
        tail = float(np.max(functions.tail() * greatest / np.where(sizes > 0.0, sizes, 1.0)))
        if tail < tolerance:
            is_none = greatest <= tolerance * energies.sizes
            if is_none[0]:
                raise NotSuitableError("nothing that the drive moves has mass")
            found = np.where(is_none[:, None], 0.0, functions.coefficients)
            coefficients = np.zeros((2, repeats * (found.shape[1] - 1) + 1), dtype=complex)
            coefficients[:, ::repeats] = found
            inertia, force = (
                Fourier(read_only(coefficients[[index]]), 2.0 * np.pi / period)
                for index in range(2)
            )
            return EnergyFunctions(inertia, force, tolerance)
        # Coefficients fall exponentially, so that the tail tells how many will do.
        factor = np.log(tolerance) / np.log(min(tail, 0.5))
        more = 2 ** max(1, int(np.ceil(np.log2(factor))))
        count *= more
        if count > _MOST:
            raise NotSuitableError(f"{_MOST} positions do not resolve the inertia over a turn")
        own, known = count // repeats, values
        new = np.flatnonzero(np.arange(own) % more)
        # Of what repeats within the period, a few are compared with the next time.
        again = new[:: max(1, new.size // _COMPARED)] if repeats > 1 else new[:0]
        found = energies.at(np.concatenate([new, again + own]) * (period / count))
        values = np.repeat(known, more, axis=1)
        values[:, new] = found[:, : new.size]
        off = np.abs(found[:, new.size :] - values[:, again])
        if np.any(off > (energies.rounding * energies.sizes)[:, None]):
            values, repeats = energies.at(np.arange(count) * (period / count)), 1


class _Energies:
    """Inertia and force of the drive by virtual work, from velocity ratios alone.

    Attributes:
        condition: greatest condition number of the velocity ratios so far.
        sizes: `(2,)` greatest terms that inertia and force are sums of, so far.
    """

    def __init__(self, solver: ProblemSolver, forces: Forces | None) -> None:
        """Begin.

        Args:
            solver: of a scene with one drive.
            forces: see `energy_functions`.
        """
        self._solver, self._forces = solver, forces
        mechanism = solver.problem.mechanism
        self._model = turning_model(mechanism, solver.problem.gravity)
        for index in mechanism.auxiliary_bodies:
            self._model.inertias[index] = pinocchio.Inertia.Zero()
        # Pinocchio 4.1 adds the energy of rotors for some kinds of joints alone.
        self._armature = np.array(self._model.armature)
        self._model.armature = np.zeros(self._model.nv)
        self._data = self._model.createData()
        self._has_weight = bool(np.any(solver.problem.gravity))
        self.condition, self.sizes = 1.0, np.zeros(2)

    @property
    def rounding(self) -> float:
        """Part of inertia and force that may be rounding."""
        return _ROUNDING * EPS * self.condition

    def at(self, positions: Array) -> Array:
        """Return inertia and force `(2, N)` at positions `(N,)` of the drive.

        Raises:
            NotSuitableError: the loops cannot be closed at one of them.
        """
        solver = self._solver
        assembled = solver.assembled_in_turn(Targets.of_positions(positions[:, None]))
        values = np.empty((2, len(positions)))
        try:
            for span, state in zip(assembled.spans, assembled.blocks, strict=True):
                ratios = solver.assembly.kinematics.velocity_ratios(state)
                condition = solver.inverse_dynamics.condition(state, ratios)
                self.condition = max(self.condition, float(np.max(condition)))
                x = state.x + 2.0 * np.pi * assembled.turns[span]
                v = ratios[:, :, 0]
                values[:, span] = [self._inertia(x, v), self._force(x, v)]
        except CardanError as error:
            raise NotSuitableError(str(error)) from error
        return values

    def _inertia(self, x: Array, v: Array) -> Array:
        """Return twice the kinetic energies `(N,)` at unit speed of the drive."""
        energy, model, data = pinocchio.computeKineticEnergy, self._model, self._data
        values = 2.0 * np.array([energy(model, data, *row) for row in zip(x, v, strict=True)])
        values += v**2 @ self._armature
        self.sizes[0] = max(self.sizes[0], float(np.max(values)))
        return values

    def _force(self, x: Array, v: Array) -> Array:
        """Return the power `(N,)` of weight and forces at unit speed of the drive."""
        model, data = self._model, self._data
        efforts = np.zeros_like(v)
        if self._has_weight:
            gravity = pinocchio.computeGeneralizedGravity
            efforts = -np.array([gravity(model, data, row) for row in x])
        if self._forces is not None and not self._forces.is_nothing:
            rest = np.zeros(v.shape[1])
            efforts = efforts + np.array(
                [self._forces.efforts(model, data, 0.0, row, rest) for row in x]
            )
        terms = efforts * v
        self.sizes[1] = max(self.sizes[1], float(np.max(np.abs(terms), initial=0.0)))
        return np.asarray(np.sum(terms, axis=1))
