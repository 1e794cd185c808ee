"""Gearboxes and axes that mimic others."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.sdf import massive, model

import cardan_dyn as cd
from cardan_dyn.core.description.read import read

LINKS = "".join(
    f'<link name="{name}"><pose>{x} 0 0 0 0 0.2</pose>{massive(1.0, "0 0 0")}</link>'
    for x, name in enumerate(("ground", "one", "two", "three", "lid"))
)


def joint(name: str, kind: str, parent: str, child: str, axis: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"<axis>{axis}</axis></joint>"
    )


Z = "<xyz>0 0 1</xyz>"


def hinges(sense: int = 1, of_a: str = "", of_b: str = "", of_c: str = "") -> str:
    """Return the joints: a about a z axis of either sense; more words in the axes of b and c."""
    return (
        joint("s", "fixed", "world", "ground", Z)
        + joint("a", "revolute", "ground", "one", f"<xyz>0 0 {sense}</xyz>" + of_a)
        + joint("b", "continuous", "ground", "two", Z + of_b)
        + joint("c", "prismatic", "one", "three", Z + of_c)
        + joint("l", "fixed", "two", "lid", Z)
    )


GEAR = """<joint name="g" type="gearbox"><parent>{parent}</parent><child>{child}</child>
<gearbox_reference_body>{base}</gearbox_reference_body>{ratio}<axis><xyz>{axis}</xyz></axis>
<axis2><xyz>0 0 1</xyz></axis2></joint>"""
PLAIN = {
    "parent": "one",
    "child": "two",
    "base": "ground",
    "ratio": "<gearbox_ratio>3</gearbox_ratio>",
    "axis": "0 0 1",
}


def gears(sense: int = 1, **changes: str) -> str:
    return model(LINKS + hinges(sense) + GEAR.format(**{**PLAIN, **changes}))


@pytest.mark.parametrize(
    ("sense", "changes", "ratio"),
    [
        (1, {}, -3.0),
        (-1, {}, 3.0),
        (1, {"axis": "0 0 -2"}, 3.0),
        (-1, {"axis": "0 0 -2"}, -3.0),
        (1, {"ratio": ""}, -1.0),
        (1, {"child": "lid"}, -3.0),
    ],
)
def test_gearboxes(sense: int, changes: dict[str, str], ratio: float) -> None:
    description = read(gears(sense, **changes))
    (found,) = description.couplings
    assert (found.name, found.predecessor, found.successor) == ("g", "one", "two")
    assert found.ratio == ratio
    assert "g" not in {joint.name for joint in description.joints}
    turn = cd.Scene(cd.Mechanism(description), drive=["a", "c"]).sweep([[0.1, 0.0]])
    np.testing.assert_allclose(turn.motion.position("b"), 0.1 * ratio, rtol=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"base": "one"}, "axis: no hinge of the tree turns 'one' on the reference body 'one'"),
        ({"parent": "three"}, "axis: no hinge of the tree turns 'three'"),
        ({"axis": "0 1 1"}, "axis: it is not parallel to the axis of the hinge 'a'"),
        ({"parent": "lid"}, "only two joints on the same body .* not 'b' on 'ground' and 'b'"),
        ({"ratio": "<gearbox_ratio>0</gearbox_ratio>"}, "a ratio of zero"),
        ({"base": ""}, "<gearbox_reference_body> is missing"),
        ({"base": "x"}, "gearbox_reference_body: frame 'x' does not exist"),
    ],
)
def test_gearboxes_that_are_refused(changes: dict[str, str], message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"joint 'g'.*{message}"):
        read(gears(**changes))


def mimic(
    leader: str = "a",
    axis: str = "axis",
    ratio: float = -0.5,
    offset: float = 0.0,
    reference: float = 0.0,
) -> str:
    return (
        f'<mimic joint="{leader}" axis="{axis}"><multiplier>{ratio}</multiplier>'
        f"<offset>{offset}</offset><reference>{reference}</reference></mimic>"
    )


def test_mimic() -> None:
    description = read(model(LINKS + hinges(of_b=mimic())))
    (found,) = description.couplings
    assert (found.name, found.predecessor, found.successor) == ("b_mimic", "a", "b")
    assert (found.ratio, found.offset, found.of_joints) == (-0.5, 0.0, True)
    turn = cd.Scene(cd.Mechanism(description), drive=["a", "c"]).sweep([[0.1, 0.0]])
    np.testing.assert_allclose(turn.motion.position("b"), -0.05, rtol=1e-13)
    (plain,) = read(model(LINKS + hinges(of_b='<mimic joint="a"/>'))).couplings
    assert plain.ratio == 1.0


def test_joints_on_different_bodies_may_mimic_each_other() -> None:
    """What a joint mimics is the other one's coordinate, wherever that joint is."""
    text = model(LINKS + hinges(of_c=mimic(offset=0.3, reference=0.2)))
    (found,) = read(text).couplings
    assert (found.predecessor, found.successor) == ("a", "c")
    assert found.offset == pytest.approx(0.4, abs=1e-15)
    turn = cd.Scene(cd.load(text), drive=["a", "b"]).sweep([[0.1, 0.0]])
    # offset + multiplier (a - reference)
    np.testing.assert_allclose(turn.motion.position("c"), 0.3 - 0.5 * (0.1 - 0.2), rtol=1e-13)


def test_mimics_in_a_circle_are_refused() -> None:
    with pytest.raises(cd.ModelError, match="joints mimic each other in a circle"):
        read(model(LINKS + hinges(of_b=mimic(), of_a=mimic("b"))))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"leader": "x"}, "'x' is no joint of the tree with one axis; .*: a, b, c"),
        ({"leader": "s"}, "'s' is no joint of the tree with one axis"),
        ({"leader": "b"}, "a joint cannot mimic itself"),
        ({"axis": "axis2"}, "only joints with one axis can be coupled"),
        ({"ratio": 0.0}, "a ratio of zero"),
    ],
)
def test_mimics_that_are_refused(changes: dict, message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"joint 'b': axis: mimic: {message}"):
        read(model(LINKS + hinges(of_b=mimic(**changes))))


def test_an_offset_that_its_reference_makes_up_for() -> None:
    text = model(LINKS + hinges(of_b=mimic(offset=-0.5, reference=-1.0, ratio=0.5)))
    (found,) = read(text).couplings
    assert (found.ratio, found.offset) == (0.5, 0.0)
