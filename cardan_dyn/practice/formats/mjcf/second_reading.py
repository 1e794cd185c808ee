"""Second reading of MJCF: the numbers of a model from where MuJoCo's own kinematics put it.

The first reader takes placements in parents from the compiled model. Here they come from those in
the world, as MuJoCo computes them in the initial configuration.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from ....core.description.description import (
    Description,
    JointDescription,
    LinkDescription,
    LoopDescription,
    SourceText,
    at_last_parts,
)
from ....kit.arrays import Array, inverse
from ..renumbered import link_in, placed_at
from .compiled import Compiled, compiled


def reread(description: Description, source: SourceText) -> Description:
    """Return a description with the masses, placements, axes and ratios of MuJoCo's model."""
    return _Placed(compiled(source.text, source.path, "MJCF")).reread(description)


class _Placed:
    """A model in its initial configuration."""

    def __init__(self, found: Compiled) -> None:
        import mujoco

        self._found, self._model = found, (model := found.model)
        self._data = data = mujoco.MjData(found.model)
        for joint, held in found.locked.items():
            data.qpos[found.model.jnt_qposadr[joint]] += held
        mujoco.mj_kinematics(found.model, data)
        self._armature = _armature(found.model)
        self._least = 2.0 * mujoco.mjMINVAL
        self._site = mujoco.mjtObj.mjOBJ_SITE
        self._kinds = int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_TENDON)
        self._slide = mujoco.mjtJoint.mjJNT_SLIDE
        self._bodies = {name: body for body, of in enumerate(found.links) for name in of}
        self._joints = {
            name: found.model.body_jntadr[body] + k
            for body, of in enumerate(found.joints)
            for k, name in enumerate(of)
            if found.model.body_jntnum[body]
        }
        self._at = [_frame(*of) for of in zip(data.xpos, data.xmat, strict=True)]
        self._links = {name: self._at[body] for name, body in self._bodies.items()}
        for body, of in enumerate(found.links if found.locked else ()):
            # The joints of a body act in their order: later ones carry no link before.
            first, last = model.body_jntadr[body], model.body_jntadr[body] + len(of)
            for count, name in enumerate(of[:-1], start=1):
                before, later = mujoco.MjData(model), model.jnt_qposadr[first + count : last]
                before.qpos[:] = data.qpos
                before.qpos[later] = model.qpos0[later]
                mujoco.mj_kinematics(model, before)
                self._links[name] = _frame(before.xpos[body], before.xmat[body])

    def reread(self, description: Description) -> Description:
        """See `reread`."""
        model = self._model
        active = [k for k in range(model.neq) if model.eq_active0[k]]
        joint, tendon = self._kinds
        loops = [k for k in active if model.eq_type[k] not in self._kinds]
        ratios = {
            (self._of_joint(model.eq_obj1id[k]), self._of_joint(model.eq_obj2id[k])): tuple(
                model.eq_data[k][:5].tolist()
            )
            for k in active
            if model.eq_type[k] == joint and model.eq_obj2id[k] >= 0
        }
        ratios |= dict(self._of_tendons(k) for k in active if model.eq_type[k] == tendon)
        return replace(
            description,
            links=tuple(self._link(link.name) for link in description.links),
            joints=tuple(map(self._joint, description.joints)),
            loops=tuple(
                self._loop(loop, k) for loop, k in zip(description.loops, loops, strict=True)
            ),
            couplings=tuple(
                replace(
                    item,
                    offset=float(of[0]),
                    ratio=float(of[1]),
                    higher=tuple(np.trim_zeros(of[2:], "b")),
                )
                for item in description.couplings
                for of in [ratios[item.successor, item.predecessor]]
            ),
        )

    def _of_tendons(self, index: int) -> tuple[tuple[str, str], tuple[float, ...]]:
        """Return the joints that tendons couple, and the polynomial of the one that follows.

        They are those along which MuJoCo's tendons stretch, unlike what the equality asks of them.
        """
        import mujoco

        model, data = self._model, self._data
        ends, terms = (model.eq_obj1id[index], model.eq_obj2id[index]), model.eq_data[index][:5]
        if ends[1] < 0:
            terms = terms * [1.0, 0.0, 0.0, 0.0, 0.0]
        along = {}
        for name, joint in self._joints.items():
            place = model.jnt_qposadr[joint]
            before = data.qpos[place]
            data.qpos[place] = before + 1.0
            mujoco.mj_tendon(model, data)
            along[name] = np.array([data.ten_length[k] - model.tendon_length0[k] for k in ends])
            data.qpos[place] = before
        if terms[2:].any():
            driven, driving = (max(along, key=lambda name: abs(along[name][k])) for k in (0, 1))
            on, by = along[driven][0], along[driving][1]
            return (driven, driving), tuple(terms * by ** np.arange(5.0) / on)
        slopes = {name: first - terms[1] * second for name, (first, second) in along.items()}
        # Along all other joints there is rounding at most.
        pair = sorted(slopes, key=lambda name: abs(slopes[name]))[-2:]
        driving, driven = (name for name in slopes if name in pair)
        return (driven, driving), (terms[0] / slopes[driven], -slopes[driving] / slopes[driven])

    def _of_joint(self, index: int) -> str:
        return next(name for name, k in self._joints.items() if k == index)

    def _link(self, name: str) -> LinkDescription:
        body = self._bodies[name]
        mass = float(self._model.body_mass[body])
        if name != self._found.links[body][-1] or mass < self._least:
            return LinkDescription(name)
        moments = self._model.body_inertia[body]
        moments = np.where(moments < self._least, 0.0, moments)
        placed = inverse(self._at[body]) @ _frame(self._data.xipos[body], self._data.ximat[body])
        return link_in(name, mass, placed, np.diag(moments))

    def _joint(self, joint: JointDescription) -> JointDescription:
        """Return a joint in the frame that has the axes of its child."""
        child, index = self._links[joint.child], self._joints.get(joint.name)
        frame, axis = child.copy(), joint.axis
        if index is not None and joint.type != "floating":
            frame[:3, 3] = self._data.xanchor[index]
            if self._model.jnt_type[index] == self._slide:
                # It carries its frame; what MuJoCo calls its anchor stays behind.
                held = self._found.locked.get(index, 0.0)
                frame[:3, 3] += held * self._data.xaxis[index]
            if joint.type not in ("spherical", "fixed"):
                axis = frame[:3, :3].T @ self._data.xaxis[index]
        rotors: list[float] = []
        if index is not None and joint.type != "fixed":
            first = self._model.jnt_dofadr[index]
            # Of a free joint those of its three slides, then of its ball.
            count = 4 if joint.type == "floating" else 1
            rotors = self._armature[first : first + count].tolist()
        placed = placed_at(joint, [frame], self._links, axis)
        return replace(placed, armature=at_last_parts(rotors, joint.type))

    def _loop(self, loop: LoopDescription, index: int) -> LoopDescription:
        model, data = self._model, self._model.eq_data[index]
        ids, is_ball = (model.eq_obj1id[index], model.eq_obj2id[index]), loop.type == "spherical"
        if model.eq_objtype[index] == self._site:
            ends = [_frame(self._data.site_xpos[k], self._data.site_xmat[k]) for k in ids]
        else:
            points = (data[:3], data[3:6]) if is_ball else (data[3:6], data[:3])
            turn = np.eye(3) if is_ball else _turn(data[6:10])
            local = map(_frame, points, (turn, np.eye(3)))
            ends = [self._at[k] @ end for k, end in zip(ids, local, strict=True)]
        if is_ball:
            ends[1][:3, :3] = ends[0][:3, :3]
        return placed_at(loop, ends, self._links)


def _armature(model: Any) -> Array:
    """Return `(nv,)` the inertia along all rates of a mechanism whose bodies have no mass.

    What acts along tendons and sites is no joint's own, and left out.
    """
    import mujoco

    light = copy(model)
    light.body_mass[:], light.body_inertia[:], light.body_simple[:] = 0.0, 0.0, 0
    light.dof_simplenum[:], light.tendon_armature[:] = 0, 0.0
    light.actuator_armature[light.actuator_trntype > int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)] = 0.0
    data, full = mujoco.MjData(light), np.zeros((model.nv, model.nv))
    for step in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_makeM):
        step(light, data)
    mujoco.mj_fullM(light, data, full)
    return np.diag(full)


def _frame(position: Array, rotation: Array) -> Array:
    """Return the `(4, 4)` placement of a position and a rotation of nine numbers."""
    result = np.eye(4)
    result[:3, 3], result[:3, :3] = position, rotation.reshape(3, 3)
    return result


def _turn(quaternion: Any) -> Array:
    """Return the `(3, 3)` rotation of a quaternion by MuJoCo."""
    import mujoco

    result = np.zeros(9)
    mujoco.mju_quat2Mat(result, quaternion)
    return result.reshape(3, 3)
