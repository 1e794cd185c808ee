"""Design turns: how a mechanism comes back to itself when a drive turns, at many held positions.

Whether a drive turns through, and how often other joints turn meanwhile, differs between designs: a
crank-rocker becomes a drag link when one of its bars grows. Between two designs it changes only
where a singular configuration lies between them. So designs near each other are represented by one
of them, as far as none lies as near.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates
from .all_groups import Kinematics
from .straight_lines import OnLines, along_lines, samples_on_lines

_SPACINGS = (0.0125, 0.025, 0.05, 0.1)
"""Distances [rad, or lengths of the mechanism] between designs that represent others; the first one
is taken at which each represents enough."""
_FEWEST = 16
"""Designs that each of them has to represent, so that ways to them take little of the time."""
_LOOKS = 24
"""Positions per turn at which it is looked how near a singular configuration is."""
_NEAREST = 0.1
"""Greatest product of a distance between designs and the condition number at which one represents
the other: at a distance δ from a singular configuration, the condition number is about 3/δ. It is a
thirtieth of that, since the condition may be greater between the positions that are looked at."""
_SAME = 1e-6
"""Difference [rad, or lengths of the mechanism] up to which a joint is back where it was."""


class DesignTurns(NamedTuple):
    """How a mechanism comes back to itself, for D designs.

    Attributes:
        period: `(D,)` displacement of the drive [rad]; zero where it does not come back.
        windings: `(D, size)` whole turns of all coordinates meanwhile.
    """

    period: Array
    windings: Array


class TurnSearch(NamedTuple):
    """Looks whether designs come back to themselves.

    Attributes:
        kinematics: of the drives, held joints included, and the groups that they move.
        start: `(size,)` closed coordinates of the scene.
        held: indices of the held joints among the drives.
        drive: index of the drive that turns.
        columns: columns of all of them in a row of coordinates.
        period: displacement after which designs are expected to come back [rad].
    """

    kinematics: Kinematics
    start: Array
    held: list[int]
    drive: int
    columns: list[int]
    period: float

    def of_designs(self, rows: Array) -> DesignTurns:
        """Return how designs `(D, h)` come back; the held joints' positions [rad or m]."""
        scale = self._coordinates.scale[[self.columns[index] for index in self.held]]
        for spacing in _SPACINGS:
            nearest = np.rint(rows * scale / spacing)
            cells, of_cell = np.unique(nearest, axis=0, return_inverse=True)
            if len(cells) * _FEWEST <= len(rows):
                break
        else:
            return self._each(rows)[0]
        middles = cells * spacing / scale
        found, condition = self._each(middles)
        away = np.sqrt(np.sum(((rows - middles[of_cell]) * scale) ** 2, axis=1))
        period, windings = found.period[of_cell], found.windings[of_cell]
        alone = ~(away * condition[of_cell] < _NEAREST) | (period == 0.0)
        if np.any(alone):
            own, _ = self._each(rows[alone])
            period[alone], windings[alone] = own
        return DesignTurns(period, windings)

    def turned_back(
        self, ahead: Array, designs: Array, design_of: Array
    ) -> tuple[Array, DesignTurns, Array]:
        """Return how many periods a drive turns back at samples, and how their designs come back.

        Args:
            ahead: `(K,)` displacements of the drive from the start.
            designs: `(K, h)` positions of the held joints.
            design_of: `(K,)` which design (index) each sample is of.

        Returns:
            `(K,)` periods, zero of designs that do not come back; the different designs; and `(K,)`
            which of these (index) each sample is of.
        """
        _, chosen, of_design = np.unique(design_of, return_index=True, return_inverse=True)
        found = self.of_designs(designs[chosen])
        unit = np.where(found.period > 0.0, found.period, np.inf)[of_design]
        return np.trunc(ahead / unit), found, of_design

    @property
    def _coordinates(self) -> Coordinates:
        return self.kinematics.coordinates

    def _each(self, rows: Array) -> tuple[DesignTurns, Array]:
        """Return how each design comes back, and `(D,)` its greatest condition number meanwhile."""
        count, groups = len(rows), list(range(len(self.kinematics.solvers)))
        held = self.kinematics.part(self.held, groups)
        columns = [self.columns[index] for index in self.held]
        begin = along_lines(held, self.start[None, :], columns, rows)
        drive, column = self.kinematics.part([self.drive], groups), self.columns[self.drive]
        share = np.tile(np.arange(1.0, _LOOKS + 1.0) / _LOOKS, count)
        looks = OnLines(np.repeat(np.arange(count), _LOOKS), share)
        ends = begin.x[:, [column]] + self.period
        way = samples_on_lines(drive, begin.x, [column], ends, looks)
        end = way.x.reshape(count, _LOOKS, -1)[:, -1]
        comes_back, windings = self._compared(begin.x, end)
        comes_back &= begin.is_there & np.all(way.is_there.reshape(count, _LOOKS), axis=1)
        with np.errstate(all="ignore"):  # Of designs out of reach, nothing is said.
            condition = drive.evaluate(way.x).condition.reshape(count, _LOOKS).max(axis=1)
        period = np.where(comes_back, self.period, 0.0)
        return DesignTurns(period, windings * comes_back[:, None]), condition

    def _compared(self, first: Array, last: Array) -> tuple[Array, Array]:
        """Return `(D,)` whether rows are the same but for whole turns, and these `(D, size)`."""
        coordinates = self._coordinates
        turn, windings = 2.0 * np.pi, np.zeros_like(first)
        angles = coordinates.angle_columns
        windings[:, angles] = np.rint((last - first)[:, angles] / turn)
        missed = np.abs(last - first - turn * windings) * coordinates.scale
        for part, column in zip(coordinates.parts, coordinates.starts, strict=True):
            if part.kind == "spherical":
                # A quaternion and its negative are the same rotation.
                ball = slice(column, column + 4)
                missed[:, ball] = np.minimum(missed[:, ball], np.abs(last + first)[:, ball])
        return np.max(missed, axis=1, initial=0.0) < _SAME, windings
