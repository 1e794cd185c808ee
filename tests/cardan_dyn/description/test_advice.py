"""What a refusal says to write is read then, and moves as it should."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from testkit.sdf import model

import cardan_dyn as cd

MASS = (
    '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
LINKS = '<link name="g"/>' + "".join(f'<link name="{name}">{MASS}</link>' for name in "abd")
HEAVY = (
    "<inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia>"
    "</inertial>"
)
EMPTY = "<inertial><mass>0</mass><inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial>"
TWO = f'<link name="a">{HEAVY}</link><link name="b"><pose>1 0 0 0 0 0</pose>{HEAVY}</link>'
HELD = '<joint name="s" type="fixed"><parent>world</parent><child>a</child></joint>'


def robot(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def hinge(name: str, parent: str, child: str, xyz: str = "0 0 0", more: str = "") -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="0 0 1"/>{more}</joint>'
    )


def joint(kind: str, more: str = "<axis><xyz>0 0 1</xyz></axis>", name: str = "h") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>a</parent><child>b</child>{more}</joint>'


CRANK = hinge("A", "g", "a") + hinge("B", "a", "b", "0 .1 0") + hinge("D", "g", "d", ".3 0 0")
PIN = hinge("C", "b", "d", ".3 .15 0")
CLOSED = (
    '<loop name="C" type="continuous"><predecessor link="b"><origin xyz=".3 .15 0"/></predecessor>'
    '<successor link="d"><origin xyz="0 .25 0"/></successor><axis xyz="0 0 1"/></loop>'
)
OPEN = hinge("A", "g", "a") + hinge("B", "a", "b", "0 .1 0") + hinge("D", "b", "d", ".3 0 0")
GAZEBO = (
    '<joint name="C" type="revolute"><parent>b</parent><child>d</child>'
    "<pose>0 .25 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>"
)


def mimicking(name: str, other: str) -> str:
    ends = {"A": ("g", "a"), "B": ("a", "b")}[name]
    return hinge(name, *ends, more=f'<mimic joint="{other}"/>')


def gears(words: str) -> str:
    """Return gears of two cranks."""
    ends = '<predecessor link="a"/><successor link="d"/>'
    return f'<coupling name="t" {words}>{ends}<ratio value="-2"/></coupling>'


def constraint(more: str) -> str:
    """Return what closes the four-bar linkage, in another notation."""
    return (
        '<constraint name="C" type="revolute"><parent link="b"/><child link="d"/>'
        '<parent_origin xyz=".3 .15 0"/><child_origin xyz="0 .25 0"/>'
        f'<parent_axis xyz="0 0 1"/>{more}</constraint>'
    )


def mjcf(equality: str = "", body: str = "", joint: str = "", head: str = "") -> str:
    return (
        f"<mujoco>{head}<worldbody>"
        f'<body name="a"{body}><joint name="A" axis="0 0 1"/>{joint}<geom size=".1"/></body>'
        '<body name="b" pos="1 0 0"><joint name="B" axis="0 0 1"/><joint name="S" type="slide" '
        f'axis="0 1 0"/><geom size=".1"/></body></worldbody>'
        f"<equality>{equality}</equality></mujoco>"
    )


def nested(inside: str = "", attributes: str = "", version: str = "1.9") -> str:
    inner = f'<model name="arm"{attributes}><link name="b">{HEAVY}</link>{inside}</model>'
    held = '<joint name="j" type="revolute"><parent>a</parent><child>arm::b</child>'
    return model(
        f'<link name="a">{HEAVY}</link>{HELD}{inner}{held}<axis><xyz>0 0 1</xyz></axis></joint>',
        version,
    )


class Case(NamedTuple):
    """What is refused, what is said, and what is read where one does so.

    Attributes:
        refused, read: texts; the second is empty where the text stays.
        said: part of the message.
        mobility: of what is read.
        arguments: further ones of `load`.
        warns: whether it is said in a warning.
    """

    refused: str
    said: str
    read: str
    mobility: int
    arguments: dict[str, Any] = {}  # noqa: RUF012
    warns: bool = False


FRAMES = "".join(
    f'<link name="closing_C_{side}"/><joint name="C_{side}" type="fixed"><parent link="{link}"/>'
    f'<child link="closing_C_{side}"/><origin xyz="{xyz}"/></joint>'
    for side, link, xyz in ((1, "b", ".3 .15 0"), (2, "d", "0 .25 0"))
)
PLANE = (
    f'<link name="e">{MASS}</link><joint name="P" type="planar"><parent link="g"/><child link="e"/>'
    '<axis xyz="0 0 1"/><dynamics armature="1 2 3"/></joint>'
)
SLIDES = f'<link name="e">{MASS}</link>' + "".join(
    f'<joint name="{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
    f'<axis xyz="{axis}"/><limit effort="1" velocity="1" lower="-1" upper="1"/>'
    f'<dynamics armature="{armature}"/></joint>'
    for parent, child, kind, axis, armature in (
        ("g", "f", "prismatic", "1 0 0", 1),
        ("f", "h", "prismatic", "0 1 0", 2),
        ("h", "e", "revolute", "0 0 1", 3),
    )
)
TILTED = GAZEBO.replace("0 .25 0 0 0 0", "0 .25 0 1.5707963267948966 0 0").replace(
    "<xyz>0 0 1<", "<xyz{}>0 1 0<"
)
THREE = TWO + f'<link name="c"><pose>1 0 0 0 0 0</pose>{HEAVY}</link>'
ROTOR = '<dynamics armature="0.3"/>'
GEAR = (
    '<joint name="w" type="gearbox"><parent>b</parent><child>c</child>'
    "<gearbox_reference_body>a</gearbox_reference_body><gearbox_ratio>3</gearbox_ratio>"
    "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>"
)
ODD = MASS.replace('iyy=".01"', 'iyy=".03"')
SCREW = "<axis><xyz>0 0 1</xyz></axis><screw_thread_pitch>{}</screw_thread_pitch>"
UNIVERSAL = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>{}</xyz></axis2>"
TURNED = TWO.replace("1 0 0 0 0 0", "1 0 0 1 0 0")
ONE_MODEL = f'<model name="{{}}"><link name="a">{HEAVY}</link>{{}}</model>'
STAND = '<joint name="s" type="revolute"><parent>world</parent><child>a</child>{}</joint>'
AXIS = "<axis><xyz>0 0 1</xyz></axis>"
WORLD = '<sdf version="1.9"><world name="w">{}</world></sdf>'
CASES = {
    "two parents": Case(
        robot(LINKS, CRANK, PIN),
        "a URDF is a tree: write one .*<loop>",
        robot(LINKS, CRANK, CLOSED),
        1,
    ),
    "a ring": Case(
        robot(LINKS, hinge("A", "g", "a"), hinge("B", "b", "d"), hinge("C", "d", "b")),
        "form a ring: write one of them as <loop>",
        robot(LINKS, CRANK, CLOSED),
        1,
    ),
    "a mass of zero": Case(
        robot(LINKS, OPEN).replace('<mass value="1"/>', '<mass value="0"/>', 1),
        r"load\(..., strict=False\) accepts it",
        "",
        3,
        {"strict": False},
    ),
    "an inertia that no body has": Case(
        robot(LINKS, OPEN).replace(MASS, ODD, 1),
        r"load\(..., strict=False\) accepts it",
        "",
        3,
        {"strict": False},
    ),
    "a quaternion": Case(
        robot(LINKS, OPEN).replace('<origin xyz="0 .1 0"', '<origin quat_xyzw="0 0 0 1"'),
        "write rpy instead",
        robot(LINKS, OPEN).replace('<origin xyz="0 .1 0"', '<origin rpy="0 0 0"'),
        3,
    ),
    "an axis without numbers": Case(
        robot(LINKS, OPEN).replace('<axis xyz="0 0 1"/>', "<axis/>"),
        'write <axis xyz="0 0 1"/>',
        robot(LINKS, OPEN),
        3,
    ),
    "no axis at all": Case(
        robot(LINKS, OPEN).replace('<axis xyz="0 0 1"/>', "<axis/>"),
        "or leave it out",
        robot(LINKS, OPEN).replace('<axis xyz="0 0 1"/>', ""),
        3,
    ),
    "a joint that mimics itself": Case(
        robot(LINKS, OPEN.replace("</joint>", '<mimic joint="A"/></joint>', 1)),
        "name another one, or remove <mimic>",
        robot(LINKS, OPEN.replace("</joint>", '<mimic joint="B"/></joint>', 1)),
        2,
    ),
    "a ratio of zero": Case(
        robot(LINKS, OPEN.replace("</joint>", '<mimic joint="B" multiplier="0"/></joint>', 1)),
        "remove <mimic> and hold the joint in the scene",
        robot(LINKS, OPEN),
        3,
    ),
    "a joint of Gazebo at a link": Case(
        robot(LINKS, CRANK, f'<gazebo reference="a">{GAZEBO}</gazebo>'),
        "write it in a <gazebo> without a reference",
        robot(LINKS, CRANK, f"<gazebo>{GAZEBO}</gazebo>"),
        1,
    ),
    "a joint of Gazebo whose child is the root": Case(
        robot(
            LINKS,
            OPEN,
            "<gazebo>",
            GAZEBO.replace(">b<", ">x<").replace(">d<", ">g<").replace(">x<", ">d<"),
            "</gazebo>",
        ),
        "or swap parent and child",
        robot(LINKS, OPEN, "<gazebo>", GAZEBO.replace(">b<", ">g<"), "</gazebo>"),
        1,
    ),
    "joints that mimic each other": Case(
        robot(LINKS, mimicking("A", "B"), mimicking("B", "A"), hinge("D", "g", "d")),
        "remove one <mimic>",
        robot(LINKS, mimicking("A", "B"), hinge("B", "a", "b"), hinge("D", "g", "d")),
        2,
    ),
    "a gearbox of Gazebo": Case(
        robot(LINKS, CRANK, "<gazebo>", GAZEBO.replace("revolute", "gearbox"), "</gazebo>"),
        "write <coupling> or <mimic>",
        robot(LINKS, CRANK, gears("")),
        2,
    ),
    "numbers of teeth": Case(
        robot(LINKS, CRANK, gears('pressure_angle="0.3"')),
        'write forces="mesh" as well',
        robot(LINKS, CRANK, gears('pressure_angle="0.3" forces="mesh"')),
        2,
    ),
    "teeth on one line": Case(
        robot(LINKS, CRANK.replace(".3 0 0", "0 0 1"), gears('forces="mesh"')),
        "leave forces= out",
        robot(LINKS, CRANK.replace(".3 0 0", "0 0 1"), gears("")),
        2,
    ),
    "teeth in two planes": Case(
        robot(LINKS, CRANK.replace(".3 0 0", ".3 0 1"), gears('forces="mesh"')),
        'along="..." says how far the teeth are',
        robot(LINKS, CRANK.replace(".3 0 0", ".3 0 1"), gears('forces="mesh" along="0.5"')),
        2,
    ),
    "two axes of a hinge": Case(
        robot(LINKS, CRANK, constraint('<child_axis xyz="0 1 0"/>')),
        "or leave child_axis out",
        robot(LINKS, CRANK, constraint("")),
        1,
    ),
    "a word that is nearly right": Case(
        robot(LINKS, OPEN.replace("<origin", "<orign", 1)),
        "did you mean 'origin'",
        robot(LINKS, OPEN),
        3,
    ),
    "a weld without moments": Case(
        mjcf('<weld body1="a" body2="b" anchor="0 0 0" torquescale="0"/>'),
        "is a ball; write <connect>",
        mjcf('<connect body1="a" body2="b" anchor="0.5 0 0"/>'),
        1,
    ),
    "weight that is taken off": Case(
        mjcf(body=' gravcomp="1"'),
        r"load\(..., strict=False\) accepts",
        "",
        3,
        {"strict": False},
    ),
    "a piston": Case(
        model(TWO + HELD + joint("piston")),
        "write a prismatic and a revolute joint in a row",
        model(
            TWO
            + HELD
            + f'<link name="c">{EMPTY}</link>'
            + joint("prismatic").replace(">b<", ">c<")
            + joint("revolute", name="k").replace(">a<", ">c<")
        ),
        2,
    ),
    "axes that are not at right angles": Case(
        model(TWO + HELD + joint("universal", UNIVERSAL.format("1 1 0"))),
        "write two revolute joints with a link of mass 0 between them",
        model(
            TWO
            + HELD
            + f'<link name="c">{EMPTY}</link>'
            + joint("revolute", "<axis><xyz>1 0 0</xyz></axis>").replace(">b<", ">c<")
            + joint("revolute", "<axis><xyz>1 1 0</xyz></axis>", "k").replace(">a<", ">c<")
        ),
        2,
    ),
    "the world as a child": Case(
        model(TWO + HELD.replace("world", "a").replace("<child>a", "<child>world") + joint("ball")),
        "swap parent and child",
        model(TWO + HELD + joint("ball")),
        3,
    ),
    "two models": Case(
        WORLD.format(
            ONE_MODEL.format("m", STAND.format(AXIS)) + ONE_MODEL.format("n", STAND.format(AXIS))
        ),
        r'load\(..., model="NAME"\) reads one',
        "",
        1,
        {"model": "n"},
    ),
    "a world that includes": Case(
        WORLD.format("<include><uri>u</uri></include>" + ONE_MODEL.format("m", STAND.format(AXIS))),
        r"load\(..., strict=False\) leaves it out",
        "",
        1,
        {"strict": False},
    ),
    "a model in a model of an old version": Case(
        nested(version="1.6"),
        "write its links and joints into the outer one",
        model(TWO + HELD + joint("revolute"), "1.6"),
        1,
    ),
    "a model in a model that stands still": Case(
        nested("<static>true</static>").replace(HELD, ""),
        "fix it to the world instead",
        nested(
            '<joint name="s" type="fixed"><parent>world</parent><child>b</child></joint>'
        ).replace(HELD, ""),
        1,
    ),
    "a model in a model that one of its frames places": Case(
        nested(attributes=' placement_frame="b"'),
        "write a <pose>",
        nested("<pose>1 0 0 0 0 0</pose>"),
        1,
    ),
    "a screw without pitch": Case(
        model(TWO + HELD + joint("screw")),
        "<screw_thread_pitch> is missing: metres per turn",
        model(TWO + HELD + joint("screw", SCREW.format("0.01"))),
        1,
    ),
    "a screw with a pitch of zero": Case(
        model(TWO + HELD + joint("screw", SCREW.format("0"))),
        "is a hinge: type revolute",
        model(TWO + HELD + joint("revolute")),
        1,
    ),
    "an axis of SDF that is missing": Case(
        model(TWO + HELD + joint("revolute", "")),
        "is missing: <axis><xyz>0 0 1</xyz></axis>",
        model(TWO + HELD + joint("revolute")),
        1,
    ),
    "an axis in the model": Case(
        model(
            TURNED
            + HELD
            + joint(
                "revolute",
                "<axis><xyz>0 0 1</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>",
            )
        ),
        'write expressed_in="__model__"',
        model(
            TURNED
            + HELD
            + joint("revolute", '<axis><xyz expressed_in="__model__">0 0 1</xyz></axis>')
        ),
        1,
    ),
    "an axis in a frame, in an old version": Case(
        model(
            TWO + HELD + joint("revolute", '<axis><xyz expressed_in="a">0 0 1</xyz></axis>'), "1.6"
        ),
        "expressed_in is known from SDF 1.7 on",
        model(
            TWO + HELD + joint("revolute", '<axis><xyz expressed_in="a">0 0 1</xyz></axis>'), "1.7"
        ),
        1,
    ),
    "an inertia of shapes and of numbers": Case(
        model(
            (
                shaped := TWO.replace(
                    HEAVY,
                    '<inertial auto="true"><mass>1</mass></inertial><collision name="c"><geometry>'
                    "<sphere><radius>1</radius></sphere></geometry></collision>",
                )
            )
            + HELD
            + joint("ball")
        ),
        "exclude each other; keep one",
        model(shaped.replace("<mass>1</mass>", "") + HELD + joint("ball")),
        3,
    ),
    "a frame in a link": Case(
        model(TWO.replace("<inertial>", '<frame name="f"/><inertial>', 1) + HELD + joint("ball")),
        "write it in the <model>",
        model(TWO + '<frame name="f" attached_to="a"/>' + HELD + joint("ball")),
        3,
    ),
    "a link that floats": Case(
        model(TWO + joint("ball")),
        '<joint type="fixed"> with parent world holds it',
        model(TWO + HELD + joint("ball")),
        3,
        warns=True,
    ),
    "higher powers of teeth": Case(
        robot(LINKS, CRANK, gears('forces="mesh" higher="0.1"')),
        "leave higher or forces='mesh' out",
        robot(LINKS, CRANK, gears('higher="0.1"')),
        2,
    ),
    "an equality that holds a joint": Case(
        mjcf('<joint joint1="A" joint2="B" polycoef="0.1 0 0 0 0"/>'),
        "leave joint2 out where joint1 stays where it is",
        mjcf('<joint joint1="A" polycoef="0.1 0 0 0 0"/>'),
        2,
    ),
    "an equality without a ratio": Case(
        mjcf('<joint joint1="A" joint2="B" polycoef="0.1 0 0 0 0"/>'),
        'write polycoef="offset ratio 0 0 0", the ratio not zero',
        mjcf('<joint joint1="A" joint2="B" polycoef="0.1 2 0 0 0"/>'),
        2,
    ),
    "closing frames without a type": Case(
        robot(LINKS, CRANK, FRAMES),
        "taken as spherical; write <loop> where it is another one",
        robot(LINKS, CRANK, CLOSED),
        1,
        warns=True,
    ),
    "two armatures of a hinge": Case(
        robot(LINKS, OPEN.replace("</joint>", '<dynamics armature="1 2"/></joint>', 1)),
        "write one for all motions of the continuous joint",
        robot(LINKS, OPEN.replace("</joint>", '<dynamics armature="1"/></joint>', 1)),
        3,
    ),
    "armatures of a plane": Case(
        robot(LINKS, OPEN, PLANE),
        "write joints that slide in a row",
        robot(LINKS, '<link name="f"/><link name="h"/>', OPEN, SLIDES),
        6,
    ),
    "an axis of Gazebo in a turned frame": Case(
        robot(LINKS, CRANK, "<gazebo>", TILTED.format(""), "</gazebo>"),
        "write expressed_in",
        robot(LINKS, CRANK, "<gazebo>", TILTED.format(' expressed_in="C"'), "</gazebo>"),
        1,
        warns=True,
    ),
    "a frame of the world": Case(
        WORLD.format('<frame name="f"/>' + ONE_MODEL.format("m", STAND.format(AXIS))),
        "write it into the <model>",
        WORLD.format(ONE_MODEL.format("m", '<frame name="f"/>' + STAND.format(AXIS))),
        1,
    ),
    "a frame in a joint": Case(
        model(TWO + HELD + joint("ball", '<frame name="f"/>'), "1.6"),
        "write it in the <model>",
        model(TWO + '<frame name="f" attached_to="a"/>' + HELD + joint("ball")),
        3,
    ),
    "a frame of an inertia": Case(
        model(
            TWO.replace("<inertial>", '<inertial><frame name="f"/>', 1) + HELD + joint("ball"),
            "1.5",
        ),
        "write a <pose>",
        model(
            TWO.replace("<inertial>", "<inertial><pose>0 0 1 0 0 0</pose>", 1)
            + HELD
            + joint("ball"),
            "1.5",
        ),
        3,
    ),
    "a gearbox without a hinge": Case(
        model(
            THREE + HELD + joint("revolute") + joint("ball", "", "k").replace(">b<", ">c<") + GEAR
        ),
        "write one, whose parent is that body",
        model(
            THREE
            + HELD
            + joint("revolute")
            + joint("revolute", name="k").replace(">b<", ">c<")
            + GEAR
        ),
        1,
    ),
    "a model included": Case(
        model(TWO + HELD + joint("ball") + "<include><uri>u</uri></include>"),
        "write the included model's links and joints into the file",
        model(TWO + HELD + joint("ball")),
        3,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_a_refusal_says_to_write_is_read(name: str) -> None:
    case = CASES[name]
    if case.warns:
        assert any(case.said in warning for warning in cd.load(case.refused).warnings)
    else:
        with pytest.raises(cd.ModelError, match=case.said):
            cd.load(case.refused)
    mechanism = cd.load(case.read or case.refused, **case.arguments)
    assert cd.describe(mechanism).mobility == case.mobility
    assert not case.warns or not mechanism.warnings


def test_what_mjcf_cannot_write_is_written_as_said(tmp_path: Path) -> None:
    mechanism = cd.load(robot(LINKS, CRANK, gears('higher="0.1 0.2 0.3 0.4"')))
    with pytest.raises(cd.ModelError, match=r"powers up to the fourth; write URDF\+"):
        cd.write(mechanism, tmp_path / "gears.xml")
    with pytest.raises(cd.CardanError, match=r"names no notation; write \.urdf for URDF\+"):
        cd.write(mechanism, tmp_path / "gears.txt")
    cd.write(mechanism, tmp_path / "gears.urdf")
    assert cd.describe(cd.load(tmp_path / "gears.urdf")).mobility == 2
    light = OPEN + hinge("E", "d", "e") + hinge("F", "e", "f") + hinge("G", "e", "h")
    more = "".join(f'<link name="{name}">{MASS}</link>' for name in "fh")
    with pytest.raises(cd.ModelError, match=r"link 'e' moves and has no mass, .* give it one"):
        cd.write(cd.load(robot(LINKS, more, '<link name="e"/>', light)), tmp_path / "light.xml")
    heavy = cd.load(robot(LINKS, more, f'<link name="e">{MASS}</link>', light))
    cd.write(heavy, tmp_path / "heavy.xml")
    assert cd.describe(cd.load(tmp_path / "heavy.xml")).mobility == 6


def test_what_locks_a_mechanism_leaves_more_free_as_said() -> None:
    """A second hinge, askew, on a four-bar linkage."""
    bar = cd.load(robot(LINKS, CRANK, CLOSED))
    with pytest.raises(cd.ArgumentError, match="has no offset; name the joints instead"):
        cd.couple(bar, "a", "d", 1.0, offset=0.1)
    tree = cd.load(robot(LINKS, CRANK))
    assert cd.describe(cd.couple(tree, "A", "D", 1.0, offset=0.1)).mobility == 2
    places = {"at": (0.3, 0.15, 0.0), "at_b": (0.0, 0.25, 0.0)}
    locked = cd.close(tree, "b", "d", "fixed", **places)  # type: ignore[arg-type]
    (told,) = [one for one in locked.warnings if "moves any more" in one]
    assert told.endswith("take a type that leaves more free, such as spherical")
    free = cd.close(tree, "b", "d", "spherical", **places)  # type: ignore[arg-type]
    assert cd.describe(free).mobility == 1


def test_an_armature_that_differs_is_given_to_a_link_as_said() -> None:
    model = pin.Model()
    index = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "j")
    model.appendBodyToJoint(
        index, pin.Inertia(1.0, np.zeros(3), 0.1 * np.eye(3)), pin.SE3.Identity()
    )
    model.armature = np.array([0.0, 0.0, 0.0, 1.0, 2.0, 2.0])
    with pytest.raises(cd.ModelError, match="set it to 0 and give a link the inertia"):
        cd.from_pinocchio(model)
    model.armature = np.zeros(6)
    own = pin.Inertia(0.0, np.zeros(3), np.diag([1.0, 2.0, 2.0]))
    model.inertias[index] = model.inertias[index] + own
    assert cd.describe(cd.from_pinocchio(model)).mobility == 6
