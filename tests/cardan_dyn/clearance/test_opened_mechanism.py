"""What an opened mechanism can do, against a mechanism that has these freedoms in its text."""

from __future__ import annotations

import numpy as np
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.motion.clearance.opened_mechanism import OpenedMechanism, across


def test_axes_across() -> None:
    for axis in np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-1.0, 0.0, 0.0]]):
        first, second = across(axis)
        np.testing.assert_allclose(np.cross(first, second), axis, atol=1e-15)


def test_what_stays_closed_takes_freedoms_away() -> None:
    """Two slides open a pin of a four-bar; a row that ties one of them leaves the other."""
    mechanism = cd.load(four_bar(loop("continuous")))
    (part,) = mechanism.joint("b").parts
    slides = [("prismatic", axis) for axis in across(part.axis)]
    fixed = mechanism.coordinates.rates_of(["a"])
    x = cd.Scene(mechanism, drive="a").sweep([0.4]).motion.rows[0]
    free = OpenedMechanism(mechanism, {part.id: slides}, fixed, {})
    ways = free.ways(x)
    assert ways.shape[1] == 2
    slide_rates = ways[free.added[part.id]]
    w = slide_rates @ np.linalg.solve(free.inertia(x, ways)[0], slide_rates.T)
    row = np.array([[0.6, 0.8]])
    tied = OpenedMechanism(mechanism, {part.id: slides}, fixed, {}, {part.id: row})
    way = tied.ways(x)
    assert way.shape[1] == 1
    # The same, by elimination: a force along the row keeps it from moving.
    moved = way[free.added[part.id]]
    np.testing.assert_allclose(row @ moved, 0.0, atol=1e-12)
    eliminated = w - w @ row.T @ row @ w / (row @ w @ row.T)
    found = moved @ moved.T / tied.inertia(x, way)[0]
    np.testing.assert_allclose(found, eliminated, rtol=1e-9, atol=1e-12)


def test_nothing_added_leaves_the_mechanism_as_it_is() -> None:
    """A free crank moves the four-bar in one way, with the inertia of the scene's response."""
    mechanism = cd.load(four_bar(loop("continuous")))
    scene = cd.Scene(mechanism, drive="a")
    at = scene.sweep([0.4], 1.0, 0.0)
    free, x = OpenedMechanism(mechanism, {}, [], {}), at.motion.rows[0]
    ways = free.ways(x)
    assert ways.shape[1] == 1
    # At unit rate of the drive; twice the kinetic energy is the slope of effort over acceleration.
    rate = ways[mechanism.coordinates.rates_of(["a"])[0], 0]
    effort = scene.sweep([0.4, 0.4], 0.0, [0.0, 1.0]).drive_effort
    inertia = float(free.inertia(x, ways)[0][0, 0] / rate**2)
    np.testing.assert_allclose(inertia, effort[1] - effort[0], rtol=1e-10)
