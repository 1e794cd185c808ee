"""Element arguments: force elements that a user hands to a scene, checked against the mechanism."""

from __future__ import annotations

from collections.abc import Sequence

from ...kit.checks import described
from ...kit.errors import ArgumentError, CardanError, choices
from ..elements.element import Element
from ..elements.element_forces import labels
from ..mechanism.mechanism import Mechanism
from .coordinate_names import check_single

_KINDS = "JointSpring, JointFriction, PointSpring, Bushing, PinContact, Actuator, PointActuator"


def listed(given: object) -> tuple[Element, ...]:
    """Return the argument `elements` as elements, whose names differ.

    Raises:
        ArgumentError: it is no sequence of elements, or two have the same name.
    """
    if isinstance(given, Element):
        raise ArgumentError(f"elements is a {type(given).__name__}; give a list of elements")
    if not isinstance(given, Sequence) or isinstance(given, (str, bytes)):
        raise ArgumentError(f"elements is {described(given)}, expected a list of: {_KINDS}")
    elements = tuple(given)
    for index, element in enumerate(elements):
        if not isinstance(element, Element):
            raise ArgumentError(
                f"elements[{index}] is {described(element)}, expected one of: {_KINDS}"
            )
    named = [element.name for element in elements if element.name]
    for index, element in enumerate(elements):
        if element.name and named.count(element.name) > 1:
            raise ArgumentError(
                f"elements[{index}]: another element is called {element.name!r} too; results are "
                "found by these names"
            )
    return elements


def elements_on(mechanism: Mechanism, elements: tuple[Element, ...]) -> tuple[Element, ...]:
    """Return elements that a mechanism can have.

    Raises:
        ModelError: no such joint, coordinate or link.
        ArgumentError: a joint without a single coordinate, or both links stand in the world.
    """
    for element, label in zip(elements, labels(elements), strict=True):
        for joint in element.joints:
            try:
                check_single(mechanism, joint, "joint")
            except CardanError as error:
                raise type(error)(f"{label}: {error}", **error.details) from error
        for link in element.links:
            try:
                mechanism.link_frame(link)
            except CardanError as error:
                raise type(error)(f"{label}: {error}", **error.details) from error
        if element.links and all(mechanism.link_frames[link][0] == 0 for link in element.links):
            moving = [name for name, (body, _) in mechanism.links.items() if body]
            raise ArgumentError(
                f"{label}: both links are fixed to the world; links that move: {choices(moving)}"
            )
    return elements
