"""Motions of two masses as users read them: samples, states at times, energies, displacements."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.integrate import trapezoid

from cardan_dyn import clearance
from cardan_dyn.clearance import LinearContact, two_masses
from cardan_dyn.clearance.two_mass_motion import impacts_of
from cardan_dyn.clearance.two_mass_phases import Begun, Phase
from cardan_dyn.errors import ArgumentError

EXAMPLE = {"play": 1e-4, "mass": 3.6, "ramp": 360e3, "end": 0.006}
MOTION = two_masses(LinearContact.of_ratio(1e7, 0.1, 3.6), **EXAMPLE)


def test_states_obey_the_equation_of_motion() -> None:
    times = np.linspace(1e-4, 0.0059, 400)
    times = times[np.abs(times - MOTION.impacts[0].time) > 1e-5]
    step = 1e-6
    before, at, after = (MOTION.at(times + shift) for shift in (-step, 0.0, step))
    np.testing.assert_allclose(at.speed, (after.gap - before.gap) / (2 * step), atol=2e-7)
    bend = (after.speed - before.speed) / (2.0 * step)
    np.testing.assert_allclose(3.6 * bend, at.external - at.force, atol=1e-2)
    np.testing.assert_allclose(at.external, 360e3 * times)
    is_apart = (at.gap > 0.0) & (at.gap < 1e-4)
    assert np.all(at.force[is_apart] == 0.0)
    assert np.all(at.force[at.gap > 1e-4] > 0.0)


def test_samples_are_states_at_their_times() -> None:
    times = MOTION.times
    assert np.all(np.diff(times) > 0.0)
    assert (times[0], times[-1]) == (0.0, 0.006)
    state = MOTION.at(times[::-1])
    for name in ("gap", "speed", "force"):
        np.testing.assert_array_equal(getattr(MOTION, name), getattr(state, name)[::-1])
    assert MOTION.at(0.002).gap.shape == (1,)


@pytest.mark.parametrize("times", [-1e-9, 0.0061, [0.0, np.nan], [[0.0]], "late"])
def test_times_that_were_not_simulated_are_refused(times: object) -> None:
    with pytest.raises(ArgumentError, match="times"):
        MOTION.at(times)  # type: ignore[arg-type]


def test_energies_balance_with_independent_sums() -> None:
    energies = MOTION.energies
    assert MOTION.energy_residual < 1e-13
    # The work of the force by a trapezium rule over many samples of the whole motion.
    times = np.linspace(0.0, 0.006, 200_001)
    state = MOTION.at(times)
    work = trapezoid(state.external * state.speed, times)
    assert energies.work[-1] == pytest.approx(work, rel=1e-8)
    touch = MOTION.impacts[0].time
    times = np.linspace(touch, 0.006, 200_001)
    lost = trapezoid(MOTION.law.damping * MOTION.at(times).speed ** 2, times)  # type: ignore[attr-defined]
    assert energies.lost[-1] - energies.lost[energies.time == touch] == pytest.approx(
        lost, rel=1e-8
    )
    # The spring that unloads before has stored energy when its force vanishes, and loses it.
    depth = 360e3 * MOTION.law.damping / 1e14  # type: ignore[attr-defined]
    assert energies.stored[0] == pytest.approx(0.5e7 * depth**2, rel=1e-12)
    assert energies.lost[energies.time == touch] == pytest.approx(energies.stored[0], rel=1e-9)
    assert energies.kinetic[-1] == pytest.approx(1.8 * state.speed[-1] ** 2, rel=1e-12)


def test_masses_move_about_their_centre() -> None:
    motion = two_masses(LinearContact(1e7), **{**EXAMPLE, "mass": (6.0, 9.0)})
    assert motion.mass == pytest.approx(3.6)
    times = np.linspace(0.0, 0.006, 50)
    first, second = motion.displacements(times)
    np.testing.assert_allclose(6.0 * first + 9.0 * second, 0.0, atol=1e-18)
    np.testing.assert_allclose(first - second, motion.at(times).gap, rtol=1e-14)
    with pytest.raises(ArgumentError, match="give mass="):
        MOTION.displacements(times)


def test_a_motion_without_an_impact_has_no_peak() -> None:
    motion = two_masses(LinearContact(1e7), **{**EXAMPLE, "end": 1e-3})
    assert (motion.impacts, motion.ended) == ((), "time is up")
    assert np.isnan(motion.peak)


def test_motions_can_be_copied() -> None:
    other = pickle.loads(pickle.dumps(MOTION))
    np.testing.assert_array_equal(other.force, MOTION.force)
    assert repr(other.impacts) == repr(MOTION.impacts)


class Told(Phase):
    """A phase whose numbers are given."""

    def __init__(self, begun: Begun, end: float, peak: float, outcome: str, again: bool) -> None:
        self.begun, self.end, self.peak, self.peak_time = begun, end, peak, end
        self.is_contact, self.outcome, self.is_resumed = True, outcome, again

    @property
    def last(self) -> tuple[float, float]:
        return 0.0, -0.1


def test_a_touch_whose_force_comes_back_is_one_impact() -> None:
    touch = Begun(1.0, 1, 0.0, 0.4, 0.4)
    phases = [
        Told(Begun(0.0, -1, 1e-5, 0.0), 0.5, 9.0, "parted", False),
        Told(touch, 1.5, 3.0, "parted", False),
        Told(touch._replace(time=1.7), 2.0, 5.0, "parted", True),
        Told(touch._replace(time=4.0), 5.0, -np.inf, "", False),
    ]
    first, last = impacts_of(phases)
    assert (first.time, first.duration, first.peak, first.restitution) == (1.0, 1.0, 5.0, 0.25)
    assert (last.time, last.side, last.speed) == (4.0, 1, 0.4)
    assert np.isnan([last.peak, last.duration, last.restitution]).all()


def test_what_the_package_offers() -> None:
    assert {"two_masses", "TwoMassMotion", "HuntCrossley"} <= set(clearance.__all__)
