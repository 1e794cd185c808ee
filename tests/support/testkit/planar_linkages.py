"""Small planar linkages whose geometry is known in closed form, and what solves them."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd
from cardan_dyn.core.kinematics.closing.all_groups import Kinematics
from cardan_dyn.core.kinematics.loop_system import LoopSystem

CRANK, ROCKER, BASE = 0.3, 0.8, 1.0
COUPLER = float(np.hypot(BASE, ROCKER - CRANK))
ARM = float(np.hypot(0.5, 0.6))
"""Length [m] of the arms that the cranks of the five-bar carry."""


def link(name: str) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx=".01" '
        'iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name: str, parent: str, child: str, origin: tuple[float, float] = (0.0, 0.0)) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin[0]!r} {origin[1]!r} 0"/><axis xyz="0 0 1"/></joint>'
    )


def loop(
    first: str, second: str, on_first: tuple[float, float], on_second: tuple[float, float]
) -> str:
    return (
        f'<loop name="C" type="continuous"><predecessor link="{first}">'
        f'<origin xyz="{on_first[0]!r} {on_first[1]!r} 0"/></predecessor>'
        f'<successor link="{second}"><origin xyz="{on_second[0]!r} {on_second[1]!r} 0"/>'
        '</successor><axis xyz="0 0 1"/></loop>'
    )


def described(*elements: str) -> cd.Mechanism:
    return cd.load(f'<robot name="linkage"><link name="ground"/>{"".join(elements)}</robot>')


def four_bar(
    crank: float = CRANK, rocker: float = ROCKER, base: float = BASE, *more: str
) -> cd.Mechanism:
    """Crank A at the origin, rocker D at (base, 0), both upright at zero; B joins the coupler."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, crank)),
        joint("D", "ground", "c", (base, 0.0)),
        loop("b", "c", (base, rocker - crank), (0.0, rocker)),
        *more,
    )


def five_bar() -> cd.Mechanism:
    """Cranks A at the origin and D at (1, 0), both upright; B and E join at (0.5, 1)."""
    return described(
        *(link(name) for name in "abce"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.4)),
        joint("D", "ground", "c", (1.0, 0.0)),
        joint("E", "c", "e", (0.0, 0.4)),
        loop("b", "e", (0.5, 0.6), (-0.5, 0.6)),
    )


def three_cranks() -> cd.Mechanism:
    """A coupler on three parallel cranks of one length: only these lengths let it move."""
    third = loop("b", "e", (2.0, 0.0), (0.0, 0.5)).replace('name="C"', 'name="F"')
    return described(
        *(link(name) for name in "abce"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.5)),
        joint("D", "ground", "c", (1.0, 0.0)),
        joint("E", "ground", "e", (2.0, 0.0)),
        loop("b", "c", (1.0, 0.0), (0.0, 0.5)),
        third,
    )


def geared(ratio: float) -> cd.Mechanism:
    """A drive A and a wheel B that a coupling turns."""
    coupling = (
        '<coupling name="mesh"><predecessor link="a"/><successor link="b"/>'
        f'<ratio value="{ratio!r}"/></coupling>'
    )
    wheels = joint("A", "ground", "a"), joint("B", "ground", "b")
    return described(link("a"), link("b"), *wheels, coupling)


def values(mechanism: cd.Mechanism, states: np.ndarray, name: str) -> np.ndarray:
    """Positions of a joint in rows of coordinates."""
    return states[..., mechanism.coordinates.columns[name].start]


def pin_distance(mechanism: cd.Mechanism, states: np.ndarray) -> np.ndarray:
    """Distance between the pins on crank and rocker of a default four-bar, the coupler's length."""
    a, d = (values(mechanism, states, name) for name in "AD")
    on_crank = CRANK * np.stack([-np.sin(a), np.cos(a)])
    on_rocker = ROCKER * np.stack([-np.sin(d), np.cos(d)]) + np.array([[BASE], [0.0]])
    return np.linalg.norm(on_rocker - on_crank, axis=0)


def rocker_range() -> tuple[float, float]:
    """Positions of D at which crank and coupler of a default four-bar are in line."""
    reaches = np.array([COUPLER + CRANK, COUPLER - CRANK])
    sines = (BASE**2 + ROCKER**2 - reaches**2) / (2.0 * BASE * ROCKER)
    low, high = np.arcsin(sines).tolist()
    return low, high


def solver(
    mechanism: cd.Mechanism, *drives: str, held: tuple[str, ...] = ()
) -> tuple[Kinematics, np.ndarray]:
    """What closes a linkage for some drives and joints held at zero, and its zero position."""
    velocities = mechanism.coordinates.velocity_columns
    prescribed = [velocities[name].start for name in (*drives, *held)]
    passives = np.setdiff1d(np.arange(mechanism.model.nv), prescribed)
    system = LoopSystem(mechanism, dict.fromkeys(held, 0.0))
    kinematics = system.kinematics(drives, system.groups(drives, passives))
    start = mechanism.coordinates.neutral()
    return kinematics.with_open_reductions(start), start


def tips(positions: np.ndarray) -> np.ndarray:
    """Where both arms of the five-bar meet `(N, 2)`: above the line between their pins."""
    a, d = positions.T
    first = 0.4 * np.stack([-np.sin(a), np.cos(a)], axis=1)
    second = 0.4 * np.stack([-np.sin(d), np.cos(d)], axis=1) + np.array([1.0, 0.0])
    between = second - first
    distance = np.linalg.norm(between, axis=1, keepdims=True)
    normal = np.stack([-between[:, 1], between[:, 0]], axis=1) / distance
    return 0.5 * (first + second) + normal * np.sqrt(ARM**2 - 0.25 * distance**2)


def meeting_points(mechanism: cd.Mechanism, x: np.ndarray) -> np.ndarray:
    """The same from the angles of the first crank and its arm."""
    a, b = (values(mechanism, x, name) for name in "AB")
    along = -0.4 * np.sin(a) + 0.5 * np.cos(a + b) - 0.6 * np.sin(a + b)
    return np.stack([along, 0.4 * np.cos(a) + 0.5 * np.sin(a + b) + 0.6 * np.cos(a + b)], axis=1)
