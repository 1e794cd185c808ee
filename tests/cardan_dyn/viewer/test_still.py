"""A configuration as the viewer draws it."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.viewer.still import Still


def test_a_still_has_one_sample_without_wrenches() -> None:
    configuration = cd.assemble(cd.load("four_bar"), near={"crank_bearing": 0.7})
    still = Still(configuration)
    assert len(still) == 1
    assert still.outputs == tuple(configuration.mechanism)
    for joint in still.outputs:
        np.testing.assert_array_equal(still.origin(joint)[0], configuration.origin(joint))
        np.testing.assert_array_equal(still.rotation(joint)[0], configuration.rotation(joint))
        assert not np.any(still[joint].force)
        assert not np.any(still[joint].moment)
        assert still.motion.position(joint).shape == (1,)
    with pytest.raises(cd.ModelError):
        still["lever"]


def test_a_configuration_can_be_viewed() -> None:
    configuration = cd.assemble(cd.load("stewart_platform"))
    page = cd.view(configuration, title="still").html
    assert "still" in page
    with pytest.raises(cd.ArgumentError, match="a sweep or a configuration, not Mechanism"):
        cd.view(configuration.mechanism)  # type: ignore[arg-type]


def test_a_still_shows_the_elements_that_are_listed() -> None:
    configuration = cd.assemble(cd.load("four_bar"), near={"crank_bearing": 0.7})
    elements = [cd.JointSpring("rocker_bearing", 5.0), cd.Actuator("crank_bearing", np.cos)]
    assert Still(configuration, elements).elements == tuple(elements)
    page = cd.view(configuration, elements=elements).html
    assert "effort of an actuator, at most 1 N·m" in page
    with pytest.raises(cd.ModelError, match=r"elements\[0\].*'lever'"):
        cd.view(configuration, elements=[cd.JointSpring("lever", 5.0)])
    with pytest.raises(cd.ArgumentError, match="give True or False"):
        cd.view(cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(0.0), elements=elements)


def test_angles_of_a_ball_that_is_solved_as_a_whole_are_refused() -> None:
    configuration = cd.assemble(cd.load("stewart_platform"))
    ball = next(
        name
        for name in configuration.mechanism.drivable
        if name not in configuration.mechanism.coordinates.named
    )
    with pytest.raises(cd.ArgumentError, match="an angle of a ball"):
        Still(configuration, [cd.JointSpring(ball, 5.0)])


def test_an_equilibrium_can_be_viewed() -> None:
    scene = cd.Scene(
        cd.load("four_bar"),
        free="crank_bearing",
        gravity=(0.0, -9.81, 0.0),
        elements=[cd.JointSpring("rocker_bearing", 50.0, rest=0.2)],
    )
    assert '"text": "spring"' in cd.view(scene.equilibrium(4.0)).html
