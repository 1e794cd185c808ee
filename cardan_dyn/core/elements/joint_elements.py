"""Joint elements: efforts along one coordinate of a joint.

An effort is positive in the sense of its coordinate [N·m, or N at a slide], like a load there.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError
from .element import Element, Exerted, Quantity
from .law import Given, Law, LawElement

if TYPE_CHECKING:
    from ..mechanism.coordinates import Scalar
    from ..mechanism.mechanism import Mechanism
    from .link_motions import LinkMotion
    from .one_state import OneState

_OF = ("time", "position")
"""What laws of actuators take."""


class JointForce(NamedTuple):
    """What an element exerts along a coordinate.

    Attributes:
        effort: `(N,)` in the sense of the coordinate [N·m or N].
        energy: `(N,)` that it stores [J].
        dissipation: `(N,)` power that it turns into heat [W].
    """

    effort: Array
    energy: Array
    dissipation: Array


class JointElement(Element):
    """An element that exerts an effort along one coordinate.

    Attributes:
        joint: name of the joint, or of one of its coordinates, see `Mechanism.drivable`.
    """

    group = "joint_element"
    quantities = (
        Quantity("effort", "element_effort", "effort of the element along its coordinate"),
    )
    joint: str

    @property
    def joints(self) -> tuple[str, ...]:
        """The coordinate's name alone."""
        return (self.joint,)

    def on(self, mechanism: Mechanism, label: str) -> _AlongCoordinate:
        """See `Element.on`."""
        return _AlongCoordinate(self, mechanism.coordinates.named[self.joint], label)

    @property
    def line(self) -> Line | None:
        """The law, if it is linear in position and speed; None if it is not."""
        return None

    @abstractmethod
    def force(self, x: Array, v: Array, time: Array, label: str) -> JointForce:
        """Return what it exerts.

        Args:
            x: positions of the coordinate `(N,)`, whole turns counted [rad or m].
            v: its speeds `(N,)` [rad/s or m/s].
            time: `(N,)` [s].
            label: how messages call the element.

        Raises:
            ArgumentError: the effort cannot be computed.
        """

    def effort_at(self, x: float, v: float, time: float, label: str) -> float:
        """Return its effort at one state; arguments and errors as of `force`."""
        return float(self.force(np.array([x]), np.array([v]), np.array([time]), label).effort[0])


class Line(NamedTuple):
    """The effort -stiffness (x - rest) - damping v, of `JointSpring`."""

    stiffness: float
    damping: float
    rest: float


class _AlongCoordinate(NamedTuple):
    """An element along a coordinate of a mechanism."""

    element: JointElement
    coordinate: Scalar
    label: str

    def at(self, x: Array, v: Array, time: Array, links: Mapping[str, LinkMotion]) -> Exerted:
        """See `Acting.at`."""
        rates = v[:, self.coordinate.rate]
        force = self.element.force(x[:, self.coordinate.column], rates, time, self.label)
        return Exerted(force, force.effort * rates, {self.coordinate.rate: force.effort})

    @property
    def line(self) -> tuple[int, int, float, float, float] | None:
        """Column, rate and `Line` of what is linear, which is added at once where there is much."""
        line = self.element.line
        return None if line is None else (self.coordinate.column, self.coordinate.rate, *line)

    def add(self, efforts: Array, state: OneState) -> None:
        """See `Acting`."""
        rate = self.coordinate.rate
        x, v = state.positions[self.coordinate.column], state.speeds[rate]
        efforts[rate] += self.element.effort_at(x, v, state.time, self.label)


@dataclass(frozen=True, eq=False)
class JointSpring(JointElement):
    """A spring and a damper along a coordinate: the effort -stiffness (x - rest) - damping v.

    Attributes:
        joint: name of the joint, or of one of its coordinates.
        stiffness: not negative [N·m/rad or N/m].
        damping: not negative [N·m·s/rad or N·s/m].
        rest: position at which the spring is without effort [rad or m]. Angles count whole turns.
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number, or negative.
    """

    joint: str
    stiffness: float
    damping: float = 0.0
    rest: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        self._set(
            joint=self._text("joint"),
            stiffness=self._number("stiffness", least=0.0),
            damping=self._number("damping", least=0.0),
            rest=self._number("rest"),
            name=self._text("name"),
        )

    @property
    def conserves(self) -> bool:
        """Whether it has no damping."""
        return self.damping == 0.0

    @property
    def damps(self) -> bool:
        """Whether it has damping."""
        return self.damping != 0.0

    @property
    def line(self) -> Line:
        """See `JointElement.line`."""
        return Line(self.stiffness, self.damping, self.rest)

    def force(self, x: Array, v: Array, time: Array, label: str) -> JointForce:
        """Return what it exerts, see `JointElement.force`."""
        turn = x - self.rest
        pull, drag = self.stiffness * turn, self.damping * v
        return JointForce(-pull - drag, 0.5 * pull * turn, drag * v)

    def effort_at(self, x: float, v: float, time: float, label: str) -> float:
        """See `JointElement.effort_at`."""
        return -self.stiffness * (x - self.rest) - self.damping * v


@dataclass(frozen=True, eq=False)
class JointFriction(JointElement):
    """Dry friction along a coordinate: the effort -effort v / sqrt(v² + transition²).

    The jump of Coulomb's law is rounded off, so that the law is smooth: at the speed `transition`
    the effort is 71 % of its greatest value, at seven times it 99 %, and a joint at rest exerts
    none, where real friction would hold it. Sweeps and simulations use the same law.

    Attributes:
        joint: name of the joint, or of one of its coordinates.
        effort: of sliding, not negative [N·m or N].
        transition: speed at which friction sets in, positive [rad/s or m/s].
        name: by which results show it; may be empty.

    Raises:
        ArgumentError: a value is no finite number, or out of its range.
    """

    joint: str
    effort: float
    transition: float = 1e-3
    name: str = ""

    def __post_init__(self) -> None:
        self._set(
            joint=self._text("joint"),
            effort=self._number("effort", least=0.0),
            transition=self._number("transition"),
            name=self._text("name"),
        )
        if not self.transition > 0.0:
            raise ArgumentError(
                f"JointFriction: transition is {self.transition:g}; it is a positive speed"
            )

    @property
    def jump(self) -> str:
        """See `Element.jump`."""
        if not self.effort:
            return ""
        return (
            f"dry friction at {self.joint!r}: its jump is not smooth, so that it has no linear "
            "vibration; use Scene.simulate, or damping of a JointSpring instead"
        )

    def force(self, x: Array, v: Array, time: Array, label: str) -> JointForce:
        """Return what it exerts, see `JointElement.force`."""
        effort = -self.effort * v / np.hypot(v, self.transition)
        return JointForce(effort, np.zeros_like(effort), -effort * v)

    def effort_at(self, x: float, v: float, time: float, label: str) -> float:
        """See `JointElement.effort_at`."""
        return -self.effort * v / math.hypot(v, self.transition)


@dataclass(frozen=True, eq=False)
class Actuator(LawElement, JointElement):
    """An effort along a coordinate: a number, a table, or a function of time or of its position.

    One of position is a load such as a pump's or a press's over the angle of its shaft. The work
    that it takes or gives counts as an actuator's, and what a function may store is not kept
    account of; a table of positions stores energy.

    Attributes:
        joint: name of the joint, or of one of its coordinates.
        effort: [N·m or N]; or a function that returns it for a time [s] or a position [rad or m],
            a number or an array; or a table `(n, 2)` of times or positions, which ascend, and
            efforts, with straight lines between its rows, or of both, as of `PointActuator`.
            Beyond its ends is an error.
        name: by which results show it; may be empty.
        of: what a function or table takes, `time` or `position`, or both in their order. Angles
            count whole turns.

    Raises:
        ArgumentError: the effort is no finite number, table or function, or `of` is unknown.
    """

    along = "position"
    joint: str
    effort: Given
    name: str = ""
    of: str | Sequence[str] = "time"

    def __post_init__(self) -> None:
        effort, name = self.law.given, self._text("name")
        of = self.of if isinstance(self.of, str) else tuple(self.of)
        self._set(joint=self._text("joint"), effort=effort, name=name, of=of)
        super().__post_init__()

    @cached_property
    def law(self) -> Law:
        """The effort and what it depends on."""
        return Law.checked("Actuator: effort", self.effort, self.of, _OF)

    def force(self, x: Array, v: Array, time: Array, label: str) -> JointForce:
        """Return what it exerts, see `JointElement.force`."""
        law, none = self.law, np.zeros(len(x))
        effort = law.at(f"{label}: effort", time=time, position=x)
        return JointForce(effort, law.energy(x) if self.conserves else none, none)

    def effort_at(self, x: float, v: float, time: float, label: str) -> float:
        """See `JointElement.effort_at`."""
        return self.law.at_one(f"{label}: effort", time=time, position=x)
