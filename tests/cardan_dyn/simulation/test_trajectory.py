"""Trajectories: times, copies, tables, energies and proofs."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from testkit.linkages import four_bar, loop
from testkit.simulated import ABOUT_PIN, GRAVITY, LENGTH, MASS, pendulum

import cardan_dyn as cd


def brake(time: float) -> float:
    """A load that a pickle finds by its name."""
    return -2.0 * time


@pytest.fixture(scope="module")
def swing() -> cd.Trajectory:
    return cd.Scene(pendulum(), free="pin", gravity=GRAVITY).simulate(3.0, position=1.0)


@pytest.fixture(scope="module")
def bars() -> cd.Scene:
    return cd.Scene(cd.load(four_bar(loop("continuous"))), free="a", gravity=GRAVITY)


def test_times(swing: cd.Trajectory) -> None:
    assert swing.time[0] == 0.0
    assert swing.time[-1] == 3.0
    assert len(swing) == swing.shape[0] == len(swing.position)
    assert swing.at(1.5).time.tolist() == [1.5]
    np.testing.assert_allclose(swing.evenly(4).time, [0.0, 1.0, 2.0, 3.0])
    for count in (-3, 0, 2.5, "4", True):
        with pytest.raises(cd.ArgumentError, match="count is"):
            swing.evenly(count)
    np.testing.assert_array_equal(swing.at([2.0, 1.0]).position[::-1], swing.at([1, 2]).position)
    assert "pendulum" in repr(swing)


@pytest.mark.parametrize("times", [-0.1, 3.1, np.nan, [], [[1.0]], "now"])
def test_other_times_are_refused(swing: cd.Trajectory, times: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"times"):
        swing.at(times)


def test_nothing_can_be_changed(swing: cd.Trajectory) -> None:
    with pytest.raises(cd.ImmutableError):
        swing.time = np.zeros(3)  # type: ignore[misc]
    for values in (swing.time, swing.position, swing.speed, swing.kinetic_energy, swing.work):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0


def test_energies_of_a_pendulum(swing: cd.Trajectory) -> None:
    np.testing.assert_allclose(swing.kinetic_energy, 0.5 * ABOUT_PIN * swing.speed**2)
    height = -LENGTH * np.cos(swing.position)
    np.testing.assert_allclose(swing.potential_energy, 9.81 * MASS * height)
    assert not np.any(swing.work)
    assert swing.energy_residual < 1e-13
    assert swing.effort_residual < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("method", ["response", "DOP853"])
@pytest.mark.parametrize("loads", [{"d": -3.0}, {"d": brake}, {"coupler": (1, 2, 0, 0, 0, 3)}])
def test_work_is_what_the_energy_gains(
    bars: cd.Scene, method: str, loads: dict[str, object]
) -> None:
    trajectory = bars.simulate(1.5, speed=4.0, loads=loads, method=method, rtol=1e-11)
    energy = trajectory.kinetic_energy + trajectory.potential_energy
    assert np.max(np.abs(trajectory.work)) > 0.3
    # Some hundred steps of this tolerance.
    np.testing.assert_allclose(energy - energy[0], trajectory.work, atol=1e-8)
    assert trajectory.energy_residual < 1e-9


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853", "Radau"])
def test_copies(bars: cd.Scene, method: str) -> None:
    loads = {} if method == "quadrature" else {"d": brake}
    trajectory = bars.simulate(0.5, speed=4.0, loads=loads, method=method, rtol=1e-8)
    for other in (copy.deepcopy(trajectory), pickle.loads(pickle.dumps(trajectory))):
        np.testing.assert_allclose(other.position, trajectory.position, atol=1e-14)
        np.testing.assert_allclose(
            other.at(0.3)["c"].force, trajectory.at(0.3)["c"].force, rtol=1e-9, atol=1e-9
        )
        assert (other.method, other.events) == (trajectory.method, trajectory.events)


def test_tables_have_times(swing: cd.Trajectory) -> None:
    dataset = swing.to_xarray()
    np.testing.assert_array_equal(dataset["time"], swing.time)
    np.testing.assert_allclose(dataset["drive_effort"], swing.drive_effort)
    frame = swing.to_dataframe(motion=False)
    assert frame.columns[0] == "time"
    assert frame.attrs["units"]["time"] == "s"
    np.testing.assert_array_equal(frame["time"], swing.time)


def test_what_is_wrong_with_accelerations_is_found(bars: cd.Scene) -> None:
    trajectory = bars.simulate(0.5, speed=4.0, method="DOP853")
    rows = trajectory._rows
    spoiled = trajectory.at(trajectory.time)
    spoiled.__dict__["_rows"] = rows._replace(a=rows.a * 1.001)
    with pytest.raises(cd.AccuracyError, match="leave such times out with at"):
        _ = spoiled.sweep


def test_the_law_of_a_drive_is_asked_once(joint: cd.Mechanism) -> None:
    """Positions, wrenches and energies of one trajectory are of one evaluation."""
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5})
    turned = scene.simulate(1.0, speed=5.0).at(np.linspace(0.0, 1.0, 9))
    asked: list[int] = []
    law = turned._run._law  # type: ignore[attr-defined]
    found = law.at

    def counted(times: np.ndarray) -> object:
        asked.append(len(times))
        return found(times)

    law.at = counted
    assert len(turned.position) == 9
    assert turned.balance_residual < 1e-13
    assert len(turned.kinetic_energy) == 9
    # The others are those at which the proof looks, for the drive and for all joints.
    assert asked[0] == 9 and asked.count(9) == 1
