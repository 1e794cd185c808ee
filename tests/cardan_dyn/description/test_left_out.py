"""What no wrench considers is said in one line per kind, with a count and the first names."""

from __future__ import annotations

from pathlib import Path

import pytest
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.core.description.description import JointDescription, Limits
from cardan_dyn.core.description.left_out import limits_left_out
from cardan_dyn.core.description.read import bundled_directory

PLUS = four_bar(loop("continuous"))


def warnings(more: str = "", robot: str = "", link: str = "") -> list[str]:
    """Return the warnings about a four-bar with something more in its joints, links and around."""
    text = PLUS.replace("</joint>", f"{more}</joint>").replace("</robot>", f"{robot}</robot>")
    text = text.replace('<link name="ground"/>', f'<link name="ground">{link}</link>')
    mechanism = cd.load(text)
    assert mechanism.warnings == cd.describe(mechanism).warnings
    prefix = "URDF text: "
    assert all(warning.startswith(prefix) for warning in mechanism.warnings)
    return [warning.removeprefix(prefix) for warning in mechanism.warnings]


def test_nothing_is_left_out_of_a_plain_description() -> None:
    assert warnings() == []
    assert warnings('<dynamics/><limit effort="inf" velocity="inf"/>') == []
    assert warnings('<dynamics damping="0.0" friction="0"/>') == []


@pytest.mark.parametrize("dynamics", ['damping="2"', 'friction="1e-9"', 'damping="-1"'])
def test_damping_and_friction(dynamics: str) -> None:
    assert warnings(f"<dynamics {dynamics}/>") == [
        "damping or friction of 3 joints (a, b, d): "
        "Scene(..., elements=described_elements(mechanism)) takes it in, as "
        "`cardan-dyn simulate` and `vibration` do; other scenes are without it"
    ]


def test_limits_and_other_elements_of_joints() -> None:
    more = '<limit effort="3" velocity="inf"/><calibration rising="0"/>'
    assert warnings(more + '<safety_controller k_velocity="1"/>') == [
        "safety controllers of 3 joints (a, b, d) left out: no wrench considers them",
        "calibrations of 3 joints (a, b, d) left out: no wrench considers them",
        "limits of 3 joints (a, b, d): they hold nothing back; results say where positions, "
        "speeds and efforts lie beyond them",
    ]


def test_elements_for_other_programs() -> None:
    other = '<transmission name="t"/><gazebo/><gazebo reference="a"><mu1>1</mu1></gazebo><drake/>'
    assert warnings(robot=other, link="<contact><stiffness value='1'/></contact>") == [
        "<contact> of 1 link (ground) left out: no wrench considers it",
        "<transmission> is for other programs and was passed over",
        "<gazebo> (2 times) is for other programs and was passed over",
        "<drake> is for other programs and was passed over",
    ]


@pytest.mark.parametrize(
    "limits", [{"lower": 0.0}, {"upper": 1.0}, {"velocity": 2.0}, {"effort": 0.0}]
)
def test_every_limit_counts(limits: dict[str, float]) -> None:
    (joint,) = cd.load("universal_joint").description.joints[:1]
    limited = JointDescription(
        *("j", joint.type, joint.parent, joint.child, joint.origin, joint.axis, joint.axis_2),
        limits=Limits(**limits),
    )
    assert len(limits_left_out([limited], "x")) == 1


def test_many_names_are_counted() -> None:
    (joint,) = cd.load("universal_joint").description.joints[:1]
    joints = [
        JointDescription(
            *(f"j{index}", joint.type, "a", "b", joint.origin, joint.axis, joint.axis_2),
            limits=Limits(effort=1.0),
        )
        for index in range(9)
    ]
    (line,) = limits_left_out(joints, "x")
    assert line.startswith("x: limits of 9 joints (j0, j1, j2 and 6 more): ")


def test_limits_of_mjcf() -> None:
    body = '<body><joint name="e" range="-10 10"/><inertial pos="0 0 0" mass="1" '
    text = f'<mujoco><worldbody>{body}diaginertia="1 1 1"/></body></worldbody></mujoco>'
    (line,) = cd.load(text).warnings
    assert line.startswith("MJCF text: limits of 1 joint (e): they hold")


def test_bundled_files_are_known(tmp_path: Path) -> None:
    """They have limits because URDF demands them; a copy of one is a file like any other."""
    bundled = bundled_directory() / "slider_crank.urdf"
    assert cd.load(bundled).warnings == cd.load("slider_crank").warnings == ()
    copied = tmp_path / "mine.urdf"
    copied.write_bytes(bundled.read_bytes())
    (line,) = cd.load(copied).warnings
    assert "mine.urdf: limits of 1 joint" in line


def test_numbers_that_are_left_out_are_numbers() -> None:
    with pytest.raises(cd.ModelError, match="joint 'a': dynamics damping: 'x' is not 1 finite"):
        warnings('<dynamics damping="x"/>')
    with pytest.raises(cd.ModelError, match="there are 2 <dynamics>"):
        warnings("<dynamics/><dynamics/>")
