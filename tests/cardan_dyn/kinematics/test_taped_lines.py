"""Lines on tapes lead where lines in general lead, or say that they do not."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import draw
from testkit.compiled_functions import without_kernel
from testkit.planar_linkages import five_bar

import cardan_dyn as cd
from cardan_dyn.core.kinematics.assembly import Assembly
from cardan_dyn.core.kinematics.following.joint_motion import JointMotion
from cardan_dyn.core.mechanics.following import Line, Place
from cardan_dyn.core.problem.arguments import checked

LEGS = [f"leg_{k}" for k in range(1, 7)]


def motion_of(mechanism: cd.Mechanism, drives: list[str], **options: object) -> JointMotion:
    problem = checked(mechanism, drive=drives, **options)
    (part,) = Assembly(problem)._guesses._parts
    assert isinstance(part, JointMotion)
    return part


def units(part: JointMotion) -> np.ndarray:
    """What counts as a radian of each drive: a slide by the length of the mechanism."""
    return 1.0 / part._kinematics.coordinates.scale[part._drive_columns]


def on_tapes(part: JointMotion, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    assert part._taped is not None
    return part._taped.ends(positions)


def in_general(part: JointMotion, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return part._on_lines(part._kinematics, positions)


def apart(part: JointMotion, x: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return `(N,)` how far coordinates differ, those of balls as rotations."""
    missed = np.abs(x - other)
    for column in part._kinematics.coordinates.balls.columns.tolist():
        ball = slice(column, column + 4)
        missed[:, ball] = np.minimum(missed[:, ball], np.abs(x + other)[:, ball])
    return np.max(missed * part._kinematics.coordinates.scale, axis=1)


@pytest.mark.parametrize(
    ("name", "drives", "options", "reach"),
    [
        ("universal_joint", ["bearing_in", "joint_angle"], {"near": {"joint_angle": 0.4}}, 1.0),
        ("double_shaft_z", ["bearing_in", "joint_angle_1", "joint_angle_2"], {}, 1.3),
        ("stewart_platform", LEGS, {}, 0.2),
    ],
)
def test_bundled_mechanisms(
    name: str, drives: list[str], options: dict[str, object], reach: float
) -> None:
    part = motion_of(cd.load(name), drives, **options)
    rng = np.random.default_rng(3)
    ahead = reach * units(part) * rng.uniform(-1.0, 1.0, (150, len(drives)))
    positions = part._start[part._drive_columns] + ahead
    x, is_there = on_tapes(part, positions)
    expected, in_reach = in_general(part, positions)
    np.testing.assert_array_equal(is_there, in_reach)
    assert np.mean(is_there) > 0.5
    np.testing.assert_array_equal(x[:, part._drive_columns], positions)
    assert apart(part, x, expected)[is_there].max() < 1e-8


@pytest.mark.parametrize("seed", range(24))
def test_random_chains(seed: int) -> None:
    """All joint types; what is held elsewhere is driven here, so that drives meet."""
    case = draw(seed)
    try:
        scene = cd.Scene(cd.load(case.chain.text), drive=[*case.drives, *case.held])
    except cd.MobilityError:
        scene = cd.Scene(cd.load(case.chain.text), drive=case.drives, held=case.held)
    rng = np.random.default_rng(seed)
    for part in scene.solver.assembly._guesses._parts:
        if not isinstance(part, JointMotion) or part._taped is None:
            continue
        columns = part._drive_columns
        ahead = units(part) * rng.uniform(-1.5, 1.5, (100, len(columns)))
        ahead *= rng.choice([0.1, 0.4, 1.0], (100, 1))
        positions = part._start[columns] + ahead
        x, is_there = on_tapes(part, positions)
        expected, in_reach = in_general(part, positions)
        assert np.mean(in_reach & ~is_there) < 0.1
        both = in_reach & is_there
        assert apart(part, x, expected)[both].max(initial=0.0) < 1e-8


def test_ways_round_singular_positions_are_those_of_the_lines() -> None:
    """At a joint angle of 90° and input angles of 0 and 180° the way on is not unique.

    Lines pass these points on either side and end with joints turned differently.
    """
    part = motion_of(cd.load("universal_joint"), ["bearing_in", "joint_angle"])
    rng = np.random.default_rng(0)
    positions = np.stack([rng.uniform(-6.0, 6.0, 600), rng.uniform(-2.9, 2.9, 600)], axis=1)
    expected, in_reach = in_general(part, positions)
    assert np.all(in_reach)
    turned = expected[:, part._columns]
    assert np.ptp(turned - turned.mean(axis=0), axis=0).max() > np.pi
    x, is_there = on_tapes(part, positions)
    assert np.mean(is_there) > 0.99
    assert apart(part, x, expected)[is_there].max() < 1e-6


@pytest.mark.slow
def test_positions_out_of_reach_are_not_there() -> None:
    """The arms of a five-bar do not meet where its pins are far apart."""
    part = motion_of(five_bar(), ["A", "D"])
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = 1.6 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    _, expected = in_general(part, circle)
    assert 20 < np.sum(~expected) < 60
    np.testing.assert_array_equal(on_tapes(part, circle)[1], expected)


def test_neighbours_and_order_change_no_bit() -> None:
    part = motion_of(cd.load("universal_joint"), ["bearing_in", "joint_angle"])
    rng = np.random.default_rng(4)
    positions = np.stack([rng.uniform(-6.0, 6.0, 333), rng.uniform(-2.0, 2.0, 333)], axis=1)
    x, is_there = on_tapes(part, positions)
    order = rng.permutation(len(positions))
    for chosen in (order, order[:70], order[:33], order[:3], order[:1]):
        found, there = on_tapes(part, positions[chosen])
        np.testing.assert_array_equal(there, is_there[chosen])
        np.testing.assert_array_equal(found[there], x[chosen][there])


@pytest.mark.slow
def test_without_compiled_functions_lines_are_the_same() -> None:
    part = motion_of(cd.load("stewart_platform"), LEGS)
    rng = np.random.default_rng(5)
    positions = part._start[part._drive_columns] + rng.uniform(-0.1, 0.1, (40, 6))
    x, is_there = on_tapes(part, positions)
    assert is_there.all()
    with without_kernel():
        other, is_there = on_tapes(part, positions)
    assert is_there.all()
    assert apart(part, x, other).max() < 1e-10


def line(start: float, end: float) -> tuple[Line, Place]:
    """Return a line of the universal joint as text on floats: turned from one angle to another."""
    part = motion_of(cd.load("universal_joint"), ["bearing_in", "joint_angle"])
    taped = part._taped
    assert taped is not None
    begin, to = np.array([[start, 0.8], [end, 0.8]])
    (x,), _ = in_general(part, begin[None, :])
    chosen = taped._orders.at(0)
    assert chosen is not None
    order = chosen.order
    columns = taped._columns
    line = Line(
        taped._tree,
        taped._roles,
        order,
        dict(zip(columns, to.tolist(), strict=True)),
        dict(zip(columns, (to - begin).tolist(), strict=True)),
        {column: float(x[column]) for column in range(len(x)) if column not in columns},
    )
    passives = {column: float(x[column]) for column in taped._passives}
    return line, line.begun(passives)


def test_errors_of_steps_grow_with_their_third_power() -> None:
    """The text itself, on floats: what is left of a step is what two derivatives neglect."""
    way, place = line(0.3, 0.9)
    errors = []
    for length in (0.2, 0.1, 0.05):
        step = way.advanced(place, 1.0, length)
        assert step.rest == 1.0 - length and step.left == step.rest
        # One step of Newton's method leaves the square of the error.
        closed, left = way._at(step.place.x, step.rest).corrected(way.tree, way.roles)
        predicted = way._predicted(place, length)
        errors.append(max(abs(predicted[c] - closed[c]) for c in predicted))
        assert left < 10.0 * errors[-1] ** 2
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 8.0, rtol=0.15)


def test_steps_end_where_lines_end_and_are_not_taken_beyond_what_predictions_know() -> None:
    way, place = line(0.3, 0.35)
    step = way.advanced(place, 1.0, 3.0)
    assert step.rest == 0.0 and step.left == 0.0
    again = way.advanced(step.place, step.rest, step.length)
    assert again.place == step.place and again.rest == 0.0
    far, place = line(0.1, 40.0)
    step = far.advanced(place, 1.0, 1.0)
    # A radian at most by each derivative.
    fastest, most_bent = (max(map(abs, values.values())) for values in place[1:3])
    assert step.length <= min(1.0 / fastest, (2.0 / most_bent) ** 0.5) * 2.0
    wrong = place._replace(sides=[-side for side in place.sides])
    stays = far.advanced(wrong, 1.0, 1e-3)
    assert stays.rest == 1.0 and stays.length < 1e-3 and stays.place.x == place.x
    lost = far.advanced(place._replace(x=dict.fromkeys(place.x, np.nan)), 1.0, 1e-3)
    assert lost.rest == 1.0
