"""Forces that a text states are refused, or listed."""

from __future__ import annotations

import pytest
from testkit.sdf import massive, model

import cardan_dyn as cd
from cardan_dyn.core.description.read import read

TEXT = model(
    '<link name="a"><inertial><mass>1</mass>{inertial}<inertia><ixx>1</ixx><iyy>1</iyy>'
    "<izz>1</izz></inertia></inertial>{link}</link>{model}"
    '<joint name="j" type="revolute"><parent>world</parent><child>a</child>'
    "<axis><xyz>0 0 1</xyz>{axis}</axis>{joint}</joint>"
)
PLACES = dict.fromkeys(("inertial", "link", "model", "axis", "joint"), "")
ACTING = {
    "link 'a': gravity false": ("link", "<gravity>false</gravity>"),
    "link 'a': enable_wind true": ("link", "<enable_wind>true</enable_wind>"),
    "link 'a': kinematic 1": ("link", "<kinematic>1</kinematic>"),
    "link 'a': velocity_decay: linear 0.1": (
        "link",
        "<velocity_decay><linear>0.1</linear></velocity_decay>",
    ),
    "link 'a': fluid_added_mass: xx 2, pq 3": (
        "inertial",
        "<fluid_added_mass><xx>2</xx><yy>0</yy><pq>3</pq></fluid_added_mass>",
    ),
    "model: enable_wind true": ("model", "<enable_wind>true</enable_wind>"),
    "joint 'j': axis: damping -0.5, spring_stiffness 3": (
        "axis",
        "<dynamics><damping>-0.5</damping><spring_stiffness>3</spring_stiffness></dynamics>",
    ),
    "joint 'j': axis: friction -1": ("axis", "<dynamics><friction>-1</friction></dynamics>"),
    "joint 'j': physics: max_force 4": (
        "joint",
        "<physics><ode><max_force>4</max_force></ode></physics>",
    ),
}
IDLE = {
    "link": "<gravity>true</gravity><kinematic>0</kinematic><self_collide>true</self_collide>",
    "axis": "<dynamics><damping>0</damping><spring_reference>3</spring_reference></dynamics>",
    "joint": "<physics><ode><cfm>0.1</cfm></ode></physics>",
}


@pytest.mark.parametrize(("noted", "inside"), ACTING.items(), ids=ACTING.keys())
def test_forces_that_act(noted: str, inside: tuple[str, str]) -> None:
    text = TEXT.format(**{**PLACES, inside[0]: inside[1]})
    with pytest.raises(cd.ModelError, match=f"forces that wrenches leave out: {noted}; load"):
        read(text)
    assert read(text, strict=False).warnings == (f"SDF text: {noted} left out of the wrenches",)


def test_forces_that_are_none() -> None:
    assert read(TEXT.format(**{**PLACES, **IDLE})).warnings == ()


def test_long_lists_are_counted() -> None:
    axis = "<axis><dynamics><damping>-1</damping></dynamics></axis>"
    text = model(
        "".join(
            f'<link name="l{k}">{massive(1.0, "0 0 0")}</link><joint name="j{k}" type="revolute">'
            f"<parent>world</parent><child>l{k}</child>{axis}</joint>"
            for k in range(10)
        )
    )
    with pytest.raises(cd.ModelError, match="joint 'j7': axis: damping -1; and 2 more; load"):
        read(text)


def test_numbers_that_are_none() -> None:
    text = TEXT.format(**{**PLACES, "axis": "<dynamics><damping>much</damping></dynamics>"})
    with pytest.raises(cd.ModelError, match="joint 'j': axis: damping: 'much' is not 1 finite"):
        read(text, strict=False)


DYNAMICS = (
    "<dynamics><damping>0.5</damping><friction>0.25</friction>"
    "<spring_stiffness>3</spring_stiffness><spring_reference>0.1</spring_reference></dynamics>"
)
TAKES_IN = (
    "SDF text: damping, friction or springs of 1 joint (j): "
    "Scene(..., elements=described_elements(mechanism)) takes it in, as "
    "`cardan-dyn simulate` and `vibration` do; other scenes are without it"
)


def test_damping_friction_and_springs_of_an_axis_are_read() -> None:
    description = read(TEXT.format(**{**PLACES, "axis": DYNAMICS}))
    assert description.warnings == (TAKES_IN,)
    (joint,) = (item for item in description.joints if item.name == "j")
    assert joint.dynamics == (0.5, 0.25, 3.0, 0.1)


def test_a_joint_that_closes_a_loop_keeps_them() -> None:
    text = model(
        f'<link name="a">{massive(1.0, "0 0 0")}</link>'
        + "".join(
            f'<joint name="{name}" type="revolute"><parent>world</parent><child>a</child>'
            f"<axis><xyz>0 0 1</xyz>{inside}</axis></joint>"
            for name, inside in (("first", ""), ("j", DYNAMICS))
        )
    )
    description = read(text)
    (loop,) = description.loops
    found = loop if loop.name == "j" else next(j for j in description.joints if j.name == "j")
    assert found.dynamics == (0.5, 0.25, 3.0, 0.1)
    assert description.warnings == (TAKES_IN,)
    mechanism = cd.load(text)
    assert dict(mechanism.joint_springs) == {"j": (3.0, 0.1)}
    assert dict(mechanism.joint_dynamics) == {"j": (0.5, 0.25)}


@pytest.mark.parametrize("alike", [True, False])
def test_axes_of_a_universal_joint_are_alike_or_refused(alike: bool) -> None:
    second = DYNAMICS if alike else ""
    text = model(
        f'<link name="a">{massive(1.0, "0 0 0")}</link><joint name="j" type="universal">'
        f"<parent>world</parent><child>a</child><axis><xyz>1 0 0</xyz>{DYNAMICS}</axis>"
        f"<axis2><xyz>0 1 0</xyz>{second}</axis2></joint>"
    )
    if alike:
        springs = dict(cd.load(text).joint_springs)
        assert springs == {"j.turn_1": (3.0, 0.1), "j.turn_2": (3.0, 0.1)}
        return
    noted = "joint 'j': axis: damping 0.5, friction 0.25, spring_stiffness 3"
    with pytest.raises(cd.ModelError, match=noted):
        read(text)
    assert read(text, strict=False).warnings == (f"SDF text: {noted} left out of the wrenches",)
