"""Drive-line page: what is on it, that it stands alone, and what its tables say."""

from __future__ import annotations

import dataclasses
import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="the page has figures")
pytest.importorskip("meshcat", reason="the page has a scene")

from testkit.line_data import double_shaft, random_line

from cardan_dyn.command_line.driveline_command import as_json
from cardan_dyn.drive_lines import DriveLine, ShaftJoint
from cardan_dyn.report import drive_line_page as page


def reported(line: DriveLine) -> page.LineReport:
    line = line.replace(speed=100.0, torque=200.0)
    return page.LineReport(line, line.analyse(), line.verdict(), page.best_forks(line))


@pytest.fixture(scope="module")
def report() -> page.LineReport:
    line = random_line(3, 2).replace(name="<line>", joints=[ShaftJoint(size="2040")] * 3)
    return reported(line)


def test_page_stands_alone(report: page.LineReport, tmp_path: Path) -> None:
    text = page.write(report, tmp_path / "new" / "line.html", with_scene=False).read_text("utf-8")
    assert "&lt;line&gt;" in text and "<line>" not in text
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert text.count("data:image/svg+xml;base64,") == 2
    for row in report.verdict:
        if row.value is not None:
            assert row.texts[3].split()[0] in text
        else:
            assert row.quantity in text
    assert "[[shafts]]" in text and "Turning scene" not in text
    assert f"{report.analysis.loop_residual:.1e}" in text


def test_unusual_data_are_remarked_on(tmp_path: Path) -> None:
    line = double_shaft((0.0, 0.1, 0.0)).replace(name="long")
    shafts = [line.shafts[0], dataclasses.replace(line.shafts[1], length=1200.0), line.shafts[2]]
    found = reported(line.replace(shafts=shafts))
    (remark,) = found.verdict.remarks
    text = page.write(found, tmp_path / "line.html", with_scene=False).read_text("utf-8")
    assert remark in html.unescape(text)
    assert json.loads(as_json(found))["remarks"] == [remark]


def test_scene_is_part_of_the_page(report: page.LineReport, tmp_path: Path) -> None:
    text = page.write(report, tmp_path / "line.html").read_text("utf-8")
    assert "Turning scene" in text and "support_C1" in text and len(text) > 1_000_000


def test_figures_are_saved(report: page.LineReport, tmp_path: Path) -> None:
    plain = reported(double_shaft((0.0, 0.1, 0.0)))
    paths = page.save_figures(plain, tmp_path / "figures")
    assert [path.name for path in paths] == [
        "drive_line_arrangement.svg",
        "drive_line_arrangement.png",
        "drive_line_over_angle.svg",
        "drive_line_over_angle.png",
    ]
    assert all(path.stat().st_size > 10_000 for path in paths)


def test_tables_of_data(report: page.LineReport) -> None:
    line = report.line
    shafts, joints = page.shaft_rows(line), page.joint_rows(line)
    assert [row[0] for row in shafts] == list(line.shaft_names)
    assert shafts[1][1] == f"{line.shafts[1].length * 1e3:.1f} mm"
    assert shafts[1][2] == f"{np.degrees(line.shafts[1].slope_side):.3f}°"
    assert joints[2][4] == f"{np.degrees(line.joint_angles[2]):.3f}°"
    extremes = page.extreme_rows(report.analysis)
    assert extremes[2][1] == f"{report.analysis.total.bearing_radial[:, 2].max():.4g} N"


def test_forks_in_words(report: page.LineReport) -> None:
    assert "global optimum" in page.phasing_text(report.phasing)
    assert len(page.phasing_rows(report.phasing)) == 2
    best = reported(double_shaft((0.0, 0.1, 0.0)))
    assert "as well as they can" in page.phasing_text(best.phasing)
    single = random_line(1, 1)
    assert page.best_forks(single) is None
    assert "one joint" in page.phasing_text(None) and page.phasing_rows(None) == []


def test_what_all_rows_of_a_rule_say_is_said_once(report: page.LineReport) -> None:
    groups = page.verdict_groups(report.verdict)
    assert sum(len(group.rows) + len(group.missing) for group in groups) == len(report.verdict)
    for group in groups:
        for row, remarks in group.rows:
            shared = {f"! {text}" for text in group.shared}
            assert not shared & set(remarks)
            assert shared | set(remarks) == set(row.remarks)
