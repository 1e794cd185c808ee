"""Torques for which a drive shaft is chosen, and the static ratings they are held against.

SI units throughout, all arguments broadcast. Torques are sizes: their sense plays no part.

References:
    Spicer driveline installation manual, driveshaft torque; SAE Universal Joint and Driveshaft
    Design Manual AE-7; AISCO, universal joint sizing; PSS.DriveshaftCalculations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import filled
from ._checks import FloatArray, fraction, not_negative, positive, real, same_shape

__all__ = [
    "StaticRatings",
    "low_gear_torque",
    "power_torque",
    "selection_torque",
    "static_utilisation",
    "vehicle_torque",
    "wheel_slip_torque",
]


class StaticRatings(NamedTuple):
    """Torques that a joint bears by its strength [N m] and its greatest speed [rad/s].

    Each greater than 0; inf where a maker states none.

    Attributes:
        elastic: limit of the running torque itself, without shocks.
        functional: T_CS, yield of the joint under rare shocks.
        pulsating: T_DSch, fatigue limit under torque of one sense.
        reversing: T_DW, fatigue limit under torque of both senses.
        speed: greatest speed.
    """

    elastic: ArrayLike
    functional: ArrayLike
    pulsating: ArrayLike
    reversing: ArrayLike
    speed: ArrayLike


def power_torque(power: ArrayLike, speed: ArrayLike, service_factor: ArrayLike = 1.0) -> FloatArray:
    """Torque of a power, with a service factor, T = P K / omega.

    Args:
        power: P [W], not negative.
        speed: omega [rad/s], greater than 0.
        service_factor: K, greater than 0; customary ones are `limits.SERVICE_FACTORS`.

    Returns:
        T [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        T = 9550 P/n with P in kW and n in 1/min (JW Winco, DIN 808); T = 63025 HP/N in lb in
        (AISCO, I); shock torque T K (PSS, ShockLoad).

    >>> round(float(power_torque(650.0, 230 * np.pi / 30)))
    27
    """
    power, speed = not_negative("power", power), positive("speed", speed)
    factor = positive("service_factor", service_factor)
    same_shape(power=power, speed=speed, service_factor=factor)
    return power / speed * factor


def low_gear_torque(
    engine_torque: ArrayLike,
    gear_ratio: ArrayLike,
    efficiency: ArrayLike = 0.85,
    stall_ratio: ArrayLike = 1.0,
    transfer_ratio: ArrayLike = 1.0,
    transfer_efficiency: ArrayLike = 1.0,
) -> FloatArray:
    """Greatest torque that the engine brings to the drive shaft.

    LGT = T TLGR TE SR TCR C.

    Args:
        engine_torque: T, net torque of the engine or 0.95 of the gross [N m], not negative.
        gear_ratio: TLGR, ratio of the lowest forward gear, greater than 0.
        efficiency: TE of the gearbox, above 0 and at most 1; 0.85 manual, 0.8 automatic.
        stall_ratio: SR of a torque converter, greater than 0; 1 without.
        transfer_ratio: TCR of a transfer case, greater than 0; 1 without.
        transfer_efficiency: C of a transfer case, above 0 and at most 1; 0.95 with, 1 without.

    Returns:
        LGT [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Spicer driveline installation manual, p. 2.

    >>> round(float(low_gear_torque(1000.0, 12.0)), 6)
    10200.0
    """
    torque, ratio = not_negative("engine_torque", engine_torque), positive("gear_ratio", gear_ratio)
    loss, stall = fraction("efficiency", efficiency), positive("stall_ratio", stall_ratio)
    case = positive("transfer_ratio", transfer_ratio)
    case_loss = fraction("transfer_efficiency", transfer_efficiency)
    same_shape(
        engine_torque=torque,
        gear_ratio=ratio,
        efficiency=loss,
        stall_ratio=stall,
        transfer_ratio=case,
        transfer_efficiency=case_loss,
    )
    return torque * ratio * loss * stall * case * case_loss


def wheel_slip_torque(
    axle_load: ArrayLike,
    rolling_radius: ArrayLike,
    axle_ratio: ArrayLike,
    adhesion: ArrayLike = 0.71,
    axle_efficiency: ArrayLike = 0.95,
) -> FloatArray:
    """Torque of the drive shaft at which the wheels of its axle slip.

    WST = 0.71 W RR / (11.4 AR) in lb, in and lb ft; 11.4 are 12 in/ft times an efficiency of 0.95.

    Args:
        axle_load: weight W that the axle carries [N], not negative.
        rolling_radius: RR of the tyres [m], greater than 0.
        axle_ratio: AR, speed of the drive shaft over that of the wheels, greater than 0.
        adhesion: coefficient between tyre and road, greater than 0.
        axle_efficiency: of the axle, above 0 and at most 1.

    Returns:
        WST [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Spicer driveline installation manual, p. 2.
    """
    load, radius = not_negative("axle_load", axle_load), positive("rolling_radius", rolling_radius)
    ratio, grip = positive("axle_ratio", axle_ratio), positive("adhesion", adhesion)
    loss = fraction("axle_efficiency", axle_efficiency)
    same_shape(
        axle_load=load,
        rolling_radius=radius,
        axle_ratio=ratio,
        adhesion=grip,
        axle_efficiency=loss,
    )
    return grip * load * radius / (loss * ratio)


def vehicle_torque(low_gear: ArrayLike, wheel_slip: ArrayLike) -> FloatArray:
    """Design torque of a vehicle on the road, the lesser of both.

    Args:
        low_gear: torque of `low_gear_torque` [N m], not negative.
        wheel_slip: torque of `wheel_slip_torque` [N m], not negative.

    Returns:
        The torque [N m], in the broadcast shape; NaN where either is. Off the road, `low_gear`
        alone counts.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Spicer driveline installation manual, p. 2.
    """
    low, slip = not_negative("low_gear", low_gear), not_negative("wheel_slip", wheel_slip)
    same_shape(low_gear=low, wheel_slip=slip)
    return np.minimum(low, slip)


def selection_torque(
    torque: ArrayLike, life_factor: ArrayLike, angle_factor: ArrayLike, power_factor: ArrayLike
) -> FloatArray:
    """Equivalent torque by which a maker's table is entered, T_e = T K_1 K_2 K_3.

    The factors belong to one maker's table, and so does what T_e is compared with: neither the
    rated torque T_D of `shaft_design.joint_life`, nor the capacity factor L_C, nor Klein's
    T = C R. Klein's example (1000 N m, 1450/min, 7 degrees, 2000 h) comes to 1339 N m, the same
    case to T_D = 2185 N m.

    Args:
        torque: T [N m], of any sign.
        life_factor: K_1, greater than 0.
        angle_factor: K_2, greater than 0.
        power_factor: K_3 of the prime mover, greater than 0; `limits.POWER_FACTORS`.

    Returns:
        The size of T_e [N m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, EquivalentTorque; IMS.
    """
    torque = np.abs(real("torque", torque))
    life, angle = positive("life_factor", life_factor), positive("angle_factor", angle_factor)
    power = positive("power_factor", power_factor)
    same_shape(torque=torque, life_factor=life, angle_factor=angle, power_factor=power)
    return torque * life * angle * power


def static_utilisation(
    torque: ArrayLike, service_factor: ArrayLike, speed: ArrayLike, ratings: StaticRatings
) -> StaticRatings:
    """How far torque, shocks and speed use up the ratings of a joint.

    Args:
        torque: running torque T [N m], of any sign.
        service_factor: K, at which T K is the torque with its shocks, greater than 0.
        speed: speed of rotation [rad/s], of any sign.
        ratings: what the joint bears.

    Returns:
        T / elastic, T K / functional, T K / pulsating, T K / reversing and speed / greatest
        speed, each in the broadcast shape. At most 1 is permissible; which of `pulsating` and
        `reversing` counts depends on whether the torque changes its sense.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        PSS, ConditionAnalyzer; T_CS, T_DSch and T_DW as in Dana's data sheets; AISCO's T_cs
        (yield) and T_e (fully reversed) are the second and the fourth.
    """
    torque, speed = np.abs(real("torque", torque)), np.abs(real("speed", speed))
    factor = positive("service_factor", service_factor)
    rated = {
        name: positive(name, value, unlimited=True) for name, value in ratings._asdict().items()
    }
    loads = (torque, torque * factor, torque * factor, torque * factor, speed)
    shape = same_shape(torque=torque, service_factor=factor, speed_of_use=speed, **rated)
    used = [load / limit for load, limit in zip(loads, rated.values(), strict=True)]
    return StaticRatings(*(filled(value, shape) for value in used))
