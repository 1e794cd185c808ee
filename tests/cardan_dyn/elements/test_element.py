"""What all elements have in common: they are frozen, compared by content, copied and pickled."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.elements.element import Element

ELEMENTS = [
    cd.JointSpring("pin", 3.0, damping=1.0, rest=0.2, name="coil"),
    cd.JointFriction("pin", 3.0),
    cd.Actuator("pin", np.cos),
    cd.PointSpring("a", (1.0, 2.0, 3.0), "b", (0.0, 0.0, 0.0), 5.0, 1.0, 0.3),
    cd.Bushing("a", "b", (1.0, 2.0, 3.0), np.arange(1.0, 7.0)),
]


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda item: type(item).__name__)
def test_elements_are_frozen_and_compared_by_content(element: Element) -> None:
    for other in (copy.copy(element), copy.deepcopy(element), pickle.loads(pickle.dumps(element))):
        assert other == element
    field = "link_a" if element.links else "joint"
    with pytest.raises(FrozenInstanceError):
        setattr(element, field, "another")
    for value in vars(pickle.loads(pickle.dumps(element))).values():
        if isinstance(value, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                value[...] = 0.0


def test_elements_that_differ_are_not_equal() -> None:
    assert cd.JointSpring("pin", 3.0) != cd.JointSpring("pin", 3.1)
    assert cd.JointSpring("pin", 3.0) != cd.JointSpring("pin", 3.0, name="coil")
    first, second = (cd.Bushing("a", "b", (0, 0, z), np.ones(6)) for z in (0.0, 1.0))
    assert first != second
    assert first != ELEMENTS[0]


def test_elements_say_what_they_act_on() -> None:
    assert [element.joints for element in ELEMENTS] == [("pin",)] * 3 + [()] * 2
    assert [element.links for element in ELEMENTS] == [()] * 3 + [("a", "b")] * 2


def test_numbers_given_may_change_later_without_effect() -> None:
    point = np.array([1.0, 2.0, 3.0])
    spring = cd.PointSpring("a", point, "b", point, 1.0)
    point[0] = 9.0
    assert spring.point_a.tolist() == [1.0, 2.0, 3.0]
