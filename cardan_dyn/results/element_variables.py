"""Element variables: what the force elements of a sweep exert, as variables of its tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..arrays import Array
from ..elements.bushing import BushingForce
from ..elements.element_forces import ElementForce
from ..elements.joint_elements import JointForce
from ..elements.pin_contact import ContactForce
from ..elements.point_spring import PointForce
from ..errors import ModelError
from ..forces.link_loads import WRENCH_COMPONENTS
from .sweep_data import SweepData
from .variable import Variable

DEFORMATION_COMPONENTS = ("x", "y", "z", "turn_x", "turn_y", "turn_z")
_WRENCH_UNITS = ("N",) * 3 + ("N·m",) * 3
_DEFORMATION_UNITS = ("m",) * 3 + ("rad",) * 3
_OF_KINDS: dict[str, type] = {
    "joint_element": JointForce,
    "point_spring": PointForce,
    "bushing": BushingForce,
    "pin_contact": ContactForce,
}
"""Dimensions of the tables to what elements along them exert."""


def element_variables(sweep: SweepData, dims: tuple[str, ...]) -> Iterator[tuple[str, Variable]]:
    """Return what elements exert and store, a variable per quantity; none without elements.

    Args:
        sweep: the sweep.
        dims: names of the dimensions of its operating points.
    """
    if not sweep.elements:
        return
    named = _forces(sweep)
    forces = list(named.values())
    along = [force for force in forces if isinstance(force, JointForce)]
    springs = [force for force in forces if isinstance(force, PointForce)]
    bushings = [force for force in forces if isinstance(force, BushingForce)]
    contacts = [force for force in forces if isinstance(force, ContactForce)]
    if along:
        units = effort_units(sweep)
        values = _beside([force.effort for force in along])
        label = "effort of the element along its coordinate"
        yield "element_effort", Variable((*dims, "joint_element"), values, units, label)
    if springs:
        yield from _of_springs(springs, (*dims, "point_spring"))
    if bushings:
        yield from _of_bushings(bushings, (*dims, "bushing"))
    if contacts:
        yield from _of_contacts(contacts, (*dims, "pin_contact"))
    each = (*dims, "element")
    energy = _beside([force.energy for force in forces])
    yield "element_energy", Variable(each, energy, "J", "energy that the element stores")
    heat = _beside([force.dissipation for force in forces])
    label = "power that the element turns into heat"
    yield "element_dissipation", Variable(each, heat, "W", label)
    label = "energy that all springs and bushings store"
    yield "elastic_energy", Variable(dims, sweep.elastic_energy, "J", label)


def _of_springs(springs: list[PointForce], dims: tuple[str, ...]) -> Iterator[tuple[str, Variable]]:
    """Return what point springs exert."""
    tension = _beside([force.tension for force in springs])
    label = "tension by which the spring pulls its points together"
    yield "element_tension", Variable(dims, tension, "N", label)
    length = _beside([force.length for force in springs])
    yield "element_length", Variable(dims, length, "m", "distance of the points of the spring")
    vectors = np.stack([force.force for force in springs], axis=-2)
    label = "force of the spring on its link_a, in world axes"
    yield "element_force", Variable((*dims, "component"), vectors, "N", label)


def _of_bushings(
    bushings: list[BushingForce], dims: tuple[str, ...]
) -> Iterator[tuple[str, Variable]]:
    """Return what bushings exert."""
    wrenches = np.stack([force.wrench for force in bushings], axis=-2)
    label = "wrench of the bushing on its link_b, in the axes of its frame in link_a"
    yield "element_wrench", Variable((*dims, "wrench_component"), wrenches, _WRENCH_UNITS, label)
    moved = np.stack([force.deformation for force in bushings], axis=-2)
    label = "position and rotation vector of the bushing's frame in link_b, in that of link_a"
    yield (
        "element_deformation",
        Variable((*dims, "deformation_component"), moved, _DEFORMATION_UNITS, label),
    )


def _of_contacts(
    contacts: list[ContactForce], dims: tuple[str, ...]
) -> Iterator[tuple[str, Variable]]:
    """Return what pin contacts exert."""
    pressure = _beside([force.pressure for force in contacts])
    yield "contact_pressure", Variable(dims, pressure, "N", "force that presses pin and wall apart")
    friction = _beside([force.friction for force in contacts])
    yield "contact_friction", Variable(dims, friction, "N", "force along the wall on the pin")
    depth = _beside([force.depth for force in contacts])
    label = "depth by which the pin has entered the wall, negative in the play"
    yield "contact_depth", Variable(dims, depth, "m", label)
    offsets = np.stack([force.offset for force in contacts], axis=-2)
    label = "place of the pin beside the axis of its bush, in world axes"
    yield "contact_offset", Variable((*dims, "component"), offsets, "m", label)


def element_labels(sweep: SweepData) -> dict[str, Sequence[str]]:
    """Return the names along each dimension of these variables."""
    named = _forces(sweep) if sweep.elements else {}
    of_kinds = {
        dim: tuple(name for name, force in named.items() if isinstance(force, kind))
        for dim, kind in _OF_KINDS.items()
    }
    return {
        "element": tuple(named),
        **of_kinds,
        "wrench_component": WRENCH_COMPONENTS,
        "deformation_component": DEFORMATION_COMPONENTS,
    }


def effort_units(sweep: SweepData) -> tuple[str, ...]:
    """Return the units of the efforts of elements along coordinates."""
    drivable = sweep.mechanism.drivable
    joints = (name for element in sweep.elements for name in element.joints)
    return tuple("N" if drivable[name].slides else "N·m" for name in joints)


def _forces(sweep: SweepData) -> dict[str, ElementForce]:
    """Return names of elements, `elements[0]` where one has none, and what they exert.

    Raises:
        ModelError: an element has the name that another one gets.
    """
    names = [element.name or f"elements[{index}]" for index, element in enumerate(sweep.elements)]
    for name in names:
        if names.count(name) > 1:
            raise ModelError(
                f"an element is called {name!r}, by which tables show the one that has no name; "
                "give it another name"
            )
    return dict(zip(names, sweep.element_force.values(), strict=True))


def _beside(values: list[Array]) -> Array:
    """Return values of several elements side by side, along a last dimension."""
    return np.stack(values, axis=-1)
