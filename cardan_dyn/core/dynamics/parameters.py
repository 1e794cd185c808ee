"""Parameters: numbers by which samples are differentiated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kit.arrays import EPS
from ...kit.errors import ModelError
from ..description.description import Description
from ..description.origins import origin_of, without_origins
from ..elements.element import Element
from ..mechanics.bodies import Body, Loop, Mass, Tree
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

    @property
    def input(self) -> str:
        """Name of the input of a tape that it is."""
        return f"x{self.column}"


@dataclass(frozen=True)
class OfRow(Parameter):
    """A number among what is prescribed, by its row in `Prescribed`."""

    row: int

    @property
    def input(self) -> str:
        """Name of the input of a tape that it is."""
        return f"r{self.row}"


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
        joint: name of the joint or loop that lies there.
        body: index of the body that it lies on.
        is_whole: whether other numbers of that body depend on it than where the joint lies.
        unit: amount that changes a mechanism by about its own size.
    """

    joint: str
    body: int
    is_whole: bool
    unit: float

    def displaced(self, mechanism: Mechanism, by: float) -> Mechanism:
        """Return the mechanism in which it is greater by some amount [m or rad]."""
        return _displaced([self], mechanism, by)

    def moves(self, body: int, joint: str = "") -> bool:
        """Return whether numbers depend on it: of a body, or of where a joint lies on that."""
        return self.body == body and (self.is_whole or self.joint == joint)

    def goes_with(self, other: OfOrigin) -> bool:
        """Return whether no number depends on both, and both are compared at the same places."""
        moves_alike = self.moves(other.body, other.joint) or other.moves(self.body, self.joint)
        return self.nodes == other.nodes and not moves_alike


def _displaced(items: Sequence[OfOrigin], mechanism: Mechanism, by: float) -> Mechanism:
    """Return the mechanism in which numbers are greater by some amount."""
    description = mechanism.description
    for item in items:
        description = item.changed(description, by)
    return Mechanism(description, mechanism.base, mechanism.coordinates.cardan)


Numbers = tuple[Tree, tuple[LinkKind, ...]]
"""A tree and links, or something in their structure."""


def slopes_of(
    items: Sequence[OfOrigin], mechanism: Mechanism, numbers_at: Callable[[Mechanism], Numbers]
) -> dict[str, Numbers]:
    """Return the derivatives of all numbers of a tree and of links by lengths and angles.

    Those of which none moves what another does are found together.

    Args:
        items: these.
        mechanism: in which.
        numbers_at: returns the numbers of a mechanism.

    Returns:
        Names of the items to numbers in the structure of the tree and of links; 0.0 in place of
        those that do not change.

    Raises:
        ModelError: the tree has numbers of other kinds.
    """
    together: list[list[OfOrigin]] = []
    for item in items:
        for group in together:
            if all(map(item.goes_with, group)):
                group.append(item)
                break
        else:
            together.append([item])
    found: dict[str, Numbers] = {}
    for group in together:
        first = group[0]
        numbers = [numbers_at(_displaced(group, mechanism, node)) for node in first.nodes]
        tree, links = numbers[0]
        if tree.spins or tree.gears:
            raise ModelError(
                f"{first.name}: the lines of idle rods and the teeth of gears depend on it, of "
                "which derivatives are not known; of gears, couple them by forces='none'; of rods, "
                "write one end as a universal joint, which does not spin, or drive or hold the spin"
            )
        # Axes of lengths and angles that are held turn: at some of these places, they are numbers.
        vectors = [(_with_vectors(of), places) for of, places in numbers]
        slopes = _slope(vectors, first.weights)
        for item in group:
            found[item.name] = _own(item, mechanism, (tree, links), slopes)
    return found


def _own(item: OfOrigin, mechanism: Mechanism, numbers: Numbers, slopes: Any) -> Numbers:
    """Return those of slopes that one of the numbers is the reason of; 0.0 for others."""
    (tree, links), of_tree, of_links = numbers, Tree(*slopes[0]), slopes[1]
    joints = joints_of(mechanism)
    loops = {loop.joint for loop in mechanism.loops}

    def own(slope: Any, body: int, joint: str = "") -> Any:
        """Return slopes of where a joint lies, or a link, from a body or a length of it inwards."""
        while joint and body >= 0 and joints[body] == joint:
            body = tree.bodies[body].parent
        return slope if item.moves(body, joint) else 0.0

    names = [joints[loop.predecessor.body] for loop in tree.loops]
    names = [name if name in loops else "" for name in names]
    # A joint of a loop carries some of the mass of the loop's successor.
    ends = {name: (loop.successor.body, name) for name, loop in zip(names, tree.loops, strict=True)}
    bodies = []
    for index, (body, joint) in enumerate(zip(tree.bodies, joints, strict=True)):
        of = Body(*of_tree.bodies[index])
        placed = {
            name: own(getattr(of, name), body.parent, joint)
            for name in ("rotation", "translation", "axis")
        }
        masses = own(of.masses, *ends.get(joint, (index, "")))
        bodies.append(of._replace(**placed, masses=masses))
    welds = tuple(
        Loop(own(of[0], loop.predecessor.body, name), own(of[1], loop.successor.body, name), 0)
        for loop, name, of in zip(tree.loops, names, of_tree.loops, strict=True)
    )
    nothing = Tree(*[0.0] * len(Tree._fields))  # type: ignore[arg-type]
    axes = own(of_tree.axes, -1, joints[0])
    return (
        nothing._replace(axes=axes, bodies=tuple(bodies), loops=welds),
        tuple(own(of, link.body) for link, of in zip(links, of_links, strict=True)),
    )


def joints_of(mechanism: Mechanism) -> list[str]:
    """Return the joint or loop of each body; of lengths and angles that of which they are."""
    origins = mechanism.description.origins
    plain = without_origins(mechanism.description)
    names = [""] * (mechanism.model.njoints - 1)
    for name, joint in mechanism.joints.items():
        for part in joint.parts:
            names[part.id - 1] = origin_of(plain, name).joint.name if name in origins else name
    return names


def _with_vectors(tree: Tree) -> Tree:
    """Return a tree in which no axis is a number."""
    bodies = (
        body._replace(axis=UNTURNED[body.axis]) if isinstance(body.axis, int) else body
        for body in tree.bodies
    )
    return tree._replace(bodies=tuple(bodies))


def _slope(values: Sequence[Any], weights: Sequence[float]) -> Any:
    """Return a weighted sum of numbers in nested tuples and arrays; 0.0 where rounding is left."""
    first = values[0]
    if isinstance(first, tuple):
        return tuple(_slope(items, weights) for items in zip(*values, strict=True))
    if isinstance(first, np.ndarray):
        return _slope([*map(tuple, values)], weights)
    if not isinstance(first, float):
        return 0.0
    terms = [value * weight for value, weight in zip(values, weights, strict=True)]
    result = sum(terms)
    return result if abs(result) > 4.0 * EPS * sum(map(abs, terms)) else 0.0


def moved(value: Any, slope: Any, change: Scalar) -> Any:
    """Return numbers in nested tuples and arrays, which change by some times their slopes."""
    if isinstance(slope, float) and not slope:
        return value
    if isinstance(value, int) and isinstance(slope, tuple):  # An axis.
        return moved(UNTURNED[value], slope, change) if any(slope) else value
    if isinstance(value, tuple):
        items = [moved(*pair, change) for pair in zip(value, slope, strict=True)]
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    if isinstance(value, np.ndarray):
        if not np.any(slope):
            return value
        return np.array(moved(tuple(map(tuple, value.tolist())), slope, change), dtype=object)
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
