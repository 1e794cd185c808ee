"""Couplings between joints: velocity ratios, moments, and closed trains of wheels."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import LINK, coupling, gears
from testkit.scenes import relative

import cardan_dyn as cd
from cardan_dyn.core.description.write import to_urdf

POSITIONS = np.linspace(-10.0, 10.0, 41)


def test_a_coupling_passes_power_on_without_loss() -> None:
    scene = cd.Scene(cd.load(gears(coupling("mesh", "a", "b", -2.5))), drive="a", loads={"b": 7.0})
    turn = scene.sweep(POSITIONS, speed=3.0, acceleration=2.0)
    np.testing.assert_allclose(turn.motion.position("b"), -2.5 * POSITIONS, atol=1e-13)
    np.testing.assert_allclose(turn.motion.velocity("b"), -7.5)
    # The moment that the coupling exerts on b drives its inertia against the load.
    moment = 0.025 * (-2.5 * 2.0) - 7.0
    np.testing.assert_allclose(turn.coupling_moment["mesh"], moment, rtol=1e-13)
    np.testing.assert_allclose(turn["b"].torsion, 7.0 + moment, rtol=1e-13)
    # On a the same coupling exerts 2.5 times as much, so that no power is lost.
    np.testing.assert_allclose(turn["a"].torsion, 0.025 * 2.0, rtol=1e-13)
    np.testing.assert_allclose(turn.drive_effort, 0.025 * 2.0 - 2.5 * moment, rtol=1e-13)
    assert turn.power_residual < 1e-14
    assert turn.coupling_unique["mesh"]


def test_closed_trains_of_wheels_are_solved_or_refused() -> None:
    train = (
        coupling("ab", "a", "b", -2.0, 'forces="none"'),
        coupling("bc", "b", "c", -3.0, 'forces="none"'),
    )
    closed = gears(*train, coupling("ca", "c", "a", 1.0 / 6.0, 'forces="none"'), third=True)
    scene = cd.Scene(cd.load(closed), drive="a", loads={"c": -4.0})
    turn = scene.sweep(POSITIONS, speed=1.0)
    assert relative(turn.drive_effort, np.full(41, 24.0)) < 1e-13
    assert turn.coupling_unique == {"ab": False, "bc": False, "ca": False}
    assert np.all([turn[name].unique for name in "abc"])
    tree = cd.Scene(cd.load(gears(*train, third=True)), drive="a", loads={"c": -4.0})
    assert tree.sweep(POSITIONS, speed=1.0).coupling_unique == {"ab": True, "bc": True}
    locked = gears(*train, coupling("ca", "c", "a", 1.0 / 5.0), third=True)
    with pytest.raises(cd.MobilityError, match="it is locked") as caught:
        cd.Scene(cd.load(locked), drive="a")
    assert caught.value.mobility == 0


def test_a_planetary_gear_counts_from_the_nearest_common_ancestor() -> None:
    """Sun on the ground, planet on the carrier: ratios count along the whole way to each."""
    urdf = f"""<robot name="planetary"><link name="ground"/>
{LINK.format(name="sun", com="0 0 0", mass="1")}
{LINK.format(name="carrier", com="0.2 0 0", mass="2")}
{LINK.format(name="planet", com="0 0 0", mass="3")}
<joint name="s" type="continuous"><parent link="ground"/><child link="sun"/>
  <axis xyz="0 0 1"/></joint>
<joint name="k" type="continuous"><parent link="ground"/><child link="carrier"/>
  <axis xyz="0 0 1"/></joint>
<joint name="p" type="continuous"><parent link="carrier"/><child link="planet"/>
  <origin xyz="0.4 0 0"/><axis xyz="0 0 1"/></joint>
<coupling name="mesh"><predecessor link="sun"/><successor link="planet"/><ratio value="-1.5"/>
</coupling></robot>"""
    mechanism = cd.load(urdf)
    turn = cd.Scene(mechanism, drive="s", held={"k": 0.3}).sweep(POSITIONS, speed=2.0)
    np.testing.assert_allclose(turn.motion.position("p"), -1.5 * POSITIONS - 0.3, atol=1e-13)
    both = cd.Scene(mechanism, drive=["s", "k"]).sweep([[0.2, 0.5]], speed=[[1.0, 4.0]])
    assert both.motion.velocity("p")[0] == pytest.approx(-1.5 * 1.0 - 4.0)
    assert both.power_residual < 1e-14


@pytest.mark.parametrize("mass", ["0", "1e-50", "1e-9", "1"])
def test_a_rotor_resists_by_its_inertia_however_little_it_weighs(mass: str) -> None:
    """As in published robots, whose rotors have an inertia and no mass: a = τ / (J + i² j)."""
    text = f"""<robot name="drive"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
  <inertia ixx="0.1" iyy="0.3" izz="0.3"/></inertial></link>
<link name="rotor"><inertial><mass value="{mass}"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.002"/></inertial></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/>
  <axis xyz="0 0 1"/></joint>
<joint name="motor" type="continuous" independent="false"><parent link="base"/><child link="rotor"/>
  <axis xyz="0 0 1"/></joint>
<coupling name="gear" type="rolling"><predecessor link="arm"/><successor link="rotor"/>
  <ratio value="6"/></coupling></robot>"""
    inertia = 0.3 + 2.0 * 0.5**2 + 6.0**2 * 0.002
    mechanism = cd.load(text, strict=mass != "0")
    assert mechanism.characteristic_length < 2.0
    scene = cd.Scene(mechanism)
    turn = scene.sweep([0.3], speed=2.0, acceleration=5.0)
    assert turn.drive_effort == pytest.approx(5.0 * inertia, rel=1e-13)
    assert turn["motor"].torsion == pytest.approx(6.0 * 5.0 * 0.002, rel=1e-13)
    assert turn.balance_residual < 1e-14
    free = cd.Scene(mechanism, free=["hinge"], loads={"hinge": 5.0 * inertia})
    assert free.simulate(1.0).motion.position("hinge")[-1] == pytest.approx(2.5, rel=1e-9)
    if mass == "0":
        again = cd.load(to_urdf(mechanism.description), strict=False)
        assert again.description.links == mechanism.description.links


def test_bad_couplings() -> None:
    for urdf, message in (
        (gears(coupling("x", "a", "z", 1.0)), "coupling 'x': successor link 'wheel_z' does not"),
        (gears(coupling("x", "a", "b", 0.0)), "a ratio of zero would hold the successor"),
        (gears(coupling("x", "a", "a", 2.0)), "no joint moves 'wheel_a' relative to 'wheel_a'"),
        (gears(coupling("a", "a", "b", 2.0)), "names that occur twice: a"),
    ):
        with pytest.raises(cd.ModelError, match=message):
            cd.load(urdf)
