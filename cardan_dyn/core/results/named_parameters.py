"""Named parameters: numbers by which sweeps are differentiated, by their names."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ArgumentError, ModelError, choices
from ..description.origins import (
    COMPONENTS,
    PREFIX,
    origin_of,
    places_of,
    with_origins,
    without_origins,
)
from ..dynamics.parameters import (
    OfColumn,
    OfElement,
    OfMass,
    OfOrigin,
    OfRow,
    Parameter,
    joints_of,
)
from ..mechanics.bodies import Mass
from ..mechanism.mechanism import Mechanism
from ..problem.acting import Acting
from ..problem.problem import Problem

if TYPE_CHECKING:
    from pinocchio import SE3

    from ..description.description import Description, LinkDescription
    from ..elements.element import Element
    from ..tape import Scalar

_AXES = "xyz"
_OF_INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
_OF_ELEMENTS = {"stiffness": "stiffness", "damping": "damping", "friction": "effort"}
"""Parameters of elements to their attributes."""
_FORMS = (
    "a driven or held coordinate, 'speed:DRIVE', 'acceleration:DRIVE', 'load:JOINT', 'gravity.x', "
    "'mass:LINK', 'centre:LINK.x', 'inertia:LINK.xx', 'origin:JOINT.x' (y, z, roll, pitch, yaw), "
    "'stiffness:ELEMENT', 'damping:ELEMENT' or 'friction:ELEMENT'"
)


def parameters_of(problem: Problem, acting: Acting, names: Sequence[str]) -> dict[str, Parameter]:
    """Return the parameters of names and of patterns, by their names.

    Args:
        problem: of the scene.
        acting: what acts in the sweep.
        names: of parameters, or with `*` of all that they match.

    Raises:
        ArgumentError: a name says nothing, or a pattern matches nothing.
        ModelError: no such joint, link or element.
    """
    found: dict[str, Parameter] = {}
    for name in names:
        if "*" not in name:
            found[name] = _parameter(problem, acting, name)
            continue
        matching = [every for every in _every_name(problem) if fnmatchcase(every, name)]
        if not matching:
            raise ArgumentError(f"{name!r} matches no parameter; one is {_FORMS}")
        for every in matching:
            # Some angle of a joint may say nothing of how it is turned.
            with suppress(ModelError):
                found[every] = _parameter(problem, acting, every)
    return found


def _every_name(problem: Problem) -> Iterator[str]:
    """Yield the names of all parameters, but for components of loads on links."""
    yield from problem.independent
    yield from problem.held
    yield from (f"gravity.{axis}" for axis in _AXES)
    for kind in "speed", "acceleration":
        yield from (f"{kind}:{drive}" for drive in problem.independent)
    yield from (f"load:{name}" for name in problem.mechanism.coordinates.named)
    description = problem.mechanism.description
    links = [link for link in problem.mechanism.links if link not in description.origins]
    yield from (f"mass:{link}" for link in links)
    for kind, components in ("centre", _AXES), ("inertia", _OF_INERTIA):
        yield from (f"{kind}:{link}.{component}" for link in links for component in components)
    places = places_of(without_origins(description))
    yield from (f"{PREFIX}{place}.{component}" for place in places for component in COMPONENTS)
    for label, element in _elements(problem).items():
        yield from (
            f"{kind}:{label}"
            for kind, attribute in _OF_ELEMENTS.items()
            if isinstance(getattr(element, attribute, None), float)
        )


def _parameter(problem: Problem, acting: Acting, name: str) -> Parameter:
    """Return what a name says.

    Raises:
        ArgumentError: it says nothing.
        ModelError: no such joint, link or element.
    """
    kind, colon, of = name.partition(":")
    drives, rates = problem.independent, problem.mechanism.model.nv
    prescribed = (*drives, *problem.held)
    first_effort = 2 * len(drives) + 3
    if name in prescribed:
        return OfColumn(name, problem.mechanism.coordinates.columns_of([name])[0])
    if not colon:
        if match := re.fullmatch(r"gravity\.([xyz])", name):
            return OfRow(name, 2 * len(drives) + _AXES.index(match[1]))
        raise ModelError(
            f"{name!r} is nothing that the scene drives or holds: {choices(prescribed, name)}; "
            f"a parameter is {_FORMS}",
            name=name,
        )
    if kind in ("speed", "acceleration"):
        if of not in drives:
            raise ModelError(f"{name!r}: drives are {choices(drives, of)}", name=of)
        return OfRow(name, drives.index(of) + len(drives) * (kind == "acceleration"))
    if kind == "load":
        named = problem.mechanism.coordinates.named
        if of in named:
            return OfRow(name, first_effort + named[of].rate)
        link, _, component = of.rpartition(".")
        loads = [key for key, load in acting.link_loads.items() if load.body >= 0]
        match = re.fullmatch(r"(force|moment)_([xyz])", component)
        if link in loads and match:
            number = 6 * loads.index(link) + 3 * (match[1] == "moment") + _AXES.index(match[2])
            return OfRow(name, first_effort + rates + number)
        raise ModelError(
            f"{name!r}: name a joint, {choices(named, of)}, or a component of a link that has a "
            f"load in the sweep, such as 'load:LINK.force_x'; these links are {choices(loads)}",
            name=of,
        )
    if kind in ("mass", "centre", "inertia"):
        return _of_mass(problem, name, kind, of)
    if kind == "origin":
        return _of_origin(problem, name)
    if kind in _OF_ELEMENTS:
        return _of_element(problem, name, kind, of)
    raise ArgumentError(f"{name!r} says no parameter; one is {_FORMS}")


def _of_mass(problem: Problem, name: str, kind: str, of: str) -> OfMass:
    """Return mass, centre or inertia of a link; arguments and errors as of `_parameter`."""
    link, _, component = (of, "", "") if kind == "mass" else of.rpartition(".")
    wanted = {"mass": r"", "centre": r"[xyz]", "inertia": r"[xyz]{2}"}[kind]
    if not re.fullmatch(wanted, component):
        raise ArgumentError(f"{name!r} says no parameter; one is {_FORMS}")
    body, frame = problem.mechanism.link(link)
    described, total = _described(problem.mechanism)[link]
    at = frame.act(np.asarray(described.centre))
    length = problem.mechanism.characteristic_length
    # What a body exerts is linear in masses and inertias, and of second degree in a centre.
    size = {"mass": total, "centre": length, "inertia": total * length**2}[kind]
    nodes, weights = ((size, 0.0), (1.0 / size, -1.0 / size))
    if kind == "centre":
        nodes, weights = ((size, -size), (0.5 / size, -0.5 / size))
    changed = partial(_with_mass, kind, component, link)
    adds = partial(_added_mass, kind, component, frame, described, at)
    return OfMass(name, changed, nodes, weights, link, body - 1, adds)


def _described(mechanism: Mechanism) -> dict[str, tuple[LinkDescription, float]]:
    """Return links to how they are described, each with the mass of all; 1 kg if there is none."""
    links = mechanism.description.links
    total = sum(item.mass for item in links) or 1.0
    return mechanism.kept.of(
        "described links", None, lambda: {item.name: (item, total) for item in links}
    )


def _with_mass(
    kind: str, component: str, name: str, description: Description, by: float
) -> Description:
    """Return a description in which mass, centre or inertia of a link differ by some amount."""
    links = []
    for link in description.links:
        value: Any = getattr(link, kind) if link.name == name else 0.0
        if link.name == name and kind == "mass":
            link = replace(link, mass=value + by)
        elif link.name == name:
            value = np.array(value)
            index = tuple(map(_AXES.index, component))
            value[index] += by
            if kind == "inertia" and index[0] != index[1]:
                value[index[::-1]] += by
            link = replace(link, **{kind: value})
        links.append(link)
    return replace(description, links=tuple(links))


def _added_mass(
    kind: str,
    component: str,
    frame: SE3,
    link: LinkDescription,
    centre: Array,
    change: Scalar,
    length: float,
) -> tuple[Mass, ...]:
    """Return the masses that a change of a link by some amount adds to its body.

    Args:
        kind: `mass`, `centre` or `inertia`.
        component: of the centre, or of the inertia.
        frame: of the link in its body.
        link: as it is described.
        centre: of its mass in the body [m].
        change: by how much.
        length: unit of what is returned [m].
    """
    at, nothing = tuple((centre / length).tolist()), ((0.0, 0.0, 0.0),) * 3
    if kind == "mass":
        return (Mass(change, at, nothing, ""),)
    if kind == "centre":
        way = frame.rotation[:, _AXES.index(component)] / length
        moved = tuple(c + change * w for c, w in zip(at, way.tolist(), strict=True))
        return Mass(link.mass, moved, nothing, ""), Mass(-link.mass, at, nothing, "")
    unit = np.zeros((3, 3))
    row, column = map(_AXES.index, component)
    unit[row, column] = unit[column, row] = 1.0 / length**2
    turned = frame.rotation @ unit @ frame.rotation.T
    return (Mass(0.0, at, tuple(tuple(change * x for x in r) for r in turned.tolist()), ""),)


def _of_element(problem: Problem, name: str, kind: str, of: str) -> OfElement:
    """Return a number of an element; arguments and errors as of `_parameter`."""
    known, attribute = _elements(problem), _OF_ELEMENTS[kind]
    if of not in known:
        raise ModelError(f"{name!r}: elements are {choices(known, of)}", name=of)
    element = known[of]
    value = getattr(element, attribute, None)
    if not isinstance(value, float):
        raise ModelError(f"{name!r}: {of} has no {attribute} that is a number", name=of)
    # What acts is linear in it: any difference is exact.
    ends = (1.5 * value, 0.5 * value) if value else (1.0, 0.0)
    more, less = (replace(cast("Any", element), **{attribute: end}) for end in ends)
    index = list(known).index(of)
    return OfElement(name, index, (more, less), ends[0] - ends[1])


def _elements(problem: Problem) -> dict[str, Element]:
    """Return elements by how parameters call them."""
    return {item.name or f"elements[{k}]": item for k, item in enumerate(problem.elements)}


def _of_origin(problem: Problem, name: str) -> OfOrigin:
    """Return a length or an angle of a placement; arguments and errors as of `_parameter`."""
    mechanism = problem.mechanism

    def changed(of: Description, by: float) -> Description:
        plain = without_origins(of)
        return with_origins(origin_of(plain, name).displaced(plain, by), of.origins)

    origin = origin_of(without_origins(mechanism.description), name)
    body = mechanism.link(getattr(origin.joint, origin.carrier))[0] - 1
    # What lies on the world is counted from its first joint.
    is_first = body < 0 and joints_of(mechanism)[0] == origin.joint.name
    is_whole = is_first or origin.joint.type == "fixed"
    unit = 1.0 if origin.turns else mechanism.characteristic_length
    nodes, weights = np.array([unit, -unit]), np.array([0.5, -0.5]) / unit
    if origin.turns:
        nodes = np.pi / 4.0 * np.array([1.0, 3.0, -3.0, -1.0])
        weights = np.array([0.125, -0.125, 0.125, -0.125]) / np.sin(nodes / 2.0) ** 2
    places = tuple(nodes.tolist()), tuple(weights.tolist())
    return OfOrigin(name, changed, *places, origin.joint.name, body, is_whole, unit)
