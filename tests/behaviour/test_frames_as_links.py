"""Frames that are fixed in a link stand for a link wherever one is named."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

TIP = np.array([0.3, 0.1, -0.2])
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Placement of the frame in the link: a quarter turn about z."""
POSITIONS = np.linspace(-0.4, 0.4, 5)

MJCF = """<mujoco><worldbody>
  <site name="eye" pos="0.5 0.2 0.6"/>
  <body name="one"><joint name="h" axis="0 1 0.3"/>
    <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
    <body name="two" pos="0.2 0 0.1"><joint name="k" axis="1 0 0"/>
      <inertial pos="0.1 0 0.1" mass="2" diaginertia="0.01 0.02 0.02"/>
      <site name="tip" pos="0.3 0.1 -0.2" euler="0 0 90"/></body></body>
</worldbody></mujoco>"""

INERTIAL = (
    "<inertial><{0}>{1}</{0}><mass>{2}</mass><inertia><ixx>0.01</ixx><iyy>0.02</iyy>"
    "<izz>0.02</izz></inertia></inertial>"
)
SDF = f"""<sdf version="1.9"><model name="arm">
  <frame name="eye" attached_to="world"><pose>0.5 0.2 0.6 0 0 0</pose></frame>
  <link name="one">{INERTIAL.format("pose", "0.1 0 0 0 0 0", 1)}</link>
  <link name="two"><pose relative_to="k"/>{INERTIAL.format("pose", "0.1 0 0.1 0 0 0", 2)}</link>
  <frame name="tip" attached_to="two">
    <pose relative_to="two">0.3 0.1 -0.2 0 0 {np.pi / 2!r}</pose></frame>
  <joint name="h" type="revolute"><parent>world</parent><child>one</child>
    <axis><xyz>0 1 0.3</xyz></axis></joint>
  <joint name="k" type="revolute"><pose relative_to="one">0.2 0 0.1 0 0 0</pose>
    <parent>one</parent><child>two</child><axis><xyz>1 0 0</xyz></axis></joint>
</model></sdf>"""


def urdf() -> str:
    def link(name: str, mass: float, centre: str) -> str:
        return (
            f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>'
            '<inertia ixx="0.01" iyy="0.02" izz="0.02"/></inertial></link>'
        )

    def joint(name: str, ends: str, kind: str, origin: str, axis: str = "1 0 0") -> str:
        parent, child = ends.split()
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin {origin}/><axis xyz="{axis}"/></joint>'
        )

    return (
        '<robot name="arm"><link name="ground"/><link name="a"/><link name="b"/>'
        + link("one", 1.0, "0.1 0 0")
        + link("two", 2.0, "0.1 0 0.1")
        + joint("h", "ground one", "continuous", 'xyz="0 0 0"', "0 1 0.3")
        + joint("k", "one two", "continuous", 'xyz="0.2 0 0.1"')
        + joint("eye", "ground a", "fixed", 'xyz="0.5 0.2 0.6"')
        + joint("tip", "two b", "fixed", f'xyz="0.3 0.1 -0.2" rpy="0 0 {np.pi / 2!r}"')
        + "</robot>"
    )


@pytest.fixture(params=["mjcf", "sdf", "urdf"])
def arm(request: pytest.FixtureRequest) -> cd.Mechanism:
    return cd.load({"mjcf": MJCF, "sdf": SDF, "urdf": urdf()}[request.param])


def assert_same(found: cd.Sweep, expected: cd.Sweep) -> None:
    assert found.balance_residual < 1e-12
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-12)
    for name in ("h", "k"):
        np.testing.assert_allclose(found[name].force, expected[name].force, atol=1e-12)
        np.testing.assert_allclose(found[name].moment, expected[name].moment, atol=1e-12)


def swept(mechanism: cd.Mechanism, **arguments: object) -> cd.Sweep:
    scene = cd.Scene(mechanism, drive=["h", "k"], gravity=(0, 0, -9.81), **arguments)
    return scene.sweep(np.stack([POSITIONS, -2.0 * POSITIONS], axis=1), speed=2.0)


def test_loads(arm: cd.Mechanism) -> None:
    force, moment, point = np.array([1.0, -2.0, 3.0]), np.array([0.3, 0.2, -0.1]), (0.1, 0.2, 0.3)
    in_link = cd.Wrench(TURN @ force, TURN @ moment, point=TIP + TURN @ point)
    on_tip = cd.Wrench(force, moment, point=point)
    expected = swept(arm, loads={"two": in_link})
    assert_same(swept(arm, loads={"tip": on_tip}), expected)
    assert_same(
        swept(arm, loads={"tip": np.concatenate([force, moment])}),
        swept(arm, loads={"two": cd.Wrench(TURN @ force, TURN @ moment, point=TIP)}),
    )
    bare = cd.Scene(arm, drive=["h", "k"], gravity=(0, 0, -9.81))
    at = np.stack([POSITIONS, -2.0 * POSITIONS], axis=1)
    assert_same(bare.sweep(at, speed=2.0, loads={"tip": on_tip}), expected)
    response = cd.Scene(arm, drive="h", held={"k": 0.1}, loads={"tip": on_tip}).response()
    single = cd.Scene(arm, drive="h", held={"k": 0.1}, loads={"two": in_link}).sweep([0.2])
    np.testing.assert_allclose(response.sweep([0.2]).drive_effort, single.drive_effort, atol=1e-9)
    with pytest.raises(cd.CardanError, match="'tip' is a link"):
        response.sweep([0.2], loads={"tip": on_tip})
    with pytest.raises(cd.ArgumentError, match="'eye' is fixed to the world"):
        swept(arm, loads={"eye": on_tip})
    with pytest.raises(cd.ArgumentError, match=r"no joint or link has this name.*mean 'tip'"):
        swept(arm, loads={"tipp": on_tip})


def test_elements(arm: cd.Mechanism) -> None:
    ground = arm.description.root
    eye = np.array([0.5, 0.2, 0.6])
    end = np.array([0.05, -0.1, 0.02])
    spring = cd.PointSpring("eye", np.zeros(3), "tip", end, 300.0)
    on_links = cd.PointSpring(ground, eye, "two", TIP + TURN @ end, 300.0)
    assert_same(swept(arm, elements=[spring]), swept(arm, elements=[on_links]))
    stiffness = np.array([1e3, 2e3, 3e3, 10.0, 20.0, 30.0])
    place = np.eye(4)
    place[:3, :3], place[:3, 3] = TURN, TIP
    assert_same(
        swept(arm, elements=[cd.Bushing("tip", "eye", np.eye(4), stiffness)]),
        swept(arm, elements=[cd.Bushing("two", ground, place, stiffness)]),
    )
    with pytest.raises(cd.ModelError, match="no link or frame 'tipp'"):
        swept(arm, elements=[cd.PointSpring("eye", np.zeros(3), "tipp", end, 300.0)])


@pytest.mark.slow
def test_simulations(arm: cd.Mechanism) -> None:
    pull = np.array([1.0, -2.0, 3.0])

    def angle(**loads: object) -> np.ndarray:
        scene = cd.Scene(arm, free=["h", "k"], gravity=(0, 0, -9.81))
        return scene.simulate(0.1, loads=loads).motion.position("k")[-1]

    on_link = cd.Wrench(TURN @ pull, point=TIP)
    expected = angle(two=on_link)
    assert abs(expected - angle()) > 1e-3
    for wrench in (cd.Wrench(pull), lambda time, position, speed: cd.Wrench(pull)):
        np.testing.assert_allclose(angle(tip=wrench), expected, atol=1e-7)
    at_rest = cd.Scene(arm, free=["h", "k"], gravity=(0, 0, -9.81)).equilibrium
    np.testing.assert_allclose(
        at_rest([0.0, 0.0], loads={"tip": cd.Wrench(pull, frame="world")}).position,
        at_rest([0.0, 0.0], loads={"two": cd.Wrench(pull, frame="world", point=TIP)}).position,
        atol=1e-9,
    )


def test_axes_and_points(arm: cd.Mechanism) -> None:
    turn = swept(arm)
    np.testing.assert_allclose(
        turn.wrench("k", "tip").force, turn.wrench("k", "two").force @ TURN, atol=1e-12
    )
    np.testing.assert_allclose(
        turn.point("tip").position, turn.point("two", TIP).position, atol=1e-12
    )
