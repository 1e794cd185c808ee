"""Results as points over closed forms as lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures


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
