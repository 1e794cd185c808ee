"""What scenes, sweeps and responses tell of the problem that they belong to."""

from __future__ import annotations

import pytest

import cardan_dyn as cd
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.results.prescribed import Prescribed


class Item(Prescribed):
    def __init__(self, mechanism: cd.Mechanism) -> None:
        self._problem = checked(
            mechanism,
            drive="bearing_in",
            held={"joint_angle": 0.5},
            outputs=["pin_in", "bearing_out"],
        )
        self._freeze()


def test_what_is_prescribed_is_read_from_the_problem(joint: cd.Mechanism) -> None:
    item = Item(joint)
    assert item.mechanism is joint
    assert item.drives == ("bearing_in",)
    assert item.held == {"joint_angle": 0.5}
    assert item.outputs == ("pin_in", "bearing_out")


@pytest.mark.parametrize("name", ["mechanism", "drives", "held", "outputs", "new"])
def test_nothing_of_it_can_be_changed(joint: cd.Mechanism, name: str) -> None:
    item = Item(joint)
    with pytest.raises(cd.ImmutableError, match=f"{name} of a Item cannot be changed"):
        setattr(item, name, None)


def test_scenes_sweeps_and_responses_agree(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    for item in (scene, scene.sweep([0.0]), scene.response().sweep([0.0])):
        assert isinstance(item, Prescribed)
        assert item.mechanism is joint
        assert item.drives == ("bearing_in",)
        assert item.held == {"joint_angle": 0.5}
        assert item.outputs == tuple(joint.joint_names)
