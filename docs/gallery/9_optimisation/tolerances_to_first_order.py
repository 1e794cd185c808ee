"""
Tolerances: first order beside Monte-Carlo
==========================================

How far is the rocker of a four-bar off, if its lengths have tolerances? To first order every length
contributes the square of its derivative times its tolerance: one sweep and its derivatives tell
which of them to tighten, at every position. Four thousand random linkages agree, as far as so many
can tell.
"""

import matplotlib.pyplot as plt
import numpy as np

import cardan_dyn as cd

sigma = {
    "origin:crank_pin.x": 0.02e-3,
    "origin:rocker_pin.predecessor.x": 0.05e-3,
    "origin:rocker_pin.successor.x": 0.05e-3,
    "origin:rocker_bearing.x": 0.1e-3,
}
labels = ("crank", "coupler", "rocker", "frame")
scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", held=dict.fromkeys(sigma, 0.0))
angle = np.linspace(0.0, 2.0 * np.pi, 73)
turn = scene.sweep(angle)
found = turn.derivative(*sigma)
shares = np.array(
    [(found[name].motion.position("rocker_bearing") * value) ** 2 for name, value in sigma.items()]
)
first_order = np.sqrt(shares.sum(axis=0))

# The same of the law of cosines, by complex steps.
sizes = np.array([0.08, 0.40, 0.25, 0.47])


def rocker(crank, coupler, rocker, frame):
    x, y = frame - crank * np.cos(angle), crank * np.sin(angle)
    across = np.sqrt(x * x + y * y)
    cosine = (across**2 + rocker**2 - coupler**2) / (2.0 * across * rocker)
    return np.arccos(cosine) + np.arctan(y / x)


for number, name in enumerate(sigma):
    step = np.zeros(4, dtype=complex)
    step[number] = 1e-30j
    slope = np.imag(rocker(*(sizes + step))) / 1e-30
    by = found[name].motion.position("rocker_bearing")
    np.testing.assert_allclose(np.abs(by), np.abs(slope), rtol=0.0, atol=1e-12)

count, rng = 4000, np.random.default_rng(1)
samples = {name: rng.normal(0.0, value, (count, 1)) for name, value in sigma.items()}
scattered = scene.sweep(angle, held=samples).motion.position("rocker_bearing").std(axis=0)
# What a standard deviation of so many samples is off by.
np.testing.assert_allclose(scattered, first_order, rtol=5.0 / np.sqrt(2.0 * count))

figure, axes = plt.subplots(figsize=(6.4, 3.8), layout="constrained")
axes.stackplot(np.degrees(angle), *(np.degrees(shares / first_order)), labels=labels, alpha=0.7)
axes.plot(np.degrees(angle), np.degrees(scattered), "k.", markersize=4, label="Monte-Carlo")
axes.set(xlabel="crank [°]", ylabel="standard deviation of the rocker [°]")
axes.legend(ncols=2, fontsize=8)
