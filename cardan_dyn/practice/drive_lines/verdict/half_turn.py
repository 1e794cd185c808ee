"""Half turn: what acts half a turn later, which is the same.

Forks, crosses and their inertias are those that they were after half a turn of all shafts. So all
forces come back in space; in axes that turn with a shaft, what is across it changes its sign.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....kit.arrays import ROUNDED, Array
from .analysis import LineForces
from .line_motion import LineMotion

_TURNING = frozenset({"moment_in", "moment_out", "spline_force", "spline_moment", "centring_force"})
"""Vectors in axes that turn with a shaft."""


class HalfTurn(NamedTuple):
    """Positions of the input shaft of which none is another one half turns later.

    Attributes:
        positions: `(Q,)` those that are solved [rad].
        source: `(P,)` for each position that is asked for, the index of the one that is solved.
        later: `(P,)` how many half turns later it is.
    """

    positions: Array
    source: Array
    later: Array

    @staticmethod
    def of(positions: Array) -> HalfTurn:
        """Return what is to be solved for positions `(P,)`."""
        slack = ROUNDED * np.maximum(np.abs(positions), 1.0)
        number = np.floor((positions + slack) / np.pi)
        within = positions - np.pi * number
        order = np.argsort(within, kind="stable")
        begins = np.diff(within[order], prepend=-np.inf) > slack[order]
        if begins.all():
            everything = np.arange(len(positions))
            return HalfTurn(positions, everything, np.zeros(len(positions)))
        group = np.cumsum(begins) - 1
        # Of each group the first one in the order of the positions; these stay in that order.
        first = np.full(group[-1] + 1, len(positions))
        np.minimum.at(first, group, order)
        chosen = np.sort(first)
        source = np.empty(len(positions), dtype=int)
        source[order] = np.searchsorted(chosen, first[group])
        return HalfTurn(positions[chosen], source, number - number[chosen][source])

    def same(self, values: Array, trailing: int) -> Array:
        """Return values at all positions of what comes back.

        Args:
            values: `(…, Q)`, with so many axes more.
            trailing: number of these axes.
        """
        if len(self.source) == len(self.positions):
            return values
        return np.take(values, self.source, axis=values.ndim - 1 - trailing)

    def forces(self, forces: LineForces) -> LineForces:
        """Return forces at all positions."""
        is_odd = np.flatnonzero(self.later % 2.0)
        found = {}
        for name, values in forces._asdict().items():
            every = self.same(values, values.ndim - forces.drive_torque.ndim)
            if name in _TURNING and is_odd.size:
                every[..., is_odd, :, 1:] *= -1.0
            found[name] = every
        return LineForces(**found)

    def motion(self, motion: LineMotion) -> LineMotion:
        """Return the motion at all positions."""
        return LineMotion(
            self.same(motion.rotation, 1) + np.pi * self.later[:, None],
            self.same(motion.ratio, 1),
            self.same(motion.acceleration, 1),
            self.same(motion.slip, 1),
            motion.mean_lead,
        )
