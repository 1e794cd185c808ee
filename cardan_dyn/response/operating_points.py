"""Operating points: a response evaluated where, and when, it is asked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..arrays import Array
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError
from ..frozen import frozen, read_only
from ..results.collect import motion_at
from ..results.motion import Motion
from .columns import Column
from .data import ResponseData
from .series import Location


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """A `sweep.Source` that evaluates a response where and when it is asked.

    What it returns cannot be written to: it is kept, and returned again.

    Attributes:
        solver: of the scene.
        data: the functions of the response.
        given: drive positions of any shape; None if they are equal steps of a period.
        count: number of positions if they are equal steps of a period.
        factors: what each column is multiplied with; broadcasts with the positions.
        shape: of all operating points.
        speed, acceleration: of the drive; they broadcast with the positions.
        joint_loads: loaded joints and their efforts.
        gravity: `(..., 3)`.
    """

    solver: ProblemSolver
    data: ResponseData
    given: Array | None
    count: int | None
    factors: dict[Column, Array]
    shape: tuple[int, ...]
    speed: Array
    acceleration: Array
    joint_loads: Mapping[str, Array]
    gravity: Array

    @cached_property
    def position(self) -> Array:
        """Drive positions."""
        if self.given is not None:
            return self.given
        series = self.data.series
        return np.asarray(series.origin + series.length * np.arange(self.shape[0]) / self.shape[0])

    @cached_property
    def where(self) -> Location:
        """Where the positions lie in the series' tables."""
        return self.data.series.locate(self.position)

    def __len__(self) -> int:
        return int(self.shape[0])

    def wrench(self, number: int) -> Evaluated:
        """Return the wrench of an output in its joint frame."""
        layout = self.data.layout
        return Evaluated(self, {column: layout.wrench(column, number) for column in self.factors})

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        return self._effort(0) if self.solver.knows_effort(self.solver.problem.drives[0]) else None

    def holding_effort(self) -> Mapping[str, Array]:
        """Return what holds the held joints."""
        held = enumerate(self.solver.problem.held, start=1)
        return frozen(
            {name: self._effort(index) for index, name in held if self.solver.knows_effort(name)}
        )

    def motion(self) -> Motion:
        """Return the motion at the operating points, solved directly; they are made flat."""
        flat = [
            np.broadcast_to(part, self.shape).ravel()
            for part in (self.position, self.speed, self.acceleration)
        ]
        return solved_motion(self.solver, *flat)

    def coupling_moment(self, number: int) -> Array:
        """Return the moment of a coupling, by its number among those of the response."""
        layout = self.data.layout
        return self.combined({column: layout.coupling(column, number) for column in self.factors})

    def _effort(self, number: int) -> Array:
        layout = self.data.layout
        return self.combined({column: layout.effort(column, number) for column in self.factors})

    def combined(self, rows: Mapping[Column, int]) -> Array:
        """Return the sum over columns of one function each, in `shape`.

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
        data = self.data
        result: Array | None = None
        for column, row in rows.items():
            if data.zero[row]:
                continue
            factor = self.factors[column]
            if data.constant[row]:
                part = np.asarray(data.series.values[row].mean() * factor)
            else:
                if self.count is None:
                    part = data.series.at(np.array([row]), self.where)[0]
                else:
                    part = data.series.uniform(np.array([row]), self.count)[0]
                if factor.ndim:
                    part = part * factor
                elif factor != 1.0:
                    part *= factor
            result = part if result is None else result + part
        if result is None:
            return np.zeros(self.shape)
        return result if result.shape == self.shape else np.broadcast_to(result, self.shape).copy()


@dataclass(frozen=True, eq=False)
class CouplingMoments(Mapping[str, Array]):
    """CouplingMoments of the couplings `(N,)`, evaluated one by one when they are looked up.

    Attributes:
        points: the operating points.
    """

    points: OperatingPoints
    _done: dict[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self._done:
            couplings = self.points.data.layout.couplings
            if name not in couplings:
                raise KeyError(name)
            self._done[name] = self.points.coupling_moment(couplings.index(name))
        return self._done[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.points.data.layout.couplings)

    def __len__(self) -> int:
        return len(self.points.data.layout.couplings)


@dataclass(frozen=True, eq=False)
class Evaluated:
    """Components of a wrench, evaluated one by one when they are asked for.

    Attributes:
        points: the operating points.
        rows: column to the places `(6,)` of the components in the series.
    """

    points: OperatingPoints
    rows: dict[Column, range]
    _done: dict[int, Array] = field(default_factory=dict)

    def one(self, number: int) -> Array:
        """Return a component `(N,)`."""
        if number not in self._done:
            rows = {column: places[number] for column, places in self.rows.items()}
            self._done[number] = self.points.combined(rows)
        return self._done[number]

    def vanishes(self, number: int) -> bool:
        """Return whether a component is zero throughout."""
        return all(self.points.data.zero[places[number]] for places in self.rows.values())

    def vectors(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return read_only(np.stack([self.one(first + axis) for axis in range(3)], axis=-1))


def solved_motion(
    solver: ProblemSolver, positions: Array, speeds: Array, accelerations: Array
) -> Motion:
    """Return the motion alone of a scene with one drive, solved directly at samples `(N,)`.

    Raises:
        ArgumentError: numbers overflow.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # What overflows is refused below.
        found = motion_at(solver, positions[:, None], speeds[:, None], accelerations[:, None])
    if any(np.any(np.isinf(part)) for part in (found.v, found.a)):
        raise ArgumentError("position, speed or acceleration is so great that numbers overflow")
    return found
