"""Factors: what the columns of a response are multiplied with at operating points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import mapping, numbers
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, choices
from ..problem.problem import Problem
from ..problem.samples import drive_values
from .columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Column, Kind
from .data import ResponseData

_GREATEST_WRENCH = 1e300
"""Greater wrenches are refused, since a sum of a few of them could overflow."""


class Operation(NamedTuple):
    """How the drive moves and what acts; all of it broadcasts.

    Attributes:
        speed, acceleration: of the drive.
        joint_loads: loaded joints and their efforts.
        gravity: `(..., 3)`.
    """

    speed: Array
    acceleration: Array
    joint_loads: dict[str, Array]
    gravity: Array


def numbers_given(name: str, value: object) -> Array:
    """Return an argument as an array of finite numbers.

    Raises:
        ArgumentError: it is not numeric, not finite or empty.
    """
    array = numbers(name, value)
    if not array.size:
        raise ArgumentError(f"{name} is empty")
    return array


def checked_operation(
    problem: Problem, speed: object, acceleration: object, loads: object, gravity: object
) -> Operation:
    """Return the arguments of an evaluation, those of the scene where None is given.

    Raises:
        ArgumentError: one is not finite, empty or of a wrong shape, or a load is not on a joint.
    """
    speeds = drive_values("speed", speed, problem)[..., 0]
    accelerations = drive_values("acceleration", acceleration, problem)[..., 0]
    efforts = {**problem.joint_loads, **_efforts(problem, loads)}
    gravities = problem.gravity if gravity is None else numbers_given("gravity", gravity)
    if gravities.shape[-1:] != (3,):
        raise ArgumentError(f"gravity has shape {gravities.shape}, expected (..., 3)")
    return Operation(speeds, accelerations, efforts, gravities)


def _efforts(problem: Problem, loads: object) -> dict[str, Array]:
    """Return the efforts at joints that replace the scene's."""
    efforts, mechanism = {}, problem.mechanism
    for name, value in mapping("loads", loads).items():
        if name in problem.link_loads or (name in mechanism.links and name not in mechanism.joints):
            raise ArgumentError(
                f"loads[{name!r}]: {name!r} is a link; a response keeps the wrenches of its "
                "scene, and replaces efforts at joints only: build one of a scene with this "
                "wrench"
            )
        if name not in mechanism.drivable:
            reason = (
                "it has no single coordinate" if name in mechanism else "no joint has this name"
            )
            raise ArgumentError(
                f"loads[{name!r}]: {reason}; the response has loads on: "
                f"{choices(problem.joint_loads, name)}"
            )
        efforts[name] = numbers_given(f"loads[{name!r}]", value)
    return efforts


def column_factors(
    solver: ProblemSolver, data: ResponseData, operation: Operation, greatest: float
) -> dict[Column, Array]:
    """Return what each column that acts is multiplied with, in the order of the layout.

    Args:
        solver: of the scene.
        data: the functions of the response.
        operation: how the drive moves and what acts.
        greatest: the greatest value of all functions.

    Raises:
        ArgumentError: the response has no column for something that acts, or wrenches overflow.
    """
    factors: list[tuple[Column, Array]] = []
    if operation.speed.any():
        with np.errstate(over="ignore"):  # What overflows is refused below.
            factors.append((SPEED_SQUARED, operation.speed * operation.speed))
    factors.append((ACCELERATION, operation.acceleration))
    for name, effort in operation.joint_loads.items():
        factors.append((Column(Kind.JOINT_LOAD, name), effort))
    factors += [(Column(Kind.LINK_LOAD, name), np.ones(())) for name in solver.problem.link_loads]
    if operation.gravity.any():
        factors += [(column, operation.gravity[..., axis]) for axis, column in enumerate(GRAVITY)]
    found = {column: factor for column, factor in factors if factor.any()}
    columns = data.layout.columns
    acting = {column: found[column] for column in columns if column in found}
    if len(acting) < len(found):
        _refuse_missing(found, columns, solver.has_mass)
    for column, factor in acting.items():
        if not float(np.abs(factor).max()) * greatest < _GREATEST_WRENCH:
            raise ArgumentError(f"{column.label} is so great that wrenches overflow")
    return acting


def _refuse_missing(
    acting: Mapping[Column, Array], columns: tuple[Column, ...], has_mass: bool
) -> None:
    """Refuse what acts but has no column."""
    missing = set(acting) - set(columns)
    if not has_mass:
        # Nothing has inertia or weight, so that these columns would be zero.
        missing -= {SPEED_SQUARED, ACCELERATION, *GRAVITY}
    if missing:
        raise ArgumentError(
            f"the response has no columns for {choices(column.label for column in missing)}, only "
            f"for {choices(column.label for column in columns)}; give the scene such loads or a "
            "gravity"
        )
