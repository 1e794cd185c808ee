"""What a scene's refusal says to drive, hold, drop or give makes a scene that moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio
import pytest

import cardan_dyn as cd

MASS = '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01"/></inertial>'
LINKS = '<link name="g"/>' + "".join(f'<link name="{name}">{MASS}</link>' for name in "abd")


def hinge(name: str, parent: str, child: str, xyz: str) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="0 0 1"/></joint>'
    )


CHAIN = hinge("A", "g", "a", "0 0 0") + hinge("B", "a", "b", "0 .1 0")
ROW = CHAIN + hinge("D", "b", "d", ".3 0 0")
CRANKS = CHAIN + hinge("D", "g", "d", ".3 0 0")
MECHANISMS = {
    "row": ROW,
    "bar": CRANKS + '<loop name="C" type="continuous"><predecessor link="b" xyz=".3 .15 0"/>'
    '<successor link="d" xyz="0 .25 0"/><axis xyz="0 0 1"/></loop>',
    "gears": CRANKS + '<coupling name="t"><predecessor link="a"/><successor link="d"/>'
    '<ratio value="-2"/></coupling>',
}


@pytest.mark.parametrize(
    ("name", "given", "said", "then"),
    [
        (
            "row",
            {"drive": "A"},
            "drive or hold 2 of them, such as B, D$",
            {"drive": ["A", "B", "D"]},
        ),
        (
            "row",
            {"drive": "A"},
            "drive or hold 2 of them, such as B, D$",
            {"drive": "A", "held": {"B": 0.1, "D": 0.2}},
        ),
        (
            "row",
            {"drive": "A", "held": {"B": 0.1}},
            "drive or hold one of: D$",
            {"drive": ["A", "D"], "held": {"B": 0.1}},
        ),
        (
            "bar",
            {"drive": ["A", "D"]},
            "drop a drive or stop holding a joint: one of: A, D$",
            {"drive": "D"},
        ),
        ("bar", {"drive": "A", "held": {"D": 0.0}}, "stop holding D$", {"drive": "A"}),
        (
            "gears",
            {"drive": ["A", "D"]},
            "couples A, D: drive or hold only one of them; .*drive or hold one of: B$",
            {"drive": ["A", "B"]},
        ),
        (
            "row",
            {"drive": ["A", "B", "D"], "gravity": "description"},
            r"give gravity=\(0, 0, -9\.81\)$",
            {"drive": ["A", "B", "D"], "gravity": (0, 0, -9.81)},
        ),
    ],
)
def test_what_a_scene_says_to_do_is_done(
    name: str, given: dict[str, object], said: str, then: dict[str, object]
) -> None:
    mechanism = cd.load(f'<robot name="{name}">{LINKS}{MECHANISMS[name]}</robot>')
    with pytest.raises(cd.CardanError, match=said):
        cd.Scene(mechanism, **given)
    scene = cd.Scene(mechanism, **then)
    turn = scene.sweep(np.full(len(scene.drives), 0.05), speed=1.0)
    assert turn.balance_residual < 1e-13 and turn.loop_residual < 1e-13


def test_what_names_are_said_to_stand_for_is_there() -> None:
    mechanism = cd.load(f'<robot name="row">{LINKS}{ROW}</robot>')
    placed = cd.assemble(mechanism, near={"A": 0.3})
    with pytest.raises(cd.ModelError, match=r"name one of them, or take origin\('B'\) and rot"):
        placed.point("B")
    np.testing.assert_allclose(placed.origin("B"), placed.point("b"), atol=1e-15)
    np.testing.assert_allclose(placed.rotation("B"), placed.orientation("a"), atol=1e-15)
    ball = mechanism.to_urdf().replace('name="A" type="continuous"', 'name="A" type="spherical"')
    with pytest.raises(cd.ModelError, match=r"'A\.x' is a coordinate; name its joint, 'A'"):
        cd.load(ball).joint("A.x")
    assert cd.load(ball).joint("A").coordinates == ("A.x", "A.y", "A.z")


@pytest.mark.parametrize(
    "written", ['forces="mesh" pressure_angle="0.35"', 'forces="none"'], ids=["mesh", "none"]
)
def test_what_is_open_of_gears_is_said_as_told(written: str) -> None:
    text = f'<robot name="gears">{LINKS}{MECHANISMS["gears"]}</robot>'
    report = str(cd.describe(cd.load(text)))
    assert 'write forces="mesh" and pressure_angle in it' in report
    assert 'forces="none" where nothing but moments' in report
    described = cd.describe(cd.load(text.replace('name="t"', f'name="t" {written}')))
    assert described.mobility == 2 and not described.silent


def in_other_words(notation: str) -> tuple[Callable[..., cd.Mechanism], object, str]:
    """Return who reads the gears in a notation without a word for forces, them, and their name."""
    text = f'<robot name="gears">{LINKS}{MECHANISMS["gears"]}</robot>'
    if notation == "MJCF":
        pytest.importorskip("mujoco")
        inertial = '<inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>'
        wheel = '<body name="{}" pos="{} 0 0"><joint name="{}"/>{}{}</body>'
        wheels = [
            wheel.format("a", 0, "A", inertial, wheel.format("b", 0.1, "B", inertial, "")),
            wheel.format("d", 0.3, "D", inertial, ""),
        ]
        teeth = '<joint name="t" joint1="D" joint2="A" polycoef="0 -.5 0 0 0"/>'
        text = f"""<mujoco model="gears"><worldbody>{"".join(wheels)}</worldbody>
            <equality>{teeth}</equality></mujoco>"""
        return cd.load, text, "t"
    mimic = '<mimic joint="A" multiplier="-0.5"/></joint>'
    coupled = text.replace(CRANKS[CRANKS.index('<joint name="D"') :], "").split("<coupling")[0]
    wheel_d = hinge("D", "g", "d", ".3 0 0").replace("</joint>", mimic)
    coupled += f"{wheel_d}</robot>"
    if notation == "Pinocchio":
        full = coupled.replace('iyy=".01"', 'iyy=".01" ixy="0" ixz="0" iyz="0"')
        return cd.from_pinocchio, pinocchio.buildModelFromXML(full, mimic=True), "D_mimic"
    mass = "<inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz>"
    mass += "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
    links = "".join(
        f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose>{mass}</link>'
        for name, x in (("g", 0), ("a", 0), ("b", 0.1), ("d", 0.3))
    )
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent>{parent}</parent><child>{child}</child>'
        f"<axis><xyz>0 0 1</xyz>{more}</axis></joint>"
        for name, parent, child, more in (
            ("A", "g", "a", ""),
            ("B", "a", "b", ""),
            ("D", "g", "d", '<mimic joint="A"><multiplier>-0.5</multiplier></mimic>'),
        )
    )
    base = '<joint name="s" type="fixed"><parent>world</parent><child>g</child></joint>'
    text = f'<sdf version="1.11"><model name="gears">{links}{base}{joints}</model></sdf>'
    return cd.load, text, "D_mimic"


@pytest.mark.parametrize("notation", ["MJCF", "SDF", "Pinocchio"])
@pytest.mark.parametrize("forces", ["none", "mesh"])
def test_what_is_open_of_gears_is_said_where_the_notation_cannot(
    notation: str, forces: str
) -> None:
    """Nothing presses on bearings where none is said; teeth do, by the torque over the arm."""
    reader, source, name = in_other_words(notation)
    told = cd.describe(reader(source)).silent
    report = str(cd.describe(reader(source)))
    assert len(told) == 1 and repr(name) in told[0]
    assert 'load(..., forces={"name of the coupling": "none"}), or from_pinocchio' in report
    mechanism = reader(source, forces={name: forces})
    described = cd.describe(mechanism)
    assert described.mobility == 2 and not described.silent
    scene = cd.Scene(mechanism, drive=["A", "B"], loads={"D": 1.0}, gravity=(0, 0, 0), strict=True)
    turn = scene.sweep(np.zeros((1, 2)))
    np.testing.assert_allclose(turn.drive_effort, [[0.5, 0.0]], atol=1e-13)
    # The pitch radius of the second wheel is two thirds of the distance of 0.3 m.
    across = {"none": 0.0, "mesh": 1.0 / 0.2 / np.cos(np.radians(20.0))}[forces]
    np.testing.assert_allclose(np.linalg.norm(turn["D"].force), across, atol=1e-12)
