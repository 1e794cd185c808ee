"""Element efforts: what force elements exert, along all coordinates, one state at a time.

`ElementForces` computes the same for many states at once. A simulation asks for one state after the
other, where arrays over samples cost more than what they compute.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from ..elements.bushing import Bushing, PlacedBushing, too_far
from ..elements.element import Element
from ..elements.element_forces import ElementForces, labels
from ..elements.joint_elements import Actuator, JointElement, JointSpring
from ..elements.pin_contact import PinContact
from ..elements.point_spring import PointSpring
from ..elements.winding import GREATEST_ANGLE
from ..mechanism.mechanism import Mechanism
from ..mechanism.tree import se3
from .pin_motion import PinMotion


class _End(NamedTuple):
    """A point of a spring.

    Attributes:
        joint: index of the joint in the model that moves it, 0 for the world.
        point: `(3,)` in that joint's frame [m].
    """

    joint: int
    point: Array


class _Joined(NamedTuple):
    """A bushing between two bodies.

    Attributes:
        element: the bushing.
        joints: indices of the joints in the model that move its ends, 0 for the world.
        placements: `pin.SE3` of its frames in those joints' frames.
        acting: the bushing on the mechanism.
    """

    element: Bushing
    joints: tuple[int, int]
    placements: tuple[pinocchio.SE3, pinocchio.SE3]
    acting: PlacedBushing


class ElementEfforts:
    """Efforts of elements along all coordinates.

    Attributes:
        is_conservative: whether all elements are springs without damping.
        has_functions: whether actuators follow functions.
    """

    def __init__(self, mechanism: Mechanism, elements: Sequence[Element]) -> None:
        """Sort the elements by what they need.

        Args:
            mechanism: the mechanism.
            elements: checked against it.
        """
        self._mechanism = mechanism
        named = mechanism.coordinates.named
        self._nv = mechanism.model.nv
        every = ElementForces(mechanism, elements)
        pairs = list(zip(elements, labels(elements), strict=True))
        joint_springs = [item for item in elements if isinstance(item, JointSpring)]
        self._columns = np.array([named[item.joint].column for item in joint_springs], dtype=int)
        self._rates = np.array([named[item.joint].rate for item in joint_springs], dtype=int)
        self._stiffness = np.array([item.stiffness for item in joint_springs])
        self._damping = np.array([item.damping for item in joint_springs])
        self._rest = np.array([item.rest for item in joint_springs])
        self._others = [
            (item, named[item.joint], label)
            for item, label in pairs
            if isinstance(item, JointElement) and not isinstance(item, JointSpring)
        ]
        self._springs = [
            (
                item,
                self._end(item.link_a, item.point_a),
                self._end(item.link_b, item.point_b),
                label,
            )
            for item, label in pairs
            if isinstance(item, PointSpring)
        ]
        self._bushings = [
            self._joined(item, acting)
            for item, acting in zip(elements, every.acting, strict=True)
            if isinstance(item, Bushing) and isinstance(acting, PlacedBushing)
        ]
        self._contacts = [
            PinMotion(mechanism, item) for item in elements if isinstance(item, PinContact)
        ]
        self.has_functions = any(
            isinstance(item, Actuator) and callable(item.effort) for item in elements
        )
        self.is_conservative = all(item.conserves for item in elements)

    def _end(self, link: str, point: Array) -> _End:
        joint, frame = self._mechanism.links[link]
        return _End(joint, np.asarray(frame.act(point)))

    def _joined(self, element: Bushing, acting: PlacedBushing) -> _Joined:
        (first, frame_a), (second, frame_b) = (
            self._mechanism.links[link] for link in element.links
        )
        placements = frame_a * se3(np.asarray(element.origin)), frame_b * se3(acting.end)
        return _Joined(element, (first, second), placements, acting)

    @property
    def act_on_links(self) -> bool:
        """Whether elements act on links, not along coordinates."""
        return bool(self._springs or self._bushings or self._contacts)

    @property
    def rates(self) -> set[int]:
        """Velocity coordinates along which elements act."""
        return set(self._rates.tolist()) | {item.rate for _, item, _ in self._others}

    @property
    def bodies(self) -> set[int]:
        """Bodies of the mechanism's model on which elements act."""
        joints = [end.joint for _, *ends, _ in self._springs for end in ends]
        joints += [joint for item in self._bushings for joint in item.joints]
        joints += [joint for item in self._contacts for joint in item.joints]
        return set(joints)

    def add_along_coordinates(self, efforts: Array, time: float, x: Array, v: Array) -> None:
        """Add what joint elements exert at a state to efforts `(nv,)`; see `Forces.efforts`."""
        if self._columns.size:
            pull = self._stiffness * (x[self._columns] - self._rest)
            np.add.at(efforts, self._rates, -pull - self._damping * v[self._rates])
        for element, coordinate, label in self._others:
            at, rate = x[coordinate.column :][:1], v[coordinate.rate :][:1]
            efforts[coordinate.rate] += element.force(at, rate, np.array([time]), label).effort[0]

    def add_on_links(
        self, efforts: Array, model: Any, data: Any, time: float, q: Array, rates: Array, x: Array
    ) -> None:
        """Add what elements exert on links to efforts `(nv,)`; see `Forces.on_links`."""
        if self.act_on_links:
            pinocchio.forwardKinematics(model, data, q, rates)
            pinocchio.computeJointJacobians(model, data, q)
        for spring in self._springs:
            _add_spring(efforts, model, data, *spring)
        for bushing in self._bushings:
            self._add_bushing(efforts, model, data, bushing, x)
        for contact in self._contacts:
            contact.add(efforts, model, data, time)

    def _add_bushing(
        self, efforts: Array, model: Any, data: Any, bushing: _Joined, x: Array
    ) -> None:
        """Add the efforts of a bushing, see `Bushing`; placements and Jacobians are computed."""
        element, (first, second) = bushing.element, bushing.joints
        a, b = (
            data.oMi[joint] * placement
            for joint, placement in zip(bushing.joints, bushing.placements, strict=True)
        )
        seen = a.actInv(b)
        if bushing.acting.is_short(x):
            turned = pinocchio.log3(seen.rotation)
            if turned @ turned > GREATEST_ANGLE**2:
                raise too_far(bushing.acting.label, float(np.linalg.norm(turned)))
            gradient = element.stiffness @ np.concatenate([seen.translation, turned])
            # The right Jacobian's inverse is the transposed inverse of the left one.
            gradient[3:] = pinocchio.Jlog3(seen.rotation) @ gradient[3:]
            if np.any(element.damping):
                gradient += element.damping @ _relative_velocity(data, bushing, a, b)
            wrench = -gradient
        else:
            wrench = self._wound(bushing, data, x, seen, (a, b))
        force, moment = a.rotation @ wrench[:3], a.rotation @ wrench[3:]
        if second:
            _add_wrench(efforts, model, data, second, b.translation, force, moment)
        if first:
            _add_wrench(efforts, model, data, first, b.translation, -force, -moment)

    def _wound(
        self, bushing: _Joined, data: Any, x: Array, seen: Any, frames: tuple[Any, Any]
    ) -> Array:
        """Return the wrench `(6,)` of a bushing that may have made whole turns."""
        element = bushing.element
        turn = bushing.acting.turns(x[None], seen.rotation[None])
        rate = np.zeros(6)
        if np.any(element.damping):
            rate = _relative_velocity(data, bushing, *frames)
        force = element.force(turn, seen.translation[None], rate[None], bushing.acting.label)
        return np.asarray(force.wrench[0])


def _add_spring(
    efforts: Array, model: Any, data: Any, spring: PointSpring, a: _End, b: _End, label: str
) -> None:
    """Add the efforts of a point spring; placements, velocities and Jacobians are computed."""
    at_a, at_b = (np.asarray(data.oMi[end.joint].act(end.point)) for end in (a, b))
    rate = np.zeros(3)
    if spring.damping:
        rate = _velocity(data, b, at_b) - _velocity(data, a, at_a)
    force = spring.force((at_b - at_a)[None, :], rate[None, :], label).force[0]
    none = np.zeros(3)
    if a.joint:
        _add_wrench(efforts, model, data, a.joint, at_a, force, none)
    if b.joint:
        _add_wrench(efforts, model, data, b.joint, at_b, -force, none)


def _relative_velocity(data: Any, bushing: _Joined, a: Any, b: Any) -> Array:
    """Return the velocity `(6,)` of a bushing's second frame as the first, `a`, sees it."""
    spins = [
        data.oMi[joint].rotation @ data.v[joint].angular if joint else np.zeros(3)
        for joint in bushing.joints
    ]
    ends = (_End(joint, np.zeros(3)) for joint in bushing.joints)
    # That of the point of the first body where the second frame's origin is.
    at_a, at_b = (_velocity(data, end, b.translation) for end in ends)
    back = a.rotation.T
    return np.concatenate([back @ (at_b - at_a), back @ (spins[1] - spins[0])])


def _velocity(data: Any, end: _End, place: Array) -> Array:
    """Return the velocity `(3,)` of a point in the world [m/s]."""
    if not end.joint:
        return np.zeros(3)
    frame, velocity = data.oMi[end.joint], data.v[end.joint]
    spin = frame.rotation @ velocity.angular
    return np.asarray(frame.rotation @ velocity.linear + np.cross(spin, place - frame.translation))


def _add_wrench(
    efforts: Array,
    model: Any,
    data: Any,
    joint: int,
    place: Array,
    force: Array,
    moment: Array,
) -> None:
    """Add the efforts that do the work of a force at a place and a moment, in world axes."""
    jacobian = pinocchio.getJointJacobian(model, data, joint, pinocchio.ReferenceFrame.WORLD)
    efforts += jacobian[:3].T @ force + jacobian[3:].T @ (moment + np.cross(place, force))
