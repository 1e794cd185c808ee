"""Point spring: what acts along the line between points of two links; a spring and a damper."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import vector
from ...kit.errors import ArgumentError
from .element import Exerted, LinkElement, LinkWrench, Quantity

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism
    from .link_motions import LinkMotion
    from .one_state import OneState

COINCIDENT = 1e-12
"""Distance of two points, relative to the greatest length of a spring or its mechanism, by which
rounding alone may part them: it has no direction."""


class PointForce(NamedTuple):
    """What an element between points exerts.

    Attributes:
        tension: `(N,)` by which it pulls its points together [N].
        length: `(N,)` distance of the points [m].
        force: `(N, 3)` on `link_a` at its point, in world axes [N]; on `link_b`, the opposite.
        energy: `(N,)` that it stores [J].
        dissipation: `(N,)` power that it turns into heat [W].
    """

    tension: Array
    length: Array
    force: Array
    energy: Array
    dissipation: Array


class PointElement(LinkElement):
    """An element along the line between points of two links.

    Attributes:
        point_a, point_b: `(3,)` in the frames of the links [m].
    """

    group = "point_spring"
    quantities = (
        Quantity("tension", "element_tension", "tension that pulls the points together", "N"),
        Quantity("length", "element_length", "distance of the points of the element", "m"),
        Quantity(
            *("force", "element_force", "force of the element on its link_a, in world axes"),
            *("N", "component"),
        ),
    )
    point_a: Array
    point_b: Array

    @property
    @abstractmethod
    def feels_rate(self) -> bool:
        """Whether what it exerts depends on the rate of its length."""

    def on(self, mechanism: Mechanism, label: str) -> _BetweenPoints:
        """See `Element.on`."""
        (body_a, frame_a), (body_b, frame_b) = (mechanism.link_frames[link] for link in self.links)
        ends = (body_a, frame_a.act(self.point_a)), (body_b, frame_b.act(self.point_b))
        return _BetweenPoints(self, label, mechanism.characteristic_length, ends)

    @abstractmethod
    def force(
        self, span: Array, rate: Array, time: Array, label: str, size: float = 0.0
    ) -> PointForce:
        """Return what it exerts.

        Args:
            span: `(N, 3)` from the point of `link_a` to that of `link_b`, in world axes [m].
            rate: `(N, 3)` velocity of the second relative to the first, in world axes [m/s].
            time: `(N,)` [s].
            label: how messages call the element.
            size: length of the mechanism, whose rounding may part points that coincide [m].

        Raises:
            ArgumentError: the points coincide, so that the force has no direction; or a law is not
                defined there.
        """

    @abstractmethod
    def tension_at(self, length: float, rate: float, time: float, label: str) -> float:
        """Return its tension [N] at one state, of points that do not coincide; as of `force`.

        Args:
            length: distance of the points [m].
            rate: of the distance [m/s].
            time: [s].
            label: how messages call the element.
        """

    def _ends(self) -> dict[str, object]:
        """Return the fields of its ends and its name, checked."""
        (link_a, link_b), kind = self._two_links(), type(self).__name__
        return {
            "link_a": link_a,
            "point_a": vector(f"{kind}: point_a", self.point_a, 3),
            "link_b": link_b,
            "point_b": vector(f"{kind}: point_b", self.point_b, 3),
            "name": self._text("name"),
        }


def without_direction(label: str, coincident: Array, advice: str = "") -> ArgumentError:
    """Return the error for points that coincide at some of the samples `(N,)`."""
    return ArgumentError(
        f"{label}: its points coincide at sample {int(np.argmax(coincident))}, where the force has "
        f"no direction{advice}"
    )


@dataclass(frozen=True, eq=False)
class PointSpring(PointElement):
    """A spring and a damper along the line between points of two links.

    It pulls the points together by the tension stiffness (distance - length) + damping d(distance)/
    dt; a negative tension pushes them apart. With the length zero, the force of the spring is
    stiffness times the vector from one point to the other, at any distance; where the points
    coincide, the damper acts against their relative velocity in any direction. A `PointActuator`
    has any other law.

    Attributes:
        link_a, link_b: names of the links, one of which may stand in the world.
        point_a, point_b: `(3,)` in the frames of the links [m].
        stiffness: not negative [N/m].
        damping: not negative [N·s/m].
        length: of the spring without tension, not negative [m].
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number, negative or of a wrong shape, or both links are
            the same.
    """

    link_a: str
    point_a: Array
    link_b: str
    point_b: Array
    stiffness: float
    damping: float = 0.0
    length: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        self._set(
            **self._ends(),
            stiffness=self._number("stiffness", least=0.0),
            damping=self._number("damping", least=0.0),
            length=self._number("length", least=0.0),
        )
        super().__post_init__()

    @property
    def conserves(self) -> bool:
        """Whether it has no damping."""
        return self.damping == 0.0

    @property
    def damps(self) -> bool:
        """Whether it has damping."""
        return self.damping != 0.0

    @property
    def feels_rate(self) -> bool:
        """See `PointElement.feels_rate`."""
        return self.damps

    def force(
        self, span: Array, rate: Array, time: Array, label: str, size: float = 0.0
    ) -> PointForce:
        """Return what it exerts, see `PointElement.force`; with the length 0 it always can."""
        distance = np.sqrt(np.einsum("ni,ni->n", span, span))
        coincident = distance <= COINCIDENT * max(self.length, size)
        if self.length > 0.0 and np.any(coincident):
            advice = "; a spring that may do so has the length 0"
            raise without_direction(label, coincident, advice)
        away = np.where(coincident, 1.0, distance)
        speed = np.einsum("ni,ni->n", span, rate) / away
        drag = rate
        if not np.all(coincident):
            drag = np.where(coincident[:, None], rate, span * (speed / away)[:, None])
        speed = np.where(coincident, np.sqrt(np.einsum("ni,ni->n", rate, rate)), speed)
        stretch = distance - self.length
        pull = self.stiffness * stretch
        # A spring of length zero pulls in proportion to its span: no direction is needed.
        along = self.stiffness * (1.0 if self.length == 0.0 else stretch / away)
        force = np.broadcast_to(along, distance.shape)[:, None] * span + self.damping * drag
        return PointForce(
            tension=pull + self.damping * speed,
            length=distance,
            force=force,
            energy=0.5 * pull * stretch,
            dissipation=self.damping * speed**2,
        )

    def tension_at(self, length: float, rate: float, time: float, label: str) -> float:
        """See `PointElement.tension_at`."""
        return self.stiffness * (length - self.length) + self.damping * rate


class _BetweenPoints(NamedTuple):
    """An element between points on a mechanism.

    Attributes:
        element: the element.
        label: how messages call it.
        size: characteristic length of the mechanism [m].
        ends: bodies that move its points, 0 for the world, and these in their frames.
    """

    element: PointElement
    label: str
    size: float
    ends: tuple[tuple[int, Array], tuple[int, Array]]

    def at(self, x: Array, v: Array, time: Array, links: Mapping[str, LinkMotion]) -> Exerted:
        """See `Acting.at`."""
        element, shape = self.element, (len(x), 3)
        at_a, at_b = links[element.link_a], links[element.link_b]
        arm_a, arm_b = at_a.rotation @ element.point_a, at_b.rotation @ element.point_b
        span = np.broadcast_to(at_b.position + arm_b - at_a.position - arm_a, shape)
        rate = at_b.velocity + np.cross(at_b.spin, arm_b)
        rate = np.broadcast_to(rate - at_a.velocity - np.cross(at_a.spin, arm_a), shape)
        done = element.force(span, rate, time, self.label, self.size)
        wrenches = (
            LinkWrench(element.link_a, done.force, np.cross(arm_a, done.force)),
            LinkWrench(element.link_b, -done.force, -np.cross(arm_b, done.force)),
        )
        return Exerted(done, -np.einsum("ni,ni->n", done.force, rate), wrenches=wrenches)

    def add(self, efforts: Array, state: OneState) -> None:
        """See `Acting`."""
        element, ((body_a, _), (body_b, _)) = self.element, self.ends
        at_a, at_b = (np.asarray(state.data.oMi[body].act(point)) for body, point in self.ends)
        span, rate = at_b - at_a, np.zeros(3)
        if element.feels_rate:
            rate = state.velocity(body_b, at_b) - state.velocity(body_a, at_a)
        length = math.sqrt(span.dot(span))
        if length > COINCIDENT * self.size:
            speed = float(span.dot(rate)) / length
            force = element.tension_at(length, speed, state.time, self.label) / length * span
        else:
            time = np.array([state.time])
            force = element.force(span[None, :], rate[None, :], time, self.label).force[0]
        state.push(efforts, body_a, at_a, force)
        state.push(efforts, body_b, at_b, -force)
