"""MJCF, read by this package: against Pinocchio's reader, MuJoCo's numbers and closed formulas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from testkit.linkages import POSITIONS, RATES, four_bar, loop
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn.description.description import LoopDescription
from cardan_dyn.description.read import read

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
    found = []
    for model in (theirs, ours):
        q = pin.integrate(model, pin.neutral(model), np.array([0.3, 0.2, 0.4]))
        data = model.createData()
        mass = np.triu(pin.crba(model, data, q))
        pin.framesForwardKinematics(model, data, q)
        frames = [model.getFrameId(name, pin.FrameType.BODY) for name in ("one", "two", "three")]
        found.append((mass, *(data.oMf[frame].homogeneous for frame in frames)))
    for expected, own in zip(*found, strict=True):
        np.testing.assert_allclose(own, expected, atol=1e-14 * np.max(np.abs(expected)))


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


def placed(mechanism: cd.Mechanism, coordinates: dict[str, float]) -> dict[str, pin.SE3]:
    """Return the placements of all links in the world."""
    model = mechanism.model
    step = np.zeros(model.nv)
    for name, value in coordinates.items():
        step[model.idx_vs[mechanism.joints[name].id]] = value
    data = model.createData()
    pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), step))
    return {name: data.oMi[body] * place for name, (body, place) in mechanism.links.items()}


def test_against_mujoco() -> None:
    places = placed(cd.load(RICH), COORDINATES)
    description = read(RICH)
    links = {link.name: link for link in description.links}
    for name, (position, quaternion, mass, centre, inertia) in MUJOCO.items():
        turn = pin.Quaternion(np.array([*quaternion[1:], quaternion[0]])).matrix()
        np.testing.assert_allclose(places[name].translation, position, atol=1e-11)
        np.testing.assert_allclose(places[name].rotation, turn, atol=1e-11)
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
    assert len(description.warnings) == 1
    assert "zero where the file counts 30 (ref)" in description.warnings[0]


BODY = '<mujoco>{head}<worldbody><body name="b">{body}</body></worldbody>{tail}</mujoco>'


def of_body(body: str, head: str = "", tail: str = "") -> str:
    return BODY.format(body=body, head=head, tail=tail)


def link_of(text: str, strict: bool = True) -> tuple[float, list[float], np.ndarray]:
    link = read(text, strict).links[-1]
    return link.mass, link.centre.tolist(), link.inertia


@pytest.mark.parametrize(
    ("shape", "volume", "moments"),
    [
        ('type="sphere" size=".3"', 4 / 3 * np.pi * 0.027, [0.036] * 3),
        ('type="box" size="1 2 3"', 48.0, [13 / 3, 10 / 3, 5 / 3]),
        ('type="ellipsoid" size="1 2 3"', 8 * np.pi, [13 / 5, 10 / 5, 5 / 5]),
        (
            'type="cylinder" size="1 2"',
            4 * np.pi,
            [(3 + 16) / 12, (3 + 16) / 12, 1 / 2],
        ),
    ],
)
def test_solids(shape: str, volume: float, moments: list[float]) -> None:
    mass, centre, inertia = link_of(of_body(f'<joint/><geom {shape} pos="1 2 3"/>'))
    assert mass == pytest.approx(1000.0 * volume, rel=1e-14)
    assert centre == [1.0, 2.0, 3.0]
    np.testing.assert_allclose(inertia, mass * np.diag(moments), atol=1e-13 * mass)


def test_a_capsule_by_integration() -> None:
    """Slices along its axis: discs of the radius r(z)."""
    radius, half = 0.4, 0.7
    nodes, weights = np.polynomial.legendre.leggauss(20)
    area, across, along = 0.0, 0.0, 0.0
    for low, high, cap in ((0.0, half, False), (half, half + radius, True)):
        z = low + 0.5 * (high - low) * (nodes + 1.0)
        w = (high - low) * weights  # of both halves
        square = radius**2 - (z - half) ** 2 if cap else np.full_like(z, radius**2)
        area += np.sum(w * np.pi * square)
        along += np.sum(w * np.pi * square**2 / 2.0)
        across += np.sum(w * np.pi * (square**2 / 4.0 + square * z**2))
    text = of_body(f'<joint/><geom type="capsule" size="{radius} {half}" density="1"/>')
    mass, _, inertia = link_of(text)
    assert mass == pytest.approx(area, rel=1e-13)
    np.testing.assert_allclose(inertia, np.diag([across, across, along]), atol=1e-13)


INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="{}"/>'
BALL = '<geom size="1" mass="5"/>'


@pytest.mark.parametrize(
    ("compiler", "content", "mass", "moments"),
    [
        ("", INERTIAL.format("1 2 3") + BALL, 1.0, [1, 2, 3]),
        ('inertiafromgeom="true"', INERTIAL.format("1 2 3") + BALL, 5.0, [2, 2, 2]),
        ('inertiafromgeom="true"', INERTIAL.format("1 2 3"), 1.0, [1, 2, 3]),
        ('inertiafromgeom="false"', BALL, 0.0, [0, 0, 0]),
        ('inertiagrouprange="1 2"', BALL, 0.0, [0, 0, 0]),
        ("", '<geom size="1" mass="0"/><geom type="mesh" mass="0"/>', 0.0, [0, 0, 0]),
        ("", "", 0.0, [0, 0, 0]),
        # As MuJoCo 4.0 has them.
        ('balanceinertia="true"', INERTIAL.format("1 1 5"), 1.0, [7 / 3] * 3),
        ('boundmass="3" boundinertia="2"', "", 3.0, [2, 2, 2]),
        (
            'balanceinertia="true" boundmass="3" boundinertia="2"',
            INERTIAL.format(".1 .1 5"),
            3.0,
            [3, 3, 3],
        ),
        ('settotalmass="7"', INERTIAL.format("1 2 3"), 7.0, [7, 14, 21]),
    ],
)
def test_what_the_compiler_makes_of_masses(
    compiler: str, content: str, mass: float, moments: list[float]
) -> None:
    found = link_of(of_body("<joint/>" + content, head=f"<compiler {compiler}/>"))
    assert found[0] == mass
    np.testing.assert_allclose(found[2], np.diag(moments), atol=1e-14)


def test_inertias_that_no_body_can_have() -> None:
    text = of_body("<joint/>" + INERTIAL.format("1 1 5"))
    with pytest.raises(cd.ModelError, match=r"body 'b': principal moments 1, 1, 5 .*strict=False"):
        read(text)
    assert "violate the triangle inequality" in read(text, strict=False).warnings[0]


def test_names() -> None:
    """What has no name gets one that nothing else has; a joint may be named like Pinocchio's."""
    text = """<mujoco model="names"><worldbody>
<body name="world"><joint name="universe"/><geom size="1"/>
  <body><joint name="joint_3"/><joint/><joint name="world"/><geom size="1"/></body>
  <body name="body_3"><joint/><geom size="1"/></body></body>
<body><body><freejoint/></body></body></worldbody></mujoco>"""
    with pytest.raises(cd.ModelError, match="a free joint is the only joint of a body in <world"):
        read(text)
    text = text.replace(
        "<body><body><freejoint/></body></body>", "<body><freejoint/></body><body/>"
    )
    description = read(text)
    assert description.name == "names"
    assert [link.name for link in description.links] == [
        *("world_2", "world", "body_2_1", "body_2_2", "body_2", "body_3", "body_4", "body_5"),
    ]
    assert description.order == (
        *("universe", "joint_3", "joint_3_2", "world", "joint_5", "joint_6", "body_5_fixed"),
    )
    assert [joint.type for joint in description.joints][-2:] == ["floating", "fixed"]
    mechanism = cd.load(text)
    assert list(mechanism.joints)[:4] == ["universe", "joint_3", "joint_3_2", "world"]


HALVES = """<mujoco model="four_bar"><compiler angle="radian"/><worldbody>
<body name="crank"><inertial pos="0 0.25 0" mass="1" diaginertia="0.02 0.03 0.025"/>
  <joint name="a" axis="0 0 1"/><body name="coupler" pos="0 0.5 0"><site name="s_1" pos="2 2 0"/>
    <inertial pos="1 1 0" mass="2" diaginertia="0.02 0.03 0.025"/><joint name="b"/></body></body>
{rocker}</worldbody>{more}</mujoco>"""
ROCKER = """<body name="rocker" pos="2 0 0"><joint name="d" axis="0 0 1"/>
<inertial pos="0 1.25 0" mass="3" diaginertia="0.02 0.03 0.025"/>
<site name="s_2" pos="0 2.5 0" euler="0.3 0 0.4"/></body>"""
CONNECTS = {
    "bodies": '<connect name="c" body1="coupler" body2="rocker" anchor="2 2 0"/>',
    "swapped": '<connect name="c" body1="rocker" body2="coupler" anchor="0 2.5 0"/>',
    "sites": '<connect name="c" site1="s_1" site2="s_2"/>',
}


def same_as_urdf(mechanism: cd.Mechanism, sign: float = 1.0, kind: str = "spherical") -> None:
    found, reference = (
        cd.Scene(item, drive="a", loads={"d": -3.0}).sweep(POSITIONS, **RATES)
        for item in (mechanism, cd.load(four_bar(loop(kind))))
    )
    assert relative(found.drive_effort, reference.drive_effort) < 1e-12
    for name in "abcd":
        force = reference.wrench(name, "world").force[:, :2] * (sign if name == "c" else 1.0)
        assert relative(found.wrench(name, "world").force[:, :2], force) < 1e-11


@pytest.mark.parametrize("kind", CONNECTS)
def test_connect(kind: str) -> None:
    text = HALVES.format(rocker=ROCKER, more=f"<equality>{CONNECTS[kind]}</equality>")
    mechanism = cd.load(text)
    assert mechanism.notation == "MJCF <equality>"
    same_as_urdf(mechanism, -1.0 if kind == "swapped" else 1.0)


def test_a_pin_welded_to_a_link_is_a_hinge() -> None:
    """The pin turns on the coupler and is welded to the rocker: joint c is its hinge."""
    axle = '<body name="pin" pos="2 2 0"><joint name="c"/></body>'
    text = HALVES.format(
        rocker=ROCKER, more='<equality><weld name="w" body1="pin" body2="rocker"/></equality>'
    ).replace('<joint name="b"/>', f'<joint name="b"/>{axle}')
    same_as_urdf(cd.load(text), kind="continuous")


def test_includes(tmp_path: Path) -> None:
    equality = f"<equality>{CONNECTS['bodies']}</equality>"
    (tmp_path / "parts").mkdir()
    (tmp_path / "main.xml").write_text(
        HALVES.format(rocker='<include file="parts/rocker.xml"/>', more='<include file="e.xml"/>')
    )
    (tmp_path / "parts" / "rocker.xml").write_text('<x><include file="inner.xml"/></x>')
    (tmp_path / "parts" / "inner.xml").write_text(f"<mujocoinclude>{ROCKER}</mujocoinclude>")
    (tmp_path / "e.xml").write_text(f"<mujoco>{equality}</mujoco>")
    same_as_urdf(cd.load(tmp_path / "main.xml"))
    # Beside the main file comes before beside the including one, as in MuJoCo.
    (tmp_path / "inner.xml").write_text("<x><body name='other'/></x>")
    with pytest.raises(cd.ModelError, match=r"body2 'rocker' does not exist; names: .*other"):
        cd.load(tmp_path / "main.xml")
    for content, message in (
        ('<x><include file="parts/rocker.xml"/></x>', "is included twice, or includes itself"),
        ('<x><include file="main.xml"/></x>', "is included twice, or includes itself"),
        ('<x><include file="nowhere.xml"/></x>', "there is no file .*nowhere.xml"),
        ("<x><include/></x>", 'an <include> needs file="..."'),
        ('<x><include file="e.xml"><y/></include></x>', "it has elements of its own"),
        ("<x>", "malformed XML"),
        ("<x>\0</x>", "malformed XML"),
    ):
        (tmp_path / "inner.xml").write_text(content)
        (tmp_path / "parts" / "inner.xml").write_text(content)
        with pytest.raises(cd.ModelError, match=message):
            cd.load(tmp_path / "main.xml")
    with pytest.raises(cd.ModelError, match=r"text has no directory .*load the file by its path"):
        read('<mujoco><include file="a.xml"/></mujoco>')


def test_inactive_equalities_are_left_out() -> None:
    off = '<default><equality active="false"/></default>'
    both = f"<equality>{CONNECTS['sites']}<connect body1='crank' anchor='0 0 0' /></equality>"
    text = HALVES.format(rocker=ROCKER, more=off + both)
    assert read(text).loops == ()
    assert read(text).notation == "no loops"
    assert [remark.split(": ", 1)[1] for remark in read(text).warnings] == [
        "<equality> <connect> 'c': left out, as it is not active",
        "<equality> <connect> 2: left out, as it is not active",
    ]
    (found,) = read(text.replace("anchor='0 0 0'", "anchor='0 0 0' active='true'")).loops
    assert (found.name, found.predecessor, found.successor) == ("equality_2", "crank", "world")
    flagged = text.replace(off, '<option><flag equality="disable"/></option>')
    assert read(flagged).loops == ()


TWO = """<mujoco><worldbody>
<body name="b1" pos="0 0 1" euler="0 0 30"><joint name="e"/>
  <site name="s1" pos=".1 .2 .3" euler="10 20 30"/></body>
<body name="b2" pos="1 0 0" euler="40 0 0"><joint/>
  <site name="s2" pos=".4 .2 .3" euler="10 20 70"/></body>
</worldbody><equality>{}</equality></mujoco>"""


def ends(equality: str) -> tuple[LoopDescription, np.ndarray, np.ndarray]:
    """Return a loop, and both placements of its frame in the world, initially."""
    (found,) = read(TWO.format(equality)).loops
    places = placed(cd.load(TWO.format("")), {})
    return (
        found,
        places[found.predecessor].homogeneous @ found.predecessor_origin,
        places[found.successor].homogeneous @ found.successor_origin,
    )


@pytest.mark.parametrize(
    ("equality", "first", "second"),
    [
        # eq_data of MuJoCo 4.0: points in the bodies that coincide.
        ('<connect body1="b1" body2="b2" anchor="1 2 3"/>', (1, 2, 3), (-1.13397, 4.281, 1.62944)),
        ('<connect body1="b1" anchor="1 2 3"/>', (1, 2, 3), (-0.13397, 2.23205, 4)),
        ('<connect body1="world" body2="b1" anchor="1 2 3"/>', (1, 2, 3), (1.86603, 1.23205, 2)),
        ('<connect site1="s1" site2="s2"/>', (0.1, 0.2, 0.3), (0.4, 0.2, 0.3)),
        ('<weld body1="b1" body2="b2"/>', (0.86603, -0.5, -1), (0, 0, 0)),
        (
            '<weld body1="b1" body2="b2" anchor=".1 .2 .3" relpose="5 6 7 0 0 0 0"/>',
            (0.93281, -0.58432, -0.64163),
            (0.1, 0.2, 0.3),
        ),
        ('<weld body1="b1" body2="b2" relpose=".5 .6 .7 1 .1 0 0"/>', (0.5, 0.6, 0.7), (0, 0, 0)),
        (
            '<weld body1="b1" body2="b2" anchor=".1 .2 .3" relpose=".5 .6 .7 1 .1 0 0"/>',
            (0.5, 0.6, 0.7),
            (0.1, 0.2, 0.3),
        ),
        ('<weld body1="b1"/>', (0, 0, -1), (0, 0, 0)),
        ('<weld site1="s1" site2="s2"/>', (0.1, 0.2, 0.3), (0.4, 0.2, 0.3)),
    ],
)
def test_where_equalities_hold(
    equality: str, first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    found, predecessor, successor = ends(equality)
    assert found.type == ("spherical" if "connect" in equality else "fixed")
    np.testing.assert_allclose(found.predecessor_origin[:3, 3], first, atol=1e-5)
    np.testing.assert_allclose(found.successor_origin[:3, 3], second, atol=1e-5)
    if "connect" in equality or not ("relpose" in equality or "site" in equality):
        np.testing.assert_allclose(predecessor[:3, :3], successor[:3, :3], atol=1e-14)
    if "relpose" in equality and "0 0 0 0" not in equality:
        turn = pin.Quaternion(np.array([0.1, 0.0, 0.0, 1.0])).normalized().matrix()
        np.testing.assert_allclose(found.predecessor_origin[:3, :3], turn, atol=1e-14)
        np.testing.assert_array_equal(found.successor_origin[:3, :3], np.eye(3))


def test_equalities_are_named_apart_from_joints() -> None:
    connect = '<connect {} body1="b1" body2="b2" anchor="0 0 0"/>'
    named = [connect.format(f'name="{name}"') if name else connect.format("") for name in "eef"]
    text = TWO.format("".join([*named, connect.format(""), connect.format('name="equality_4"')]))
    assert [found.name for found in read(text).loops] == [
        *("e_2", "e_3", "f", "equality_4_2", "equality_4"),
    ]


def test_gears() -> None:
    gear = '<joint name="g" joint1="e" joint2="f" polycoef="0 -2.5 0 0 0"/>'
    wheels = TWO.replace("<joint/>", '<joint name="f"/>').replace('euler="40 0 0"', "")
    mass = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    mechanism = cd.load(wheels.format(gear).replace("<site", mass + "<site"))
    turn = cd.Scene(mechanism, drive="f").sweep([0.1, 0.2], acceleration=1.0)
    np.testing.assert_allclose(turn.motion.position("e"), [-0.25, -0.5], rtol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, 1.0 + 2.5**2, rtol=1e-13)
    for other in (
        gear.replace("0 -2.5 0", "0.1 -2.5 0"),
        gear.replace("0 -2.5 0", "0 -2.5 1"),
        gear.replace("-2.5", "0"),
        gear.replace('joint2="f"', ""),
        gear.replace('joint2="f"', 'joint2="e"'),
    ):
        with pytest.raises(cd.ModelError, match="<equality> <joint> is not supported but for gear"):
            read(wheels.format(other))
    slide = wheels.replace('name="f"', 'name="f" type="slide"')
    with pytest.raises(cd.ModelError, match="needs two hinges on the same body"):
        read(slide.format(gear))


FORCES = HALVES.format(
    rocker=ROCKER.replace('name="d"', 'name="d" stiffness="3"').replace(
        'name="rocker"', 'name="rocker" gravcomp="1"'
    ),
    more=f'<equality>{CONNECTS["bodies"]}</equality><default><joint damping="1 0"/>'
    '<tendon frictionloss="2"/></default><option density="1.2"/>'
    '<tendon><fixed name="t"><joint joint="a" coef="1"/></fixed></tendon>'
    '<actuator><motor joint="a" armature="0.1"/></actuator>',
)


def test_forces_that_wrenches_leave_out() -> None:
    with pytest.raises(cd.ModelError) as caught:
        read(FORCES)
    assert str(caught.value).split(": ", 1)[1] == (
        "forces that wrenches leave out: joint 'a': damping 1 0; joint 'b': damping 1 0; "
        "joint 'd': damping 1 0, stiffness 3; body 'rocker': gravcomp 1; option: density 1.2; "
        "tendon 't': frictionloss 2; actuator 'motor': armature 0.1; load(..., strict=False) "
        "accepts the file and leaves them out"
    )
    warnings = read(FORCES, strict=False).warnings
    assert len(warnings) == 7
    assert "joint 'd': damping 1 0, stiffness 3 left out of the wrenches" in warnings[2]
    same_as_urdf(cd.load(FORCES, strict=False))


def test_depth() -> None:
    def nested(count: int) -> str:
        bodies = "<body><joint/>" * count + "</body>" * count
        return f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"

    assert len(read(nested(297)).joints) == 297
    for count in (299, 5000):
        with pytest.raises(cd.ModelError, match="nested 301 elements deep; the limit is 300"):
            read(nested(count))
    with pytest.raises(cd.ModelError, match="the limit is 300"):
        read("<mujoco>" + "<default>" * 20000 + "</default>" * 20000 + "</mujoco>")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body("", head='<compiler coordinate="global"/>'), "coordinate 'global' is not"),
        (of_body("", head='<compiler angle="gon"/>'), "angle is 'gon', expected one of degree"),
        (of_body("", head='<compiler eulerseq="xyw"/>'), "eulerseq 'xyw' is not three letters"),
        (of_body("", head='<compiler eulersec="xyz"/>'), "<compiler> has no attribute eulersec"),
        (of_body("", head='<default class="a"/>'), "outermost <default> is class 'main'"),
        (of_body("", head="<default><default/></default>"), "needs a class name of its own"),
        (of_body("", head="<equalities/>"), "<equalities> in <mujoco> is unknown; elements: act"),
        (of_body("<replicate/>"), "body 'b': <replicate> is not supported: write the copies"),
        (of_body("<frame><attach/></frame>"), "frame '': <attach> is not supported"),
        (of_body("<flexcomp/>"), "<flexcomp> is not supported"),
        (of_body("<link/>"), "<link> in <body> is unknown; elements: body, camera"),
        (of_body('<joint axes="0 0 1"/>'), "<joint> has no attribute axes; attributes: actuator"),
        (of_body('<joint class="x"/>'), "default class 'x' does not exist; classes: main"),
        (of_body('<body childclass="x"/>'), "default class 'x' does not exist"),
        (of_body('<joint type="screw"/>'), "type is 'screw', expected one of hinge, slide"),
        (of_body('<joint axis="0 0 0"/>'), "axis: a vector of zeros has no direction"),
        (of_body('<joint pos="1 2"/>'), "'1 2' is not 3 finite"),
        (of_body('<joint pos="1,2,3"/>'), "is not 3 finite"),
        (of_body('<joint range="nan 1"/>'), "is not 2 finite"),
        (of_body('<joint limited="true"/>'), "range 0 0 does not ascend"),
        (of_body('<joint limited="1"/>'), "limited is '1', expected one of"),
        (
            of_body('<joint range="0 1"/>', head='<compiler autolimits="false"/>'),
            "without autolimits, a range needs limited=",
        ),
        (of_body('<joint name="j"/><joint name="j"/>'), "joint names that occur twice: j"),
        (of_body('<body name="b"/>'), "body names that occur twice: b"),
        (of_body('<site name="s"/><site name="s"/>'), "site 's': another site has this name"),
        (of_body("<freejoint/><joint/>"), "a free joint is the only joint"),
        (of_body('<joint/><body mocap="true"/>'), "a mocap body stands in the world"),
        (of_body('<body quat="0 0 0 0"/>'), "quat: a vector of zeros has no direction"),
        (of_body('<body quat="1 0 0 0" zaxis="1 0 0"/>'), "quat and zaxis both turn it"),
        (of_body('<body xyaxes="1 0 0 2 0 0"/>'), "xyaxes: both axes have the same direction"),
        (of_body('<inertial pos="0 0 0"/>'), 'mass="..." is missing'),
        (of_body('<inertial mass="1"/>'), 'pos="..." is missing'),
        (of_body('<inertial pos="0 0 0" mass="-1"/>'), "mass -1 kg is not positive"),
        (of_body('<inertial pos="0 0 0" mass="0" diaginertia="1 1 1"/>'), "needs a mass; load"),
        (
            of_body('<inertial pos="0 0 0" mass="1" quat="1 0 0 0" fullinertia="1 1 1 0 0 0"/>'),
            "fullinertia and quat exclude each other",
        ),
        (of_body(INERTIAL.format("1 1 1") * 2), "there are 2 <inertial>"),
        (of_body('<joint/><geom type="mesh" mesh="m"/>'), "of type 'mesh' is not .*<inertial>"),
        (of_body('<joint/><geom type="sdf" mesh="m"/>'), "of type 'sdf' is not computed here"),
        (of_body('<joint/><geom type="box" mesh="m"/>'), "of type 'box' fitted to a mesh"),
        (of_body('<joint/><geom size="1" shellinertia="true"/>'), "shellinertia is not supported"),
        (of_body('<joint/><geom size="1" density="-1"/>'), "mass or density is negative"),
        (of_body('<joint/><geom type="box" size="1 1"/>'), "a box needs 3 positive size"),
        (of_body('<joint/><geom size="0"/>'), "a sphere needs 1 positive size"),
        (of_body('<joint/><geom size="1" fromto="0 0 0 1 0 0"/>'), "fromto does not suit"),
        (
            of_body('<joint/><geom type="box" pos="0 0 0" size="1" fromto="0 0 0 1 0 0"/>'),
            "pos and fromto both place it",
        ),
        (
            of_body('<joint/><geom type="box" size="1e50 1e50 1e50" density="1e50"/>'),
            "mass or inertia is beyond 1e[+]50",
        ),
        (of_body("", head='<compiler settotalmass="1"/>'), "but no body has a mass"),
        ('<mujoco><worldbody name="w"/></mujoco>', "<worldbody> has no attributes"),
        ("<mujoco><worldbody><joint/></worldbody></mujoco>", "the world has no joints"),
        (TWO.format('<tendon tendon1="t"/>'), "<tendon> is not supported; kinds: connect, weld"),
        (TWO.format("<flex/>"), "<equality> <flex> is not supported"),
        (TWO.format('<connect body1="b1"/>'), 'anchor="..." is missing'),
        (TWO.format('<connect body2="b1" anchor="0 0 0"/>'), 'body1="..." is missing'),
        (TWO.format('<connect site1="s1"/>'), 'site2="..." is missing'),
        (TWO.format('<connect site1="s1" body1="b1"/>'), "site1 and body1 exclude each other"),
        (TWO.format('<connect body1="x" anchor="0 0 0"/>'), "'x' does not exist; names: b1, b2"),
        (TWO.format('<weld site1="s1" site2="s3"/>'), "'s3' does not exist; names: s1, s2"),
        (TWO.format('<weld body1="b1" body2="b1"/>'), "both ends are on the body 'b1'"),
        (TWO.format('<weld body1="b1" torquescale="0"/>'), "is a ball; write <connect>"),
        (TWO.format('<weld body1="b1" active="yes"/>'), "active is 'yes', expected one of true"),
        (TWO.format('<joint joint1="x"/>'), "joint1 'x' does not exist; names: e"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


def test_what_stands_in_the_world_needs_no_mass() -> None:
    mocap = of_body('<geom type="mesh" mesh="m"/>').replace("<body ", '<body mocap="true" ')
    assert read(mocap).links[-1].mass == 0.0
    assert "it stands still" in read(mocap).warnings[0]
    point = read(of_body('<joint/><inertial pos="0 0 0" mass="2"/>'))
    assert point.links[-1].mass == 2.0
    assert "a point mass" in point.warnings[0]
