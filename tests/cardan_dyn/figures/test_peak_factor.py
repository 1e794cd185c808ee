"""f(τ): lines against the printed limits, points against the scan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

import cardan_dyn as cd
from cardan_dyn.clearance import ImpactModel, scan
from cardan_dyn.motion.clearance import drawing


@pytest.mark.slow
def test_points_lie_on_their_lines(tmp_path: Path) -> None:
    drive = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    found = scan(drive, 300.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.25)
    figure = drawing.peak_factor(found)
    check_units_and_files(figure, tmp_path)
    lines = {line.get_label(): line for line in figure.axes[0].get_lines()}
    damped = lines["from release, damping ratio 0.25"].get_xydata()
    striking = [name for name in found.ranking if found[name].impacts]
    assert len(striking) == 4
    for name in striking:
        ((tau, value),) = lines[name].get_xydata()
        worst = found[name].worst
        assert worst is not None
        assert (tau, value) == pytest.approx((worst.tau, worst.two_mass_peak / (1e8 * 0.5e-4)))
        known = np.isfinite(damped[:, 1])
        on_line = np.interp(np.log(tau), *np.log(damped[known]).T)
        assert np.log(value) == pytest.approx(on_line, abs=2e-3)


def test_bild_5() -> None:
    paper = ImpactModel(3.6, 1e7, 1e-4, 360e3, start="rest")
    (axes,) = drawing.peak_factor({"example": paper}).axes
    lines = {line.get_label(): line.get_xydata() for line in axes.get_lines()}
    assert lines["example"][0] == pytest.approx([3.02853, 2181.89 / 500.0], rel=1e-5)
    tau, rest = lines["from rest"].T
    assert np.interp(2.0, tau, rest) == pytest.approx(3.0 + 3.0 + 3.0 * np.pi / 2, rel=1e-3)
    release = lines["from release"][:, 1]
    assert np.isnan(release[tau < 1.83]).all() and np.isfinite(release[tau > 1.85]).all()
    assert len(drawing.peak_factor().axes[0].get_lines()) == 4
