"""Mechanisms to simulate, and their motion in minimal coordinates, found without the package."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import cardan_dyn as cd

GRAVITY = (0.0, -9.81, 0.0)
MASS, LENGTH, INERTIA = 2.0, 0.7, 0.05
"""Of the pendulum: its mass, the distance of its centre from the pin, its inertia about that."""
ABOUT_PIN = INERTIA + MASS * LENGTH**2
WEIGHT = 9.81 * MASS * LENGTH


def link(name: str, centre: tuple[float, float], mass: float = 1.0, inertia: float = 0.1) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre[0]!r} {centre[1]!r} 0"/>'
        f'<mass value="{mass!r}"/><inertia ixx="{inertia!r}" iyy="{inertia!r}" izz="{inertia!r}" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name: str, parent: str, child: str, at: tuple[float, float] = (0.0, 0.0)) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at[0]!r} {at[1]!r} 0"/><axis xyz="0 0 1"/></joint>'
    )


def pendulum() -> cd.Mechanism:
    """A body on a pin; its centre hangs below at zero, gravity along -y."""
    body = link("bob", (0.0, -LENGTH), MASS, INERTIA)
    return cd.load(
        f'<robot name="pendulum"><link name="base"/>{body}{joint("pin", "base", "bob")}</robot>'
    )


def parallelograms(count: int) -> cd.Mechanism:
    """Four-bars with equal opposite sides of 1 m, side by side; the cranks are upright at zero."""
    parts = [link(f"crank_{k}", (0.0, 0.5)) for k in range(count + 1)]
    parts += [joint(f"pin_{k}", "base", f"crank_{k}", (float(k), 0.0)) for k in range(count + 1)]
    for k in range(count):
        parts.append(link(f"coupler_{k}", (0.5, 0.0)))
        parts.append(joint(f"knee_{k}", f"crank_{k}", f"coupler_{k}", (0.0, 1.0)))
        parts.append(
            f'<loop name="end_{k}" type="continuous"><predecessor link="coupler_{k}">'
            f'<origin xyz="1 0 0"/></predecessor><successor link="crank_{k + 1}">'
            '<origin xyz="0 1 0"/></successor><axis xyz="0 0 1"/></loop>'
        )
    return cd.load(f'<robot name="bars"><link name="base"/>{"".join(parts)}</robot>')


def parallelogram_law(count: int) -> tuple[float, float]:
    """Inertia and weight that bars moving as parallelograms add to I φ̈ = W sin φ.

    The cranks turn about their pins, the couplers circle without turning.
    """
    inertia = (count + 1) * (0.1 + 0.5**2) + count * 1.0
    return inertia, 9.81 * ((count + 1) * 0.5 + count * 1.0)


def spatial_slider_crank() -> cd.Mechanism:
    """Crank about x, rod with a universal joint at the crank and a ball at the slider along x.

    The crank's pin is at (0, 0.2, 0) at zero, the slider at (0.9, 0.1, 0.2).
    """
    limit = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
    at = "0.9 0.1 0.2"
    rod = "0.9 -0.1 0.2"
    return cd.load(
        f"""<robot name="spatial"><link name="base"/>{link("crank", (0.0, 0.1))}
        {link("yoke", (0.0, 0.0), 0.1, 0.001)}{link("rod", (0.45, -0.05), 1.5, 0.05)}
        {link("slider", (0.0, 0.0), 2.0)}
        <joint name="a" type="continuous"><parent link="base"/><child link="crank"/>
          <axis xyz="1 0 0"/></joint>
        <joint name="u_1" type="continuous"><parent link="crank"/><child link="yoke"/>
          <origin xyz="0 0.2 0"/><axis xyz="0 1 0"/></joint>
        <joint name="u_2" type="continuous"><parent link="yoke"/><child link="rod"/>
          <axis xyz="0 0 1"/></joint>
        <joint name="s" type="prismatic"><parent link="base"/><child link="slider"/>
          <origin xyz="{at}"/><axis xyz="1 0 0"/>{limit}</joint>
        <loop name="ball" type="spherical"><predecessor link="rod"><origin xyz="{rod}"/>
          </predecessor><successor link="slider"/></loop></robot>"""
    )


def integrated(
    acceleration: Callable[[float, np.ndarray, np.ndarray], np.ndarray],
    position: np.ndarray,
    speed: np.ndarray,
    times: np.ndarray,
) -> np.ndarray:
    """Positions and speeds `(2 d, N)` of a differential equation, integrated to rounding."""
    from scipy.integrate import solve_ivp

    start = np.concatenate([np.atleast_1d(position), np.atleast_1d(speed)]).astype(float)
    half = start.size // 2

    def rate(time: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[half:], np.atleast_1d(acceleration(time, y[:half], y[half:]))])

    result = solve_ivp(
        rate, (0.0, times[-1]), start, "DOP853", times, rtol=3e-14, atol=1e-14, max_step=0.02
    )
    return np.asarray(result.y)


class SpinningJoint:
    """The universal joint of `urdf/` as one coordinate: I(φ) φ̈ + I'(φ) φ̇²/2 = Q.

    The kinetic energy is that of both shafts and of the cross, whose axes are the pins.
    """

    SHAFT = 0.02495917039
    NORMAL, PIN = 0.00143871864, 0.000861348282
    """Of the cross: inertias about its normal and about both pins."""

    def __init__(self, beta: float) -> None:
        self.beta = beta

    def ratio(self, phi: np.ndarray) -> np.ndarray:
        """Speed of the output relative to the input; the input's pin is in plane at zero."""
        c = np.cos(self.beta)
        return c / (1.0 - (np.sin(self.beta) * np.sin(phi + 0.5 * np.pi)) ** 2)

    def inertia(self, phi: np.ndarray) -> np.ndarray:
        zero, one = np.zeros_like(phi), np.ones_like(phi)
        e_1 = np.stack([one, zero, zero], axis=1)
        e_2 = np.stack([np.cos(self.beta) * one, np.sin(self.beta) * one, zero], axis=1)
        pin_1 = np.stack([zero, np.cos(phi), np.sin(phi)], axis=1)
        pin_2 = np.cross(e_2, pin_1)
        pin_2 /= np.linalg.norm(pin_2, axis=1, keepdims=True)
        ratio = self.ratio(phi)[:, None]
        # The cross turns with shaft 1 but about pin 1, and with shaft 2 but about pin 2: along
        # pin 2 its spin is that of shaft 1, along pin 1 and along no other that of shaft 2.
        normal = np.cross(pin_1, pin_2)
        on_2, on_1 = np.sum(e_1 * pin_2, axis=1), np.sum(ratio * e_2 * pin_1, axis=1)
        on_normal = np.sum(e_1 * normal, axis=1)
        cross = self.PIN * (on_1**2 + on_2**2) + self.NORMAL * on_normal**2
        return self.SHAFT * (1.0 + ratio[:, 0] ** 2) + cross

    def time_of(self, speed: float, turns: float) -> float:
        """Time of some turns from zero, free of forces: the integral of √(I/I₀) / speed.

        Equidistant sums over a turn are exact for so smooth a function that repeats.
        """
        count = 4096
        phi = 2.0 * np.pi * np.arange(count) / count
        start = self.inertia(np.zeros(1))[0]
        mean = float(np.mean(np.sqrt(self.inertia(phi) / start)))
        return 2.0 * np.pi * turns * mean / speed
