"""Transmissions between motors and joints, with closed forms that were derived by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from cardan_dyn.kit.arrays import Array

MOTORS = {"left": (0.04, 0.25), "right": (-0.04, 0.18)}
"""Motor of the ankle to the y and z of its axis, which is parallel to that of pitch [m]."""
CRANK, HEEL, SOLE = 0.05, 0.05, 0.03
"""Length of cranks; how far behind and above the ankle's axes rods end at the foot [m]."""


def ankle() -> str:
    """A parallel ankle: two cranks on the shin, rods with balls at both ends, pitch and roll."""
    parts = []
    for name, (y, z) in MOTORS.items():
        length = z - SOLE
        across = 0.08 * length**2 / 12.0
        parts.append(f"""
<link name="{name}_crank"><inertial><origin xyz="-0.02 0 0"/><mass value="0.1"/>
  <inertia ixx="1e-5" iyy="4e-5" izz="4e-5"/></inertial></link>
<link name="{name}_rod"><inertial><origin xyz="0 0 {-0.5 * length!r}"/><mass value="0.08"/>
  <inertia ixx="{across!r}" iyy="{across!r}" izz="1e-6"/></inertial></link>
<joint name="{name}_motor" type="revolute"><parent link="shin"/><child link="{name}_crank"/>
  <origin xyz="0 {y} {z}"/><axis xyz="0 1 0"/><dynamics armature="0.002"/>
  <limit lower="-0.4" upper="0.4" velocity="12" effort="40"/></joint>
<joint name="{name}_top" type="spherical"><parent link="{name}_crank"/><child link="{name}_rod"/>
  <origin xyz="{-CRANK} 0 0"/></joint>
<loop name="{name}_bottom" type="spherical">
  <predecessor link="{name}_rod"><origin xyz="0 0 {-length!r}"/></predecessor>
  <successor link="foot"><origin xyz="{-HEEL} {y} {SOLE}"/></successor></loop>""")
    return f"""<robot name="ankle"><link name="shin"/>
<link name="cross"><inertial><mass value="0.05"/>
  <inertia ixx="1e-5" iyy="1e-5" izz="1e-5"/></inertial></link>
<link name="foot"><inertial><origin xyz="0.03 0 -0.05"/><mass value="0.9"/>
  <inertia ixx="0.001" iyy="0.003" izz="0.003"/></inertial></link>
<joint name="pitch" type="revolute"><parent link="shin"/><child link="cross"/><axis xyz="0 1 0"/>
  <limit lower="-0.3" upper="0.3" velocity="20" effort="100"/></joint>
<joint name="roll" type="revolute"><parent link="cross"/><child link="foot"/><axis xyz="1 0 0"/>
  <limit lower="-0.2" upper="0.2" velocity="20" effort="100"/></joint>{"".join(parts)}</robot>"""


def ankle_in_one_joint() -> str:
    """The same with pitch and roll as a universal joint, whose cross has no mass."""
    text = ankle()
    cross, rest = text.index('<link name="cross">'), text.index('<link name="foot">')
    joints, end = text.index('<joint name="pitch"'), text.index('<link name="left_crank')
    joint = """<joint name="both" type="universal"><parent link="shin"/><child link="foot"/>
<axis xyz="0 1 0"/><axis2 xyz="1 0 0"/></joint>"""
    return text[:cross] + text[rest:joints] + joint + text[end:]


def ankle_on_a_base() -> str:
    """The same on a shin that floats, which a fixed joint of adjustable length carries."""
    base = """<link name="world"/><link name="knee"><inertial><mass value="3"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01"/></inertial></link><link name="shin"/>
<joint name="base" type="floating"><parent link="world"/><child link="knee"/></joint>
<joint name="length" type="fixed" adjustable="prismatic"><parent link="knee"/><child link="shin"/>
<axis xyz="0 0 1"/></joint>"""
    return ankle().replace('<link name="shin"/>', base)


def ankle_motors(pitch: Any, roll: Any, use: Any = np) -> list[Any]:
    """Angles of the ankle's motors, by hand: |foot's ball - crank's ball| is the rod's length.

    With the foot's ball at (x, y, z) from the motor's axis, and the crank's at c (-cos a, 0,
    sin a): 2 c (x cos a - z sin a) = L² - c² - x² - y² - z², of which the solution near a = 0 is
    taken.

    Args:
        pitch, roll: numbers or arrays [rad].
        use: `numpy`, or `mpmath` for numbers of more digits.
    """
    found = []
    for y, z in MOTORS.values():
        # Ry(pitch) Rx(roll) p of the point p of the foot.
        aside = y * use.cos(roll) - SOLE * use.sin(roll)
        above = y * use.sin(roll) + SOLE * use.cos(roll)
        at_x = -HEEL * use.cos(pitch) + above * use.sin(pitch)
        at_y = aside - y
        at_z = HEEL * use.sin(pitch) + above * use.cos(pitch) - z
        length = z - SOLE
        right = (length**2 - CRANK**2 - at_x**2 - at_y**2 - at_z**2) / (2 * CRANK)
        # x cos a - z sin a = r cos(a + b), with b = atan2(z, x).
        size = use.sqrt(at_x**2 + at_z**2)
        b = (use.arctan2 if use is np else use.atan2)(at_z, at_x)
        angle = -b - (use.arccos if use is np else use.acos)(right / size)
        turns = (use.rint if use is np else use.nint)(angle / (2 * use.pi))
        found.append(angle - 2 * use.pi * turns)
    return found


def hexapod() -> str:
    """A Stewart platform whose legs are rods of no mass, and whose platform floats in the tree."""
    base, top = hexapod_points()
    legs = []
    for k in range(6):
        axis, first = base_frame(top[k] + [0.0, 0.0, 0.6] - base[k])
        rpy = " ".join(map(repr, axis))
        legs.append(f"""
<link name="cylinder_{k}"/><link name="rod_{k}"/>
<joint name="foot_{k}" type="universal"><parent link="ground"/><child link="cylinder_{k}"/>
  <origin xyz="{words(base[k])}" rpy="{rpy}"/><axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></joint>
<joint name="leg_{k}" type="prismatic"><parent link="cylinder_{k}"/><child link="rod_{k}"/>
  <origin xyz="0 0 {first!r}"/><axis xyz="0 0 1"/></joint>
<loop name="ball_{k}" type="spherical"><predecessor link="rod_{k}"/>
  <successor link="platform"><origin xyz="{words(top[k])}"/></successor></loop>""")
    return f"""<robot name="hexapod"><link name="ground"/>
<link name="platform"><inertial><origin xyz="0.01 0.02 0.03"/><mass value="20"/>
  <inertia ixx="0.5" iyy="0.6" izz="0.9"/></inertial></link>
<joint name="pose" type="floating"><parent link="ground"/><child link="platform"/>
  <origin xyz="0 0 0.6"/></joint>{"".join(legs)}</robot>"""


def hexapod_points() -> tuple[Array, Array]:
    """Points of the legs on the base, and in the platform `(6, 3)` [m]."""
    angles = np.radians([[-10, 10, 110, 130, 230, 250], [-50, 50, 70, 170, 190, 290]])
    base, top = (
        radius * np.stack([np.cos(of), np.sin(of), 0.0 * of], axis=1)
        for radius, of in zip((0.5, 0.3), angles, strict=True)
    )
    return base, top


def base_frame(leg: Array) -> tuple[tuple[float, float, float], float]:
    """Roll, pitch and yaw of a frame whose z lies along a leg, and the leg's length."""
    length = float(np.linalg.norm(leg))
    x, y, z = leg / length
    return (0.0, float(np.arctan2(np.hypot(x, y), z)), float(np.arctan2(y, x))), length


def words(vector: Array) -> str:
    """Numbers of a vector as XML has them."""
    return " ".join(map(repr, vector.tolist()))


def differential(ratio: float = 1.5) -> str:
    """Two motors on the ground that turn gears on a carrier; joints are carrier and output.

    The gears turn `ratio` times as fast as the output, in opposite senses, both about the carrier's
    axis: motors turn by pitch ± ratio · roll.
    """
    gear = "".join(
        f"""
<link name="gear_{k}"><inertial><mass value="0.2"/>
  <inertia ixx="1e-4" iyy="2e-4" izz="1e-4"/></inertial></link>
<joint name="spin_{k}" type="continuous"><parent link="carrier"/><child link="gear_{k}"/>
  <axis xyz="0 1 0"/></joint>
<loop name="motor_{k}" type="continuous"><predecessor link="ground"/><successor link="gear_{k}"/>
  <axis xyz="0 1 0"/></loop>
<coupling name="mesh_{k}" forces="none"><predecessor link="output"/><successor link="gear_{k}"/>
  <ratio value="{sign * ratio}"/></coupling>"""
        for k, sign in ((1, 1.0), (2, -1.0))
    )
    return f"""<robot name="differential"><link name="ground"/>
<link name="carrier"><inertial><mass value="1"/><inertia ixx="1e-3" iyy="2e-3" izz="1e-3"/>
</inertial></link>
<link name="output"><inertial><mass value="1"/><inertia ixx="3e-3" iyy="2e-3" izz="2e-3"/>
</inertial></link>
<joint name="pitch" type="continuous"><parent link="ground"/><child link="carrier"/>
  <axis xyz="0 1 0"/></joint>
<joint name="roll" type="continuous"><parent link="carrier"/><child link="output"/>
  <axis xyz="1 0 0"/></joint>{gear}</robot>"""


BOOM, POST, ARM = np.array([0.3, -0.4]), 1.6, 0.35
"""Where the boom's cylinder stands from the boom's pin (x, z); how far along the boom it acts, and
the angle of that point above the boom's line."""


def boom() -> str:
    """A loader's boom, raised by a cylinder; at zero the boom is level."""
    pin = POST * np.array([np.cos(ARM), np.sin(ARM)])
    along = pin - BOOM
    length, tilt = float(np.linalg.norm(along)), float(-np.arctan2(along[1], along[0]))
    return f"""<robot name="boom"><link name="frame"/>
<link name="boom"><inertial><origin xyz="1.5 0 0.1"/><mass value="400"/>
  <inertia ixx="10" iyy="300" izz="300"/></inertial></link>
<link name="cylinder"><inertial><origin xyz="0.4 0 0"/><mass value="60"/>
  <inertia ixx="1" iyy="5" izz="5"/></inertial></link>
<link name="piston"><inertial><origin xyz="-0.3 0 0"/><mass value="40"/>
  <inertia ixx="1" iyy="4" izz="4"/></inertial></link>
<joint name="boom_pin" type="revolute"><parent link="frame"/><child link="boom"/>
  <axis xyz="0 -1 0"/><limit lower="-0.7" upper="0.9" velocity="9" effort="9e9"/></joint>
<joint name="cylinder_pin" type="continuous"><parent link="frame"/><child link="cylinder"/>
  <origin xyz="{BOOM[0]} 0 {BOOM[1]}" rpy="0 {tilt!r} 0"/><axis xyz="0 -1 0"/></joint>
<joint name="stroke" type="prismatic"><parent link="cylinder"/><child link="piston"/>
  <origin xyz="{length!r} 0 0"/><axis xyz="1 0 0"/>
  <limit lower="-0.3" upper="0.2" velocity="0.4" effort="120000"/></joint>
<loop name="piston_pin" type="continuous"><predecessor link="piston"/>
  <successor link="boom"><origin xyz="{pin[0]} 0 {pin[1]}" rpy="0 {tilt!r} 0"/></successor>
  <axis xyz="0 -1 0"/></loop></robot>"""
