import dataclasses

import numpy as np
import pytest
from testkit.drawings import check_texts
from testkit.line_data import random_line

from cardan_dyn import ArgumentError
from cardan_dyn.drive_lines import DriveLine

LINE = random_line(3, seed=0)


def test_every_shaft_joint_and_bearing_is_a_line() -> None:
    found = LINE.analyse(speed=0, torque=200, positions=np.linspace(0, 2 * np.pi, 37))
    figure = found.plot()
    errors, ratios, bending, bearings = figure.axes
    assert [line.get_label() for line in ratios.lines] == ["shaft_1", "shaft_2", "output"]
    assert errors.lines[1].get_ydata() == pytest.approx(np.degrees(found.angle_error[:, 2]))
    assert len(bending.lines) == 6
    assert [line.get_label() for line in bearings.lines] == list(found.bearings)
    assert bearings.lines[2].get_ydata() == pytest.approx(found.total.bearing_radial[:, 2])
    assert bearings.get_xlabel().endswith("[°]")
    assert figure.get_suptitle() == "drive_line"


def test_a_line_in_inches_is_drawn_in_pounds() -> None:
    """250 lbf·ft are 338.95 N·m by NIST SP 811; the same analysis in SI has these as its curves."""
    line = DriveLine.from_toml(
        "torque_lbft = 250\n"
        "[[shafts]]\nbearings = [{distance_in = 4}, {distance_in = 12}]\n"
        "[[shafts]]\nlength_in = 36\nslope_side_deg = 5\nspline = {}\n"
        "[[shafts]]\nslope_side_deg = 11\nbearings = [{distance_in = 4}, {distance_in = 12}]\n"
    )
    found = line.analyse(speed=0.0)
    _, _, bending, bearings = found.plot().axes
    assert bending.get_ylabel() == "bending [lbf·ft]"
    assert bearings.get_ylabel() == "bearing force [lbf]"
    pound = 4.4482216152605
    of_joint = found.total.bending_in[:, 1] / (pound * 0.3048)
    assert bending.lines[1].get_ydata() == pytest.approx(of_joint, rel=1e-12)
    across = found.total.bearing_radial[:, 0] / pound
    assert bearings.lines[0].get_ydata() == pytest.approx(across, rel=1e-12)
    si = dataclasses.replace(found, units="si").plot().axes[3]
    assert si.lines[0].get_ydata() == pytest.approx(found.total.bearing_radial[:, 0], rel=1e-12)
    assert si.get_ylabel() == "bearing force [N]"


def test_a_long_name_of_a_line_is_not_cut_off() -> None:
    name = "Drive shaft of the second stand with its intermediate bearing, drawing 4711-0815 C"
    line = DriveLine.from_toml("pto").replace(name=f"{name}, $ {name}")
    figure = line.verdict().plot()
    check_texts(figure)
    assert figure.get_suptitle().replace("\n", " ").startswith(name)


def test_many_designs_are_no_curve() -> None:
    designs = LINE.variants(angles=np.full((2, 3), 0.2))
    found = LINE.analyse(speed=0, torque=200, positions=[0, 1], variants=designs)
    with pytest.raises(ArgumentError, match="the analysis is of many designs"):
        found.plot()


@pytest.mark.slow
def test_margins_of_a_verdict_are_bars() -> None:
    verdict = DriveLine.from_toml("truck").verdict()
    (axes,) = verdict.plot().axes
    rows = [row for row in verdict if row.margin is not None and row.limit is not None]
    margins = sorted(100.0 * row.margin for row in rows if row.limit.value != 0.0)
    widths = [bar.get_width() for bar in axes.patches]
    # Nothing is relative to a limit of 0: the travel that is left fills its bar, in its unit.
    assert widths == pytest.approx([*np.clip(margins, -100.0, 100.0), 100.0])
    told = [text.get_text() for text in axes.texts if text.get_text() != "//"]
    # Bars that end before their values are marked as cut.
    cut = [text.get_position()[1] for text in axes.texts if text.get_text() == "//"]
    assert cut == [place for place, margin in enumerate(margins) if abs(margin) > 100.0]
    assert told == [*(f"{margin:+.0f} %" for margin in margins), "+25 mm"]
    assert [bool(bar.get_hatch()) for bar in axes.patches] == [width < 0.0 for width in widths]
    # The least margin stands on top.
    assert axes.get_ylim()[0] > axes.get_ylim()[1]
    assert verdict.summary in axes.figure.get_suptitle().replace("\n", " ")
    check_texts(axes.figure)


def test_what_statics_leaves_open_is_said() -> None:
    found = DriveLine.from_toml("truck").analyse()
    assert not found.indeterminate and not found.plot().get_supxlabel()
    opened = dataclasses.replace(found, indeterminate=("the bearings of axle share a moment",))
    assert "the bearings of axle share a moment" in opened.plot().get_supxlabel()
    (legend,) = opened.plot("centre.bearing_radial").legends
    assert "the bearings of axle" in legend.get_title().get_text().replace("\n", " ")
    (legend,) = opened.plot("axle.ratio").legends
    assert not legend.get_title().get_text()
