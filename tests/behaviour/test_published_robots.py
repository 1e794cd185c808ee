"""Published parallel robots: a small twin of what each row of the table shows, and the files.

The robots of others are no part of this project. The environment variable
`CARDAN_DYN_PARALLEL_ROBOTS` names a folder of Gepetto's example-parallel-robots to be read.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from testkit import linkages
from testkit.ball_rods import ALONG, as_balls, as_hinges, link

import cardan_dyn as cd

PAGE = Path(__file__).parents[2] / "docs" / "parallel_robots.md"
FOLDER = os.environ.get("CARDAN_DYN_PARALLEL_ROBOTS", "")
GRAVITY = (0.0, 0.0, -9.81)
OPTIONS = {"drive": "a", "gravity": GRAVITY, "loads": {"d": -3.0}}


class Row(NamedTuple):
    """A row of the table, as it is written."""

    robot: str
    loops: str
    motors: str
    idle: str
    result: str


ROWS = {
    row.robot: row
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith("| robot |")
    for row in [Row(*(cell.strip() for cell in line.strip("|").split("|")))]
}


def solved(mechanism: cd.Mechanism, motors: tuple[str, ...]) -> cd.Sweep:
    """Sweep over random positions as the page says."""
    scene = cd.Scene(mechanism, drive=motors, gravity=GRAVITY)
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


def test_every_row_has_a_twin() -> None:
    assert set(TWINS) == set(ROWS)
    refused = {heavy_link_between_hinges, rod_beside_its_line, rod_that_is_too_short}
    for name, row in ROWS.items():
        assert row.result.startswith("solved") == (TWINS[name] in _SOLVED), name
        assert row.result.startswith("refused") == (TWINS[name] in refused), name


_SOLVED = {planar_loop, rod_between_balls, rod_of_hinges}


@pytest.mark.slow
@pytest.mark.parametrize("twin", dict.fromkeys(TWINS.values()), ids=lambda twin: twin.__name__)
def test_twins_do_what_the_table_says(twin: Callable[[Path], None], tmp_path: Path) -> None:
    twin(tmp_path)


@pytest.mark.slow
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
