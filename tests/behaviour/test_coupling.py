"""Couplings that are added in Python are those that a file would have stated."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import cardan_dyn as cd

BODY = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="{}" ixy="0" ixz="0" iyz="0"/>'
BODY += "</inertial>"
PAIR = f"""<robot name="pair"><link name="box"/><link name="pinion">{BODY.format(1, 0.02)}</link>
  <link name="wheel">{BODY.format(3, 0.3)}</link><joint name="in" type="continuous">
  <parent link="box"/><child link="pinion"/><axis xyz="0 0 1"/></joint>
  <joint name="out" type="continuous"><parent link="box"/><child link="wheel"/>
  <origin xyz="0.14 0 0"/><axis xyz="0 0 1"/></joint>{{}}</robot>"""
TEETH = """<coupling name="teeth" forces="mesh" pressure_angle="0.4"><predecessor link="pinion"/>
  <successor link="wheel"/><ratio value="-0.4"/></coupling>"""
SCREW = f"""<robot name="screw"><link name="base"/>
  <link name="spindle">{BODY.format(1, 0.02)}</link><link name="nut">{BODY.format(3, 0.3)}</link>
  <joint name="spin" type="continuous">
  <parent link="base"/><child link="spindle"/><axis xyz="0 0 1"/></joint>
  <joint name="way" type="prismatic"><parent link="base"/><child link="nut"/><axis xyz="0 0 1"/>
  <limit effort="1" velocity="1" lower="0" upper="9"/>{{}}</joint></robot>"""
LEAD = 0.005 / (2.0 * np.pi)


def turn(mechanism: cd.Mechanism, drive: str) -> cd.Sweep:
    scene = cd.Scene(mechanism, drive=drive, gravity=(0.0, 0.0, -9.81))
    return scene.sweep(np.linspace(0.0, 6.0, 13), speed=7.0, acceleration=3.0)


def geared() -> cd.Mechanism:
    return cd.couple(
        *(cd.load(PAIR.format("")), "pinion", "wheel", -0.4),
        **{"forces": "mesh", "pressure_angle": 0.4, "name": "teeth"},
    )


def test_gears_are_those_of_a_file() -> None:
    written, given = cd.load(PAIR.format(TEETH)), geared()
    assert given.description == written.description
    one, other = turn(written, "in"), turn(given, "in")
    np.testing.assert_array_equal(one.drive_effort, other.drive_effort)
    np.testing.assert_array_equal(one["out"].force, other["out"].force)


def test_a_screw_by_hand() -> None:
    """1000 N on a lead of 5 mm need 0.795775 N·m."""
    mechanism = cd.couple(cd.load(SCREW.format("")), "spin", "way", LEAD, forces="none")
    scene = cd.Scene(mechanism, drive="spin", loads={"way": -1000.0})
    assert scene.sweep(0.0).drive_effort[0] == pytest.approx(0.795775, rel=1e-6)
    mimic = f'<mimic joint="spin" multiplier="{LEAD!r}" forces="none" name="coupling_1"/>'
    assert mechanism.description == cd.load(SCREW.format(mimic)).description


def test_a_joint_follows_another_with_an_offset() -> None:
    mechanism = cd.couple(cd.load(PAIR.format("")), "in", "out", 2.0, offset=0.3, name="follows")
    np.testing.assert_allclose(
        turn(mechanism, "in").motion.position("out"), 2.0 * np.linspace(0.0, 6.0, 13) + 0.3
    )


@pytest.mark.parametrize("how", [copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
def test_copies_have_the_coupling(how: object) -> None:
    again = how(geared())  # type: ignore[operator]
    assert again.description == geared().description
    assert turn(again, "in").loop_residual < 1e-12


def test_a_written_file_has_the_coupling(tmp_path: Path) -> None:
    mechanism = cd.couple(cd.load(SCREW.format("")), "spin", "way", LEAD, name="thread")
    for given in (geared(), mechanism):
        again = cd.load(cd.write(given, tmp_path / "coupled.urdf"))
        assert again.description == given.description


@pytest.mark.parametrize(
    "make", [geared, lambda: cd.couple(cd.load(PAIR.format("")), "in", "out", 2.0)]
)
def test_the_proof_reads_it_from_its_own_text(make: object) -> None:
    description = make().description  # type: ignore[operator]
    moved = replace(
        description,
        couplings=tuple(replace(item, ratio=1.01 * item.ratio) for item in description.couplings),
    )
    assert cd.Mechanism(moved).second_reading.couplings == description.couplings
    with pytest.raises(cd.AccuracyError):
        turn(cd.Mechanism(moved), "in")


def test_a_model_of_pinocchio_is_coupled_and_closed() -> None:
    model = pinocchio.buildModelFromXML(PAIR.format(""))
    mechanism = cd.couple(cd.from_pinocchio(model), "pinion", "wheel", -0.4, forces="none")
    expected = turn(cd.couple(cd.load(PAIR.format("")), "in", "out", -0.4, forces="none"), "in")
    np.testing.assert_allclose(turn(mechanism, "in").drive_effort, expected.drive_effort)


DIFFERENTIAL = f"""<robot name="axle"><link name="housing"/>
  <link name="cage">{BODY.format(2, 0.05)}</link><link name="planet"/>
  <link name="left">{BODY.format(1, 0.4)}</link><link name="right">{BODY.format(1, 0.4)}</link>
  <joint name="ring" type="continuous"><parent link="housing"/><child link="cage"/>
  <axis xyz="1 0 0"/></joint><joint name="pin" type="continuous"><parent link="cage"/>
  <child link="planet"/><axis xyz="0 0 1"/></joint><joint name="left_gear" type="continuous">
  <parent link="cage"/><child link="left"/><origin xyz="-0.1 0 0"/><axis xyz="1 0 0"/></joint>
  <joint name="right_gear" type="continuous"><parent link="cage"/><child link="right"/>
  <origin xyz="0.1 0 0"/><axis xyz="1 0 0"/></joint></robot>"""


def test_a_differential_shares_torque_and_adds_speeds() -> None:
    """Bevel gears on the pin of a cage: both wheels' speeds are twice the cage's together."""
    mechanism = cd.load(DIFFERENTIAL)
    for gear, ratio in (("left", 0.5), ("right", -0.5)):
        mechanism = cd.couple(mechanism, "planet", gear, ratio, forces="none")
    assert cd.describe(mechanism).mobility == 2
    assert [item.name for item in mechanism.couplings] == ["coupling_1", "coupling_2"]
    loads = {
        link: cd.Wrench(moment=(-torque, 0, 0), frame="world")
        for link, torque in (("left", 30.0), ("right", 30.0))
    }
    scene = cd.Scene(mechanism, drive=["ring", "pin"], loads=loads)
    swept = scene.sweep([[0.3, 0.0], [0.3, 0.5]], speed=[[5.0, 0.0], [5.0, 4.0]])
    ring, left, right = (
        swept.motion.velocity(name) for name in ("ring", "left_gear", "right_gear")
    )
    np.testing.assert_allclose((ring + left) + (ring + right), 2.0 * ring)
    np.testing.assert_allclose(left - right, [0.0, 4.0], atol=1e-12)
    np.testing.assert_allclose(swept.drive_effort[:, 0], 60.0, rtol=1e-12)
    # Equal torques: nothing is left to turn the pin.
    np.testing.assert_allclose(swept.drive_effort[:, 1], 0.0, atol=1e-12)
    uneven = {**loads, "left": cd.Wrench(moment=(-40.0, 0, 0), frame="world")}
    turned = scene.sweep([0.3, 0.5], speed=[5.0, 4.0], loads=uneven).drive_effort
    np.testing.assert_allclose(turned, [[70.0, 0.5 * (40.0 - 30.0)]], rtol=1e-12)


def test_what_nothing_moves_any_more_says_so() -> None:
    mechanism = geared()
    locked = cd.couple(mechanism, "in", "out", 1.5, name="chain")
    told = "with 'chain' none of the 2 coordinates that it couples moves any more"
    assert any(told in one for one in locked.warnings)


def test_numbers_are_made_exact_within_the_tolerance() -> None:
    """Two axes of a ring of four are off by 3e-4."""
    text = """<robot name="ring"><link name="base"/><link name="a"/><link name="b"/><link name="c"/>
    <link name="dial"/><joint name="A" type="continuous"><parent link="base"/><child link="a"/>
    <axis xyz="0 0 1"/></joint><joint name="B" type="continuous"><parent link="a"/>
    <child link="b"/><origin xyz="0.1 0 0" rpy="1.5711 0 0"/><axis xyz="0 1 0"/></joint>
    <joint name="C" type="continuous"><parent link="b"/><child link="c"/>
    <origin xyz="0.3 0 0" rpy="-1.5711 0 0"/><axis xyz="0 0 1"/></joint>
    <joint name="dial" type="continuous"><parent link="base"/><child link="dial"/></joint>
    </robot>"""
    ring = cd.close(
        *(cd.load(text), "base", "c", "revolute"),
        **{"at": (0.3, 0.2, 0), "axis": (0, 0, 1), "closure_tolerance": 1e-3},
    )
    assert cd.describe(ring).mobility == 2
    shown = cd.couple(ring, "A", "dial", 2.0, closure_tolerance=1e-3)
    assert cd.describe(shown).mobility == 1
    assert not any("moves any more" in one for one in shown.warnings)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"second": "whel"}, cd.ModelError, r"'whel' is no joint .* \(did you mean 'wheel'\?\)"),
        ({"first": "pinon"}, cd.ModelError, "'wheel' is no joint of the tree"),
        (
            {"first": "in"},
            cd.ModelError,
            "'in' and 'wheel' are not both links; joints: in, out; links: box, pinion, wheel$",
        ),
        ({"first": "im", "second": "out"}, cd.ModelError, r"joint 'im' does not exist"),
        ({"second": "pinion"}, cd.ModelError, "no joint moves 'pinion' relative to 'pinion'"),
        ({"first": "in", "second": "in"}, cd.ModelError, "cannot mimic itself"),
        ({"ratio": 0.0}, cd.ModelError, "ratio of zero"),
        ({"ratio": np.nan}, cd.ArgumentError, "couple: ratio is not finite"),
        ({"higher": [[1, 2]]}, cd.ArgumentError, r"higher has shape \(1, 2\), expected \(n,\)"),
        ({"higher": 2.0}, cd.ArgumentError, r"higher has shape \(\), expected \(n,\)"),
        ({"offset": 0.1}, cd.ArgumentError, "a coupling of links has no offset"),
        ({"forces": "mash"}, cd.ModelError, "forces 'mash' is unknown"),
        ({"helix_angle": 0.2}, cd.ModelError, 'helix_angle|is one of teeth: write forces="mesh"'),
        ({"name": "in"}, cd.ModelError, "occur twice: in"),
        ({"mechanism": "pair"}, cd.ArgumentError, "couple needs a mechanism from load"),
    ],
)
def test_what_cannot_be_coupled_is_refused(
    given: dict[str, object], error: type[Exception], words: str
) -> None:
    usual = {"mechanism": cd.load(PAIR.format("")), "first": "pinion", "second": "wheel"}
    with pytest.raises(error, match=words):
        cd.couple(**{**usual, "ratio": -0.4, **given})  # type: ignore[arg-type]


def test_a_joint_follows_only_one_other() -> None:
    mechanism = cd.couple(cd.load(PAIR.format("")), "in", "out", 2.0)
    with pytest.raises(cd.ModelError, match="joint 'out' mimics 'in' and 'in'"):
        cd.couple(mechanism, "in", "out", 2.0)
    with pytest.raises(cd.ModelError, match="in a circle"):
        cd.couple(mechanism, "out", "in", 0.5)
