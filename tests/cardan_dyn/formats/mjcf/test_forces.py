"""Forces of MJCF that no wrench considers are refused by name, or left out with a warning."""

from __future__ import annotations

import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, same_as_urdf

import cardan_dyn as cd
from cardan_dyn.core.description.read import read

FORCES = HALVES.format(
    rocker=ROCKER.replace('name="d"', 'name="d" stiffness="3"').replace(
        'name="rocker"', 'name="rocker" gravcomp="1"'
    ),
    more=f'<equality>{CONNECTS["bodies"]}</equality><default><joint damping="1 2"/>'
    '<tendon frictionloss="2"/></default><option density="1.2"/>'
    '<tendon><fixed name="t"><joint joint="a" coef="1"/></fixed></tendon>'
    '<actuator><motor tendon="t" armature="0.1"/></actuator>',
)


def test_forces_that_wrenches_leave_out() -> None:
    with pytest.raises(cd.ModelError) as caught:
        read(FORCES)
    assert str(caught.value).split(": ", 1)[1] == (
        "forces that wrenches leave out: joint 'a': damping 1 2; joint 'b': damping 1 2; "
        "joint 'd': damping 1 2; body 'rocker': gravcomp 1; option: density 1.2; "
        "tendon 't': frictionloss 2; actuator '1': armature 0.1; load(..., strict=False) "
        "accepts the file and leaves them out"
    )
    warnings = read(FORCES, strict=False).warnings
    assert len(warnings) == 9, "an actuator along a tendon is told as well"
    assert "springs of 1 joint (d): Scene(..., elements=described" in warnings[-1]
    assert "joint 'd': damping 1 2 left out of the wrenches" in warnings[2]
    same_as_urdf(cd.load(FORCES.replace(' stiffness="3"', ""), strict=False))


TENDON = '<tendon><fixed name="t"{}><joint joint="j" coef="1"/></fixed></tendon>'


def left_out(attributes: str = "", body: str = "", sections: str = "") -> list[str]:
    """Return the forces that a model with one joint leaves out."""
    text = (
        f"<mujoco>{sections}<worldbody><body name='b' {body}><joint name='j' {attributes}/>"
        "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>"
    )
    ending = " left out of the wrenches"
    found = [
        line.removeprefix("MJCF text: ").removesuffix(ending)
        for line in read(text, strict=False).warnings
        if line.endswith(ending)
    ]
    if found:
        with pytest.raises(cd.ModelError, match=f"that wrenches leave out: {found[0]}; "):
            read(text)
    else:
        read(text)
    return found


def test_a_file_without_forces() -> None:
    quiet = (
        '<option gravity="0 0 -9.81" density="0"/><actuator><motor joint="j" gear="2"/></actuator>'
    )
    joint = "stiffness='0' damping='0 0 0' range='0 1'"
    assert left_out(joint, "gravcomp='0' pos='1 2 3'", quiet) == []


@pytest.mark.parametrize(
    ("attributes", "body", "force"),
    [
        ("stiffness='1 2' damping='0 0 3'", "", "joint 'j': damping 0 0 3, stiffness 1 2"),
        ("frictionloss='-1'", "", "joint 'j': frictionloss -1"),
        ("", "gravcomp='0.5'", "body 'b': gravcomp 0.5"),
    ],
)
def test_forces_of_joints_and_bodies(attributes: str, body: str, force: str) -> None:
    """What can be taken for an element, as damping, is none of them."""
    assert left_out(attributes, body) == [force]


@pytest.mark.parametrize(
    ("sections", "force"),
    [
        ('<option viscosity="1"/>', "option: viscosity 1"),
        ('<option density="1" viscosity="2"/>', "option: density 1, viscosity 2"),
        (TENDON.format(' damping="3"'), "tendon 't': damping 3"),
        (TENDON.format(' stiffness="3"'), "tendon 't': stiffness 3"),
        (
            '<default><tendon armature="1"/></default>' + TENDON.format(""),
            "tendon 't': armature 1",
        ),
        (
            '<default><default class="c"><motor damping="2"/></default></default>'
            '<actuator><motor class="c" name="m" joint="j"/></actuator>',
            "actuator 'm': damping 2",
        ),
    ],
)
def test_forces_of_other_sections(sections: str, force: str) -> None:
    assert left_out(sections=sections) == [force]


@pytest.mark.parametrize(("count", "more"), [(8, ""), (9, "; and 1 more"), (20, "; and 12 more")])
def test_a_message_lists_eight_forces(count: int, more: str) -> None:
    bodies = "".join(f"<body name='b_{index}' gravcomp='1'/>" for index in range(count))
    text = f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"
    with pytest.raises(cd.ModelError) as caught:
        read(text)
    assert f"body 'b_7': gravcomp 1{more}; load(..., strict=False) accepts" in str(caught.value)
    assert str(caught.value).count("gravcomp") == 8
    assert len(read(text, strict=False).warnings) == count


def test_a_spring_and_damper_by_their_times() -> None:
    """MuJoCo's time constant t and damping ratio r: k = I / (t r)², d = 2 I / t."""
    inertial = "<inertial pos='0 0 0' mass='1' diaginertia='2 2 2'/>"
    joint = "<joint name='j' springdamper='0.5 0.25'/>"
    mechanism = cd.load(f"<mujoco><worldbody><body>{joint}{inertial}</body></worldbody></mujoco>")
    stiffness, _ = mechanism.joint_springs["j"]
    damping, _ = mechanism.joint_dynamics["j"]
    assert stiffness == pytest.approx(2.0 / (0.5 * 0.25) ** 2, rel=1e-12)
    assert damping == pytest.approx(2.0 * 2.0 / 0.5, rel=1e-12)
