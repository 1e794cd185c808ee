"""
A double shaft in space
=======================

If the shafts do not lie in one plane, forks in line no longer make the output even: they have to
be turned against each other by the angle between both planes of bending. All forks are swept in
one call, and held against the closed form for the single joint that is as uneven as the line.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd
from cardan_dyn.analytic import drive_line

# The example of a catalogue: 15° and 7°, -11.5° and 12° in side view and plan view.
side, plan = np.radians([15.0, -11.5]), np.radians([7.0, 12.0])
up = np.arctan(np.tan(side) * np.cos(plan))
held = {"joint_angle_1_h": plan[0], "joint_angle_1_v": up[0]}
held |= {"fork_phase": 0.0, "joint_angle_2_h": plan[1], "joint_angle_2_v": up[1]}
betas = np.arctan(np.hypot(np.tan(side), np.tan(plan)))

scene = cd.Scene(
    cd.load("double_shaft_spatial"), drive="bearing_in", held=held, loads={"bearing_out": -100.0}
)
phase = np.radians(np.linspace(-90.0, 90.0, 181))  # from the phase that the file already has
turn = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 181), held={"fork_phase": phase[:, None]})
ratio = turn.motion.ratio("bearing_out")  # (181, 181): forks × positions

# Turned by γ, both joints are as uneven as one at β_E: its ratio is between cos β_E and 1 / cos
# β_E.
expected = drive_line.residual_angle(betas, drive_line.fork_phases([[0.0]], phase[:, None]))
found = np.arccos(np.sqrt(ratio.min(axis=1) / ratio.max(axis=1)))
np.testing.assert_allclose(found, expected, atol=3e-4)  # extremes lie between the positions
assert abs(np.degrees(phase[np.argmin(found)])) < 1.01
assert np.round(np.degrees(betas), 4).tolist() == [16.4225, 16.3956]

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(np.degrees(phase), np.degrees(expected), label="closed form")
axes.plot(np.degrees(phase[::10]), np.degrees(found[::10]), "o", label="sweep")
axes.set(xlabel="rear fork, turned further by [°]", ylabel="residual angle [°]")
axes.set_title("Spatial double shaft: how even is its output?")
axes.legend()
