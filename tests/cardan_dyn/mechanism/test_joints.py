"""Elementary parts of joint types."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import elementary
from cardan_dyn.core.mechanism.joints import Joint, Part, named_coordinates

AXIS = np.array([0.0, 0.6, 0.8])
AXIS_2 = np.array([1.0, 0.0, 0.0])
PARTS = {
    "fixed": [],
    "revolute": ["revolute"],
    "continuous": ["revolute"],
    "prismatic": ["prismatic"],
    "cylindrical": ["prismatic", "revolute"],
    "planar": ["prismatic", "prismatic", "revolute"],
    "universal": ["revolute", "revolute"],
    "spherical": ["spherical"],
    "floating": ["prismatic", "prismatic", "prismatic", "spherical"],
}


@pytest.mark.parametrize("kind", PARTS)
def test_types_are_made_of_their_parts(kind: str) -> None:
    assert [part for part, _ in elementary(kind, AXIS, AXIS_2)] == PARTS[kind]


def test_axes_of_parts() -> None:
    (_, first), (_, second) = elementary("universal", AXIS, AXIS_2)
    assert first.tolist() == AXIS.tolist() and second.tolist() == AXIS_2.tolist()
    for _, axis in elementary("cylindrical", AXIS, AXIS_2):
        assert axis.tolist() == AXIS.tolist()
    # The two slides of a planar joint and its normal are a right-handed system.
    axes = np.array([axis for _, axis in elementary("planar", AXIS, AXIS_2)])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    slides = np.array([axis for _, axis in elementary("floating", AXIS, AXIS_2)[:3]])
    np.testing.assert_array_equal(slides, np.eye(3))


def test_balls_written_as_turns_turn_about_x_then_y_then_z() -> None:
    for kind in ("spherical", "floating"):
        parts = elementary(kind, AXIS, AXIS_2, cardan=True)
        assert [part for part, _ in parts[-3:]] == ["revolute"] * 3
        np.testing.assert_array_equal([axis for _, axis in parts[-3:]], np.eye(3))
    for kind in PARTS.keys() - {"spherical", "floating"}:
        assert [part for part, _ in elementary(kind, AXIS, AXIS_2, True)] == PARTS[kind]


@pytest.mark.parametrize("kind", PARTS)
@pytest.mark.parametrize("cardan", [False, True])
def test_every_velocity_coordinate_has_a_name(kind: str, cardan: bool) -> None:
    chain = elementary(kind, AXIS, AXIS_2, cardan)
    parts = [Part(part, axis, 1 + index) for index, (part, axis) in enumerate(chain)]
    joint = Joint("j", kind, AXIS, tuple(parts))
    assert len(joint.coordinates) == joint.nv == len(set(joint.coordinates))
    assert joint.coordinates == ("j",) * joint.nv or all(
        name.startswith("j.") for name in joint.coordinates
    )
    found = named_coordinates([joint])
    assert [item.offset for item in found.values()] == list(range(joint.nv))
    # What is called a slide is one.
    expected = [part.kind == "prismatic" for part in parts for _ in range(part.nv)]
    assert [item.slides for item in found.values()] == expected
    assert joint.has_ball == (not cardan and kind in ("spherical", "floating"))


def test_a_joint_is_the_body_of_its_last_part() -> None:
    parts = (Part("prismatic", AXIS, 3), Part("spherical", AXIS, 4))
    joint = Joint("pin", "floating", AXIS, parts)
    assert (joint.id, joint.nv) == (4, 4)
    assert repr(joint) == "<Joint 'pin': floating>"
    bolt = Joint("bolt", "fixed", AXIS, ())
    assert (bolt.id, bolt.nv) == (0, 0)


def test_axes_cannot_be_written_to(joint: cd.Mechanism) -> None:
    record = joint["bearing_in"]
    for axis in (record.axis, record.parts[0].axis):
        with pytest.raises(ValueError, match="read-only"):
            axis[:] = 0.0
