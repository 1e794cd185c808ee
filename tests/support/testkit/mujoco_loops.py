"""Closed chains on MuJoCo's own numbers: one linear system of mass matrix, bias force and loops.

Loops are screws between two bodies, whose rows come from MuJoCo's Jacobians and their rates. What
is solved are accelerations, efforts of drives, and wrenches, with a random self-stress added where
they are not unique.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.linalg import null_space, qr

import cardan_dyn as cd

Array = np.ndarray
CARDAN = ("turn_x", "turn_y", "turn_z")
SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
"""Types of joints with one coordinate."""


def framed(position: Array, rotation: Array) -> Array:
    """Return the `(4, 4)` placement of a position and a rotation of nine numbers."""
    result = np.eye(4)
    result[:3, 3], result[:3, :3] = position, np.reshape(rotation, (3, 3))
    return result


class Closure(NamedTuple):
    """A joint that closes a loop.

    Attributes:
        name: of the joint.
        first, second: indices of its bodies.
        placement: `(4, 4)` of its frame in the world.
        screws: `(k, 7)` motions that it allows: linear and angular part of a twist in that frame,
            and 0.0 if it moves with the first body, else 1.0.
        force: velocity along its one motion to the force or moment that is exerted along it.
    """

    name: str
    first: int
    second: int
    placement: Array
    screws: Array
    force: Callable[[float], float] | None = None


def screws(kind: str, axis: Array, axis_2: Array | None = None) -> Array:
    """Return the screws of a type of joint by its axes `(3,)`."""
    e, zero = np.asarray(axis, dtype=float), np.zeros(3)
    if kind == "spherical":
        return np.array([[*zero, *row, 0.0] for row in np.eye(3)])
    if kind == "universal":
        return np.array([[*zero, *e, 0.0], [*zero, *np.asarray(axis_2, dtype=float), 1.0]])
    if kind == "fixed":
        return np.zeros((0, 7))
    return np.array([[*e, *zero, 0.0] if kind == "prismatic" else [*zero, *e, 0.0]])


class Loops:
    """A model in a state: Jacobians, and what they say of accelerations and forces.

    Attributes:
        model, data: of MuJoCo, without constraints of its own.
        jacobian: `(m, nv)` rows of all loops and couplings.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        q: Array,
        closures: Sequence[Closure],
        couplings: Sequence[tuple[int, int, float]] = (),
    ) -> None:
        """Compute Jacobians.

        Args:
            model: it is changed.
            q: `(nq,)` a configuration that closes all loops.
            closures: the loops.
            couplings: velocity coordinates that follow another one, that one, and the ratio; -1 in
                its place where they are held.
        """
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self.model, self.data = model, mujoco.MjData(model)
        self.data.qpos[:] = q
        mujoco.mj_fwdPosition(model, self.data)
        self._closures, self._wrenches = closures, []
        self._passive: dict[str, Array] = {}
        rows = [np.zeros((0, model.nv))]
        for item in closures:
            twists = _in_world(item)
            self._wrenches.append(null_space(twists) if len(twists) else np.eye(6))
            rows.append(
                self._wrenches[-1].T @ (self._spatial(item.second) - self._spatial(item.first))
            )
        for follower, leader, ratio in couplings:
            row = np.zeros((1, model.nv))
            row[0, follower] = 1.0
            if leader >= 0:
                row[0, leader] = -ratio
            rows.append(row)
        self.jacobian = np.vstack(rows)

    def _spatial(self, body: int, rate: bool = False) -> Array:
        """Return the Jacobian `(6, nv)` of a body's twist about the world's origin, or its rate.

        The rate is that of a body's point, which lies there now.
        """
        linear, angular = np.zeros((2, 3, self.model.nv))
        of = mujoco.mj_jacDot if rate else mujoco.mj_jac
        of(self.model, self.data, linear, angular, np.zeros(3), body)
        return np.vstack([linear, angular])

    def move(self, v: Array) -> Array:
        """Set velocities `(nv,)`; return what the rows of accelerations `(m,)` have to be."""
        model, data = self.model, self.data
        data.qvel[:] = v
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        result = np.zeros(len(self.jacobian))
        start = 0
        for item, wrenches in zip(self._closures, self._wrenches, strict=True):
            twists, drifts = [], []
            for body in (item.first, item.second):
                twist = self._spatial(body) @ v
                drift = self._spatial(body, rate=True) @ v
                # A point's acceleration has a part that the rate of a twist has not.
                drift[:3] -= np.cross(twist[3:], twist[:3])
                twists.append(twist)
                drifts.append(drift)
            screws = _in_world(item)
            self._passive[item.name] = np.zeros(6)
            ways = np.linalg.lstsq(screws.T, twists[1] - twists[0], rcond=None)[0]
            if item.force is not None:
                turn, at = item.placement[:3, :3], item.placement[:3, 3]
                force, moment = item.force(float(ways[0])) * (
                    item.screws[0, :6].reshape(2, 3) @ turn.T
                )
                self._passive[item.name] = np.concatenate([force, moment + np.cross(at, force)])
            carried = np.zeros(6)
            for screw, way, which in zip(screws, ways, item.screws[:, 6], strict=True):
                carried += way * _cross(twists[int(which)], screw)
            count = wrenches.shape[1]
            result[start : start + count] = wrenches.T @ (carried - drifts[1] + drifts[0])
            start += count
        return result

    def passive(self) -> Array:
        """Return the forces `(nv,)` that loops exert by themselves, after `move`."""
        result = np.zeros(self.model.nv)
        for item in self._closures:
            between = self._spatial(item.second) - self._spatial(item.first)
            result += between.T @ self._passive[item.name]
        return result

    def wrenches(self, a: Array, forces: Array) -> tuple[Array, dict[str, Array]]:
        """Return what parents exert on bodies `(nbody, 6)` about the world's origin, and loops.

        Args:
            a: `(nv,)` accelerations.
            forces: `(m,)` of the rows.
        """
        model, data = self.model, self.data
        data.xfrc_applied[:] = 0.0
        loops, start = {}, 0
        for item, basis in zip(self._closures, self._wrenches, strict=True):
            count = basis.shape[1]
            wrench = basis @ forces[start : start + count] + self._passive[item.name]
            loops[item.name] = wrench
            start += count
            for body, sign in ((item.first, -1.0), (item.second, 1.0)):
                moment = wrench[3:] - np.cross(data.xipos[body], wrench[:3])
                data.xfrc_applied[body] += sign * np.concatenate([wrench[:3], moment])
        data.qacc[:] = a
        mujoco.mj_rnePostConstraint(model, data)
        result = np.zeros((model.nbody, 6))
        for body in range(1, model.nbody):
            moment, force = data.cfrc_int[body][:3], data.cfrc_int[body][3:]
            about = data.subtree_com[model.body_rootid[body]]
            result[body] = [*force, *(moment + np.cross(about, force))]
        return result, loops

    def mass(self) -> Array:
        """Return the mass matrix `(nv, nv)`, rotor inertia included."""
        result = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, result)
        return result


def _in_world(item: Closure) -> Array:
    """Return the screws `(k, 6)` of a loop as twists about the world's origin."""
    turn, at = item.placement[:3, :3], item.placement[:3, 3]
    linear, angular = item.screws[:, :3] @ turn.T, item.screws[:, 3:6] @ turn.T
    return np.hstack([linear + np.cross(at, angular), angular])


def _cross(twist: Array, screw: Array) -> Array:
    """Return the rate of a screw that moves with a twist."""
    v, w = twist[:3], twist[3:]
    return np.concatenate([np.cross(w, screw[:3]) + np.cross(v, screw[3:]), np.cross(w, screw[3:])])


class Column(NamedTuple):
    """A velocity coordinate of MuJoCo's model, and what it is called here.

    Attributes:
        name: of the coordinate.
        ours: its column in Pinocchio's model; -1 where an equality holds it.
        joint: that it belongs to.
    """

    name: str
    ours: int
    joint: str


def columns(
    mechanism: cd.Mechanism, model: mujoco.MjModel, turns: Mapping[str, Array] | None = None
) -> tuple[list[Column], Array]:
    """Return the coordinates in MuJoCo's order, and the map `(nv, nv)` to MuJoCo's velocities.

    MuJoCo counts turns of balls about the child's axes, and ways of a free body along the axes of
    the world; here both are along those in which they start.

    Args:
        mechanism, model: the same one, whose joints have the same names. A hinge `u.turn_2` of
            MuJoCo's is that of a universal joint `u`.
        turns: names of balls to the axes `(3, 3)`, in MuJoCo's child, about which they turn here;
            without one they are the child's.
    """
    result, turn = [], np.eye(model.nv)
    for index in range(model.njnt):
        name = model.joint(index).name
        joint = name if name in mechanism.joints else name.rpartition(".turn_")[0]
        ours = [
            int(mechanism.model.idx_vs[part.id]) + k
            for part in (mechanism.joints[joint].parts if joint else ())
            for k in range(part.nv)
        ]
        names = [name]
        if joint not in ("", name):
            ours = [ours[int(name[-1]) - 1]]
        elif len(ours) > 1:
            names = [f"{name}.{word}" for word in ("x", "y", "z", *CARDAN)[: len(ours)]]
        start, address = model.jnt_dofadr[index], model.jnt_qposadr[index]
        if len(ours) == 6:
            initial = np.zeros(9)
            mujoco.mju_quat2Mat(initial, model.qpos0[address + 3 : address + 7])
            turn[start : start + 3, start : start + 3] = initial.reshape(3, 3)
        if name in (turns or {}):
            turn[start : start + 3, start : start + 3] = turns[name]
        # A joint that an equality holds has no coordinate here.
        result += [Column(*item, joint or name) for item in zip(names, ours or [-1], strict=True)]
    return result, turn


def drives(jacobian: Array, rng: np.random.Generator, allowed: Array) -> list[int] | None:
    """Return velocity coordinates that decide all others well, drawn by lot; None without any."""
    free = null_space(jacobian, rcond=1e-9) if len(jacobian) else np.eye(jacobian.shape[1])
    if not free.shape[1]:
        return None
    weights = rng.uniform(0.3, 1.0, size=len(free)) * allowed
    order = qr(free.T * weights, pivoting=True, mode="r")[1][: free.shape[1]]
    chosen = [int(index) for index in order if allowed[index]]
    if len(chosen) < len(order):
        return None
    return chosen if np.linalg.svd(free[chosen], compute_uv=False)[-1] > 0.05 else None


def same_tree(
    mechanism: cd.Mechanism,
    model: mujoco.MjModel,
    rng: np.random.Generator,
    turns: Mapping[str, Array] | None = None,
) -> None:
    """Hold mass matrix and bias forces against MuJoCo's at a random state.

    Rotor inertia is part of both.
    """
    data, ours = mujoco.MjData(model), mechanism.model
    of, to_theirs = columns(mechanism, model, turns)
    order = [item.ours for item in of]
    step, v = rng.normal(size=(2, model.nv))
    # Slides of a free body stand before its turns, and move along axes of where it starts.
    mujoco.mj_integratePos(model, data.qpos, to_theirs @ step, 1.0)
    data.qvel[:] = to_theirs @ v
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    mass = to_theirs.T @ mass @ to_theirs
    our_step, our_v = np.zeros((2, ours.nv))
    our_step[order], our_v[order] = step, v
    ours.gravity.linear = model.opt.gravity.copy()
    q = pin.integrate(ours, pin.neutral(ours), our_step)
    place = ours.createData()
    found = pin.crba(ours, place, q)
    found = np.triu(found) + np.triu(found, 1).T
    bias = pin.nonLinearEffects(ours, ours.createData(), q, our_v)
    their_bias = to_theirs.T @ data.qfrc_bias
    scale = max(np.max(np.abs(mass)), np.max(np.abs(their_bias)))
    for mine, other in ((found[np.ix_(order, order)], mass), (bias[order], their_bias)):
        np.testing.assert_allclose(mine, other, rtol=0.0, atol=1e-10 * scale)


def same_dynamics(
    mechanism: cd.Mechanism,
    loops: Loops,
    rng: np.random.Generator,
    near: Mapping[str, float],
    passive: Callable[[Array], Array],
    bodies: Mapping[str, int],
    turns: Mapping[str, Array] | None = None,
) -> int:
    """Hold a sweep at one position against MuJoCo's numbers; return how many wrenches were held.

    Args:
        mechanism: what was read.
        loops: the model in the configuration where the scene starts.
        rng: draws drives, speeds and accelerations.
        near: coordinates at the start, of those that are not zero.
        passive: velocities to forces `(nv,)` that described elements exert along coordinates.
        bodies: joints to the bodies that they carry, of those whose wrenches are compared.
        turns: see `columns`.
    """
    model = loops.model
    listed, turn = columns(mechanism, model, turns)
    jacobian = loops.jacobian @ turn
    chosen = drives(jacobian, rng, np.ones(model.nv, dtype=bool))
    if chosen is None:
        return 0
    names = [listed[index].name for index in chosen]
    speed, rate = rng.normal(size=(2, len(chosen)))
    pick = np.eye(model.nv)[chosen]
    system = np.vstack([jacobian, pick])
    v = np.linalg.lstsq(system, np.concatenate([np.zeros(len(jacobian)), speed]), rcond=None)[0]
    # Cardan angles at zero: their accelerations differ from those of the turn.
    bent = np.zeros(model.nv)
    for index, item in enumerate(listed):
        if item.name == f"{item.joint}.{CARDAN[0]}" or (
            item.name == f"{item.joint}.x" and mechanism.joints[item.joint].type == "spherical"
        ):
            x, y, z = v[index : index + 3]
            bent[index : index + 3] = y * z, -x * z, x * y
    needed = loops.move(turn @ v)
    a = np.linalg.lstsq(system, np.concatenate([needed, rate + bent[chosen]]), rcond=None)[0]
    mass = loops.mass()
    effort = turn.T @ (mass @ turn @ a + loops.data.qfrc_bias - passive(turn @ v) - loops.passive())
    found = np.linalg.lstsq(np.hstack([jacobian.T, pick.T]), effort, rcond=None)[0]
    np.testing.assert_allclose(
        jacobian.T @ found[: len(jacobian)] + pick.T @ found[len(jacobian) :],
        effort,
        atol=1e-9 * max(1.0, np.max(np.abs(effort))),
    )
    forces, motors = found[: len(jacobian)], found[len(jacobian) :]
    stress = null_space(jacobian.T, rcond=1e-9) if len(jacobian) else np.zeros((0, 0))
    forces = forces + np.max(np.abs(forces), initial=0.0) * stress @ rng.normal(
        size=stress.shape[1]
    )
    by_body, by_loop = loops.wrenches(turn @ a, forces)

    angled = {listed[index].joint for index in chosen}
    if any(
        item.name in angled
        and item.type in ("spherical", "floating")
        and item.armature[-1:] > (0.0,)
        for item in mechanism.description.joints
    ):
        with pytest.raises(cd.ModelError, match="its ball has an armature"):
            cd.Scene(mechanism, drive=names, gravity=model.opt.gravity.copy())
        return 0
    scene = cd.Scene(
        mechanism,
        drive=names,
        gravity=model.opt.gravity.copy(),
        near=dict(near) or None,
        elements=cd.described_elements(mechanism),
    )
    at = [near.get(name, 0.0) for name in names]
    turned = scene.sweep(np.array([at]), np.array([speed]), np.array([rate]))
    ours = np.array([item.ours for item in listed])
    # Balls of which an angle is named have the accelerations of their angles.
    named = {
        joint
        for joint, _, angle in (item.rpartition(".") for item in (*names, *near))
        if angle in CARDAN or (joint and mechanism.joints[joint].type == "spherical")
    }
    a = a - np.where([item.joint in named for item in listed], bent, 0.0)
    for mine, theirs in (
        (turned.motion.v[0][ours[ours >= 0]], v[ours >= 0]),
        (turned.motion.a[0][ours[ours >= 0]], a[ours >= 0]),
        (np.ravel(turned.drive_effort[0]), motors),
    ):
        _close(mine, theirs, np.max(np.abs(theirs)))
    greatest = np.max(np.abs([*by_body, *by_loop.values()]), axis=0)
    held, origins = 0, {}
    for name, body in bodies.items():
        origins[name] = by_body[body]
    origins |= by_loop
    for name, theirs in origins.items():
        wrench = turned.wrench(name, "world")
        at_origin = np.concatenate(
            [theirs[:3], theirs[3:] - np.cross(turned.origin(name)[0], theirs[:3])]
        )
        mine = np.concatenate([wrench.force[0], wrench.moment[0]])
        for columns_, size in ((slice(0, 3), greatest[:3]), (slice(3, 6), greatest[3:])):
            kept = wrench.unique[columns_]
            _close(mine[columns_][kept], at_origin[columns_][kept], np.max(size))
            held += int(np.sum(kept))
    return held


def passive_force(way: float, v: float, stiffness: float, damping: float, friction: float) -> float:
    """Return what damps, rubs and springs along a coordinate, friction by the law here.

    Args:
        way: from where the spring rests.
        v: velocity.
        stiffness, damping, friction: of the joint.
    """
    return -stiffness * way - damping * v - friction * v / float(np.hypot(v, 1e-3))


def passive_forces(model: mujoco.MjModel, v: Array, q: Array) -> Array:
    """Return these forces `(nv,)` of hinges and slides."""
    result = np.zeros(model.nv)
    for k in range(model.njnt):
        if model.jnt_type[k] in SINGLE:
            dof, at = model.jnt_dofadr[k], model.jnt_qposadr[k]
            result[dof] = passive_force(
                q[at] - model.qpos_spring[at],
                v[dof],
                model.jnt_stiffness[k],
                model.dof_damping[dof],
                model.dof_frictionloss[dof],
            )
    return result


def _close(mine: Array, theirs: Array, size: float) -> None:
    np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=1e-10 * max(1.0, float(size)))
