"""
The same four-bar in URDF+, MJCF and SDF
========================================

Files of other simulators are read as well: MuJoCo closes loops by ``connect``, and in SDF a link
may have two parents. One four-bar in three notations has the same forces in its pins.
``cd.write`` writes what was read.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

urdf = """<robot name="bars"><link name="base"/><link name="crank"/><link name="rocker">
    <inertial><origin xyz="0 0.15 0"/><mass value="3"/>
    <inertia ixx="0.02" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="coupler"/>
  <joint name="a" type="continuous"><parent link="base"/><child link="crank"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0 0.1 0"/><axis xyz="0 0 1"/></joint>
  <joint name="d" type="continuous"><parent link="base"/><child link="rocker"/>
    <origin xyz="0.4 0 0"/><axis xyz="0 0 1"/></joint>
  <loop name="c" type="continuous"><axis xyz="0 0 1"/>
    <predecessor link="coupler"><origin xyz="0.4 0.2 0"/></predecessor>
    <successor link="rocker"><origin xyz="0 0.3 0"/></successor></loop></robot>"""
mjcf = """<mujoco model="bars"><compiler angle="radian"/><option gravity="0 0 0"/><worldbody>
    <body name="crank"><joint name="a" axis="0 0 1"/><inertial pos="0 0 0" mass="1e-9"
        diaginertia="1e-12 1e-12 1e-12"/>
      <body name="coupler" pos="0 0.1 0"><joint name="b" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/></body></body>
    <body name="rocker" pos="0.4 0 0"><joint name="d" axis="0 0 1"/>
      <inertial pos="0 0.15 0" mass="3" diaginertia="0.02 0.01 0.02"/></body></worldbody>
  <equality><connect name="c" body1="coupler" body2="rocker" anchor="0.4 0.2 0"/></equality>
</mujoco>"""
hinge = """<joint name="{}" type="revolute"><parent>{}</parent><child>{}</child>
    <pose>{}</pose><axis><xyz>0 0 1</xyz></axis></joint>"""
# A link of SDF without <inertial> has a mass of 1 kg.
light = """<inertial><mass>1e-9</mass><inertia><ixx>1e-12</ixx><iyy>1e-12</iyy><izz>1e-12</izz>
    <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"""
sdf = f"""<sdf version="1.9"><model name="bars"><link name="crank">{light}</link>
  <link name="coupler"><pose>0 0.1 0 0 0 0</pose>{light}</link>
  <link name="rocker"><pose>0.4 0 0 0 0 0</pose><inertial><pose>0 0.15 0 0 0 0</pose><mass>3</mass>
    <inertia><ixx>0.02</ixx><iyy>0.01</iyy><izz>0.02</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>
  </inertial></link>
  {hinge.format("a", "world", "crank", "0 0 0 0 0 0")}
  {hinge.format("b", "crank", "coupler", "0 0 0 0 0 0")}
  {hinge.format("d", "world", "rocker", "0 0 0 0 0 0")}
  {hinge.format("c", "coupler", "rocker", "0 0.3 0 0 0 0")}</model></sdf>"""

angle = np.linspace(0.0, 2.0 * np.pi, 361)
turns = {}
for text in (urdf, mjcf, sdf):
    mechanism = cd.load(text)
    print(mechanism.notation)
    scene = cd.Scene(mechanism, drive="a", loads={"d": -5.0})
    turns[mechanism.notation] = scene.sweep(angle, speed=20.0)
first, *others = turns.values()
for name in "abcd":
    force = first.wrench(name, "world").force[:, :2]
    for other in others:
        np.testing.assert_allclose(
            other.wrench(name, "world").force[:, :2], force, atol=1e-6 * np.abs(force).max()
        )
# The rocker: its inertia about its bearing is 0.02 + 3 · 0.15² kg·m², and the rod pulls at 300 mm.
place, rate = first.motion.position("d"), first.motion.acceleration("d")
arm = 0.3 * np.stack([-np.sin(place), np.cos(place)], axis=1)
pull = first.wrench("c", "world").force[:, :2]  # of the coupler on the rocker
moment = arm[:, 0] * pull[:, 1] - arm[:, 1] * pull[:, 0]
np.testing.assert_allclose(moment, (0.02 + 3.0 * 0.15**2) * rate + 5.0, rtol=1e-9)

with tempfile.TemporaryDirectory() as folder:
    path = cd.write(cd.load(sdf), Path(folder) / "bars.urdf")
    assert cd.load(path).notation == "URDF+ <loop>"

figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
for (notation, turn), style in zip(turns.items(), ("-", "--", ":"), strict=True):
    axes.plot(np.degrees(angle), turn.drive_effort, style, label=notation)
axes.set(xlabel="crank [°]", ylabel="torque of the crank [N·m]", title="One four-bar, three files")
axes.legend()
