"""Mesh files: where they are found, what of them is read, and what is said of broken ones."""

from __future__ import annotations

import importlib.metadata
import json
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
import pytest

pytest.importorskip("trimesh", reason="the viewer reads meshes with trimesh")

import cardan_dyn as cd
from cardan_dyn.practice.viewer.meshes import (
    creased,
    find_mesh,
    read_mesh,
    searched,
    thinned,
)
from cardan_dyn.practice.viewer.visuals import shapes_of

POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
"""A tetrahedron."""


def ascii_stl(path: Path) -> None:
    facets = (
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in POINTS[face])
        + "endloop\nendfacet\n"
        for face in FACES
    )
    path.write_text(f"solid t\n{''.join(facets)}endsolid t\n")


def binary_stl(path: Path) -> None:
    facets = (struct.pack("<12fH", 0, 0, 0, *POINTS[face].flatten(), 0) for face in FACES)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(FACES)) + b"".join(facets))


def obj(path: Path) -> None:
    path.with_suffix(".mtl").write_text("newmtl red\nKd 1 0 0\n")
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS] + ["mtllib mesh.mtl", "usemtl red"]
    path.write_text("\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]) + "\n")


def dae(path: Path, unit: str = "1", up: str = "Z_UP") -> None:
    numbers = " ".join(str(x) for x in (POINTS / float(unit)).flatten())
    path.write_text(
        f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="u" meter="{unit}"/><up_axis>{up}</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><phong>
<diffuse><color>1 0 0 1</color></diffuse></phong></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="r"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="s">
<float_array id="f" count="12">{numbers}</float_array>
<technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="4" material="k"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(str(x) for x in FACES.flatten())}</p></triangles></mesh></geometry>
</library_geometries>
<library_visual_scenes><visual_scene id="w"><node><translate>0 0 {1 / float(unit)}</translate>
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="k" target="#r"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"""
    )


def glb(path: Path) -> None:
    points = POINTS.astype("<f4").tobytes()
    faces = FACES.astype("<u2").tobytes()
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
        "buffers": [{"byteLength": len(points) + len(faces)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(faces)},
        ],
        "accessors": [
            {
                **{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                **{"min": POINTS.min(axis=0).tolist(), "max": POINTS.max(axis=0).tolist()},
            },
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary = points + faces + b"\0" * (-len(points + faces) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def ordered(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.round(6).T)]


@pytest.mark.parametrize(
    ("name", "write", "shift", "color"),
    [
        ("mesh.stl", ascii_stl, 0.0, None),
        ("MESH.STL", binary_stl, 0.0, None),
        ("mesh.obj", obj, 0.0, (1.0, 0.0, 0.0, 1.0)),
        # Both place their geometry in a node, one metre up.
        ("mesh.dae", dae, 1.0, (1.0, 0.0, 0.0, 1.0)),
        ("mesh.glb", glb, 1.0, (1.0, 0.0, 0.0, 1.0)),
    ],
)
def test_each_format_gives_the_points_of_its_file(
    name: str, write: Callable[[Path], None], shift: float, color: object, tmp_path: Path
) -> None:
    write(tmp_path / name)
    (found,) = read_mesh(tmp_path / name)
    np.testing.assert_allclose(
        ordered(found.surface[0]), ordered(POINTS + np.array([0.0, 0.0, shift]))
    )
    assert found.color == color
    # Each triangle once, seen from the same side.
    corners = found.surface[0][found.surface[1]] - [0.0, 0.0, shift]
    expected = {tuple(np.roll(face, k)) for face in FACES for k in range(3)}
    indices = np.argmin(np.linalg.norm(corners[:, :, None] - POINTS, axis=-1), axis=-1)
    assert len(indices) == 4 and {tuple(face) for face in indices} <= expected


@pytest.mark.parametrize(("unit", "up"), [("0.001", "Z_UP"), ("0.0254", "Y_UP")])
def test_a_dae_file_counts_in_its_unit_and_keeps_its_axes(
    unit: str, up: str, tmp_path: Path
) -> None:
    dae(tmp_path / "mesh.dae", unit, up)
    (found,) = read_mesh(tmp_path / "mesh.dae")
    np.testing.assert_allclose(
        ordered(found.surface[0]), ordered(POINTS + np.array([0.0, 0.0, 1.0]))
    )


def test_a_part_of_a_file(tmp_path: Path) -> None:
    dae(tmp_path / "mesh.dae")
    assert len(read_mesh(tmp_path / "mesh.dae", "g")[0].surface[1]) == 4
    with pytest.raises(cd.ModelError, match=r"mesh\.dae: the mesh has no triangles in part 'h'"):
        read_mesh(tmp_path / "mesh.dae", "h")


def test_each_color_is_a_surface_of_its_own(tmp_path: Path) -> None:
    obj(tmp_path / "mesh.obj")
    (tmp_path / "mesh.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n")
    text = (tmp_path / "mesh.obj").read_text()
    (tmp_path / "mesh.obj").write_text(text + "usemtl blue\nf 1 2 3\n")
    found = {item.color: len(item.surface[1]) for item in read_mesh(tmp_path / "mesh.obj")}
    assert found == {(1.0, 0.0, 0.0, 1.0): 4, (0.0, 0.0, 1.0, 1.0): 1}


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("part.step", b"ISO-10303", r"a mesh of this kind is not read; convert it to \.stl"),
        ("part", b"", r"a mesh of this kind is not read"),
        ("part.stl", b"nothing of a mesh", r"the mesh (cannot be read|has no triangles)"),
        (
            "part.stl",
            b"\0" * 80 + struct.pack("<I", 9) + b"\0" * 60,
            r"the mesh (cannot be read|has no triangles)",
        ),
        ("part.stl", b"", r"the mesh (cannot be read|has no triangles)"),
        ("part.obj", b"v 0 0 0\nv 1 0 0\n", r"the mesh (cannot be read|has no triangles)"),
        ("part.dae", b"<COLLADA", r"the mesh cannot be read"),
        ("part.glb", b"glTF", r"the mesh cannot be read"),
    ],
)
def test_files_that_cannot_be_read(name: str, content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(cd.ModelError, match=rf"{name}: {message}"):
        read_mesh(tmp_path / name)


def test_points_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    facet = struct.pack("<12fH", 0, 0, 0, *(np.nan, 0, 0), *(1, 0, 0), *(0, 1, 0), 0)
    (tmp_path / "part.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 1) + facet)
    with pytest.raises(cd.ModelError, match=r"part\.stl: the mesh has (points that|no triang)"):
        read_mesh(tmp_path / "part.stl")


def test_without_trimesh_the_message_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ascii_stl(tmp_path / "part.stl")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(cd.ModelError, match=r'need trimesh: pip install "cardan-dyn\[viz\]"'):
        read_mesh(tmp_path / "part.stl")


def test_places_where_a_mesh_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "somewhere" / "robot_description"
    folder = package / "urdf" / "deep"
    folder.mkdir(parents=True)
    file = package / "part.stl"
    file.write_bytes(b"")
    (package / "package.xml").write_bytes(b"")
    for name in (
        "../../part.stl",
        str(file),
        f"file://{file}",
        "package://robot_description/part.stl",
        "model://robot_description/part.stl",
        # The directory of a clone may have another name than the package.
        "package://robot/part.stl",
        f"package://{file}",
        "package:///robot_description/part.stl",
    ):
        found = find_mesh(name, folder)
        assert found is not None and found.samefile(file), name
    for name in ("part.stl", "", "package://", "http://robot_description/part.stl", "x" * 5000):
        assert find_mesh(name, folder) is None
    # Text has no folder: the search path alone leads there.
    monkeypatch.chdir(tmp_path)
    name = "package://robot_description/part.stl"
    assert find_mesh(name, None) is None
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH"):
        for entry in (package, package.parent):
            with monkeypatch.context() as changed:
                changed.setenv(variable, f"/nowhere:{entry}")
                found = find_mesh(name, None)
                assert found is not None and found.samefile(file)


def test_messages_tell_where_was_looked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert searched("part.stl", tmp_path) == f"looked in {tmp_path}"
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    said = searched("package://p/part.stl", tmp_path)
    assert str(tmp_path) in said and "ROS_PACKAGE_PATH (not set)" in said
    monkeypatch.setenv("ROS_PACKAGE_PATH", "/opt/ros")
    assert "ROS_PACKAGE_PATH (/opt/ros)" in searched("package://p/part.stl", tmp_path)
    assert searched("https://p/part.stl", None).startswith("https:// is not read; give a file")


def test_installed_robots_are_found_from_texts() -> None:
    name = "package://example-robot-data/robots/solo_description/meshes/stl/solo12/solo_12_base.stl"
    found = find_mesh(name, None)
    assert found is not None and found.samefile(
        next(robot("solo12.urdf").parents[1].rglob(found.name))
    )


def robot(name: str) -> Path:
    files = importlib.metadata.files("example-robot-data")
    assert files is not None
    (found,) = (file for file in files if file.name == name)
    return Path(str(found.locate()))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur5_robot.urdf", "solo12.urdf", "laikago.urdf"])
def test_robots_look_as_pinocchio_reads_them(name: str) -> None:
    """Corners of a box around the meshes of each link, in its body: DAE, STL and OBJ."""
    path = robot(name)
    mechanism = cd.load(path, strict=False)
    shapes, notes = shapes_of(mechanism)
    assert notes == ()
    share = next(parent for parent in path.parents if parent.name == "share")
    model = pinocchio.buildModelFromUrdf(str(path))
    read = pinocchio.buildGeomFromUrdf(
        model, str(path), pinocchio.VISUAL, package_dirs=[str(share)]
    )
    expected: dict[str, list[np.ndarray]] = {}
    for item in read.geometryObjects:
        if hasattr(item.geometry, "vertices"):
            points = np.array(item.geometry.vertices()).reshape(-1, 3)
            place = item.placement.homogeneous
            link = model.frames[item.parentFrame].name
            expected.setdefault(link, []).append(points @ place[:3, :3].T + place[:3, 3])
    assert len(expected) > 5
    for link, clouds in expected.items():
        own = [
            shape.surface[0] @ shape.placement[:3, :3].T + shape.placement[:3, 3]
            for shape in shapes
            if shape.link == link and shape.kind == "mesh"
        ]
        for extreme in (np.min, np.max):
            box = [extreme(np.concatenate(points), axis=0) for points in (own, clouds)]
            np.testing.assert_allclose(*box, atol=1e-6)


def ball(steps: int) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=steps)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def test_thinned_meshes_keep_their_form() -> None:
    fine = ball(5)
    coarse = thinned(fine, 0.1)
    assert 100 < len(coarse[1]) < 0.2 * len(fine[1])
    # Points are some of those that there were, and the surface is still closed.
    assert set(map(tuple, coarse[0])) <= set(map(tuple, fine[0]))
    edges = np.concatenate([coarse[1][:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    assert set(map(tuple, edges)) == set(map(tuple, edges[:, ::-1]))
    assert len(thinned(fine, 1e-9)[1]) == len(fine[1])


def test_edges_are_creased_and_curves_are_not() -> None:
    smooth = ball(4)
    assert len(creased(smooth)[0]) == len(smooth[0])
    vertices, faces = creased((POINTS, FACES))
    assert faces.shape == (4, 3) and len(vertices) == 12
    np.testing.assert_array_equal(vertices[faces], POINTS[FACES])
    _, single = creased((POINTS[:3], FACES[:1] % 3))
    assert single.shape == (1, 3)
