"""
Toggle press
============

Two equal levers that are almost in line press with many times the force that pushes their knee.
With levers at the angle α to the line, the ram's force is F / (2 tan α), and the bars carry F /
(2 sin α): the sweep gives both, and what the frame has to hold.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

press = cd.load("""<robot name="toggle_press">
  <link name="frame"/> <link name="upper"/> <link name="lower"/> <link name="ram"/>
  <joint name="top" type="continuous"><parent link="frame"/><child link="upper"/>
    <origin xyz="0 0.8 0"/><axis xyz="0 0 1"/></joint>
  <joint name="knee" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.24 -0.32 0"/><axis xyz="0 0 1"/></joint>
  <joint name="guide" type="prismatic"><parent link="frame"/><child link="ram"/>
    <origin xyz="0 0.16 0"/><axis xyz="0 -1 0"/>
    <limit lower="-0.2" upper="0.2" effort="1e6" velocity="1"/></joint>
  <loop name="foot" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="lower"><origin xyz="-0.24 -0.32 0"/></predecessor>
    <successor link="ram"/></loop>
</robot>""")
start = np.arctan2(0.24, 0.32)
slant = np.radians(np.linspace(25.0, 1.0, 200))  # of the levers to the vertical
push = 2000.0  # N, on the knee
turn = cd.Scene(press, drive="guide", loads={"lower": cd.Wrench((-push, 0, 0), frame="world")})
turn = turn.sweep(0.8 * (np.cos(slant) - np.cos(start)))

# What the drive of the ram holds is the force of the press.
force = -turn.drive_effort
np.testing.assert_allclose(force, push / (2.0 * np.tan(slant)), rtol=1e-11)
np.testing.assert_allclose(turn["top"].shear, push / (2.0 * np.sin(slant)), rtol=1e-11)
assert 28.0 < force[-1] / push < 29.0

figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
axes.semilogy(np.degrees(slant), force / push, label="ram")
axes.semilogy(np.degrees(slant), turn["top"].shear / push, "--", label="lever")
axes.set(xlabel="slant of the levers [°]", ylabel="force / force on the knee", title="Toggle press")
axes.grid(which="both", alpha=0.3)
axes.legend()
