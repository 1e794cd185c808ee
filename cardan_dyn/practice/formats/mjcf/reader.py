"""MJCF: a MuJoCo model to a checked description, by MuJoCo's own parser and compiler.

Bodies, joints, masses, armatures and rigid equalities of a compiled model are read, and damping,
friction and springs of joints, which scenes take as elements. Forces of other kinds would change
wrenches as well: they are refused, or left out with a warning.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from xml.etree.ElementTree import Element

import numpy as np

from ....core.description.description import (
    UNBOUNDED,
    CouplingDescription,
    Description,
    Dynamics,
    JointDescription,
    Limits,
    LinkDescription,
    LoopDescription,
    SourceText,
    summed_efforts,
)
from ....core.description.elements import (
    GREATEST,
    SINGLE_TYPES,
    armature,
    at_point,
    check_size,
    unique,
)
from ....core.description.left_out import forces_left_out, line_of
from ....kit.arrays import Array, inverse, quaternion_product
from ....kit.errors import ModelError
from ....kit.frozen import FrozenDict, frozen
from .actuators import actuators, ends
from .compiled import Compiled, compiled, placement

_TYPES = ("floating", "spherical", "prismatic", "revolute")
"""Types of joints, in the order of MuJoCo's `mjtJoint`."""
_EQUALITIES = {0: "connect", 1: "weld", 2: "joint", 3: "tendon"}
_UNSUPPORTED = (
    "it is not supported; kinds: connect, joint, weld, and tendon where fixed tendons couple two "
    "joints that move; by a polynomial with higher powers, one joint on either tendon"
)
"""Kinds of `mjtEq`; others are of deformable bodies."""


def parse(root: Element, given: SourceText, where: str, strict: bool) -> Description:
    """Read an MJCF model; equalities `connect` and `weld` become loops, `joint` couplings.

    Joints that share a body get massless links between them. All coordinates are zero in the
    initial configuration, also those to which the file gives another value there (`ref`). A joint
    that an equality holds is fixed.

    Args:
        root: outermost element of the main file.
        given: its text and path, from which included files and meshes are found.
        where: how messages name the source of the text.
        strict: whether forces that no wrench considers are refused.

    Raises:
        MissingExtraError: MuJoCo is not installed.
        ModelError: what is wrong, where, and the valid choices.
    """
    found = compiled(given.text, given.path, where)
    check_size(sum(map(len, found.links)), where)
    reader = _Reader(found, where)
    joints = tuple(reader.joints)
    loops, couplings = reader.equalities()
    left_out = forces_left_out(reader.forces(), where, strict)
    left_out += line_of(where, "limits", reader.limited_tendons(), "they couple nothing", "tendon")
    left_out += line_of(
        *(where, "efforts", reader.other_actuators(), "they act along no joint alone", "actuator")
    )
    return Description(
        name=root.get("model") or "mechanism",
        links=tuple(reader.links),
        joints=joints,
        order=tuple(joint.name for joint in joints),
        loops=tuple(loops),
        couplings=tuple(couplings),
        independent_joints=reader.actuated(),
        notation="MJCF <equality>" if loops or couplings else "no loops",
        warnings=(*found.warnings, *reader.warnings, *left_out),
        source=given,
        frames=frozen(reader.sites),
        keyframes=frozen(dict(reader.keyframes())),
        gravity=found.model.opt.gravity.copy(),
        states_gravity=found.states_gravity,
        actuators=reader.actuators,
    )


class _Reader:
    """Reads a compiled model.

    Attributes:
        links: those of all bodies, that of the world first.
        joints: those of the tree.
        sites: name to the link that carries it, and its placement there.
        actuators: those along joints that move.
        warnings: what is wrong and was accepted.
    """

    def __init__(self, found: Compiled, where: str) -> None:
        import mujoco

        self._mujoco, self._found, self._where = mujoco, found, where
        self._model = model = found.model
        self.warnings: list[str] = []
        self.links: list[LinkDescription] = []
        self.joints: list[JointDescription] = []
        # Actuators to the joints along which they act.
        along = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
        self._driven = {
            k: model.actuator_trnid[k][0]
            for k, kind in enumerate(model.actuator_trntype)
            if kind in along
        }
        # Joints as MuJoCo counts them; of bodies: their initial placement in the world.
        self._of_index: list[JointDescription] = []
        every = [
            name
            for names, n in zip(found.joints, model.body_jntnum, strict=True)
            for name in names[:n]
        ]
        single = {
            index: name
            for index, name in enumerate(every)
            if _TYPES[model.jnt_type[index]] in SINGLE_TYPES and index not in found.locked
        }
        self.actuators = tuple(actuators(model, self._driven, single))
        self._placements = [np.eye(4)]
        for body in range(model.nbody):
            if body:
                self._read_joints(body)
            self.links += map(LinkDescription, found.links[body][:-1])
            self.links.append(self._link(body))
        self.sites = {
            site: (found.links[model.site_bodyid[k]][-1], self._site(k))
            for k in range(model.nsite)
            if (site := model.site(k).name)
        }

    def _site(self, index: int) -> Array:
        return placement(self._model.site_pos[index], self._model.site_quat[index])

    def _link(self, body: int) -> LinkDescription:
        """Return the link of a body with its mass; it has none where MuJoCo gave it the least."""
        item, name = self._model.body(body), self._found.links[body][-1]
        at = f"{self._where}: body {name!r}"
        mass, moments = float(item.mass[0]), item.inertia
        least = np.nextafter(self._mujoco.mjMINVAL, 1.0)
        if item.mocapid[0] >= 0:
            self.warnings.append(f"{at}: mocap: it stands still")
        if mass <= least:
            return LinkDescription(name)
        turn = placement(np.zeros(3), item.iquat)[:3, :3]
        moments = np.where(moments > least, moments, 0.0)
        if not max(mass, *np.abs(item.ipos), *moments) <= GREATEST:
            raise ModelError(
                f"{at}: its mass or inertia is beyond {GREATEST:.0e}; choose units in which "
                "numbers are not so far from 1"
            )
        if not np.any(moments) and item.weldid[0]:
            self.warnings.append(f"{at}: it has a mass and no inertia: a point mass")
        inertia = (turn * moments) @ turn.T
        return LinkDescription(name, mass, item.ipos.copy(), inertia)

    def _read_joints(self, body: int) -> None:
        """Add the joints of a body."""
        item, found = self._model.body(body), self._found
        names, links, before = found.joints[body], found.links[body], item.parentid[0]
        origin = placement(item.pos, item.quat)
        parent, at_body = found.links[before][-1], self._placements[before]
        for count, (name, link) in enumerate(zip(names, links, strict=True)):
            joint = JointDescription(name, "fixed", parent, link, origin)
            if item.jntnum[0]:
                joint = self._joint(joint, item.jntadr[0] + count)
                self._of_index.append(joint)
            self.joints.append(joint)
            at_body = at_body @ joint.origin @ joint.child_placement
            # The links between the joints of a body all stand where the body stands.
            parent, origin = link, np.eye(4)
        self._placements.append(at_body)

    def _joint(self, fixed: JointDescription, index: int) -> JointDescription:
        """Return a joint of a body, whose frame is at its point and has the axes of the child."""
        item, at = self._model.joint(index), f"{self._where}: joint {fixed.name!r}"
        kind = _TYPES[item.type[0]]
        joint = replace(fixed, type=kind, armature=self._armature(index, kind, at))
        if kind == "floating":
            return joint
        origin, behind = fixed.origin @ at_point(item.pos), at_point(-item.pos)
        joint = replace(joint, origin=origin, child_placement=behind)
        if kind == "spherical":
            return joint
        axis, initial = item.axis.copy(), item.qpos0[0]
        if initial:
            in_degrees = kind == "revolute" and self._found.spec.compiler.degree
            shown = math.degrees(initial) if in_degrees else initial
            self.warnings.append(
                f"{at}: its coordinate is zero where the file counts {shown:g} (ref)"
            )
        if index in self._found.locked:
            held = self._found.locked[index]
            self.warnings.append(
                f"{at}: an equality holds it at {held:g} {'m' if kind == 'prismatic' else 'rad'}: "
                "it is fixed there"
            )
            placed = origin @ _moved(kind, axis, held)
            return replace(joint, type="fixed", origin=placed, armature=())
        limits, (dynamics, _) = self._efforts(index, fixed.name), self._along(index)
        if item.limited[0]:
            lower, upper = ends(item.range - initial)
            limits = replace(limits, lower=lower, upper=upper)
        elif kind == "revolute":
            kind = "continuous"
        return replace(joint, type=kind, axis=axis, limits=limits, dynamics=dynamics)

    def _armature(self, index: int, kind: str, at: str) -> tuple[float, ...]:
        """Return the armature of a joint, with that of the actuators on it.

        MuJoCo multiplies an actuator's by the square of its first gear, also where others act along
        a ball or a free joint.
        """
        model = self._model
        total = float(model.joint(index).armature[0])
        for actuator, joint in self._driven.items():
            if joint == index:
                gear = float(model.actuator_gear[actuator, 0])
                total += gear**2 * float(model.actuator_armature[actuator])
        return armature([total], kind, f"{at}: armature")

    def _efforts(self, index: int, name: str) -> Limits:
        """Return between which efforts the actuators of a joint together act on it."""
        acting = [item for item in self.actuators if item.joint == name]
        found = np.array(UNBOUNDED)
        if acting:
            found = np.array(
                summed_efforts([item.gear for item in acting], [item.force for item in acting])
            )
        if self._model.jnt_actfrclimited[index]:
            found = np.clip(found, *self._model.jnt_actfrcrange[index])
        least, greatest = ends(found)
        return Limits(effort=greatest, least_effort=least)

    def other_actuators(self) -> list[str]:
        """Return the names of actuators that act by tendons, sites or bodies."""
        model = self._model
        return [
            model.actuator(index).name or str(index + 1)
            for index in range(len(model.actuator_trntype))
            if index not in self._driven
        ]

    def _along(self, index: int) -> tuple[Dynamics, list[str]]:
        """Return what rubs and springs along a joint, and what of it no element is made of.

        Those are all of a joint with a ball, higher terms of a polynomial and negative values. The
        spring is at rest at `springref`, which counts as the file counts the joint; here the
        initial configuration is zero.
        """
        model, item = self._model, self._model.joint(index)
        is_single = _TYPES[item.type[0]] in SINGLE_TYPES
        taken, left = [0.0, 0.0, 0.0], list[str]()
        for place, (what, *more) in enumerate(
            (
                ("damping", *model.dof_dampingpoly[item.dofadr[0]]),
                ("frictionloss",),
                ("stiffness", *model.jnt_stiffnesspoly[index]),
            )
        ):
            first = float(getattr(item, what)[0])
            if is_single and first >= 0.0 and not any(more):
                taken[place] = first
            else:
                left += _stated(what, first, *more)
        if is_single:
            left += _stated("springyield", model.jnt_springyield[index])
        rest = float(item.qpos_spring[0] - item.qpos0[0]) if taken[-1] else 0.0
        damping, friction, stiffness = taken
        return Dynamics(damping, friction, stiffness, rest), left

    def limited_tendons(self) -> list[str]:
        """Return the names of tendons that stop where they are too long or too short."""
        limited = np.flatnonzero(self._model.tendon_limited)
        names = [self._model.tendon(index).name for index in limited.tolist()]
        return [name or str(number) for number, name in zip(limited + 1, names, strict=True)]

    def forces(self) -> list[str]:
        """Return what joints, bodies, fluids, tendons, actuators and flexes exert beside that."""
        model, found = self._model, list[str]()
        for index, joint in enumerate(self._of_index):
            if joint.type != "fixed":
                found += _line(f"joint {joint.name!r}", self._along(index)[1])
        for body, links in enumerate(self._found.links):
            owner = f"body {links[-1]!r}"
            found += _line(owner, _stated("gravcomp", model.body_gravcomp[body]))
            if model.body_plugin[body] >= 0:
                found.append(f"{owner}: a plugin")
        fluid = [*_stated("density", model.opt.density), *_stated("viscosity", model.opt.viscosity)]
        found += _line("option", fluid)
        for kind, count, words in (
            ("tendon", model.ntendon, ("armature", "damping", "stiffness", "frictionloss")),
            ("actuator", len(model.actuator_trntype), ("armature", "damping")),
        ):
            for index in range(count):
                # The armature of an actuator is that of the joint along which it acts.
                is_along = kind == "actuator" and index in self._driven
                parts = list[str]()
                for word in words[is_along:]:
                    first = getattr(model, f"{kind}_{word}")[index]
                    more = getattr(model, f"{kind}_{word}poly", np.zeros((count, 0)))[index]
                    parts += _stated(word, first, *more)
                found += _line(
                    f"{kind} {(getattr(model, kind)(index).name or str(index + 1))!r}", parts
                )
        flex = self._mujoco.mjtObj.mjOBJ_FLEX
        names = (self._mujoco.mj_id2name(model, flex, index) for index in range(model.nflex))
        return found + [f"flex {(name or '')!r}" for name in names]

    def keyframes(self) -> Iterator[tuple[str, FrozenDict[str, float | Array]]]:
        """Yield names of keyframes and the positions of joints in them, counted as here."""
        model = self._model
        joints = [item for item in enumerate(self._of_index) if item[1].type != "fixed"]
        taken = {model.key(key).name for key in range(model.nkey)}
        for key, at in enumerate(model.key_qpos):
            name = model.key(key).name or unique(f"keyframe_{key + 1}", taken)
            yield name, frozen({joint.name: self._counted(k, at) for k, joint in joints})

    def _counted(self, joint: int, at: Array) -> float | Array:
        """Return the position of a joint in coordinates of MuJoCo's, from where it is at first."""
        model, kind = self._model, self._of_index[joint].type
        place, initial = model.jnt_qposadr[joint], model.qpos0
        if kind in SINGLE_TYPES:
            return float(at[place] - initial[place])
        turn = place + (3 if kind == "floating" else 0)
        # Real parts come first there.
        before, after = (np.roll(row[turn : turn + 4], -1) for row in (initial, at))
        back = before / np.linalg.norm(before) * (-1.0, -1.0, -1.0, 1.0)
        turned = quaternion_product(back, after / np.linalg.norm(after))
        if kind == "spherical":
            return turned
        start = placement(initial[place:turn], initial[turn : turn + 4])
        return np.concatenate([start[:3, :3].T @ (at[place:turn] - initial[place:turn]), turned])

    def actuated(self) -> tuple[str, ...]:
        """Return the joints of the tree that have an actuator, in the order of these."""
        named = (self._of_index[joint] for joint in self._driven.values())
        return tuple(dict.fromkeys(joint.name for joint in named if joint.type != "fixed"))

    def equalities(self) -> tuple[list[LoopDescription], list[CouplingDescription]]:
        """Return the loops and couplings; `connect` and `weld` are loops, `joint` a coupling."""
        model, loops, couplings = self._model, [], []
        names = {model.equality(index).name for index in range(model.neq)}
        taken = {joint.name for joint in self.joints}
        for index in range(model.neq):
            item = model.equality(index)
            kind = _EQUALITIES.get(item.type[0], "flex")
            at = f"{self._where}: <equality> <{kind}> {(item.name or index + 1)!r}"
            if not item.active0[0]:
                self.warnings.append(f"{at}: left out, as it is not active")
                continue
            if kind == "flex":
                raise ModelError(f"{at}: {_UNSUPPORTED}")
            if kind == "joint" and item.obj2id[0] < 0:
                continue  # It holds a joint.
            if kind == "weld" and item.data[10] == 0.0:
                raise ModelError(f"{at}: a weld with torquescale 0 is a ball; write <connect>")
            others = taken if item.name else taken | names
            name = unique(item.name or f"equality_{index + 1}", others)
            taken.add(name)
            if kind == "tendon":
                couplings.append(self._of_tendons(index, name, at))
            elif kind == "joint":
                couplings.append(self._coupling(index, name, at))
            else:
                loops.append(self._loop(kind, index, name))
        # In the order of the joints, as a URDF lists them.
        order = {joint.name: index for index, joint in enumerate(self.joints)}
        couplings.sort(key=lambda coupling: order[coupling.successor])
        return loops, couplings

    def _loop(self, kind: str, index: int, name: str) -> LoopDescription:
        """Return the loop that a `connect` or a `weld` is.

        Its coordinates are zero in the initial configuration, save for a `weld` that states another
        relative pose.
        """
        model = self._model
        ends, data = (model.eq_obj1id[index], model.eq_obj2id[index]), model.eq_data[index]
        if model.eq_objtype[index] == self._mujoco.mjtObj.mjOBJ_SITE:
            origins = [self._site(site) for site in ends]
            ends = tuple(model.site_bodyid[site] for site in ends)
        elif kind == "connect":
            origins = [at_point(data[:3]), at_point(data[3:6])]
        else:
            # MuJoCo holds the anchor, a point of the second body, at this point of the first.
            origins = [placement(data[3:6], data[6:10]), at_point(data[:3])]
        if kind == "connect":
            # The frames of a ball joint may have any orientation: that of the second is chosen so
            # that the coordinate is zero in the initial configuration.
            across = inverse(self._placements[ends[1]]) @ self._placements[ends[0]]
            origins[1][:3, :3] = across[:3, :3] @ origins[0][:3, :3]
        first, second = (self._found.links[body][-1] for body in ends)
        joint = "spherical" if kind == "connect" else "fixed"
        return LoopDescription(name, joint, first, second, origins[0], origins[1])

    def _coupling(self, index: int, name: str, at: str) -> CouplingDescription:
        """Return the coupling that an equality of two joints is.

        The polynomial counts both coordinates from the initial configuration, where those of a
        description are zero.
        """
        model = self._model
        driven, driving = (
            self._of_index[ids[index]].name for ids in (model.eq_obj1id, model.eq_obj2id)
        )
        offset, ratio, *higher = model.eq_data[index][:5].tolist()
        held = {self._of_index[k].name for k in self._found.locked} & {driven, driving}
        while higher and higher[-1] == 0.0:
            higher.pop()
        if held or not (ratio or higher):
            raise ModelError(
                f"{at}: it is not supported except as a coupling of two joints that move: write "
                'polycoef="offset ratio 0 0 0", the ratio not zero, or higher coefficients; leave '
                "joint2 out where joint1 stays where it is"
            )
        return CouplingDescription(
            name, driving, driven, ratio, offset, of_joints=True, higher=tuple(higher)
        )

    def _of_tendons(self, index: int, name: str, at: str) -> CouplingDescription:
        """Return the coupling that fixed tendons of two joints are, one tendon or both.

        It keeps the sum of coordinates times coefficients, counted from the initial configuration;
        a polynomial that bends has one joint on either tendon.
        """
        model = self._model
        first, second = (
            self._stretch(tendon, at) for tendon in (model.eq_obj1id[index], model.eq_obj2id[index])
        )
        constant, ratio = model.eq_data[index][:2].tolist()
        higher = np.trim_zeros(model.eq_data[index][2:5], "b").tolist() if second else []
        factors = dict(first)
        for joint, factor in second.items():
            factors[joint] = factors.get(joint, 0.0) - ratio * factor
        coupled = sorted(joint for joint, factor in factors.items() if factor)
        if higher:
            coupled = [joint for ends in (second, first) for joint in ends if ends[joint]]
        if len(coupled) != 2 or len({*coupled}) != 2 or self._found.locked.keys() & set(coupled):
            raise ModelError(f"{at}: {_UNSUPPORTED}")
        one, other = coupled
        driving, driven = (self._of_index[joint].name for joint in coupled)
        numbers = -factors[one] / factors[other], constant / factors[other]
        powers = [
            term * second[one] ** power / first[other] for power, term in enumerate(higher, start=2)
        ]
        return CouplingDescription(
            name, driving, driven, *numbers, of_joints=True, higher=tuple(powers)
        )

    def _stretch(self, tendon: int, at: str) -> dict[int, float]:
        """Return the joints along which a fixed tendon stretches, and how far; none of none."""
        model, found = self._model, dict[int, float]()
        first = model.tendon_adr[tendon]
        for k in range(first, first + model.tendon_num[tendon] * (tendon >= 0)):
            if model.wrap_type[k] != self._mujoco.mjtWrap.mjWRAP_JOINT:
                raise ModelError(f"{at}: {_UNSUPPORTED}")
            joint = int(model.wrap_objid[k])
            found[joint] = found.get(joint, 0.0) + float(model.wrap_prm[k])
        return found


def _moved(kind: str, axis: Array, by: float) -> Array:
    """Return the `(4, 4)` motion of a hinge or slide by an angle [rad] or a way [m]."""
    if kind == "prismatic":
        return at_point(by * axis)
    half = 0.5 * by
    return placement(np.zeros(3), np.array([math.cos(half), *(math.sin(half) * axis)]))


def _stated(word: str, *values: float) -> list[str]:
    """Return a word and its values, as a file states them, unless all are zero."""
    if not np.any(values):
        return []
    last = int(np.flatnonzero(values)[-1]) + 1
    return [" ".join([word, *(f"{float(value):g}" for value in values[:last])])]


def _line(owner: str, parts: list[str]) -> list[str]:
    """Return what something states, if it does."""
    return [f"{owner}: {', '.join(parts)}"] if parts else []
