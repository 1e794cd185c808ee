"""
Delta robot
===========

Clavel's delta robot carries its plate by three arms and three parallelograms of rods, so that it
never turns. The angles of the motors for a circle of the plate are computed by hand, and the
sweep has to bring the plate there; their torques are those of virtual work, by differences of
these angles.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

BASE, ARM, ROD, PLATE, DEPTH, HALF = 0.12, 0.2, 0.45, 0.05, 0.45, 0.04  # m
TURNS = np.radians([0.0, 120.0, 240.0])


def angles(place):
    """Return how far below the horizontal each arm hangs, with the plate at `(..., 3)`."""
    found = []
    for turned in TURNS:
        x = place[..., 0] * np.cos(turned) + place[..., 1] * np.sin(turned) + PLATE - BASE
        y = place[..., 1] * np.cos(turned) - place[..., 0] * np.sin(turned)
        z = place[..., 2]
        # The elbow is at (A cos q, -A sin q), and a rod's length away from the plate.
        right = (x**2 + y**2 + z**2 + ARM**2 - ROD**2) / (2.0 * ARM)
        found.append(np.arctan2(-z, x) - np.arccos(right / np.hypot(x, z)))
    return np.stack(found, axis=-1)


home = np.array([0.0, 0.0, -DEPTH])
text = '<link name="base"/><link name="plate"/>'
for index, (turned, down) in enumerate(zip(TURNS, angles(home), strict=True), start=1):
    c, s = np.cos(turned), np.sin(turned)
    elbow = ARM * np.cos(down), -ARM * np.sin(down)
    wrist = PLATE - BASE - elbow[0], -DEPTH - elbow[1]
    text += f"""<link name="arm_{index}"/>
      <joint name="motor_{index}" type="continuous"><parent link="base"/><child link="arm_{index}"/>
        <origin xyz="{BASE * c} {BASE * s} 0" rpy="0 0 {turned}"/><axis xyz="0 1 0"/></joint>"""
    for side, y in (("left", HALF), ("right", -HALF)):
        rod = f"rod_{index}_{side}"
        text += f"""<link name="{rod}"/>
          <joint name="elbow_{index}_{side}" type="universal">
            <parent link="arm_{index}"/><child link="{rod}"/>
            <origin xyz="{elbow[0]} {y} {elbow[1]}"/>
            <axis xyz="0 1 0"/><axis2 xyz="1 0 0"/></joint>"""
        # The plate hangs on the first rod, from which the places on it are counted.
        x = PLATE * c - y * s - PLATE
        end = f'<origin xyz="{wrist[0]} 0 {wrist[1]}"/>'
        if rod == "rod_1_left":
            text += f"""<joint name="wrist_{rod}" type="spherical">
              <parent link="{rod}"/><child link="plate"/>{end}</joint>"""
            continue
        text += f"""<loop name="wrist_{rod}" type="spherical">
          <predecessor link="{rod}">{end}</predecessor><successor link="plate">
          <origin xyz="{x} {PLATE * s + y * c - HALF} 0"/></successor></loop>"""
robot = cd.load(f'<robot name="delta">{text}</robot>')
motors = ["motor_1", "motor_2", "motor_3"]
arm = np.cross([-PLATE, -HALF, 0.0], [0.0, 0.0, -20.0])  # 20 N at the middle of the plate
load = {"plate": cd.Wrench((0.0, 0.0, -20.0), arm, frame="world")}
scene = cd.Scene(robot, drive=motors, loads=load)

turn = np.linspace(0.0, 2.0 * np.pi, 121)
circle = home + 0.12 * np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
moved = scene.sweep(angles(circle) - angles(home), along_path=True)
plate = moved.point("plate", (-PLATE, -HALF, 0.0))
np.testing.assert_allclose(plate.position, circle, atol=1e-12)
np.testing.assert_allclose(plate.orientation, np.broadcast_to(np.eye(3), (121, 3, 3)), atol=1e-12)
# Virtual work: the torques do what lifting 20 N takes, for a small step along x, y and z.
step = 1e-5 * np.eye(3)
slopes = np.stack([angles(circle + part) - angles(circle - part) for part in step], axis=1) / 2e-5
lifted = np.einsum("nij,nj->ni", slopes, moved.drive_effort)
np.testing.assert_allclose(lifted, np.tile([0.0, 0.0, 20.0], (121, 1)), atol=1e-6)

figure = plt.figure(figsize=(8.6, 4.0), layout="constrained")
left = figure.add_subplot(1, 2, 1, projection="3d")
for index in (1, 2, 3):
    for side in ("left", "right"):
        names = (f"motor_{index}", f"elbow_{index}_{side}", f"wrist_rod_{index}_{side}")
        left.plot(*np.array([moved.origin(name)[0] for name in names]).T, color=f"C{index - 1}")
left.plot(*circle.T, "k", linewidth=1)
left.set(box_aspect=(1, 1, 0.9))
right = figure.add_subplot(1, 2, 2)
right.plot(np.degrees(turn), moved.drive_effort, label=motors)
right.set(xlabel="place on the circle [°]", ylabel="torque of the motor [N·m]")
right.set_title("20 N on a circle of 240 mm")
right.legend()
