"""
Watt's and Peaucellier's straight lines
=======================================

Watt's linkage guides the middle of its link nearly along a straight line. Peaucellier's cell
(1864) does so exactly, since it inverts a circle that passes through the centre of inversion:
what is nearly straight is off by millimetres, and what is exactly so by 1e-15 m.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd


def planar(at, joints, loops):
    """Return a linkage that moves in the plane, its pins being `at` complex places [m] at zero."""
    where, text = {"frame": 0j}, '<link name="frame"/>'

    def origin(joint, link):
        place = at[joint] - where[link]
        return f'<origin xyz="{place.real} {place.imag} 0"/>'

    for joint, parent, child in joints:
        text += f'<link name="{child}"/><joint name="{joint}" type="continuous">'
        text += f'<parent link="{parent}"/><child link="{child}"/>{origin(joint, parent)}'
        text += '<axis xyz="0 0 1"/></joint>'
        where[child] = at[joint]
    for joint, one, other in loops:
        text += f'<loop name="{joint}" type="continuous"><axis xyz="0 0 1"/>'
        text += f'<predecessor link="{one}">{origin(joint, one)}</predecessor>'
        text += f'<successor link="{other}">{origin(joint, other)}</successor></loop>'
    return cd.load(f'<robot name="linkage">{text}</robot>')


watt = planar(
    {"A": 0j, "B": 0.5 + 0j, "C": 0.5 - 0.25j, "D": 1.0 - 0.25j},
    [("A", "frame", "left"), ("B", "left", "link"), ("D", "frame", "right")],
    [("C", "link", "right")],
)
swing = cd.Scene(watt, drive="A").sweep(np.radians(np.linspace(-18.0, 18.0, 181)))
middle = swing.point("link", (0.0, -0.125, 0.0)).position
# Watt's by circles: C is 250 mm from B, and 500 mm from D.
tip, end = 0.5 * np.exp(1j * swing.position), 1.0 - 0.25j
way = end - tip
along = (np.abs(way) ** 2 + 0.25**2 - 0.5**2) / (2.0 * np.abs(way))
pin = tip + way / np.abs(way) * (along - 1j * np.sqrt(0.25**2 - along**2))
np.testing.assert_allclose(middle[:, 0] + 1j * middle[:, 1], (tip + pin) / 2.0, atol=1e-14)

# Bars of 500 mm from O to T and S, a rhombus of 200 mm, P on a circle about Q through O.
along, across = np.sqrt(0.5**2 - 0.12**2), np.sqrt(0.2**2 - 0.12**2)
near, far = along - across, along + across
upper, lower = along + 0.12j, along - 0.12j
cell = planar(
    {"Q": near / 2 + 0j, "O1": 0j, "O2": 0j, "P1": near + 0j, "P2": near + 0j}
    | {"T1": upper, "T2": upper, "S1": lower, "S2": lower, "R": far + 0j},
    [
        ("Q", "frame", "crank"),
        ("O1", "frame", "bar_up"),
        ("O2", "frame", "bar_down"),
        ("P1", "crank", "near_up"),
        ("P2", "crank", "near_down"),
        ("T2", "bar_up", "far_up"),
        ("R", "far_up", "far_down"),
    ],
    [("T1", "near_up", "bar_up"), ("S1", "near_down", "bar_down"), ("S2", "far_down", "bar_down")],
)
turn = cd.Scene(cell, drive="Q").sweep(np.linspace(-0.75, 0.75, 181))
pen = turn.origin("R")
np.testing.assert_allclose(pen[:, 0], far, rtol=1e-13)
# Inversion: the distances of P and R from O have the product 0.5² - 0.2².
np.testing.assert_allclose(
    np.linalg.norm(turn.origin("P1"), axis=1) * np.linalg.norm(pen, axis=1), 0.21, rtol=1e-13
)
print(f"Watt {np.ptp(middle[:, 0]):.1e} m, Peaucellier {np.ptp(pen[:, 0]):.1e} m")

figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 4.4), layout="constrained")
for sample in (0, 90, 180):
    places = np.array([swing.origin(name)[sample, :2] for name in "ABCD"])
    left.plot(*places.T, "o-", color="0.6", markersize=3)
    at = {name: turn.origin(name)[sample, :2] for name in cell.joint_names}
    for line in (["O1", "T1", "R", "S1", "O1"], ["T1", "P1", "S1"], ["Q", "P1"]):
        right.plot(*np.array([at[name] for name in line]).T, "o-", color="0.6", markersize=3)
left.plot(middle[:, 0], middle[:, 1], color="C3", linewidth=2.5)
right.plot(pen[:, 0], pen[:, 1], color="C3", linewidth=2.5)
left.set(aspect="equal", title="Watt", xlabel="x [m]", ylabel="y [m]")
right.set(aspect="equal", title="Peaucellier", xlabel="x [m]")
