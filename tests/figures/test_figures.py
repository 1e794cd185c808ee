"""Figures: each draws what it says, with units on its axes, as SVG and PNG."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.validation.comparisons import POSITIONS, double_shaft_turn, universal_joint_turn

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from cardan_dyn import figures
from cardan_dyn.figures.style import line_style, point_style
from cardan_dyn.figures.work_precision import read_records, work_precision

BETA = float(np.deg2rad(50.0))
UNIT = re.compile(r"\[(–|°|N|N·m|mm|µs)\]$")
RECORDS = [
    {
        "method": method,
        "task": task,
        "beta_deg": 50.0,
        "error": 0.0 if steps == 4 else 10.0 ** (-order * steps),
        "microseconds": cost * 2.0**steps,
    }
    for task in ("motion", "wrenches")
    for method, order, cost in (("first", 1, 0.1), ("second", 2, 1.0), ("third", 3, 4.0))
    for steps in range(1, 5)
]


@pytest.fixture(scope="module")
def turn() -> cd.Sweep:
    return universal_joint_turn(cd.load("universal_joint"), BETA)


@pytest.fixture(scope="module")
def shaft() -> cd.Sweep:
    return double_shaft_turn(cd.load("double_shaft_z"), BETA)


@pytest.fixture(scope="module")
def needles() -> cd.Sweep:
    return cd.Scene(cd.load("needle_drive"), drive="main_shaft").sweep(POSITIONS, speed=209.4)


def drawn(name: str, turn: cd.Sweep, shaft: cd.Sweep, needles: cd.Sweep) -> Any:
    bending = turn.wrench("bearing_out", "parent").moment
    return {
        "torque_ratio": lambda: figures.torque_ratio(turn),
        "bending_polar": lambda: figures.bending_polar(turn),
        "thoma_bending": lambda: figures.thoma_bending(turn),
        "speed_ratio": lambda: figures.speed_ratio(turn, shaft),
        "compared": lambda: figures.compared(
            POSITIONS, {"a": bending[:, 1]}, {"a": bending[:, 1]}, quantity="M [N·m]"
        ),
        "over_angle": lambda: figures.over_angle(turn, ["bearing_in", "bearing_out"]),
        "over_angle, forces": lambda: figures.over_angle(needles, "needle_pin", ["shear", "axial"]),
        "ratio_and_angle_error": lambda: figures.ratio_and_angle_error({"a": turn, "b": shaft}),
        "moment_polar": lambda: figures.moment_polar(turn, "bearing_out", ["parent", "joint"]),
        "force_polar": lambda: figures.force_polar(
            needles, needles.outputs[:5], "world", plane="xy"
        ),
        "forces_in_place": lambda: figures.forces_in_place(
            needles, ["rocker_pin"], [["rocker_pin", "rocker_bearing"]], size=0.05
        ),
        "order_spectrum": lambda: figures.order_spectrum(
            POSITIONS, {"y": bending[:, 1], "z": bending[:, 2]}, unit="N·m", logarithmic=True
        ),
        "universal_joint_positions": lambda: figures.universal_joint_positions(
            turn, [0, 90], ["A", "between"]
        ),
        "work_precision": lambda: work_precision(RECORDS),
    }[name]()


FIGURES = (
    "torque_ratio",
    "bending_polar",
    "thoma_bending",
    "speed_ratio",
    "compared",
    "over_angle",
    "over_angle, forces",
    "ratio_and_angle_error",
    "moment_polar",
    "force_polar",
    "forces_in_place",
    "order_spectrum",
    "universal_joint_positions",
    "work_precision",
)


@pytest.mark.parametrize("name", FIGURES)
def test_draws_with_units(
    name: str, turn: cd.Sweep, shaft: cd.Sweep, needles: cd.Sweep, tmp_path: Path
) -> None:
    figure = drawn(name, turn, shaft, needles)
    vector, pixels = figures.save(figure, tmp_path / "deep" / "figure")
    assert vector.read_text(encoding="utf-8").count("<path") > 5
    content = pixels.read_bytes()
    assert content.startswith(b"\x89PNG") and len(content) > 10_000
    for axes in figure.axes:
        if axes.name != "rectilinear":
            continue
        assert UNIT.search(axes.get_ylabel()), axes.get_ylabel()
        # Of axes that share their abscissa only the lowest says what it is.
        shared = axes.get_shared_x_axes().get_siblings(axes)
        labels = [other.get_xlabel() for other in shared if other.get_xlabel()]
        assert labels and all(UNIT.search(label) for label in labels), labels


CLOSED = ("torque_ratio", "thoma_bending", "speed_ratio", "bending_polar")
ODD_SWEEPS = {
    "from elsewhere": (np.linspace(1.0, 4.0, 37), -50.0),
    "100 samples": (np.linspace(0.0, 2.0 * np.pi, 100), -100.0),
    "one sample": (np.array([2.0]), -1e-3),
    "driving load": (np.linspace(-7.0, 9.0, 33), 70.0),
    "in any order": (np.array([5.0, 1.0, 30.0, 2.5]), np.array([1.0, -2.0, 3.0, 0.0])),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("case", ODD_SWEEPS)
def test_points_lie_on_the_lines_of_any_sweep(name: str, case: str, tmp_path: Path) -> None:
    """Angles and torques are the sweep's own, wherever it starts and whatever its load."""
    positions, load = ODD_SWEEPS[case]
    beta = 0.6
    scenes = [
        cd.Scene(
            cd.load(source),
            drive="bearing_in",
            held=dict.fromkeys(held, beta),
            loads={"bearing_out": load},
        )
        for source, held in (
            ("universal_joint", ("joint_angle",)),
            ("double_shaft_z", ("joint_angle_1", "joint_angle_2")),
        )
    ]
    swept = [scene.sweep(positions) for scene in scenes]
    arguments = swept if name == "speed_ratio" else swept[:1]
    figure = getattr(figures, name)(*arguments)
    figures.save(figure, tmp_path / "figure")
    lines, points = figure.axes[0].get_lines()[::2], figure.axes[0].get_lines()[1::2]
    assert len(lines) == len(points) == (1 if name == "torque_ratio" else 2)
    for line, found in zip(lines, points, strict=True):
        angle, value = found.get_xydata().T
        if name != "speed_ratio" and len(angle) == len(positions):
            # Where no torque passes there is no ratio.
            loaded = np.broadcast_to(load, len(angle)) != 0.0
            np.testing.assert_array_equal(np.isfinite(value), loaded)
        x, y = line.get_xydata().T
        if name == "bending_polar":
            x, angle = x % (2.0 * np.pi), angle % (2.0 * np.pi)
            y = y[np.argsort(x)]
            x = np.sort(x)
            wanted = np.interp(angle, x, y, period=2.0 * np.pi)
        else:
            assert np.all((angle >= x[0] - 1e-9) & (angle <= x[-1] + 1e-9))
            low, high = figure.axes[0].get_xlim()
            assert low <= np.min(angle) and np.max(angle) <= high
            wanted = np.interp(angle, x, y)
        known = np.isfinite(value)
        np.testing.assert_allclose(value[known], wanted[known], atol=1e-4)
    if name != "bending_polar":
        own = np.rad2deg(swept[0].motion.position("bearing_in"))
        assert np.all(np.isin(points[0].get_xdata(), own))


def test_closed_forms_need_a_torque(joint_without_load: cd.Sweep) -> None:
    for draw in (figures.torque_ratio, figures.thoma_bending, figures.bending_polar):
        with pytest.raises(cd.ArgumentError, match=r"no torque passes .* load 'bearing_out'"):
            draw(joint_without_load)


@pytest.fixture(scope="module")
def joint_without_load() -> cd.Sweep:
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.3})
    return scene.sweep([0.0, 1.0])


def test_one_sample_is_drawn(tmp_path: Path) -> None:
    """A line of one point would not be seen."""
    held = {"joint_angle": 0.5}
    scene = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held=held, loads={"bearing_out": 1.0}
    )
    one = scene.sweep([2.0])
    for figure in (
        figures.over_angle(one, "bearing_out"),
        figures.ratio_and_angle_error({"a": one}),
        figures.moment_polar(one, "bearing_out"),
    ):
        figures.save(figure, tmp_path / "one")
        assert all(axes.get_lines()[0].get_marker() == "o" for axes in figure.axes)
    with pytest.raises(cd.ArgumentError, match="no sweep"):
        figures.ratio_and_angle_error({})


def test_all_sweeps_of_a_figure_are_within_its_range(turn: cd.Sweep) -> None:
    held = {"joint_angle": BETA}
    scene = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held=held, loads={"bearing_out": 1.0}
    )
    figure = figures.ratio_and_angle_error({"long": turn, "short": scene.sweep([1.0, 2.0])})
    low, high = figure.axes[1].get_xlim()
    assert low <= 0.0 and high >= 360.0 - 1e-9


def test_same_figure_is_the_same_file(turn: cd.Sweep, tmp_path: Path) -> None:
    contents = [
        [path.read_bytes() for path in figures.save(figures.over_angle(turn, "bearing_in"), path)]
        for path in (tmp_path / "first", tmp_path / "second")
    ]
    assert contents[0] == contents[1]


def test_lines_differ_without_colours(turn: cd.Sweep, shaft: cd.Sweep) -> None:
    styles = [str(line_style(number)["linestyle"]) for number in range(8)]
    markers = [point_style(number)["marker"] for number in range(8)]
    assert len(set(styles)) == len(set(markers)) == 8
    figure = figures.ratio_and_angle_error({"a": turn, "b": shaft})
    for axes in figure.axes:
        shown = {line.get_linestyle() for line in axes.get_lines()}
        assert len(shown) == 2


def test_moment_polar_is_thomas_circle(turn: cd.Sweep) -> None:
    """In fixed axes a circle through the origin, of diameter T tan β; in turning axes a line."""
    fixed, turning = figures.moment_polar(turn, "bearing_out", ["parent", "joint"]).axes
    y, z = fixed.get_lines()[0].get_data()
    radius = 50.0 * np.tan(BETA)
    np.testing.assert_allclose(np.hypot(y - radius, z), radius, rtol=1e-12)
    y, z = turning.get_lines()[0].get_data()
    np.testing.assert_allclose(z, 0.0, atol=1e-11)
    assert np.ptp(y) == pytest.approx(4.0 * radius)
    assert fixed.get_xlabel() == "$M_y$ [N·m]" and fixed.get_ylabel() == "$M_z$ [N·m]"
    assert {text.get_text() for text in fixed.texts} == {"0°, 180°", "90°, 270°"}
    assert fixed.get_aspect() == turning.get_aspect() == 1.0


def test_polars_in_place_share_a_scale(needles: cd.Sweep) -> None:
    joints = ["rocker_bearing", "needle_pin"]
    figure = figures.forces_in_place(needles, joints, [], size=0.06)
    forces = {name: needles.wrench(name, "world").force[:, :2] for name in joints}
    greatest = np.max(np.linalg.norm(forces["rocker_bearing"], axis=1))
    curves = {line.get_label(): line for line in figure.axes[0].get_lines()}
    for name in joints:
        from_joint = curves[name].get_xydata() / 1e3 - needles.origin(name)[0, :2]
        np.testing.assert_allclose(from_joint, 0.06 * forces[name] / greatest, atol=1e-12)


def test_order_amplitudes() -> None:
    for angle in (
        np.linspace(0.0, 4.0 * np.pi, 181),
        np.linspace(0.0, 4.0 * np.pi, 180, endpoint=False),
        np.linspace(1.0, 1.0 + 4.0 * np.pi, 180, endpoint=False),
    ):
        values = -2.0 + 3.0 * np.cos(2.0 * angle + 0.3) - 0.5 * np.sin(4.5 * angle)
        orders, amplitudes = figures.order_amplitudes(angle, values)
        expected = np.zeros_like(orders)
        expected[orders == 0.0], expected[orders == 2.0], expected[orders == 4.5] = 2.0, 3.0, 0.5
        np.testing.assert_allclose(amplitudes, expected, atol=1e-13)
    # The highest order of an even number of samples occurs once.
    _, amplitudes = figures.order_amplitudes(0.5 * np.pi * np.arange(4), [1.0, -1.0, 1.0, -1.0])
    np.testing.assert_allclose(amplitudes, [0.0, 0.0, 1.0], atol=1e-15)


@pytest.mark.parametrize(
    "angle", [np.linspace(0.0, 3.0, 50), [0.0, 1.0, 3.0, 6.0], [0.0, 1.0], [2.0, 1.0, 0.0]]
)
def test_orders_need_whole_turns(angle: Any) -> None:
    with pytest.raises(cd.ArgumentError, match="orders need"):
        figures.order_amplitudes(angle, np.zeros(len(angle)))


def test_wrong_names_are_refused(turn: cd.Sweep) -> None:
    with pytest.raises(cd.ArgumentError, match="quantity 'twist' is unknown"):
        figures.over_angle(turn, "bearing_in", "twist")
    with pytest.raises(cd.ArgumentError, match="frame 'fixed' is unknown"):
        figures.moment_polar(turn, "bearing_in", "fixed")
    with pytest.raises(cd.ArgumentError, match="plane 'xz' is unknown"):
        figures.moment_polar(turn, "bearing_in", plane="xz")
    with pytest.raises(cd.ModelError, match="bearing_on"):
        figures.force_polar(turn, "bearing_on")
    with pytest.raises(cd.ArgumentError, match="as many titles"):
        figures.universal_joint_positions(turn, [0], [])


def test_records(tmp_path: Path) -> None:
    assert read_records(tmp_path) == []
    (tmp_path / "a.json").write_text(json.dumps(RECORDS[:2]), encoding="utf-8")
    unmeasured = {**RECORDS[0], "error": None}
    content = {"machine": "x", "records": [*RECORDS[2:4], {"method": "no error"}, unmeasured]}
    (tmp_path / "b.json").write_text(json.dumps(content), encoding="utf-8")
    assert read_records(tmp_path) == RECORDS[:4]
    (tmp_path / "c.json").write_text("{", encoding="utf-8")
    with pytest.raises(cd.ArgumentError, match=r"c\.json is not JSON"):
        read_records(tmp_path)


def test_work_precision() -> None:
    figure = work_precision(RECORDS)
    assert [axes.get_title() for axes in figure.axes] == ["motion", "wrenches"]
    for axes in figure.axes:
        assert axes.get_xscale() == axes.get_yscale() == "log"
        lines = {line.get_label(): line for line in axes.get_lines()}
        assert list(lines) == ["first", "second", "third"]
        # From quick to slow; an error of zero stays on the paper.
        assert np.all(np.diff(lines["second"].get_xdata()) > 0.0)
        assert lines["second"].get_ydata()[-1] == 1e-17
    for wrong in ([], [{"method": "a"}]):
        with pytest.raises(cd.ArgumentError, match="method, task, error, microseconds"):
            work_precision(wrong)


def test_importing_figures_does_not_import_matplotlib() -> None:
    text = "import sys, cardan_dyn.figures; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
