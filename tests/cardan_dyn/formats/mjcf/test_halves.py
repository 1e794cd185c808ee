"""Bodies of MJCF that carry the joints of loops: a share of their successor's inertia."""

from __future__ import annotations

from xml.etree.ElementTree import fromstring

import numpy as np
import pinocchio as pin
import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.bodies import bodies_of
from cardan_dyn.core.description.description import Description
from cardan_dyn.core.description.read import read
from cardan_dyn.practice.formats.mjcf.writer import to_mjcf

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


def weighed(description: Description) -> dict[str, pin.Inertia]:
    """Return the inertias that bodies are written with, by name, in their own frames."""
    found = {}
    for body in fromstring(to_mjcf(description)).iter("body"):
        inertial = body.find("inertial")
        if inertial is None:
            continue
        centre, tensor = (
            np.array(inertial.get(name, "").split(), dtype=float) for name in ("pos", "fullinertia")
        )
        if len(tensor):
            xx, yy, zz, xy, xz, yz = tensor
            matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            matrix = np.diag(np.array(inertial.get("diaginertia", "").split(), dtype=float))
        found[body.get("name", "")] = pin.Inertia(float(inertial.get("mass", "")), centre, matrix)
    return found


def test_each_carries_a_share_of_the_successor() -> None:
    """Against Pinocchio's sum of inertias; a ball without a rotor is a `connect` by itself."""
    description = described(
        LOOP.format("one", "continuous", "base", "tip"),
        LOOP.format("two", "universal", "base", "arm").replace(
            "</loop>", '<axis xyz="1 0 0"/><axis2 xyz="0 1 0"/></loop>'
        ),
        LOOP.format("three", "spherical", "base", "arm"),
    )
    arm, whole = bodies_of(description)["arm"], pin.Inertia.Zero()
    for link, placement in arm.links:
        if link.mass:
            own = pin.Inertia(link.mass, link.centre, link.inertia)
            whole = whole + pin.SE3(placement).act(own)
    found = weighed(description)
    for loop, half in zip(description.loops, ("one_half", "two_half"), strict=False):
        frame = pin.SE3(arm.at(loop.successor)) * pin.SE3(loop.successor_origin)
        expected = frame.actInv(whole)
        assert found[half].mass == pytest.approx(expected.mass / 3.0)
        np.testing.assert_allclose(found[half].lever, expected.lever, atol=1e-14)
        np.testing.assert_allclose(found[half].inertia, expected.inertia / 3.0, atol=1e-14)
    assert (found["arm"].mass, found["hand"].mass, found["lid"].mass) == (2 / 3, 1 / 3, 4.0)


def test_a_successor_that_stands_still_lends_no_mass() -> None:
    found = weighed(described(LOOP.format("one", "continuous", "hand", "lid")))
    assert found["one_half"].mass == pytest.approx(7.0 / 3.0)
    np.testing.assert_allclose(found["one_half"].inertia, 7.0 / 3.0 * np.eye(3))
    assert (found["arm"].mass, found["hand"].mass, found["lid"].mass) == (2.0, 1.0, 4.0)


def test_loops_may_be_called_as_links_are() -> None:
    mujoco = pytest.importorskip("mujoco")
    found = {}
    for name in ("one", "hand"):
        description = described(
            LOOP.format(name, "continuous", "base", "tip"),
            LOOP.format("two", "spherical", "base", "hand"),
        )
        model = mujoco.MjModel.from_xml_string(to_mjcf(description))
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        found[name] = data.site_xpos
    np.testing.assert_array_equal(found["one"], found["hand"])


def test_a_massless_successor() -> None:
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><link name="c"/>'
        + JOINT.format("j", "continuous", "a", "b")
        + LINK.format("d", 1)
        + JOINT.format("k", "continuous", "a", "d")
        + JOINT.format("f", "fixed", "b", "c")
        + LOOP.format("l", "continuous", "d", "c")
        + "</robot>"
    )
    with pytest.raises(cd.ModelError, match="link 'b' moves and has no mass"):
        to_mjcf(read(text))
