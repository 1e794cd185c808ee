"""Thrusts between points by any law, against statics and motions by hand and linear springs."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn import vibration
from cardan_dyn.core.elements.law import Law
from cardan_dyn.core.elements.point_spring import PointForce

pytestmark = pytest.mark.usefixtures("loaded_once")

ENDS = ("crank", (0.05, 0.02, 0.0), "rocker", (0.1, 0.1, 0.0))
TURN = np.linspace(0.0, 2.0 * np.pi, 30)
SPRING = cd.PointSpring(*ENDS, 500.0, length=0.2)
LINE = np.array([[0.01, 95.0], [0.15, 25.0], [0.9, -350.0]])
"""The same as a table: its thrust is 500 (0.2 - length)."""

SLIDE = """<robot name="slide"><link name="floor"/><link name="block"><inertial><mass value="{}"/>
  <inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="lift" type="prismatic">
  <parent link="floor"/><child link="block"/><axis xyz="0 0 1"/>
  <limit effort="1" velocity="1" lower="0" upper="9"/></joint></robot>"""


def four_bar(*elements: object, **options: object) -> cd.Scene:
    return cd.Scene(cd.load("four_bar"), drive="crank_bearing", elements=list(elements), **options)


def lift(mass: float, *elements: object) -> cd.Scene:
    return cd.Scene(
        cd.load(SLIDE.format(mass)), free="lift", elements=list(elements), gravity=(0, 0, -9.81)
    )


def between(thrust: object, of: object = "time") -> cd.PointActuator:
    return cd.PointActuator("floor", (0, 0, 0), "block", (0, 0, 0), thrust, of=of)


@pytest.mark.parametrize(
    ("thrust", "of"),
    [
        (LINE, "length"),
        (lambda length: 500.0 * (0.2 - length), "length"),
        (lambda rate, length: 500.0 * (0.2 - length) + 0.0 * rate, ["rate", "length"]),
        (lambda length: 500.0 * (0.2 - float(length)), "length"),
    ],
    ids=["table", "function", "of two", "of numbers"],
)
def test_the_law_of_a_linear_spring_is_that_spring(thrust: object, of: object) -> None:
    scene, plain = four_bar(cd.PointActuator(*ENDS, thrust, of=of)), four_bar(SPRING)
    turn, expected = (item.sweep(TURN, speed=3.0, acceleration=2.0) for item in (scene, plain))
    assert relative(turn.drive_effort, expected.drive_effort) < 1e-13
    for name in turn:
        assert relative(turn[name].force, expected[name].force) < 1e-13
    one, other = turn.element_force[0], expected.element_force[0]
    for field in ("tension", "length", "force"):
        np.testing.assert_allclose(getattr(one, field), getattr(other, field), atol=1e-11)
    energy = other.energy if thrust is LINE else 0.0 * other.energy
    np.testing.assert_allclose(one.energy, energy, atol=1e-12)
    assert turn.power_residual < 1e-13


def test_a_law_of_length_and_rate_is_a_spring_and_a_damper() -> None:
    def thrust(length: float, rate: float) -> float:
        return 500.0 * (0.2 - length) - 30.0 * rate

    damped = cd.PointSpring(*ENDS, 500.0, 30.0, 0.2)
    given = cd.PointActuator(*ENDS, thrust, of=("length", "rate"))
    one, other = (four_bar(item).sweep(TURN, speed=3.0) for item in (given, damped))
    assert relative(one.drive_effort, other.drive_effort) < 1e-13
    resisting = cd.PointActuator(*ENDS, [[-5.0, 150.0], [5.0, -150.0]], of="rate")
    one = four_bar(SPRING, resisting).sweep(TURN, speed=3.0)
    assert relative(one.drive_effort, other.drive_effort) < 1e-13
    heat = other.element_force[0].dissipation
    np.testing.assert_allclose(one.element_force[1].dissipation, heat, atol=1e-11)


def sheet(law: Callable[[float, float], float], first: object, second: object) -> np.ndarray:
    """A table of two things as a sheet shows it."""
    table = np.zeros((np.size(first) + 1, np.size(second) + 1))
    table[1:, 0], table[0, 1:] = first, second
    table[1:, 1:] = [[law(x, y) for y in np.ravel(second)] for x in np.ravel(first)]
    return table


def test_a_table_of_length_and_rate_is_the_law_it_was_made_of() -> None:
    """Lengths times rates lie on it between its places, too."""

    def thrust(length: float, rate: float) -> float:
        return 500.0 * (0.2 - length) - 30.0 * rate - 70.0 * length * rate

    table = sheet(thrust, [0.01, 0.15, 0.9], [-9.0, -1.0, 0.5, 9.0])
    laws = (thrust, ("length", "rate")), (table, ("length", "rate")), (table.T, ("rate", "length"))
    plain, *tables = (
        four_bar(cd.PointActuator(*ENDS, law, of=of)).sweep(TURN, speed=3.0) for law, of in laws
    )
    for turn in tables:
        assert relative(turn.drive_effort, plain.drive_effort) < 1e-13
        assert turn.element_force[0].energy.max() == turn.element_force[0].dissipation.max() == 0.0
        assert turn.power_residual < 1e-13


def test_a_table_of_two_is_bilinear_between_its_places() -> None:
    rng = np.random.default_rng(5)
    first, second = np.cumsum(rng.uniform(0.1, 1.0, (2, 6)), axis=1)
    table = sheet(lambda *_: rng.normal(), first, second[:4])
    law = Law.checked("Actuator: effort", table, ("time", "position"), ("time", "position"))
    at = rng.uniform(first[0], first[-1], 50), rng.uniform(second[0], second[3], 50)
    expected = RegularGridInterpolator((first, second[:4]), table[1:, 1:])(np.stack(at, axis=1))
    found = law.at("effort", time=at[0], position=at[1])
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14)
    one = law.at_one("effort", time=at[0][3], position=at[1][3])
    assert one == found[3]


def test_a_block_falls_through_a_table_of_height_and_speed() -> None:
    """A drag of 3 N·s/m that grows by 2 N·s/m² with the height."""
    table = sheet(lambda z, v: -(3.0 + 2.0 * z) * v, [0.0, 4.0], [-20.0, 20.0])
    turn = lift(2.0, between(table, ("length", "rate"))).simulate(0.5, position=3.0)
    fall = solve_ivp(
        lambda _, y: (y[1], -9.81 - (3.0 + 2.0 * y[0]) * y[1] / 2.0),
        *((0.0, 0.5), (3.0, 0.0)),
        rtol=1e-12,
        atol=1e-13,
    )
    assert turn.motion.position("lift")[-1] == pytest.approx(fall.y[0, -1], rel=1e-8)


def test_the_thrust_of_a_cylinder_at_a_slider_crank() -> None:
    """Virtual work: M dφ + F ds = 0, where s is the way of the slider."""
    crank, rod, thrust = 0.1, 0.35, 1500.0
    text = f"""<robot name="press"><link name="bed"/><link name="crank"/><link name="rod"/>
    <link name="ram"/><joint name="shaft" type="continuous"><parent link="bed"/>
    <child link="crank"/><axis xyz="0 0 1"/></joint><joint name="pin" type="continuous">
    <parent link="crank"/><child link="rod"/><origin xyz="{crank} 0 0"/><axis xyz="0 0 1"/></joint>
    <joint name="guide" type="prismatic"><parent link="bed"/><child link="ram"/>
    <origin xyz="{crank + rod} 0 0"/><axis xyz="1 0 0"/>
    <limit effort="1" velocity="1" lower="0" upper="9"/></joint></robot>"""
    press = cd.close(cd.load(text), "rod", "ram", "continuous", at=(rod, 0, 0), axis=(0, 0, 1))
    cylinder = cd.PointActuator("bed", (0.9, 0.0, 0.0), "ram", (0.05, 0.0, 0.0), thrust)
    angle = np.linspace(0.1, 6.0, 25)
    turn = cd.Scene(press, drive="shaft", elements=[cylinder]).sweep(angle, speed=4.0)
    across = np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)
    slide = -crank * np.sin(angle) * (1.0 + crank * np.cos(angle) / across)
    # It stands before the ram and pushes it back.
    np.testing.assert_allclose(turn.drive_effort, thrust * slide, rtol=1e-11)
    np.testing.assert_allclose(
        turn.element_force[0].length, 0.9 - 0.05 - crank * np.cos(angle) - across, rtol=1e-12
    )
    assert turn.power_residual < 1e-13


HALF, FOOT, LOAD = 0.4, 0.25, 30.0
SCISSORS = f"""<robot name="scissors"><link name="base"/><link name="one"><inertial>
  <origin xyz="{2 * HALF} 0 0"/><mass value="{LOAD}"/>
  <inertia ixx="1e-9" iyy="1e-9" izz="1e-9"/></inertial></link><link name="two"/>
  <link name="shoe"/><joint name="foot" type="continuous"><parent link="base"/><child link="one"/>
  <origin rpy="0 -0.5 0"/><axis xyz="0 -1 0"/></joint>
  <joint name="middle" type="continuous"><parent link="one"/><child link="two"/>
  <origin xyz="{HALF} 0 0" rpy="0 1 0"/><axis xyz="0 1 0"/></joint>
  <joint name="roller" type="prismatic"><parent link="base"/><child link="shoe"/>
  <origin xyz="{2 * HALF * math.cos(0.5)!r} 0 0"/><axis xyz="1 0 0"/>
  <limit effort="1" velocity="1" lower="0" upper="9"/></joint></robot>"""


def gas(length: object) -> object:
    """A gas spring: 1.2 times its thrust at 0.5 m where it is pressed by 0.2 m, polytropic."""
    return 1900.0 * (1.0 + (0.5 - np.asarray(length)) * (1.0 - 1.2 ** (-1 / 1.3)) / 0.2) ** -1.3


def test_a_scissor_lift_on_a_gas_spring() -> None:
    """Virtual work of a load on the upper end, and of a spring from a foot to the other arm."""
    mechanism = cd.close(
        cd.load(SCISSORS), "two", "shoe", "continuous", at=(HALF, 0, 0), axis=(0, 1, 0)
    )
    gas_spring = cd.PointActuator(
        "base", (0, 0, 0), "two", (HALF - FOOT, 0, 0), gas, of="length", name="gas"
    )
    scene = cd.Scene(mechanism, drive="foot", elements=[gas_spring], gravity=(0, 0, -9.81))
    turned = np.linspace(-0.3, 0.6, 10)
    turn, angle = scene.sweep(turned), turned + 0.5
    length = np.hypot((2 * HALF - FOOT) * np.cos(angle), FOOT * np.sin(angle))
    slope = (FOOT**2 - (2 * HALF - FOOT) ** 2) * np.sin(angle) * np.cos(angle) / length
    weight = LOAD * 9.81 * 2 * HALF * np.cos(angle)
    np.testing.assert_allclose(turn.element_force["gas"].length, length, rtol=1e-12)
    np.testing.assert_allclose(turn.drive_effort, weight - gas(length) * slope, rtol=1e-10)

    free = scene.replace(drive=None, free="foot", elements=[_opposed(gas_spring)])
    rest = free.equilibrium(position=0.2)
    at = rest.position[0] + 0.5
    length = np.hypot((2 * HALF - FOOT) * np.cos(at), FOOT * np.sin(at))
    slope = (FOOT**2 - (2 * HALF - FOOT) ** 2) * np.sin(at) * np.cos(at) / length
    assert -gas(length) * slope == pytest.approx(LOAD * 9.81 * 2 * HALF * np.cos(at), rel=1e-9)


def _opposed(spring: cd.PointActuator) -> cd.PointActuator:
    """Return one that pulls, which lifts."""
    return cd.PointActuator(
        spring.link_a, spring.point_a, spring.link_b, spring.point_b, lambda x: -gas(x), of="length"
    )


@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_a_block_falls_on_a_bump_stop_and_comes_back(method: str) -> None:
    """Free fall, half a swing on the stop, and the way up; all by hand."""
    mass, stiffness, contact, height = 2.0, 8000.0, 0.1, 0.3
    stop = [[0.0, stiffness * contact], [contact, 0.0], [2.0, 0.0]]
    fall, pace = math.sqrt(2 * height / 9.81), math.sqrt(stiffness / mass)
    touch = 2.0 * (math.pi - math.atan(9.81 * fall * pace / 9.81)) / pace
    run = lift(mass, between(stop, "length")).simulate(
        2.0 * fall + touch, position=contact + height, method=method, rtol=1e-9
    )
    assert run.motion.position("lift")[-1] == pytest.approx(contact + height, abs=1e-7)
    assert run.motion.velocity("lift")[-1] == pytest.approx(0.0, abs=1e-5)
    deepest = 9.81 / pace**2 + math.hypot(9.81 / pace**2, 9.81 * fall / pace)
    assert run.energy_residual < 1e-8
    at = run.at(fall + 0.5 * touch)
    assert contact - at.motion.position("lift")[0] == pytest.approx(deepest, rel=1e-6)
    assert at.elastic_energy[0] == pytest.approx(0.5 * stiffness * deepest**2, rel=1e-6)


def test_a_damper_of_two_rates() -> None:
    """Without weight, the speed falls exponentially, by another rate in either sense."""
    table = [[-9.0, 9.0 * 14.0], [0.0, 0.0], [9.0, -9.0 * 5.0]]
    scene = lift(2.0, between(table, "rate")).replace(gravity=(0, 0, 0))
    for speed, damping in ((4.0, 5.0), (-4.0, 14.0)):
        run = scene.simulate(0.7, position=5.0, speed=speed)
        expected = speed * np.exp(-damping * run.time / 2.0)
        np.testing.assert_allclose(run.motion.velocity("lift"), expected, atol=1e-8)
        heat = run.element_force[0].dissipation
        np.testing.assert_allclose(heat, damping * expected**2, atol=1e-6)


def test_a_thrust_over_time_lifts() -> None:
    run = lift(2.0, between(lambda t: 2.0 * 9.81 + 12.0 * t)).simulate(1.0, position=1.0)
    np.testing.assert_allclose(run.motion.position("lift"), 1.0 + run.time**3, rtol=1e-9)
    over = lift(2.0, between([[0.0, 2.0 * 9.81], [3.0, 2.0 * 9.81 + 36.0]])).simulate(
        1.0, position=1.0
    )
    assert over.motion.position("lift")[-1] == pytest.approx(2.0, rel=1e-9)


def test_the_stiffness_of_a_progressive_spring() -> None:
    """An equilibrium of a thrust c / length: its stiffness is c / length²."""
    rest = lift(2.0, between(lambda length: 40.0 / length, "length")).equilibrium(position=1.0)
    length = 40.0 / (2.0 * 9.81)
    assert rest.position[0] == pytest.approx(length, rel=1e-10)
    assert rest.stiffness[0, 0] == pytest.approx(40.0 / length**2, rel=1e-9)
    assert rest.frequencies[0] == pytest.approx(math.sqrt(20.0) / length, rel=1e-9)
    assert rest.stability == "stable"


@pytest.mark.parametrize("off", [-3e-4, -2e-8, 2e-8, 3e-4])
def test_the_stiffness_beside_a_row_is_that_of_its_side(off: float) -> None:
    """A row at the weight, shifted: its force is met on the stiff side, or on the soft one."""
    weight, stiff, soft = 2.0 * 9.81, 8000.0, 20.0
    slope = stiff if off < 0.0 else soft
    row = weight + slope * off
    table = [[0.0, row + 0.1 * stiff], [0.1, row], [0.6, row - 0.5 * soft]]
    for start in (0.05, 0.3):
        rest = lift(2.0, between(table, "length")).equilibrium(position=start)
        assert rest.position[0] == pytest.approx(0.1 + off, abs=1e-12)
        assert rest.stiffness[0, 0] == pytest.approx(slope, rel=1e-5)


def test_an_equilibrium_in_a_row_has_no_stiffness() -> None:
    table = [[0.0, 800.0], [0.1, 2.0 * 9.81], [2.0, 0.0]]
    with pytest.raises(cd.EquilibriumError, match="at a kink of a force") as found:
        lift(2.0, between(table, "length")).equilibrium(position=0.05)
    assert found.value.details["position"] == pytest.approx([0.1], abs=1e-12)


@pytest.mark.slow
def test_an_equilibrium_beyond_a_table_says_so() -> None:
    table = [[0.0, 800.0], [0.1, 30.0]]
    with pytest.raises(cd.EquilibriumError, match=r"its table of length goes from 0 to 0\.1"):
        lift(2.0, between(table, "length")).equilibrium(position=0.05)


def test_tables_along_coordinates_store_energy() -> None:
    spring = cd.JointSpring("lift", 30.0, rest=1.5)
    table = cd.Actuator("lift", [[0.0, 45.0], [0.7, 24.0], [4.0, -75.0]], of="position")
    assert table.conserves
    assert not table.gives_power
    places = np.linspace(0.0, 4.0, 9)
    one, other = (
        lift(2.0, item).replace(drive="lift", free=None).sweep(places) for item in (table, spring)
    )
    np.testing.assert_allclose(one.drive_effort, other.drive_effort, atol=1e-12)
    np.testing.assert_allclose(one.elastic_energy, other.elastic_energy, atol=1e-12)


ROTOR = """<robot name="rotor"><link name="base"/><link name="wheel"/><link name="block"><inertial>
  <mass value="2"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="wheel"/>
  <axis xyz="0 0 1"/></joint><joint name="arm" type="prismatic"><parent link="wheel"/>
  <child link="block"/><axis xyz="1 0 0"/>
  <limit effort="1" velocity="1" lower="0" upper="9"/></joint></robot>"""


def rotor(*laws: object) -> cd.Scene:
    """A block on an arm that turns, on which the weight pulls once a turn."""
    arm = ("wheel", (0, 0, 0), "block", (0, 0, 0))
    elements = [cd.PointActuator(*arm, thrust, of=of) for thrust, of in laws]
    options = {"near": {"arm": 1.0127}, "gravity": (0.0, -9.81, 0.0), "elements": elements}
    return cd.Scene(cd.load(ROTOR), drive="turn", free="arm", **options)


def test_the_stiffness_of_a_turning_block_is_the_slope_of_its_law() -> None:
    """The mean of c / length² less m Ω², over the motion that was found."""
    speed, law = 5.0, 4000.0
    curved = vibration.linearise(rotor((lambda x: law / x, "length"), (-law, "time")), speed)
    expected = np.mean(law / curved.motion**2) - 2.0 * speed**2
    assert curved.fourier("stiffness")[0, 0, 0].real == pytest.approx(expected, rel=1e-8)
    straight = vibration.linearise(rotor(([[0.5, 2000.0], [1.4, -1600.0]], "length")), speed)
    assert straight.fourier("stiffness")[0, 0, 0].real == pytest.approx(law - 50.0, rel=1e-10)


@pytest.mark.parametrize(
    ("thrust", "of", "error", "words"),
    [
        (np.sin, "time", cd.ArgumentError, "at 'wheel' and 'block' is a function of time"),
        (np.cos, "rate", cd.ArgumentError, "law of the rate, which has no linear vibration"),
        (
            lambda length, rate: -length - rate,
            *(("length", "rate"), cd.ArgumentError, "law of the rate, which has no linear"),
        ),
        (
            [[0.5, 2000.0], [1.013, -52.0], [1.4, -3148.0]],
            *("length", cd.AccuracyError, "no smooth functions"),
        ),
    ],
)
def test_what_has_no_tangent_is_refused(
    thrust: object, of: object, error: type[Exception], words: str
) -> None:
    # Far from a resonance, and so light that no other motions are looked for beside the first.
    scene = rotor((thrust, of)).replace(gravity=(0.0, -1.0, 0.0))
    with pytest.raises(error, match=words):
        vibration.linearise(scene, 5.0)


def test_a_simulation_ends_where_a_table_does() -> None:
    """A fall of 0.3 m takes sqrt(2 · 0.3 m / g)."""
    for table in ([[0.1, 0.0], [2.0, 0.0]], [[0.1, 5.0], [0.2, 0.0], [2.0, 0.0]]):
        with pytest.raises(cd.SimulationError, match=r"goes from 0\.1 to 2") as found:
            lift(2.0, between(table, "length")).simulate(1.0, position=0.4)
        end = math.sqrt(0.6 / 9.81)
        assert found.value.details["time"] == pytest.approx(end, rel=2e-2)


@pytest.mark.parametrize("how", [copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))])
def test_tables_are_values(how: object) -> None:
    one = cd.PointActuator(*ENDS, LINE, of="length", name="stop")
    again = how(one)  # type: ignore[operator]
    assert again == one
    assert again.thrust.flags.writeable is False
    assert one != cd.PointActuator(*ENDS, LINE + 1.0, of="length", name="stop")
    number = cd.PointActuator(*ENDS, 5, of=["length", "rate"])
    assert how(number) == number  # type: ignore[operator]
    assert cd.PointActuator(*ENDS, LINE.tolist(), of=["length"], name="stop").of == ("length",)


def test_results_have_its_columns() -> None:
    turn = four_bar(SPRING, cd.PointActuator(*ENDS, 40.0, name="ram")).sweep(TURN)
    table = turn.to_xarray()
    np.testing.assert_array_equal(table["element_tension"].sel(point_spring="ram"), -40.0)
    assert turn.element_force["ram"].energy.max() == 0.0


class _Wrong(cd.PointActuator):
    """A law whose results are not what it states."""

    def force(self, *args: object, **options: object) -> PointForce:
        done = super().force(*args, **options)  # type: ignore[arg-type]
        return done._replace(force=1.001 * done.force)


MAP = np.array([[0, -9, 1, 9], [0.01, 40, 30, 0], [0.9, 60, 30, -20]], dtype=float)
"""A thrust over length and rate."""


@pytest.mark.parametrize(
    ("thrust", "of"),
    [(30.0, "time"), (LINE, "length"), (np.cos, "rate"), (MAP, ("length", "rate"))],
)
def test_the_proof_has_the_law_once_more(thrust: object, of: object) -> None:
    four_bar(cd.PointActuator(*ENDS, thrust, of=of)).sweep(TURN, speed=2.0)
    with pytest.raises(cd.AccuracyError):
        four_bar(_Wrong(*ENDS, thrust, of=of)).sweep(TURN, speed=2.0)


@pytest.mark.parametrize(
    ("thrust", "of", "words"),
    [
        (np.nan, "time", "thrust is not finite"),
        ("much", "time", "thrust is not an array of real numbers"),
        ([1.0, 2.0], "length", r"thrust has shape \(2,\), expected a number, a function, a table"),
        ([[1.0, 2.0]], "length", r"thrust has shape \(1, 2\)"),
        ([[1.0, 2.0], [1.0, 3.0]], "length", "thrust: the first column of a table ascends"),
        (
            [[1.0, 2.0], [2.0, 3.0]],
            ("length", "rate"),
            r"thrust has shape \(2, 2\).* a table .* of one of: length, rate, time; or of two",
        ),
        (MAP[:, :2], ("length", "rate"), r"thrust has shape \(3, 2\)"),
        (MAP, ("length", "rate", "time"), r"thrust has shape \(3, 4\)"),
        (MAP[[0, 2, 1]], ("length", "rate"), "thrust: the first column of a table ascends"),
        (MAP[:, [0, 3, 2, 1]], ("length", "rate"), "thrust: the first row of a table ascends"),
        (1.0, "speed", "of is 'speed'; it is length, rate, time"),
        (1.0, (), r"of is .*; it is length, rate, time"),
        (
            lambda *lengths: 0.0,
            ("length", "length"),
            r"of is .* it is length, rate, time, or several",
        ),
    ],
)
def test_laws_that_are_none_are_refused(thrust: object, of: object, words: str) -> None:
    with pytest.raises(cd.ArgumentError, match="PointActuator: " + words):
        cd.PointActuator(*ENDS, thrust, of=of)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("thrust", "of", "words"),
    [
        (LINE[:2], "length", r"thrust at length 0\.\d+ m: its table of length .* 0\.01 to 0\.15"),
        (
            MAP[:, [0, 2, 3]],
            ("length", "rate"),
            r"thrust at length 0\.\d+ m, rate .* m/s: its table of length goes from 0\.01 to 0\.9 "
            "and of rate goes from 1 to 9; give it",
        ),
        (lambda length: 1.0 / 0.0, "length", r"thrust at length .* m fails: ZeroDivisionError"),
        (lambda a, b: np.nan, ("rate", "time"), r"thrust at rate .* m/s, 0 s is not finite"),
    ],
)
def test_laws_that_fail_say_where(thrust: object, of: object, words: str) -> None:
    scene = four_bar(SPRING, cd.PointActuator(*ENDS, thrust, of=of, name="ram"))
    with pytest.raises(cd.ArgumentError, match=r"elements\[1\] \(PointActuator 'ram'\): " + words):
        scene.sweep(TURN, speed=1.0)


def test_points_that_coincide_are_refused() -> None:
    both = cd.PointActuator("crank", (0, 0, 0), "base", (0, 0, 0), 5.0)
    with pytest.raises(cd.ArgumentError, match=r"\(PointActuator\): its points coincide at sample"):
        four_bar(both).sweep(TURN)
    with pytest.raises(cd.ArgumentError, match="points coincide"):
        lift(2.0, between(5.0)).simulate(0.1, position=0.0)
