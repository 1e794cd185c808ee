"""Setup: what a simulation is asked for, checked."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.simulation.setup import Asked, setup_of, with_all_loops


@pytest.fixture
def scene(joint: cd.Mechanism) -> cd.Scene:
    return universal(joint, 0.6).replace(free="bearing_in")


def test_a_start_is_closed_and_tolerances_are_those_asked_for(scene: cd.Scene) -> None:
    setup = setup_of(scene.solver, Asked(2.0, 0.4, 3.0, rtol=1e-9))
    turn = scene.replace(drive="bearing_in").sweep([0.4], [3.0])
    np.testing.assert_allclose(setup.x, turn.motion._x[0], atol=1e-15)
    np.testing.assert_allclose(setup.v, turn.motion.v[0], atol=1e-14)
    assert (setup.duration, setup.rtol, setup.atol) == (2.0, 1e-9, 1e-9)
    assert setup.traits.is_one_coordinate
    assert not setup.has_elements
    assert not setup.traits.has_idle_rods


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        (Asked(0.0), "duration is 0, expected a positive number"),
        (Asked(float("nan")), "duration"),
        (Asked(1.0, rtol=1e-16), "below rounding"),
        (Asked(1.0, rtol=2.0), "expected a fraction"),
        (Asked(1.0, atol=-1.0), "atol is -1,"),
        (Asked(1.0, step=0.0), "step is 0,"),
        (Asked(1.0, settle=1), "settle is 1, expected True or False"),
        (Asked(1.0, loads={"bearing_out": [1.0, 2.0]}), "one value, or a function of time"),
        (Asked(1.0, loads={"nothing": lambda time: 1.0}), "nothing"),
    ],
)
def test_what_cannot_be_is_refused(scene: cd.Scene, asked: Asked, message: str) -> None:
    with pytest.raises(cd.CardanError, match=message):
        setup_of(scene.solver, asked)


def test_loops_that_outputs_leave_out_are_closed_all_the_same(joint: cd.Mechanism) -> None:
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.2, "joint_angle_2": 0.2}
    few = cd.Scene(shaft, drive="bearing_in", held=held, outputs=["bearing_in"])
    whole = with_all_loops(few._solver)
    passive = set(few._problem.passive_columns.tolist())
    assert set(whole.assembly.decided.tolist()) >= passive
    every = universal(joint, 0.6)
    assert with_all_loops(every._solver) is every._solver
