"""Sweeps whose arguments broadcast, against a sweep of a scene of its own for every sample."""

from __future__ import annotations

import copy
import itertools
import pickle
import re
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from testkit.ball_rods import ALONG, WAYS
from testkit.claims import GRAVITY, SCENES, four_bar, linkages_on_arms, spatial, universal
from testkit.planar_linkages import ARM, five_bar, meeting_points, rocker_range, tips
from testkit.planar_linkages import four_bar as linkage
from testkit.scaling import moving, scaled
from testkit.scenes import double

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

P = np.linspace(-1.0, 2.5, 6)
RATES = {"speed": 3.0, "acceleration": -2.0}
DESIGNS: dict[str, tuple[Callable[[], cd.Scene], dict[str, np.ndarray]]] = {
    "universal": (universal, {"joint_angle": np.array([0.8, 0.2, 1.1])}),
    "double": (
        lambda: double(cd.load("double_shaft_z"), 0.5, 0.4, gravity=GRAVITY),
        {"joint_angle_2": np.array([0.1, 0.4, 0.9]), "joint_angle_1": np.array([0.3, 0.5, 0.2])},
    ),
    "spatial": (spatial, {"joint_angle_1_v": np.array([0.3, -0.2, 0.1])}),
}


def assert_same(found: cd.Sweep, index: Any, expected: cd.Sweep) -> None:
    """Compare some samples of a grid with those of a sweep, to rounding times the condition."""
    allowed = 1e3 * np.finfo(float).eps * float(np.max(expected.condition))
    wrenches = [
        (getattr(found[name], quantity)[index], getattr(expected[name], quantity))
        for name in expected
        for quantity in ("force", "moment")
    ]
    efforts = [(found.drive_effort[index], expected.drive_effort)]
    efforts += [
        (found.holding_effort[name][index], effort)
        for name, effort in expected.holding_effort.items()
    ]
    size = max(float(np.max(np.abs(item))) for _, item in wrenches)
    for value, wanted in (*wrenches, *efforts):
        np.testing.assert_allclose(value, wanted, rtol=0.0, atol=allowed * size)
    for name in expected.mechanism.coordinates.named:
        for quantity in ("position", "velocity", "acceleration", "ratio"):
            value = getattr(found.motion, quantity)(name)[index]
            wanted = getattr(expected.motion, quantity)(name)
            scale = max(1.0, float(np.max(np.abs(wanted))))
            np.testing.assert_allclose(value, wanted, rtol=0.0, atol=allowed * scale)
    for quantity in ("position", "speed", "acceleration"):
        np.testing.assert_array_equal(getattr(found, quantity)[index], getattr(expected, quantity))


def assert_shaped(sweep: cd.Sweep, shape: tuple[int, ...]) -> None:
    """Check the shapes of all results."""
    model = sweep.mechanism.model
    assert sweep.shape == sweep.motion.shape == sweep.condition.shape == shape
    assert len(sweep) == len(sweep.motion) == shape[0]
    drives = () if len(sweep.drives) == 1 else (len(sweep.drives),)
    for name in ("position", "speed", "acceleration", "drive_effort"):
        assert getattr(sweep, name).shape == (*shape, *drives)
    for effort in (*sweep.holding_effort.values(), *sweep.coupling_moment.values()):
        assert effort.shape == shape
    assert sweep.motion.q.shape == (*shape, model.nq)
    assert sweep.motion.v.shape == sweep.motion.a.shape == (*shape, model.nv)
    for name in sweep:
        for frame in ("joint", "parent", "world"):
            wrench = sweep.wrench(name, frame)
            assert wrench.force.shape == wrench.moment.shape == (*shape, 3)
            if sweep.mechanism.joints[name].type not in ("spherical", "floating", "fixed"):
                assert wrench.torsion.shape == wrench.bending.shape == shape
            assert wrench.unique.shape == (6,)
        assert sweep.rotation(name).shape == (*shape, 3, 3)
        assert sweep.origin(name).shape == (*shape, 3)


# Held joints at other positions


@pytest.mark.slow
@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", DESIGNS)
def test_designs_are_scenes_that_hold_their_joints_elsewhere(
    name: str, rates: dict[str, float]
) -> None:
    make, designs = DESIGNS[name]
    scene = make()
    held = {joint: angles[:, None] for joint, angles in designs.items()}
    grid = scene.sweep(P, **rates, held=held)
    assert_shaped(grid, (3, len(P)))
    assert grid.balance_residual < 1e-12
    for row in range(3):
        own = {joint: float(angles[row]) for joint, angles in designs.items()}
        assert_same(grid, row, make().replace(held=own).sweep(P, **rates))
    # The scene itself stays as it was.
    assert_same(scene.sweep(P, **rates), slice(None), make().sweep(P, **rates))


@pytest.mark.parametrize("name", DESIGNS)
def test_designs_may_differ_from_sample_to_sample(name: str) -> None:
    make, designs = DESIGNS[name]
    held = {joint: np.tile(angles, 2) for joint, angles in designs.items()}
    sweep = make().sweep(P, **RATES, held=held)
    assert_shaped(sweep, (len(P),))
    for sample in range(3):
        own = {joint: float(angles[sample]) for joint, angles in held.items()}
        both = slice(sample, None, 3)
        assert_same(sweep, both, make().replace(held=own).sweep(P[both], **RATES))


def test_single_held_positions_hold_for_all_samples() -> None:
    sweep = universal().sweep(P, **RATES, held={"joint_angle": 0.3})
    assert_shaped(sweep, (len(P),))
    assert_same(
        sweep, slice(None), universal().replace(held={"joint_angle": 0.3}).sweep(P, **RATES)
    )
    same = universal().sweep(P, **RATES, held={"joint_angle": 0.8})
    assert_same(same, slice(None), universal().sweep(P, **RATES))


@pytest.mark.parametrize("angle", [0.3, 0.8])
def test_equal_designs_span_the_shape_all_the_same(angle: float) -> None:
    """Whether or not they are what the scene holds."""
    held = {"joint_angle": np.full((3, 1), angle)}
    assert universal().sweep(P, held=held).shape == (3, len(P))
    assert universal().assemble(P, held=held).shape == (3, len(P))
    assert universal().reachable(P, held=held).shape == (3, len(P))


def test_order_and_number_of_designs_make_no_difference() -> None:
    scene = double(cd.load("double_shaft_z"), 0.5, 0.4)
    rng = np.random.default_rng(0)
    angles = rng.uniform(0.0, 0.9, (2, 400))
    positions = rng.uniform(-20.0, 20.0, 400)

    def swept_at(order: np.ndarray) -> cd.Sweep:
        held = dict(zip(("joint_angle_1", "joint_angle_2"), angles[:, order], strict=True))
        return scene.sweep(positions[order], held=held)

    whole = swept_at(np.arange(400))
    for order in (rng.permutation(400), np.array([7, 300]), np.array([123])):
        part = swept_at(order)
        for name in ("slip", "bearing_out", "pin_1_in"):
            expected = whole.motion.position(name)[order]
            np.testing.assert_allclose(part.motion.position(name), expected, rtol=0.0, atol=1e-11)
        expected = whole.drive_effort[order]
        np.testing.assert_allclose(part.drive_effort, expected, rtol=1e-10, atol=1e-12)


def test_many_turns_at_other_held_positions() -> None:
    """Cardan's ratio, and turns are counted on."""
    phi = np.array([0.3, 700.0, -700.0, 3e4])
    beta = np.array([[0.2], [1.2], [-0.7]])
    scene = universal(gravity=None, loads={"bearing_out": -100.0})
    sweep = scene.sweep(phi, held={"joint_angle": beta})
    ratio = np.cos(beta) / (1.0 - np.sin(beta) ** 2 * np.cos(phi) ** 2)
    np.testing.assert_allclose(np.abs(sweep.drive_effort), 100.0 * ratio, rtol=1e-10)
    output = sweep.motion.position("bearing_out")
    assert np.max(np.abs(np.abs(output) - np.abs(phi))) < 0.5 * np.pi


def test_several_drives_at_other_held_positions() -> None:
    loads = {"bearing_out": -5.0}
    angles = {"joint_angle_1": 0.5, "joint_angle_2": 0.4}

    def scene(held: float) -> cd.Scene:
        return cd.Scene(
            cd.load("double_shaft_z"),
            drive=["bearing_in", "joint_angle_1"],
            held={"joint_angle_2": held},
            loads=loads,
            gravity=GRAVITY,
        )

    positions = np.stack([P, np.linspace(0.1, 0.7, len(P))], axis=1)
    rates = {"speed": [2.0, -1.0], "acceleration": [0.5, 3.0]}
    second = np.array([[0.2], [0.4], [0.8]])
    grid = scene(angles["joint_angle_2"]).sweep(positions, **rates, held={"joint_angle_2": second})
    assert_shaped(grid, (3, len(P)))
    for row, angle in enumerate(second[:, 0]):
        assert_same(grid, row, scene(angle).sweep(positions, **rates))


def test_along_a_path_held_joints_move_with_the_drives() -> None:
    turn = np.linspace(0.0, 4.0 * np.pi, 60)
    angle = 0.8 + 0.3 * np.sin(turn)
    path = universal().sweep(turn, held={"joint_angle": angle}, along_path=True)
    assert_same(path, slice(None), universal().sweep(turn, held={"joint_angle": angle}))


# What acts


LOADS = np.array([[-5.0], [2.0], [0.0]])
WRENCHES = np.random.default_rng(1).normal(size=(3, 1, 6))
FORCES = np.random.default_rng(2).normal(size=(3, 1, 3))
GRAVITIES = np.array([[[0.0, 0.0, -9.81]], [[3.0, -1.0, 2.0]], [[0.0, 0.0, 0.0]]])
SPEEDS = np.array([[0.0], [4.0], [-1.0]])


@pytest.mark.parametrize("held", [None, 0.3], ids=["as in the scene", "elsewhere"])
def test_all_that_acts_broadcasts_with_the_positions(held: float | None) -> None:
    """Rows of a grid are scenes with their own loads, gravity and speeds."""
    loads = {"bearing_out": LOADS, "cross": WRENCHES, "shaft_in": cd.Wrench(FORCES, frame="world")}
    options = {} if held is None else {"held": {"joint_angle": held}}
    grid = universal().sweep(
        P[None], SPEEDS, 0.5 * SPEEDS, loads=loads, gravity=GRAVITIES, **options
    )
    assert_shaped(grid, (3, len(P)))
    for row in range(3):
        own = {
            "bearing_out": LOADS[row, 0],
            "cross": WRENCHES[row, 0],
            "shaft_in": cd.Wrench(FORCES[row, 0], frame="world"),
        }
        scene = universal().replace(loads=own, gravity=GRAVITIES[row, 0], **options)
        speed = SPEEDS[row, 0]
        assert_same(grid, row, scene.sweep(P, speed, 0.5 * speed))
    np.testing.assert_array_equal(grid.gravity, GRAVITIES)
    np.testing.assert_array_equal(grid.loads["bearing_out"], LOADS)
    np.testing.assert_array_equal(grid.loads["cross"].moment, WRENCHES[..., 3:])


@pytest.mark.parametrize("rows", [3, len(P)])
@pytest.mark.parametrize("name", ["speed", "acceleration", "loads", "links", "gravity", "inertia"])
def test_any_argument_alone_adds_its_axis_to_positions_in_a_row(name: str, rows: int) -> None:
    """Also where it has as many samples as there are positions."""
    values = np.linspace(1.0, 2.0, rows)[:, None]
    options: dict[str, Any] = {
        "speed": {"speed": values},
        "acceleration": {"acceleration": values},
        "loads": {"loads": {"bearing_out": values}},
        "links": {"loads": {"shaft_out": values[..., None] * np.ones(6)}},
        "gravity": {"gravity": values[..., None] * [0.0, 0.0, -9.81]},
        "inertia": {"inertia": {"cross": values}},
    }[name]
    assert universal().sweep(P, **options).shape == (rows, len(P))
    both = cd.Scene(cd.load("universal_joint"), drive=["bearing_in", "joint_angle"])
    if name not in ("speed", "acceleration"):
        two = np.stack([P, 0.1 * P], axis=1)
        assert both.sweep(two, **options).shape == (rows, len(P))


def test_rates_of_several_drives_span_a_grid() -> None:
    scene = linkages_on_arms()
    positions = 0.1 * np.arange(6.0)[:, None] * np.arange(1.0, 1.0 + len(scene.drives))
    speeds = np.random.default_rng(0).normal(size=(2, 1, len(scene.drives)))
    grid = scene.sweep(positions, speeds, 1.0)
    assert_shaped(grid, (2, 6))
    for row in range(2):
        assert_same(grid, row, scene.sweep(positions, speeds[row], 1.0))


@pytest.mark.parametrize("options", [{}, {"held": {"joint_angle": 0.3}}], ids=["", "elsewhere"])
@pytest.mark.parametrize("shape", [(6,), (2, 3), (3, 1, 2), (6, 1), (1, 6), (1, 1, 6)])
def test_samples_of_any_shape_are_those_in_a_row(
    shape: tuple[int, ...], options: dict[str, Any]
) -> None:
    scene, rng = universal(), np.random.default_rng(3)
    speed, effort, forces = rng.normal(size=6), rng.normal(size=6), rng.normal(size=(6, 6))
    gravity, factor = rng.normal(size=(6, 3)), rng.uniform(size=6)
    row = scene.sweep(
        P,
        speed,
        loads={"bearing_out": effort, "cross": forces},
        gravity=gravity,
        inertia={"shaft_out": factor},
        **options,
    )
    loads = {"bearing_out": effort.reshape(shape), "cross": forces.reshape(*shape, 6)}
    grid = scene.sweep(
        P.reshape(shape),
        speed.reshape(shape),
        loads=loads,
        gravity=gravity.reshape(*shape, 3),
        inertia={"shaft_out": factor.reshape(shape)},
        **options,
    )
    assert_shaped(grid, shape)
    for sample, index in enumerate(np.ndindex(grid.shape)):
        for name in row:
            for quantity in ("force", "moment"):
                expected = getattr(row[name], quantity)[sample]
                np.testing.assert_allclose(getattr(grid[name], quantity)[index], expected)
        assert (
            grid.motion.position("bearing_out")[index] == row.motion.position("bearing_out")[sample]
        )


@pytest.mark.parametrize("ones", [(), (1,), (1, 1)])
@pytest.mark.parametrize("shape", [(6,), (2, 3), (1, 6)])
def test_single_values_may_have_axes(shape: tuple[int, ...], ones: tuple[int, ...]) -> None:
    scene, positions = universal(), P.reshape(shape)
    expected = scene.sweep(
        positions,
        2.0,
        loads={"bearing_out": -7.0, "cross": np.arange(6.0)},
        gravity=(0.0, 5.0, 0.0),
        inertia={"cross": 2.0},
    )
    found = scene.sweep(
        positions,
        np.full(ones, 2.0),
        loads={"bearing_out": np.full(ones, -7.0), "cross": np.arange(6.0).reshape(*ones, 6)},
        gravity=np.array([0.0, 5.0, 0.0]).reshape(*ones, 3),
        inertia={"cross": np.full(ones, 2.0)},
    )
    assert found.shape == np.broadcast_shapes(shape, ones)
    for name in expected:
        actual = found[name].force.reshape(expected[name].force.shape)
        np.testing.assert_allclose(actual, expected[name].force, atol=1e-12)


MASSIVE: dict[str, Callable[[], cd.Scene]] = {
    **SCENES,
    **{
        f"rod as {way}": lambda way=way: cd.Scene(
            cd.load(WAYS[way](centre=0.5 * ALONG + np.array([0.0, 0.012, 0.004]))),
            drive="a",
            gravity=GRAVITY,
        )
        for way in WAYS
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", MASSIVE)
def test_factors_on_inertia_are_those_of_a_scaled_description(
    name: str, rates: dict[str, float]
) -> None:
    """Also where loops cut bodies, coupled wheels sit on arms, and rods spin idly."""
    scene = MASSIVE[name]()
    drives = len(scene.drives)
    positions = 0.1 * np.arange(5.0)[:, None] * np.arange(1.0, 1.0 + drives)
    if drives == 1:
        positions = positions[:, 0]
    links = moving(scene.mechanism)
    rows = np.random.default_rng(5).uniform(0.2, 3.0, (3, len(links)))
    rows[1] = 1.0
    rows[1, 0] = 10.0
    factors = {link: rows[:, [k]] for k, link in enumerate(links)}
    grid = scene.sweep(positions[None], **rates, inertia=factors)
    assert_shaped(grid, (3, 5))
    for index, row in enumerate(rows):
        mechanism = scaled(scene.mechanism, dict(zip(links, row.tolist(), strict=True)))
        assert_same(grid, index, scene.replace(mechanism=mechanism).sweep(positions, **rates))
    for link, factor in factors.items():
        np.testing.assert_array_equal(grid.inertia[link], factor)


def test_without_inertia_neither_weight_nor_speed_counts() -> None:
    scene = four_bar()
    light = scene.sweep(P, **RATES, inertia=dict.fromkeys(moving(scene.mechanism), 0.0))
    text = scene.mechanism.description.source.text
    massless = cd.load(re.sub("<inertial>.*?</inertial>", "", text, flags=re.DOTALL))
    assert_same(light, slice(None), scene.replace(mechanism=massless).sweep(P, **RATES))
    still = scene.replace(gravity=None).sweep(P)
    np.testing.assert_allclose(light.drive_effort, still.drive_effort, atol=1e-11)


def test_a_sweep_knows_what_was_given() -> None:
    angles, factor = np.array([[0.2], [0.8]]), np.array([[1.0], [2.0]])
    sweep = universal().sweep(P, held={"joint_angle": angles}, inertia={"cross": factor})
    np.testing.assert_array_equal(sweep.held["joint_angle"], angles)
    np.testing.assert_array_equal(sweep.inertia["cross"], factor)
    plain = universal().sweep(P)
    assert plain.held == {"joint_angle": 0.8}
    assert plain.inertia == {}


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_copies_of_a_grid_are_equal(copied: Callable[[cd.Sweep], cd.Sweep]) -> None:
    grid = universal().sweep(P, held={"joint_angle": np.array([[0.2], [0.8]])}, speed=2.0)
    again = copied(grid)
    assert_shaped(again, (2, len(P)))
    assert_same(again, slice(None), grid)
    np.testing.assert_array_equal(again.held["joint_angle"], grid.held["joint_angle"])
    assert not again.held["joint_angle"].flags.writeable


def test_shapes_that_do_not_broadcast_are_refused() -> None:
    scene = universal(loads={"bearing_out": np.zeros(5)})
    message = r"^shapes do not broadcast: position \(7,\), loads\['bearing_out'\] \(5,\); for a "
    with pytest.raises(cd.ArgumentError, match=message):
        scene.sweep(np.zeros(7))
    with pytest.raises(cd.ArgumentError, match=r"position \(7,\), held\['joint_angle'\] \(6,\);"):
        universal().sweep(np.zeros(7), held={"joint_angle": np.full(6, 0.3)})
    with pytest.raises(cd.ArgumentError, match=r"position \(3, 7\), gravity \(2,\);"):
        universal().sweep(
            np.zeros(7), held={"joint_angle": np.full((3, 1), 0.3)}, gravity=np.zeros((2, 3))
        )


def test_strict_scenes_refuse_designs_as_well() -> None:
    strict = cd.Scene(
        cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5}, strict=True
    )
    with pytest.raises(cd.IndeterminateError, match="bearing_in: force x"):
        strict.sweep(P, held={"joint_angle": 0.3})


def test_what_overflows_is_refused_without_warnings() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for options in (
            {"gravity": [[0.0, 0.0, 1e300]] * len(P), "loads": {"cross": [1e308] * 6}},
            {"inertia": {"cross": 1e308}, "speed": 1e10},
            {"speed": 1e200},
        ):
            with pytest.raises(cd.CardanError):
                universal().sweep(P, **options)


# Positions that are closed once


def test_assembled_designs_serve_several_sweeps() -> None:
    scene = universal()
    held = {"joint_angle": np.array([[0.2], [0.8], [1.1]])}
    closed = scene.assemble(P, held=held)
    assert closed.shape == (3, len(P))
    assert len(closed) == 3 * len(P)
    for options in ({}, RATES, {"gravity": GRAVITIES}, {"loads": {"bearing_out": LOADS}}):
        found, expected = scene.sweep(closed, **options), scene.sweep(P, held=held, **options)
        assert_shaped(found, (3, len(P)))
        assert_same(found, slice(None), expected)
        np.testing.assert_array_equal(found.held["joint_angle"], held["joint_angle"])
    again = pickle.loads(pickle.dumps(closed))
    assert again.shape == closed.shape
    for state, other in zip(closed.blocks, again.blocks, strict=True):
        np.testing.assert_allclose(other.x, state.x, atol=1e-12)


def test_assembled_positions_keep_their_shape() -> None:
    closed = universal().assemble
    assert closed(0.3).shape == closed([0.3]).shape == (1,)
    assert closed(P.reshape(2, 3)).shape == (2, 3)
    assert closed(P[:, None]).shape == (6, 1)


def test_what_acts_must_not_exceed_assembled_positions() -> None:
    scene = universal()
    closed = scene.assemble(P)
    message = (
        r"^the positions were assembled in shape \(6,\), which these exceed: .*"
        r"loads\['bearing_out'\] \(2, 6\).*; give the positions an axis for each of theirs$"
    )
    with pytest.raises(cd.ArgumentError, match=message):
        scene.sweep(closed, loads={"bearing_out": np.ones((2, 6))})
    with pytest.raises(cd.ArgumentError, match=r"shape \(6,\), which these exceed: speed \(2, 6\)"):
        scene.sweep(closed, np.ones((2, 6)))
    with pytest.raises(cd.ArgumentError, match=r"position \(6,\), loads\['bearing_out'\] \(5,\)"):
        scene.sweep(closed, loads={"bearing_out": np.ones(5)})
    grid = scene.assemble(P[None])
    with pytest.raises(cd.ArgumentError, match=r"assembled in shape \(1, 6\), which these exceed"):
        scene.sweep(grid, loads={"bearing_out": np.ones((2, 1))})
    single = scene.assemble(0.3)
    with pytest.raises(cd.ArgumentError, match=r"assembled in shape \(1,\), which these exceed"):
        scene.sweep(single, gravity=np.ones((4, 3)))


def test_positions_that_were_assembled_otherwise_are_refused() -> None:
    scene, held = universal(), {"joint_angle": 0.3}
    for given in (held, {}):
        with pytest.raises(
            cd.ArgumentError,
            match=r"^held: .* where they are; write assemble\(\.\.\., held=\.\.\.\)",
        ):
            scene.sweep(scene.assemble(P), held=given)
        with pytest.raises(cd.ArgumentError, match=r"^held: these positions were assembled with"):
            scene.sweep(scene.assemble(P, held=held), held=given)
    with pytest.raises(cd.ArgumentError, match=r"^along_path: these positions were assembled"):
        scene.sweep(scene.assemble(P, held=held), along_path=True)
    path = scene.assemble(P, held=held, along_path=True)
    assert_same(scene.sweep(path, along_path=True), slice(None), scene.sweep(P, held=held))
    for options in ({}, {"held": held}):
        with pytest.raises(cd.ArgumentError, match="assembled by another scene; assemble them a"):
            universal().sweep(scene.assemble(P, **options))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"position": [0.0, np.nan]}, r"^position is not finite at index \[1\]$"),
        ({"position": []}, "^position is empty$"),
        ({"held": {"bearing_out": 0.1}}, r"^held\['bearing_out'\]: the scene does not hold this"),
        ({"held": {"joint_angle": [0.1, np.inf]}}, r"^held\['joint_angle'\] is not finite at in"),
        ({"held": {"joint_angle": []}}, r"^held\['joint_angle'\] is empty$"),
        (
            {"held": {"joint_angle": -7000.0}},
            r"^held\['joint_angle'\] is -7000 rad, 1.11e\+03 turns",
        ),
        ({"held": {"joint_angle": [0.1, 0.2, 0.3]}}, r"^shapes do not broadcast: position \(2,\)"),
    ],
)
def test_all_ways_to_ask_check_positions(given: dict[str, Any], message: str) -> None:
    scene = universal()
    asked = {"position": [0.0, 0.1], **given}
    for solve in (scene.assemble, scene.sweep, scene.reachable):
        with pytest.raises(cd.ArgumentError, match=message):
            solve(**asked)


# Reach


def is_in_reach(way: np.ndarray) -> bool:
    """Return whether the arms of the five-bar span the distance of its pins all along a way."""
    a, d = way.T
    apart = np.hypot(1.0 - 0.4 * np.sin(d) + 0.4 * np.sin(a), 0.4 * np.cos(d) - 0.4 * np.cos(a))
    return bool(np.max(apart) < 2.0 * ARM)


def ways(first: np.ndarray, then: np.ndarray) -> Iterator[np.ndarray]:
    """Yield ways of D to `first`, then of A to `then`."""
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    for d, a in itertools.product(first, then):
        yield np.concatenate([share * [0.0, d], [0.0, d] + share * [a, 0.0]])


@pytest.mark.slow
def test_reach_of_a_drive_at_held_positions() -> None:
    """Held joints move first, then the drive; beyond a gap nothing is reached."""
    scene = cd.Scene(five_bar(), drive="A", held={"D": 0.1})
    d, a = np.linspace(-1.5, 1.5, 13), np.linspace(-0.3, 4.0, 16)
    found = scene.reachable(a, held={"D": d[:, None]})
    assert found.shape == (13, 16)
    assert found.dtype == bool
    expected = np.array([is_in_reach(way) for way in ways(d, a)]).reshape(13, 16)
    assert 20 < np.sum(expected) < 188
    np.testing.assert_array_equal(found, expected)
    alone = scene.reachable(a, held={"D": 0.0})
    np.testing.assert_array_equal(alone, [is_in_reach(way) for way in ways(np.zeros(1), a)])


@pytest.mark.slow
def test_reach_of_several_drives() -> None:
    scene = cd.Scene(five_bar(), drive=["D", "A"])
    grid = np.stack(np.meshgrid(np.linspace(-1.5, 1.5, 9), np.linspace(-2.0, 2.0, 11)), axis=-1)
    found = scene.reachable(grid)
    assert found.shape == (11, 9)
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    expected = [is_in_reach(share * end[::-1]) for end in grid.reshape(-1, 2)]
    assert 10 < np.sum(expected) < 89
    np.testing.assert_array_equal(found, np.reshape(expected, (11, 9)))


@pytest.mark.slow
def test_whole_turns_do_not_close_a_way_that_is_open() -> None:
    """Lines of many turns lead where they lead, though each drive by itself could turn back."""
    rng, scene = np.random.default_rng(3), cd.Scene(five_bar(), drive=["A", "D"])
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    ends = rng.uniform(-20.0, 20.0, (1000, 2))
    is_open = np.array([is_in_reach(share * end) for end in ends])
    taken = ends - 2.0 * np.pi * np.trunc(ends / (2.0 * np.pi))
    is_short_way_open = np.array([is_in_reach(share * end) for end in taken])
    assert np.sum(is_open & ~is_short_way_open) >= 2
    reached = scene.reachable(ends)
    np.testing.assert_array_equal(reached, is_open | is_short_way_open)
    turn = scene.sweep(ends[is_open])
    rows = np.zeros((len(turn.position), turn.mechanism.coordinates.size))
    for name in "AB":
        columns = turn.mechanism.coordinates.columns[name]
        rows[:, columns.start] = turn.motion.position(name)
    np.testing.assert_allclose(
        meeting_points(turn.mechanism, rows), tips(ends[is_open]), atol=1e-11
    )
    for end in ends[~reached][:5]:
        with pytest.raises(cd.AssemblyError, match="on the straight way there") as caught:
            scene.sweep(end)
        nearest = np.asarray(caught.value.nearest)
        assert abs(np.cross([*end, 0.0], [*nearest, 0.0])[2]) < 1e-9 * (end @ end)
        assert 0.0 < nearest @ end < end @ end


def test_reach_of_a_rocker_ends_at_its_dead_points() -> None:
    scene = cd.Scene(linkage(), drive="D")
    low, high = rocker_range()
    inside = np.linspace(low + 1e-5, high - 1e-5, 5)
    assert np.all(scene.reachable(inside))
    assert not np.any(scene.reachable([low - 1e-5, high + 1e-5, low - 7.0, 1e6]))
    assert scene.reachable(0.0).tolist() == [True]


@pytest.mark.slow
def test_nothing_at_all_may_be_in_reach() -> None:
    """Neither the drives' positions nor those of the held joint, which moves first."""
    held = cd.Scene(five_bar(), drive="A", held={"D": 0.0})
    assert not np.any(held.reachable([1.4, 1.5], held={"D": [[-1.5], [-1.6]]}))
    turned = cd.Scene(five_bar(), drive="A", held={"D": 0.0}, near={"A": 0.9})
    assert not np.any(turned.reachable([0.0, 0.1], held={"D": [[-1.5], [-1.6]]}))
    with pytest.raises(cd.AssemblyError, match="cannot be closed"):
        turned.sweep([0.0, 0.1], held={"D": -1.5})
    both = cd.Scene(five_bar(), drive=["A", "D"])
    assert not np.any(both.reachable([[3.0, -3.0], [2.0, -2.0]]))
    assert not np.any(cd.Scene(linkage(), drive="D").reachable([3.0, -3.0]))
    # The scene has learned nothing wrong from that.
    assert np.all(held.reachable([0.0, 0.1]))
    assert np.all(both.reachable([[0.1, 0.1], [0.0, 0.2]]))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_what_is_reachable_is_what_a_sweep_solves(seed: int) -> None:
    """The same scene answers both, whatever it was asked before."""
    rng = np.random.default_rng(seed)
    scene = cd.Scene(five_bar(), drive="A", held={"D": 0.0}, loads={"A": -1.0})
    a, d = rng.uniform(-3.0, 3.0, 40), rng.uniform(-2.0, 2.0, 40)
    found = scene.reachable(a, held={"D": d})
    assert 0 < np.sum(found) < 40
    assert scene.sweep(a[found], held={"D": d[found]}).balance_residual < 1e-12
    for position, held in zip(a[~found], d[~found], strict=True):
        with pytest.raises((cd.AssemblyError, cd.SingularConfigurationError)):
            scene.sweep(position, held={"D": held})
    np.testing.assert_array_equal(scene.reachable(a, held={"D": d}), found)


def test_what_is_out_of_reach_at_a_held_position_is_named() -> None:
    scene = cd.Scene(five_bar(), drive="A", held={"D": 0.0})
    with pytest.raises(cd.AssemblyError, match=r"\(sample 2 of 3\)") as caught:
        scene.sweep([0.0, 0.1, 1.5], held={"D": [0.0, 0.1, -1.5]})
    assert caught.value.sample == 2


def test_all_is_reachable_where_nothing_is_solved() -> None:
    arm = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 1 0"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="1 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
    scene = cd.Scene(
        cd.load(arm), drive="shoulder", held={"elbow": 0.4}, loads={"lower": [1.0] * 6}
    )
    found = scene.reachable([[0.0, 1e3]], held={"elbow": [[0.1], [7.0]]})
    np.testing.assert_array_equal(found, np.ones((2, 2), dtype=bool))
    elbow = np.array([[0.1], [7.0], [0.4]])
    grid = scene.sweep([0.0, 1.0], held={"elbow": elbow}, speed=2.0)
    for row, angle in enumerate(elbow[:, 0]):
        expected = scene.replace(held={"elbow": angle}).sweep([0.0, 1.0], speed=2.0)
        assert_same(grid, row, expected)
