"""
A torque through a universal joint
==================================

One torque goes in, one comes out, and both shafts are bent. Statics alone says how much: the
moment that the cross passes on stands normal to the plane of its pins, so that its component
along one shaft fixes the one along the other, and all that stands across them.
"""

import numpy as np

import cardan_dyn as cd

joint = cd.load("universal_joint")
beta = np.radians(30.0)
scene = cd.Scene(
    joint,
    drive="bearing_in",
    held={"joint_angle": beta},
    loads={"bearing_out": -100.0},  # N·m, against the motion
)
turn = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 361))

# The drive needs between T cos β and T / cos β, twice a revolution.
np.testing.assert_allclose(turn.drive_effort.min(), 100.0 * np.cos(beta), rtol=1e-13)
np.testing.assert_allclose(turn.drive_effort.max(), 100.0 / np.cos(beta), rtol=1e-13)
# Bending: up to T tan β on the output shaft, and T sin β on the input shaft where the output
# has none.
np.testing.assert_allclose(turn["bearing_out"].bending.max(), 100.0 * np.tan(beta), rtol=1e-13)
np.testing.assert_allclose(turn["bearing_in"].bending[90], 100.0 * np.sin(beta), rtol=1e-13)
print(turn)

figure = turn.plot("bearing_in", "bearing_out", title="Universal joint at 30°, 100 N·m")
