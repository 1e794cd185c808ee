"""What figures say by themselves: the case, what they leave out, what is no line, what is cut."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.results.case_line import case_line
from cardan_dyn.figures.critical_speeds import campbell
from cardan_dyn.figures.designs import contour_map, parallel_coordinates, scatter, tornado
from cardan_dyn.figures.panels import Panel, stacked
from cardan_dyn.figures.polar import force_polar
from cardan_dyn.figures.style import over
from cardan_dyn.scene.usual_motion import usual_motion

SCENE = cd.Scene(cd.load("four_bar"), drive="crank_bearing", loads={"rocker_bearing": -20.0})


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    return SCENE.sweep(np.linspace(0.0, 2.0 * np.pi, 25), speed=20.0)


def note(figure: Any) -> str:
    (legend,) = figure.legends
    return str(legend.get_title().get_text()).replace("\n", " ")


def test_the_title_is_the_case(turn: cd.Sweep) -> None:
    case = "four_bar: crank_bearing 0° … 360° at 191 1/min, load rocker_bearing −20 N·m"
    assert case_line(turn) == case
    assert turn.plot().get_suptitle().replace("\n", " ") == case
    assert turn.plot("crank_bearing.shear").axes[0].get_title().replace("\n", " ") == case
    assert turn.plot(title="own").get_suptitle() == "own"
    # Axes of somebody else have the title that he gives them.
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    turn.plot("crank_bearing.shear", ax=axes)
    assert axes.get_title() == ""


def test_cases_of_several_drives_of_wrenches_and_of_time() -> None:
    slider = cd.load("slider_crank")
    load = cd.Wrench(force=(3000.0, 4000.0, 0.0))
    scene = cd.Scene(slider, drive="crank_bearing", loads={"piston": load})
    pushed = scene.sweep(np.linspace(0.0, 1.0, 5))
    assert case_line(pushed) == "slider_crank: crank_bearing 0° … 57.3°, load piston 5 kN"
    platform = cd.load("stewart_platform")
    legs = [name for name in platform.joints if name.startswith("leg_")]
    still = cd.Scene(platform, drive=legs).sweep(np.zeros((2, 6)))
    assert case_line(still) == "stewart_platform: 6 drives"
    coasting = cd.Scene(cd.load("four_bar"), free="crank_bearing").simulate(0.1, speed=1.0)
    assert case_line(coasting) == "four_bar: 0 … 0.1 s"


def test_what_is_left_out_is_said(turn: cd.Sweep) -> None:
    said = note(turn.plot())
    bending = max(turn[name].bending.max() for name in ("crank_bearing", "rocker_bearing"))
    assert f"not drawn: crank_pin, rocker_pin; bending, at most {bending:.2g} N·m; axial" in said
    assert [panel.get_ylabel().split()[0] for panel in turn.plot().axes] == [
        "effort",
        "torsion",
        "shear",
    ]
    # What is named is drawn, however small it is.
    assert len(turn.plot("crank_bearing", quantities="bending").axes) == 1
    assert "crank_pin" not in note(turn.plot("crank_bearing"))


def test_efforts_of_drives_stand_above_with_the_limits_that_are_near() -> None:
    text = (
        '<robot name="bar"><link name="ground"/><link name="arm"><inertial><origin xyz="0.5 0 0"/>'
        '<mass value="1"/><inertia ixx="0" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="motor" type="revolute"><parent link="ground"/><child link="arm"/>'
        '<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="{}" velocity="1"/></joint></robot>'
    )
    for effort, drawn in ((4.0, [-4.0]), (100.0, [])):
        scene = cd.Scene(cd.load(text.format(effort)), drive="motor", gravity=(0.0, 0.0, -9.81))
        swept = scene.sweep(np.linspace(-0.5, 0.5, 9))
        effort_axes = swept.plot().axes[0]
        curve, *limits = effort_axes.get_lines()
        np.testing.assert_array_equal(curve.get_ydata(), swept.drive_effort)
        assert curve.get_label() == f"motor, limit {effort:g} N·m"
        assert [line.get_ydata()[0] for line in limits] == drawn


def test_what_was_given_its_times_is_drawn_over_them(turn: cd.Sweep) -> None:
    timed = SCENE.sweep(turn.position, speed=20.0, time=np.linspace(0.0, 3.0, 25))
    for figure in (timed.plot(), timed.plot("drive_effort")):
        assert figure.axes[-1].get_xlabel() == "time [s]"
    assert timed.plot(x="crank_bearing").axes[-1].get_xlabel() == "crank_bearing [°]"


def test_the_axis_of_a_cross_is_said() -> None:
    text = (
        '<robot name="u"><link name="a"/><link name="b"><inertial><origin xyz="1 0 0"/>'
        '<mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
        '<joint name="u" type="universal"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 1 0"/><axis2 xyz="0 0 1"/></joint></robot>'
    )
    scene = cd.Scene(cd.load(text), drive=["u.turn_1", "u.turn_2"], gravity=(0.0, 0.0, -9.81))
    hanging = scene.sweep(np.linspace([0.0, 0.0], [0.4, 0.3], 9))
    said = "the axis of u turns with the child, and is across both pins where the joint is straight"
    assert note(hanging.plot("u")).endswith(said)
    assert said not in note(hanging.plot("u", quantities=["force", "moment"]))
    # So does the axis in the world: along x at first, across the pins along y and z.
    expected = hanging.rotation("u") @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(hanging.wrench("u", "world").axis, expected, atol=1e-12)


def test_samples_in_no_order_are_points(turn: cd.Sweep) -> None:
    mixed = SCENE.sweep(turn.position[np.random.default_rng(3).permutation(24)], speed=20.0)
    for panel in (*mixed.plot().axes, *mixed.plot("crank_bearing.shear").axes):
        assert all(line.get_linestyle() == "None" for line in panel.get_lines())
        assert not panel.texts
    there_and_back = np.concatenate([np.arange(9.0), np.arange(9.0)[::-1]])
    for path in (np.arange(9.0), -np.arange(9.0), there_and_back, np.zeros(9), np.zeros(1)):
        assert over("x", path, "m").style(0)["linestyle"] == "-"


def test_up_in_polar_diagrams_is_z() -> None:
    slider = cd.Scene(cd.load("slider_crank"), drive="crank_bearing")
    swept = slider.sweep(np.linspace(0.0, 6.0, 25), speed=30.0)
    text = (
        '<robot name="arm"><link name="base"/><link name="arm"><inertial><origin xyz="1 0 0"/>'
        '<mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '</link><joint name="pivot" type="continuous"><parent link="base"/><child link="arm"/>'
        '<axis xyz="0 1 0"/></joint></robot>'
    )
    arm = cd.Scene(cd.load(text), drive="pivot", gravity=(0.0, 0.0, -10.0))
    (axes,) = force_polar(arm.sweep(np.linspace(0.0, 6.0, 25)), "pivot").axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$F_x$ [N]", "$F_z$ [N]")
    # What holds the arm points upwards.
    assert axes.get_lines()[0].get_ydata() == pytest.approx(20.0)
    (given,) = force_polar(swept, "crank_bearing", plane="zx").axes
    assert given.get_xlabel().startswith("$F_z$")


def test_gaps_of_a_campbell_diagram_are_explained() -> None:
    speed = np.linspace(1.0, 50.0, 31)
    whole = np.stack([40.0 + speed, 0.0 * speed], axis=1)
    assert note(campbell(speed, whole)) == ""
    broken = np.stack([40.0 + speed, np.where(speed < 20.0, 0.0, speed)], axis=1)
    assert "does not swing" in note(campbell(speed, broken))


def test_a_parallel_plot_explains_itself_in_short_units() -> None:
    columns = {"arm [m]": [0.1, 0.2, 0.3], "mass": [1.0, 2.0, 3.0], "force [N]": [2e3, 4e4, 9e4]}
    figure = parallel_coordinates(columns, limit=5e4)
    (axes,) = figure.axes
    assert [text.get_text() for text in axes.get_xticklabels()] == [
        "arm [mm]",
        "mass",
        "force [kN]",
    ]
    ends = [text.get_text() for text in axes.texts]
    assert ends == ["100.0", "300.0", "1.000", "3.000", "2.00", "90.00"]
    said = figure.get_supxlabel().replace("\n", " ")
    assert "a line is a case" in said and "dark where force is small" in said
    assert said.endswith("dashed beyond 50 kN")


def test_numbers_of_contours_and_limits_have_prefixes() -> None:
    x, y = np.array([0.1, 0.2, 0.3]), np.array([0.0, 50.0, 100.0])
    cells = np.add.outer([1e4, 1e5, 2e5], [0.0, 5e4, 1e5])
    labels = ("length [m]", "speed [1/min]", "force [N]")
    (axes,) = contour_map(x, y, cells, labels=labels, limit=1e5).axes
    assert axes.get_title() == "force [kN], limit 100 kN"
    numbers = [
        float(text.get_text().strip("$").removeprefix("\\mathdefault")[1:-1]) for text in axes.texts
    ]
    assert numbers and max(numbers) <= 300.0


def test_points_over_parameters_share_an_ordinate_in_short_units() -> None:
    parameters = {"arm [m]": [0.1, 0.2, 0.3], "mass [kg]": [1.0, 2.0, 3.0]}
    first, second = scatter(parameters, [2e3, 4e4, 9e4], label="force [N]").axes
    assert first.get_ylabel() == "force [kN]" and first.get_xlabel() == "arm [mm]"
    assert first.get_ylim() == second.get_ylim()
    assert not second.yaxis.get_tick_params()["labelleft"]


def test_a_bar_without_a_result_says_so() -> None:
    ranges = {"length": [1.0, 3.0, 4.0], "mass": [2.0, 3.0, np.nan], "none": [np.nan, 3.0, np.nan]}
    (axes,) = tornado(ranges, middle=3.0, label="force [N]").axes
    texts = {text.xy[1]: text.get_text() for text in axes.texts}
    assert texts == {
        "mass": "no result at the upper end",
        "none": "no result at the lower and upper end",
    }


def test_a_style_is_that_of_one_name_on_all_axes() -> None:
    """Efforts of drives, and below them forces of joints with other names."""
    motion = usual_motion(cd.load("slider_crank"), samples=9, loads={"piston_guide": -60.0})
    figure = motion.scene.sweep(motion.positions).plot()
    lines = [line for axes in figure.axes for line in axes.get_lines()]
    drawn = {
        (str(line.get_label()), line.get_color()) for line in lines if line.get_label()[0] != "_"
    }
    names, colors = map(set, zip(*drawn, strict=True))
    assert len(drawn) == len(names) == len(colors) > 1


def test_legends_call_limits_what_they_are() -> None:
    lift = Panel("effort [N]", "N", 1.0, {"lift": np.zeros(2)}, {"lift": (-181_100.0, 306_800.0)})
    figure = stacked(over("time", np.arange(2.0), "s"), [lift])
    (label,) = {line.get_label() for line in figure.axes[0].get_lines()}
    assert label == "lift, limits −181.1 … 306.8 kN"
