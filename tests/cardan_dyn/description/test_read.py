"""Descriptions are found by name, by path or as text; what cannot be read is refused."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from testkit.scenes import text

import cardan_dyn as cd
from cardan_dyn.core.description.elements import MOST_LINKS
from cardan_dyn.core.description.read import bundled_directory, bundled_names, read

JOINT = text("universal_joint")


def serial(links: int, kind: str = "continuous") -> str:
    elements = [
        f'<link name="l_{index}"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
        f'<joint name="j_{index}" type="{kind}"><parent link="l_{index - 1}"/>'
        f'<child link="l_{index}"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>'
        for index in range(1, links)
    ]
    return f'<robot name="chain"><link name="l_0"/>{"".join(elements)}</robot>'


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["continuous", "fixed"])
def test_descriptions_of_the_greatest_size(kind: str) -> None:
    mechanism = cd.load(serial(MOST_LINKS, kind))
    assert len(mechanism.links) == MOST_LINKS


@pytest.mark.parametrize("kind", ["continuous", "fixed"])
def test_reading_takes_work_in_proportion_to_the_links(kind: str) -> None:
    def calls(links: int) -> int:
        urdf, count = serial(links, kind), 0

        def counted(_frame: object, event: str, _argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(counted)
        try:
            cd.load(urdf)
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


@pytest.mark.slow
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
        ("<svg/>", "text: the outermost"),
        ("<robot>\ud800</robot>", "text: malformed"),
    ):
        with pytest.raises(cd.ModelError) as caught:
            cd.load(content)
        assert str(caught.value).startswith(start)


@pytest.mark.parametrize("strict", [0, "no", None, [], np.array([True, False])])
def test_strict_is_true_or_false(strict: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"strict is .*expected True or False"):
        cd.load("universal_joint", strict=strict)


BODY = '<worldbody><body name="b"><freejoint/><geom size="1"/></body></worldbody>'


def test_every_bundled_name_is_a_file_of_the_directory() -> None:
    assert bundled_names() == sorted(
        path.name.removesuffix(".urdf") for path in bundled_directory().iterdir()
    )
    for name in bundled_names():
        description = read(name)
        assert description.source is not None
        assert description.source.path == bundled_directory() / f"{name}.urdf"
        assert description.source.text == description.source.path.read_text("utf-8")


def test_a_bundled_name_is_preferred_to_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "universal_joint").write_text('<robot><link name="a"/></robot>')
    assert read("universal_joint") == read(JOINT)
    assert [link.name for link in read("./universal_joint").links] == ["a"]


def test_paths_of_every_kind(tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    path.write_text("\ufeff" + JOINT, encoding="utf-8")
    for source in (path, str(path), os.path.relpath(path), np.str_(path), Nowhere(str(path))):
        description = read(source)
        assert description == read(JOINT)
        assert description.source is not None
        assert description.source.path == Path(str(os.fspath(source)))
        assert description.source.text == JOINT


@pytest.mark.parametrize("start", ["", "\ufeff", " \r\n\t", "\ufeff\n", "<!-- comment -->"])
def test_what_may_stand_before_a_text(start: str) -> None:
    robot = JOINT[JOINT.index("<robot") :]
    description = read(start + robot)
    assert description == read(JOINT)
    assert description.source is not None
    assert description.source.path is None


def test_the_outermost_element_chooses_the_reader() -> None:
    urdf = read('<robot name="r"><link name="a"/></robot>')
    mjcf = read(f'<mujoco model="m">{BODY}</mujoco>')
    assert (urdf.name, urdf.joints) == ("r", ())
    assert (mjcf.name, mjcf.joints[0].type) == ("m", "floating")
    sdf = read('<sdf version="1.9"><model name="s"><link name="a"/></model></sdf>')
    assert (sdf.name, sdf.joints[0].type) == ("s", "floating")
    with pytest.raises(cd.ModelError, match="is <svg>, expected <robot>, <mujoco> or <sdf>"):
        read("<svg/>")


@pytest.mark.parametrize("strict", [True, np.True_, False, np.False_])
def test_strict_reaches_both_readers(strict: object) -> None:
    mjcf = f"<mujoco>{BODY}</mujoco>".replace('name="b"', 'name="b" gravcomp="1"')
    urdf = '<robot><link name="a"><inertial><mass value="0"/><inertia/></inertial></link></robot>'
    for source in (mjcf, urdf):
        if strict:
            with pytest.raises(cd.ModelError, match="strict=False"):
                read(source, strict)  # type: ignore[arg-type]
        else:
            assert len(read(source, strict).warnings) == 1  # type: ignore[arg-type]


def test_unknown_name_or_file(tmp_path: Path) -> None:
    for source in ("no_such_joint", tmp_path / "none.urdf", tmp_path, "x\0y", "a" * 5000):
        with pytest.raises(cd.ModelError, match=r"bundled .*double_shaft_z, .*universal_joint"):
            cd.load(source)
    with pytest.raises(cd.ModelError, match="not NoneType"):
        cd.load(None)
    binary = tmp_path / "binary.urdf"
    binary.write_bytes(b"\xff\x00<robot>")
    with pytest.raises(cd.ModelError, match=r"binary\.urdf: cannot be read"):
        cd.load(binary)


def test_entities() -> None:
    """Few are read, very many are refused before they fill the memory."""
    robot = JOINT[JOINT.index("<robot") :]
    few = robot.replace('<axis xyz="0 1 0"/>', '<axis xyz="1 &zero;"/>')
    few = f'<!DOCTYPE robot [<!ENTITY zero "0 0">]>{few}'
    np.testing.assert_array_equal(cd.load(few).joint("pin_in").axis, [1.0, 0.0, 0.0])
    levels = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 12))
    bomb = f'<!DOCTYPE robot [<!ENTITY e0 "0 ">{levels}]>{robot.replace("0 1 0", "&e11;")}'
    with pytest.raises(cd.ModelError, match="malformed XML"):
        cd.load(bomb)
    elsewhere = '<!DOCTYPE robot SYSTEM "file:///nowhere">' + robot.replace("0 1 0", "0 1&x; 0")
    with pytest.raises(cd.ModelError, match="DOCTYPE refers to another document"):
        cd.load(elsewhere)


def test_a_comment_hides_no_reference_to_another_document() -> None:
    robot = JOINT[JOINT.index("<robot") :].replace('mass value="', 'mass value="&x;1', 1)
    for comment in ("", "<!-- <robot> -->"):
        with pytest.raises(cd.ModelError, match="text: its DOCTYPE refers to another document"):
            cd.load(f'{comment}<!DOCTYPE robot SYSTEM "file:///nowhere">{robot}')
