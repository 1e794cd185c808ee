"""Gepetto's YAML file beside a URDF."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element, fromstring

import numpy as np
import pytest
from testkit.linkages import four_bar, loop

import cardan_dyn as cd
from cardan_dyn.core.description.beside import Beside, file_beside, gepetto, unread_files

PLUS = four_bar(loop("continuous"))
TREE = PLUS[: PLUS.index("<loop")] + "</robot>"
ENDS = """<link name="end_1"/><link name="end_2"/>
<joint name="tip_1" type="fixed"><parent link="coupler"/><child link="end_1"/>
  <origin xyz="2 2 0"/></joint>
<joint name="tip_2" type="fixed"><parent link="rocker"/><child link="end_2"/>
  <origin xyz="0 2.5 0"/></joint>"""
LINKS = ("a", "b", "c")


def robot(*elements: str) -> Element:
    return fromstring(f"<robot>{''.join(elements)}</robot>")


def beside_text(tmp_path: Path, yaml: str, suffix: str = ".yaml") -> Beside | None:
    """Return what a YAML file says beside a URDF of the links a, b, c and the joints j, k."""
    (tmp_path / f"robot{suffix}").write_text(yaml, encoding="utf-8")
    urdf = robot(
        *(f'<link name="{name}"/>' for name in LINKS),
        '<joint name="j"><child link="b"/></joint><joint name="k"><child link="c"/></joint>',
    )
    return gepetto(tmp_path / f"robot{suffix}", urdf, {"j", "k"})


def test_no_file_beside_a_urdf(tmp_path: Path) -> None:
    assert file_beside(robot(), "x", tmp_path / "robot.urdf", strict=True) is None


@pytest.mark.parametrize("yaml", ["", "[1, 2]", "controllers: [1]", "loops: [[a, b]]"])
def test_files_about_something_else(tmp_path: Path, yaml: str) -> None:
    assert beside_text(tmp_path, yaml) is None


def test_what_a_file_beside_a_urdf_says(tmp_path: Path) -> None:
    extra = beside_text(
        tmp_path,
        "closed_loop: [[a, j], [k, b]]\ntype: [3D, 6d]\nname_mot: [k, j]\n"
        "joint_name: [j]\njoint_type: [Spherical]",
    )
    assert extra is not None
    assert extra.path == tmp_path / "robot.yaml"
    assert [(item.name, item.type, item.predecessor, item.successor) for item in extra.loops] == [
        ("loop_1", "spherical", "a", "b"),
        ("loop_2", "fixed", "c", "b"),
    ]
    for item in extra.loops:
        np.testing.assert_array_equal(item.predecessor_origin, np.eye(4))
        np.testing.assert_array_equal(item.successor_origin, np.eye(4))
    assert extra.motors == ("k", "j")
    assert extra.joint_types.keys() == {"j"}
    assert extra.joint_types["j"].type == "spherical"
    assert extra.joint_types["j"].axes == ()


def test_a_file_beside_a_urdf_makes_joints_universal(tmp_path: Path) -> None:
    content = "closed_loop: [[a, j]]\njoint_name: [j, k]\njoint_type: [UJOINT_XY, ujoint_zx]"
    extra = beside_text(tmp_path, content)
    assert extra is not None
    expected = {"j": ([1, 0, 0], [0, 1, 0]), "k": ([0, 0, 1], [1, 0, 0])}
    for name, axes in expected.items():
        changed = extra.joint_types[name]
        assert changed.type == "universal"
        np.testing.assert_array_equal(changed.axes, axes)


def test_closures_without_a_type_are_welds(tmp_path: Path) -> None:
    extra = beside_text(tmp_path, "closed_loop: [[a, b], [a, c]]")
    assert extra is not None
    assert [item.type for item in extra.loops] == ["fixed", "fixed"]
    assert (extra.motors, extra.joint_types) == ((), {})


def test_yaml_comes_before_yml(tmp_path: Path) -> None:
    urdf = robot('<link name="a"/><link name="b"/>')
    for suffix in (".yml", ".yaml"):
        (tmp_path / f"robot{suffix}").write_text("closed_loop: [[a, b]]", encoding="utf-8")
        extra = file_beside(urdf, "x", tmp_path / "robot.urdf", strict=True)
        assert extra is not None
        assert extra.path.name == f"robot{suffix}"


def test_a_file_with_a_byte_order_mark(tmp_path: Path) -> None:
    assert beside_text(tmp_path, "\ufeffclosed_loop: [[a, b]]") is not None


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_bytes(b"closed_loop: \xff")
    with pytest.raises(cd.ModelError, match=r"robot.yaml: cannot be read as YAML: unacceptable"):
        gepetto(tmp_path / "robot.yaml", robot(), set())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("closed_loop: [['end_1', 'nowhere']]\ntype: ['3d']", "frame 'nowhere' does not exist"),
        ("closed_loop: [['end_1']]\ntype: ['3d']", "is not a pair of frames"),
        ("closed_loop: [['end_1', 'end_2']]\ntype: ['5d']", "type '5d' is unknown; types: 3d, 6d"),
        ("closed_loop: [['end_1', 'end_2']]\ntype: []", "1 closed_loop but 0 type entries"),
        ("closed_loop: end_1", "is not a list of pairs"),
        ("closed_loop: [", "cannot be read as YAML"),
        ("closed_loop: [['end_1', 'end_2']]\nname_mot: ['z']", "joint 'z' does not exist"),
        (
            "closed_loop: [['end_1', 'end_2']]\njoint_name: ['b']\njoint_type: ['x']",
            "joint_type 'x' is unknown",
        ),
        (
            "closed_loop: [['end_1', 'end_2']]\njoint_name: ['b']\njoint_type: ['UJOINT_XX']",
            "joint_type 'UJOINT_XX' has the same axis twice",
        ),
        (
            "closed_loop: [['end_1', 'end_2']]\njoint_name: ['b']\njoint_type: []",
            "1 joint_name but 0 joint_type",
        ),
    ],
)
def test_bad_gepetto_files(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(TREE.replace("</robot>", ENDS + "</robot>"), encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(content, encoding="utf-8")
    with pytest.raises(cd.ModelError, match=message):
        cd.load(path)


def test_a_yaml_file_about_something_else_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(PLUS, encoding="utf-8")
    (tmp_path / "robot.yaml").write_text("controllers: [1, 2]", encoding="utf-8")
    assert cd.load(path).notation == "URDF+ <loop>"


TIPS = """<robot name="tips"><link name="ground"/><link name="one"/><link name="two"/>
<link name="tip"/>{more}<joint name="a" type="fixed"><parent link="ground"/><child link="one"/>
<axis xyz="0 0 1"/></joint>
<joint name="b" type="continuous"><parent link="one"/><child link="two"/></joint>
<joint name="c" type="fixed"><parent link="two"/><child link="tip"/></joint></robot>"""
PAIR = "closed_loop: [[tip, ground]]\ntype: [3d]\n"
YAML = {
    "type is a mapping": ("closed_loop: [[tip, ground]]\ntype: {a: 1}", "type is not a list"),
    "types are mappings": ("closed_loop: [[tip, ground]]\ntype: [{a: 1}]", "dict is not a name"),
    "number": ("closed_loop: [[1, ground]]", "int is not a name; .* needs quotes"),
    "word that YAML knows": ("closed_loop: [[no, ground]]", "bool is not a name"),
    "frame is a list": ("closed_loop: [[[tip], ground]]", "list is not a name"),
    "frame is a mapping": ("closed_loop: [[{a: b}, ground]]", "dict is not a name"),
    "entry is a name": ("closed_loop: [tip, ground]", "entry 1 is not a list of names"),
    "loops are a name": ("closed_loop: tip", "is not a list of pairs"),
    "nothing": ("closed_loop:", "is not a list of pairs"),
    "three frames": ("closed_loop: [[tip, one, ground]]", "is not a pair of frames"),
    "nested": ("a: " + "[" * 3000 + "]" * 3000, "cannot be read as YAML"),
    "nested mappings": ("a: " + "{b: " * 3000 + "}" * 3000, "cannot be read as YAML"),
    "no such date": (f"{PAIR}a: 2001-13-99", "cannot be read as YAML"),
    "no number": (f"{PAIR}a: !!int x", "cannot be read as YAML"),
    "no time": (f"{PAIR}a: !!timestamp x", "cannot be read as YAML"),
    "neither true nor false": (f"{PAIR}a: !!bool perhaps", "cannot be read as YAML"),
    "key twice": (f"{PAIR}closed_loop: [[tip, one]]", "key names that occur twice: closed_loop"),
    "motor twice": (f"{PAIR}name_mot: [b, b]", "name_mot names that occur twice: b"),
    "joint twice": (
        f"{PAIR}joint_name: [b, b]\njoint_type: [revolute, fixed]",
        "joint_name names that occur twice: b",
    ),
    "bytes": (f"{PAIR}name_mot: [!!binary YQ==]", "bytes is not a name"),
    "itself": (f"{PAIR}name_mot: &x [*x]", "list is not a name"),
}


def beside(path: Path, yaml: str, more: str = "") -> cd.Mechanism:
    (path / "tips.urdf").write_text(TIPS.format(more=more), encoding="utf-8")
    (path / "tips.yaml").write_text(yaml, encoding="utf-8")
    return cd.load(path / "tips.urdf")


@pytest.mark.parametrize(("yaml", "message"), YAML.values(), ids=YAML.keys())
def test_bad_files_beside(yaml: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(cd.ModelError, match=f"tips.yaml: .*{message}|tips.yaml: {message}"):
        beside(tmp_path, yaml)


def test_a_frame_is_one_link(tmp_path: Path) -> None:
    """Of a link and a joint with one name, neither is preferred without a word."""
    more = '<link name="b"/><joint name="d" type="fixed"><parent link="ground"/>'
    more += '<child link="b"/></joint>'
    with pytest.raises(cd.ModelError, match=r"frame 'b' is a link and a joint.*: b, two; rename"):
        beside(tmp_path, "closed_loop: [[b, ground]]", more)
    # Those that are not used may be called as they like.
    closure = beside(tmp_path, PAIR, more).description.loops[0]
    assert (closure.predecessor, closure.successor, closure.type) == ("tip", "ground", "spherical")


def test_a_joint_that_the_file_beside_frees_turns_about_its_axis(tmp_path: Path) -> None:
    """What stands as fixed in the URDF has an axis there all the same."""
    mechanism = beside(tmp_path, f"{PAIR}joint_name: [a]\njoint_type: [revolute]")
    np.testing.assert_array_equal(mechanism.joint("a").axis, [0.0, 0.0, 1.0])


def test_lenient_reading_passes_over_joints_that_do_not_exist(tmp_path: Path) -> None:
    content = "closed_loop: [[a, b]]\nname_mot: [k, z]\njoint_name: [y]\njoint_type: [spherical]"
    (tmp_path / "robot.yaml").write_text(content, encoding="utf-8")
    urdf, joints = robot('<link name="a"/>', '<link name="b"/>'), {"j", "k"}
    with pytest.raises(cd.ModelError, match="joint 'z' does not exist"):
        gepetto(tmp_path / "robot.yaml", urdf, joints)
    extra = gepetto(tmp_path / "robot.yaml", urdf, joints, strict=False)
    assert extra is not None
    assert (extra.motors, extra.joint_types) == (("k",), {})
    assert [warning.split(": ")[-1] for warning in extra.warnings] == [
        "joint 'z' does not exist and was passed over",
        "joint 'y' does not exist and was passed over",
    ]


def test_files_of_another_name_are_named(tmp_path: Path) -> None:
    for name in ("other.yaml", "second.yml", "theirs.yaml"):
        (tmp_path / name).write_text("closed_loop: [[a, b]]", encoding="utf-8")
    (tmp_path / "theirs.urdf").write_text("<robot/>", encoding="utf-8")
    (tmp_path / "notes.yaml").write_text("text: nothing", encoding="utf-8")
    warnings = unread_files(tmp_path / "mine.urdf")
    assert all(name in warning for name, warning in zip(("other", "second"), warnings, strict=True))
    assert all("rename it to mine.yaml" in warning for warning in warnings)
