"""Motion text: axes and points that can be read off the description."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.mixed_chain import joint

import cardan_dyn as cd
from cardan_dyn.core.kinematics.diagnosis.imbalance import motion_text


def link(name: str) -> str:
    return f'<link name="{name}"/>'


def chain(*elements: str) -> cd.Mechanism:
    return cd.load(f'<robot name="chain"><link name="base"/>{"".join(elements)}</robot>')


def text(mechanism: cd.Mechanism, most: int = 3, **rates: float) -> str:
    motion = np.zeros(mechanism.model.nv)
    for name, rate in rates.items():
        motion[mechanism.coordinates.velocity_columns[name].start] = rate
    return motion_text(mechanism, mechanism.coordinates.neutral(), motion, most)


def plain(name: str, kind: str, parent: str, child: str, origin: str, axis: str) -> str:
    return joint(name, kind, parent, child, origin, axis).replace(' rpy="0.3 -0.2 0.5"', "")


DOOR = chain(
    link("door"),
    plain("hinge", "continuous", "base", "door", "0.2 0 0.5", "0 0 -1"),
    link("handle"),
    plain("latch", "continuous", "door", "handle", "0.7 0 1", "0 2 0"),
    link("bolt"),
    plain("slide", "prismatic", "door", "bolt", "0.8 0 1", "0.6 0 -0.8"),
)


def test_a_single_link_turns_or_slides() -> None:
    assert text(DOOR, latch=1.0) == "link 'handle' turns about (0, 1, 0) through (0.9, 0, 1.5)"
    # A line has no sign.
    assert text(DOOR, latch=-3.0) == text(DOOR, latch=1.0)
    assert text(DOOR, slide=2.0) == "link 'bolt' slides along (-0.6, 0, 0.8)"


def test_links_that_move_as_one_are_named_together() -> None:
    assert (
        text(DOOR, hinge=0.1)
        == "links bolt, door, handle turn about (0, 0, 1) through (0.2, 0, 0.5)"
    )


def test_sets_of_links_are_described_the_greatest_first_and_counted() -> None:
    both = text(DOOR, hinge=1.0, latch=1.0)
    assert both.startswith("links bolt, door turn about (0, 0, 1) through (0.2, 0, 0.5), link 'han")
    assert text(DOOR, 1, hinge=1.0, latch=1.0) == (
        "links bolt, door turn about (0, 0, 1) through (0.2, 0, 0.5), 1 more link with them"
    )
    assert text(DOOR, 1, hinge=1.0, latch=1.0, slide=1.0).endswith(", 2 more links with them")


def test_a_screw_turns_and_slides() -> None:
    nut = chain(
        link("nut"),
        plain("slide", "prismatic", "base", "nut", "1 2 3", "1 0 0"),
        link("screw"),
        plain("turn", "continuous", "nut", "screw", "0 0 0", "1 0 0"),
    )
    screw = "link 'screw' turns about (1, 0, 0) through (1, 2, 3) and slides along it"
    assert text(nut, slide=0.1, turn=1.0).endswith(screw)


def test_nothing_moves() -> None:
    assert text(DOOR) == ""


@pytest.mark.parametrize("distance", [1e3, 1e6])
def test_rest_is_seen_far_from_the_worlds_origin(distance: float) -> None:
    far = chain(
        link("mast"),
        plain("turn", "continuous", "base", "mast", f"{distance} 0 0", "0 0 1"),
        link("flag"),
        plain("wave", "continuous", "mast", "flag", "0.5 0 0", "0 0 1"),
        link("rope"),
        plain("pull", "prismatic", "mast", "rope", "0 0 1", "0 0 1"),
    )
    found = text(far, wave=1.0)
    assert found.startswith("link 'flag' turns about (0, 0, 1) through (1")
    assert "rope" not in found
    # A slow link does not rest because another one's axis is far from the world's origin.
    assert "link 'rope' slides along (0, 0, 1)" in text(far, wave=1.0, pull=0.01)


def test_the_axis_of_two_parallel_hinges_lies_where_their_rates_balance() -> None:
    """Rates ω and -2 ω at p and q: the outer link turns about 2 q - p."""
    arm = chain(
        link("upper"),
        plain("shoulder", "continuous", "base", "upper", "0.1 0.2 0", "0 0 1"),
        link("lower"),
        plain("elbow", "continuous", "upper", "lower", "0.4 -0.3 0", "0 0 1"),
    )
    found = text(arm, shoulder=1.0, elbow=-2.0)
    assert "link 'lower' turns about (0, 0, 1) through (0.9, -0.4, 0)" in found
