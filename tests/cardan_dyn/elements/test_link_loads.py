"""Loads on links and their samples."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.elements.link_loads import LinkLoad, Wrench

FORCE = np.arange(12.0).reshape(4, 3)


def load(in_world: bool = False) -> LinkLoad:
    return LinkLoad(2, np.eye(3), np.zeros(3), FORCE.copy(), np.array([[1.0, 2.0, 3.0]]), in_world)


def test_samples_of_what_varies_and_of_what_does_not() -> None:
    part = load().of_samples(slice(1, 3))
    np.testing.assert_array_equal(part.force, FORCE[1:3])
    np.testing.assert_array_equal(part.moment, [[1.0, 2.0, 3.0]])
    assert (part.body, part.in_world) == (2, False)


def test_arrays_of_a_load_and_of_its_samples_are_read_only() -> None:
    for item in (load(), load().of_samples(slice(0, 1))):
        for array in (item.force, item.moment):
            with pytest.raises(ValueError, match="read-only"):
                array[0, 0] = 1.0


@pytest.mark.parametrize(("in_world", "frame"), [(True, "world"), (False, "link")])
def test_the_wrench_is_what_was_given(in_world: bool, frame: str) -> None:
    wrench = load(in_world).wrench
    assert isinstance(wrench, Wrench)
    assert wrench.frame == frame
    np.testing.assert_array_equal(wrench.force, FORCE)
    np.testing.assert_array_equal(wrench.moment, [[1.0, 2.0, 3.0]])


def test_a_wrench_is_zero_unless_given() -> None:
    wrench = Wrench()
    assert (wrench.force, wrench.moment, wrench.frame) == ((0.0,) * 3, (0.0,) * 3, "link")
