"""
A million operating points
==========================

Forces follow from loads, speed and acceleration by a few functions of the position alone. A
response tabulates them once to rounding; a thousand speeds at a thousand positions then cost no
more than their multiplication. The map shows where a compressor's crank pin is loaded least.
"""

import time

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": -2000.0})
response = scene.response()
angle = np.linspace(0.0, 2.0 * np.pi, 1000)[:, None]
speed = np.linspace(0.0, 400.0, 1000)
start = time.process_time()
grid = response.sweep(angle, speed=speed)
pressed = grid["crank_pin"].shear
print(f"{pressed.size} points in {time.process_time() - start:.1f} s")

# Quasi-static force and centrifugal parts grow with the square of the speed: a parabola in ω².
vector = grid.wrench("crank_pin", "parent").force
middle = vector[:, 0] + (vector[:, -1] - vector[:, 0]) * (speed[500] / speed[-1]) ** 2
np.testing.assert_allclose(vector[:, 500], middle, atol=1e-8)
# Without speed: gas over the cosine of the rod's slope.
slope = np.arcsin(0.3 * np.sin(angle[:, 0]))
np.testing.assert_allclose(pressed[:, 0], 2000.0 / np.cos(slope), rtol=1e-10)
# The same by a sweep.
some = scene.sweep(angle[::111, 0], speed=speed[777])
np.testing.assert_allclose(pressed[::111, 777], some["crank_pin"].shear, rtol=1e-9)

figure, axes = plt.subplots(figsize=(6.2, 4.2), layout="constrained")
drawn = axes.pcolormesh(np.degrees(angle[::4, 0]), speed[::4], pressed[::4, ::4].T / 1e3)
figure.colorbar(drawn, label="force in the crank pin [kN]")
axes.set(xlabel="crank [°]", ylabel="speed [rad/s]", title="2 kN of gas, a million points")
