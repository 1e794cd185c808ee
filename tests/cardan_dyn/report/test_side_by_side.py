"""Reports on load cases side by side: what governs, against the arrays of the sweeps."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.report.case import case_of

pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = np.linspace(0.0, 2.0 * np.pi, 361)


def swept(*cases: tuple[float, float]) -> list[cd.Sweep]:
    """Return sweeps of a slider-crank at speeds and forces on its piston."""
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    return [
        scene.replace(loads={"piston_guide": force}).sweep(TURN, speed=speed)
        for speed, force in cases
    ]


CASES = [(speed, force) for speed in (20.0, 90.0) for force in (-300.0, -100.0, 0.0, 400.0)]


def test_the_headline_is_the_greatest_of_all_sweeps() -> None:
    """By the arrays alone: shear of each joint, and the torque of the crank."""
    sweeps = swept(*CASES)
    found = {item.quantity: (case, item) for case, item in cd.Reports(sweeps).headline}
    for quantity, of in {
        "shear": lambda sweep: {
            name: np.abs(sweep[name].shear).max()
            for name in ("crank_bearing", "crank_pin", "piston_pin", "piston_guide")
        },
        "drive effort": lambda sweep: {"crank_bearing": np.abs(sweep.drive_effort).max()},
    }.items():
        sizes = {
            (case, name): size
            for case, sweep in enumerate(sweeps)
            for name, size in of(sweep).items()
        }
        case, item = found[quantity]
        assert item.size == pytest.approx(max(sizes.values()), rel=1e-4)
        assert sizes[case, item.owner] >= max(sizes.values()) * (1.0 - 1e-12)
        assert item.determined
    # Torsion of the crank is its drive effort, and what is along the guide is the load on it.
    assert not {"torsion", "axial", "force"} & found.keys()


def test_cases_are_called_by_what_tells_them_apart() -> None:
    assert cd.Reports(swept((90.0, 0.0), (90.0, -50.0))).labels == (
        "0 N at piston_guide",
        "-50 N at piston_guide",
    )
    assert cd.Reports(swept((60.0, 5.0), (90.0, 5.0))).labels == ("573 1/min", "859.4 1/min")
    assert cd.Reports(swept((60.0, 5.0), (60.0, 5.0))).labels == ("case 1", "case 2")
    gravity = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", gravity=(0.0, -9.81, 0.0))
    labels = cd.Reports([*swept((0.0, 5.0)), gravity.sweep(TURN)]).labels
    assert labels == ("5 N at piston_guide", "gravity (0, -9.81, 0) m/s²")


def test_text_and_table_have_every_case() -> None:
    sweeps = swept(*CASES[:4])
    reports = cd.Reports(sweeps, ["a", "b", "c", "d"])
    lines = str(reports).splitlines()
    row = next(line for line in lines if line.split()[:2] == ["crank_bearing", "shear"])
    sizes = [np.abs(sweep["crank_bearing"].shear).max() for sweep in sweeps]
    np.testing.assert_allclose([float(text) for text in row.split()[3:7]], sizes, rtol=2e-3)
    assert sum("not determined by statics" in line for line in lines) == 1
    frame = reports.to_dataframe()
    for case, sweep in zip("abcd", sweeps, strict=True):
        rows = frame[(frame.case == case) & (frame.owner == "piston_guide")]
        (least,) = rows[rows.quantity == "axial"].least
        assert least == pytest.approx(sweep["piston_guide"].axial.min(), abs=1e-9)


def test_page_shows_each_case(tmp_path: Path) -> None:
    pytest.importorskip("jinja2", reason="it is a page")
    reports = cd.Reports(swept((20.0, 5.0), (90.0, 5.0)), title="two speeds")
    text = html.unescape(reports.save(tmp_path / "page.html", scene=False).read_text("utf-8"))
    plain = re.sub(r"<[^>]*>", "", text)
    assert (
        plain.count("two speeds") >= 2
        and "2 load cases, in all of them crank_bearing 0° … 360°" in plain
    )
    assert "What joints are sized by, in each load case" in plain
    for label in reports.labels:
        assert f"Case: {label}" in plain and f"Residuals and condition, {label}" in plain
    # Everything is greatest at the higher speed: figures are of that case alone.
    assert {case for case, _ in reports.headline} == {1}
    assert plain.count("Polar diagrams of bearings") == 1


def test_more_cases_than_a_sheet_is_wide_are_several_tables(tmp_path: Path) -> None:
    pytest.importorskip("jinja2", reason="it is a page")
    reports = cd.Reports(swept(*((10.0 * k, 5.0) for k in range(1, 10))))
    text = reports.save(tmp_path / "page.html", scene=False).read_text("utf-8")
    assert text.count("Greatest in size, by load case") == 2


@pytest.mark.parametrize(
    ("cases", "labels", "said"),
    [
        ([], (), "no load case"),
        (CASES[:2], ("one",), "expected one of its own for each of 2"),
        (CASES[:2], ("one", "one"), "expected one of its own"),
    ],
)
def test_other_cases_are_refused(
    cases: list[tuple[float, float]], labels: tuple[str, ...], said: str
) -> None:
    with pytest.raises(cd.ArgumentError, match=said):
        cd.Reports(swept(*cases), labels)


def test_cases_are_of_one_mechanism() -> None:
    other = cd.Scene(cd.load("four_bar"), drive="crank_bearing").sweep(TURN)
    with pytest.raises(cd.ArgumentError, match="of one mechanism"):
        cd.Reports([*swept((1.0, 1.0)), other])
    with pytest.raises(cd.ArgumentError, match="list of sweeps"):
        cd.Reports(other)  # type: ignore[arg-type]
    with pytest.raises(cd.ArgumentError, match="several load cases"):
        cd.Report([other])  # type: ignore[arg-type]


ARM = """<robot name="arm">
<link name="base"/><link name="upper"/><link name="fore"/><link name="tip"/>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
  <axis xyz="0 -1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper"/><child link="fore"/>
  <origin xyz="2 0 0" rpy="0 1.5 0"/><axis xyz="0 -1 0"/></joint>
<joint name="hand" type="fixed"><parent link="fore"/><child link="tip"/>
  <origin xyz="1.5 0 0"/></joint></robot>"""
RISE = np.linspace(0.0, 1.0, 41)
TIP = np.stack([2.4 + 0.3 * np.sin(5.0 * RISE), RISE - 1.0], axis=1)


def lifted(*forces: tuple[float, float, float]) -> list[Any]:
    """Return sweeps of an arm without weight whose tip rises, under forces there."""
    scene = cd.Scene(
        cd.load(ARM), task=cd.PointTask("hand", axes="xz"), actuated=["shoulder", "elbow"]
    )
    return [
        scene.sweep(TIP, along_path=True, loads={"hand": cd.Wrench(force, frame="world")})
        for force in forces
    ]


FORCES = (0.0, 0.0, -100.0), (-250.0, 0.0, -100.0)


def drawn_in(figure: Any) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Return the curves of a figure by the label of their axes, whose first line is the owner."""
    return {
        " ".join(panel.get_ylabel().split()): [
            (np.asarray(line.get_xdata()), np.asarray(line.get_ydata()))
            for line in panel.get_lines()
            if len(line.get_xdata()) > 2
        ]
        for panel in figure.axes
    }


def test_a_figure_of_a_task_is_drawn_over_the_row_that_rises() -> None:
    """Against moments of the forces about the shoulder; x turns back on its way, z does not."""
    pytest.importorskip("matplotlib", reason="it is a figure")
    reports = cd.Reports(lifted(*FORCES))
    figure = reports.plot("shoulder.drive_effort")
    assert figure.axes[-1].get_xlabel() == "hand.z [m]"
    ((label, curves),) = drawn_in(figure).items()
    assert label.startswith("shoulder drive effort")
    scale = {"[N·m]": 1.0, "[kN·m]": 1e3}[label.rpartition(" ")[2]]
    assert len(curves) == 2
    for (at, values), (across, _, up) in zip(curves, FORCES, strict=True):
        np.testing.assert_allclose(at, TIP[:, 1], atol=1e-12)
        moment = TIP[:, 0] * up - TIP[:, 1] * across
        np.testing.assert_allclose(values * scale, -moment, atol=1e-9)
    over_x = drawn_in(reports.plot("shoulder", x="hand.x"))
    for curves in over_x.values():
        np.testing.assert_allclose(curves[0][0], TIP[:, 0], atol=1e-12)
    with pytest.raises(cd.ArgumentError, match=r"x is 'hand'.*did you mean 'hand.*'"):
        reports.plot(x="hand")


def test_plot_is_the_figure_of_the_page_and_draws_joints_by_name() -> None:
    pytest.importorskip("matplotlib", reason="it is a figure")
    sweeps = swept(*CASES[:2])
    reports = cd.Reports(sweeps, ["pulled", "pushed"])
    figure = reports.plot()
    assert len(figure.axes) == len(reports.headline)
    assert figure.axes[-1].get_xlabel() == "crank_bearing [°]"
    curves = drawn_in(reports.plot("crank_pin"))
    (shear,) = (lines for label, lines in curves.items() if label.startswith("crank_pin shear"))
    for sweep, report, (at, values) in zip(sweeps, reports.reports, shear, strict=True):
        # Through all samples, and the extremes between them.
        samples = np.interp(np.degrees(TURN), at, values)
        np.testing.assert_allclose(samples, sweep["crank_pin"].shear, rtol=1e-9)
        (most,) = (of.greatest for of in report.told if of[:2] == ("crank_pin", "shear"))
        assert values.max() == pytest.approx(most, rel=1e-12)
    ((alone,),) = drawn_in(cd.Report(sweeps[1]).plot("crank_pin.shear")).values()
    np.testing.assert_array_equal(alone[1], shear[1][1])
    with pytest.raises(
        cd.ArgumentError, match=r"nothing acts in 'crank'.*did you mean 'crank_pin'"
    ):
        reports.plot("crank")
    with pytest.raises(cd.ArgumentError, match="no option 'color'"):
        reports.plot(color="red")


def test_angles_whole_turns_apart_lie_over_each_other() -> None:
    pytest.importorskip("matplotlib", reason="it is a figure")
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": 9.0})
    way = np.linspace(-np.pi, np.pi, 61)
    far = [scene.sweep(way + 2.0 * np.pi * turns) for turns in (0, -40)]
    figure = cd.Reports(far, ["here", "there"]).plot("crank_pin.shear")
    assert figure.axes[-1].get_xlabel() == "crank_bearing [°] less whole turns"
    (((here, one), (there, other)),) = drawn_in(figure).values()
    np.testing.assert_allclose(there, here, atol=1e-9)
    np.testing.assert_allclose(other, one, rtol=1e-9)
    # What has places in common stays where it is.
    near = [scene.sweep(way), scene.sweep(way + 0.5 * np.pi)]
    figure = cd.Reports(near, ["here", "there"]).plot("crank_pin.shear")
    assert figure.axes[-1].get_xlabel() == "crank_bearing [°]"


def test_drives_without_a_task_are_drawn_over_samples() -> None:
    pytest.importorskip("matplotlib", reason="it is a figure")
    machines = [sweep.of_machine for sweep in lifted(*FORCES)]
    figure = cd.Reports(machines).plot()
    assert figure.axes[-1].get_xlabel() == "sample"
    for curves in drawn_in(figure).values():
        assert all(len(at) == len(TIP) and at[-1] == len(TIP) for at, _ in curves)


def test_a_case_with_nothing_of_its_own_is_called_by_what_it_lacks() -> None:
    assert cd.Reports(lifted(FORCES[0], FORCES[0])).labels == ("case 1", "case 2")
    scene = cd.Scene(cd.load("slider_crank"), drive="crank_bearing", loads={"piston_guide": 5.0})
    weighed = scene.replace(gravity=(0.0, -9.81, 0.0))
    assert cd.Reports([scene.sweep(TURN), weighed.sweep(TURN)]).labels == (
        "without gravity (0, -9.81, 0) m/s²",
        "gravity (0, -9.81, 0) m/s²",
    )


def test_the_head_tells_what_cases_have_in_common_and_what_each_has(tmp_path: Path) -> None:
    reports = cd.Reports(swept((20.0, -300.0), (20.0, 400.0)), ["pulled", "pushed"])
    common = "2 load cases, in all of them crank_bearing 0° … 360°; 191 1/min"
    own = ["pulled: -300 N at piston_guide", "pushed: 400 N at piston_guide"]
    lines = str(reports).splitlines()
    assert common in lines[0] and [f"1: {own[0]}", f"2: {own[1]}"] == lines[1:3]
    pytest.importorskip("jinja2", reason="it is a page")
    text = html.unescape(reports.save(tmp_path / "page.html", scene=False).read_text("utf-8"))
    plain = text.replace("<wbr>", "").replace("−", "-")
    assert f"{common}." in plain and all(f"<li>{line}</li>" in plain for line in own)
    assert "pulled: −300" in text
    # Columns stay beside each other on a narrow screen.
    assert '<div class="beside">\n<table class="beside' in text


def test_a_row_names_all_cases_in_which_it_is_as_great() -> None:
    cases = swept((90.0, 5.0), (90.0, 5.0), (20.0, 5.0))
    lines = str(cd.Reports(cases, ["a", "b", "c"])).splitlines()
    assert next(line for line in lines if line.startswith("shear ")).endswith("  a, b")
    lines = str(cd.Reports(cases[:2], ["a", "b"])).splitlines()
    assert next(line for line in lines if line.startswith("shear ")).endswith("  all")
    lines = str(cd.Reports(cases[1:], ["b", "c"])).splitlines()
    assert next(line for line in lines if line.startswith("shear ")).endswith("  b")


def test_a_report_of_a_task_tells_its_rows_and_places_in_them(tmp_path: Path) -> None:
    (sweep,) = lifted(FORCES[1])
    report = cd.Report(sweep)
    across = f"hand.x {TIP[:, 0].min():.4g} … {TIP[:, 0].max():.4g} m"
    assert report.case_lines[:2] == [across, "hand.z -1 … 0 m"]
    worst = np.abs(sweep.actuated_effort["shoulder"]).argmax()
    place = f"hand.x {TIP[worst, 0]:.4g} m, hand.z {TIP[worst, 1]:.4g} m"
    (item,) = [
        it for it in report.extremes if (it.owner, it.quantity) == ("shoulder", "drive effort")
    ]
    assert report.at(item.ends[0][1]) == place and place in str(report)
    pytest.importorskip("jinja2", reason="it is a page")
    text = html.unescape(report.save(tmp_path / "page.html", scene=False).read_text("utf-8"))
    plain = re.sub(r"<[^>]*>|\u200b", "", text)
    assert f"Task: {across}; hand.z −1 … 0 m" in plain and "task hand.z−1 … 0 m" in plain
    assert place.replace("-", "−") in plain


def test_rounding_at_the_end_of_a_way_is_nothing(tmp_path: Path) -> None:
    slide = """<robot name="rail"><link name="base"/><link name="car"><inertial><mass value="7"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="way" type="prismatic">
    <parent link="base"/><child link="car"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/></joint>
    </robot>"""
    scene = cd.Scene(cd.load(slide), drive="way", gravity=(0.0, 0.0, -9.81))
    report = cd.Report(scene.sweep(np.linspace(4.7e-12, 0.9, 31)))
    assert report.at(np.array([[4.7e-12], [0.05]])) == "0 mm, 50 mm"
    pytest.importorskip("jinja2", reason="it is a page")
    text = html.unescape(report.save(tmp_path / "page.html", scene=False).read_text("utf-8"))
    plain = re.sub(r"<[^>]*>|\u200b", "", text)
    assert "from 0 to 900 mm" in plain and " pm" not in plain and "e-12" not in plain


def test_a_task_sweep_is_drawn_over_a_row_of_its_task() -> None:
    pytest.importorskip("matplotlib", reason="it is a figure")
    (sweep,) = lifted(FORCES[0])
    axes = sweep.plot("shoulder.drive_effort", x="hand.z").axes[-1]
    assert axes.get_xlabel() == "hand.z [m]"
    np.testing.assert_allclose(axes.get_lines()[0].get_xdata(), TIP[:, 1], atol=1e-12)
    assert sweep.plot("shoulder", x="hand.x").axes[-1].get_xlabel() == "hand.x [m]"


def test_loads_that_act_one_way_are_told_apart_by_it() -> None:
    mechanism, load = cd.load("slider_crank"), 100.0
    cases = [
        case_of(mechanism, loads={}, ways={"piston_guide": (load, sense)}, samples=37)
        for sense in (1, -1)
    ]
    reports = cd.Reports([cd.Report(case) for case in cases])
    told = "100 N at piston_guide moving"
    assert reports.labels == (f"{told} forward", f"{told} backward")
    for sense, report in zip((1, -1), reports.reports, strict=True):
        # The piston comes back over the first half of a turn.
        way = -sense * np.sin(np.ravel(report.sweep.position))
        acting = report.sweep.loads["piston_guide"][np.abs(way) > 1e-6]
        np.testing.assert_array_equal(acting != 0.0, way[np.abs(way) > 1e-6] > 0.0)


def test_cases_beside_each_other_have_the_numbers_of_their_list(tmp_path: Path) -> None:
    """Names of load cases are too long for columns."""
    reports = cd.Reports(swept(*((10.0 * k, 5.0) for k in range(1, 9))))
    grids = [reports.beside(first, 6) for first in (0, 6)]
    assert [grid.header[3:] for grid in grids] == [tuple("123456"), tuple("78")]
    for first, grid in zip((0, 6), grids, strict=True):
        for (*_, sizes), row in zip(reports.compared, grid.rows, strict=True):
            assert list(row[3:]) == sizes[first : first + len(row) - 3]


def test_places_of_a_task_of_many_rows_are_a_table_of_these(tmp_path: Path) -> None:
    """Three rows in a plane: they are named in the headline, and numbered in tables."""
    arm = ARM.replace(
        '<joint name="hand" type="fixed">',
        '<link name="wrist"/><joint name="bend" type="continuous"><parent link="fore"/>'
        '<child link="wrist"/><origin xyz="1.2 0 0"/><axis xyz="0 -1 0"/></joint>'
        '<joint name="hand" type="fixed">',
    ).replace(
        '<parent link="fore"/><child link="tip"/>', '<parent link="wrist"/><child link="tip"/>'
    )
    arm = arm.replace('<origin xyz="1.5 0 0"/>', '<origin xyz="0.3 0 0"/>')
    names = ["shoulder", "elbow", "bend"]
    task = cd.PointTask("hand", axes="xz"), cd.AngleTask("tip", axis="y")
    scene = cd.Scene(cd.load(arm), task=task, actuated=names)
    rows = np.column_stack([TIP, 0.2 * RISE])
    push = cd.Wrench((-250.0, 0.0, -100.0), frame="world")
    report = cd.Report(scene.sweep(rows, loads={"hand": push}))
    assert report.cases.sized.rows[-1][4].startswith("hand.x ")
    at = {str(row[4]) for grid in report.grids() for row in grid.rows} - {"throughout"}
    assert at and all(place.isdigit() for place in at)
    pytest.importorskip("jinja2", reason="it is a page")
    text = html.unescape(report.save(tmp_path / "page.html", scene=False).read_text("utf-8"))
    plain = re.sub(r"<[^>]*>|\u200b", "", text)
    assert "The task at these places" in plain and "shoulder [rad]" not in plain
    table = plain[plain.index("The task at these places") :]
    for place in report.places:
        sample = int(np.all(report.sweep.position == place, axis=1).argmax())
        for value in rows[sample]:
            assert f"{abs(value):.6g}"[:7] in table


def test_a_place_at_which_loads_alone_vary_is_told_by_the_rows_of_the_task(tmp_path: Path) -> None:
    arm = cd.load(ARM)
    task = cd.PointTask("hand", axes="xz")
    scene = cd.Scene(arm, task=task, actuated=["shoulder", "elbow"])
    push = np.linspace([0.0, 0.0, 0.0], [-250.0, 0.0, -100.0], 5)
    report = cd.Report(scene.sweep(TIP[0], loads={"hand": cd.Wrench(push, frame="world")}))
    assert {row[4] for grid in report.grids() for row in grid.rows} - {"throughout"} == {
        f"hand.x {TIP[0, 0]:.4g} m, hand.z {TIP[0, 1]:.4g} m"
    }
    pytest.importorskip("jinja2", reason="it is a page")
    assert "at these places" in report.save(tmp_path / "p.html", scene=False).read_text("utf-8")


def test_the_moment_of_a_slide_says_about_which_point_it_is() -> None:
    """A crane's trolley: the rail's moment is about the trolley, wherever that is."""
    crane = """<robot name="crane"><link name="rail"/><link name="trolley"><inertial>
    <origin xyz="0 0 -1"/><mass value="10"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="travel" type="prismatic"><parent link="rail"/><child link="trolley"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="5" effort="0" velocity="0"/></joint></robot>"""
    scene = cd.Scene(cd.load(crane), drive="travel")
    way = np.linspace(0.0, 5.0, 11)
    sweeps = [
        scene.sweep(way, loads={"trolley": cd.Wrench((0.0, side, 0.0), point=(0.3, 0.0, 0.0))})
        for side in (50.0, 80.0)
    ]
    reports = cd.Reports(sweeps, ["calm", "storm"])
    (told,) = reports.remarks
    assert told.startswith("Bending of travel is that about the joint's origin, which slides")
    assert told in str(reports)
    # It is the same wherever the trolley is: 80 N at 0.3 m, and 5 m more about the end of the rail.
    (item,) = [item for _, item in reports.headline if item.quantity == "bending"]
    assert item.greatest == pytest.approx(24.0) and item.least == pytest.approx(24.0)
    moment = sweeps[1]["travel"].at((-5.0, 0.0, 0.0)).moment
    np.testing.assert_allclose(np.linalg.norm(moment, axis=1), 24.0 + 80.0 * 5.0)
    assert not cd.Reports(swept((20.0, 5.0), (90.0, 5.0))).remarks


def test_a_force_that_is_less_than_a_part_of_another_is_no_headline() -> None:
    """A hook on a ball below a beam of 90 kg: the hinge of the beam carries ten times as much."""
    hung = """<robot name="hung"><link name="wall"/><link name="beam"><inertial>
    <origin xyz="1 0 0"/><mass value="90"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <link name="hook"><inertial><origin xyz="0 0 -0.1"/><mass value="10"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial></link>
    <joint name="hinge" type="continuous"><parent link="wall"/><child link="beam"/>
    <axis xyz="0 1 0"/></joint><joint name="ball" type="spherical"><parent link="beam"/>
    <child link="hook"/><origin xyz="2 0 0"/></joint></robot>"""
    held = {"ball.x": 0.0, "ball.y": 0.0, "ball.z": 0.0}
    scene = cd.Scene(cd.load(hung), drive="hinge", held=held, gravity=(0.0, 0.0, -9.81))
    report = cd.Report(scene.sweep(np.linspace(0.0, 0.5, 5)))
    told = {item.quantity: item for item in report.headline}
    assert told["shear"].owner == "hinge"
    assert told["shear"].greatest == pytest.approx(100 * 9.81)
    assert "force" not in told
    sizes = {of: sizes for of, quantity, _, sizes in report.cases.compared if quantity == "force"}
    assert sizes["ball"] == pytest.approx([10 * 9.81])
