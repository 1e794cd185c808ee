"""Reduced: the tree that is left where motors, rods and loops are cut away, joints driven directly.

Those who train controllers simulate trees. What the cut-away parts weigh along the joints at one
position becomes armature of the joints; what that leaves out is told in numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError, choices
from ...kit.frozen import Frozen, frozen
from ..description.description import (
    Description,
    JointDescription,
    Limits,
    kinds_of,
    summed_efforts,
)
from ..description.write import to_urdf
from ..mechanics.exact import load
from ..mechanism.mechanism import Mechanism
from .way import SolvedWay

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class LeftOut(NamedTuple):
    """What a reduced tree leaves out at joint positions.

    Attributes:
        inertia: `(..., n, n)` that of the parts that were cut away, less the armature in their
            place [kg·m², kg·m, kg], along the joints; entries beside the diagonal couple them.
        gravity: `(..., n)` efforts at the joints that carry the parts which were cut away [N·m or
            N].
    """

    inertia: Array
    gravity: Array


class ReducedTree(Frozen):
    """A mechanism without motors, rods and loops, from `Transmission.reduced`.

    Attributes:
        mechanism: the tree; `cd.write(reduced.mechanism, "robot.xml")` writes it as MJCF or URDF.
        armature: joint, or coordinate of a joint, to its armature [kg·m² or kg].
        cut: names of the links that were cut away.
    """

    mechanism: Mechanism
    armature: Mapping[str, float]
    cut: tuple[str, ...]
    _way: SolvedWay
    _weightless: Mapping[str, float]

    def __init__(self, way: SolvedWay, joints: Array) -> None:
        """Cut it.

        Args:
            way: from the joints to the actuated.
            joints: `(n,)` positions at which inertia becomes armature.

        Raises:
            ModelError: a joint is no joint of the tree, or not all of its coordinates are wanted.
        """
        problem, names = way.problem, way.given.names
        mechanism, drivable = problem.mechanism, problem.mechanism.drivable
        description = mechanism.description
        moving = {drivable[name].joint for name in names}
        known = {*names, *problem.held}
        kept = _kept(
            description,
            moving,
            {
                name
                for name, joint in mechanism.joints.items()
                if known.issuperset(joint.coordinates)
            },
        )
        links = [link for link in description.links if link.name in kept]
        # Links on the world count for nothing, and cannot be given a factor.
        weightless = {link.name: 0.0 for link in links if mechanism.link(link.name)[0]}
        inertia = way.inertia(joints, weightless)
        # Rounding may leave less than nothing.
        felt = np.maximum(np.diagonal(inertia), 0.0).tolist()
        armature = dict(zip(names, felt, strict=True))
        limits = dict(zip(names, _limits(way, joints), strict=True))
        own = [
            replace(
                joint,
                armature=_armature(joint, mechanism, armature),
                limits=limits.get(joint.name, joint.limits),
            )
            if joint.name in moving
            else joint
            for joint in description.joints
            if joint.child in kept
        ]
        every = {joint.name for joint in own}
        tree = replace(
            description,
            links=tuple(links),
            joints=tuple(own),
            order=tuple(name for name in description.order if name in every),
            loops=(),
            couplings=(),
            independent_joints=tuple(joint.name for joint in own if joint.name in moving),
        )
        self._freeze(
            mechanism=load(to_urdf(tree), strict=False),
            armature=frozen(armature),
            cut=tuple(link.name for link in description.links if link.name not in kept),
            _way=way,
            _weightless=frozen(weightless),
        )

    def __repr__(self) -> str:
        parts = (f"{name} {value:.3g}" for name, value in self.armature.items())
        return f"<ReducedTree of {self.mechanism.name!r}: armature {', '.join(parts)}>"

    def left_out(self, joints: ArrayLike, gravity: object = (0.0, 0.0, -9.81)) -> LeftOut:
        """Return what the tree leaves out, of what does not depend on speed.

        Args:
            joints: their positions `(..., n)` [rad or m].
            gravity: `(3,)` acceleration of free fall in world axes [m/s²], or `"description"`.

        Raises:
            CardanError: as `Transmission.actuated_of`.
        """
        at = self._way.given.rows("joints", joints)
        inertia = self._way.inertia(at, self._weightless)
        weight = self._way.sweep(at, gravity=gravity, inertia=self._weightless).drive_effort
        armature = np.diag(list(self.armature.values()))
        return LeftOut(inertia - armature, np.reshape(weight, at.shape))


def _kept(description: Description, moving: set[str], decided: set[str]) -> set[str]:
    """Return the links that joints carry which are decided or fixed, from the root on.

    Args:
        description: the whole mechanism.
        moving: names of joints that are to be kept.
        decided: names of those of which all coordinates are driven or held, loops among them.

    Raises:
        ModelError: a joint that moves is none of the tree, moves in other ways as well, or hangs on
            one that is cut away.
    """
    children = {joint.child for joint in description.joints}
    kept = {link.name for link in description.links} - children
    left = list(description.joints)
    while more := [
        joint
        for joint in left
        if joint.parent in kept and (joint.name in decided or joint.type == "fixed")
    ]:
        kept |= {joint.child for joint in more}
        left = [joint for joint in left if joint not in more]
    if lost := moving - {joint.name for joint in description.joints if joint.child in kept}:
        raise ModelError(
            f"{description.name}: {choices(lost)} cannot be kept without motors and loops: "
            "describe the chain from the root to the joints as joints of the tree, of which the "
            "transmission names all coordinates, and cut the loops elsewhere",
            name=min(lost),
        )
    return kept


def _limits(way: SolvedWay, joints: Array) -> list[Limits]:
    """Return the limits of joints, with what motors can do to each at some positions.

    Args:
        way: from the joints to the actuated.
        joints: `(n,)`.
    """
    _, jacobian = way.at(joints)
    motors, found = way.found.limits, []
    for limits, pushes, moves in zip(
        way.given.limits, jacobian.T, np.abs(np.linalg.inv(jacobian)), strict=True
    ):
        velocity = sum(by * of.velocity for by, of in zip(moves, motors, strict=True) if by)
        ranges = [limits.efforts, summed_efforts(pushes, [motor.efforts for motor in motors])]
        found.append(
            replace(
                limits,
                least_effort=max(least for least, _ in ranges),
                effort=min(greatest for _, greatest in ranges),
                velocity=min(limits.velocity, float(velocity)),
            )
        )
    return found


def _armature(
    joint: JointDescription, mechanism: Mechanism, armature: Mapping[str, float]
) -> tuple[float, ...]:
    """Return the armature of the parts of a joint, from that of its coordinates; held ones keep it.

    Raises:
        ModelError: it has a ball, whose axes have one armature together.
    """
    if "spherical" in kinds_of(joint.type):
        raise ModelError(
            f"{joint.name} is a {joint.type} joint, and armature stands for each of its "
            "coordinates alone: describe it as hinges and slides in a row, and name all of them",
            name=joint.name,
        )
    coordinates = mechanism.joints[joint.name].coordinates
    own = joint.armature or (0.0,) * len(coordinates)
    return tuple(armature.get(name, value) for name, value in zip(coordinates, own, strict=True))
