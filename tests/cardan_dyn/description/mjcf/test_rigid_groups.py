"""Links that move as one, and how their inertia is split."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.mjcf.writer import RigidGroups
from cardan_dyn.core.description.read import read

LINK = """<link name="{}"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><mass value="{}"/>
<inertia ixx="1" iyy="1.5" izz="2"/></inertial></link>"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>
<origin xyz="1 2 3" rpy="0.4 0.5 0.6"/><axis xyz="0 0 1"/></joint>"""
LOOP = """<loop name="{}" type="{}"><predecessor link="{}"/><successor link="{}">
<origin xyz="0.5 0 0" rpy="0.7 0 0"/></successor></loop>"""


def described(*loops: str) -> Description:
    """Return `base`, on it `arm` with `hand` and `tip` fixed in a row, and `lid` fixed to base."""
    parts = [
        '<link name="base"/>',
        *(LINK.format(name, mass) for name, mass in (("arm", 2), ("hand", 1), ("lid", 4))),
        '<link name="tip"/>',
        JOINT.format("f2", "fixed", "hand", "tip"),
        JOINT.format("j", "continuous", "base", "arm"),
        JOINT.format("f1", "fixed", "arm", "hand"),
        JOINT.format("f3", "fixed", "base", "lid"),
    ]
    return read(f'<robot name="r">{"".join([*parts, *loops])}</robot>')


def test_groups() -> None:
    groups = RigidGroups(described())
    step = pin.SE3(pin.rpy.rpyToMatrix(0.4, 0.5, 0.6), np.array([1.0, 2.0, 3.0]))
    for name, placement in (("arm", pin.SE3.Identity()), ("hand", step), ("tip", step * step)):
        np.testing.assert_allclose(groups.placements[name], placement.homogeneous, atol=1e-14)
        assert [link.name for link in groups.members(name)] == ["arm", "hand", "tip"]
        assert (groups.mass(name), groups.is_fixed(name), groups.shares(name)) == (3.0, False, 1)
        assert [joint.name for joint in groups.path(name)] == ["j"]
    assert groups.is_fixed("lid")
    assert groups.path("lid") == []
    assert groups.links["hand"].mass == 1.0


def test_helpers_carry_a_share_of_the_successor() -> None:
    """Against Pinocchio's sum of inertias."""
    loops = [
        LOOP.format("one", "continuous", "base", "tip"),
        LOOP.format("two", "universal", "base", "arm").replace(
            "</loop>", '<axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></loop>'
        ),
        LOOP.format("three", "spherical", "base", "arm"),
    ]
    description = described(*loops)
    groups = RigidGroups(description)
    assert groups.shares("hand") == 3
    links = {link.name: link for link in description.links}
    whole = pin.Inertia.Zero()
    for name in ("arm", "hand"):
        link = links[name]
        placement = pin.SE3(groups.placements[name])
        whole = whole + placement.act(pin.Inertia(link.mass, link.centre, link.inertia))
    loop = description.loops[0]
    frame = pin.SE3(groups.placements["tip"]) * pin.SE3(loop.successor_origin)
    expected = frame.actInv(whole)
    found = groups.helper(loop, "half")
    assert found.name == "half"
    assert found.mass == pytest.approx(expected.mass / 3.0)
    np.testing.assert_allclose(found.centre, expected.lever, atol=1e-14)
    np.testing.assert_allclose(found.inertia, expected.inertia / 3.0, atol=1e-14)


def test_a_successor_that_stands_still_lends_no_mass() -> None:
    description = described(LOOP.format("one", "continuous", "hand", "lid"))
    groups = RigidGroups(description)
    assert groups.shares("lid") == 1
    found = groups.helper(description.loops[0], "half")
    assert found.mass == pytest.approx(7.0 / 3.0)
    np.testing.assert_allclose(found.inertia, found.mass * np.eye(3))


def test_a_massless_successor() -> None:
    text = (
        '<robot name="r"><link name="a"/><link name="b"/>'
        + JOINT.format("j", "continuous", "a", "b")
        + LOOP.format("l", "continuous", "a", "b")
        + "</robot>"
    )
    description = read(text)
    with pytest.raises(cd.ModelError, match="loop 'l': its successor 'b' moves and has no mass"):
        RigidGroups(description).helper(description.loops[0], "half")
