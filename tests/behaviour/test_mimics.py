"""Joints that mimic others: positions, efforts by virtual work, chains, loops, and the proof."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from testkit.linkages import LINK, coupling, four_bar, gears, loop
from testkit.mimicking import efforts, finger, mimic
from testkit.scenes import relative

import cardan_dyn as cd

POSITIONS = np.linspace(-9.0, 9.0, 37)
SPEED, ACCELERATION = 3.0, -2.0
BOTH = finger(mimic("knuckle", -1.5, 0.4), mimic("middle", 0.05, -0.2))


def wheels(text: str = "") -> str:
    """Return two wheels of which the second one mimics the first."""
    return gears().replace('name="b" type="continuous">', f'name="b" type="continuous">{text}')


@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_a_chain_of_mimics_against_virtual_work(gravity: float) -> None:
    """The joints of a finger follow its knuckle; Pinocchio knows nothing of their couplings."""
    scene = cd.Scene(cd.load(BOTH), drive="knuckle", gravity=(0.0, 0.0, gravity))
    turn = scene.sweep(POSITIONS, speed=SPEED, acceleration=ACCELERATION)
    ratios = np.array([1.0, -1.5, -0.075])
    # 0.05 (-1.5 q + 0.4) - 0.2
    offsets = np.array([0.0, 0.4, -0.18])
    at_rest = BOTH if gravity else None
    expected = []
    for position, *found in zip(
        POSITIONS, *(turn.motion.position(name) for name in ("middle", "plunger")), strict=True
    ):
        q = offsets + ratios * position
        np.testing.assert_allclose(found, q[1:], rtol=1e-13, atol=1e-13)
        needed = efforts(finger(), q, ratios * SPEED, ratios * ACCELERATION)
        weight = efforts(finger(), q, np.zeros(3), np.zeros(3))  # Pinocchio's own gravity.
        expected.append(needed - (0.0 if at_rest else weight))
    tree = np.array(expected)
    assert relative(turn.drive_effort, tree @ ratios) < 1e-13
    # What each coupling exerts on the joint that mimics, moments of further ones passed on.
    plunger = tree[:, 2]
    assert relative(turn.coupling_moment["plunger_mimic"], plunger) < 1e-13
    assert relative(turn.coupling_moment["middle_mimic"], tree[:, 1] + 0.05 * plunger) < 1e-13
    assert max(turn.loop_residual, turn.balance_residual, turn.power_residual) < 1e-13
    assert turn.coupling_unique == {"middle_mimic": True, "plunger_mimic": True}


def test_a_mimic_without_offset_is_a_coupling_of_wheels() -> None:
    loads = {"b": 7.0}
    first, second = (
        cd.Scene(cd.load(text), drive="a", loads=loads).sweep(POSITIONS, acceleration=1.0)
        for text in (wheels(mimic("a", -2.5)), gears(coupling("b_mimic", "a", "b", -2.5)))
    )
    np.testing.assert_array_equal(first.drive_effort, second.drive_effort)
    for name in "ab":
        np.testing.assert_array_equal(first[name].moment, second[name].moment)
    assert first.coupling_moment.keys() == second.coupling_moment.keys()


@pytest.mark.parametrize("offset", [0.7, -40.0, 1e4])
@pytest.mark.parametrize("drive", ["a", "b"])
def test_offsets_of_any_size_and_either_drive(drive: str, offset: float) -> None:
    """Whole turns count: the position of the other wheel is not one of many."""
    scene = cd.Scene(cd.load(wheels(mimic("a", -2.5, offset))), drive=drive)
    turn = scene.sweep(POSITIONS, speed=1.0)
    a, b = (turn.motion.position(name) for name in "ab")
    np.testing.assert_allclose(b, -2.5 * a + offset, rtol=0.0, atol=1e-15 * (abs(offset) + 30.0))
    again = scene.sweep([POSITIONS[3], POSITIONS[0]]).motion.position("ab".replace(drive, ""))
    other = a if drive == "b" else b
    np.testing.assert_allclose(again, other[[3, 0]], atol=1e-15 * (abs(offset) + 30.0))


TWO_LOOPS = four_bar(loop("continuous")).replace(
    "</robot>",
    LINK.format(name="wheel", com="0.1 0 0", mass="1")
    + '<joint name="w" type="continuous"><parent link="ground"/><child link="wheel"/>'
    '<origin xyz="-1 0 0"/><axis xyz="0 0 1"/></joint></robot>',
)


def test_a_loop_moves_with_a_joint_that_it_mimics() -> None:
    """The crank follows a wheel: as a four-bar that is driven at these positions by itself."""
    text = TWO_LOOPS.replace('<origin xyz="0 0 0"/>', mimic("w", 0.5, 0.3), 1)
    turn = cd.Scene(cd.load(text), drive="w", loads={"d": 5.0}).sweep(POSITIONS, speed=SPEED)
    crank = 0.5 * POSITIONS + 0.3
    alone = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a", loads={"d": 5.0})
    expected = alone.sweep(crank, speed=0.5 * SPEED)
    for name in "abcd":
        assert relative(turn[name].force, expected[name].force) < 1e-11
    for name in "ad":
        assert relative(turn[name].moment, expected[name].moment) < 1e-11
    assert relative(turn.coupling_moment["a_mimic"], expected.drive_effort) < 1e-11
    assert relative(turn.drive_effort, 0.5 * expected.drive_effort) < 1e-11


def test_a_response_knows_mimics() -> None:
    scene = cd.Scene(cd.load(BOTH), drive="knuckle", gravity=(0.0, 0.0, -9.81))
    direct = scene.sweep(POSITIONS, speed=SPEED, acceleration=ACCELERATION)
    found = scene.response(interval=(-9.5, 9.5)).sweep(
        POSITIONS, speed=SPEED, acceleration=ACCELERATION
    )
    assert relative(found.drive_effort, direct.drive_effort) < 1e-11
    for name, moment in direct.coupling_moment.items():
        assert relative(found.coupling_moment[name], moment) < 1e-11


def test_offsets_change_what_responses_belong_to(tmp_path: object) -> None:
    from cardan_dyn.core.response.identity import digest

    hashes = {
        digest(cd.load(wheels(mimic("a", ratio, offset))).description)
        for ratio, offset in ((2.0, 0.0), (2.0, 0.1), (3.0, 0.1))
    }
    assert len(hashes) == 3


def test_copies_and_texts_keep_mimics() -> None:
    mechanism = cd.load(BOTH)
    for again in (copy.deepcopy(mechanism), pickle.loads(pickle.dumps(mechanism))):
        assert again.description == mechanism.description
        assert again.couplings == mechanism.couplings
    again = cd.load(mechanism.to_urdf())
    assert again.description.agrees(mechanism.description, 1e-15)
    assert again.couplings == mechanism.couplings
    assert "middle_mimic: ratio -1.5, offset 0.4" in mechanism._repr_html_()
    assert "middle_mimic   ratio -1.5, offset 0.4   knuckle -> middle" in str(mechanism.description)


def test_the_zero_and_the_report() -> None:
    mechanism = cd.load(BOTH)
    np.testing.assert_allclose(mechanism.zero, [0.0, 0.4, -0.18])
    report = cd.describe(mechanism)
    assert report.mobility == 1
    assert sorted(name for part in report.components for name in part.couplings) == [
        "middle_mimic",
        "plunger_mimic",
    ]
    plan = cd.Scene(mechanism, drive="knuckle").plan()
    assert any("middle_mimic" in step and "decides" in step for step in plan.steps)


@pytest.mark.parametrize(
    ("drive", "held", "message"),
    [
        (["a", "b"], {}, "b_mimic couples a, b: drive or hold only one of them"),
        ("a", {"b": 0.7}, "b_mimic couples a, b: drive or hold only one of them"),
        ("a", {"b": 0.0}, "b_mimic couples a, b: drive or hold only one of them"),
        ("b", {"a": 3.0}, "b_mimic couples a, b: drive or hold only one of them"),
    ],
)
def test_joints_that_are_prescribed_twice(drive: str, held: dict[str, float], message: str) -> None:
    mechanism = cd.load(wheels(mimic("a", 2.0, 0.7)))
    with pytest.raises(cd.MobilityError, match=message) as caught:
        cd.Scene(mechanism, drive=drive, held=held)
    assert caught.value.mobility == (1 if not held else 0)


def test_both_ends_of_a_chain_are_prescribed() -> None:
    with pytest.raises(cd.MobilityError, match="middle_mimic, plunger_mimic couple knuckle, plun"):
        cd.Scene(cd.load(BOTH), drive="knuckle", held={"plunger": 0.1})


@pytest.mark.parametrize("field", ["ratio", "offset"])
def test_the_proof_reads_mimics_by_itself(field: str) -> None:
    """The first reader was wrong by little: the second one sees it in the text."""
    description = cd.load(BOTH).description
    first, second = description.couplings
    wrong = replace(first, **{field: getattr(first, field) * (1.0 + 1e-6)})
    mechanism = cd.Mechanism(replace(description, couplings=(wrong, second)))
    scene = cd.Scene(mechanism, drive="knuckle")
    with pytest.raises(cd.AccuracyError):
        scene.sweep(POSITIONS[5:8], speed=1.0)
