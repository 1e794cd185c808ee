"""
Excavator arm
=============

Cylinders hold boom and stick: loops of two pins with a slide between them. The boom's cylinder is
driven through its stroke while the stick's keeps its length; what it has to push is the moment of
all that hangs on the boom's pin, divided by the lever arm of the cylinder.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd


def body(name, mass, x, y):
    return f"""<link name="{name}"><inertial><origin xyz="{x} {y} 0"/><mass value="{mass}"/>
      <inertia ixx="{mass}" iyy="{mass}" izz="{mass}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


def hinge(name, parent, child, x, y):
    return f"""<joint name="{name}" type="continuous">
      <parent link="{parent}"/><child link="{child}"/>
      <origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/></joint>"""


def cylinder(name, parent, foot, child, head, reach):
    """Return a cylinder between points of two links, which reaches so far (x, y) at zero."""
    length, slope = np.hypot(*reach), np.arctan2(reach[1], reach[0])
    return f"""<link name="{name}_tube"/><link name="{name}_rod"/>
      <joint name="{name}_foot" type="continuous">
        <parent link="{parent}"/><child link="{name}_tube"/>
        <origin xyz="{foot[0]} {foot[1]} 0" rpy="0 0 {slope}"/><axis xyz="0 0 1"/></joint>
      <joint name="{name}" type="prismatic"><parent link="{name}_tube"/><child link="{name}_rod"/>
        <origin xyz="{length} 0 0"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" effort="1e6" velocity="1"/></joint>
      <loop name="{name}_head" type="continuous"><axis xyz="0 0 1"/>
        <predecessor link="{name}_rod"/><successor link="{child}">
        <origin xyz="{head[0]} {head[1]} 0"/></successor></loop>"""


arm = cd.load(
    '<robot name="excavator"><link name="cab"/>'
    + body("boom", 1500.0, 2.6, 0.5)
    + body("stick", 700.0, 1.2, -0.2)
    + body("bucket", 1800.0, 0.6, -0.4)  # with its load
    + hinge("boom_pin", "cab", "boom", 0.0, 1.5)
    + hinge("stick_pin", "boom", "stick", 5.5, 0.0)
    + hinge("bucket_pin", "stick", "bucket", 2.5, 0.0)
    + cylinder("lift", "cab", (0.5, 0.9), "boom", (2.4, 0.6), (1.9, 1.2))
    + cylinder("crowd", "boom", (2.8, 1.0), "stick", (-0.8, 0.5), (1.9, -0.5))
    + "</robot>"
)
scene = cd.Scene(
    arm,
    drive="lift",
    held={"crowd": 0.35, "bucket_pin": -0.6},
    gravity=(0.0, -9.81, 0.0),
)
stroke = np.linspace(-0.35, 0.55, 181)
swing = scene.sweep(stroke)

# Moments about the boom's pin: weights times their distances, thrust times its lever arm.
pin = swing.origin("boom_pin")[:, :2]
moment = np.zeros(len(stroke))
for link in arm.description.links:
    centre = swing.point(link.name, link.centre).position[:, :2]
    moment += 9.81 * link.mass * (centre - pin)[:, 0]
foot, head = swing.origin("lift_foot")[:, :2] - pin, swing.origin("lift_head")[:, :2] - pin
along = (head - foot) / np.linalg.norm(head - foot, axis=1, keepdims=True)
lever = foot[:, 0] * along[:, 1] - foot[:, 1] * along[:, 0]
np.testing.assert_allclose(swing.drive_effort, moment / lever, rtol=1e-11)
np.testing.assert_allclose(np.linalg.norm(head - foot, axis=1), np.hypot(1.9, 1.2) + stroke)

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.0), layout="constrained")
for sample in (0, 90, 180):
    places = {name: swing.origin(name)[sample, :2] for name in arm.joint_names}
    for line in (
        ("boom_pin", "lift_head", "stick_pin", "boom_pin"),
        ("stick_pin", "crowd_head", "bucket_pin", "stick_pin"),
    ):
        left.plot(*np.array([places[name] for name in line]).T, color="0.4")
    for name in ("lift", "crowd"):
        ends = np.array([places[f"{name}_foot"], places[f"{name}_head"]])
        left.plot(*ends.T, color="C3", linewidth=3)
left.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Lowest, middle, highest")
right.plot(stroke, swing.drive_effort / 1e3, label="thrust of the lift cylinder")
right.plot(stroke, swing["boom_pin"].shear / 1e3, label="boom pin")
right.plot(stroke, np.abs(swing.holding_effort["crowd"]) / 1e3, label="crowd cylinder")
right.set(xlabel="stroke [m]", ylabel="force [kN]")
right.legend()
