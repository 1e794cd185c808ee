"""One state: what elements of a simulation see of a mechanism, and how they push its links.

A simulation asks for one state after the other, where arrays over samples cost more than what they
compute: `Acting.add` is `Acting.at` for one of them. Kinds that lack it are asked by arrays.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ..mechanism.mechanism import Mechanism
from .element import Acting, Element
from .link_motions import LinkMotion
from .pin_motion import cross


class OneState(NamedTuple):
    """A state of a mechanism.

    Attributes:
        time: [s].
        x: coordinates `(size,)`, see `Coordinates`; angles count whole turns.
        v: velocities `(nv,)` [rad/s, m/s].
        positions, speeds: the same as numbers.
        model: Pinocchio's, whose bodies are those of the mechanism; along its velocities are the
            efforts of what acts on links, which may differ from those of the mechanism.
        data: of the model: placements, velocities and Jacobians at the state; None for elements
            that name no link.
    """

    time: float
    x: Array
    v: Array
    positions: list[float]
    speeds: list[float]
    model: Any = None
    data: Any = None

    def push(
        self, efforts: Array, body: int, place: Array, force: Array, moment: Array | None = None
    ) -> None:
        """Add to efforts what does the work of a force at a place, and a moment, in world axes.

        Args:
            efforts: along the velocities of `model`.
            body: index of the body that is pushed; on the world nothing does work.
            place: `(3,)` [m].
            force: `(3,)` [N].
            moment: `(3,)` [N·m].
        """
        if body:
            turning = _cross(place, force)
            if moment is not None:
                turning += moment
            self.push_about_origin(efforts, body, np.concatenate([force, turning]))

    def push_about_origin(self, efforts: Array, body: int, wrench: Array) -> None:
        """Add to efforts what does the work of a wrench `(6,)` about the world's origin."""
        if body:
            world = pinocchio.ReferenceFrame.WORLD
            efforts += wrench.dot(pinocchio.getJointJacobian(self.model, self.data, body, world))

    def velocity(self, body: int, place: Array) -> Array:
        """Return the velocity `(3,)` of the point of a body that is at a place, in world axes."""
        if not body:
            return np.zeros(3)
        frame, moving = self.data.oMi[body], self.data.v[body]
        arm = place - frame.translation
        return np.asarray(frame.rotation @ moving.linear + _cross(self.spin(body), arm))

    def spin(self, body: int) -> Array:
        """Return the angular velocity `(3,)` of a body, in world axes."""
        if not body:
            return np.zeros(3)
        return np.asarray(self.data.oMi[body].rotation @ self.data.v[body].angular)


class ByArrays:
    """An element that is asked for one state by arrays of one sample; see `Acting.add`."""

    def __init__(self, element: Element, acting: Acting, mechanism: Mechanism) -> None:
        self._acting = acting
        self._links = {link: mechanism.link_frames[link] for link in element.links}

    def add(self, efforts: Array, state: OneState) -> None:
        """Add what it exerts to efforts, see `Acting.add`."""
        motions = {}
        for link, (body, frame) in self._links.items():
            placed = state.data.oMi[body] * frame
            place = placed.translation
            values = placed.rotation, place, state.velocity(body, place), state.spin(body)
            motions[link] = LinkMotion(*(value[None] for value in values))
        x, v, time = state.x[None], state.v[None], np.array([state.time])
        done = self._acting.at(x, v, time, motions)
        for rate, effort in done.efforts.items():
            efforts[rate] += effort[0]
        for wrench in done.wrenches:
            body = self._links[wrench.link][0]
            place = motions[wrench.link].position[0]
            state.push(efforts, body, place, wrench.force[0], wrench.moment[0])


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors; NumPy's takes ten times as long."""
    return np.array(cross(a.tolist(), b.tolist()))
