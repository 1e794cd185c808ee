"""Methods: what suits which scene, that all find one motion, and where each of them ends."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc
from testkit.scenes import universal
from testkit.simulated import ABOUT_PIN, GRAVITY, INERTIA, LENGTH, MASS, WEIGHT, pendulum

import cardan_dyn as cd
from cardan_dyn.motion.simulation.forces import Named

METHODS = ("quadrature", "response", "DOP853")


@pytest.fixture
def scene(joint: cd.Mechanism) -> cd.Scene:
    return universal(joint, 0.6).replace(loads=None, free="bearing_in")


@pytest.mark.parametrize(
    ("changed", "asked", "out"),
    [
        ({}, {}, set()),
        ({"free": ["pin_in"], "drive": "bearing_in"}, {}, {"quadrature", "response"}),
        ({"elements": [cd.JointSpring("pin_in", 0.0, 1.0)]}, {}, {"quadrature"}),
        ({}, {"loads": {"pin_in": lambda time: 0.0}}, {"quadrature"}),
        ({}, {"step": 0.01}, {"quadrature", "Radau"}),
    ],
)
def test_methods_that_would_leave_something_out_are_refused(
    scene: cd.Scene, changed: dict[str, object], asked: dict[str, object], out: set[str]
) -> None:
    if "drive" in changed:
        shaft = cd.load("double_shaft_z")
        held = {"joint_angle_1": 0.2}
        scene = cd.Scene(shaft, drive="bearing_in", free="joint_angle_2", held=held)
        asked = {"motion": {"bearing_in": 1.0}}
    else:
        scene = scene.replace(**changed)
    for method in (*METHODS, "Radau"):
        if method in out:
            with pytest.raises(cd.ArgumentError, match=f"'{method}' does not suit the scene: it"):
                scene.simulate(0.02, method=method, **asked)
        else:
            assert scene.simulate(0.02, method=method, **asked).method.startswith(method)


@pytest.mark.parametrize("method", METHODS)
def test_all_reach_the_same_end(scene: cd.Scene, method: str) -> None:
    reference = scene.simulate(1.5, position=0.2, speed=8.0)
    assert reference.method == "quadrature"
    found = scene.simulate(1.5, position=0.2, speed=8.0, rtol=1e-11, method=method)
    assert found.time[0] == 0.0
    assert found.time[-1] == 1.5
    assert found.position[-1] == pytest.approx(reference.position[-1], abs=1e-8)


@pytest.mark.parametrize("method", METHODS)
def test_events_end_each_of_them(scene: cd.Scene, method: str) -> None:
    event = cd.Event(lambda time, position, speed: position["bearing_in"] - 5.0, True, name="five")
    found = scene.simulate(3.0, speed=8.0, rtol=1e-11, events=event, method=method)
    assert found.reason == "event 'five'"
    assert found.events == (("five", found.time[-1]),)
    assert found.position[-1] == pytest.approx(5.0, abs=1e-9)


def test_a_load_that_fails_ends_with_what_was_computed(scene: cd.Scene) -> None:
    def load(time: float) -> float:
        if time > 0.5:
            raise ZeroDivisionError("as told")
        return 0.0

    for method in METHODS[1:]:
        with pytest.raises(cd.SimulationError, match="ZeroDivisionError: as told") as raised:
            scene.simulate(1.0, speed=8.0, loads={"bearing_out": load}, method=method)
        assert 0.0 < raised.value.time <= 0.5
        assert raised.value.trajectory.time[-1] == raised.value.time


def test_an_interruption_returns_what_was_computed(scene: cd.Scene) -> None:
    def interrupt(done: float) -> None:
        if done > 0.3:
            raise KeyboardInterrupt

    for method in METHODS[1:]:
        found = scene.simulate(1.0, speed=8.0, progress=interrupt, method=method)
        assert found.reason == "interrupted"
        assert 0.3 < found.time[-1] < 1.0


def test_an_interrupted_search_for_events_returns_what_was_searched(scene: cd.Scene) -> None:
    def interrupt(time: float) -> float:
        if time > 0.5:
            raise KeyboardInterrupt
        return time - 0.2

    found = scene.simulate(1.0, speed=8.0, events=interrupt)
    assert found.reason == "interrupted"
    assert 0.4 < found.time[-1] <= 0.5
    assert [event.time for event in found.events] == [pytest.approx(0.2, abs=1e-14)]


def test_a_quadrature_of_few_times_misses_nothing_between_them(
    scene: cd.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a run of so many turns that not all of them are among its times."""
    monkeypatch.setattr("cardan_dyn.motion.simulation.methods.MOST_STATES", 2)

    def half_turn(time: float, position: Named, speed: Named) -> float:
        return math.sin(position["bearing_in"])

    found = scene.simulate(7.3, position=0.1, speed=8.0, loads={"pin_in": 0.5}, events=half_turn)
    assert len(found) == 2
    assert len(found.events) == math.floor(found.position[-1] / math.pi) > 16
    several = found.at([7.3, 0.4, 6.1])
    gained = several.kinetic_energy - found.kinetic_energy[0]
    np.testing.assert_allclose(several.work, gained, atol=1e-12 * found.kinetic_energy[0])
    assert np.all(np.abs(gained) > 1e-6 * found.kinetic_energy[0])


def test_a_swing_from_rest_turns_back_after_the_start() -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    turns = [event.time for event in scene.simulate(2.0, position=1.0, events=of_speed).events]
    swing = scene.simulate(2.0, position=1.0, rtol=1e-13, method="DOP853", events=of_speed)
    np.testing.assert_allclose(turns, [event.time for event in swing.events], atol=1e-11)


@pytest.mark.parametrize("method", [*METHODS, "Radau"])
def test_events_of_many_zeros_are_all_found_by_each_method(method: str) -> None:
    """A pendulum of whose angle sin 90 φ is watched: its zeros are elliptic integrals."""
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    reach, rate = 1.1, np.sqrt(WEIGHT / ABOUT_PIN)
    modulus = np.sin(0.5 * reach) ** 2
    found = scene.simulate(
        1.8,
        position=reach,
        method=method,
        rtol=1e-9 if method == "Radau" else 1e-11,
        events=lambda time, x, v: math.sin(90.0 * x["pin"] + 1.0),
    )
    levels = (np.arange(-40, 41) * math.pi - 1.0) / 90.0
    levels = levels[np.abs(levels) < reach]
    phases = ellipkinc(np.arcsin(np.sin(0.5 * levels) / np.sqrt(modulus)), modulus)
    whole = ellipk(modulus)
    down, up = whole - phases, 3.0 * whole + phases
    times = np.concatenate([down, up, down + 4.0 * whole]) / rate
    expected = np.sort(times[times < 1.8])
    assert len(expected) == len(found.events) > 60
    np.testing.assert_allclose([item.time for item in found.events], expected, atol=1e-6)
    assert found.notes == ()


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_limit_switch_is_found_at_each_passage(method: str) -> None:
    """A pendulum passes its lowest point at T/4 + k T/2, the edges beside it so much earlier."""
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    reach, width, rate = 2.0, 0.02, np.sqrt(WEIGHT / ABOUT_PIN)

    def switch(time: float, x: Named, v: Named) -> float:
        return 1.0 if abs(x["pin"]) < width else -1.0

    modulus = np.sin(0.5 * reach) ** 2
    quarter = ellipk(modulus)
    beside = ellipkinc(np.arcsin(np.sin(0.5 * width) / np.sqrt(modulus)), modulus)
    middles = quarter * (1.0 + 2.0 * np.arange(4))
    expected = np.sort(np.concatenate([middles - beside, middles + beside])) / rate
    event = cd.Event(switch, name="switch")
    end = 8.0 * quarter / rate
    found = scene.simulate(end, position=reach, method=method, rtol=1e-10, events=event)
    np.testing.assert_allclose([item.time for item in found.events], expected, atol=1e-6)
    assert sum("event 'switch' is constant between" in note for note in found.notes) == 1
    stop = cd.Event(switch, terminal=True, name="switch")
    ended = scene.simulate(end, position=reach, method=method, rtol=1e-10, events=stop)
    assert ended.time[-1] == pytest.approx(expected[0], abs=1e-6)
    smooth = cd.Event(lambda time, x, v: abs(x["pin"]) - width, name="smooth")
    found = scene.simulate(end, position=reach, method=method, rtol=1e-10, events=smooth)
    np.testing.assert_allclose([item.time for item in found.events], expected, atol=1e-6)
    assert found.notes == ()


@pytest.mark.slow
def test_an_event_that_is_too_fast_is_told_of() -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    for method in ("quadrature", "response"):
        found = scene.simulate(
            0.01, position=1.0, method=method, events=lambda t: math.sin(1e9 * t * t + 1.0)
        )
        assert sum("changes so fast" in note for note in found.notes) == 1


def test_what_rounding_makes_of_late_times_is_in_the_residual() -> None:
    """Errors are those of the phase of an elliptic function; beyond a limit there is none left."""
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    rate, reach = math.sqrt(WEIGHT / ABOUT_PIN), 1.2
    before = 0.0
    for duration in (1e2, 1e5, 1e8, 1e11):
        swing = scene.simulate(duration, position=reach)
        times = duration * np.array([0.3, 0.7, 1.0])
        with mpmath.workdps(40):
            squared = mpmath.mpf(9.81) * mpmath.mpf(MASS) * mpmath.mpf(LENGTH)
            squared /= mpmath.mpf(INERTIA) + mpmath.mpf(MASS) * mpmath.mpf(LENGTH) ** 2
            m = mpmath.sin(mpmath.mpf(reach) / 2) ** 2
            phases = [mpmath.ellipk(m) + mpmath.sqrt(squared) * mpmath.mpf(t) for t in times]
            sines = [mpmath.ellipfun("sn", u % (4 * mpmath.ellipk(m)), m=m) for u in phases]
            expected = [float(2 * mpmath.asin(mpmath.sqrt(m) * sn)) for sn in sines]
        found = swing.at(times)
        off = float(np.max(np.abs(found.position - expected)))
        assert off <= found.time_residual * 2.0 * reach
        # Of so many periods, what is told is not far above what rounding is seen to do.
        assert found.time_residual < 1e-7 + 300.0 * np.finfo(float).eps * duration * rate
        assert found.time_residual >= before
        assert bool(swing.notes) == (duration > 1e4)
        before = found.time_residual
    for late in (1e12, 1e15, 1e300):
        with pytest.raises(cd.ArgumentError, match="keep no place within a turn or swing"):
            scene.simulate(late, position=reach)
    # However short the way of a swing is, and for as long as anyone likes at rest.
    with pytest.raises(cd.ArgumentError, match="keep no place within a turn or swing") as refused:
        scene.simulate(1e14, position=1e-9)
    # Small swings are harmonic: the speed that is told is ω times the reach, not ω.
    assert f"moves at up to {1e-9 * rate:.3g} rad/s in a swing of 1e-09 rad" in str(refused.value)
    rest = scene.simulate(1e300)
    assert rest.position[-1] == rest.effort_residual == 0.0


def test_a_turn_that_is_fast_or_short_is_late_by_no_more_than_it_lasts() -> None:
    scene = cd.Scene(pendulum(), free="pin", gravity=GRAVITY)
    for duration, speed in ((1e-18, 1e3), (1e-12, 1e20), (1e-280, 5.0), (1e-3, 1e6)):
        moved = scene.simulate(duration, position=0.3, speed=speed)
        assert moved.method == "quadrature"
        assert moved.time_residual < 1e-6
        assert moved.position[-1] == pytest.approx(0.3 + speed * duration, rel=1e-10)


@pytest.mark.parametrize("method", [None, "response", "DOP853", "Radau"])
@pytest.mark.filterwarnings("error")
def test_numbers_near_their_end_warn_of_nothing(method: str | None) -> None:
    """Each of these gives the right motion, or an error in words."""
    heavy, free = (cd.Scene(pendulum(), free="pin", gravity=g) for g in (GRAVITY, (0, 0, 0)))
    for duration in (5e-324, 1e-300):
        with pytest.raises(cd.ArgumentError, match="cannot divide into steps"):
            heavy.simulate(duration, speed=5.0, method=method)
    for scene, duration, speed in ((heavy, 1e-290, 5.0), (free, 1e-160, 5.0), (free, 1.0, 5e-324)):
        moved = scene.simulate(duration, position=0.3, speed=speed, method=method)
        assert moved.position[-1] == pytest.approx(0.3, abs=1e-15)
        assert moved.time_residual < 1e-9
        assert moved.notes == ()
    for speed in (1e-300, 1e-160):
        moved = heavy.simulate(0.3, position=0.3, speed=speed, method=method)
        alike = heavy.simulate(0.3, position=0.3, method=method)
        assert moved.position[-1] == pytest.approx(alike.position[-1], abs=1e-9)
        moved = free.simulate(1.0, position=0.3, speed=speed, method=method)
        assert moved.speed[-1] == pytest.approx(speed, rel=1e-9, abs=1e-290)
        assert moved.notes == ()
    with pytest.raises(cd.CardanError):
        heavy.simulate(1e-9, speed=1e150, method=method)
    with pytest.raises(cd.ArgumentError, match="leave whole turns out"):
        heavy.simulate(1.0, position=1e15, method=method)


def of_speed(time: float, position: Named, speed: Named) -> float:
    return speed["pin"]


def test_steps_from_rest_are_as_fine_as_the_motion_is_slow() -> None:
    """The tolerance of speeds follows from the first acceleration, not from 1 rad/s."""
    scene = cd.Scene(cd.load("four_bar"), free="crank_bearing", gravity=(0.0, -1e-6, 0.0))
    slow = scene.simulate(4000.0, position=1.0, method="DOP853", rtol=1e-9)
    assert slow.energy_residual < 1e-6
    assert np.ptp(slow.position) > 0.1


@pytest.mark.parametrize("method", ["response", "DOP853", "Radau"])
@pytest.mark.parametrize("acts", ["load", "actuator"])
def test_a_pulse_at_rest_is_not_leapt_over(method: str, acts: str) -> None:
    """Without a limit, steps from rest grow tenfold each, far beyond the pulse."""

    def pulse(time: float) -> float:
        return math.sin(math.pi * (time - 5.0) / 0.1) ** 2 if 5.0 < time < 5.1 else 0.0

    scene = cd.Scene(pendulum(), free="pin")
    loads = {"pin": pulse}
    if acts == "actuator":
        scene, loads = scene.replace(elements=[cd.Actuator("pin", pulse)]), {}
    pushed = scene.simulate(8.0, loads=loads, method=method, rtol=1e-8)
    assert pushed.speed[-1] == pytest.approx(0.05 / ABOUT_PIN, rel=1e-6)
    assert pushed.position[-1] == pytest.approx((8.0 - 5.05) * 0.05 / ABOUT_PIN, rel=1e-6)


@pytest.mark.parametrize("method", [None, "response", "DOP853", "Radau"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_efforts_beyond_all_numbers_end_it(method: str | None) -> None:
    scene = cd.Scene(cd.load("four_bar"), free="crank_bearing")
    with pytest.raises(cd.SimulationError, match="ended at 0 s"):
        scene.simulate(1.0, loads={"crank_bearing": lambda time: 1e200}, method=method)
