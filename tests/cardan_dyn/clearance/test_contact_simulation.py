"""Results of simulations of clearance."""

from __future__ import annotations

import copy

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn import clearance


@pytest.fixture(scope="module")
def found() -> clearance.ContactSimulation:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    return clearance.simulate(
        scene, 300.0, joints="coupler_pin", clearance=1e-4, stiffness=1e8, damping_ratio=0.25,
        turns=1.0, rtol=1e-11,
    )  # fmt: skip


@pytest.mark.slow
def test_courses_fit_the_trajectory(found: clearance.ContactSimulation) -> None:
    at = found.evenly(200)
    course = at["coupler_pin"]
    assert course.time.shape == course.force.shape == (200,) and course.offset.shape == (200, 3)
    slides = at.trajectory.motion.position("coupler_pin")[:, :2]
    distance = np.linalg.norm(slides, axis=1)
    np.testing.assert_allclose(np.linalg.norm(course.offset, axis=1), distance, atol=1e-15)
    np.testing.assert_allclose(course.depth, distance - 5e-5, atol=1e-15)
    np.testing.assert_allclose(
        course.position, course.position[0] + 300.0 * course.time, rtol=1e-12
    )
    # Both are as the bush sees it, in directions that a fixed turn leads to each other.
    turn, *_ = np.linalg.lstsq(slides, course.orbit, rcond=None)
    np.testing.assert_allclose(turn @ turn.T, np.eye(2), atol=1e-9)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(slides @ turn, course.orbit, atol=1e-14)
    assert 0 < np.count_nonzero(course.force > 0.0) < 200


@pytest.mark.slow
def test_impacts_are_where_pins_reach_the_wall(found: clearance.ContactSimulation) -> None:
    struck = found["coupler_pin"].struck
    assert len(struck) >= 2 and struck == tuple(i for i in found.impacts if i.speed == i.speed)
    starts = found.at([item.start for item in struck])["coupler_pin"]
    np.testing.assert_allclose(starts.depth, 0.0, atol=1e-12)
    np.testing.assert_allclose(starts.position, [item.position for item in struck], rtol=1e-12)
    peaks = found.at([item.peak_time for item in struck])["coupler_pin"].force
    np.testing.assert_allclose(peaks, [item.peak for item in struck], rtol=1e-9)


@pytest.mark.slow
def test_copies_and_texts(found: clearance.ContactSimulation) -> None:
    again = copy.deepcopy(found)
    np.testing.assert_array_equal(again["coupler_pin"].force, found["coupler_pin"].force)
    assert "coupler_pin" in repr(found) and list(found) == ["coupler_pin"] and len(found) == 1
    with pytest.raises(cd.ModelError, match="no joint 'needle_pin' has clearance"):
        found["needle_pin"]
    with pytest.raises(cd.ArgumentError, match="reach beyond"):
        found.at([9.0])


@pytest.mark.slow
def test_energy_is_that_of_walls(found: clearance.ContactSimulation) -> None:
    assert found.energy_residual < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("share", "is_told"), [(0.03, False), (0.3, True)])
def test_energy_that_is_missing_beside_that_of_walls_is_noted(
    found: clearance.ContactSimulation,
    monkeypatch: pytest.MonkeyPatch,
    share: float,
    is_told: bool,
) -> None:
    """Far less than simulations note by themselves: walls store little of what moves."""
    peak = max(item.peak for item in found.impacts)
    missing = share * peak**2 / (2.0 * 1e8)
    plain = cd.Trajectory.kinetic_energy.func  # type: ignore[attr-defined]

    def off(self: cd.Trajectory) -> np.ndarray:
        lost: np.ndarray = plain(self) + missing * (self.time > found.time[-1] / 2.0)
        return lost

    assert not found.at(found.steps).notes
    monkeypatch.setattr(cd.Trajectory, "kinetic_energy", property(off))
    # Copies have not looked at their energy.
    notes = found.at(found.steps).notes
    assert any("walls store" in note for note in notes) == is_told


@pytest.mark.slow
def test_energy_is_known_of_pins_with_friction() -> None:
    """Where a pin begins to slide, accelerations within a step are off; its energy is not."""
    needles = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    omega = 2000.0 * np.pi / 30.0
    contact = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    played = clearance.simulate(
        needles, omega, joints="needle_pin", friction=0.1, turns=1.8, rtol=1e-7, **contact
    )
    assert "needle_pin" in repr(played)
    assert played.energy_residual < 1e-6
