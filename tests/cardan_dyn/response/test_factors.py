"""Factors of operating points: arguments of an evaluation, and what they make of the columns."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.dynamics.problem_solver import ProblemSolver
from cardan_dyn.core.problem.acting import Acting
from cardan_dyn.core.response.columns import ACCELERATION, GRAVITY, SPEED_SQUARED, Acts, Column
from cardan_dyn.core.response.operating_points import checked_acting, column_factors

POSITIONS = np.linspace(-3.0, 9.0, 40)
LOAD = Column(Acts.JOINT_LOAD, "bearing_out")
PUSH = Column(Acts.LINK_LOAD, "shaft_out")


@pytest.fixture(scope="module")
def response(joint: cd.Mechanism) -> cd.Response:
    return universal(joint, 0.5).response()


@pytest.fixture(scope="module")
def built(joint: cd.Mechanism) -> tuple[ProblemSolver, tuple[Column, ...]]:
    """A response with a column of every kind."""
    scene = cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.4},
        loads={"bearing_out": -2.0, "shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0))},
        gravity=(0.0, 0.0, -9.81),
    )
    response = scene.response(1e-6)
    return response.solver, response._data[0].layout.columns


def operation(solver: ProblemSolver, **changes: object) -> Acting:
    arguments = {"speed": 0.0, "acceleration": 0.0, "loads": None, "gravity": None, **changes}
    return checked_acting(solver.problem, **arguments)


def test_the_scene_gives_what_is_not_given(built: tuple[ProblemSolver, tuple[Column, ...]]) -> None:
    result = operation(built[0])
    assert list(result.joint_loads) == ["bearing_out"]
    assert result.joint_loads["bearing_out"] == -2.0
    np.testing.assert_array_equal(result.gravity, [0.0, 0.0, -9.81])
    replaced = operation(built[0], loads={"bearing_out": [1.0, 2.0]}, gravity=np.ones((4, 3)))
    np.testing.assert_array_equal(replaced.joint_loads["bearing_out"], [1.0, 2.0])
    assert replaced.gravity.shape == (4, 3)
    # An effort at another joint is added to those of the scene.
    added = operation(built[0], loads={"pin_in": 3.0})
    assert sorted(added.joint_loads) == ["bearing_out", "pin_in"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": np.nan}, "speed is not finite"),
        ({"speed": []}, "speed is empty"),
        ({"acceleration": "fast"}, "acceleration is not an array of real numbers"),
        ({"gravity": 9.81}, r"gravity has shape \(\), expected \(\.\.\., 3\)"),
        ({"gravity": np.zeros((3, 2))}, r"gravity has shape \(3, 2\), expected \(\.\.\., 3\)"),
        ({"gravity": np.zeros((0, 3))}, r"gravity has shape \(0, 3\), expected"),
        ({"loads": 3.0}, "loads is 3.0, expected a mapping of names to values"),
        ({"loads": {"bearing_out": []}}, r"loads\['bearing_out'\] is empty"),
        ({"loads": {"bearing_out": np.inf}}, r"loads\['bearing_out'\] is not finite"),
        (
            {"loads": {"nothing": 1.0}},
            r"loads\['nothing'\]: no joint has this name; the response has loads on: bearing_out",
        ),
        ({"loads": {"shaft_out": 1.0}}, r"loads\['shaft_out'\]: 'shaft_out' is a link"),
        ({"loads": {"cross": 1.0}}, r"loads\['cross'\]: 'cross' is a link"),
    ],
)
def test_what_is_no_operating_point_is_refused(
    built: tuple[ProblemSolver, tuple[Column, ...]], changes: dict[str, object], message: str
) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        operation(built[0], **changes)


def test_factors_of_every_kind_of_column(built: tuple[ProblemSolver, tuple[Column, ...]]) -> None:
    solver, columns = built
    gravity = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    given = operation(
        solver,
        speed=[[3.0], [-4.0]],
        acceleration=5.0,
        loads={"bearing_out": [7.0, 8.0]},
        gravity=gravity,
    )
    factors = dict(column_factors(solver, columns, given, 1.0))
    # In the order of the layout, so that sums are always rounded in the same way.
    assert tuple(factors) == columns
    expected = {
        SPEED_SQUARED: [[9.0], [16.0]],
        ACCELERATION: 5.0,
        LOAD: [7.0, 8.0],
        PUSH: 1.0,
        GRAVITY[0]: [1.0, 4.0],
        GRAVITY[1]: [2.0, 5.0],
        GRAVITY[2]: [3.0, 6.0],
    }
    assert set(factors) == set(expected)
    for column, value in expected.items():
        np.testing.assert_array_equal(factors[column], value)


def test_columns_that_do_not_act_are_left_out(
    built: tuple[ProblemSolver, tuple[Column, ...]],
) -> None:
    solver, columns = built
    given = operation(solver, loads={"bearing_out": 0.0}, gravity=[[0.0, 0.0, 0.0]] * 2)
    assert list(dict(column_factors(solver, columns, given, 1.0))) == [PUSH]
    given = operation(solver, loads={"bearing_out": [0.0, 1.0]}, speed=[0.0, 2.0])
    assert list(dict(column_factors(solver, columns, given, 1.0))) == [
        SPEED_SQUARED,
        LOAD,
        PUSH,
        GRAVITY[2],
    ]


def test_what_acts_without_a_column_is_named(response: cd.Response) -> None:
    message = (
        "the response has no columns for gravity x, pin_in, only for acceleration, bearing_out, "
        "speed²; give the scene such loads or a gravity"
    )
    with pytest.raises(cd.ArgumentError, match=message):
        response.sweep(0.0, loads={"pin_in": 1.0}, gravity=(1.0, 0.0, 0.0))


def test_without_masses_speed_and_gravity_do_nothing() -> None:
    urdf = """<robot name="massless"><link name="ground"/><link name="wheel"/>
      <joint name="a" type="continuous"><parent link="ground"/><child link="wheel"/>
      <axis xyz="0 0 1"/></joint></robot>"""
    scene = cd.Scene(cd.load(urdf), drive="a", loads={"a": 2.0})
    response = scene.response()
    sweep = response.sweep(0.0, 3.0, 4.0, gravity=(0.0, 0.0, -9.81))
    np.testing.assert_allclose(sweep.drive_effort, [-2.0])
    assert not np.any(sweep["a"].force)


@pytest.mark.parametrize(
    ("changes", "label"),
    [
        ({"speed": 1e200}, "speed²"),
        ({"speed": 1e153}, "speed²"),
        ({"acceleration": -1e306}, "acceleration"),
        ({"loads": {"bearing_out": [1.0, 1e306]}}, "bearing_out"),
        ({"gravity": (0.0, 1e306, 0.0)}, "gravity y"),
    ],
)
def test_wrenches_that_overflow_are_refused(
    built: tuple[ProblemSolver, tuple[Column, ...]], changes: dict[str, object], label: str
) -> None:
    """Functions of at most 100 in six columns allow factors below 3e305."""
    given = operation(built[0], **changes)
    with pytest.raises(cd.ArgumentError, match=f"{label} is so great that wrenches overflow"):
        column_factors(*built, given, 100.0)


def test_great_factors_that_do_not_overflow_are_allowed(
    built: tuple[ProblemSolver, tuple[Column, ...]],
) -> None:
    given = operation(built[0], acceleration=0.9e298)
    assert dict(column_factors(*built, given, 100.0))[ACCELERATION] == 0.9e298


def test_a_load_never_acts_as_a_column_of_its_name(response: cd.Response) -> None:
    for name in ("acceleration", "speed²", "gravity x", "nowhere", ""):
        with pytest.raises(cd.ArgumentError, match="no joint has this name"):
            response.sweep(POSITIONS, loads={name: 7.0})


def test_wrenches_on_links_are_not_replaced_and_the_message_says_so(joint: cd.Mechanism) -> None:
    push = {"shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0))}
    response = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.4}, loads=push).response()
    for value in (7.0, cd.Wrench(force=(1.0, 0.0, 0.0)), np.ones(6)):
        with pytest.raises(cd.ArgumentError, match="'shaft_out' is a link; a response keeps"):
            response.sweep(POSITIONS, loads={"shaft_out": value})
    with pytest.raises(cd.ArgumentError, match="'cross' is a link; a response keeps"):
        response.sweep(POSITIONS, loads={"cross": 7.0})
