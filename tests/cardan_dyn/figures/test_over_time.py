"""Lines over time: wrenches and energies of trajectories, and the residual of their balance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures


@pytest.fixture(scope="module")
def swing() -> cd.Trajectory:
    spring = cd.JointSpring("rocker_bearing", 50.0, 0.1, 0.2)
    scene = cd.Scene(
        cd.load("four_bar"),
        free="crank_bearing",
        gravity=(0.0, -9.81, 0.0),
        elements=[spring],
    )
    return scene.simulate(0.5, position=1.0).evenly(41)


@pytest.mark.slow
def test_wrenches_are_drawn_over_time(swing: cd.Trajectory, tmp_path: Path) -> None:
    figure = figures.over_time(swing, ["crank_pin", "rocker_pin"], ["shear", "bending"], title="t")
    check_units_and_files(figure, tmp_path)
    for quantity, axes in zip(("shear", "bending"), figure.axes, strict=True):
        for name, line in zip(("crank_pin", "rocker_pin"), axes.get_lines(), strict=True):
            np.testing.assert_array_equal(line.get_xdata(), swing.time)
            np.testing.assert_array_equal(line.get_ydata(), getattr(swing[name], quantity))
    assert figure.axes[-1].get_xlabel() == "time [s]"
    assert figure.axes[-1].get_xlim() == (0.0, 0.5)


def test_a_sweep_needs_times() -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    times = np.array([0.0, 0.1, 0.4])
    figure = figures.over_time(scene.sweep([0.0, 0.1, 0.2], time=times), "crank_pin")
    np.testing.assert_array_equal(figure.axes[0].get_lines()[0].get_xdata(), times)
    with pytest.raises(cd.ArgumentError, match=r"no times.*over_angle"):
        figures.over_time(scene.sweep([0.0, 0.1, 0.2]), "crank_pin")
    grid = scene.sweep([0.0, 0.1, 0.2], speed=[[1.0], [2.0]], time=times)
    with pytest.raises(cd.ArgumentError, match="one dimension"):
        figures.over_time(grid, "crank_pin")


@pytest.mark.slow
def test_energies_and_the_residual_of_their_balance(swing: cd.Trajectory, tmp_path: Path) -> None:
    figure = figures.energy_over_time(swing)
    check_units_and_files(figure, tmp_path)
    above, below = figure.axes
    kinetic, potential, work = (line.get_ydata() for line in above.get_lines())
    np.testing.assert_array_equal(kinetic, swing.kinetic_energy)
    assert potential[0] == work[0] == 0.0
    (line,) = below.get_lines()
    expected = np.abs(kinetic + potential - work) / swing.energy_scale  # It starts from rest.
    np.testing.assert_allclose(line.get_ydata(), np.maximum(expected, 1e-16), rtol=1e-12)
    assert np.max(line.get_ydata()) == pytest.approx(swing.energy_residual, rel=1e-6)
    assert below.get_yscale() == "log"
    later = figures.energy_over_time(swing.at(swing.time[20:]))
    assert np.max(later.axes[1].get_lines()[0].get_ydata()) < 10.0 * swing.energy_residual


def test_only_trajectories_have_energies() -> None:
    sweep = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep([0.0, 0.1])
    with pytest.raises(cd.ArgumentError, match="not of a Sweep"):
        figures.energy_over_time(sweep)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_single_time_is_drawn_as_a_point(swing: cd.Trajectory, tmp_path: Path) -> None:
    check_units_and_files(figures.over_time(swing.at(0.2), "crank_pin"), tmp_path)
