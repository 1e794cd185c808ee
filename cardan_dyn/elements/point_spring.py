"""Point spring: a spring and a damper between points of two links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import vector
from ..errors import ArgumentError
from .element import Element

_COINCIDENT = 1e-12
"""Distance of two points, relative to the spring's length, from which rounding alone may part them:
it has no direction."""


class PointForce(NamedTuple):
    """What a point spring exerts.

    Attributes:
        tension: `(N,)` by which it pulls its points together [N].
        length: `(N,)` distance of the points [m].
        force: `(N, 3)` on `link_a` at its point, in world axes [N]; on `link_b`, the opposite.
        energy: `(N,)` that the spring stores [J].
        dissipation: `(N,)` power that the damper turns into heat [W].
    """

    tension: Array
    length: Array
    force: Array
    energy: Array
    dissipation: Array


@dataclass(frozen=True, eq=False)
class PointSpring(Element):
    """A spring and a damper along the line between points of two links.

    It pulls the points together by the tension stiffness (distance - length) + damping d(distance)/
    dt; a negative tension pushes them apart. With the length zero, the force of the spring is
    stiffness times the vector from one point to the other, at any distance; where the points
    coincide, the damper acts against their relative velocity in any direction.

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
        link_a, link_b = self._two_links()
        self._set(
            link_a=link_a,
            point_a=vector("PointSpring: point_a", self.point_a, 3),
            link_b=link_b,
            point_b=vector("PointSpring: point_b", self.point_b, 3),
            stiffness=self._number("stiffness", least=0.0),
            damping=self._number("damping", least=0.0),
            length=self._number("length", least=0.0),
            name=self._text("name"),
        )
        super().__post_init__()

    @property
    def links(self) -> tuple[str, ...]:
        """Names of both links."""
        return self.link_a, self.link_b

    def force(self, span: Array, rate: Array, label: str) -> PointForce:
        """Return what it exerts.

        Args:
            span: `(N, 3)` from the point of `link_a` to that of `link_b`, in world axes [m].
            rate: `(N, 3)` velocity of the second relative to the first, in world axes [m/s].
            label: how messages call the element.

        Raises:
            ArgumentError: the points coincide and the length is not zero, so that the force has no
                direction.
        """
        distance = np.sqrt(np.einsum("ni,ni->n", span, span))
        if self.length > 0.0:
            coincident = distance <= _COINCIDENT * self.length
            if np.any(coincident):
                raise ArgumentError(
                    f"{label}: its points coincide at sample {int(np.argmax(coincident))}, where "
                    "the force has no direction; a spring that may do so has the length 0"
                )
        else:
            coincident = distance == 0.0
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
