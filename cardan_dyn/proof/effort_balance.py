"""Effort balance: joint wrenches along the coordinates against what is said to act there.

Along a passive coordinate a joint transmits only the efforts of loads and couplings; along a driven
or held one, the drive effort or the holding effort adds to them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from .twists import State, Twists, cross
from .wrenches import JointWrenches


class EffortBalance:
    """The components of the claimed wrenches that act along the rates."""

    def __init__(self, twists: Twists, joints: Sequence[int], rate_scale: Array) -> None:
        """Find the component of a wrench that acts along each rate.

        Args:
            twists: of the description's joints.
            joints: indices of the joints whose wrenches are claimed, in the order of the wrenches.
            rate_scale: `(nv,)` factor that makes an effort a moment: the length for slides.
        """
        self._twists = twists
        frames = twists.frames
        owners = [frames.motions[owner].joint for owner in twists.owners]
        index_of = {joint: index for index, joint in enumerate(joints)}
        rows = [row for row, joint in enumerate(owners) if joint in index_of]
        # The frame of a joint is that of its last motion: along this motion's rates, the effort is
        # a component of the wrench in the joint's frame, just as it was returned.
        last = [row for row in rows if frames.last[owners[row]] == twists.owners[row]]
        inner = [row for row in rows if row not in set(last)]
        last_rows = np.array(last, dtype=int)
        self._inner_rows = np.array(inner, dtype=int)
        self._last_joints = np.array([index_of[owners[row]] for row in last], dtype=int)
        self._inner_joints = np.array([index_of[owners[row]] for row in inner], dtype=int)
        force_or_moment = np.where(twists.sliding[last_rows], 0, 1)
        axes = twists.axes[last_rows]
        # Rows of all components of the wrenches one behind the other. Along an axis of the frame
        # the effort is one of them up to its sign, else a sum over three.
        rows = 6 * self._last_joints + 3 * force_or_moment
        self._are_aligned = bool(np.all(np.count_nonzero(axes, axis=1) == 1))
        if self._are_aligned:
            self._rows = rows + np.abs(axes).argmax(axis=1)
            self._factors = axes.sum(axis=1)[:, None]
        else:
            self._rows, self._factors = rows[:, None] + np.arange(3), axes[:, :, None]
        self._rates = twists.rates[np.array([*last, *inner], dtype=int)]
        scale = rate_scale[self._rates][:, None]
        self._scale = None if np.all(scale == 1.0) else scale

    def imbalance(self, state: State, wrenches: JointWrenches, given: Array) -> Array:
        """Return `(N,)` the greatest difference [N·m] between a wrench along a rate and `given`.

        Args:
            state: of the mechanism.
            wrenches: of the claimed joints.
            given: `(nv, N)` what loads, drives, held joints and couplings exert [N·m, N].
        """
        components = wrenches.in_joint_frames.reshape(-1, given.shape[1]).take(self._rows, 0)
        difference = components * self._factors
        if not self._are_aligned:
            difference = np.add.reduce(difference, axis=1)
        if self._inner_rows.size:
            twists, rows = self._twists, self._inner_rows
            in_world = wrenches.in_world[self._inner_joints]
            origins = state.motion_frames[twists.owners[rows], 3]
            moment = in_world[:, 1] - cross(origins, in_world[:, 0])
            vectors = np.where(twists.sliding[rows, None, None], in_world[:, 0], moment)
            inner = np.einsum("kin,kin->kn", vectors, state.directions[rows])
            difference = np.concatenate((difference, inner))
        difference -= given.take(self._rates, 0)
        if self._scale is not None:
            difference *= self._scale
        return np.asarray(np.maximum.reduce(np.abs(difference), axis=0, initial=0.0))
