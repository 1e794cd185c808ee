"""
Where a balanced lamp rests
===========================

A spring from the wall to a lamp's arm, with no length of its own when it is loose, carries the
arm at any angle if k a b = m g l. Real springs have a length: then the arm has places where it
rests. The package finds one, says whether the lamp stays there, and how fast it swings.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

mass, length, a, b = 1.5, 0.6, 0.4, 0.25  # kg, m; a above the pin, b along the arm
lamp = cd.load(f"""<robot name="lamp"><link name="wall"/>
  <link name="arm"><inertial><origin xyz="{length} 0 0"/><mass value="{mass}"/>
    <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="pin" type="continuous"><parent link="wall"/><child link="arm"/>
    <axis xyz="0 -1 0"/></joint></robot>""")
balanced = mass * 9.81 * length / (a * b)  # N/m


def scene(stiffness, rest=0.0):
    spring = cd.PointSpring("wall", (0.0, 0.0, a), "arm", (b, 0.0, 0.0), stiffness, length=rest)
    return cd.Scene(lamp, free="pin", gravity=(0.0, 0.0, -9.81), elements=[spring])


# What holds the arm at any angle is nothing if the spring is right.
angle = np.radians(np.linspace(-80.0, 80.0, 161))
held = scene(balanced).replace(drive="pin").sweep(angle)
np.testing.assert_allclose(held.drive_effort, 0.0, atol=1e-13)

# A real spring has a length of its own, 0.1 m here: one rest, where the moments are equal.
found = scene(1.35 * balanced, 0.1).equilibrium(0.3)
at = found.position[0]
stretched = np.hypot(a - b * np.sin(at), b * np.cos(at))
moment = 1.35 * balanced * (1.0 - 0.1 / stretched) * a * b * np.cos(at)
np.testing.assert_allclose(moment, mass * 9.81 * length * np.cos(at), rtol=1e-9)
assert found.stability == "stable"
print(found)
swing = scene(1.35 * balanced, 0.1).simulate(4.0, position=at + 1e-3)
period = 2.0 * np.pi / found.frequencies[0]
np.testing.assert_allclose(swing.at(period).position, at + 1e-3, atol=1e-7)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
for stiffness, rest, label in (
    (balanced, 0.0, "k a b = m g l, loose length 0"),
    (1.35 * balanced, 0.1, "1.35 k, loose length 0.1 m"),
    (1.2 * balanced, 0.1, "1.2 k, loose length 0.1 m"),
):
    turn = scene(stiffness, rest).replace(drive="pin").sweep(angle)
    axes.plot(np.degrees(angle), turn.drive_effort, label=label)
axes.plot(np.degrees(at), 0.0, "ko")
axes.set(xlabel="arm above the horizontal [°]", ylabel="moment to hold it [N·m]")
axes.legend()
