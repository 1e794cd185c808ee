"""Descriptions of robots: rods that may spin idly, and gears by the dozen."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np

ARM, ROD, BASE, PLATE = 0.3, 0.7, 0.25, 0.1
"""Lengths of the delta robot: arms, rods, radii of the base and of the platform [m]."""
_HALF = 0.05
"""Half the distance of the two rods of an arm [m]."""


def _numbers(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)


def _link(name: str, mass: float, centre: np.ndarray, inertia: np.ndarray) -> str:
    entries = [inertia[i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    words = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), entries, strict=True)
    moments = " ".join(f'{word}="{float(value)!r}"' for word, value in words)
    return (
        f'<link name="{name}"><inertial><origin xyz="{_numbers(centre)}"/><mass value="{mass!r}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def delta(balls: bool) -> str:
    """Return a delta robot: three arms, two rods each, a platform that keeps its direction.

    Args:
        balls: rods have a ball at either end and may spin about their lines, which no drive
            decides; otherwise a universal joint at the arm, and they may not.

    The drives are `arm_1` to `arm_3`; arms are level at zero.
    """
    drop = sqrt(ROD**2 - (BASE + ARM - PLATE) ** 2)
    urdf = '<robot name="delta"><link name="base"/>'
    urdf += _link("platform", 1.0, np.zeros(3), np.diag([2e-3, 2e-3, 4e-3]))
    urdf += (
        '<joint name="moves" type="floating"><parent link="base"/><child link="platform"/>'
        f'<origin xyz="0 0 {-drop!r}"/></joint>'
    )
    for k in range(1, 4):
        angle = 2.0 * pi * (k - 1) / 3.0
        out, across = (
            np.array([cos(angle), sin(angle), 0.0]),
            np.array([-sin(angle), cos(angle), 0.0]),
        )
        inertia = 0.01 * (np.eye(3) - np.outer(out, out)) + 1e-3 * np.eye(3)
        urdf += _link(f"arm_{k}_link", 0.5, 0.5 * ARM * out, inertia)
        urdf += (
            f'<joint name="arm_{k}" type="continuous"><parent link="base"/>'
            f'<child link="arm_{k}_link"/><origin xyz="{_numbers(BASE * out)}"/>'
            f'<axis xyz="{_numbers(across)}"/></joint>'
        )
        along = (PLATE - BASE - ARM) * out - drop * np.array([0.0, 0.0, 1.0])
        line = along / ROD
        slender = 0.01 * (np.eye(3) - np.outer(line, line)) + 1e-4 * np.outer(line, line)
        for side, shift in (("a", -_HALF * across), ("b", _HALF * across)):
            rod, end = f"rod_{k}{side}", PLATE * out + shift
            urdf += _link(rod, 0.2, 0.5 * along, slender)
            at = f'<origin xyz="{_numbers(ARM * out + shift)}"/>'
            ends = f'<parent link="arm_{k}_link"/>', f'<child link="{rod}"/>'
            if balls:
                urdf += (
                    f'<joint name="upper_{k}{side}" type="spherical">{"".join(ends)}{at}</joint>'
                )
            else:
                normal = np.cross(across, line)
                urdf += f'<link name="yoke_{k}{side}"/>'
                urdf += (
                    f'<joint name="swing_{k}{side}" type="continuous">{ends[0]}'
                    f'<child link="yoke_{k}{side}"/>{at}<axis xyz="{_numbers(across)}"/></joint>'
                    f'<joint name="yaw_{k}{side}" type="continuous">'
                    f'<parent link="yoke_{k}{side}"/>{ends[1]}'
                    f'<axis xyz="{_numbers(normal)}"/></joint>'
                )
            urdf += (
                f'<loop name="lower_{k}{side}" type="spherical"><predecessor link="{rod}">'
                f'<origin xyz="{_numbers(along)}"/></predecessor><successor link="platform">'
                f'<origin xyz="{_numbers(end)}"/></successor></loop>'
            )
    return urdf + "</robot>"


def fingers(chains: int = 13, free: int = 4) -> tuple[str, list[str]]:
    """Return a robot of arms whose last joints mimic earlier ones, and the names of its drives.

    Args:
        chains: of seven joints each, on one turning base of six joints in a row.
        free: joints of a chain that mimic no other one; 13 chains of 4 have 97 joints, of which 45
            are geared (the last arms have fewer).
    """
    bulk = np.diag([0.002, 0.003, 0.001])

    def joint(name: str, parent: str, child: str, xyz: str, axis: str, mimic: str = "") -> str:
        return (
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz}"/><axis xyz="{axis}"/><limit lower="-3" upper="3" effort="9" '
            f'velocity="9"/>{mimic}</joint>'
        )

    axes = ("0 0 1", "0 1 0", "1 0 0")
    urdf, drives, geared, parent = '<robot name="fingers"><link name="base"/>', [], 0, "base"
    for k in range(6):
        urdf += _link(f"trunk_{k}", 2.0, np.array([0.01, 0.02, 0.05]), bulk)
        urdf += joint(f"trunk_joint_{k}", parent, f"trunk_{k}", "0 0 0.1", axes[k % 3])
        drives.append(f"trunk_joint_{k}")
        parent = f"trunk_{k}"
    root = parent
    for chain in range(chains):
        parent = root
        for k in range(7):
            name, link = f"joint_{chain}_{k}", f"link_{chain}_{k}"
            urdf += _link(link, 0.2, np.array([0.02, 0.001, 0.0]), bulk)
            follows, mimic = k >= free - (chain < 6), ""
            if follows:
                leader = f"joint_{chain}_{k % 3}"
                mimic = f'<mimic joint="{leader}" multiplier="{0.5 + 0.1 * k!r}"/>'
                geared += 1
            else:
                drives.append(name)
            xyz = f"0 {0.05 * chain!r} 0.05" if k == 0 else "0.05 0 0"
            urdf += joint(name, parent, link, xyz, axes[(k + chain) % 3], mimic)
            parent = link
    assert geared == 45, geared
    return urdf + "</robot>", drives
