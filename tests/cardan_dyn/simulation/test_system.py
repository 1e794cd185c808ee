"""System: rates of rows, closed rows, and whole turns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.constrained import closure_error
from testkit.linkages import coupling, four_bar, gears, loop

import cardan_dyn as cd
from cardan_dyn.motion.simulation.constrained_model import ConstrainedModel
from cardan_dyn.motion.simulation.forces import Forces
from cardan_dyn.motion.simulation.prescribed_motion import Uniform
from cardan_dyn.motion.simulation.system import System

GRAVITY = np.array([0.0, -9.81, 0.0])
BALL = """<robot name="ball"><link name="base"/><link name="top"><inertial>
<mass value="2"/><inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0" ixz="0" iyz="0"/></inertial>
</link><joint name="seat" type="spherical"><parent link="base"/><child link="top"/></joint></robot>
"""


def system_of(mechanism: cd.Mechanism, prescribed: tuple[str, ...] = ()) -> System:
    rates = mechanism.coordinates.rates_of(prescribed)
    start = mechanism.coordinates.neutral()
    model = ConstrainedModel(mechanism, rates, GRAVITY, start)
    motions = {name: Uniform(2.0, 0.5) for name in prescribed}
    return System(model, Forces(mechanism, {}, {}, {}), motions, start)


@pytest.fixture
def bars() -> System:
    return system_of(cd.load(four_bar(loop("continuous"))))


def test_accelerations_are_slopes_of_rates_that_stay_closed(bars: System) -> None:
    """Along a row's derivative, closed rows have closed rates."""
    mechanism = bars.model.mechanism
    scene = cd.Scene(mechanism, drive="a", gravity=GRAVITY)
    turn = scene.sweep([0.4], [2.0])
    y = np.concatenate([turn.motion.x[0], turn.motion.v[0]])
    rate = bars.derivative(0.0, y)
    np.testing.assert_array_equal(rate[: bars.size], turn.motion.v[0])
    drive = rate[bars.size :][mechanism.coordinates.named["a"].rate]
    expected = scene.sweep([0.4], [2.0], [drive]).motion.a[0]
    np.testing.assert_allclose(rate[bars.size :], expected, rtol=1e-12)
    step = 1e-5
    drift = bars.restored(0.0, y + step * rate) - (y + step * rate)
    assert np.max(np.abs(drift)) < 100.0 * step**2


def test_rows_far_from_closed_are_refused(bars: System) -> None:
    y = np.zeros(2 * bars.size)
    y[1] = 0.5
    with pytest.raises(cd.SingularConfigurationError, match="at time 3 s the loops opened"):
        bars.restored(3.0, y)


def test_turns_are_taken_off_and_counted(bars: System) -> None:
    y = np.zeros(2 * bars.size)
    names = bars.model.mechanism.coordinates.named
    for name, angle in (("a", 7.0), ("b", -13.0), ("d", 1.0)):
        y[names[name].column] = angle
    wrapped = bars.wrap(y)
    turns = [bars.turns[names[name].column] for name in "abd"]
    assert turns == [1.0, -2.0, 0.0]
    position, speed = bars.named(wrapped, bars.turns)
    for name in "abd":
        assert position[name] == pytest.approx(y[names[name].column], abs=1e-14)
        assert speed[name] == 0.0
    assert bars.wrap(wrapped) is wrapped


def test_turns_of_geared_joints_stay() -> None:
    system = system_of(cd.load(gears(coupling("m", "a", "b", -0.5))))
    y = np.array([20.0, -10.0, 1.0, -0.5])
    assert system.wrap(y) is y
    np.testing.assert_allclose(system.restored(0.0, y), y, rtol=1e-15)


def test_what_is_prescribed_is_where_it_should_be(joint: cd.Mechanism) -> None:
    system = system_of(joint, ("joint_angle",))
    named = joint.coordinates.named["joint_angle"]
    turn = cd.Scene(joint, drive=["bearing_in", "joint_angle"]).sweep([[1.0, 0.9]], [[3.0, 2.0]])
    y = np.concatenate([turn.motion.x[0], turn.motion.v[0]])
    y[named.column] += 1e-6
    restored = system.restored(0.2, y)
    assert restored[named.column] == pytest.approx(0.9, abs=1e-15)
    assert restored[system.size + named.rate] == pytest.approx(2.0, abs=1e-14)
    assert closure_error(joint, restored[: system.size]) < 2e-15


def test_balls_turn_by_their_spin() -> None:
    system = system_of(cd.load(BALL))
    orientation = Rotation.from_rotvec([0.3, -0.5, 0.2])
    spin = np.array([1.0, 2.0, -0.7])
    y = np.concatenate([orientation.as_quat(), spin])
    rate = system.derivative(0.0, y)
    step = 1e-5
    after, before = (
        (orientation * Rotation.from_rotvec(sign * step * spin)).as_quat() for sign in (1, -1)
    )
    np.testing.assert_allclose(rate[:4], (after - before) / (2.0 * step), atol=1e-10)
    inertia = np.array([0.1, 0.2, 0.25])
    np.testing.assert_allclose(rate[4:], -np.cross(spin, inertia * spin) / inertia, rtol=1e-13)
    long = y.copy()
    long[:4] *= 1.0 + 1e-6
    assert np.linalg.norm(system.restored(0.0, long)[:4]) == pytest.approx(1.0, abs=1e-15)
