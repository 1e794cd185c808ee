"""`<mimic>` of URDF: what is read, how it is named and written, and what is refused."""

from __future__ import annotations

import pytest
from testkit.linkages import gears
from testkit.mimicking import finger, mimic

import cardan_dyn as cd
from cardan_dyn.core.description.description import CouplingDescription
from cardan_dyn.core.description.mimics import check_mimics
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.second_reading import reread


def test_numbers_have_defaults() -> None:
    (found,) = read(finger('<mimic joint="knuckle"/>')).couplings
    assert found == CouplingDescription("middle_mimic", "knuckle", "middle", 1.0, 0.0, True)
    odd = '<mimic offset=" +.5e1 " joint="plunger" multiplier="-1."/>'
    description = read(finger(odd))
    assert description.couplings == (
        CouplingDescription("middle_mimic", "plunger", "middle", -1.0, 5.0, True),
    )
    assert reread(description).couplings == description.couplings


def test_names_keep_apart() -> None:
    """A mimic has a name of its own, or one that nothing else has."""
    text = finger(mimic("knuckle"), '<mimic joint="knuckle" name="middle_mimic"/>')
    found = read(text).couplings
    assert [item.name for item in found] == ["middle_mimic_2", "middle_mimic"]
    again = read(cd.load(text).to_urdf()).couplings
    assert again == found
    with pytest.raises(cd.ModelError, match="names that occur twice: knuckle"):
        read(finger('<mimic joint="knuckle" name="knuckle"/>'))


def test_couplings_of_links_come_first() -> None:
    text = gears().replace("</robot>", "{}</robot>")
    link = '<coupling name="z"><predecessor link="wheel_a"/><successor link="wheel_b"/>'
    text = text.format(link + '<ratio value="2"/></coupling>')
    text = text.replace('name="a" type="continuous">', f'name="a" type="continuous">{mimic("b")}')
    assert [(item.name, item.of_joints) for item in read(text).couplings] == [
        ("z", False),
        ("a_mimic", True),
    ]


@pytest.mark.parametrize(
    ("middle", "message"),
    [
        ("<mimic/>", 'joint="..." is missing; joints: knuckle, middle, plunger'),
        ('<mimic joint=""/>', 'joint="..." is missing'),
        (mimic("knukle"), "joint 'knukle' does not exist; .*did you mean 'knuckle'"),
        (mimic("middle"), "a joint cannot mimic itself; name another one"),
        (mimic("knuckle", 0.0), "a ratio of zero would hold the successor"),
        ('<mimic joint="knuckle" multiplier="x"/>', "multiplier: 'x' is not 1 finite"),
        ('<mimic joint="knuckle" offset="nan"/>', "offset: 'nan' is not 1 finite"),
        ('<mimic joint="knuckle" offset="1 2"/>', "offset: '1 2' is not 1 finite"),
    ],
)
def test_refused(middle: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=f"URDF text: joint 'middle': <mimic>.*{message}"):
        read(finger(middle))


def test_two_mimics_and_misspelled_ones_are_refused() -> None:
    with pytest.raises(cd.ModelError, match="there are 2 <mimic> in <joint>; keep one"):
        read(finger(mimic("knuckle") + mimic("plunger")))
    with pytest.raises(cd.ModelError, match=r"'ofset' is unknown; did you mean 'offset'"):
        read(finger('<mimic joint="knuckle" ofset="1"/>'))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("knuckle", "fixed"),
        *((name, kind) for name in ("knuckle", "middle") for kind in ("planar", "spherical")),
        *((name, kind) for name in ("knuckle", "middle") for kind in ("floating", "cylindrical")),
    ],
)
def test_joints_without_exactly_one_coordinate(name: str, kind: str) -> None:
    text = finger(mimic("knuckle"))
    text = text.replace(f'name="{name}" type="continuous"', f'name="{name}" type="{kind}"')
    with pytest.raises(cd.ModelError, match=f"joint '{name}' is {kind}; only joints with one"):
        read(text)


def test_fixed_joints_follow_nothing() -> None:
    """As in robots whose grippers were fixed, whatever their joints mimic."""
    for mimicked in ("plunger", "knuckle", "nothing"):
        text = finger(mimic(mimicked)).replace(
            '"middle" type="continuous"', '"middle" type="fixed"'
        )
        description = read(text)
        assert description.couplings == ()
        assert description.warnings[0] == (
            "URDF text: <mimic> of 1 joint (middle) left out: fixed joints follow nothing"
        )


def test_circles() -> None:
    with pytest.raises(
        cd.ModelError, match="in a circle: middle -> plunger -> middle; remove one <mimic>"
    ):
        read(finger(mimic("plunger"), mimic("middle")))


def test_a_joint_that_leads_into_a_circle_is_not_part_of_it() -> None:
    ends = (("a", "b"), ("b", "c"), ("c", "b"))
    couplings = [
        CouplingDescription(f"{one}{other}", other, one, 1.0, 0.0, True) for one, other in ends
    ]
    with pytest.raises(cd.ModelError, match="here: joints mimic each other in a circle: b -> c"):
        check_mimics(couplings, "here")
    twice = CouplingDescription("again", "c", "a", 1.0, 0.0, True)
    with pytest.raises(cd.ModelError, match="joint 'a' mimics 'b' and 'c'; let it mimic one"):
        check_mimics([couplings[0], twice], "here")


def test_what_mjcf_can_and_urdf_cannot_say() -> None:
    """MJCF may couple a joint twice, or joints in a circle; a URDF of it is refused."""
    bodies = "".join(
        f'<body><joint name="{name}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
        for name in "abc"
    )
    text = f"<mujoco><worldbody>{bodies}</worldbody><equality>{{}}</equality></mujoco>"
    link = '<joint name="{0}{1}" joint1="{0}" joint2="{1}" polycoef="{2} {3} 0 0 0"/>'
    once = cd.load(text.format(link.format("a", "b", 0.5, 2) + link.format("c", "a", 0, -1)))
    assert cd.load(once.to_urdf()).description.couplings == once.description.couplings
    circle = cd.load(text.format(link.format("a", "b", 0, 2) + link.format("b", "a", 0, 0.5)))
    assert cd.Scene(circle, drive=["a", "c"]).sweep([[1.0, 0.0]]).motion.position("b") == 0.5
    with pytest.raises(cd.ModelError, match="in a circle: a -> b -> a"):
        circle.to_urdf()
