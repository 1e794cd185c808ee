"""Sampling: wrenches and efforts for unit speed, acceleration, loads and gravity."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..dynamics.inverse_dynamics import Inputs, JointRates, Solution, joined
from ..dynamics.open_tree import LoadCase
from ..dynamics.problem_solver import ProblemSolver
from ..dynamics.reactions import UNIQUE_TOLERANCE, Reactions, superposed
from ..forces.link_loads import LinkLoad
from ..kinematics.all_groups import ClosedState
from .columns import ACCELERATION, AXES, GRAVITY, SPEED_SQUARED, Column, Kind, Layout

_EPS = float(np.finfo(float).eps)
_ROUNDED = 10.0
"""Rounding of inertial terms in units of eps, per condition number and cancellation. Measured: up
to 3, at bend angles from 1° to 85° and in a line of three joints."""


def layout_of(solver: ProblemSolver) -> Layout:
    """Return which functions the response of a problem has, and where they stand."""
    problem = solver.problem
    columns = [SPEED_SQUARED, ACCELERATION] if solver.has_mass else []
    columns += [Column(Kind.JOINT_LOAD, name) for name in problem.joint_loads]
    columns += [Column(Kind.LINK_LOAD, name) for name in problem.link_loads]
    if solver.has_mass and np.any(problem.gravity):
        columns += GRAVITY
    efforts, couplings = (*problem.drives, *problem.held), tuple(solver.couplings.values())
    return Layout(tuple(columns), problem.outputs, efforts, couplings)


class FunctionSampler:
    """Solves the functions of a response at drive positions, and keeps what was met there.

    Attributes:
        layout: which functions there are.
        condition: greatest condition number met.
        indeterminate_couplings: indices of the couplings whose moment is not unique.
    """

    def __init__(self, solver: ProblemSolver) -> None:
        self._solver = solver
        self._problem = problem = solver.problem
        self._inverse_dynamics = solver.inverse_dynamics
        self.layout = layout_of(solver)
        self.condition = 1.0
        self.indeterminate_couplings: set[int] = set()
        self._influence = np.zeros((solver.reactions.size, 6))
        loops = len(problem.mechanism.loops)
        self._moments = [loops + index for index in solver.couplings]
        self._weights = np.repeat([problem.mechanism.characteristic_length, 1.0], 3)

    @property
    def unique(self) -> Array:
        """Which components of the outputs follow from the laws of motion alone, `(k, 6)`."""
        return (self._influence < UNIQUE_TOLERANCE)[self._problem.output_indices]

    def solve(self, positions: Array) -> Array:
        """Return all functions `(C, M)` at drive positions `(M,)`."""
        here, _ = self._closed(positions)
        rates = self._rates(here)
        return self._stacked(self._reactions(here, rates), rates[1])

    def prove(self, positions: Array) -> tuple[Array, Solution]:
        """Return all functions, and the scene's own loads at unit rates with their residuals.

        The latter are the sum of the columns, so their residuals prove the columns.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        problem, columns = self._problem, self.layout.columns
        here, turns = self._closed(positions)
        rates = velocity_ratios, v, a = self._rates(here)
        cases = self._reactions(here, rates)
        factors = [self._factor(column) for column in columns]
        loads = self._loads(None)
        for factor, column in zip(factors, columns, strict=True):
            loads += factor * self._loads(column)
        ones = np.ones((len(positions), 1))
        placed = positions[:, None]
        inputs = Inputs(placed, ones, ones, loads, problem.link_loads, turns, has_rates=True)
        together = superposed(cases, factors or [1.0])
        unit_rates = JointRates(velocity_ratios, v, a + v)
        block = self._inverse_dynamics.with_residuals(here, inputs, unit_rates, together)
        block = joined([block], placed)
        self._inverse_dynamics.prove_flags(block)
        return self._stacked(cases, v), block

    def scales(self, values: Array) -> Array:
        """Return `(C,)` what errors of each function are relative to."""
        sizes, singles = self._sizes(values)
        least = 0.1 * np.where(self._greatest(values) > 0.0, self._greatest(values), 1.0)[:, None]
        scales = np.maximum(sizes, least)[:, :, None] / self._weights
        return self.layout.joined(scales, np.maximum(singles, least))

    def empty(self, values: Array) -> Array:
        """Return `(C,)` which functions are nothing but the rounding of weights or inertia."""
        mechanism = self._problem.mechanism
        mass = sum(float(inertia.mass) for inertia in mechanism.model.inertias)
        terms = dict.fromkeys(
            (SPEED_SQUARED, ACCELERATION), mass * mechanism.characteristic_length**2
        )
        terms |= dict.fromkeys(GRAVITY, mass * mechanism.characteristic_length)
        sizes, singles = self._sizes(values)
        floor = _EPS * np.array([terms.get(name, 0.0) for name in self.layout.columns])[:, None]
        return self.layout.joined(np.repeat((sizes <= floor)[:, :, None], 6, 2), singles <= floor)

    def cancellation(self, values: Array, proven: Solution) -> float:
        """Return by how much inertial terms exceed what is left of them at constant speed."""
        sizes = dict(zip(self.layout.columns, self._greatest(values).tolist(), strict=True))
        greatest = sizes.get(SPEED_SQUARED, 0.0)
        return 1.0 + (float(np.max(proven.residuals.inertia)) / greatest if greatest else 0.0)

    def rounding(self, values: Array, proven: Solution) -> Array:
        """Return `(C,)` what rounding of inertial terms adds to each function, by its scale.

        What depends on speed alone is what is left of inertial terms, and so is its rounding.
        """
        size = _ROUNDED * _EPS * self.condition * self.cancellation(values, proven)
        belongs = [column == SPEED_SQUARED for column in self.layout.columns]
        return self.layout.spread(size * np.array(belongs, dtype=float))

    def _greatest(self, values: Array) -> Array:
        """Return the greatest wrench or effort of each column, forces times the length."""
        sizes = np.concatenate(self._sizes(values), axis=1)
        return np.asarray(np.max(sizes, axis=1, initial=0.0))

    def _sizes(self, values: Array) -> tuple[Array, Array]:
        """Return greatest wrenches of the outputs, and greatest singles, by columns."""
        wrenches, singles = self.layout.parted(np.max(np.abs(values), axis=1))
        return np.max(wrenches * self._weights, axis=2, initial=0.0), singles

    def _closed(self, positions: Array) -> tuple[ClosedState, Array]:
        """Return closed positions, and the whole turns that their angles lack."""
        guess = self._solver.assembly.guesses(positions[:, None])
        return self._solver.assembly.close(guess, positions[:, None]), guess.turns

    def _rates(self, here: ClosedState) -> tuple[Array, Array, Array]:
        """Return velocity_ratios, velocities and accelerations at constant unit speed."""
        ones = np.ones((len(here.x), 1))
        rates = self._inverse_dynamics.joint_rates(here, ones, 0.0 * ones)
        condition = self._inverse_dynamics.condition(here, rates[0])
        self.condition = max(self.condition, float(np.max(condition)))
        return rates

    def _reactions(self, here: ClosedState, rates: tuple[Array, Array, Array]) -> list[Reactions]:
        """Return the reactions of every column, those of rest if there is none."""
        _, v, a = rates
        still = np.zeros_like(v)
        dynamics = {SPEED_SQUARED: (v, a), ACCELERATION: (still, v)}
        dynamics |= dict.fromkeys(GRAVITY, (still, still))
        cases = [LoadCase(None, self._loads(None), [], np.zeros(3))]
        if self.layout.columns:
            cases = [
                LoadCase(
                    dynamics.get(column),
                    self._loads(column),
                    self._links(column),
                    self._pull(column),
                )
                for column in self.layout.columns
            ]
        found = self._solver.reactions.solve(here, cases)
        self._influence = np.maximum(self._influence, found[0].influence)
        self.indeterminate_couplings |= found[0].indeterminate_couplings
        return found

    def _links(self, column: Column) -> list[LinkLoad]:
        return [self._problem.link_loads[column.name]] if column.kind is Kind.LINK_LOAD else []

    def _pull(self, column: Column) -> Array:
        """Return the unit gravity `(3,)` of a column."""
        return np.eye(3)[AXES.index(column.name)] if column.kind is Kind.GRAVITY else np.zeros(3)

    def _loads(self, column: Column | None) -> Array:
        """Return the unit load `(1, nv)` of a column."""
        loads = np.zeros((1, self._problem.mechanism.model.nv))
        if column is not None and column.kind is Kind.JOINT_LOAD:
            loads[:, self._problem.mechanism.coordinates.velocity_columns[column.name].start] = 1.0
        return loads

    def _factor(self, column: Column) -> float:
        """Return what the scene multiplies a column with at unit speed and acceleration."""
        if column.kind is Kind.GRAVITY:
            return float(self._problem.gravity[AXES.index(column.name)])
        if column.kind is Kind.JOINT_LOAD:
            given = self._problem.joint_loads[column.name]
            # A load that changes from sample to sample is as good as one that does not.
            return 1.0 if given.ndim else float(given)
        return 1.0

    def _stacked(self, cases: list[Reactions], v: Array) -> Array:
        """Return all functions `(C, M)` of the reactions of all columns."""
        count, layout = len(v), self.layout
        wrenches = np.zeros((len(layout.columns), len(layout.outputs), 6, count))
        efforts = np.zeros((len(layout.columns), len(layout.efforts), count))
        moments = np.zeros((len(layout.columns), len(layout.couplings), count))
        # Without any column there is one case, that of rest.
        for place, (column, reactions) in enumerate(zip(layout.columns, cases, strict=False)):
            wrenches[place] = reactions.wrenches[:, self._problem.output_indices].transpose(1, 2, 0)
            effort = self._solver.reactions.efforts(reactions) - self._loads(column)
            if self._solver.assembly.needed.efforts_alone:
                # Without closure forces virtual work gives the drive's effort.
                efforts[place, 0] = np.sum(effort * v, axis=1)
            else:
                efforts[place] = effort[:, self._problem.prescribed_columns].T
            for number, gear in enumerate(self._moments):
                moments[place, number] = reactions.closure_forces[gear][:, 0]
        return layout.joined(wrenches, np.concatenate([efforts, moments], axis=1))
