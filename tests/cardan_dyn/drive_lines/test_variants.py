import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.practice.drive_lines.verdict.variants import adjustables

LINE = double_shaft((0.0, 0.2, 0.1))
THREE = random_line(3, seed=0)


def test_positions_add_to_the_data() -> None:
    found = LINE.variants(angles=[[0.3, 0.1], [0.2, 0.2]], fork_offsets=[[0.5], [0.0]])
    assert found.designs == 2
    assert found.held["joint_angle_1"] == pytest.approx([0.1, 0.0], abs=1e-15)
    assert found.held["joint_angle_2"] == pytest.approx([0.0, 0.1], abs=1e-15)
    assert found.held["fork_offset_1"].tolist() == [0.5, 0.0]
    assert set(found.held) == {"joint_angle_1", "joint_angle_2", "fork_offset_1"}


def test_one_value_for_all_joints_or_designs() -> None:
    found = LINE.variants(angles=np.array([[0.1], [0.2], [0.3]]), planes=[0.5, np.pi])
    assert found.designs == 3
    assert found.held["joint_angle_2"] == pytest.approx([0.0, 0.1, 0.2], abs=1e-15)
    assert found.held["joint_plane_1"].shape == (3,)
    assert LINE.variants().designs == 1


def test_a_longer_shaft_without_a_spline_is_longer_itself() -> None:
    found = THREE.variants(lengths=[[1.0, 1.1]])
    assert found.held["tube_length_1"].tolist() == found.held["shaft_length_1"].tolist()
    assert "tube_length_2" not in found.held


def test_names_are_those_of_the_description() -> None:
    for line in (LINE, THREE):
        assert {joint.name for joint in adjustables(line)} == set(line.mechanism.adjustable)


def test_what_designs_hold_cannot_be_changed() -> None:
    found = LINE.variants(misalignments={"offset_y_1": [0.1, 0.2]})
    with pytest.raises(ValueError, match="read-only"):
        found.held["offset_y_1"][0] = 1.0
    with pytest.raises(TypeError):
        found.held["offset_y_1"] = 1.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"angles": [0.1, np.pi / 2]}, "angles has 1.5708, expected joint angles from 0 to below"),
        ({"angles": [0.1, -0.1]}, "angles has -0.1"),
        ({"angles": [0.1, 0.2, 0.3]}, r"angles has shape \(3,\), expected \(2,\) or designs × 2"),
        ({"angles": [np.nan, 0.1]}, "angles is not finite"),
        ({"angles": np.ones((0, 2))}, "there are no designs"),
        ({"lengths": [0.0]}, "lengths has 0, expected more than 0 m"),
        ({"angles": np.ones((3, 2)), "lengths": np.ones((2, 1))}, r"differ in number: \[2, 3\]"),
        ({"misalignments": {"offset_y_1": [[0.1]]}}, r"offset_y_1 has shape \(1, 1\)"),
        (
            {"misalignments": {"joint_angle_1": 0.1}, "angles": [0.1, 0.1]},
            "joint_angle_1 is given twice",
        ),
    ],
)
def test_wrong_arguments(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        LINE.variants(**arguments)


def test_a_single_joint_has_no_intermediate_shafts() -> None:
    single = random_line(1, seed=0)
    for name in ("lengths", "fork_offsets"):
        with pytest.raises(ArgumentError, match=f"{name} is given, but a line of one joint has no"):
            single.variants(**{name: [1.0]})


def test_unknown_joints() -> None:
    with pytest.raises(ModelError, match=r"'offset_x_1' is no adjustable .* mean 'offset_[yz]_1'"):
        LINE.variants(misalignments={"offset_x_1": 0.1})


def test_lengths_leave_room_for_bearings_and_splines() -> None:
    with pytest.raises(
        ArgumentError, match=r"0\.1 for shaft_1, expected at least .* bearing C1 is"
    ):
        THREE.variants(lengths=[[1.2, 1.0], [0.1, 1.0]])
    with pytest.raises(
        ArgumentError, match=r"0\.44 for shaft_1, .* 0\.45 m, up to where its spline"
    ):
        LINE.variants(lengths=[0.44])
