"""Sampling: wrenches and efforts for unit speed, acceleration, loads and gravity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import BLOCK_SIZE, Array
from ..dynamics.inverse_dynamics import Inputs, JointRates, Solution
from ..dynamics.open_tree import LoadCase
from ..dynamics.problem_solver import ProblemSolver
from ..dynamics.reactions import UNIQUE_TOLERANCE, Reactions, superposed
from ..elements.link_loads import LinkLoad
from ..frozen import frozen
from ..kinematics.closing.all_groups import ClosedState
from ..problem.samples import Targets, acting_on
from ..proof.residuals import Residuals
from .columns import ACCELERATION, AXES, GRAVITY, SPEED_SQUARED, Column, Kind, Layout


def layout_of(solver: ProblemSolver) -> Layout:
    """Return which functions the response of a problem has, and in which order."""
    problem = solver.problem
    columns = [SPEED_SQUARED, ACCELERATION] if solver.has_mass else []
    columns += [Column(Kind.JOINT_LOAD, name) for name in problem.joint_loads]
    columns += [Column(Kind.LINK_LOAD, name) for name in problem.link_loads]
    if solver.has_mass and np.any(problem.gravity):
        columns += GRAVITY
    efforts, couplings = (*problem.independent, *problem.held), tuple(solver.couplings.values())
    return Layout(tuple(columns), problem.outputs, efforts, couplings)


class Samples(NamedTuple):
    """The functions of a response at some drive positions, with their condition and uniqueness.

    Attributes:
        values: `(C, M)` all functions.
        condition: the greatest condition number, 1 at least.
        influence: `(k, 6)` greatest influence of self-stresses on the outputs' wrenches, see
            `Reactions.influence`.
        indeterminate_couplings: indices of the couplings whose moment is not unique.
    """

    values: Array
    condition: float
    influence: Array
    indeterminate_couplings: frozenset[int]

    @property
    def unique(self) -> Array:
        """Which components of the outputs follow from the laws of motion alone, `(k, 6)`."""
        return self.influence < UNIQUE_TOLERANCE

    def first(self, count: int) -> Samples:
        """Return the values of the first positions; the other attributes stay those of all."""
        return self._replace(values=self.values[:, :count])

    def interleaved(self, between: Samples) -> Samples:
        """Return samples with others put between each two of them."""
        count = self.values.shape[1] + between.values.shape[1]
        values = np.empty((len(self.values), count))
        values[:, ::2], values[:, 1::2] = self.values, between.values
        return Samples(
            values,
            max(self.condition, between.condition),
            np.maximum(self.influence, between.influence),
            self.indeterminate_couplings | between.indeterminate_couplings,
        )


class Request(NamedTuple):
    """Positions at which a response asks for its functions.

    Attributes:
        positions: of the drive `(M,)`.
        proven: whether residuals are wanted as well.
    """

    positions: Array
    proven: bool = False


class Answer(NamedTuple):
    """Functions at the positions of a request.

    Attributes:
        samples: the functions.
        loop_error: `(M,)` see `Sweep.loop_residual`; None unless residuals are wanted.
        residuals: of the scene's own loads at unit rates, the sum of the columns, so that they
            prove the columns; None likewise.
    """

    samples: Samples
    loop_error: Array | None = None
    residuals: Residuals | None = None


class FunctionSampler:
    """Solves the functions of responses at drive positions.

    Attributes:
        layout: which functions there are.
    """

    def __init__(self, solver: ProblemSolver) -> None:
        self._solver = solver
        self._problem = problem = solver.problem
        # Efforts at joints are columns of their own, and may vary from sample to sample.
        self._acting = acting_on(problem)._replace(joint_loads=frozen({})).flat((1,))
        self._inverse_dynamics = solver.inverse_dynamics
        self.layout = layout_of(solver)
        loop_count = len(problem.mechanism.loops)
        # Couplings follow the loops among the closure forces.
        self._coupling_rows = [loop_count + index for index in solver.couplings]

    def answer(self, request: Request) -> Answer:
        """Return all functions at drive positions `(M,)`.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        targets = Targets.of_positions(request.positions[:, None])
        span = slice(0, targets.size)
        (answer,) = self.answers(targets, [span], request.proven)
        return answer

    def answers(self, targets: Targets, spans: Sequence[slice], proven: bool) -> list[Answer]:
        """Return all functions at targets, for each span of samples.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        guess = self._solver.assembly.guesses(targets)
        answers: list[Answer] = []
        for together in _in_blocks(spans):
            block = slice(together[0].start, together[-1].stop)
            own = targets.block(block)
            positions = own.positions
            state = self._solver.assembly.close(guess.of_samples(block), positions, block.start)
            rates = self._rates(state)
            reactions = self._reactions(state, rates)
            values, condition = self._values(reactions, rates.v), self._condition(state, rates)
            # All columns are solved with the same closure equations, and so have the same
            # influence.
            first = reactions[0]
            solution = None
            if proven:
                solution = self._proven(own, guess.turns[block], state, rates, reactions)
            for span in together:
                part = slice(span.start - block.start, span.stop - block.start)
                samples = Samples(
                    values[:, part],
                    max(1.0, float(np.max(condition[part]))),
                    first.influence[self._problem.output_indices],
                    frozenset(first.indeterminate_couplings),
                )
                answers.append(
                    Answer(samples)
                    if solution is None
                    else Answer(
                        samples, solution.loop_error[part], solution.residuals.of_samples(part)
                    )
                )
        return answers

    def _proven(
        self,
        targets: Targets,
        turns: Array,
        state: ClosedState,
        rates: JointRates,
        reactions: list[Reactions],
    ) -> Solution:
        """Return the solution of the scene's own loads at unit rates, proven.

        Args:
            targets: N samples.
            turns: `(N, size)` whole turns that their angles lack.
            state: closed there.
            rates: at constant unit speed.
            reactions: of every column.
        """
        factors = [self._factor(column) for column in self.layout.columns]
        loads = self._loads(None)
        for factor, column in zip(factors, self.layout.columns, strict=True):
            loads += factor * self._loads(column)
        ones = np.ones((targets.size, 1))
        inputs = Inputs.of(self._problem, targets, self._acting, turns)
        inputs = inputs._replace(speeds=ones, accelerations=ones, loads=loads, has_rates=True)
        total = superposed(reactions, factors or [1.0])
        unit_rates = rates._replace(a=rates.a + rates.v)
        solution = self._inverse_dynamics.with_residuals(state, inputs, unit_rates, total)
        solution.prove(targets.positions)
        self._inverse_dynamics.prove_flags(solution)
        return solution

    def _condition(self, state: ClosedState, rates: JointRates) -> Array:
        """Return `(N,)` condition numbers, see `InverseDynamics.condition`."""
        return self._inverse_dynamics.condition(state, rates.velocity_ratios)

    def _rates(self, state: ClosedState) -> JointRates:
        """Return the rates of all joints at constant unit speed."""
        ones = np.ones((len(state.x), 1))
        return self._inverse_dynamics.joint_rates(state, ones, 0.0 * ones)

    def _reactions(self, state: ClosedState, rates: JointRates) -> list[Reactions]:
        """Return the reactions of every column, those of rest if there is none."""
        rest = np.zeros_like(rates.v)
        motions = {SPEED_SQUARED: (rates.v, rates.a), ACCELERATION: (rest, rates.v)}
        motions |= dict.fromkeys(GRAVITY, (rest, rest))
        cases = [
            LoadCase(
                motions.get(column),
                self._loads(column),
                self._link_loads(column),
                self._gravity(column),
            )
            for column in self.layout.columns
        ] or [LoadCase(None, self._loads(None), [], np.zeros((1, 3)))]
        return self._solver.reactions.solve(state, cases)

    def _link_loads(self, column: Column) -> list[LinkLoad]:
        """Return the wrench of a column that belongs to a loaded link."""
        return [self._acting.link_loads[column.name]] if column.kind is Kind.LINK_LOAD else []

    def _gravity(self, column: Column) -> Array:
        """Return the unit gravity `(1, 3)` of a column."""
        gravity = np.zeros((1, 3))
        if column.kind is Kind.GRAVITY:
            gravity[0, AXES.index(column.name)] = 1.0
        return gravity

    def _loads(self, column: Column | None) -> Array:
        """Return the unit load `(1, nv)` of a column."""
        loads = np.zeros((1, self._problem.mechanism.model.nv))
        if column is not None and column.kind is Kind.JOINT_LOAD:
            loads[:, self._problem.mechanism.coordinates.named[column.name].rate] = 1.0
        return loads

    def _factor(self, column: Column) -> float:
        """Return what the scene multiplies a column with at unit speed and acceleration."""
        if column.kind is Kind.GRAVITY:
            return float(self._problem.gravity[AXES.index(column.name)])
        if column.kind is Kind.JOINT_LOAD:
            load = self._problem.joint_loads[column.name]
            # The proof needs any constant load; the samples of a varying one belong to a sweep.
            return 1.0 if load.ndim else float(load)
        return 1.0

    def _values(self, reactions: list[Reactions], v: Array) -> Array:
        """Return all functions `(C, M)` of the reactions of all columns."""
        count, layout = len(v), self.layout
        wrenches = np.zeros((len(layout.columns), len(layout.outputs), 6, count))
        efforts = np.zeros((len(layout.columns), len(layout.efforts), count))
        moments = np.zeros((len(layout.columns), len(layout.couplings), count))
        # Without any column the only reactions are those of rest, which `zip` leaves out.
        for index, (column, solved) in enumerate(zip(layout.columns, reactions, strict=False)):
            wrenches[index] = solved.wrenches[:, self._problem.output_indices].transpose(1, 2, 0)
            effort = self._solver.reactions.efforts(solved) - self._loads(column)
            if self._solver.assembly.needed.efforts_alone:
                # Without closure forces virtual work gives the drive's effort.
                efforts[index, 0] = np.sum(effort * v, axis=1)
            else:
                efforts[index] = effort[:, self._problem.prescribed_columns].T
            for coupling, row in enumerate(self._coupling_rows):
                moments[index, coupling] = solved.closure_forces[row][:, 0]
        return layout.joined(wrenches, np.concatenate([efforts, moments], axis=1))


def _in_blocks(spans: Sequence[slice]) -> list[list[slice]]:
    """Return spans of samples that follow each other in blocks of few samples."""
    blocks: list[list[slice]] = []
    for span in spans:
        if blocks and span.stop - blocks[-1][0].start <= BLOCK_SIZE:
            blocks[-1].append(span)
        else:
            blocks.append([span])
    return blocks
