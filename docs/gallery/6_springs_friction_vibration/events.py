"""
Events: a hammer that is caught
===============================

A hammer falls from the upright and is to be stopped where it passes the horizontal. Events are
located where a function of time, positions and speeds passes through zero; a terminal one ends
the simulation there. Time and speed are held against the integral of the equation of energy.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import quad

import cardan_dyn as cd

hammer = cd.load("""<robot name="hammer"><link name="frame"/>
  <link name="hammer"><inertial><origin xyz="0 0 0.4"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="pin" type="continuous"><parent link="frame"/><child link="hammer"/>
    <axis xyz="0 1 0"/></joint></robot>""")
start = np.radians(5.0)
passed = cd.Event(lambda t, x, v: x["pin"] - np.pi / 4.0, name="45°")
caught = cd.Event(lambda t, x, v: x["pin"] - np.pi / 2.0, terminal=True, name="horizontal")
scene = cd.Scene(hammer, free="pin", gravity=(0.0, 0.0, -9.81))
fall = scene.simulate(5.0, position=start, events=[passed, caught])
print(fall.events)
assert [event.name for event in fall.events] == ["45°", "horizontal"]

# ½ J ω² = m g l (cos start - cos angle), and time is the integral of 1 / ω.
inertia, moment = 0.02 + 3.0 * 0.4**2, 3.0 * 9.81 * 0.4
speed = np.sqrt(2.0 * moment * np.cos(start) / inertia)
np.testing.assert_allclose(fall.at(fall.events[1].time).speed, speed, rtol=1e-10)


def integrand(root):
    """Return dt/d(root) with angle = start + root², which takes the singularity away."""
    angle = start + root**2
    fallen = 2.0 * np.sin((angle + start) / 2.0) * np.sin(root**2 / 2.0)
    return 2.0 * root / np.sqrt(2.0 * moment * fallen / inertia)


for event, end in zip(fall.events, (np.pi / 4.0, np.pi / 2.0), strict=True):
    time = quad(integrand, 1e-9, np.sqrt(end - start), epsabs=1e-12)[0]
    np.testing.assert_allclose(event.time, time, atol=1e-8)

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
shown = fall.evenly(301)
axes.plot(shown.time, np.degrees(shown.position))
for event in fall.events:
    place = np.degrees(fall.at(event.time).position.item())
    axes.plot(event.time, place, "o")
    axes.annotate(event.name, (event.time, place), xytext=(-48, -4), textcoords="offset points")
axes.set(xlabel="time [s]", ylabel="angle from the upright [°]", title="A falling hammer")
