"""Singularities: dead points, meeting modes and trusses, of linkages whose lines show them."""

from __future__ import annotations

import numpy as np
from testkit.planar_linkages import four_bar, rocker_range, solver

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.singularities import Singularity, singularity_at


def in_line(mechanism: cd.Mechanism) -> np.ndarray:
    x = mechanism.coordinates.neutral()
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        x[mechanism.coordinates.columns[name]] = 0.5 * np.pi * sign
    return x


def test_at_a_dead_point_the_drive_loses_its_freedom() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "D")
    column = mechanism.coordinates.columns["D"].start
    guess = start.copy()[None, :]
    low, _ = rocker_range()
    for distance in np.geomspace(0.2, 1e-9, 60):
        guess[:, column] = low + distance
        guess = kinematics.close(guess).x
    found = singularity_at(kinematics, guess[0], start)
    assert found == Singularity(("D",), found.moving, ("D",), modes_meet=False)
    assert set(found.moving) == set("ABC")
    assert found.text.startswith("it is a dead point: D cannot move there, and A, B, C can")


def test_where_modes_meet_nothing_loses_its_freedom() -> None:
    mechanism = four_bar(1.0, 1.0, 2.0)
    kinematics, start = solver(mechanism, "A")
    found = singularity_at(kinematics, in_line(mechanism), start)
    assert found.modes_meet
    assert found.lost == ()
    assert set(found.moving) == set("BCD")
    assert found.text == "assembly modes meet, and B, C, D can move while A rests"
    assert found.details["finding"] == found.text


def test_a_regular_position_where_a_drive_stops_is_a_truss() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "A", held=("D",))
    found = singularity_at(kinematics, start, start)
    assert (found.lost, found.moving) == (("A",), ())
    assert found.text == "A cannot move"
