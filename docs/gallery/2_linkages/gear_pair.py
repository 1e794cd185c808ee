"""
A pair of gears
===============

A ``<mimic>`` makes a joint follow another, as gears, chains and belts do. Torques follow by the
ratio, with what the wheels' inertia takes: J₁ + i² J₂ as seen from the drive. With a crank on the
second wheel, gears and a linkage are one mechanism; its drive torque is the ratio times that of
the linkage alone. ``forces="mesh"`` says that it is teeth that couple both: they press the shafts
apart, at pitch radii that follow from the ratio and the distance of the axes.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

ratio = -0.5  # 20 teeth drive 40
engine = cd.load("slider_crank").to_urdf()
pinion = """<link name="pinion"><inertial><mass value="1"/>
    <inertia ixx="0.002" iyy="0.002" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="motor" type="continuous"><parent link="base"/><child link="pinion"/>
    <origin xyz="0 -0.12 0"/><axis xyz="0 0 1"/></joint>
"""
follows = f'<mimic joint="motor" multiplier="{ratio}" forces="mesh"/>'
start = engine.index('<joint name="crank_bearing"')
end = engine.index("</joint>", start)
geared = cd.load(engine[:start] + pinion + engine[start:end] + follows + engine[end:])

angle = np.linspace(0.0, 4.0 * np.pi, 721)
loads = {"piston_guide": -500.0}
turn = cd.Scene(geared, drive="motor", loads=loads).sweep(angle, speed=300.0, acceleration=50.0)
alone = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads=loads)
alone = alone.sweep(ratio * angle, speed=ratio * 300.0, acceleration=ratio * 50.0)

np.testing.assert_allclose(turn.motion.position("crank_bearing"), ratio * angle, atol=1e-13)
needed = ratio * alone.drive_effort + 0.004 * 50.0
np.testing.assert_allclose(turn.drive_effort, needed, atol=1e-11 * np.abs(needed).max())
# The teeth pass on what the crank needs.
(passed,) = turn.coupling_moment.values()
np.testing.assert_allclose(np.abs(passed), np.abs(alone.drive_effort), atol=1e-9)

# Teeth at 20° press on the motor's bearing: by the torque over 0.04 m, and apart by its tangent.
pressed = np.abs(turn.drive_effort - 0.004 * 50.0) / 0.04 / np.cos(np.radians(20.0))
np.testing.assert_allclose(turn["motor"].shear, pressed, atol=1e-9 * pressed.max())

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(np.degrees(angle), turn.drive_effort, label="motor")
axes.plot(np.degrees(angle), alone.drive_effort, "--", label="crank")
axes.set(
    xlabel="motor [°]", ylabel="torque [N·m]", title="Compressor behind gears of 20 and 40 teeth"
)
axes.legend()
