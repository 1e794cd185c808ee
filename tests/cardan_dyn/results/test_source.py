"""What was solved: read in the shape of the samples, closed to writing."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from testkit.planar_linkages import four_bar

from cardan_dyn.core.dynamics.velocity_ratios import VelocityRatios
from cardan_dyn.core.results.motion import Motion
from cardan_dyn.core.results.source import SolvedSource


def source() -> SolvedSource:
    mechanism = four_bar()
    x, rates = np.zeros((3, mechanism.coordinates.size)), np.zeros((3, mechanism.model.nv))
    ratios = VelocityRatios.of(rates[:, :, None])
    return SolvedSource(
        shape=(3,),
        position=np.array([[0.1], [0.2], [0.3]]),
        wrenches=np.arange(36.0).reshape(3, 2, 6),
        efforts=np.array([[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]),
        knows_drives=True,
        holding={"D": 1},
        solved_motion=Motion(mechanism, ("A",), x, x, (rates, rates, ratios)),
    )


def test_what_was_solved_has_the_shape_of_the_samples() -> None:
    item = source()
    moments = [[9, 10, 11], [21, 22, 23], [33, 34, 35]]
    np.testing.assert_array_equal(item.wrench(1).vector(3), moments)
    np.testing.assert_array_equal(item.wrench(0).component(5), [5.0, 17.0, 29.0])
    np.testing.assert_array_equal(item.drive_effort(), [[1.0], [2.0], [3.0]])
    np.testing.assert_array_equal(item.holding_effort()["D"], [4.0, 5.0, 6.0])
    grid = item._replace(shape=(3, 1), position=item.position[:, None])
    np.testing.assert_array_equal(grid.wrench(1).vector(3)[:, 0], moments)
    assert grid.drive_effort().shape == (3, 1, 1)
    assert grid.holding_effort()["D"].shape == (3, 1)


def test_a_drive_effort_that_was_left_out_is_none() -> None:
    assert source()._replace(knows_drives=False).drive_effort() is None


def test_a_motion_may_be_made_when_it_is_read_and_is_part_of_copies() -> None:
    item = source()
    late = item._replace(solved_motion=item.motion)
    assert item.motion() is item.solved_motion is late.motion()
    assert isinstance(pickle.loads(pickle.dumps(late)).solved_motion, Motion)


def test_no_array_of_a_copy_can_be_written_to() -> None:
    item, again = source(), pickle.loads(pickle.dumps(source()))
    for array in (again.wrenches, again.position, again.drive_effort(), again.wrench(0).vector(0)):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    np.testing.assert_array_equal(again.wrenches, item.wrenches)
    with pytest.raises(AttributeError):
        again.wrenches = item.wrenches
