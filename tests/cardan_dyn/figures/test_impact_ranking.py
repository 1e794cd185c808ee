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
    kinds = "severity", "partial_severity", "rigid_peak"
    assert widths == pytest.approx([getattr(joint, kind) for kind in kinds for joint in joints])
    # The force of the first turns through, and that of the last does not bring it to strike.
    assert widths[0] == 0.0 < widths[3] and widths[2] == widths[5] == 0.0
    assert forces.get_xlabel() == "force [N]"
    assert effects.get_xlabel() == "change of the peak with 10 % less [%]"
    # The first joint stands at the top.
    assert forces.get_ylim()[0] > forces.get_ylim()[1]
    worst = joints[0].worst
    assert worst is not None
    for line in effects.get_lines()[:5]:
        name = line.get_label().removeprefix("less ")
        exponent = getattr(worst.exponents, name)
        assert line.get_xdata()[0] == pytest.approx(100.0 * (0.9**exponent - 1.0))
        assert np.isnan(line.get_xdata()[2])


def test_nothing_to_be_ranked() -> None:
    with pytest.raises(ArgumentError, match="no joint was scanned"):
        drawing.impact_ranking(Scan({}, 1.0, {}))
