"""Words of MJCF that are not known are refused, with those that are."""

from __future__ import annotations

from xml.etree.ElementTree import fromstring

import pytest
from testkit.mjcf import of_body

import cardan_dyn as cd
from cardan_dyn.description.mjcf import schema
from cardan_dyn.description.read import read


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (of_body("", head='<compiler eulersec="xyz"/>'), "<compiler> has no attribute eulersec"),
        (of_body("", head="<equalities/>"), "<equalities> in <mujoco> is unknown; elements: act"),
        (of_body("<link/>"), "<link> in <body> is unknown; elements: body, camera"),
        (of_body('<joint axes="0 0 1"/>'), "<joint> has no attribute axes; attributes: actuator"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        read(text)


def test_attributes_of_every_element_that_is_read() -> None:
    for tag, known in schema.ATTRIBUTES.items():
        kind, name = (tag, "joint") if " " in tag else (None, tag)
        stated = " ".join(f'{attribute}="0"' for attribute in known)
        schema.check_attributes(fromstring(f"<{name} {stated}/>"), "x", kind)
        with pytest.raises(
            cd.ModelError, match=rf"^x: <{name}> has no attribute odd; attributes: "
        ):
            schema.check_attributes(fromstring(f'<{name} {stated} odd="0"/>'), "x", kind)


def test_unknown_attributes_are_listed_with_the_known_ones() -> None:
    with pytest.raises(cd.ModelError) as caught:
        schema.check_attributes(fromstring('<include file="a" prefix="b" dir="c"/>'), "x")
    assert str(caught.value) == "x: <include> has no attribute dir, prefix; attributes: file"


def test_attributes_of_elements_that_are_not_read_are_not_checked() -> None:
    schema.check_attributes(fromstring('<camera odd="0"/>'), "x")


def test_a_joint_in_an_equality_has_other_attributes_than_one_in_a_body() -> None:
    element = fromstring('<joint joint1="a" joint2="b" polycoef="0 1 0 0 0"/>')
    schema.check_attributes(element, "x", "equality joint")
    with pytest.raises(cd.ModelError, match="has no attribute joint1, joint2, polycoef"):
        schema.check_attributes(element, "x")


def test_children() -> None:
    schema.check_children(fromstring("<a><b/><c/><b/></a>"), {"b", "c"}, "x")
    with pytest.raises(cd.ModelError, match=r"^x: <d> in <a> is unknown; elements: b, c$"):
        schema.check_children(fromstring("<a><b/><d/></a>"), {"c", "b"}, "x")


def test_keywords() -> None:
    assert schema.keyword("yes", ("yes", "no"), "x: flag") == "yes"
    for value in ("Yes", "", "y"):
        with pytest.raises(
            cd.ModelError, match=rf"^x: flag is '{value}', expected one of yes, no$"
        ):
            schema.keyword(value, ("yes", "no"), "x: flag")


def test_the_lists_do_not_contradict_each_other() -> None:
    """What is refused is not read; what can be placed knows every orientation."""
    assert not set(schema.REFUSED) & schema.CONTENTS
    assert schema.ACTUATORS < schema.DEFAULTS
    for tag in ("body", "frame", "inertial", "geom", "site"):
        assert {"pos", *schema.ORIENTATIONS} <= schema.ATTRIBUTES[tag]
    assert set(schema.ATTRIBUTES) - {"equality joint"} >= {"connect", "weld", "joint", "freejoint"}
