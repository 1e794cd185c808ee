"""Point actuator: a force along the line between points of two links, by any law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...kit.arrays import Array
from .law import Given, Law, LawElement
from .point_spring import COINCIDENT, PointElement, PointForce, without_direction

_OF = ("time", "length", "rate")
"""What laws of point actuators take."""


@dataclass(frozen=True, eq=False)
class PointActuator(LawElement, PointElement):
    """A thrust along the line between points of two links: a number, a table, or a function.

    A positive thrust pushes the points apart, in the sense of their distance, as a cylinder or a
    gas spring does; results show its opposite, the tension.

    What it turns over is kept account of by what it depends on: a table of lengths stores energy,
    counted from the least within the table; a law of the rate alone turns its power into heat (a
    negative one where it drives); all other power counts as an actuator's.

    Attributes:
        link_a, link_b: names of the links, one of which may stand in the world.
        point_a, point_b: `(3,)` in the frames of the links [m].
        thrust: [N]; or a function that returns it for a time [s], the distance of the points [m]
            or its rate [m/s], a number or an array; or a table `(n, 2)` of such places, which
            ascend, and thrusts, with straight lines between its rows; or a table
            `(n + 1, m + 1)` of two of them, with places of the first in its first column, of the
            second in its first row, and thrusts between, bilinear. Beyond its ends is an error.
        name: by which results show it; may be empty.
        of: what a function or table takes, `time`, `length` or `rate`; or several of them in
            their order, a table two.

    Raises:
        ArgumentError: the thrust is no finite number, table or function, `of` is unknown, a point
            is none, or both links are the same.
    """

    along = "length"
    link_a: str
    point_a: Array
    link_b: str
    point_b: Array
    thrust: Given
    name: str = ""
    of: str | Sequence[str] = "time"

    def __post_init__(self) -> None:
        thrust = self.law.given
        of = self.of if isinstance(self.of, str) else tuple(self.of)
        self._set(**self._ends(), thrust=thrust, of=of)
        super().__post_init__()

    @cached_property
    def law(self) -> Law:
        """The thrust and what it depends on."""
        return Law.checked("PointActuator: thrust", self.thrust, self.of, _OF)

    @property
    def feels_rate(self) -> bool:
        """See `PointElement.feels_rate`."""
        return "rate" in self.law.of

    @property
    def jump(self) -> str:
        """See `Element.jump`."""
        if not self.feels_rate:
            return ""
        return (
            f"the thrust between {self.link_a!r} and {self.link_b!r} is a law of the rate, which "
            "has no linear vibration; use Scene.simulate, or damping of a PointSpring instead"
        )

    def force(
        self, span: Array, rate: Array, time: Array, label: str, size: float = 0.0
    ) -> PointForce:
        """Return what it exerts, see `PointElement.force`."""
        length = np.sqrt(np.einsum("ni,ni->n", span, span))
        coincident = length <= COINCIDENT * size
        if np.any(coincident):
            raise without_direction(label, coincident)
        direction = span / length[:, None]
        speed, none = np.einsum("ni,ni->n", direction, rate), np.zeros(len(span))
        law = self.law
        thrust = law.at(f"{label}: thrust", time=time, length=length, rate=speed)
        return PointForce(
            tension=-thrust,
            length=length,
            force=-thrust[:, None] * direction,
            energy=law.energy(length) if self.conserves else none,
            dissipation=-thrust * speed if self.is_damper else none,
        )

    def tension_at(self, length: float, rate: float, time: float, label: str) -> float:
        """See `PointElement.tension_at`."""
        return -self.law.at_one(f"{label}: thrust", time=time, length=length, rate=rate)
