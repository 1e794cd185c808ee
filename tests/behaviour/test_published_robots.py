"""Published parallel robots: a small twin of what each row of the tables shows, and the files.

The robots of others are no part of this project. The environment variables
`CARDAN_DYN_PARALLEL_ROBOTS` and `CARDAN_DYN_RBDA` name folders of Gepetto's example-parallel-robots
and of the robot-models of generalized_rbda to be read.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml
from testkit import linkages
from testkit.ball_rods import ALONG, as_balls, as_hinges, link

import cardan_dyn as cd

PAGE = Path(__file__).parents[2] / "docs" / "parallel_robots.md"
FOLDER = os.environ.get("CARDAN_DYN_PARALLEL_ROBOTS", "")
RBDA = os.environ.get("CARDAN_DYN_RBDA", "")
GRAVITY = (0.0, 0.0, -9.81)
OPTIONS = {"drive": "a", "gravity": GRAVITY, "loads": {"d": -3.0}}

TWO_ASSEMBLIES = pytest.mark.filterwarnings("ignore:.*two assemblies lie beside it:UserWarning")
"""Some robots are open at zero, which is told."""


class Row(NamedTuple):
    """A row of the table, as it is written."""

    robot: str
    loops: str
    motors: str
    idle: str
    result: str


def rows_of(heading: str) -> dict[str, Row]:
    """Return the rows of the table below a heading, by what they begin with."""
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return {
        row.robot: row
        for line in section.splitlines()
        if line.startswith("| ") and not line.startswith("| robot |")
        for row in [Row(*(cell.strip() for cell in line.strip("|").split("|")))]
    }


ROWS = rows_of("example-parallel-robots")
RBDA_ROWS = rows_of("generalized_rbda")
MORE_ROWS = rows_of("More robots")


def solved(mechanism: cd.Mechanism, motors: tuple[str, ...], **options: Any) -> cd.Sweep:
    """Sweep over random positions as the page says."""
    scene = cd.Scene(mechanism, drive=motors, gravity=GRAVITY, **options)
    at = scene.configuration().positions
    start = np.array([float(np.ravel(at[name])[0]) for name in motors])
    near, speed, acceleration = np.random.default_rng(0).uniform(-1.0, 1.0, (3, 50, len(motors)))
    turn = scene.sweep(start + 0.02 * near, speed, acceleration)
    assert turn.balance_residual < 1e-13
    assert turn.loop_residual < 1e-13
    return turn


def planar_loop(_: Path) -> None:
    """A loop in a plane closed by a ball, or by a hinge: nothing is idle."""
    for kind in ("spherical", "continuous"):
        mechanism = cd.load(linkages.four_bar(linkages.loop(kind)))
        assert not solved(mechanism, ("a",)).idle_rods


def rod_between_balls(_: Path) -> None:
    assert len(solved(cd.load(as_balls()), ("a",)).idle_rods) == 1


def rod_of_hinges(_: Path) -> None:
    """Three hinges are a ball; at zero the rod points elsewhere, so that it has far to turn.

    How far it turns about its line where it settles says nothing about the motion of all others.
    """
    where = '<child link="x1"/><origin xyz="0.3 0 0"'
    positions = np.linspace(-1.0, 1.0, 21)
    expected = cd.Scene(cd.load(as_balls()), **OPTIONS).sweep(positions, speed=2.0)
    for rpy in ("0.9 -0.7 0.5", "2.8 -0.3 0.2", "0 1.4 -2"):
        text = as_hinges().replace(where, f'{where} rpy="{rpy}"')
        assert text.count(rpy) == 1
        mechanism = cd.load(text)
        assert cd.assemble(mechanism).loop_residual < 1e-12
        near = {"d": float(expected.motion.position("d")[10])}
        turn = cd.Scene(mechanism, near=near, **OPTIONS).sweep(positions, speed=2.0)
        assert len(turn.idle_rods) == 1
        np.testing.assert_allclose(turn.drive_effort, expected.drive_effort, rtol=1e-10)
        assert np.all(cd.Scene(mechanism, near=near, **OPTIONS).reachable(positions))


@pytest.mark.slow
def test_hinges_in_line_may_keep_a_rod_from_settling() -> None:
    text = as_hinges().replace(
        '<child link="x1"/><origin xyz="0.3 0 0"',
        '<child link="x1"/><origin xyz="0.3 0 0" rpy="-2.45 0.4 2.65"',
    )
    with pytest.raises(cd.AssemblyError, match="b3, b2, b1, c1, c2, c3 hold a rod that may spin"):
        cd.Scene(cd.load(text), **OPTIONS).sweep(np.linspace(-1.0, 1.0, 21))


def heavy_link_between_hinges(_: Path) -> None:
    """It turns like a rotor, which somebody has to drive."""
    heavy = link("x2", 654e3, "0 0 0", np.eye(3))
    text = as_hinges().replace('<link name="x2"/>', heavy)
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(cd.load(text), drive="a")
    assert caught.value.mobility == 2


def rod_beside_its_line(_: Path) -> None:
    """Gravity would turn it."""
    beside = 0.5 * ALONG + np.array([0.0, 0.3, 0.0])
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(cd.load(as_balls(centre=beside)), drive="a")
    assert caught.value.mobility == 2


def rod_that_is_too_short(_: Path) -> None:
    text = as_balls().replace('<origin xyz="0 0 0.6"/>', '<origin xyz="0 0 6"/>')
    with pytest.raises(cd.AssemblyError, match="the loops cannot be closed") as caught:
        cd.assemble(cd.load(text))
    assert caught.value.residual > 0.1


def beside(tmp_path: Path, content: str, name: str = "robot.yaml") -> Path:
    """Write a four-bar without its loop, and a file beside it."""
    urdf = linkages.four_bar(linkages.loop("continuous"))
    path = tmp_path / "robot.urdf"
    path.write_text(urdf[: urdf.index("<loop")] + "</robot>", encoding="utf-8")
    (tmp_path / name).write_text(content, encoding="utf-8")
    return path


def joint_that_does_not_exist(tmp_path: Path) -> None:
    content = "closed_loop: [['coupler', 'rocker']]\ntype: ['3d']\njoint_name: ['left']\n"
    path = beside(tmp_path, content + "joint_type: ['SPHERICAL']\n")
    with pytest.raises(cd.ModelError, match="'left' does not exist"):
        cd.load(path)
    assert any("'left'" in warning for warning in cd.load(path, strict=False).warnings)


def no_file_with_loops(tmp_path: Path) -> None:
    assert not cd.load(beside(tmp_path, "", "notes.txt")).loops


def loops_in_a_file_of_another_name(tmp_path: Path) -> None:
    path = beside(tmp_path, "closed_loop: [['coupler', 'rocker']]\ntype: ['3d']\n", "other.yaml")
    mechanism = cd.load(path)
    assert not mechanism.loops
    assert any("other.yaml" in warning for warning in mechanism.warnings)


TWINS: dict[str, Callable[[Path], None]] = {
    "5bar_linkage": heavy_link_between_hinges,
    **dict.fromkeys(
        (
            *("5bar_linkage_iso3d", "5bar_linkage_iso6d", "battobot_6d", "digit_like_2legs"),
            *("digit_like_2legs_6D", "digit_like_2legs_old"),
        ),
        planar_loop,
    ),
    **dict.fromkeys(
        ("cassie_like", "digit_like", "old/digit_like_2legs", "robot_delta"), rod_between_balls
    ),
    "talos_like": rod_of_hinges,
    "disney_like": heavy_link_between_hinges,
    "disney_robot": joint_that_does_not_exist,
    "wl16_like": rod_beside_its_line,
    **dict.fromkeys(("kangaroo_like", "kangaroo_like_2legs"), rod_that_is_too_short),
    "kangaroo_like_2leg": no_file_with_loops,
    "true_talos_2_legs": loops_in_a_file_of_another_name,
}


BODY = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>'
STRETCHED = f"""<robot name="stretched"><link name="ground"/>
<link name="crank">{BODY}</link>
<link name="rod">{BODY}</link>
<link name="rocker">{BODY}</link>
<joint name="a" type="revolute" independent="true"><parent link="ground"/><child link="crank"/>
  <axis xyz="0 0 1"/></joint>
<joint name="b" type="revolute" independent="false"><parent link="crank"/><child link="rod"/>
  <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="c" type="revolute" independent="false"><parent link="ground"/><child link="rocker"/>
  <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
<loop name="d" type="revolute"><predecessor link="rod"><origin xyz="1 0 0"/></predecessor>
  <successor link="rocker"><origin xyz="0.5 0 0"/></successor><axis xyz="0 0 1"/></loop></robot>"""
GEARED = f"""<robot name="geared"><link name="ground"/>
<link name="pelvis">{BODY}</link>
<link name="leg"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.1"/></inertial></link>
<link name="rotor"><inertial><mass value="0"/><inertia ixx="1e-3" iyy="2e-3" izz="1e-3"/></inertial>
  </link>
<joint name="base" type="floating"><parent link="ground"/><child link="pelvis"/>
  <axis xyz="0 0 0"/></joint>
<joint name="hip" type="revolute"><parent link="pelvis"/><child link="leg"/>
  <axis xyz="0 1 0"/></joint>
<joint name="motor" type="revolute" independent="false"><parent link="pelvis"/><child link="rotor"/>
  <axis xyz="0 1 0"/></joint>
<coupling name="gear" type="rolling"><predecessor link="leg"/><successor link="rotor"/>
  <ratio value="6"/></coupling></robot>"""
BASE = dict.fromkeys(("x", "y", "z", "turn_x", "turn_y", "turn_z"), 0.0)


def stretched_at_zero(_: Path) -> None:
    mechanism = cd.load(STRETCHED)
    with pytest.raises(cd.SingularConfigurationError, match="near="):
        cd.Scene(mechanism).sweep([0.0])
    solved(mechanism, ("a",), near={"a": 0.5})


def rotor_and_held_base(_: Path) -> None:
    """A rotor without mass resists by 36 times its inertia, and the base is held at its place."""
    mechanism = cd.load(GEARED, strict=False)
    assert mechanism.independent_joints == ("hip",)
    with pytest.raises(cd.MobilityError, match="6 freedoms are left over"):
        cd.Scene(mechanism)
    held = {f"base.{name}": value for name, value in BASE.items()}
    turn = solved(mechanism, ("hip",), held=held)
    angle, pace = turn.motion.position("hip"), turn.motion.acceleration("hip")
    weight = 9.81 * 2.0 * 0.2 * np.sin(angle)
    inertia = 0.2 + 2.0 * 0.2**2 + 6.0**2 * 2e-3
    found = np.ravel(turn.drive_effort)
    np.testing.assert_allclose(found, np.ravel(inertia * pace + weight), rtol=1e-12)


def tree_without_its_loops(_: Path) -> None:
    """Where the loops stand in a program, nothing decides what passive joints do."""
    urdf = linkages.four_bar(linkages.loop("continuous"))
    tree = cd.load(urdf[: urdf.index("<loop")] + "</robot>")
    with pytest.raises(cd.MobilityError, match="it has no loop: nothing decides the motion of"):
        cd.Scene(tree, drive="a")
    joints = tuple(joint.name for joint in tree.description.joints)
    solved(tree, joints)


def loop_added_in_python(_: Path) -> None:
    """It is the same mechanism as that of a file with the loop."""
    urdf = linkages.four_bar(linkages.loop("continuous"))
    whole = cd.load(urdf)
    (loop,) = whole.description.loops
    tree = cd.load(urdf[: urdf.index("<loop")] + "</robot>")
    closed = cd.close(
        tree,
        *(loop.predecessor, loop.successor, loop.type),
        at=loop.predecessor_origin,
        at_b=loop.successor_origin,
        axis=loop.axis,
    )
    efforts = [solved(mechanism, ("a",)).drive_effort for mechanism in (whole, closed)]
    np.testing.assert_allclose(*efforts, rtol=1e-12)


def more_motors_than_freedoms(_: Path) -> None:
    mechanism = cd.load(linkages.four_bar(linkages.loop("continuous")))
    with pytest.raises(cd.MobilityError, match="drop a drive"):
        cd.Scene(mechanism, drive=("a", "b"))


def rods_of_two_lengths(_: Path) -> None:
    """They lock what they were meant to move side by side."""
    with pytest.raises(cd.MobilityError, match=r"mobility 0.*closure_tolerance="):
        cd.Scene(cd.load(linkages.neck(2.5e-5)), drive="arm").sweep([0.1])
    alike = solved(cd.load(linkages.neck(0.0)), ("arm",))
    accepted = cd.load(linkages.neck(2.5e-5), closure_tolerance=1e-3)
    scene = cd.Scene(accepted, drive=("arm",), gravity=GRAVITY)
    turn = scene.sweep(alike.position, alike.speed, alike.acceleration)
    np.testing.assert_allclose(turn.drive_effort, alike.drive_effort, rtol=1e-3, atol=1e-6)


def file_that_contradicts_itself(_: Path) -> None:
    text = linkages.four_bar(linkages.loop("continuous"))
    assert '<axis xyz="0 ' in text
    with pytest.raises(cd.ModelError, match="is not 3 finite number"):
        cd.load(text.replace('<axis xyz="0 ', '<axis xyz="0z ', 1))
    twice = re.sub(r"(<axis [^>]*/>)", r"\1\1", text, count=1)
    with pytest.raises(cd.ModelError, match="there are 2 <axis> in"):
        cd.load(twice)


def of_more(begins: str, result: str) -> Callable[[Path], None]:
    """Return the twin of a row of the last table by what its result says."""
    for word, twin in (
        ("cd.close", loop_added_in_python),
        ("closure_tolerance", rods_of_two_lengths),
        ("from `near=", stretched_at_zero),
        ("a tree", tree_without_its_loops),
        ("to drop", more_motors_than_freedoms),
        ("refused", file_that_contradicts_itself),
        ("solved", rod_between_balls if "orbita" in begins or "spm" in begins else planar_loop),
    ):
        if word in result:
            return twin
    return no_file_with_loops  # What is read of Gazebo's worlds has tests of its own.


RBDA_TWINS = {
    name: stretched_at_zero
    if "stretched" in row.result
    else rotor_and_held_base
    if "gears" in row.loops
    else planar_loop
    if row.loops == "1"
    else tree_without_its_loops
    for name, row in RBDA_ROWS.items()
}
MORE_TWINS = {name: of_more(name, row.result) for name, row in MORE_ROWS.items()}
EVERY_TWIN = [*TWINS.values(), *RBDA_TWINS.values(), *MORE_TWINS.values()]


def test_every_row_has_a_twin() -> None:
    assert set(TWINS) == set(ROWS)
    refused = {heavy_link_between_hinges, rod_beside_its_line, rod_that_is_too_short}
    for name, row in ROWS.items():
        assert row.result.startswith("solved") == (TWINS[name] in _SOLVED), name
        assert row.result.startswith("refused") == (TWINS[name] in refused), name


_SOLVED = {planar_loop, rod_between_balls, rod_of_hinges}


@pytest.mark.slow
@pytest.mark.parametrize("twin", dict.fromkeys(EVERY_TWIN), ids=lambda twin: twin.__name__)
def test_twins_do_what_the_table_says(twin: Callable[[Path], None], tmp_path: Path) -> None:
    twin(tmp_path)


@pytest.mark.slow
@TWO_ASSEMBLIES
@pytest.mark.skipif(
    not FOLDER, reason="CARDAN_DYN_PARALLEL_ROBOTS names no folder of example-parallel-robots"
)
@pytest.mark.parametrize("name", ROWS)
def test_the_robots_themselves(name: str) -> None:
    row = ROWS[name]
    # Older ones lie in a folder of their own, under the same name.
    path = min(
        (
            path
            for path in Path(FOLDER).rglob("*.urdf")
            if path.parent.as_posix().endswith(f"/{name}")
        ),
        key=lambda path: len(path.parts),
    )
    if row.loops == "–":
        assert not cd.load(path, strict=False).loops
        return
    if row.result.startswith("`strict`"):
        with pytest.raises(cd.ModelError, match="does not exist"):
            cd.load(path)
        return
    motors = tuple(yaml.safe_load(path.with_suffix(".yaml").read_text("utf-8"))["name_mot"])
    assert len(motors) == int(row.motors)
    mechanism = cd.load(path, strict=False)
    assert len(mechanism.loops) == int(row.loops)
    if row.result.startswith("solved"):
        turn = solved(mechanism, motors)
        assert len(turn.idle_rods) == int(row.idle)
    elif mobility := re.search(r"mobility (\d+)", row.result):
        with pytest.raises(cd.MobilityError) as caught:
            cd.Scene(mechanism, drive=motors)
        assert caught.value.mobility == int(mobility[1])
    else:
        with pytest.raises(cd.AssemblyError, match="cannot be closed"):
            cd.Scene(mechanism, drive=motors)


@pytest.mark.slow
@TWO_ASSEMBLIES
@pytest.mark.skipif(not RBDA, reason="CARDAN_DYN_RBDA names no folder of robot-models")
@pytest.mark.parametrize("name", RBDA_ROWS)
def test_robots_in_urdf_plus(name: str) -> None:
    row = RBDA_ROWS[name]
    mechanism = cd.load(Path(RBDA) / f"{name}.urdf", strict=False)
    described = mechanism.description
    gears = f"{len(described.couplings)} gears" if described.couplings else "–"
    assert row.loops == (str(len(mechanism.loops)) if mechanism.loops else gears)
    motors = mechanism.independent_joints
    if row.motors == "–":
        # Nothing says what motors drive, or what couples them stands elsewhere.
        motors = tuple(
            joint.name
            for joint in described.joints
            if joint.type not in ("fixed", "floating")
            and not (described.couplings and "rotor" in joint.name)
        )
    else:
        assert len(motors) == int(row.motors)
    floating = [joint.name for joint in described.joints if joint.type == "floating"]
    held = {f"{joint}.{name}": value for joint in floating for name, value in BASE.items()}
    options: dict[str, Any] = {"held": held} if held else {}
    if near := re.search(r'near=\{"(\w+)": ([\d.]+)\}', row.result):
        with pytest.raises(cd.SingularConfigurationError):
            cd.Scene(mechanism, drive=motors).sweep(np.zeros(len(motors)))
        options["near"] = {near[1]: float(near[2])}
    turn = solved(mechanism, motors, **options)
    assert len(turn.idle_rods) == int(row.idle)
