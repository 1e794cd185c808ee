"""Bodies of MJCF become links and joints: against Pinocchio's reader and MuJoCo's numbers."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from testkit.mjcf import INERTIAL, of_body, placed

import cardan_dyn as cd
from cardan_dyn.core.description.read import read

BALL = '<geom size="1"/>'
HEAD = '<mujoco><compiler angle="{angle}" eulerseq="{sequence}"/>'
TREE = (
    HEAD
    + """<default><geom density="500"/><joint axis="0 1 0"/><default class="k">
<joint type="slide"/></default></default><worldbody><body name="base">
<body name="one" pos="0.1 0.2 0.3" {turned}><joint name="a" axis="1 2 2" pos="0.3 0.1 0.2"/>
  <inertial pos="0.1 0 0" mass="2" {inertia}/>
  <body name="two" pos="0 0 1"><joint name="b" class="k" axis="0 3 4"/>{geoms}
    <body name="three" pos="0.5 0 0"><joint name="c" range="-30 60" pos="0 0 -0.4"/>
      <geom type="{shape}" size="{size}"/></body></body></body></body></worldbody></mujoco>"""
)
PLAIN = {
    "angle": "degree",
    "sequence": "xyz",
    "turned": 'euler="30 40 50"',
    "inertia": 'diaginertia="1 1.2 1.3"',
    "geoms": '<geom size="0.1"/>',
    "shape": "sphere",
    "size": "0.1",
}
# What Pinocchio's reader gets wrong is not here, but in MuJoCo's numbers below: capital letters
# of eulerseq, an axisangle whose axis is not of length 1, the pos of a joint's class.
CASES = [
    {},
    *({"turned": turned} for turned in ("", 'quat="1 2 3 4"', 'xyaxes="1 1 0 -1 2 1"')),
    *({"turned": turned} for turned in ('axisangle="0 .6 .8 40"', 'zaxis="1 2 3"')),
    {"turned": 'zaxis="0 0 -1"'},
    {"turned": 'euler=".3 .4 .5"', "angle": "radian"},
    *({"sequence": sequence} for sequence in ("zyx", "zxz")),
    {"inertia": 'fullinertia="1 1.2 1.3 .1 .2 .05"'},
    {"inertia": 'diaginertia="1 1.2 1.3" quat="1 2 3 4"'},
    *({"shape": shape, "size": ".1 .3"} for shape in ("capsule", "cylinder")),
    *({"shape": shape, "size": ".1 .2 .3"} for shape in ("box", "ellipsoid")),
    *(
        {"geoms": f'<geom type="{shape}" size=".1" fromto="0 0 0 1 1 1"/>'}
        for shape in ("capsule", "cylinder", "box", "ellipsoid")
    ),
    {
        "geoms": '<geom type="box" size=".1 .2 .3" pos="1 0 0" euler="10 20 30" mass="2"/>'
        '<geom size=".3" pos="0 1 0" density="300"/>'
    },
]


@pytest.mark.parametrize("changes", CASES, ids=lambda case: " ".join(case.values()))
def test_against_pinocchios_reader(tmp_path: Path, changes: dict[str, str]) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(TREE.format(**PLAIN | changes), encoding="utf-8")
    theirs = pin.buildModelAndLegacyConstraintsFromMJCF(str(path))[0]
    ours = cd.load(path).model
    assert list(ours.names) == list(theirs.names)
    results = []
    for model in (theirs, ours):
        q = pin.integrate(model, pin.neutral(model), np.array([0.3, 0.2, 0.4]))
        data = model.createData()
        mass = np.triu(pin.crba(model, data, q))
        pin.framesForwardKinematics(model, data, q)
        frames = [model.getFrameId(name, pin.FrameType.BODY) for name in ("one", "two", "three")]
        results.append((mass, *(data.oMf[frame].homogeneous for frame in frames)))
    for expected, found in zip(*results, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-14 * np.max(np.abs(expected)))


RICH = """<mujoco><compiler eulerseq="xYz" inertiagrouprange="0 2"/>
<default><geom density="500"/><default class="a"><joint pos="0.1 0.2 0.3" axis="1 2 2"/>
  <geom type="box" size="0.3 0.2 0.1" euler="10 20 30"/>
  <default class="b"><geom type="cylinder" quat="1 2 3 4"/></default></default></default>
<worldbody><frame pos="1 2 3" axisangle="1 1 0 40">
<body name="one" pos="0.5 0 0" euler="30 40 50" childclass="a"><joint name="j_1"/>
  <frame pos="0 1 0" zaxis="1 2 3"><joint name="j_2" type="slide"/><geom size="0.5" group="1"/>
    <geom class="b" pos="0 0 1" mass="40"/><geom group="3"/></frame>
  <body name="two" pos="0 0 1" xyaxes="1 1 0 -1 2 1">
    <joint name="j_3" pos="0 0 0" axis="0 1 0" ref="30" range="0 90"/>
    <joint name="j_4" axis="0 0 1"/>
    <geom type="capsule" class="main" size="0.1" fromto="0 0 0 1 1 1"/>
    <geom type="ellipsoid" euler="0 0 0" pos="0 0 1"/></body></body></frame>
<body name="three" zaxis="0 0 -1"><joint name="j_5" pos="1 0 0"/>
  <inertial pos="0 1 0" quat="1 2 0 1" mass="3" diaginertia="1 2 2.5"/></body>
</worldbody></mujoco>"""
COORDINATES = {"j_1": 0.3, "j_2": -0.2, "j_3": 0.5, "j_4": 0.4, "j_5": -0.6}
# From MuJoCo 4.0 at these coordinates beyond qpos0: xpos, xquat, body_mass, body_ipos, and the
# inertia about the centre in the body's axes (xx yy zz xy xz yz).
MUJOCO = {
    "one": (
        (1.36368761045, 1.99555374389, 2.60045229539),
        (0.57883187346, 0.653643857725, 0.333408319342, 0.355727792165),
        80.0,
        (0.133630620956, 1.26726124191, 0.400891862869),
        (22.3551353315, 19.1963291952, 11.11520214, -3.10232073433, -2.90352971727, -8.13876577091),
    ),
    "two": (
        (2.20505273761, 1.54220848891, 2.58215367227),
        (0.0345282519414, 0.678702711997, 0.0949567393109, 0.727429478509),
        41.8677561803,
        (0.349927823213, 0.349927823213, 0.650072176787),
        (
            *(10.2944398995, 10.4201036057, 10.4955018294),
            *(-5.01218183033, -0.614859115562, -0.614859115562),
        ),
    ),
    "three": (
        (0.17466438509, -0.564642473395, 0.0),
        (0.0, 0.955336489126, 0.295520206661, 0.0),
        3.0,
        (0.0, 1.0, 0.0),
        (
            *(1.77777777778, 2.11111111111, 1.61111111111),
            *(-0.444444444444, -0.555555555556, -0.111111111111),
        ),
    ),
}


def test_against_mujoco() -> None:
    placements = placed(cd.load(RICH), COORDINATES)
    description = read(RICH)
    links = {link.name: link for link in description.links}
    for name, (position, quaternion, mass, centre, inertia) in MUJOCO.items():
        turn = pin.Quaternion(np.array([*quaternion[1:], quaternion[0]])).matrix()
        np.testing.assert_allclose(placements[name].translation, position, atol=1e-11)
        np.testing.assert_allclose(placements[name].rotation, turn, atol=1e-11)
        tensor = links[name].inertia
        entries = [*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        assert links[name].mass == pytest.approx(mass, rel=1e-11)
        np.testing.assert_allclose(links[name].centre, centre, atol=1e-11)
        np.testing.assert_allclose(entries, inertia, atol=1e-10)
    assert description.order == ("j_1", "j_2", "j_3", "j_4", "j_5")
    assert description.notation == "no loops"
    joints = {joint.name: joint for joint in description.joints}
    assert [joints[name].type for name in ("j_1", "j_2", "j_3")] == [
        *("continuous", "prismatic", "revolute"),
    ]
    # The range counts from ref, our coordinate from the initial configuration.
    limits = joints["j_3"].limits
    assert np.rad2deg([limits.lower, limits.upper]) == pytest.approx([-30.0, 60.0])
    shifted, limited = description.warnings
    assert "zero where the file counts 30 (ref)" in shifted
    assert "limits of 1 joint (j_3): they hold" in limited


def test_what_flags_switch_off_does_not_act() -> None:
    joint = '<joint name="j" type="slide" damping="2" frictionloss="3" stiffness="4"/>'
    text = (
        "<mujoco><option><flag {}/></option><worldbody><body>"
        f'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{joint}</body></worldbody></mujoco>'
    )
    whole = cd.load(text.replace("{}", 'contact="disable"')).description.joints[0].dynamics
    assert whole[:3] == (2.0, 3.0, 4.0)
    for flag, kept in (
        ("damper", (0.0, 3.0, 4.0)),
        ("frictionloss", (2.0, 0.0, 4.0)),
        ("spring", (2.0, 3.0, 0.0)),
    ):
        found = cd.load(text.replace("{}", f'{flag}="disable"'))
        assert found.description.joints[0].dynamics[:3] == kept
    without = cd.load(text.replace("{}", 'constraint="disable"'))
    assert without.description.joints[0].dynamics[:3] == (2.0, 0.0, 4.0)


def test_names() -> None:
    """What has no name gets one that nothing else has; a joint may be named like Pinocchio's."""
    text = """<mujoco model="names"><worldbody>
<body name="body_2"><joint name="universe"/><geom size="1"/>
  <body><joint name="joint_3"/><joint/><joint name="world"/><geom size="1"/></body>
  <body name="body_3"><joint/><geom size="1"/></body></body>
<body><freejoint/></body><body/></worldbody></mujoco>"""
    description = read(text)
    assert description.name == "names"
    assert [link.name for link in description.links] == [
        *("world", "body_2", "body_2_2_1", "body_2_2_2", "body_2_2", "body_3", "body_4", "body_5"),
    ]
    assert description.order == (
        *("universe", "joint_3", "joint_3_2", "world", "joint_5", "joint_6", "body_5_fixed"),
    )
    assert [joint.type for joint in description.joints][-2:] == ["floating", "fixed"]
    mechanism = cd.load(text)
    assert list(mechanism.joints)[:4] == ["universe", "joint_3", "joint_3_2", "world"]


def test_what_stands_in_the_world_needs_no_mass() -> None:
    mocap = of_body("").replace("<body ", '<body mocap="true" ')
    assert read(mocap).links[-1].mass == 0.0
    assert "it stands still" in read(mocap).warnings[0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body('<joint name="j"/><joint name="j"/>'), "repeated name 'j' in joint"),
        (of_body('<body name="b"/>'), "repeated name 'b' in body"),
        (of_body('<site name="s"/><site name="s"/>'), "repeated name 's' in site"),
        (of_body("<freejoint/><joint/>"), "more than 6 dofs"),
        (of_body("<joint/><body><freejoint/></body>"), "free joint can only be used on top level"),
        (of_body('<joint/><body mocap="true"/>'), "mocap body"),
        (of_body(INERTIAL.format("1 1 1") * 2), "unique element 'inertial' found 2 times"),
        ("<mujoco><worldbody><joint/></worldbody></mujoco>", "World body cannot have joints"),
        (of_body('<joint class="x"/>'), "unknown default class name 'x'"),
        (of_body('<joint axes="0 0 1"/>'), "unrecognized attribute: 'axes'"),
    ],
)
def test_refused(text: str, message: str) -> None:
    """The message is MuJoCo's, and says where."""
    with pytest.raises(cd.ModelError, match=f"^MJCF text: MuJoCo: .*{message}.*line 1"):
        read(text)


def test_copies_are_read() -> None:
    """MuJoCo makes them, and their names."""
    ball = f'<body name="b"><joint name="j"/>{INERTIAL.format("1 1 1")}</body>'
    copies = f'<replicate count="3" offset="1 0 0">{ball}</replicate>'
    description = read(f"<mujoco><worldbody>{copies}</worldbody></mujoco>")
    assert [link.name for link in description.links] == ["world", "b0", "b1", "b2"]
    assert [joint.origin[0, 3] for joint in description.joints] == [0.0, 1.0, 2.0]


def test_without_mujoco_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(cd.CardanError, match=r'pip install "cardan-dyn\[mjcf\]"'):
        cd.load(of_body("<joint/>" + INERTIAL.format("1 1 1")))


def test_names_of_files_without_a_name() -> None:
    assert read("<mujoco/>").name == "mechanism"
    assert [link.name for link in read("<mujoco/>").links] == ["world"]
    assert read('<mujoco model="m"/>').name == "m"


def test_several_joints_of_a_body_have_massless_links_between_them() -> None:
    description = read(
        of_body(
            '<joint name="u" type="slide"/><joint name="v"/><joint name="w" type="ball"/>'
            '<inertial pos="1 0 0" mass="2" diaginertia="1 1 1"/>'
        )
    )
    assert [(link.name, link.mass) for link in description.links] == [
        ("world", 0.0),
        ("b_1", 0.0),
        ("b_2", 0.0),
        ("b", 2.0),
    ]
    assert [(joint.name, joint.parent, joint.child) for joint in description.joints] == [
        ("u", "world", "b_1"),
        ("v", "b_1", "b_2"),
        ("w", "b_2", "b"),
    ]


def test_frames_place_what_is_in_them_and_choose_its_class() -> None:
    """Frames in frames add up; the body's own class counts before that of a frame around it."""
    text = """<mujoco><default><default class="k"><joint axis="1 0 0"/></default>
    <default class="l"><joint axis="0 1 0"/></default></default><worldbody>
    <frame pos="1 0 0" childclass="k"><frame pos="0 2 0" euler="0 0 90">
    <body name="a" pos="0 0 3"><joint name="u"/></body>
    <body name="b" pos="1 0 0" childclass="l"><joint name="v"/></body></frame></frame>
    <body name="c"><joint name="w"/></body></worldbody></mujoco>"""
    joints = {joint.name: joint for joint in read(text).joints}
    np.testing.assert_allclose(joints["u"].origin[:3, 3], [1.0, 2.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(joints["v"].origin[:3, 3], [1.0, 3.0, 0.0], atol=1e-15)
    for name, axis in (("u", [1, 0, 0]), ("v", [0, 1, 0]), ("w", [0, 0, 1])):
        np.testing.assert_array_equal(joints[name].axis, axis)
    quarter = pin.rpy.rpyToMatrix(0.0, 0.0, np.pi / 2)
    np.testing.assert_allclose(joints["u"].origin[:3, :3], quarter, atol=1e-15)


def test_a_total_mass_is_shared_among_all_bodies() -> None:
    """Those that stand in the world have a mass as well, which no motion shows."""
    ball = '<geom size="1" mass="{}"/>'
    text = (
        f'<mujoco><compiler settotalmass="8"/><worldbody><body name="a">{ball.format(1)}</body>'
        f'<body name="b"><joint/>{ball.format(3)}</body></worldbody></mujoco>'
    )
    assert [link.mass for link in read(text).links] == [0.0, 2.0, 6.0]
    text = text.replace('<compiler settotalmass="8"/>', "")
    assert [link.mass for link in read(text).links] == [0.0, 1.0, 3.0]
