"""Group solver: close the loops of a group for many samples at once, and find its rates.

Newton's method on whole arrays. Each sample is factorised once: the inverse that gave the last
small step serves the rates and the closure forces as well, after one step of refinement.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...arrays import Array, generic
from ...mechanism.kept import MOST, Kept
from ...mechanism.mechanism import Mechanism
from ..loops.groups import Group
from ..loops.structure import OPEN_CONFIGURATIONS
from .batch_model import BatchModel, actions_of, batch_model
from .equations import ClosureEquations, Reduction
from .stacked import (
    condition_numbers,
    factorised,
    factorised_with_spins,
    is_near,
    refined,
    same_side,
    times,
    transposed,
)

_FEW = 0.4
"""Share of the samples up to which a Newton step is taken for these alone: it saves more than it
costs to take them out and put them back."""
_CONVERGED = 1e-17
"""Error [rad] that the last step of Newton's method may leave, well below rounding, since only its
order is known before the loops are evaluated once more."""
_STRAIGHT, _CURVATURE = 3e-10, 100.0
"""Newton steps [rad] up to which nothing is gained by bending them, since they leave less than
rounding: this times their square at most, where no singular configuration is near."""
_BENT = 0.1
"""Newton steps [rad] up to which the curvature of the closure equations tells where they lead."""
_MOST_BENT = 0.25
"""Ratio of what the curvature adds to a step from which on it is left out: its powers are what is
neglected, so the step is too long for them."""
LONGEST_STEP = 0.5
"""Greatest Newton step [rad]: farther away, a full step may end in another assembly mode. Over half
a radian, sines differ from their linearisation by 4 %."""
_NEARBY = 1e-4
"""Newton step [rad] up to which the inverse before it is tried as the inverse after it. The matrix
changes in proportion to the step, and whether the inverse serves is then tested (`is_near`): the
value decides only about the cost of tests in vain."""
_SETTLED = 1e-9
"""Angle [rad] of an idle rod from where it settles from which one more step leaves rounding, even
where hinges near their singular position magnify what is left, its square, a thousandfold."""
_UNMOVED = 1e-12
"""Newton step [rad] up to which an idle rod stays where it settled. Where a rod settles depends on
how its line lies, so each step turns it about that in proportion."""
_MOST_SETTLING = 40
"""Greatest number of such steps: half a turn takes seven of the longest ones."""
MOST_STEPS = 12
"""Newton steps that a guess gets unless the caller says otherwise. From nearby a few suffice, since
each squares the error; the rest is for guesses from which steps are shortened to `LONGEST_STEP`."""
MOST_STEPS_FROM_AFAR = 60
"""The same for guesses anywhere within half a turn of closed loops: many steps are shortened."""


class GroupSolver:
    """Closes the loops of a group for many samples by Newton's method on whole arrays.

    It does not change after it is made: which rows are redundant is an argument of its methods.

    Attributes:
        group: what it solves.
        coordinates: layout of coordinate rows.
        batch: its bodies.
        equations: its closure equations.
        row_scale: `(p, 1)` lengths for the rows of slides, or None where nothing slides.
        known_scale: `(k, 1)` likewise for what is known.
    """

    def __init__(self, mechanism: Mechanism, group: Group) -> None:
        self.group = group
        self._kept = Kept()
        self.coordinates = coordinates = mechanism.coordinates
        self.batch = _batch_model(mechanism, group)
        self.equations = ClosureEquations(mechanism, self.batch, group)
        self._length = mechanism.characteristic_length
        self._moves = coordinates.moves(group.passives)
        self._zero = mechanism.zero
        slides = np.any(self.batch.subspace[:, :3] != 0.0, axis=1)
        sliding = slides[group.passives]
        self._scale = np.where(sliding, 1.0 / self._length, 1.0)
        # Slides count in characteristic lengths; otherwise the unit of length would decide which
        # positions are singular.
        self.row_scale = self._length ** sliding[:, None] if np.any(sliding) else None
        self.known_scale = self._length ** slides[group.known][:, None]

    def evaluate(
        self,
        x: Array,
        reduction: Reduction,
        turns: Array | None = None,
        inverse: Array | None = None,
        correction: Array | None = None,
    ) -> tuple[GroupState, Array]:
        """Return the closure equations at `x` and their reduced error `(N, R)`, closed or not.

        Args:
            x: `(N, size)` coordinates.
            reduction: the rows that are solved.
            turns: `(N, size)` whole turns that the angles in `x` lack; couplings count them.
            inverse: inverse at a position nearby; used where it is near enough.
            correction: `(N,)` how far the guess was off; zero if None.
        """
        equations = self.equations
        placed = self.batch.placed(x)
        actions = actions_of(placed)
        twists = equations.unit_twists.of(actions)
        rows = equations.rows(twists, actions, reduction)
        error, residual = equations.error(placed)
        slips = None
        if equations.couplings:
            slips = self._slips(x, turns)
            relative = np.abs(slips) / equations.slip_units
            residual = np.maximum(residual, relative.max(axis=1))
        if self.group.idle:
            spins = equations.rod_spins.rows(twists, equations.rod_spins.lines(actions))
            rows = np.concatenate([rows, spins], axis=2)
        inverse, null, condition = self._factors(rows[:, self.group.known.size :], inverse)
        state = GroupState(
            solver=self,
            reduction=reduction,
            x=x,
            actions=actions,
            twists=twists,
            rows=rows,
            inverse=inverse,
            null=null,
            residual=residual,
            condition=condition,
            correction=np.zeros(len(x)) if correction is None else correction,
        )
        return state, equations.project(error, slips, actions, reduction)

    def _factors(self, square: Array, inverse: Array | None) -> tuple[Array, Array, Array]:
        """Return inverses, null spaces and condition numbers of the passives' rows.

        Args:
            square: these rows, followed by the spins of idle rods, if any.
            inverse: see `evaluate`.
        """
        idle = len(self.group.idle)
        if inverse is not None and is_near(square, inverse, self.row_scale):
            null = np.zeros((len(square), square.shape[2] - idle, 0))
            return inverse, null, condition_numbers(square, inverse, self.row_scale)
        if idle:
            return factorised_with_spins(square, self.row_scale, idle)
        return factorised(square, self.row_scale)

    def linearised(self, x: Array) -> tuple[Array, Array, Array]:
        """Return all closure equations at `x (N, size)` about the welds, slides in lengths.

        Returns:
            Transposed closure matrices `(N, p, R)`, errors `(N, R)` and closure errors `(N,)`.
        """
        equations, known = self.equations, len(self.group.known)
        placed = self.batch.placed(x)
        twists = equations.unit_twists.of(actions_of(placed))
        rows, error = equations.at_welds(twists, placed)
        passive = rows[:, known:]
        if self.row_scale is not None:
            passive = passive * self.row_scale
        _, residual = equations.error(placed)
        slips = self._slips(x, None)
        if slips.size:
            residual = np.maximum(residual, np.max(np.abs(slips) / equations.slip_units, axis=1))
        return passive, np.concatenate([error, slips], axis=1), residual

    def moved(self, x: Array, step: Array) -> Array:
        """Return coordinates `(N, size)` after steps `(N, p)`, slides counted in lengths."""
        x = x.copy()
        self._moves.apply(x, step / self._scale)
        return x

    def open_reduction(self, x: Array) -> Reduction:
        """Return the rows that the joints of each loop can reach while the loops are open.

        A planar or spherical chain stays one however it is bent, so a few configurations suffice.
        Closed loops may reach fewer rows, never more.

        Args:
            x: `(size,)` coordinates of the joints that do not move.
        """
        key = x[self.batch.columns].tobytes()
        return self._kept.of("open reduction", key, lambda: self._open_reduction(x))

    def _open_reduction(self, x: Array) -> Reduction:
        """See `open_reduction`."""
        rows = np.repeat(x[None, :], OPEN_CONFIGURATIONS, axis=0)
        movable = self.equations.movable
        moves = self.coordinates.moves(movable)
        step = generic(OPEN_CONFIGURATIONS, len(movable))
        step[:, moves.slides] *= self._length
        moves.apply(rows, step)
        actions = self.batch.actions(rows)
        return self.equations.reduction(self.equations.unit_twists.of(actions), actions)

    def _steps(self, state: GroupState, error: Array) -> tuple[Array, Array]:
        """Return Newton's steps `(N, p)` from a state with its error `(N, R)`, see `evaluate`.

        And their greatest parts `(N,)` [rad], slides counted in lengths.
        """
        step = state.step(error)
        return step, np.maximum.reduce(np.abs(step * self._scale), axis=1, initial=0.0)

    def _bend(self, state: GroupState, step: Array, sizes: Array) -> Array:
        """Shorten Newton steps, and let them follow the curvature, where that is known.

        Args:
            state: where they begin.
            step: changed in place.
            sizes: see `_steps`.

        Returns:
            Errors `(N,)` after them, in order of magnitude [rad].
        """
        if not _greatest(sizes) <= LONGEST_STEP:
            step *= np.minimum(1.0, LONGEST_STEP / np.maximum(sizes, LONGEST_STEP))[:, None]
        left = _CURVATURE * sizes**2
        is_good = (sizes > _STRAIGHT) & (sizes <= _BENT)
        if not np.logical_or.reduce(is_good):
            return left
        bend = state.bend(step)
        bends = np.maximum.reduce(np.abs(bend * self._scale), axis=1)
        is_good &= bends <= _MOST_BENT * sizes
        # What a straight step leaves is the bend, and its error falls in the same ratio again; the
        # third power is that of sines, where steps happen to need no bend.
        ratio = bends / np.maximum(sizes, np.finfo(float).tiny)
        step += np.where(is_good[:, None], bend, 0.0)
        return np.where(is_good, ratio * bends + sizes**3, left)

    def newton(
        self,
        x: Array,
        reduction: Reduction,
        turns: Array | None = None,
        most: int = MOST_STEPS,
        leaves: float | None = None,
        settles: bool = False,
    ) -> GroupState:
        """Close the loops from a guess; the caller judges `residual` and `correction`.

        Args:
            x: `(N, size)` coordinates; those of the passives are corrected in place.
            reduction: the rows that are solved.
            turns: see `evaluate`.
            most: greatest number of Newton steps.
            leaves: error that may be left [rad]. Nothing is evaluated after a step that leaves
                less: what is known is from before it, but for the residual. None closes the loops
                as far as rounding lets them, as is done where equations outnumber unknowns.
            settles: whether idle rods are turned about their lines to where they settle, see
                `RodSpins.turned`.
        """
        settles = settles and bool(self.group.idle)
        state, error = self.evaluate(x, reduction, turns)
        if not self.group.passives.size:
            return state
        # Of more equations than unknowns only their evaluation tells whether steps lead anywhere.
        if leaves is not None and state.is_square:
            return self._near(state, error, x, turns, most, leaves)
        settling = np.zeros(len(x), dtype=bool) if settles else None
        state = self._from(state, error, x, turns, most, settling)
        if settles:
            # Whole turns of their joints depend on the way as well.
            columns = np.intersect1d(self.idle_columns, self.coordinates.angle_columns)
            x[:, columns] -= 2.0 * np.pi * np.rint(x[:, columns] / (2.0 * np.pi))
        return state

    def _from(
        self,
        state: GroupState,
        error: Array,
        x: Array,
        turns: Array | None,
        most: int,
        settling: Array | None = None,
    ) -> GroupState:
        """Take Newton steps from a state with its error `(N, R)`; see `newton`.

        Idle rods begin to turn where their loops are nearly closed, and are `settling (N,)` from
        then on: how far that opens the loops again says nothing about the guess. None leaves rods
        as they are.
        """
        reduction, correction = state.reduction, state.correction
        # By which idle rods are to be turned, if they are.
        angles, spins, spin = None, np.zeros(1), 0.0
        is_done = np.zeros(len(x), dtype=bool)
        for count in range(most if settling is None else most + _MOST_SETTLING):
            step, sizes = self._steps(state, error)
            counted = sizes
            if settling is not None:
                angles = self.equations.rod_spins.turned(state.actions)
                angles = np.clip(angles, -LONGEST_STEP, LONGEST_STEP)
                spins = np.maximum.reduce(np.abs(angles), axis=1)
                spin = _greatest(spins)
                counted = np.where(settling, 0.0, sizes)
                settling = settling | (sizes <= _NEARBY)
                angles[~settling] = 0.0
            if len(x) > 1:
                few = np.flatnonzero(~is_done)
                if not few.size:
                    break
                if few.size <= _FEW * len(x):
                    own, own_turns = x[few], None if turns is None else turns[few]
                    begun = None if settling is None else settling[few]
                    rest = own_turns, most - count, begun
                    later = self._from(state.of(few), error[few], own, *rest)
                    x[few] = own
                    return state.with_samples(few, later)
                # So a sample ends where it does whatever others are beside it.
                step[is_done] = sizes[is_done] = 0.0
                if angles is not None:
                    angles[is_done] = 0.0
            correction = correction + counted
            worst = _greatest(sizes)
            if not math.isfinite(worst):
                # Samples that are not finite leave the others alone.
                before, state = state, state._replace(correction=correction)
                few = np.flatnonzero(~is_done & np.isfinite(sizes))
                if not few.size:
                    return state
                own, own_turns = x[few], None if turns is None else turns[few]
                begun = None if settling is None else settling[few]
                rest = own_turns, most - count, begun
                later = self._from(before.of(few), error[few], own, *rest)
                x[few] = own
                return state.with_samples(few, later)
            if count >= most and _greatest(counted) > _STRAIGHT:
                break
            left = self._bend(state, step, sizes)
            if angles is not None:
                step += state.spun_back(angles)
            self._moves.apply(x, step)
            nearby = state.inverse if worst < _NEARBY and spin < _NEARBY else None
            state, error = self.evaluate(x, reduction, turns, nearby, correction)
            if settling is not None:
                # Steps that are mere rounding are as large as the condition makes them.
                unmoved = np.maximum(_UNMOVED, 10.0 * np.finfo(float).eps * state.condition)
                is_done = (sizes < unmoved) & (spins < _SETTLED)
                if np.logical_and.reduce(is_done):
                    break
            elif _greatest(left) <= _CONVERGED:
                break
            else:
                is_done = left <= _CONVERGED
        return state

    def _near(
        self,
        state: GroupState,
        error: Array,
        x: Array,
        turns: Array | None,
        most: int,
        leaves: float,
    ) -> GroupState:
        """Take Newton steps from a state with its error `(N, R)` until little is left.

        Each sample takes its steps whatever others are beside it.

        Returns:
            The state before the last step of each sample, whose residual is what that step leaves.
        """
        step, sizes = self._steps(state, error)
        left = self._bend(state, step, sizes)
        self._moves.apply(x, step)
        correction = state.correction + sizes
        is_near = (left <= leaves) & np.isfinite(state.condition)
        residual = np.minimum(left, state.residual)
        if np.logical_and.reduce(is_near):
            return state._replace(correction=correction, residual=residual)
        residual = np.where(is_near, residual, state.residual)
        state = state._replace(correction=correction, residual=residual)
        # Written so that what is not a number stops as well.
        rest = np.flatnonzero(~is_near & np.isfinite(sizes))
        if not rest.size or most <= 1:
            return state
        own, own_turns = x[rest], None if turns is None else turns[rest]
        later, error = self.evaluate(own, state.reduction, own_turns, None, correction[rest])
        later = self._near(later, error, own, own_turns, most - 1, leaves)
        x[rest] = own
        return later if rest.size == len(x) else state.with_samples(rest, later)

    @cached_property
    def idle_columns(self) -> Array:
        """Columns of rows that change when idle rods spin."""
        spinning = {rate for rod in self.group.idle for rate in rod.columns}
        return self.coordinates.columns_moved_by(np.array(sorted(spinning), dtype=int))

    def _slips(self, x: Array, turns: Array | None) -> Array:
        """Return how far the couplings are from ratio and offset `(N, G)` [rad or m]."""
        equations = self.equations
        if not equations.couplings:
            return np.zeros((len(x), 0))
        angles = x if turns is None else x + 2.0 * np.pi * turns
        columns = self.coordinates.column_of(equations.coupled_columns)
        slips = np.matmul(angles[:, None, columns], equations.coupled_ratios)[:, 0]
        return np.asarray(slips + equations.coupled_offsets)


def solver_of(mechanism: Mechanism, group: Group) -> GroupSolver:
    """Return the solver of a group, which all scenes of the mechanism share."""
    # A scene has as many groups as bodies at most: those of one fit in any case.
    most = MOST + mechanism.model.njoints
    return mechanism.kept.of("solver", group.key, lambda: GroupSolver(mechanism, group), most)


def _batch_model(mechanism: Mechanism, group: Group) -> BatchModel:
    """Return the model of a group's bodies."""
    at_zero = mechanism.placements_at_zero
    on_loops = [mechanism.loops[index].predecessor - 1 for index in group.loops]
    points = [at_zero[body].translation for body in on_loops or group.inertial_bodies]
    origin = np.mean(points, axis=0) if points else np.zeros(3)
    origin = at_zero[group.base].actInv(origin)
    return batch_model(
        mechanism, group.bodies, group.inertial_bodies, origin, group.base, group.crossed
    )


def _greatest(values: Array) -> float:
    """Return the greatest of sizes `(N,)`: of a single one, NumPy's function takes long."""
    return float(values[0]) if values.size == 1 else float(np.maximum.reduce(values, initial=0.0))


class GroupState(NamedTuple):
    """A group at given positions: its closure equations there and their factors.

    Attributes:
        solver: of the group.
        reduction: which rows of its closure equations were solved.
        x: `(N, size)` coordinates.
        actions: see `actions_of`.
        twists: `(N, m, 6)` unit twists of the movable coordinates.
        rows: `(N, m, R)` transposed closure matrices of the movable coordinates, known ones first.
            With k idle rods `(N, m, R + k)`: rates of these about their lines per unit of each
            coordinate follow.
        inverse: `(N, R, p)`: inverse of the passives' rows, or its pseudoinverse; with k idle rods
            `(N, R + k, p)`.
        null: `(N, R, R - p)`: multipliers that no passive effort feels, at each position.
        residual: `(N,)` closure error, see `ClosureEquations.error`.
        condition: `(N,)` condition number of `passive_rows`, slides counted in lengths.
        correction: `(N,)` how far the guess was off.
    """

    solver: GroupSolver
    reduction: Reduction
    x: Array
    actions: Array
    twists: Array
    rows: Array
    inverse: Array
    null: Array
    residual: Array
    condition: Array
    correction: Array

    @property
    def group(self) -> Group:
        """Its loops and joints."""
        return self.solver.group

    @property
    def batch(self) -> BatchModel:
        """Its bodies."""
        return self.solver.batch

    @property
    def equations(self) -> ClosureEquations:
        """Its closure equations."""
        return self.solver.equations

    @property
    def known_rows(self) -> Array:
        """Transposed closure matrices `(N, k, R)` of what is known."""
        known = self.solver.group.known.size
        return self.rows[:, :known, : self.rows.shape[2] - len(self.solver.group.idle)]

    @property
    def passive_rows(self) -> Array:
        """Transposed closure matrices `(N, p, R)` of the passives."""
        known = self.solver.group.known.size
        return self.rows[:, known:, : self.rows.shape[2] - len(self.solver.group.idle)]

    def of(self, samples: Array) -> GroupState:
        """Return the state of some samples, given by their indices."""
        return GroupState(self.solver, self.reduction, *(values[samples] for values in self[2:]))

    def with_samples(self, samples: Array, state: GroupState) -> GroupState:
        """Return the state with that of some samples, given by their indices; it is overwritten."""
        for values, own in zip(self[2:], state[2:], strict=True):
            # The rows of couplings are the same at all samples.
            if values.flags.writeable:
                values[samples] = own
        return self

    @property
    def scaled_rows(self) -> Array:
        """The passives' rows with slides counted in lengths, for decisions about rank."""
        scale = self.solver.row_scale
        return self.passive_rows if scale is None else self.passive_rows * scale

    @property
    def all_scaled_rows(self) -> Array:
        """The rows of what is known, then of the passives, slides counted in lengths."""
        known = self.known_rows * self.solver.known_scale
        return np.concatenate([known, self.scaled_rows], axis=1)

    @property
    def reachable(self) -> Reduction:
        """The rows that the loops' joints can reach at these positions together."""
        return self.equations.reduction(self.twists, self.actions)

    def same_side(self, inverse: Array) -> Array:
        """Return `(N,)` whether other positions lie on the same side of singular configurations.

        Args:
            inverse: of the closure equations at the other positions.
        """
        return same_side(self.square, inverse)

    @property
    def is_square(self) -> bool:
        """Whether there are as many equations, with those of idle rods, as passives."""
        return self.rows.shape[2] == self.solver.group.passives.size

    @property
    def square(self) -> Array:
        """The passives' rows, with the spins of idle rods behind those of the loops."""
        return self.rows[:, self.solver.group.known.size :]

    def _with_angles(self, right: Array, angles: Array) -> Array:
        """Return right-hand sides `(N, R)` of the loops, followed by those of idle rods."""
        whole = np.empty((len(right), self.inverse.shape[1]))
        whole[:, : right.shape[1]], whole[:, right.shape[1] :] = right, angles
        return whole

    @property
    def idle(self) -> Array:
        """Passive rates `(N, p, k)` that violate no equation: unit spins of idle rods."""
        unit = np.zeros((len(self.inverse), self.inverse.shape[1], len(self.group.idle)))
        unit[:, self.passive_rows.shape[2] :] = np.eye(len(self.group.idle))
        return refined(transposed(self.square), transposed(self.inverse), unit)

    def solve(self, right: Array) -> Array:
        """Solve the closure equations for passive rates: `(N, R, c)` to `(N, p, c)`.

        With idle rods, right-hand sides `(N, R + k, c)` end with rates about their lines.
        """
        return refined(transposed(self.square), transposed(self.inverse), right)

    def solve_transposed(self, right: Array) -> Array:
        """Solve for closure forces: passive efforts `(N, p, k)` to multipliers `(N, R, k)`."""
        return refined(self.square, self.inverse, right)[:, : self.passive_rows.shape[2]]

    def step(self, error: Array) -> Array:
        """Return Newton's step `(N, p)` that removes an error `(N, R)`, without spins of rods."""
        return -times(transposed(self.inverse)[:, :, : error.shape[1]], error)

    def bend(self, step: Array) -> Array:
        """Return what the curvature of the closure equations adds to Newton steps `(N, p)`.

        With it, the error falls with the third power of the step (Chebyshev's method).
        """
        equations = self.equations
        rates = np.zeros((len(step), len(equations.movable)))
        rates[:, len(self.group.known) :] = step
        left = equations.drift(self.twists, rates, closes=True)
        return 0.5 * self.step(equations.project(left, None, self.actions, self.reduction))

    def spun_back(self, angles: Array) -> Array:
        """Return steps `(N, p)` that turn idle rods back by angles `(N, k)` about their lines."""
        return -times(transposed(self.inverse)[:, :, -angles.shape[1] :], angles)

    def rates(self, known: Array) -> Array:
        """Return passive rates `(N, p, c)` for c sets of rates `(N, k, c)` of what is known.

        Idle rods do not turn about their lines.
        """
        return -self.solve(self._of_known(known))

    def accelerations(self, v: Array, known: Array) -> Array:
        """Return passive accelerations `(N, p)` at joint rates `v (N, nv)`.

        Args:
            v: joint rates.
            known: accelerations `(N, k)` of what is known.
        """
        v, equations = v[:, self.equations.movable], self.equations
        drift = equations.drift(self.twists, v)
        drift = equations.project(drift, None, self.actions, self.reduction)
        if self.group.idle:
            lines = equations.rod_spins.lines(self.actions)
            drift = self._with_angles(drift, equations.rod_spins.drift(self.twists, v, lines))
        return -self.solve(self._of_known(known[:, :, None]) + drift[:, :, None])[:, :, 0]

    def _of_known(self, known: Array) -> Array:
        """Return rates of the closure equations `(N, R, c)`, of those `(N, k, c)` of the known."""
        rows = self.rows[:, : self.group.known.size]
        return np.asarray(np.matmul(transposed(rows), known))

    def set_rates(self, v: Array) -> None:
        """Write the rates of the passives into joint rates `(N, nv, c)`, see `rates`."""
        v[:, self.group.passives] = self.rates(v[:, self.group.known])

    def set_accelerations(self, v: Array, a: Array) -> None:
        """Write the accelerations of the passives into those of all joints `(N, nv)`.

        Args:
            v: joint rates `(N, nv)`.
            a: joint accelerations, those of what is known, and the result.
        """
        a[:, self.group.passives] = self.accelerations(v, a[:, self.group.known])
