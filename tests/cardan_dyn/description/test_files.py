"""The suffix of a file chooses the notation in which a description is written."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.read import read
from cardan_dyn.core.description.write import to_urdf, write
from cardan_dyn.practice.formats.mjcf.writer import to_mjcf


@pytest.mark.parametrize("name", ["a.urdf", "a.URDF", "b c.xml", "ü.mjcf"])
def test_suffixes(tmp_path: Path, name: str) -> None:
    description = read("four_bar")
    expected = to_urdf if name.lower().endswith("urdf") else to_mjcf
    for path in (tmp_path / name, str(tmp_path / name)):
        assert write(description, path) == tmp_path / name
        assert (tmp_path / name).read_text(encoding="utf-8") == expected(description)
    assert read(tmp_path / name).name == "four_bar"


def test_what_was_there_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.urdf"
    path.write_text("x" * 100_000, encoding="utf-8")
    write(read("four_bar"), path)
    assert read(path).agrees(read("four_bar"), 1e-15)


def test_names_of_any_script_are_read_back(tmp_path: Path) -> None:
    text = '<robot name="Kardan-Gelenk β"><link name="Welle &amp; &lt;Gabel&gt;"/></robot>'
    for suffix in ("urdf", "xml"):
        path = write(read(text), tmp_path / f"a.{suffix}")
        assert read(path).name == "Kardan-Gelenk β"
        assert "Welle & <Gabel>" in [link.name for link in read(path).links]


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("a.sdf", r"suffix '\.sdf' names no notation; write \.urdf for URDF\+, \.xml or \.mjcf"),
        ("a", "suffix '' names no notation"),
        ("no/such/a.urdf", "the directory '.*no.such' does not exist"),
        (3, "path is 3, expected a path"),
        (None, "path is None, expected a path"),
        (b"a.urdf", "expected a path"),
        ("a\0b/c.urdf", "does not exist"),
        ("a\0b.urdf", "cannot be written"),
    ],
)
def test_paths_that_cannot_be_written(tmp_path: Path, path: object, message: str) -> None:
    target = str(tmp_path / path) if isinstance(path, str) else path
    with pytest.raises(cd.ArgumentError, match=message):
        write(read("four_bar"), target)  # type: ignore[arg-type]


def test_a_directory_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").mkdir()
    with pytest.raises(cd.ArgumentError, match="cannot be written"):
        write(read("four_bar"), tmp_path / "a.urdf")


def test_nothing_is_written_where_something_has_no_notation(tmp_path: Path) -> None:
    massless = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
    massless += '<parent link="a"/><child link="b"/></joint></robot>'
    with pytest.raises(cd.ModelError, match="link 'b' moves and has no mass"):
        write(read(massless), tmp_path / "a.xml")
    assert not list(tmp_path.iterdir())
