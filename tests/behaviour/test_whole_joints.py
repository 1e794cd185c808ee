"""The name of a joint with several coordinates stands for all of them."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from testkit.compound_joints import Y, Z, body, joint, robot

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

G = (0.4, -0.3, -9.81)
BASE = ("base.x", "base.y", "base.z", "base.turn_x", "base.turn_y", "base.turn_z")
AT = np.array([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])


def arm(kind: str = "floating") -> cd.Mechanism:
    axes = {"floating": (), "spherical": (), "planar": (Z,), "universal": (Y, Z)}[kind]
    return cd.load(
        robot(
            body("platform", 3.0, "0.05 -0.1 0.2"),
            joint("base", kind, "ground platform", "", axes),
            body("one", 1.1, "0.2 0.1 -0.1"),
            joint("h", "revolute", "platform one", 'xyz="0.1 0.2 0.3" rpy="0.5 0 0.1"', (Y,)),
        )
    )


def quaternion(angles: np.ndarray) -> np.ndarray:
    """Return the rotation by three carried turns, by Pinocchio."""
    turns = [pinocchio.exp3(angle * axis) for angle, axis in zip(angles, np.eye(3), strict=True)]
    return pinocchio.Quaternion(np.linalg.multi_dot(turns)).coeffs()


def assert_same(found: cd.Sweep, expected: cd.Sweep) -> None:
    assert found.shape == expected.shape
    np.testing.assert_allclose(found.drive_effort, expected.drive_effort, atol=1e-12)
    assert found.holding_effort.keys() == expected.holding_effort.keys()
    for name, effort in found.holding_effort.items():
        np.testing.assert_allclose(effort, expected.holding_effort[name], atol=1e-12)
    np.testing.assert_allclose(found["base"].moment, expected["base"].moment, atol=1e-12)


@pytest.mark.parametrize("kind", ["floating", "spherical", "planar", "universal"])
def test_held_driven_and_free(kind: str) -> None:
    mechanism = arm(kind)
    names = mechanism.joint("base").coordinates
    at = AT[: len(names)]
    each = dict(zip(names, at.tolist(), strict=True))

    single = cd.Scene(mechanism, drive="h", held=each, gravity=G)
    whole = cd.Scene(mechanism, drive="h", held={"base": at}, gravity=G)
    assert dict(whole.held) == each
    assert_same(whole.sweep([0.1, 0.7], speed=2.0), single.sweep([0.1, 0.7], speed=2.0))
    rows = at + np.array([[0.0], [0.1], [-0.2]])
    columns = {name: rows[:, [index]] for index, name in enumerate(names)}
    assert_same(
        whole.sweep([0.1, 0.7], held={"base": rows[:, None, :]}),
        single.sweep([0.1, 0.7], held=columns),
    )

    driven = cd.Scene(mechanism, drive="base", held={"h": 0.2}, gravity=G)
    assert driven.drives == names
    assert_same(
        driven.sweep(rows, speed=0.3),
        cd.Scene(mechanism, drive=list(names), held={"h": 0.2}, gravity=G).sweep(rows, speed=0.3),
    )

    free = cd.Scene(mechanism, free="base", held={"h": 0.2}, gravity=G)
    assert free.free == names
    assert free.replace(drive=["base"], free=None).drives == names
    assert whole.replace(held={"base": None}, drive=["h", "base"]).drives == ("h", *names)
    assert dict(free.replace(held={"base": at}, drive="h").held) == each


def test_a_base_falls_free() -> None:
    scene = cd.Scene(arm(), free=["base"], held={"h": 0.0}, gravity=G)
    fall = scene.simulate(0.4, position={"base": AT}, speed={"base": np.zeros(6)})
    for index, name in enumerate(BASE):
        moved = 0.5 * 0.4**2 * G[index] if index < 3 else 0.0
        np.testing.assert_allclose(fall.motion.position(name)[-1], AT[index] + moved, atol=1e-9)


@pytest.mark.parametrize("kind", ["floating", "spherical"])
def test_what_a_configuration_has_is_held(kind: str) -> None:
    mechanism = arm(kind)
    size = mechanism.joint("base").nv
    row = np.concatenate([AT[: size - 3], quaternion(AT[size - 3 : size])])
    configuration = cd.assemble(mechanism, {"base": row})
    np.testing.assert_allclose(configuration.positions["base"], row, atol=1e-12)
    scene = cd.Scene(mechanism, drive="h", held={"base": configuration.positions["base"]})
    np.testing.assert_allclose(list(scene.held.values()), AT[:size], atol=1e-12)


@pytest.mark.parametrize(
    ("held", "message"),
    [
        ({"base": AT[:4]}, r"held\['base'\] has shape \(4,\), expected \(..., 6\); .* base.turn_z"),
        ({"base": np.ones(7)}, "length 2, expected 1"),
        ({"base": AT, "base.x": 0.1}, "base.x is given by itself and with its joint"),
        ({"base": np.ones((2, 6))}, r"has shape \(2,\), expected a number"),
        ({"base": 0.0}, "held joint 'base' is a floating joint; name one"),
    ],
)
def test_what_is_refused(held: dict[str, object], message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        cd.Scene(arm(), drive="h", held=held)


def test_a_joint_called_like_a_coordinate_is_meant() -> None:
    mechanism = cd.load(
        robot(
            body("one", 1.0),
            joint("base", "universal", "ground one", "", (Y, Z)),
            body("two", 1.0),
            joint("base.turn_1", "revolute", "one two", "", (Y,)),
        )
    )
    for given in ({"free": "base"}, {"drive": "base.turn_1", "held": {"base": [0.1, 0.2]}}):
        with pytest.raises(cd.ArgumentError, match="is a universal joint; name one of its"):
            cd.Scene(mechanism, **given)


def test_a_name_alone_is_held_where_it_starts() -> None:
    mechanism = arm()
    for held in "base", ["base"]:
        at_zero = cd.Scene(mechanism, drive="h", held=held)
        assert dict(at_zero.held) == dict.fromkeys(BASE, 0.0)
    there = cd.Scene(mechanism, drive="h", held="base", near={"base": AT})
    assert dict(there.held) == dict(zip(BASE, AT.tolist(), strict=True))
    assert_same(there.sweep([0.2]), cd.Scene(mechanism, drive="h", held={"base": AT}).sweep([0.2]))
    freed = cd.Scene(mechanism, drive="h", free="base", near={"base": AT})
    assert dict(freed.replace(held="base").held) == dict(there.held)
    assert freed.replace(held="base").free == ()
    for held in "bass", ["base", "base.x"], "h":
        with pytest.raises(cd.ArgumentError, match="expected a mapping of names"):
            cd.Scene(mechanism, drive="h", held=held)
