"""Sampling: wrenches and efforts for unit speed, acceleration, loads and gravity."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np

from ...kit.arrays import BLOCK_SIZE, Array
from ...kit.frozen import frozen
from ..dynamics.inverse_dynamics import UNIQUE_TOLERANCE, Inputs, Solution
from ..dynamics.problem_solver import ProblemSolver
from ..dynamics.tape import Found
from ..dynamics.velocity_ratios import VelocityRatios
from ..kinematics.closing.all_groups import ClosedState
from ..problem.samples import Targets, acting_on
from ..proof.residuals import Residuals
from .columns import ACCELERATION, AXES, GRAVITY, SPEED_SQUARED, Acts, Column, Layout


def layout_of(solver: ProblemSolver) -> Layout:
    """Return which functions the response of a problem has, and in which order."""
    problem = solver.problem
    columns = [SPEED_SQUARED, ACCELERATION] if solver.has_mass else []
    columns += [Column(Acts.JOINT_LOAD, name) for name in problem.joint_loads]
    columns += [Column(Acts.LINK_LOAD, name) for name in problem.link_loads]
    if solver.has_mass and np.any(problem.gravity):
        columns += GRAVITY
    efforts, couplings = (*problem.independent, *problem.held), tuple(solver.couplings.values())
    return Layout(tuple(columns), problem.outputs, efforts, couplings)


class Sampled(NamedTuple):
    """The functions of a response at some drive positions, with their condition and uniqueness.

    Attributes:
        values: `(C, M)` all functions.
        condition: the greatest condition number, 1 at least.
        influence: `(k, 6)` greatest influence of self-stresses on the outputs' wrenches, see
            `Solution`.
        indeterminate_couplings: indices of the couplings whose moment is not unique.
        proven: residuals of the scene's own loads at unit rates, the sum of the columns, so that
            they prove the columns; None unless they are wanted.
        loop_error: `(M,)` see `Sweep.loop_residual`; None likewise.
    """

    values: Array
    condition: float
    influence: Array
    indeterminate_couplings: frozenset[int]
    proven: Residuals | None = None
    loop_error: Array | None = None

    @property
    def unique(self) -> Array:
        """Which components of the outputs follow from the laws of motion alone, `(k, 6)`."""
        return self.influence < UNIQUE_TOLERANCE

    def first(self, count: int) -> Sampled:
        """Return the values of the first positions; the other attributes stay those of all."""
        return self._replace(values=self.values[:, :count])

    def interleaved(self, between: Sampled) -> Sampled:
        """Return samples with others put between each two of them."""
        count = self.values.shape[1] + between.values.shape[1]
        values = np.empty((len(self.values), count))
        values[:, ::2], values[:, 1::2] = self.values, between.values
        return Sampled(
            values,
            max(self.condition, between.condition),
            np.maximum(self.influence, between.influence),
            self.indeterminate_couplings | between.indeterminate_couplings,
        )


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
        self.layout = layout_of(solver)

    def samples(self, targets: Targets, counts: Sequence[int], proven: bool) -> list[Sampled]:
        """Return all functions at targets, for so many samples at a time as the counts say.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        assembly = self._solver.assembly
        guess, answers = assembly.guesses(targets), list[Sampled]()
        for together in in_blocks(counts, BLOCK_SIZE):
            block = slice(together[0].start, together[-1].stop)
            own = targets.block(block)
            inputs = Inputs.of(self._problem, own, self._acting, guess.turns[block], True)
            # As far as rounding lets loops close: series show what more is left.
            state = assembly.close(guess.of_samples(block), own.positions, block.start)
            columns = self._columns(state.x, inputs)
            ratios = assembly.kinematics.velocity_ratios(state)
            condition = self._solver.inverse_dynamics.condition(state, ratios)
            values = self._values(columns)
            # All columns are solved with the same closure equations, and so have the same
            # influence.
            told = columns.influence[self._problem.output_indices], frozenset(columns.loose)
            solution = self._proven(own, inputs, columns, state) if proven else None
            for span in together:
                part = slice(span.start - block.start, span.stop - block.start)
                greatest = max(1.0, float(np.max(condition[part])))
                proof: tuple[Any, ...] = ()
                if solution is not None:
                    proof = solution.residuals.of_samples(part), solution.loop_error[part]
                answers.append(Sampled(values[:, part], greatest, *told, *proof))
        return answers

    def _columns(self, x: Array, inputs: Inputs) -> _Columns:
        """Return what is found of every column, of rest if there is none.

        Args:
            x: `(N, size)` closed coordinates.
            inputs: what the scene prescribes for them.
        """
        columns: Sequence[Column | None] = self.layout.columns or (None,)
        count, each = len(x), len(columns)
        lanes = np.tile(np.arange(count), each)

        def unit(values: Array, wanted: Sequence[Column]) -> Array:
            """Return values in the lanes of some columns, zero in all others."""
            of_column = [values if column in wanted else 0.0 * values for column in columns]
            return np.repeat(np.concatenate(of_column), count, axis=0)

        ones, no_loads = np.ones((1, 1)), np.zeros((1, self._problem.mechanism.model.nv))
        loads = [no_loads if column is None else self._loads(column) for column in columns]
        given = inputs.of_samples(lanes)._replace(
            speeds=unit(ones, [SPEED_SQUARED]),
            accelerations=unit(ones, [ACCELERATION]),
            loads=np.repeat(np.concatenate(loads), count, axis=0),
            gravity=np.sum(
                [unit(axis[None], [of]) for axis, of in zip(np.eye(3), GRAVITY, strict=True)], 0
            ),
            inertia={},
        )
        links = [
            replace(
                load,
                force=unit(load.force, [Column(Acts.LINK_LOAD, name)]),
                moment=unit(load.moment, [Column(Acts.LINK_LOAD, name)]),
            )
            for name, load in inputs.link_loads.items()
        ]

        def close(samples: Array) -> ClosedState:
            return self._solver.assembly.kinematics.evaluate(x[lanes[samples]])

        found, influence, loose = self._solver.taped.found(x[lanes], given, close, links)
        return _Columns(found, each, count, influence, loose)

    def _proven(
        self, targets: Targets, inputs: Inputs, columns: _Columns, state: ClosedState
    ) -> Solution:
        """Return the solution of the scene's own loads at unit rates, proven.

        Args:
            targets: N samples.
            inputs: what the scene prescribes for them.
            columns: found there.
            state: closed there.
        """
        factors = np.array([self._factor(column) for column in self.layout.columns] or [1.0])
        loads = np.zeros((1, self._problem.mechanism.model.nv))
        for factor, column in zip(factors, self.layout.columns, strict=False):
            loads += factor * self._loads(column)
        ones, found = np.ones((targets.size, 1)), columns.found

        def total(values: Array) -> Array:
            """Return the sum of all columns, each times its factor."""
            return np.asarray(np.tensordot(factors, columns.each(values), 1))

        rates = self._solver.inverse_dynamics.joint_rates(state, ones, ones)
        if SPEED_SQUARED in self.layout.columns:
            rates = rates._replace(a=total(found.a))  # With those of rods that spin.
        inputs = inputs._replace(speeds=ones, accelerations=ones, loads=loads)
        wrenches = total(found.wrenches).reshape(targets.size, -1, 6)
        of_joints = wrenches, total(found.efforts), total(found.couplings)
        dynamics = self._solver.inverse_dynamics
        claim = dynamics.claim(columns.x, inputs, rates, *of_joints)
        residuals = dynamics.bodies.check(claim)
        solution = Solution(
            x=columns.x,
            v=rates.v,
            a=rates.a,
            velocity_ratios=VelocityRatios.of(rates.velocity_ratios, rates.depends),
            wrenches=wrenches,
            efforts=of_joints[1],
            coupling_moments=of_joints[2],
            closure_condition=columns.each(found.condition)[0],
            loop_error=np.maximum(columns.each(found.error)[0], residuals.loop_error),
            residuals=residuals,
            influence=columns.influence,
            indeterminate_couplings=columns.loose,
        )
        solution.prove(targets.positions)
        self._solver.inverse_dynamics.prove_flags(solution)
        return solution

    def _loads(self, column: Column) -> Array:
        """Return the unit load `(1, nv)` of a column."""
        loads = np.zeros((1, self._problem.mechanism.model.nv))
        if column.kind is Acts.JOINT_LOAD:
            loads[:, self._problem.mechanism.coordinates.named[column.name].rate] = 1.0
        return loads

    def _factor(self, column: Column) -> float:
        """Return what the scene multiplies a column with at unit speed and acceleration."""
        if column.kind is Acts.GRAVITY:
            return float(self._problem.gravity[AXES.index(column.name)])
        if column.kind is Acts.JOINT_LOAD:
            load = self._problem.joint_loads[column.name]
            # The proof needs any constant load; the samples of a varying one belong to a sweep.
            return 1.0 if load.ndim else float(load)
        return 1.0

    def _values(self, columns: _Columns) -> Array:
        """Return all functions `(C, M)`."""
        found, layout, problem = columns.found, self.layout, self._problem
        wrenches = found.wrenches.reshape(len(found.wrenches), -1, 6)[:, problem.output_indices]
        every = (
            wrenches.reshape(len(wrenches), layout.wrenches),
            found.efforts[:, problem.prescribed_columns],
            found.couplings[:, list(self._solver.couplings)],
        )
        # Without any columns, those of rest are left out.
        each = columns.each(np.concatenate(every, axis=1))[: len(layout.columns)]
        return np.ascontiguousarray(each.transpose(0, 2, 1)).reshape(-1, columns.samples)


class _Columns(NamedTuple):
    """What is found of c columns at N samples.

    Attributes:
        found: of `c N` lanes, column after column.
        columns, samples: c and N.
        influence, loose: see `Solution`.
    """

    found: Found
    columns: int
    samples: int
    influence: Array
    loose: set[int]

    def each(self, values: Array) -> Array:
        """Return values by column and sample."""
        return values.reshape(self.columns, self.samples, *values.shape[1:])

    @property
    def x(self) -> Array:
        """Coordinates `(N, size)`."""
        return self.found.x[: self.samples]


def in_blocks(counts: Iterable[int], most: int) -> list[list[slice]]:
    """Return so many samples each as spans that follow each other, as many together as `most`."""
    blocks: list[list[slice]] = []
    for start, stop in pairwise(accumulate(counts, initial=0)):
        if blocks and stop - blocks[-1][0].start <= most:
            blocks[-1].append(slice(start, stop))
        else:
            blocks.append([slice(start, stop)])
    return blocks
