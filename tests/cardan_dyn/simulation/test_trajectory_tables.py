"""Tables of a trajectory: time as the axis, energies, work, and how it went."""

from __future__ import annotations

import io
import json
from pathlib import Path

import numpy as np
import pytest
import xarray

import cardan_dyn as cd


@pytest.fixture(scope="module")
def swing() -> cd.Trajectory:
    scene = cd.Scene(
        cd.load("four_bar"),
        free="crank_bearing",
        gravity=(0.0, -9.81, 0.0),
        elements=[
            cd.JointSpring("rocker_bearing", 50.0, 0.1, 0.2, name="spring"),
            cd.Actuator("crank_bearing", 0.4, name="motor"),
        ],
    )

    def turned(time: float, position: dict[str, float], speed: dict[str, float]) -> float:
        return position["crank_bearing"] - 1.2

    return scene.simulate(1.0, position=1.0, events=turned).evenly(401)


@pytest.mark.slow
def test_a_dataset_has_time_as_its_dimension(swing: cd.Trajectory) -> None:
    data = swing.to_xarray()
    assert "sample" not in data.dims
    assert data.bending.dims == ("time", "joint")
    np.testing.assert_array_equal(data.time, swing.time)
    middle = data.sel(time=0.5, method="nearest")
    assert float(middle.position) == pytest.approx(float(swing.at(0.5).position[0]), rel=1e-12)
    for name in ("kinetic_energy", "potential_energy", "work", "elastic_energy"):
        assert data[name].dims == ("time",)
        assert data[name].attrs["units"] == "J"


def test_energies_and_work_balance(swing: cd.Trajectory) -> None:
    data = swing.to_xarray()
    energy = data.kinetic_energy + data.potential_energy - data.work
    assert float(np.ptp(energy.values)) < 1e-8 * float(data.kinetic_energy.max())
    # The motor's work by hand, less the damper's heat by the trapezoidal rule.
    heat = data.element_dissipation.sel(element="spring").values
    lost = np.concatenate([[0.0], np.cumsum(0.5 * (heat[1:] + heat[:-1]) * np.diff(swing.time))])
    gained = 0.4 * (data.position - data.position[0])
    np.testing.assert_allclose(data.work, gained - lost, atol=2e-3 * float(np.ptp(lost)))


def test_a_data_frame_has_times_and_energies_first(swing: cd.Trajectory) -> None:
    frame = swing.to_dataframe(motion=False)
    assert list(frame.columns[:7]) == [
        *("time", "position", "speed", "acceleration"),
        *("kinetic_energy", "potential_energy", "work"),
    ]
    np.testing.assert_array_equal(frame["time"], swing.time)
    np.testing.assert_array_equal(frame["kinetic_energy"], swing.kinetic_energy)
    assert {frame.attrs["units"][name] for name in ("kinetic_energy", "work")} == {"J"}
    assert frame.attrs["units"]["motor.element_effort"] == "N·m"
    text = io.StringIO()
    frame.to_csv(text, index=False)
    header = text.getvalue().splitlines()[0].split(",")
    assert header == list(frame.columns)


def test_attributes_tell_how_it_went(swing: cd.Trajectory) -> None:
    for attributes in (swing.to_xarray().attrs, swing.to_dataframe().attrs):
        assert attributes["method"] == swing.method
        assert attributes["energy_residual"] == swing.energy_residual
        assert [tuple(item) for item in json.loads(attributes["events"])] == list(swing.events)
        assert json.loads(attributes["notes"]) == list(swing.notes)
    assert swing.events


def test_they_go_through_files(swing: cd.Trajectory, tmp_path: Path) -> None:
    data = swing.to_xarray()
    data.to_netcdf(tmp_path / "swing.nc", engine="scipy")
    read = xarray.load_dataset(tmp_path / "swing.nc", engine="scipy")
    xarray.testing.assert_equal(read[["work", "bending"]], data[["work", "bending"]])


@pytest.mark.slow
def test_several_drives_and_a_single_time_have_tables_too() -> None:
    scene = cd.Scene(cd.load("stewart_platform"), free=[f"leg_{k}" for k in range(1, 7)])
    trajectory = scene.simulate(0.01)
    assert trajectory.to_xarray().position.dims == ("time", "drive")
    frame = trajectory.at(0.005).to_dataframe()
    assert len(frame) == 1
    assert frame.columns[0] == "time"
    assert "kinetic_energy" in frame
