"""Shapes of links: what is read from a description, where it is placed, and what is left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.viewer.bodies import Shape, shapes_of

TURNED = '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
STL = "solid t\nfacet normal 0 0 1\nouter loop\n{}endloop\nendfacet\nendsolid t\n"
TRIANGLE = STL.format("vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n")


def described(visuals: str, more: str = "") -> cd.Mechanism:
    """A link that turns, with these visuals."""
    return cd.load(
        f'<robot name="r"><link name="a"/><link name="b">{visuals}</link>{more}'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )


def visual(geometry: str, origin: str = "", material: str = "") -> str:
    return f"<visual>{origin}<geometry>{geometry}</geometry>{material}</visual>"


@pytest.mark.parametrize(
    ("geometry", "kind", "size", "half"),
    [
        ('<box size="1 2 4"/>', "box", (1.0, 2.0, 4.0), (0.5, 1.0, 2.0)),
        ('<cylinder radius="0.5" length="3"/>', "cylinder", (0.5, 3.0), (0.5, 0.5, 1.5)),
        ('<sphere radius="2"/>', "sphere", (2.0,), (2.0, 2.0, 2.0)),
    ],
)
def test_kinds_sizes_and_corners(
    geometry: str, kind: str, size: tuple[float, ...], half: tuple[float, float, float]
) -> None:
    color = '<material name="m"><color rgba="0.2 0.4 0.6 0.5"/></material>'
    (shape,) = shapes_of(described(visual(geometry, TURNED, color)))
    assert (shape.link, shape.kind) == ("b", kind)
    assert shape.size == pytest.approx(size)
    assert shape.color == pytest.approx((0.2, 0.4, 0.6, 0.5))
    np.testing.assert_allclose(shape.placement[:3, :3], QUARTER, atol=1e-15)
    np.testing.assert_allclose(shape.placement[:3, 3], (1.0, 2.0, 3.0))
    # A quarter turn about z swaps the extents along x and y.
    extent = np.array([half[1], half[0], half[2]])
    corners = shape.corners()
    assert corners.shape == (8, 3) and len(np.unique(corners.round(9), axis=0)) == 8
    np.testing.assert_allclose(np.abs(corners - (1.0, 2.0, 3.0)), np.tile(extent, (8, 1)))


def test_corners_of_a_mesh_enclose_its_vertices() -> None:
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, -2.0, 0.5], [0.5, 3.0, 0.25]])
    placement = np.eye(4)
    placement[:3, 3] = (10.0, 0.0, 0.0)
    shape = Shape("b", 1, "mesh", (), placement, (1, 1, 1, 1), vertices, np.zeros((0, 3), int))
    np.testing.assert_array_equal(np.min(shape.corners(), axis=0), (10.0, -2.0, 0.0))
    np.testing.assert_array_equal(np.max(shape.corners(), axis=0), (11.0, 3.0, 0.5))


def test_shapes_of_a_fixed_link_belong_to_the_body_that_carries_it() -> None:
    ball = visual('<sphere radius="1"/>')
    mechanism = described(
        "",
        f'<link name="c">{ball}</link><joint name="f" type="fixed">'
        '<parent link="b"/><child link="c"/><origin xyz="0 0 5"/></joint>',
    )
    (shape,) = shapes_of(mechanism)
    assert shape.link == "c" and shape.body == mechanism.joint("j").id
    np.testing.assert_allclose(shape.placement[:3, 3], (0.0, 0.0, 5.0))


def test_collision_shapes_are_not_drawn(capfd: pytest.CaptureFixture[str]) -> None:
    collision = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    assert shapes_of(described(collision)) == []
    (shape,) = shapes_of(described(collision + visual('<sphere radius="1"/>')))
    assert shape.kind == "sphere"
    # Nor are they read: Pinocchio's reader would print what is malformed.
    malformed = collision.replace("1 1 1", "1")
    (shape,) = shapes_of(described(malformed + visual('<sphere radius="1"/>')))
    assert shape.kind == "sphere"
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", sorted(cd.bundled_names()))
def test_every_bundled_description_has_shapes(name: str) -> None:
    assert shapes_of(cd.load(name))


@pytest.mark.parametrize("kind", ["universal", "cylindrical", "spherical"])
def test_joints_of_more_types_than_urdf_has(kind: str, capfd: pytest.CaptureFixture[str]) -> None:
    mechanism = cd.load(
        '<robot name="r"><link name="a"/><link name="b"><visual><geometry>'
        '<sphere radius="2"/></geometry></visual></link>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>'
        '<origin xyz="1 2 3"/><axis xyz="0 0 1"/></joint></robot>'
    )
    (shape,) = shapes_of(mechanism)
    assert shape.link == "b"
    np.testing.assert_allclose(shape.placement, np.eye(4), atol=1e-15)
    assert capfd.readouterr().err == ""


def test_mjcf_and_descriptions_without_a_text_have_none() -> None:
    model = """<mujoco model="m"><worldbody><body name="b"><joint name="j" axis="0 0 1"/>
      <geom type="sphere" size="1" mass="1"/></body></worldbody></mujoco>"""
    assert shapes_of(cd.load(model)) == []
    assert shapes_of(described("")) == []


@pytest.mark.parametrize("geometry", ["", '<box size="1 2"/>', '<sphere radius="big"/>'])
def test_malformed_visuals_are_refused(geometry: str) -> None:
    mechanism = described(visual('<sphere radius="1"/>') + visual(geometry))
    with pytest.raises(cd.ModelError, match=r"^r: the visuals cannot be read: one is malformed$"):
        shapes_of(mechanism)


def test_mesh_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "part.stl"
    file.write_text("nothing of a mesh")
    mechanism = described(visual(f'<mesh filename="{file}"/>'))
    with pytest.raises(cd.ModelError, match=r"^r: the visuals cannot be read: (.|\n)*part\.stl"):
        shapes_of(mechanism)


def test_meshes_are_shown_if_their_files_exist(tmp_path: Path) -> None:
    triangle = "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    (tmp_path / "part.stl").write_text(triangle + "endloop\nendfacet\nendsolid t\n")
    visual = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    names = ("part.stl", "gone.stl", f"package://{tmp_path.name}/part.stl")
    text = (
        '<robot name="r"><link name="a"/><link name="b">'
        + "".join(visual.format(name) for name in names)
        + '</link><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    file = tmp_path / "robot.urdf"
    file.write_text(text)
    mechanism = cd.load(file)
    shown = shapes_of(mechanism)
    assert [(shape.kind, len(shape.vertices), len(shape.faces)) for shape in shown] == [
        ("mesh", 3, 1),
        ("mesh", 3, 1),
    ]
    turn = cd.Scene(mechanism, drive="j", gravity=(0, 0, -9.81)).sweep([0.0, 1.0])
    assert "robot" not in cd.view(turn, title="mesh").html.split("</title>")[0]


def test_packages_are_found_on_the_search_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the directories on the path and above them; `file://` names and absolute ones as well."""
    package = tmp_path / "somewhere" / "robot_description"
    package.mkdir(parents=True)
    (package / "part.stl").write_text(TRIANGLE)
    names = ("package://robot_description/part.stl", "model://robot_description/part.stl")
    text = "".join(visual(f'<mesh filename="{name}"/>') for name in names)
    assert shapes_of(described(text)) == []
    for entry in (package, package.parent):
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(entry))
        assert [shape.kind for shape in shapes_of(described(text))] == ["mesh", "mesh"]
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    for name in (f"file://{package}/part.stl", f"{package}/part.stl"):
        (shape,) = shapes_of(described(visual(f'<mesh filename="{name}"/>')))
        np.testing.assert_array_equal(np.max(shape.vertices, axis=0), (1.0, 1.0, 0.0))
    assert shapes_of(described(visual('<mesh filename=""/>'))) == []


def test_meshes_are_scaled(tmp_path: Path) -> None:
    file = tmp_path / "part.stl"
    file.write_text(TRIANGLE)
    (shape,) = shapes_of(described(visual(f'<mesh filename="{file}" scale="2 3 1"/>')))
    np.testing.assert_allclose(np.max(shape.vertices, axis=0), (2.0, 3.0, 0.0))
