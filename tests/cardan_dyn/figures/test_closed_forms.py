"""Closed forms drawn as lines: against the points of the sweeps and against each other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures
from cardan_dyn.practice.report import closed_forms

CLOSED = ("torque_ratio", "thoma_bending", "speed_ratio", "bending_polar")
ODD_SWEEPS = {
    "from elsewhere": (np.linspace(1.0, 4.0, 37), -50.0),
    "100 samples": (np.linspace(0.0, 2.0 * np.pi, 100), -100.0),
    "one sample": (np.array([2.0]), -1e-3),
    "driving load": (np.linspace(-7.0, 9.0, 33), 70.0),
    "in any order": (np.array([5.0, 1.0, 30.0, 2.5]), np.array([1.0, -2.0, 3.0, 0.0])),
}


def drawn(name: str, joint_turn: cd.Sweep, shaft_turn: cd.Sweep) -> Any:
    turns = (joint_turn, shaft_turn) if name == "speed_ratio" else (joint_turn,)
    return getattr(closed_forms, name)(*turns)


def lines_of(figure: Any) -> list[np.ndarray]:
    """Ordinates of the closed forms: the lines, without the points between them."""
    return [line.get_ydata() for line in figure.axes[0].get_lines()[::2]]


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSED)
def test_figures_have_units(
    name: str, joint_turn: cd.Sweep, shaft_turn: cd.Sweep, tmp_path: Path
) -> None:
    figure = drawn(name, joint_turn, shaft_turn)
    check_units_and_files(figure, tmp_path)
    assert figure.axes[0].get_title().endswith(", β = 50°")


@pytest.mark.slow
@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("case", ODD_SWEEPS)
def test_points_lie_on_the_lines_of_any_sweep(
    name: str, case: str, joint: cd.Mechanism, shaft: cd.Mechanism, tmp_path: Path
) -> None:
    """Angles and torques are the sweep's own, wherever it starts and whatever its load."""
    positions, load = ODD_SWEEPS[case]
    beta = 0.6
    scenes = [
        cd.Scene(
            mechanism,
            drive="bearing_in",
            held=dict.fromkeys(held, beta),
            loads={"bearing_out": load},
        )
        for mechanism, held in (
            (joint, ("joint_angle",)),
            (shaft, ("joint_angle_1", "joint_angle_2")),
        )
    ]
    swept = [scene.sweep(positions) for scene in scenes]
    figure = drawn(name, *swept)
    figures.save(figure, tmp_path / "figure")
    lines, points = figure.axes[0].get_lines()[::2], figure.axes[0].get_lines()[1::2]
    assert len(lines) == len(points) == (1 if name == "torque_ratio" else 2)
    for line, computed in zip(lines, points, strict=True):
        angle, value = computed.get_xydata().T
        if name != "speed_ratio" and len(angle) == len(positions):
            # Where no torque passes there is no ratio.
            loaded = np.broadcast_to(load, len(angle)) != 0.0
            np.testing.assert_array_equal(np.isfinite(value), loaded)
        x, y = line.get_xydata().T
        if name == "bending_polar":
            x, angle = x % (2.0 * np.pi), angle % (2.0 * np.pi)
            y = y[np.argsort(x)]
            x = np.sort(x)
            expected = np.interp(angle, x, y, period=2.0 * np.pi)
        else:
            assert np.all((angle >= x[0] - 1e-9) & (angle <= x[-1] + 1e-9))
            low, high = figure.axes[0].get_xlim()
            assert low <= np.min(angle) and np.max(angle) <= high
            expected = np.interp(angle, x, y)
        known = np.isfinite(value)
        np.testing.assert_allclose(value[known], expected[known], atol=1e-4)
    if name != "bending_polar":
        swept_angles = np.rad2deg(swept[0].motion.position("bearing_in"))
        assert np.all(np.isin(points[0].get_xdata(), swept_angles))


def test_lines_keep_the_power(joint_turn: cd.Sweep, shaft_turn: cd.Sweep) -> None:
    """Without losses D₁ ω₁ = D₂ ω₂; a double shaft with equal angles turns evenly."""
    (torque,) = lines_of(closed_forms.torque_ratio(joint_turn))
    speed, even = lines_of(closed_forms.speed_ratio(joint_turn, shaft_turn))
    np.testing.assert_allclose(torque * speed, 1.0, rtol=1e-13)
    np.testing.assert_array_equal(even, 1.0)


def test_lines_are_components_of_one_moment(joint_turn: cd.Sweep) -> None:
    """The cross passes one moment on: D₁² + B₁² = D₂² + B₂², and B₂ is Thoma's M_x and M_z."""
    (torque,) = lines_of(closed_forms.torque_ratio(joint_turn))
    bending_1, bending_2 = lines_of(closed_forms.bending_polar(joint_turn))
    np.testing.assert_allclose(1.0 + bending_1**2, torque**2 + bending_2**2, rtol=1e-12)
    m_x, m_z = lines_of(closed_forms.thoma_bending(joint_turn))
    np.testing.assert_allclose(np.hypot(m_x, m_z), bending_2 / torque, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("beta", [0.02, 0.3, 0.9, 1.4])
def test_circles_of_a_polar_diagram_are_round_and_contain_it(
    beta: float, joint: cd.Mechanism
) -> None:
    held = {"joint_angle": beta}
    scene = cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": 1.0})
    figure = closed_forms.bending_polar(scene.sweep(np.linspace(0.0, 2.0 * np.pi, 9)))
    circles = figure.axes[0].get_yticks()
    np.testing.assert_allclose(np.diff(circles), circles[0])
    # The greatest ratio is B₁/D₁ = tan β.
    assert circles[-1] >= np.tan(beta) * (1.0 - 1e-12)
    assert circles[-1] < 2.0 * np.tan(beta)
    assert len(f"{circles[0]:.12g}".replace(".", "").strip("0")) <= 2


def test_a_single_position_is_drawn_in_its_turn(joint: cd.Mechanism) -> None:
    held = {"joint_angle": 0.5}
    scene = cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": 1.0})
    axes = closed_forms.torque_ratio(scene.sweep([7.0])).axes[0]
    assert axes.get_xlim() == pytest.approx((360.0, 720.0))
    assert len(axes.get_lines()[0].get_xdata()) > 360


def test_a_short_range_is_still_smooth(joint: cd.Mechanism) -> None:
    held = {"joint_angle": 0.5}
    scene = cd.Scene(joint, drive="bearing_in", held=held, loads={"bearing_out": 1.0})
    line = closed_forms.torque_ratio(scene.sweep([0.0, 0.01])).axes[0].get_lines()[0]
    assert len(line.get_xdata()) > 90


def test_closed_forms_need_a_torque(joint_without_load: cd.Sweep) -> None:
    for draw in (closed_forms.torque_ratio, closed_forms.thoma_bending, closed_forms.bending_polar):
        with pytest.raises(cd.ArgumentError, match=r"no torque passes .* load 'bearing_out'"):
            draw(joint_without_load)


def test_closed_forms_need_a_held_joint_angle(shaft_turn: cd.Sweep) -> None:
    message = (
        "the closed forms need a universal joint whose 'joint_angle' is held; held: "
        "joint_angle_1, joint_angle_2"
    )
    for draw in (closed_forms.torque_ratio, closed_forms.thoma_bending, closed_forms.bending_polar):
        with pytest.raises(cd.ArgumentError, match=message):
            draw(shaft_turn)
    with pytest.raises(cd.ArgumentError, match=message):
        closed_forms.speed_ratio(shaft_turn, shaft_turn)


@pytest.mark.slow
def test_compared_gives_a_label_one_colour(tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    computed = {"a": np.sin(angle), "only computed": np.cos(angle)}
    closed = {"only closed": np.zeros(73), "a": np.sin(angle)}
    figure = figures.compared(angle, computed, closed, quantity="M [N·m]", title="both", points=12)
    check_units_and_files(figure, tmp_path)
    (axes,) = figure.axes
    assert axes.get_title() == "both"
    drawn_lines = {line.get_label(): line for line in axes.get_lines()}
    assert list(drawn_lines) == [
        *("only closed", "a, closed form", "a, Pinocchio", "only computed, Pinocchio")
    ]
    colours = {label: line.get_color() for label, line in drawn_lines.items()}
    assert colours["a, closed form"] == colours["a, Pinocchio"]
    assert len(set(colours.values())) == 3
    points = drawn_lines["a, Pinocchio"]
    np.testing.assert_allclose(points.get_xdata(), np.arange(0.0, 361.0, 30.0))
    np.testing.assert_allclose(
        points.get_ydata(), np.sin(np.deg2rad(points.get_xdata())), atol=1e-15
    )
    assert points.get_linestyle() == "None"
