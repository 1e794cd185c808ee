"""Mechanisms written to files: the zero of their coordinates may be any closed configuration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from testkit import linkages, sdf
from testkit.bundled import EVERY_KIND
from testkit.kinematics import at_zero

import cardan_dyn as cd
from cardan_dyn.scene.usual_motion import usual_motion


def placed(mechanism: cd.Mechanism, q: np.ndarray) -> dict[str, np.ndarray]:
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, q)
    return {
        name: (data.oMi[body] * frame).homogeneous
        for name, (body, frame) in mechanism.links.items()
    }


MASSLESS = {"thoma_rig": 1, "elastic_thoma_rig": 2}
"""Links between two joints without mass, for which MJCF has no body."""


@pytest.mark.parametrize("suffix", ["urdf", "xml"])
@pytest.mark.parametrize("name", ["thoma_rig", *EVERY_KIND])
def test_links_stand_at_zero_where_they_stood(tmp_path: Path, name: str, suffix: str) -> None:
    mechanism = cd.load(name)
    motion = usual_motion(mechanism, samples=9).sweep().motion
    at = {joint: motion.position(joint)[5] for joint in mechanism if mechanism[joint].parts}
    path = cd.write(mechanism, tmp_path / f"{name}.{suffix}", at=at)
    assert path == tmp_path / f"{name}.{suffix}"
    again = cd.load(path)
    expected, found = placed(mechanism, motion.q[5]), placed(again, pin.neutral(again.model))
    for link in set(expected) & set(found):
        np.testing.assert_allclose(found[link], expected[link], atol=1e-13)
    massless = MASSLESS.get(name, 0) if suffix == "xml" else 0
    assert len(set(expected) - set(found)) == massless
    # Where loops are closed at zero, assembling moves nothing.
    for loop in again.loops:
        ends = [
            item.homogeneous
            for item in (
                at_zero(again)[loop.predecessor] * loop.predecessor_placement,
                at_zero(again)[loop.successor] * loop.successor_placement,
            )
        ]
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-13)


def test_without_a_configuration_the_zero_stays(tmp_path: Path) -> None:
    mechanism = cd.load("needle_drive")
    path = cd.write(mechanism, str(tmp_path / "a.urdf"))
    assert path.read_text(encoding="utf-8") == mechanism.to_urdf()


def test_any_notation_becomes_any_other(tmp_path: Path) -> None:
    """A four-bar from SDF to URDF+ to MJCF and back: the effort of its drive stays."""
    mechanism = cd.load(sdf.four_bar())
    scene = {"drive": "a", "loads": {"d": -3.0}, "gravity": (0.0, -9.0, 0.0)}
    reference = cd.Scene(mechanism, **scene).sweep(linkages.POSITIONS, **linkages.RATES)
    for suffix in ("urdf", "mjcf", "urdf", "xml"):
        mechanism = cd.load(cd.write(mechanism, tmp_path / f"four_bar.{suffix}"))
        found = cd.Scene(mechanism, **scene).sweep(linkages.POSITIONS, **linkages.RATES)
        np.testing.assert_allclose(
            found.drive_effort,
            reference.drive_effort,
            atol=1e-11 * np.max(np.abs(reference.drive_effort)),
        )
        assert sdf.compare(found, reference, 1e-10, decided=True)


def test_sites_of_loops_are_told_from_those_of_the_author(tmp_path: Path) -> None:
    """An author's site may be called as the end of a loop would be, and lie elsewhere."""
    mass = '<inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
    text = f"""<mujoco><compiler angle="radian"/><worldbody>
    <body name="a"><joint name="a" axis="0 0 1"/>{mass}<site name="c_predecessor" pos="0.3 0 0"/>
    <body name="b" pos="0.1 0 0"><joint name="b" axis="0 0 1"/>{mass}</body></body>
    <body name="d" pos="0.3 0 0"><joint name="d" axis="0 0 1"/>{mass}</body></worldbody>
    <equality><connect name="c" body1="b" body2="d" anchor="0.2 0.2 0"/></equality></mujoco>"""
    first = cd.load(text)
    again = cd.load(cd.write(first, tmp_path / "bar.xml"))
    third = cd.load(cd.write(again, tmp_path / "more.xml"))
    assert {*again.description.own_frames} == {*third.description.own_frames} == {"c_predecessor"}
    np.testing.assert_array_equal(third.description.frames["c_predecessor"][1][:3, 3], [0.3, 0, 0])
    efforts = [
        cd.Scene(item, drive="a", gravity=(0, -9.81, 0)).sweep([0.1, 0.2]).drive_effort
        for item in (first, third)
    ]
    np.testing.assert_allclose(*efforts, rtol=0, atol=1e-12)
    with pytest.warns(UserWarning, match=r"no word for it: frame 'c_predecessor'; gravity$"):
        cd.write(third, tmp_path / "bar.urdf")


def test_what_is_wrong_with_a_configuration(tmp_path: Path) -> None:
    mechanism = cd.load("four_bar")
    path = tmp_path / "a.urdf"
    with pytest.raises(cd.ArgumentError, match="there is no position of crank_pin, rocker"):
        cd.write(mechanism, path, at={"crank_bearing": 0.1})
    with pytest.raises(cd.ArgumentError, match="the loop 'rocker_pin' is open by"):
        cd.write(mechanism, path, at=dict.fromkeys(mechanism, 0.3))
    assert not path.exists()
