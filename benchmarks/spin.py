"""The free spin of a universal joint: description, and exact time of its revolutions.

Two shafts of 1 kg m² and a cross of the same small inertia about all its axes; nothing acts. The
centres of mass are in the joint's centre. With the speed ratio r(φ) = cos β / (cos²β + sin²β sin²φ)
and the pin's angle θ(φ), the kinetic energy is I(φ) φ̇² / 2, and time follows by quadrature.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from mpmath import mp, mpf

SHAFT, CROSS = 1.0, 1e-3
"""Inertia of each shaft about its axis, and of the cross [kg m²]."""
SPEED = 10.0
"""Speed of the input at the start, in main position A [rad/s]."""
_DIGITS = 40


class Spin(NamedTuple):
    """A free spin.

    Attributes:
        beta: joint angle [rad].
        revolutions: of the input.
        duration: which they take, rounded [s].
        end: position of the input at `duration` [rad].
    """

    beta: float
    revolutions: int
    duration: float
    end: float

    @property
    def start_speeds(self) -> tuple[float, float, float]:
        """Speeds of input, pin of the input's fork and output at the start [rad/s]."""
        return SPEED, SPEED * float(np.tan(self.beta)), SPEED / float(np.cos(self.beta))


def spin(beta: float, revolutions: int = 10, shaft: float = SHAFT, cross: float = CROSS) -> Spin:
    """Return a free spin with its exact duration, by quadrature with 40 digits.

    Args:
        beta: see `Spin`.
        revolutions: see `Spin`.
        shaft: inertia of the output shaft; that of the input is 1 kg m².
        cross: inertia of the cross.
    """
    with mp.workdps(_DIGITS):
        sine, cosine = mp.sin(mpf(beta)), mp.cos(mpf(beta))

        def inertia(phi: mpf) -> mpf:
            square = cosine**2 + (sine * mp.sin(phi)) ** 2
            ratio, pin = cosine / square, sine * cosine * mp.cos(phi) / square
            return mpf(SHAFT) + mpf(shaft) * ratio**2 + mpf(cross) * (1 + pin**2)

        start = inertia(mpf(0))

        def pace(half: mpf) -> mpf:
            # tan φ = cos β tan t spreads what is crowded near φ = 0 at great joint angles.
            phi = mp.atan2(cosine * mp.sin(half), mp.cos(half))
            way = cosine / (mp.cos(half) ** 2 + (cosine * mp.sin(half)) ** 2)
            return mp.sqrt(inertia(phi) / start) * way

        quarter = mp.quad(pace, mp.linspace(0, mp.pi / 2, 17))
        exact = 4 * quarter * revolutions / mpf(SPEED)
        duration = float(exact)
        end = float(2 * mp.pi * revolutions + mpf(SPEED) * (mpf(duration) - exact))
    return Spin(beta, revolutions, duration, end)


def description(beta: float, shaft: float = SHAFT, cross: float = CROSS) -> str:
    """Return the mechanism as a URDF; arguments as for `spin`."""
    links = "".join(
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="{value!r}" iyy="{value!r}" '
        f'izz="{value!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, value in (("shaft_in", SHAFT), ("cross", cross), ("shaft_out", shaft))
    )
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 0" rpy="0 0 {yaw!r}"/><axis xyz="{axis}"/></joint>'
        for name, parent, child, yaw, axis in (
            ("bearing_in", "base", "shaft_in", 0.0, "1 0 0"),
            ("pin_in", "shaft_in", "cross", 0.0, "0 1 0"),
            ("bearing_out", "base", "shaft_out", float(beta), "1 0 0"),
        )
    )
    return (
        f'<robot name="spinning_joint"><link name="base"/>{links}{joints}'
        '<loop name="pin_out" type="continuous"><predecessor link="cross"/>'
        '<successor link="shaft_out"/><axis xyz="0 0 1"/></loop></robot>'
    )
