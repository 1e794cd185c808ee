"""Branch table: closed positions along a drive with two derivatives, and the curve through them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.coordinates import Coordinates
from .all_groups import ClosedState, Kinematics

_HERMITE = np.array(
    [
        [0.0, 1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0],
        [10.0, -6.0, -1.5, -4.0, 0.5],
        [-15.0, 8.0, 1.5, 7.0, -1.0],
        [6.0, -3.0, -0.5, -3.0, 0.5],
    ]
)
"""Quintic Hermite polynomials on an interval of width one, a row per power of the share from the
first on. The columns are factors of the difference of both values, of the left node's derivatives
and of the right node's."""


class BranchTable(NamedTuple):
    """Nodes of a branch in ascending order of the drive. It is never changed.

    Attributes:
        positions: `(K,)` drive positions of the nodes [rad or m].
        nodes: `(K, 3, size)` coordinates, their first and their second derivatives with respect
            to the drive.
        drive_column: column of the drive in a row of coordinates.
        coordinates: layout of those rows.
    """

    positions: Array
    nodes: Array
    drive_column: int
    coordinates: Coordinates

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.positions)

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest drive position of a node."""
        return float(self.positions[0]), float(self.positions[-1])

    @property
    def states(self) -> Array:
        """Closed coordinates `(K, size)` of all nodes."""
        return self.nodes[:, 0]

    def with_nodes(self, nodes: Array) -> BranchTable:
        """Return a table that also holds new nodes `(M, 3, size)`, given in any order."""
        positions = np.concatenate([self.positions, nodes[:, 0, self.drive_column]])
        order = np.argsort(positions, kind="stable")
        joined = np.concatenate([self.nodes, nodes])[order]
        return _table(positions[order], joined, self.drive_column, self.coordinates)

    def with_replaced(self, chosen: Array, nodes: Array) -> BranchTable:
        """Return a table in which the nodes chosen by a mask `(K,)` are replaced.

        Args:
            chosen: true for M nodes.
            nodes: `(M, 3, size)` at the same drive positions.
        """
        replaced = self.nodes.copy()
        replaced[chosen] = nodes
        return _table(self.positions, replaced, self.drive_column, self.coordinates)

    def guess(self, positions: Array) -> Array:
        """Return `(N, size)` coordinates near the branch, exact in the drive's coordinate.

        Quintic Hermite interpolation of values, first and second derivatives; a single node is
        repeated.

        Args:
            positions: `(N,)` drive positions.
        """
        return self._with_drive(self.values(positions, slice(None)), positions)

    def values(self, positions: Array, columns: Array | slice) -> Array:
        """Return `(N, k)` some coordinates near the branch; see `guess`.

        Args:
            positions: `(N,)` drive positions.
            columns: of a row; quaternions come without their unit length.
        """
        if self.size == 1:
            return np.repeat(self.nodes[:, 0, columns], len(positions), axis=0)
        left = self.positions[1:-1].searchsorted(positions)
        right, low = left + 1, self.positions[left]
        width = self.positions[right] - low
        nodes = self.nodes
        if len(positions) < self.size:
            left_nodes, right_nodes = nodes[left][:, :, columns], nodes[right][:, :, columns]
        else:
            nodes = nodes[:, :, columns]
            left_nodes, right_nodes = nodes[left], nodes[right]
        return _hermite(left_nodes, right_nodes, width, (positions - low) / width)

    def extrapolated(self, indices: list[int], positions: Array) -> Array:
        """Return coordinates `(E, size)` beyond nodes, by Taylor polynomials of second order.

        Args:
            indices: of E nodes.
            positions: `(E,)` drive positions.
        """
        rows = taylor(self.nodes[indices], positions - self.positions[indices])
        return self._with_drive(rows, positions)

    def error_back(self, nodes: Array, indices: list[int]) -> Array:
        """Return how far new nodes' Taylor polynomials miss the nodes that they come from.

        Towards a dead point the derivatives grow without bound: a step can be short enough to
        extrapolate to its end, and too long to interpolate over it.

        Args:
            nodes: `(E, 3, size)` new nodes.
            indices: of the nodes of this table that they come from.

        Returns:
            `(E,)` greatest deviation of a coordinate [rad, or characteristic lengths].
        """
        step = self.positions[indices] - nodes[:, 0, self.drive_column]
        deviation = taylor(nodes, step) - self.states[indices]
        return np.asarray(np.max(np.abs(deviation) * self.coordinates.scale, axis=1))

    def _with_drive(self, rows: Array, positions: Array) -> Array:
        rows[:, self.drive_column] = positions
        return self.coordinates.normalised(rows)


def table_of(kinematics: Kinematics, state: ClosedState, drive_column: int) -> BranchTable:
    """Return the table of a single node, at a closed state of one sample."""
    nodes = nodes_of(kinematics, state)
    return _table(nodes[:, 0, drive_column], nodes, drive_column, kinematics.coordinates)


def nodes_of(kinematics: Kinematics, state: ClosedState) -> Array:
    """Return coordinates, their first and their second derivatives `(N, 3, size)`.

    The derivatives are taken with respect to the only drive of the kinematics.
    """
    coordinates = kinematics.coordinates
    ones = np.ones((len(state.x), 1))
    v = kinematics.rates(state, ones)
    a = kinematics.accelerations(state, v, 0.0 * ones)
    first, second = coordinates.derivative(state.x, v), coordinates.curvature(state.x, v, a)
    return np.stack([state.x, first, second], axis=1)


def taylor(nodes: Array, step: Array) -> Array:
    """Return Taylor polynomials of second order `(N, size)`, from nodes `(N, 3, size)`.

    Args:
        nodes: values, first and second derivatives.
        step: `(N,)` drive displacements from there.
    """
    step = step[:, None]
    return np.asarray(nodes[:, 0] + step * (nodes[:, 1] + 0.5 * step * nodes[:, 2]))


def _table(
    positions: Array, nodes: Array, drive_column: int, coordinates: Coordinates
) -> BranchTable:
    """Return a table whose arrays cannot be written to."""
    positions.setflags(write=False)
    nodes.setflags(write=False)
    return BranchTable(positions, nodes, drive_column, coordinates)


def _hermite(left: Array, right: Array, width: Array, share: Array) -> Array:
    """Return quintic Hermite polynomials `(N, size)` between nodes `(N, 3, size)`.

    Args:
        left: nodes at the share 0.
        right: nodes at the share 1.
        width: `(N,)` drive displacements between them.
        share: `(N,)` share of the width.
    """
    powers = np.multiply.accumulate(np.repeat(share[:, None], 5, axis=1), axis=1)
    weights = powers @ _HERMITE
    # Derivatives are taken with respect to the drive: first ones count times the width, second
    # ones times its square.
    weights[:, 1:] *= width[:, None]
    weights[:, 2::2] *= width[:, None]
    known = np.concatenate((right[:, :1] - left[:, :1], left[:, 1:], right[:, 1:]), axis=1)
    return np.asarray(left[:, 0] + np.matmul(weights[:, None], known)[:, 0])
