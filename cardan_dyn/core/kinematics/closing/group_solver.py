"""Group solver: close the loops of a group for many samples at once, and find its rates.

Newton's method on whole arrays. The inverse of the last position serves the rates and the closure
forces as well, after one step of refinement.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....kit.arrays import EPS, Array, generic
from ...mechanism.kept import MOST, Kept
from ...mechanism.mechanism import Mechanism
from ..loops.groups import Group
from ..tolerances import CLOSURE_TOLERANCE, CONFIGURATIONS, SINGULAR_CONDITION
from .equations import ClosureEquations, Reduction, equations_of
from .stacked import factorised, refined, times, transposed

LONGEST_STEP = 0.5
"""Greatest Newton step [rad]: farther away, a full step may end in another assembly mode. Over half
a radian, sines differ from their linearisation by 4 %."""
MOST_CORRECTIONS = 12
"""Newton steps of a guess. Each squares its error, so one that takes more was none."""
MOST_STEPS = 100
"""Steps that a guess gets unless the caller says otherwise. From nearby a few suffice, since each
squares the error; from afar many are short, as in narrow curved valleys of the error."""


class GroupSolver:
    """Closes the loops of a group for many samples by Newton's method on whole arrays.

    It does not change after it is made: which rows are redundant is an argument of its methods.

    Attributes:
        group: what it solves.
        coordinates: layout of coordinate rows.
        equations: its closure equations.
        movable: `(m,)` velocity coordinates that may move, known ones first, then passives.
        row_scale: `(p, 1)` lengths for the rows of slides, or None where nothing slides.
        known_scale: `(k, 1)` likewise for what is known.
    """

    def __init__(self, mechanism: Mechanism, group: Group) -> None:
        self.group = group
        self._kept = Kept()
        self.coordinates = coordinates = mechanism.coordinates
        self.equations = equations = equations_of(mechanism, group)
        self.curving_columns = mechanism.curving_columns
        self._moves = coordinates.moves(group.passives)
        self.movable = np.concatenate([group.known, group.passives])
        self._own_rows = [equations.rates.index(rate) for rate in self.movable.tolist()]
        sliding = equations.slides[group.passives]
        # Slides count in characteristic lengths; otherwise the unit of length would decide which
        # positions are singular.
        self._scale = equations.length ** -sliding.astype(float)
        self.row_scale = equations.length ** sliding[:, None] if np.any(sliding) else None
        self.known_scale = equations.length ** equations.slides[group.known][:, None]

    def evaluate(self, x: Array, reduction: Reduction, turns: Array | None = None) -> GroupState:
        """Return the closure equations at `x`, closed or not.

        Args:
            x: `(N, size)` coordinates.
            reduction: the rows that are solved.
            turns: `(N, size)` whole turns that the angles in `x` lack; couplings count them.
        """
        rows, error, residual = self.equations.at(x, reduction, turns)
        rows = rows.take(self._own_rows, 1)
        passive = rows[:, self.group.known.size :]
        factors = factorised(passive, self.row_scale, len(self.group.idle))
        return GroupState(self, reduction, x, rows, error, *factors, residual, np.zeros(len(x)))

    def linearised(self, x: Array) -> tuple[Array, Array, Array]:
        """Return all closure equations at `x (N, size)` about the welds, slides in lengths.

        There, gaps and angles do not mix, so that the sum of their squares says how far the loops
        are from closed, wherever the origin is.

        Returns:
            Transposed closure matrices `(N, p, R)`, errors `(N, R)` and closure errors `(N,)`.
        """
        rows, error, residual = self.equations.at(x, self.equations.about_welds)
        rows = rows[:, self._own_rows[self.group.known.size :], : error.shape[1]]
        return rows if self.row_scale is None else rows * self.row_scale, error, residual

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

        def found() -> Reduction:
            step = generic(CONFIGURATIONS, len(self.movable))
            rows = self.coordinates.displaced(x, self.movable, step)
            return self.equations.reduction(rows, self.movable)

        key = x[self.equations.columns].tobytes()
        return self._kept.of("open reduction", key, found)

    def _sizes(self, step: Array) -> Array:
        """Return the greatest parts `(N,)` of steps `(N, p)` [rad], slides counted in lengths."""
        return np.maximum.reduce(np.abs(step * self._scale), axis=1, initial=0.0)

    def newton(
        self,
        x: Array,
        reduction: Reduction,
        turns: Array | None = None,
        most: int = MOST_CORRECTIONS,
        settles: bool = False,
        within: float = np.inf,
    ) -> GroupState:
        """Close the loops from a guess; the caller judges `residual` and `correction`.

        Each sample takes its steps whatever others are beside it.

        Args:
            x: `(N, size)` coordinates; those of the passives are corrected in place.
            reduction: the rows that are solved.
            turns: see `evaluate`.
            most: greatest number of Newton steps.
            settles: whether idle rods are turned about their lines to where they settle, see
                `spins`.
            within: correction from which on a sample is given up.
        """
        state = self.evaluate(x, reduction, turns)
        if not self.group.passives.size:
            return state
        state = self._stepped(state, np.arange(len(x)), x, turns, most, within=within)
        if settles and self.group.idle:
            # What is open stays as it is. Rods may have far to turn.
            (closed,) = np.nonzero(state.residual < CLOSURE_TOLERANCE)
            correction = state.correction.copy()
            state = self._stepped(state, closed, x, turns, MOST_STEPS, settles)
            state.correction[:] = correction
            # Whole turns of their joints depend on the way as well.
            columns = np.intersect1d(self.idle_columns, self.coordinates.angle_columns)
            x[:, columns] -= 2.0 * np.pi * np.rint(x[:, columns] / (2.0 * np.pi))
        return state._replace(x=x)

    def _stepped(
        self,
        state: GroupState,
        rest: Array,
        x: Array,
        turns: Array | None,
        most: int,
        settles: bool = False,
        within: float = np.inf,
    ) -> GroupState:
        """Return the state after steps of some samples (index), see `newton`."""
        now, correction = state if rest.size == len(x) else state.of(rest), state.correction
        before = np.full(len(x), np.inf)
        for _ in range(most):
            if not rest.size:
                break
            step = now.step(now.error)
            sizes = self._sizes(step)
            correction[rest] += sizes
            # What is not a number leaves the others alone.
            goes = np.isfinite(sizes)
            if not goes.all():
                now, rest, step, sizes = now.of(goes), rest[goes], step[goes], sizes[goes]
            step *= np.minimum(1.0, LONGEST_STEP / np.maximum(sizes, LONGEST_STEP))[:, None]
            # A step leaves its square, as much greater as the equations are badly conditioned.
            left = np.minimum(now.condition, SINGULAR_CONDITION) * sizes**2
            # Where loops are closed, a step that is no shorter than the one before is rounding.
            left[(sizes >= before[rest]) & (now.residual < CLOSURE_TOLERANCE)] = 0.0
            before[rest] = sizes
            if settles:
                angles = self.equations.turned(x[rest]).clip(-LONGEST_STEP, LONGEST_STEP)
                # The last columns turn rods back by their angles. Where a rod settles depends on
                # how its line lies, so each step turns it about that in proportion.
                step -= times(transposed(now.inverse)[:, :, -angles.shape[1] :], angles)
                spins = now.condition * np.maximum.reduce(angles**2, axis=1)
                left = np.maximum(spins, np.where(left > 0.0, sizes, 0.0))
            own = x[rest]
            self._moves.apply(own, step)
            x[rest] = own
            now = self.evaluate(x[rest], state.reduction, None if turns is None else turns[rest])
            state = state.with_samples(rest, now)
            goes = (left > EPS) & (correction[rest] < within)
            if not goes.all():
                now, rest = now.of(goes), rest[goes]
        return state._replace(correction=correction)

    @cached_property
    def idle_columns(self) -> Array:
        """Columns of rows that change when idle rods spin."""
        spinning = {rate for rod in self.group.idle for rate in rod.columns}
        return self.coordinates.columns_moved_by(np.array(sorted(spinning), dtype=int))


def solver_of(mechanism: Mechanism, group: Group) -> GroupSolver:
    """Return the solver of a group, which all scenes of the mechanism share."""
    # A scene has as many groups as bodies at most: those of one fit in any case.
    most = MOST + mechanism.model.njoints
    return mechanism.kept.of("solver", group.key, lambda: GroupSolver(mechanism, group), most)


class GroupState(NamedTuple):
    """A group at given positions: its closure equations there and their factors.

    Attributes:
        solver: of the group.
        reduction: which rows of its closure equations were solved.
        x: `(N, size)` coordinates.
        rows: `(N, m, R)` transposed closure matrices of the movable coordinates, known ones first;
            with k idle rods `(N, m, R + k)`, see `ClosureEquations.at`.
        error: `(N, R)`.
        inverse: `(N, R, p)`: inverse of the passives' rows, or its pseudoinverse; with k idle rods
            `(N, R + k, p)`.
        condition: `(N,)` condition number of `passive_rows`, slides counted in lengths.
        residual: `(N,)` closure error.
        correction: `(N,)` how far the guess was off.
    """

    solver: GroupSolver
    reduction: Reduction
    x: Array
    rows: Array
    error: Array
    inverse: Array
    condition: Array
    residual: Array
    correction: Array

    @property
    def group(self) -> Group:
        """Its loops and joints."""
        return self.solver.group

    @property
    def equations(self) -> ClosureEquations:
        """Its closure equations."""
        return self.solver.equations

    @property
    def passive_rows(self) -> Array:
        """Transposed closure matrices `(N, p, R)` of the passives."""
        return self.square[:, :, : self.error.shape[1]]

    def of(self, samples: Array) -> GroupState:
        """Return the state of some samples, given by their indices."""
        return GroupState(self.solver, self.reduction, *(values[samples] for values in self[2:]))

    def with_samples(self, samples: Array, state: GroupState) -> GroupState:
        """Return the state with that of some samples, given by their indices; it is overwritten."""
        if len(samples) == len(self.x):
            return state
        for values, own in zip(self[2:], state[2:], strict=True):
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
        known = self.rows[:, : self.group.known.size, : self.error.shape[1]]
        return np.concatenate([known * self.solver.known_scale, self.scaled_rows], axis=1)

    @property
    def reachable(self) -> Reduction:
        """The rows that the loops' joints can reach at these positions together."""
        return self.equations.reduction(self.x, self.solver.movable)

    @property
    def square(self) -> Array:
        """The passives' rows, with the spins of idle rods behind those of the loops."""
        return self.rows[:, self.group.known.size :]

    def solve(self, right: Array) -> Array:
        """Solve the closure equations for passive rates: `(N, R, c)` to `(N, p, c)`.

        With idle rods, right-hand sides `(N, R + k, c)` end with rates about their lines.
        """
        return refined(transposed(self.square), transposed(self.inverse), right)

    def step(self, error: Array) -> Array:
        """Return Newton's step `(N, p)` that removes an error `(N, R)`, without spins of rods."""
        return -times(transposed(self.inverse)[:, :, : error.shape[1]], error)

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
        own, movable = np.zeros_like(v), self.solver.movable
        own[:, movable] = v[:, movable]
        drift = self.equations.drift(self.x, own, self.reduction)
        return -self.solve(self._of_known(known[:, :, None]) + drift[:, :, None])[:, :, 0]

    def _of_known(self, known: Array) -> Array:
        """Return rates of the closure equations `(N, R, c)`, of those `(N, k, c)` of the known."""
        rows = self.rows[:, : self.group.known.size]
        return np.asarray(np.matmul(transposed(rows), known))
