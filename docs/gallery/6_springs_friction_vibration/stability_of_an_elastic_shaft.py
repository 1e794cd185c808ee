"""
Stability chart of an elastic shaft in front of the joint
=========================================================

At an angle a universal joint makes the inertia behind it vary twice a turn. Near the natural
frequency of the shaft in front of it, the line then vibrates by itself, however well it is
balanced. For small angles the edges of this zone are known: 1 ∓ a β² / 4 of the natural
frequency.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

line = cd.load("torsional_line_front")
inertia = {link.name: link.inertia[0, 0] for link in line.description.links}
stiffness = 6135.92315154  # N·m/rad, of 500 mm of steel, 25 mm thick
front, behind = inertia["shaft_in"] + inertia["cross"], inertia["shaft_out"]
own = np.sqrt(stiffness / (front + behind))
assert round(own, 1) == 222.9

beta = np.radians(np.linspace(6.0, 24.0, 7))
scene = cd.Scene(
    line,
    drive="bearing_in",
    free=["twist_in"],
    elements=[cd.JointSpring("twist_in", stiffness)],  # without damping
    held={"joint_angle": beta[0]},
)
speeds = np.linspace(0.9, 1.1, 41) * own
chart = cd.vibration.floquet(scene, speeds, held={"joint_angle": beta}, edges=True)
print(chart)

# The closed form leaves terms in β⁴ out, and that the cross turns with neither shaft alone.
share = behind / (front + behind)
edges = np.array([[region.lower, region.upper] for (region,) in chart.region]) / own
closed = 1.0 + share * np.outer(beta**2, [-0.25, 0.25])
cross = inertia["cross"] / (front + behind)
assert np.all(np.abs(edges - closed) < (0.1 * beta**4 + cross * beta**2 / 4.0)[:, None])

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.fill_betweenx(np.degrees(beta), *edges.T, color="C3", alpha=0.4, label="unstable")
axes.plot(closed, np.degrees(beta), "k--")
axes.set(xlabel="speed / natural frequency", ylabel="joint angle [°]")
axes.set_title("Elastic shaft in front of the joint; dashed: small angles")
axes.legend(loc="lower right")
