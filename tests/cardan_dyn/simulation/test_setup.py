"""Setup: what a simulation is asked for, checked."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd


@pytest.fixture
def scene(joint: cd.Mechanism) -> cd.Scene:
    return universal(joint, 0.6).replace(free="bearing_in")


def test_a_simulation_begins_where_it_was_asked_to_with_closed_loops(scene: cd.Scene) -> None:
    begun = scene.simulate(0.1, position=0.4, speed=3.0, method="DOP853").at(0.0)
    turn = scene.replace(drive="bearing_in").sweep([0.4], [3.0])
    np.testing.assert_allclose(begun.motion.rows, turn.motion.rows, atol=1e-15)
    np.testing.assert_allclose(begun.motion.v, turn.motion.v, atol=1e-14)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"duration": 0.0}, "duration is 0, expected a positive number"),
        ({"duration": float("nan")}, "duration"),
        ({"rtol": 1e-16}, "below rounding"),
        ({"rtol": 2.0}, "expected a fraction"),
        ({"atol": -1.0}, "atol is -1,"),
        ({"step": 0.0}, "step is 0,"),
        ({"settle": 1}, "settle is 1, expected True or False"),
        ({"max_touches": 0}, "max_touches"),
        ({"loads": {"bearing_out": [1.0, 2.0]}}, "one value, or a function of time"),
        ({"loads": {"nothing": lambda time: 1.0}}, "nothing"),
    ],
)
def test_what_cannot_be_is_refused(scene: cd.Scene, asked: dict[str, object], message: str) -> None:
    with pytest.raises(cd.CardanError, match=message):
        scene.simulate(**{"duration": 1.0, **asked})


def test_loops_that_outputs_leave_out_are_closed_all_the_same() -> None:
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.2, "joint_angle_2": 0.2}
    every = cd.Scene(shaft, free="bearing_in", held=held)
    few, all_of_it = (
        scene.simulate(0.1, speed=9.0, method="DOP853").at(0.1)
        for scene in (every.replace(outputs=["bearing_in"]), every)
    )
    for name in ("bearing_in", "bearing_out"):
        np.testing.assert_array_equal(few.motion.position(name), all_of_it.motion.position(name))
