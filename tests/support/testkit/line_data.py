"""Drive lines as data, for tests."""

from __future__ import annotations

import numpy as np

from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Spline, Tube

Array = np.ndarray

NEAR, SPAN = (0.06, 0.07), (0.12, 0.15)
"""Distance of the near bearing from its joint, and from there to the far one: b, a and e, f [m]."""


def end_bearings(index: int) -> list[Bearing]:
    """Bearings of the input (0) or output (1) shaft."""
    return [Bearing(distance=NEAR[index]), Bearing(distance=NEAR[index] + SPAN[index])]


def double_shaft(
    side: tuple[float, float, float],
    plan: tuple[float, float, float] = (0.0, 0.0, 0.0),
    fork_offset: float = 0.0,
    length: float = 0.9,
    **spline: float,
) -> DriveLine:
    """A massless double shaft with slopes of its three shafts in both views [rad]."""
    common = [{"slope_side": v, "slope_plan": h} for v, h in zip(side, plan, strict=True)]
    return DriveLine(
        shafts=[
            Shaft(**common[0], bearings=end_bearings(0)),
            Shaft(**common[1], length=length, fork_offset=fork_offset, spline=Spline(**spline)),
            Shaft(**common[2], bearings=end_bearings(1)),
        ]
    )


def random_line(count: int, seed: int, bend: float = 0.3, *, mass: bool = False) -> DriveLine:
    """A line with centre bearings on all intermediate shafts but the last, which has a spline.

    Args:
        count: number of joints.
        seed: of slopes, lengths, forks and places of bearings.
        bend: greatest slope in each view [rad].
        mass: whether shafts and crosses have one.
    """
    rng = np.random.default_rng(seed)
    shafts = []
    for k in range(count + 1):
        length = rng.uniform(0.4, 0.9)
        fields: dict[str, object] = {
            "length": length,
            "slope_side": rng.uniform(-bend, bend),
            "slope_plan": rng.uniform(-bend, bend),
            "tube": Tube(outer_diameter=0.1, wall=0.004) if mass else None,
        }
        if k in (0, count):
            fields["bearings"] = end_bearings(k == count)
        else:
            fields["fork_offset"] = rng.uniform(-3.0, 3.0)
            if k == count - 1:
                fields["spline"] = Spline()
            else:
                fields["bearings"] = [Bearing(distance=rng.uniform(0.6, 0.95) * length)]
        shafts.append(Shaft(**fields))
    joints = [ShaftJoint(cross_mass=1.0 if mass else 0.0, cross_span=0.1)] * count
    return DriveLine(shafts=shafts, joints=joints)


def along_points(line: DriveLine, angles: Array, planes: Array, **fields: Array) -> DriveLine:
    """The line with other joint angles and planes, by the points where its shafts meet.

    Args:
        line: its first shaft keeps its direction.
        angles: joint angles `(n,)` [rad].
        planes: plane offsets `(n,)` [rad].
        fields: `length` and `fork_offset` of the intermediate shafts `(n - 1,)`.
    """
    frame = line.geometry.frames[0]
    points = [-frame[:, 0], np.zeros(3)]
    lengths = [*fields.get("length", line.geometry.lengths[1:-1]), 1.0]
    for angle, plane, length in zip(angles, planes, lengths, strict=True):
        c, s, cp, sp = np.cos(angle), np.sin(angle), np.cos(plane), np.sin(plane)
        frame = frame @ np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
        frame = frame @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        points.append(points[-1] + length * frame[:, 0])
    forks = [0.0, *fields.get("fork_offset", line.fork_offsets), 0.0]
    shafts = [
        Shaft(
            start=points[k],
            end=points[k + 1],
            fork_offset=forks[k],
            tube=shaft.tube,
            spline=shaft.spline,
            bearings=shaft.bearings,
        )
        for k, shaft in enumerate(line.shafts)
    ]
    return DriveLine(shafts=shafts, joints=line.joints)


FAN = """
name = "fan"
application = "industrial"
speed_rpm = 980
torque_nm = 800
acceleration_rad_s2 = 10
life_h = 8000
[[shafts]]
mass_kg = 40
inertia_kgm2 = 0.5
bearings = [
  { distance_mm = 80, radial_limit_kn = 8, axial_limit_kn = 9 },
  { distance_mm = 280, radial_limit_kn = 8 },
]
[[shafts]]
length = "1.2 m"
slope_side_deg = 3
tube = { outer_diameter_mm = 90, wall_mm = 3, shear_limit_mpa = 60 }
spline = { friction = 0.1, radius_mm = 25, compressed_mm = 1150, travel_mm = 110 }
[[shafts]]
mass_kg = 300
inertia_kgm2 = 25
bearings = [
  { distance_mm = 100, radial_limit_kn = 8, axial_limit_kn = 9 },
  { distance_mm = 500, radial_limit_kn = 8 },
]
[[joints]]
size = "2040"
largest_angle_deg = 20
rated_torque_nm = 2500
torque_limit_nm = 5000
pulsating_limit_nm = 2500
reversing_limit_nm = 1800
[[joints]]
size = "2040"
largest_angle_deg = 20
rated_torque_nm = 2500
torque_limit_nm = 5000
pulsating_limit_nm = 2500
reversing_limit_nm = 1800
"""
"""A line of which everything is known that rules ask for, and nothing is missed."""
