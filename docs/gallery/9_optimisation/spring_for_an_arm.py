"""
A spring that carries an arm
============================

A spring without free length, from a hook straight above the arm's bearing, carries the arm in every
position: k h b = m g s. Least squares on the effort finds its hook. A spring that has a free length
cannot do that; least squares finds what it does best, and which bound keeps it from doing better.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, least_squares

import cardan_dyn as cd

mass, centre, reach, stiffness = 4.0, 0.35, 0.25, 900.0
lamp = cd.load(f"""<robot name="lamp"><link name="post"/><link name="hook"/>
  <link name="arm"><inertial><origin xyz="{centre} 0 0"/><mass value="{mass}"/>
    <inertia ixx="0.01" iyy="0.1" izz="0.1"/></inertial></link>
  <joint name="bearing" type="continuous"><parent link="post"/><child link="arm"/>
    <axis xyz="0 -1 0"/></joint>
  <joint name="hook" type="fixed"><parent link="post"/><child link="hook"/>
  </joint></robot>""")
lift = np.radians(np.linspace(-60.0, 60.0, 41))
bounds = {"origin:hook.x": ("-100 mm", "50 mm"), "origin:hook.z": ("-20 mm", "100 mm")}


def best_hook(length):
    """Return the scene, where its hook is best, and what is left there."""
    ends = "hook", (0.0, 0.0, 0.0), "arm", (reach, 0.0, 0.0)
    scene = cd.Scene(
        lamp,
        drive="bearing",
        held=dict.fromkeys(bounds, 0.0),
        gravity=(0.0, 0.0, -9.81),
        elements=[cd.PointSpring(*ends, stiffness, length=length)],
    )
    variables = cd.DesignVariables(lambda hook: scene.sweep(lift, held=hook), bounds)
    effort = variables.quantity(lambda sweep: sweep.drive_effort, lambda sweep, by: by.drive_effort)
    best = least_squares(effort, [0.5, 0.5], jac=effort.jac, bounds=Bounds(*variables.bounds))
    return effort(best.x), variables.review(best)


left, ideal = best_hook(0.0)
height = mass * 9.81 * centre / (stiffness * reach)
np.testing.assert_allclose([*ideal.values.values()], [0.0, height], rtol=0.0, atol=1e-9)
np.testing.assert_allclose(left, 0.0, atol=1e-8)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(np.degrees(lift), mass * 9.81 * centre * np.cos(lift), label="no spring")
for length in (0.0, 0.08, 0.16):
    left, review = best_hook(length)
    x, z = (round(1e3 * value) for value in review.values.values())
    axes.plot(np.degrees(lift), left, label=f"free length {1e3 * length:.0f} mm: {x}, {z} mm")
    print(f"{1e3 * length:.0f} mm: {review}")
    assert review.optimality < 1e-4
axes.set(xlabel="arm above the horizontal [°]", ylabel="effort of the bearing [N·m]")
axes.legend(title="hook at x, z", fontsize=8)
