"""`loop_closures.yaml` near a URDF: two formats, where it is found, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from testkit.kinematics import at_zero
from testkit.linkages import coupling
from testkit.mimicking import mimic
from testkit.other_notations import CLOSURES, PINS, PLUS, TREE, written

import cardan_dyn as cd
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.second_reading import reread

BALLS = PINS.replace("pin_loops", "ball_loops").replace("    axis: [0.0, 0.0, 2.0]\n", "")
TURNED = TREE.format("").replace('<origin xyz="2 0 0"/>', '<origin xyz="2 0 0" rpy="0.3 0.2 0.1"/>')


@pytest.mark.parametrize("inside", ["", ".", "config"])
@pytest.mark.parametrize("yaml", [CLOSURES, PINS, BALLS])
def test_where_files_are(yaml: str, inside: str, tmp_path: Path) -> None:
    description = read(written(tmp_path, yaml, inside=inside))
    (found,) = description.loops
    assert found.type == ("spherical" if yaml is BALLS else "revolute")
    assert found.name == ("loop_1" if yaml is CLOSURES else "knee")
    assert (found.predecessor, found.successor) == ("coupler", "rocker")
    # Coupler and rocker stand at (0, 0.5) and (2, 0) at zero.
    assert found.predecessor_origin[:3, 3].tolist() == [2.0, 2.0, 0.0]
    assert found.successor_origin[:3, 3].tolist() == [0.0, 2.5, 0.0]
    assert reread(description).loops == description.loops


def test_only_a_directory_named_urdf_is_left(tmp_path: Path) -> None:
    path = written(tmp_path, CLOSURES, inside=".")
    moved = tmp_path / "robots" / "bars.urdf"
    moved.parent.mkdir()
    path.rename(moved)
    assert read(moved).loops == ()


def test_points_and_axes_are_those_of_the_root_at_zero(tmp_path: Path) -> None:
    """Joints with turned origins on both sides."""
    description = read(written(tmp_path, CLOSURES, TURNED))
    (found,) = description.loops
    mechanism = cd.load(TURNED)
    frames = []
    for link, origin in (
        (found.predecessor, found.predecessor_origin),
        (found.successor, found.successor_origin),
    ):
        body, placement = mechanism.links[link]
        placed = at_zero(mechanism)[body] * placement
        frames.append(placed.homogeneous @ origin)
    expected = np.eye(4)
    expected[:3, 3] = [2.0, 2.5, 0.0]
    for frame in frames:
        np.testing.assert_allclose(frame, expected, atol=1e-15)
    assert found.axis.tolist() == [0.0, 0.0, 1.0]
    assert reread(description).agrees(description, 1e-15)


def test_pins_need_parallel_frames(tmp_path: Path) -> None:
    with pytest.raises(cd.ModelError, match="knee: the frames of 'coupler' and 'rocker' are not"):
        read(written(tmp_path, PINS, TURNED))
    assert read(written(tmp_path, BALLS, TURNED)).loops[0].type == "spherical"


def test_loops_replace_approximate_mimics(tmp_path: Path) -> None:
    """The programs state a mimic for others that know no loops; both together would lock."""
    text = TREE.format("").replace('name="d" type="continuous">', 'name="d" type="continuous">{}')
    path = written(tmp_path, CLOSURES, text.format(mimic("a", 0.4)))
    description = read(path)
    assert description.couplings == ()
    assert any(
        "<mimic> of 1 joint (d) left out: loops decide where these joints are" in warning
        for warning in description.warnings
    )
    assert cd.describe(cd.load(path)).mobility == 1
    # A joint that is not dependent mimics all the same.
    free = CLOSURES.replace("dependent: [b, d]", "dependent: [b]")
    assert len(read(written(tmp_path, free, text.format(mimic("a", 0.4)))).couplings) == 1


def test_hinges_that_are_balls(tmp_path: Path) -> None:
    description = read(written(tmp_path, PINS.replace("upgrades: []", "upgrades: [b]")))
    assert {joint.name: joint.type for joint in description.joints}["b"] == "spherical"
    assert [warning.split(": ")[-1] for warning in description.warnings] == ["limits play no part"]


@pytest.mark.parametrize("yaml", ["closures: []", "dependent: [b]", "closures:\nball_loops: []"])
def test_files_without_loops_are_left_alone(yaml: str, tmp_path: Path) -> None:
    assert read(written(tmp_path, yaml)).notation == "no loops"


@pytest.mark.parametrize("yaml", ["", "[1]", "loop_closures: []"])
def test_files_that_say_nothing_about_loops_are_refused(yaml: str, tmp_path: Path) -> None:
    path = written(tmp_path, yaml)
    with pytest.raises(
        cd.ModelError, match=r"it lists no loops; keys: actuated_joints, .* closures"
    ):
        read(path)
    assert read(path, strict=False).notation == "no loops"


def test_misspelled_keys_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path, CLOSURES.replace("closures", "closurs"))
    with pytest.raises(cd.ModelError, match=r"key 'closurs' .* did you mean 'closures'"):
        read(path)
    digits = "1" * 400
    huge = written(tmp_path, CLOSURES.replace("[2, 2.5, 0]", f"[{digits}, 2.5, 0]"))
    with pytest.raises(cd.ModelError, match=r"1111 2\.5 0' is beyond"):
        read(huge)


@pytest.mark.parametrize(
    ("yaml", "old", "new", "message"),
    [
        (CLOSURES, "link_b: rocker", "link_b: roker", "loop_1: link 'roker' .* 'rocker'"),
        (CLOSURES, "link_b: rocker, ", "", "loop_1: link '' does not exist in the URDF"),
        (CLOSURES, "[2, 2.5, 0]", "[2, 2.5]", r"loop_1: point: '2 2.5' is not 3 finite"),
        (CLOSURES, "[2, 2.5, 0]", "[2, x, 0]", "is not 3 finite"),
        (CLOSURES, "[2, 2.5, 0]", "[2, .nan, 0]", "is not 3 finite"),
        (CLOSURES, "[2, 2.5, 0]", "[2, true, 0]", "is not 3 finite"),
        (CLOSURES, "[2, 2.5, 0]", "[2, [1], 0]", "is not 3 finite"),
        (CLOSURES, "[2, 2.5, 0]", "7", "loop_1: point: '7' is not 3 finite"),
        (CLOSURES, "point: [2, 2.5, 0], ", "", "loop_1: point: '' is not 3 finite"),
        (CLOSURES, "[0, 0, 3]", "[0, 0, 0]", r"loop_1: the axis .* has no direction"),
        (CLOSURES, "[a]", "[z]", "joint 'z' does not exist; joints: a, b, d; load"),
        (CLOSURES, "[a]", "a", "independent is not a list of names"),
        (CLOSURES, "[b, d]", "[b, 1]", "dependent: int is not a name"),
        (CLOSURES, "dependent", "closures", "key names that occur twice: closures"),
        (PINS, "name: knee", "name: 3", "pin_loops: 3 is not a name; it needs quotes"),
        (PINS, "name: knee", "name: a", "names that occur twice: a"),
        (PINS, "pin_loops:\n", "pin_loops: 3\nx:\n", "pin_loops is not a list of loops"),
        (PINS, "upgrades: []", "upgrades: [z]", "joint 'z' does not exist"),
    ],
)
def test_refused(yaml: str, old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in yaml
    with pytest.raises(cd.ModelError, match=message):
        read(written(tmp_path, yaml.replace(old, new, 1)))


def test_lenient_reading_passes_over_what_does_not_match(tmp_path: Path) -> None:
    """A file of another robot: named in the warnings, and the URDF is read without it."""
    other = CLOSURES.replace("coupler", "theirs").replace("[a]", "[z]")
    path = written(tmp_path, other)
    with pytest.raises(cd.ModelError, match=r"loop_closures.yaml: loop_1: link 'theirs'"):
        read(path)
    description = read(path, strict=False)
    assert (description.loops, description.independent_joints) == ((), ())
    assert [warning.split("yaml: ")[-1] for warning in description.warnings] == [
        "loop_1: no link 'theirs'; the loop was passed over",
        "joint 'z' does not exist and was passed over",
    ]


def test_unknown_keys_are_named(tmp_path: Path) -> None:
    text = CLOSURES.replace("point:", "colour: red, point:") + "version: 2\n"
    warnings = read(written(tmp_path, text)).warnings
    assert [warning.split("yaml: ")[-1] for warning in warnings] == [
        "version is unknown and was passed over",
        "closures: colour is unknown and was passed over",
    ]


def test_two_files_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path, CLOSURES)
    path.with_suffix(".yaml").write_text("closed_loop: [[coupler, rocker]]", encoding="utf-8")
    with pytest.raises(cd.ModelError, match=r"both .*bars.yaml and .*loop_closures.yaml list its"):
        read(path)


def test_a_ring_of_joints_is_what_is_wrong(tmp_path: Path) -> None:
    """Not the file, whose links exist."""
    ring = PLUS[: PLUS.index("<loop")] + "</robot>"
    ring = ring.replace('<parent link="ground"/><child link="rocker"/>', "{}").format(
        '<parent link="coupler"/><child link="crank"/>'
    )
    with pytest.raises(cd.ModelError, match="joint 'd': link 'crank' has two parents"):
        read(written(tmp_path, CLOSURES, ring))


def test_the_urdf_says_the_same(tmp_path: Path) -> None:
    description = read(written(tmp_path, CLOSURES, PLUS))
    assert description.notation == (
        "URDF+ <loop>; loop_closures.yaml closes the same links and is not used"
    )
    assert reread(description).loops == description.loops


def test_couplings_of_links_stay(tmp_path: Path) -> None:
    gear = coupling("g", "a", "b", 2.0).replace("wheel_a", "crank").replace("wheel_b", "rocker")
    description = read(written(tmp_path, CLOSURES, TREE.format(gear)))
    assert [item.name for item in description.couplings] == ["g"]
