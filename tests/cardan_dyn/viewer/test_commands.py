"""Drawings: colours, poses, paths, and what the page reads of them."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from cardan_dyn.practice.viewer.commands import (
    STEADY,
    Arrays,
    Color,
    Drawing,
    Place,
    Pose,
    meshcat,
    node_name,
)

TRIANGLE = (np.eye(3), np.array([[0, 1, 2]], dtype=np.uint32))


def read(arrays: Arrays, place: Place) -> np.ndarray:
    """Numbers of a page at a place."""
    content = base64.b64decode(arrays.base64())
    assert place.at % 8 == 0  # Where a typed array of any kind may start.
    return np.frombuffer(content, f"<{place.kind}", place.size, place.at)


def packed(drawing: Drawing) -> tuple[dict[str, Any], Arrays]:
    arrays = Arrays()
    return drawing.packed(arrays), arrays


def test_colors_in_all_notations() -> None:
    color = Color.of("#ff8000", opacity=0.5, layer=2)
    assert (color.red, color.green, color.blue) == pytest.approx((1.0, 128 / 255, 0.0))
    assert (color.opacity, color.layer) == (0.5, 2)
    assert color.css == "#ff8000"


def test_names_stay_one_step_of_a_path() -> None:
    assert node_name("arm/left") == "arm∕left"
    assert "/" not in node_name("a/b/c")
    assert node_name("") == "-"


def test_a_pose_is_neither_turned_nor_scaled_by_default() -> None:
    pose = Pose(np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(pose.position, [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(pose.quaternion, [[0.0, 0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(pose.scale, [[1.0, 1.0, 1.0]])


def test_only_what_moves_has_a_track() -> None:
    size = 2.0
    drawing = Drawing(size)
    steps = np.arange(3.0)[:, None] * [1.0, 0.0, 0.0]
    drawing.nodes["/still"] = Pose(steps * 0.4 * STEADY * size)
    drawing.nodes["/moving"] = Pose(steps, scale=np.array([1.0, 2.0, 1.0]))
    data, arrays = packed(drawing)
    still, moving = data["nodes"]
    assert still == {
        "path": "/still",
        "position": [0.0, 0.0, 0.0],
        "quaternion": [0.0, 0.0, 0.0, 1.0],
        "scale": [1.0, 1.0, 1.0],
    }
    np.testing.assert_array_equal(read(arrays, moving["position"]).reshape(-1, 3), steps)
    np.testing.assert_array_equal(
        read(arrays, moving["scale"]).reshape(-1, 3), [[1.0] * 3, [2.0] * 3, [1.0] * 3]
    )
    assert moving["quaternion"] == [0.0, 0.0, 0.0, 1.0]


def test_equal_arrays_and_shapes_are_written_once() -> None:
    drawing = Drawing(1.0)
    for path in ("/a", "/b"):
        drawing.add(path, TRIANGLE, Color.of("#000000"))
    drawing.add("/c", (2.0 * TRIANGLE[0], TRIANGLE[1]), Color.of("#000000"))
    data, arrays = packed(drawing)
    assert [item["shape"] for item in data["objects"]] == [0, 0, 1]
    (vertices, faces), (others, same) = data["shapes"]
    np.testing.assert_array_equal(read(arrays, vertices), np.eye(3).ravel())
    np.testing.assert_array_equal(read(arrays, others), 2.0 * np.eye(3).ravel())
    assert same == faces and faces.kind == "u2" and list(read(arrays, faces)) == [0, 1, 2]
    assert len(base64.b64decode(arrays.base64())) == 2 * 40 + 8


def test_shapes_of_more_vertices_than_16_bits_count() -> None:
    count = 65536
    faces = np.array([[0, 1, count - 1]])
    drawing = Drawing(1.0)
    drawing.add("/a", (np.zeros((count, 3)), faces), Color.of("#000000"))
    data, arrays = packed(drawing)
    assert list(read(arrays, data["shapes"][0][1])) == [0, 1, count - 1]


def test_the_legend_says_each_meaning_once() -> None:
    drawing = Drawing(1.0)
    for path in ("/axes/a", "/axes/b", "/loads/a"):
        drawing.add(path, TRIANGLE, Color.of("#000000"), means="black", pose=Pose(np.ones(3)))
    assert drawing.legend == [("#000000", "black", "axes"), ("#000000", "black", "loads")]
    assert list(drawing.nodes) == ["/axes/a", "/axes/b", "/loads/a"]


def test_objects_on_top_have_layers_and_placements_are_written_by_columns() -> None:
    drawing = Drawing(1.0)
    placement = np.eye(4)
    placement[:3, 3] = [1.0, 2.0, 3.0]
    drawing.add("/a", TRIANGLE, Color.of("#000000"))
    top = Color.of("#000000", opacity=0.5, layer=3)
    drawing.add("/b", TRIANGLE, top, placement)
    plain, above = packed(drawing)[0]["objects"]
    assert plain == {"path": "/a", "shape": 0, "color": "#000000", "opacity": 1.0, "layer": 0}
    assert above["layer"] == 3 and above["opacity"] == 0.5
    assert above["placement"][12:15] == [1.0, 2.0, 3.0]


def test_labels_are_placed_and_listed() -> None:
    drawing = Drawing(1.0)
    drawing.label("/labels/a", "text", Color.of("#123456"), Pose(np.ones(3)))
    data, _ = packed(drawing)
    assert data["labels"] == [{"path": "/labels/a", "text": "text", "color": "#123456"}]
    assert data["nodes"][0]["path"] == "/labels/a"


def test_the_script_that_draws_is_part_of_the_package() -> None:
    assert len(meshcat()) > 100_000
