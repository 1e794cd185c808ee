"""Visuals of descriptions: kinds, sizes, places and colours, and what is said about others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.practice.formats.visual import Visual
from cardan_dyn.practice.formats.visuals import visuals_of

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def urdf(visuals: str, more: str = "") -> cd.Mechanism:
    return cd.load(
        f'<robot name="r">{more}<link name="a"/><link name="b">{visuals}</link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )


def visual(geometry: str, rest: str = "") -> str:
    return f'<visual name="v">{rest}<geometry>{geometry}</geometry></visual>'


def sdf(visuals: str, more: str = "") -> cd.Mechanism:
    return cd.load(
        '<sdf version="1.9"><model name="m"><link name="b"><pose>1 0 0 0 0 0</pose>'
        f"<inertial><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>{visuals}"
        f'</link>{more}<joint name="j" type="revolute"><parent>world</parent><child>b</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )


def mjcf(geoms: str, head: str = "", world: str = "") -> cd.Mechanism:
    return cd.load(
        f'<mujoco model="m"><compiler angle="radian"/>{head}<worldbody>{world}<body name="b">'
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="j" axis="0 0 1"/>'
        f"{geoms}</body></worldbody></mujoco>"
    )


def only(mechanism: cd.Mechanism) -> Visual:
    (found,), messages = visuals_of(mechanism.description)
    assert messages == []
    return found


@pytest.mark.parametrize(
    ("notation", "text", "kind", "size"),
    [
        (urdf, visual('<box size="1 2 4"/>'), "box", (1, 2, 4)),
        (urdf, visual('<cylinder radius="0.5" length="3"/>'), "cylinder", (0.5, 3)),
        (urdf, visual('<capsule radius="0.5" length="3"/>'), "capsule", (0.5, 3)),
        (urdf, visual('<sphere radius="2"/>'), "sphere", (2,)),
        (sdf, visual("<box><size>1 2 4</size></box>"), "box", (1, 2, 4)),
        (
            sdf,
            visual("<cylinder><radius>0.5</radius><length>3</length></cylinder>"),
            *("cylinder", (0.5, 3)),
        ),
        (
            sdf,
            visual("<capsule><radius>0.5</radius><length>3</length></capsule>"),
            *("capsule", (0.5, 3)),
        ),
        (sdf, visual("<ellipsoid><radii>1 2 3</radii></ellipsoid>"), "ellipsoid", (1, 2, 3)),
        (sdf, visual("<plane><size>2 3</size></plane>"), "plane", (2, 3)),
        # MuJoCo's sizes are radii and halves.
        (mjcf, '<geom type="box" size="1 2 4"/>', "box", (2, 4, 8)),
        (mjcf, '<geom type="cylinder" size="0.5 3"/>', "cylinder", (0.5, 6)),
        (mjcf, '<geom type="capsule" size="0.5 3"/>', "capsule", (0.5, 6)),
        (mjcf, '<geom type="capsule" size="0.5" fromto="0 0 0 0 0 4"/>', "capsule", (0.5, 4)),
        (mjcf, '<geom type="ellipsoid" size="1 2 3"/>', "ellipsoid", (1, 2, 3)),
        (mjcf, '<geom size="2"/>', "sphere", (2,)),
    ],
)
def test_kinds_and_sizes(notation: object, text: str, kind: str, size: tuple[float, ...]) -> None:
    found = only(notation(text))  # type: ignore[operator]
    assert (found.link, found.kind) == ("b", kind)
    assert found.size == pytest.approx(size)


@pytest.mark.parametrize(
    ("notation", "text"),
    [
        (
            urdf,
            visual('<sphere radius="2"/>', '<origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>'),
        ),
        (
            sdf,
            visual(
                "<sphere><radius>2</radius></sphere>", "<pose>1 2 3 0 0 1.5707963267948966</pose>"
            ),
        ),
        (mjcf, '<geom size="2" pos="1 2 3" euler="0 0 1.5707963267948966"/>'),
        (
            mjcf,
            '<frame pos="1 2 0"><geom size="2" pos="0 0 3" euler="0 0 1.5707963267948966"/>'
            "</frame>",
        ),
    ],
)
def test_places_in_the_link(notation: object, text: str) -> None:
    found = only(notation(text))  # type: ignore[operator]
    np.testing.assert_allclose(found.placement[:3, :3], QUARTER, atol=1e-15)
    np.testing.assert_allclose(found.placement[:3, 3], (1.0, 2.0, 3.0))


def test_a_pose_relative_to_a_frame_of_the_model() -> None:
    frame = '<frame name="f"><pose>1 2 3 0 0 0</pose></frame>'
    shape = "<sphere><radius>2</radius></sphere>"
    # The link stands at 1 0 0.
    found = only(sdf(visual(shape, '<pose relative_to="f">0 0 1 0 0 0</pose>'), frame))
    np.testing.assert_allclose(found.placement[:3, 3], (0.0, 2.0, 4.0))


RED = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
MATERIAL = '<asset><material name="red" rgba="1 0 0 0.5"/></asset>'
DEFAULTS = '<default><geom rgba="1 0 0 0.5"/></default>'


@pytest.mark.parametrize(
    ("mechanism", "color"),
    [
        (urdf(visual('<sphere radius="2"/>')), None),
        (urdf(visual('<sphere radius="2"/>', RED)), (1, 0, 0, 0.5)),
        (urdf(visual('<sphere radius="2"/>', '<material name="red"/>'), RED), (1, 0, 0, 0.5)),
        (urdf(visual('<sphere radius="2"/>', '<material name="blue"/>'), RED), None),
        (
            sdf(
                visual(
                    "<sphere><radius>2</radius></sphere>",
                    "<material><diffuse>1 0 0 1</diffuse></material>"
                    "<transparency>0.5</transparency>",
                )
            ),
            (1, 0, 0, 0.5),
        ),
        (mjcf('<geom size="2" rgba="1 0 0 0.5"/>'), (1, 0, 0, 0.5)),
        (mjcf('<geom size="2" material="red"/>', MATERIAL), (1, 0, 0, 0.5)),
        (mjcf('<geom size="2"/>', DEFAULTS), (1, 0, 0, 0.5)),
        (mjcf('<geom size="2" rgba="0.5 0.5 0.5 1"/>'), None),
    ],
)
def test_colors(mechanism: cd.Mechanism, color: tuple[float, ...] | None) -> None:
    assert only(mechanism).color == color


def test_a_material_is_known_by_its_name_in_other_links() -> None:
    ball = '<sphere radius="2"/>'
    found, _ = visuals_of(
        urdf(visual(ball, '<material name="red"/>') + visual(ball, RED)).description
    )
    assert [item.color for item in found] == [(1, 0, 0, 0.5)] * 2


def test_what_mujoco_does_not_show_is_left_out() -> None:
    geoms = '<geom size="2" group="3"/><geom size="2" rgba="1 1 1 0"/><geom size="1" group="2"/>'
    assert only(mjcf(geoms)).size == (1.0,)
    floor = only(mjcf("", world='<geom name="floor" type="plane" size="0 3 1"/>'))
    assert (floor.link, floor.size) == ("world", (0.0, 6.0))


MESHES = """<compiler angle="radian" meshdir="parts"/><default><mesh scale="2 2 2"/></default>
<asset><mesh name="m" file="sub/one.stl" refpos="1 0 0"/><mesh file="two.obj" scale="1 1 -1"/>
</asset>"""


def test_meshes_of_mjcf(tmp_path: Path) -> None:
    first = only(mjcf('<geom type="mesh" mesh="m"/>', MESHES))
    assert (first.file, first.folder) == ("parts/sub/one.stl", None)
    np.testing.assert_array_equal(first.scale, (2.0, 2.0, 2.0))
    np.testing.assert_array_equal(first.mesh_placement[:3, 3], (-1.0, 0.0, 0.0))
    second = only(mjcf('<geom type="mesh" mesh="two"/>', MESHES))
    np.testing.assert_array_equal(second.scale, (1.0, 1.0, -1.0))
    stripped = MESHES.replace("meshdir", 'strippath="true" assetdir')
    assert only(mjcf('<geom type="mesh" mesh="m"/>', stripped)).file == "parts/one.stl"
    file = tmp_path / "m.xml"
    source = mjcf('<geom type="mesh" mesh="m"/>', MESHES).description.source
    assert source is not None
    file.write_text(source.text)
    assert only(cd.load(file)).folder == tmp_path


def test_meshes_of_urdf_and_sdf() -> None:
    found = only(urdf(visual('<mesh filename="package://p/x.dae" scale="1 2 3"/>')))
    assert (found.kind, found.file) == ("mesh", "package://p/x.dae")
    np.testing.assert_array_equal(found.scale, (1.0, 2.0, 3.0))
    part = "<submesh><name>wheel</name></submesh>"
    text = f"<mesh><uri>model://p/x.dae</uri><scale>1 2 3</scale>{part}</mesh>"
    other = only(sdf(visual(text)))
    assert (other.kind, other.file, other.part) == ("mesh", "model://p/x.dae", "wheel")
    np.testing.assert_array_equal(other.scale, (1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("notation", "text", "message"),
    [
        (urdf, visual(""), "visual 'v' is not drawn: <geometry> needs one of box"),
        (urdf, visual('<box size="1 2"/>'), "box size: '1 2' is not 3 finite"),
        (urdf, visual('<sphere radius="big"/>'), "sphere radius: 'big' is not 1 finite"),
        (urdf, visual('<sphere radius="-1"/>'), "sphere: its size has to be positive"),
        (urdf, visual('<mesh filename="x.stl" scale="0 1 1"/>'), "would leave nothing"),
        (urdf, visual('<mesh filename="x.stl" scale="2"/>'), "mesh scale: '2' is not 3"),
        (sdf, visual("<heightmap/>"), "its <geometry> is heightmap; one of"),
        (sdf, visual("<plane><normal>0 0 0</normal><size>1 1</size></plane>"), "no direction"),
    ],
)
def test_what_cannot_be_read_is_said(notation: object, text: str, message: str) -> None:
    found, (said,) = visuals_of(notation(text).description)  # type: ignore[operator]
    assert found == []
    assert said.startswith("link 'b': ") and message in said


def test_an_empty_geometry_and_a_description_without_text_have_none() -> None:
    assert visuals_of(sdf(visual("<empty/>")).description) == ([], [])
    from dataclasses import replace

    assert visuals_of(replace(urdf("").description, source=None)) == ([], [])
