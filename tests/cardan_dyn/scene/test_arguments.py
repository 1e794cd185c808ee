"""Arguments of a scene: as properties, as text, and with changes."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.problem.arguments import checked
from cardan_dyn.scene.arguments import SceneArguments, replaced

WRENCH = cd.Wrench(force=(1.0, 2.0, 3.0), frame="world")


class Arguments(SceneArguments):
    def __init__(self, mechanism: cd.Mechanism, **options: object) -> None:
        self._problem = checked(mechanism, **options)
        self._freeze()


def full(joint: cd.Mechanism) -> Arguments:
    return Arguments(
        joint,
        drive="bearing_in",
        held={"joint_angle": 0.5},
        loads={"bearing_out": -2.0, "shaft_out": WRENCH},
        gravity=(0.0, 0.0, -9.81),
        outputs=["pin_in"],
        compliance={"pin_in": np.ones(6)},
        strict=True,
        start={"bearing_in": 1.0},
        branch="A",
    )


def test_arguments_are_properties(joint: cd.Mechanism) -> None:
    item = full(joint)
    assert item.mechanism is joint
    assert item.drives == ("bearing_in",)
    assert item.held == {"joint_angle": 0.5}
    assert item.outputs == ("pin_in",)
    assert item.strict is True
    assert item.start == {"bearing_in": 1.0}
    assert item.branch == "A"
    np.testing.assert_array_equal(item.gravity, [0.0, 0.0, -9.81])
    np.testing.assert_array_equal(item.compliance["pin_in"], np.eye(6))
    assert list(item.loads) == ["bearing_out", "shaft_out"]
    assert item.loads["bearing_out"] == -2.0
    assert item.loads["shaft_out"].frame == "world"
    np.testing.assert_array_equal(item.loads["shaft_out"].force, [1.0, 2.0, 3.0])
    with pytest.raises(cd.ImmutableError):
        item.loads["bearing_out"] = 0.0
    with pytest.raises(cd.ImmutableError, match="strict of a Arguments cannot be changed"):
        item.strict = False


def test_arguments_that_were_not_given(joint: cd.Mechanism) -> None:
    item = Arguments(joint, drive=["bearing_in", "joint_angle"])
    assert item.held == item.loads == item.compliance == item.start == {}
    assert item.outputs == tuple(joint.joint_names)
    assert item.strict is False
    np.testing.assert_array_equal(item.gravity, np.zeros(3))


def test_texts_tell_what_was_given(joint: cd.Mechanism) -> None:
    assert repr(full(joint)) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.5; "
        "loads on bearing_out, shaft_out; gravity [0.0, 0.0, -9.81]>"
    )
    bare = Arguments(joint, drive=["bearing_in", "joint_angle"])
    assert repr(bare) == "<Scene of 'universal_joint': drives bearing_in, joint_angle>"
    assert repr(universal(joint, 1.0 / 3.0)) == (
        "<Scene of 'universal_joint': drives bearing_in; held joint_angle 0.333333; "
        "loads on bearing_out>"
    )


def test_changes_of_nothing_give_the_same_problem(joint: cd.Mechanism) -> None:
    item = full(joint)
    again = checked(**replaced(item, {}))
    # Loads on links are compared by identity.
    assert again.differs_from(item._problem) == {"link_loads"}
    assert again.link_loads["shaft_out"].in_world
    np.testing.assert_array_equal(again.link_loads["shaft_out"].force, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("changes", "held"),
    [
        ({"joint_angle": 0.7}, {"joint_angle": 0.7}),
        ({"pin_in": 0.1}, {"joint_angle": 0.5, "pin_in": 0.1}),
        ({"joint_angle": None, "pin_in": 0.1}, {"pin_in": 0.1}),
        ({}, {"joint_angle": 0.5}),
        ({"pin_in": None}, {"joint_angle": 0.5}),
        (None, {}),
    ],
)
def test_held_joints_are_merged_by_name(
    joint: cd.Mechanism, changes: dict[str, float | None] | None, held: dict[str, float]
) -> None:
    assert replaced(full(joint), {"held": changes})["held"] == held


def test_loads_are_merged_by_name(joint: cd.Mechanism) -> None:
    item = full(joint)
    loads = replaced(item, {"loads": {"bearing_out": None, "pin_in": 4.0}})["loads"]
    assert list(loads) == ["shaft_out", "pin_in"]
    assert loads["pin_in"] == 4.0
    assert replaced(item, {"loads": None})["loads"] == {}
    assert list(item.loads) == ["bearing_out", "shaft_out"]


@pytest.mark.parametrize("name", ["compliance", "start", "outputs", "gravity", "branch", "strict"])
def test_other_arguments_are_replaced_whole(joint: cd.Mechanism, name: str) -> None:
    value = object()
    arguments = replaced(full(joint), {name: value})
    assert arguments.pop(name) is value
    unchanged = replaced(full(joint), {})
    assert set(unchanged) - set(arguments) == {name}


def test_all_joints_stay_all_joints_of_another_mechanism(joint: cd.Mechanism) -> None:
    some, every = full(joint), Arguments(joint, drive="bearing_in", held={"joint_angle": 0.5})
    assert replaced(some, {"mechanism": None})["outputs"] == ("pin_in",)
    assert replaced(every, {"mechanism": None})["outputs"] is None


def test_unknown_arguments_are_refused(joint: cd.Mechanism) -> None:
    with pytest.raises(TypeError, match=r"Scene has no argument drives, load; arguments: branch"):
        replaced(full(joint), {"load": 1.0, "drives": "a", "held": {}})


@pytest.mark.parametrize("value", [3, "joint_angle", [("joint_angle", 0.1)]])
@pytest.mark.parametrize("name", ["held", "loads"])
def test_changes_by_name_need_names(joint: cd.Mechanism, name: str, value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=f"^{name} is "):
        replaced(full(joint), {name: value})


@pytest.mark.parametrize("name", ["loads", "held"])
def test_names_to_be_taken_out_have_to_exist(joint: cd.Mechanism, name: str) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    with pytest.raises(cd.ModelError, match=r"no joint 'pin_inn'; .*did you mean 'pin_in'"):
        scene.replace(**{name: {"pin_inn": None}})
    assert scene.replace(loads={"pin_in": None}).loads == {}
