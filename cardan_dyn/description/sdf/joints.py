"""Joints of SDF: which links they connect, where, and about which axes."""

from __future__ import annotations

from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from ...arrays import Array, inverse
from ...errors import ModelError, choices
from ..description import JointDescription, Limits, LoopDescription
from ..elements import DYNAMICS_WORDS, Dynamics, numbers, only
from ..mjcf.elements import unit
from .elements import flag, limit, number, text
from .frames import MODEL, WORLD, Frames

TYPES = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "ball": "spherical",
    "universal": "universal",
    "revolute2": "universal",
    "fixed": "fixed",
}
"""SDF's word for a joint to its type. Of the axes of `universal` and `revolute2`, the first moves
with the parent and the second with the child, as in Gazebo."""
GEARBOX = "gearbox"
"""A joint that couples two angles and connects nothing."""
_REFUSED = {
    "screw": "turns and slides that depend on each other are not supported; write a prismatic and "
    "a revolute joint in a row, which are free of each other",
    "piston": 'write a prismatic and a revolute joint in a row, or <loop type="cylindrical"> in '
    "a URDF",
}
"""Types that are not read, and what to do."""
_AXES_IN_MODEL_UNTIL = (1, 4)
"""Last version whose axes were written in the model's frame."""
_RIGHT_ANGLE_TOLERANCE = 1e-9
"""Greatest cosine between the axes of a universal joint: what axes written with ten digits have."""


@dataclass(frozen=True, eq=False)
class Edge:
    """A joint between two links, before it is known whether it closes a loop.

    Attributes:
        name, type: of the joint.
        parent, child: names of the links, of the first `WORLD` as well.
        placement: `(4, 4)` initial placement of the joint's frame in the world [m].
        axis, axis_2: `(3,)` in that frame.
        limits: of its coordinate.
        is_cut: whether the author wants a loop to be cut here.
        dynamics: what rubs and springs along its coordinates.
    """

    name: str
    type: str
    parent: str
    child: str
    placement: Array
    axis: Array
    axis_2: Array
    limits: Limits
    is_cut: bool
    dynamics: Dynamics = field(default_factory=Dynamics)

    def joint(self, links: dict[str, Array], is_reversed: bool) -> JointDescription:
        """Return the edge as a joint of the tree.

        Args:
            links: `(4, 4)` initial placements of the links in the world.
            is_reversed: whether a `fixed` joint carries its parent.
        """
        parent, child = (self.child, self.parent) if is_reversed else (self.parent, self.child)
        return JointDescription(
            name=self.name,
            type=self.type,
            parent=parent,
            child=child,
            origin=inverse(links[parent]) @ self.placement,
            axis=self.axis,
            axis_2=self.axis_2,
            child_placement=inverse(self.placement) @ links[child],
            limits=self.limits,
            **self.dynamics._asdict(),
        )

    def loop(self, links: dict[str, Array]) -> LoopDescription:
        """Return the edge as a loop, which the initial placements close."""
        return LoopDescription(
            name=self.name,
            type=self.type,
            predecessor=self.parent,
            successor=self.child,
            predecessor_origin=inverse(links[self.parent]) @ self.placement,
            successor_origin=inverse(links[self.child]) @ self.placement,
            axis=self.axis,
            axis_2=self.axis_2,
            **self.dynamics._asdict(),
        )


def edge(
    element: ElementTree.Element, frames: Frames, version: tuple[int, int], where: str
) -> tuple[Edge, list[str]]:
    """Return a joint, and warnings about what it says and is left out.

    Raises:
        ModelError: it is malformed or of a type that is not supported.
    """
    at = f"{where}: joint {element.get('name')!r}"
    kind = TYPES[kind_of(element, at)]
    parent, child = ends(element, frames, at)
    placement = frames.joint_placement(element.get("name", ""), at)
    axis = axis_2 = np.array([1.0, 0.0, 0.0])
    limits, warnings = Limits(), list[str]()
    if kind not in ("fixed", "spherical"):
        axis = axis_2 = axis_of(element, "axis", placement, frames, version, at)
        limits, warnings = _limits(element, kind, at)
    if kind == "universal":
        axis_2 = axis_of(element, "axis2", placement, frames, version, at)
        _check_right_angle(axis, axis_2, at)
    if kind == "revolute" and not np.isfinite([limits.lower, limits.upper]).any():
        kind = "continuous"
    dynamics = dynamics_of(element, kind, at)
    cut = element.find("physics/simbody/must_be_loop_joint")
    is_cut = cut is not None and flag(cut.text or "", f"{at}: must_be_loop_joint")
    name = element.get("name", "")
    described = (name, kind, parent, child, placement, axis, axis_2, limits, is_cut, dynamics)
    return Edge(*described), warnings


def dynamics_of(element: ElementTree.Element, kind: str, at: str) -> Dynamics:
    """Return what rubs and springs along the coordinates of a joint.

    What cannot be taken in is none: along a joint that has no single coordinate, negative values,
    and what both axes of a universal joint do not have alike.

    Args:
        element: the `<joint>`.
        kind: its type here.
        at: how messages name it.

    Raises:
        ModelError: a value is no number.
    """
    if kind in ("fixed", "spherical"):
        return Dynamics()
    first, second = (_dynamics_of_axis(element, tag, at) for tag in ("axis", "axis2"))
    if (kind == "universal" and first != second) or min(first[:3]) < 0.0:
        return Dynamics()
    return first


def _dynamics_of_axis(element: ElementTree.Element, tag: str, at: str) -> Dynamics:
    """Return what an axis states, nothing where there is none."""
    axis = only(element, tag, at)
    dynamics = None if axis is None else only(axis, "dynamics", at)
    if dynamics is None:
        return Dynamics()
    stated = Dynamics(*(number(dynamics, word, "0", f"{at}: {tag}") for word in DYNAMICS_WORDS))
    # Where nothing springs, its rest means nothing.
    return stated if stated.stiffness else stated._replace(rest=0.0)


def kind_of(element: ElementTree.Element, at: str) -> str:
    """Return SDF's word for the type of a joint.

    Raises:
        ModelError: it is unknown, or not supported.
    """
    kind = (element.get("type") or "").lower()
    if kind in _REFUSED:
        raise ModelError(f"{at}: type {kind!r} is not supported: {_REFUSED[kind]}")
    if kind != GEARBOX and kind not in TYPES:
        raise ModelError(
            f"{at}: type {element.get('type')!r} is not supported; types: "
            f"{choices([*TYPES, GEARBOX], kind)}"
        )
    return kind


def ends(element: ElementTree.Element, frames: Frames, at: str) -> tuple[str, str]:
    """Return the links that a joint connects, of its parent `WORLD` as well."""
    links = []
    for tag in ("parent", "child"):
        name = text(element, tag, "", at)
        if not name:
            raise ModelError(f"{at}: <{tag}> is missing or empty")
        links.append(frames.link(name, f"{at}: {tag}"))
    parent, child = links
    if child == WORLD:
        raise ModelError(f"{at}: the world cannot be the child; swap parent and child")
    if parent == child:
        raise ModelError(f"{at}: parent and child are the same link {child!r}")
    return parent, child


def axis_of(
    element: ElementTree.Element,
    tag: str,
    placement: Array,
    frames: Frames,
    version: tuple[int, int],
    at: str,
) -> Array:
    """Return the `(3,)` unit axis of a joint in its frame, whose `(4, 4)` placement is given."""
    axis = only(element, tag, at)
    if axis is None:
        raise ModelError(f"{at}: <{tag}><xyz>0 0 1</xyz></{tag}> is missing")
    at = f"{at}: {tag}"
    stated = numbers(text(axis, "xyz", "0 0 1", at), 3, "", f"{at}: xyz")
    direction = unit(stated, f"{at}: xyz")
    frame = _frame_of_axis(axis, frames, version, at)
    if not frame:
        return direction
    turn = frames.placement(frame, f"{at}: expressed_in")[:3, :3]
    return np.asarray(placement[:3, :3].T @ turn @ direction)


def _frame_of_axis(
    axis: ElementTree.Element, frames: Frames, version: tuple[int, int], at: str
) -> str:
    """Return the frame in which an axis is written; empty where that is the joint's own."""
    xyz = only(axis, "xyz", at)
    named = "" if xyz is None else xyz.get("expressed_in", "")
    in_model = flag(text(axis, "use_parent_model_frame", "false", at), at)
    if frames.has_names:
        if in_model:
            raise ModelError(f'{at}: write expressed_in="{MODEL}", not <use_parent_model_frame>')
        return named
    if named:
        raise ModelError(f"{at}: expressed_in is known from SDF 1.7 on; this is an older version")
    return MODEL if in_model or version <= _AXES_IN_MODEL_UNTIL else ""


def _check_right_angle(axis: Array, axis_2: Array, at: str) -> None:
    cosine = float(axis @ axis_2)
    if abs(cosine) > _RIGHT_ANGLE_TOLERANCE:
        raise ModelError(
            f"{at}: its axes are at an angle whose cosine is {cosine:g}, not at right angles; "
            "write two revolute joints with a link of mass 0 between them"
        )


def _limits(element: ElementTree.Element, kind: str, at: str) -> tuple[Limits, list[str]]:
    """Return the limits of a joint, and warnings about what else its axes say.

    A universal joint has limits per axis, which a description has no place for; as all limits they
    play no part in wrenches.
    """
    warnings, limits = [], Limits()
    for tag in ("axis", "axis2"):
        axis = only(element, tag, at)
        if axis is None:
            continue
        initial = number(axis, "initial_position", "0", f"{at}: {tag}")
        if initial:
            warnings.append(
                f"{at}: {tag}: initial_position {initial:g} left out: the coordinate is zero in "
                "the poses of the links"
            )
        stated = only(axis, "limit", at)
        if stated is None or kind == "universal" or tag == "axis2":
            continue
        limits = Limits(
            lower=limit(stated, "lower", -1.0, at),
            upper=limit(stated, "upper", 1.0, at),
            velocity=limit(stated, "velocity", 1.0, at),
            effort=limit(stated, "effort", 1.0, at),
        )
    if kind == "continuous":
        limits = Limits(velocity=limits.velocity, effort=limits.effort)
    return limits, warnings
