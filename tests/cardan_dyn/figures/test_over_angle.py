"""Lines over the angle: the sweep's own values, in degrees, with one axes per quantity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures


@pytest.mark.slow
def test_figures_have_units(
    joint_turn: cd.Sweep, shaft_turn: cd.Sweep, needle_turn: cd.Sweep, tmp_path: Path
) -> None:
    for figure in (
        figures.over_angle(joint_turn, ["bearing_in", "bearing_out"]),
        figures.over_angle(needle_turn, "needle_pin", ["shear", "axial"]),
        figures.ratio_and_angle_error({"a": joint_turn, "b": shaft_turn}),
    ):
        check_units_and_files(figure, tmp_path)


def test_each_joint_is_a_line_in_each_quantity(joint_turn: cd.Sweep) -> None:
    joints = ["bearing_in", "bearing_out"]
    figure = figures.over_angle(joint_turn, joints, title="wrenches")
    for quantity, axes in zip(("torsion", "bending"), figure.axes, strict=True):
        assert axes.get_ylabel() == f"{quantity} [N·m]"
        for name, line in zip(joints, axes.get_lines(), strict=True):
            assert line.get_label() == name
            angle = np.rad2deg(joint_turn.motion.position("bearing_in"))
            np.testing.assert_array_equal(line.get_xdata(), angle)
            np.testing.assert_array_equal(line.get_ydata(), getattr(joint_turn[name], quantity))
    assert figure.axes[-1].get_xlabel() == "bearing_in [°]"
    assert figure.get_suptitle() == "wrenches"


def test_forces_are_in_newtons_over_any_joint(needle_turn: cd.Sweep) -> None:
    figure = figures.over_angle(needle_turn, "needle_pin", "shear", drive="rocker_bearing")
    (axes,) = figure.axes
    assert axes.get_ylabel() == "shear [kN]" and axes.get_xlabel() == "rocker_bearing [°]"
    (line,) = axes.get_lines()
    rocker = np.rad2deg(needle_turn.motion.position("rocker_bearing"))
    np.testing.assert_array_equal(line.get_xdata(), rocker)
    force = needle_turn["needle_pin"].force
    axis = needle_turn.mechanism.joint("needle_pin").axis
    across = np.linalg.norm(np.cross(force, axis), axis=1)
    np.testing.assert_allclose(line.get_ydata(), across, rtol=1e-12)


def test_unknown_quantities_and_joints_are_refused(joint_turn: cd.Sweep) -> None:
    with pytest.raises(cd.ArgumentError, match="quantity 'twist' is unknown"):
        figures.over_angle(joint_turn, "bearing_in", "twist")
    with pytest.raises(cd.ModelError, match="bearing_on"):
        figures.over_angle(joint_turn, "bearing_on")
    with pytest.raises(cd.ArgumentError, match="there is no sweep to be drawn"):
        figures.ratio_and_angle_error({})


def test_speed_ratio_and_lead_of_a_universal_joint(joint_turn: cd.Sweep) -> None:
    """The speed ratio lies between cos β and 1/cos β, the sine of the lead between
    ±(1 - cos β)/(1 + cos β).
    """
    ratio, lead = figures.ratio_and_angle_error({"joint": joint_turn}).axes
    cosine = np.cos(joint_turn.held["joint_angle"])
    speeds = ratio.get_lines()[0].get_ydata()
    assert np.min(speeds) == pytest.approx(cosine)
    assert np.max(speeds) == pytest.approx(1.0 / cosine)
    leads = lead.get_lines()[0].get_ydata()
    greatest = np.rad2deg(np.arcsin((1.0 - cosine) / (1.0 + cosine)))
    # A position every half degree misses the extreme by some 1e-5 of it.
    assert np.max(leads) == pytest.approx(greatest, rel=1e-4)
    assert np.min(leads) == pytest.approx(-greatest, rel=1e-4)
    assert ratio.get_ylabel() == "speed ratio ω₂/ω₁ [–]"
    assert lead.get_ylabel() == "angle error φ₂ − φ₁ [°]"


def test_a_constant_lead_is_left_out(shaft_turn: cd.Sweep) -> None:
    """The mean over a whole turn is zero; its last position repeats the first."""
    _, lead = figures.ratio_and_angle_error({"shaft": shaft_turn}, output="slip").axes
    slip = np.rad2deg(shaft_turn.motion.position("slip"))
    angle = np.rad2deg(shaft_turn.motion.position("bearing_in"))
    drawn = lead.get_lines()[0].get_ydata()
    np.testing.assert_allclose(np.diff(drawn), np.diff(slip - angle), atol=1e-10)
    assert np.mean(drawn[:-1]) == pytest.approx(0.0, abs=1e-10)


@pytest.mark.slow
def test_one_sample_is_drawn(one_position: cd.Sweep, tmp_path: Path) -> None:
    """A line of one point would not be seen."""
    for figure in (
        figures.over_angle(one_position, "bearing_out"),
        figures.ratio_and_angle_error({"a": one_position}),
    ):
        figures.save(figure, tmp_path / "one")
        assert all(axes.get_lines()[0].get_marker() == "o" for axes in figure.axes)


def test_all_sweeps_of_a_figure_are_within_its_range(joint_turn: cd.Sweep) -> None:
    scene = cd.Scene(
        joint_turn.mechanism,
        drive="bearing_in",
        held=joint_turn.held,
        loads={"bearing_out": 1.0},
    )
    figure = figures.ratio_and_angle_error({"long": joint_turn, "short": scene.sweep([1.0, 2.0])})
    low, high = figure.axes[1].get_xlim()
    assert low <= 0.0 and high >= 360.0 - 1e-9


def test_lines_differ_without_colours(joint_turn: cd.Sweep, shaft_turn: cd.Sweep) -> None:
    figure = figures.ratio_and_angle_error({"a": joint_turn, "b": shaft_turn})
    for axes in figure.axes:
        shown = {line.get_linestyle() for line in axes.get_lines()}
        assert len(shown) == 2


@pytest.fixture(scope="module")
def spin(joint: cd.Mechanism) -> cd.Trajectory:
    """Free spin of the universal joint, over two turns of its input and somewhat more."""
    scene = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.6})
    return scene.simulate(1.4, speed=10.0)


def test_a_trajectory_is_drawn_over_the_angle(spin: cd.Trajectory) -> None:
    figure = figures.over_angle(spin, "bearing_out")
    torsion, bending = figure.axes
    angle = np.rad2deg(spin.motion.position("bearing_in"))
    np.testing.assert_array_equal(bending.get_lines()[0].get_xdata(), angle)
    np.testing.assert_array_equal(bending.get_lines()[0].get_ydata(), spin["bearing_out"].bending)
    # Nothing drives it: torsion is rounding, and drawn as the zero that it is.
    assert np.max(np.abs(spin["bearing_out"].torsion)) < 1e-12
    assert torsion.get_ylim()[1] == pytest.approx(np.max(np.abs(spin["bearing_out"].moment)))


def test_the_mean_lead_of_a_trajectory_is_that_over_the_angle(spin: cd.Trajectory) -> None:
    angles = spin.motion.position("bearing_in")
    turn = 2.0 * np.pi
    # Two whole turns, at times that crowd together at their start.
    times = np.concatenate([np.linspace(0.0, 0.2, 4000), np.linspace(0.2, 1.4, 4000)[1:]])
    dense = spin.at(times)
    times = times[dense.motion.position("bearing_in") <= 2.0 * turn]
    assert angles[-1] > 2.0 * turn
    lead = figures.ratio_and_angle_error({"spin": spin.at(times)}).axes[1].get_lines()[0]
    # Without its mean, the lead of a universal joint is as great as its lag.
    assert np.max(lead.get_ydata()) == pytest.approx(-np.min(lead.get_ydata()), rel=1e-3)


def test_a_slide_is_drawn_in_millimetres() -> None:
    positions = np.linspace(-0.05, -0.03, 5)
    sweep = cd.Scene(
        cd.load("slider_crank"), drive="piston_guide", near={"crank_bearing": 1.2}
    ).sweep(positions)
    figure = figures.over_angle(sweep, "crank_pin", "shear")
    (panel,) = figure.axes
    assert panel.get_xlabel() == "piston_guide [mm]"
    np.testing.assert_allclose(panel.lines[0].get_xdata(), positions)
    with pytest.raises(cd.ArgumentError, match="drive 'piston_guide' slides"):
        figures.ratio_and_angle_error({"": sweep}, output="crank_bearing")


def test_sweeps_whole_turns_apart_lie_over_each_other(joint: cd.Mechanism) -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 37)
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    turns = {"first": scene.sweep(angles), "sixth": scene.sweep(angles + 10.0 * np.pi)}
    for panel in figures.ratio_and_angle_error(turns).axes:
        first, sixth = panel.get_lines()
        np.testing.assert_allclose(first.get_xdata(), sixth.get_xdata(), atol=1e-9)
        np.testing.assert_allclose(first.get_ydata(), sixth.get_ydata(), atol=1e-9)


@pytest.mark.parametrize("option", ["peak", "colour"])
def test_options_that_a_figure_has_not_are_told_with_those_that_it_has(
    joint_turn: cd.Sweep, option: str
) -> None:
    told = rf"no option '{option}' of over_angle; options: .*figsize.*peaks.*title"
    with pytest.raises(cd.ArgumentError, match=told):
        figures.over_angle(joint_turn, "bearing_in", **{option: True})  # type: ignore[arg-type]
