"""What cannot be read is refused: sizes, paths, text, and files beside a description."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd
from cardan_dyn.description.elements import MOST_LINKS


def serial(links: int, kind: str = "continuous") -> str:
    parts = [
        f'<link name="l_{number}"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
        f'<joint name="j_{number}" type="{kind}"><parent link="l_{number - 1}"/>'
        f'<child link="l_{number}"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>'
        for number in range(1, links)
    ]
    return f'<robot name="chain"><link name="l_0"/>{"".join(parts)}</robot>'


@pytest.mark.parametrize("kind", ["continuous", "fixed"])
def test_descriptions_of_the_greatest_size(kind: str) -> None:
    mechanism = cd.load(serial(MOST_LINKS, kind))
    assert len(mechanism.links) == MOST_LINKS


@pytest.mark.parametrize("kind", ["continuous", "fixed"])
def test_reading_takes_work_in_proportion_to_the_links(kind: str) -> None:
    def calls(links: int) -> int:
        text, count = serial(links, kind), 0

        def counted(_frame: object, event: str, _argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(counted)
        try:
            cd.load(text)
        finally:
            sys.setprofile(None)
        return count

    assert calls(400) < 2.2 * calls(200)


@pytest.mark.parametrize("bodies", [MOST_LINKS, 5000])
def test_the_limit_of_size_is_stated(bodies: int) -> None:
    message = f"there are {bodies + 1} links, the limit is 2000"
    with pytest.raises(cd.ModelError, match=f"URDF text: {message}"):
        cd.load(serial(bodies + 1))
    body = '<body><joint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
    with pytest.raises(cd.ModelError, match=f"MJCF text: {message}"):
        cd.load(f"<mujoco><worldbody>{body * bodies}</worldbody></mujoco>")


def test_massless_links_between_joints_count() -> None:
    """Two joints of a body have a link between them."""
    body = '<body><joint/><joint axis="0 1 0"/>'
    body += '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
    with pytest.raises(cd.ModelError, match="there are 2401 links"):
        cd.load(f"<mujoco><worldbody>{body * 1200}</worldbody></mujoco>")


class Nowhere:
    def __init__(self, path: object) -> None:
        self.path = path

    def __fspath__(self) -> object:
        if isinstance(self.path, Exception):
            raise self.path
        return self.path


@pytest.mark.parametrize(
    "source",
    [
        *(
            b"universal_joint",
            bytearray(b"a"),
            memoryview(b"ab"),
            3,
            1.5,
            [],
            object(),
            np.array("a"),
        ),
        *(Nowhere(b"/tmp"), Nowhere(3), Nowhere(RuntimeError("no"))),
    ],
)
def test_what_is_no_path_is_refused(source: object) -> None:
    with pytest.raises(cd.ModelError, match="takes a name, a path or text, not"):
        cd.load(source)


@pytest.mark.parametrize(
    "source", ["\ud800", "a" * 100_000, "/" + "a/" * 5000, "", ".", "\x00", "~", "a\nb"]
)
def test_what_is_no_file_is_refused(source: str) -> None:
    with pytest.raises(cd.ModelError, match="neither a file nor a bundled name") as caught:
        cd.load(source)
    assert len(str(caught.value)) < 500


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.urdf")
    with pytest.raises(cd.ModelError, match="neither a file"):
        cd.load(tmp_path / "pipe.urdf")


def test_messages_name_the_kind_of_text() -> None:
    for content, start in (
        ("<mujoco><nothing/></mujoco>", "MJCF text: "),
        ("<robot/>", "URDF text: "),
        ("<robot", "text: malformed"),
        ("<sdf/>", "text: the outermost"),
        ("<robot>\ud800</robot>", "text: malformed"),
    ):
        with pytest.raises(cd.ModelError) as caught:
            cd.load(content)
        assert str(caught.value).startswith(start)


@pytest.mark.parametrize("strict", [0, "no", None, [], np.array([True, False])])
def test_strict_is_true_or_false(strict: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"strict is .*expected True or False"):
        cd.load("universal_joint", strict=strict)


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
    "same frame": ("closed_loop: [[tip, tip]]", "both frames are on the link 'tip'"),
    "same link": ("closed_loop: [[tip, c]]", "both frames are on the link 'tip'"),
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
    loop = beside(tmp_path, PAIR, more).description.loops[0]
    assert (loop.predecessor, loop.successor, loop.type) == ("tip", "ground", "spherical")


def test_a_joint_that_the_file_beside_frees_turns_about_its_axis(tmp_path: Path) -> None:
    """What stands as fixed in the URDF has an axis there all the same."""
    mechanism = beside(tmp_path, f"{PAIR}joint_name: [a]\njoint_type: [revolute]")
    np.testing.assert_array_equal(mechanism.joint("a").axis, [0.0, 0.0, 1.0])
