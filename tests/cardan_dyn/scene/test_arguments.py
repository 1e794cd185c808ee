"""Arguments of a scene: as properties, as text, and with changes."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd

WRENCH = cd.Wrench(force=(1.0, 2.0, 3.0), frame="world")


def full(joint: cd.Mechanism) -> cd.Scene:
    return cd.Scene(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -2.0, "shaft_out": WRENCH},
        gravity=(0.0, 0.0, -9.81),
        outputs=["pin_in"],
        compliance={"pin_in": np.ones(6)},
        near={"bearing_in": 1.0},
        branch="A",
    )


def test_arguments_are_properties(joint: cd.Mechanism) -> None:
    item = full(joint)
    assert item.mechanism is joint
    assert item.drives == ("bearing_in",)
    assert item.held == {"joint_angle": 0.5}
    assert item.outputs == ("pin_in",)
    assert item.strict is False
    assert item.near == {"bearing_in": 1.0}
    assert item.branch == "A"
    np.testing.assert_array_equal(item.gravity, [0.0, 0.0, -9.81])
    np.testing.assert_array_equal(item.compliance["pin_in"], np.eye(6))
    assert list(item.loads) == ["bearing_out", "shaft_out"]
    assert item.loads["bearing_out"] == -2.0
    assert item.loads["shaft_out"].frame == "world"
    np.testing.assert_array_equal(item.loads["shaft_out"].force, [1.0, 2.0, 3.0])
    with pytest.raises(cd.ImmutableError):
        item.loads["bearing_out"] = 0.0
    with pytest.raises(cd.ImmutableError, match="strict of a Scene cannot be changed"):
        item.strict = False


def test_arguments_that_were_not_given(joint: cd.Mechanism) -> None:
    item = cd.Scene(joint, drive=["bearing_in", "joint_angle"])
    assert item.held == item.loads == item.compliance == item.near == {}
    assert item.outputs == tuple(joint.joint_names)
    assert item.strict is False
    np.testing.assert_array_equal(item.gravity, np.zeros(3))


def test_texts_tell_what_was_given(joint: cd.Mechanism) -> None:
    assert repr(full(joint)) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.5; "
        "loads on bearing_out, shaft_out; gravity [0.0, 0.0, -9.81]>"
    )
    bare = cd.Scene(joint, drive=["bearing_in", "joint_angle"])
    assert repr(bare) == "<Scene of 'universal_joint': drives bearing_in, joint_angle>"
    assert repr(universal(joint, 1.0 / 3.0)) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.333333; "
        "loads on bearing_out>"
    )


def test_changes_of_nothing_give_the_same_scene(joint: cd.Mechanism) -> None:
    item = full(joint)
    again = item.replace()
    for name in ("mechanism", "drives", "free", "held", "outputs", "strict", "near", "branch"):
        assert getattr(again, name) == getattr(item, name)
    assert again.loads["bearing_out"] == -2.0
    assert again.loads["shaft_out"].frame == "world"
    np.testing.assert_array_equal(again.loads["shaft_out"].force, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(again.gravity, item.gravity)


@pytest.mark.parametrize(
    ("changes", "held"),
    [
        ({"joint_angle": 0.7}, {"joint_angle": 0.7}),
        ({}, {"joint_angle": 0.5}),
        ({"pin_in": None}, {"joint_angle": 0.5}),
        ({"joint_angle": None, "bearing_in": 0.1}, {"bearing_in": 0.1}),
    ],
)
def test_held_joints_are_merged_by_name(
    joint: cd.Mechanism, changes: dict[str, float | None], held: dict[str, float]
) -> None:
    drive = "bearing_in" if "joint_angle" in held else "joint_angle"
    scene = full(joint).replace(near=None)
    assert scene.replace(held=changes, drive=drive).held == held


def test_none_instead_of_a_mapping_takes_all_out(joint: cd.Mechanism) -> None:
    item = full(joint)
    assert item.replace(held=None, drive=["bearing_in", "joint_angle"]).held == {}
    assert item.replace(loads=None).loads == {}


def test_loads_are_merged_by_name(joint: cd.Mechanism) -> None:
    item = full(joint)
    loads = item.replace(loads={"bearing_out": None, "pin_in": 4.0}).loads
    assert set(loads) == {"shaft_out", "pin_in"}
    assert loads["pin_in"] == 4.0
    assert list(item.loads) == ["bearing_out", "shaft_out"]


def test_a_coordinate_has_one_role(joint: cd.Mechanism) -> None:
    """What one of drive, free and held names anew, the others name no longer."""
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    free = scene.replace(free="bearing_in")
    assert (free.drives, free.free, free.held) == ((), ("bearing_in",), {"joint_angle": 0.5})
    back = free.replace(drive="bearing_in")
    assert (back.drives, back.free) == (("bearing_in",), ())
    both = scene.replace(free=["joint_angle"])
    assert (both.drives, both.free, both.held) == (("bearing_in",), ("joint_angle",), {})
    assert both.coordinates == ("bearing_in", "joint_angle")
    held = both.replace(held={"joint_angle": 0.5})
    assert (held.drives, held.free, held.held) == (("bearing_in",), (), {"joint_angle": 0.5})
    turned = scene.replace(held={"bearing_in": 0.2, "joint_angle": None}, free="joint_angle")
    assert (turned.drives, turned.free, turned.held) == (
        (),
        ("joint_angle",),
        {"bearing_in": 0.2},
    )
    swapped = scene.replace(drive="joint_angle", held={"bearing_in": 0.1})
    assert (swapped.drives, swapped.free, swapped.held) == (
        ("joint_angle",),
        (),
        {"bearing_in": 0.1},
    )
    for asked in ({"drive": "joint_angle", "held": {"joint_angle": 0.1}}, {"free": [], "drive": 3}):
        with pytest.raises(cd.ArgumentError, match=r"named once|drive is 3"):
            scene.replace(**asked)
    with pytest.raises(cd.ArgumentError, match="either driven, free or held, and named once"):
        cd.Scene(joint, drive="bearing_in", free="bearing_in", held={"joint_angle": 0.5})
    with pytest.raises(cd.ArgumentError, match="either driven, free or held, and named once"):
        cd.Scene(joint, free=["bearing_in", "joint_angle"], held={"joint_angle": 0.5})
    with pytest.raises(cd.ModelError, match="lever"):
        cd.Scene(joint, free="lever", held={"joint_angle": 0.5})


def test_freeing_a_drive_keeps_what_was_learned(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    assert scene.replace(free="bearing_in").solver.assembly is scene.solver.assembly


def test_free_coordinates_are_not_swept(joint: cd.Mechanism) -> None:
    free = cd.Scene(joint, free="bearing_in", held={"joint_angle": 0.5})
    assert repr(free) == "<Scene of 'universal_joint': free bearing_in; held joint_angle 0.5>"
    for refused in (
        lambda: free.sweep(0.0),
        lambda: free.assemble(0.0),
        free.response,
        lambda: free.responses({"joint_angle": [0.1, 0.2]}),
    ):
        with pytest.raises(cd.MobilityError, match=r"bearing_in is free; drive it or hold it"):
            refused()
    # Questions of geometry do not ask who moves a coordinate.
    assert free.motion_range() == (-np.inf, np.inf)
    assert free.reachable([0.0, 1.0]).all()
    assert next(iter(free.branches())) == "A"
    assert free.configuration().positions["bearing_in"] == 0.0
    scene = free.replace(drive="bearing_in")
    for refused in (lambda: scene.simulate(1.0), scene.equilibrium):
        with pytest.raises(cd.MobilityError, match=r"scene\.replace\(free="):
            refused()


def test_all_joints_stay_all_joints_of_another_mechanism(joint: cd.Mechanism) -> None:
    every = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    other = cd.load("four_bar")
    changed = every.replace(mechanism=other, drive="crank_bearing", held=None)
    assert changed.outputs == tuple(other.joint_names)


def test_unknown_arguments_are_refused(joint: cd.Mechanism) -> None:
    with pytest.raises(TypeError, match=r"Scene has no argument drives, load; arguments: branch"):
        full(joint).replace(load=1.0, drives="a", held={})


@pytest.mark.parametrize("value", [3, "joint_angle", [("joint_angle", 0.1)]])
@pytest.mark.parametrize("name", ["held", "loads"])
def test_changes_by_name_need_names(joint: cd.Mechanism, name: str, value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=f"^{name} is "):
        full(joint).replace(**{name: value})


@pytest.mark.parametrize("name", ["loads", "held"])
def test_names_to_be_taken_out_have_to_exist(joint: cd.Mechanism, name: str) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    with pytest.raises(cd.ModelError, match=r"no joint 'pin_inn'; .*did you mean 'pin_in'"):
        scene.replace(**{name: {"pin_inn": None}})
    assert scene.replace(loads={"pin_in": None}).loads == {}
