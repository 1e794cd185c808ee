"""
Steering column with two joints
===============================

Between steering wheel and gear are two joints at angles that the car's body decides: 30° and 20°
here, in planes 40° apart. How the forks of the middle shaft are put decides how uneven steering
is. The best that any forks can do is a single joint of arccos (cos 30° / cos 20°), and a spline
finds the next tooth.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn.drive_lines as dl

# Directions of the three shafts, from the wheel forwards and down.
slant, second = np.radians(30.0), np.radians(20.0)
turned = np.radians(40.0)  # between the planes, about the middle shaft, which is x
first = np.array([-np.cos(slant), 0.0, np.sin(slant)])
last = np.array([np.cos(second), np.sin(second) * np.sin(turned), np.sin(second) * np.cos(turned)])
line = dl.DriveLine(
    name="steering",
    speed=2.0 * np.pi,
    torque=10.0,
    shafts=[
        dl.Shaft(
            start=tuple(0.5 * first),
            end=(0.0, 0.0, 0.0),
            bearings=[dl.Bearing(distance=0.1), dl.Bearing(distance=0.4)],
        ),
        dl.Shaft(end=(0.4, 0.0, 0.0), spline=dl.Spline()),
        dl.Shaft(
            end=tuple([0.4, 0.0, 0.0] + 0.3 * last),
            bearings=[dl.Bearing(distance=0.05), dl.Bearing(distance=0.2)],
        ),
    ],
)
np.testing.assert_allclose(np.degrees(line.joint_angles), [30.0, 20.0], rtol=1e-12)
best, on_teeth = line.phasing(), line.phasing(teeth=36)
limit = np.arccos(np.cos(slant) / np.cos(second))
np.testing.assert_allclose(best.value, limit, rtol=1e-9)
assert best.proven and on_teeth.proven and best.value <= on_teeth.value
# A single joint at that angle runs between cos β and 1 / cos β.
ratio = best.line.analyse(positions=np.radians(np.arange(0.0, 360.5, 0.5))).ratio[:, -1]
np.testing.assert_allclose(
    [ratio.min(), ratio.max()], [np.cos(limit), 1 / np.cos(limit)], rtol=1e-4
)
print(f"{np.degrees(best.given_value):.1f}° as drawn, {np.degrees(limit):.1f}° at best")

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
designs = {"forks in line": line, "36 teeth": on_teeth.line, "best": best.line}
for (name, design), style in zip(designs.items(), ("-", "-", "--"), strict=True):
    turn = design.analyse()
    axes.plot(np.degrees(turn.position), turn.ratio[:, -1], style, label=name)
axes.set(xlabel="steering wheel [°]", ylabel="speed ratio", title="Steering column")
axes.legend()
