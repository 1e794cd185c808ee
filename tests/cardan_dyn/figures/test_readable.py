"""Figures can be read, whatever they show: no text covers another one or is cut."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from testkit.scenes import text, universal

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_texts

import cardan_dyn as cd
from cardan_dyn import drive_lines, figures
from cardan_dyn.figures import critical_speeds, designs, style, vibration
from cardan_dyn.motion.clearance import drawing
from cardan_dyn.practice.drive_lines import drawing as line_drawing

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 73)
SPEEDS = np.linspace(10.0, 300.0, 40)
LONG = "main_shaft_between_motor_and_needle_bar_of_station_number_one"
TITLE = "A title about the needle drive, its bearings and what acts in them at full speed, " * 2


def test_texts_that_overlap_or_are_cut_are_found() -> None:
    figure, axes = style.axes_grid()
    check_texts(figure)
    axes.text(0.5, 0.5, "one")
    axes.text(0.5, 0.5, "other")
    with pytest.raises(AssertionError, match="one"):
        check_texts(figure)
    figure, axes = style.axes_grid()
    axes.annotate("outside", (1.0, 0.5), xycoords="figure fraction", annotation_clip=False)
    with pytest.raises(AssertionError, match="cut"):
        check_texts(figure)


@pytest.fixture(scope="module")
def long_named() -> cd.Sweep:
    """The needle drive, whose joints have long names."""
    names = {"main_shaft": LONG, "rocker_bearing": "bearing_of_the_rocker_behind_the_gearbox"}
    description = text("needle_drive")
    for short, name in names.items():
        description = description.replace(short, name)
    return cd.Scene(cd.load(description), drive=LONG).sweep(POSITIONS, speed=209.4)


@pytest.mark.slow
def test_long_names_and_titles(long_named: cd.Sweep) -> None:
    check_texts(long_named.plot(title=TITLE))
    check_texts(long_named.plot(*long_named.outputs))
    check_texts(long_named.plot.orders())
    check_texts(long_named.plot.polar(title=TITLE))


@pytest.mark.slow
@pytest.mark.parametrize("load", [1e-12, 1.0, 1e12])
def test_sizes_of_any_kind(joint: cd.Mechanism, load: float) -> None:
    turn = universal(joint, 0.5, load=-load).sweep(POSITIONS)
    check_texts(turn.plot("bearing_out", "bearing_in"))
    check_texts(turn.plot("bearing_out", peaks=True))
    check_texts(turn.plot("bearing_out.bending", "drive_effort", "pin_in.position"))
    check_texts(turn.plot.orders("bearing_out.bending"))
    check_texts(turn.plot.polar("bearing_out", ["parent", "joint"]))


@pytest.mark.slow
def test_one_sample_and_nothing(joint_without_load: cd.Sweep, one_position: cd.Sweep) -> None:
    check_texts(joint_without_load.plot())
    check_texts(joint_without_load.plot.polar("bearing_out"))
    check_texts(one_position.plot())
    check_texts(one_position.plot.polar("bearing_out"))
    check_texts(one_position.plot("drive_effort", peaks=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(drive_lines.examples()))
def test_lines_in_both_views(name: str) -> None:
    line = drive_lines.DriveLine.from_toml(name)
    check_texts(line.plot())
    side, plan = line.plot().axes
    # One scale across the line in both views.
    assert np.ptp(side.get_ylim()) == pytest.approx(np.ptp(plan.get_ylim()), rel=0.5)


def _orders() -> Any:
    swing = 1e-4 / np.abs(1.0 - (SPEEDS / 100.0) ** 2 + 0.02j)
    near = {"first": 100.0, "second": 104.0, "third": 108.0, "fourth": 250.0}
    return critical_speeds.orders_over_speed(SPEEDS, {"tilt": swing}, unit="rad", critical=near)


def _campbell() -> Any:
    modes = np.stack([80.0 + 0.2 * SPEEDS, 80.0 - 0.15 * SPEEDS], axis=1)
    return critical_speeds.campbell(SPEEDS, modes, orders=(1, 2, 4), title="Campbell")


def _orbit() -> Any:
    path = 1e-4 * np.stack([np.cos(POSITIONS), 0.4 * np.sin(POSITIONS)], axis=1)
    return vibration.orbits({"100 rad/s": path}, labels=("tilt_y [rad]", "tilt_z [rad]"))


def _parameters() -> dict[str, Any]:
    numbers = np.random.default_rng(1)
    return {
        f"parameter number {k} [kg·m²]": 10.0 ** (3 * k - 6) * numbers.normal(size=50)
        for k in range(5)
    }


def _scatter() -> Any:
    return designs.scatter(_parameters(), np.linspace(0.0, 1.0, 50), label="force [N]", limit=0.5)


def _map() -> Any:
    values = np.outer(np.arange(1.0, 9.0), np.linspace(1.0, 2.0, 7))
    values[2, 3] = np.nan
    labels = ("joint angle [°]", "length of the shaft [m]", "greatest force [N]")
    return designs.value_map(np.arange(8.0), np.arange(7.0), values, labels=labels, limit=9.0)


@pytest.mark.parametrize(
    "draw",
    [
        _orders,
        _campbell,
        _orbit,
        _scatter,
        _map,
        lambda: designs.parallel_coordinates(_parameters()),
        lambda: vibration.multipliers(SPEEDS, np.full((40, 12), 1.0)),
    ],
)
def test_other_figures(draw: Callable[[], Any]) -> None:
    check_texts(draw())


def test_cells_without_a_result_alone_are_grey() -> None:
    values = np.outer(np.arange(1.0, 9.0), np.linspace(1.0, 2.0, 7))
    values[2, 3] = np.nan
    labels = ("x [m]", "y [m]", "force [N]")
    figure = designs.contour_map(np.arange(8.0), np.arange(7.0), values, labels=labels)
    (axes,) = figure.axes
    from matplotlib.collections import QuadMesh

    (grey,) = (item for item in axes.collections if isinstance(item, QuadMesh))
    shown = np.ma.filled(np.ma.asarray(grey.get_array(), float), np.nan).reshape(7, 8).T
    np.testing.assert_array_equal(np.isfinite(shown), np.isnan(values))
    assert [item.get_text() for item in figure.legends[0].get_texts()] == ["no result: 1 of 56"]


def test_colours_differ_for_every_eye() -> None:
    """Differences in the plane of Lab as those see them who lack one kind of cones.

    Matrices of Machado, Oliveira and Fernandes (2009) for complete blindness.
    """
    blind = {
        "none": np.eye(3),
        "protan": [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        "deutan": [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
    }
    from matplotlib.colors import to_rgb

    given = np.array([to_rgb(style.line_style(index)["color"]) for index in range(8)])
    linear = np.where(given > 0.04045, ((given + 0.055) / 1.055) ** 2.4, given / 12.92)
    to_xyz = np.array(
        [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
    )
    for kind, matrix in blind.items():
        seen = np.clip(linear @ np.array(matrix).T, 0.0, 1.0) @ to_xyz.T
        seen /= to_xyz.sum(axis=1)
        root = np.where(seen > 0.008856, np.cbrt(seen), 7.787 * seen + 16.0 / 116.0)
        x, y, z = root.T
        lab = np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=1)
        apart = np.linalg.norm(lab[:, None] - lab[None], axis=2)[np.triu_indices(8, 1)]
        assert apart.min() > 15.0, kind


def test_looks_of_users_do_not_change_figures(one_position: cd.Sweep) -> None:
    import matplotlib

    with matplotlib.rc_context({"font.size": 25.0, "lines.linewidth": 9.0, "axes.grid": False}):
        figure = one_position.plot("drive_effort")
    (line,) = figure.axes[0].lines
    assert line.get_linewidth() == style.LOOK["lines.linewidth"]
    assert figure.legends[0].get_texts()[0].get_fontsize() == style.LOOK["font.size"]


def test_labels_of_peaks_leave_lines_alone() -> None:
    from cardan_dyn.figures.columns import over_column

    at = style.over("way", np.linspace(0.0, 1.0, 101), "m")
    # The peak of the lower line lies right below the upper one.
    hump = 1.0 + 0.5 * np.sin(np.pi * at.values)
    columns = {"upper": (1.03 * hump, "N"), "lower": (hump, "N")}
    (axes,) = over_column(at, columns).axes
    assert [text.get_text() for text in axes.texts] == ["1.545 N at 0.5 m"]
    assert len(axes.collections) == 2
    (axes,) = over_column(at, columns, peaks=True).axes
    assert {text.get_text() for text in axes.texts} >= {"1.545 N at 0.5 m", "1.5 N at 0.5 m"}
    on_white = [text for text in axes.texts if text.get_bbox_patch() is not None]
    assert "1.5 N at 0.5 m" in [text.get_text() for text in on_white]


def _drawing_functions() -> dict[str, Callable[..., Any]]:
    rooms = (figures, drawing, line_drawing, critical_speeds, designs, vibration)
    return {
        f"{room.__name__}.{name}": function
        for room in rooms
        for name, function in vars(room).items()
        if inspect.isfunction(function)
        and not name.startswith("_")
        and inspect.unwrap(function).__annotations__.get("return") == "Figure"
    }


def test_every_figure_takes_axes_a_size_and_a_title() -> None:
    found = _drawing_functions()
    assert len(found) > 25
    for name, function in found.items():
        parameters = inspect.signature(function).parameters
        if "onto" in parameters:
            assert parameters["onto"].annotation == "Unpack[Onto]", name
            continue
        assert {"ax", "figsize", "title"} <= set(parameters), name
        assert parameters["ax"].kind is inspect.Parameter.KEYWORD_ONLY, name
    assert set(style.Onto.__annotations__) == {"ax", "figsize", "title"}


@pytest.mark.parametrize("count", [1, 3])
def test_figures_of_two_axes_need_two(joint_turn: cd.Sweep, count: int) -> None:
    from matplotlib.figure import Figure

    axes = Figure().subplots(count)
    with pytest.raises(cd.ArgumentError, match=f"ax has {count} axes, and 2 are drawn"):
        figures.over_angle(joint_turn, "bearing_out", ax=axes)
    with pytest.raises(cd.ArgumentError, match=f"ax has {count} axes, and 2 are drawn"):
        figures.ratio_and_angle_error({"joint": joint_turn}, ax=axes)
