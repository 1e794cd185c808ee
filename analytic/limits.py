"""Limits and makers' constants of drive-line practice, each with its source.

They are data, not laws: makers disagree, and a user's own figure replaces any of them,
`LIMITS["torsional_acceleration"].replaced(350.0, "own measurements")`. No function of `analytic`
reads them behind the user's back; what has a default states it in its signature. SI units and
radians, with the unit beside the value.

References:
    Each entry names its source. AE-7 is the SAE Universal Joint and Driveshaft Design Manual; PSS
    the open program PSS.DriveshaftCalculations, which follows it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import cos, isfinite, pi, radians
from numbers import Real
from types import MappingProxyType
from typing import Literal, NamedTuple

__all__ = [
    "CRITICAL_CONSTANTS",
    "DIN_808_FACTORS",
    "JOINT_SIZES",
    "LIMITS",
    "POWER_FACTORS",
    "SERVICE_FACTORS",
    "SPEED_ANGLES",
    "JointSize",
    "Limit",
]

_RPM = pi / 30.0


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and isfinite(value)


@dataclass(frozen=True)
class Limit:
    """A limit or constant: its value, the unit of the value, and who states it.

    `bound` says whether a quantity must stay below ("most") or above it ("least"), or whether it is
    a constant of a formula ("constant").
    """

    value: float
    unit: str
    source: str
    bound: Literal["most", "least", "constant"] = "most"

    def __post_init__(self) -> None:
        if not _is_finite(self.value):
            raise ValueError(f"value = {self.value!r} of a limit is not a finite number")
        if not self.source.strip():
            raise ValueError(f"source = {self.source!r} of a limit is empty: say who states it")

    def replaced(self, value: float, source: str) -> Limit:
        """The same limit with another value, in the same unit, and its source."""
        return replace(self, value=value, source=source)


class JointSize(NamedTuple):
    """Limits of one size of joint: greatest speed [rad/s] and speed times angle [rad^2/s]."""

    size: str
    speed: float
    n_beta: float


_SPICER = "Spicer driveline installation manual"
_DANA_INDUSTRIAL = "Dana industrial drive shafts catalogue"
_PSS_LAYOUT = "PSS, DriveshaftLayout, after AE-7 p. 50"

LIMITS: Mapping[str, Limit] = MappingProxyType(
    {
        "residual_angle": Limit(radians(3.0), "rad", "catalogue chapter 6 (Klein), 6.4 and 6.5"),
        "non_uniformity": Limit(
            1.0 / cos(radians(3.0)) - cos(radians(3.0)),
            "1",
            "catalogue chapter 6 (Klein), U at 3 degrees, printed as 0.0027",
        ),
        "least_joint_angle": Limit(
            radians(0.5), "rad", f"{_SPICER}: rollers that do not turn wear the pins", "least"
        ),
        "speed_angle_share": Limit(1.0, "1", f"{_SPICER}, greatest angles by speed"),
        "angle_difference": Limit(radians(1.0), "rad", f"{_SPICER}: equal within 1 degree"),
        "torsional_acceleration": Limit(300.0, "rad/s^2", f"{_PSS_LAYOUT}, normal"),
        "torsional_acceleration_greatest": Limit(500.0, "rad/s^2", f"{_PSS_LAYOUT}, greatest"),
        "inertia_acceleration": Limit(1000.0, "rad/s^2", f"{_PSS_LAYOUT}, normal"),
        "inertia_acceleration_greatest": Limit(2000.0, "rad/s^2", f"{_PSS_LAYOUT}, greatest"),
        "bending_speed_share": Limit(0.75, "1", "PSS, CriticalSpeed; Cardan India, speed limit"),
        "bending_speed_share_industrial": Limit(0.65, "1", "IMS, industrial"),
        "bending_speed_share_automotive": Limit(0.70, "1", "IMS, automotive"),
        "half_critical_from": Limit(0.42, "1", "PSS, CriticalSpeed"),
        "half_critical_to": Limit(0.58, "1", "PSS, CriticalSpeed; Cardan India, 50 % and 8 %"),
        "second_order_angle": Limit(
            radians(3.0), "rad", f"{_DANA_INDUSTRIAL}, critical bending speed"
        ),
        "torsional_distance": Limit(
            0.1,
            "1",
            "API 617, separation of torsional natural frequencies; Wang, Feese and Pettinato 2012",
            "least",
        ),
        "mean_life_factor": Limit(5.0, "1", "AISCO, universal joint sizing", "constant"),
        "least_life_angle": Limit(
            radians(3.0), "rad", "AISCO: ratings at 3 degrees; PSS, B10Life", "constant"
        ),
        "adhesion": Limit(0.71, "1", f"{_SPICER}, wheel slip torque", "constant"),
        "axle_efficiency": Limit(0.95, "1", f"{_SPICER}: 11.4 = 12 x 0.95", "constant"),
        "lubrication_pressure": Limit(15e5, "Pa", f"{_DANA_INDUSTRIAL}, axial forces"),
        "balancing_speed": Limit(
            500.0 * _RPM, "rad/s", "Dana industrial p. 49: not normally balanced below 500/min"
        ),
        "balance_grade_maker": Limit(0.016, "m/s", "Dana industrial p. 49, G16 of the maker"),
        "telescope_travel_left": Limit(0.025, "m", "PTO practice; Befco asks 2 in", "least"),
        "telescope_overlap": Limit(0.150, "m", "PTO practice", "least"),
        "pto_angle": Limit(
            radians(15.0), "rad", "Befco, driveline length instructions, continuous"
        ),
        "din_808_plain_speed": Limit(1000.0 * _RPM, "rad/s", "DIN 808, plain bearings"),
        "din_808_needle_speed": Limit(4000.0 * _RPM, "rad/s", "DIN 808, needle bearings"),
        "din_808_double_share": Limit(0.90, "1", "DIN 808, double joints", "constant"),
    }
)
"""Limits by name."""

CRITICAL_CONSTANTS: Mapping[str, Limit] = MappingProxyType(
    {
        "steel": Limit(1.2187e8 * 1e-3 * _RPM, "rad m/s", "beam of steel, 1.2187e8 mm", "constant"),
        "elbe": Limit(1.21e8 * 1e-3 * _RPM, "rad m/s", "Elbe, 1.21e8 mm", "constant"),
        "ae_7": Limit(4.705e6 * 0.0254 * _RPM, "rad m/s", "AE-7 p. 267, 4.705e6 in", "constant"),
        "ims": Limit(4.8e6 * 0.0254 * _RPM, "rad m/s", "IMS, 4.8e6 in", "constant"),
    }
)
"""Constants C of omega = C sqrt(D^2 + d^2) / L^2 by maker, from n = C' sqrt(D^2 + d^2) / L^2."""

JOINT_SIZES: Mapping[str, JointSize] = MappingProxyType(
    {
        size: JointSize(size, rpm * _RPM, radians(n_beta) * _RPM)
        for size, rpm, n_beta in (
            ("2015", 6000.0, 27000.0),
            ("2020", 6000.0, 26000.0),
            ("2025", 6000.0, 24000.0),
            ("2030", 6000.0, 22000.0),
            ("2035", 5600.0, 21000.0),
            ("2040", 5000.0, 20000.0),
            ("2045", 4700.0, 19000.0),
            ("2047", 4500.0, 19000.0),
            ("2050", 4500.0, 19000.0),
            ("2055", 4500.0, 18000.0),
            ("2060", 4100.0, 17000.0),
            ("2065", 3900.0, 17000.0),
        )
    }
)
"""Greatest speed and speed times angle of Dana's joint sizes, for shafts of some 1.5 m.

Source: Dana commercial drive shafts catalogue, influence of speed and deflection angle, which
prints 1/min and degrees/min.
"""

SPEED_ANGLES: Mapping[float, float] = MappingProxyType(
    {
        rpm * _RPM: radians(degrees)
        for rpm, degrees in (
            (1500.0, 11.5),
            (2000.0, 8.7),
            (2500.0, 7.0),
            (3000.0, 5.8),
            (3500.0, 5.0),
            (4000.0, 4.2),
            (4500.0, 3.7),
            (5000.0, 3.2),
        )
    }
)
"""Greatest angle of a joint in normal operation [rad] by its speed [rad/s].

Source: Spicer driveline installation manual, which prints 1/min and degrees.
"""

SERVICE_FACTORS: Mapping[str, tuple[Limit, Limit]] = MappingProxyType(
    {
        load: (
            Limit(low, "1", f"PSS, ServiceFactor, {load}", "constant"),
            Limit(high, "1", f"PSS, ServiceFactor, {load}", "constant"),
        )
        for load, low, high in (
            ("continuous", 1.2, 1.5),
            ("light shock", 1.5, 2.0),
            ("medium shock", 2.5, 2.5),
            ("heavy shock", 3.0, 3.0),
            ("extreme shock", 4.0, 6.0),
        )
    }
)
"""Least and greatest service factor K by the kind of load."""

POWER_FACTORS: Mapping[str, Limit] = MappingProxyType(
    {
        "electric": Limit(1.0, "1", "PSS, PowerFactor, after catalogue IJ900 p. 3", "constant"),
        "petrol": Limit(1.2, "1", "PSS, PowerFactor, after catalogue IJ900 p. 3", "constant"),
        "diesel": Limit(1.25, "1", "PSS, PowerFactor, after catalogue IJ900 p. 3", "constant"),
    }
)
"""Factor K_3 of the prime mover. IMS states 1, 1.25 and 1.3 for its three classes."""

DIN_808_FACTORS: Mapping[str, Mapping[float, float]] = MappingProxyType(
    {
        bearing: MappingProxyType(
            dict(zip((10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0), factors, strict=True))
        )
        for bearing, factors in (
            ("plain", (1.0, 1.25, 1.5, 1.8, 2.2, 2.6, 3.3, 4.0)),
            ("needle", (1.0, 1.1, 1.25, 1.4, 2.0, 2.5, 3.3, 4.0)),
        )
    }
)
"""Factor k of the torque of precision joints by the angle in degrees, for both bearings.

Source: vibdoc (DIN 808). JW Winco reads 2.25 off its chart for plain bearings at 30 degrees, and
1.43 for needle bearings at 18 degrees, where this table has 1.19.
"""
