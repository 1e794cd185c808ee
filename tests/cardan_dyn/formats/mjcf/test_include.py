"""Included files stand in the place of `<include>`, in any encoding."""

from __future__ import annotations

from pathlib import Path

import pytest
from testkit.mjcf import CONNECTS, HALVES, ROCKER, same_as_urdf

import cardan_dyn as cd
from cardan_dyn.core.description.read import read


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
    with pytest.raises(cd.ModelError, match="unknown element 'rocker' in equality"):
        cd.load(tmp_path / "main.xml")
    for content, message in (
        ('<x><include file="parts/rocker.xml"/></x>', "already included"),
        ('<x><include file="nowhere.xml"/></x>', "there is no file .*nowhere.xml"),
        ("<x><include/></x>", "required attribute missing: 'file'|unexpected"),
        ("<x>", "malformed XML"),
        ("<x>\0</x>", "malformed XML"),
    ):
        (tmp_path / "inner.xml").write_text(content)
        (tmp_path / "parts" / "inner.xml").write_text(content)
        with pytest.raises(cd.ModelError, match=message):
            cd.load(tmp_path / "main.xml")


def test_text_has_no_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even where the file is beside the caller."""
    (tmp_path / "a.xml").write_text("<x/>")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(cd.ModelError, match=r"text has no directory .*load the file by its path"):
        read('<mujoco><include file="a.xml"/></mujoco>')


def test_depth() -> None:
    def nested(count: int) -> str:
        bodies = "<body><joint/>" * count + "</body>" * count
        return f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"

    assert len(read(nested(297)).joints) == 297
    with pytest.raises(cd.ModelError, match="nesting is too deep"):
        read(nested(5000))
    with pytest.raises(cd.ModelError, match="nesting is too deep"):
        read("<mujoco>" + "<default>" * 20000 + "</default>" * 20000 + "</mujoco>")


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
    main = tmp_path / "main.xml"
    main.write_text('<mujoco><include file="f.xml"/></mujoco>')
    with pytest.raises(cd.ModelError, match=rf"<include file='f.xml'>: {message}"):
        cd.load(main)


def test_a_file_may_begin_with_a_byte_order_mark_and_blanks(tmp_path: Path) -> None:
    (tmp_path / "f.xml").write_text(
        "\ufeff\n <x><worldbody><body name='a'/></worldbody></x>", "utf-8"
    )
    (tmp_path / "main.xml").write_text('<mujoco><include file="f.xml"/></mujoco>')
    assert [link.name for link in read(tmp_path / "main.xml").links] == ["world", "a"]


@pytest.mark.parametrize("name", ["f.xml", ".", "x" * 5000])
def test_files_that_are_not_there(tmp_path: Path, name: str) -> None:
    main = tmp_path / "main.xml"
    main.write_text(f'<mujoco><include file="{name}"/></mujoco>')
    with pytest.raises(cd.ModelError, match="there is no file"):
        cd.load(main)
