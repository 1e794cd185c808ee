"""What a trajectory shows of the sweep along its motion."""

from __future__ import annotations

import numpy as np
import pytest
from testkit import task_machines as machines
from testkit.simulated import GRAVITY, MASS, pendulum

import cardan_dyn as cd


@pytest.fixture(scope="module")
def turn(joint: cd.Mechanism) -> cd.Trajectory:
    scene = cd.Scene(
        joint,
        free="bearing_in",
        held={"joint_angle": 0.7},
        loads={"bearing_out": -2.0},
        gravity=(0.0, 0.0, -9.81),
        outputs=["bearing_in", "pin_in", "joint_angle"],
        elements=[cd.JointSpring("bearing_out", 0.0, damping=0.3)],
    )
    return scene.simulate(0.4, speed=20.0).evenly(9)


def test_its_wrenches_are_those_of_a_sweep(turn: cd.Trajectory, joint: cd.Mechanism) -> None:
    """The same motion by inverse dynamics of a scene without elements."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.7}, gravity=turn.gravity)
    drag = -2.0 - 0.3 * turn.motion.velocity("bearing_out")
    sweep = scene.sweep(turn.position, turn.speed, turn.acceleration, loads={"bearing_out": drag})
    for name in turn:
        scale = np.max(np.abs(sweep[name].moment))
        np.testing.assert_allclose(turn[name].moment, sweep[name].moment, atol=1e-9 * scale)
        there = turn.wrench(name, "world").force, sweep.wrench(name, "world").force
        np.testing.assert_allclose(*there, atol=1e-9 * np.max(np.abs(there[1])))
        np.testing.assert_allclose(turn.rotation(name), sweep.rotation(name), atol=1e-12)
        np.testing.assert_allclose(turn.origin(name), sweep.origin(name), atol=1e-12)
    np.testing.assert_allclose(
        turn.holding_effort["joint_angle"],
        sweep.holding_effort["joint_angle"],
        rtol=1e-9,
        atol=1e-12,
    )
    np.testing.assert_allclose(turn.loads["bearing_out"], -2.0)


@pytest.mark.parametrize("method", ["quadrature", "response", "DOP853"])
@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 1e-9])
def test_wrenches_of_what_all_but_rests_are_known(method: str, off: float) -> None:
    """Its weight is all that there is; accelerations are rounding, and no sign of singularity."""
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    resting = scene.simulate(1.0, position=np.pi + np.pi + off, method=method)
    np.testing.assert_allclose(resting["pin"].force[:, 1], 9.81 * MASS, rtol=1e-12)
    assert resting.effort_residual < 1e-12
    # Accelerations that do not belong to the motion are seen by what they lack of the weight.
    wrong = resting._rows._replace(a=resting._rows.a + 1e-4)
    moved = cd.Trajectory(resting._course, resting.time)
    moved.__dict__.update(_rows=wrong, _drives_alone=None, _misfit=0.0)
    with pytest.raises(cd.AccuracyError, match="accelerations and wrenches are wrong by"):
        _ = moved.effort_residual


def test_it_is_like_a_sweep(turn: cd.Trajectory) -> None:
    assert list(turn) == ["bearing_in", "pin_in", "joint_angle"]
    assert "pin_in" in turn
    assert "pin_out" not in turn
    assert 3 not in turn
    assert turn.unique.shape == turn.sweep.unique.shape
    for alone, swept in zip(
        turn.element_force.values(), turn.sweep.element_force.values(), strict=True
    ):
        # The sweep closes the loops of the states once more, to other roundings.
        size = np.max(np.abs(swept.effort))
        np.testing.assert_allclose(alone.effort, swept.effort, rtol=0.0, atol=1e-14 * size)
    assert len(turn.element_force) == 1
    np.testing.assert_array_equal(turn.elastic_energy, turn.sweep.elastic_energy)
    assert turn.condition.shape == turn.shape == (9,)
    assert np.max(np.abs(turn.sweep.drive_effort)) < 1e-12


@pytest.mark.parametrize("name", ["loop", "balance", "power", "rate"])
def test_it_is_proven(turn: cd.Trajectory, name: str) -> None:
    # Some roundings times the condition number, which is of order ten.
    assert getattr(turn, f"{name}_residual") < 1e-13


@pytest.mark.slow
def test_figures_and_views_take_it(turn: cd.Trajectory) -> None:
    figures = pytest.importorskip("cardan_dyn.figures")
    pytest.importorskip("meshcat")
    axes = figures.moment_polar(turn, ["bearing_in"])
    assert axes is not None
    assert cd.view(turn) is not None


def test_free_coordinates_have_no_effort() -> None:
    """What inverse dynamics leaves of one is the error of accelerations, and no result."""
    here, side = np.zeros(3), np.array([1.0, 0.0, 0.0])
    parts = [machines.link("ground"), machines.link("trolley", 5.0, here, here + 0.1)]
    parts += [machines.link("rod", 2.0, here - 0.3, here + 0.1)]
    parts.append(machines.joint("base", "prismatic", "ground", "trolley", here, side))
    turned = np.array([0.0, 1.0, 0.0])
    parts.append(machines.joint("swing", "continuous", "trolley", "rod", here, turned))
    mechanism = cd.load(machines.robot("crane", *parts))
    scene = cd.Scene(mechanism, drive="base", free="swing", gravity=GRAVITY)
    found = scene.simulate(
        0.5, position={"swing": 0.4}, motion={"base": lambda t: (t**3, 3 * t**2, 6 * t)}
    )
    column = found.coordinates.index("swing")
    assert np.any(found.sweep.drive_effort[:, column])
    assert found.effort_residual > 0.0
    assert not np.any(found.drive_effort[:, column])
    driving = scene.replace(drive=["base", "swing"], free=())
    driven = driving.sweep(found.position, found.speed, found.acceleration).drive_effort
    np.testing.assert_allclose(found.drive_effort, driven, atol=1e-10 * np.abs(driven).max())
    table = found.to_dataframe()
    assert not np.any(table["swing.drive_effort"])
    np.testing.assert_array_equal(table["base.drive_effort"], found.drive_effort[:, 1 - column])
    panels = found.plot().axes
    efforts = [panel for panel in panels if panel.get_ylabel().startswith("effort of drives")]
    drawn = [line.get_label() for panel in efforts for line in panel.get_lines()]
    assert "base" in drawn
    assert "swing" not in drawn


def test_a_law_that_jumps_is_not_blamed_on_the_configuration() -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    moving = scene.simulate(0.2, position=1.0, method="DOP853")
    wrong = moving._rows._replace(a=moving._rows.a + 1.0)
    moved = cd.Trajectory(moving._course, moving.time)
    moved.__dict__.update(_rows=wrong, _drives_alone=None, _misfit=0.0)
    with pytest.raises(cd.AccuracyError, match=r"do not belong to what acts.*is not singular"):
        _ = moved.effort_residual
