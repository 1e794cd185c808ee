"""Commands for meshcat's viewer: colours, tracks, paths and labels."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

from cardan_dyn.viewer.commands import STEADY, Color, Drawing, Pose, mesh, meshcat, node_name


def test_colors_in_all_notations() -> None:
    color = Color.of("#ff8000", opacity=0.5, layer=2)
    assert (color.red, color.green, color.blue) == pytest.approx((1.0, 128 / 255, 0.0))
    assert (color.opacity, color.on_top, color.layer) == (0.5, False, 2)
    assert color.css == "#ff8000" and color.number == 0xFF8000


def test_names_stay_one_step_of_a_path() -> None:
    assert node_name("arm/left") == "arm∕left"
    assert "/" not in node_name("a/b/c")
    assert node_name("") == "-"


def test_a_pose_is_neither_turned_nor_scaled_by_default() -> None:
    pose = Pose.of(np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(pose.position, [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(pose.quaternion, [[0.0, 0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(pose.scale, [1.0])


def animation(drawing: Drawing) -> list[dict]:
    """What the last command animates, read back from msgpack."""
    import umsgpack

    last = umsgpack.unpackb(drawing.packed()[-1])
    return last["animations"] if last["type"] == "set_animation" else []


def test_only_what_moves_has_a_track() -> None:
    size, times = 2.0, np.array([0.0, 0.5, 1.0])
    drawing = Drawing(size, times)
    steps = np.arange(3.0)[:, None] * [1.0, 0.0, 0.0]
    drawing.place("/still", Pose.of(steps * 0.4 * STEADY * size))
    assert animation(drawing) == []
    drawing.place("/moving", Pose.of(steps, scale=np.array([1.0, 2.0, 1.0])))
    (moving,) = animation(drawing)
    assert moving["path"] == "/moving"
    tracks = {track["name"]: track for track in moving["clip"]["tracks"]}
    assert set(tracks) == {".position", ".scale"}
    values = np.frombuffer(tracks[".position"]["values"].data, dtype="<f4")
    np.testing.assert_array_equal(values.reshape(-1, 3), steps)
    instants = np.frombuffer(tracks[".scale"]["times"].data, dtype="<f4")
    np.testing.assert_array_equal(instants, times)


def test_a_single_sample_is_placed_without_animation() -> None:
    drawing = Drawing(1.0, np.zeros(1))
    drawing.place("/a", Pose.of(np.array([[1.0, 2.0, 3.0]])))
    assert animation(drawing) == []
    assert [command["property"] for command in drawing.commands] == [
        "position",
        "quaternion",
        "scale",
    ]
    assert drawing.commands[0]["value"] == [1.0, 2.0, 3.0]


def test_objects_on_top_are_drawn_in_the_order_of_their_layers() -> None:
    drawing = Drawing(1.0, np.zeros(1))
    surface = (np.eye(3), np.array([[0, 1, 2]], dtype=np.uint32))
    drawing.add("/a", mesh(surface), Color.of("#000000"))
    drawing.add("/b", mesh(surface), Color.of("#000000", on_top=True, layer=3), np.eye(4))
    kinds = [command["type"] for command in drawing.commands]
    assert kinds == ["set_object", "set_object", "set_property", "set_transform"]
    first, second = (command["object"]["materials"][0] for command in drawing.commands[:2])
    assert first["depthTest"] and not second["depthTest"]
    assert drawing.commands[2]["property"] == "renderOrder" and drawing.commands[2]["value"] == 4


def test_labels_are_placed_and_listed() -> None:
    drawing = Drawing(1.0, np.zeros(1))
    drawing.label("/labels/a", "text", Color.of("#123456"), Pose.of(np.ones(3)))
    assert drawing.labels == [("/labels/a", "text", "#123456")]
    assert drawing.commands[0]["path"] == "/labels/a"


def test_the_viewers_script_is_part_of_the_package() -> None:
    assert len(meshcat().script) > 100_000
