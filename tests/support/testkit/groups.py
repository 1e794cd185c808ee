"""The only group of a linkage, closed at positions of its drive."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.equations import Reduction
from cardan_dyn.core.kinematics.closing.group_solver import GroupSolver, GroupState
from testkit.planar_linkages import described, joint, link, solver


def only_group(mechanism: cd.Mechanism, *drives: str) -> tuple[GroupSolver, Reduction, np.ndarray]:
    """The only group of a mechanism, its reachable rows, and its zero position."""
    kinematics, start = solver(mechanism, *drives)
    (item,), (reduction,) = kinematics.solvers, kinematics.reductions
    return item, reduction, start


def guesses(mechanism: cd.Mechanism, drive: str, positions: np.ndarray) -> np.ndarray:
    x = np.repeat(mechanism.coordinates.neutral()[None], len(positions), axis=0)
    x[:, mechanism.coordinates.columns[drive].start] = positions
    return x


def state_of(mechanism: cd.Mechanism, drive: str, positions: np.ndarray) -> GroupState:
    """Closed states at positions of the drive."""
    item, reduction, _ = only_group(mechanism, drive)
    x = guesses(mechanism, drive, positions)
    return item.newton(x, reduction)


def overconstrained() -> cd.Mechanism:
    """Three equal rockers on one coupler: one of their six equations is redundant."""
    return described(
        *(link(name) for name in "abcd"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 1.0)),
        joint("D", "ground", "c", (2.0, 0.0)),
        joint("E", "ground", "d", (1.0, 0.0)),
        loop_named("C", "b", "c", (2.0, 0.0), (0.0, 1.0)),
        loop_named("F", "b", "d", (1.0, 0.0), (0.0, 1.0)),
    )


def loop_named(
    name: str,
    first: str,
    second: str,
    on_first: tuple[float, float],
    on_second: tuple[float, float],
) -> str:
    return (
        f'<loop name="{name}" type="continuous"><predecessor link="{first}">'
        f'<origin xyz="{on_first[0]!r} {on_first[1]!r} 0"/></predecessor>'
        f'<successor link="{second}"><origin xyz="{on_second[0]!r} {on_second[1]!r} 0"/>'
        '</successor><axis xyz="0 0 1"/></loop>'
    )
