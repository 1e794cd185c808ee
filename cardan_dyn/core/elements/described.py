"""Described: the damping, friction and springs that a description states, as elements."""

from __future__ import annotations

from ...kit.errors import ModelError
from ..mechanism.mechanism import Mechanism
from .element import Element
from .joint_elements import JointFriction, JointSpring


def described_elements(mechanism: Mechanism, transition: float = 1e-3) -> tuple[Element, ...]:
    """Return the damping, friction and springs of a description's joints, for a `Scene`.

    Damping becomes a `JointSpring` without stiffness, friction a `JointFriction`, a spring a
    `JointSpring` without damping, along each coordinate of the joint: `damping`, `friction`,
    `spring_stiffness` and `spring_reference` of `<dynamics>` in URDF+ and SDF, `damping`,
    `frictionloss`, `stiffness` and `springref` of a joint in MJCF. MuJoCo's own law of friction is
    another one; it holds where it is not overcome.

    Args:
        mechanism: see `Mechanism.joint_dynamics` and `Mechanism.joint_springs`.
        transition: of friction, see `JointFriction` [rad/s or m/s].

    Raises:
        ModelError: a value is negative.
        ArgumentError: the transition is not positive.
    """
    elements: list[Element] = []
    for name, (damping, friction) in mechanism.joint_dynamics.items():
        for what, value in (("damping", damping), ("friction", friction)):
            if value < 0.0:
                raise ModelError(f"{mechanism.name}: {what} of {name!r} is {value:g}, negative")
        if damping:
            elements.append(JointSpring(name, 0.0, damping, name=f"damping of {name}"))
        if friction:
            elements.append(JointFriction(name, friction, transition, name=f"friction of {name}"))
    for name, (stiffness, rest) in mechanism.joint_springs.items():
        if stiffness < 0.0:
            raise ModelError(f"{mechanism.name}: stiffness of {name!r} is {stiffness:g}, negative")
        elements.append(JointSpring(name, stiffness, 0.0, rest, name=f"spring of {name}"))
    return tuple(elements)
