"""Where named frames are, and what they move with."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from testkit.sdf import model

import cardan_dyn as cd
from cardan_dyn.practice.formats.sdf.frames import MODEL, WORLD, NamedFrames
from cardan_dyn.practice.formats.sdf.plain import FIRST_WITH_FRAMES, modern

CONTENT = """<pose>1 0 0 0 0 0.5</pose>
<frame name="f" attached_to="j"><pose>0 0 2 0 0 0</pose></frame>
<frame name="g"><pose relative_to="b">0 3 0 0 0 0</pose></frame>
<link name="a"><pose>0 1 0 0.3 0 0</pose></link>
<link name="b"><pose relative_to="a">0 0 1 0 0.4 0</pose></link>
<joint name="j" type="fixed"><pose>0 0 0.5 0 0 0</pose><parent>a</parent><child>b</child></joint>
<joint name="k" type="fixed"><pose relative_to="g">0 0 0.5 0 0 0</pose><parent>a</parent>
<child>f</child></joint>"""


def frames(text: str, version: tuple[int, int] = (1, 9)) -> NamedFrames:
    element = ElementTree.fromstring(text).find("model")
    assert element is not None
    modern(element, version, "at")
    return NamedFrames(element, "at", version >= FIRST_WITH_FRAMES)


def at(x: float, y: float, z: float, *angles: float) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(*(angles or (0.0, 0.0, 0.0))), np.array([x, y, z]))


def test_placements() -> None:
    found = frames(model(CONTENT))
    whole = at(1, 0, 0, 0, 0, 0.5)
    a = whole * at(0, 1, 0, 0.3, 0, 0)
    b = a * at(0, 0, 1, 0, 0.4, 0)
    expected = {
        MODEL: whole,
        WORLD: at(0, 0, 0),
        **{"a": a, "b": b, "g": b * at(0, 3, 0), "f": b * at(0, 0, 2.5), "j": b * at(0, 0, 0.5)},
    }
    for name, placement in expected.items():
        np.testing.assert_allclose(found.placement(name, "x"), placement.homogeneous, atol=1e-15)
    k = expected["g"] * at(0, 0, 0.5)
    np.testing.assert_allclose(found.joint_placement("k", "x"), k.homogeneous, atol=1e-15)


def test_links_of_frames() -> None:
    found = frames(model(CONTENT))
    links = {name: found.link(name, "x") for name in (*"abfgjk", MODEL, WORLD)}
    assert links == {
        **{"a": "a", "b": "b", "f": "b", "g": "a", "j": "b", "k": "b"},
        **{MODEL: "a", WORLD: WORLD},
    }
    other = frames(model(CONTENT).replace('name="m"', 'name="m" canonical_link="b"'))
    assert (other.canonical, other.link("g", "x")) == ("b", "b")


def test_a_frame_of_the_model_is_placed() -> None:
    text = model(CONTENT).replace('name="m"', 'name="m" placement_frame="g"')
    found = frames(text)
    expected = at(1, 0, 0, 0, 0, 0.5).homogeneous
    np.testing.assert_allclose(found.placement("g", "x"), expected, atol=1e-15)
    a = at(0, 1, 0, 0.3, 0, 0)
    g = a * at(0, 0, 1, 0, 0.4, 0) * at(0, 3, 0)
    np.testing.assert_allclose(
        found.placement("a", "x"), expected @ (g.inverse() * a).homogeneous, atol=1e-15
    )


def test_older_versions_name_other_things() -> None:
    old = '<link name="a"/><link name="b"><pose frame="a">1 0 0 0 0 0</pose></link>'
    joint = '<joint name="a" type="fixed"><parent>a</parent><child>b</child></joint>'
    found = frames(model(old + joint), (1, 6))
    assert found.joint_placement("a", "x")[0, 3] == 1.0
    assert found.placement("a", "x")[0, 3] == 0.0
    with pytest.raises(cd.ModelError, match="the attribute is called 'relative_to'"):
        frames(model(old))
    with pytest.raises(cd.ModelError, match="the attribute is called 'frame'"):
        frames(model(old.replace("frame=", "relative_to=")), (1, 6))
    with pytest.raises(cd.ModelError, match="link, joint or frame names that occur twice: a"):
        frames(model(old.replace("frame=", "relative_to=") + joint))


LINK = '<link name="a"/>'


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the model has no <link>"),
        ("<link/>", "a <link> has no name"),
        (LINK + LINK, "link or frame names that occur twice: a"),
        (LINK + '<frame name="a"/>', "link or frame names that occur twice: a"),
        ('<link name="world"/>', "the name 'world' is reserved"),
        ('<link name="__a__"/>', "the name '__a__' is reserved"),
        (LINK + '<pose relative_to="a">0 0 0 0 0 0</pose>', "only a pose in the world is read"),
    ],
)
def test_refused(content: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        frames(model(content))


def test_names_that_lead_nowhere() -> None:
    ring = '<link name="b"><pose relative_to="f"/></link><frame name="f" attached_to="g">'
    ring += '<pose relative_to="b"/></frame><frame name="g" attached_to="f"/>'
    found = frames(model(LINK + ring))
    with pytest.raises(cd.ModelError, match="x: the pose of 'b' is stated relative to itself"):
        found.placement("b", "x")
    with pytest.raises(cd.ModelError, match="x: the frame 'f' is attached to itself"):
        found.link("f", "x")
    with pytest.raises(
        cd.ModelError, match="x: frame 'c' does not exist; frames: __model__, a, b, f, g"
    ):
        found.placement("c", "x")
    with pytest.raises(cd.ModelError, match="x: frame 'c' does not"):
        found.link("c", "x")
    with pytest.raises(cd.ModelError, match="at: 'b': the pose of 'b' is stated relative to"):
        found.check()
    text = model(LINK).replace('name="m"', 'name="m" canonical_link="c"')
    with pytest.raises(cd.ModelError, match="canonical link 'c' does not exist; links: a"):
        frames(text)
    still = model(LINK + '<frame name="f" attached_to="world"/>')
    with pytest.raises(cd.ModelError, match="placement_frame: 'f' does not move with the model"):
        frames(still.replace('name="m"', 'name="m" placement_frame="f"'))
