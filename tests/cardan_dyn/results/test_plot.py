"""Results plot themselves: right numbers over the right abscissa, and errors that name names."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd

pytest.importorskip("matplotlib", reason="figures need matplotlib")

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 73)


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Sweep:
    return universal(joint, 0.5, load=-2.0).sweep(POSITIONS, speed=3.0)


def test_joints_are_drawn_by_torsion_and_bending(turn: cd.Sweep) -> None:
    torsion, bending = turn.plot("bearing_out", "bearing_in").axes
    assert [line.get_label() for line in bending.lines] == ["bearing_out", "bearing_in"]
    np.testing.assert_array_equal(bending.lines[0].get_ydata(), turn["bearing_out"].bending)
    np.testing.assert_allclose(torsion.lines[0].get_xdata(), np.rad2deg(POSITIONS))


def test_columns_of_one_unit_share_their_axes(turn: cd.Sweep) -> None:
    names = ("bearing_out.bending", "pin_in.velocity", "drive_effort")
    moments, rates = turn.plot(*names, title="three").axes
    assert [line.get_label() for line in moments.lines] == [names[0], names[2]]
    np.testing.assert_array_equal(rates.lines[0].get_ydata(), turn.motion.velocity("pin_in"))
    assert (moments.get_ylabel(), rates.get_ylabel()) == ("[N·m]", "[rad/s]")
    assert rates.get_xlabel() == "position [°]"
    (over,) = turn.plot("drive_effort", over="bearing_out.position").axes
    at = turn.motion.position("bearing_out")
    np.testing.assert_allclose(over.lines[0].get_xdata(), np.rad2deg(at))


def test_orders_and_polar_diagrams_are_those_of_figures(turn: cd.Sweep) -> None:
    (axes,) = turn.plot.orders("bearing_out.bending", highest=4).axes
    orders, sizes = cd.figures.order_amplitudes(POSITIONS, turn["bearing_out"].bending)
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == pytest.approx(sizes[np.isin(orders, range(5))])
    assert len(turn.plot.polar(["bearing_out", "pin_in"], of="force").axes) == 2


def test_trajectories_are_drawn_over_time(joint: cd.Mechanism) -> None:
    free = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5})
    trajectory = free.simulate(0.1, speed=5.0)
    (axes,) = trajectory.plot("kinetic_energy").axes
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), trajectory.time)
    assert axes.get_xlabel() == "time [s]"


@pytest.mark.parametrize(
    ("columns", "options", "message"),
    [
        ((), {}, "name what is drawn; columns: "),
        (("bending",), {}, "no column 'bending'; columns: "),
        (("drive_effort",), {"over": "angle"}, "no column 'angle'"),
    ],
)
def test_what_is_no_column_is_refused(
    turn: cd.Sweep, columns: tuple[str, ...], options: dict[str, str], message: str
) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        turn.plot(*columns, **options)
    with pytest.raises(cd.ArgumentError, match="of is 'torque'; it is force, moment"):
        turn.plot.polar("bearing_out", of="torque")
    with pytest.raises(cd.ArgumentError, match="columns of one unit, not of: N, N·m"):
        turn.plot.orders("bearing_out.bending", "bearing_out.shear")


def test_grids_are_no_lines(joint: cd.Mechanism) -> None:
    grid = universal(joint, 0.5).sweep(POSITIONS, speed=[[1.0], [2.0]])
    with pytest.raises(cd.ArgumentError, match="over one dimension, not over sample_0, sample_1"):
        grid.plot("drive_effort")
