"""Thoma's rig with other crosses, and as one universal joint, for play in its pin bearings."""

from __future__ import annotations

from xml.etree import ElementTree

import cardan_dyn as cd
from testkit.urdf_reader import edited, text

THETA = 0.0103048185928
"""Inertia of shaft 2 with its flywheel about its axis, as the description has it [kg m²]."""


def rig(mass: float, inertia: tuple[float, float, float], theta: float = THETA) -> str:
    """The rig with a cross that has mass, its moments of inertia along pin 1, pin 2 and normal."""

    def change(robot: ElementTree.Element) -> None:
        cross = robot.find("link[@name='cross']")
        shaft = robot.find("link[@name='shaft_out']/inertial/inertia")
        assert cross is not None and shaft is not None
        inertial = ElementTree.SubElement(cross, "inertial")
        ElementTree.SubElement(inertial, "mass", value=repr(mass))
        along = dict(zip(("iyy", "izz", "ixx"), map(repr, inertia), strict=True))
        ElementTree.SubElement(inertial, "inertia", ixy="0", ixz="0", iyz="0", **along)
        shaft.set("ixx", repr(theta))

    return edited(text("thoma_rig"), change)


def compound() -> str:
    """The rig without a link for the cross: a loop of type universal joins the forks."""

    def change(robot: ElementTree.Element) -> None:
        for tag, name in (("link", "cross"), ("joint", "pin_in"), ("loop", "pin_out")):
            element = robot.find(f"{tag}[@name='{name}']")
            assert element is not None
            robot.remove(element)
        robot.append(
            ElementTree.fromstring(
                '<loop name="coupling" type="universal"><predecessor link="shaft_in">'
                '<origin xyz="0 0 0"/></predecessor><successor link="shaft_out">'
                '<origin xyz="0 0 0"/></successor><axis xyz="0 1 0"/><axis2 xyz="0 0 1"/></loop>'
            )
        )

    return edited(text("thoma_rig"), change)


def displaced() -> str:
    """The rig with the origins of both pins' joints 10 and 20 mm from the centre, on their axes."""

    def change(robot: ElementTree.Element) -> None:
        for path, place in (
            ("joint[@name='pin_in']/origin", "0 0.01 0"),
            ("loop[@name='pin_out']/predecessor/origin", "0 -0.01 0.02"),
            ("loop[@name='pin_out']/successor/origin", "0 0 0.02"),
        ):
            element = robot.find(path)
            assert element is not None
            element.set("xyz", place)

    return edited(text("thoma_rig"), change)


def doubled() -> str:
    """The rig with a second cross beside the first, so that nothing decides what each carries."""

    def change(robot: ElementTree.Element) -> None:
        for tag, name in (("link", "cross"), ("joint", "pin_in"), ("loop", "pin_out")):
            element = robot.find(f"{tag}[@name='{name}']")
            assert element is not None
            words = ElementTree.tostring(element, encoding="unicode")
            for old in ("cross", "pin_in", "pin_out"):
                words = words.replace(f'"{old}"', f'"{old}_2"')
            robot.append(ElementTree.fromstring(words))

    return edited(rig(0.5, (2e-4, 3e-4, 4e-4)), change)


def scene(urdf: str, beta: float, load: float = 0.0) -> cd.Scene:
    """The rig at an angle of its shafts, driven at shaft 1, with a torque on shaft 2."""
    return cd.Scene(
        cd.load(urdf),
        drive="bearing_in",
        held={"joint_angle": beta},
        loads={"bearing_out": load},
    )
