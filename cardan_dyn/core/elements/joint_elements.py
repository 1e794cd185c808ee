"""Joint elements: efforts along one coordinate of a joint.

An effort is positive in the sense of its coordinate [N·m, or N at a slide], like a load there.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import described, numbers
from ...kit.errors import ArgumentError, choices
from .element import Element, Exerted, Quantity

if TYPE_CHECKING:
    from ..mechanism.coordinates import Scalar
    from ..mechanism.mechanism import Mechanism
    from .link_motions import LinkMotion
    from .one_state import OneState

_OF = ("time", "position")
"""What functions of actuators take."""


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
class Actuator(JointElement):
    """An effort along a coordinate: a number, or a function of time or of its position.

    One of position is a load such as a pump's or a press's over the angle of its shaft. The work
    that it takes or gives counts as an actuator's; what it may store is not kept account of.

    Attributes:
        joint: name of the joint, or of one of its coordinates.
        effort: [N·m or N]; or a function that returns it for a time [s] or a position [rad or m],
            a number or an array.
        name: by which results show it; may be empty.
        of: what a function takes, `time` or `position`. Angles count whole turns.

    Raises:
        ArgumentError: the effort is neither a finite number nor a function, or `of` is neither.
    """

    joint: str
    effort: float | Callable[[Any], Any]
    name: str = ""
    of: str = "time"

    def __post_init__(self) -> None:
        effort = self.effort if callable(self.effort) else self._number("effort")
        self._set(joint=self._text("joint"), effort=effort, name=self._text("name"))
        if not isinstance(self.of, str) or self.of not in _OF:
            raise ArgumentError(f"Actuator: of is {described(self.of)}; it is {choices(_OF)}")

    @property
    def gives_power(self) -> bool:
        """See `Element.gives_power`."""
        return True

    @property
    def follows_time(self) -> bool:
        """Whether the effort is a function of time."""
        return callable(self.effort) and self.of == "time"

    @property
    def has_functions(self) -> bool:
        """Whether the effort is a function."""
        return callable(self.effort)

    def force(self, x: Array, v: Array, time: Array, label: str) -> JointForce:
        """Return what it exerts, see `JointElement.force`."""
        none = np.zeros(len(x))
        if not callable(self.effort):
            return JointForce(np.full(len(x), self.effort), none, none)
        places = time if self.of == "time" else x
        return JointForce(_at_places(self.effort, places, f"{label}: effort", self.of), none, none)

    def effort_at(self, x: float, v: float, time: float, label: str) -> float:
        """See `JointElement.effort_at`."""
        if not callable(self.effort):
            return float(self.effort)
        place = time if self.of == "time" else x
        return _at_place(self.effort, place, f"{label}: effort", self.of)


def _at_places(function: Callable[[Any], Any], at: Array, label: str, of: str) -> Array:
    """Return the values of a function at `(N,)` times or positions, all at once if it can."""
    if len(at) > 1 and np.any(at != at[0]):
        values = _of_array(function, at)
        if values is not None:
            return numbers(label, values)
        return np.array([_at_place(function, item, label, of) for item in at.tolist()])
    return np.full(len(at), _at_place(function, float(at[0]), label, of) if len(at) else 0.0)


def _of_array(function: Callable[[Any], Any], at: Array) -> Array | None:
    """Return the values of a function of an array, None if it takes no arrays."""
    try:
        values = np.asarray(function(at.copy()))
    except Exception:  # It was written for numbers, and fails with arrays in any way.
        return None
    return values if values.shape == at.shape and values.dtype.kind in "iuf" else None


def _at_place(function: Callable[[Any], Any], at: float, label: str, of: str) -> float:
    """Return the value of a function at a time or position."""
    text = f"{label} at {at:g} s" if of == "time" else f"{label} at position {at:g}"
    try:
        value = function(at)
    except Exception as error:
        raise ArgumentError(f"{text} fails: {type(error).__name__}: {error}") from error
    array = numbers(text, value)
    if array.size != 1:
        raise ArgumentError(f"{text} has shape {array.shape}, expected a number")
    return float(array.reshape(()))
