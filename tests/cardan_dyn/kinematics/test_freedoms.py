"""Freedoms: motions that loops leave, against differences of closed positions and Grübler."""

from __future__ import annotations

import numpy as np
from testkit.ball_rods import as_balls
from testkit.planar_linkages import five_bar, four_bar, solver

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.imbalance import Freedoms, Surroundings
from cardan_dyn.core.kinematics.loops.structure import Structure


def columns(mechanism: cd.Mechanism, names: str) -> list[int]:
    return [mechanism.coordinates.velocity_columns[name].start for name in names]


def near(mechanism: cd.Mechanism, x: np.ndarray, held: str = "") -> list[Freedoms]:
    every = set(range(mechanism.model.nv))
    held_columns = set(columns(mechanism, held))
    return Surroundings(Structure(mechanism), x, held_columns, every).freedoms()


def test_the_motion_of_a_four_bar_is_the_difference_of_its_positions() -> None:
    mechanism = four_bar()
    kinematics, start = solver(mechanism, "A")
    step = 1e-5
    guess = np.repeat(start[None, :], 2, axis=0)
    column = mechanism.coordinates.columns["A"].start
    guess[:, column] += [-step, step]
    closed = kinematics.close(guess).x
    difference = (closed[1] - closed[0]) / (2.0 * step)
    found = near(mechanism, start)
    np.testing.assert_array_equal(found[0].x, start)
    for item in found:
        assert item.number == 1
    motion = found[0].motions[:, 0] / found[0].motions[columns(mechanism, "A")[0], 0]
    np.testing.assert_allclose(motion, difference, atol=1e-8)
    assert np.max(np.abs(found[1].x - start)) > 1e-2


def test_held_and_resting_joints_take_freedoms_away() -> None:
    mechanism = five_bar()
    _, start = solver(mechanism, "A", "D")
    a, d = columns(mechanism, "AD")
    (first, *_) = near(mechanism, start)
    assert first.number == 2
    assert first.rank_of([a, d]) == 2
    left = first.while_resting([a])
    assert left.number == 1
    assert a not in left.moving([a, d])
    assert d in left.moving([a, d])
    assert left.while_resting([d]).number == 0
    assert near(mechanism, start, held="A")[0].number == 1
    assert near(mechanism, start, held="AD")[0].number == 0
    # Of joints that serve well, the first ones are taken.
    assert first.chosen([d, a], []) == [d, a]
    assert first.chosen([d, a], [a]) == [d]
    assert first.chosen([], []) == []


def test_where_modes_meet_there_is_one_freedom_more_than_around() -> None:
    flat = four_bar(1.0, 1.0, 2.0)
    x = flat.coordinates.neutral()
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        x[flat.coordinates.columns[name]] = 0.5 * np.pi * sign
    every = set(range(flat.model.nv))
    around = Surroundings(Structure(flat), x, set(), every)
    assert [item.number for item in around.freedoms(here=True)] == [2]
    assert {item.number for item in near(flat, x)} == {1}


def test_spins_of_idle_rods_count_only_if_they_are_asked_for() -> None:
    mechanism = cd.load(as_balls())
    every = set(range(mechanism.model.nv))
    x = mechanism.coordinates.neutral()
    around = Surroundings(Structure(mechanism), x, set(), every)
    numbers = [around.freedoms(with_spins=spins)[0].number for spins in (False, True)]
    assert numbers[1] == numbers[0] + 1 == cd.describe(mechanism).mobility


def test_only_the_motion_of_needed_joints_matters() -> None:
    mechanism = five_bar()
    _, start = solver(mechanism, "A", "D")
    (a,) = columns(mechanism, "A")
    (item, *_) = Surroundings(Structure(mechanism), start, set(), {a}).freedoms()
    assert item.number == 1
    assert item.moving([a]) == {a}
