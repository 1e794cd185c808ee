"""Chains and trees of driven four-bar linkages, each of which stands on a rocker of another one."""

from __future__ import annotations

import math

import cardan_dyn as cd

CRANK, COUPLER, ROCKER, BASE = 0.1, 0.35, 0.3, 0.4
"""Lengths of the links [m]: the crank turns through (Grashof)."""
START = 0.7
"""Angle of the cranks at zero [rad]."""


def _angles() -> tuple[float, float]:
    """Return the angles of coupler and rocker at zero, by the law of cosines."""
    x, y = CRANK * math.cos(START) - BASE, CRANK * math.sin(START)
    diagonal, direction = math.hypot(x, y), math.atan2(y, x)
    cosine = (ROCKER**2 + diagonal**2 - COUPLER**2) / (2.0 * ROCKER * diagonal)
    rocker = direction - math.acos(cosine)
    end = (BASE + ROCKER * math.cos(rocker), ROCKER * math.sin(rocker))
    coupler = math.atan2(end[1] - CRANK * math.sin(START), end[0] - CRANK * math.cos(START))
    return coupler, rocker


def _link(name: str, length: float) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{length / 2!r} 0 0.01"/><mass value="1.5"/>'
        '<inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0.001" ixz="0" iyz="0"/></inertial></link>'
    )


def _joint(name: str, kind: str, parent: str, child: str, xyz: str, rpy: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/></joint>'
    )


def linkage(index: int, base: str, xyz: str = "0.3 0 0.02", roll: float = 0.3) -> str:
    """Return a four-bar linkage on a link, in a plane that is turned about the link's x axis.

    Its joints are `crank_i` (the drive), `middle_i`, `rocker_i` and the loop `end_i`; the last
    link is `rocker_link_i`.
    """
    coupler, rocker = _angles()
    crank_link, coupler_link, rocker_link = (
        f"{name}_link_{index}" for name in ("crank", "coupler", "rocker")
    )
    plate = f"plate_{index}"
    return "".join(
        [
            f'<link name="{plate}"/>',
            _link(crank_link, CRANK),
            _link(coupler_link, COUPLER),
            _link(rocker_link, ROCKER),
            _joint(f"on_{index}", "fixed", base, plate, xyz, f"{roll!r} 0 0"),
            _joint(f"crank_{index}", "continuous", plate, crank_link, "0 0 0", f"0 0 {START!r}"),
            _joint(
                f"middle_{index}",
                "continuous",
                crank_link,
                coupler_link,
                f"{CRANK!r} 0 0",
                f"0 0 {coupler - START!r}",
            ),
            _joint(
                f"rocker_{index}",
                "continuous",
                plate,
                rocker_link,
                f"{BASE!r} 0 0",
                f"0 0 {rocker!r}",
            ),
            f'<loop name="end_{index}" type="continuous"><predecessor link="{coupler_link}">'
            f'<origin xyz="{COUPLER!r} 0 0"/></predecessor><successor link="{rocker_link}">'
            f'<origin xyz="{ROCKER!r} 0 0"/></successor><axis xyz="0 0 1"/></loop>',
        ]
    )


def stacked(count: int) -> cd.Mechanism:
    """Return linkages each of which stands on the rocker of the one before it."""
    parts = [linkage(i, "base" if i == 0 else f"rocker_link_{i - 1}") for i in range(count)]
    return cd.load(f'<robot name="stack"><link name="base"/>{"".join(parts)}</robot>')


def tree(count: int) -> cd.Mechanism:
    """Return linkages two of which stand on the rocker of each one before."""
    parts = [
        linkage(i, "base" if i == 0 else f"rocker_link_{(i - 1) // 2}", roll=0.3 + 0.2 * (i % 2))
        for i in range(count)
    ]
    return cd.load(f'<robot name="tree"><link name="base"/>{"".join(parts)}</robot>')


def on_arms(count: int) -> cd.Mechanism:
    """Return linkages on arms: a driven arm, which no loop holds, stands on every rocker."""
    parts = []
    for i in range(count):
        below = "base" if i == 0 else f"rocker_link_{i - 1}"
        parts.append(_link(f"arm_link_{i}", 0.2))
        parts.append(_joint(f"arm_{i}", "revolute", below, f"arm_link_{i}", "0.1 0.2 0", "1 0 0"))
        parts.append(linkage(i, f"arm_link_{i}"))
    return cd.load(f'<robot name="arms"><link name="base"/>{"".join(parts)}</robot>')


def cranks(mechanism: cd.Mechanism) -> list[str]:
    """Return the names of all joints of a chain or tree that have to be driven."""
    return [name for name in mechanism if name.startswith(("crank_", "arm_"))]
