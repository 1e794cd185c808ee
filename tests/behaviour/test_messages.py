"""Errors of every kind, raised as users raise them: all that is documented is there and true."""

from __future__ import annotations

import inspect
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit import linkages
from testkit.planar_linkages import five_bar, four_bar
from testkit.scenes import text

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")


def universal(**options: object) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.4}, **options}
    return cd.Scene(cd.load("universal_joint"), **given)


def rocker() -> cd.Scene:
    return cd.Scene(four_bar(), drive="D")


def open_loop() -> cd.Mechanism:
    """A four-bar whose rocker is too long."""
    return cd.load(linkages.four_bar(linkages.loop("continuous"), rocker="9.0"))


RAISED: dict[str, tuple[type[cd.CardanError], Callable[[], object]]] = {
    "model: text": (cd.ModelError, lambda: cd.load("<robot")),
    "model: joint": (cd.ModelError, lambda: universal(drive="bearing_inn")),
    "argument": (cd.ArgumentError, lambda: universal(held={"joint_angle": "x"})),
    "immutable": (cd.ImmutableError, lambda: setattr(universal(), "drives", ())),
    "assembly: sweep": (cd.AssemblyError, lambda: rocker().sweep([0.0, 2.0])),
    "assembly: far sweep": (cd.AssemblyError, lambda: rocker().sweep([0.0, 2e7])),
    "assembly: several": (
        cd.AssemblyError,
        lambda: cd.Scene(five_bar(), drive=["A", "D"]).sweep([[1.5, -1.5]]),
    ),
    "assembly: response": (cd.AssemblyError, lambda: rocker().response(interval=(-1.0, 1.0))),
    "assembly: near": (cd.AssemblyError, lambda: cd.Scene(four_bar(), drive="A", near={"D": 2})),
    "assembly: held": (
        cd.AssemblyError,
        lambda: cd.Scene(five_bar(), drive="A", near={"A": 1.5}, held={"D": -1.5}),
    ),
    "assembly: contradiction": (
        cd.AssemblyError,
        lambda: universal(near={"pin_in": 0.1, "pin_out": 0.4}),
    ),
    "assembly: zero": (cd.AssemblyError, lambda: cd.Scene(open_loop(), drive="a")),
    "assembly: describe": (cd.AssemblyError, lambda: cd.describe(open_loop())),
    "singular: sweep": (
        cd.SingularConfigurationError,
        lambda: cd.Scene(four_bar(1.0, 1.0, 2.0), drive="A").sweep([0.0, 2.0]),
    ),
    "singular: start": (
        cd.SingularConfigurationError,
        lambda: cd.Scene(cd.load("slider_crank"), drive="piston_guide"),
    ),
    "singular: held": (
        cd.SingularConfigurationError,
        lambda: universal(held={"joint_angle": 1.6}),
    ),
    "mobility: few": (cd.MobilityError, lambda: universal(held=None)),
    "mobility: many": (cd.MobilityError, lambda: universal(drive=["bearing_in", "bearing_out"])),
    "mobility: none": (cd.MobilityError, lambda: cd.Scene(four_bar(), drive=[])),
    "mobility: range": (
        cd.MobilityError,
        lambda: cd.Scene(five_bar(), drive=["A", "D"]).motion_range(),
    ),
    "indeterminate": (cd.IndeterminateError, lambda: universal(strict=True).sweep([0.1])),
    "accuracy": (cd.AccuracyError, lambda: universal().sweep([0.1], speed=1e200)),
    "accuracy: response": (
        cd.AccuracyError,
        lambda: cd.Scene(four_bar(), drive="D", loads={"A": 1.0}).response(
            1e-13, interval=(0.0, 0.6519816)
        ),
    ),
}
"""What is raised, and by what."""


def documented(kind: type) -> list[str]:
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")
    return re.findall(r"^ {4}(\w+):", section, re.MULTILINE)


@pytest.mark.parametrize("name", RAISED)
def test_every_documented_attribute_is_there(name: str) -> None:
    kind, call = RAISED[name]
    with pytest.raises(kind) as caught:
        call()
    error = caught.value
    assert type(error) is kind
    names = documented(kind)
    assert names or kind in (cd.ArgumentError, cd.ImmutableError)
    copied = pickle.loads(pickle.dumps(error))
    for attribute in names:
        np.testing.assert_equal(getattr(copied, attribute), getattr(error, attribute))


UNDECIDED = {
    # Nothing was followed, or nothing counted.
    "assembly: contradiction": {"position", "nearest", "finding"},
    "assembly: zero": {"position", "nearest", "finding"},
    "assembly: describe": {"position", "nearest", "finding"},
    "assembly: several": {"finding"},
    "assembly: far sweep": set(),
    "mobility: none": {"mobility"},
}
"""Attributes that have nothing to say where this is raised."""


@pytest.mark.parametrize("name", [name for name in RAISED if "assembly" in name])
def test_errors_of_assembly_carry_their_numbers(name: str) -> None:
    with pytest.raises(cd.AssemblyError) as caught:
        RAISED[name][1]()
    error, silent = caught.value, UNDECIDED.get(name, set())
    assert error.residual > 1e-10
    for attribute, empty in (("position", None), ("nearest", None), ("finding", "")):
        value = getattr(error, attribute)
        assert (value is empty or np.array_equal(value, empty)) == (attribute in silent), attribute
    assert (error.joint is not None) == (name in ("assembly: near", "assembly: held"))
    assert (error.sample is not None) == ("sweep" in name or "several" in name)


@pytest.mark.parametrize("name", [name for name in RAISED if "singular" in name])
def test_errors_of_singular_positions_carry_their_numbers(name: str) -> None:
    with pytest.raises(cd.SingularConfigurationError) as caught:
        RAISED[name][1]()
    error = caught.value
    assert isinstance(error.position, float)
    assert error.condition > 1e3
    assert error.moving
    assert error.finding in str(error)
    assert bool(error.joints) == ("dead point" in error.finding)


@pytest.mark.parametrize("name", [name for name in RAISED if "mobility" in name])
def test_errors_of_mobility_carry_their_numbers(name: str) -> None:
    with pytest.raises(cd.MobilityError) as caught:
        RAISED[name][1]()
    error = caught.value
    assert (error.mobility is None) == (name == "mobility: none")
    assert bool(error.advised) == (name == "mobility: few")
    assert bool(error.surplus) == (name == "mobility: many")


def test_errors_of_indeterminate_components_name_them() -> None:
    with pytest.raises(cd.IndeterminateError) as caught:
        universal(strict=True).sweep([0.1])
    assert set(caught.value.components) == set(universal().outputs)


NAMES: dict[str, Callable[[], object]] = {
    "drive": lambda: universal(drive="bearing_inn"),
    "held": lambda: universal(held={"bearing_inn": 0.1}),
    "near": lambda: universal(near={"bearing_inn": 0.1}),
    "loads": lambda: universal(loads={"bearing_inn": 0.1}),
    "outputs": lambda: universal(outputs=["bearing_inn"]),
    "compliance": lambda: universal(compliance={"bearing_inn": np.ones(6)}),
    "sweep": lambda: universal().sweep([0.1])["bearing_inn"],
    "position": lambda: universal().sweep([0.1]).motion.position("bearing_inn"),
    "ratio of": lambda: universal().sweep([0.1]).motion.ratio("bearing_inn"),
    "ratio to": lambda: universal().sweep([0.1]).motion.ratio("pin_in", "bearing_inn"),
    "mechanism": lambda: cd.load("universal_joint")["bearing_inn"],
    "response": lambda: universal().response().ratio("bearing_inn", 0.1),
    "replace": lambda: universal().replace(held={"bearing_inn": 0.1}),
}


@pytest.mark.parametrize("where", NAMES)
def test_every_unknown_name_suggests_the_nearest(where: str) -> None:
    with pytest.raises(cd.CardanError, match=r"did you mean 'bearing_in'"):
        NAMES[where]()


OTHER_NAMES: dict[str, tuple[str, Callable[[], object]]] = {
    "description": ("universal_joint", lambda: cd.load("universal_joynt")),
    "link": ("shaft_out", lambda: cd.load("universal_joint").link("shaft_ot")),
    "joint type": (
        "continuous",
        lambda: cd.load(text("universal_joint").replace('"continuous"', '"continous"')),
    ),
    "frame": ("parent", lambda: universal().sweep([0.1]).wrench("bearing_in", "parents")),
}


@pytest.mark.parametrize("what", OTHER_NAMES)
def test_names_of_all_kinds_suggest_the_nearest(what: str) -> None:
    name, call = OTHER_NAMES[what]
    with pytest.raises(cd.CardanError, match=f"did you mean '{name}'"):
        call()


def test_arguments_that_scenes_do_not_have_suggest_the_nearest() -> None:
    with pytest.raises(TypeError, match=r"no argument load.*did you mean 'loads'"):
        universal().replace(load={})


def test_long_lists_are_shortened_with_a_count() -> None:
    with pytest.raises(cd.CardanError) as caught:
        cd.Scene(cd.load("stewart_platform"), drive="leg")
    assert "and 16 more (did you mean 'leg_" in str(caught.value)


@pytest.mark.slow
def test_no_message_is_longer_than_a_paragraph() -> None:
    for name in sorted(
        path.stem for path in (Path(cd.__file__).parents[1] / "urdf").glob("*.urdf")
    ):
        mechanism = cd.load(name)
        for drive in mechanism.joint_names:
            if mechanism.joints[drive].nv == 1:
                try:
                    cd.Scene(mechanism, drive=drive)
                except cd.CardanError as error:
                    assert len(str(error)) < 1200, (name, drive)


@pytest.mark.parametrize(
    "kind", [cd.Scene, cd.Mechanism, cd.Sweep, cd.Trajectory, cd.Response, cd.JointWrench]
)
def test_what_is_meant_by_other_names_is_told_of_names_that_do_not_exist(kind: type) -> None:
    tried = [name for names in kind._meant for name in names.split()]  # type: ignore[attr-defined]
    assert not [name for name in tried if hasattr(kind, name)]
    assert ({"to_dataframe"} if kind is cd.JointWrench else {"run", "solve"}) <= set(tried)
    assert len(set(tried)) == len(tried)


def test_people_who_try_other_names_are_told_which_they_mean() -> None:
    scene = cd.Scene(cd.load("universal_joint"), drive="bearing_in", held={"joint_angle": 0.5})
    turn = scene.sweep([0.1])
    tried: list[tuple[Any, str, str]] = [
        (scene, "run", r"Scene has no attribute 'run'; scene\.sweep\(positions\)"),
        (scene, "plot", r"scene\.sweep\(positions\)\.plot\('joint'\)"),
        (scene.mechanism, "dof", r"cd\.describe\(mechanism\)"),
        (turn, "torque", r"Sweep has no attribute 'torque'; result\['joint'\]\.moment"),
        (turn, "positon", r"did you mean 'position'"),
        (turn, "condtion", r"did you mean 'condition'"),
        (turn["pin_in"], "torque", r"JointWrench has no attribute 'torque'; \.moment"),
        (turn["pin_in"], "momnet", r"did you mean 'moment'"),
    ]
    for item, name, told in tried:
        with pytest.raises(AttributeError, match=told):
            getattr(item, name)
    anything: Any = cd.Scene
    with pytest.raises(TypeError, match="Scene has no argument 'drives'; the driven joints are"):
        anything(scene.mechanism, drives="bearing_in")
    anything = scene
    with pytest.raises(TypeError, match=r"Scene\.sweep has no argument 'rpm'; speeds are in rad/s"):
        anything.sweep(0.1, rpm=3.0)
    with pytest.raises(TypeError, match=r"Scene\.simulate has no argument 'dt'; steps have"):
        anything.simulate(1.0, dt=3.0)
