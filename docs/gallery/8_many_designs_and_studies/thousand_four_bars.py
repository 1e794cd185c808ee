"""
A thousand four-bars
====================

Which crank-rocker transmits best? Lengths that are adjustable joints are held at as many values
as one likes, and all designs are swept in one call. The transmission angle, between coupler and
rocker, shows where a design would bind; its extremes are known in closed form.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

length = 'type="fixed" adjustable="prismatic"'
reach = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
# Crank 60 mm, base 200 mm, coupler and rocker adjustable about 180 and 150 mm.
along = (0.14**2 + 0.18**2 - 0.15**2) / (2.0 * 0.14)  # of C from B, the crank lying on the base
up = np.sqrt(0.18**2 - along**2)
first, second = np.arctan2(up, along), np.arctan2(up, along - 0.14)
bars = cd.load(f"""<robot name="bars"><link name="frame"/><link name="crank"/><link name="coupler"/>
  <link name="coupler_end"/><link name="rocker"/><link name="rocker_end"/>
  <joint name="A" type="continuous"><parent link="frame"/><child link="crank"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0.06 0 0" rpy="0 0 {first}"/><axis xyz="0 0 1"/></joint>
  <joint name="longer_coupler" {length}><parent link="coupler"/><child link="coupler_end"/>
    <origin xyz="0.18 0 0"/><axis xyz="1 0 0"/>{reach}</joint>
  <joint name="D" type="continuous"><parent link="frame"/><child link="rocker"/>
    <origin xyz="0.2 0 0" rpy="0 0 {second}"/><axis xyz="0 0 1"/></joint>
  <joint name="longer_rocker" {length}><parent link="rocker"/><child link="rocker_end"/>
    <origin xyz="0.15 0 0"/><axis xyz="1 0 0"/>{reach}</joint>
  <loop name="C" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="coupler_end"/><successor link="rocker_end"/></loop></robot>""")
coupler, rocker = (
    np.linspace(-0.045, 0.035, 32)[:, None, None],
    np.linspace(-0.02, 0.05, 32)[:, None],
)
held = {"longer_coupler": 0.0, "longer_rocker": 0.0}
scene = cd.Scene(bars, drive="A", held=held, loads={"D": -1.0})
angle = np.linspace(0.0, 2.0 * np.pi, 25)
turn = scene.sweep(angle, held={"longer_coupler": coupler, "longer_rocker": rocker})
# Angle between coupler and rocker, from the turns of their joints.
position = turn.motion.position
between = second + position("D") - first - angle - position("B")
least = np.abs(np.sin(between)).min(axis=-1)  # (32, 32)

# At the crank's dead points with the base: law of cosines for 140 and 260 mm.
b, c = 0.18 + coupler[..., 0], 0.15 + rocker[:, 0]
cosines = [(b**2 + c**2 - d**2) / (2.0 * b * c) for d in (0.14, 0.26)]
expected = np.sqrt(1.0 - np.maximum(*np.abs(cosines)) ** 2)
np.testing.assert_allclose(least, expected, atol=1e-12)

# The best design has both extremes alike, b² + c² = 0.0436 m², and b = c: cos μ = 0.012 / b².
best = np.unravel_index(np.argmax(least), least.shape)
assert abs(np.arcsin(least[best]) - np.arccos(0.012 / 0.0218)) < np.radians(1.5)

figure, axes = plt.subplots(figsize=(5.8, 4.4), layout="constrained")
drawn = axes.contourf(1e3 * c, 1e3 * b[:, 0], np.degrees(np.arcsin(least)), levels=12)
figure.colorbar(drawn, label="least transmission angle [°]")
axes.plot(1e3 * c[best[1]], 1e3 * b[best[0], 0], "r*", markersize=14)
axes.set(
    xlabel="rocker [mm]", ylabel="coupler [mm]", title="Crank 60 mm, base 200 mm: 1024 designs"
)
