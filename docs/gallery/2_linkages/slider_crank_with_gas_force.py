"""
Slider-crank with gas force and inertia
=======================================

A compressor's crank at 1500 rpm against the gas in its cylinder. With the rod replaced by two
masses at its ends, as textbooks do, and the rest of its moment of inertia, the torque on the
crank is gas and inertia of the piston times its transfer function, and a couple of the rod. Here
this is exact.
"""

import numpy as np

import cardan_dyn as cd

crank, rod, speed, area = 0.045, 0.15, 50.0 * np.pi, np.pi * 0.043**2
angle = np.linspace(0.0, 2.0 * np.pi, 721)

# Slope of the rod and place of the piston, and their derivatives over the crank's angle.
slope = np.arcsin(crank / rod * np.sin(angle))
slope_1 = crank * np.cos(angle) / (rod * np.cos(slope))
slope_2 = (-crank * np.sin(angle) + rod * slope_1**2 * np.sin(slope)) / (rod * np.cos(slope))
place = crank * np.cos(angle) + rod * np.cos(slope)
place_1 = -crank * np.sin(angle) - rod * slope_1 * np.sin(slope)
place_2 = -crank * np.cos(angle) - rod * (slope_2 * np.sin(slope) + slope_1**2 * np.cos(slope))

# Gas between 1 and 6 bar, polytropic with 1.3, clearance volume 5 % of the stroke of 90 mm.
height = crank + rod - place + 0.0045
expansion, compression = 6e5 * (0.0045 / height) ** 1.3, 1e5 * (0.0945 / height) ** 1.3
pressure = np.where(angle < np.pi, np.maximum(expansion, 1e5), np.minimum(compression, 6e5))
gas = -(pressure - 1e5) * area

engine = cd.load("slider_crank")
scene = cd.Scene(engine, drive="crank_bearing", loads={"piston_guide": gas})
turn = scene.sweep(angle, speed=speed)

links = {link.name: link for link in engine.description.links}
share = links["rod"].centre[0] / rod  # of the rod's mass at the piston
moving = links["piston"].mass + share * links["rod"].mass
rest = links["rod"].inertia[2, 2] - links["rod"].mass * share * (1.0 - share) * rod**2
torque = place_1 * (moving * speed**2 * place_2 - gas) + rest * speed**2 * slope_1 * slope_2
np.testing.assert_allclose(turn.drive_effort, torque, atol=1e-12 * np.abs(torque).max())
# Without inertia the rod's slope alone presses the piston against its cylinder.
light = scene.sweep(angle)
wall = light.wrench("piston_guide", "world").force[:, 1]
np.testing.assert_allclose(wall, -gas * np.tan(slope), atol=1e-9)

figure = turn.plot("crank_bearing", quantities=["torsion", "shear"], title="1500 rpm, 6 bar")
