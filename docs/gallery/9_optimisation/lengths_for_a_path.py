"""
Lengths for a path: straight, and evenly
========================================

Six lengths of a four-bar decide which path a point of its coupler takes. The finger of a feeder is
to push parts evenly along a straight line while the crank makes half a turn, and to come back below
it. Least squares on how far the finger is from there, with exact gradients, takes some forty sweeps
from each of several starts. Designs whose loop does not close are met on the way: to SciPy they
are infinitely bad, so that it tries a shorter step. Nor does a crank that turns through
(Grashof's condition) need a constraint: one that does not cannot be driven.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import Bounds, least_squares

import cardan_dyn as cd


def hinge(name, parent, child, x, y=0.0, yaw=0.0):
    return f"""<joint name="{name}" type="continuous"><parent link="{parent}"/>
      <child link="{child}"/><origin xyz="{x} {y} 0" rpy="0 0 {yaw}"/><axis xyz="0 0 1"/></joint>"""


# Chebyshev's lambda, with a crank of 100 mm, coarsely drawn.
lean = np.arccos(0.2)
feeder = cd.load(f"""<robot name="feeder">
  <link name="base"/><link name="crank"/><link name="coupler"/>
  <link name="rocker"/><link name="finger"/>
  {hinge("motor", "base", "crank", 0.0)}{hinge("crank_pin", "crank", "coupler", 0.1, yaw=-lean)}
  {hinge("bearing", "base", "rocker", 0.2, yaw=lean - np.pi)}
  <joint name="arm" type="fixed"><parent link="coupler"/><child link="finger"/>
    <origin xyz="0.45 0.05 0"/></joint>
  <loop name="pin" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="coupler"><origin xyz="0.25 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="0.25 0 0"/></successor></loop></robot>""")
lengths = {
    "origin:crank_pin.x": ("-50 mm", "50 mm"),
    "origin:bearing.x": ("-80 mm", "80 mm"),
    "origin:pin.predecessor.x": ("-80 mm", "80 mm"),
    "origin:pin.successor.x": ("-80 mm", "80 mm"),
    "origin:arm.x": ("-150 mm", "150 mm"),
    "origin:arm.y": ("-150 mm", "150 mm"),
}
scene = cd.Scene(feeder, drive="motor", held=dict.fromkeys(lengths, 0.0), outputs=["pin"])
pushing = np.linspace(0.55 * np.pi, 1.45 * np.pi, 37)
wanted = np.stack([0.2 - 0.4 * (1.0 - pushing / np.pi), 0.0 * pushing - 0.4], axis=-1)
variables = cd.DesignVariables(lambda values: scene.sweep(pushing, held=values), lengths)
miss = variables.quantity(
    lambda sweep: (sweep.point("finger").position[:, :2] - wanted).ravel(),
    lambda sweep, by: by.point("finger")[:, :2].ravel(),
)
bounds, runs = Bounds(*variables.bounds), []
for start in variables.starts(2, seed=0):
    runs.append(least_squares(miss, start, jac=miss.jac, bounds=bounds))
    print(f"{runs[-1].nfev} designs, {1e3 * np.abs(runs[-1].fun).max():.3g} mm off")
best = min(runs, key=lambda run: run.cost)
review = variables.review(best)
print(review)
assert review.optimality < 1e-6


def closed_form(values):
    """Return where the finger is in the plane, by the intersection of two circles."""
    crank, base, coupler, rocker, x, y = np.add(sizes, [*values.values()])
    pin = crank * np.exp(1j * pushing)
    line = base - pin
    angle = np.arccos((coupler**2 + abs(line) ** 2 - rocker**2) / (2.0 * coupler * abs(line)))
    return pin + (x + 1j * y) * line / abs(line) * np.exp(-1j * angle)


sizes = [0.1, 0.2, 0.25, 0.25, 0.45, 0.05]
found = scene.sweep(pushing, held=review.values).point("finger").position
np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], closed_form(review.values), atol=1e-13)

turn = np.linspace(0.0, 2.0 * np.pi, 145)
figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for label, values in (("drawn", dict.fromkeys(lengths, 0.0)), ("found", review.values)):
    x, y = 1e3 * scene.sweep(turn, held=values).point("finger").position[:, :2].T
    axes.plot(x, y, label=label)
axes.plot(*1e3 * wanted.T, "k.", markersize=4, label="wanted")
axes.set(xlabel="finger [mm]", ylabel="[mm]", aspect="equal", title="A feeder's four-bar")
axes.legend()
