"""Operating points: a response evaluated there, each quantity when it is first read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import mapping
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import frozen, read_only
from ..dynamics.problem_solver import ProblemSolver
from ..problem.acting import Acting
from ..problem.problem import Problem
from ..problem.samples import Targets, acting_on, targets_of
from ..results.collect import motion_at
from ..results.motion import Motion
from .columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Acts, Column, Layout
from .data import ResponseData
from .series import Location


@dataclass(frozen=True, eq=False)
class OfDesign:
    """The operating points of one design.

    Attributes:
        data: its functions.
        where: which they are of all operating points.
        positions: of the drive; None where these are so many equal steps of a period.
        step_count: their number; None if there are `positions`.
        factors: columns that act, and what each is multiplied with; broadcasts with the positions.
    """

    data: ResponseData
    where: Any
    positions: Array | None
    step_count: int | None
    factors: list[tuple[Column, Array]]

    def sum(self, function: int) -> Array:
        """Return the sum over columns of a function, see `Layout`; it broadcasts to its points."""
        total: Array | None = None
        for column, factor in self.factors:
            row = self.data.layout.row(column, function)
            if not self.data.zero[row]:
                term = self._term(row, factor)
                total = term if total is None else total + term
        return np.zeros(()) if total is None else total

    def vanishes(self, function: int) -> bool:
        """Return whether a function is zero throughout."""
        row = self.data.layout.row
        return all(self.data.zero[row(column, function)] for column, _ in self.factors)

    @cached_property
    def _location(self) -> Location:
        """Where the positions lie in the series' tables."""
        assert self.positions is not None
        return self.data.series.locate(self.positions)

    def _term(self, row: int, factor: Array) -> Array:
        """Return a function times its factor."""
        series, rows = self.data.series, np.array([row])
        if self.data.constant[row]:
            return np.asarray(series.values[row].mean() * factor)
        if self.step_count is None:
            values = series.at(rows, self._location)[0]
        else:
            values = series.uniform(rows, self.step_count)[0]
        if factor.ndim:
            return np.asarray(values * factor)
        if factor != 1.0:
            # In place: the values are new, and large arrays take as long to make as to fill.
            values *= factor
        return values


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """A `Source` of a sweep that evaluates responses only where and when they are read.

    What it returns cannot be written to.

    Attributes:
        solver: of the scene, for positions of the held joints that vary.
        shape: of all operating points.
        parts: of the designs.
        acting: how fast the drive moves and what acts.
        held: positions of held joints that vary; they broadcast with the shape.
        given: drive positions `(..., 1)`; None where they are equal steps of a period.
    """

    solver: ProblemSolver
    shape: tuple[int, ...]
    parts: list[OfDesign]
    acting: Acting
    held: Mapping[str, Array]
    given: Array | None
    _evaluated: dict[int, Array] = field(default_factory=dict)

    @property
    def layout(self) -> Layout:
        """Order of the functions."""
        return self.parts[0].data.layout

    @cached_property
    def position(self) -> Array:
        """Drive positions `(..., 1)`."""
        if self.given is not None:
            return self.given
        part = self.parts[0]
        return part.data.series.domain.nodes(part.step_count or 0)[:, None]

    def wrench(self, output: int) -> EvaluatedComponents:
        """Return the wrench of an output, by its index, in its joint frame."""
        return EvaluatedComponents(self, 6 * output)

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts `(..., 1)`, None if the outputs leave it out."""
        known = self.solver.knows_drive_efforts
        return self.values(self.layout.wrenches)[..., None] if known else None

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        known, first = self.solver.known_holding_efforts.items(), self.layout.wrenches
        return frozen({name: self.values(first + column) for name, column in known})

    def motion(self) -> Motion:
        """Return the motion at the operating points, solved directly."""
        given = self.position, self.acting.speeds, self.acting.accelerations
        x, v, a = (np.broadcast_to(values[..., 0], self.shape) for values in given)
        return solved_motion(self.solver, x, v, a, self.held)

    def values(self, function: int) -> Array:
        """Return a function, see `Layout`; it is evaluated when it is first asked for.

        Raises:
            ArgumentError: there is not enough memory for so many operating points.
        """
        if function in self._evaluated:
            return self._evaluated[function]
        try:
            whole: Array | None = None
            for part in self.parts:
                values = part.sum(function)
                if part.where is ... and values.shape == self.shape:
                    whole = values
                    break
                whole = np.empty(self.shape) if whole is None else whole
                whole[part.where] = values
            return self._evaluated.setdefault(function, read_only(np.asarray(whole)))
        except MemoryError as error:
            size = 8e-9 * np.prod(self.shape, dtype=float)
            raise ArgumentError(
                f"there is not enough memory for operating points of shape {self.shape}, "
                f"{size:.3g} GB per component of a wrench; evaluate fewer at once"
            ) from error


@dataclass(frozen=True, eq=False)
class CouplingMoments(Mapping[str, Array]):
    """Moments of the couplings `(N,)`, each evaluated when it is first looked up."""

    points: OperatingPoints

    def __getitem__(self, name: str) -> Array:
        layout = self.points.layout
        if name not in layout.couplings:
            raise KeyError(name)
        return self.points.values(layout.moments + layout.couplings.index(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self.points.layout.couplings)

    def __len__(self) -> int:
        return len(self.points.layout.couplings)


@dataclass(frozen=True, eq=False)
class EvaluatedComponents:
    """Components of a wrench, each evaluated when it is first read.

    Attributes:
        points: the operating points.
        first: function that is the first component, see `Layout`.
    """

    points: OperatingPoints
    first: int

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        return self.points.values(self.first + index)

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return all(part.vanishes(self.first + index) for part in self.points.parts)

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return read_only(np.stack([self.component(first + axis) for axis in range(3)], axis=-1))


def checked_acting(
    problem: Problem, speed: object, acceleration: object, loads: object, gravity: object
) -> Acting:
    """Return how fast the drive moves and what acts: what the scene has where None is given.

    Raises:
        ArgumentError: one is not finite, empty or of a wrong shape, or a load is not on a joint.
    """
    mechanism = problem.mechanism
    for name in mapping("loads", loads):
        is_frame = name in mechanism.link_frames and name not in mechanism.joints
        if name in problem.link_loads or is_frame:
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
    return acting_on(problem, speed, acceleration, loads, gravity)


def column_factors(
    solver: ProblemSolver, columns: tuple[Column, ...], acting: Acting, greatest: float
) -> list[tuple[Column, Array]]:
    """Return the columns that act, in their order, and what each is multiplied with.

    Args:
        solver: of the scene.
        columns: that the response has.
        acting: how fast the drive moves and what acts.
        greatest: the greatest value of all functions.

    Raises:
        ArgumentError: the response has no column for something that acts, or wrenches overflow.
    """
    with np.errstate(over="ignore"):  # What overflows is refused below.
        factors = [(SPEED_SQUARED, acting.speeds[..., 0] ** 2)]
    factors.append((ACCELERATION, acting.accelerations[..., 0]))
    factors += [(Column(Acts.JOINT_LOAD, name), load) for name, load in acting.joint_loads.items()]
    factors += [(Column(Acts.LINK_LOAD, name), np.ones(())) for name in acting.link_loads]
    if acting.gravity.any():
        factors += [(column, acting.gravity[..., axis]) for axis, column in enumerate(GRAVITY)]
    found = [item for item in factors if item[1].any()]
    missing = {column for column, _ in found if column not in columns}
    if not solver.has_mass:
        # Nothing has inertia or weight, so that these columns would be zero.
        missing -= {SPEED_SQUARED, ACCELERATION, *GRAVITY}
    if missing:
        raise ArgumentError(
            f"the response has no columns for {choices(column.label for column in missing)}, only "
            f"for {choices(column.label for column in columns)}; give the scene such loads or a "
            "gravity"
        )
    # Of all columns together, no sum may overflow.
    most = np.finfo(float).max / (len(columns) or 1) / greatest
    for column, factor in found:
        if column in columns and not float(np.abs(factor).max()) < most:
            raise ArgumentError(f"{column.label} is so great that wrenches overflow")
    return sorted((of for of in found if of[0] in columns), key=lambda of: columns.index(of[0]))


def solved_motion(
    solver: ProblemSolver,
    positions: Array,
    speeds: Array,
    accelerations: Array,
    held: Mapping[str, Array] | None = None,
) -> Motion:
    """Return the motion alone of a scene with one drive, solved directly at samples of any shape.

    Args:
        solver: of the scene; for positions of the held joints that vary, if there are any.
        positions: of the drive.
        speeds: of the same shape.
        accelerations: likewise.
        held: positions of held joints that broadcast with them.

    Raises:
        ArgumentError: a velocity or acceleration overflows.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # What overflows is refused below.
        of_drive, *rates = (values.reshape(-1, 1) for values in (positions, speeds, accelerations))
        targets = Targets.of_positions(of_drive, positions.shape)
        if held:
            targets = targets_of(solver.problem, positions, held).expanded(positions.shape)
        motion = motion_at(solver, targets, *rates)
    # Overflow may also leave NaN; of joints that are not solved, velocities are NaN as well.
    is_undefined = np.isnan(motion.a) & ~np.isnan(motion.v)
    if np.any(np.isinf(motion.v) | np.isinf(motion.a) | is_undefined):
        raise ArgumentError("position, speed or acceleration is so great that numbers overflow")
    return motion
