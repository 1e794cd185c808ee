"""Orders: amplitudes of known oscillations, Parseval's theorem, and the bars that show them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures

TURN = np.linspace(0.0, 2.0 * np.pi, 73)


def test_order_amplitudes() -> None:
    for angle in (
        np.linspace(0.0, 4.0 * np.pi, 181),
        np.linspace(0.0, 4.0 * np.pi, 180, endpoint=False),
        np.linspace(1.0, 1.0 + 4.0 * np.pi, 180, endpoint=False),
    ):
        values = -2.0 + 3.0 * np.cos(2.0 * angle + 0.3) - 0.5 * np.sin(4.5 * angle)
        orders, amplitudes = figures.order_amplitudes(angle, values)
        expected = np.zeros_like(orders)
        expected[orders == 0.0], expected[orders == 2.0], expected[orders == 4.5] = 2.0, 3.0, 0.5
        np.testing.assert_allclose(amplitudes, expected, atol=1e-13)
    # The highest order of an even number of samples occurs once.
    _, amplitudes = figures.order_amplitudes(0.5 * np.pi * np.arange(4), [1.0, -1.0, 1.0, -1.0])
    np.testing.assert_allclose(amplitudes, [0.0, 0.0, 1.0], atol=1e-15)


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=40))
def test_mean_square_is_that_of_the_amplitudes(values: list[float]) -> None:
    """Parseval: an oscillation adds half the square of its amplitude, the highest order of an
    even count its whole square, since it is sampled at its peaks alone.
    """
    count = len(values)
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    orders, amplitudes = figures.order_amplitudes(angle, values)
    np.testing.assert_array_equal(orders, np.arange(count // 2 + 1))
    share = np.full(len(orders), 0.5)
    share[0] = 1.0
    if count % 2 == 0:
        share[-1] = 1.0
    square = np.mean(np.square(values))
    assert np.sum(share * amplitudes**2) == pytest.approx(square, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize(
    "angle", [np.linspace(0.0, 3.0, 50), [0.0, 1.0, 3.0, 6.0], [0.0, 1.0], [2.0, 1.0, 0.0]]
)
def test_orders_need_whole_turns(angle: Any) -> None:
    with pytest.raises(cd.ArgumentError, match="orders need"):
        figures.order_amplitudes(angle, np.zeros(len(angle)))


@pytest.mark.parametrize(
    ("angle", "count", "message"),
    [
        ([0.0, 1.0], 2, r"at least 3 angles and as many values, not \(2,\) and \(2,\)$"),
        (TURN, 72, r"at least 3 angles and as many values, not \(73,\) and \(72,\)$"),
        (TURN[::-1], 73, "angles that rise evenly$"),
        (np.square(TURN), 73, "angles that rise evenly$"),
        (np.zeros(5), 5, "angles that rise evenly$"),
        (np.linspace(0.0, 3.0 * np.pi, 31), 31, r"whole turns, the angles cover 1\.55$"),
        (np.linspace(0.0, 1e-12, 5), 5, r"whole turns, the angles cover 1\.98944e-13$"),
    ],
)
def test_the_message_names_what_is_wrong_with_the_angles(
    angle: Any, count: int, message: str
) -> None:
    with pytest.raises(cd.ArgumentError, match="^orders need " + message):
        figures.order_amplitudes(angle, np.zeros(count))


@pytest.mark.slow
def test_bars_are_the_amplitudes(tmp_path: Path) -> None:
    values = {"a": 2.0 * np.sin(2.0 * TURN), "b": 1.0 + 0.5 * np.cos(3.0 * TURN)}
    figure = figures.order_spectrum(TURN, values, unit="N·m", highest=4, title="orders")
    check_units_and_files(figure, tmp_path)
    (axes,) = figure.axes
    assert axes.get_title() == "orders" and axes.get_ylabel() == "amplitude [N·m]"
    first, second = axes.containers
    np.testing.assert_allclose([bar.get_height() for bar in first], [0, 0, 2, 0, 0], atol=1e-14)
    np.testing.assert_allclose([bar.get_height() for bar in second], [1, 0, 0, 0.5, 0], atol=1e-14)
    # Both bars of an order stand side by side around it, and differ without colours.
    for order, (left, right) in enumerate(zip(first, second, strict=True)):
        assert left.get_x() + left.get_width() == pytest.approx(order)
        assert right.get_x() == pytest.approx(order)
    assert first[0].get_hatch() != second[0].get_hatch()
    assert axes.get_yscale() == "linear"


@pytest.mark.slow
def test_a_logarithmic_scale_ends_above_rounding(joint_turn: cd.Sweep, tmp_path: Path) -> None:
    bending = joint_turn.wrench("bearing_out", "parent").moment
    angle = joint_turn.motion.position("bearing_in")
    figure = figures.order_spectrum(
        angle, {"y": bending[:, 1], "z": bending[:, 2]}, unit="N·m", logarithmic=True
    )
    check_units_and_files(figure, tmp_path)
    (axes,) = figure.axes
    greatest = max(bar.get_height() for bars in axes.containers for bar in bars)
    assert axes.get_yscale() == "log"
    assert axes.get_ylim()[0] == pytest.approx(1e-6 * greatest)
