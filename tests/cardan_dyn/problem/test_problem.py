"""Problems as frozen data."""

from __future__ import annotations

import pickle
from dataclasses import fields, replace

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.problem.arguments import checked
from cardan_dyn.core.problem.problem import Problem


@pytest.fixture(scope="module")
def mechanism() -> cd.Mechanism:
    return cd.load("universal_joint")


def problem(mechanism: cd.Mechanism, **changes: object) -> Problem:
    arguments: dict[str, object] = {
        "drive": "bearing_in",
        "held": {"joint_angle": 0.5},
        "loads": {"bearing_out": [-5.0, -6.0], "shaft_out": cd.Wrench([1.0, 2.0, 3.0])},
        "gravity": (0.0, 0.0, -9.81),
        "compliance": {"pin_in": np.ones(6)},
    }
    return checked(mechanism, **{**arguments, **changes})


def test_columns_of_prescribed_and_passive_joints(mechanism: cd.Mechanism) -> None:
    item, velocities = problem(mechanism), mechanism.coordinates.velocity_columns
    expected = [velocities[name].start for name in ("bearing_in", "joint_angle")]
    assert item.prescribed_columns.tolist() == expected
    both = [*item.passive_columns.tolist(), *expected]
    assert sorted(both) == list(range(mechanism.model.nv))


def test_wrenches_are_those_of_bodies_then_of_fixed_loops() -> None:
    text = cd.load("four_bar").description.source.text
    cut = text.index("<loop")
    loop = text[cut : text.index("</loop>") + 7]
    start = loop.index('type="') + 6
    fixed = loop[:start] + "fixed" + loop[loop.index('"', start) :]
    mechanism = cd.load(text.replace(loop, fixed))
    name = mechanism.loops[0].joint
    item = checked(mechanism, drive="crank_bearing", outputs=[name, "crank_bearing"])
    assert mechanism.wrench_indices["crank_bearing"] == mechanism["crank_bearing"].id - 1
    # No body of the model is the loop's; it comes after all of them.
    expected = mechanism.model.njoints - 1, mechanism.wrench_indices["crank_bearing"]
    np.testing.assert_array_equal(item.output_indices, expected)
    ends = {mechanism.loops[0].predecessor - 1, mechanism.loops[0].successor - 1}
    assert item.wanted_bodies == {*ends, mechanism["crank_bearing"].id - 1} - {-1}


def test_wanted_bodies(mechanism: cd.Mechanism) -> None:
    assert problem(mechanism).wanted_bodies is None
    assert problem(mechanism, outputs=[]).wanted_bodies == set()
    one = problem(mechanism, outputs=["pin_out", "bearing_in"])
    assert one.wanted_bodies == {mechanism[name].id - 1 for name in ("pin_out", "bearing_in")}


@pytest.mark.parametrize("shape", [(), (4,), (2, 3), (5, 1)])
def test_loads_have_the_shape_that_was_given(
    mechanism: cd.Mechanism, shape: tuple[int, ...]
) -> None:
    effort, wrench = np.full(shape, -5.0), np.ones((*shape, 6))
    item = problem(mechanism, loads={"bearing_out": effort, "shaft_out": wrench})
    np.testing.assert_array_equal(item.joint_loads["bearing_out"], effort)
    for vectors in (item.link_loads["shaft_out"].force, item.link_loads["shaft_out"].moment):
        np.testing.assert_array_equal(vectors, wrench[..., :3])


def test_held_joints_become_drives_after_the_others() -> None:
    shaft = cd.load("double_shaft_z")
    angles = {"joint_angle_1": 0.1, "joint_angle_2": 0.2}
    item = checked(shaft, drive="bearing_in", held=angles, near={"bearing_in": 1.0})
    assert item.driving(()) is item
    driven = item.driving(("joint_angle_1",))
    assert driven.independent == ("bearing_in", "joint_angle_1")
    assert driven.held == {"joint_angle_2": 0.2}
    assert driven.differs_from(item) == {"independent", "held"}
    assert item.held == angles


CHANGES = {
    "independent": {"drive": "bearing_out", "loads": {}},
    "free": {"drive": None, "free": "bearing_in"},
    "held": {"held": {"joint_angle": 0.6}},
    "near": {"near": {"bearing_in": 1.0}},
    "branch": {"branch": "B"},
    "joint_loads": {"loads": {"bearing_out": [-5.0, -7.0]}},
    "gravity": {"gravity": (0.0, 0.0, -9.8)},
    "outputs": {"outputs": ["pin_in"]},
    "compliance": {"compliance": {"pin_in": 2.0 * np.ones(6)}},
    "strict": {"strict": True},
}


@pytest.mark.parametrize("name", CHANGES)
def test_problems_differ_in_what_was_changed(mechanism: cd.Mechanism, name: str) -> None:
    first = problem(mechanism)
    second = problem(mechanism, **CHANGES[name])
    # Loads on links are equal only where they are the same objects; these are made anew.
    implied = {"independent": {"joint_loads"}, "outputs": {"all_outputs"}}.get(name, set())
    assert first.differs_from(second) == {name, "link_loads", *implied}
    assert second.differs_from(first) == {name, "link_loads", *implied}


def test_problems_with_equal_values_do_not_differ(mechanism: cd.Mechanism) -> None:
    first = problem(mechanism)
    again = replace(problem(mechanism), link_loads=first.link_loads)
    assert again.differs_from(first) == set()
    assert problem(cd.load("universal_joint")).differs_from(first) == {"mechanism", "link_loads"}


def test_loops_are_closed_alike_whatever_acts(mechanism: cd.Mechanism) -> None:
    first = problem(mechanism)
    assert first.moves_like(problem(mechanism, gravity=(1.0, 0.0, 0.0), loads={}))
    assert not first.moves_like(problem(mechanism, held={"joint_angle": 0.4}))
    spring = [cd.JointSpring("bearing_out", 1.0)]
    assert first.moves_like(problem(mechanism, elements=spring))
    # Springs need motion that a single output may do without.
    one = problem(mechanism, outputs=["bearing_in"])
    assert not one.moves_like(problem(mechanism, outputs=["bearing_in"], elements=spring))


def test_the_order_of_held_joints_makes_a_difference() -> None:
    shaft = cd.load("double_shaft_z")
    held = {"joint_angle_1": 0.1, "joint_angle_2": 0.2}
    first = checked(shaft, drive="bearing_in", held=held)
    second = checked(shaft, drive="bearing_in", held=dict(reversed(held.items())))
    assert first.differs_from(second) == {"held"}


def test_pickles_are_equal_and_as_closed_to_writing(mechanism: cd.Mechanism) -> None:
    item = problem(mechanism)
    copy = pickle.loads(pickle.dumps(item))
    assert item.differs_from(copy) == {"mechanism", "link_loads"}
    for field in fields(Problem):
        with pytest.raises(AttributeError):
            setattr(copy, field.name, None)
    load = copy.link_loads["shaft_out"]
    arrays = [copy.gravity, copy.joint_loads["bearing_out"], copy.compliance["pin_in"]]
    for array in (*arrays, load.rotation, load.translation, load.force, load.moment):
        assert not array.flags.writeable
    with pytest.raises(cd.ImmutableError):
        copy.held["joint_angle"] = 0.0
