"""Force elements in tables: values computed by hand from positions, with names and units."""

from __future__ import annotations

import numpy as np
import pytest

import cardan_dyn as cd

ANGLES = np.array([0.3, 1.1, 2.0])
TIMES = np.array([0.0, 0.5, 0.7])


@pytest.fixture(scope="module")
def four_bar() -> cd.Sweep:
    elements = [
        cd.PointSpring("crank", (0.1, 0.0, 0.0), "base", (0.0, 0.4, 0.0), 50.0, 3.0, 0.2, "coil"),
        cd.JointSpring("rocker_bearing", 5.0, 0.5, 0.2),
        cd.Bushing("coupler", "base", (0.1, 0.0, 0.0), [3e3] * 3 + [5.0] * 3, name="rubber"),
        cd.Actuator("crank_bearing", lambda time: 2.0 * time, name="motor"),
    ]
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=elements)
    return scene.sweep(ANGLES, speed=4.0, time=TIMES)


def test_a_dataset_has_elements_by_name(four_bar: cd.Sweep) -> None:
    data = four_bar.to_xarray()
    assert list(data.element.values) == ["coil", "elements[1]", "rubber", "motor"]
    np.testing.assert_array_equal(data.time, TIMES)
    assert data.time.attrs["units"] == "s"
    efforts = data.element_effort
    np.testing.assert_array_equal(efforts.sel(joint_element="motor"), 2.0 * TIMES)
    motion = four_bar.motion
    turn = motion.position("rocker_bearing") - 0.2
    expected = -5.0 * turn - 0.5 * motion.velocity("rocker_bearing")
    np.testing.assert_allclose(efforts.sel(joint_element="elements[1]"), expected, rtol=1e-14)
    energies = data.element_energy
    np.testing.assert_allclose(energies.sel(element="elements[1]"), 2.5 * turn**2, rtol=1e-13)
    assert not np.any(energies.sel(element="motor"))
    np.testing.assert_allclose(data.elastic_energy, energies.sum("element"), rtol=1e-14)
    heat = data.element_dissipation.sel(element="elements[1]")
    np.testing.assert_allclose(heat, 0.5 * motion.velocity("rocker_bearing") ** 2, rtol=1e-13)


def test_a_spring_between_points_has_its_tension_length_and_force(four_bar: cd.Sweep) -> None:
    data = four_bar.to_xarray().sel(point_spring="coil")
    # The crank turns about the origin: its point is where the sweep says that its frame is.
    point = four_bar.origin("crank_bearing") + four_bar.rotation("crank_bearing") @ [0.1, 0.0, 0.0]
    span = np.array([0.0, 0.4, 0.0]) - point
    length = np.linalg.norm(span, axis=1)
    np.testing.assert_allclose(data.element_length, length, rtol=1e-14)
    spin = four_bar.rotation("crank_bearing") @ four_bar.mechanism.joints["crank_bearing"].axis
    rate = -np.sum(span / length[:, None] * np.cross(4.0 * spin, point), axis=1)
    tension = 50.0 * (length - 0.2) + 3.0 * rate
    np.testing.assert_allclose(data.element_tension, tension, rtol=1e-12)
    force = tension[:, None] * span / length[:, None]
    np.testing.assert_allclose(data.element_force, force, rtol=1e-12, atol=1e-12)


def test_a_bushing_has_its_wrench_by_component(four_bar: cd.Sweep) -> None:
    data, force = four_bar.to_xarray().sel(bushing="rubber"), four_bar.element_force["rubber"]
    np.testing.assert_array_equal(
        data.element_wrench.sel(wrench_component="force y"), force.wrench[:, 1]
    )
    moved = data.element_deformation.sel(deformation_component="turn_z")
    np.testing.assert_array_equal(moved, force.deformation[:, 5])
    # Without damping, the elastic force is the stiffness times the deformation.
    np.testing.assert_allclose(force.wrench[:, 0], -3e3 * force.deformation[:, 0], rtol=1e-14)


def test_a_data_frame_has_a_column_per_value(four_bar: cd.Sweep) -> None:
    frame = four_bar.to_dataframe()
    units = frame.attrs["units"]
    for column, unit in {
        "time": "s",
        "coil.element_tension": "N",
        "coil.element_length": "m",
        "coil.element_force_x": "N",
        "rubber.element_wrench_force_x": "N",
        "rubber.element_wrench_moment_z": "N·m",
        "rubber.element_deformation_x": "m",
        "rubber.element_deformation_turn_x": "rad",
        "motor.element_effort": "N·m",
        "elements[1].element_energy": "J",
        "coil.element_dissipation": "W",
        "elastic_energy": "J",
    }.items():
        assert units[column] == unit
        assert frame[column].notna().all()
    np.testing.assert_array_equal(frame["motor.element_effort"], 2.0 * TIMES)
    wrench = four_bar.element_force["rubber"].wrench
    np.testing.assert_array_equal(frame["rubber.element_wrench_moment_z"], wrench[:, 5])


def test_efforts_along_slides_are_forces() -> None:
    mechanism = cd.load("slider_crank")
    slide = next(name for name, item in mechanism.drivable.items() if item.slides)
    turn = next(name for name, item in mechanism.drivable.items() if not item.slides)
    elements = [cd.Actuator(slide, 3.0, name="push"), cd.Actuator(turn, 4.0, name="twist")]
    sweep = cd.Scene(mechanism, drive=turn, elements=elements).sweep(ANGLES)
    assert list(sweep.to_xarray().effort_unit.values) == ["N", "N·m"]
    assert sweep.to_dataframe().attrs["units"]["push.element_effort"] == "N"


def test_on_a_grid_they_have_its_shape() -> None:
    scene = cd.Scene(
        cd.load("four_bar"),
        drive="crank_bearing",
        elements=[cd.Actuator("rocker_bearing", lambda time: 2.0 * time, name="motor")],
    )
    grid = scene.sweep(ANGLES, speed=np.array([[1.0], [2.0]]), time=TIMES)
    data = grid.to_xarray()
    assert data.element_effort.dims == ("sample_0", "sample_1", "joint_element")
    assert data.time.dims == ("sample_1",)
    np.testing.assert_array_equal(data.element_effort[..., 0], np.tile(2.0 * TIMES, (2, 1)))


def test_without_elements_there_is_nothing() -> None:
    sweep = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(ANGLES)
    assert sweep.table().labels["element"] == ()
    data = sweep.to_xarray()
    assert not [name for name in (*data.variables, *data.dims) if str(name).startswith("element")]
    assert "time" not in data.variables


def test_a_name_that_another_element_gets_is_refused() -> None:
    elements = [
        cd.JointSpring("rocker_bearing", 1.0),
        cd.JointSpring("crank_bearing", 1.0, name="elements[0]"),
    ]
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=elements)
    with pytest.raises(cd.ModelError, match=r"'elements\[0\]'.*another name"):
        scene.sweep(ANGLES).to_dataframe()
