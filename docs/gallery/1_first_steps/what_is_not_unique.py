"""
An indeterminate four-bar made determinate
==========================================

Four parallel hinges are held more often than they need to be: no law of motion says how they
share moments about axes in the plane. The package marks what is open instead of returning a
choice in silence. With a ball and a cylindrical joint in the coupler all is determined, and can
be checked by hand.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

bar = cd.load("four_bar")
weight = {"coupler": cd.Wrench((0.0, 0.0, -50.0), frame="world")}  # N, across the plane
angle = np.linspace(0.0, 2.0 * np.pi, 361)
turn = cd.Scene(bar, drive="crank_bearing", loads=weight).sweep(angle)
assert turn["rocker_pin"].unique.tolist() == [True, True, False, False, False, True]
try:
    cd.Scene(bar, drive="crank_bearing", loads=weight, strict=True).sweep(angle)
except cd.IndeterminateError as error:
    print(error)
else:
    raise AssertionError("a strict scene refuses to choose")

text = bar.to_urdf()
text = text.replace('"rocker_pin" type="continuous"', '"rocker_pin" type="spherical"')
text = text.replace('"crank_pin" type="continuous"', '"crank_pin" type="cylindrical"')
free = cd.Scene(cd.load(text), drive="crank_bearing", loads=weight).sweep(angle)
assert all(free[name].unique.all() for name in free.outputs)
# A cylindrical joint takes no force along its axis: the ball carries all 50 N, and the rocker
# with it.
force = free.wrench("rocker_pin", "world").force[:, 2]
np.testing.assert_allclose(np.abs(force), 50.0, rtol=1e-12)
support = free.wrench("rocker_bearing", "world")
np.testing.assert_allclose(support.force[:, 2], 50.0, rtol=1e-12)
arm = free.origin("rocker_pin") - free.origin("rocker_bearing")
np.testing.assert_allclose(support.bending, 50.0 * np.hypot(arm[:, 0], arm[:, 1]), rtol=1e-12)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
for result, label in ((turn, "four hinges: least norm, a choice"), (free, "determinate")):
    moment = result.wrench("rocker_bearing", "world").moment[:, 0]
    axes.plot(np.degrees(angle), moment, label=label)
axes.set(xlabel="crank [°]", ylabel="moment x at the rocker's bearing [N·m]")
axes.set_title("50 N across the plane")
axes.legend()
