"""
Four-bar and coupler curve
==========================

Where does a point of a link go? ``sweep.point(link, xyz)`` says, with its velocity and
acceleration. The linkage is Hoecken's: its proportions of 1 : 2 : 2.5 : 2.5 guide the far end of
the coupler almost along a straight line during half a turn. The curve is checked against the
intersection of two circles.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

height = np.sqrt(0.25**2 - 0.05**2)  # the crank lies along x at zero: the pin C is above 0.15 m
bar = cd.load(f"""<robot name="hoecken">
  <link name="frame"/> <link name="crank"/> <link name="coupler"/> <link name="rocker"/>
  <joint name="A" type="continuous"><parent link="frame"/><child link="crank"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="D" type="continuous"><parent link="frame"/><child link="rocker"/>
    <origin xyz="0.2 0 0"/><axis xyz="0 0 1"/></joint>
  <loop name="C" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="coupler"><origin xyz="0.05 {height} 0"/></predecessor>
    <successor link="rocker"><origin xyz="-0.05 {height} 0"/></successor></loop>
</robot>""")
angle = np.linspace(0.0, 2.0 * np.pi, 721)
turn = cd.Scene(bar, drive="A").sweep(angle)
tip = turn.point("coupler", (0.1, 2.0 * height, 0.0)).position

# The same by the geometry of circles: C at 250 mm from B and D, the tip twice as far from B.
pin = 0.1 * np.exp(1j * angle)
across = 0.2 - pin
up = 1j * across / np.abs(across) * np.sqrt(0.25**2 - np.abs(across) ** 2 / 4.0)
by_hand = pin + 2.0 * (across / 2.0 + up)
np.testing.assert_allclose(tip[:, 0] + 1j * tip[:, 1], by_hand, atol=1e-14)
# Half a turn is straight within a quarter of a percent of the travel, four cranks.
half = np.abs(angle - np.pi) <= np.pi / 2.0
line = tip[half, 1]
np.testing.assert_allclose(np.ptp(tip[half, 0]), 0.4, rtol=1e-12)
assert np.ptp(line) < 0.0025 * 0.4

figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
axes.plot(tip[:, 0], tip[:, 1], color="0.6", label="path of the coupler's end")
axes.plot(tip[half, 0], line, color="C3", linewidth=2.5, label="half a turn of the crank")
places = [turn.origin(name)[180, :2] for name in ("A", "B", "C", "D")]
axes.plot(*np.array(places).T, "o-", color="C0", label="linkage at 90°")
axes.plot(*np.array([places[2], tip[180, :2]]).T, "--", color="C0")
axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="Hoecken's linkage")
axes.legend(loc="lower right", fontsize=8)
