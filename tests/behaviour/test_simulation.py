"""Simulations: exact where a closed form is known, closed and conservative for as long as they run.

Tolerances are those of the method: rounding, or the relative tolerance times the steps.
"""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from testkit.constrained import closure_error
from testkit.simulated import (
    ABOUT_PIN,
    GRAVITY,
    WEIGHT,
    SpinningJoint,
    integrated,
    parallelogram_law,
    parallelograms,
    pendulum,
    spatial_slider_crank,
)

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

SPEED = 10.0
METHODS = ("quadrature", "response", "DOP853", "Radau")


def free(joint: cd.Mechanism, degrees: float) -> cd.Scene:
    return cd.Scene(joint, free="bearing_in", held={"joint_angle": np.deg2rad(degrees)})


@pytest.mark.parametrize("degrees", [30.0, 80.0])
@pytest.mark.parametrize(
    ("method", "rtol", "allowed"), [(None, 1e-10, 1e-13), ("DOP853", 1e-13, 2e-12)]
)
def test_ten_turns_take_the_time_of_the_energy_integral(
    joint: cd.Mechanism, degrees: float, method: str | None, rtol: float, allowed: float
) -> None:
    end = SpinningJoint(np.deg2rad(degrees)).time_of(SPEED, 10.0)
    turned = free(joint, degrees).simulate(end, speed=SPEED, method=method, rtol=rtol)
    assert abs(turned.position[-1] / (20.0 * np.pi) - 1.0) < allowed
    # It comes back to the position at which it began, and so to its speed.
    assert abs(turned.speed[-1] / SPEED - 1.0) < 10.0 * allowed


def test_fixed_steps_converge_with_order_eight(joint: cd.Mechanism) -> None:
    scene = free(joint, 30.0)
    end = SpinningJoint(np.deg2rad(30.0)).time_of(SPEED, 2.0)
    counts = np.array([16, 24, 32, 48, 64, 96])
    errors = []
    for count in counts.tolist():
        found = scene.simulate(end, speed=SPEED, step=end / count).position[-1]
        errors.append(abs(found - 4.0 * np.pi))
    within = (np.array(errors) > 1e-12) & (np.array(errors) < 1e-4)
    assert np.count_nonzero(within) >= 3
    slope = np.polyfit(np.log(counts[within]), np.log(np.array(errors)[within]), 1)[0]
    assert -slope >= 7.5


@pytest.mark.slow
@pytest.mark.parametrize("degrees", [30.0, 80.0])
def test_loops_stay_closed_over_a_hundred_turns(joint: cd.Mechanism, degrees: float) -> None:
    scene = free(joint, degrees)
    end = SpinningJoint(np.deg2rad(degrees)).time_of(SPEED, 100.0)
    turned = scene.simulate(end, speed=SPEED, method="DOP853", rtol=1e-9)
    rows = turned._rows
    assert max(closure_error(joint, x) for x in rows.x) < 1e-13
    times = np.random.default_rng(0).uniform(0.0, end, 200)
    some = turned.at(times)
    assert max(closure_error(joint, x) for x in some._rows.x) < 1e-13
    # A sweep counts the turns of its drive, whose rounding it cannot tell from a position.
    rounding = np.finfo(float).eps * 200.0 * np.pi * float(np.max(some.condition))
    assert some.loop_residual < rounding
    column = joint.coordinates.named["joint_angle"].column
    np.testing.assert_allclose(some._rows.x[:, column], np.deg2rad(degrees), atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("method", [None, "DOP853"])
@pytest.mark.parametrize("name", ["four_bar", "spatial"])
def test_energy_is_kept_for_tens_of_turns(name: str, method: str | None) -> None:
    if name == "spatial":
        scene = cd.Scene(spatial_slider_crank(), free="a", gravity=GRAVITY)
    else:
        scene = cd.Scene(cd.load(name), free="crank_bearing", gravity=GRAVITY)
    turned = scene.simulate(20.0, speed=15.0, method=method, rtol=1e-12)
    assert abs(turned.position[-1]) > 40.0 * np.pi
    assert turned.energy_residual <= 1e-10


@pytest.mark.slow
def test_energy_of_a_platform_on_springs() -> None:
    legs = [f"leg_{k}" for k in range(1, 7)]
    springs = [cd.JointSpring(leg, 2e5 * (1.0 + 0.1 * k)) for k, leg in enumerate(legs)]
    platform = cd.load("stewart_platform")
    scene = cd.Scene(platform, free=legs, gravity=(0.0, 0.0, -9.81), elements=springs)
    rest = scene.equilibrium()
    assert rest.stability == "stable"
    slowest = 2.0 * np.pi / rest.frequencies[0]
    begin = rest.position + 0.01 * np.array([1.0, -1.0, 2.0, 0.0, 1.0, -2.0])
    swung = scene.simulate(3.0 * slowest, position=begin, rtol=1e-12)
    assert 3.0 * slowest * rest.frequencies[-1] > 10.0 * 2.0 * np.pi * 0.3
    assert swung.energy_residual <= 1e-10
    some = swung.evenly(20)
    assert some.effort_residual < 1e-12
    assert some.loop_residual < 1e-13


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_wrenches_are_those_of_the_sweep_along_the_motion(joint: cd.Mechanism, method: str) -> None:
    loads = {"bearing_out": 2.0, "shaft_out": cd.Wrench((1.0, 2.0, 3.0), (0.1, 0.0, 0.2), "world")}
    if method == "quadrature":
        loads = {"shaft_out": cd.Wrench((1.0, 2.0, 3.0), frame="link")}
    scene = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.8}, gravity=(0.0, 0.0, -9.81)
    )
    some = (
        scene.replace(free=scene.drives)
        .simulate(0.5, speed=20.0, loads=loads, method=method, rtol=1e-9)
        .evenly(15)
    )
    assert some.effort_residual < 1e-12
    assert some.balance_residual < 1e-12
    turn = scene.sweep(some.position, some.speed, some.acceleration, loads=loads)
    for name in scene.outputs:
        for part in ("force", "moment"):
            found, expected = getattr(some[name], part), getattr(turn[name], part)
            np.testing.assert_allclose(found, expected, atol=1e-9 * np.max(np.abs(expected)))
    # The load comes out as the torsion of its joint.
    if "bearing_out" in loads:
        np.testing.assert_allclose(some["bearing_out"].torsion, 2.0, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("rtol", [1e-11, 1e-12])
def test_a_parallelogram_passes_its_flat_positions(rtol: float) -> None:
    """There the crank decides neither coupler nor rocker, but their inertia does."""
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY)
    inertia, weight = parallelogram_law(1)
    turned = scene.simulate(5.0, position=0.3, speed=12.0, rtol=rtol)
    assert turned.position[-1] > 20.0 * np.pi
    assert turned.energy_residual < 1e-9
    times = np.linspace(0.0, 5.0, 50)
    expected = integrated(lambda t, x, v: weight * np.sin(x) / inertia, 0.3, 12.0, times)
    # Twenty passages, at each of which errors grow by the inverse of the distance of the steps.
    np.testing.assert_allclose(turned.at(times).position, expected[0], atol=1e4 * rtol)
    first, second = (
        turned._rows.x[:, scene.mechanism.coordinates.named[name].column]
        for name in ("pin_0", "pin_1")
    )
    apart = np.mod(first - second + np.pi, 2.0 * np.pi) - np.pi
    assert np.max(np.abs(apart)) < 1e-6


def test_a_flat_position_is_refused_as_start_and_for_wrenches() -> None:
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY)
    with pytest.raises(cd.SingularConfigurationError):
        scene.simulate(1.0, position=0.5 * np.pi, speed=1.0)
    flat = cd.Event(lambda t, p, s: p["pin_0"] - 2.5 * np.pi, terminal=True)
    ended = scene.simulate(4.0, position=0.3, speed=12.0, rtol=1e-12, events=flat)
    there = ended.at(ended.time[-1])
    assert there.position[0] == pytest.approx(2.5 * np.pi, abs=1e-9)
    assert there.energy_residual < 1e-9
    assert there.motion.position("pin_1")[0] == pytest.approx(2.5 * np.pi, abs=1e-9)
    for name in ("acceleration", "drive_effort"):
        with pytest.raises((cd.AccuracyError, cd.SingularConfigurationError)):
            getattr(there, name)


@pytest.mark.parametrize("later", [0.0, 1e-13, 1e-9, -1e-9])
def test_one_flat_position_does_not_refuse_all_times(later: float) -> None:
    """The cranks stay parallel, and the couplers keep their direction."""
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY)
    flat = cd.Event(lambda t, p, s: p["pin_0"] - 2.5 * np.pi)
    moved = scene.simulate(2.0, position=0.3, speed=12.0, rtol=1e-12, events=flat)
    times = np.array([0.01, moved.events[0].time + later, 1.0])
    found, others = moved.at(times), moved.at(times[[0, 2]])
    assert found.singular.tolist() == [False, True, False]
    assert not np.any(others.singular)
    for name, sign in (("pin_1", 1.0), ("knee_0", -1.0)):
        np.testing.assert_allclose(found.motion.position(name), sign * found.position, atol=1e-8)
        np.testing.assert_allclose(found.motion.velocity(name), sign * found.speed, atol=1e-6)
    swept = found.sweep.drive_effort
    for values in (found.acceleration, swept, found["knee_0"].force[:, 0]):
        np.testing.assert_array_equal(np.isnan(values), found.singular)
    assert not np.any(found.drive_effort)
    np.testing.assert_allclose(found["knee_0"].force[[0, 2]], others["knee_0"].force, rtol=1e-9)
    assert found.condition[1] == np.inf
    # Alone, it is refused for what it is: its loops are closed.
    alone = moved.at(times[1])
    assert alone.singular.tolist() == [True] and alone.energy_residual < 1e-9
    with pytest.raises((cd.AccuracyError, cd.SingularConfigurationError), match="singular"):
        _ = alone.sweep
    assert found.energy_residual < 1e-9
    assert found.effort_residual < 1e-6
    assert len(found.to_dataframe()) == 3


@pytest.mark.slow
@pytest.mark.parametrize(("begin", "rtol"), [(0.4, 1e-11), (0.4, 1e-12), (0.43, 1e-10)])
def test_a_chain_of_parallelograms(begin: float, rtol: float) -> None:
    """It swings through positions in which all bars are in line, wherever steps fall."""
    scene = cd.Scene(parallelograms(12), free="pin_0", gravity=GRAVITY)
    inertia, weight = parallelogram_law(12)
    moved = scene.simulate(2.0, position=begin, rtol=rtol)
    times = np.linspace(0.0, 2.0, 20)
    expected = integrated(lambda t, x, v: weight * np.sin(x) / inertia, begin, 0.0, times)
    np.testing.assert_allclose(moved.at(times).position, expected[0], atol=30.0 * rtol)
    assert moved.energy_residual < 10.0 * rtol
    assert not moved.notes


def test_positions_are_read_wherever_assembly_modes_meet() -> None:
    scene = cd.Scene(parallelograms(1), free="pin_0", gravity=GRAVITY)
    inertia, weight = parallelogram_law(1)
    moved = scene.simulate(0.3, position=0.3, speed=12.0)
    law = integrated(lambda t, x, v: weight * np.sin(x) / inertia, 0.3, 12.0, np.array([0.0, 0.3]))
    assert law[0][-1] > 0.5 * np.pi
    flat = cd.Event(lambda t, p, s: p["pin_0"] - 0.5 * np.pi)
    time = scene.simulate(0.3, position=0.3, speed=12.0, events=flat).events[0][1]
    near = moved.at(time + np.array([-1e-4, -1e-6, -1e-8, 0.0, 1e-8, 1e-6, 1e-4]))
    columns = [scene.mechanism.coordinates.named[name].column for name in ("pin_0", "pin_1")]
    first, second = near._rows.x[:, columns].T
    np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-8)


def test_energy_far_off_is_told() -> None:
    """Whatever the cause: here motion under another gravity than the one that is weighed."""
    scene, other = (
        cd.Scene(parallelograms(1), free="pin_0", gravity=factor * np.array(GRAVITY))
        for factor in (1.0, 1.001)
    )
    moved, heavier = (item.simulate(0.2, position=0.3, speed=1.0) for item in (scene, other))
    assert not moved.notes
    told = type(moved)(replace(heavier._course, setup=moved._course.setup), heavier.time)
    assert told.energy_residual > 1e-6
    assert any(note.startswith("inaccurate") for note in told.notes)


@pytest.mark.parametrize("away", [1e-2, 1e-3, 1e-4, 1e-6])
def test_a_pendulum_released_beside_its_upright_position(away: float) -> None:
    """By elliptic functions of 40 digits, from exactly this start; monotone between its ends."""
    start = np.pi - away
    found = cd.Scene(pendulum(), free="pin", gravity=GRAVITY).simulate(10.0, position=start)
    found = found.at(np.linspace(0.0, 10.0, 101))
    with mpmath.workdps(40):
        root = mpmath.sin(mpmath.mpf(start) / 2)
        rate = mpmath.sqrt(mpmath.mpf(WEIGHT) / mpmath.mpf(ABOUT_PIN))
        expected = [
            float(2 * mpmath.asin(root * mpmath.ellipfun("cd", rate * mpmath.mpf(t), m=root**2)))
            for t in found.time.tolist()
        ]
    assert found.method == "quadrature"
    # The upright position itself is known to some 1e-16 rad.
    np.testing.assert_allclose(found.position, expected, atol=1e-12 + 1e-14 / away)
    half = found.time < 0.5 * found._run.period
    assert np.all(np.diff(found.position[half]) <= 0.0)
    if away < 1e-4:
        assert any("unstable equilibrium" in note for note in found.notes)


@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
@pytest.mark.parametrize("start", [4.0, -7.0, 40.0])
def test_starts_beyond_half_a_turn_count_their_turns(start: float, method: str) -> None:
    times = np.linspace(0.0, 2.0, 9)
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    found = scene.simulate(2.0, position=start, speed=1.0, method=method).at(times)
    law = integrated(lambda t, x, v: -WEIGHT * np.sin(x) / ABOUT_PIN, start, 1.0, times)
    np.testing.assert_allclose(found.position, law[0], atol=1e-5)
    np.testing.assert_allclose(found.speed, law[1], atol=1e-5)


@pytest.mark.parametrize("method", ["response", "DOP853"])
def test_steps_that_linger_upright_are_noted(method: str) -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    upright = scene.simulate(8.0, position=np.pi - 1e-4, method=method)
    assert any("unstable equilibrium" in note for note in upright.notes)
    # Until it has left, and where it never came near.
    assert scene.simulate(8.0, position=2.0, method=method).notes == ()
    slowed = [cd.JointSpring("pin", 0.0, damping=3.0)]
    resting = cd.Scene(pendulum(), free="pin", gravity=GRAVITY, elements=slowed)
    assert resting.simulate(20.0, position=2.0, method=method).notes == ()
    # Where errors do not grow, nothing lingers: at constant speed, or with wide tolerances.
    level = cd.Scene(pendulum(), free="pin", gravity=(0.0, 0.0, 0.0))
    assert level.simulate(2.0, speed=7.0, method=method).notes == ()
    assert scene.simulate(2.0, position=1.0, method=method, rtol=1e-5).notes == ()


def cranks_of_one_length(last: str) -> cd.Mechanism:
    """Base and coupler are of another: in line they can go on in two ways."""
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="{x} 0 0"/><mass value="1"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, x in (("a", 0.05), ("b", 0.1))
    )
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x} 0 0"/><axis xyz="0 0 1"/></joint>'
        for name, parent, child, x in (
            ("A", "f", "a", 0.0), ("B", "a", "b", 0.1), ("D", "f", "c", 0.3)
        )
    )  # fmt: skip
    loop = (
        '<loop name="C" type="continuous"><predecessor link="b"><origin xyz="0.3 0 0"/>'
        '</predecessor><successor link="c"><origin xyz="0.1 0 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>'
    )
    return cd.load(f'<robot name="p"><link name="f"/>{links}{last}{joints}{loop}</robot>')


def test_a_motion_that_rounding_decides_is_no_result() -> None:
    """A parallelogram keeps its speed, so that a step ends where all are in line."""
    turning = {"A": np.pi / 2, "B": -np.pi / 2, "D": np.pi / 2}
    scene = cd.Scene(cranks_of_one_length('<link name="c"/>'), free="A", near=turning)
    begin = {"position": np.pi / 2, "speed": np.pi / 0.3, "method": "DOP853"}
    past = scene.simulate(0.3, **begin)
    assert past.position[-1] == pytest.approx(1.5 * np.pi, abs=1e-12)
    assert past.energy_residual < 1e-12
    assert scene.simulate(0.14, step=0.01, **begin).energy_residual < 1e-12
    with pytest.raises(cd.SingularConfigurationError, match="rounding decides all of its speeds"):
        scene.simulate(0.3, step=0.01, **begin)


@pytest.mark.slow
def test_links_without_mass_pass_where_links_are_in_line_as_light_ones_do() -> None:
    light = (
        '<link name="c"><inertial><mass value="1e-6"/><inertia ixx="1e-9" iyy="1e-9" izz="1e-9" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    ends = []
    for last in ('<link name="c"/>', light):
        scene = cd.Scene(cranks_of_one_length(last), free="A", near={"A": np.pi / 2})
        passed = scene.simulate(0.3, position=np.pi / 2, speed=10.471975512)
        assert passed.energy_residual < 1e-8
        ends.append(passed.position[-1])
    assert ends[0] == pytest.approx(ends[1], abs=1e-7)
