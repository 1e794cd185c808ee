"""Drawn positions of a universal joint, against its geometry from the axes of shafts and pins."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit.scenes import CrossGeometry

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

from testkit.drawings import check_units_and_files

from cardan_dyn import figures

SAMPLES = [0, 90, 200]
TITLES = ["A", "between", "C"]
LINES_OF_A_SHAFT = 3  # Its fork, itself and its axis.


def points_of(line: Any) -> np.ndarray:
    return np.stack(line.get_data_3d(), axis=1)


def test_figure_is_written(joint_turn: cd.Sweep, tmp_path: Path) -> None:
    figure = figures.universal_joint_positions(joint_turn, [0, 90], ["A", "between"], title="cross")
    check_units_and_files(figure, tmp_path)
    assert figure.get_suptitle() == "cross"


def test_arms_forks_and_shafts_lie_along_pins_and_axes(joint_turn: cd.Sweep) -> None:
    figure = figures.universal_joint_positions(joint_turn, SAMPLES, TITLES)
    assert [axes.get_title() for axes in figure.axes] == TITLES
    beta = joint_turn.held["joint_angle"]
    angles = joint_turn.motion.position("bearing_in")[SAMPLES]
    geometry = CrossGeometry(beta, angles)
    for index, axes in enumerate(figure.axes):
        lines = [points_of(line) for line in axes.get_lines()]
        assert len(lines) == 2 * LINES_OF_A_SHAFT + 2
        shafts = lines[:LINES_OF_A_SHAFT], lines[LINES_OF_A_SHAFT : 2 * LINES_OF_A_SHAFT]
        arms = lines[2 * LINES_OF_A_SHAFT :]
        pins = geometry.pin_1[index], geometry.pin_2[index]
        # The input shaft lies behind the joint, the output shaft ahead of it.
        directions = -geometry.e_1[index], geometry.e_2[index]
        for (fork, shaft, axis), arm, pin, direction in zip(
            shafts, arms, pins, directions, strict=True
        ):
            centre = np.mean(arm, axis=0)
            np.testing.assert_allclose(np.abs((arm[1] - centre) @ pin), 1.0, rtol=1e-12)
            np.testing.assert_allclose(np.linalg.norm(arm - centre, axis=1), 1.0, rtol=1e-12)
            # The fork ends at both ends of its pin and lies in the plane of pin and shaft.
            np.testing.assert_allclose(np.abs((fork[[0, -1]] - centre) @ pin), 1.0, rtol=1e-12)
            np.testing.assert_allclose((fork - centre) @ np.cross(pin, direction), 0.0, atol=1e-12)
            for line in (shaft, axis):
                along = (line - centre) @ direction
                np.testing.assert_allclose(line - centre, np.outer(along, direction), atol=1e-12)
                assert along[1] > along[0] >= 0.0
            np.testing.assert_allclose(axis[0], centre, atol=1e-15)


def test_arrow_shows_the_moment_of_the_cross(joint_turn: cd.Sweep) -> None:
    figure = figures.universal_joint_positions(joint_turn, SAMPLES, TITLES)
    angles = joint_turn.motion.position("bearing_in")[SAMPLES]
    geometry = CrossGeometry(joint_turn.held["joint_angle"], angles)
    moments = geometry.moment(100.0)
    for axes, moment in zip(figure.axes, moments, strict=True):
        (arrow,) = axes.collections
        # Its shaft, which matplotlib lists before both strokes of its head, ends at the centre.
        tip, tail = np.array(arrow._segments3d[0])
        np.testing.assert_allclose(tail, joint_turn.origin("pin_in")[0], atol=1e-15)
        direction = (tip - tail) / np.linalg.norm(tip - tail)
        np.testing.assert_allclose(direction, moment / np.linalg.norm(moment), atol=1e-12)
        assert {text.get_text() for text in axes.texts} == {"I", "II", "M"}


def test_no_arrow_without_a_moment(joint_turn: cd.Sweep, joint_without_load: cd.Sweep) -> None:
    for figure in (
        figures.universal_joint_positions(joint_turn, [0], ["A"], moment=False),
        figures.universal_joint_positions(joint_without_load, [0], ["A"]),
    ):
        (axes,) = figure.axes
        assert len(axes.collections) == 0
        assert {text.get_text() for text in axes.texts} == {"I", "II"}


def test_view_and_scale_are_the_same_in_all_drawings(joint_turn: cd.Sweep) -> None:
    figure = figures.universal_joint_positions(joint_turn, SAMPLES, TITLES, view=(90.0, -90.0))
    for axes in figure.axes:
        assert (axes.elev, axes.azim) == (90.0, -90.0)
        limits = {axes.get_xlim(), axes.get_ylim(), axes.get_zlim()}
        assert limits == {(-2.2, 2.2)}


def test_wrong_arguments_are_refused(joint_turn: cd.Sweep) -> None:
    with pytest.raises(cd.ArgumentError, match="1 samples need as many titles, not 0"):
        figures.universal_joint_positions(joint_turn, [0], [])
    with pytest.raises(cd.ModelError, match="pin_on"):
        figures.universal_joint_positions(joint_turn, [0], ["A"], pins=("pin_in", "pin_on"))
