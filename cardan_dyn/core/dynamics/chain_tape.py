"""Chain tape: the accelerations of a chain, and what closes its loops, as traced programs.

A tape has an order of elimination: which coordinates are independent. At each state it says by
which ratios the others move, and how strong closure equations are beside elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ..mechanics import closure
from ..mechanics.bodies import Tree, tree_of
from ..mechanics.constrained import Carried, Free, triangle
from ..mechanics.elimination import UnsuitableError
from ..mechanics.placements import moved, normalised, placed, stepped
from ..mechanism.mechanism import Mechanism
from ..tape import Program, Scalar, Trace, greater

_GROWTH = 100.0
"""Greatest ratio of rates up to which independent coordinates suit a state: as many times rounding
is the error of accelerations."""
_NARROW = 30.0
"""Ratio of a pivot's size elsewhere to its own beyond which closure equations are looked at."""
_LIGHT = 1e11
"""Inertia along a way, over what is left of it beside other ways, beyond which there is none."""


class ChainTapes:
    """The tapes of a chain, by orders of elimination; not for several threads.

    Attributes:
        made: those that were asked for; None of an order that suits no state.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        bodies: tuple[int, ...],
        prescribed: Sequence[int],
        gravity: Array,
        places: Array,
        resting: Sequence[int] | None = None,
    ) -> None:
        """Read the chain, and trace nothing yet.

        Args:
            mechanism: that the chain is part of; its tapes share programs.
            bodies: of the chain, in the mechanism's model.
            prescribed: velocity coordinates of the chain that are driven or held.
            gravity: `(3,)` [m/s²].
            places: coordinates `(P, size)` of the chain at which pivots have their usual sizes.
            resting: where others carry what is prescribed, see `Carried`.
        """

        def read() -> Tree:
            return tree_of(mechanism).part([body - 1 for body in bodies])

        kept = self._kept = mechanism.kept
        self._tree = kept.of("chain trees", bodies, read)
        self._prescribed, self._gravity, self._places = prescribed, gravity, places
        self._resting = resting
        self._programs: dict[Any, _Programs] = kept.of("chain tapes", gravity.tobytes(), dict)
        self._key = bodies, tuple(prescribed), resting and tuple(resting)
        self._columns = sorted(column for body in self._tree.bodies for column in body.columns)
        self._rates = sorted(rate for body in self._tree.bodies for rate in body.rates)
        self.made: dict[tuple[tuple[int, ...], ...], ChainTape | None] = {}

    def of(self, *dependent: tuple[int, ...]) -> ChainTape | None:
        """Return the tape of an order of elimination; None if it suits no state.

        Args:
            dependent: velocity coordinates that the others decide, in that order; and those
                while others carry what is prescribed.
        """
        if dependent not in self.made:
            self.made[dependent] = None
            with suppress(UnsuitableError):
                self.made[dependent] = self._traced(dependent)
        return self.made[dependent]

    def _traced(self, dependent: tuple[tuple[int, ...], ...]) -> ChainTape:
        key, tree, prescribed = (*self._key, dependent), self._tree, self._prescribed
        resting, first = self._resting, dependent[0]
        carried = None if resting is None else Carried(resting, dependent[1])
        programs = self._programs.get(key)
        if programs is None:
            programs = _Programs(tree, prescribed, self._gravity, first, carried)
            self._programs[key] = programs

        def sizes() -> Array:
            found = _pivot_sizes(tree, prescribed, first, self._places)
            if carried:
                found = np.append(found, _pivot_sizes(tree, *carried, self._places))
            return found

        return ChainTape(
            programs, self._kept.of("pivot sizes", (*key, self._places.tobytes()), sizes)
        )

    def sparse_first(self, dependent: Sequence[int]) -> tuple[int, ...]:
        """Return velocity coordinates in an order of elimination: few closure rows first."""
        x = dict.fromkeys(self._columns, 0.0)
        rows = closure.rows(self._tree, placed(self._tree, x), dependent)
        return tuple(sorted(dependent, key=lambda rate: (sum(rate in row for row in rows), rate)))

    def unit(self, x: Array) -> Array:
        """Return coordinates `(size,)` of the chain with quaternions of unit length."""
        return self._row(normalised, x)

    def gains(self, x: Array, v: Array) -> Array:
        """Return the rates of coordinates `(size,)` at velocities `(nv,)` of the chain."""
        return self._row(moved, x, dict(zip(self._rates, v, strict=True)))

    def _row(self, of_body: Callable[..., Mapping[int, Any]], x: Array, *more: Any) -> Array:
        """Return a row of what is known of the coordinates of each body."""
        own = dict(zip(self._columns, x, strict=True))
        found: dict[int, Any] = {}
        for body in self._tree.bodies:
            found.update(of_body(body, own, *more))
        return np.array([found[column] for column in self._columns])


class _Programs:
    """Programs of a chain for one order of elimination; they serve all who ask.

    Their inputs are coordinates, velocities, sizes of pivots elsewhere, prescribed accelerations
    and efforts; the last of their outputs how great doubts are, all of them and those that another
    order makes smaller: up to 1 there are none.

    Attributes:
        rates: of coordinates, of velocities, and the doubts.
        closer: coordinates and velocities after a step of Newton's method, the closure error before
            it, and the doubts.
        count, prescribed: numbers of velocity coordinates, and of those that are prescribed.
    """

    def __init__(
        self,
        tree: Tree,
        prescribed: Sequence[int],
        gravity: Array,
        dependent: Sequence[int],
        carried: Carried | None,
    ) -> None:
        """Trace the equations.

        Args:
            tree: the chain.
            prescribed: velocity coordinates of it that are driven or held.
            gravity: `(3,)` [m/s²].
            dependent: those that the others decide, in the order of elimination.
            carried: see `Free.of`.

        Raises:
            UnsuitableError: closure rows do not decide these, or a way moves no mass.
        """
        units, of_efforts = tree.units.tolist(), tree.effort_units.tolist()
        columns = sorted(column for body in tree.bodies for column in body.columns)
        rates = sorted(rate for body in tree.bodies for rate in body.rates)
        of_columns = dict.fromkeys(columns, 1.0)
        of_columns |= {b.column: tree.length for b in tree.bodies if b.kind == "prismatic"}
        self.count, self.prescribed = len(rates), len(prescribed)
        trace = Trace()

        def inputs(name: str, keys: Sequence[int], units: Any) -> dict[int, Scalar]:
            return {key: trace.input(f"{name}{key}", 1.0) * (1.0 / units[key]) for key in keys}

        x, v = inputs("x", columns, of_columns), inputs("v", rates, units)
        sizes = [*inputs("s", dependent, [1.0] * len(units)).values()]
        if carried:
            sizes += inputs("w", carried.dependent, [1.0] * len(units)).values()
        told, efforts = inputs("a", prescribed, units), inputs("e", rates, of_efforts)
        for body in tree.bodies:
            x |= normalised(body, x)
        free = Free.of(tree, x, v, told, dependent, sizes, carried)
        unsuited = greater(free.growth * (1.0 / _GROWTH), free.lightness * (1.0 / _LIGHT))
        doubts = greater(unsuited, free.narrowness * (1.0 / _NARROW)), unsuited
        a = free.accelerations(tuple(tree.in_axes(gravity / tree.length).tolist()), efforts)
        gains: dict[int, Scalar] = {}
        for body in tree.bodies:
            gains |= moved(body, x, v)
        outputs = [gains[column] * of_columns[column] for column in columns]
        outputs += [a.get(rate, 0.0) * units[rate] for rate in rates]
        self.rates = Program(trace, [*outputs, *doubts], keeps_inputs=True)
        step, change = free.displacement(), free.slowing()
        near: dict[int, Scalar] = dict(x)
        for body in tree.bodies:
            if told.keys().isdisjoint(body.rates):
                near |= stepped(body, x, {rate: step.get(rate, 0.0) for rate in body.rates})
        outputs = [near[column] * of_columns[column] for column in columns]
        outputs += [(v[rate] + change.get(rate, 0.0)) * units[rate] for rate in rates]
        self.closer = Program(trace, [*outputs, free.error, *doubts], keeps_inputs=True)


class ChainTape:
    """Programs of a chain, and how great its pivots are elsewhere; not for several threads."""

    def __init__(self, programs: _Programs, sizes: Array) -> None:
        """Keep both."""
        self._program, rates = programs.rates, programs.count
        self._find_rates, self._find_closer = programs.rates.of_one(), programs.closer.of_one()
        self._row = np.zeros(len(programs.rates.inputs))
        last = len(self._row) - rates
        told = last - programs.prescribed
        places = (told - len(sizes) - rates, told - len(sizes), told, last, len(self._row))
        self._x, self._v, of_sizes, self._told, self._efforts = (
            self._row[first:end] for first, end in pairwise((0, *places))
        )
        of_sizes[:] = sizes

    def rates(
        self, x: Array, v: Array, told: Array, efforts: Array, at_last: bool = False
    ) -> Array | None:
        """Return rates `(size + nv,)` of coordinates and velocities; None if it does not suit.

        Args:
            x: coordinates `(size,)`.
            v: velocities `(nv,)`.
            told: accelerations of prescribed coordinates `(p,)`.
            efforts: `(nv,)` along all coordinates.
            at_last: whether this is the best order, however weak equations are.
        """
        self._x[:], self._v[:], self._told[:], self._efforts[:] = x, v, told, efforts
        found = self._find_rates(self._row)
        return found[:-2] if found.item(-1 if at_last else -2) <= 1.0 else None

    def traced(self) -> tuple[Any, Array, Array] | None:
        """Return the rates while nothing acts or is told to move, see `Traced`."""
        handle, row = self._program.single, self._row.copy()
        row[-(len(self._told) + len(self._efforts)) :] = 0.0
        return None if handle is None else (handle, row, np.empty(self._program.outputs))

    def closer(
        self, x: Array, v: Array, at_last: bool = False
    ) -> tuple[Array, Array, float] | None:
        """Return a state nearer to a closed one, and the closure error of this one.

        Velocities are those after which loops stay closed here. Arguments, and None, as of
        `rates`.
        """
        self._x[:], self._v[:] = x, v
        found = self._find_closer(self._row)
        if not found.item(-1 if at_last else -2) <= 1.0:
            return None
        return found[: len(x)], found[len(x) : -3], found.item(-3)


def _pivot_sizes(
    tree: Tree, prescribed: Sequence[int], dependent: Sequence[int], places: Array
) -> Array:
    """Return the sizes of pivots `(r,)` at places `(P, size)`: medians.

    Arguments else as of `_Programs`.
    """
    columns = sorted(column for body in tree.bodies for column in body.columns)
    slides = {body.column for body in tree.bodies if body.kind == "prismatic"}
    x = {
        column: values / tree.length if column in slides else values
        for column, values in zip(columns, places.T, strict=True)
    }
    free = {rate for body in tree.bodies for rate in body.rates} - {*prescribed}
    rows = triangle(closure.rows(tree, placed(tree, x), free), dependent)
    return np.array([np.median(np.abs(row[column])) for column, row in rows])
