"""Pinocchio's models: a `pin.Model` and its constraints to a description.

A body is the link of the first frame of type `BODY` on it; all other frames go with that link. What
Pinocchio writes as one joint and a description as several (a composite, a screw) is a chain with
massless links between.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import pinocchio

from ....core.description.description import (
    CouplingDescription,
    Description,
    Dynamics,
    JointDescription,
    Limits,
    LinkDescription,
    LoopDescription,
    elementary,
    kinds_of,
)
from ....core.description.elements import GREATEST, armature, check_size, one_of, unique, words
from ....core.description.left_out import dynamics_left_out, limits_left_out
from ....core.description.mimics import default_name
from ....core.description.urdf import check_inertia
from ....core.mechanics.exact import made
from ....core.mechanism.mechanism import Mechanism
from ....kit.arrays import Array, inverse
from ....kit.checks import described as told
from ....kit.checks import flag
from ....kit.errors import ArgumentError, ModelError, choices
from ....kit.frozen import FrozenDict, frozen
from .source import SourceModel

_TYPES = {
    "JointModelFreeFlyer": "floating",
    "JointModelPlanar": "planar",
    "JointModelSpherical": "spherical",
    "JointModelSphericalZYX": "spherical",
    "JointModelUniversal": "universal",
    **{f"JointModelRUB{axis}": "continuous" for axis in "XYZ"},
    "JointModelRevoluteUnboundedUnaligned": "continuous",
    **{f"JointModelR{axis}": "revolute" for axis in "XYZ"},
    "JointModelRevoluteUnaligned": "revolute",
    **{f"JointModelP{axis}": "prismatic" for axis in "XYZ"},
    "JointModelPrismaticUnaligned": "prismatic",
    **{f"JointModelH{axis}": "screw" for axis in "XYZ"},
    "JointModelHelicalUnaligned": "screw",
}
"""Pinocchio's names of joints, and ours; a `screw` becomes a hinge and a slide that follows it."""
_CLOSING = ("RigidConstraintModel", "PointAnchorConstraintModel", "FrameAnchorConstraintModel")
"""Constraints that close loops."""
_LOOPS = {3: "spherical", 6: "fixed"}
"""Rows of a constraint to the joint that it is."""


def from_pinocchio(
    model: pinocchio.Model | str,
    constraint_models: Iterable[Any] = (),
    *,
    actuated: Iterable[str] | None = None,
    strict: bool = True,
    closure_tolerance: float | None = None,
    forces: Mapping[str, str] | None = None,
) -> Mechanism:
    """Return the mechanism of a model that Pinocchio has loaded, and of its constraints.

    Bodies are the links of its frames of type `BODY`; a composite joint and a screw become several
    joints in a row, the last of which has its name. A scene takes `model.gravity` where it is
    given `gravity="description"`.

    Args:
        model: a `pin.Model`, or what has one as its `model` (`pin.RobotWrapper`), or the name of a
            robot of the package `robot_descriptions`, such as `panda_description`.
        constraint_models: what closes its loops: `pin.RigidConstraintModel` of contact type 3D (a
            ball) and 6D (a weld), `pin.PointAnchorConstraintModel`,
            `pin.FrameAnchorConstraintModel`, and these in a `pin.ConstraintModel`.
        actuated: names of the joints that motors drive.
        strict: refuse inertias that no body can have.
        closure_tolerance: as of `load`; the numbers count as exact if None.
        forces: as of `load`, of joints that follow others: `k_mimic` is the coupling of `k`.

    Raises:
        ArgumentError: there is no model, no robot of that name, or `robot_descriptions` is not
            installed; the tolerance is negative or no number, or `forces` names no coupling.
        ModelError: a joint or constraint of another kind, or a name that no joint has.
    """
    if isinstance(model, str):
        model = _published(model)
    found = getattr(model, "model", model)
    if not isinstance(found, pinocchio.Model):
        raise ArgumentError(f"from_pinocchio() takes a pin.Model, not {told(model)}")
    reader = _Reader(found, tuple(constraint_models), flag("strict", strict))
    return made(reader.description(actuated), closure_tolerance, forces)


def _published(name: str) -> Any:
    """Return the robot of that name in `robot_descriptions`, as Pinocchio loads it."""
    try:
        from robot_descriptions import DESCRIPTIONS
        from robot_descriptions.loaders.pinocchio import load_robot_description
    except ImportError as error:
        raise ArgumentError(
            f"from_pinocchio() takes a pin.Model, or {name!r} where robot_descriptions is "
            "installed: pip install robot_descriptions; files are read by load()"
        ) from error
    return load_robot_description(one_of(name, DESCRIPTIONS, "robot", "robot_descriptions"))


class _Reader:
    def __init__(self, model: pinocchio.Model, constraints: tuple[Any, ...], strict: bool) -> None:
        self._model, self._strict, self._where = model, strict, f"pin.Model {model.name!r}"
        self._constraints = [
            item.extract() if hasattr(item, "extract") else item for item in constraints
        ]
        check_size(model.njoints, self._where)
        bodies: dict[int, Any] = {}
        for frame in model.frames:
            if frame.type == pinocchio.FrameType.BODY:
                bodies.setdefault(frame.parentJoint, frame)
        self._taken = {frame.name for frame in bodies.values()} | set(model.names)
        self._links = {
            index: (bodies[index].name, np.array(bodies[index].placement.homogeneous))
            if index in bodies
            else (unique(f"{model.names[index]}_link", self._taken), np.eye(4))
            for index in range(model.njoints)
        }
        self._joints: list[JointDescription] = []
        self._between: list[LinkDescription] = []
        self._couplings: list[CouplingDescription] = []
        self._of_index: dict[int, list[str]] = {}
        self._warnings: list[str] = []

    def description(self, actuated: Iterable[str] | None) -> Description:
        """Return the description."""
        model = self._model
        links = [self._link(index) for index in range(model.njoints)]
        for index in range(1, model.njoints):
            self._add(index)
        loops = tuple(
            self._loop(number, constraint) for number, constraint in enumerate(self._constraints)
        )
        names = [joint.name for joint in self._joints]
        motors = (actuated,) if isinstance(actuated, str) else tuple(actuated or ())
        for name in motors:
            one_of(name, names, "joint", self._where)
        return Description(
            name=model.name or "mechanism",
            links=(*links, *self._between),
            joints=tuple(self._joints),
            order=tuple(names),
            loops=loops,
            couplings=tuple(self._couplings),
            independent_joints=motors,
            notation="Pinocchio's constraints" if loops else "no loops",
            warnings=(
                *self._warnings,
                *limits_left_out(self._joints, self._where),
                *dynamics_left_out(self._joints, self._where),
            ),
            source=SourceModel(
                pinocchio.Model(model), tuple(map(_ends, self._constraints)), guest=__package__
            ),
            frames=frozen(
                {
                    frame.name: self._on_link(frame.parentJoint, frame.placement)
                    for frame in model.frames
                    if frame.name not in self._taken
                }
            ),
            keyframes=frozen(
                {name: self._positions(name, q) for name, q in _configurations(model).items()}
            ),
            gravity=np.array(model.gravity.linear),
            states_gravity=True,
        )

    def _positions(self, name: str, given: Array) -> FrozenDict[str, float | Array]:
        """Return a reference configuration as positions of joints."""
        model, q, found = self._model, np.array(given), dict[str, float | Array]()
        if q.shape != (model.nq,) or not np.isfinite(q).all():
            raise ModelError(
                f"{self._where}: its reference configuration {name!r} is not {model.nq} finite "
                "numbers"
            )
        q = pinocchio.normalize(model, q)
        for index, names in self._of_index.items():
            if model.nqs[index]:  # Those that follow others have none.
                at = q[model.idx_qs[index] :][: model.nqs[index]]
                found |= zip(names, _at(model.joints[index].extract(), at), strict=True)
        return frozen(found)

    def _on_link(self, index: int, placement: pinocchio.SE3) -> tuple[str, Array]:
        """Return the link that is the body of a joint, and a `(4, 4)` placement in it."""
        name, link = self._links[index]
        return name, inverse(link) @ placement.homogeneous

    def _link(self, index: int) -> LinkDescription:
        name, place = self._links[index]
        inertia = self._model.inertias[index]
        at = f"{self._where}: link {name!r}"
        if inertia.mass == 0.0 and not inertia.inertia.any():
            return LinkDescription(name)
        tensor = np.array(inertia.inertia)
        warning = check_inertia(inertia.mass, tensor, at, self._strict, "no inertia, too")
        if warning:
            self._warnings.append(warning)
        turn = place[:3, :3]
        centre = turn.T @ (inertia.lever - place[:3, 3])
        return LinkDescription(name, inertia.mass, centre, turn.T @ tensor @ turn)

    def _add(self, index: int) -> None:
        """Add the joint of an index, part by part from the parent outwards."""
        model, name = self._model, self._model.names[index]
        parent, place = self._links[model.parents[index]]
        origin = inverse(place) @ model.jointPlacements[index].homogeneous
        joint = model.joints[index].extract()
        follows = joint.shortname() == "JointModelMimic"
        parts = [self._mimicking(index)] if follows else list(_parts(joint, self._where, name))
        is_screw, rate = joint.shortname().startswith("JointModelH"), model.idx_vs[index]
        for number, (kind, axes, before, pitch) in enumerate(parts, start=1):
            own, (child, place) = name, self._links[index]
            if is_screw and pitch:
                own = unique(f"{name}_slide", self._taken)
            elif not is_screw and number < len(parts):
                own = unique(f"{name}_{number}", self._taken)
            if number < len(parts):
                child, place = unique(f"{name}:{number}", self._taken), np.eye(4)
                self._between.append(LinkDescription(child))
            found = (own, kind, parent, child, origin @ before, axes[0], axes[-1], place)
            rotors = () if follows or pitch else self._armature(name, joint.shortname(), kind, rate)
            self._joints.append(JointDescription(*found, armature=rotors))
            self._of_index.setdefault(index, []).append(own)
            if not pitch:
                rate += sum(map(_rates, kinds_of(kind)))
            else:
                self._couple(self._joints[-2].name, own, pitch, 0.0)
            parent, origin = child, np.eye(4)
        if len(parts) == 1:
            self._joints[-1] = self._with_numbers(self._joints[-1], index)
        if follows:
            leader = model.mimicked_joints[list(model.mimicking_joints).index(index)]
            self._couple(model.names[leader], name, joint.scaling, joint.offset)

    def _armature(self, name: str, word: str, kind: str, rate: int) -> tuple[float, ...]:
        """Return the armature of a part of a joint, whose first rate is given.

        Pinocchio's rates along the slides of a body that turns are along axes which turn with it,
        and its accelerations leave out how they do.
        """
        model, found = self._model, []
        at = f"{self._where}: joint {name!r}: armature"
        every = model.armature + model.rotorInertia * model.rotorGearRatio**2
        for part in kinds_of(kind):
            values = every[rate : rate + _rates(part)]
            rate += len(values)
            turned = part == "prismatic" and kind in ("planar", "floating")
            if values.any() and (turned or word.endswith("ZYX") or len({*values}) > 1):
                raise ModelError(
                    f"{at} {words(values)}: of a {word}, only one number for all axes of a ball is "
                    "read; set it to 0 and give a link the inertia"
                )
            found.append(float(values[0]))
        return armature(found, kind, at)

    def _mimicking(self, index: int) -> _Part:
        """Return the part of a joint that follows another, of whose rate its twist is."""
        model, data = self._model, self._model.createData()
        pinocchio.computeJointJacobians(model, data, pinocchio.neutral(model))
        twist = np.array(data.joints[index].S).reshape(6)
        ratio = model.joints[index].extract().scaling
        if not ratio or (twist[:3].any() and twist[3:].any()):
            name = model.names[index]
            raise ModelError(
                f"{self._where}: joint {name!r}: only hinges and slides follow others here, by a "
                "ratio that is not zero"
            )
        kind = "prismatic" if twist[:3].any() else "revolute"
        return kind, ((twist[:3] + twist[3:]) / ratio,), np.eye(4), 0.0

    def _couple(self, first: str, second: str, ratio: float, offset: float) -> None:
        name = unique(default_name(second), self._taken)
        self._couplings.append(
            CouplingDescription(name, first, second, ratio, offset, of_joints=True)
        )

    def _with_numbers(self, joint: JointDescription, index: int) -> JointDescription:
        """Return a joint of a single part with its limits, damping and friction."""
        model, rate, place = self._model, self._model.idx_vs[index], self._model.idx_qs[index]
        if model.nvs[index] != 1:
            return joint
        found = {
            "velocity": model.upperVelocityLimit[rate],
            "effort": model.upperEffortLimit[rate],
            "least_effort": model.lowerEffortLimit[rate],
        }
        if model.nqs[index] == 1:
            found["lower"] = model.lowerPositionLimit[place]
            found["upper"] = model.upperPositionLimit[place]
        # Pinocchio's greatest double means none.
        limits = Limits(
            **{
                key: float(x) if abs(x) < GREATEST else math.copysign(math.inf, x)
                for key, x in found.items()
            }
        )
        dynamics = Dynamics(float(model.damping[rate]), float(model.friction[rate]))
        return replace(joint, limits=limits, dynamics=dynamics)

    def _loop(self, number: int, constraint: Any) -> LoopDescription:
        name = getattr(constraint, "name", "") or f"loop_{number + 1}"
        at, kind = f"{self._where}: constraint {name!r}", type(constraint).__name__
        rows = constraint.residualSize() if kind in _CLOSING else 0
        if rows not in _LOOPS:
            raise ModelError(
                f"{at}: a {kind} of {rows} rows closes no loop here; of contact type 3D or 6D, "
                f"these do: {choices(_CLOSING)}"
            )
        _refuse_desired(constraint, at)
        first, before, second, behind = _ends(constraint)
        (one, own), (other, place) = (self._links[joint] for joint in (first, second))
        ends = one, other, inverse(own) @ before, inverse(place) @ behind
        return LoopDescription(unique(name, self._taken), _LOOPS[rows], *ends)


def _ends(constraint: Any) -> tuple[int, Array, int, Array]:
    """Return the joints of the two ends of a constraint, and its `(4, 4)` placements there."""
    return (
        *(constraint.joint1_id, np.array(constraint.joint1_placement.homogeneous)),
        *(constraint.joint2_id, np.array(constraint.joint2_placement.homogeneous)),
    )


def _refuse_desired(constraint: Any, at: str) -> None:
    """Refuse a constraint whose ends are not meant to stay where they are placed."""
    for name in dir(constraint):
        if name.startswith("desired_"):
            value = getattr(constraint, name)
            if isinstance(value, pinocchio.SE3):
                value = value.homogeneous - np.eye(4)
            if np.any(np.array(value)):
                raise ModelError(f"{at}: {name} is not read: place its two ends where they meet")


def _rates(part: str) -> int:
    return 3 if part == "spherical" else 1


_Part: TypeAlias = tuple[str, Sequence[Array], Array, float]
"""Type, axes and `(4, 4)` placement in what is before of a part of a joint; and, of the slide of a
screw, by how much it follows the hinge before it [m/rad], else 0."""


def _parts(joint: Any, where: str, name: str) -> Iterator[_Part]:
    """Yield the parts of a joint from the parent outwards."""
    kind = joint.shortname()
    if kind == "JointModelComposite":
        for part, placement in zip(joint.joints, joint.jointPlacements, strict=True):
            before = placement.homogeneous
            for inner, axes, own, pitch in _parts(part.extract(), where, name):
                yield inner, axes, before @ own, pitch
                before = np.eye(4)
        return
    if kind == "JointModelTranslation":
        for axis in np.eye(3):
            yield "prismatic", (axis,), np.eye(4), 0.0
        return
    one_of(kind, _TYPES, "joint", f"{where}: joint {name!r}", "is not supported")
    twists, found = _twists(joint), _TYPES[kind]
    if found == "screw":
        along, axis = twists[:3, 0], twists[3:, 0]
        yield "revolute", (axis,), np.eye(4), 0.0
        if pitch := float(along @ axis):
            yield "prismatic", (axis,), np.eye(4), pitch
        return
    axes = list((twists[:3] + twists[3:]).T)
    if found in ("planar", "spherical", "floating"):
        axes = [np.eye(3)[2 if found == "planar" else 0]]
    yield found, axes, np.eye(4), 0.0


def _configurations(model: pinocchio.Model) -> dict[str, Array]:
    """Return a model's reference configurations, those of its SRDF, by name."""
    return {item.key(): item.data() for item in model.referenceConfigurations}


def _at(joint: Any, q: Array) -> Iterator[float | Array]:
    """Yield the positions of the parts of a joint in Pinocchio's coordinates."""
    kind = joint.shortname()
    if kind == "JointModelComposite":
        for part in joint.joints:
            inner = part.extract()
            yield from _at(inner, q[: inner.nq])
            q = q[inner.nq :]
    elif kind == "JointModelPlanar":
        normal = np.eye(3)[2]
        slides = [axis[:2] @ q[:2] for _, axis in elementary("planar", normal, normal)[:2]]
        yield np.array([*slides, np.arctan2(q[3], q[2])])
    elif _TYPES.get(kind) == "continuous":
        yield float(np.arctan2(q[1], q[0]))
    elif kind == "JointModelSphericalZYX":
        yield np.array(pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(q[::-1])).coeffs())
    elif kind == "JointModelTranslation":
        yield from q.tolist()
    elif joint.nq == 1:
        for *_, pitch in _parts(joint, "", ""):
            yield float(q[0]) * (pitch or 1.0)
    else:
        yield np.array(q)


def _twists(joint: Any) -> Array:
    """Return the `(6, nv)` unit twists of a joint at its zero, linear parts first."""
    alone = pinocchio.Model()
    alone.addJoint(0, joint, pinocchio.SE3.Identity(), "joint")
    data = alone.createData()
    pinocchio.computeJointJacobians(alone, data, pinocchio.neutral(alone))
    return np.array(data.joints[1].S).reshape(6, -1, order="F")
