"""Element: what a force element is to the rest of the package, and checks of its numbers.

A kind of element is a class in a file of its own: its data, its law (`Acting`), what it is like
(`conserves`, `damps`, `gives_power`, `follows_time`, `jump`), and what results show of it
(`quantities`). The proof has its law once more.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from ...kit.arrays import Array
from ...kit.checks import number, positive, text
from ...kit.errors import ArgumentError
from ...kit.frozen import Value

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism
    from .link_motions import LinkMotion


class Quantity(NamedTuple):
    """A number or vector that results show of an element.

    Attributes:
        field: of what it exerts.
        name: of the variable in tables.
        label: what it is.
        units: of it, or of each component; empty for those of an effort along a coordinate.
        components: dimension of tables along which it has components; empty for a number.
        component_names: along that dimension.
    """

    field: str
    name: str
    label: str
    units: str | tuple[str, ...] = ""
    components: str = ""
    component_names: tuple[str, ...] = ("x", "y", "z")


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


ElementForce = Any
"""What one element exerts: a named tuple of arrays over samples, such as `JointForce`, with
`energy` that it stores [J] and `dissipation`, the power that it turns into heat [W]."""


class Exerted(NamedTuple):
    """What one element exerts, and where.

    Attributes:
        force: what results show of it.
        power: `(N,)` at which it does work on the mechanism [W].
        efforts: column of a velocity coordinate to the effort `(N,)` along it [N·m or N].
        wrenches: on links.
    """

    force: ElementForce
    power: Array
    efforts: Mapping[int, Array] = {}
    wrenches: tuple[LinkWrench, ...] = ()


class Acting(Protocol):
    """An element on a mechanism.

    A kind may have `add(efforts, state)` as well, which adds what it exerts at one state to the
    efforts along all velocities, see `OneState`: simulations ask for it so, and by `at` otherwise.
    `line` tells column, rate, stiffness, damping and rest of a linear law along a coordinate.
    """

    def at(self, x: Array, v: Array, time: Array, links: Mapping[str, LinkMotion]) -> Exerted:
        """Return what it exerts.

        Args:
            x: `(N, size)` coordinates, see `Coordinates`; angles count whole turns.
            v: `(N, nv)` joint velocities [rad/s, m/s].
            time: `(N,)` [s].
            links: motions of the links that it names.

        Raises:
            ArgumentError: its force is not defined there.
        """
        ...


class Element(Value, ABC):
    """A force element: frozen data, checked when it is made and by the scene that it is given to.

    Two elements are equal where all their values are.

    Attributes:
        name: by which results show it, beside its index; may be empty.
        group: dimension of tables along which elements of its kind stand.
        quantities: what results show of it, beside its energy and dissipation.
    """

    group: ClassVar[str]
    quantities: ClassVar[tuple[Quantity, ...]]
    name: str

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the coordinates along which it exerts an effort."""
        return ()

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links on which it exerts a wrench."""
        return ()

    @property
    def conserves(self) -> bool:
        """Whether it stores energy and does nothing else."""
        return False

    @property
    def damps(self) -> bool:
        """Whether it has viscous damping."""
        return False

    @property
    def gives_power(self) -> bool:
        """Whether its power comes from outside, neither from what it stores nor as heat."""
        return False

    @property
    def follows_time(self) -> bool:
        """Whether what it exerts is a function of time."""
        return False

    @property
    def has_functions(self) -> bool:
        """Whether users' functions or tables say what it exerts."""
        return False

    @property
    def limits(self) -> str:
        """Between which places its law is known; empty if it is everywhere."""
        return ""

    @property
    def jump(self) -> str:
        """Where and why its law is not smooth, and what to do about it; empty if it is."""
        return ""

    @abstractmethod
    def on(self, mechanism: Mechanism, label: str) -> Acting:
        """Return the element on a mechanism.

        Args:
            mechanism: in which every coordinate that it names is a turn or a slide.
            label: how messages call the element.
        """

    def _set(self, **values: object) -> None:
        """Set fields to what was checked; only constructors call it."""
        for field, value in values.items():
            object.__setattr__(self, field, value)

    def _number(self, field: str, least: float = -math.inf) -> float:
        """Return a field as a finite number that is not less than `least`."""
        return number(f"{type(self).__name__}: {field}", getattr(self, field), least)

    def _positive(self, field: str) -> float:
        """Return a field as a finite number greater than zero."""
        return positive(f"{type(self).__name__}: {field}", getattr(self, field))

    def _text(self, field: str) -> str:
        """Return a field as a string."""
        return text(f"{type(self).__name__}: {field}", getattr(self, field))


class LinkElement(Element):
    """An element between two links.

    Attributes:
        link_a, link_b: names of the links, one of which may stand in the world.
    """

    link_a: str
    link_b: str

    @property
    def links(self) -> tuple[str, ...]:
        """Names of both links."""
        return self.link_a, self.link_b

    def _two_links(self) -> tuple[str, str]:
        """Return the fields `link_a` and `link_b`."""
        first, second = self._text("link_a"), self._text("link_b")
        if first == second:
            raise ArgumentError(
                f"{type(self).__name__}: both ends are on link {first!r}; it connects two links"
            )
        return first, second
