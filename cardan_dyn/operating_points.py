"""Operating points: a response evaluated where, and when, it is asked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .motion import Motion
from .series import Location

if TYPE_CHECKING:
    from .response import Response


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """A `sweep.Source` that evaluates a response where and when it is asked.

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
    factors: dict[str, Array]
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
        rows = {column: self.response.wrench_rows(column, number) for column in self.factors}
        return Evaluated(self, rows)

    def drive_effort(self) -> Array | None:
        """Return what the drive exerts, None if the outputs leave it out."""
        alone = self.response.scene.assembly.needed.efforts_alone
        if not alone and not self._known(self.response.scene.drives[0]):
            return None
        return self._efforts(0)

    def holding_effort(self) -> dict[str, Array]:
        """Return what holds the held joints."""
        held = enumerate(self.response.scene.held, start=1)
        return {name: self._efforts(place) for place, name in held if self._known(name)}

    def _known(self, joint: str) -> bool:
        scene = self.response.scene
        return scene.mechanism.joints[joint].index - 1 in scene.assembly.needed.complete

    def motion(self) -> Motion:
        """Return the motion at the operating points, solved directly; they are made flat."""
        scene = self.response.scene
        flat = [
            np.broadcast_to(part, self.shape).ravel()
            for part in (self.positions, self.speeds, self.accelerations)
        ]
        return scene.motion(*flat)

    def _efforts(self, place: int) -> Array:
        return self.combined(
            {column: self.response.effort_rows(column)[place] for column in self.factors}
        )

    def combined(self, rows: Mapping[str, int]) -> Array:
        """Return the sum over columns of one function each, in `shape`."""
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
class Evaluated:
    """Components of a wrench, evaluated one by one when they are asked for.

    Attributes:
        points: the operating points.
        rows: column to the places `(6,)` of the components in the series.
    """

    points: OperatingPoints
    rows: dict[str, Array]
    _done: dict[int, Array] = field(default_factory=dict)

    def one(self, number: int) -> Array:
        """Return a component `(N,)`."""
        if number not in self._done:
            rows = {column: int(places[number]) for column, places in self.rows.items()}
            self._done[number] = self.points.combined(rows)
        return self._done[number]

    def vanishes(self, number: int) -> bool:
        """Return whether a component is zero throughout."""
        return all(self.points.response.zero[places[number]] for places in self.rows.values())

    def vectors(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return np.stack([self.one(first + axis) for axis in range(3)], axis=-1)
