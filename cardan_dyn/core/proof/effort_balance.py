"""Effort balance: joint wrenches along the coordinates against what is said to act there.

Along a passive coordinate a joint transmits only the efforts of loads and couplings; along a driven
or held one, the drive effort or the holding effort adds to them: τ = S · f (Featherstone 2008,
chapter 5).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..tape import Scalar
from .placing import Frame
from .screws import Screw, Screws, about
from .vectors import Vector, combine, component, dot, times


class _Along(NamedTuple):
    """A rate of a joint whose wrench is claimed.

    Attributes:
        wrench: index of this wrench.
        rate: joint velocity.
        axis: in the frame of the motion.
        motion: that has the rate; None if it is the last one of the joint, whose frame is that of
            the wrench as it is claimed.
        slides: whether it is a slide.
        scale: factor that makes an effort a moment.
    """

    wrench: int
    rate: int
    axis: Vector
    motion: int | None
    slides: bool
    scale: float


class EffortBalance:
    """The components of the claimed wrenches that act along the rates."""

    def __init__(self, screws: Screws, joints: Sequence[int], rate_scale: Sequence[float]) -> None:
        """Find the component of a wrench that acts along each rate.

        Args:
            screws: of the description's joints.
            joints: indices of the joints whose wrenches are claimed, in the order of the wrenches.
            rate_scale: `(nv,)` factor that makes an effort a moment: the length for slides.
        """
        self._along = []
        rows = zip(screws.owners, screws.rates, screws.axes, screws.sliding, strict=True)
        for owner, rate, axis, slides in rows:
            joint = screws.frames.motions[owner].joint
            if joint in joints:
                motion = None if screws.frames.last[joint] == owner else owner
                wrench, scale = joints.index(joint), rate_scale[rate]
                self._along.append(_Along(wrench, rate, axis, motion, slides, scale))

    def imbalances(
        self,
        placed: Sequence[Frame],
        wrenches: Sequence[Screw],
        in_world: Sequence[Screw],
        given: Sequence[Scalar],
    ) -> list[Scalar]:
        """Return differences [N·m] between wrenches along rates and what is given.

        Args:
            placed: frames of all motions.
            wrenches: of the claimed joints, each in its frame.
            in_world: the same in world axes about the corner.
            given: what loads, drives, held joints and couplings exert along all rates [N·m, N].
        """
        differences = []
        for item in self._along:
            if item.motion is None:
                force, moment = wrenches[item.wrench]
                along = component(force if item.slides else moment, item.axis)
            else:
                frame, wrench = placed[item.motion], in_world[item.wrench]
                vector = wrench[0] if item.slides else about(frame.origin, wrench)[1]
                along = dot(vector, combine(frame.axes, item.axis))
            differences.append(times(along - given[item.rate], item.scale))
        return differences
