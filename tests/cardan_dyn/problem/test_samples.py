"""Arguments of any shapes as samples: what broadcasts with what, in which order, and what not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from testkit.compound_joints import crank_and_slider
from testkit.exploding import ExplodingMapping
from testkit.scenes import double, universal

import cardan_dyn as cd
from cardan_dyn.core.problem import samples
from cardan_dyn.core.problem.problem import Problem
from cardan_dyn.core.problem.samples import Acting, Targets, acting_on, targets_of
from cardan_dyn.kit.frozen import frozen

ANGLES = {"joint_angle_1": 0.5, "joint_angle_2": 0.4}


@pytest.fixture(scope="module")
def one(shaft: cd.Mechanism) -> Problem:
    """One drive, two held joints, a load at a joint, none on links, no gravity."""
    return double(shaft, 0.5, 0.4).problem


@pytest.fixture(scope="module")
def two(joint: cd.Mechanism) -> Problem:
    """Two drives."""
    return cd.Scene(joint, drive=["bearing_in", "joint_angle"]).problem


def problem(drives: int, one: Problem, two: Problem) -> Problem:
    return one if drives == 1 else two


EVERY_SHAPE = [
    (2.0, 1, (), [2.0]),
    (2.0, 2, (), [2.0, 2.0]),
    ([1.0, 2.0], 1, (2,), [[1.0], [2.0]]),
    ([1.0, 2.0], 2, (), [1.0, 2.0]),
    ([[1.0, 2.0], [3.0, 4.0]], 2, (2,), [[1.0, 2.0], [3.0, 4.0]]),
    ([[1.0], [2.0]], 1, (2, 1), [[[1.0]], [[2.0]]]),
    ([[1.0, 2.0]], 1, (1, 2), [[[1.0], [2.0]]]),
    ([1.0], 1, (1,), [[1.0]]),
    (np.zeros((3, 1, 2)), 2, (3, 1), np.zeros((3, 1, 2)).tolist()),
]
"""Values, for how many drives, of samples of what shape, and a column for each drive."""


@pytest.mark.parametrize(("value", "drives", "shape", "expected"), EVERY_SHAPE)
def test_rates_of_every_shape(
    value: object,
    drives: int,
    shape: tuple[int, ...],
    expected: list[object],
    one: Problem,
    two: Problem,
) -> None:
    acting = acting_on(problem(drives, one, two), value, value)
    for name in ("speed", "acceleration"):
        assert acting.shapes[name] == shape
    assert acting.speeds.tolist() == acting.accelerations.tolist() == expected


@pytest.mark.parametrize(("value", "drives", "shape", "expected"), EVERY_SHAPE)
def test_positions_of_every_shape(
    value: object,
    drives: int,
    shape: tuple[int, ...],
    expected: list[object],
    one: Problem,
    two: Problem,
) -> None:
    """A single position is one sample; of several drives, the last axis counts them."""
    targets = targets_of(problem(drives, one, two), value)
    assert targets.shape == (shape or (1,))
    np.testing.assert_array_equal(targets.positions, np.reshape(expected, (-1, drives)))
    assert targets.size == len(targets.positions) == np.prod(targets.shape)
    assert targets.varied == ()
    assert np.shares_memory(targets.prescribed, targets.positions)


@pytest.mark.parametrize(
    ("value", "drives", "message"),
    [
        ([], 1, "is empty"),
        (np.zeros((0, 2)), 2, "is empty"),
        (np.zeros((2, 0)), 2, "is empty"),
        ([1.0, 2.0, 3.0], 2, r"has shape \(3,\), expected a number or \(\.\.\., 2\), a column .*"),
        (np.zeros((2, 3)), 2, r"has shape \(2, 3\), expected a number or \(\.\.\., 2\), a col.*"),
        ([[1.0], [2.0]], 2, r"has shape \(2, 1\), expected a number or \(\.\.\., 2\), a col.*"),
        (["a"], 1, r"is not an array of real numbers \(.*\)"),
        (None, 1, r"is not an array of real numbers \(it is None\)"),
        (np.nan, 1, "is not finite"),
        ([0.0, np.inf], 1, r"is not finite at index \[1\]"),
        ([[0.0, 1.0], [-np.inf, np.nan]], 2, r"is not finite at index \[1, 0\]"),
    ],
)
def test_values_of_drives_that_are_none(
    value: object, drives: int, message: str, one: Problem, two: Problem
) -> None:
    asked = problem(drives, one, two)
    with pytest.raises(cd.ArgumentError, match=f"^position {message}$"):
        targets_of(asked, value)
    with pytest.raises(cd.ArgumentError, match=f"^speed {message}$"):
        acting_on(asked, speed=value)
    with pytest.raises(cd.ArgumentError, match=f"^acceleration {message}$"):
        acting_on(asked, acceleration=value)


# What is held at other positions


@pytest.mark.parametrize(
    ("position", "first", "second", "shape"),
    [
        ((), (), (), (1,)),
        ((4,), (), (), (4,)),
        ((4,), (4,), (), (4,)),
        ((), (4,), (), (4,)),
        ((4,), (3, 1), (), (3, 4)),
        ((4,), (3, 1), (3, 1), (3, 4)),
        ((4,), (3, 1, 1), (2, 1), (3, 2, 4)),
        ((2, 1, 4), (3, 1), (2, 3, 4), (2, 3, 4)),
        ((4, 1), (3,), (), (4, 3)),
        ((1, 4), (3, 1), (), (3, 4)),
    ],
)
def test_positions_and_held_positions_span_one_shape(
    one: Problem,
    position: tuple[int, ...],
    first: tuple[int, ...],
    second: tuple[int, ...],
    shape: tuple[int, ...],
) -> None:
    """Samples are counted in C order, with the row of its design for each."""
    rng = np.random.default_rng(0)
    driven, of_first, of_second = (rng.uniform(size=size) for size in (position, first, second))
    held = {"joint_angle_2": of_second, "joint_angle_1": of_first}
    targets = targets_of(one, driven, held)
    assert targets.shape == shape
    # In the order of the scene, and as they were given.
    assert targets.varied == ("joint_angle_1", "joint_angle_2")
    for name, values in held.items():
        np.testing.assert_array_equal(targets.held[name], values)
    # No more designs than the held positions span.
    assert len(targets.designs) == np.prod(np.broadcast_shapes(first, second))
    expected = [np.broadcast_to(values, shape).ravel() for values in (driven, of_first, of_second)]
    np.testing.assert_array_equal(targets.prescribed, np.stack(expected, axis=1))
    np.testing.assert_array_equal(targets.positions, expected[0][:, None])
    designs = targets.designs[targets.design_of]
    np.testing.assert_array_equal(designs, np.stack(expected[1:], axis=1))


def test_designs_of_several_drives() -> None:
    shaft = cd.load("double_shaft_z")
    scene = cd.Scene(shaft, drive=["bearing_in", "joint_angle_1"], held={"joint_angle_2": 0.4})
    positions = np.random.default_rng(0).uniform(size=(4, 2))
    targets = targets_of(scene.problem, positions, {"joint_angle_2": np.arange(3.0)[:, None]})
    assert targets.shape == (3, 4)
    np.testing.assert_array_equal(targets.positions, np.tile(positions, (3, 1)))
    np.testing.assert_array_equal(targets.designs, [[0.0], [1.0], [2.0]])
    np.testing.assert_array_equal(targets.design_of, np.repeat([0, 1, 2], 4))
    np.testing.assert_array_equal(targets.prescribed[:, 2], np.repeat([0.0, 1.0, 2.0], 4))


def test_only_what_differs_from_the_scene_is_varied(one: Problem) -> None:
    same = targets_of(one, [0.1, 0.2], {"joint_angle_1": 0.5, "joint_angle_2": [0.4, 0.4]})
    assert same.varied == ()
    assert same.shape == (2,)
    assert same.designs.shape == (1, 0)
    some = targets_of(one, [0.1, 0.2], {"joint_angle_1": 0.5, "joint_angle_2": [0.4, 0.3]})
    assert some.varied == ("joint_angle_2",)
    for nothing in (None, {}):
        assert targets_of(one, [0.1], nothing).varied == ()


@pytest.mark.parametrize("angle", [0.3, 0.5])
def test_the_shape_does_not_depend_on_values(one: Problem, angle: float) -> None:
    """Also held positions that are those of the scene have the axes that they were given."""
    held = {"joint_angle_1": np.full((3, 1), angle)}
    assert targets_of(one, np.zeros(4), held).shape == (3, 4)


@pytest.mark.parametrize(
    ("held", "shape"),
    [
        ({}, (4, 1)),
        ({"joint_angle_1": 0.3}, (4, 1)),
        ({"joint_angle_1": np.full((4, 1), 0.3)}, (4, 1)),
        ({"joint_angle_1": [0.3, 0.2]}, (4, 2)),
        ({"joint_angle_1": np.full((4, 2), 0.3)}, (4, 2)),
    ],
)
def test_columns_of_one_drive_stay_as_they_are(
    one: Problem, held: dict[str, object], shape: tuple[int, ...]
) -> None:
    column = np.arange(4.0)[:, None]
    targets = targets_of(one, column, held)
    assert targets.shape == shape
    expected = np.repeat(column, np.prod(shape) // 4, axis=0)
    np.testing.assert_array_equal(targets.positions, expected)
    assert targets.prescribed.shape == (np.prod(shape), 1 + len(targets.varied))


def test_columns_of_several_drives_stay_as_they_are(two: Problem) -> None:
    assert targets_of(two, np.zeros((4, 1, 2))).shape == (4, 1)


def test_targets_of_positions_alone() -> None:
    positions = np.arange(12.0).reshape(6, 2)
    targets = Targets.of_positions(positions)
    assert targets.shape == (6,)
    assert np.shares_memory(targets.prescribed, positions)
    np.testing.assert_array_equal(targets.design_of, np.zeros(6))
    assert Targets.of_positions(positions, (2, 3)).shape == (2, 3)


def test_targets_of_some_samples(one: Problem) -> None:
    targets = targets_of(one, np.arange(4.0), {"joint_angle_1": np.arange(3.0)[:, None]})
    some = targets.of_samples(np.array([0, 5, 11]))
    assert some.shape == (3,)
    assert some.size == 3
    np.testing.assert_array_equal(some.prescribed, targets.prescribed[[0, 5, 11]])
    np.testing.assert_array_equal(some.prescribed, [[0.0, 0.0], [1.0, 1.0], [3.0, 2.0]])


@pytest.mark.parametrize("shape", [(3, 4), (2, 3, 4)])
def test_blocks_of_targets_are_those_of_all(one: Problem, shape: tuple[int, ...]) -> None:
    targets = targets_of(one, np.arange(4.0), {"joint_angle_1": np.arange(3.0)[:, None]})
    targets = targets.expanded(shape)
    chosen = targets.of_samples(np.arange(targets.size)[::-1])
    for whole in (targets, chosen, targets_of(one, np.arange(12.0))):
        for span in (slice(0, 5), slice(5, 12), slice(0, whole.size)):
            block = whole.block(span)
            assert block.size == span.stop - span.start
            np.testing.assert_array_equal(block.positions, whole.positions[span])
            np.testing.assert_array_equal(block.prescribed, whole.prescribed[span])


def test_targets_at_other_positions(one: Problem) -> None:
    targets = targets_of(one, np.arange(4.0), {"joint_angle_1": np.arange(3.0)[:, None]})
    moved = targets.at(np.arange(12.0)[:, None])
    np.testing.assert_array_equal(moved.positions[:, 0], np.arange(12.0))
    np.testing.assert_array_equal(moved.prescribed[:, 1], targets.prescribed[:, 1])


@pytest.mark.parametrize("shape", [(3, 4), (2, 3, 4), (5, 1, 3, 4)])
def test_targets_are_repeated_where_other_arguments_have_more_axes(
    one: Problem, shape: tuple[int, ...]
) -> None:
    targets = targets_of(one, np.arange(4.0), {"joint_angle_1": np.arange(3.0)[:, None]})
    expanded = targets.expanded(shape)
    assert expanded.shape == shape
    times = int(np.prod(shape)) // 12
    np.testing.assert_array_equal(expanded.prescribed, np.tile(targets.prescribed, (times, 1)))
    # No design is solved twice for that.
    np.testing.assert_array_equal(expanded.designs, targets.designs)
    assert targets.expanded(targets.shape) is targets


def test_targets_are_repeated_along_inner_axes_in_c_order(one: Problem) -> None:
    targets = targets_of(one, np.arange(3.0)[:, None])
    assert targets.shape == (3, 1)
    expanded = targets.expanded((3, 2))
    np.testing.assert_array_equal(expanded.positions[:, 0], [0.0, 0.0, 1.0, 1.0, 2.0, 2.0])


@pytest.mark.parametrize(
    ("held", "error", "message"),
    [
        (3, cd.ArgumentError, "held is 3, expected a mapping of names to values"),
        ({"lever": 0.1}, cd.ModelError, "no joint 'lever'; joints: "),
        ({3: 0.1}, cd.CardanError, "3"),
        (
            {"bearing_out": 0.1},
            cd.ArgumentError,
            r"^held\['bearing_out'\]: the scene does not hold this joint; "
            "held: joint_angle_1, joint_angle_2.*Hold it in the scene, at any position near these",
        ),
        ({"bearing_in": 0.1}, cd.ArgumentError, "the scene does not hold this joint"),
        ({"joint_angle_1": []}, cd.ArgumentError, r"^held\['joint_angle_1'\] is empty$"),
        ({"joint_angle_1": np.zeros((0, 3))}, cd.ArgumentError, "is empty"),
        (
            {"joint_angle_1": [[0.1], [np.nan]]},
            cd.ArgumentError,
            r"^held\['joint_angle_1'\] is not finite at index \[1, 0\]$",
        ),
        ({"joint_angle_1": None}, cd.ArgumentError, r"not an array of real numbers \(it is None\)"),
        (
            {"joint_angle_2": [0.1, -7000.0, 6500.0]},
            cd.ArgumentError,
            r"^held\['joint_angle_2'\] is -7000 rad, 1.11e\+03 turns; positions count whole turns,"
            " 1000 at most",
        ),
        ({"joint_angle_1": [0.1, 0.2]}, cd.ArgumentError, r"position \(3,\), held\['joint_angle_1"),
    ],
)
def test_held_positions_that_are_none(
    one: Problem, held: object, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        targets_of(one, np.zeros(3), held)


def test_held_slides_too_far_away() -> None:
    crank = cd.load("slider_crank")
    scene = cd.Scene(crank, drive="crank_bearing")
    held = replace(scene.problem, held=frozen({"piston_guide": 0.0}))
    with pytest.raises(
        cd.ArgumentError, match=r"^held\['piston_guide'\] is -100000 m; joints slide"
    ):
        targets_of(held, 0.0, {"piston_guide": [0.0, -1e5]})


def test_mappings_that_cannot_be_read(one: Problem) -> None:
    for read in (
        lambda item: targets_of(one, 0.0, item),
        lambda item: acting_on(one, loads=item),
        lambda item: acting_on(one, inertia=item),
    ):
        with pytest.raises(cd.ArgumentError):
            read(ExplodingMapping(bearing_out=1.0))


# What acts


def test_what_acts_is_that_of_the_scene_unless_given(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.5, gravity=(0.0, 1.0, 2.0)).replace(loads={"cross": [1.0] * 6})
    acting = acting_on(scene.problem)
    assert acting.speeds.tolist() == acting.accelerations.tolist() == [0.0]
    assert acting.gravity.tolist() == [0.0, 1.0, 2.0]
    assert list(acting.joint_loads) == ["bearing_out"]
    assert acting.joint_loads["bearing_out"] == -1.0
    assert list(acting.link_loads) == ["cross"]
    assert acting.inertia == {}
    loads = {"pin_in": [1.0, 2.0], "cross": cd.Wrench(np.ones((2, 3)), frame="world")}
    acting = acting_on(scene.problem, 0.0, 0.0, loads, [[3.0, 0.0, 0.0]], {"shaft_in": 2})
    assert acting.gravity.tolist() == [[3.0, 0.0, 0.0]]
    assert acting.joint_loads["bearing_out"] == -1.0
    assert acting.joint_loads["pin_in"].tolist() == [1.0, 2.0]
    assert acting.link_loads["cross"].in_world
    np.testing.assert_array_equal(acting.link_loads["cross"].force, np.ones((2, 3)))
    np.testing.assert_array_equal(acting.link_loads["cross"].moment, np.zeros(3))
    assert acting.inertia["shaft_in"] == 2.0
    # The scene's own are not changed by that.
    assert list(scene.loads) == ["bearing_out", "cross"]
    with pytest.raises(cd.ImmutableError):
        acting.joint_loads["pin_in"] = np.zeros(2)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"gravity": 9.81}, cd.ArgumentError, r"^gravity has shape \(\), expected \(\.\.\., 3\)$"),
        ({"gravity": [0.0, 1.0]}, cd.ArgumentError, r"^gravity has shape \(2,\), expected "),
        ({"gravity": np.zeros((0, 3))}, cd.ArgumentError, r"^gravity has shape \(0, 3\), expected"),
        (
            {"gravity": [[0.0, 0.0, 1.0], [0.0, np.inf, 0.0]]},
            cd.ArgumentError,
            r"^gravity is not finite at index \[1, 1\]$",
        ),
        ({"loads": 3.0}, cd.ArgumentError, "^loads is 3.0, expected a mapping"),
        ({"loads": {"lever": 1.0}}, cd.ArgumentError, r"^loads\['lever'\]: no joint or link has"),
        ({"loads": {"bearing_out": []}}, cd.ArgumentError, r"^loads\['bearing_out'\] is empty$"),
        (
            {"loads": {"bearing_out": [[1.0, np.nan]]}},
            cd.ArgumentError,
            r"^loads\['bearing_out'\] is not finite at index \[0, 1\]$",
        ),
        (
            {"loads": {"shaft_out": np.ones((2, 5))}},
            cd.ArgumentError,
            r"^loads\['shaft_out'\] has shape \(2, 5\); a link takes force and moment, \(6,\) or ",
        ),
        (
            {"loads": {"shaft_out": cd.Wrench(np.zeros((4, 2)))}},
            cd.ArgumentError,
            r"^loads\['shaft_out'\]\.force has shape \(4, 2\), expected \(3,\) or \(\.\.\., 3\)$",
        ),
        ({"loads": {"base": np.ones(6)}}, cd.ArgumentError, "link 'base' is fixed to the world"),
        ({"inertia": 2.0}, cd.ArgumentError, "^inertia is 2.0, expected a mapping"),
        ({"inertia": {"lever": 1.0}}, cd.ModelError, "no link 'lever'; links: base, "),
        (
            {"inertia": {"base": 1.0}},
            cd.ArgumentError,
            r"^inertia\['base'\]: the link is fixed to the world; its mass does not count$",
        ),
        ({"inertia": {"cross": []}}, cd.ArgumentError, r"^inertia\['cross'\] is empty$"),
        (
            {"inertia": {"cross": [1.0, -0.5, -2.0]}},
            cd.ArgumentError,
            r"^inertia\['cross'\] is -2; factors are not negative$",
        ),
        (
            {"inertia": {"cross": [1.0, np.inf]}},
            cd.ArgumentError,
            r"^inertia\['cross'\] is not finite at index \[1\]$",
        ),
    ],
)
def test_what_cannot_act(
    joint: cd.Mechanism, options: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        acting_on(universal(joint, 0.5).problem, **options)


def test_coordinates_of_a_ball_are_loaded_in_the_scene() -> None:
    """It solves the ball by a quaternion as long as none of its coordinates is named there."""
    mechanism = cd.load(crank_and_slider())
    scene = cd.Scene(mechanism, drive="r")
    with pytest.raises(
        cd.ArgumentError,
        match=r"^loads\['s.x'\]: the scene solves this joint as a ball; give the scene itself a",
    ):
        acting_on(scene.problem, loads={"s.x": 1.0})
    named = scene.replace(loads={"s.x": 0.0})
    assert acting_on(named.problem, loads={"s.y": 1.0}).joint_loads["s.y"] == 1.0


def acting_of(joint: cd.Mechanism, **shapes: tuple[int, ...]) -> Acting:
    """Return what acts, each of it with random samples of a shape."""
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(size=shape) for name, shape in shapes.items()}
    loads = {
        "bearing_out": values["effort"],
        "shaft_out": cd.Wrench(values["force"], values["moment"]),
    }
    return acting_on(
        universal(joint, 0.5).problem,
        values["speed"],
        values["acceleration"],
        loads,
        values["gravity"],
        {"cross": values["factor"]},
    )


def test_what_acts_is_flat_in_c_order(joint: cd.Mechanism) -> None:
    acting = acting_of(
        joint,
        speed=(3, 1, 1),
        acceleration=(4,),
        effort=(2, 1),
        force=(3, 1, 4, 3),
        moment=(2, 4, 3),
        gravity=(3, 2, 4, 3),
        factor=(3, 2, 1),
    )
    shape = (3, 2, 4)
    assert samples.common_shape(acting.shapes) == shape
    flat = acting.flat(shape)

    def expected(values: np.ndarray, *trailing: int) -> np.ndarray:
        return np.broadcast_to(values, (*shape, *trailing)).reshape(24, *trailing)

    np.testing.assert_array_equal(flat.speeds, expected(acting.speeds, 1))
    np.testing.assert_array_equal(flat.accelerations, expected(acting.accelerations, 1))
    np.testing.assert_array_equal(flat.gravity, expected(acting.gravity, 3))
    efforts = acting.joint_loads["bearing_out"], flat.joint_loads["bearing_out"]
    np.testing.assert_array_equal(efforts[1], expected(efforts[0]))
    loads = acting.link_loads["shaft_out"], flat.link_loads["shaft_out"]
    np.testing.assert_array_equal(loads[1].force, expected(loads[0].force, 3))
    np.testing.assert_array_equal(loads[1].moment, expected(loads[0].moment, 3))
    np.testing.assert_array_equal(flat.inertia["cross"], expected(acting.inertia["cross"]))


@pytest.mark.parametrize("ones", [(), (1,), (1, 1)])
def test_what_is_the_same_for_all_samples_stays_a_single_one(
    joint: cd.Mechanism, ones: tuple[int, ...]
) -> None:
    acting = acting_of(
        joint,
        speed=(),
        acceleration=ones,
        effort=ones,
        force=(*ones, 3),
        moment=(*ones, 3),
        gravity=(*ones, 3),
        factor=ones,
    )
    flat = acting.flat((2, 3))
    assert flat.shapes == {
        "speed": (6,),
        "acceleration": (6,),
        "gravity": (1,),
        "loads['bearing_out']": (1,),
        "loads['shaft_out'].force": (1,),
        "loads['shaft_out'].moment": (1,),
        "inertia['cross']": (1,),
        "time": (1,),
    }
    np.testing.assert_array_equal(flat.gravity[0], acting.gravity.reshape(3))


# Shapes together


@pytest.mark.parametrize(
    ("shapes", "expected"),
    [
        ({}, ()),
        ({"a": ()}, ()),
        ({"a": (3,), "b": ()}, (3,)),
        ({"a": (3,), "b": (3,)}, (3,)),
        ({"a": (3,), "b": (1,)}, (3,)),
        ({"a": (3,), "b": (2, 1)}, (2, 3)),
        ({"a": (3,), "b": (2, 1), "c": (5, 1, 1)}, (5, 2, 3)),
    ],
)
def test_shapes_that_broadcast(
    shapes: dict[str, tuple[int, ...]], expected: tuple[int, ...]
) -> None:
    assert samples.common_shape(shapes) == expected


def test_shapes_that_do_not_broadcast_are_all_named() -> None:
    message = (
        r"^shapes do not broadcast: position \(7,\), loads\['x'\] \(5,\), held\['y'\] \(2, 1\); "
        r"for a grid, give each argument an axis of its own, as values\[:, None\] does, "
        r"or values\[:, None, :\] where the last axis is that of several drives or rows of a task$"
    )
    shapes = {"position": (7,), "speed": (), "loads['x']": (5,), "held['y']": (2, 1)}
    with pytest.raises(cd.ArgumentError, match=message):
        samples.common_shape(shapes)


@pytest.mark.parametrize("angle", [8e13, -1e15, 1e300])
def test_angles_whose_neighbours_are_far_apart_are_refused(one: Problem, angle: float) -> None:
    with pytest.raises(cd.ArgumentError, match="does not say where it is, since numbers of that"):
        targets_of(one, [1.0, angle])


@pytest.mark.parametrize("angle", [1e12, -7e13])
def test_angles_of_any_number_of_turns_are_what_they_are(angle: float) -> None:
    """Whole turns are taken off as by the library's cosine, which reduces exactly."""
    turn = cd.Scene(cd.load("slider_crank"), drive="crank_bearing").sweep([0.0, angle])
    rotation = turn.rotation("crank_bearing")
    turned = rotation[0].T @ rotation[1]
    np.testing.assert_allclose(turned[0, 0], np.cos(angle), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(abs(turned[1, 0]), abs(np.sin(angle)), rtol=0.0, atol=1e-15)
