"""
Wobble plate
============

A plate is inclined by 18° on a turning shaft, and pads that slide on it push five pistons to and
fro. A pad is held by a universal joint in its piston, and by a plane on the plate. Strokes are
harmonic, and the torque under pressure follows by virtual work.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

alpha, radius, thrust = np.radians(18.0), 0.04, 3000.0
places = np.radians([0.0, 72.0, 144.0, 216.0, 288.0])
parts = ""
for index, place in enumerate(places):
    x, y = radius * np.cos(place), radius * np.sin(place)
    parts += f"""<link name="piston_{index}"/><link name="pad_{index}"/>
      <joint name="bore_{index}" type="prismatic"><parent link="block"/>
        <child link="piston_{index}"/><origin xyz="{x} {y} {x * np.tan(alpha)}"/>
        <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
      <joint name="knuckle_{index}" type="universal"><parent link="piston_{index}"/>
        <child link="pad_{index}"/><axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></joint>
      <loop name="face_{index}" type="planar"><predecessor link="plate"/>
        <successor link="pad_{index}"/><axis xyz="{-np.sin(alpha)} 0 {np.cos(alpha)}"/></loop>"""
pump = cd.load(f"""<robot name="pump"><link name="block"/><link name="plate"/>
  <joint name="shaft" type="continuous"><parent link="block"/><child link="plate"/>
    <axis xyz="0 0 1"/></joint>{parts}</robot>""")

angle = np.linspace(0.0, 2.0 * np.pi, 721)
height = radius * np.tan(alpha) * np.cos(angle - places[:, None])
slope = -radius * np.tan(alpha) * np.sin(angle - places[:, None])
pressed = thrust * (slope > 0.0)  # N, while a piston goes out
loads = {f"bore_{index}": -force for index, force in enumerate(pressed)}
turn = cd.Scene(pump, drive="shaft", loads=loads).sweep(angle)
for index, expected in enumerate(height):
    place = turn.point(f"piston_{index}").position
    np.testing.assert_allclose(place[:, 2], expected, atol=1e-14)
torque = np.sum(pressed * slope, axis=0)
np.testing.assert_allclose(turn.drive_effort, torque, atol=1e-9)
# The plane pushes along its normal: across the bore it is tan α of the thrust.
across = turn["bore_2"].shear
np.testing.assert_allclose(across, pressed[2] * np.tan(alpha), atol=1e-8)

figure, (above, below) = plt.subplots(2, 1, figsize=(6.0, 5.0), sharex=True, layout="constrained")
above.plot(np.degrees(angle), 1e3 * height.T)
above.set(ylabel="pistons [mm]", title="Wobble plate, five pistons of 3 kN")
below.plot(np.degrees(angle), turn.drive_effort)
below.set(xlabel="shaft [°]", ylabel="torque [N·m]")
