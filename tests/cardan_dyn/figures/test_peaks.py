"""Peaks: their labels say value and place."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd


@pytest.mark.parametrize(
    ("torque", "text"), [(1e3, "364 "), (48250.0, "17.56 kN·m"), (1e9, "364 MN·m")]
)
def test_labels_have_four_digits_and_a_prefix(torque: float, text: str) -> None:
    """The output shaft is bent by its torque times the tangent of the joint angle, 20 degrees."""
    scene = universal(cd.load("universal_joint"), np.radians(20.0), -torque)
    turn = scene.sweep(np.linspace(0.0, 2.0 * np.pi, 73))
    figure = turn.plot("bearing_out", quantities=["bending"], peaks=True)
    (axes,) = figure.axes
    assert any(label.get_text().startswith(text) for label in axes.texts), [
        label.get_text() for label in axes.texts
    ]
