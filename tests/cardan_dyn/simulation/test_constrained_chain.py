"""A constrained chain alone, beside a mechanism that has another one."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from testkit.constrained import closure_error
from testkit.linkages import four_bar, loop
from testkit.many import in_one

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array
from cardan_dyn.motion.simulation.constrained_model import ConstrainedChain, chains_of

LINKS = "".join(
    f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
    'ixz="0" iyz="0"/></inertial></link>'
    for name in "abc"
)


def bars(coupler: str = "2 0 0", rocker: str = "1 0 0") -> str:
    """A four-bar linkage, closed at zero; with equal opposite sides, all are in line there."""
    return f"""<robot name="bars"><link name="ground"/>{LINKS}
<joint name="A" type="continuous"><parent link="ground"/><child link="a"/>
  <axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="a"/><child link="b"/><origin xyz="1 0 0"/>
  <axis xyz="0 0 1"/></joint>
<joint name="D" type="continuous"><parent link="ground"/><child link="c"/><origin xyz="2 0 0"/>
  <axis xyz="0 0 1"/></joint>
<loop name="C" type="continuous"><predecessor link="b"><origin xyz="{coupler}"/></predecessor>
  <successor link="c"><origin xyz="{rocker}"/></successor><axis xyz="0 0 1"/></loop></robot>"""


GRAVITY = np.array([0.3, -9.81, 0.2])
FIVE = cd.load(in_one(four_bar(loop("continuous")), 5))
NEUTRAL = FIVE.coordinates.neutral()


@pytest.fixture(scope="module")
def second() -> ConstrainedChain:
    """The second chain of five four-bars, a single one, whose crank is told how to move."""
    drive = FIVE.coordinates.named["a_4"].rate
    return ConstrainedChain(FIVE, chains_of(FIVE)[1], [0, drive], GRAVITY, NEUTRAL)


def gap(x: Array) -> float:
    """How far loops are open where the second chain is at its coordinates `x`."""
    row = NEUTRAL.copy()
    row[chains_of(FIVE)[1].columns] = x
    return closure_error(FIVE, row)


def test_it_knows_its_own_coordinates_alone(second: ConstrainedChain) -> None:
    assert second.model.nv == 4
    assert second.prescribed.tolist() == [0]


def test_it_closes_and_moves_as_it_is_told(second: ConstrainedChain) -> None:
    drifted, v = np.array([1e-5, -2e-5, 3e-5, 1e-5]), np.array([1.0, 0.2, 0.3, -0.4])
    closed, rates = second.closed(drifted, v)
    assert gap(drifted) > 1e-6
    assert gap(closed) < 2e-15
    assert (closed[0], rates[0]) == pytest.approx((1e-5, 1.0), abs=1e-15)
    a = second.rates(closed, rates, None, np.array([2.5]))[4:]
    assert a[0] == pytest.approx(2.5, abs=1e-13)
    # Accelerations differentiate the speeds that close the loops, along the motion.
    step = 1e-5
    after, speeds = second.closed(closed + step * rates + 0.5 * step**2 * a, rates + step * a)
    assert gap(after) < 2e-15
    assert np.max(np.abs(speeds - rates - step * a)) < 10.0 * step**2


@pytest.mark.parametrize("way", ["tape", "rank"])
def test_what_does_not_converge_is_not_returned(way: str) -> None:
    """Turned away from the other one, a crank is farther from it than both rods are long."""
    mechanism = cd.load(bars("0.4 0.3 0", "-0.6 0.3 0"))
    (only,) = chains_of(mechanism)
    drive, state = mechanism.coordinates.named["A"], mechanism.coordinates.neutral()
    chain = ConstrainedChain(mechanism, only, [drive.rate], GRAVITY, state)
    close = chain._by_rank.closed if way == "rank" else chain.closed
    x, v = np.zeros((2, 4))
    assert np.max(np.abs(close(x, v)[0])) < 1e-15
    x[drive.column] = np.pi
    with pytest.raises(cd.SingularConfigurationError, match=r"closing them leaves \d"):
        close(x, v)


def test_copies_answer_alike(second: ConstrainedChain) -> None:
    x, v = second.closed(np.zeros(4), np.array([1.0, 0.0, 0.0, 0.0]))
    other = copy.deepcopy(second)
    np.testing.assert_array_equal(other.rates(x, v), second.rates(x, v))


def test_weak_closures_are_noticed_at_the_state_that_is_asked_for() -> None:
    mechanism = cd.load(bars())
    (only,) = chains_of(mechanism)
    turned = np.zeros(4)
    for name, way in {"A": 1.0, "B": -1.0, "C": 1.0, "D": 1.0}.items():
        turned[mechanism.coordinates.named[name].column] = way
    chain = ConstrainedChain(mechanism, only, [], GRAVITY, turned)
    noticed = []
    for angle in (1.0, 1e-3, 1.0):
        chain.was_weak = False
        assert closure_error(mechanism, angle * turned) < 1e-15
        chain.rates(angle * turned, turned)
        noticed.append(chain.was_weak)
    assert noticed == [False, True, False]
