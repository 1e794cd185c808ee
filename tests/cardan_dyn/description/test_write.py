"""What is written is read back: the same description, the same model, the same wrenches."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from compare import scene_of, sweep_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw

import cardan_dyn as cd
from cardan_dyn.core.description.description import (
    Description,
    JointDescription,
    Limits,
    LinkDescription,
    LoopDescription,
)
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.write import angles_of, to_urdf, with_links_at_joints
from cardan_dyn.scene.usual_motion import usual_motion

ROUNDING = 1e-15
"""Of rotations written as three angles, and of axes scaled to the length 1 a second time; random
chains showed at most 5e-16."""
X, Y, Z = np.eye(3)


def deviation(found: np.ndarray, reference: np.ndarray) -> float:
    """Return the greatest deviation relative to the greatest value; absolute where all are 0."""
    scale = float(np.max(np.abs(reference)))
    return float(np.max(np.abs(found - reference))) / (scale or 1.0)


def compare(found: cd.Sweep, reference: cd.Sweep, tolerance: float = 1e-12) -> None:
    """Compare all wrenches, in world axes, relative to the greatest force and moment."""
    wrenches = [
        {name: sweep.wrench(name, "world") for name in reference.mechanism.joint_names}
        for sweep in (found, reference)
    ]
    for component in ("force", "moment"):
        values = [
            np.array([getattr(wrench, component) for wrench in of_sweep.values()])
            for of_sweep in wrenches
        ]
        assert deviation(*values) < tolerance
    assert deviation(found.drive_effort, reference.drive_effort) < tolerance


@pytest.mark.slow
@pytest.mark.parametrize("name", cd.bundled_names())
def test_bundled_mechanisms(name: str) -> None:
    mechanism = cd.load(name)
    text = mechanism.to_urdf()
    again = cd.load(text)
    assert again.description.agrees(mechanism.description, ROUNDING)
    # Only the Stewart platform has rotated frames and inclined axes.
    assert (again.description == mechanism.description) is (name != "stewart_platform")
    assert list(again.model.names) == list(mechanism.model.names)
    found, reference = (usual_motion(item, samples=25).sweep(2.0) for item in (again, mechanism))
    compare(found, reference)


@pytest.mark.parametrize("seed", [0, 1, 7, 8, 11, 13, 16, 17, 18])
def test_random_chains(seed: int) -> None:
    """All types of joints and loops, couplings, inclined frames: see `tests/oracle`."""
    case = draw(seed)
    reference = scene_of(case).sweep(
        case.positions, speed=case.speeds, acceleration=case.accelerations
    )
    text = reference.mechanism.to_urdf()
    assert read(text).agrees(reference.mechanism.description, ROUNDING)
    rewritten = replace(case, chain=Text(text))
    found = sweep_of(rewritten)
    compare(found, reference, 1e-10)


class Text:
    """Stands for a chain of which only the text is read."""

    def __init__(self, text: str) -> None:
        self.text = text


JOINTS = """<mujoco model="inclined"><worldbody>
<body name="one" pos="0.1 0.2 0.3" euler="30 40 50">
  <joint name="turn" axis="1 2 2" pos="0.3 0.1 0.2" range="-60 200"/>
  <inertial pos="0.1 0 0" mass="2" diaginertia="1 1.2 1.3" quat="1 2 3 4"/>
  <body name="rigid" pos="0 0.4 0" euler="10 0 20"><geom size="0.1"/>
    <body name="two" pos="0 0 1"><joint name="slide" type="slide" axis="0 3 4" pos="0 1 0"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0"/>
      <body name="three" pos="0.5 0 0" euler="0 90 0">
        <joint name="ball" type="ball" pos="0.1 0 -0.4"/>
        <geom type="capsule" size="0.1 0.2"/></body></body></body></body>
<body name="loose" pos="1 2 3" euler="0 20 0"><freejoint name="free"/><geom size="0.2"/></body>
</worldbody></mujoco>"""


def dynamics(mechanism: cd.Mechanism) -> tuple[np.ndarray, ...]:
    """Return inertia matrix, efforts and placements of the links, joints in order of their names.

    Coordinates are an arbitrary function of a joint's name, so that models with their joints in
    different orders are in the same state.
    """
    model = mechanism.model
    names = sorted(mechanism.joints)
    columns = [
        column
        for name in names
        for column in range(
            mechanism.coordinates.velocity_columns[name].start,
            mechanism.coordinates.velocity_columns[name].stop,
        )
    ]
    v, step, a = np.zeros((3, model.nv))
    v[columns], a[columns], step[columns] = np.sin(np.arange(3.0 * model.nv)).reshape(3, -1)
    q = pin.integrate(model, pin.neutral(model), step)
    data = model.createData()
    matrix = np.triu(pin.crba(model, data, q))
    matrix += np.triu(matrix, 1).T
    efforts = pin.rnea(model, data, q, v, a)
    origins = [data.oMi[mechanism.joints[name].id].homogeneous for name in names]
    return matrix[np.ix_(columns, columns)], efforts[columns], np.array(origins)


def test_mjcf_joints_that_stand_apart_from_their_links() -> None:
    mechanism = cd.load(JOINTS)
    assert any(not np.array_equal(j.child_placement, np.eye(4)) for j in read(JOINTS).joints)
    again = cd.load(mechanism.to_urdf())
    assert all(np.array_equal(j.child_placement, np.eye(4)) for j in again.description.joints)
    for found, reference in zip(dynamics(again), dynamics(mechanism), strict=True):
        assert deviation(found, reference) < 1e-13
    joints = {joint.name: joint for joint in again.description.joints}
    for joint in mechanism.description.joints:
        assert (joints[joint.name].type, joints[joint.name].limits) == (joint.type, joint.limits)
    assert math.isinf(joints["turn"].limits.velocity)
    # Written a second time nothing moves any more.
    once = again.description
    assert read(to_urdf(once)).agrees(once, ROUNDING)


FOUR_BAR = """<mujoco model="four_bar"><compiler angle="radian"/><worldbody>
<body name="crank"><inertial pos="0 0.25 0" mass="1" diaginertia="0.02 0.03 0.025"/>
  <joint name="a" axis="0 0 1" pos="0 0 0.1"/>
  <body name="coupler" pos="0 0.5 0"><site name="s_1" pos="2 2 0"/>
    <inertial pos="1 1 0" mass="2" diaginertia="0.02 0.03 0.025"/>
    <joint name="b" pos="0 0 0.2"/>{axle}</body></body>
<body name="rocker" pos="2 0 0"><joint name="d" axis="0 0 1" pos="0 0 -0.3"/>
  <inertial pos="0 1.25 0" mass="3" diaginertia="0.02 0.03 0.025"/>
  <site name="s_2" pos="0 2.5 0" euler="0.3 0 0.4"/></body>
<body name="wheel" pos="3 0 0"><joint name="e" pos="0.1 0 0"/>
  <inertial pos="0 0.1 0" mass="0.5" diaginertia="0.02 0.03 0.025"/></body></worldbody>
<equality>{closure}<joint name="g" joint1="e" joint2="d" polycoef="0 -1.5 0 0 0"/></equality>
</mujoco>"""
AXLE = '<body name="pin" pos="2 2 0"><joint name="c" pos="0 0 0.1"/></body>'


@pytest.mark.parametrize(
    ("axle", "closure"),
    [
        ("", '<connect name="c" body1="coupler" body2="rocker" anchor="2 2 0"/>'),
        ("", '<connect name="c" site1="s_1" site2="s_2"/>'),
        (AXLE, '<weld name="w" body1="pin" body2="rocker"/>'),
    ],
)
def test_mjcf_loops(axle: str, closure: str) -> None:
    mechanism = cd.load(FOUR_BAR.format(axle=axle, closure=closure))
    again = cd.load(mechanism.to_urdf())
    assert again.notation == "URDF+ <loop>"
    assert again.description.couplings == mechanism.description.couplings
    found, reference = (
        cd.Scene(item, drive="a", loads={"d": -3.0}, gravity=[0.0, -9.81, 0.0]).sweep(
            np.linspace(0.0, 6.0, 13), speed=2.0, acceleration=1.0
        )
        for item in (again, mechanism)
    )
    compare(found, reference)


def plain(joints: tuple[JointDescription, ...], **more: object) -> Description:
    """Return a description of the links that joints connect, each of 1 kg."""
    names = dict.fromkeys(name for joint in joints for name in (joint.parent, joint.child))
    links = tuple(LinkDescription(name, 1.0, X, np.eye(3)) for name in names)
    order = tuple(sorted(joint.name for joint in joints))
    return Description("plain", links, joints, order, **{"loops": (), **more})


def joint(name: str, kind: str, parent: str, child: str, **more: object) -> JointDescription:
    return JointDescription(
        **{
            **{"name": name, "type": kind, "parent": parent, "child": child},
            **{"origin": np.eye(4), "axis": X, "axis_2": X, **more},
        }
    )


@pytest.mark.parametrize(
    "limits",
    [
        Limits(),
        Limits(-1.0, 2.0),
        Limits(-1.0, 2.0, 0.0, 1e-3),
        Limits(effort=0.1),
        Limits(upper=0.1 + 0.2),
    ],
)
def test_limits(limits: Limits) -> None:
    description = plain((joint("j", "revolute", "a", "b", limits=limits),))
    assert read(to_urdf(description)) == description


def test_joints_of_all_types_in_the_tree() -> None:
    kinds = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating")
    kinds += ("spherical", "universal", "cylindrical")
    description = plain(
        tuple(
            joint(f"j_{kind}", kind, f"l_{index}", f"l_{index + 1}", axis_2=Y)
            if kind == "universal"
            else joint(f"j_{kind}", kind, f"l_{index}", f"l_{index + 1}")
            for index, kind in enumerate(kinds)
        ),
        independent_joints=("j_revolute", "j_prismatic"),
    )
    again = read(to_urdf(description))
    assert again == description
    mechanism = cd.load(to_urdf(description))
    assert [mechanism.joints[f"j_{kind}"].nv for kind in kinds[1:]] == [1, 1, 1, 3, 6, 3, 2, 2]


def test_loops_of_all_types() -> None:
    tree = (joint("a", "floating", "ground", "body"),)
    kinds = ("revolute", "continuous", "prismatic", "fixed", "planar", "spherical", "cylindrical")
    shifted = np.eye(4)
    shifted[:3, 3] = 0.1, 0.2, 0.3
    loops = tuple(
        LoopDescription(f"l_{kind}", kind, "body", "ground", shifted, np.eye(4), Y, Y)
        for kind in kinds
    )
    loops += (LoopDescription("u", "universal", "ground", "body", np.eye(4), shifted, Y, Z),)
    description = plain(tree, loops=loops)
    assert read(to_urdf(description)) == description


def test_names_with_the_characters_of_xml() -> None:
    name = 'a<b>&"c"\n\té'
    description = plain((joint(name, "fixed", "x & y", "<z>"),))
    assert read(to_urdf(description)) == description


TIPS = """<robot name="tips"><link name="ground"/><link name="one"/><link name="two"/>
<link name="tip"/><joint name="a" type="continuous"><parent link="ground"/><child link="one"/>
</joint><joint name="b" type="continuous"><parent link="one"/><child link="two"/></joint>
<joint name="c" type="fixed"><parent link="two"/><child link="tip"/></joint></robot>"""


def test_drives_of_gepetto_keep_their_order(tmp_path: Path) -> None:
    """Positions of several drives are given in this order."""
    (tmp_path / "tips.urdf").write_text(TIPS, encoding="utf-8")
    (tmp_path / "tips.yaml").write_text(
        "closed_loop: [[tip, ground]]\ntype: [3d]\nname_mot: [b, a]\n"
        "joint_name: [c]\njoint_type: [spherical]",
        encoding="utf-8",
    )
    description = read(tmp_path / "tips.urdf")
    again = read(to_urdf(description))
    assert again.independent_joints == description.independent_joints == ("b", "a")
    assert [item.name for item in again.joints] == ["b", "a", "c"]
    by_name = {item.name: item for item in again.joints}
    assert replace(again, joints=tuple(by_name[name] for name in "abc")) == description
    assert by_name["c"].type == "spherical"


BAD = {
    "type": (plain((joint("j", "helical", "a", "b"),)), "joint 'j': type 'helical' cannot be"),
    "loop type": (
        plain(
            (joint("j", "fixed", "a", "b"),),
            loops=(LoopDescription("l", "floating", "a", "b", np.eye(4), np.eye(4), X, X),),
        ),
        "loop 'l': type 'floating' cannot be written; types: continuous",
    ),
    "reflection": (
        plain((joint("j", "fixed", "a", "b", origin=np.diag([1.0, 1.0, -1.0, 1.0])),)),
        "joint 'j': .* is no rotation",
    ),
    "limits": (
        plain((joint("j", "continuous", "a", "b", limits=Limits(-1.0)),)),
        "joint 'j': a continuous joint has no limits of position",
    ),
    "drive": (
        plain((joint("j", "fixed", "a", "b"),), independent_joints=("k",)),
        "independent joint 'k' is no joint of the tree; joints: j",
    ),
}


@pytest.mark.parametrize(("description", "message"), BAD.values(), ids=BAD.keys())
def test_what_cannot_be_written(description: Description, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        to_urdf(description)


@pytest.mark.parametrize(
    ("mass", "moment", "message"),
    [(1.0, 5.0, "triangle inequality"), (0.0, 1.0, "mass 0 kg is not positive")],
)
def test_inertias_that_no_body_can_have_stay(mass: float, moment: float, message: str) -> None:
    link = LinkDescription("b", mass, X, np.diag([1.0, 1.0, moment]))
    description = replace(
        plain((joint("j", "fixed", "a", "b"),)), links=(LinkDescription("a"), link)
    )
    with pytest.raises(cd.ModelError, match=message):
        read(to_urdf(description))
    assert read(to_urdf(description), strict=False) == description


RIGHT = [0.0, np.pi / 2, -np.pi / 2, np.pi, 1e-9, np.pi / 2 - 1e-9]
ANGLES = st.one_of(st.sampled_from(RIGHT), st.floats(-4.0, 4.0))


@pytest.mark.slow
@settings(max_examples=300, derandomize=True, deadline=None)
@given(roll=ANGLES, pitch=ANGLES, yaw=ANGLES)
def test_angles_of_any_rotation(roll: float, pitch: float, yaw: float) -> None:
    """Also where pitch is a right angle, and roll and yaw turn about the same axis."""
    turn = pin.rpy.rpyToMatrix(roll, pitch, yaw)
    np.testing.assert_allclose(pin.rpy.rpyToMatrix(*angles_of(turn)), turn, atol=1e-15)


def test_links_at_joints_by_hand() -> None:
    """The link stands 1 m beside its joint, a quarter turn about z."""
    quarter = np.array([[0.0, -1.0, 0.0, 1.0], [1.0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    ahead = np.eye(4)
    ahead[:3, 3] = 0.0, 2.0, 0.0
    description = plain(
        (
            joint("j", "revolute", "a", "b", child_placement=quarter),
            joint("k", "revolute", "b", "c", origin=ahead),
        ),
        loops=(LoopDescription("l", "spherical", "a", "b", np.eye(4), ahead, X, X),),
    )
    link = LinkDescription("b", 2.0, np.array([0.5, 0.0, 0.0]), np.diag([1.0, 2.0, 2.5]))
    description = replace(description, links=(description.links[0], link, description.links[2]))
    moved = with_links_at_joints(description)
    np.testing.assert_array_equal(moved.links[1].centre, [1.0, 0.5, 0.0])
    np.testing.assert_array_equal(moved.links[1].inertia, np.diag([2.0, 1.0, 2.5]))
    np.testing.assert_array_equal(moved.joints[1].origin[:3, 3], [-1.0, 0.0, 0.0])
    np.testing.assert_array_equal(moved.loops[0].successor_origin[:3, 3], [-1.0, 0.0, 0.0])
    np.testing.assert_array_equal(moved.joints[0].child_placement, np.eye(4))
    assert moved.links[2] is description.links[2]
    assert with_links_at_joints(moved) is moved


@pytest.mark.parametrize("upright", [0.0, 1e-17, 1e-14, 3e-10, 1e-8, 1e-3, 1.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_angles_of_a_rounded_rotation_however_upright(side: float, upright: float) -> None:
    rotation = pin.rpy.rpyToMatrix(0.7, side * (0.5 * np.pi - upright), -1.9)
    rotation += 1e-16 * np.arange(9.0).reshape(3, 3)  # As products of rotations are rounded.
    assert np.abs(pin.rpy.rpyToMatrix(*angles_of(rotation)) - rotation).max() < 5e-15
