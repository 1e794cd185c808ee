"""Models: versions, links, what floats, what stands still, what is refused."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from testkit.sdf import four_bar, massive, model

import cardan_dyn as cd
from cardan_dyn.core.description.read import read

LINK = f'<link name="a">{massive(1.0, "0 0 0")}</link>'
STAND = '<joint name="s" type="fixed"><parent>world</parent><child>a</child></joint>'


def test_a_file(tmp_path: Path) -> None:
    path = tmp_path / "four bar.sdf"
    path.write_text('<?xml version="1.0"?>\n<!-- SDF -->\n' + four_bar(), encoding="utf-8")
    mechanism = cd.load(path)
    assert mechanism.description == read(four_bar())
    assert (mechanism.name, mechanism.notation) == ("four_bar", "SDF joints beyond a tree")
    assert list(mechanism) == ["a", "b", "d", "c"]
    assert mechanism.description.order == ("a", "b", "d")
    assert pickle.loads(pickle.dumps(mechanism)).description == mechanism.description
    assert copy.deepcopy(mechanism).description == mechanism.description
    assert mechanism.description.root == "world"


def test_inertia_in_a_turned_frame() -> None:
    inertial = massive(2.0, "1 2 3").replace("0 0 0</pose>", "0.3 0.4 0.5</pose>")
    description = read(model(f'<link name="a">{inertial}</link>{STAND}'))
    link = description.links[1]
    turn = pin.rpy.rpyToMatrix(0.3, 0.4, 0.5)
    assert (link.name, link.mass, link.centre.tolist()) == ("a", 2.0, [1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        link.inertia, turn @ np.diag([0.02, 0.03, 0.025]) @ turn.T, atol=1e-17
    )


def test_what_sdf_adds_by_itself() -> None:
    bare = read(model(f'<link name="a"/>{STAND}'))
    assert (bare.links[1].mass, bare.links[1].inertia.tolist()) == (1.0, np.eye(3).tolist())
    assert "link 'a': without <inertial>, SDF gives it 1 kg and 1 kg·m²" in bare.warnings[0]
    half = read(model(f'<link name="a"><inertial><mass>3</mass></inertial></link>{STAND}'))
    assert (half.links[1].mass, half.links[1].inertia.tolist()) == (3.0, np.eye(3).tolist())
    assert "link 'a': without <inertia>" in half.warnings[0]


def test_masses_of_zero() -> None:
    zero = "<inertial><mass>0</mass><inertia><ixx>{0}</ixx><iyy>{0}</iyy><izz>{0}</izz>"
    text = model(f'<link name="a">{zero}</inertia></inertial></link>{STAND}')
    assert read(text.format(0)).links[1].mass == 0.0
    assert read(text.format(0)).warnings == ()
    with pytest.raises(cd.ModelError, match="mass 0 kg is not positive; a massless link has"):
        read(text.format(1))
    accepted = read(text.format(1), strict=False)
    assert (accepted.links[1].mass, accepted.links[1].inertia.tolist()) == (0.0, np.eye(3).tolist())
    assert "mass 0 kg: an inertia without mass" in accepted.warnings[0]


def test_inertias_that_no_body_can_have() -> None:
    text = model(f"{LINK}{STAND}").replace("<ixx>0.02</ixx>", "<ixx>2</ixx>")
    with pytest.raises(cd.ModelError, match=r"link 'a': principal moments .* triangle inequality"):
        read(text)
    assert "triangle inequality" in read(text, strict=False).warnings[0]


def test_a_free_model_floats() -> None:
    """As in SDF: nothing holds it. It falls as a body falls, and a warning says what to add."""
    text = model(LINK.replace('"a">', '"a"><pose>1 2 3 0 0 0.5</pose>'))
    description = read(text)
    (joint,) = description.joints
    assert (joint.name, joint.type, joint.parent, joint.child) == (
        *("a_floating", "floating", "world", "a"),
    )
    assert joint.origin[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert "link 'a' floats (joint 'a_floating')" in description.warnings[0]
    assert '<joint type="fixed"> with parent world holds it' in description.warnings[0]
    held = read(text.replace("</model>", f"{STAND}</model>"))
    assert (held.joints[0].type, held.warnings) == ("fixed", ())


def test_generated_names_are_new() -> None:
    joint = '<joint name="a_floating" type="ball"><parent>a</parent><child>b</child></joint>'
    description = read(model(LINK + LINK.replace('"a"', '"b"') + joint))
    assert [item.name for item in description.joints] == ["a_floating_2", "a_floating"]


def test_a_static_model_stands_still() -> None:
    text = four_bar().replace("<link", "<static>true</static><link", 1)
    description = read(text)
    assert {(joint.type, joint.parent) for joint in description.joints} == {("fixed", "world")}
    assert [joint.name for joint in description.joints] == [
        *("crank_fixed", "coupler_fixed", "rocker_fixed"),
    ]
    assert len([text for text in description.warnings if "the model is static" in text]) == 4
    assert not description.loops


def test_worlds() -> None:
    ground = f'<model name="ground"><static>1</static>{LINK}</model>'
    text = four_bar()
    inside = text[text.index("<model") : text.index("</sdf>")]
    inside = f"{ground}{inside}<gravity>0 0 -9</gravity>{{}}"
    world = f'<sdf version="1.9"><world name="w">{inside}</world></sdf>'
    found = read(world.format(""))
    assert found == read(text)
    assert found.warnings == ("SDF text: static model 'ground' left out",)
    include = "<include><uri>model://sun</uri></include>"
    with pytest.raises(cd.ModelError, match="<include> in <world> is not read"):
        read(world.format(include))
    assert "1 <include> of the world left out" in read(world.format(include), False).warnings[1]
    for tag in ("joint", "frame"):
        with pytest.raises(cd.ModelError, match=f"<{tag}> in <world> is not read: write it into"):
            read(world.format(f'<{tag} name="x"/>'), strict=False)
    assert read(f'<sdf version="1.9"><world name="w">{ground}</world></sdf>').name == "ground"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<sdf/>", "<sdf> needs its version, such as 1.9, not ''"),
        ('<sdf version="1"/>', "needs its version"),
        ('<sdf version="1.3"/>', "SDF 1.3 is not read, only versions 1.4 to 1.12"),
        ('<sdf version="1.13"/>', "SDF 1.13 is not read"),
        ('<sdf version="1.9"/>', "there are 0 models \\(none\\), expected one"),
        (
            model(LINK).replace("</sdf>", f'<model name="n">{LINK}</model></sdf>'),
            "there are 2 models \\(m, n\\), expected one",
        ),
        (model(f"{LINK}<include/>"), "<include> in <model> is not read: write the included"),
        (model(f'{LINK}<model name="n"/>'), "model 'n' in 'm': it has no <link>"),
        (model('<link name="a"><frame/></link>', "1.6"), "<frame> in <link> is not read"),
        (
            model('<link name="a"><inertial><frame/></inertial></link>', "1.6"),
            "<frame> in <inertial> is not read: write a <pose>",
        ),
        (model('<link name="a"><inertial auto="true"/></link>'), "--expand-auto-inertials"),
        (
            model('<link name="a"><inertial><mass>-1</mass></inertial></link>'),
            "mass -1 kg is not positive",
        ),
        (
            model('<link name="a"><inertial><inertia><ixx>1</ixx></inertia></inertial></link>'),
            "link 'a': inertia iyy: '' is not 1 finite",
        ),
        (
            model('<link name="a"><inertial><pose relative_to="b"/></inertial></link>'),
            "the pose of <inertial> is in the link",
        ),
        (model('<static>maybe</static><link name="a"/>'), "static is 'maybe'"),
        (
            model(
                f'{LINK}{STAND}<frame name="f"><pose relative_to="n::f">0 0 0 0 0 0</pose></frame>'
            ),
            "'f': frame 'n::f' does not exist",
        ),
        (
            model(
                f'{LINK}{STAND}<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'
            ),
            "stated relative to itself",
        ),
        (model("<lnik/>"), "element 'lnik' is unknown.*did you mean 'link'"),
        (
            model(
                LINK
                + STAND
                + STAND.replace('"s"', '"t"').replace("world", "b")
                + LINK.replace('"a"', '"b"')
                + STAND.replace('"s"', '"u"').replace(">a<", ">b<")
            ),
            "which fixed joints already make one body",
        ),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(text)


def test_plugins_are_named() -> None:
    text = model(f'{LINK}{STAND}<plugin name="p" filename="x"><any/></plugin>')
    assert read(text).warnings == (
        "SDF text: <plugin> 'p' passed over: forces that it makes are unknown here",
    )
