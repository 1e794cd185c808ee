"""Arrays of a solved sweep: read as they were given, closed to writing."""

from __future__ import annotations

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest
from testkit.planar_linkages import four_bar

import cardan_dyn as cd
from cardan_dyn.dynamics.velocity_ratios import VelocityRatios
from cardan_dyn.frozen import frozen
from cardan_dyn.results.motion import Motion
from cardan_dyn.results.source import SolvedSource


def source() -> SolvedSource:
    mechanism = four_bar()
    x, rates = np.zeros((3, mechanism.coordinates.size)), np.zeros((3, mechanism.model.nv))
    return SolvedSource(
        shape=(3,),
        wrenches=np.arange(36.0).reshape(3, 2, 6),
        drive_efforts=np.array([1.0, 2.0, 3.0]),
        holding_efforts=frozen({"D": np.array([4.0, 5.0, 6.0])}),
        solved_motion=Motion(
            mechanism, ("A",), x, x, (rates, rates, VelocityRatios.of(rates[:, :, None]))
        ),
        position=np.array([0.1, 0.2, 0.3]),
        speed=np.array([10.0, 20.0, 30.0]),
        acceleration=np.array([7.0, 8.0, 9.0]),
        held=frozen({"D": 0.3}),
        joint_loads=frozen({"D": np.array(-2.0)}),
        link_loads=frozen({}),
        gravity=np.array([0.0, 0.0, -9.81]),
        inertia=frozen({}),
    )


def test_arrays_are_read_as_they_were_given() -> None:
    item = source()
    assert item.shape == (3,)
    assert len(item) == 3
    np.testing.assert_array_equal(
        item.wrench(1).vector(3), [[9, 10, 11], [21, 22, 23], [33, 34, 35]]
    )
    np.testing.assert_array_equal(item.wrench(0).component(5), [5.0, 17.0, 29.0])
    np.testing.assert_array_equal(item.drive_effort(), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(item.holding_effort()["D"], [4.0, 5.0, 6.0])
    assert item.motion() is item.solved_motion


def test_a_drive_effort_that_was_left_out_is_none() -> None:
    assert replace(source(), drive_efforts=None).drive_effort() is None


def test_no_array_can_be_written_to_in_a_source_or_in_its_pickle() -> None:
    item = source()
    again = pickle.loads(pickle.dumps(item))
    for field in fields(SolvedSource):
        value = getattr(item, field.name)
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(getattr(again, field.name), value)
        for this in (item, again):
            with pytest.raises(AttributeError):
                setattr(this, field.name, None)
    for this in (item, again):
        arrays = [this.wrenches, this.position, this.speed, this.acceleration, this.gravity]
        efforts = [this.drive_effort(), this.holding_effort()["D"]]
        for array in (*arrays, *efforts, this.wrench(0).vector(0), this.motion().v):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0
    with pytest.raises(cd.ImmutableError):
        again.joint_loads["D"] = np.array(0.0)
