"""
A wedge that locks itself
=========================

A wedge lifts a load along an incline, with dry friction on its face. Pushed in, it needs W tan α
+ F / cos α, and pushed back W tan α - F / cos α: where that is negative, the load does not come
down by itself. Friction here is a force of given size along a slide, as a brake is, or a bearing
that is preloaded.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

weight, grip = 1000.0, 180.0  # N
slide = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def wedge(alpha):
    return cd.load(f"""<robot name="wedge">
      <link name="ground"/><link name="wedge"/><link name="load"/>
      <joint name="push" type="prismatic"><parent link="ground"/><child link="wedge"/>
        <axis xyz="1 0 0"/>{slide}</joint>
      <joint name="lift" type="prismatic"><parent link="ground"/><child link="load"/>
        <axis xyz="0 1 0"/>{slide}</joint>
      <loop name="face" type="prismatic"><predecessor link="wedge"/><successor link="load"/>
        <axis xyz="{-np.cos(alpha)} {np.sin(alpha)} 0"/></loop></robot>""")


slopes = np.radians(np.linspace(3.0, 30.0, 28))
needed = []
for alpha in slopes:
    friction = cd.JointFriction("face", effort=grip, transition=1e-9)
    scene = cd.Scene(wedge(alpha), drive="push", loads={"lift": -weight}, elements=[friction])
    turn = scene.sweep(0.0, speed=[0.1, -0.1])
    needed.append(turn.drive_effort)
    np.testing.assert_allclose(turn.motion.ratio("lift"), np.tan(alpha), rtol=1e-12)
needed = np.array(needed)

# Virtual work: a step s of the wedge lifts by s tan α, and slides by s / cos α on the face.
for column, sign in ((0, 1.0), (1, -1.0)):
    expected = weight * np.tan(slopes) + sign * grip / np.cos(slopes)
    np.testing.assert_allclose(needed[:, column], expected, rtol=1e-9)
# It locks where W sin α is less than the friction.
locked = slopes[needed[:, 1] < 0.0].max()
assert locked < np.arcsin(grip / weight) < locked + np.radians(1.0)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
axes.plot(np.degrees(slopes), needed[:, 0], label="pushed in")
axes.plot(np.degrees(slopes), needed[:, 1], label="coming back")
axes.axhline(0.0, color="0.7")
axes.axvspan(3.0, np.degrees(np.arcsin(grip / weight)), color="C2", alpha=0.2, label="locks itself")
axes.set(xlabel="slope of the wedge [°]", ylabel="force [N]", title="A wedge under 1000 N")
axes.legend()
