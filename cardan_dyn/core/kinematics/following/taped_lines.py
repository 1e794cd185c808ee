"""Taped lines: many straight lines from one start, followed side by side on tapes.

Each sample has a line of its own, and nothing but the line decides its steps. Held joints move
first, then the drives. A line that no tape brings to its end is left to those who follow in
general, and say why it cannot be followed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial

import numpy as np

from ....kit.arrays import LARGE_BLOCK, Array, blocks, consecutive, neighbours
from ....kit.threads import in_threads
from ...mechanics.bodies import Tree, massless
from ...mechanics.elimination import Order
from ...mechanics.following import NEAR, Line, Place
from ...mechanics.sample import Roles
from ...mechanism.mechanism import Mechanism
from ...tape import LANES, Program, Scalar, Stage, Stages, Trace, select
from ..closing.all_groups import Kinematics
from ..closing.group_solver import MOST_STEPS
from ..loops.closure_blocks import closure_blocks, with_rods
from .orders import Orders

_MOST_TAPES = 2
"""Orders that are tried."""
_MOST_STEPS = 400
"""Steps of a line at most."""


class TapedLines:
    """Lines from one start, whose equations are traced when they are first followed."""

    def __init__(
        self,
        mechanism: Mechanism,
        kinematics: Kinematics,
        start: Array,
        legs: Sequence[Sequence[int]],
        orders: Callable[[Tree, Roles], Orders],
    ) -> None:
        """Begin without tapes.

        Args:
            mechanism: the mechanism.
            kinematics: of the drives and the groups that they move.
            start: `(size,)` closed coordinates.
            legs: sets of drives, by their indices, that move one after the other.
            orders: returns orders of elimination.
        """
        groups = [solver.group for solver in kinematics.solvers]

        def of_groups() -> Tree:
            loops = [index for group in groups for index in group.loops]
            couplings = [index for group in groups for index in group.couplings]
            return with_rods(massless(mechanism, loops, couplings), mechanism, groups)

        keys = tuple(group.key for group in groups)
        self._tree = tree = mechanism.kept.of("trees of lines", keys, of_groups)
        drives = tuple(kinematics.drives.tolist())
        self._roles = Roles(drives, (), closure_blocks([(group, True) for group in groups]), ())
        self._legs = legs
        self._units = tree.coordinate_units(len(start))
        self._begins, self._start = start, start / self._units
        self._columns = kinematics.coordinates.column_of(kinematics.drives)
        self._passives = np.array(self._roles.columns(tree), dtype=int)
        moving = {*self._columns.tolist(), *self._passives.tolist()}
        self._still = [column for column in range(len(start)) if column not in moving]
        self._from = self._start[self._columns]
        self._mechanism, self._find_orders = mechanism, orders
        self._key = self._roles, *map(tuple, legs)
        # Of each leg, the drives that have moved behind it, and those that move; and of its stages
        # what is given besides, or None where it is what the stage before found.
        still, x = self._start[self._still, None], self._start[self._passives, None]
        place = [None] * (len(x) + 2 * len(self._roles.passives) + len(self._roles.blocks))
        moved = np.zeros((len(drives), 1), dtype=bool)
        begins: list[Array | None] = [still, np.zeros(()), x]
        self._given: list[tuple[Array, Array, list[list[Array | None]]]] = []
        for leg in legs:
            moves = np.zeros_like(moved)
            moves[leg] = True
            moved = moved | moves
            self._given.append((moved, moves, [begins, [still, *place, np.ones((2, 1))]]))
            begins = [still, *[None] * (1 + len(x))]
        # The last stage goes on from where the last leg ends.
        self._given[-1][2].append([*begins, np.array(np.inf)])

    def ends(self, positions: Array) -> tuple[Array, Array]:
        """Return coordinates near closed ones at the ends of lines, and which these hold for.

        With positions `(N, d)` of the drives, to which lines lead [rad or m].

        Returns:
            `(N, size)`, off by rounding or by the square of `NEAR`; and `(N,)`.
        """
        x = self._begins[None, :].repeat(len(positions), axis=0)
        is_there = np.zeros(len(positions), dtype=bool)
        targets = positions / self._units[self._columns]
        for index in range(_MOST_TAPES):
            (rest,) = (~is_there).nonzero()
            chosen = self._orders.at(index, from_start=True) if len(rest) else None
            if chosen is None:
                break
            key = chosen.scene, index
            if key not in self._known:
                self._known.setdefault(key, self._stages(chosen.order))
            follow = partial(self._follow, self._known[key], targets, x, is_there)
            in_threads(follow, [rest[span] for span in blocks(len(rest), LARGE_BLOCK)])
        x[:, self._columns] = positions
        return x, is_there

    @cached_property
    def _orders(self) -> Orders:
        """Orders of elimination: the same for all scenes that move alike."""
        return self._find_orders(self._tree, self._roles)

    @cached_property
    def _known(self) -> dict[tuple[bytes, int], Stages]:
        """Stages of orders, by where these are chosen and which they are."""
        return self._mechanism.kept.of("lines", (self._key, self._orders.key), dict)

    def _follow(
        self, stages: Stages, targets: Array, x: Array, is_there: Array, own: Array
    ) -> None:
        """Write coordinates at ends of some of N lines, and which are there.

        Args:
            stages: that lead there.
            targets: `(N, d)` ends of the drives, as all coordinates in units of the tree.
            x: `(N, size)` coordinates [rad or m], of which passive ones are written.
            is_there: `(N,)`, written.
            own: indices of the lines.
        """
        ways = targets[own] - self._from
        # Lines to places near by take as many steps, and those of a block end together.
        order = neighbours(ways, LANES)
        own = own[order]
        ends, ways = targets[own].T, ways[order].T
        inputs = []
        for moved, moves, given in self._given:
            line = np.where(moved, ends, self._from[:, None]), moves * ways
            inputs += [[*line, *rest] for rest in given]
        (outputs,) = stages.run_rows(inputs, len(order))
        closed = outputs[:-1].T * self._units[self._passives]
        lines = consecutive(own)  # Of which slices are written at once.
        x[lines if isinstance(lines, slice) else own[:, None], self._passives] = closed
        is_there[own] = outputs[-1] <= NEAR

    def _stages(self, order: Order) -> Stages:
        """Return the stages that lead to the ends of lines."""
        roles = self._roles
        begins, lines, last = (
            self._program(text, order) for text in (self._begun, self._advanced, self._corrected)
        )
        x = {f"x{column}": row for row, column in enumerate(self._passives.tolist())}
        names = [*x, *(f"{kind}{rate}" for kind in "va" for rate in roles.passives)]
        names += [f"s{block}" for block in range(len(roles.blocks))]
        place = {name: row for row, name in enumerate(names)}
        rest, length, left = range(len(names), len(names) + 3)
        stages: list[Stage] = []
        for _ in self._legs:
            stages += [
                Stage(begins, taken={**x, "lost": rest} if stages else {}),
                Stage(
                    lines,
                    carried={**place, "rest": rest, "length": length},
                    taken=place,
                    until=left,
                    most=_MOST_STEPS,
                ),
            ]
        step = len(x)
        ends = Stage(
            last,
            carried={**x, "step": step},
            taken={**x, "lost": rest},
            until=step,
            most=MOST_STEPS,
            within=NEAR,
            kept=True,
        )
        return Stages([*stages, ends])

    def _program(self, text: Callable[[Trace, Line], Sequence[Scalar]], order: Order) -> Program:
        drives = self._columns.tolist()
        with Trace() as trace:
            ends, ways = (
                {column: trace.input(f"{kind}{column}", 0.0) for column in drives} for kind in "ew"
            )
            still = {
                column: trace.input(f"x{column}", value, uniform=True)
                for column, value in zip(self._still, self._start[self._still], strict=True)
            }
            line = Line(self._tree, self._roles, order, ends, ways, still)
            return Program(trace, text(trace, line), keeps_inputs=True)

    def _begun(self, trace: Trace, line: Line) -> list[Scalar]:
        """Return the rows of a place where lines begin; NaN where the leg before did not end."""
        lost = trace.input("lost", 0.0)
        x = {column: select(lost, np.nan, value) for column, value in self._inputs(trace).items()}
        return _rows(line.begun(x))

    def _advanced(self, trace: Trace, line: Line) -> list[Scalar]:
        """Return the rows of a place after a step, with what is left of the line."""
        passives = self._roles.passives
        v, a = ({rate: trace.input(f"{kind}{rate}", 0.0) for rate in passives} for kind in "va")
        sides = [trace.input(f"s{block}", 1.0) for block in range(len(self._roles.blocks))]
        place = Place(self._inputs(trace), v, a, sides)
        rest, length = trace.input("rest", 1.0), trace.input("length", 1.0)
        step = line.advanced(place, rest, length)
        return [*_rows(step.place), step.rest, step.length, step.left]

    def _corrected(self, trace: Trace, line: Line) -> list[Scalar]:
        """Return coordinates after a step at the end, and the step; NaN where none leads there."""
        lost = trace.input("lost", 0.0)
        x, step = line.corrected(self._inputs(trace), trace.input("step", np.inf))
        return [*x.values(), select(lost, np.nan, step)]

    def _inputs(self, trace: Trace) -> dict[int, Scalar]:
        return {column: trace.input(f"x{column}", 0.0) for column in self._passives.tolist()}


def _rows(place: Place) -> list[Scalar]:
    """Return what is known of a place, in a row."""
    return [*place.x.values(), *place.v.values(), *place.a.values(), *place.sides]
