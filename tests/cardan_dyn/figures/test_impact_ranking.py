"""The ranking of impacts as bars and points, against the scan."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from matplotlib.axes import Axes

import cardan_dyn as cd
from cardan_dyn import ArgumentError, figures
from cardan_dyn.clearance import Scan, scan
from cardan_dyn.kit.arrays import Array
from cardan_dyn.motion.clearance import drawing


@pytest.mark.slow
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
    assert drawn_intervals(forces) == pytest.approx(
        np.array([(one.least, one.greatest) for one in joints])
    )
    for width, joint in zip(widths, joints, strict=False):
        assert f"{width:.4g} N at most" in joint.summary
    assert forces.get_xlabel() == "force [kN]"
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


def drawn_intervals(forces: Axes) -> Array:
    """Both ends of each error bar that is drawn, those first that stand at the top."""
    (intervals,) = [found for found in forces.containers if hasattr(found, "has_xerr")]
    segments = intervals.lines[2][0].get_segments()
    return np.array([segment[:, 0] for segment in segments if len(segment)])


def test_an_interval_ends_where_it_ends_though_a_force_is_greater() -> None:
    loads = {"piston_guide": -300.0}
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads=loads)
    found = scan(scene, 120.0, clearance=1e-4, stiffness=1e8, damping_ratio=0.2)
    joint = found["crank_pin"]
    beyond = 1.5 * joint.greatest
    rigid = replace(joint, name="rigid", force=joint.force * (beyond / joint.rigid_peak))
    struck = replace(joint, name="struck", simulated={"crank_pin": beyond})
    unknown = replace(joint, name="unknown", motion=None, reversals=())
    for one in (rigid, struck):
        assert one.peak == pytest.approx(beyond) and one.greatest == joint.greatest
        alone = drawing.impact_ranking(Scan({one.name: one}, 120.0, {})).axes[0]
        assert alone.patches[0].get_width() == pytest.approx(beyond)
        ((least, greatest),) = drawn_intervals(alone)
        assert (least, greatest) == pytest.approx((joint.least, joint.greatest))
        assert f"({least:.4g} to {greatest:.4g} N)" in one.summary
    # Where no interval is known, none is drawn.
    alone = drawing.impact_ranking(Scan({unknown.name: unknown}, 120.0, {})).axes[0]
    assert math.isnan(unknown.greatest) and not len(drawn_intervals(alone))


def test_nothing_to_be_ranked() -> None:
    with pytest.raises(ArgumentError, match="no joint was scanned"):
        drawing.impact_ranking(Scan({}, 1.0, {}))
