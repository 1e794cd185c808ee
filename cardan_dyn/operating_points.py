"""Operating points: a response evaluated where, and when, it is asked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .errors import ArgumentError
from .frozen import frozen, read_only
from .motion import Motion
from .response_columns import Column
from .series import Location

if TYPE_CHECKING:
    from .response import Response
    from .scene import Scene


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """A `sweep.Source` that evaluates a response where and when it is asked.

    What it returns cannot be written to: it is kept, and returned again.

    Attributes:
        response: the response.
        given: drive positions of any shape; None if they are equal steps of a period.
        count: number of positions if they are equal steps of a period.
        factors: what each column is multiplied with; broadcasts with the positions.
        shape: of all operating points.
        speeds, accelerations: of the drive.
    """

    response: Response
    given: Array | None
    count: int | None
    factors: dict[Column, Array]
    shape: tuple[int, ...]
    speeds: Array
    accelerations: Array

    @cached_property
    def positions(self) -> Array:
        """Drive positions."""
        if self.given is not None:
            return self.given
        series = self.response.series
        return np.asarray(series.origin + series.length * np.arange(self.shape[0]) / self.shape[0])

    @cached_property
    def where(self) -> Location:
        """Where the positions lie in the series' tables."""
        return self.response.series.locate(self.positions)

    def __len__(self) -> int:
        return int(self.shape[0])

    def wrench(self, number: int) -> Evaluated:
        """Return the wrench of an output in its joint frame."""
        layout = self.response.layout
        return Evaluated(self, {column: layout.wrench(column, number) for column in self.factors})

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        alone = self.response.scene.assembly.needed.efforts_alone
        if not alone and not self._known(self.response.scene.drives[0]):
            return None
        return self._effort(0)

    def holding_effort(self) -> dict[str, Array]:
        """Return what holds the held joints."""
        held = enumerate(self.response.scene.held, start=1)
        return frozen({name: self._effort(place) for place, name in held if self._known(name)})

    def _known(self, joint: str) -> bool:
        scene = self.response.scene
        return scene.mechanism.joints[joint].index - 1 in scene.assembly.needed.complete

    def motion(self) -> Motion:
        """Return the motion at the operating points, solved directly; they are made flat."""
        flat = [
            np.broadcast_to(part, self.shape).ravel()
            for part in (self.positions, self.speeds, self.accelerations)
        ]
        return solved_motion(self.response.scene, *flat)

    def tooth_moment(self, number: int) -> Array:
        """Return the moment of a coupling, by its number among those of the response."""
        layout = self.response.layout
        return self.combined({column: layout.coupling(column, number) for column in self.factors})

    def _effort(self, number: int) -> Array:
        layout = self.response.layout
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
        response = self.response
        result: Array | None = None
        for column, row in rows.items():
            if response.zero[row]:
                continue
            factor = self.factors[column]
            if response.constant[row]:
                part = np.asarray(response.series.values[row].mean() * factor)
            else:
                if self.count is None:
                    part = response.series.at(np.array([row]), self.where)[0]
                else:
                    part = response.series.uniform(np.array([row]), self.count)[0]
                if factor.ndim:
                    part = part * factor
                elif factor != 1.0:
                    part *= factor
            result = part if result is None else result + part
        if result is None:
            return np.zeros(self.shape)
        return result if result.shape == self.shape else np.broadcast_to(result, self.shape).copy()


@dataclass(frozen=True, eq=False)
class Moments(Mapping[str, Array]):
    """Moments of the couplings `(N,)`, evaluated one by one when they are looked up.

    Attributes:
        points: the operating points.
    """

    points: OperatingPoints
    _done: dict[str, Array] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Array:
        if name not in self._done:
            couplings = self.points.response.layout.couplings
            if name not in couplings:
                raise KeyError(name)
            self._done[name] = self.points.tooth_moment(couplings.index(name))
        return self._done[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.points.response.layout.couplings)

    def __len__(self) -> int:
        return len(self.points.response.layout.couplings)


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
        return all(self.points.response.zero[places[number]] for places in self.rows.values())

    def vectors(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return read_only(np.stack([self.one(first + axis) for axis in range(3)], axis=-1))


def solved_motion(scene: Scene, positions: Array, speeds: Array, accelerations: Array) -> Motion:
    """Return the motion alone of a scene with one drive, solved directly at samples `(N,)`.

    Raises:
        ArgumentError: numbers overflow.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # What overflows is refused below.
        found = scene.motion(positions, speeds, accelerations)
    if any(np.any(np.isinf(part)) for part in (found.x, found.v, found.a)):
        raise ArgumentError("position, speed or acceleration is so great that numbers overflow")
    return found
