"""Springs and bushings that are drawn: where they are, and how long."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

import cardan_dyn as cd
from cardan_dyn.viewer.commands import Drawing
from cardan_dyn.viewer.element_shapes import coil, draw_elements

ELEMENTS = [
    cd.PointSpring("crank", (0.1, 0.0, 0.0), "base", (0.1, 0.2, 0.0), 500.0, name="coil"),
    cd.Bushing("coupler", "rocker", (0.3, 0.0, 0.0), np.arange(1.0, 7.0)),
    cd.JointSpring("rocker_bearing", 5.0),
]
SAMPLES = np.arange(4)


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=ELEMENTS)
    return scene.sweep([0.0, 0.5, 1.0, 1.5])


def placed(drawing: Drawing, path: str) -> dict[str, np.ndarray]:
    return {
        item["property"]: np.array(item["value"])
        for item in drawing.commands
        if item["type"] == "set_property" and item["path"] == path
    }


def test_a_spring_starts_at_its_first_point_and_is_as_long_as_it_is(turn: cd.Sweep) -> None:
    drawing = Drawing(1.0, np.linspace(0.0, 1.0, 4))
    drawn = draw_elements(drawing, turn, SAMPLES, 1.0)
    spring = placed(drawing, "/elements/coil")
    crank = turn.rotation("crank_bearing")[0] @ [0.1, 0.0, 0.0] + turn.origin("crank_bearing")[0]
    np.testing.assert_allclose(spring["position"], crank, atol=1e-15)
    np.testing.assert_allclose(spring["scale"], [1.0, 1.0, turn.element_force["coil"].length[0]])
    x, y, z, w = spring["quaternion"]
    direction = np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(crank + direction * spring["scale"][2], [0.1, 0.2, 0.0], atol=1e-12)
    assert drawn.points.shape == (12, 3)


def test_only_elements_with_a_place_are_drawn(turn: cd.Sweep) -> None:
    drawing = Drawing(1.0, np.linspace(0.0, 1.0, 4))
    drawn = draw_elements(drawing, turn, SAMPLES, 1.0)
    paths = [item["path"] for item in drawing.commands if item["type"] == "set_object"]
    assert paths == ["/elements/coil", "/elements/1"]
    assert [text for _, text in drawn.legend] == ["spring between two points", "bushing"]


def test_views_show_them_unless_they_are_switched_off(turn: cd.Sweep) -> None:
    assert "spring between two points" in cd.view(turn).html
    assert "spring between two points" not in cd.view(turn, elements=False).html


def test_a_coil_has_the_length_one() -> None:
    points = coil(0.1)
    assert points[0].tolist() == [0.0, 0.0, 0.0]
    assert points[-1].tolist() == [0.0, 0.0, 1.0]
    assert np.max(np.hypot(*points[:, :2].T)) == pytest.approx(0.1)
