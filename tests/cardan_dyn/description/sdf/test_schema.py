"""Words that are known, and those that are not."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

import cardan_dyn as cd
from cardan_dyn.description.sdf.schema import ATTRIBUTES, CHILDREN, check_words

LINK = '<sdf version="1.9"><model name="m"><link name="a">{}</link></model></sdf>'


def check(text: str, strict: bool = True) -> list[str]:
    return check_words(ElementTree.fromstring(text), "at", strict)


def test_known_words() -> None:
    inside = '<pose relative_to="b">0 0 0 0 0 0</pose><visual name="v"><anything/></visual>'
    assert check(LINK.format(inside)) == []


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<inertal/>", "<link> 'a': element 'inertal' is unknown; .*did you mean 'inertial'"),
        ('<pose relativ_to="b"/>', "<pose>: attribute 'relativ_to'.*did you mean 'relative_to'"),
        ("<inertial><inertia><lxx>1</lxx></inertia></inertial>", "element 'lxx' is unknown"),
        ('<inertial><mass unit="g">1</mass></inertial>', "<mass>: attribute 'unit' .*: none"),
    ],
)
def test_unknown_words(inside: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        check(LINK.format(inside))
    (warning,) = check(LINK.format(inside), strict=False)
    assert "is unknown and was passed over" in warning


def test_words_of_other_programs_are_named() -> None:
    text = LINK.format("<d:gravity/><d:gravity/>").replace("<sdf ", '<sdf xmlns:d="drake" ')
    (warning,) = check(text)
    assert warning == (
        "at: element '{drake}gravity' of <link> is unknown and was passed over (2 times)"
    )


def test_what_has_attributes_is_a_known_element() -> None:
    known = {"sdf", *(word for words in CHILDREN.values() for word in words)}
    assert set(ATTRIBUTES) <= known | {"xyz"}
    assert set(CHILDREN) <= known
