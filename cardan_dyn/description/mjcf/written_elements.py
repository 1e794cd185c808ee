"""Elements of MJCF as text: joints, inertias and poses, for the writer."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...arrays import Array
from ...errors import ModelError
from ..description import JointDescription, LinkDescription, LoopDescription
from .elements import rotation_of_quaternion

_ROTATION_TOLERANCE = 1e-9
"""Greatest difference between a matrix and the rotation that is written for it, see `write`."""
_MOST_FREEDOMS = 6
"""Freedoms that MuJoCo allows between a body and the one that carries it."""


def elementary_joints(kind: str, axis: Array, axis_2: Array) -> list[tuple[str, Array]]:
    """Return MJCF's words and axes for the coordinates of a joint type, outermost first."""
    x, y, z = np.eye(3)
    if kind == "planar":
        first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        first /= np.linalg.norm(first)
        return [("slide", first), ("slide", np.cross(axis, first)), ("hinge", axis)]
    return {
        "fixed": [],
        "revolute": [("hinge", axis)],
        "continuous": [("hinge", axis)],
        "prismatic": [("slide", axis)],
        "cylindrical": [("slide", axis), ("hinge", axis)],
        "universal": [("hinge", axis), ("hinge", axis_2)],
        "spherical": [("ball", axis)],
        "floating": [("slide", x), ("slide", y), ("slide", z), ("ball", x)],
    }[kind]


def check_kinds(kinds: list[str], body: str) -> None:
    """Refuse joints that MuJoCo does not combine in one body."""
    freedoms = sum(3 if kind == "ball" else 1 for kind in kinds)
    balls = [index for index, kind in enumerate(kinds) if kind == "ball"]
    turns_after = balls and any(kind != "slide" for kind in kinds[balls[0] + 1 :])
    if freedoms > _MOST_FREEDOMS or turns_after:
        raise ModelError(
            f"body {body!r}: {', '.join(kinds)} cannot be its joints together in MuJoCo; give the "
            "massless links between them a mass"
        )


def range_of(joint: JointDescription) -> str:
    """Return the attribute of a joint's limits; empty where MJCF has no notation for them."""
    lower, upper = joint.limits.lower, joint.limits.upper
    if not (np.isfinite([lower, upper]).all() and lower < upper):
        return ""
    return f' range="{words([lower, upper])}"'


def dynamics_of(joint: JointDescription | LoopDescription) -> str:
    """Return the attributes of what rubs and springs along a hinge or slide of a joint."""
    stated = {
        "damping": joint.damping,
        "frictionloss": joint.friction,
        "stiffness": joint.stiffness,
        "springref": joint.rest if joint.stiffness else 0.0,
    }
    return "".join(f' {name}="{words([value])}"' for name, value in stated.items() if value)


def inertial_of(link: LinkDescription) -> str:
    """Return the `<inertial>` of a link with mass."""
    tensor = 0.5 * (link.inertia + link.inertia.T)
    if np.count_nonzero(tensor - np.diag(np.diag(tensor))):
        moments = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        inertia = f'fullinertia="{words(moments)}"'
    else:
        inertia = f'diaginertia="{words(np.diag(tensor))}"'
    return f'<inertial pos="{words(link.centre)}" mass="{words([link.mass])}" {inertia}/>'


def pose_of(placement: Array) -> str:
    """Return the attributes of a `(4, 4)` placement."""
    result = f' pos="{words(placement[:3, 3])}"'
    if not np.array_equal(placement[:3, :3], np.eye(3)):
        result += f' quat="{words(quaternion_of(placement[:3, :3]))}"'
    return result


def check_rotation(placement: Array, name: str) -> None:
    """Refuse a `(4, 4)` matrix that is no placement.

    Raises:
        ModelError: it reflects or scales.
    """
    turn = placement[:3, :3]
    written = rotation_of_quaternion(quaternion_of(turn), name)
    if not np.allclose(written, turn, rtol=0.0, atol=_ROTATION_TOLERANCE):
        raise ModelError(f"{name!r}: {turn.tolist()} is no rotation")


def quaternion_of(turn: Array) -> Array:
    """Return the unit quaternion w x y z of a rotation `(3, 3)`, accurate for any angle.

    Source: S. W. Shepperd, Quaternion from rotation matrix, 1978: the greatest component is found
    first, so that none is divided by a small number.
    """
    xx, yy, zz = np.diag(turn)
    squares = np.array([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    w = np.array([0.0, turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    rows = np.zeros((4, 4))
    rows[0] = rows[:, 0] = w
    rows[1:, 1:] = turn + turn.T
    rows[np.diag_indices(4)] = squares
    row = rows[int(np.argmax(squares))]
    return np.asarray(row / np.linalg.norm(row))


def words(values: Iterable[float]) -> str:
    """Return numbers as text from which they are read back to the last bit."""
    # Adding zero removes the sign of negative zeros.
    return " ".join(repr(float(value) + 0.0) for value in values)
