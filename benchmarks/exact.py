"""What are the exact motion and wrenches of a mechanism? Evaluated with 50 digits.

Nothing here shares a formula with the library. The description is read again; loops are closed by
Newton's method on joint coordinates; velocities and accelerations are central differences of the
closed positions over a step of 1e-30 with 130 digits, good to 50; the wrenches of all joints
together are the unknowns of Newton's and Euler's laws of every body. What these laws leave open
shows as a free column of their reduced form, so that unique components are known for certain.

The numbers of a description are taken as the doubles that a program reads.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass

from mpmath import mp, mpf

from .vectors import (
    Matrix,
    Vector,
    about,
    add,
    axial,
    combined,
    cross,
    dot,
    flip,
    identity,
    product,
    turn,
)

DIGITS = 130
STEP = "1e-30"
_RANK = "1e-60"


@dataclass(frozen=True)
class Joint:
    """A joint of the tree (`loop` False) or a loop's joint, with exact numbers."""

    name: str
    kind: str
    parent: str
    child: str
    rotation: Matrix
    translation: Vector
    axis: Vector
    loop: bool
    successor_rotation: Matrix
    successor_translation: Vector


@dataclass(frozen=True)
class Body:
    """Mass properties of a link, the inertia about its centre of mass in the link's axes."""

    mass: mpf
    centre: Vector
    inertia: Matrix


@dataclass(frozen=True)
class State:
    """Exact results at one position.

    Attributes:
        positions: joint coordinates of the tree.
        velocities, accelerations: their rates.
        wrenches: joint to force and moment of the parent on the child, at the joint's origin, in
            the joint's frame; None for a component that the laws of motion leave open.
    """

    positions: dict[str, mpf]
    velocities: dict[str, mpf]
    accelerations: dict[str, mpf]
    wrenches: dict[str, list[mpf | None]]


class Exact:
    """A description evaluated with 50 digits.

    Args:
        urdf: text of a description with joints of the types fixed, revolute, continuous and
            prismatic, and loops of the types revolute and continuous.
    """

    def __init__(self, urdf: str) -> None:
        mp.dps = DIGITS
        root = ElementTree.fromstring(urdf)
        self.bodies = {link.get("name", ""): _body(link) for link in root.findall("link")}
        self.joints = [_joint(item) for item in root.findall("joint")]
        self.loops = [_loop(item) for item in root.findall("loop")]
        children = {joint.child for joint in self.joints}
        (self.root,) = [name for name in self.bodies if name not in children]

    def at(
        self,
        guess: Mapping[str, float],
        driven: Mapping[str, float],
        speed: Mapping[str, float] | None = None,
        acceleration: Mapping[str, float] | None = None,
        loads: Mapping[str, float] | None = None,
        gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
        quasi_static: bool = False,
    ) -> State:
        """Return the exact state.

        Args:
            guess: positions of the passive joints near the wanted way of assembling.
            driven: positions of driven and held joints, exact as given.
            speed: of driven joints, zero if not given.
            acceleration: of driven joints, zero if not given.
            loads: efforts at joints.
            gravity: acceleration of free fall.
            quasi_static: leave velocities and accelerations out.
        """
        mp.dps = DIGITS
        speed, acceleration = speed or {}, acceleration or {}
        start = {name: mpf(value) for name, value in guess.items() if name not in driven}
        fixed = {name: mpf(value) for name, value in driven.items()}
        here = self.close(start, fixed)
        moving = not quasi_static and any([*speed.values(), *acceleration.values()])
        step = mpf(STEP)
        states = [here]
        if moving:
            # In a time in which the fastest drive turns by the step.
            rate = max(
                [mpf(1), *(abs(mpf(x)) for x in speed.values())]
                + [mp.sqrt(abs(mpf(x))) for x in acceleration.values()]
            )
            step = step / rate
            for sign in (-1, 1):
                moved = {
                    name: value
                    + sign * step * mpf(speed.get(name, 0))
                    + step**2 * mpf(acceleration.get(name, 0)) / 2
                    for name, value in fixed.items()
                }
                passive = {name: here[name] for name in here if name not in fixed}
                states.append(self.close(passive, moved))
        velocities = {name: mpf(0) for name in here}
        accelerations = dict(velocities)
        if moving:
            for name in here:
                velocities[name] = (states[2][name] - states[1][name]) / (2 * step)
                accelerations[name] = (
                    states[2][name] - 2 * states[0][name] + states[1][name]
                ) / step**2
        poses = [self.poses(state) for state in states]
        wrenches = self._wrenches(poses, step, fixed, loads or {}, [mpf(g) for g in gravity])
        return State(here, velocities, accelerations, wrenches)

    def poses(self, positions: Mapping[str, mpf]) -> dict[str, tuple[Matrix, Vector]]:
        """Return rotation and origin of every link in the world."""
        poses = {self.root: (identity(), [mpf(0)] * 3)}
        left = list(self.joints)
        while left:
            for joint in [joint for joint in left if joint.parent in poses]:
                rotation, origin = poses[joint.parent]
                origin = add(origin, turn(rotation, joint.translation))
                rotation = product(rotation, joint.rotation)
                value = positions.get(joint.name, mpf(0))
                if joint.kind == "prismatic":
                    origin = add(origin, turn(rotation, [value * a for a in joint.axis]))
                elif joint.kind != "fixed":
                    rotation = product(rotation, about(joint.axis, value))
                poses[joint.child] = (rotation, origin)
                left.remove(joint)
        return poses

    def errors(self, positions: Mapping[str, mpf]) -> list[Vector]:
        """Return of every loop its gap (3) and how its axes differ (3), in world axes."""
        poses = self.poses(positions)
        result = []
        for loop in self.loops:
            frames = self.ends(loop, poses)
            axes = [turn(rotation, loop.axis) for rotation, _ in frames]
            gap = [a - b for a, b in zip(frames[0][1], frames[1][1], strict=True)]
            result.append(gap + cross(axes[1], axes[0]))
        return result

    def close(self, passive: Mapping[str, mpf], fixed: Mapping[str, mpf]) -> dict[str, mpf]:
        """Return all coordinates with closed loops, by Newton's method from a guess."""
        passive = dict(passive)
        size = max(
            [mpf(1) * 0, *(abs(x) for joint in self.joints for x in joint.translation)], default=1
        )
        size = size if size > 0 else mpf(1)
        for _ in range(60):
            state = {**passive, **fixed}
            error = self._scaled(state, size)
            columns = self._columns(state, list(passive), size)
            step = least_squares(columns, [-value for value in error])
            passive = {
                name: passive[name] + change for name, change in zip(passive, step, strict=True)
            }
            # Quadratic: the error after this step is its square.
            if max([abs(change) for change in step], default=mpf(0)) < mpf("1e-75"):
                return {**passive, **fixed}
        raise ArithmeticError("the exact loops do not close from this guess")

    def _scaled(self, state: Mapping[str, mpf], size: mpf) -> Vector:
        return [
            value / size if row < 3 else value
            for error in self.errors(state)
            for row, value in enumerate(error)
        ]

    def _columns(self, state: Mapping[str, mpf], names: list[str], size: mpf) -> list[Vector]:
        """Return derivatives of the scaled errors with respect to joints: screws, exactly."""
        poses = self.poses(state)
        by_name = {joint.name: joint for joint in self.joints}
        above = {joint.child: joint for joint in self.joints}
        columns = []
        ends = [self.ends(loop, poses) for loop in self.loops]
        for name in names:
            joint, column = by_name[name], []
            rotation, origin = poses[joint.child]
            axis = turn(rotation, joint.axis)
            for loop, frames in zip(self.loops, ends, strict=True):
                gap, axes = [mpf(0)] * 3, [turn(frame[0], loop.axis) for frame in frames]
                change = [[mpf(0)] * 3, [mpf(0)] * 3]
                for side, (link, sign) in enumerate(((loop.parent, 1), (loop.child, -1))):
                    while link in above and above[link].name != name:
                        link = above[link].parent
                    if link not in above:
                        continue
                    if joint.kind == "prismatic":
                        gap = [g + sign * a for g, a in zip(gap, axis, strict=True)]
                    else:
                        arm = [a - b for a, b in zip(frames[side][1], origin, strict=True)]
                        gap = [g + sign * a for g, a in zip(gap, cross(axis, arm), strict=True)]
                        change[side] = cross(axis, axes[side])
                tilt = add(cross(change[1], axes[0]), cross(axes[1], change[0]))
                column += [g / size for g in gap] + tilt
            columns.append(column)
        return columns

    def ends(
        self, loop: Joint, poses: Mapping[str, tuple[Matrix, Vector]]
    ) -> list[tuple[Matrix, Vector]]:
        """Return rotation and origin of a loop's frame on its predecessor and on its successor."""
        ends = []
        for link, tilt, shift in (
            (loop.parent, loop.rotation, loop.translation),
            (loop.child, loop.successor_rotation, loop.successor_translation),
        ):
            rotation, origin = poses[link]
            ends.append((product(rotation, tilt), add(origin, turn(rotation, shift))))
        return ends

    def inertia_wrench(
        self, name: str, poses: list[dict[str, tuple[Matrix, Vector]]], step: mpf, gravity: Vector
    ) -> tuple[Vector, Vector, Vector]:
        """Return what must act on a body: force, moment about its centre, and its centre."""
        body = self.bodies[name]
        centres = [add(pose[name][1], turn(pose[name][0], body.centre)) for pose in poses]
        force, moment = [-body.mass * g for g in gravity], [mpf(0)] * 3
        if len(poses) == 3:
            here, before, after = centres
            for k in range(3):
                force[k] += body.mass * (after[k] - 2 * here[k] + before[k]) / step**2
            here, before, after = (pose[name][0] for pose in poses)
            first = combined(after, before, here, (1, -1, 0), 2 * step)
            second = combined(after, before, here, (1, 1, -2), step**2)
            flipped = flip(here)
            spin, change = axial(product(first, flipped)), axial(product(second, flipped))
            inertia = product(product(here, body.inertia), flipped)
            moment = add(turn(inertia, change), cross(spin, turn(inertia, spin)))
        return force, moment, centres[0]

    def _wrenches(
        self,
        poses: list[dict[str, tuple[Matrix, Vector]]],
        step: mpf,
        fixed: Mapping[str, mpf],
        loads: Mapping[str, float],
        gravity: Vector,
    ) -> dict[str, list[mpf | None]]:
        """Solve the laws of motion of all bodies for the wrenches of all joints."""
        everything = self.joints + self.loops
        frames = {}
        for joint in everything:
            frames[joint.name] = (
                self.ends(joint, poses[0])[1] if joint.loop else poses[0][joint.child]
            )
        names = [name for name in self.bodies if name != self.root]
        rows: Matrix = []
        for name in names:
            force, moment, centre = self.inertia_wrench(name, poses, step, gravity)
            block = [[mpf(0)] * (6 * len(everything)) for _ in range(6)]
            for number, joint in enumerate(everything):
                sign = (joint.child == name) - (joint.parent == name)
                if not sign:
                    continue
                rotation, origin = frames[joint.name]
                arm = [a - b for a, b in zip(origin, centre, strict=True)]
                for k in range(3):
                    unit = [rotation[i][k] for i in range(3)]
                    turned = cross(arm, unit)
                    for i in range(3):
                        block[i][6 * number + k] = sign * unit[i]
                        block[3 + i][6 * number + k] = sign * turned[i]
                        block[3 + i][6 * number + 3 + k] = sign * unit[i]
            rows += [[*row, value] for row, value in zip(block, force + moment, strict=True)]
        for number, joint in enumerate(everything):
            if joint.name in fixed or joint.kind == "fixed":
                continue
            row = [mpf(0)] * (6 * len(everything) + 1)
            for k in range(3):
                row[6 * number + (0 if joint.kind == "prismatic" else 3) + k] = joint.axis[k]
            row[-1] = mpf(loads.get(joint.name, 0))
            rows.append(row)
        values = _unique_part(rows)
        return {
            joint.name: values[6 * number : 6 * number + 6]
            for number, joint in enumerate(everything)
        }


def least_squares(columns: list[Vector], right: Vector) -> Vector:
    """Return the least-squares solution for columns of full rank, by orthogonalising twice."""
    basis: list[Vector] = []
    upper: list[Vector] = []
    for column in columns:
        rest, parts = list(column), [mpf(0)] * len(columns)
        for _ in range(2):
            for number, unit in enumerate(basis):
                part = dot(unit, rest)
                parts[number] += part
                rest = [a - part * b for a, b in zip(rest, unit, strict=True)]
        norm = mp.sqrt(dot(rest, rest))
        if norm < mpf(_RANK):
            raise ArithmeticError("the exact closure equations do not decide the motion")
        parts[len(basis)] = norm
        basis.append([a / norm for a in rest])
        upper.append(parts)
    result = [dot(unit, right) for unit in basis]
    for number in reversed(range(len(columns))):
        for later in range(number + 1, len(columns)):
            result[number] -= upper[later][number] * result[later]
        result[number] /= upper[number][number]
    return result


def _unique_part(rows: Matrix) -> list[mpf | None]:
    """Solve rows `[a … | b]`; components that the rows do not decide are None."""
    width = len(rows[0]) - 1
    rows = [[value / max(map(abs, row[:-1])) for value in row] for row in rows]
    # Sizes of columns, so that a pivot's size means something in any units.
    scale = [max(abs(row[k]) for row in rows) or mpf(1) for k in range(width)]
    pivots: dict[int, int] = {}
    used: set[int] = set()
    while len(used) < len(rows):
        best, place = mpf(0), (-1, -1)
        for r, row in enumerate(rows):
            if r in used:
                continue
            for k in range(width):
                if row[k] and k not in pivots and abs(row[k]) / scale[k] > best:
                    best, place = abs(row[k]) / scale[k], (r, k)
        if best < mpf(_RANK):
            break
        r, k = place
        pivots[k] = r
        used.add(r)
        entries = [(c, value / rows[r][k]) for c, value in enumerate(rows[r]) if value]
        for other, row in enumerate(rows):
            factor = row[k]
            if other == r or not factor:
                continue
            for c, value in entries:
                row[c] -= factor * value
            row[k] = mpf(0)
    result: list[mpf | None] = [None] * width
    for k, r in pivots.items():
        row = rows[r]
        free = [abs(row[c] / row[k]) for c in range(width) if c != k and c not in pivots]
        if not free or max(free) < mpf(_RANK):
            result[k] = row[width] / row[k]
    return result


def _body(link: ElementTree.Element) -> Body:
    inertial = link.find("inertial")
    if inertial is None:
        return Body(mpf(0), [mpf(0)] * 3, [[mpf(0)] * 3 for _ in range(3)])
    rotation, centre = _origin(inertial)
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    assert mass is not None and tensor is not None
    entry = {key: mpf(float(value)) for key, value in tensor.attrib.items()}
    inertia = [
        [entry["ixx"], entry["ixy"], entry["ixz"]],
        [entry["ixy"], entry["iyy"], entry["iyz"]],
        [entry["ixz"], entry["iyz"], entry["izz"]],
    ]
    inertia = product(product(rotation, inertia), flip(rotation))
    return Body(mpf(float(mass.get("value", "0"))), centre, inertia)


def _joint(item: ElementTree.Element) -> Joint:
    rotation, translation = _origin(item)
    return Joint(
        name=item.get("name", ""),
        kind=item.get("type", ""),
        parent=_attribute(item, "parent", "link"),
        child=_attribute(item, "child", "link"),
        rotation=rotation,
        translation=translation,
        axis=_axis(item),
        loop=False,
        successor_rotation=identity(),
        successor_translation=[mpf(0)] * 3,
    )


def _loop(item: ElementTree.Element) -> Joint:
    sides = [item.find(side) for side in ("predecessor", "successor")]
    (rotation, translation), (turn, shift) = (_origin(side) for side in sides if side is not None)
    return Joint(
        name=item.get("name", ""),
        kind=item.get("type", ""),
        parent=_attribute(item, "predecessor", "link"),
        child=_attribute(item, "successor", "link"),
        rotation=rotation,
        translation=translation,
        axis=_axis(item),
        loop=True,
        successor_rotation=turn,
        successor_translation=shift,
    )


def _attribute(item: ElementTree.Element, tag: str, key: str) -> str:
    found = item.find(tag)
    return "" if found is None else found.get(key, "")


def _axis(item: ElementTree.Element) -> Vector:
    text = _attribute(item, "axis", "xyz") or "1 0 0"
    axis = [mpf(float(value)) for value in text.split()]
    norm = mp.sqrt(dot(axis, axis))
    return [value / norm for value in axis]


def _origin(item: ElementTree.Element) -> tuple[Matrix, Vector]:
    origin = item.find("origin")
    attributes = {} if origin is None else origin.attrib
    shift = [mpf(float(value)) for value in attributes.get("xyz", "0 0 0").split()]
    roll, pitch, yaw = (mpf(float(x)) for x in attributes.get("rpy", "0 0 0").split())
    units = [[mpf(i == k) for i in range(3)] for k in range(3)]
    turn = product(about(units[1], pitch), about(units[0], roll))
    turn = product(about(units[2], yaw), turn)
    return turn, shift
