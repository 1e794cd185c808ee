"""Forces that a text states are refused, or listed."""

from __future__ import annotations

import pytest
from testkit.sdf import massive, model

import cardan_dyn as cd
from cardan_dyn.description.read import read
from cardan_dyn.description.sdf.forces import Forces

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
    "joint 'j': axis: damping 0.5, spring_stiffness 3": (
        "axis",
        "<dynamics><damping>0.5</damping><spring_stiffness>3</spring_stiffness></dynamics>",
    ),
    "joint 'j': axis: friction 1": ("axis", "<dynamics><friction>1</friction></dynamics>"),
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
    axis = "<axis><dynamics><damping>1</damping></dynamics></axis>"
    text = model(
        "".join(
            f'<link name="l{k}">{massive(1.0, "0 0 0")}</link><joint name="j{k}" type="revolute">'
            f"<parent>world</parent><child>l{k}</child>{axis}</joint>"
            for k in range(10)
        )
    )
    with pytest.raises(cd.ModelError, match="joint 'j7': axis: damping 1; and 2 more; load"):
        read(text)


def test_numbers_that_are_none() -> None:
    text = TEXT.format(**{**PLACES, "axis": "<dynamics><damping>much</damping></dynamics>"})
    with pytest.raises(cd.ModelError, match="joint 'j': axis: damping: 'much' is not 1 finite"):
        read(text, strict=False)
    assert Forces("at").left_out(strict=True) == []
