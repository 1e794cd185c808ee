"""Forces of MJCF that no wrench considers are refused by name, or left out with a warning."""

from __future__ import annotations

from collections.abc import Callable
from xml.etree.ElementTree import fromstring

import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, same_as_urdf

import cardan_dyn as cd
from cardan_dyn.description.mjcf.elements import DefaultClasses
from cardan_dyn.description.mjcf.forces import Forces
from cardan_dyn.description.read import read

FORCES = HALVES.format(
    rocker=ROCKER.replace('name="d"', 'name="d" stiffness="3"').replace(
        'name="rocker"', 'name="rocker" gravcomp="1"'
    ),
    more=f'<equality>{CONNECTS["bodies"]}</equality><default><joint damping="1 2"/>'
    '<tendon frictionloss="2"/></default><option density="1.2"/>'
    '<tendon><fixed name="t"><joint joint="a" coef="1"/></fixed></tendon>'
    '<actuator><motor joint="a" armature="0.1"/></actuator>',
)


def test_forces_that_wrenches_leave_out() -> None:
    with pytest.raises(cd.ModelError) as caught:
        read(FORCES)
    assert str(caught.value).split(": ", 1)[1] == (
        "forces that wrenches leave out: joint 'a': damping 1 2; joint 'b': damping 1 2; "
        "joint 'd': damping 1 2; body 'rocker': gravcomp 1; option: density 1.2; "
        "tendon 't': frictionloss 2; actuator 'motor': armature 0.1; load(..., strict=False) "
        "accepts the file and leaves them out"
    )
    warnings = read(FORCES, strict=False).warnings
    assert len(warnings) == 8
    assert "springs of 1 joint (d) left out: Scene(..., elements=described" in warnings[0]
    assert "joint 'd': damping 1 2 left out of the wrenches" in warnings[3]
    same_as_urdf(cd.load(FORCES.replace(' stiffness="3"', ""), strict=False))


def forces(sections: str = "") -> Forces:
    """Return a collector that has read all sections of a file."""
    root = fromstring(f"<mujoco>{sections}</mujoco>")
    collected = Forces(DefaultClasses(root, "x"), "x")
    collected.of_sections(root)
    return collected


def test_a_file_without_forces() -> None:
    assert forces().left_out(strict=True) == []
    quiet = (
        '<option gravity="0 0 -9.81" density="0"/><actuator><motor joint="a" gear="2"/></actuator>'
    )
    collected = forces(quiet)
    collected.of_joint({"stiffness": "0", "damping": "0 0 0", "range": "0 1"}, "j")
    collected.of_body({"gravcomp": "0", "pos": "1 2 3"}, "b")
    assert collected.left_out(strict=True) == []


@pytest.mark.parametrize(
    ("note", "force"),
    [
        (lambda item: item.of_joint({"armature": "2"}, "j"), "joint 'j': armature 2"),
        (
            lambda item: item.of_joint({"stiffness": "1 2", "damping": "0 0 3"}, "j"),
            "joint 'j': damping 0 0 3, stiffness 1 2",
        ),
        (lambda item: item.of_joint({"frictionloss": "-1"}, "j"), "joint 'j': frictionloss -1"),
        (
            lambda item: item.of_joint({"springdamper": "1 1"}, "j"),
            "joint 'j': springdamper 1 1",
        ),
        (lambda item: item.of_body({"gravcomp": "0.5"}, "b"), "body 'b': gravcomp 0.5"),
    ],
)
def test_forces_of_joints_and_bodies(note: Callable[[Forces], None], force: str) -> None:
    collected = forces()
    note(collected)
    assert collected.left_out(strict=False) == [f"x: {force} left out of the wrenches"]
    with pytest.raises(cd.ModelError, match=rf"^x: forces that wrenches leave out: {force}; load"):
        collected.left_out(strict=True)


@pytest.mark.parametrize(
    ("sections", "force"),
    [
        ('<option viscosity="1"/>', "option: viscosity 1"),
        ('<option density="1" viscosity="2"/>', "option: density 1, viscosity 2"),
        ('<tendon><spatial stiffness="3"/></tendon>', "tendon 'spatial': stiffness 3"),
        ('<tendon><fixed name="t" damping="3"/></tendon>', "tendon 't': damping 3"),
        (
            '<default><tendon armature="1"/></default><tendon><fixed name="t"/></tendon>',
            "tendon 't': armature 1",
        ),
        (
            '<default><default class="c"><motor damping="2"/></default></default>'
            '<actuator><motor class="c" name="m"/></actuator>',
            "actuator 'm': damping 2",
        ),
        ('<deformable><flex name="f"/></deformable>', "flex 'f'"),
    ],
)
def test_forces_of_other_sections(sections: str, force: str) -> None:
    assert forces(sections).left_out(strict=False) == [f"x: {force} left out of the wrenches"]


@pytest.mark.parametrize(("count", "more"), [(8, ""), (9, "; and 1 more"), (20, "; and 12 more")])
def test_a_message_lists_eight_forces(count: int, more: str) -> None:
    collected = forces()
    for index in range(count):
        collected.of_body({"gravcomp": "1"}, f"b_{index}")
    with pytest.raises(cd.ModelError) as caught:
        collected.left_out(strict=True)
    assert f"body 'b_7': gravcomp 1{more}; load(..., strict=False) accepts" in str(caught.value)
    assert str(caught.value).count("gravcomp") == 8
    assert len(collected.left_out(strict=False)) == count


@pytest.mark.parametrize("value", ["", "1 2 3 4", "x"])
def test_coefficients_that_are_no_numbers(value: str) -> None:
    with pytest.raises(cd.ModelError, match=rf"^x: joint 'j': damping:? '{value}' is not "):
        forces().of_joint({"damping": value}, "j")


def test_what_is_taken_is_not_noted() -> None:
    collected = forces()
    collected.of_joint({"damping": "1", "armature": "2"}, "j", {"damping"})
    assert collected.left_out(strict=False) == ["x: joint 'j': armature 2 left out of the wrenches"]
