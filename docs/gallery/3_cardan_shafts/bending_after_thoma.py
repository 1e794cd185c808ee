"""
Thoma's bending of the output shaft
===================================

The output shaft of a universal joint bends its bearings twice a turn, even if its torque is
constant. Thoma (1920) gave both components in axes at rest. Together they run through a circle of
the diameter tan β, and their mean does not vanish: it pushes the joint out of its bend at all
times.
"""

import numpy as np

import cardan_dyn as cd

beta, torque = np.radians(20.0), 500.0
scene = cd.Scene(
    cd.load("universal_joint"),
    drive="bearing_in",
    held={"joint_angle": beta},
    loads={"bearing_out": -torque},
)
phi = np.linspace(0.0, 2.0 * np.pi, 721)
turn = scene.sweep(phi)
bending = turn.wrench("bearing_out", "parent").moment[:, 1:] / torque

# Thoma's (6) and (7).
below = np.cos(beta) ** 2 * np.cos(phi) ** 2 + np.sin(phi) ** 2
normal = np.sin(beta) * np.cos(beta) * np.cos(phi) ** 2 / below
swing = np.sin(beta) * np.sin(phi) * np.cos(phi) / below
np.testing.assert_allclose(bending[:, 0], normal, atol=1e-14)
np.testing.assert_allclose(np.abs(bending[:, 1]), np.abs(swing), atol=1e-14)
# A circle with the diameter tan β through the origin.
radius = np.hypot(bending[:, 0] - np.tan(beta) / 2.0, bending[:, 1])
np.testing.assert_allclose(radius, np.tan(beta) / 2.0, rtol=1e-13)
# What swivels the joint has to be held against: the same moment about the normal of both shafts.
held = np.abs(turn.holding_effort["joint_angle"])
np.testing.assert_allclose(held, torque * np.abs(swing), atol=1e-11)

figure = turn.plot.polar(
    "bearing_out", ["parent", "joint"], title="Bending of the output shaft, 20°, 500 N·m"
)
