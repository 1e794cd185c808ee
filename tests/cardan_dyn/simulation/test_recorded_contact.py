"""Recorded contacts: phases by time."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.motion.simulation.recorded_contact import FREE, PRESSED, Phase, RecordedContact

ORIGIN, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture
def recorded() -> RecordedContact:
    law = cd.HuntCrossley(1e9, restitution=0.5)
    contact = RecordedContact.of(cd.PinContact("a", ORIGIN, Z, "b", ORIGIN, 1e-3, law, name="pin"))
    for phase in (Phase(0.0, FREE, np.inf), Phase(1.0, PRESSED, 0.2), Phase(2.0, FREE, np.inf)):
        contact.phases.begin(phase)
    return contact


def test_the_law_acts_in_pressed_phases_alone(recorded: RecordedContact) -> None:
    times = np.array([0.5, 1.0, 1.5, 2.0, 9.0])
    depth, rate = np.full(5, 1e-4), np.full(5, 0.1)
    expected = float(recorded.law.force(1e-4, 0.1, 0.2))
    np.testing.assert_allclose(
        recorded.pressure(depth, rate, times), [0.0, expected, expected, 0.0, 0.0]
    )
    for time in times.tolist():
        alone = recorded.pressure_at(1e-4, 0.1, time)
        assert alone == (expected if 1.0 <= time < 2.0 else 0.0)
        assert recorded.acts_at(time) == (1.0 <= time < 2.0)


def test_pressures_of_tables_are_not_negative(recorded: RecordedContact) -> None:
    depth, time = np.array([-1e-9]), np.array([1.5])
    assert recorded.pressure(depth, np.zeros(1), time) == 0.0
    assert recorded.pressure_at(-1e-9, 0.0, 1.5) < 0.0


def test_copies_keep_phases(recorded: RecordedContact) -> None:
    for other in (copy.deepcopy(recorded), pickle.loads(pickle.dumps(recorded))):
        assert len(other.phases) == 3 and other.phases.last == Phase(2.0, FREE, np.inf)
        assert other == recorded
