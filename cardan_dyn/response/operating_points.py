"""Operating points: a response evaluated there, each quantity when it is first read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..elements.link_loads import LinkLoad
from ..errors import ArgumentError
from ..frozen import frozen, read_only
from ..problem.samples import Targets, targets_of
from ..results.collect import motion_at
from ..results.motion import Motion
from .columns import Column
from .data import ResponseData
from .series import Location


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """A `Source` of a sweep that evaluates a response only where and when it is read.

    What it returns cannot be written to: it is kept, and returned again.

    Attributes:
        solver: of the scene.
        data: the functions of the response.
        positions: drive positions of any shape; None if they are equal steps of a period.
        step_count: number of equal steps of a period; None if there are `positions`.
        factors: what each column is multiplied with; broadcasts with the positions.
        shape: of all operating points.
        speed, acceleration: of the drive; they broadcast with the positions.
        joint_loads: loaded joints and their efforts.
        gravity: `(..., 3)`.
    """

    solver: ProblemSolver
    data: ResponseData
    positions: Array | None
    step_count: int | None
    factors: dict[Column, Array]
    shape: tuple[int, ...]
    speed: Array
    acceleration: Array
    joint_loads: Mapping[str, Array]
    gravity: Array

    @cached_property
    def position(self) -> Array:
        """Drive positions; they broadcast to `shape`."""
        if self.positions is not None:
            return self.positions
        domain, count = self.data.series.domain, self.step_count or 0
        return np.asarray(domain.origin + domain.length * np.arange(count) / count)

    @cached_property
    def location(self) -> Location:
        """Where the positions lie in the series' tables."""
        return self.data.series.locate(self.position)

    def __len__(self) -> int:
        return int(self.shape[0])

    def wrench(self, output: int) -> EvaluatedComponents:
        """Return the wrench of an output, by its index, in its joint frame."""
        layout = self.data.layout
        rows = {column: layout.wrench(column, output) for column in self.factors}
        return EvaluatedComponents(self, rows)

    @property
    def held(self) -> Mapping[str, float | Array]:
        """Held joints and their positions."""
        return self.solver.problem.held

    @property
    def link_loads(self) -> Mapping[str, LinkLoad]:
        """Loaded links and their wrenches."""
        return self.solver.problem.link_loads

    @property
    def inertia(self) -> Mapping[str, Array]:
        """Factors on mass and inertia of links: none."""
        return frozen({})

    @property
    def time(self) -> Array:
        """Time at which actuators act [s]: zero."""
        return np.zeros(())

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        return (
            self._effort(0)
            if self.solver.knows_effort(self.solver.problem.independent[0])
            else None
        )

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        # Efforts list the drive first.
        held = enumerate(self.solver.problem.held, start=1)
        return frozen(
            {name: self._effort(index) for index, name in held if self.solver.knows_effort(name)}
        )

    def motion(self) -> Motion:
        """Return the motion at the operating points, solved directly."""
        position, speed, acceleration = (
            np.broadcast_to(values, self.shape)
            for values in (self.position, self.speed, self.acceleration)
        )
        return solved_motion(self.solver, position, speed, acceleration)

    def coupling_moment(self, index: int) -> Array:
        """Return the moment of a coupling, by its index in the layout of the response."""
        layout = self.data.layout
        return self.combined({column: layout.coupling(column, index) for column in self.factors})

    def _effort(self, index: int) -> Array:
        layout = self.data.layout
        return self.combined({column: layout.effort(column, index) for column in self.factors})

    def combined(self, rows: Mapping[Column, int]) -> Array:
        """Return the sum over columns of one function each, in `shape`.

        Args:
            rows: column to the index of the function.

        Raises:
            ArgumentError: there is not enough memory for so many operating points.
        """
        try:
            return read_only(self._combined(rows))
        except MemoryError as error:
            size = 8e-9 * np.prod(self.shape, dtype=float)
            raise ArgumentError(
                f"there is not enough memory for operating points of shape {self.shape}, "
                f"{size:.3g} GB per component of a wrench; evaluate fewer at once"
            ) from error

    def _combined(self, rows: Mapping[Column, int]) -> Array:
        result: Array | None = None
        for column, row in rows.items():
            if not self.data.zero[row]:
                term = self._term(row, self.factors[column])
                result = term if result is None else result + term
        if result is None:
            return np.zeros(self.shape)
        return result if result.shape == self.shape else np.broadcast_to(result, self.shape).copy()

    def _term(self, row: int, factor: Array) -> Array:
        """Return a function times its factor; it broadcasts to `shape`."""
        series = self.data.series
        if self.data.constant[row]:
            return np.asarray(series.values[row].mean() * factor)
        rows = np.array([row])
        if self.step_count is None:
            values = series.at(rows, self.location)[0]
        else:
            values = series.uniform(rows, self.step_count)[0]
        if factor.ndim:
            return np.asarray(values * factor)
        if factor != 1.0:
            # In place: the values are new, and large arrays take as long to make as to fill.
            values *= factor
        return values


@dataclass(frozen=True, eq=False)
class CouplingMoments(Mapping[str, Array]):
    """Moments of the couplings `(N,)`, each evaluated when it is first looked up.

    Attributes:
        points: the operating points.
    """

    points: OperatingPoints
    _evaluated: dict[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self._evaluated:
            couplings = self.points.data.layout.couplings
            if name not in couplings:
                raise KeyError(name)
            self._evaluated[name] = self.points.coupling_moment(couplings.index(name))
        return self._evaluated[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.points.data.layout.couplings)

    def __len__(self) -> int:
        return len(self.points.data.layout.couplings)


@dataclass(frozen=True, eq=False)
class EvaluatedComponents:
    """Components of a wrench, each evaluated when it is first read.

    Attributes:
        points: the operating points.
        rows: column to the indices `(6,)` of the components in the series.
    """

    points: OperatingPoints
    rows: dict[Column, range]
    _evaluated: dict[int, Array] = field(default_factory=dict)

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        if index not in self._evaluated:
            rows = {column: indices[index] for column, indices in self.rows.items()}
            self._evaluated[index] = self.points.combined(rows)
        return self._evaluated[index]

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return all(self.points.data.zero[indices[index]] for indices in self.rows.values())

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return read_only(np.stack([self.component(first + axis) for axis in range(3)], axis=-1))


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
        flat = (values.reshape(-1, 1) for values in (positions, speeds, accelerations))
        of_drive, *rates = flat
        targets = Targets.of_positions(of_drive, positions.shape)
        if held:
            targets = targets_of(solver.problem, positions, held).expanded(positions.shape)
        motion = motion_at(solver, targets, *rates)
    # Overflow may also leave NaN; of joints that are not solved, velocities are NaN as well.
    is_undefined = np.isnan(motion.a) & ~np.isnan(motion.v)
    if np.any(np.isinf(motion.v) | np.isinf(motion.a) | is_undefined):
        raise ArgumentError("position, speed or acceleration is so great that numbers overflow")
    return motion
