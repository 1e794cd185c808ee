"""Start state: closed coordinates and velocities at which a simulation begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.mechanism.configuration import Configuration
from ...core.problem.arguments import by_coordinate
from ...core.problem.coordinate_names import check_single
from ...core.problem.samples import Targets
from ...core.results.collect import motion_at
from ...core.results.motion import Motion
from ...kit.arrays import EPS, NOTHING, Array
from ...kit.checks import number, numbers
from ...kit.errors import ArgumentError, CardanError, choices


def drive_positions(
    solver: ProblemSolver, position: Any, prescribed: Mapping[str, float] | None = None
) -> Array:
    """Return the positions `(d,)` of driven and free coordinates at which a simulation begins.

    Args:
        solver: of the scene.
        position: see `Scene.simulate`; coordinates that nothing is said of begin where the scene
            does.
        prescribed: drives whose motion is prescribed to where it begins.

    Raises:
        ArgumentError: not finite, of a wrong shape, or positions that contradict each other.
        ModelError: no such joint.
        AssemblyError: the loops cannot be closed there.
    """
    problem = solver.problem
    mechanism, drives = problem.mechanism, problem.independent
    start = solver.assembly.start[mechanism.coordinates.columns_of(drives)]
    prescribed = prescribed or {}
    given = _given(solver, "position", position)
    _refuse_other("position", given, prescribed)
    given.update(prescribed)
    positions = start.copy()
    for index, name in enumerate(drives):
        positions[index] = given.get(name, positions[index])
    others = {name: value for name, value in given.items() if name not in drives}
    undecided = [name for name in drives if name not in given]
    if others and undecided:
        positions = _following(solver, given, others, undecided)
    if others:
        _refuse_conflict(solver, positions, others)
    return positions


def _refuse_other(label: str, given: Mapping[str, float], prescribed: Mapping[str, float]) -> None:
    """Refuse values of drives that are not those of their prescribed motion."""
    for name, value in prescribed.items():
        gap = abs(given.get(name, value) - value)
        if gap > NOTHING * max(1.0, abs(value)):
            raise ArgumentError(
                f"{label}[{name!r}] is {given[name]:g}, {gap:.3g} from {value:.12g}, with which "
                "its prescribed motion begins; give that, or leave it out"
            )


def _given(solver: ProblemSolver, label: str, value: Any) -> dict[str, float]:
    """Return values by name, of numbers for the free coordinates or for driven and free ones."""
    problem = solver.problem
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        values = np.atleast_1d(numbers(label, value))
        ways = list(dict.fromkeys(filter(None, (problem.free, problem.independent))))
        for names in ways:
            if values.shape == (len(names),):
                return dict(zip(names, values.tolist(), strict=True))
        expected = " or ".join(f"{len(names)} ({', '.join(names)})" for names in ways)
        raise ArgumentError(
            f"{label} has shape {values.shape}, expected {expected}, or a mapping of joint names"
        )
    mechanism = problem.mechanism
    result = {}
    for name, item in by_coordinate(mechanism, label, value).items():
        check_single(mechanism, name, f"a key of {label},")
        if name not in mechanism.coordinates.named:
            if isinstance(value, Configuration):
                continue  # The loops place a ball that nothing drives and that is not free.
            raise ArgumentError(f"{label}[{name!r}]: the scene solves this joint as a ball")
        given = number(f"{label}[{name!r}]", item)
        if name in problem.held:
            if isinstance(value, Configuration) and abs(given - problem.held[name]) <= NOTHING * (
                mechanism.characteristic_length if mechanism.drivable[name].slides else 1.0
            ):
                continue
            raise ArgumentError(
                f"{label}[{name!r}]: the scene holds this joint; driven and free: "
                f"{choices(problem.independent)}"
            )
        result[name] = given
    return result


def _following(
    solver: ProblemSolver,
    given: Mapping[str, float],
    others: Mapping[str, float],
    undecided: list[str],
) -> Array:
    """Return drive positions at which other joints are at given positions.

    A solver that is driven by these joints finds them.
    """
    problem = solver.problem
    kept = [name for name in problem.independent if name in given] + undecided[len(others) :]
    leading = (*kept, *list(others)[: len(undecided)])
    try:
        other = ProblemSolver(replace(problem, independent=leading, free=()))
        start = other.assembly.start[problem.mechanism.coordinates.columns_of(leading)]
        row = np.array(
            [[given.get(name, value) for name, value in zip(leading, start, strict=True)]]
        )
        motion = _motion(other, row, np.zeros_like(row))
    except CardanError as error:
        raise ArgumentError(
            f"position: no start was found with {', '.join(others)} there: {error}"
        ) from error
    return np.array([float(motion.position(name)[0]) for name in problem.independent])


def _motion(solver: ProblemSolver, positions: Array, speeds: Array) -> Motion:
    return motion_at(solver, Targets.of_positions(positions), speeds)


def _refuse_conflict(solver: ProblemSolver, positions: Array, others: Mapping[str, float]) -> None:
    """Refuse positions of other joints that are not where the drives put them."""
    motion = _motion(solver, positions[None, :], np.zeros((1, len(positions))))
    mechanism = solver.problem.mechanism
    for name, value in others.items():
        there, coordinate = float(motion.position(name)[0]), mechanism.coordinates.named[name]
        gap = there - value
        if not coordinate.slides:
            gap = (gap + np.pi) % (2.0 * np.pi) - np.pi
        if abs(gap) > NOTHING * mechanism.coordinates.rate_scale[coordinate.rate]:
            at = ", ".join(
                f"{drive} at {place:.12g}"
                for drive, place in zip(solver.problem.independent, positions, strict=True)
            )
            raise ArgumentError(
                f"position[{name!r}] is {value:g}, which violates the loops by {abs(gap):.3g}: "
                f"with {at} it is at {there:.12g}; give that, or leave it out"
            )


def closed_start(
    solver: ProblemSolver, positions: Array, speed: Any, prescribed: Mapping[str, float]
) -> Motion:
    """Return the motion with which a simulation begins, and motions beside it.

    The first sample is the start. In the others, see `rounding_of_speeds`, the speed of one drive
    after the other is greater by a step, and then less by it.

    Args:
        solver: of the scene.
        positions: of driven and free coordinates `(d,)`.
        speed: see `Scene.simulate`; free coordinates that nothing is said of rest.
        prescribed: drives whose motion is prescribed to their speeds.

    Raises:
        ArgumentError: not finite, of a wrong shape, or speeds that contradict each other.
        ModelError: no such joint.
        SingularConfigurationError: the drives do not decide the motion there.
    """
    drives = solver.problem.independent
    row = positions[None, :]
    rest = np.zeros_like(row)
    given = _given(solver, "speed", speed)
    _refuse_other("speed", given, prescribed)
    given.update(prescribed)
    if all(name in drives for name in given):
        speeds = np.array([given.get(name, 0.0) for name in drives])
        return _beside(solver, row, speeds)
    at_rest = _motion(solver, row, rest)
    ratios = np.array(
        [[float(at_rest.ratio(name, drive)[0]) for drive in drives] for name in given]
    ).reshape(len(given), len(drives))
    wanted = np.array(list(given.values()))
    fixed = np.array([name in given for name in drives])
    speeds = np.array([given.get(name, 0.0) for name in drives])
    if not np.all(fixed) and len(wanted):
        rest_of = wanted - ratios[:, fixed] @ speeds[fixed]
        speeds[~fixed] = np.linalg.lstsq(ratios[:, ~fixed], rest_of, rcond=1e-12)[0]
    gaps = ratios @ speeds - wanted if len(wanted) else np.zeros(0)
    if np.any(np.abs(gaps) > NOTHING * np.max(np.abs(wanted), initial=1e-300)):
        worst = int(np.argmax(np.abs(gaps)))
        name = list(given)[worst]
        raise ArgumentError(
            f"speed[{name!r}] is {wanted[worst]:g}, which violates the loops by "
            f"{abs(gaps[worst]):.3g}: with the others it is {wanted[worst] + gaps[worst]:.12g}; "
            "give that, or leave it out"
        )
    return _beside(solver, row, speeds)


def _beside(solver: ProblemSolver, positions: Array, speeds: Array) -> Motion:
    """Return the motion at positions `(1, d)` and speeds `(d,)` and beside, see `closed_start`."""
    steps = np.diag(_step(solver, speeds))
    rows = np.concatenate([speeds[None, :], speeds + steps, speeds - steps])
    return _motion(solver, positions.repeat(len(rows), axis=0), rows)


def _step(solver: ProblemSolver, speeds: Array) -> Array:
    """Return steps `(d,)` as great as speeds are: a radian, or the mechanism's length, or more."""
    coordinates = solver.problem.mechanism.coordinates
    units = coordinates.rate_scale[coordinates.rates_of(solver.problem.independent)]
    return np.asarray(units * (float(np.max(np.abs(speeds) / units, initial=0.0)) or 1.0))


def rounding_of_speeds(solver: ProblemSolver, begun: Motion) -> float:
    """Return which part of the velocities at a start rounding of lengths and positions decides.

    Near a configuration that is singular for the drives, their speeds mean very different
    velocities in positions that differ by rounding. By how much velocities change along the way of
    a drive is half of what accelerations at constant speeds change by with its speed: they are
    quadratic in the speeds of the drives.

    Args:
        solver: of the scene.
        begun: motion at the start and beside it, see `closed_start`.
    """
    coordinates = solver.problem.mechanism.coordinates
    scale, driven = coordinates.rate_scale, coordinates.rates_of(solver.problem.independent)
    size = float(np.max(np.abs(begun.v[0]) / scale, initial=0.0))
    if not size or not np.isfinite(size):
        return 0.0
    # Steps as great as the speeds lose no digits.
    steps = _step(solver, begun.v[0][driven]) / scale[driven]
    with np.errstate(over="ignore", invalid="ignore"):
        greater, less = np.split(begun.a[1:] / scale, 2)
        changes = np.abs(greater - less) / (4.0 * steps[:, None])
    return EPS * float(np.max(changes, initial=0.0)) / size
