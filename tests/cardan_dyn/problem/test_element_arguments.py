"""Elements that a scene refuses, with their index and the choices there are."""

from __future__ import annotations

import re

import numpy as np
import pytest
from testkit.mixed_chain import MIXED

import cardan_dyn as cd
from cardan_dyn.core.elements.joint_elements import JointElement, JointForce
from cardan_dyn.core.problem.element_arguments import elements_on, listed

ORIGIN = (0.0, 0.0, 0.0)
GOOD = cd.JointSpring("crank_bearing", 1.0)


def scene(*elements: object) -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=list(elements))


@pytest.mark.parametrize(
    ("elements", "error", "message"),
    [
        ([GOOD, 3.0], cd.ArgumentError, "elements[1] is 3.0, expected one of: JointSpring, Joint"),
        (
            [cd.JointSpring],
            cd.ArgumentError,
            "elements[0] is the class JointSpring itself, expected one of",
        ),
        (
            [GOOD, cd.JointSpring("crank_bearings", 1.0)],
            cd.ModelError,
            "elements[1] (JointSpring): four_bar: no joint 'crank_bearings'; joints: crank_bearing",
        ),
        (
            [cd.JointFriction("crank_bearing.turn", 1.0)],
            cd.ModelError,
            "elements[0] (JointFriction): four_bar: joint 'crank_bearing' has no coordinate",
        ),
        (
            [cd.PointSpring("crank", ORIGIN, "arm", ORIGIN, 1.0, name="coil")],
            cd.ModelError,
            "elements[0] (PointSpring 'coil'): four_bar: no link or frame 'arm'; links and frames: "
            "base, coupler",
        ),
        (
            [cd.Bushing("hub", "crank", ORIGIN, np.ones(6))],
            cd.ModelError,
            "elements[0] (Bushing): four_bar: no link or frame 'hub'",
        ),
        (
            [cd.JointSpring("crank_bearing", 1.0, name="a"), cd.Actuator("rocker_pin", 1.0, "a")],
            cd.ArgumentError,
            "elements[0]: another element is called 'a' too",
        ),
    ],
)
def test_refused_elements_are_named(
    elements: list[object], error: type[cd.CardanError], message: str
) -> None:
    with pytest.raises(error) as caught:
        scene(*elements)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (GOOD, "elements is a JointSpring; give a list of elements"),
        (3, "elements is 3, expected a list of: JointSpring"),
        ("spring", "elements is 'spring', expected a list of"),
        ({"a": GOOD}, "elements is of type dict, expected a list of"),
    ],
)
def test_what_is_no_list_is_refused(given: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=re.escape(message)):
        listed(given)


def test_joints_of_several_coordinates_are_refused() -> None:
    mechanism = cd.load(MIXED)
    with pytest.raises(cd.ArgumentError) as caught:
        elements_on(mechanism, (cd.JointSpring("cross", 1.0),))
    expected = "name one of its coordinates: cross.turn_1, cross.turn_2"
    assert str(caught.value) == (
        f"elements[0] (JointSpring): joint 'cross' is a universal joint; {expected}"
    )
    with pytest.raises(cd.ArgumentError, match="joint 'bolt' is a fixed joint; it has no coord"):
        elements_on(mechanism, (cd.JointSpring("bolt", 1.0),))


def test_both_ends_in_the_world_are_refused() -> None:
    text = (
        '<robot name="r"><link name="ground"/><link name="wall"/><link name="arm"/>'
        '<joint name="weld" type="fixed"><parent link="ground"/><child link="wall"/></joint>'
        '<joint name="pin" type="continuous"><parent link="wall"/><child link="arm"/></joint>'
        "</robot>"
    )
    with pytest.raises(cd.ArgumentError) as caught:
        elements_on(cd.load(text), (cd.PointSpring("ground", ORIGIN, "wall", ORIGIN, 1.0),))
    assert "both links are fixed to the world; links that move: arm" in str(caught.value)


def test_no_elements_are_none() -> None:
    assert scene().elements == ()
    assert scene().problem.element_forces is None


class Untold(JointElement):
    """An element of whose law the proof knows nothing."""

    joint, name = "crank_bearing", "untold"

    def force(self, x: np.ndarray, v: np.ndarray, time: np.ndarray, label: str) -> JointForce:
        return JointForce(-x, 0.5 * x * x, 0.0 * x)


def test_elements_that_cannot_be_proven_are_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="the proof does not know the law of Untold"):
        scene(Untold()).sweep([0.0])
