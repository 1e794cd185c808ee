"""Mechanisms with joints of several coordinates, and the same written with single ones.

`NAMES` says how the coordinates of the first notation are called in the second.
"""

from __future__ import annotations

import numpy as np
import pinocchio

_INERTIA = 'ixx="0.04" iyy="0.05" izz="0.03" ixy="0.004" ixz="-0.002" iyz="0.003"'


def body(name: str, mass: float = 0.0, centre: str = "0.1 -0.05 0.08") -> str:
    """Return a link, massless unless it is given a mass."""
    if not mass:
        return f'<link name="{name}"/>'
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>'
        f"<inertia {_INERTIA}/></inertial></link>"
    )


def joint(
    name: str,
    kind: str,
    ends: str,
    origin: str = "",
    axes: tuple[str, ...] = (),
) -> str:
    """Return a joint of the tree; `ends` are parent and child, `origin` are attributes."""
    parent, child = ends.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f"<origin {origin}/>{_axes(axes)}</joint>"
    )


def loop(
    name: str,
    kind: str,
    ends: str,
    origins: tuple[str, str] = ("", ""),
    axes: tuple[str, ...] = (),
) -> str:
    """Return a loop; `ends` are predecessor and successor, `origins` are attributes."""
    predecessor, successor = ends.split()
    return (
        f'<loop name="{name}" type="{kind}"><predecessor link="{predecessor}">'
        f'<origin {origins[0]}/></predecessor><successor link="{successor}">'
        f"<origin {origins[1]}/></successor>{_axes(axes)}</loop>"
    )


def _axes(axes: tuple[str, ...]) -> str:
    tags = ("axis", "axis2")[: len(axes)]
    return "".join(f'<{tag} xyz="{xyz}"/>' for tag, xyz in zip(tags, axes, strict=True))


def robot(*elements: str) -> str:
    """Return a description on a link `ground`."""
    return '<robot name="compound"><link name="ground"/>' + "".join(elements) + "</robot>"


X, Y, Z = "1 0 0", "0 1 0", "0 0 1"
OBLIQUE = 'xyz="0.3 0.1 0.2" rpy="0.3 -0.2 0.4"'
"""Origin of the joint that hangs on the first body."""

# A crank, a rod that hangs on it by a universal joint, and a slider that a ball joins to the rod.
_CRANK = body("crank", 1.5) + joint("r", "continuous", "ground crank", "", ("0.6 0 0.8",))
_SLIDER = body("slider", 2.0) + joint(
    "p", "prismatic", "ground slider", 'xyz="0.7 0.5 0.1" rpy="0.1 0.5 -0.3"', ("0.8 0.6 0",)
)


def _rod_to_slider() -> tuple[str, str]:
    """Return origins at which the ball joins rod and slider, closed at zero."""
    ball = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.4, 0.1, -0.2), np.array([0.5, 0.4, 0.6]))
    rod = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.3, -0.2, 0.4), np.array([0.3, 0.1, 0.2]))
    slider = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.1, 0.5, -0.3), np.array([0.7, 0.5, 0.1]))
    return _attributes(rod.inverse() * ball), _attributes(slider.inverse() * ball)


def _attributes(placement: pinocchio.SE3) -> str:
    xyz = " ".join(map(repr, placement.translation.tolist()))
    rpy = " ".join(map(repr, pinocchio.rpy.matrixToRpy(placement.rotation).tolist()))
    return f'xyz="{xyz}" rpy="{rpy}"'


def crank_and_slider(single: bool = False) -> str:
    """A spatial crank and slider of mobility 1: hinge, universal joint, ball as a loop, slide."""
    ends = _rod_to_slider()
    rod = body("rod", 1.0)
    if not single:
        return robot(
            _CRANK,
            rod,
            joint("u", "universal", "crank rod", OBLIQUE, (Y, "0.6 0 -0.8")),
            _SLIDER,
            loop("s", "spherical", "rod slider", ends),
        )
    return robot(
        _CRANK,
        rod,
        body("cross"),
        joint("u1", "continuous", "crank cross", OBLIQUE, (Y,)),
        joint("u2", "continuous", "cross rod", "", ("0.6 0 -0.8",)),
        _SLIDER,
        body("x"),
        joint("s1", "continuous", "rod x", ends[0], (X,)),
        body("y"),
        joint("s2", "continuous", "x y", "", (Y,)),
        loop("s3", "continuous", "y slider", ("", ends[1]), (Z,)),
    )


# A plate on a table, which an arm on a cylindrical guide moves by a universal joint.
_ARM = 'xyz="-0.2 0.1 0.3" rpy="0.2 0.6 0.1"'
_PLATE = 'xyz="0.2 0.3 -0.1" rpy="0.4 -0.3 0.5"'


def plate_on_table(single: bool = False) -> str:
    """A plate of mobility 1: cylindrical guide, universal joint, and a table as a loop."""
    arm = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.2, 0.6, 0.1), np.array([-0.2, 0.1, 0.3]))
    plate = pinocchio.SE3(pinocchio.rpy.rpyToMatrix(0.4, -0.3, 0.5), np.array([0.2, 0.3, -0.1]))
    ends = ("", _attributes((arm * plate).inverse()))
    links = body("arm", 1.2) + body("plate", 0.8)
    if not single:
        return robot(
            links,
            joint("c", "cylindrical", "ground arm", _ARM, ("0 0.6 0.8",)),
            joint("u", "universal", "arm plate", _PLATE, (X, Z)),
            loop("t", "planar", "ground plate", ends, (Z,)),
        )
    return robot(
        links,
        body("guide"),
        joint("c1", "prismatic", "ground guide", _ARM, ("0 0.6 0.8",)),
        joint("c2", "continuous", "guide arm", "", ("0 0.6 0.8",)),
        body("cross"),
        joint("u1", "continuous", "arm cross", _PLATE, (X,)),
        joint("u2", "continuous", "cross plate", "", (Z,)),
        body("t_1"),
        joint("t1", "prismatic", "ground t_1", "", (Y,)),
        body("t_2"),
        joint("t2", "prismatic", "t_1 t_2", "", ("-1 0 0",)),
        loop("t3", "continuous", "t_2 plate", ends, (Z,)),
    )


NAMES = {
    "r": "r",
    "p": "p",
    "u.turn_1": "u1",
    "u.turn_2": "u2",
    "s.x": "s1",
    "s.y": "s2",
    "s.z": "s3",
    "c.slide": "c1",
    "c.turn": "c2",
    "t.slide_1": "t1",
    "t.slide_2": "t2",
    "t.turn": "t3",
}
LAST = {"r": "r", "p": "p", "u": "u2", "s": "s3", "c": "c2", "t": "t3"}
"""Joints to the single joint whose frame theirs is."""
