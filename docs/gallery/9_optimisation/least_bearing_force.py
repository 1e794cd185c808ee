"""
Least greatest force on a bearing
=================================

A counterweight on the crank that makes the greatest force on its bearing over a turn least. The
greatest of many numbers has kinks, where gradients fail; but "z as small as it can be, and no force
greater than z" is smooth: one more variable, and a constraint for each position. SLSQP ends where
the force is equally great at three positions, and the multipliers say which ones they are. Where
the mean square is least, the greatest is 14 % more; a batch of designs in one sweep shows that no
other place is better.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, minimize

import cardan_dyn as cd

bar = cd.load("four_bar").to_urdf()
weight = """<link name="weight"><inertial><mass value="2"/>
    <inertia ixx="0" iyy="0" izz="0"/></inertial></link>
  <joint name="weight" type="fixed"><parent link="crank"/><child link="weight"/></joint></robot>"""
places = ["origin:weight.x", "origin:weight.y"]
scene = cd.Scene(
    cd.load(bar.replace("</robot>", weight)),
    drive="crank_bearing",
    held=dict.fromkeys(places, 0.0),
    outputs=["crank_bearing"],
)
angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
variables = cd.DesignVariables(
    lambda at: scene.sweep(angle, speed=30.0, held=at), dict.fromkeys(places, ("-150 mm", "150 mm"))
)


def force(sweep):
    # Across the plane, forces are not unique.
    return np.hypot(*sweep["crank_bearing"].force[..., :2].T).T


def change(sweep, by):
    inside = sweep["crank_bearing"].force[:, :2] * by["crank_bearing"].force[:, :2]
    return inside.sum(axis=-1) / force(sweep)


forces = variables.quantity(force, change)
squares = variables.quantity(
    lambda sweep: np.mean(force(sweep) ** 2),
    lambda sweep, by: 2.0 * np.mean(force(sweep) * change(sweep, by)),
)
middle = np.array([0.5, 0.5])  # The weight on the bearing itself.
scale = forces(middle).max()
smooth = minimize(squares, middle, jac=squares.jac, bounds=Bounds(*variables.bounds))

# Of (x, y, z), with z in units of the greatest force to begin with.
below = {
    "type": "ineq",
    "fun": lambda v: v[2] - forces(v) / scale,
    "jac": lambda v: np.column_stack([-forces.jac(v) / scale, np.ones(len(angle))]),
}
best = minimize(
    lambda v: v[2],
    [*smooth.x, forces(smooth.x).max() / scale],
    jac=lambda v: np.array([0.0, 0.0, 1.0]),
    bounds=[(0.0, 1.0), (0.0, 1.0), (0.0, None)],
    constraints=[below],
    method="SLSQP",
    options={"ftol": 1e-12},
)
review = variables.review(best, [below])
print(review)
assert best.success and review.optimality < 1e-9 and review.violation < 1e-12
# A kink holds the greatest down by shares of its sides.
np.testing.assert_allclose(sum(review.limits.values()), 1.0, rtol=1e-9)
least = scale * best.x[2]
np.testing.assert_allclose(least, forces(best.x).max(), rtol=1e-12)
assert forces(smooth.x).max() > 1.1 * least

around = np.linspace(-0.15, 0.15, 41)
batch = {places[0]: around[:, None, None], places[1]: around[:, None]}
greatest = force(scene.sweep(angle, speed=30.0, held=batch)).max(axis=-1)
assert least < greatest.min() < 1.05 * least
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for label, x in (("without", middle), ("least squares", smooth.x), ("least greatest", best.x)):
    left.plot(np.degrees(angle), forces(x), label=label)
left.set(xlabel="crank [°]", ylabel="force on its bearing [N]")
left.legend()
drawn = right.contourf(*[1e3 * around] * 2, greatest.T, levels=20)
figure.colorbar(drawn, label="greatest force [N]")
right.plot(*[1e3 * value for value in review.values.values()], "r*", markersize=12)
right.set(xlabel="2 kg at x [mm]", ylabel="y [mm]", aspect="equal")
