"""
A constant-velocity joint
=========================

Clemens's coupling of 1869: an arm on each shaft, and a ball where they meet. Both halves are
mirror images, so that the ball stays in the plane that halves the angle between the shafts, which
turn alike at any angle. That is the principle of every constant-velocity joint since.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

bend = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
coupling = cd.load(f"""<robot name="clemens">
  <link name="frame"/> <link name="housing"/> <link name="shaft_in"/> <link name="shaft_out"/>
  <link name="arm_in"/> <link name="arm_out"/>
  <joint name="bearing_in" type="continuous"><parent link="frame"/><child link="shaft_in"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="bend" type="revolute"><parent link="frame"/><child link="housing"/>
    <axis xyz="0 0 1"/>{bend}</joint>
  <joint name="bearing_out" type="continuous"><parent link="housing"/><child link="shaft_out"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="pin_in" type="continuous"><parent link="shaft_in"/><child link="arm_in"/>
    <origin xyz="-0.09 0.03 0"/><axis xyz="0 0 1"/></joint>
  <joint name="pin_out" type="continuous"><parent link="shaft_out"/><child link="arm_out"/>
    <origin xyz="0.09 0.03 0"/><axis xyz="0 0 1"/></joint>
  <loop name="ball" type="spherical">
    <predecessor link="arm_in"><origin xyz="0.09 0.05 0"/></predecessor>
    <successor link="arm_out"><origin xyz="-0.09 0.05 0"/></successor></loop>
</robot>""")
angle = np.linspace(0.0, 2.0 * np.pi, 361)
figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
for degrees in (15.0, 30.0, 45.0):
    beta = np.radians(degrees)
    scene = cd.Scene(
        coupling, drive="bearing_in", held={"bend": beta}, loads={"bearing_out": -50.0}
    )
    turn = scene.sweep(angle)
    np.testing.assert_allclose(turn.motion.ratio("bearing_out"), 1.0, rtol=1e-12)
    np.testing.assert_allclose(turn.drive_effort, 50.0, rtol=1e-12)
    # The ball stays in the plane that halves the angle: normal to both shafts' mean direction.
    ball = turn.origin("ball")
    halving = np.array([np.cos(beta / 2.0), np.sin(beta / 2.0), 0.0])
    np.testing.assert_allclose(ball @ halving, 0.0, atol=1e-14)
    # The arms keep their length of √(90² + 50²) mm.
    length = np.linalg.norm(ball - turn.origin("pin_in"), axis=1)
    np.testing.assert_allclose(length, np.hypot(0.09, 0.05), rtol=1e-12)
    force = np.linalg.norm(turn["ball"].force, axis=1)
    axes.plot(np.degrees(angle), force, label=f"{degrees:.0f}°")
axes.set(xlabel="input shaft [°]", ylabel="force in the ball [N]")
axes.set_title("Clemens's coupling, 50 N·m: even motion, uneven force")
axes.legend()
