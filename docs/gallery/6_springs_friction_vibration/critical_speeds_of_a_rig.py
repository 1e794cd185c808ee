"""
Critical speeds of Thoma's rig
==============================

Thoma (1920) expected resonance where the bending of a universal joint, twice a turn, meets the
natural frequency of the shaft behind it: at half of it. With the gyroscopic moment of the
flywheel there are two such speeds, for whirls with and against the rotation, and their closed
form is ω / √(4 ∓ 2 Θ/A).
"""

import numpy as np

import cardan_dyn as cd

rig = cd.load("elastic_thoma_rig")
scene = cd.Scene(
    rig,
    drive="bearing_in",
    free=list(rig.joint_springs),
    elements=cd.described_elements(rig),
    held={"joint_angle": np.radians(2.0)},
)
found = cd.vibration.critical_speeds(scene, [60.0, 160.0], orders=(2,), instabilities=False)
print(found)

# Inertia of what tilts, about the joint's centre, and of what turns about its own axis.
parts = {link.name: link for link in rig.description.links}
tilting = [parts["housing_out"], parts["shaft_out"]]
across = sum(part.inertia[1, 1] + part.mass * part.centre[0] ** 2 for part in tilting)
ratio = parts["shaft_out"].inertia[0, 0] / across
own = np.sqrt(rig.joint_springs["tilt_z"][0] / across)
closed = own / np.sqrt(4.0 + 2.0 * ratio), own / np.sqrt(4.0 - 2.0 * ratio)
speeds = [row.speed for row in found.rows]
np.testing.assert_allclose(speeds, closed, rtol=1e-3)  # of small joint angles
print(
    f"Thoma: {own / 2.0:.1f} rad/s, with the gyroscopic moment {closed[0]:.1f} and {closed[1]:.1f}"
)

figure = found.plot()
