"""The common look: styles that differ without colours, axes, ticks, legends and files."""

from __future__ import annotations

import builtins
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

import matplotlib

from cardan_dyn import figures
from cardan_dyn.figures import style


def test_importing_figures_does_not_import_matplotlib() -> None:
    text = "import sys, cardan_dyn.figures; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_without_matplotlib_the_install_command_is_named(
    monkeypatch: pytest.MonkeyPatch, joint_turn: cd.Sweep
) -> None:
    real: Callable[..., object] = builtins.__import__

    def without(name: str, *rest: object, **more: object) -> object:
        if name.split(".")[0] == "matplotlib":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    for draw in (
        style.require_matplotlib,
        style.axes_grid,
        lambda: figures.over_angle(joint_turn, "bearing_in"),
    ):
        with pytest.raises(cd.MissingExtraError, match=re.escape('pip install "cardan-dyn[viz]"')):
            draw()


def test_eight_lines_differ_without_colours() -> None:
    styles = [str(style.line_style(index)["linestyle"]) for index in range(8)]
    markers = [style.point_style(index)["marker"] for index in range(8)]
    assert len(set(styles)) == len(set(markers)) == 8
    # Where colours come again, line styles are others.
    assert len({str(style.line_style(index)) for index in range(64)}) == 64


def test_sixteen_points_differ_without_colours() -> None:
    points = [style.point_style(index) for index in range(16)]
    assert len({(point["marker"], point["markerfacecolor"]) for point in points}) == 16
    assert all(point["linestyle"] == "none" for point in points)
    # Points have the colour of the line with the same index.
    for index, point in enumerate(points):
        assert point["color"] == style.line_style(index)["color"]


def test_a_line_of_one_point_has_a_marker() -> None:
    assert style.curve_style(3, 2) == style.line_style(3)
    single = style.curve_style(3, 1)
    assert single == {**style.line_style(3), "marker": style.point_style(3)["marker"]}


def test_axes_are_drawn_in_the_look_and_leave_the_users_look_alone() -> None:
    before = dict(matplotlib.rcParams)
    figure, axes = style.axes_grid()
    assert tuple(figure.get_size_inches()) == (7.2, 4.8)
    assert axes.spines["top"].get_visible() is False
    assert dict(matplotlib.rcParams) == before


def test_axes_are_listed_row_by_row() -> None:
    figure, axes = style.axes_grid(2, 3, size=(5.0, 4.0), share_x=True)
    assert axes.shape == (6,) and figure.axes == list(axes)
    assert tuple(figure.get_size_inches()) == (5.0, 4.0)
    shared = axes[0].get_shared_x_axes()
    assert shared.joined(axes[0], axes[3]) and not shared.joined(axes[0], axes[1])
    _, polar = style.axes_grid(projection="polar")
    assert polar.name == "polar"


def test_legend_has_each_label_once() -> None:
    figure, (first, second) = style.axes_grid(2)
    first.plot([0.0, 1.0], label="a")
    second.plot([0.0, 1.0], label="b")
    second.plot([1.0, 0.0], label="a")
    style.legend(figure)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["a", "b"]


@pytest.mark.slow
def test_same_figure_is_the_same_file(joint_turn: cd.Sweep, tmp_path: Path) -> None:
    contents = [
        [
            file.read_bytes()
            for file in figures.save(figures.over_angle(joint_turn, "bearing_in"), path)
        ]
        for path in (tmp_path / "first", tmp_path / "second")
    ]
    assert contents[0] == contents[1]


@pytest.mark.slow
def test_names_with_points_are_not_cut(tmp_path: Path) -> None:
    figure, axes = style.axes_grid(size=(2.0, 1.0))
    axes.plot([0.0, 1.0])
    first, second = (figures.save(figure, tmp_path / f"GWB 390.{size}") for size in (60, 65))
    assert [path.name for path in first] == ["GWB 390.60.svg", "GWB 390.60.png"]
    assert len({*first, *second}) == 4 and all(path.is_file() for path in (*first, *second))


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
def test_a_suffix_is_the_format_and_files_of_one_figure_are_the_same(
    suffix: str, tmp_path: Path
) -> None:
    contents = []
    for name in ("first", "second"):
        figure, axes = style.axes_grid(size=(2.0, 1.0))
        axes.plot([0.0, 1.0])
        (path,) = figures.save(figure, tmp_path / "new" / f"{name}{suffix}", dpi=100)
        assert path == tmp_path / "new" / f"{name}{suffix}"
        contents.append(path.read_bytes())
    content, again = contents
    assert content == again
    if suffix == ".png":
        width, height = (int.from_bytes(content[k : k + 4], "big") for k in (16, 20))
        assert (width, height) == (200, 100)


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0.0, 360.0, [0, 45, 90, 135, 180, 225, 270, 315, 360]),
        (-90.0, 90.0, [-90, -45, 0, 45, 90]),
        (10.0, 191.0, [45, 90, 135, 180]),
    ],
)
def test_ticks_of_a_turn_are_multiples_of_45(low: float, high: float, ticks: list[int]) -> None:
    _, axes = style.axes_grid()
    style.over("angle", np.deg2rad([high, low]), "rad").name(axes)
    np.testing.assert_allclose(axes.get_xticks(), ticks, atol=1e-9)
    np.testing.assert_allclose(axes.get_xlim(), (low, high))
    assert axes.get_xlabel() == "angle [°]"


@pytest.mark.parametrize(("low", "high"), [(0.0, 20.0), (0.0, 3600.0)])
def test_other_ranges_keep_matplotlibs_ticks(low: float, high: float) -> None:
    _, axes = style.axes_grid()
    style.over("angle", np.deg2rad([low, high]), "rad").name(axes)
    assert not np.all(axes.get_xticks() % 45.0 == 0.0)
    assert len(axes.get_xticks()) < 20


def test_a_single_angle_has_room_on_both_sides() -> None:
    _, axes = style.axes_grid()
    axes.plot([30.0], [1.0], "o")
    style.over("angle", np.deg2rad([30.0]), "rad").name(axes)
    low, high = axes.get_xlim()
    assert low < 30.0 < high


@pytest.mark.parametrize(("count", "points", "shown"), [(721, 36, 37), (10, 36, 10), (5, 0, 2)])
def test_points_are_thinned_evenly(count: int, points: int, shown: int) -> None:
    chosen = np.arange(count)[style.thinned(count, points)]
    assert len(chosen) == shown
    assert chosen[0] == 0 and len(set(np.diff(chosen))) == 1


def test_the_first_drive_is_the_default(joint_turn: cd.Sweep) -> None:
    assert style.drive_of(joint_turn, None) == "bearing_in"
    assert style.drive_of(joint_turn, "bearing_out") == "bearing_out"


def test_curves_over_an_abscissa() -> None:
    at = style.abscissa("speed", [1, 2, 3])
    assert at.tolist() == [1.0, 2.0, 3.0]
    assert style.shaped("line", [1, 2, 3], 3).dtype == float
    assert style.shaped("lines", np.ones((3, 2)), 3, "m").shape == (3, 2)
    assert style.shaped("lines", np.ones((3, 2)), 3, 2).shape == (3, 2)
    for call, message in (
        (lambda: style.abscissa("speed", [1.0, np.nan]), "speed has shape"),
        (lambda: style.abscissa("speed", []), "speed has shape"),
        (lambda: style.shaped("line", [[1, 2, 3]], 3), r"'line' has shape \(1, 3\)"),
        (lambda: style.shaped("lines", [1, 2, 3], 3, "m"), r"'lines' has shape \(3,\)"),
        (lambda: style.shaped("lines", np.ones((2, 3)), 3, "m"), r"expected \(3, m\)"),
        (lambda: style.shaped("lines", np.ones((3, 1)), 3, 2), r"expected \(3, 2\)"),
    ):
        with pytest.raises(cd.ArgumentError, match=message):
            call()


def test_a_number_stays_with_its_unit_where_a_title_breaks() -> None:
    title = "universal_joint: bearing_in 0° … 360° at 477.5 1/min, load bearing_out −100 N·m"
    for width in np.linspace(1.5, 8.0, 27):
        lines = style.wrapped(title, float(width)).split("\n")
        assert " ".join(lines) == title
        assert not any(line.startswith(("1/min", "N·m")) for line in lines)


def test_no_label_of_a_legend_is_cut() -> None:
    """Columns as Matplotlib fills them: nine labels in four columns are three, two, two and two."""
    for count in range(3, 12):
        drawn = style.sheet()
        for index in range(count):
            label = f"leg_{index}, limit 20 kN" if index < 6 else f"base_{index}_x"
            drawn.panels[0].plot([0, 1], label=label)
        figure = drawn.finish("", 4)
        figure.canvas.draw()
        (legend,) = figure.legends
        box = legend.get_window_extent()
        assert figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1
