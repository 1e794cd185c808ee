"""
Scissor lift
============

A table on two crossed arms, raised by a cylinder between the lower ends. The force that lifts a
weight W by a slide at the foot is W / tan α, however the load stands on the table; what the pins
carry does depend on it. Virtual work says the first, free bodies of the table the second.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

arm, start = 2.0, 0.5  # m, and rad at the description's zero
x, y = arm * np.cos(start), arm * np.sin(start)
slide = '<limit lower="-2" upper="2" effort="1e6" velocity="1"/>'
lift = cd.load(f"""<robot name="scissor_lift">
  <link name="frame"/> <link name="foot"/> <link name="rising"/> <link name="falling"/>
  <link name="table"/> <link name="shoe"/>
  <joint name="fixed_foot" type="continuous"><parent link="frame"/><child link="rising"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="cylinder" type="prismatic"><parent link="frame"/><child link="foot"/>
    <origin xyz="{x} 0 0"/><axis xyz="-1 0 0"/>{slide}</joint>
  <joint name="sliding_foot" type="continuous"><parent link="foot"/><child link="falling"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="table_pin" type="continuous"><parent link="falling"/><child link="table"/>
    <origin xyz="{-x} {y} 0"/><axis xyz="0 0 1"/></joint>
  <joint name="rail" type="prismatic"><parent link="table"/><child link="shoe"/>
    <origin xyz="{x} 0 0"/><axis xyz="1 0 0"/>{slide}</joint>
  <loop name="middle" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="rising"><origin xyz="{x / 2} {y / 2} 0"/></predecessor>
    <successor link="falling"><origin xyz="{-x / 2} {y / 2} 0"/></successor></loop>
  <loop name="shoe_pin" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="rising"><origin xyz="{x} {y} 0"/></predecessor>
    <successor link="shoe"/></loop>
</robot>""")
slope = np.radians(np.linspace(10.0, 65.0, 200))
weight, places = 8000.0, np.array([[0.2], [0.6], [1.0]])  # N, m from the table's pin
wrenches = np.zeros((3, 1, 6))
wrenches[:, :, 1], wrenches[:, :, 5] = -weight, -weight * places
scene = cd.Scene(lift, drive="cylinder")
rise = scene.sweep(x - arm * np.cos(slope), loads={"table": wrenches})

height = rise.point("table").position[..., 1]
np.testing.assert_allclose(height, arm * np.sin(slope) + 0.0 * places, rtol=1e-12)
np.testing.assert_allclose(rise.drive_effort, weight / np.tan(slope) + 0.0 * places, rtol=1e-11)
# The table is a beam on its pin and its shoe.
shoe = rise.wrench("rail", "world").force[..., 1]
np.testing.assert_allclose(-shoe, weight * places / (arm * np.cos(slope)), rtol=1e-10)

figure, axes = plt.subplots(figsize=(6.0, 4.2), layout="constrained")
axes.plot(height[0], rise.drive_effort[0] / 1e3, "k", label="cylinder")
for place, pin in zip(places[:, 0], rise["middle"].shear, strict=True):
    axes.plot(height[0], pin / 1e3, "--", label=f"middle pin, load at {place:.1f} m")
axes.set(xlabel="height of the table [m]", ylabel="force [kN]", title="Scissor lift, 8 kN")
axes.legend()
