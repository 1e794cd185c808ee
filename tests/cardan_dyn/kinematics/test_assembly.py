"""Assembly: the way to the start of a scene, closing there, limits, and what is refused."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from testkit.linkages import rack, tilted_slider_crank
from testkit.planar_linkages import (
    COUPLER,
    CRANK,
    described,
    five_bar,
    four_bar,
    geared,
    joint,
    link,
    pin_distance,
    rocker_range,
    values,
)

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.samples import Targets

TURN = 2.0 * np.pi


def assembly_of(mechanism: cd.Mechanism, *drives: str, **options: object) -> Assembly:
    return Assembly(checked(mechanism, drive=list(drives), **options))


def closed(assembly: Assembly, positions: np.ndarray) -> np.ndarray:
    return assembly.close(assembly.guesses(Targets.of_positions(positions)), positions).x


def test_a_scene_starts_at_its_held_positions() -> None:
    mechanism = five_bar()
    assembly = assembly_of(mechanism, "A", held={"D": 0.3})
    assert values(mechanism, assembly.start, "A") == 0.0
    assert values(mechanism, assembly.start, "D") == 0.3
    state = assembly.kinematics.evaluate(assembly.start[None])
    assert state.residual[0] < 1e-12
    velocities = mechanism.coordinates.velocity_columns
    assert assembly.decided.tolist() == sorted(velocities[name].start for name in "BEC")


def test_joints_of_the_start_move_before_the_held_ones() -> None:
    """The crank turns to where it is to start; the rocker is not held and follows."""
    mechanism = four_bar()
    assembly = assembly_of(mechanism, "D", near={"A": 1.2})
    assert values(mechanism, assembly.start, "A") == pytest.approx(1.2, abs=1e-12)
    assert pin_distance(mechanism, assembly.start[None])[0] == pytest.approx(COUPLER, rel=1e-12)
    assert values(mechanism, assembly.start, "D") != 0.0


def test_a_start_beyond_a_dead_point_lies_on_its_other_side() -> None:
    """At the same position of the rocker, its crank stands differently on both sides."""
    mechanism = four_bar()
    near = assembly_of(mechanism, "D")
    far = assembly_of(mechanism, "D", near={"A": 4.0})
    positions = np.array([[0.05], [0.1]])
    cranks = [values(mechanism, closed(item, positions), "A") for item in (near, far)]
    difference = np.mod(cranks[0] - cranks[1] + np.pi, TURN) - np.pi
    assert np.min(np.abs(difference)) > 0.5
    for item in (near, far):
        np.testing.assert_allclose(
            pin_distance(mechanism, closed(item, positions)), COUPLER, rtol=1e-12
        )


def test_what_does_not_close_at_zero_is_refused() -> None:
    mechanism = described(
        *(link(name) for name in "abc"),
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.3)),
        joint("D", "ground", "c", (9.0, 0.0)),
        '<loop name="C" type="continuous"><predecessor link="b"><origin xyz="1 0.5 0"/>'
        '</predecessor><successor link="c"><origin xyz="0 0.8 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
    )
    message = "linkage: the loops cannot be closed; the least closure error found around"
    with pytest.raises(cd.AssemblyError, match=message) as caught:
        assembly_of(mechanism, "A")
    assert caught.value.position is None
    assert caught.value.nearest is None
    assert caught.value.residual > 0.1


@pytest.mark.parametrize(
    ("mechanism", "options", "value"),
    [
        (four_bar, {"near": {"D": 1.5}}, 1.5),
        # With the other crank turned away, the arms of the five-bar are too short.
        (five_bar, {"near": {"A": 1.5}, "held": {"D": -1.5}}, -1.5),
    ],
)
def test_a_joint_that_cannot_be_brought_to_its_position_is_named(
    mechanism: Callable[[], cd.Mechanism], options: dict[str, object], value: float
) -> None:
    with pytest.raises(cd.AssemblyError, match="joint 'D' cannot be brought to ") as caught:
        assembly_of(mechanism(), "A", **options)
    assert f"brought to {value:g}: " in str(caught.value)
    assert (caught.value.position, caught.value.joint) == (value, "D")
    assert "D cannot move there" in str(caught.value)
    assert 0.0 < caught.value.nearest / value < 1.0


def test_a_wrong_mobility_explains_why_a_held_joint_cannot_move() -> None:
    with pytest.raises(cd.MobilityError, match="it is locked"):
        assembly_of(four_bar(), "A", held={"D": 0.1})


def test_assembly_modes_have_names() -> None:
    mechanism = four_bar()
    assembly = assembly_of(mechanism, "A")
    modes = assembly.modes.named()
    assert list(modes) == ["A", "B"]
    np.testing.assert_allclose(modes["A"], assembly.start, atol=1e-12)
    second = assembly_of(mechanism, "A", branch="B")
    np.testing.assert_array_equal(second.start, modes["B"])
    x = closed(second, np.array([[0.0], [0.5]]))
    np.testing.assert_allclose(pin_distance(mechanism, x), COUPLER, rtol=1e-12)
    assert abs(values(mechanism, x, "D")[0]) > 0.5
    # Names are those of the description's mode, whichever mode the scene has.
    assert list(second.modes.named()) == ["A", "B"]
    with pytest.raises(cd.ArgumentError, match="branch 'C' does not exist; branches: A, B"):
        assembly_of(mechanism, "A", branch="C")


def test_loops_are_closed_at_every_sample() -> None:
    mechanism = four_bar()
    assembly = assembly_of(mechanism, "A")
    positions = np.linspace(-20.0, 30.0, 300)[:, None]
    state = assembly.close(assembly.guesses(Targets.of_positions(positions)), positions)
    np.testing.assert_allclose(pin_distance(mechanism, state.x), COUPLER, rtol=1e-13)
    np.testing.assert_array_equal(values(mechanism, state.x, "A"), positions[:, 0])
    assert np.max(state.residual) < 1e-13


def test_a_guess_that_leaves_the_branch_is_refused() -> None:
    assembly = assembly_of(four_bar(), "A")
    positions = np.array([[0.1], [0.2], [0.3]])
    guess = assembly.guesses(Targets.of_positions(positions))
    x = guess.x.copy()
    x[1:] += 0.05 * (np.arange(x.shape[1]) != 0)
    with pytest.raises(cd.AssemblyError, match=r"at drive position 0.2 \(closure error") as caught:
        assembly.close(guess._replace(x=x), positions)
    assert caught.value.position == 0.2
    assert caught.value.nearest is None


def test_a_guess_that_does_not_close_is_refused() -> None:
    mechanism = four_bar()
    assembly = assembly_of(mechanism, "D")
    guess = assembly.guesses(Targets.of_positions(np.array([[0.1], [0.2]])))
    beyond = np.array([[0.1], [rocker_range()[1] + 0.3]])
    x = guess.x.copy()
    x[:, mechanism.coordinates.columns["D"].start] = beyond[:, 0]
    with pytest.raises(cd.AssemblyError, match="cannot be closed on the branch") as caught:
        assembly.close(guess._replace(x=x), beyond)
    assert caught.value.position == beyond[1, 0]
    assert caught.value.residual > 1e-3


def test_a_dead_point_is_refused_when_it_is_closed() -> None:
    """The parallelogram with all links in line, in whichever direction it goes on."""
    mechanism = four_bar(1.0, 1.0, 2.0)
    assembly = assembly_of(mechanism, "A")
    guess = assembly.guesses(Targets.of_positions(np.array([[0.1]])))
    x = guess.x.copy()
    for name, sign in (("A", 1.0), ("B", -1.0), ("D", 1.0), ("C", 1.0)):
        x[:, mechanism.coordinates.columns[name]] = 0.5 * np.pi * sign
    flat = np.array([[0.5 * np.pi]])
    with pytest.raises(
        cd.SingularConfigurationError, match=r"1\.57079632679 is singular .* assembly modes meet"
    ) as caught:
        assembly.close(guess._replace(x=x), flat)
    assert caught.value.position == 0.5 * np.pi
    assert caught.value.condition > 1e12
    assert caught.value.joints == ()
    assert set(caught.value.moving) == set("BCD")


def test_periods() -> None:
    assert assembly_of(four_bar(), "A").period() == pytest.approx(TURN)
    assert assembly_of(geared(0.5), "A").period() == pytest.approx(2.0 * TURN)
    assert assembly_of(geared(0.3819660112501051), "A").period() is None
    slider = cd.load("slider_crank")
    assert assembly_of(slider, "piston_guide", near={"crank_bearing": 1.0}).period() is None
    arm = described(link("a"), joint("A", "ground", "a"))
    assert assembly_of(arm, "A").period() == TURN


def test_ranges_of_rotating_drives() -> None:
    assert assembly_of(four_bar(), "A").motion_range() == (-np.inf, np.inf)
    assert assembly_of(four_bar(), "D").motion_range() == pytest.approx(rocker_range(), abs=1e-9)
    # Neither repeats nor ends.
    assert assembly_of(geared(0.3819660112501051), "A").motion_range() == (-np.inf, np.inf)
    arm = described(link("a"), joint("A", "ground", "a"))
    assert assembly_of(arm, "A").motion_range() == (-np.inf, np.inf)


def test_a_range_holds_for_the_side_of_the_dead_point_where_the_scene_starts() -> None:
    low, high = assembly_of(four_bar(), "D", near={"A": 4.0}).motion_range()
    assert (low, high) == pytest.approx(rocker_range(), abs=1e-9)


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])
def test_ranges_of_sliding_drives(length: float) -> None:
    """A piston moves between the positions where crank and rod are in line."""
    mechanism = cd.load(tilted_slider_crank(length, planar=False))
    assembly = assembly_of(mechanism, "guide", near={"crank_bearing": 1.0})
    low, high = assembly.motion_range()
    # Crank 1 and rod hypot(2, 0.2), the rail 0.2 beside the crank's axis; zero is at 3 lengths.
    rod, offset = np.hypot(2.0, 0.2), 0.2
    expected = [np.sqrt((rod + side) ** 2 - offset**2) - 3.0 for side in (-1.0, 1.0)]
    assert (low / length, high / length) == pytest.approx(expected, abs=1e-8)


def test_a_rack_slides_without_end() -> None:
    assembly = assembly_of(cd.load(rack("rack", "wheel")), "b")
    assert assembly.motion_range() == (-np.inf, np.inf)
    assert assembly.period() is None


def test_outputs_decide_which_joints_are_solved() -> None:
    """A second linkage beside the first one is left out where nothing of it is wanted."""
    beside = (
        *(link(name) for name in "pqr"),
        joint("P", "ground", "p", (5.0, 0.0)),
        joint("Q", "p", "q", (0.0, CRANK)),
        joint("R", "ground", "r", (6.0, 0.0)),
        '<loop name="S" type="continuous"><predecessor link="q"><origin xyz="1 0.5 0"/>'
        '</predecessor><successor link="r"><origin xyz="0 0.8 0"/></successor>'
        '<axis xyz="0 0 1"/></loop>',
    )
    mechanism = four_bar(0.3, 0.8, 1.0, *beside)
    assembly = assembly_of(mechanism, "A", "P", outputs=["D"])
    velocities = mechanism.coordinates.velocity_columns
    assert len(assembly.groups) == 2
    assert len(assembly.needed.motion) == 1
    assert assembly.decided.tolist() == sorted(velocities[name].start for name in "BDC")
    everything = assembly_of(mechanism, "A", "P")
    expected = sorted(velocities[name].start for name in "BDCQRS")
    assert everything.decided.tolist() == expected
