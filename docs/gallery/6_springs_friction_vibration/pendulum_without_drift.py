"""
A pendulum against the elliptic integral
========================================

A pendulum that is let go at 170° has a period of 2.4 times that of small swings: 4 √(l/g) K(sin²
85°). One free coordinate without losses is a quadrature, so that the period is right to rounding,
and still so after a hundred swings.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk

import cardan_dyn as cd

pendulum = cd.load("""<robot name="pendulum"><link name="wall"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="pin" type="continuous"><parent link="wall"/><child link="rod"/>
    <axis xyz="0 1 0"/></joint></robot>""")
start = np.radians(170.0)
length = (0.1 + 2.0 * 0.5**2) / (2.0 * 0.5)  # of a mathematical pendulum
period = 4.0 * np.sqrt(length / 9.81) * ellipk(np.sin(start / 2.0) ** 2)
assert round(period / (2.0 * np.pi * np.sqrt(length / 9.81)), 2) == 2.44

scene = cd.Scene(pendulum, free="pin", gravity=(0.0, 0.0, -9.81))
swing = scene.simulate(100.25 * period, position=start)
after = swing.at(period * np.array([0.5, 1.0, 99.75, 100.0]))
np.testing.assert_allclose(after.position, [-start, start, 0.0, start], atol=1e-9)
# In the lowest place energy alone says how fast it is, and what the pin carries.
lowest = swing.at(99.75 * period)
square = 2.0 * 9.81 * (1.0 - np.cos(start)) / length
np.testing.assert_allclose(lowest.speed**2, square, rtol=1e-10)
pull = 2.0 * (9.81 + 0.5 * square)
np.testing.assert_allclose(lowest["pin"].shear, pull, rtol=1e-10)
print(swing, f"energy {swing.energy_residual:.1e}")

time = np.linspace(0.0, 2.0 * period, 801)
shown = swing.at(time)
figure, (above, below) = plt.subplots(2, 1, figsize=(6.0, 4.6), sharex=True, layout="constrained")
above.plot(time, np.degrees(shown.position))
above.set(ylabel="angle [°]", title="Let go at 170°")
below.plot(time, shown["pin"].shear)
below.set(xlabel="time [s]", ylabel="force in the pin [N]")
