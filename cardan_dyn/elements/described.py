"""Described: the damping and friction that a description states, as elements."""

from __future__ import annotations

from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from .element import Element
from .joint_elements import JointFriction, JointSpring


def described_elements(mechanism: Mechanism, transition: float = 1e-3) -> tuple[Element, ...]:
    """Return the damping and friction of a description's joints, for `Scene(elements=...)`.

    `<dynamics damping="..." friction="...">` of URDF becomes a `JointSpring` without stiffness and
    a `JointFriction` along each coordinate of the joint.

    Args:
        mechanism: see `Mechanism.joint_dynamics`.
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
    return tuple(elements)
