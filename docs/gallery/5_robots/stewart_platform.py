"""
Forces in the legs of a Stewart platform
========================================

Six legs carry a platform, and each is a drive. What they push follows from the six equations of
the platform alone, by a matrix of six lines: the Plücker coordinates of their lines. Both agree
at every place of the platform.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

legs = [f"leg_{index}" for index in range(1, 7)]
robot = cd.load("stewart_platform")
load = 800.0  # N, on the platform
scene = cd.Scene(robot, drive=legs, loads={"platform": cd.Wrench((0, 0, -load), frame="world")})
start = scene.sweep(np.zeros((1, 6)))
feet = np.stack([start.origin(f"base_{index}_x")[0] for index in range(1, 7)])
balls = np.stack(
    [start.origin("ball_1_x" if index == 1 else f"ball_{index}")[0] for index in range(1, 7)]
)
rest = np.linalg.norm(balls - feet, axis=1)

# Move the platform to and fro without turning it: the legs' lengths are known.
shift = np.linspace(-0.15, 0.15, 61)
tips = balls + shift[:, None, None] * [1.0, 0.0, 0.0]
lengths = np.linalg.norm(tips - feet, axis=2)
swept = scene.sweep(lengths - rest, along_path=True)
centre = start.point("platform").position[0]
np.testing.assert_allclose(swept.point("platform").position[:, 0] - centre[0], shift, atol=1e-12)

# Six forces along the legs hold the platform: Plücker coordinates of their lines.
lines = (tips - feet) / lengths[..., None]
about = tips - (centre + shift[:, None, None] * [1.0, 0.0, 0.0])
matrix = np.concatenate([lines, np.cross(about, lines)], axis=2).swapaxes(1, 2)
wanted = np.array([0.0, 0.0, load, 0.0, 0.0, 0.0])
thrust = np.linalg.solve(matrix, np.broadcast_to(wanted[:, None], (61, 6, 1)))[..., 0]
np.testing.assert_allclose(swept.drive_effort, thrust, atol=1e-9)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(shift, swept.drive_effort, label=legs)
axes.set(xlabel="platform moved along x [m]", ylabel="thrust of the leg [N]")
axes.set_title("800 N on a Stewart platform")
axes.legend(ncols=2, fontsize=8)
