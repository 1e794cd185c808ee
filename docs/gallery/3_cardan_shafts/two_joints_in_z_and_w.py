"""
Two joints in Z and in W
========================

With equal angles and forks of the middle shaft in one plane, a double shaft turns evenly, whether
its ends are parallel (Z) or cross (W). What differs is the middle shaft: the moments of both
joints on it cancel in Z. In W they add up, and forces at its ends have to balance them.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

beta, torque = np.radians(20.0), 400.0
angle = np.linspace(0.0, 2.0 * np.pi, 721)
held = {"joint_angle_1": beta, "joint_angle_2": beta}
sizes = {}
figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for name in ("double_shaft_z", "double_shaft_w"):
    scene = cd.Scene(cd.load(name), drive="bearing_in", held=held, loads={"bearing_out": -torque})
    turn = scene.sweep(angle)
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), 1.0, rtol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, torque, rtol=1e-13)
    for end in ("bearing_in", "bearing_out"):
        np.testing.assert_allclose(turn[end].bending.max(), torque * np.tan(beta), rtol=1e-12)
    across = turn.wrench("pin_1_out", "world").force
    sizes[name] = np.linalg.norm(across, axis=1)
    axes.plot(np.degrees(angle), sizes[name], label=name)
# On the middle shaft of 900 mm both moments, T sin β each, cancel in Z and add up in W.
np.testing.assert_allclose(sizes["double_shaft_z"], 0.0, atol=1e-10)
np.testing.assert_allclose(
    sizes["double_shaft_w"].max(), 2.0 * torque * np.sin(beta) / 0.9, rtol=1e-12
)
axes.set(xlabel="input shaft [°]", ylabel="force on joint 1 across the middle shaft [N]")
axes.set_title("400 N·m, 20° at both joints")
axes.legend()
