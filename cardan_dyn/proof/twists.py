"""Twists: velocities and accelerations of all joints, summed up from the root outwards.

Arrays are `(…, 2, 3, N)`: the linear part (of the point at `Frames.corner`), then the angular one,
in world axes.
"""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..mechanism.frames import Frames


class Twists:
    """The rates of a description's joints and the twists that they make.

    Attributes:
        owners: `(K,)` per rate, the number of its elementary motion.
        rates: `(K,)` its place among joint velocities.
        sliding: `(K,)` whether it is a slide.
        axes: `(K, 3)` along what, in its motion's frame.
    """

    def __init__(self, frames: Frames) -> None:
        self._before = [motion.before for motion in frames.motions]
        owners, axes, rates = [], [], []
        for number, motion in enumerate(frames.motions):
            directions = np.eye(3) if motion.kind == "ball" else motion.axis[None]
            for place, direction in enumerate(directions):
                owners.append(number)
                axes.append(direction)
                rates.append(motion.rate + place)
        self.owners = np.array(owners, dtype=int)
        self.rates = np.array(rates, dtype=int)
        self.axes = np.array(axes).reshape(-1, 3)
        self.sliding = np.array([frames.motions[k].kind == "slide" for k in owners], dtype=bool)
        self._single = len(set(owners)) == len(owners)
        # Along an axis of its frame, a direction is a column up to its sign.
        self._plain = bool(np.all(np.count_nonzero(self.axes, axis=1) == 1))
        self._columns = np.argmax(np.abs(self.axes), axis=1)
        self._signs = self.axes.sum(axis=1)[:, None, None]

    def directions(self, placed: Array) -> Array:
        """Return along what every rate acts, `(K, 3, N)`, for frames from `Frames.placed`."""
        if self._plain:
            return np.asarray(placed[self.owners, self._columns] * self._signs)
        return np.asarray(np.einsum("kc,kcin->kin", self.axes, placed[self.owners, :3]))

    def units(self, placed: Array, directions: Array) -> Array:
        """Return the twist of every rate `(K, 2, 3, N)`."""
        units = np.empty((len(directions), 2, *directions.shape[1:]))
        units[:, 1] = directions
        units[:, 0] = cross(placed[self.owners, 3], directions)
        units[self.sliding, 0] = directions[self.sliding]
        units[self.sliding, 1] = 0.0
        return units

    def own(self, units: Array, rates: Array) -> Array:
        """Return what each motion adds for rates `(nv, N)`, `(M, 2, 3, N)`."""
        added = units * rates[self.rates][:, None, None]
        if self._single:
            return added
        result = np.zeros((len(self._before), *added.shape[1:]))
        np.add.at(result, self.owners, added)
        return result

    def summed(self, own: Array) -> Array:
        """Return twists of all motions' frames from what each motion adds."""
        result = own.copy()
        for number, before in enumerate(self._before):
            if before >= 0:
                result[number] += result[before]
        return result

    def changes(self, units: Array, own: Array, velocities: Array, a: Array) -> Array:
        """Return what each motion adds to the accelerations, `(M, 2, 3, N)`.

        Args:
            units: from `units`.
            own: what each motion adds to the velocities.
            velocities: of the motions' frames.
            a: joint accelerations `(nv, N)`.
        """
        added = self.own(units, a)
        # A motion's twist is carried along by the one before it.
        carried = velocities - own
        added += cross(carried[:, [1]], own)
        added[:, 0] += cross(carried[:, 0], own[:, 1])
        return added


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the last axis but one."""
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for one, other, third in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        part = result[..., one, :]
        np.multiply(a[..., other, :], b[..., third, :], out=part)
        part -= a[..., third, :] * b[..., other, :]
    return result
