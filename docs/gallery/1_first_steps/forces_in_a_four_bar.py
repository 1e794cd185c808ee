"""
Forces in a four-bar, drawn in place
====================================

Polar diagrams show which way a bearing is pushed, not only how hard. Here they are drawn where
the pins are. The crank turns at 600 rpm, and the sum of what the base exerts on both bearings is,
by Newton, what accelerates all the masses: checked with their centres, differentiated by hand.
"""

import numpy as np

import cardan_dyn as cd
from cardan_dyn import figures

bar = cd.load("four_bar")
speed = 20.0 * np.pi
scene = cd.Scene(bar, drive="crank_bearing")
angle = np.linspace(0.0, 2.0 * np.pi, 361)
turn = scene.sweep(angle, speed=speed)

# Newton: forces on the base's pins = d/dt of momentum, by spectral derivatives of the centres.
momentum_rate = np.zeros((360, 3))
for link in bar.description.links[1:]:
    mass, centre = link.mass, link.centre
    place = turn.point(link.name, centre).position[:-1]
    orders = np.fft.rfftfreq(360, 1.0 / 360)[:, None]
    momentum_rate -= mass * speed**2 * np.fft.irfft(orders**2 * np.fft.rfft(place, axis=0), 360, 0)
support = turn.wrench("crank_bearing", "world").force + turn.wrench("rocker_bearing", "world").force
np.testing.assert_allclose(support[:-1, :2], momentum_rate[:, :2], atol=1e-9)

figure = figures.forces_in_place(
    turn,
    ["crank_bearing", "crank_pin", "rocker_pin", "rocker_bearing"],
    [["crank_bearing", "crank_pin", "rocker_pin", "rocker_bearing"]],
    size=0.12,
    sample=45,
    title="Four-bar at 600 rpm: forces of inertia",
)
