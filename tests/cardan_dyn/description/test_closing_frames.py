"""Pairs of frames that onshape-to-robot exports are loops: hinges, or balls with a warning."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.linkages import loop
from testkit.other_notations import FRAME, TREE, closing_frames

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.read import read


def framed(text: str) -> Description:
    return read(TREE.format(text))


def test_frames_on_z_make_a_hinge() -> None:
    description = framed(closing_frames())
    (found,) = description.loops
    assert (found.name, found.type) == ("closing_pin", "revolute")
    assert (found.predecessor, found.successor) == ("closing_pin_1", "closing_pin_2")
    assert found.axis.tolist() == [0.0, 0.0, 1.0]
    np.testing.assert_array_equal(found.predecessor_origin, np.eye(4))
    assert description.notation == "closing frames of onshape-to-robot"
    assert not any("taken as" in warning for warning in description.warnings)


def test_a_pair_without_them_is_taken_as_a_ball() -> None:
    text = closing_frames(on_z=False) + closing_frames(on_z=False, name="closing_2_1")
    description = framed(text)
    assert [(item.name, item.type) for item in description.loops] == [
        ("closing_pin", "spherical"),
        ("closing_2_1", "spherical"),
    ]
    assert description.warnings[-1] == (
        "URDF text: closing frames do not state the type of closing_2_1, closing_pin: taken as "
        "spherical; write <loop> where it is another one"
    )


def test_another_notation_counts_more() -> None:
    """Frames are mere names; a `<loop>` says what is meant."""
    text = closing_frames(first="3 2 0") + loop("fixed").replace("ROCKER", "2.5")
    description = framed(text)
    assert [(item.name, item.type) for item in description.loops] == [("c", "fixed")]
    assert description.notation == "URDF+ <loop>; closing frames are not used"


def test_frames_without_a_partner_are_named() -> None:
    alone = FRAME.format(name="closing_x_2", body="coupler", xyz="1 0 0", rpy="0 0 0")
    description = framed(alone)
    assert description.loops == ()
    assert description.warnings[-1] == (
        "URDF text: frame 'closing_x_2' closes no loop: there is no link 'closing_x_1' that is "
        "fixed to a body"
    )
    moving = closing_frames(on_z=False).replace(
        '<joint name="closing_pin_1_frame" type="fixed">',
        '<joint name="closing_pin_1_frame" type="continuous">',
    )
    description = framed(moving.replace("0 0 0", "0 0 1"))
    assert description.loops == ()
    assert sum("no link 'closing_pin_1'" in warning for warning in description.warnings) == 2


def test_other_links_are_no_frames() -> None:
    for name in ("closing_1", "my_closing_a_1", "closing_a_3", "closing_a_1_z", "Closing_a_1"):
        text = FRAME.format(name=name, body="coupler", xyz="1 0 0", rpy="0 0 0")
        assert not any("closes no loop" in warning for warning in framed(text).warnings)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.0 2.5 0.1", "0.0 2.6 0.1", "'closing_pin_2_z' does not lie on the z-axis of 'closing"),
        ("0.0 2.5 0.1", "0.0 2.5 -0.1", "'closing_pin_2_z' does not lie on the z-axis"),
        ("0.0 2.5 0.1", "0.0 2.5 0.0", "'closing_pin_2_z' does not lie on the z-axis"),
        ('"closing_pin_1_z"', '"other"', "'closing_pin_1_z' is not fixed to the body of 'closing"),
    ],
)
def test_frames_on_z_that_are_elsewhere(old: str, new: str, message: str) -> None:
    text = closing_frames()
    assert old in text
    with pytest.raises(cd.ModelError, match=f"URDF text: frame {message}"):
        framed(text.replace(old, new))
