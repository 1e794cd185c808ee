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

from .exact_equations import least_squares, unique_solution
from .exact_reading import Joint, read_body, read_joint, read_loop
from .vectors import (
    Matrix,
    Vector,
    about,
    add,
    axial,
    combined,
    cross,
    flip,
    identity,
    product,
    turn,
)

Pose = tuple[Matrix, Vector]
"""Rotation and origin of a link in the world."""
DIGITS = 130
"""Digits of the evaluation: second differences over `STEP` lose 60 of them, and 50 must be left."""
STEP = "1e-30"
"""Step of the central differences. Their error is of the order of its square, 1e-60."""
_CONVERGED = "1e-75"
"""Newton step after which the loops are closed: its square is below the last of the digits."""
_ITERATIONS = 60
"""Newton steps after which the guess counts as unusable. Near the solution each step doubles the
correct digits, so that a few are enough."""


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
        self.bodies = {link.get("name", ""): read_body(link) for link in root.findall("link")}
        self.joints = [read_joint(item) for item in root.findall("joint")]
        self.loops = [read_loop(item) for item in root.findall("loop")]
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
            guess: positions of the passive joints near those of the assembly mode.
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
        positions = self.close(start, fixed)
        step = mpf(STEP)
        states = [positions]
        velocities = {name: mpf(0) for name in positions}
        accelerations = dict(velocities)
        if not quasi_static and any([*speed.values(), *acceleration.values()]):
            step = step / _fastest(speed, acceleration)
            states += [
                self._moved(positions, fixed, speed, acceleration, time) for time in (-step, step)
            ]
            for name in positions:
                now, before, after = (state[name] for state in states)
                velocities[name] = (after - before) / (2 * step)
                accelerations[name] = (after - 2 * now + before) / step**2
        poses = [self.poses(state) for state in states]
        wrenches = self._wrenches(poses, step, fixed, loads or {}, [mpf(g) for g in gravity])
        return State(positions, velocities, accelerations, wrenches)

    def _moved(
        self,
        positions: Mapping[str, mpf],
        fixed: Mapping[str, mpf],
        speed: Mapping[str, float],
        acceleration: Mapping[str, float],
        time: mpf,
    ) -> dict[str, mpf]:
        """Return the coordinates with closed loops a short time later, or earlier if negative."""
        moved = {
            name: value
            + time * mpf(speed.get(name, 0))
            + time**2 * mpf(acceleration.get(name, 0)) / 2
            for name, value in fixed.items()
        }
        passive = {name: value for name, value in positions.items() if name not in fixed}
        return self.close(passive, moved)

    def poses(self, positions: Mapping[str, mpf]) -> dict[str, Pose]:
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
        for _ in range(_ITERATIONS):
            state = {**passive, **fixed}
            error = self._scaled(state, size)
            columns = self._columns(state, list(passive), size)
            step = least_squares(columns, [-value for value in error])
            passive = {
                name: passive[name] + change for name, change in zip(passive, step, strict=True)
            }
            # Quadratic: the error after this step is its square.
            if max([abs(change) for change in step], default=mpf(0)) < mpf(_CONVERGED):
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

    def ends(self, loop: Joint, poses: Mapping[str, Pose]) -> list[Pose]:
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
        self, name: str, poses: list[dict[str, Pose]], step: mpf, gravity: Vector
    ) -> tuple[Vector, Vector, Vector]:
        """Return what must act on a body: force, moment about its centre, and its centre."""
        body = self.bodies[name]
        centres = [add(pose[name][1], turn(pose[name][0], body.centre)) for pose in poses]
        force, moment = [-body.mass * g for g in gravity], [mpf(0)] * 3
        if len(poses) == 3:
            now, before, after = centres
            for k in range(3):
                force[k] += body.mass * (after[k] - 2 * now[k] + before[k]) / step**2
            now, before, after = (pose[name][0] for pose in poses)
            first = combined(after, before, now, (1, -1, 0), 2 * step)
            second = combined(after, before, now, (1, 1, -2), step**2)
            flipped = flip(now)
            spin, change = axial(product(first, flipped)), axial(product(second, flipped))
            inertia = product(product(now, body.inertia), flipped)
            moment = add(turn(inertia, change), cross(spin, turn(inertia, spin)))
        return force, moment, centres[0]

    def _wrenches(
        self,
        poses: list[dict[str, Pose]],
        step: mpf,
        fixed: Mapping[str, mpf],
        loads: Mapping[str, float],
        gravity: Vector,
    ) -> dict[str, list[mpf | None]]:
        """Solve the laws of motion of all bodies for the wrenches of all joints."""
        joints = self.joints + self.loops
        frames = [
            self.ends(joint, poses[0])[1] if joint.loop else poses[0][joint.child]
            for joint in joints
        ]
        rows: Matrix = []
        for name in self.bodies:
            if name != self.root:
                force, moment, centre = self.inertia_wrench(name, poses, step, gravity)
                block = _balance(name, centre, joints, frames)
                rows += [[*row, value] for row, value in zip(block, force + moment, strict=True)]
        for index, joint in enumerate(joints):
            if joint.name in fixed or joint.kind == "fixed":
                continue
            row = [mpf(0)] * (6 * len(joints) + 1)
            for k in range(3):
                row[6 * index + (0 if joint.kind == "prismatic" else 3) + k] = joint.axis[k]
            row[-1] = mpf(loads.get(joint.name, 0))
            rows.append(row)
        values = unique_solution(rows)
        return {joint.name: values[6 * index : 6 * index + 6] for index, joint in enumerate(joints)}


def _fastest(speed: Mapping[str, float], acceleration: Mapping[str, float]) -> mpf:
    """Return the rate [1/s] by which to divide the step, so that no drive moves by more than it."""
    return max(
        [
            mpf(1),
            *(abs(mpf(value)) for value in speed.values()),
            *(mp.sqrt(abs(mpf(value))) for value in acceleration.values()),
        ]
    )


def _balance(name: str, centre: Vector, joints: list[Joint], frames: list[Pose]) -> Matrix:
    """Return six rows: force on a body, and moment about its centre, per wrench component."""
    block = [[mpf(0)] * (6 * len(joints)) for _ in range(6)]
    for index, (joint, (rotation, origin)) in enumerate(zip(joints, frames, strict=True)):
        sign = (joint.child == name) - (joint.parent == name)
        if not sign:
            continue
        arm = [a - b for a, b in zip(origin, centre, strict=True)]
        for k in range(3):
            unit = [rotation[i][k] for i in range(3)]
            moment = cross(arm, unit)
            for i in range(3):
                block[i][6 * index + k] = sign * unit[i]
                block[3 + i][6 * index + k] = sign * moment[i]
                block[3 + i][6 * index + 3 + k] = sign * unit[i]
    return block
