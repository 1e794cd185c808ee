"""What all laws of contact have in common: numbers that they accept, and what a law has to say."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.core.elements.contact_law import ContactLaw, ranged
from cardan_dyn.core.elements.contact_laws import LinearContact
from cardan_dyn.kit.errors import ArgumentError


def test_restitutions_lie_from_a_least_one_to_1() -> None:
    assert [ranged("e", value, 0.2) for value in (0.2, 1)] == [0.2, 1.0]
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
