"""What all laws of contact have in common: numbers that they accept, and what a law has to say."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.elements.contact_law import ContactLaw, number, positive, ranged
from cardan_dyn.elements.contact_laws import LinearContact
from cardan_dyn.errors import ArgumentError


def test_numbers_are_plain_floats() -> None:
    assert type(number("d", np.int64(3), 0.0)) is float
    assert number("d", 0, 0.0) == 0.0
    assert positive("c", np.array(2.5)) == 2.5
    assert ranged("e", 1, 0.0) == 1.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, "1", None, [1.0], 1.0 + 0.0j])
def test_what_is_no_number_is_refused(bad: object) -> None:
    for check in (lambda: number("d", bad, 0.0), lambda: positive("c", bad)):
        with pytest.raises(ArgumentError, match=r"^[cd] "):
            check()


def test_ranges() -> None:
    with pytest.raises(ArgumentError, match="d is -1; it is not less than 0"):
        number("d", -1, 0.0)
    with pytest.raises(ArgumentError, match="c is 0, expected a positive number"):
        positive("c", 0.0)
    for value in (-0.1, 1.1):
        with pytest.raises(ArgumentError, match="it lies from 0 to 1"):
            ranged("e", value, 0.0)


def test_a_law_that_says_nothing_has_no_force() -> None:
    with pytest.raises(NotImplementedError):
        ContactLaw().force(1.0, 1.0)
    with pytest.raises(NotImplementedError):
        ContactLaw().restitution(1.0, 1.0)
    assert not ContactLaw().needs_touch_speed


def test_stored_energy_of_depths() -> None:
    np.testing.assert_allclose(LinearContact(4.0).energy([-1.0, 0.0, 3.0]), [0.0, 0.0, 18.0])
