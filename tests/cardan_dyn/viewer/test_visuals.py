"""Shapes of links: where visuals stand on bodies, how they are drawn, what is said of others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")

import cardan_dyn as cd
from cardan_dyn.practice.viewer.meshes import read_mesh
from cardan_dyn.practice.viewer.visuals import Shape, few_enough, shapes_of, surface_of

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
STL = "solid t\nfacet normal 0 0 1\nouter loop\n{}endloop\nendfacet\nendsolid t\n"
TRIANGLE = STL.format("vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n")
WHITE = (1.0, 1.0, 1.0, 1.0)


def described(visuals: str, more: str = "") -> cd.Mechanism:
    """A link that turns, with these visuals."""
    return cd.load(
        f'<robot name="r"><link name="a"/><link name="b">{visuals}</link>{more}'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )


def visual(geometry: str, origin: str = "", material: str = "") -> str:
    return f"<visual>{origin}<geometry>{geometry}</geometry>{material}</visual>"


def only(mechanism: cd.Mechanism) -> Shape:
    (shape,), notes = shapes_of(mechanism)
    assert notes == ()
    return shape


@pytest.mark.parametrize(
    ("kind", "size", "half"),
    [
        ("box", (1.0, 2.0, 4.0), (0.5, 1.0, 2.0)),
        ("cylinder", (0.5, 3.0), (0.5, 0.5, 1.5)),
        ("capsule", (0.5, 3.0), (0.5, 0.5, 2.0)),
        ("sphere", (2.0,), (2.0, 2.0, 2.0)),
        ("ellipsoid", (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    ],
)
def test_corners(kind: str, size: tuple[float, ...], half: tuple[float, float, float]) -> None:
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = QUARTER, (1.0, 2.0, 3.0)
    corners = Shape("b", 1, kind, placement, WHITE, surface_of(kind, size)).corners()
    # A quarter turn about z swaps the extents along x and y.
    extent = np.array([half[1], half[0], half[2]])
    assert corners.shape == (8, 3) and len(np.unique(corners.round(9), axis=0)) == 8
    np.testing.assert_allclose(np.abs(corners - (1.0, 2.0, 3.0)), np.tile(extent, (8, 1)))


def test_corners_of_a_mesh_enclose_its_vertices_and_a_floor_has_none() -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, -2.0, 0.5], [0.5, 3.0, 0.25]])
    placement = np.eye(4)
    placement[:3, 3] = (10.0, 0.0, 0.0)
    shape = Shape("b", 1, "mesh", placement, WHITE, (vertices, np.zeros((0, 3), int)))
    np.testing.assert_array_equal(np.min(shape.corners(), axis=0), (10.0, -2.0, 0.0))
    np.testing.assert_array_equal(np.max(shape.corners(), axis=0), (11.0, 3.0, 0.5))
    floor = surface_of("plane", (0.0, 0.0))
    assert len(Shape("b", 1, "plane", placement, WHITE, floor).corners()) == 0


@pytest.mark.parametrize(
    ("kind", "size", "extent"),
    [
        ("capsule", (0.5, 3.0), (0.5, 0.5, 2.0)),
        ("ellipsoid", (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
        ("mesh", (), (1.0, 1.0, 0.0)),
    ],
)
def test_what_is_drawn_reaches_its_corners(
    kind: str, size: tuple[float, ...], extent: tuple[float, ...]
) -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    triangle = vertices, np.array([[0, 1, 2]])
    surface = surface_of(kind, size) if size else triangle
    drawn, _ = Shape("b", 1, kind, np.eye(4), WHITE, surface).drawn(1.0)
    np.testing.assert_allclose(np.max(drawn, axis=0), extent, atol=1e-12)


def test_a_plane_without_end_is_drawn_as_large_as_the_scene() -> None:
    shape = Shape("b", 1, "plane", np.eye(4), WHITE, surface_of("plane", (0.0, 0.5)))
    width, depth, height = np.ptp(shape.drawn(2.0)[0], axis=0)
    assert (width, depth) == (6.0, 0.5) and 0.0 < height < 0.01


def test_shapes_of_a_fixed_link_belong_to_the_body_that_carries_it() -> None:
    ball = visual('<sphere radius="1"/>')
    mechanism = described(
        "",
        f'<link name="c">{ball}</link><joint name="f" type="fixed">'
        '<parent link="b"/><child link="c"/><origin xyz="0 0 5"/></joint>',
    )
    shape = only(mechanism)
    assert shape.link == "c" and shape.body == mechanism.joint("j").id
    np.testing.assert_allclose(shape.placement[:3, 3], (0.0, 0.0, 5.0))


def test_collision_shapes_are_not_drawn() -> None:
    collision = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    assert shapes_of(described(collision)) == ([], ())
    assert only(described(collision + visual('<sphere radius="1"/>'))).kind == "sphere"


@pytest.mark.parametrize("name", sorted(cd.bundled_names()))
def test_every_bundled_description_has_shapes(name: str) -> None:
    shapes, notes = shapes_of(cd.load(name))
    assert shapes and notes == ()


@pytest.mark.parametrize("kind", ["universal", "cylindrical", "spherical"])
def test_joints_of_more_types_than_urdf_has(kind: str) -> None:
    mechanism = cd.load(
        '<robot name="r"><link name="a"/><link name="b"><visual><geometry>'
        '<sphere radius="2"/></geometry></visual></link>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>'
        '<origin xyz="1 2 3"/><axis xyz="0 0 1"/></joint></robot>'
    )
    shape = only(mechanism)
    assert shape.link == "b" and shape.body == mechanism.joint("j").id
    np.testing.assert_allclose(shape.placement, np.eye(4), atol=1e-15)


def test_links_of_mjcf_stand_where_their_bodies_do() -> None:
    model = """<mujoco model="m"><worldbody><body name="b" pos="0 0 1">
      <joint name="j" axis="0 0 1" pos="1 0 0"/>
      <geom type="sphere" size="1" mass="1" pos="0 2 0"/></body></worldbody></mujoco>"""
    shape = only(cd.load(model))
    # The body's frame in the model is that of the joint, one metre along x.
    np.testing.assert_allclose(shape.placement[:3, 3], (-1.0, 2.0, 0.0))


def test_visuals_that_cannot_be_read_are_noted_and_others_drawn() -> None:
    broken = visual('<box size="1 2"/>')
    (shape,), (note,) = shapes_of(described(visual('<sphere radius="1"/>') + broken))
    assert shape.kind == "sphere"
    assert note.startswith("link 'b': a visual is not drawn: box size: '1 2'")


def test_meshes_are_shown_and_missing_ones_are_noted(tmp_path: Path) -> None:
    (tmp_path / "part.stl").write_text(TRIANGLE)
    names = ("part.stl", "gone.stl", f"package://{tmp_path.name}/part.stl", "gone_too.stl")
    text = described("".join(visual(f'<mesh filename="{name}"/>') for name in names))
    file = tmp_path / "robot.urdf"
    assert text.description.source is not None
    file.write_text(text.description.source.text)
    shown, (note,) = shapes_of(cd.load(file))
    assert [(shape.kind, *map(len, shape.surface)) for shape in shown] == [
        ("mesh", 3, 1),
        ("mesh", 3, 1),
    ]
    assert note == (
        "2 meshes were not found: 'gone.stl' (link 'b'), 'gone_too.stl' (link 'b'); "
        f"looked in {tmp_path}"
    )


def test_a_broken_mesh_is_noted_once(tmp_path: Path) -> None:
    file = tmp_path / "part.stl"
    file.write_text("nothing of a mesh")
    shown, (note,) = shapes_of(described(2 * visual(f'<mesh filename="{file}"/>')))
    assert shown == []
    assert note.startswith(f"link 'b': {file}: the mesh ")


def test_a_note_names_few_of_many_missing_meshes() -> None:
    many = "".join(visual(f'<mesh filename="/none/{k}.stl"/>') for k in range(9))
    _, (note,) = shapes_of(described(many))
    assert note.startswith("9 meshes were not found: '/none/0.stl' (link 'b'), ")
    assert "'/none/5.stl' (link 'b') and 3 more; looked in" in note


def test_meshes_are_scaled_and_placed(tmp_path: Path) -> None:
    file = tmp_path / "part.stl"
    file.write_text(TRIANGLE)
    origin = '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'
    shape = only(described(visual(f'<mesh filename="{file}" scale="2 -3 1"/>', origin)))
    points = shape.surface[0] @ shape.placement[:3, :3].T + shape.placement[:3, 3]
    np.testing.assert_allclose(np.min(points, axis=0), (1.0, 2.0, 3.0), atol=1e-12)
    np.testing.assert_allclose(np.max(points, axis=0), (4.0, 4.0, 3.0), atol=1e-12)
    # One negative factor mirrors it; it is still seen from above.
    first, second, third = points[shape.surface[1][0]]
    assert np.cross(second - first, third - first)[2] > 0.0


def test_a_stated_color_counts_before_that_of_the_file(tmp_path: Path) -> None:
    file = tmp_path / "part.obj"
    (tmp_path / "part.mtl").write_text("newmtl red\nKd 1 0 0\n")
    file.write_text("mtllib part.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    stated = '<material name="m"><color rgba="0 0 1 1"/></material>'
    red = only(described(visual(f'<mesh filename="{file}"/>')))
    blue = only(described(visual(f'<mesh filename="{file}"/>', material=stated)))
    assert (red.color, blue.color) == ((1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0))


def test_huge_meshes_are_thinned_with_a_note() -> None:
    side = np.linspace(0.0, 1.0, 300)
    across, up = (grid.flatten() for grid in np.meshgrid(side, side))
    vertices = np.stack([across, up, 0.1 * np.sin(9.0 * across)], axis=1)
    start = (np.arange(299)[:, None] * 300 + np.arange(299)).flatten()[:, None]
    faces = np.concatenate([start + np.array(corners) for corners in ([0, 1, 301], [0, 301, 300])])
    shape = Shape("b", 1, "mesh", np.eye(4), None, (vertices, faces))
    few, note = few_enough([shape], 1.0)
    assert note == f"meshes are drawn with {len(few[0].surface[1])} of their {len(faces)} triangles"
    assert len(few[0].surface[1]) < 100_000 < len(faces)
    np.testing.assert_allclose(few[0].corners(), shape.corners(), atol=0.02)
    few, note = few_enough([shape], 1e-6)
    assert few[0].surface[1] is faces and note == ""  # They would be unknowable.
    small = Shape("b", 1, "mesh", np.eye(4), None, (vertices, faces[:9]))
    assert few_enough([small], 1.0) == ([small], "")


def test_a_file_is_read_once_however_often_it_is_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "part.stl"
    file.write_text(TRIANGLE)
    read: list[Path] = []

    def counted(path: Path, part: str = "") -> object:
        read.append(path)
        return read_mesh(path, part)

    monkeypatch.setattr("cardan_dyn.practice.viewer.visuals.read_mesh", counted)
    shapes, _ = shapes_of(described(5 * visual(f'<mesh filename="{file}"/>')))
    assert len(shapes) == 5 and read == [file]
