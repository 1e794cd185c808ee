"""Numbers that figures and tables of a drive line's page draw, against others derived otherwise."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="figures")

from testkit.line_data import double_shaft, random_line

from cardan_dyn.practice.drive_lines.wording import Wording
from cardan_dyn.practice.report import line_figures, line_tables

WORDS = Wording()


def number_of(text: str) -> float:
    return float(text.replace("\N{MINUS SIGN}", "-").replace("\N{NARROW NO-BREAK SPACE}", ""))


def bars(forces: np.ndarray, errors: np.ndarray) -> list[list[float]]:
    """Heights of the bars of order 0, 1, …, of the angle error and of a bearing force."""
    turn = np.linspace(0.0, 2.0 * np.pi, len(forces), endpoint=False)
    analysis = SimpleNamespace(
        position=turn,
        shafts=("input", "output"),
        bearings=("B1",),
        angle_error=np.stack([np.zeros_like(errors), errors], axis=1),
        total=SimpleNamespace(bearing_force=forces[:, None, :]),
    )
    figure = line_figures.orders(analysis, WORDS)
    return [[bar.get_height() for bar in axes.patches] for axes in figure.axes]


def test_orders_of_forces_are_the_greatest_lengths_of_their_vectors() -> None:
    """Each order alone, sampled finely: the force that turns at 50.3 N, an ellipse, a line."""
    turn = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    across = {
        0: (30.0 + 0.0 * turn, -40.0 + 0.0 * turn),
        1: (50.3 * np.cos(turn), 50.3 * np.sin(turn)),
        2: (9.0 * np.cos(2 * turn + 0.3), 7.0 * np.cos(2 * turn + 1.4)),
        3: (5.0 * np.sin(3 * turn), 12.0 * np.sin(3 * turn)),
        5: (8.0 * np.cos(5 * turn), -8.0 * np.sin(5 * turn)),
    }
    forces = np.zeros((720, 3))
    forces[:, 0] = 1000.0 * np.cos(turn)  # Along the shaft, which does not count.
    forces[:, 1:] = np.sum([np.stack(pair, axis=1) for pair in across.values()], axis=0)
    errors = np.radians(0.25 * np.sin(2 * turn) + 0.03 * np.cos(4 * turn))
    angle, force = bars(forces, errors)
    assert force[1] == pytest.approx(50.3, rel=1e-12)
    for order, pair in enumerate(force):
        longest = np.max(np.hypot(*across.get(order, (0.0, 0.0))))
        assert pair == pytest.approx(longest, rel=1e-4, abs=1e-10), order
    assert force[3] == pytest.approx(13.0, rel=1e-12) and force[0] == pytest.approx(50.0)
    expected = [0.0, 0.0, 0.25, 0.0, 0.03, 0.0, 0.0, 0.0, 0.0]
    assert angle == pytest.approx(expected, abs=1e-12)


def test_bars_beside_each_other_differ_in_black_and_white() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    error = np.radians(np.sin(2.0 * turn))
    analysis = SimpleNamespace(
        position=turn,
        shafts=("input", "first", "second"),
        bearings=("B1",),
        angle_error=np.stack([0.0 * error, error, 2.0 * error], axis=1),
        total=SimpleNamespace(bearing_force=np.ones((36, 1, 3))),
    )
    first, second = np.split(np.array(line_figures.orders(analysis, WORDS).axes[0].patches), 2)
    assert [bar.get_hatch() for bar in (first[2], second[2])] == ["", "///"]
    # They stand clear of each other, and of those of the next order.
    assert first[2].get_x() + first[2].get_width() == pytest.approx(second[2].get_x())
    assert second[2].get_x() + second[2].get_width() < first[3].get_x()


def test_forks_that_can_be_built() -> None:
    """Each row is what the motion and the forces of the line with these forks have over a turn."""
    line = double_shaft((0.0, 0.1, 0.3), (0.0, 0.0, -0.15), fork_offset=np.radians(30.0))
    torque = 350.0
    found = line_tables.built_listing(line.phasing(), torque, WORDS)
    assert found is not None and found.header[-1] == "greatest bearing force [N]"
    names, *columns = zip(*found.rows, strict=True)
    forks, residual, force = np.array([[number_of(x) for x in column] for column in columns])
    assert names == ("as given", "best", "at 0° or 90°", "at 0° or 90°")
    assert forks[0] == 30.0 and sorted(abs(forks[2:])) == [0.0, 90.0]
    assert residual[1] <= residual[2] <= residual[3]
    for row, angle in enumerate(forks):
        turned = double_shaft((0.0, 0.1, 0.3), (0.0, 0.0, -0.15), fork_offset=np.radians(angle))
        solved = turned.analyse(speed=0.0, torque=torque, gravity=(0, 0, 0))
        lead = np.abs(solved.angle_error[:, -1]).max()
        equivalent = np.degrees(2.0 * np.arctan(np.sqrt(np.sin(lead))))
        assert residual[row] == pytest.approx(equivalent, abs=2e-3)
        assert force[row] == pytest.approx(solved.total.bearing_radial.max(), rel=5e-4)


def test_forks_at_right_angles_are_the_best_of_all_that_stand_so() -> None:
    """All choices of 0° and 90° of two forks, each by the maps of its joints."""
    line = random_line(3, seed=4)
    found = line_tables.built_listing(line.phasing(), 1.0, WORDS)
    assert found is not None
    square = [row for row in found.rows if row[0] == "at 0° or 90°"]
    told = {tuple(abs(number_of(x)) for x in row[1:3]): number_of(row[3]) for row in square}
    assert set(told) == set(product((0.0, 90.0), repeat=2))
    kappas, planes = np.tan(line.joint_angles / 2.0) ** 2, line.geometry.plane_offsets
    for forks, residual in told.items():
        phases = np.cumsum([0.0, *(np.pi / 2 + np.radians(forks) - planes[1:])])
        maps = np.eye(2, dtype=complex)
        for kappa, phase in zip(kappas, phases, strict=True):
            z = kappa * np.exp(-2j * phase)
            maps = np.array([[1.0, -z], [-np.conj(z), 1.0]]) @ maps
        exact = np.degrees(2.0 * np.arctan(np.sqrt(abs(maps[0, 1] / maps[0, 0]))))
        assert residual == pytest.approx(exact, abs=6e-4)
    assert list(told.values()) == sorted(told.values())
