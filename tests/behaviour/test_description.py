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
    "not a robot": ("<svg/>", "outermost element is <svg>, expected <robot>"),
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
        "connects 'cross' and 'cross', which fixed joints already make one body",
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


VALUES = st.sampled_from(
    ["", "nan", "inf", "-1e400", "0", "1e308", "x", "0 0", "0 0 0 0", "\u00e9"]
)


@pytest.mark.slow
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


def test_what_does_not_move_at_all_has_warnings_as_well() -> None:
    assert cd.load('<robot name="stone"><link name="ground"/></robot>').warnings == ()
    text = """<sdf version="1.9"><model name="wall"><static>true</static><link name="stone"/>
    </model></sdf>"""
    (told,) = cd.load(text).warnings
    assert "link 'stone': without <inertial>" in told
