"""Twists: velocities and accelerations of all joints, added up from the root outwards.

Arrays of twists are `(…, 2, 3, N)`: the linear part (velocity of the body's point that lies at
`Frames.corner`) [m/s], then the angular part [rad/s], in world axes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanism.frames import Frames

_LEFT, _RIGHT = np.array([1, 2, 0, 2, 0, 1]), np.array([2, 0, 1, 1, 2, 0])
"""Components whose products a cross product adds, and three that it takes off."""


class State(NamedTuple):
    """A mechanism at given coordinates, in world axes, samples along the last axis.

    Attributes:
        motion_frames: `(M, 4, 3, N)` frames of the elementary motions, see `Frames.placed`.
        joint_frames: `(J, 4, 3, N)` frames of all joints, see `Frames.joint_frames`.
        directions: `(K, 3, N)` unit vector along which each rate acts.
        unit_twists: `(K, 2, 3, N)` twist per unit of each rate.
    """

    motion_frames: Array
    joint_frames: Array
    directions: Array
    unit_twists: Array


class Twists:
    """The rates of a description's joints and the twists that they cause.

    There are K rates of M elementary motions: one rate per turn or slide, three per ball.

    Attributes:
        frames: of the description.
        owners: `(K,)` per rate, the index of its elementary motion.
        rates: `(K,)` its index among the joint velocities.
        sliding: `(K,)` whether it is a slide.
        axes: `(K, 3)` its direction in the frame of its motion.
        along_frame_axes: whether all of them are axes of their frames, or opposite to one.
    """

    def __init__(self, frames: Frames) -> None:
        self.frames = frames
        owners, axes, rates = [], [], []
        for index, motion in enumerate(frames.motions):
            directions = np.eye(3) if motion.kind == "ball" else motion.axis[None]
            for offset, direction in enumerate(directions):
                owners.append(index)
                axes.append(direction)
                rates.append(motion.rate + offset)
        self.owners = np.array(owners, dtype=int)
        self.rates = np.array(rates, dtype=int)
        self.axes = np.array(axes).reshape(-1, 3)
        self.sliding = np.array([frames.motions[k].kind == "slide" for k in owners], dtype=bool)
        self._slides = np.flatnonzero(self.sliding)
        # The first rate of each motion; balls have two more.
        self._firsts = np.flatnonzero(np.diff(self.owners, prepend=-1))
        self._balls = [k for k, motion in enumerate(frames.motions) if motion.kind == "ball"]
        # A direction along a frame axis is a column of the frame, up to its sign; copying that
        # column is faster than multiplying the frame with the axis.
        self.along_frame_axes = bool(np.all(np.count_nonzero(self.axes, axis=1) == 1))
        self._columns = 4 * self.owners + np.argmax(np.abs(self.axes), axis=1)
        signs = self.axes.sum(axis=1)[:, None, None]
        self._signs = None if np.all(signs == 1.0) else signs

    def state(self, x: Array) -> State:
        """Return the frames and unit twists at coordinates `x (N, size)`."""
        motion_frames = self.frames.placed(x)
        joint_frames = self.frames.joint_frames(motion_frames)
        directions = self._directions(motion_frames)
        unit_twists = self._unit_twists(motion_frames, directions)
        return State(motion_frames, joint_frames, directions, unit_twists)

    def relative(self, state: State, rates: Array) -> Array:
        """Return `(M, 2, …, 3, N)` the twist of each motion's frame relative to the one before it.

        Args:
            state: of the mechanism.
            rates: joint velocities `(nv, …, N)`.
        """
        twists, more = state.unit_twists, rates.ndim - 2
        if more:
            twists = twists.reshape(*twists.shape[:2], *[1] * more, *twists.shape[2:])
        added = twists * rates.take(self.rates, 0)[:, None, ..., None, :]
        if not self._balls:
            return added
        result = added.take(self._firsts, 0)
        for ball in self._balls:
            first = self._firsts[ball]
            result[ball] += added[first + 1]
            result[ball] += added[first + 2]
        return result

    def absolute(self, relative: Array) -> Array:
        """Return the sums of relative twists, or accelerations, from the world to each motion.

        Args:
            relative: `(M, 2, 3, N)`.

        Returns:
            Those of all motions' frames relative to the world, `(M, 2, 3, N)`.
        """
        result = relative.copy()
        for alike in self.frames.alike:
            if alike.before is not None:
                result[alike.own] += result[alike.before]
        return result

    def relative_accelerations(
        self, state: State, relative: Array, velocities: Array, a: Array
    ) -> Array:
        """Return what each motion adds to the acceleration of the frame before it.

        Accelerations are time derivatives of twists at `Frames.corner`, which is fixed in the
        world; points of bodies that pass there have other accelerations.

        Args:
            state: of the mechanism.
            relative: twists from `relative`.
            velocities: twists of the motions' frames, from `absolute`.
            a: joint accelerations `(nv, N)`.

        Returns:
            `(M, 2, 3, N)` [m/s², rad/s²].
        """
        added = self.relative(state, a)
        # The axis of a motion moves with the frame before it, which changes the twist about it.
        before = velocities - relative
        added += cross(before[:, [1]], relative)
        added[:, 0] += cross(before[:, 0], relative[:, 1])
        return added

    def _directions(self, motion_frames: Array) -> Array:
        """Return `(K, 3, N)` the unit vector along which each rate acts."""
        if self.along_frame_axes:
            axes = motion_frames.reshape(-1, *motion_frames.shape[2:]).take(self._columns, 0)
            return axes if self._signs is None else np.asarray(axes * self._signs)
        return np.asarray(np.einsum("kc,kcin->kin", self.axes, motion_frames[self.owners, :3]))

    def _unit_twists(self, motion_frames: Array, directions: Array) -> Array:
        """Return `(K, 2, 3, N)` the twist per unit of each rate."""
        twists = np.empty((len(directions), 2, *directions.shape[1:]))
        twists[:, 1] = directions
        origins = motion_frames[:, 3]
        if self._balls:
            origins = origins.take(self.owners, 0)
        twists[:, 0] = cross(origins, directions)
        if self._slides.size:
            twists[self._slides, 0] = directions[self._slides]
            twists[self._slides, 1] = 0.0
        return twists


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the last axis but one, for arrays `(…, 3, N)`.

    `np.cross` would need that axis to be moved, and makes more copies.
    """
    products = a.take(_LEFT, -2) * b.take(_RIGHT, -2)
    return np.asarray(products[..., :3, :] - products[..., 3:, :])
