"""Rezero: the same mechanism described from another closed configuration.

A joint's displacement from its old zero goes into its origin, so that coordinates count from the
new one. Links, masses and wrenches stay what they are:

- The new origin of a joint is the old one times the displacement. The frame that moves with the
  child is then the same as before, and so are the components of its wrench.
- The first of two axes moves with the parent: in the new frame it is turned back by the second's
  angle. So the normal of a `universal` joint's axes at zero, along which torsion is counted, is
  another.
- The slides of a `planar` and a `floating` joint are turned in the world as the child was, since
  they are counted along the axes of the joint's frame.
- A loop's joint is displaced likewise; its frame in the successor stays, as the loop is closed.
- Couplings hold for the displacements, so they hold for what is counted from them, without an
  offset, where polynomials are written about the new zero.

What the laws of motion leave open is chosen by a norm that weighs moments with the mechanism's
characteristic length, which counts slides that are part of an origin.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pinocchio

from ...kit.arrays import Array, inverse
from ...kit.checks import mapping, numbers
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import FrozenDict, frozen
from ..description.description import (
    TWO_AXES,
    CouplingDescription,
    Description,
    Dynamics,
    JointDescription,
    JointOrLoop,
    LoopDescription,
    elementary,
    placed_links,
    shown_ratio,
)

_CLOSED = 1e-6
"""Greatest gap of a loop, in radians and in lengths relative to the mechanism's size, of a
configuration that counts as closed: what positions written with seven digits leave."""
_UNIT_TOLERANCE = 1e-6
"""Greatest deviation of a quaternion's length from 1, likewise."""


def rezeroed(
    description: Description, positions: Mapping[str, object], length: float
) -> Description:
    """Return a description whose zero is another closed configuration.

    Args:
        description: it stays as it is.
        positions: name of every joint and loop that moves to its coordinates there, in the order
            of its elementary parts: an angle [rad] or slide [m] each, a ball's unit quaternion
            x y z w or its three Cardan angles. A number does for a single one; angles may count
            whole turns.
        length: the mechanism's characteristic one [m].

    Raises:
        ArgumentError: a position is missing, unknown or malformed, a loop is open there, or a
            coupling does not hold there.
    """
    displacements = _displacements(description, mapping("at", positions))
    angles = {name: values for name, (_, values) in displacements.items()}
    couplings = tuple(_coupling(description, item, angles) for item in description.couplings)
    result = replace(
        description,
        joints=tuple(_joint(joint, *displacements[joint.name]) for joint in description.joints),
        loops=tuple(_loop(loop, *displacements[loop.name]) for loop in description.loops),
        couplings=couplings,
        keyframes=_keyframes(description, displacements),
        source=None,
        added="",
    )
    _check_closed(result, length)
    return result


def _keyframes(
    description: Description, displacements: Mapping[str, tuple[Array, Array]]
) -> FrozenDict[str, FrozenDict[str, float | Array]]:
    """Return the keyframes, positions counted from the new zero."""
    joints = {joint.name: joint for joint in description.joints}

    def counted(name: str, position: float | Array) -> float | Array:
        """Return a position of a joint; a ball turns on from where it is at the new zero."""
        start, values = displacements[name]
        kind = joints[name].type
        if kind not in ("spherical", "floating"):
            shifted = np.asarray(position) - values
            return float(shifted[0]) if np.ndim(position) == 0 else shifted
        there = inverse(start) @ _displacement(joints[name], position)[0]
        turned = np.asarray(pinocchio.Quaternion(there[:3, :3]).normalized().coeffs())
        return turned if kind == "spherical" else np.concatenate([there[:3, 3], turned])

    return frozen(
        {
            key: frozen({name: counted(name, value) for name, value in positions.items()})
            for key, positions in description.keyframes.items()
        }
    )


def _displacements(
    description: Description, positions: Mapping[str, object]
) -> dict[str, tuple[Array, Array]]:
    """Return the `(4, 4)` displacement of each joint and loop from zero, and its coordinates."""
    described = description.joints_and_loops
    moving = [joint.name for joint in described if joint.type != "fixed"]
    unknown = sorted(set(positions) - set(moving))
    if unknown:
        raise ArgumentError(
            f"at: no joint {unknown[0]!r} moves; joints: {choices(moving, unknown[0])}"
        )
    missing = [name for name in moving if name not in positions]
    if missing:
        raise ArgumentError(
            "at takes a complete configuration; there is no position of " + choices(missing)
        )
    return {joint.name: _displacement(joint, positions.get(joint.name, ())) for joint in described}


def _displacement(joint: JointOrLoop, position: object) -> tuple[Array, Array]:
    """Return the `(4, 4)` displacement of a joint from zero, and its coordinates there."""
    parts = elementary(joint.type, joint.axis, joint.axis_2)
    size = sum(4 if kind == "spherical" else 1 for kind, _ in parts)
    name = f"at[{joint.name!r}]"
    values = np.atleast_1d(numbers(name, position)) if size else np.zeros(0)
    if any(kind == "spherical" for kind, _ in parts) and values.shape == (size - 1,):
        # Three angles instead of a quaternion, of a mechanism whose balls are written as turns.
        parts, size = elementary(joint.type, joint.axis, joint.axis_2, cardan=True), size - 1
    if values.shape != (size,):
        raise ArgumentError(
            f"{name} has shape {values.shape}; a {joint.type} joint has {size} coordinate(s)"
        )
    result, column = np.eye(4), 0
    for kind, axis in parts:
        step = np.eye(4)
        if kind == "spherical":
            step[:3, :3] = _turned(values[column : column + 4], name)
            column += 4
        else:
            if kind == "prismatic":
                step[:3, 3] = values[column] * axis
            else:
                step[:3, :3] = _turn(axis, values[column])
            column += 1
        result = result @ step
    return result, values


def _turn(axis: Array, angle: float) -> Array:
    cross = pinocchio.skew(axis)
    # 1 - cos as a square of the half angle's sine: without cancellation for small angles.
    return np.asarray(
        np.eye(3) + np.sin(angle) * cross + 2.0 * np.sin(0.5 * angle) ** 2 * (cross @ cross)
    )


def _turned(quaternion: Array, name: str) -> Array:
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        raise ArgumentError(f"{name}: the quaternion has length {length:g}, expected 1")
    return np.asarray(pinocchio.Quaternion(quaternion / length).toRotationMatrix())


def _joint(joint: JointDescription, displacement: Array, values: Array) -> JointDescription:
    """Return a joint that counts from a displacement."""
    if joint.type == "fixed":
        return joint
    limits = joint.limits
    if len(values) == 1:
        start = float(values[0])
        limits = replace(limits, lower=limits.lower - start, upper=limits.upper - start)
    return replace(
        joint,
        origin=joint.origin @ displacement,
        axis=_axis(joint, displacement),
        limits=limits,
        dynamics=_dynamics(joint, values),
    )


def _loop(loop: LoopDescription, displacement: Array, values: Array) -> LoopDescription:
    """Return a loop that counts from a displacement."""
    return replace(
        loop,
        predecessor_origin=loop.predecessor_origin @ displacement,
        axis=_axis(loop, displacement),
        dynamics=_dynamics(loop, values),
    )


def _dynamics(joint: JointOrLoop, values: Array) -> Dynamics:
    """Return what rubs and springs along a joint, its rest counted from coordinates."""
    if not joint.dynamics.stiffness or not np.any(values):
        return joint.dynamics
    if len(values) > 1:
        raise ArgumentError(
            f"at[{joint.name!r}]: a {joint.type} joint with a spring keeps its zero, since its "
            "description has one place of rest for all of its coordinates"
        )
    return joint.dynamics._replace(rest=joint.dynamics.rest - float(values[0]))


def _axis(joint: JointOrLoop, displacement: Array) -> Array:
    """Return the `(3,)` first axis in the displaced frame.

    Its own motion does not turn it; where there are two, the second one's does.
    """
    if joint.type not in TWO_AXES:
        return joint.axis
    axis = displacement[:3, :3].T @ joint.axis
    # Rounding must not make the angle between both axes any other than a right one.
    axis = axis - (axis @ joint.axis_2) * joint.axis_2
    return np.asarray(axis / np.linalg.norm(axis))


def _coupling(
    description: Description, coupling: CouplingDescription, positions: Mapping[str, Array]
) -> CouplingDescription:
    """Return a coupling that counts from other positions, which are refused if it does not hold."""
    carriers = {joint.child: joint for joint in description.joints}

    def path(link: str) -> list[str]:
        found = []
        while link in carriers:
            found.append(carriers[link].name)
            link = carriers[link].parent
        return found

    first, second = [coupling.predecessor], [coupling.successor]
    if not coupling.of_joints:
        first, second = path(coupling.predecessor), path(coupling.successor)
    motions = [
        sum(float(np.sum(positions[name])) for name in side if name not in other)
        for side, other in ((first, second), (second, first))
    ]
    gap = abs(motions[1] - coupling.polynomial(motions[0]))
    if gap > _CLOSED * max(1.0, *map(abs, motions)):
        raise ArgumentError(
            f"at: the coupling {coupling.name!r} does not hold: its successor is at "
            f"{motions[1]:g}, its predecessor at {motions[0]:g}; the ratio is "
            f"{shown_ratio(coupling.ratio, coupling.offset, coupling.higher)}"
        )
    about_there = np.polynomial.Polynomial((motions[0], 1.0))
    _, ratio, *higher = coupling.polynomial(about_there).coef.tolist()
    return replace(coupling, offset=0.0, ratio=ratio, higher=tuple(higher))


def link_placements(description: Description) -> dict[str, Array]:
    """Return the `(4, 4)` placements of all links in the world with every joint at zero."""
    joints = description.joints
    return placed_links(
        (link.name for link in description.links),
        ((item.parent, item.child, item.origin @ item.child_placement) for item in joints),
    )


def is_closed(description: Description, length: float) -> bool:
    """Return whether all loops of a description are closed, and all couplings hold, at zero.

    With the mechanism's characteristic length [m].
    """
    return not any(coupling.offset for coupling in description.couplings) and not any(
        _open_loops(description, length)
    )


def _check_closed(description: Description, length: float) -> None:
    for loop, distance, angle in _open_loops(description, length):
        raise ArgumentError(
            f"at: the loop {loop!r} is open by {distance:g} m, {angle:g} rad; give the positions "
            "of a closed configuration, such as `assemble` or `Scene.configuration` returns"
        )


def _open_loops(description: Description, length: float) -> Iterator[tuple[str, float, float]]:
    """Yield each loop that is open at zero, and how far [m], [rad]."""
    placements = link_placements(description)
    ends = [
        (
            placements[loop.predecessor] @ loop.predecessor_origin,
            placements[loop.successor] @ loop.successor_origin,
        )
        for loop in description.loops
    ]
    joints = [placements[joint.parent] @ joint.origin for joint in description.joints]
    frames = [*placements.values(), *joints, *(frame for pair in ends for frame in pair)]
    points = np.array([frame[:3, 3] for frame in frames])
    # All joints may lie in one point but for rounding, as in a spherical linkage: then the length
    # is that of its masses. Far from the origin, distances themselves are rounded.
    spread = float(np.max(np.linalg.norm(points - np.mean(points, axis=0), axis=1)))
    allowed = _CLOSED * max(spread, length)
    for loop, (start, end) in zip(description.loops, ends, strict=True):
        gap = inverse(start) @ end
        distance = float(np.linalg.norm(gap[:3, 3]))
        # As much as the sine for small angles, and never small for large ones.
        angle = float(np.max(np.abs(gap[:3, :3] - np.eye(3))))
        if distance > allowed or angle > _CLOSED:
            yield loop.name, distance, angle
