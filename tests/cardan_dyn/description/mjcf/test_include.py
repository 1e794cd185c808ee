"""Included files stand in the place of `<include>`, as deep as models were tested."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import fromstring, tostring

import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, same_as_urdf

import cardan_dyn as cd
from cardan_dyn.description.mjcf.reader import DEPTH, with_includes
from cardan_dyn.description.read import read


def test_includes(tmp_path: Path) -> None:
    equality = f"<equality>{CONNECTS['bodies']}</equality>"
    (tmp_path / "parts").mkdir()
    (tmp_path / "main.xml").write_text(
        HALVES.format(rocker='<include file="parts/rocker.xml"/>', more='<include file="e.xml"/>')
    )
    (tmp_path / "parts" / "rocker.xml").write_text('<x><include file="inner.xml"/></x>')
    (tmp_path / "parts" / "inner.xml").write_text(f"<mujocoinclude>{ROCKER}</mujocoinclude>")
    (tmp_path / "e.xml").write_text(f"<mujoco>{equality}</mujoco>")
    same_as_urdf(cd.load(tmp_path / "main.xml"))
    # Beside the main file comes before beside the including one, as in MuJoCo.
    (tmp_path / "inner.xml").write_text("<x><body name='other'/></x>")
    with pytest.raises(cd.ModelError, match=r"body2 'rocker' does not exist; names: .*other"):
        cd.load(tmp_path / "main.xml")
    for content, message in (
        ('<x><include file="parts/rocker.xml"/></x>', "is included twice, or includes itself"),
        ('<x><include file="main.xml"/></x>', "is included twice, or includes itself"),
        ('<x><include file="nowhere.xml"/></x>', "there is no file .*nowhere.xml"),
        ("<x><include/></x>", 'an <include> needs file="..."'),
        ('<x><include file="e.xml"><y/></include></x>', "it has elements of its own"),
        ("<x>", "malformed XML"),
        ("<x>\0</x>", "malformed XML"),
    ):
        (tmp_path / "inner.xml").write_text(content)
        (tmp_path / "parts" / "inner.xml").write_text(content)
        with pytest.raises(cd.ModelError, match=message):
            cd.load(tmp_path / "main.xml")
    with pytest.raises(cd.ModelError, match=r"text has no directory .*load the file by its path"):
        read('<mujoco><include file="a.xml"/></mujoco>')


def test_depth() -> None:
    def nested(count: int) -> str:
        bodies = "<body><joint/>" * count + "</body>" * count
        return f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"

    assert len(read(nested(297)).joints) == 297
    for count in (299, 5000):
        with pytest.raises(cd.ModelError, match="nested 301 elements deep; the limit is 300"):
            read(nested(count))
    with pytest.raises(cd.ModelError, match="the limit is 300"):
        read("<mujoco>" + "<default>" * 20000 + "</default>" * 20000 + "</mujoco>")


def text_of(tmp_path: Path, main: str, **files: str) -> str:
    """Return a model with its includes resolved, as text."""
    for name, content in files.items():
        (tmp_path / f"{name}.xml").write_text(content, encoding="utf-8")
    root = fromstring(main)
    before = tostring(root)
    resolved = tostring(with_includes(root, "x", tmp_path / "main.xml"), encoding="unicode")
    assert tostring(root) == before
    return resolved


def test_elements_keep_their_order_and_attributes(tmp_path: Path) -> None:
    found = text_of(
        tmp_path,
        '<m model="n"><a/><include file="f.xml"/><b c="1"><include file="g.xml"/><d/></b></m>',
        f='<other lost="1"><e x="1"><h/></e><include file="i.xml"/><j/></other>',
        g="<other><k/><l/></other>",
        i="<other/>",
    )
    assert found == ('<m model="n"><a /><e x="1"><h /></e><j /><b c="1"><k /><l /><d /></b></m>')


def test_a_model_without_includes_is_copied() -> None:
    root = fromstring('<m a="1"><b><c/></b></m>')
    copied = with_includes(root, "x", None)
    assert tostring(copied) == tostring(root)
    assert copied is not root
    assert copied[0] is not root[0]


def test_a_file_is_looked_for_beside_the_main_file_first(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "f.xml").write_text('<x><include file="g.xml"/></x>')
    (tmp_path / "sub" / "g.xml").write_text("<x><beside/></x>")
    main = '<m><include file="sub/f.xml"/></m>'
    assert text_of(tmp_path, main) == "<m><beside /></m>"
    assert text_of(tmp_path, main, g="<x><first/></x>") == "<m><first /></m>"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'<!DOCTYPE x SYSTEM "file:///nowhere"><x a="&b;"/>', "its DOCTYPE refers to another"),
        (b"\xff", "malformed XML: .*is it in the encoding that it declares"),
        (b"<x/><x/>", "malformed XML"),
        (b"", "malformed XML"),
    ],
)
def test_files_that_cannot_be_read(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "f.xml").write_bytes(content)
    with pytest.raises(cd.ModelError, match=rf"^x: <include file='f.xml'>: {message}"):
        text_of(tmp_path, '<m><include file="f.xml"/></m>')


def test_a_file_may_begin_with_a_byte_order_mark_and_blanks(tmp_path: Path) -> None:
    main = '<m><include file="f.xml"/></m>'
    assert text_of(tmp_path, main, f="\ufeff\n <x><a/></x>") == "<m><a /></m>"


@pytest.mark.parametrize(
    ("element", "message"),
    [
        ("<include/>", 'x: an <include> needs file="..."'),
        ('<include file=""/>', 'x: an <include> needs file="..."'),
        (
            '<include file="f.xml" prefix="a"/>',
            "<include>: attribute 'prefix' is unknown; attributes: file",
        ),
        (
            '<include file="f.xml"><a/></include>',
            "it has elements of its own; an <include> has none",
        ),
        ('<include file="f.xml"/>', "there is no file .*f.xml"),
        ('<include file="."/>', "there is no file"),
        ('<include file="main.xml"/>', "the file is included twice, or includes itself"),
    ],
)
def test_includes_that_are_refused(tmp_path: Path, element: str, message: str) -> None:
    (tmp_path / "main.xml").write_text("<m/>")
    with pytest.raises(cd.ModelError, match=message):
        text_of(tmp_path, f"<m>{element}</m>")


@pytest.mark.parametrize("in_file", [0, 100])
def test_the_depth_counts_through_included_files(tmp_path: Path, in_file: int) -> None:
    def nested(depth: int, innermost: str = "") -> str:
        return "<a>" * depth + innermost + "</a>" * depth

    def resolved(depth: int) -> str:
        """Return a model of a depth, some of which is in an included file."""
        main = nested(depth - in_file, '<include file="f.xml"/>')
        return text_of(tmp_path, main, f=f"<x>{nested(in_file)}</x>")

    assert resolved(DEPTH).count("<a") == DEPTH
    with pytest.raises(
        cd.ModelError, match=r"^x: <a> is nested 301 elements deep; the limit is 300"
    ):
        resolved(DEPTH + 1)
