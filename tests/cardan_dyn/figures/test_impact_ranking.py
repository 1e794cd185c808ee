"""The ranking of impacts as bars and points, against the scan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

import cardan_dyn as cd
from cardan_dyn import ArgumentError, figures
from cardan_dyn.clearance import Scan, drawing, scan


def test_bars_are_forces_and_points_what_less_would_buy(tmp_path: Path) -> None:
    loads = {"piston_guide": -300.0}
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads=loads)
    found = scan(scene, 120.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.2)
    figure = drawing.impact_ranking(found)
    assert all(path.stat().st_size > 5000 for path in figures.save(figure, tmp_path / "ranking"))
    forces, effects = figure.axes
    assert [label.get_text() for label in forces.get_yticklabels()] == found.ranking
    widths = [bar.get_width() for bar in forces.patches]
    joints = [found[name] for name in found.ranking]
    kinds = "peak", "rigid_peak"
    assert widths == pytest.approx([getattr(joint, kind) for kind in kinds for joint in joints])
    # Each bar has the interval of its peak, and is as long as the text says.
    (intervals,) = [found for found in forces.containers if hasattr(found, "has_xerr")]
    ends = [segment[:, 0].tolist() for segment in intervals.lines[2][0].get_segments()]
    assert np.ravel(ends) == pytest.approx(np.ravel([(one.least, one.peak) for one in joints]))
    for width, joint in zip(widths, joints, strict=False):
        assert f"{width:.4g} N at most" in joint.summary
    assert forces.get_xlabel() == "force [N]"
    assert effects.get_xlabel() == "change of the two-mass peak with 10 % less [%]"
    # The first joint stands at the top.
    assert forces.get_ylim()[0] > forces.get_ylim()[1]
    for line in effects.get_lines()[:5]:
        name = line.get_label().removeprefix("less ")
        for value, joint in zip(line.get_xdata(), joints, strict=True):
            assert joint.worst is not None
            exponent = getattr(joint.worst.exponents, name)
            expected = 100.0 * (0.9**exponent - 1.0) if joint.worst.strikes else np.nan
            assert value == pytest.approx(expected, nan_ok=True)


def test_nothing_to_be_ranked() -> None:
    with pytest.raises(ArgumentError, match="no joint was scanned"):
        drawing.impact_ranking(Scan({}, 1.0, {}))
