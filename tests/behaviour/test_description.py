"""Bad descriptions get a ModelError that says what is wrong, where, and the valid choices."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from testkit.scenes import text, universal

import cardan_dyn as cd
from cardan_dyn.description.urdf import check_inertia

JOINT = text("universal_joint")


def changed(old: str, new: str, count: int = 1) -> str:
    assert old in JOINT
    return JOINT.replace(old, new, count)


def second_parent() -> str:
    extra = '<joint name="extra" type="fixed"><parent link="base"/><child link="cross"/></joint>'
    return JOINT.replace("</robot>", f"{extra}</robot>")


def with_root(links: str) -> str:
    return f'<robot name="r">{links}</robot>'


LOOSE = '<link name="a"/><link name="b"/>'
RING = (
    LOOSE
    + '<link name="c"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>'
    '<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>'
)

BAD = {
    "not XML": ("<robot", "malformed XML"),
    "cut off": (JOINT[: len(JOINT) // 2], "malformed XML"),
    "not a robot": ("<sdf/>", "outermost element is <sdf>, expected <robot>"),
    "empty": (with_root(""), "there is no <link>"),
    "two roots": (with_root(LOOSE), "exactly one root link; links without a parent: a, b"),
    "ring of joints": (with_root(RING), "not connected to the root 'c': a, b"),
    "two parents": (
        second_parent(),
        "link 'cross' has two parents, joints 'pin_in' and 'extra'",
    ),
    "unknown parent": (
        changed('<parent link="shaft_in"/>', '<parent link="shaft"/>'),
        "joint 'pin_in': parent link 'shaft' does not exist; links: base, cross",
    ),
    "unknown child": (
        changed('<child link="cross"/>', '<child link="spider"/>'),
        "joint 'pin_in': child link 'spider' does not exist; links: base, cross",
    ),
    "no parent": (changed('<parent link="shaft_in"/>', ""), 'joint .pin_in.: <parent link="..."'),
    "loop on unknown link": (
        changed('<predecessor link="cross">', '<predecessor link="spider">'),
        "loop 'pin_out': predecessor link 'spider' does not exist; links: base, cross",
    ),
    "loop without successor": (
        re.sub(r"<successor.*?</successor>", "", JOINT),
        "loop 'pin_out': <successor link",
    ),
    "loop on itself": (
        changed('<successor link="shaft_out">', '<successor link="cross">'),
        "predecessor and successor are the same link 'cross'",
    ),
    "unknown loop type": (
        changed('name="pin_out" type="continuous"', 'name="pin_out" type="helical"'),
        "type .helical. is not supported; types: continuous, cylindrical, fixed, planar",
    ),
    "unknown joint type": (
        changed('name="pin_in" type="continuous"', 'name="pin_in" type="ball"'),
        "type .ball. is not supported; types: continuous, fixed, floating, planar, prismatic",
    ),
    "other notation": (
        changed("</robot>", '<loop_joint name="x"/></robot>'),
        "loop_joint 'x': type None is not supported",
    ),
    "axis of no direction": (
        changed('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'),
        "joint 'pin_in': the axis .* has no direction",
    ),
    "axis of two numbers": (changed('<axis xyz="0 1 0"/>', '<axis xyz="0 1"/>'), "not 3 finite"),
    "not a number": (
        changed('<axis xyz="0 1 0"/>', '<axis xyz="0 y 0"/>'),
        "is not 3 finite number",
    ),
    "infinite origin": (
        changed(
            '<successor link="shaft_out"><origin xyz="0',
            '<successor link="shaft_out"><origin xyz="inf',
        ),
        "loop 'pin_out': origin xyz: 'inf 0 0' is not 3 finite",
    ),
    "NaN mass": (
        re.sub('mass value=".*?"', 'mass value="nan"', JOINT, count=1),
        "link 'base': mass",
    ),
    "zero mass": (
        re.sub('mass value=".*?"', 'mass value="0"', JOINT, count=1),
        "link 'base': mass 0 kg is not positive; a massless link has no <inertial>",
    ),
    "negative mass": (
        re.sub('mass value=".*?"', 'mass value="-2"', JOINT, count=1),
        "mass -2 kg is not positive",
    ),
    "mass without inertia": (
        re.sub("<inertia .*?/>", "", JOINT, count=1),
        "<inertial> needs <mass> and <inertia>",
    ),
    "negative inertia": (
        re.sub('ixx=".*?"', 'ixx="-1"', JOINT, count=1),
        "negative principal moment -1",
    ),
    "triangle inequality": (
        re.sub('ixx=".*?"', 'ixx="9"', JOINT, count=1),
        "violate the triangle inequality",
    ),
    "doubled link": (changed("</robot>", '<link name="cross"/></robot>'), "link names that occur"),
    "loop named like a joint": (
        changed('loop name="pin_out"', 'loop name="pin_in"'),
        "joint or loop names that occur twice: pin_in",
    ),
    "nameless joint": (changed('joint name="pin_in" ', "joint "), "a <joint> has no name"),
    "loop within one body": (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">'
        '<parent link="a"/><child link="b"/></joint><loop name="l" type="fixed">'
        '<predecessor link="a"/><successor link="b"/></loop></robot>',
        "fixed joints already make one body",
    ),
}


@pytest.mark.parametrize(("urdf", "message"), BAD.values(), ids=BAD.keys())
def test_bad_description(urdf: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(urdf)


def test_unknown_name_or_file(tmp_path: Path) -> None:
    for source in ("no_such_joint", tmp_path / "none.urdf", tmp_path, "x\0y", "a" * 5000):
        with pytest.raises(cd.ModelError, match=r"bundled .*double_shaft_z, .*universal_joint"):
            cd.load(source)
    with pytest.raises(cd.ModelError, match="not NoneType"):
        cd.load(None)
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(b"\xff\xfe\x00<robot>")
    with pytest.raises(cd.ModelError, match="cannot be read as text"):
        cd.load(binary)


def test_file_path_and_text_load_alike(tmp_path: Path) -> None:
    path = tmp_path / "mine.urdf"
    path.write_text("\ufeff" + JOINT, encoding="utf-8")
    turns = [universal(cd.load(source), 0.3).sweep([0.4]) for source in (path, str(path), JOINT)]
    assert turns[0].drive_effort == turns[1].drive_effort == turns[2].drive_effort
    assert {"double_shaft_z", "universal_joint"} <= set(cd.bundled_names())


def test_origins_with_angles_are_roll_pitch_yaw() -> None:
    """A loop described in a turned frame with a turned axis is the same loop."""
    turned = JOINT.replace(
        '<predecessor link="cross"><origin xyz="0 0 0"/>',
        '<predecessor link="cross"><origin xyz="0 0 0" rpy="0.4 -0.3 1.1"/>',
    ).replace(
        '<successor link="shaft_out"><origin xyz="0 0 0"/>',
        '<successor link="shaft_out"><origin xyz="0 0 0" rpy="0.4 -0.3 1.1"/>',
    )
    import pinocchio as pin

    axis = pin.rpy.rpyToMatrix(0.4, -0.3, 1.1).T @ np.array([0.0, 0.0, 1.0])
    start = turned.index('<loop name="pin_out"')
    words = " ".join(repr(float(component)) for component in axis)
    turned = turned[:start] + turned[start:].replace("0 0 1", words)
    positions = np.linspace(0.0, 6.0, 13)
    found = universal(cd.load(turned), 0.7).sweep(positions, speed=3.0)
    reference = universal(cd.load(JOINT), 0.7).sweep(positions, speed=3.0)
    for name in reference.mechanism.joint_names:
        np.testing.assert_allclose(
            found.wrench(name, "world").moment, reference.wrench(name, "world").moment, atol=1e-12
        )
        np.testing.assert_allclose(found[name].torsion, reference[name].torsion, atol=1e-13)


def inside(tag: str, extra: str) -> str:
    """Return the joint with elements put at the beginning of the first of a kind."""
    found = re.sub(rf"(<{tag}\b([^>]*[^/])?>)", rf"\1{extra}", JOINT, count=1)
    assert found != JOINT
    return found


TWICE = {
    "inertial": inside("link", '<inertial><mass value="1"/></inertial>'),
    "mass": inside("inertial", '<mass value="3"/>'),
    "inertia": inside("inertial", '<inertia ixx="1" iyy="1" izz="1"/>'),
    "origin": inside("inertial", '<origin xyz="1 0 0"/>' * 2),
    "parent": inside("joint", '<parent link="base"/>'),
    "child": inside("joint", '<child link="base"/>'),
    "axis": inside("joint", '<axis xyz="0 0 1"/>'),
    "limit": inside("joint", '<limit upper="1"/><limit upper="2"/>'),
    "dynamics": inside("joint", '<dynamics damping="1"/><dynamics/>'),
    "predecessor": inside("loop", '<predecessor link="base"/>'),
    "successor": inside("loop", '<successor link="base"/>'),
}


@pytest.mark.parametrize(("tag", "urdf"), TWICE.items(), ids=TWICE.keys())
def test_what_is_said_twice_is_refused(tag: str, urdf: str) -> None:
    with pytest.raises(cd.ModelError, match=rf"there are \d <{tag}> in <\w+>; keep one"):
        cd.load(urdf)


def test_a_frame_is_given_in_one_way() -> None:
    both = changed('<predecessor link="cross">', '<predecessor link="cross" xyz="1 0 0">')
    with pytest.raises(cd.ModelError, match="attributes xyz or rpy and an <origin>; keep one"):
        cd.load(both)
    turned = changed("<origin ", '<origin quat_xyzw="0 0 1 0" ')
    with pytest.raises(cd.ModelError, match="quat_xyzw is not read; write rpy"):
        cd.load(turned)


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ("1e200 1e200 0", "beyond 1e[+]50"),
        ("1e-320 1e-320 0", "has no direction; its length is to be 1"),
        ("1e-320 2e-320 0", "has no direction"),
        ("0 1e-200 0", "has no direction"),
        ("0 0 1e-400", "has no direction"),
    ],
)
def test_axes_without_a_direction(axis: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(changed('<axis xyz="0 1 0"/>', f'<axis xyz="{axis}"/>'))


@pytest.mark.parametrize("size", ["1e-49", "1e49", "3"])
def test_axes_of_any_other_length(size: str) -> None:
    mechanism = cd.load(changed('<axis xyz="0 1 0"/>', f'<axis xyz="{size} {size} 0"/>'))
    np.testing.assert_allclose(
        mechanism.joint("pin_in").axis, [0.5**0.5, 0.5**0.5, 0.0], atol=1e-16
    )


@pytest.mark.parametrize(
    ("urdf", "message"),
    [
        (
            changed("<robot ", '<robot xmlns="http://a/b" '),
            "outermost element is <{http://a/b}robot>",
        ),
        (
            changed("<joint ", '<joint xmlns="http://a/b" '),
            "<joint> stands in the namespace 'http://a/b'",
        ),
        (
            changed("<inertial>", '<inertial xmlns="http://a/b">'),
            "<inertial> stands in the namespace 'http://a/b'",
        ),
        (
            changed(
                "</robot>", '<x:macro xmlns:x="http://www.ros.org/wiki/xacro" name="m"/></robot>'
            ),
            "<xacro:macro> is to be processed first",
        ),
    ],
)
def test_namespaces(urdf: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=re.escape(message)):
        cd.load(urdf)


def test_extensions_of_others_are_left_alone() -> None:
    extra = '<g:joint_states xmlns:g="http://a/b"><g:joint name="x"/></g:joint_states>'
    extra += '<velocity_ratios><joint name="x"/><joint name="y"/></velocity_ratios>'
    assert (
        cd.load(changed("</robot>", f"{extra}</robot>")).joint_names == cd.load(JOINT).joint_names
    )


def test_entities() -> None:
    """Few are read, very many are refused before they fill the memory."""
    robot = JOINT[JOINT.index("<robot") :]
    few = robot.replace('<axis xyz="0 1 0"/>', '<axis xyz="1 &zero;"/>')
    few = f'<!DOCTYPE robot [<!ENTITY zero "0 0">]>{few}'
    np.testing.assert_array_equal(cd.load(few).joint("pin_in").axis, [1.0, 0.0, 0.0])
    levels = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 12))
    bomb = f'<!DOCTYPE robot [<!ENTITY e0 "0 ">{levels}]>{robot.replace("0 1 0", "&e11;")}'
    with pytest.raises(cd.ModelError, match="malformed XML"):
        cd.load(bomb)
    elsewhere = '<!DOCTYPE robot SYSTEM "file:///nowhere">' + robot.replace("0 1 0", "0 1&x; 0")
    with pytest.raises(cd.ModelError, match="DOCTYPE refers to another document"):
        cd.load(elsewhere)


@pytest.mark.parametrize("tensor", [np.full((3, 3), np.nan), np.diag([np.inf, 1.0, 1.0])])
def test_inertias_beyond_all_numbers(tensor: np.ndarray) -> None:
    with pytest.raises(cd.ModelError, match="link 'a': the inertia has no principal moments"):
        check_inertia(tensor, "link 'a'", False)


VALUES = st.sampled_from(
    ["", "nan", "inf", "-1e400", "0", "1e308", "x", "0 0", "0 0 0 0", "\u00e9"]
)


@settings(max_examples=150, derandomize=True, deadline=None)
@given(data=st.data())
def test_damaged_descriptions_raise_nothing_else(data: st.DataObject) -> None:
    """Any attribute value or piece of text may be damaged: CardanError or a working mechanism."""
    damaged = JOINT
    for _ in range(data.draw(st.integers(1, 3))):
        attributes = list(re.finditer(r'"[^"<>]*"', damaged))
        if attributes and data.draw(st.booleans()):
            at = attributes[data.draw(st.integers(0, len(attributes) - 1))]
            damaged = damaged[: at.start()] + f'"{data.draw(VALUES)}"' + damaged[at.end() :]
        else:
            start = data.draw(st.integers(0, len(damaged) - 1))
            damaged = damaged[:start] + damaged[start + data.draw(st.integers(1, 300)) :]
    try:
        mechanism = cd.load(damaged if damaged.lstrip().startswith("<") else "<" + damaged)
        universal(mechanism, 0.3).sweep([0.0, 1.0], speed=2.0)
    except cd.CardanError:
        pass
