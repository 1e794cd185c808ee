"""Coordinate names: what a scene can drive, hold or load, and why something else cannot be."""

from __future__ import annotations

from collections.abc import Iterable

from ...kit.errors import ArgumentError, ModelError, choices
from ..mechanism.mechanism import Mechanism


def check_single(mechanism: Mechanism, name: object, role: str) -> None:
    """Refuse what a scene cannot drive, hold or load, since it is no single coordinate.

    Raises:
        ModelError: no such joint or coordinate.
        ArgumentError: the joint has no coordinate, or several.
    """
    if isinstance(name, str) and name in mechanism.drivable:
        return
    if mechanism.is_adjustable(name):
        raise ArgumentError(f"{role} {name!r} is fixed in this scene; hold it there as well")
    if isinstance(name, str) and name not in mechanism and "." in name:
        joint_name, _, coordinate = name.rpartition(".")
        reason = f"no joint or coordinate {name!r}; there are: {choices(mechanism.drivable, name)}"
        if joint_name in mechanism:
            valid = coordinates_of(mechanism, joint_name)
            reason = f"joint {joint_name!r} has no coordinate {coordinate!r}; {valid}"
        raise ModelError(f"{mechanism.name}: {reason}", name=name)
    joint = mechanism.joint(name)
    raise ArgumentError(
        f"{role} {name!r} is a {joint.type} joint; {coordinates_of(mechanism, joint.name)}"
    )


def each_coordinate(mechanism: Mechanism, names: Iterable[str]) -> tuple[str, ...]:
    """Return names in which a joint of several coordinates stands for all of them, in their order.

    Other names stay as they are, also those of nothing.
    """
    several = mechanism.coordinates_together
    return tuple(item for name in names for item in several.get(name, (name,)))


def coordinates_of(mechanism: Mechanism, joint: str) -> str:
    """Return the valid names of a joint's coordinates, for the end of a message."""
    valid = [name for name, item in mechanism.drivable.items() if item.joint == joint]
    if not valid:
        return f"it has no coordinate; those of other joints: {choices(mechanism.drivable)}"
    if valid == [joint]:
        return f"it has one coordinate, which is called {joint!r}"
    return f"name one of its coordinates: {', '.join(valid)}"
