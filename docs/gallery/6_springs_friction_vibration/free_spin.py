"""
Free spin of a universal joint
==============================

A joint spins by itself, without drive or losses. Both shafts exchange energy twice a turn: where
the output is fast, the input has to be slow. Its speed follows from the inertia that the joint
shows its drive at each position, and after a hundred turns nothing has drifted.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

WHEEL = """<inertial><mass value="1"/>
    <inertia ixx="{}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
text = f"""<robot name="wheels"><link name="frame"/>
  <link name="shaft_in">{WHEEL.format(0.5)}</link> <link name="cross"/>
  <link name="shaft_out">{WHEEL.format(2.0)}</link>
  <joint name="bearing_in" type="continuous"><parent link="frame"/><child link="shaft_in"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="pin_in" type="continuous"><parent link="shaft_in"/><child link="cross"/>
    <axis xyz="0 1 0"/></joint>
  <joint name="bend" type="fixed" adjustable="revolute"><parent link="frame"/>
    <child link="housing"/><axis xyz="0 0 1"/>
    <limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint> <link name="housing"/>
  <joint name="bearing_out" type="continuous"><parent link="housing"/><child link="shaft_out"/>
    <axis xyz="1 0 0"/></joint>
  <loop name="pin_out" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="cross"/><successor link="shaft_out"/></loop></robot>"""
beta = np.radians(40.0)
scene = cd.Scene(cd.load(text), free="bearing_in", held={"bend": beta})
spin = scene.simulate(100.0, speed=10.0)
assert spin.method == "quadrature" and spin.energy_residual < 1e-12

# J₁ ω² + J₂ η² ω² stays what it was, η being the ratio of the joint.
time = np.linspace(95.0, 100.0, 2001)
late = spin.at(time)
ratio = np.cos(beta) / (1.0 - (np.sin(beta) * np.cos(late.position)) ** 2)
first = 1.0 / np.cos(beta)  # where it starts
energy = 0.5 + 2.0 * first**2
np.testing.assert_allclose(late.speed**2 * (0.5 + 2.0 * ratio**2), 100.0 * energy, rtol=1e-12)
np.testing.assert_allclose(late.motion.velocity("bearing_out"), ratio * late.speed, rtol=1e-12)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(time, late.speed, label="input")
axes.plot(time, late.motion.velocity("bearing_out"), label="output")
axes.set(xlabel="time [s]", ylabel="speed [rad/s]", xlim=(98.5, 100.0))
axes.set_title("Free spin at 40°, after a hundred seconds")
axes.legend()
