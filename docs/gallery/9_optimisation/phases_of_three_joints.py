"""
Phases of three joints for an even motion
=========================================

A line of three universal joints of 10, 12 and 8° in one plane runs evenly if its forks have the
right phases: with d = -ln cos β they are the angles of a hyperbolic triangle with the sides d.
Least squares on the ratio of speeds, with the exact derivative by each phase, meets the closed form
to rounding.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, least_squares

import cardan_dyn as cd

bends = np.radians([10.0, 12.0, 8.0])


def shaft(index, slope):
    """Return a shaft of 1 m on a bearing, bent off the first one."""
    return f"""<link name="shaft_{index}"/><joint name="bearing_{index}" type="continuous">
      <parent link="base"/><child link="shaft_{index}"/>
      <origin xyz="{places[index].real} {places[index].imag} 0" rpy="0 0 {slope}"/>
      <axis xyz="1 0 0"/></joint>"""


def joint(index):
    return f"""<loop name="joint_{index}" type="universal"><axis xyz="0 1 0"/><axis2 xyz="0 0 1"/>
      <predecessor link="shaft_{index - 1}"><origin xyz="1 0 0"/></predecessor>
      <successor link="shaft_{index}"/></loop>"""


slopes = [0.0, *np.cumsum(bends)]
places = [0.0 + 0.0j, *np.cumsum(np.exp(1j * np.array(slopes[:-1])))]
line = cd.load(f"""<robot name="line"><link name="base"/>
  {"".join(map(shaft, range(4), slopes))}{"".join(map(joint, (1, 2, 3)))}</robot>""")

# Of the two shafts between joints, how far the second fork is turned on from across the first.
phases = ["origin:joint_2.predecessor.roll", "origin:joint_3.predecessor.roll"]
scene = cd.Scene(line, drive="bearing_0", held=dict.fromkeys(phases, 0.0), outputs=[])
turn = np.linspace(0.0, np.pi, 36, endpoint=False)
variables = cd.DesignVariables(
    lambda phases: scene.sweep(turn, held=phases), dict.fromkeys(phases, ("0 deg", "90 deg"))
)
uneven = variables.quantity(
    lambda sweep: sweep.motion.ratio("bearing_3") - 1.0,
    lambda sweep, by: by.motion.ratio("bearing_3"),
)
# As exact as it gets: it ends where rounding stops it.
exactly = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
bounds = Bounds(*variables.bounds)
best = least_squares(uneven, [0.5, 0.5], jac=uneven.jac, bounds=bounds, **exactly)
found = np.array([*variables.values(best.x).values()])

# Angles γ of the triangle, by its sides.
d = -np.log(np.cos(bends))
ch, sh = np.cosh(d), np.sinh(d)
first = 0.5 * np.arccos((ch[2] - ch[0] * ch[1]) / (sh[0] * sh[1]))
second = 0.5 * np.arccos((ch[0] - ch[1] * ch[2]) / (sh[1] * sh[2]))
np.testing.assert_allclose(np.degrees(found), np.degrees([first, second]), rtol=0.0, atol=1e-9)
assert np.abs(uneven(best.x)).max() < 1e-12
print(variables.review(best))

# What lies around it, of a batch of designs in one sweep.
grid = np.radians(np.linspace(0.0, 90.0, 31))
batch = {phases[0]: grid[:, None, None], phases[1]: grid[:, None]}
ratio = scene.sweep(turn, held=batch).motion.ratio("bearing_3")
figure, axes = plt.subplots(figsize=(5.6, 4.4), layout="constrained")
drawn = axes.contourf(*[np.degrees(grid)] * 2, 100.0 * np.ptp(ratio, axis=-1).T, levels=20)
figure.colorbar(drawn, label="range of the speed of the output [%]")
axes.plot(*np.degrees(found), "r*", markersize=14)
axes.set(xlabel="phase of shaft 1 [°]", ylabel="phase of shaft 2 [°]", title="Joints of 10, 12, 8°")
