"""What a file drives is what scenes drive; three hinges in place of a ball leave a rod idle."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from testkit.compound_joints import Z, body, joint, loop, robot

import cardan_dyn as cd
from cardan_dyn.practice.command_line.commands import main

pytestmark = pytest.mark.usefixtures("loaded_once")

TRANSMISSION = '<transmission name="t{0}"><type>simple</type><joint name="{0}"/></transmission>'
CONTROL = (
    '<ros2_control name="s" type="system">{}<joint name="rocker"><state_interface '
    'name="position"/></joint></ros2_control>'
)
COMMAND = '<joint name="{}"><command_interface name="effort"/></joint>'


def four_bar(more: str = "") -> str:
    return robot(
        body("crank_arm", 0.5, "0.05 0 0"),
        joint("crank", "continuous", "ground crank_arm", "", (Z,)),
        body("coupler_bar", 0.8, "0.2 0.1 0"),
        joint("coupler", "continuous", "crank_arm coupler_bar", 'xyz="0.1 0 0"', (Z,)),
        body("rocker_arm", 0.6, "0 0.1 0"),
        joint("rocker", "continuous", "ground rocker_arm", 'xyz="0.4 0 0"', (Z,)),
        loop(
            "pin",
            "continuous",
            "coupler_bar rocker_arm",
            ('xyz="0.3 0.2 0"', 'xyz="0 0.2 0"'),
            (Z,),
        ),
    ).replace("</robot>", f"{more}</robot>")


@pytest.mark.parametrize(
    ("more", "motors"),
    [
        ("", ()),
        (TRANSMISSION.format("rocker"), ("rocker",)),
        (CONTROL.format(COMMAND.format("coupler")), ("coupler",)),
        (CONTROL.format(""), ()),
        (TRANSMISSION.format("rocker") + TRANSMISSION.format("nowhere"), ("rocker",)),
        (TRANSMISSION.format("rocker") + CONTROL.format(COMMAND.format("rocker")), ("rocker",)),
    ],
)
def test_motors_of_urdf(more: str, motors: tuple[str, ...]) -> None:
    mechanism = cd.load(four_bar(more))
    assert mechanism.description.independent_joints == motors
    report = cd.describe(mechanism)
    told = ["<transmission> is for other programs" in warning for warning in report.warnings]
    assert told == [True] * ("nowhere" in more)
    assert report.drives.default == (motors or ("crank",))
    if motors:
        assert cd.Scene(mechanism).drives == motors


def test_what_is_marked_independent_comes_first() -> None:
    marked = four_bar(TRANSMISSION.format("rocker")).replace(
        'name="crank" type', 'name="crank" independent="true" type'
    )
    assert cd.load(marked).description.independent_joints == ("crank",)


def test_what_says_nothing_is_independent_where_another_joint_says_that_it_is_not() -> None:
    """The default of URDF+; a joint that is fixed, floats or follows has no motor."""
    chain = robot(
        joint("base", "floating", "ground a"),
        *(body(name, 1.0) for name in "abcdef"),
        joint("one", "continuous", "a b", "", (Z,)),
        joint("two", "continuous", "a c", "", (Z,)),
        joint("three", "continuous", "a d", "", (Z,)).replace(
            "</joint>", '<mimic joint="one"/></joint>'
        ),
        joint("four", "fixed", "a e"),
        joint("five", "continuous", "a f", "", (Z,)),
    )
    assert cd.load(chain).independent_joints == ()
    marked = chain.replace('name="two"', 'name="two" independent="false"')
    assert cd.load(marked).independent_joints == ("one", "five")
    both = marked.replace('name="one"', 'name="one" independent="true"')
    assert cd.load(both).independent_joints == ("one", "five")


def test_joints_that_follow_others_are_no_motors() -> None:
    text = robot(
        body("a", 1.0),
        joint("one", "continuous", "ground a", "", (Z,)),
        body("b", 1.0),
        joint("two", "continuous", "ground b", 'xyz="1 0 0"', (Z,)).replace(
            "</joint>", '<mimic joint="one"/></joint>'
        ),
    ).replace("</robot>", TRANSMISSION.format("one") + TRANSMISSION.format("two") + "</robot>")
    assert cd.load(text).description.independent_joints == ("one",)


@pytest.mark.parametrize(
    ("motors", "text"),
    [
        (
            ("crank", "rocker"),
            "drives: 2 (crank, rocker); coordinates that decide the motion: 1; say",
        ),
        (("crank",), "drives: 1 (crank); coordinates that decide the motion: 2; drive or hold 1"),
    ],
)
def test_numbers_that_disagree_are_told(motors: tuple[str, ...], text: str, tmp_path) -> None:
    more = "".join(map(TRANSMISSION.format, motors))
    if len(motors) == 1:
        more += body("tool", 0.1) + joint("wrist", "continuous", "rocker_arm tool", "", (Z,))
    mechanism = cd.load(four_bar(more))
    (found,) = cd.describe(mechanism).warnings
    assert text in found
    path = tmp_path / "bar.urdf"
    path.write_text(four_bar(more))
    assert text in " ".join(CliRunner().invoke(main, ["check", str(path)]).output.split())


def rod(ball: str) -> str:
    return f"""<mujoco><worldbody>
      <body name="crank"><joint name="a" axis="0 0 1"/>
        <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
        <body name="rod" pos="0.2 0 0">{ball}
          <inertial pos="0.25 0.1 0.05" mass="0.5" diaginertia="0.01 0.01 0.01"/></body></body>
      <body name="rocker" pos="0.7 0 0"><joint name="d" axis="0 1 0"/>
        <inertial pos="0 0.1 0" mass="1" diaginertia="0.01 0.01 0.01"/></body>
    </worldbody>
    <equality><connect name="c" body1="rod" body2="rocker" anchor="0.5 0.2 0.1"/></equality>
    <actuator><motor joint="a"/></actuator></mujoco>"""


@pytest.mark.slow
@pytest.mark.parametrize("order", [pytest.param("x y z", marks=pytest.mark.slow), "z x y"])
def test_three_hinges_are_a_ball(order: str) -> None:
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    hinges = "".join(f'<joint name="b{axis}" axis="{axes[axis]}"/>' for axis in order.split())
    found = []
    for ball in ('<joint name="b" type="ball"/>', hinges):
        mechanism = cd.load(rod(ball))
        report = cd.describe(mechanism)
        assert (report.mobility, len(report.idle_rods), report.warnings) == (2, 1, ())
        assert report.drives.default == ("a",)
        scene = cd.Scene(mechanism, loads={"d": 1.0}, gravity="description")
        found.append(scene.sweep(np.linspace(-0.3, 0.3, 5), speed=2.0))
    ball_rod, hinge_rod = found
    np.testing.assert_allclose(hinge_rod.drive_effort, ball_rod.drive_effort, rtol=1e-10)
    for name in ("a", "d"):
        np.testing.assert_allclose(hinge_rod[name].force, ball_rod[name].force, atol=1e-9)
