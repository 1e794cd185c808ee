"""Four-bars in MJCF have the wrenches of the same four-bar in URDF+."""

from __future__ import annotations

import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, same_as_urdf

import cardan_dyn as cd


@pytest.mark.parametrize("kind", CONNECTS)
def test_connect(kind: str) -> None:
    text = HALVES.format(rocker=ROCKER, more=f"<equality>{CONNECTS[kind]}</equality>")
    mechanism = cd.load(text)
    assert mechanism.notation == "MJCF <equality>"
    same_as_urdf(mechanism, -1.0 if kind == "swapped" else 1.0)


def test_a_pin_welded_to_a_link_is_a_hinge() -> None:
    """The pin turns on the coupler and is welded to the rocker: joint c is its hinge."""
    axle = '<body name="pin" pos="2 2 0"><joint name="c"/></body>'
    text = HALVES.format(
        rocker=ROCKER, more='<equality><weld name="w" body1="pin" body2="rocker"/></equality>'
    ).replace('<joint name="b"/>', f'<joint name="b"/>{axle}')
    same_as_urdf(cd.load(text), kind="continuous")
