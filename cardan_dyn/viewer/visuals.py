"""Visuals: the shapes of a mechanism's links, read from its description only when shown.

Pinocchio reads boxes, cylinders, spheres and meshes with their colours. Meshes whose files do not
exist are left out instead of failing.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio

from ..arrays import Array
from ..description.description import SourceText
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism


@dataclass(frozen=True)
class Shape:
    """One visual of a link.

    Attributes:
        link: name of the link.
        body: index of the link's body in `Mechanism.model`.
        kind: `box`, `cylinder` (along z), `sphere` or `mesh`.
        size: box: three edges; cylinder: radius and length; sphere: radius [m].
        placement: `(4, 4)` of the shape in the link's body in `Mechanism.model`.
        color: red, green, blue and opacity, 0 to 1.
        vertices: `(n, 3)` of a mesh [m].
        faces: `(m, 3)` of a mesh, indices of vertices.
    """

    link: str
    body: int
    kind: str
    size: tuple[float, ...]
    placement: Array
    color: tuple[float, float, float, float]
    vertices: Array
    faces: Array

    def corners(self) -> Array:
        """Return the corners `(8, 3)` of a box around the shape, in axes of the body [m]."""
        if self.kind == "mesh":
            low, high = np.min(self.vertices, axis=0), np.max(self.vertices, axis=0)
        else:
            if self.kind == "box":
                half = np.array(self.size) / 2.0
            elif self.kind == "cylinder":
                half = np.array([self.size[0], self.size[0], self.size[1] / 2.0])
            else:
                half = np.full(3, self.size[0])
            low, high = -half, half
        upper = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
        local = np.where(upper == 0, low, high)
        return np.asarray(local @ self.placement[:3, :3].T + self.placement[:3, 3])


def shapes(mechanism: Mechanism) -> list[Shape]:
    """Return the visuals of all links; none if the description has none.

    An MJCF or SDF model is shown without visuals.

    Raises:
        ModelError: a visual is malformed, or a mesh cannot be read from its file.
    """
    source = mechanism.description.source
    if source is None:
        return []
    robot = ElementTree.fromstring(source.text)
    if robot.tag != "robot":
        return []
    text = _only_visuals(robot, source)
    if text is None:
        return []
    try:
        geometries = pinocchio.buildGeomFromUrdfString(mechanism.model, text, pinocchio.VISUAL)
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{mechanism.name}: the visuals cannot be read: {error}") from error
    if not geometries.geometryObjects:
        # One malformed visual makes Pinocchio's reader drop the visuals of all links.
        raise ModelError(f"{mechanism.name}: the visuals cannot be read: one is malformed")
    frames = mechanism.model.frames
    return [
        shape
        for item in geometries.geometryObjects
        if (shape := _shape(item, frames[item.parentFrame].name)) is not None
    ]


def _shape(item: Any, link: str) -> Shape | None:
    """Return Pinocchio's geometry object as a shape; None for a kind that is not drawn."""
    geometry = item.geometry
    vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint32)
    size: tuple[float, ...] = ()
    name = type(geometry).__name__
    if name == "Box":
        kind, size = "box", tuple(float(edge) for edge in 2.0 * geometry.halfSide)
    elif name == "Cylinder":
        kind, size = "cylinder", (float(geometry.radius), 2.0 * float(geometry.halfLength))
    elif name == "Sphere":
        kind, size = "sphere", (float(geometry.radius),)
    elif hasattr(geometry, "num_tris") and geometry.num_tris:
        kind = "mesh"
        vertices = np.array(geometry.vertices(), dtype=float).reshape(-1, 3)
        triangles = (geometry.tri_indices(index) for index in range(geometry.num_tris))
        faces = np.array([[face[0], face[1], face[2]] for face in triangles], dtype=np.uint32)
    else:
        return None
    placement = item.placement.homogeneous
    red, green, blue, opacity = np.clip(item.meshColor, 0.0, 1.0).tolist()
    return Shape(
        link=link,
        body=int(item.parentJoint),
        kind=kind,
        size=size,
        placement=placement,
        color=(red, green, blue, opacity),
        vertices=vertices,
        faces=faces,
    )


def _only_visuals(robot: ElementTree.Element, source: SourceText) -> str | None:
    """Return the text with the visuals that can be shown; None if there are none.

    Mesh files are written as absolute paths.
    """
    count = 0
    for joint in robot.findall("joint"):
        # Not all types are known to the reader of visuals, which asks the model where links are.
        joint.set("type", "floating")
    for link in robot.findall("link"):
        for collision in link.findall("collision"):
            link.remove(collision)
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is not None:
                path = _mesh_file(mesh.get("filename", ""), source.path)
                if path is None:
                    link.remove(visual)
                    continue
                mesh.set("filename", str(path))
            count += 1
    return ElementTree.tostring(robot, encoding="unicode") if count else None


def _mesh_file(name: str, description: Path | None) -> Path | None:
    """Return a mesh's file; None if it does not exist.

    A `package://` name is searched in the directories above the description and in those that
    `ROS_PACKAGE_PATH` lists; other names are paths from the description.
    """
    above = list(description.resolve().parents) if description is not None else []
    listed = [Path(entry) for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)]
    if name.startswith(("package://", "model://")):
        name = name.split("://", 1)[1]
        directories = [*above, *(path for entry in listed for path in (entry, entry.parent))]
    else:
        name = name.removeprefix("file://")
        directories = above[:1] or [Path.cwd()]
    if not name:
        return None
    candidates = (directory / name for directory in directories)
    return next((path for path in candidates if path.is_file()), None)
