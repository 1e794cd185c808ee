"""
Which joints of a needle drive hammer?
======================================

With clearance in its pins, a mechanism strikes where the force in a joint swings round. The scan
finds these places in every joint, and estimates the impacts with the two-mass model of Dresig and
Thümmel. Its closed form is evaluated here by hand for the worst of them.
"""

import numpy as np

import cardan_dyn as cd
from cardan_dyn import clearance
from cardan_dyn.motion.clearance import drawing

needles = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
found = clearance.scan(needles, speed=300.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.25)
print(found)
reversal = found["coupler_pin"].worst

# The slope of its force where it swings round, from a sweep, and the flight under it from rest:
# t = (12 m s / F')^(1/3), v = 6 s / t with half the clearance, s.
step = 1e-4
near = reversal.position + step * np.arange(-1, 2)
force = needles.sweep(near, speed=300.0)["coupler_pin"].force[:, :2]
slope = 300.0 * np.linalg.norm(force[2] - force[0]) / (2.0 * step)
np.testing.assert_allclose(reversal.force_slope, slope, rtol=2e-3)
flight = np.cbrt(12.0 * reversal.reduced_mass * 0.5e-4 / slope)
# The scan lets the slope change over the flight, by some percent here.
np.testing.assert_allclose(reversal.contact_time, flight, rtol=0.04)
np.testing.assert_allclose(reversal.impact_speed, 6.0 * 0.5e-4 / flight, rtol=0.04)
turn = needles.sweep(np.linspace(0.0, 2.0 * np.pi, 7201), speed=300.0)
np.testing.assert_allclose(
    found["coupler_pin"].rigid_peak, turn["coupler_pin"].shear.max(), rtol=1e-4
)

figure = drawing.impact_ranking(found)
