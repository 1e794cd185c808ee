"""Kinematics: all groups of a scene, from the drives to the last joint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .closure import Reduction
from .coordinates import Array, Coordinates
from .solver import Closed, Solver


@dataclass(frozen=True, eq=False, repr=False)
class ClosedMechanism:
    """Positions whose loops are all closed.

    Attributes:
        x: `(N, size)` coordinates.
        groups: what each group's solver found.
        residual: `(N,)` worst closure error, see `Closure.error`.
        condition: `(N,)` greatest condition number of a group's closure equations.
        correction: `(N,)` how far the guess was off.
    """

    x: Array
    groups: list[Closed]
    residual: Array
    condition: Array
    correction: Array

    @property
    def inverses(self) -> list[Array]:
        """Inverses of every group's closure equations."""
        return [closed.inverse for closed in self.groups]


class Kinematics:
    """Solves the groups of a scene in order. Nothing in it changes.

    Attributes:
        coordinates: layout of coordinate rows.
        drives: velocity coordinates of the drives.
        solvers: one per group.
    """

    def __init__(self, coordinates: Coordinates, drives: Array, solvers: list[Solver]) -> None:
        self.coordinates = coordinates
        self.drives = drives
        self.solvers = solvers

    @property
    def rows(self) -> list[Reduction]:
        """Which rows every group solves; they change as long as little of the motion is known."""
        return [solver.reduction for solver in self.solvers]

    def solving(self, reductions: list[Reduction]) -> Kinematics:
        """Return the same for other rows of every group."""
        pairs = zip(self.solvers, reductions, strict=True)
        solvers = [solver.solving(reduction) for solver, reduction in pairs]
        return Kinematics(self.coordinates, self.drives, solvers)

    def moving(self, states: Array) -> Kinematics:
        """Return the same, told how far everything moves; see `Solver.moving`."""
        solvers = [solver.moving(states) for solver in self.solvers]
        return Kinematics(self.coordinates, self.drives, solvers)

    def approach(self, x: Array) -> ClosedMechanism:
        """Take one Newton step towards closed loops from guesses `x (N, size)`.

        Returns:
            Coordinates after the step, and all else as it is before it.
        """
        x = self.coordinates.normalised(x.copy())
        return _joined(x, [solver.approach(x) for solver in self.solvers])

    def close(self, x: Array, turns: Array | None = None, most: int = 12) -> ClosedMechanism:
        """Close all loops from guesses `x (N, size)`; the caller judges the result.

        Args:
            x: coordinates; kept as they are.
            turns: `(N, size)` whole turns that the angles in `x` lack.
            most: greatest number of Newton steps per group.
        """
        x = self.coordinates.normalised(x.copy())
        return _joined(x, [solver.close(x, turns, most) for solver in self.solvers])

    def evaluate(self, x: Array) -> ClosedMechanism:
        """Return what is known at coordinates `x (N, size)` without changing them."""
        return _joined(x, [solver.evaluate(x)[0] for solver in self.solvers])

    def rates(self, here: ClosedMechanism, drive_rates: Array) -> Array:
        """Return joint rates `(N, nv)` for drive rates `(N, d)`; held joints rest."""
        v = np.zeros((len(here.x), self.coordinates.model.nv))
        v[:, self.drives] = drive_rates
        for closed in here.groups:
            group = closed.solver.group
            if group.passives.size:
                v[:, group.passives] = closed.solver.rates(closed, v[:, group.known])
        return v

    def accelerations(self, here: ClosedMechanism, v: Array, drive_accelerations: Array) -> Array:
        """Return joint accelerations `(N, nv)` at joint rates `v (N, nv)`."""
        a = np.zeros_like(v)
        a[:, self.drives] = drive_accelerations
        for closed in here.groups:
            solver, group = closed.solver, closed.solver.group
            if group.passives.size:
                a[:, group.passives] = solver.accelerations(closed, v, a[:, group.known])
        return a

    def same_side(self, here: ClosedMechanism, inverses: list[Array]) -> Array:
        """Return `(N,)` whether no group crosses a singular position to come from other positions.

        Args:
            here: closed positions.
            inverses: of every group's closure equations at the other positions.
        """
        result = np.ones(len(here.x), dtype=bool)
        for closed, inverse in zip(here.groups, inverses, strict=True):
            result &= closed.same_side(inverse)
        return result


def _joined(x: Array, groups: list[Closed]) -> ClosedMechanism:
    def worst(name: str, least: float) -> Array:
        found = np.full(len(x), least)
        for group in groups:
            found = np.maximum(found, getattr(group, name))
        return found

    return ClosedMechanism(
        x, groups, worst("residual", 0.0), worst("condition", 1.0), worst("correction", 0.0)
    )
