"""Couplings whose ratio changes: the successor's motion is a polynomial of the predecessor's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.kinematics.following.lines import Lines
from cardan_dyn.core.mechanics import closure

POWERS = (0.2, 0.5, 0.3, -0.1, 0.05)
P = np.polynomial.Polynomial(POWERS)
GRAVITY = (1.0, -9.81, 2.0)
BODY = """<inertial><origin xyz="{0}"/><mass value="{1}"/>
  <inertia ixx="0.01" iyy="0.02" izz="0.03"/></inertial>"""
ARM = f"""<robot name="arm"><link name="ground"/>
<link name="upper">{BODY.format("0.1 0.02 0", 2)}</link>
<link name="lower">{BODY.format("0.2 0.05 0", 1)}</link>
<joint name="A" type="continuous"><parent link="ground"/><child link="upper"/>
  <axis xyz="0 0 1"/></joint>
<joint name="B" type="continuous"><parent link="upper"/><child link="lower"/>
  <origin xyz="0.3 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
STATED = ARM.replace(
    '"0 1 0"/></joint>',
    '"0 1 0"/><mimic joint="A" multiplier="0.5" offset="0.2" higher="0.3 -0.1 0.05"/></joint>',
)
AT = np.linspace(-2.0, 2.0, 9)


def by_hand(mechanism: cd.Mechanism, a: float, speed: float, acceleration: float) -> float:
    """Return the effort of A by Lagrange's equation: that of the tree along (1, P')."""
    model = mechanism.model.copy()
    model.gravity.linear = np.array(GRAVITY)
    v = np.array([1.0, P.deriv()(a)]) * speed
    rates = np.array([acceleration, P.deriv()(a) * acceleration + P.deriv(2)(a) * speed**2])
    q = pin.integrate(model, pin.neutral(model), np.array([a, P(a)]))
    tau = pin.rnea(model, model.createData(), q, v, rates)
    return float(tau[0] + P.deriv()(a) * tau[1])


@pytest.mark.parametrize("way", ["URDF", "couple"])
def test_motion_and_efforts_are_those_of_the_polynomial(way: str) -> None:
    if way == "URDF":
        arm = cd.load(STATED)
    else:
        arm = cd.couple(cd.load(ARM), "A", "B", 0.5, offset=0.2, higher=[0.3, -0.1, 0.05])
    assert cd.describe(arm).mobility == 1
    swept = cd.Scene(arm, drive="A", gravity=GRAVITY).sweep(AT, speed=3.0, acceleration=2.0)
    np.testing.assert_allclose(swept.motion.position("B"), P(AT), rtol=0, atol=1e-14)
    np.testing.assert_allclose(swept.motion.velocity("B"), 3.0 * P.deriv()(AT), atol=1e-13)
    turned = 2.0 * P.deriv()(AT) + 9.0 * P.deriv(2)(AT)
    np.testing.assert_allclose(swept.motion.acceleration("B"), turned, rtol=0, atol=1e-13)
    expected = [by_hand(arm, a, 3.0, 2.0) for a in AT.tolist()]
    np.testing.assert_allclose(swept.drive_effort, expected, rtol=0, atol=1e-13)


def test_the_proof_has_the_polynomial_from_the_text(monkeypatch: pytest.MonkeyPatch) -> None:
    """Accelerations of a solver that takes the ratio as constant are refused."""
    monkeypatch.setattr(closure, "bends", lambda tree, *_: [0.0] * len(tree.couplings))
    with pytest.raises(cd.CardanError, match="residual"):
        cd.Scene(cd.load(STATED), drive="A").sweep([0.5, 0.6], speed=3.0)


def test_many_turns_of_the_predecessor_count_as_they_are() -> None:
    """A polynomial takes no whole turns off, even where it maps one turn to another."""
    higher = 1.0 / (2.0 * np.pi)  # P(2π) = 2π: after a turn, both are where they were.
    arm = cd.couple(cd.load(ARM), "A", "B", 0.0, higher=[higher])
    swept = cd.Scene(arm, drive="A", gravity=GRAVITY).sweep(np.linspace(0.0, 30.0, 7), speed=1.0)
    a = swept.motion.position("A")
    np.testing.assert_allclose(swept.motion.position("B"), higher * a**2, rtol=1e-14)


def test_a_swing_has_the_energy_that_pinocchio_counts() -> None:
    """With one way to move, its equation of motion is that its energy stays."""
    arm = cd.load(STATED)
    scene = cd.Scene(arm, free=["A"], gravity=GRAVITY)
    swung = scene.simulate(1.0, position={"A": 0.3}, speed=0.5, rtol=1e-10)
    a = swung.motion.position("A")
    assert np.ptp(a) > 0.1
    np.testing.assert_allclose(swung.motion.position("B"), P(a), rtol=0, atol=1e-12)
    model = arm.model.copy()
    model.gravity.linear = np.array(GRAVITY)
    data, energies = model.createData(), []
    for q, v in zip(swung.motion.q, swung.motion.v, strict=True):
        kinetic = pin.computeKineticEnergy(model, data, q, v)
        energies.append(kinetic + pin.computePotentialEnergy(model, data, q))
    assert np.ptp(energies) < 1e-8
    (rest,) = scene.equilibrium(position={"A": 0.3}).position
    assert by_hand(arm, float(rest), 0.0, 0.0) == pytest.approx(0.0, abs=1e-9)


def test_mjcf_is_read_as_mujoco_has_it_and_written(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    arm = cd.load(STATED)
    for name in ("arm.xml", "arm.urdf"):
        again = cd.load(str(cd.write(arm, tmp_path / name, at={"A": 0.0, "B": 0.2})))
        (item,) = again.description.couplings
        assert (item.ratio, *item.higher) == POWERS[1:]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml"))
    data = mujoco.MjData(model)
    for a in AT.tolist():
        data.qpos[:] = a, P(a) - 0.2
        mujoco.mj_forward(model, data)
        (row,) = data.efc_J.reshape(data.nefc, model.nv)
        assert -row[0] / row[1] == pytest.approx(P.deriv()(a), abs=1e-12)
        assert data.efc_pos[0] == pytest.approx(0.0, abs=1e-14)


def test_written_from_another_zero_it_is_the_same_mechanism(tmp_path: Path) -> None:
    arm = cd.load(STATED)
    path = cd.write(arm, tmp_path / "arm.urdf", at={"A": 0.4, "B": float(P(0.4))})
    moved, same = (
        cd.Scene(mechanism, drive="A", gravity=GRAVITY).sweep(at, speed=3.0)
        for mechanism, at in ((cd.load(str(path)), AT - 0.4), (arm, AT))
    )
    np.testing.assert_allclose(moved.drive_effort, same.drive_effort, rtol=0, atol=1e-12)


def test_links_that_a_screw_of_changing_lead_couples() -> None:
    """A slide by the square of a turn: the thrust times the slope, nothing at zero."""
    text = f"""<robot name="lift"><link name="ground"/><link name="cam"/>
    <link name="plate">{BODY.format("0 0 0", 4)}</link>
    <joint name="shaft" type="continuous"><parent link="ground"/><child link="cam"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="guide" type="prismatic"><parent link="ground"/><child link="plate"/>
      <axis xyz="0 0 1"/></joint>
    <coupling name="lead" higher="0.02" forces="none"><predecessor link="cam"/>
      <successor link="plate"/><ratio value="0"/></coupling></robot>"""
    lift = cd.Scene(cd.load(text), drive="shaft", gravity=(0, 0, -10))
    swept = lift.sweep([0.0, 0.5, 2.0], speed=3.0)
    a = swept.motion.position("shaft")
    np.testing.assert_allclose(swept.motion.position("guide"), 0.02 * a**2, atol=1e-16)
    thrust = 4.0 * (10.0 + 0.04 * 9.0)
    np.testing.assert_allclose(swept.drive_effort, 0.04 * a * thrust, rtol=0, atol=1e-13)
    np.testing.assert_allclose(swept["guide"].force[:, 2], thrust, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ('higher="0 0"', "a ratio of zero would hold the successor"),
        ('higher="0.1" forces="mesh"', "gears have one ratio; leave higher or forces='mesh' out"),
        ('higher="a"', "'a' is not 1 finite"),
    ],
)
def test_what_is_no_polynomial_is_refused(stated: str, message: str) -> None:
    text = ARM.replace(
        '"0 1 0"/></joint>', f'"0 1 0"/><mimic joint="A" multiplier="0" {stated}/></joint>'
    )
    with pytest.raises(cd.ModelError, match=message):
        cd.load(text)


@pytest.mark.parametrize("drives", [["A"], ["A", "D"]])
def test_what_follows_steeply_is_followed_only_where_it_is_asked_for(
    drives: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In half a turn of the drive, the second follower would turn by a million radians."""
    steps, advance = [], Lines.advance
    monkeypatch.setattr(Lines, "advance", lambda *of: steps.append(1) or advance(*of))
    finger = """<link name="finger"/><joint name="D" type="continuous"><parent link="hand"/>
        <child link="finger"/></joint>""" * ("D" in drives)
    text = ARM.replace(
        "</robot>",
        f"""<link name="hand">{BODY.format("0.1 0 0", 1)}</link><joint name="C" type="continuous">
        <parent link="lower"/><child link="hand"/><axis xyz="1 0 0"/>
        <mimic joint="B" multiplier="0" higher="0.4"/></joint>{finger}</robot>""",
    )
    arm = cd.couple(cd.load(text), "A", "B", 3.0, higher=[-20.0, 5.0, 10.0])
    swept = cd.Scene(arm, drive=drives).sweep(np.outer([0.0, 0.1], np.ones(len(drives))))
    b = 0.3 - 0.2 + 0.005 + 0.001
    assert swept.motion.position("C")[1] == pytest.approx(0.4 * b**2, abs=1e-14)
    assert len(steps) < 1000


def test_what_goes_round_is_not_followed_for_a_period_that_its_polynomial_lacks() -> None:
    """A drag link: both cranks go round, and what follows the second one never comes back."""
    bar = f"""<robot name="drag_link"><link name="ground"/><link name="crank"/><link name="rod"/>
    <link name="other"/><link name="arm">{BODY.format("0.1 0.02 0", 2)}</link>
    <joint name="A" type="continuous"><parent link="ground"/><child link="crank"/>
      <axis xyz="0 0 1"/></joint>
    <joint name="B" type="continuous"><parent link="crank"/><child link="rod"/>
      <origin xyz="0 0.3 0"/><axis xyz="0 0 1"/></joint>
    <joint name="D" type="continuous"><parent link="ground"/><child link="other"/>
      <origin xyz="0.05 0 0"/><axis xyz="0 0 1"/></joint>
    <loop name="C" type="continuous"><predecessor link="rod"><origin xyz="0.22 0 0"/></predecessor>
      <successor link="other"><origin xyz="0 0.25 0"/></successor><axis xyz="0 0 1"/></loop>
    <joint name="E" type="continuous"><parent link="other"/><child link="arm"/>
      <axis xyz="1 0 0"/></joint></robot>"""
    drag_link = cd.load(bar)
    cd.Scene(drag_link, drive="A", held={"E": 0.0}).response()  # It comes back by itself.
    following = cd.Scene(cd.couple(drag_link, "D", "E", 0.5, higher=[0.3, -0.1, 0.05]), drive="A")
    with pytest.raises(cd.CardanError, match="does not come back to where it was"):
        following.response()
    at = np.linspace(-3.0, 3.0, 5)
    some, exact = following.response(interval=(-3.0, 3.0)), following.sweep(at, speed=2.0)
    np.testing.assert_allclose(
        some.sweep(at, speed=2.0).drive_effort, exact.drive_effort, atol=1e-9
    )
