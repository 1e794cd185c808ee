"""Elements along coordinates: where they stand, how they turn, and how great they are."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from testkit.drawn import placed

import cardan_dyn as cd
from cardan_dyn.core.elements.joint_elements import JointElement
from cardan_dyn.core.elements.link_motions import LinkMotion
from cardan_dyn.core.mechanism.joints import Part
from cardan_dyn.practice.viewer import element_shapes as shapes
from cardan_dyn.practice.viewer.commands import Drawing
from cardan_dyn.practice.viewer.places import Axis
from cardan_dyn.practice.viewer.shapes import ARROW

TIMES = np.array([0.0, 1.0])
X = np.array([0.3, -0.5])


def axis(kind: str) -> Axis:
    """Axis along y of the world, at (1, 0, 0) and moved there by 0.3 and -0.5."""
    y = np.array([0.0, 1.0, 0.0])
    cosine, sine, none = np.cos(X), np.sin(X), np.zeros(2)
    turned = np.array([[cosine, none, sine], [none, none + 1.0, none], [-sine, none, cosine]])
    slides = kind == "prismatic"
    rotation = np.tile(np.eye(3), (2, 1, 1)) if slides else turned.transpose(2, 0, 1)
    position = np.array([1.0, 0.0, 0.0]) + (X[:, None] * y if slides else np.zeros((2, 1)))
    child = LinkMotion(rotation, position, np.zeros((2, 3)), np.zeros((2, 3)))
    return Axis(Part(kind, y, 1), child, X, np.zeros(2), TIMES, np.zeros(3))


def drawn(element: JointElement, kind: str) -> Drawing:
    drawing = Drawing(2.0)
    shapes.draw_along(drawing, "/e", element, axis(kind))
    assert len(drawing.legend) == 1
    return drawing


def efforts(kind: str, *efforts: object) -> Drawing:
    """Arrows of actuators at one axis, whose nodes are /0, /1, …"""
    drawing = Drawing(2.0)
    at = axis(kind)
    told = [np.broadcast_to(np.asarray(item, float), 2) for item in efforts]
    shapes.draw_efforts(drawing, [(f"/{k}", item, at) for k, item in enumerate(told)])
    return drawing


def turned_z(quaternion: np.ndarray) -> np.ndarray:
    """Where a quaternion x, y, z, w leads z."""
    x, y, z, w = quaternion
    return np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])


def turned_x(quaternion: np.ndarray) -> np.ndarray:
    x, y, z, w = quaternion
    return np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])


def test_the_end_of_a_spiral_meets_its_pin_where_the_spring_is_at_rest() -> None:
    drawing = drawn(cd.JointSpring("j", 5.0, rest=0.3), "revolute")
    spiral, pin = placed(drawing, "/e/spiral"), placed(drawing, "/e/rest")
    for node in (spiral, pin):
        np.testing.assert_allclose(turned_z(node["quaternion"]), [0, 1, 0], atol=1e-15)
        assert node["position"].tolist() == [1.0, 0.0, 0.0]
    np.testing.assert_allclose(
        turned_x(spiral["quaternion"]), turned_x(pin["quaternion"]), atol=1e-15
    )
    drawing = drawn(cd.JointSpring("j", 5.0, rest=1.0), "revolute")
    ends = [turned_x(placed(drawing, path)["quaternion"]) for path in ("/e/spiral", "/e/rest")]
    # The pin stands 0.7 rad further in the sense of the turn, that from z to x.
    assert np.dot(*ends) == pytest.approx(np.cos(0.7))
    assert np.cross(*ends) @ [0, 1, 0] == pytest.approx(np.sin(0.7))


def test_a_coil_along_a_slide_is_stretched_with_it() -> None:
    drawing = drawn(cd.JointSpring("j", 5.0, rest=0.1), "prismatic")
    coil = placed(drawing, "/e")
    # Most pressed at -0.5, by 0.6, where a quarter of the scene's radius is left: 0.5 m.
    assert coil["scale"].tolist() == pytest.approx([2.0, 2.0, 0.5 + 0.8])
    np.testing.assert_allclose(coil["position"], [1.0, 0.3 - 1.3, 0.0], atol=1e-15)


def test_a_spring_without_stiffness_is_a_damper() -> None:
    for kind in ("revolute", "prismatic"):
        drawing = drawn(cd.JointSpring("j", 0.0, damping=1.0), kind)
        assert [item.text for item in drawing.legend] == ["damper"]


def test_shoes_stay_with_the_parent_and_the_ring_turns() -> None:
    drawing = drawn(cd.JointFriction("j", 2.0), "revolute")
    ring, shoes = placed(drawing, "/e/ring"), placed(drawing, "/e/shoes")
    between = turned_x(ring["quaternion"]) @ turned_x(shoes["quaternion"])
    assert between == pytest.approx(np.cos(0.3))
    drawing = drawn(cd.JointFriction("j", 2.0), "prismatic")
    assert placed(drawing, "/e/rod")["position"].tolist() == [1.0, 0.0, 0.0]
    assert placed(drawing, "/e/pads")["position"].tolist() == [1.0, 0.3, 0.0]


def test_an_arrow_is_as_great_as_the_effort_and_turns_with_its_sign() -> None:
    arrow = placed(efforts("prismatic", -4.0, 8.0), "/0")
    np.testing.assert_allclose(turned_z(arrow["quaternion"]), [0, -1, 0], atol=1e-12)
    assert arrow["scale"][0] == pytest.approx(0.5 * 2.0 * ARROW)
    arc = placed(efforts("revolute", 2.0 - TIMES, 8.0), "/0")
    np.testing.assert_allclose(turned_z(arc["quaternion"]), [0, 1, 0], atol=1e-12)
    assert arc["scale"][0] == pytest.approx(0.25 * 2.0 * shapes.ARC_RADIUS)


def test_an_actuator_without_effort_has_no_arrow() -> None:
    assert efforts("revolute", 0.0).objects == []
