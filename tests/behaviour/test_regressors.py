"""Regressors and base parameters, against Pinocchio's and what is published of robots."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest
from testkit.coordinates import (
    BARS,
    GRAVITY,
    SCENES,
    agree,
    all_driven,
    as_given,
    motion_of,
    ratios_by_pinocchio,
    scene_of,
)

import cardan_dyn as cd
from cardan_dyn.kit.arrays import Array

pytestmark = pytest.mark.usefixtures("loaded_once")


def by_pinocchio(scene: cd.Scene, turn: cd.Sweep) -> Array:
    """Return regressors `(N, n, 10 bodies)` of the open tree, through null spaces of the welds."""
    model, found = scene.mechanism.model.copy(), []
    model.gravity.linear[:] = scene.gravity
    motion, data = turn.motion, model.createData()
    for q, v, a in zip(motion.q, motion.v, motion.a, strict=True):
        _, ratio = ratios_by_pinocchio(scene, q)
        found.append(ratio.T @ pin.computeJointTorqueRegressor(model, data, q, v, a))
    return np.array(found)


@pytest.mark.parametrize("name", SCENES)
def test_efforts_are_linear_in_masses(name: str) -> None:
    scene = scene_of(name)
    motion = motion_of(scene, 60)
    turn = all_driven(scene).sweep(*motion)
    found = scene.regressor(*(as_given(scene, values) for values in motion))
    efforts = turn.drive_effort.reshape(found.shape[:2])
    agree(found @ found.values + found.rotors, efforts, 1e-12)
    # All of it, not with the values of the description alone: other masses, other efforts.
    tree, model = by_pinocchio(scene, turn), scene.mechanism.model
    described = np.concatenate([inertia.toDynamicParameters() for inertia in model.inertias[1:]])
    agree(tree @ described, efforts, 1e-11)
    base = found.base_parameters()
    assert len(base) == np.linalg.matrix_rank(tree.reshape(-1, tree.shape[2]), rtol=1e-11)
    assert base.gap > 1e3
    reduced = found[..., base.columns] @ base.values + found.rotors
    agree(reduced, efforts, 1e-11)


@pytest.mark.parametrize("axes", ["xx", "yy", "zz", "xy", "xz", "yz"])
def test_columns_are_derivatives(axes: str) -> None:
    """Of exact derivatives by the masses of a description: centres move, inertias stay."""
    scene = scene_of("universal")
    motion = motion_of(scene, 3)
    turn, found = scene.sweep(*motion), scene.regressor(*motion)
    columns = dict(zip(found.parameters, np.moveaxis(found.value, -1, 0), strict=True))
    by = turn.derivative(f"inertia:shaft_out.{axes}", "mass:shaft_out", "centre:shaft_out.x")
    size = np.abs(found.value).max()
    own = by[f"inertia:shaft_out.{axes}"].drive_effort
    assert columns[f"inertia:shaft_out.{axes}"] == pytest.approx(own, abs=1e-13 * size)
    described = {link.name: link for link in scene.mechanism.description.links}["shaft_out"]
    x, y, z = described.centre
    squares = (y * y + z * z, x * x + z * z, x * x + y * y)
    steiner = dict(zip(("xx", "yy", "zz"), squares, strict=True))
    steiner |= {"xy": -x * y, "xz": -x * z, "yz": -y * z}
    expected = columns["mass:shaft_out"] + sum(
        value * columns[f"first_moment:shaft_out.{axis}"]
        for axis, value in zip("xyz", described.centre, strict=True)
    )
    expected = expected + sum(v * columns[f"inertia:shaft_out.{k}"] for k, v in steiner.items())
    assert by["mass:shaft_out"].drive_effort == pytest.approx(expected, abs=1e-12 * size)


def serial(rows: list[tuple[float, float, float]]) -> cd.Mechanism:
    """Return a robot of hinges about z, by modified Denavit-Hartenberg rows (α, a, d)."""
    text = '<robot name="arm"><link name="l0"/>'
    for k, (angle, along, offset) in enumerate(rows, 1):
        turned = pin.rpy.rpyToMatrix(angle, 0.0, 0.0) @ [0.0, 0.0, offset]
        xyz = " ".join(repr(float(x)) for x in (along + turned[0], turned[1], turned[2]))
        text += (
            f'<link name="l{k}"><inertial><origin xyz="0.{k} 0.2 -0.1"/><mass value="{k}"/>'
            f'<inertia ixx="0.{k + 3}" iyy="0.5" izz="0.6" ixy="0.01" ixz="0.02" iyz="-0.03"/>'
            f'</inertial></link><joint name="j{k}" type="continuous"><parent link="l{k - 1}"/>'
            f'<child link="l{k}"/><origin xyz="{xyz}" rpy="{angle!r} 0 0"/><axis xyz="0 0 1"/>'
            "</joint>"
        )
    return cd.load(f"{text}</robot>")


RIGHT = np.pi / 2.0
PUMA = [
    *((0.0, 0.0, 0.0), (-RIGHT, 0.0, 0.0), (0.0, 0.4318, 0.1501)),
    *((-RIGHT, -0.0203, 0.4331), (RIGHT, 0.0, 0.0), (-RIGHT, 0.0, 0.0)),
]


@pytest.mark.parametrize(
    ("rows", "gravity", "count"),
    [
        # Two parallel hinges: m₂l², I₁ and I₂ about their axes, two first moments; weight adds two.
        ([(0, 0, 0), (0, 0.5, 0)], (0, 0, 0), 4),
        ([(0, 0, 0), (0, 0.5, 0)], (0, -9.81, 0), 6),
        # The weight along the axes does no work.
        ([(0, 0, 0), (0, 0.5, 0)], (0, 0, -9.81), 4),
        (PUMA, (0, 0, -9.81), 36),
    ],
)
def test_published_counts(
    rows: list[tuple[float, float, float]], gravity: tuple[float, float, float], count: int
) -> None:
    """36 of the PUMA 560: Gautier and Khalil (1990), Mayeda, Yoshida and Osuka (1990)."""
    scene = cd.Scene(serial(rows), drive=[f"j{k + 1}" for k in range(len(rows))], gravity=gravity)
    rng = np.random.default_rng(0)
    motion = rng.uniform(-2.0, 2.0, (3, 100, len(rows)))
    found = scene.regressor(*motion)
    base = found.base_parameters()
    assert len(base) == len(base.columns) == count
    assert base.condition < 1e3 and base.gap > 1e9
    # Links lie at their joints, whose frames are Pinocchio's.
    tree = by_pinocchio(scene, scene.sweep(*motion)).reshape(100, len(rows), -1, 10)
    order = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]  # Pinocchio counts yy before xz.
    agree(found.value.reshape(tree.shape), tree[..., order], 1e-13)


def test_a_single_hinge_has_one_inertia() -> None:
    scene = cd.Scene(serial([(0, 0, 0)]), drive="j1")
    base = scene.regressor(np.zeros(3), 2.0, [1.0, 2.0, 3.0]).base_parameters()
    (alone,) = base.combinations
    assert alone.parameter == "inertia:l1.zz" and not alone.terms
    assert str(base) == f"0: inertia:l1.zz = {0.6 + 0.1**2 + 0.2**2:.6g}"
    assert len(base.silent) == 9
    with pytest.raises(cd.ModelError, match="no effort depends on any mass"):
        scene.regressor(np.zeros(3)).base_parameters()


def test_rotors_are_told_apart_and_copies_are_equal() -> None:
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="a">
<joint name="a" axis="0 0 1" armature=".3"/><inertial pos=".1 .2 0" mass="2" diaginertia="1 1 1"/>
</body></worldbody></mujoco>"""
    found = cd.Scene(cd.load(text), drive="a").regressor(0.1, 1.0, [2.0, -1.0])
    np.testing.assert_allclose(found.rotors, [[0.6], [-0.3]], rtol=1e-15)
    again = pickle.loads(pickle.dumps(found))
    np.testing.assert_array_equal(again, found)
    assert again.parameters == found.parameters
    assert again.base_parameters().values == pytest.approx(found.base_parameters().values)


def test_four_bars_tell_eight_sums() -> None:
    """Two of the coupler are counted with crank and rocker; its weight does no work of its own."""
    scene = cd.Scene(cd.load(BARS), drive="a", gravity=GRAVITY)
    rng = np.random.default_rng(0)
    position = rng.uniform(-3.0, 3.0, 200)
    found = scene.regressor(position, *rng.normal(size=(2, 200)))
    base = found.base_parameters()
    links = {
        name.split(":")[1].split(".")[0]
        for item in base.combinations
        for name in (item.parameter, *item.terms)
    }
    assert len(base) == 8 and links == {"crank", "coupler", "rocker"}


def test_lengths_that_are_held_have_no_masses() -> None:
    scene, rng = scene_of("four_bar"), np.random.default_rng(5)
    motion = rng.normal(size=(3, 60)) * [[0.3], [1.0], [3.0]]
    lengths = {"origin:b.x": 0.0, "origin:d.y": 0.0, "origin:c.predecessor.x": 0.0}
    plain, held = (item.regressor(*motion) for item in (scene, scene.replace(held=lengths)))
    assert held.parameters == plain.parameters
    agree(held, plain, 1e-12)
    assert len(held.base_parameters()) == len(plain.base_parameters())
    # Designs are samples: sums that lengths tell apart are further ones.
    moved = scene.replace(held=lengths).regressor(
        *motion, held={"origin:b.x": np.array([[0.0], [0.05], [0.1]])}
    )
    assert moved.shape == (3, *plain.shape)
    agree(moved[0], plain, 1e-12)
    assert np.abs(moved[2] - plain.value).max() > 1e-3
