"""Peaks over parameters as drawn, against `clearance.influence`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import ArgumentError
from cardan_dyn.clearance import ImpactModel, influence
from cardan_dyn.motion.clearance import drawing

PAPER = ImpactModel(3.6, 1e7, 1e-4, 360e3, start="rest")
UNITS = {"speed": 1.0, "slope": 1e-3, "clearance": 1e6, "mass": 1.0, "stiffness": 1e-6}


@pytest.mark.slow
def test_bild_8(tmp_path: Path) -> None:
    both = {"paper": PAPER, "damped": replace(PAPER, damping_ratio=0.2)}
    figure = drawing.peak_influence(both, title="Bild 8")
    check_units_and_files(figure, tmp_path)
    assert len(figure.axes) == 5
    for axes, (name, unit) in zip(figure.axes, UNITS.items(), strict=True):
        assert axes.get_xlabel().startswith(name if name != "mass" else "reduced mass")
        assert axes.get_ylabel() == "two-mass peak [kN]"  # Not that of the pin in the plane.
        curve, point, *_ = axes.get_lines()
        expected = influence(PAPER, name)
        np.testing.assert_allclose(curve.get_xdata(), unit * expected.value)
        np.testing.assert_array_equal(curve.get_ydata(), expected.peak)
        ((at, peak),) = point.get_xydata()
        given = 1.0 if name == "speed" else getattr(PAPER, name)
        assert (at, peak) == pytest.approx((unit * given, 2181.89), rel=1e-5)


def test_one_panel_with_own_factors() -> None:
    figure = drawing.peak_influence(PAPER, "clearance", factors=[0.5, 1.0, 1.5])
    (axes,) = figure.axes
    assert axes.get_lines()[0].get_xdata() == pytest.approx([50.0, 100.0, 150.0])
    assert axes.get_xlabel() == "clearance 2s [µm]"
    with pytest.raises(ArgumentError, match="no reversal or no parameter"):
        drawing.peak_influence({}, "clearance")
    with pytest.raises(ArgumentError, match="'length' is unknown"):
        drawing.peak_influence(PAPER, "length")
