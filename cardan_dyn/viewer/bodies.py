"""Bodies of the viewer: where they are over the shown samples, and how their links are drawn.

The shapes of links are read from the description only when they are shown. Pinocchio reads boxes,
cylinders, spheres and meshes with their colours; meshes whose files do not exist are left out
instead of failing.
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
from ..results.sweep import Sweep
from . import shapes as forms
from .commands import STEADY, Color, Drawing, Pose, mesh, meshcat, node_name
from .still import Still

ROD_COLOR = Color.of("#7a8794")
"""Colour of the rods that stand for a body without visuals."""
_ROD_RADIUS = 0.008
"""Radius of these rods, as a fraction of the radius of the scene."""
_CORNER_STRIDE = 8
"""Every how manieth sample the corners of the shapes are followed: they only decide how much the
camera has to see, and between two such samples a corner moves little."""
_Y_TO_Z = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
"""Turns meshcat's cylinders, which stand along y, to stand along z."""


class Bodies:
    """The bodies of a sweep's mechanism over the samples that are shown.

    Args:
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        visuals: whether the shapes of the links are drawn; rods between the joints otherwise.

    Attributes:
        loops: names of the joints that close loops.
        shapes: the visuals of the links whose motion is known.
        notes: what is drawn otherwise than the description says, and why.
    """

    def __init__(self, sweep: Sweep | Still, samples: Array, visuals: bool) -> None:
        mechanism = sweep.mechanism
        self._sweep, self._samples = sweep, samples
        self._length = mechanism.characteristic_length
        self.notes: tuple[str, ...] = ()
        self.loops = frozenset(loop.joint for loop in mechanism.loops)
        self._joint_of_body = {
            joint.id: name
            for name, joint in mechanism.joints.items()
            if joint.id and name not in self.loops
        }
        self._link_of_body: dict[int, str] = {}
        for name, (body, _) in mechanism.links.items():
            self._link_of_body.setdefault(body, name)
        self.shapes = [
            shape for shape in (shapes_of(mechanism) if visuals else []) if self._known(shape.body)
        ]

    def points(self) -> Array:
        """Return the points `(n, 3)` between which the mechanism moves [m]; none if unknown."""
        origins = (self._origin(name) for name in self._sweep.mechanism.joints)
        return np.concatenate(
            [
                np.zeros((0, 3)),
                *(points for points in origins if points is not None),
                *(self._swept_corners(shape) for shape in self.shapes),
            ]
        )

    def on_ground(self) -> frozenset[str]:
        """Return the joints that carry what moves on what stands still over the shown samples."""
        return frozenset(
            name
            for name, ends in self._ends().items()
            if len({self._stands(body) for body in ends}) == 2
        )

    def _stands(self, body: int) -> bool:
        """Return whether a body does not move; of one sample alone, whether it is the ground."""
        if body == 0 or len(self._samples) == 1 or not self._known(body):
            return body == 0
        rotation, position = self._placement(body)
        moves = np.ptp(rotation, axis=0).max() > STEADY
        return not (moves or np.ptp(position, axis=0).max() > STEADY * self._length)

    def _ends(self) -> dict[str, tuple[int, int]]:
        """Return which bodies each joint connects: its parent's, then its child's."""
        mechanism = self._sweep.mechanism
        ends = {
            name: (int(mechanism.model.parents[joint.parts[0].id]), joint.id)
            for name, joint in mechanism.joints.items()
            if joint.parts
        }
        for loop in mechanism.loops:
            parent = loop.predecessor if loop.is_fixed else ends[loop.joint][0]
            ends[loop.joint] = parent, loop.successor
        return ends

    def draw(self, drawing: Drawing, radius: float) -> None:
        """Draw the shapes of the links, or rods if there are none.

        Args:
            drawing: what they are drawn on.
            radius: of the scene [m].
        """
        if self.shapes:
            self._draw_shapes(drawing)
        else:
            self._draw_rods(drawing, radius)

    def _known(self, body: int) -> bool:
        """Return whether the sweep knows how a body moves."""
        return body == 0 or (
            body in self._joint_of_body and self._origin(self._joint_of_body[body]) is not None
        )

    def _origin(self, joint: str) -> Array | None:
        """Return where a joint is `(n, 3)` [m]; None if the sweep leaves it out."""
        try:
            return self._sweep.origin(joint)[self._samples]
        except ModelError:
            return None

    def _placement(self, body: int) -> tuple[Array, Array]:
        """Return rotations and positions [m] of a known body, one each for the fixed base."""
        if body == 0:
            return np.eye(3)[None], np.zeros((1, 3))
        joint, samples = self._joint_of_body[body], self._samples
        return self._sweep.rotation(joint)[samples], self._sweep.origin(joint)[samples]

    def _pose(self, body: int) -> Pose:
        rotation, position = self._placement(body)
        return Pose.of(position, forms.quaternions(rotation))

    def _swept_corners(self, shape: Shape) -> Array:
        """Return the points `(n, 3)` through which the corners of a shape move [m]."""
        rotation, position = (array[::_CORNER_STRIDE] for array in self._placement(shape.body))
        turned = np.einsum("nij,kj->nki", rotation, shape.corners())
        return np.asarray((turned + position[:, None]).reshape(-1, 3))

    def _draw_shapes(self, drawing: Drawing) -> None:
        count = 0
        for body in sorted({shape.body for shape in self.shapes}):
            node = f"/mechanism/{node_name(self._link_of_body[body])}"
            drawing.place(node, self._pose(body))
            for shape in (item for item in self.shapes if item.body == body):
                color = Color(*shape.color[:3], opacity=shape.color[3])
                geometry, placement = _geometry(shape)
                drawing.add(f"{node}/{node_name(shape.link)} {count}", geometry, color, placement)
                count += 1

    def _draw_rods(self, drawing: Drawing, radius: float) -> None:
        """Draw each body as rods from the middle of its joints to each of them."""
        for body, joints in self._joints_of_bodies().items():
            if not self._known(body) or len(joints) < 2:
                continue
            rotation, position = (array[0] for array in self._placement(body))
            ends = np.array(
                [
                    rotation.T @ (self._sweep.origin(name)[self._samples][0] - position)
                    for name in joints
                ]
            )
            middle = ends.mean(axis=0)
            surfaces = [forms.path(np.array([middle, end]), _ROD_RADIUS * radius) for end in ends]
            # Joints that share their origin have no distance that a rod could span.
            rods = [surface for surface in surfaces if len(surface[0])]
            if not rods:
                continue
            node = f"/mechanism/{node_name(self._link_of_body.get(body, str(body)))}"
            drawing.place(node, self._pose(body))
            for index, rod in enumerate(rods):
                drawing.add(f"{node}/rod {index}", mesh(rod), ROD_COLOR)

    def _joints_of_bodies(self) -> dict[int, list[str]]:
        """Return which joints each body carries."""
        joints_of: dict[int, list[str]] = {}
        for name, ends in self._ends().items():
            for body in ends:
                joints_of.setdefault(body, []).append(name)
        return joints_of


def _geometry(shape: Shape) -> tuple[Any, Array]:
    """Return a shape as meshcat's geometry, and its placement `(4, 4)` in its body."""
    geometry = meshcat().geometry
    if shape.kind == "box":
        return geometry.Box(shape.size), shape.placement
    if shape.kind == "sphere":
        return geometry.Sphere(shape.size[0]), shape.placement
    if shape.kind == "cylinder":
        return geometry.Cylinder(shape.size[1], shape.size[0]), shape.placement @ _Y_TO_Z
    return geometry.TriangularMeshGeometry(shape.vertices, shape.faces), shape.placement


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


def shapes_of(mechanism: Mechanism) -> list[Shape]:
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
