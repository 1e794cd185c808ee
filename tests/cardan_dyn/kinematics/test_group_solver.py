"""Group solver: Newton's method against closed forms, and its linear algebra against NumPy's."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.groups import guesses, loop_named, only_group, state_of
from testkit.linkages import LIMIT, carriage, rack
from testkit.planar_linkages import (
    COUPLER,
    described,
    four_bar,
    geared,
    joint,
    link,
    pin_distance,
    solver,
    values,
)

import cardan_dyn as cd

ANGLES = np.linspace(-0.6, 0.6, 7)


def test_newton_closes_a_four_bar_in_the_mode_of_the_guess() -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    x = guesses(mechanism, "A", ANGLES)
    state = item.newton(x, reduction)
    np.testing.assert_allclose(pin_distance(mechanism, x), COUPLER, rtol=1e-14)
    np.testing.assert_array_equal(values(mechanism, x, "A"), ANGLES)
    # The loop's own angle is that of the rocker relative to the coupler.
    a, b, c, d = (values(mechanism, x, name) for name in "ABCD")
    np.testing.assert_allclose(a + b + c, d, atol=1e-14)
    assert np.max(state.residual) < 1e-14
    # The correction is the sum of all steps: at least the displacement of any passive.
    displacement = np.max(np.abs(x - guesses(mechanism, "A", ANGLES)), axis=1)
    assert np.all(state.correction >= displacement - 1e-15)
    assert state.correction[3] < 1e-14


def test_the_number_of_newton_steps_is_limited() -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    residuals = []
    for most in range(4):
        x = guesses(mechanism, "A", np.array([0.3]))
        residuals.append(float(item.newton(x, reduction, most=most).residual[0]))
    assert residuals[0] > residuals[1] > residuals[2] > residuals[3]


def test_samples_come_out_alike_whatever_others_are_beside_them() -> None:
    """Few that need more steps than others are worked on by themselves."""
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    closed = guesses(mechanism, "A", np.linspace(-0.6, 0.6, 40))
    item.newton(closed, reduction)
    column = mechanism.coordinates.columns["B"].start
    for some in ([3, 17, 18], list(range(20))):
        x = closed.copy()
        x[some, column] += 1e-3
        alone = x[some]
        state = item.newton(x, reduction)
        assert np.all(state.correction[some] > 9e-4)
        of_them = item.newton(alone, reduction)
        np.testing.assert_array_equal(x[some], alone)
        np.testing.assert_array_equal(state.residual[some], of_them.residual)


def test_long_steps_are_shortened_to_half_a_radian() -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    x = guesses(mechanism, "A", np.array([2.0, 0.1]))
    before = x.copy()
    full = x.copy()
    at = item.evaluate(x, reduction)
    step = at.step(at.error)
    item._moves.apply(full, step)
    assert np.max(np.abs(full - before)[0]) > 0.5
    state = item.newton(x, reduction, most=1)
    steps = np.max(np.abs(x - before), axis=1)
    assert steps[0] == pytest.approx(0.5, rel=1e-12)
    # In its direction the step is the full one; what counts as correction is its full size.
    np.testing.assert_allclose(
        (x - before)[0], (full - before)[0] * 0.5 / np.max(np.abs(full - before)[0]), rtol=1e-9
    )
    assert state.correction[0] == pytest.approx(np.max(np.abs(full - before)[0]), rel=1e-12)
    np.testing.assert_allclose(state.correction, np.max(np.abs(step), axis=1), rtol=1e-12)


def test_samples_take_their_steps_whatever_others_are_beside_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    x, counted, evaluate = guesses(mechanism, "A", ANGLES), [], item.evaluate
    monkeypatch.setattr(
        item, "evaluate", lambda x, *rest: counted.append(len(x)) or evaluate(x, *rest)
    )
    together = x.copy()
    state = item.newton(together, reduction)
    # The middle guess is exact; those on both sides need the fewer steps the nearer they are.
    assert counted[0] == len(x)
    assert len(counted) <= 8
    assert counted[-1] < len(x)
    for k in range(len(x)):
        # Two of a kind, since NumPy adds up products of a single sample in another order.
        alone = x[[k, k]]
        own = item.newton(alone, reduction)
        np.testing.assert_array_equal(alone[0], together[k])
        np.testing.assert_array_equal(own.inverse[0], state.inverse[k])


def test_open_loops_of_too_few_joints_are_not_taken_for_closed() -> None:
    """Steps towards the least error end; only the error that is left says that loops are open."""
    mechanism = cd.load("universal_joint")
    with pytest.raises(cd.MobilityError) as caught:
        cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": 0.4, "bearing_out": 0.5})
    assert caught.value.surplus == ["bearing_out"]


@pytest.mark.filterwarnings("ignore:invalid value")
def test_what_is_not_finite_ends_the_iteration() -> None:
    mechanism = four_bar()
    item, reduction, _ = only_group(mechanism, "A")
    x = guesses(mechanism, "A", np.array([0.1]))
    x[0, mechanism.coordinates.columns["B"].start] = np.inf
    state = item.newton(x, reduction)
    assert not state.residual[0] < 1.0


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_conditions_count_slides_in_lengths(length: float) -> None:
    """Lengths of a slider-crank in another unit change nothing but the rows of the slide."""
    mechanism = cd.load(scaled_slider_crank(length))
    state = state_of(mechanism, "a", ANGLES)
    expected = state_of(cd.load(scaled_slider_crank(1.0)), "a", ANGLES)
    np.testing.assert_allclose(state.condition, expected.condition, rtol=1e-9)
    np.testing.assert_allclose(state.scaled_rows, expected.scaled_rows, atol=1e-12)
    np.testing.assert_allclose(state.all_scaled_rows, expected.all_scaled_rows, atol=1e-12)
    np.testing.assert_allclose(state.correction, expected.correction, rtol=1e-9, atol=1e-14)
    assert state.all_scaled_rows.shape == (len(ANGLES), 4, 3)
    slide = state.group.passives.tolist().index(mechanism.coordinates.velocity_columns["d"].start)
    scale = np.ones((3, 1))
    scale[slide] = mechanism.characteristic_length
    np.testing.assert_allclose(state.scaled_rows, state.passive_rows * scale, rtol=1e-15)


def scaled_slider_crank(length: float) -> str:
    """A slider-crank whose slide d is passive; joint a is its crank."""
    reach = length * float(np.sqrt(1.0 - 0.09))
    return f"""<robot name="slider_crank"><link name="ground"/><link name="crank"/>
      <link name="rod"/><link name="slider"/>
      <joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
        <axis xyz="0 0 1"/></joint>
      <joint name="b" type="continuous"><parent link="crank"/><child link="rod"/>
        <origin xyz="0 {0.3 * length!r} 0"/><axis xyz="0 0 1"/></joint>
      <joint name="d" type="prismatic"><parent link="ground"/><child link="slider"/>
        <origin xyz="{reach!r} 0 0"/><axis xyz="1 0 0"/>{LIMIT}</joint>
      <loop name="c" type="continuous"><predecessor link="rod">
        <origin xyz="{reach!r} {-0.3 * length!r} 0"/></predecessor><successor link="slider"/>
        <axis xyz="0 0 1"/></loop></robot>"""


def test_a_driven_slide_is_scaled_among_what_is_known() -> None:
    mechanism = cd.load(scaled_slider_crank(100.0))
    state = state_of(mechanism, "d", np.array([0.0, 1.0]))
    assert np.max(state.residual) < 1e-14
    assert state.solver.row_scale is None
    length = mechanism.characteristic_length
    known = state.rows[:, :1, : state.error.shape[1]]
    np.testing.assert_allclose(state.all_scaled_rows[:, :1], length * known, rtol=1e-15)
    np.testing.assert_array_equal(state.all_scaled_rows[:, 1:], state.passive_rows)
    assert np.shares_memory(state.scaled_rows, state.rows)


def test_couplings_are_closed_with_whole_turns() -> None:
    mechanism = geared(-2.5)
    item, reduction, start = only_group(mechanism, "A")
    layout = mechanism.coordinates
    a, b = (layout.columns[name].start for name in "AB")
    x = np.repeat(start[None], 2, axis=0)
    x[:, a] = 0.2
    turns = np.zeros_like(x)
    turns[1, [a, b]] = [2.0, -4.0]
    x[1, b] = -6.5
    state = item.newton(x, reduction, turns)
    np.testing.assert_allclose(x[:, b], [-0.5, -0.5 - 2.0 * np.pi], rtol=1e-13)
    assert np.max(state.residual) < 1e-14
    np.testing.assert_allclose(state.rates(np.ones((2, 1, 1))), -2.5, rtol=1e-15)
    x[:, b] += [0.1, -0.3]
    slipped = item.evaluate(x, reduction, turns)
    np.testing.assert_allclose(slipped.residual, [0.1, 0.3], rtol=1e-12)
    np.testing.assert_allclose(slipped.error[:, 0], [-0.1, 0.3], rtol=1e-12)


def test_slips_of_a_slide_count_in_lengths() -> None:
    mechanism = cd.load(rack("wheel", "rack"))
    item, reduction, x = only_group(mechanism, "a")
    x[mechanism.coordinates.columns["b"].start] = 0.5
    state = item.evaluate(x[None], reduction)
    length = mechanism.characteristic_length
    assert length != 1.0
    np.testing.assert_allclose(state.error, [[-0.5 / length]], rtol=1e-15)
    assert state.residual[0] == pytest.approx(0.5 / length)


def test_open_reductions_hold_for_the_resting_joints_where_they_are() -> None:
    """Where a held hinge tilts one half of a planar linkage, it is planar no more."""
    tilt = (
        '<link name="t"/><joint name="T" type="continuous"><parent link="ground"/>'
        '<child link="t"/><origin xyz="1.0 0 0"/><axis xyz="1 0 0"/></joint>'
    )
    parts = [
        joint("A", "ground", "a"),
        joint("B", "a", "b", (0.0, 0.3)),
        joint("D", "t", "c", (0.0, 0.0)),
    ]
    mechanism = described(
        *(link(name) for name in "abc"),
        tilt,
        *parts,
        loop_named("C", "b", "c", (1.0, 0.5), (0.0, 0.8)),
    )
    kinematics, x = solver(mechanism, "A", held=("T",))
    (item,) = kinematics.solvers
    assert item.open_reduction(x).rows[0].shape == (6, 3)
    x[mechanism.coordinates.columns["T"]] = 0.4
    # The tilted axis adds one motion to the three of the plane.
    assert item.open_reduction(x).rows[0].shape == (6, 4)


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e12])
def test_open_reductions_move_slides_by_lengths(length: float) -> None:
    """The arm closes with a wheel about the same line, from which the carriage takes it away."""
    wheel = '<link name="wheel"/><joint name="w" type="continuous"><parent link="ground"/>'
    wheel += '<child link="wheel"/><axis xyz="0 1 0"/></joint></robot>'
    text = carriage(length).replace('<successor link="ground">', '<successor link="wheel">')
    item, _, start = only_group(cd.load(text.replace("</robot>", wheel)), "s")
    assert item.open_reduction(start).rows[0].shape == (6, 3)


@pytest.mark.parametrize("length", [1e-12, 1.0, 1e12])
def test_open_reductions_are_seen_from_behind_a_slide(length: float) -> None:
    """In the axes of the carriage its slide and its hinge stay where they are."""
    item, _, start = only_group(cd.load(carriage(length)), "s")
    reduction = item.open_reduction(start)
    assert reduction.rows[0].shape == (6, 2)
    assert item.group.bodies[reduction.axes[0].body] == cd.load(carriage(length))["s"].id - 1


def test_a_group_without_passives_stays_as_it_is() -> None:
    mechanism = described(link("a"), joint("A", "ground", "a"))
    item, reduction, _ = only_group(mechanism, "A")
    x = guesses(mechanism, "A", ANGLES)
    state = item.newton(x, reduction)
    np.testing.assert_array_equal(x, guesses(mechanism, "A", ANGLES))
    assert not np.any(state.residual)
