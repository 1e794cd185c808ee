"""Coupled forces: what `<coupling>` and `<mimic>` say beside their ratio and offset.

`higher="a2 a3"` are coefficients of the square of the predecessor's motion, its cube and so on, by
which the ratio changes.

URDF and URDF+ say how two joints move, not by what: teeth, a belt, a control. `forces="none"` says
that nothing but moments about the joints' axes acts (forces along slides), between the two links of
each joint: a control, or coaxial wheels in a housing whose teeth are in balance. `forces="mesh"`
says that two gears on parallel axes touch, with `pressure_angle`, `helix_angle` and `along`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from ...kit.checks import text
from ...kit.errors import ArgumentError, ModelError, choices
from .description import CouplingDescription, Description, Mesh
from .elements import listed, number, words

FORCES = ("none", "mesh")
"""Values of `forces`."""


def with_forces(coupling: CouplingDescription, element: Element, at: str) -> CouplingDescription:
    """Return a coupling with the forces that its element states, and how its ratio changes.

    Raises:
        ModelError: what is wrong with them.
    """
    coupling = replace(coupling, higher=_higher(coupling, element, at))
    forces = element.get("forces")
    stated = [name for name in Mesh._fields if element.get(name) is not None]
    if forces is not None and forces not in FORCES:
        raise ModelError(
            f"{at}: forces {forces!r} is unknown; forces: {choices(FORCES, forces)}; without it, "
            "what the coupling exerts on the bearings of its joints counts as open"
        )
    if forces != "mesh":
        if stated:
            raise ModelError(f'{at}: {stated[0]} is one of teeth: write forces="mesh" as well')
        return replace(coupling, forces=forces or "")
    usual = Mesh()
    pressure, helix = (
        number(element.get(name), repr(default), f"{at}: {name}")
        for name, default in zip(Mesh._fields[:2], usual[:2], strict=True)
    )
    if not 0.0 <= pressure < 0.5 * np.pi:
        raise ModelError(
            f"{at}: pressure_angle is {pressure:g} rad; it has to lie between 0 and π/2"
        )
    if not abs(helix) < 0.5 * np.pi:
        raise ModelError(f"{at}: helix_angle is {helix:g} rad; it has to lie between -π/2 and π/2")
    along = element.get("along")
    place = None if along is None else number(along, "", f"{at}: along")
    return replace(coupling, forces="mesh", mesh=Mesh(pressure, helix, place))


def with_stated_forces(description: Description, forces: Mapping[str, object]) -> Description:
    """Return a description whose couplings exert what is stated by their names, as in an element.

    Raises:
        ArgumentError: there is no such coupling.
        ModelError: what is wrong with the forces.
    """
    known = {item.name: item for item in description.couplings}
    for name, value in forces.items():
        at = f"forces[{name!r}]"
        if name not in known:
            raise ArgumentError(
                f"{at}: {description.name} has no coupling {name!r}; couplings: "
                f"{choices(known, name)}"
            )
        silent = replace(known[name], forces="", mesh=None)
        element = Element("coupling", forces_words(silent) | {"forces": text(at, value)})
        known[name] = with_forces(silent, element, at)
    return replace(description, couplings=tuple(known.values()))


def _higher(coupling: CouplingDescription, element: Element, at: str) -> tuple[float, ...]:
    """Return the coefficients of higher powers that an element states."""
    stated = element.get("higher")
    higher = () if stated is None else listed(stated, f"{at}: higher")
    while higher and higher[-1] == 0.0:
        higher = higher[:-1]
    if higher and element.get("forces") == "mesh":
        raise ModelError(f"{at}: gears have one ratio; leave higher or forces='mesh' out")
    if not higher and coupling.ratio == 0.0:
        raise ModelError(
            f"{at}: a ratio of zero would hold the successor, not couple it; "
            f"remove <{element.tag}> and hold the joint in the scene"
        )
    return higher


def forces_words(coupling: CouplingDescription) -> dict[str, str]:
    """Return the attributes that state the forces of a coupling, and how its ratio changes."""
    stated = {"higher": words(coupling.higher)} if coupling.higher else {}
    if coupling.forces:
        stated["forces"] = coupling.forces
    if coupling.mesh is not None:
        for name, value in coupling.mesh._asdict().items():
            if value is not None:
                stated[name] = words([value])
    return stated
