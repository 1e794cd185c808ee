"""Tape: the equations of a scene's samples, traced once and run for many of them side by side."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from copy import copy
from functools import cached_property
from itertools import chain, islice
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.bodies import Tree
from ..mechanics.elimination import THRESHOLD, Order
from ..mechanics.placements import placed
from ..mechanics.sample import Given, LinkForce, Roles, Solved, openings, solved
from ..mechanics.vectors import ZERO, Rotation, Vector, times, turned
from ..proof.residuals import SUM_ROUNDING
from ..tape import Program, Scalar, Trace, absolute, greater, is_zero, select, sqrt
from .inverse_dynamics import UNIQUE_TOLERANCE, Inputs

_EXACT = float(np.sqrt(EPS))
"""Newton step that leaves rounding: its square."""
_FAR = 1e-3
"""Newton step [rad, or lengths] that is left to the kinematics, which knows how far off a guess
may be: between dense samples, guesses are off by 1e-6."""


SAMPLES = 16
"""Samples that tell what statics leaves open."""


class LinkKind(NamedTuple):
    """What a tape knows of a wrench on a link.

    Attributes:
        body: index of the body that carries the link.
        rotation: of the link in the body; None where the wrench is in world axes.
        lever: from the body's frame to the point at which the force acts, in the tree's unit.
    """

    body: int
    rotation: Rotation | None
    lever: Vector


class Kind(NamedTuple):
    """Samples that a tape is traced for.

    Attributes:
        moves: whether drives have speeds or accelerations.
        links: of the wrenches on links.
        factored: links with factors on their mass.
        moves_alone: whether the motion is wanted without forces.
        is_closed: whether samples are closed up to rounding, so that no step is left to be made.
    """

    moves: bool
    links: tuple[LinkKind, ...]
    factored: tuple[str, ...]
    moves_alone: bool
    is_closed: bool = False


class Prescribed:
    """What is prescribed for samples, in rows as a tape takes them.

    Attributes:
        parts: arrays `(k, n)` of rows, or `(k, 1)` where they are the same for all samples.
    """

    def __init__(self, parts: Sequence[Array]) -> None:
        """Keep rows."""
        self.parts = parts

    @staticmethod
    def of(
        inputs: Inputs, links: Sequence[tuple[Array, Array]], offsets: Array, kind: Kind
    ) -> Prescribed:
        """Return the rows of samples but for their coordinates.

        Args:
            inputs: what is prescribed.
            links: force and moment `(n, 3)` or `(1, 3)` on each link of the kind.
            offsets: of couplings, `(c, n)`.
            kind: of the samples.
        """
        factors = (inputs.inertia[name][:, None] for name in kind.factored)
        given = [inputs.speeds, inputs.accelerations, inputs.gravity, inputs.loads]
        given += [vector for pair in links for vector in pair]
        return Prescribed([*(array.T for array in (*given, *factors)), offsets])

    def acting(self) -> Array:
        """Return which rows are not zero at some sample."""
        return np.concatenate([part.any(axis=1) for part in self.parts])

    def of_lanes(self, lanes: Array, count: int) -> Prescribed:
        """Return the rows of some of so many samples, by their indices."""
        return Prescribed(
            [part[:, lanes] if part.shape[1] == count else part for part in self.parts]
        )


class Found(NamedTuple):
    """What a tape finds of n samples, and what it says of itself.

    Attributes:
        rows: `(k, n)` all of it.
        failure: `(n,)` the tape holds where it is at most 1: the greater of the instability, and of
            Newton's last step and the closure error, beside rounding.
        instability: `(n,)` of the elimination, and a guess that is far off; infinite where the tape
            leaves out what acts.
        left_out: `(n,)` zero where the tape considers all that acts.
        unheld: `(n,)` number of a rod (from 1) that resists no moment, where one acts; else 0.
        error: `(n,)` closure error, see `Sweep.loop_residual`.
        condition: `(n,)` narrowness of the elimination, see `Eliminated`, or a condition number.
        x: `(n, size)` coordinates.
        v, a: velocities and accelerations `(n, nv)`.
        ratios: `(n, nv d)` velocity ratios.
        wrenches: `(n, 6 b)`.
        efforts: `(n, nv)` what drives and held joints exert.
        couplings: `(n, G)` moments.
        rests: `(n, G)` what is left of them beside those of teeth, see `Solved`.
    """

    rows: Array
    failure: Array
    instability: Array
    left_out: Array
    unheld: Array
    error: Array
    condition: Array
    x: Array
    v: Array
    a: Array
    ratios: Array
    wrenches: Array
    efforts: Array
    couplings: Array
    rests: Array

    def write(self, samples: Array, others: Array) -> None:
        """Write the rows of some samples, by their indices."""
        self.rows[:, samples] = others


class Equations:
    """The equations of a scene for one kind of samples: rows of numbers to rows of results.

    Attributes:
        tree, roles: the mechanism, and what its coordinates are.
        per_sample, uniform: columns of coordinates that differ between samples, and others.
        units: of coordinates, `(size,)`.
        wrenches, outputs: numbers of all wrenches, and of rows of results.
    """

    def __init__(
        self,
        tree: Tree,
        roles: Roles,
        kind: Kind,
        sizes: tuple[int, int, int],
        wrenches: Collection[int],
        varied: Collection[int],
    ) -> None:
        """Keep what they are of.

        Args:
            tree: the mechanism.
            roles: of its coordinates.
            kind: of the samples.
            sizes: numbers of all coordinates, wrenches and couplings of the mechanism.
            wrenches: indices of those that are wanted: of bodies, then of `fixed` loops.
            varied: columns of held joints that differ from sample to sample.
        """
        self.tree, self.roles, self._kind, self._sizes = tree, roles, kind, sizes
        self._wanted = set(wrenches)
        moving = {*roles.passives, *roles.drives}
        columns = {
            column
            for body in tree.bodies
            if moving.issuperset(body.rates)
            for column in body.columns
        }
        columns = columns.union(varied)
        self.per_sample = np.array(sorted(columns), dtype=int)
        self.uniform = np.array(sorted(set(range(sizes[0])) - columns), dtype=int)
        self.units = tree.coordinate_units(sizes[0]).tolist()
        rates, (_, forces, couplings) = len(tree.units), sizes
        self.wrenches = forces
        counts = [sizes[0], rates, rates, rates * len(roles.drives), 6 * forces, rates]
        counts += couplings, couplings
        if kind.moves_alone:
            counts[3:] = [0] * len(counts[3:])
        self._singles = singles = len(Found._fields) - 1 - len(counts)
        ends = np.cumsum([singles, *counts]).tolist()
        self.outputs = ends[-1]
        places = *range(singles), *map(slice, ends, ends[1:])
        self._places = [(slice(None), place) for place in places]

    @property
    def links(self) -> tuple[LinkKind, ...]:
        """What is known of the wrenches on links."""
        return self._kind.links

    @property
    def are_stressed(self) -> bool:
        """Whether there is any self-stress of forces that are wanted."""
        wanted = self._wanted and not (self.roles.efforts_alone or self._kind.moves_alone)
        return bool(wanted) and any(
            block.is_balanced and len(block.rows) > len(block.passives)
            for block in self.roles.blocks
        )

    def on(self, tree: Tree, links: tuple[LinkKind, ...]) -> Equations:
        """Return the same of a tree and of links of other numbers."""
        result = copy(self)
        result.tree, result._kind = tree, self._kind._replace(links=links)
        return result

    def given(self, rows: Iterator[Scalar], x: Sequence[Scalar]) -> Given:
        """Return what is given at a sample.

        Args:
            rows: what is prescribed, in the order of `Prescribed`.
            x: coordinates.
        """
        tree, roles = self.tree, self.roles
        length, units = tree.length, tree.units.tolist()

        def vector(unit: float) -> Vector:
            """Return the next three rows, in the tree's unit."""
            return times(tuple(islice(rows, 3)), 1.0 / unit)

        def in_tree(of: Vector) -> Vector:
            """Return a vector in world axes in those of the tree."""
            return turned(tuple(map(tuple, tree.axes.tolist())), of)

        speeds, accelerations = (
            [next(rows) * (1.0 / units[rate]) for rate in roles.drives] for _ in range(2)
        )
        gravity = in_tree(vector(length))
        efforts = tree.effort_units.tolist()
        loads = {rate: next(rows) * (1.0 / unit) for rate, unit in enumerate(efforts)}
        forces = []
        for link in self._kind.links:
            force, moment = vector(length), vector(length**2)
            if link.rotation is None:
                force, moment = in_tree(force), in_tree(moment)
            forces.append(LinkForce(*link, force, moment))
        factors = dict(zip(self._kind.factored, rows, strict=False))
        offsets = list(islice(rows, len(tree.couplings)))
        in_units = {column: x[column] * (1.0 / unit) for column, unit in enumerate(self.units)}
        loads = {rate: load for rate, load in loads.items() if not is_zero(load)}
        return Given(in_units, speeds, accelerations, gravity, loads, forces, factors, offsets)

    def results(
        self,
        given: Given,
        x: Sequence[Scalar],
        order: Order,
        left_out: Scalar,
        rounding: float,
    ) -> list[Scalar]:
        """Return what is found at a sample, in the order of `Found`.

        Args:
            given: at the sample.
            x: coordinates.
            order: of the elimination.
            left_out: see `Found`.
            rounding: error up to which loops count as closed, in units of the tree.

        Raises:
            UnsuitableError: see `reactions.closed`.
        """
        kind = self._kind
        found = solved(self.tree, self.roles, given, order, kind.is_closed, kind.moves_alone)
        error = found.error / self.tree.norm_length
        # Exactly 1 at the greatest that is allowed.
        unstable = greater(found.growth * THRESHOLD, found.narrowness / REGULAR_CONDITION)
        unheld: Scalar = 0.0
        for number, of_rod in enumerate(found.unheld, 1):
            unheld = select(of_rod, float(number), unheld)
        unstable = select(unheld, np.inf, greater(unstable, found.step / _FAR))
        unstable = select(left_out, np.inf, unstable)
        inexact = greater(error / rounding, found.turned / SUM_ROUNDING)
        inexact = greater(found.step / _EXACT, inexact)
        judged = greater(unstable, inexact), unstable, left_out, unheld, error, found.narrowness
        return [*judged, *self.quantities(found, x)]

    def place(self, field: str) -> slice:
        """Return which rows of quantities a field of `Found` is, see `quantities`."""
        place = self._places[Found._fields.index(field) - 1][1]
        return slice(place.start - self._singles, place.stop - self._singles)

    def quantities(self, found: Solved, x: Sequence[Scalar]) -> list[Scalar]:
        """Return the quantities of `Found` in SI units; forces are zero where none is wanted.

        Of the motion alone, what follows accelerations has no rows.

        Args:
            found: at the sample.
            x: coordinates, also those that loops do not decide.
        """
        return [*chain.from_iterable(self._quantities(found, x))]

    def _quantities(self, found: Solved, x: Sequence[Scalar]) -> Iterator[Iterable[Scalar]]:
        tree, roles, wanted = self.tree, self.roles, self._wanted
        length, units, rates = tree.length, tree.units.tolist(), range(len(tree.units))
        closed = set(roles.columns(tree))
        yield (
            found.x[column] * self.units[column] if column in closed else value
            for column, value in enumerate(x)
        )
        yield (found.v.get(rate, 0.0) * units[rate] for rate in rates)
        yield (found.a.get(rate, 0.0) * units[rate] for rate in rates)
        if self._kind.moves_alone:
            return
        drives = [(ratios, units[r]) for ratios, r in zip(found.ratios, roles.drives, strict=True)]
        yield (of.get(r, 0.0) * (units[r] / unit) for r in rates for of, unit in drives)
        yield (
            component
            for index in range(self._sizes[1])
            for component in _in_si(found, index if index in wanted else -1, length)
        )
        efforts = tree.effort_units.tolist()
        has_efforts = wanted or roles.efforts_alone
        yield (found.exerted.get(r, 0.0) * efforts[r] if has_efforts else 0.0 for r in rates)
        for moments in (found.couplings, found.rests):
            every = [0.0] * self._sizes[2]
            for index, moment in moments.items():
                coupling = tree.couplings[index]
                joint = coupling.successors[:1]
                unit = efforts[joint[0]] if joint else length**2
                every[coupling.number] = moment * unit if wanted else 0.0
            yield every

    def rounding(self, x: Mapping[int, Array]) -> float:
        """Return the error up to which loops count as closed near some coordinates.

        It is that of as many sums of lengths as there are bodies, in units of the tree.
        """
        points = placed(self.tree, x).points
        farthest = max((np.abs(value).max() for point in points for value in point), default=0.0)
        return len(self.tree.bodies) * EPS * max(1.0, float(farthest))

    def found(self, rows: Array) -> Found:
        """Return rows of results `(k, n)` by their names."""
        samples = rows.T
        return Found(rows, *[samples[place] for place in self._places])

    def shares(self, given: Given, order: Order) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
        """Return shares of self-stresses in components of wrenches, and in couplings, by indices.

        What vanishes everywhere is left out.

        Arguments and errors as of `results`.
        """
        if self.roles.efforts_alone or self._kind.moves_alone:
            return {}, {}
        wrenches, couplings = openings(self.tree, self.roles, given, order)
        return (
            {
                6 * index + component: value
                for index, values in wrenches.items()
                for component, value in enumerate(values)
                if not is_zero(value)
            },
            {index: value for index, value in couplings.items() if not is_zero(value)},
        )


class Tape:
    """Equations for one order of elimination, traced.

    Attributes:
        equations: that it is of.
        order: of the elimination.
        acting: which rows of samples it considers; others have to be zero.
    """

    def __init__(self, equations: Equations, order: Order, shadows: Array, acting: Array) -> None:
        """Trace the equations.

        Args:
            equations: these.
            order: of the elimination.
            shadows: coordinates `(size, S)` at which orders are chosen, in units of the tree.
            acting: see the attribute.

        Raises:
            UnsuitableError: see `Equations.results`.
        """
        self.equations, self.order, self.acting = equations, order, acting
        self._shadows = shadows
        rounding = equations.rounding(dict(enumerate(shadows)))
        with Trace() as trace:
            given, x, left_out = self.traced(trace)
            outputs = equations.results(given, x, order, left_out, rounding)
            self._program = Program(trace, outputs, keeps_inputs=True)

    def traced(self, trace: Trace) -> tuple[Given, list[Scalar], Scalar]:
        """Return what is given at a sample, its coordinates in SI units, and what is left out.

        Prescribed become inputs in their order, those of coordinates behind them.
        """
        equations = self.equations
        left_out: Scalar = 0.0
        every: list[Scalar] = []
        for index, acts in enumerate(self.acting.tolist()):
            value = trace.input(f"r{index}", 1.0)
            every.append(value if acts else 0.0)
            left_out = left_out if acts else greater(left_out, absolute(value))
        x: list[Scalar] = [0.0] * len(self._shadows)
        units = equations.tree.coordinate_units(len(x))
        for columns, is_uniform in (equations.per_sample, False), (equations.uniform, True):
            for column in columns.tolist():
                shadow = self._shadows[column] * units[column]
                x[column] = trace.input(f"x{column}", shadow, uniform=is_uniform)
        return equations.given(iter(every), x), x, left_out

    def run(self, rows: Prescribed, x: Array) -> Found:
        """Solve n samples.

        Args:
            rows: what is given.
            x: `(size, n)` coordinates near closed ones.
        """
        return self.equations.found(self._program.run_rows(self.with_x(rows, x), x.shape[1]))

    def openings(self, rows: Prescribed, x: Array) -> tuple[Array, set[int]]:
        """Return what statics leaves open at closed samples.

        Arguments as of `run`.

        Returns:
            `(b, 6)` the greatest influence of self-stresses on each component, see
            `Solution.influence`; and the couplings (index) whose moments are not unique.
        """
        program, couplings = self._opened
        components = 6 * self.equations.wrenches
        if program is None:
            return np.zeros((self.equations.wrenches, 6)), set()
        shares = program.run_rows(self.with_x(rows, x), x.shape[1])
        greatest = np.maximum.reduce(shares, 1)
        of_couplings = zip(couplings, greatest[components:].tolist(), strict=True)
        is_open = {number for number, share in of_couplings if share > UNIQUE_TOLERANCE}
        return greatest[:components].reshape(-1, 6), is_open

    @cached_property
    def _opened(self) -> tuple[Program | None, list[int]]:
        """Influences on all components, then on couplings, as a program; which couplings these are.

        None where nothing is open.
        """
        with Trace() as trace:
            wrenches, couplings = self.equations.shares(self.traced(trace)[0], self.order)
            every = [wrenches.get(index, 0.0) for index in range(6 * self.equations.wrenches)]
            every += couplings.values()
            numbers = [self.equations.tree.couplings[index].number for index in couplings]
            if not (wrenches or couplings):
                return None, numbers
            outputs = [sqrt(absolute(share)) for share in every]
            return Program(trace, outputs, keeps_inputs=True), numbers

    def with_x(self, rows: Prescribed, x: Array) -> list[Array]:
        """Return rows with those of coordinates `(size, n)` behind them."""
        equations = self.equations
        uniform = x[:, :1].take(equations.uniform, 0)
        return [*rows.parts, x.take(equations.per_sample, 0), uniform]


def _in_si(found: Solved, index: int, length: float) -> Iterator[Scalar]:
    """Yield the components of a wrench in SI units; zeros of one that is not wanted."""
    if index < 0:
        yield from [0.0] * 6
        return
    force, moment = found.fixed.get(index) or found.wrenches.get(index, (ZERO, ZERO))
    yield from times(force, length)
    yield from times(moment, length**2)
