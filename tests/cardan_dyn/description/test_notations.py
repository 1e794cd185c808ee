"""Loops in several notations: which one is used, and what they may not contradict."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.beside import Beside
from cardan_dyn.core.description.notations import agreed

LINKS = ("a", "b", "c")
URDF_PLUS = '<loop name="{}" type="{}"><predecessor link="{}"/><successor link="{}"/></loop>'
ISAAC = (
    '<loop_joint name="{}" type="{}"><link1 link="{}" xyz="1 2 3"/><link2 link="{}"/></loop_joint>'
)


def robot(*elements: str) -> Element:
    return fromstring(f"<robot>{''.join(elements)}</robot>")


def test_a_tree_has_no_loops() -> None:
    assert agreed(robot(), LINKS, None, "x") == ((), "no loops", ())


def test_loops_keep_their_order_and_their_notation() -> None:
    urdf = robot(
        URDF_PLUS.format("m", "fixed", "a", "b"), URDF_PLUS.format("l", "planar", "b", "c")
    )
    loops, notation, _ = agreed(urdf, LINKS, None, "x")
    assert notation == "URDF+ <loop>"
    assert [(item.name, item.type, item.predecessor, item.successor) for item in loops] == [
        ("m", "fixed", "a", "b"),
        ("l", "planar", "b", "c"),
    ]


def test_isaac_places_the_loop_by_attributes_of_its_sides() -> None:
    urdf = robot(ISAAC.format("l", "spherical", "c", "a"))
    (item,), notation, _ = agreed(urdf, LINKS, None, "x")
    assert notation == "Isaac <loop_joint>"
    assert (item.predecessor, item.successor) == ("c", "a")
    assert item.predecessor_origin[:3, 3].tolist() == [1.0, 2.0, 3.0]
    np.testing.assert_array_equal(item.successor_origin, np.eye(4))


@pytest.mark.parametrize("swapped", [False, True])
def test_the_first_of_three_notations_is_used(swapped: bool) -> None:
    """Whichever link is the predecessor: the pairs of links are compared."""
    ends = ("b", "a") if swapped else ("a", "b")
    (other,), *_ = agreed(robot(URDF_PLUS.format("o", "fixed", "b", "a")), LINKS, None, "x")
    extra = Beside(Path("robot.yaml"), "Gepetto robot.yaml", "", (other,))
    plus = URDF_PLUS.format("l", "fixed", "a", "b")
    isaac = ISAAC.format("m", "fixed", *ends)
    loops, notation, _ = agreed(robot(isaac, plus), LINKS, extra, "x")
    assert [item.name for item in loops] == ["l"]
    assert notation == (
        "URDF+ <loop>; Isaac <loop_joint> closes the same links and is not used; "
        "Gepetto robot.yaml closes the same links and is not used"
    )
    loops, notation, _ = agreed(robot(isaac), LINKS, extra, "x")
    assert [item.name for item in loops] == ["m"]
    assert (
        notation == "Isaac <loop_joint>; Gepetto robot.yaml closes the same links and is not used"
    )


@pytest.mark.parametrize(
    "isaac",
    [
        ISAAC.format("m", "fixed", "a", "c"),
        ISAAC.format("m", "fixed", "a", "b") * 2,
    ],
)
def test_notations_that_contradict_each_other(isaac: str) -> None:
    plus = URDF_PLUS.format("l", "fixed", "a", "b")
    message = r"x: URDF\+ <loop> and Isaac <loop_joint> close different loops: \('a', 'b'\) against"
    with pytest.raises(cd.ModelError, match=message):
        agreed(robot(plus, isaac), LINKS, None, "x")


def test_what_a_file_beside_says_is_used_last() -> None:
    (other,), *_ = agreed(robot(URDF_PLUS.format("o", "fixed", "b", "a")), LINKS, None, "x")
    extra = Beside(Path("loop_closures.yaml"), "loop_closures.yaml", "", (other,))
    assert agreed(robot(), LINKS, extra, "x") == ((other,), "loop_closures.yaml", ())
    with pytest.raises(cd.ModelError, match=r"Isaac <loop_joint> and loop_closures.yaml close"):
        agreed(robot(ISAAC.format("m", "fixed", "a", "c")), LINKS, extra, "x")
