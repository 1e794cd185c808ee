"""
Polar diagram of the bending moments, after Grossmann
=====================================================

Grossmann (1939) drew the bending moments of both shafts of a universal joint at 50°, referred to
the torque of the input shaft, over the angles of the shafts. The input shaft is bent most where
the output shaft is not bent at all; the greatest bending of the latter lies beside its main
position.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

phi = np.radians(50.0)
scene = cd.Scene(
    cd.load("universal_joint"),
    drive="bearing_in",
    held={"joint_angle": phi},
    loads={"bearing_out": -100.0},
)
alpha = np.linspace(0.0, 2.0 * np.pi, 721)
turn = scene.sweep(alpha)
torque = turn["bearing_in"].torsion
first, second = turn["bearing_in"].bending / torque, turn["bearing_out"].bending / torque

# His (6) and (8), with tan φ sin α₁ and so on.
np.testing.assert_allclose(first, np.tan(phi) * np.abs(np.sin(alpha)), atol=1e-13)
closed = np.sin(phi) * np.abs(np.cos(alpha)) * np.hypot(1.0, np.tan(phi) * np.sin(alpha))
np.testing.assert_allclose(second, closed, atol=1e-13)
# The greatest of (8), from its derivative: at sin² α₁ = (1 - cot² φ) / 2 if φ exceeds 45°.
where = np.arcsin(np.sqrt((1.0 - 1.0 / np.tan(phi) ** 2) / 2.0))
there = scene.sweep(where)
greatest = there["bearing_out"].bending[0] / there.drive_effort[0]
np.testing.assert_allclose(greatest, 0.5 * np.tan(phi) / np.sin(phi), rtol=1e-12)
assert round(np.degrees(where), 2) == 22.62 and round(greatest, 4) == 0.7779

figure, axes = plt.subplots(figsize=(5.4, 5.4), subplot_kw={"projection": "polar"})
axes.plot(alpha, first, label="$B_1/D_1$")
axes.plot(turn.motion.position("bearing_out"), second, "--", label="$B_2/D_1$")
axes.set_title("Bending over the angle of the shaft, 50°")
axes.legend(loc="lower right")
