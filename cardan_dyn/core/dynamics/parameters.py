"""Parameters: numbers by which samples are differentiated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kit.arrays import EPS
from ...kit.errors import ModelError
from ..description.description import Description
from ..elements.element import Element
from ..mechanics.bodies import Mass, Tree
from ..mechanics.vectors import UNTURNED
from ..mechanism.mechanism import Mechanism
from ..tape import Scalar
from .tape import LinkKind


@dataclass(frozen=True)
class Parameter:
    """A number by which samples are differentiated.

    Attributes:
        name: as it was asked for.
    """

    name: str


@dataclass(frozen=True)
class OfColumn(Parameter):
    """A driven or held coordinate [rad or m], by its column."""

    column: int


@dataclass(frozen=True)
class OfRow(Parameter):
    """A number among what is prescribed, by its row in `Prescribed`."""

    row: int


@dataclass(frozen=True)
class OfDescription(Parameter):
    """A number of a description.

    Attributes:
        changed: returns a description in which it is greater by some amount.
        nodes, weights: amounts, and the sum of weighted numbers there that is the derivative of all
            that is of second degree in the number, or trigonometric of second degree in an angle:
            of placements, which products of two rotations are, and of what bodies exert.
    """

    changed: Callable[[Description, float], Description]
    nodes: tuple[float, ...]
    weights: tuple[float, ...]


@dataclass(frozen=True)
class OfMass(OfDescription):
    """Mass, centre or inertia of a link.

    Attributes:
        link: its name.
        body: index of the body that carries the link.
        adds: returns the masses that a change adds, by the change and the unit of length.
    """

    link: str
    body: int
    adds: Callable[[Scalar, float], tuple[Mass, ...]]


@dataclass(frozen=True)
class OfOrigin(OfDescription):
    """A length or an angle in the placement of a joint.

    Attributes:
        displaced: returns the mechanism in which it is greater by some amount [m or rad].
        unit: amount that changes a mechanism by about its own size.
    """

    displaced: Callable[[float], Mechanism]
    unit: float

    @classmethod
    def of_length(
        cls,
        name: str,
        changed: Callable[[Description, float], Description],
        displaced: Callable[[float], Mechanism],
        far: float,
    ) -> OfOrigin:
        """Return one of a length, whose numbers are compared at places that far away [m]."""
        return cls(name, changed, (far, -far), (0.5 / far, -0.5 / far), displaced, far)

    @classmethod
    def of_angle(
        cls,
        name: str,
        changed: Callable[[Description, float], Description],
        displaced: Callable[[float], Mechanism],
    ) -> OfOrigin:
        """Return one of an angle."""
        nodes = tuple(np.pi / 4.0 * k for k in (1, 3, -3, -1))
        weights = tuple(
            sign / (8.0 * np.sin(node / 2.0) ** 2)
            for sign, node in zip((1.0, -1.0, 1.0, -1.0), nodes, strict=True)
        )
        return cls(name, changed, nodes, weights, displaced, 1.0)

    def slopes(
        self, numbers_at: Callable[[Mechanism], tuple[Tree, tuple[LinkKind, ...]]]
    ) -> tuple[Any, Any]:
        """Return the derivatives of all numbers of a tree and of links, in their structure.

        Args:
            numbers_at: returns those of a mechanism.

        Raises:
            ModelError: the tree has numbers of other kinds.
        """
        numbers = [numbers_at(self.displaced(node)) for node in self.nodes]
        tree = numbers[0][0]
        if tree.spins or tree.gears:
            raise ModelError(
                f"{self.name}: the lines of idle rods and the teeth of gears depend on it, of "
                "which derivatives are not known; of gears, couple them by forces='none'; of rods, "
                "write one end as a universal joint, which does not spin, or drive or hold the spin"
            )
        # Axes of lengths and angles that are held turn: at some of these places, they are numbers.
        numbers = [(_with_vectors(tree), links) for tree, links in numbers]
        of_tree, of_links = _slope(numbers, self.weights)
        return of_tree, of_links

    def moved(
        self,
        tree: Tree,
        links: tuple[LinkKind, ...],
        change: Scalar,
        numbers_at: Callable[[Mechanism], tuple[Tree, tuple[LinkKind, ...]]],
    ) -> tuple[Tree, tuple[LinkKind, ...]]:
        """Return a tree and links whose numbers change with this one; errors as of `slopes`."""
        of_tree, of_links = self.slopes(numbers_at)
        of = Tree(*of_tree)
        moved = {name: _moved(getattr(tree, name), getattr(of, name), change) for name in _PLACED}
        return tree._replace(**moved), _moved(links, of_links, change)


def _with_vectors(tree: Tree) -> Tree:
    """Return a tree in which no axis is a number."""
    bodies = (
        body._replace(axis=UNTURNED[body.axis]) if isinstance(body.axis, int) else body
        for body in tree.bodies
    )
    return tree._replace(bodies=tuple(bodies))


_PLACED = ("axes", "bodies", "loops")
"""What of a tree depends on where joints are."""


def _slope(values: Sequence[Any], weights: Sequence[float]) -> Any:
    """Return a weighted sum of numbers in nested tuples and arrays; 0.0 where rounding is left."""
    first = values[0]
    if isinstance(first, tuple):
        return tuple(_slope(items, weights) for items in zip(*values, strict=True))
    if isinstance(first, np.ndarray):
        return _slope([tuple(value.tolist()) for value in values], weights)
    if isinstance(first, list):
        return _slope([tuple(value) for value in values], weights)
    if not isinstance(first, float):
        return 0.0
    terms = [value * weight for value, weight in zip(values, weights, strict=True)]
    result = sum(terms)
    return result if abs(result) > 4.0 * EPS * sum(map(abs, terms)) else 0.0


def _moved(value: Any, slope: Any, change: Scalar) -> Any:
    """Return numbers in nested tuples and arrays, which change by some times their slopes."""
    if isinstance(value, int) and isinstance(slope, tuple):  # An axis.
        return _moved(UNTURNED[value], slope, change) if any(slope) else value
    if isinstance(value, tuple):
        items = [_moved(*pair, change) for pair in zip(value, slope, strict=True)]
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    if isinstance(value, np.ndarray):
        if not np.any(slope):
            return value
        return np.array(_moved(tuple(map(tuple, value.tolist())), slope, change), dtype=object)
    return value + change * slope if slope else value


@dataclass(frozen=True)
class OfElement(Parameter):
    """A number of an element, in which what it exerts is linear.

    Attributes:
        element: its index.
        ends: elements in its place whose numbers differ by `step`.
    """

    element: int
    ends: tuple[Element, Element]
    step: float

    def among(self, elements: Sequence[Element], end: Element) -> tuple[Element, ...]:
        """Return all elements, with one of `ends` in its place."""
        return (*elements[: self.element], end, *elements[self.element + 1 :])
