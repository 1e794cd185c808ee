"""Element forces: what all elements of a scene exert at given motions and times."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..arrays import Array, inverse
from ..forces.link_loads import LinkLoad
from ..mechanism.mechanism import Mechanism
from .bushing import Bushing, BushingForce, too_far
from .element import Element
from .joint_elements import JointElement, JointForce
from .link_motions import LinkMotion, LinkMotions
from .pin_contact import ContactForce, ContactMotion, PinContact
from .point_spring import PointForce, PointSpring
from .rotation_vectors import greatest_angle
from .winding import Winding

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

ElementForce = JointForce | PointForce | BushingForce | ContactForce
"""What one element exerts, see its class."""


class LinkWrench(NamedTuple):
    """A wrench on a link.

    Attributes:
        link: its name.
        force: `(N, 3)` in world axes [N].
        moment: `(N, 3)` in world axes, about the link's origin [N·m].
    """

    link: str
    force: Array
    moment: Array


class Acted(NamedTuple):
    """What all elements exert together.

    Attributes:
        efforts: `(N, nv)` along the joint coordinates [N·m, N].
        wrenches: on links, of which some may be named more than once; those on the world are left
            out.
        potential_energy: `(N,)` of springs and bushings [J].
        power: `(N,)` at which all elements do work on the mechanism [W].
        dissipation: `(N,)` power that dampers and friction turn into heat [W], not negative.
    """

    efforts: Array
    wrenches: list[LinkWrench]
    potential_energy: Array
    power: Array
    dissipation: Array

    def link_loads(self, mechanism: Mechanism) -> list[LinkLoad]:
        """Return the wrenches placed in the bodies that carry their links."""
        placed = ((mechanism.links[wrench.link], wrench) for wrench in self.wrenches)
        return [
            LinkLoad(body - 1, frame.rotation, frame.translation, wrench.force, wrench.moment, True)
            for (body, frame), wrench in placed
        ]


class _Done(NamedTuple):
    """What one element exerts, and where.

    Attributes:
        force: what results show of it.
        power: `(N,)` at which it does work on the mechanism [W].
        wrenches: on links.
    """

    force: ElementForce
    power: Array
    wrenches: list[LinkWrench]


class ElementForces:
    """Computes what elements exert on a mechanism.

    Attributes:
        elements: the elements.
        labels: how messages call them.
    """

    def __init__(self, mechanism: Mechanism, elements: Sequence[Element]) -> None:
        """Find what the elements act on.

        Args:
            mechanism: in which every coordinate that an element names is a turn or a slide, as in
                `Scene.mechanism`.
            elements: the elements, checked against it.
        """
        self.elements = tuple(elements)
        self.labels = labels(self.elements)
        self._nv = mechanism.model.nv
        self._size = mechanism.characteristic_length
        self._named = mechanism.coordinates.named
        links = {link for element in self.elements for link in element.links}
        self._fixed = {link for link in links if mechanism.links[link][0] == 0}
        self._motions = LinkMotions(mechanism, links) if links else None
        self._ends = {
            index: element.origin_b
            if element.origin_b is not None
            else _without_deformation(mechanism, element)
            for index, element in enumerate(self.elements)
            if isinstance(element, Bushing)
        }

        self._windings = {
            index: _winding(mechanism, element, self._ends[index])
            for index, element in enumerate(self.elements)
            if isinstance(element, Bushing)
        }

    def end_of(self, index: int) -> Array:
        """Return the placement `(4, 4)` in `link_b` of the frame of a bushing, by its index."""
        return self._ends[index]

    def is_short(self, index: int, x: Array) -> bool:
        """Return whether a bushing has made no whole turns, by its index, at a row `x (size,)`."""
        return self._windings[index].is_short(x)

    def turns_of(self, index: int, x: Array, rotation: Array) -> Array:
        """Return rotation vectors `(N, 3)` of a bushing, whole turns counted.

        Args:
            index: of the element.
            x: `(N, size)` coordinates; angles count whole turns.
            rotation: `(N, 3, 3)` of its second frame relative to the first.

        Raises:
            ArgumentError: it is turned too far.
        """
        turn, lost = self._windings[index].turns(x, rotation)
        if np.any(lost):
            raise too_far(self.labels[index], greatest_angle(turn[lost]))
        return turn

    def at(self, x: Array, v: Array, time: ArrayLike = 0.0) -> Acted:
        """Return what all elements exert.

        Args:
            x: `(N, size)` coordinates, see `Coordinates`; angles count whole turns.
            v: `(N, nv)` joint velocities [rad/s, m/s].
            time: `(N,)` or a number [s].

        Raises:
            ArgumentError: an element's force is not defined: its points coincide, or it is turned
                too far; or an actuator's function fails.
        """
        count = len(x)
        efforts = np.zeros((count, self._nv))
        wrenches: list[LinkWrench] = []
        energy, power, dissipation = (np.zeros(count) for _ in range(3))
        for element, done in zip(self.elements, self._done(x, v, time), strict=True):
            if isinstance(done.force, JointForce):
                efforts[:, self._named[element.joints[0]].rate] += done.force.effort
            wrenches += done.wrenches
            energy += done.force.energy
            power += done.power
            dissipation += done.force.dissipation
        return Acted(efforts, wrenches, energy, power, dissipation)

    def each(self, x: Array, v: Array, time: ArrayLike = 0.0) -> list[ElementForce]:
        """Return what every element exerts; arguments and errors as of `at`."""
        return [done.force for done in self._done(x, v, time)]

    def _done(self, x: Array, v: Array, time: ArrayLike) -> list[_Done]:
        """Return what every element exerts, and where."""
        times = np.broadcast_to(np.asarray(time, dtype=float), (len(x),))
        links = self._motions.at(x, v) if self._motions else {}
        done = []
        for index, element in enumerate(self.elements):
            if isinstance(element, JointElement):
                item = self._named[element.joint]
                rates = v[:, item.rate]
                force = element.force(x[:, item.column], rates, times, self.labels[index])
                done.append(_Done(force, force.effort * rates, []))
            elif isinstance(element, PointSpring):
                done.append(self._of_spring(index, element, links, len(x)))
            elif isinstance(element, Bushing):
                done.append(self._of_bushing(index, element, links, x))
            elif isinstance(element, PinContact):
                done.append(self._of_contact(element, links, times))
        return done

    def _of_spring(
        self, index: int, element: PointSpring, links: dict[str, LinkMotion], count: int
    ) -> _Done:
        """Return what a point spring exerts at N samples.

        Args:
            index: of the element.
            element: the element.
            links: motions of the links.
            count: N.
        """
        at_a, at_b = links[element.link_a], links[element.link_b]
        arm_a, arm_b = at_a.rotation @ element.point_a, at_b.rotation @ element.point_b
        span = _all(at_b.position + arm_b - at_a.position - arm_a, count)
        rate = at_b.velocity + np.cross(at_b.spin, arm_b)
        rate = _all(rate - at_a.velocity - np.cross(at_a.spin, arm_a), count)
        done = element.force(span, rate, self.labels[index], self._size)
        wrenches = self._on_links(
            LinkWrench(element.link_a, done.force, np.cross(arm_a, done.force)),
            LinkWrench(element.link_b, -done.force, -np.cross(arm_b, done.force)),
        )
        return _Done(done, -np.einsum("ni,ni->n", done.force, rate), wrenches)

    def _of_bushing(
        self, index: int, element: Bushing, links: dict[str, LinkMotion], x: Array
    ) -> _Done:
        """Return what a bushing exerts at N samples.

        Args:
            index: of the element.
            element: the element.
            links: motions of the links.
            x: `(N, size)` coordinates, whole turns counted.
        """
        count = len(x)
        at_a, at_b = links[element.link_a], links[element.link_b]
        first, second = at_a.placed(element.origin), at_b.placed(self._ends[index])
        back = first.rotation.transpose(0, 2, 1)
        span = second.position - first.position
        # The velocity that is seen from the first frame, which turns.
        seen = second.velocity - first.velocity - np.cross(first.spin, span)
        rate = np.concatenate(
            [
                _all(np.einsum("nij,nj->ni", back, vector), count)
                for vector in np.broadcast_arrays(seen, second.spin - first.spin)
            ],
            axis=1,
        )
        span_seen = _all(np.einsum("nij,nj->ni", back, span), count)
        rotation = np.broadcast_to(back @ second.rotation, (count, 3, 3))
        turn = self.turns_of(index, x, rotation)
        done = element.force(turn, span_seen, rate, self.labels[index])
        force, moment = (
            np.einsum("nij,nj->ni", first.rotation, half)
            for half in (done.wrench[:, :3], done.wrench[:, 3:])
        )
        arm_a, arm_b = second.position - at_a.position, second.position - at_b.position
        wrenches = self._on_links(
            LinkWrench(element.link_a, -force, -moment - np.cross(arm_a, force)),
            LinkWrench(element.link_b, force, moment + np.cross(arm_b, force)),
        )
        return _Done(done, np.einsum("ni,ni->n", done.wrench, rate), wrenches)

    def _of_contact(self, element: PinContact, links: dict[str, LinkMotion], times: Array) -> _Done:
        """Return what a pin contact exerts at N samples.

        Args:
            element: the element.
            links: motions of the links.
            times: `(N,)` [s].
        """
        count = len(times)
        bush, pin = links[element.link_a], links[element.link_b]
        axis = _all(bush.rotation @ element.axis_a, count)
        arm = _all(pin.rotation @ element.point_b, count)
        beside = pin.position + arm - bush.position
        span = _all(beside - bush.rotation @ element.point_a, count)
        # The velocity of the pin's point as the bush sees it, which turns.
        seen = _all(pin.velocity + np.cross(pin.spin, arm) - bush.velocity, count)
        seen = seen - np.cross(bush.spin, beside)
        motion = ContactMotion(
            axis,
            span - axis * np.einsum("ni,ni->n", axis, span)[:, None],
            seen - axis * np.einsum("ni,ni->n", axis, seen)[:, None],
            np.einsum("ni,ni->n", axis, _all(pin.spin - bush.spin, count)),
        )
        done = element.force(motion, times)
        lever = element.arm(motion)
        wrenches = self._on_links(
            LinkWrench(element.link_a, -done.force, -np.cross(beside + lever, done.force)),
            LinkWrench(element.link_b, done.force, np.cross(arm + lever, done.force)),
        )
        moved = seen + np.cross(motion.axis * motion.spin[:, None], lever)
        return _Done(done, np.einsum("ni,ni->n", done.force, moved), wrenches)

    def _on_links(self, *wrenches: LinkWrench) -> list[LinkWrench]:
        """Return the wrenches that act on links which can move."""
        return [wrench for wrench in wrenches if wrench.link not in self._fixed]


def labels(elements: Sequence[Element]) -> tuple[str, ...]:
    """Return how messages call elements: by their index, class and name."""
    return tuple(
        f"elements[{index}] ({type(element).__name__}{f' {name!r}' if name else ''})"
        for index, element in enumerate(elements)
        for name in [element.name]
    )


def _all(vectors: Array, count: int) -> Array:
    """Return vectors `(N, 3)` or `(1, 3)` as `(N, 3)`."""
    return np.broadcast_to(vectors, (count, 3))


def _without_deformation(mechanism: Mechanism, element: Bushing) -> Array:
    """Return the `(4, 4)` placement in `link_b` of the frame in `link_a` at the zero."""
    row, rest = mechanism.zero[None], np.zeros((1, mechanism.model.nv))
    at_zero = LinkMotions(mechanism, element.links).at(row, rest)
    first, second = (_matrix(at_zero[link]) for link in element.links)
    return inverse(second) @ first @ element.origin


def _winding(mechanism: Mechanism, element: Bushing, end: Array) -> Winding:
    """Return the winding of a bushing, by the `(4, 4)` placement of its frame in `link_b`."""
    placements = zip(element.links, (element.origin, end), strict=True)
    first, second = (
        (mechanism.links[link][0], mechanism.links[link][1].rotation @ placement[:3, :3])
        for link, placement in placements
    )
    return Winding(mechanism, first, second)


def _matrix(motion: LinkMotion) -> Array:
    """Return the placement of a frame at the first sample as `(4, 4)`."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = motion.rotation[0], motion.position[0]
    return result
