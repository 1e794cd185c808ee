"""All groups: the kinematics of a scene, from the drives to the last joint."""

from __future__ import annotations

from collections.abc import Hashable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....kit.arrays import Array
from ...mechanism.coordinates import Coordinates
from ..loops.groups import components
from .equations import Reduction
from .group_solver import MOST_CORRECTIONS, GroupSolver, GroupState
from .stacked import same_side


class ClosedState(NamedTuple):
    """A mechanism at positions whose loops are closed.

    Attributes:
        x: `(N, size)` coordinates.
        groups: the state of every group.
        residual: `(N,)` worst closure error, see `ClosureEquations.at`.
        condition: `(N,)` greatest condition number of a group's closure equations.
        correction: `(N,)` how far the guess was off.
    """

    x: Array
    groups: list[GroupState]
    residual: Array
    condition: Array
    correction: Array

    @property
    def inverses(self) -> list[Array]:
        """Inverses of every group's closure equations."""
        return [state.inverse for state in self.groups]


class Kinematics:
    """Solves the groups of a scene in the order of motion. It does not change after it is made.

    Attributes:
        coordinates: layout of coordinate rows.
        drives: velocity coordinates of the drives.
        solvers: one per group.
        reductions: per group, which rows it solves; all of them until the motion is known.
    """

    def __init__(
        self,
        coordinates: Coordinates,
        drives: Array,
        solvers: list[GroupSolver],
        reductions: list[Reduction] | None = None,
    ) -> None:
        """Make the kinematics.

        Args:
            coordinates: layout of coordinate rows.
            drives: velocity coordinates of the drives.
            solvers: one per group.
            reductions: per group; all rows if None.
        """
        self.coordinates = coordinates
        self.drives = drives
        self.solvers = solvers
        self.reductions = reductions or [solver.equations.full for solver in solvers]

    def with_reductions(self, reductions: list[Reduction]) -> Kinematics:
        """Return the same with other rows of every group."""
        return Kinematics(self.coordinates, self.drives, self.solvers, reductions)

    def part(self, drives: list[int], groups: list[int]) -> Kinematics:
        """Return the kinematics of some groups for some drives, both by their indices."""
        return Kinematics(
            self.coordinates,
            self.drives[drives],
            [self.solvers[index] for index in groups],
            [self.reductions[index] for index in groups],
        )

    def of_drive(self, rate: int) -> Kinematics:
        """Return the kinematics of what a single drive moves, by its velocity coordinate."""
        index = self.drives.tolist().index(rate)
        groups = [k for k, drives in enumerate(self._moving) if index in drives]
        return self.part([index], groups)

    @property
    def key(self) -> Hashable:
        """All that its results follow from besides the mechanism, as the key of a dictionary."""
        return (
            self.drives.tobytes(),
            *(solver.group.key for solver in self.solvers),
            *(reduction.key for reduction in self.reductions),
        )

    @property
    def moved(self) -> Array:
        """Velocity coordinates of the drives and of all passives."""
        return np.concatenate([self.drives, self.passives])

    @property
    def passives(self) -> Array:
        """Velocity coordinates of all passives."""
        none = np.zeros(0, dtype=int)
        return np.concatenate([none, *(solver.group.passives for solver in self.solvers)])

    @cached_property
    def idle_columns(self) -> Array:
        """Columns of rows that change when idle rods spin."""
        columns = [solver.idle_columns for solver in self.solvers if solver.group.idle]
        return np.concatenate([np.zeros(0, dtype=int), *columns])

    @cached_property
    def curving_columns(self) -> Array:
        """Columns of which others are polynomials, so that no turn of them is like another."""
        columns = [solver.curving_columns for solver in self.solvers]
        return np.concatenate([np.zeros(0, dtype=int), *columns])

    def independent_parts(self) -> list[tuple[list[int], list[int]]]:
        """Return sets of drives that meet in groups, with the groups whose passives they move.

        Drives and groups are given by their indices, ascending.
        """
        if len(self.drives) == 1:
            return [([0], list(range(len(self.solvers))))]
        moving = [drives.tolist() for drives in self._moving]
        met = {(one, other) for drives in moving for one in drives for other in drives}
        part_of = components(len(self.drives), met)
        return [
            (
                [drive for drive, own in enumerate(part_of) if own == part],
                [k for k, drives in enumerate(moving) if drives and part_of[drives[0]] == part],
            )
            for part in sorted(set(part_of))
        ]

    def with_open_reductions(self, x: Array) -> Kinematics:
        """Return the same with the rows that open loops can reach, see `GroupSolver`.

        Args:
            x: `(size,)` coordinates of the joints that do not move.
        """
        return self.with_reductions([solver.open_reduction(x) for solver in self.solvers])

    def close(
        self,
        x: Array,
        turns: Array | None = None,
        most: int = MOST_CORRECTIONS,
        settles: bool = False,
        within: float = np.inf,
    ) -> ClosedState:
        """Close all loops from guesses `x (N, size)`; the caller judges the result.

        Args:
            x: coordinates; kept as they are.
            turns: `(N, size)` whole turns that the angles in `x` lack.
            most: greatest number of Newton steps per group.
            settles: whether idle rods are turned about their lines to where they settle, so that
                their positions do not depend on the way there.
            within: correction from which on a guess is given up, whatever it leads to.
        """
        x = self.coordinates.normalised(x.copy())
        pairs = zip(self.solvers, self.reductions, strict=True)
        given = turns, most, settles, within
        return _joined(x, [solver.newton(x, reduction, *given) for solver, reduction in pairs])

    def evaluate(self, x: Array) -> ClosedState:
        """Return what is known at coordinates `x (N, size)` without changing them."""
        pairs = zip(self.solvers, self.reductions, strict=True)
        return _joined(x, [solver.evaluate(x, reduction) for solver, reduction in pairs])

    def rates(self, state: ClosedState, drive_rates: Array) -> Array:
        """Return joint rates `(N, nv)` for drive rates `(N, d)`; held joints rest.

        The state may be that of a single position, for N rates.
        """
        v = np.zeros((len(drive_rates), self.coordinates.model.nv, 1))
        v[:, self.drives, 0] = drive_rates
        return self._led(state, v, [np.zeros(1, dtype=int)] * len(state.groups))[:, :, 0]

    def velocity_ratios(self, state: ClosedState) -> Array:
        """Return joint rates `(N, nv, d)` per unit rate of each drive while the others rest."""
        drives = self.drives
        ratios = np.zeros((len(state.x), self.coordinates.model.nv, drives.size))
        ratios[:, drives, np.arange(drives.size)] = 1.0
        return self._led(state, ratios, self._moving)

    def _led(self, state: ClosedState, v: Array, columns: list[Array]) -> Array:
        """Return rates `(N, nv, c)` of the drives with those of all that these lead, in place.

        Args:
            state: closed positions, or a single one.
            v: rates; passives rest.
            columns: those that move each group.
        """
        for group_state, own in zip(state.groups, columns, strict=True):
            known, passives = group_state.group.known[:, None], group_state.group.passives[:, None]
            if passives.size:
                v[:, passives, own] = group_state.rates(v[:, known, own])
        return v

    @cached_property
    def depends(self) -> Array | None:
        """Which joint rates depend on which drives, `(nv, d)`; None if there is only one drive."""
        if len(self.drives) == 1:
            return None
        depends = np.zeros((self.coordinates.model.nv, len(self.drives)), dtype=bool)
        depends[self.drives, np.arange(len(self.drives))] = True
        for solver in self.solvers:
            depends[solver.group.passives] = np.any(depends[solver.group.known], axis=0)
        return depends

    @cached_property
    def _moving(self) -> list[Array]:
        """Per group, the drives (index) that move any of its passives."""
        if self.depends is None:
            return [np.zeros(1, dtype=int)] * len(self.solvers)
        return [
            np.flatnonzero(np.any(self.depends[solver.group.passives], axis=0))
            for solver in self.solvers
        ]

    def accelerations(self, state: ClosedState, v: Array, drive_accelerations: Array) -> Array:
        """Return joint accelerations `(N, nv)` at joint rates `v (N, nv)`; state as of `rates`."""
        a = np.zeros(v.shape)
        a[:, self.drives] = drive_accelerations
        for group_state in state.groups:
            known, passives = group_state.group.known, group_state.group.passives
            if passives.size:
                a[:, passives] = group_state.accelerations(v, a[:, known])
        return a

    def same_side(self, state: ClosedState, inverses: list[Array]) -> Array:
        """Return `(N,)` whether other positions lie on the same side of singular configurations.

        Args:
            state: closed positions.
            inverses: of every group's closure equations at the other positions.
        """
        result = np.ones(len(state.x), dtype=bool)
        for group_state, inverse in zip(state.groups, inverses, strict=True):
            result &= same_side(group_state.square, inverse)
        return result


def _joined(x: Array, groups: list[GroupState]) -> ClosedState:
    """Return the state of all groups, each at the coordinates `x`."""
    residual, condition, correction = (
        np.maximum.reduce([np.full(len(x), least), *values])
        for least, values in (
            (0.0, [group.residual for group in groups]),
            (1.0, [group.condition for group in groups]),
            (0.0, [group.correction for group in groups]),
        )
    )
    return ClosedState(x, groups, residual, condition, correction)
