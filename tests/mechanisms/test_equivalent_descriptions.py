"""The same mechanism written in another way gives the same wrenches.

Which end of a loop is its predecessor decides the sign of its wrench and nothing else, and the
order in which links, joints and loops stand in the file decides nothing at all, what the laws of
motion leave open included.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.urdf_reader import Reader, edited, text

import cardan_dyn as cd

TURN = np.linspace(0.0, 2.0 * np.pi, 25)
LEGS = [f"leg_{k}" for k in range(1, 7)]
GRAVITY = (0.4, -9.6, -2.0)

PLANAR = {"speed": 40.0, "acceleration": -70.0}
SHAFT = {"drive": "bearing_in", "loads": {"bearing_out": -90.0}}
# Every description with its drive, held joints and loads, and how it is swept.
SCENES: dict[str, tuple[dict, dict]] = {
    "four_bar": ({"drive": "crank_bearing", "loads": {"rocker_bearing": -60.0}}, PLANAR),
    "slider_crank": ({"drive": "crank_bearing", "loads": {"piston_guide": -900.0}}, PLANAR),
    "needle_drive": ({"drive": "main_shaft", "loads": {"needle_guide": -150.0}}, PLANAR),
    "ring_joint": ({**SHAFT, "held": {"joint_angle": 0.6}}, PLANAR),
    "thoma_rig": ({**SHAFT, "held": {"joint_angle": 0.2}}, PLANAR),
    "double_shaft_w": ({**SHAFT, "held": {"joint_angle_1": 0.3, "joint_angle_2": 0.5}}, PLANAR),
    "double_shaft_spatial": (
        {
            **SHAFT,
            "held": {
                "joint_angle_1_h": 0.12,
                "joint_angle_1_v": 0.26,
                "joint_angle_2_h": 0.21,
                "joint_angle_2_v": -0.2,
            },
        },
        PLANAR,
    ),
    "drive_line": (
        {**SHAFT, "held": {"joint_angle_1": 0.2, "joint_angle_2": -0.3, "joint_angle_3": 0.4}},
        PLANAR,
    ),
    "stewart_platform": (
        {"drive": LEGS},
        {"speed": [[0.1, -0.2, 0.3, 0.1, 0.0, -0.1]], "acceleration": [[1.0] * 3 + [-2.0] * 3]},
    ),
}


def sweep(name: str, urdf: str) -> cd.Sweep:
    options, rates = SCENES[name]
    position = [[0.03, -0.02, 0.05, 0.01, -0.04, 0.02]] if name == "stewart_platform" else TURN
    return cd.Scene(cd.load(urdf), gravity=GRAVITY, **options).sweep(position, **rates)


@pytest.fixture(scope="module", params=SCENES)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def reference(name: str) -> cd.Sweep:
    return sweep(name, text(name))


def compare(
    computed: cd.Sweep, reference: cd.Sweep, flipped: str | None = None, tolerance: float = 1e-12
) -> None:
    """All wrenches in world axes, and the drive efforts; one joint with the other sign."""
    assert set(computed.outputs) == set(reference.outputs)
    wrenches = {name: reference.wrench(name, "world") for name in reference.outputs}
    force = max(np.max(np.abs(wrench.force)) for wrench in wrenches.values())
    moment = max(np.max(np.abs(wrench.moment)) for wrench in wrenches.values())
    for name, expected in wrenches.items():
        wrench, sign = computed.wrench(name, "world"), -1.0 if name == flipped else 1.0
        assert np.max(np.abs(sign * wrench.force - expected.force)) < tolerance * force, name
        assert np.max(np.abs(sign * wrench.moment - expected.moment)) < tolerance * moment, name
        np.testing.assert_array_equal(wrench.unique, expected.unique)
    scale = np.max(np.abs(reference.drive_effort))
    assert np.max(np.abs(computed.drive_effort - reference.drive_effort)) < tolerance * scale


def test_swapping_the_ends_of_a_loop_flips_its_wrench_only(name: str, reference: cd.Sweep) -> None:
    def swap(robot: ElementTree.Element) -> None:
        element = robot.find(f"loop[@name='{loop}']")
        assert element is not None
        for end in list(element):
            if end.tag in ("predecessor", "successor"):
                end.tag = "successor" if end.tag == "predecessor" else "predecessor"

    for element in Reader(text(name)).robot.findall("loop"):
        loop = element.get("name", "")
        swapped = sweep(name, edited(text(name), swap))
        compare(swapped, reference, flipped=loop)
        # The wrench that flips is not nothing.
        assert np.max(np.abs(reference[loop].force)) + np.max(np.abs(reference[loop].moment)) > 1.0


@pytest.mark.parametrize("order", ["backwards", "shuffled"])
def test_order_in_the_file_does_not_matter(name: str, order: str, reference: cd.Sweep) -> None:
    def reorder(robot: ElementTree.Element) -> None:
        for tag in ("link", "joint", "loop"):
            elements = robot.findall(tag)
            indices = [list(robot).index(element) for element in elements]
            if order == "backwards":
                elements.reverse()
            else:
                np.random.default_rng(7).shuffle(elements)
            for index, element in zip(indices, elements, strict=True):
                robot[index] = element

    urdf = edited(text(name), reorder)
    assert [item.get("name") for item in Reader(urdf).robot.findall("joint")] != [
        item.get("name") for item in Reader(text(name)).robot.findall("joint")
    ]
    compare(sweep(name, urdf), reference)


@pytest.mark.parametrize("form", ["ring_joint", "thoma_rig"])
def test_either_pin_may_close_the_chain(form: str) -> None:
    """Cut at the input pin instead of the output pin: the forces of least norm stay the same."""
    middle = "ring" if form == "ring_joint" else "cross"

    def cut(robot: ElementTree.Element) -> None:
        pin_in, pin_out = robot.find("joint[@name='pin_in']"), robot.find("loop[@name='pin_out']")
        assert pin_in is not None and pin_out is not None
        robot.remove(pin_in)
        robot.remove(pin_out)
        # In the tree the output shaft is the parent now, so the wrench changes its sign.
        for element in (
            f'<joint name="pin_out" type="continuous"><parent link="shaft_out"/>'
            f'<child link="{middle}"/><axis xyz="0 0 1"/></joint>',
            f'<loop name="pin_in" type="continuous"><predecessor link="shaft_in"/>'
            f'<successor link="{middle}"/><axis xyz="0 1 0"/></loop>',
        ):
            robot.append(ElementTree.fromstring(element))

    reference = sweep(form, text(form))
    compare(sweep(form, edited(text(form), cut)), reference, flipped="pin_out")
    assert not np.any(reference["pin_out"].unique[:3])
