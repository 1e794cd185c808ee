"""Loops in the notations of other programs give the wrenches of the same loops in URDF+."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from testkit.linkages import POSITIONS, RATES, four_bar, loop
from testkit.scenes import relative, text, universal

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

PLUS = four_bar(loop("continuous"))
TREE = PLUS[: PLUS.index("<loop")] + "</robot>"
ISAAC = (
    '<loop_joint name="c" type="{kind}"><link1 link="coupler" rpy="0 0 0" xyz="2 2 0"/>'
    '<link2 link="rocker" rpy="0 0 0" xyz="0 2.5 0"/><axis xyz="0 0 1"/></loop_joint>'
)
ENDS = """<link name="end_1"/><link name="end_2"/>
<joint name="tip_1" type="fixed"><parent link="coupler"/><child link="end_1"/>
  <origin xyz="2 2 0"/></joint>
<joint name="tip_2" type="fixed"><parent link="rocker"/><child link="end_2"/>
  <origin xyz="0 2.5 0"/></joint>"""


def sweep(source: object, **options: object) -> cd.Sweep:
    scene = cd.Scene(cd.load(source), **{"drive": "a", "loads": {"d": -3.0}, **options})
    return scene.sweep(POSITIONS, **RATES)


def same(found: cd.Sweep, reference: cd.Sweep, names: str = "abcd") -> None:
    assert relative(found.drive_effort, reference.drive_effort) < 1e-13
    for name in names:
        force = reference.wrench(name, "world").force[:, :2]
        assert relative(found.wrench(name, "world").force[:, :2], force) < 1e-12


@pytest.mark.parametrize("kind", ["continuous", "revolute", "spherical"])
def test_isaac(kind: str) -> None:
    urdf = TREE.replace("</robot>", ISAAC.format(kind=kind) + "</robot>")
    found = sweep(urdf)
    same(found, sweep(four_bar(loop(kind))))
    assert found.mechanism.notation == "Isaac <loop_joint>"


def test_two_notations_that_agree_say_which_was_used() -> None:
    urdf = PLUS.replace("</robot>", ISAAC.format(kind="continuous") + "</robot>")
    mechanism = cd.load(urdf)
    assert mechanism.notation == (
        "URDF+ <loop>; Isaac <loop_joint> closes the same links and is not used"
    )
    assert mechanism.notation in str(cd.describe(mechanism))
    same(sweep(urdf), sweep(PLUS))


def test_loops_of_one_name_in_two_notations_are_those_of_urdf_plus() -> None:
    """Isaac's element stands half a metre off; nobody reads it, the proof as little as the rest."""
    elsewhere = ISAAC.format(kind="continuous").replace('xyz="0 2.5 0"', 'xyz="0.5 2.5 0"')
    for urdf in (
        PLUS.replace("</robot>", elsewhere + "</robot>"),
        PLUS.replace("<loop ", elsewhere + "<loop ", 1),
    ):
        same(sweep(urdf), sweep(PLUS))


def test_two_notations_that_contradict_each_other_are_refused() -> None:
    contradicting = ISAAC.format(kind="continuous").replace('link="rocker"', 'link="ground"')
    with pytest.raises(cd.ModelError, match=r"close different loops: .*rocker.* against .*ground"):
        cd.load(PLUS.replace("</robot>", contradicting + "</robot>"))


def test_gepetto(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(TREE.replace("</robot>", ENDS + "</robot>"), encoding="utf-8")
    yaml = tmp_path / "robot.yaml"
    yaml.write_text(
        "closed_loop: [['end_1', 'tip_2']]\ntype: ['3d']\nname_mot: ['a']\n", encoding="utf-8"
    )
    reference = sweep(four_bar(loop("spherical")))
    found = sweep(path, drive=None)
    assert found.mechanism.notation == "Gepetto robot.yaml"
    assert found.mechanism.independent_joints == ("a",)
    assert relative(found.drive_effort, reference.drive_effort) < 1e-13
    force = reference.wrench("c", "world").force[:, :2]
    assert relative(found.wrench("loop_1", "world").force[:, :2], force) < 1e-12


def test_gepetto_changes_joint_types(tmp_path: Path) -> None:
    """The file beside the URDF makes a ball of a hinge of the tree."""
    path = tmp_path / "robot.urdf"
    path.write_text(TREE.replace("</robot>", ENDS + "</robot>"), encoding="utf-8")
    (tmp_path / "robot.yml").write_text(
        "closed_loop: [['end_1', 'end_2']]\ntype: ['3d']\nname_mot: ['a']\n"
        "joint_name: ['b']\njoint_type: ['SPHERICAL']\n",
        encoding="utf-8",
    )
    mechanism = cd.load(path)
    assert mechanism.joints["b"].type == "spherical"
    # Two balls leave the coupler free to spin about the line between them.
    turn = cd.Scene(mechanism).sweep(POSITIONS)
    assert turn.idle_rods == [("b", "loop_1")]
    assert turn.loop_residual < 1e-13


@pytest.mark.parametrize("word", ["UJOINT_ZY", "ujoint_zx"])
def test_gepetto_makes_joints_universal(word: str, tmp_path: Path) -> None:
    """The first letter is the axis on the parent's side, the second that on the child's."""
    path = tmp_path / "robot.urdf"
    # The axis that the URDF states counts no longer.
    urdf = TREE.replace("</robot>", ENDS + "</robot>")
    path.write_text(urdf, encoding="utf-8")
    yaml = (
        "closed_loop: [['end_1', 'end_2']]\ntype: ['3d']\nname_mot: ['a']\n"
        f"joint_name: ['b']\njoint_type: ['{word}']\n"
    )
    (tmp_path / "robot.yaml").write_text(yaml, encoding="utf-8")
    axes = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
    written = four_bar(loop("spherical")).replace(
        '<joint name="b" type="continuous">',
        f'<joint name="b" type="universal"><axis2 xyz="{axes[word[-1].lower()]}"/>',
    )
    found = sweep(path, drive=None, gravity=[0.0, 0.0, -9.81])
    assert found.mechanism.joints["b"].type == "universal"
    expected = sweep(written, gravity=[0.0, 0.0, -9.81])
    assert found.balance_residual < 1e-13
    assert relative(found.drive_effort, expected.drive_effort) < 1e-13
    for name in "abd":
        assert relative(found[name].force, expected[name].force) < 1e-11
        assert relative(found[name].moment, expected[name].moment) < 1e-11


def test_independent_joints_are_the_drives() -> None:
    urdf = text("universal_joint").replace(
        '<joint name="bearing_in" ', '<joint name="bearing_in" independent="true" '
    )
    urdf = urdf.replace(
        '<joint name="joint_angle" ', '<joint name="joint_angle" independent="true" '
    )
    mechanism = cd.load(urdf)
    assert mechanism.independent_joints == ("bearing_in", "joint_angle")
    scene = cd.Scene(mechanism, held={"joint_angle": 0.5}, loads={"bearing_out": -1.0})
    assert scene.drives == ("bearing_in",)
    reference = universal(cd.load("universal_joint"), 0.5).sweep([0.3])
    assert scene.sweep([0.3]).drive_effort == pytest.approx(reference.drive_effort, rel=1e-14)
    assert cd.Scene(mechanism).drives == ("bearing_in", "joint_angle")
    with pytest.raises(cd.ModelError, match="independent is 'maybe', expected true or false"):
        cd.load(urdf.replace('independent="true"', 'independent="maybe"'))
    with pytest.raises(cd.MobilityError, match="needs at least one coordinate"):
        cd.Scene(cd.load(PLUS))


MJCF = """<mujoco model="four_bar"><compiler angle="radian"/><worldbody>
<body name="crank" pos="0 0 0"><inertial pos="0 0.25 0" mass="1" diaginertia="0.02 0.03 0.025"/>
  <joint name="a" type="hinge" axis="0 0 1"/>
  <body name="coupler" pos="0 0.5 0"><inertial pos="1 1 0" mass="2"
    diaginertia="0.02 0.03 0.025"/><joint name="b" type="hinge" axis="0 0 1"/></body></body>
<body name="rocker" pos="2 0 0"><inertial pos="0 1.25 0" mass="3"
  diaginertia="0.02 0.03 0.025"/><joint name="d" type="hinge" axis="0 0 1"/></body>
</worldbody><equality>{equality}</equality></mujoco>"""
CONNECT = '<connect name="c" body1="coupler" body2="rocker" anchor="2 2 0"/>'


def test_mjcf(tmp_path: Path) -> None:
    content = MJCF.format(equality=CONNECT)
    path = tmp_path / "four_bar.xml"
    path.write_text(content, encoding="utf-8")
    reference = sweep(four_bar(loop("spherical")))
    for source in (content, path):
        found = sweep(source)
        assert found.mechanism.notation == "MJCF <equality>"
        assert found.mechanism.name == "four_bar"
        name = found.mechanism.loops[0].joint
        assert relative(found.drive_effort, reference.drive_effort) < 1e-12
        force = reference.wrench("c", "world").force[:, :2]
        assert relative(found.wrench(name, "world").force[:, :2], force) < 1e-11


def test_mjcf_weld_locks_a_planar_chain() -> None:
    weld = '<weld name="c" body1="coupler" body2="rocker"/>'
    with pytest.raises(cd.MobilityError, match="it is locked"):
        cd.Scene(cd.load(MJCF.format(equality=weld)), drive="a")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<mujoco><worldbody><body><nothing/>", "malformed XML"),
        (
            MJCF.format(equality='<connect body1="x" body2="rocker" anchor="0 0 0"/>'),
            "unknown element 'x'",
        ),
    ],
)
def test_bad_mjcf(content: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(content)


def test_order_of_the_file_does_not_matter() -> None:
    """Links and joints in reverse order: the same wrenches, joint by joint."""
    root = ElementTree.fromstring(PLUS)
    reverse = ElementTree.Element("robot", root.attrib)
    reverse.extend(list(root)[::-1])
    found = sweep(ElementTree.tostring(reverse, encoding="unicode"))
    reference = sweep(PLUS)
    for name in "abcd":
        for component in ("force", "moment"):
            np.testing.assert_allclose(
                getattr(found[name], component), getattr(reference[name], component), atol=1e-11
            )
        np.testing.assert_array_equal(found[name].unique, reference[name].unique)
