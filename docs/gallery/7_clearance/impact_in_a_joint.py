"""
Impact in a joint, simulated
============================

Two masses of a press are pushed across their clearance by a force that grows with time, after
Dresig and Thümmel. The contact is a spring without damping; flight, touch and peak are known in
closed form, and the simulation locates every touch.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import cardan_dyn as cd

pair = cd.load("""<robot name="pair"><link name="left"/>
  <link name="right"><inertial><mass value="3.6"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="gap" type="prismatic"><parent link="left"/><child link="right"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>""")
mass, stiffness, clearance, ramp = 3.6, 1e7, 1e-4, 360e3  # kg, N/m, m, N/s
origin, axis = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
law = cd.LinearContact(stiffness)
contact = cd.PinContact("left", origin, axis, "right", origin, clearance, law, name="pin")
pushed = cd.Actuator("gap", lambda time: ramp * time)
scene = cd.Scene(pair, free="gap", elements=[contact, pushed])
run = scene.simulate(0.006, position=-clearance / 2.0, speed=0.0, rtol=1e-12)

# Flight over s = 0.1 mm: s = ramp t³ / (6 m). Then m x'' + c x = ramp t, from that speed.
touch = (6.0 * mass * clearance / ramp) ** (1.0 / 3.0)
speed = ramp * touch**2 / (2.0 * mass)
own = np.sqrt(stiffness / mass)
rest = speed - ramp / stiffness


def force(t):
    """Return the contact's force so long after the touch."""
    swing = stiffness * rest / own * np.sin(own * t) - ramp * touch * np.cos(own * t)
    return ramp * (touch + t) + swing


def slope(t):
    """Return the derivative of the force."""
    return ramp + stiffness * rest * np.cos(own * t) + ramp * touch * own * np.sin(own * t)


peak_at = brentq(slope, 0.2 / own, 3.0 / own)
first = run.touches[0]
np.testing.assert_allclose([first.start, first.speed], [touch, speed], rtol=1e-9)
np.testing.assert_allclose(first.peak, force(peak_at), rtol=1e-9)
assert round(first.peak, 2) == 2181.89  # as published

time = np.linspace(0.0, 0.005, 1001)
x = run.at(time).position
figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(1e3 * time, stiffness * np.maximum(x - clearance / 2.0, 0.0), label="simulated")
after = np.linspace(0.0, 2.4 / own, 60)
axes.plot(1e3 * (touch + after), force(after), "--", label="closed form")
axes.plot(1e3 * time, ramp * time, color="0.7", label="pushing force")
axes.set(xlabel="time [ms]", ylabel="force [N]", title="A pin across 0.1 mm of clearance")
axes.legend()
