"""Responses draw the sweeps that they are evaluated to, families a line per design."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")


def test_a_response_is_drawn_over_a_period(joint: cd.Mechanism) -> None:
    response = universal(joint, 0.5, load=-2.0).response()
    (axes,) = response.plot("bearing_out", quantities="bending", speed=3.0).axes
    at = np.linspace(0.0, 360.0, 361)
    np.testing.assert_allclose(axes.lines[0].get_xdata(), at)
    expected = response.sweep(np.deg2rad(at), 3.0)["bearing_out"].bending
    np.testing.assert_allclose(axes.lines[0].get_ydata(), expected)
    assert len(response.plot.polar("bearing_out", ["parent", "joint"]).axes) == 2
    # Whole turns in even steps, as orders need them.
    assert response.plot.orders("bearing_out.bending", highest=4).axes[0].patches
    (axes,) = response.plot("drive_effort", position=[0.1, 0.2]).axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), np.rad2deg([0.1, 0.2]))


def test_each_design_of_a_family_is_a_line(joint: cd.Mechanism) -> None:
    angles = np.deg2rad([5.0, 10.0, 20.0])
    family = universal(joint, 0.5, load=-2.0).responses(held={"joint_angle": angles})
    (axes,) = family.plot("bearing_out.bending", title="three designs").axes
    labels = [line.get_label() for line in axes.lines]
    assert labels == ["joint_angle 5°", "joint_angle 10°", "joint_angle 20°"]
    peaks = [line.get_ydata().max() for line in axes.lines]
    # The greatest bending of the output shaft is the load by the sine of the angle at the cross.
    assert peaks == pytest.approx(2.0 * np.tan(angles), rel=1e-6)
    with pytest.raises(cd.ArgumentError, match="name one joint or column"):
        family.plot()
    many = universal(joint, 0.5).responses(held={"joint_angle": np.linspace(0.1, 0.5, 9)})
    with pytest.raises(cd.ArgumentError, match="9 designs are more lines"):
        many.plot("bearing_out")
