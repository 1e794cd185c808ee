"""Zeros that are not closed, or singular: assembled all the same, and right afterwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from testkit.linkages import four_bar, loop
from testkit.planar_linkages import described, joint, link
from testkit.planar_linkages import loop as planar_loop

import cardan_dyn as cd

POSITIONS = np.linspace(0.1, 5.9, 23)
OFFSETS = {"a": 0.3, "b": -0.4, "d": 0.25}


def displaced() -> cd.Mechanism:
    """A four-bar in whose zero every joint is turned by an offset, so that the loop is open."""
    description = cd.load(four_bar(loop("continuous"))).description
    joints = []
    for item in description.joints:
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(OFFSETS[item.name] * item.axis).as_matrix()
        joints.append(replace(item, origin=item.origin @ turn))
    return cd.load(cd.Mechanism(replace(description, joints=tuple(joints))).to_urdf())


def parallelogram_in_line() -> cd.Mechanism:
    """Cranks A and D of length 1, base and coupler of length 2, all on the x axis at zero."""
    return described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (1.0, 0.0)),
        joint("D", "ground", "c", (2.0, 0.0)),
        planar_loop("b", "c", (2.0, 0.0), (1.0, 0.0)),
    )


def test_wrenches_are_those_of_the_closed_description() -> None:
    given = {"loads": {"d": -2.0}, "gravity": [0.0, -9.81, 0.0]}
    closed = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="a", **given)
    opened = cd.Scene(displaced(), drive="a", **given)
    rates = {"speed": 3.0, "acceleration": -1.0}
    expected = closed.sweep(POSITIONS, **rates)
    # The drive's own zero is displaced as well.
    found = opened.sweep(POSITIONS - OFFSETS["a"], **rates)
    assert found.loop_residual < 1e-13 and found.balance_residual < 1e-12
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, rtol=1e-10, atol=1e-9)
    for name in "abdc":
        np.testing.assert_allclose(
            found.wrench(name, "world").force, expected.wrench(name, "world").force, atol=1e-8
        )
    for name in "bd":
        offset = found.motion.position(name) + OFFSETS[name] - expected.motion.position(name)
        np.testing.assert_allclose(np.sin(0.5 * offset), 0.0, atol=1e-12)


def test_an_open_zero_is_not_closed_without_a_word() -> None:
    """The gap between coupler and rocker in the plane, by complex numbers."""
    a, b, d = OFFSETS["a"], OFFSETS["b"], OFFSETS["d"]
    coupler = 0.5j * np.exp(1j * a) + (2.0 + 2.0j) * np.exp(1j * (a + b))
    gap = abs(coupler - (2.0 + 2.5j * np.exp(1j * d)))
    mechanism = displaced()
    (line,) = (line for line in mechanism.warnings if "are open at the description's zero" in line)
    assert f"c by {gap:.3g} m, " in line
    # Its own joint turns away what the angles differ by.
    assert float(line.split(" m, ")[1].split(" rad")[0]) < 1e-10
    assert line in str(cd.describe(mechanism))
    closed = cd.load(four_bar(loop("continuous")))
    assert not any("open" in line for line in closed.warnings)


def test_the_same_start_every_time() -> None:
    first, second = (cd.Scene(displaced(), drive="a").sweep(POSITIONS) for _ in range(2))
    np.testing.assert_array_equal(first.motion.q, second.motion.q)


def test_a_start_beyond_a_singular_zero_is_reached() -> None:
    mechanism = parallelogram_in_line()
    scene = cd.Scene(mechanism, drive="A", near={"A": 0.5, "D": 0.5})
    turn = scene.sweep(np.linspace(0.3, 2.8, 9))
    np.testing.assert_allclose(turn.motion.position("D"), np.linspace(0.3, 2.8, 9), atol=1e-12)
    # The same drive position also closes as an antiparallelogram, in which the half angles of its
    # cranks have tangents of a constant ratio.
    crossed = 2.0 * np.arctan(np.tan(0.25) * (2.0 + 1.0) / (2.0 - 1.0))
    swept = cd.Scene(mechanism, drive="A", near={"A": 0.5, "D": -crossed}).sweep([0.5])
    assert swept.motion.position("D")[0] == pytest.approx(-crossed, abs=1e-12)
    with pytest.raises(cd.AssemblyError, match=r"all joints of start .*\(A: 0.5, D: -0.4\)"):
        cd.Scene(mechanism, drive="A", near={"A": 0.5, "D": -0.4})


def test_a_complete_configuration_that_closes_is_taken_as_it_is() -> None:
    mechanism = parallelogram_in_line()
    start = {"A": 0.5, "B": -0.5, "D": 0.5, "C": 0.5}
    turn = cd.Scene(mechanism, drive="A", near=start).sweep([0.5])
    for name, position in start.items():
        assert turn.motion.position(name)[0] == pytest.approx(position, abs=1e-15)


def test_what_no_configuration_closes_is_refused_with_its_gap() -> None:
    mechanism = cd.load(four_bar(loop("continuous"), rocker="9.0"))
    with pytest.raises(cd.AssemblyError, match="the least closure error found around") as caught:
        cd.Scene(mechanism, drive="a")
    # Rocker 9 against base 2, crank 0.5 and coupler √8 in line.
    gap = 9.0 - (2.0 + 0.5 + np.sqrt(8.0))
    assert caught.value.residual * mechanism.characteristic_length == pytest.approx(gap, rel=1e-4)


def test_degrees_in_the_place_of_radians_are_suspected(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.CardanError, match=r"if 50 degrees were meant, give 0\.872665"):
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": 50.0})
    with pytest.raises(cd.CardanError) as caught:
        cd.Scene(joint, drive="bearing_in", held={"joint_angle": 2.0})
    assert "degrees" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "suggestion"),
    [("bearing_inn", "did you mean 'bearing_in' or"), ("pin", "did you mean 'pin_in'")],
)
def test_similar_names_are_suggested(joint: cd.Mechanism, name: str, suggestion: str) -> None:
    with pytest.raises(cd.ModelError, match=suggestion):
        cd.Scene(joint, drive=name)


def test_names_that_resemble_nothing_bring_no_suggestion(joint: cd.Mechanism) -> None:
    with pytest.raises(cd.ModelError) as caught:
        cd.Scene(joint, drive="xyz")
    assert "did you mean" not in str(caught.value)


def test_long_lists_of_names_are_cut() -> None:
    links = "".join(link(f"l{index:02}") for index in range(15))
    joints = "".join(joint_of(index) for index in range(15))
    mechanism = cd.load(f'<robot name="wheels"><link name="ground"/>{links}{joints}</robot>')
    with pytest.raises(cd.ModelError, match=r"j00, .*, j09 and 5 more$"):
        mechanism.joint("xyz")


def joint_of(index: int) -> str:
    return joint(f"j{index:02}", "ground", f"l{index:02}")
