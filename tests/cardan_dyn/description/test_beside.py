"""YAML files beside a URDF: their content, and the names in it."""

from __future__ import annotations

from pathlib import Path

import pytest

import cardan_dyn as cd
from cardan_dyn.core.description.beside import (
    Beside,
    list_of_names,
    unknown_joints,
    yaml_content,
)
from cardan_dyn.core.description.elements import file_text


def test_files_are_read_as_unicode(tmp_path: Path) -> None:
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-32"):
        (tmp_path / "a.yaml").write_bytes("joint: [\u00e4]".encode(encoding))
        text = file_text(tmp_path / "a.yaml", "x")
        assert yaml_content(text, "x") == {"joint": ["\u00e4"]}
    with pytest.raises(cd.ModelError, match="x: cannot be read as YAML: unacceptable char"):
        yaml_content("\u00e4".encode("latin-1"), "x")
    with pytest.raises(cd.ModelError, match="x: cannot be read"):
        file_text(tmp_path / "none.yaml", "x")


@pytest.mark.parametrize("text", ["", "[1, 2]", "3", "--- word"])
def test_what_is_no_mapping_says_nothing(text: str) -> None:
    assert yaml_content(text, "x") == {}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [", "x: cannot be read as YAML"),
        ("a: 1\nb: 2\na: 3", "x: key names that occur twice: a"),
        ("a: !!python/object:x {}", "x: cannot be read as YAML"),
        ("a: 1\n---\nb: 2", "x: cannot be read as YAML"),
    ],
)
def test_malformed_files(text: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        yaml_content(text, "x")


def test_lists_of_names() -> None:
    assert list_of_names(["a", "b"], "x") == ["a", "b"]
    for value, message in (("a", "x is not a list of names"), ([1], "x: int is not a name")):
        with pytest.raises(cd.ModelError, match=message):
            list_of_names(value, "x")


def test_joints_that_do_not_exist() -> None:
    assert unknown_joints(["a"], {"a", "b"}, "x", strict=True) == []
    with pytest.raises(cd.ModelError, match=r"x: joint 'c' does not exist; joints: a, b; load\("):
        unknown_joints(["a", "c"], {"a", "b"}, "x", strict=True)
    assert unknown_joints(["c", "a", "c"], {"a"}, "x", strict=False) == [
        "x: joint 'c' does not exist and was passed over"
    ]


def test_files_add_nothing_unless_they_say_so() -> None:
    plain = Beside(Path("a"), "n", "", ())
    assert (plain.motors, plain.joint_types, plain.solved, plain.warnings) == ((), {}, set(), ())
