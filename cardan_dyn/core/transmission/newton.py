"""Newton: a way of a transmission within a range, by steps of Newton's method from polynomials.

They only have to lead to the right assembly mode; what they miss, steps make good, each
of which doubles the digits. Whether it does, each position says of itself, by its last step.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations_with_replacement, product
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array, quaternion_product
from ...kit.errors import (
    AccuracyError,
    ArgumentError,
    AssemblyError,
    SingularConfigurationError,
    as_position,
    choices,
)
from ..kinematics.following.orders import Orders
from ..kinematics.loops.closure_blocks import closure_blocks, with_rods
from ..mechanics.bodies import Body, massless
from ..mechanics.elimination import THRESHOLD, Order
from ..mechanics.placements import stepped
from ..mechanics.sample import Position, Roles
from ..mechanism.kept import Kept
from ..tape import Program, Scalar, Stage, Stages, Trace, absolute, greater, select
from .way import SolvedWay, Way

_SAMPLES = 1000
"""Positions that polynomials are made from, and as many between them at which errors are
measured."""
_EXACT = float(np.sqrt(EPS))
"""Newton step that leaves rounding: its square."""
_NO_STEP = np.array(np.inf)
"""Whether a step holds, before there was one."""
MOST_STEPS = 6
"""Newton steps at most: they double the digits, and 2⁶ bits are more than a number has."""


class FitError(NamedTuple):
    """How far a way is off: the greatest of what was measured between its samples.

    Attributes:
        position: of coordinates [rad or m].
        jacobian: of their derivatives [1, m/rad, rad/m].
    """

    position: float
    jacobian: float


class FittedWay(Way):
    """A way that Newton's method goes within a range, from polynomials.

    All programs take what is given, `n` numbers, and all but `start` what is closed behind it.

    Attributes:
        low, high: `(n,)` the range of the given side [rad or m].
        start: to `m` coordinates near closed ones.
        steps: of each order of elimination, to these after a step of Newton's method, and whether
            it holds: at most 1 where they are closed. It takes the latter of the last step as well.
        slopes: of each order, to coordinates of the found side, and all derivatives row by row.
        values: to the former alone.
        error: how far it is off.
    """

    def __init__(self, solved: SolvedWay, low: Array, high: Array) -> None:
        """Make the programs.

        Args:
            solved: what they stand for.
            low: see the attributes.
            high: likewise.

        Raises:
            AccuracyError: Newton's method does not lead to all positions.
            AssemblyError, SingularConfigurationError: a position of the range is out of reach.
        """
        super().__init__(solved.given, solved.found)
        self.low, self.high = low, high
        random, size = np.random.default_rng(0), (_SAMPLES, len(low))
        ends = np.array(list(product((-1.0, 1.0), repeat=len(low))))
        fitted = np.concatenate([np.zeros((1, len(low))), np.cos(random.uniform(0, np.pi, size))])
        parts = np.concatenate([fitted, ends, random.uniform(-1.0, 1.0, size)])
        points = np.clip(0.5 * (low + high) + 0.5 * (high - low) * parts, low, high)
        known = _looked(solved, points)
        closed = _Closed(solved, points, (low, high))
        orders = closed.orders()
        bodies = closed.needed(orders)
        self.steps, self.slopes, (self.values, *_) = zip(
            *(closed.programs(order, bodies) for order in orders), strict=True
        )
        step, least, degree = max(map(_size, self.steps)), np.inf, 1
        while 2 * math.comb(len(low) + degree, degree) <= len(fitted):
            start = closed.start(bodies, degree, fitted)
            for most in range(1, MOST_STEPS + 1):
                cost = _size(start) + most * step
                if cost >= least:
                    break
                found, left = self._found(self._staged(start, most), points.T)
                off = np.abs(found[: len(low)].T - known[0]) / self.found.units
                if not len(left) and np.max(off) <= _EXACT:
                    least, self.start = cost, start
            if _size(start) + step >= least:
                break
            degree += max(1, degree // 2)
        if not np.isfinite(least):
            raise AccuracyError(
                f"Newton's method does not lead from polynomials in {choices(self.given.names)} to "
                f"{choices(self.found.names)} everywhere; give smaller ranges, farther from "
                "singular configurations",
                tolerance=_EXACT,
            )
        self._stages = self._staged(self.start, MOST_STEPS)
        errors = (np.abs(a - b) for a, b in zip(self.at(points), known, strict=True))
        self.error = FitError(*(float(np.max(each)) for each in errors))

    @property
    def programs(self) -> dict[str, Program]:
        """All programs by their names, those of an order with its number."""
        found = {"start": self.start, "values": self.values}
        for kind, every in ("step", self.steps), ("slopes", self.slopes):
            found |= {f"{kind}_{index}": program for index, program in enumerate(every)}
        return found

    def at(self, position: Array, held: object = None) -> tuple[Array, Array]:
        """See `Way.at`."""
        if held is not None:
            raise ArgumentError(
                "what is fitted holds joints where the scene does: fit that of "
                "scene.replace(held={...})"
            )
        inside = (position >= self.low) & (position <= self.high)
        if not inside.all():
            *_, k = np.argwhere(~inside)[0]
            raise ArgumentError(
                f"{self.given.names[k]} is {position[~inside][0]:.12g}, outside of the range "
                f"{self.low[k]:.12g} to {self.high[k]:.12g} that was fitted"
            )
        given = position.reshape(-1, len(self.low)).T
        found, left = self._found(self._stages, given)
        if len(left):
            lost = as_position(given[:, left[0]])
            raise AssemblyError(
                f"Newton's method does not close the loops at {lost} of "
                f"{choices(self.given.names)}; fit smaller ranges",
                position=lost,
            )
        values, slopes = found[: len(self.low)].T, found[len(self.low) :].T
        return values.reshape(position.shape), slopes.reshape(*position.shape, len(self.low))

    def _staged(self, start: Program, most: int) -> list[Stages]:
        """Return what leads to values and slopes, for each order, with so many steps at most."""
        closed, staged = start.outputs, []
        for step, slopes in zip(self.steps, self.slopes, strict=True):
            x = {name: row for row, name in enumerate(slopes.inputs[len(self.low) :])}
            stages = [
                Stage(start),
                Stage(step, {**x, "last": closed}, x, closed, most, 1.0, kept=True),
                Stage(slopes, taken=x, kept=True),
            ]
            staged.append(Stages(stages))
        return staged

    def _found(self, staged: Sequence[Stages], given: Array) -> tuple[Array, Array]:
        """Return values and slopes `(n + n², N)` at positions `(n, N)`, and those left (index)."""
        size, count = given.shape
        found, left = None, np.arange(count)
        for stages in staged:
            rows = np.ascontiguousarray(given if found is None else given[:, left])
            taken: list[Array | None] = [rows, *[None] * stages.stages[0].program.outputs]
            closed, result = stages.run_rows([[rows], [*taken, _NO_STEP], taken], len(left))
            holds = closed[-1] <= 1.0
            if found is None and holds.all():
                return result, left[:0]  # As most are.
            if found is None:
                found = np.full((size * (size + 1), count), np.nan)
            found[:, left[holds]] = result[:, holds]
            left = left[~holds]
            if not len(left):
                break
        assert found is not None
        return found, left


class _Closed:
    """Equations of a way, and its closed positions, from which programs are made.

    Attributes:
        x: `(N, size)` coordinates in units of the tree; the first is in the middle of the range.
    """

    def __init__(self, way: SolvedWay, points: Array, ends: tuple[Array, Array]) -> None:
        """Keep both, at positions `(N, n)` of the given side, between ends `(n,)`."""
        self._ends = ends
        mechanism, assembly = way.problem.mechanism, way.solver.assembly
        groups = [assembly.groups[index] for index in assembly.needed.motion]
        loops = [index for group in groups for index in group.loops]
        couplings = [index for group in groups for index in group.couplings]
        self._tree = with_rods(massless(mechanism, loops, couplings), mechanism, groups)
        blocks = closure_blocks([(group, False) for group in groups])
        of, sides = mechanism.coordinates, (way.given.names, way.found.names)
        self._given, self._found = map(of.columns_of, sides)
        drives, self._rates = (of.rates_of(names) for names in sides)
        self._roles = Roles(tuple(drives), (), blocks, ())
        motion = way.sweep(points).motion
        self._units = self._tree.coordinate_units(of.size)
        self.x = (motion.x + 2.0 * np.pi * motion.turns) / self._units

    def orders(self) -> list[Order]:
        """Return orders of elimination, each chosen where those before it serve worst."""
        scouts = self.x * self._units
        of = scouts, lambda: scouts, None, b"range", self._tree, self._roles, Kept()
        orders, growth, found = Orders(*of), np.full(len(self.x), np.inf), list[Order]()
        while np.max(growth) * THRESHOLD > 1.0 and (chosen := orders.at(len(found))):
            found.append(chosen.order)
            with np.errstate(all="ignore"):  # A pivot may vanish at a sample.
                position, _ = self._stepped(dict(enumerate(self.x.T)), chosen.order)
            growth = np.fmin(growth, position.factors.growth)
        return found

    def needed(self, orders: Sequence[Order]) -> list[Body]:
        """Return the passive bodies whose coordinates the found side depends on."""
        passives, needed = set(self._roles.passives), set(self._found)
        bodies = [body for body in self._tree.bodies if passives.issuperset(body.rates)]
        while True:
            own = [body for body in bodies if needed.intersection(body.columns)]
            columns, known = [column for body in own for column in body.columns], len(needed)
            for order in orders:
                with Trace() as trace:
                    position, after = self._stepped(self._inputs(trace, bodies), order)
                    outputs = [*map(after.__getitem__, columns), *self._slopes(position)]
                    program = Program(trace, outputs)
                needed |= {int(name) for name in program.inputs if name.isdigit()}
            if len(needed) == known:
                return own

    def programs(self, order: Order, bodies: list[Body]) -> tuple[Program, Program, Program]:
        """Return a step of Newton's method, and what it leads to, see `FittedWay`."""
        columns = [column for body in bodies for column in body.columns]
        rates = {rate for body in bodies for rate in body.rates}
        with Trace() as trace:
            position, after = self._stepped(self._inputs(trace, bodies), order)
            failure: Scalar = 0.0
            for column in columns:
                step = absolute(after[column] - position.x[column])
                failure = greater(failure, step * (1.0 / _EXACT))
            # The growth of what others do is none of theirs.
            steps = [step for step in position.factors.steps if step.column in rates]
            own = {step.row for step in steps}
            for step in steps:
                for row, factor in step.below:
                    if row in own:
                        size = order.sizes[step.row] / order.sizes[row] * THRESHOLD
                        failure = greater(failure, absolute(factor) * size)
            found = [position.x[column] * float(self._units[column]) for column in self._found]
            values = Program(trace, found, keeps_inputs=True)
            slopes = Program(trace, [*found, *self._slopes(position)], keeps_inputs=True)
            # Where it holds already, nothing changes any more.
            before = trace.input("last", np.inf)
            outputs = [
                select(before - 1.0, new, old)
                for new, old in (
                    *((after[column], position.x[column]) for column in columns),
                    (failure, before),
                )
            ]
            return Program(trace, outputs, keeps_inputs=True), slopes, values

    def start(self, bodies: Iterable[Body], degree: int, parts: Array) -> Program:
        """Return polynomials as far as coordinates go, see `FittedWay`.

        Args:
            bodies: whose coordinates they lead to.
            degree: of the polynomials.
            parts: `(S, n)` of the range, from -1 to 1, of the first samples.
        """
        middle = dict(enumerate(self.x[0].tolist()))
        terms = np.stack(np.broadcast_arrays(*_terms(parts.T, degree)), axis=1)
        low, high = self._ends
        with Trace() as trace:
            given = [trace.input(f"g{k}", 0.0) for k in range(len(low))]
            ranges = zip(
                given, (0.5 * (low + high)).tolist(), (2.0 / (high - low)).tolist(), strict=True
            )
            own = [*_terms([(x - at) * by for x, at, by in ranges], degree)]
            found: list[Scalar] = []
            for body in bodies:
                way = self._way(body)[: len(parts)]
                factors = np.linalg.lstsq(terms, way, rcond=None)[0].T.tolist()
                sums = [
                    sum((factor * term for factor, term in zip(row, own, strict=True)), 0.0)
                    for row in factors
                ]
                found += stepped(body, middle, dict(zip(body.rates, sums, strict=True))).values()
            return Program(trace, found, keeps_inputs=True)

    def _way(self, body: Body) -> Array:
        """Return the steps `(N, k)` that lead a body from the middle, see `placements.stepped`."""
        x = self.x[:, list(body.columns)]
        if body.kind != "spherical":
            return np.asarray(x - x[0])
        back = quaternion_product(x[:1] * (-1.0, -1.0, -1.0, 1.0), x)
        return np.asarray(2.0 * back[:, :3] / back[:, 3:])

    def _inputs(self, trace: Trace, bodies: Iterable[Body]) -> dict[int, Scalar]:
        """Return coordinates: what is given and those of bodies as inputs, others in the middle."""
        x: dict[int, Scalar] = dict(enumerate(self.x[0].tolist()))
        for k, column in enumerate(self._given):
            x[column] = trace.input(f"g{k}", 0.0) * (1.0 / float(self._units[column]))
        for body in bodies:
            for column in body.columns:
                x[column] = trace.input(str(column), x[column])
        return x

    def _stepped(self, x: Mapping[int, Scalar], order: Order) -> tuple[Position, dict[int, Scalar]]:
        """Return a position near a closed one, and coordinates after a step of Newton's method."""
        tree, roles = self._tree, self._roles
        offsets = [coupling.offset for coupling in tree.couplings]
        position = Position.of(tree, roles, x, offsets, order, settles=False)
        return position, position.corrected(tree, roles)[0]

    def _slopes(self, position: Position) -> list[Scalar]:
        """Return derivatives of the found side, row by row."""
        rates = [position.velocities({rate: 1.0}) for rate in self._roles.drives]
        units = self._units
        return [
            rate.get(own, 0.0) * float(units[found] / units[given])
            for found, own in zip(self._found, self._rates, strict=True)
            for rate, given in zip(rates, self._given, strict=True)
        ]


def _size(program: Program) -> int:
    """Return how many operations a program has."""
    return len(program.graph.operations) - len(program.graph.constants)


def _terms(parts: Iterable[Scalar], degree: int) -> Iterator[Scalar]:
    """Yield all products of numbers up to a degree."""
    for power in range(degree + 1):
        yield from map(math.prod, combinations_with_replacement(parts, power))


def _looked(way: SolvedWay, points: Array) -> tuple[Array, Array]:
    """Return what a way finds at positions of a range; see `FittedWay` for errors."""
    try:
        return way.at(points)
    except (AssemblyError, SingularConfigurationError) as error:
        raise type(error)(
            f"positions in the ranges of {choices(way.given.names)} are out of reach, such as "
            f"{error.position}; give smaller ranges: Transmission.borders tells where they end",
            position=error.position,
        ) from error
