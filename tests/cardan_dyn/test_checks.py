"""Checks of single arguments return plain values of the expected type, or say what they expect."""

from __future__ import annotations

import itertools
import sys
from collections import OrderedDict, UserDict
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType, ModuleType

import numpy as np
import pytest
from testkit.exploding import Exploding, ExplodingMapping

import cardan_dyn as cd
from cardan_dyn.kit import checks


class ExplodingError(Exception):
    """An error whose message cannot be read."""

    def __str__(self) -> str:
        raise ZeroDivisionError("no message")


class Raising:
    """Raises a given error when it is iterated or made an array."""

    def __init__(self, error: Exception) -> None:
        self.error = error

    def __iter__(self) -> object:
        raise self.error

    def __array__(self, *_: object, **__: object) -> np.ndarray:
        raise self.error


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "None"),
        (True, "True"),
        (-3, "-3"),
        (2.5, "2.5"),
        (1j, "1j"),
        ("it's", '"it\'s"'),
        (b"a", "b'a'"),
        (10**5000, "of type int"),
        (np.zeros(2), "an array of type float64"),
        (np.array(["ab"]), "an array of type <U2"),
        ([], "of type list"),
        (Exploding(), "of type Exploding"),
        (int, "the class int itself"),
    ],
    ids=lambda item: type(item).__name__,
)
def test_described_shows_plain_values_and_the_type_of_others(value: object, text: str) -> None:
    assert checks.described(value) == text


def test_described_is_shorter_than_a_line() -> None:
    found = checks.described("x" * 1000)
    assert len(found) == 80
    assert found.startswith("'xxx")
    assert found.endswith("x...")


@pytest.mark.parametrize(("text", "expected"), [("abcdef", "abcdef"), ("abcdefg", "abc...")])
def test_shortened(text: str, expected: str) -> None:
    assert checks.shortened(text, 6) == expected


@pytest.mark.parametrize("value", [True, False, np.True_, np.False_])
def test_flags_are_pythons(value: object) -> None:
    found = checks.flag("strict", value)
    assert type(found) is bool
    assert found == value


@pytest.mark.parametrize("value", [None, 0, 1.0, "True", np.array(True), Exploding()], ids=repr)
def test_no_flags(value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"^strict is .*, expected True or False$"):
        checks.flag("strict", value)


@pytest.mark.parametrize("value", ["", "name", np.str_("name")])
def test_texts_are_pythons(value: str) -> None:
    found = checks.text("branch", value)
    assert type(found) is str
    assert found == value


@pytest.mark.parametrize("value", [None, 3, b"name", np.array("name"), Exploding()], ids=repr)
def test_no_texts(value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"^branch is .*, expected a string$"):
        checks.text("branch", value)


NO_NAMES = {
    "number": 3,
    "nothing in a list": [None],
    "nothing among names": ["bearing_in", None],
    "numbers": np.array([1.0, 2.0]),
    "table": np.array([["bearing_in"]]),
    "objects": np.array(["bearing_in", None], object),
    "set": {"bearing_in"},
    "frozen set": frozenset({"bearing_in"}),
    "mapping": {"bearing_in": 1.0},
    "bytes": b"bearing_in",
    "list in a list": [["bearing_in"]],
    "exploding": Exploding(),
    "exploding in a list": [Exploding()],
    "function": len,
    "endless": itertools.repeat("bearing_in"),
    "generator that fails": (str(1 // number) for number in (1, 0)),
}


@pytest.mark.parametrize("value", NO_NAMES.values(), ids=NO_NAMES.keys())
def test_no_names(value: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"^roles(\[\d+\])? (is|has) "):
        checks.names("roles", value)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("a", ("a",)),
        (["a", "b"], ("a", "b")),
        (("b", "a", "b"), ("b", "a", "b")),
        ((name for name in "ab"), ("a", "b")),
        (np.array("a"), ("a",)),
        (np.array(["a", "b"]), ("a", "b")),
        ({"a": 1, "b": 2}.keys(), ("a", "b")),
        ([], ()),
    ],
    ids=lambda value: type(value).__name__,
)
def test_names_keep_their_order(value: object, expected: tuple[str, ...]) -> None:
    found = checks.names("outputs", value)
    assert found == expected
    assert all(type(name) is str for name in found)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (3, "is 3, expected a name or a sequence of names"),
        ({"a"}, "is of type set, which has no order; expected a name or a sequence of names"),
        ({"a": 1}, "is of type dict; expected a name or a sequence of names"),
        (b"a", "is b'a'; expected a name or a sequence of names"),
        (Exploding(), r"is not a name or a sequence of names \(not to be iterated\)"),
        (Raising(ExplodingError()), r"is not a name or a sequence of names \(ExplodingError\)"),
        (Raising(KeyError()), r"is not a name or a sequence of names \(KeyError\)"),
        (Raising(ValueError("a\n b")), r"is not a name or a sequence of names \(a b\)"),
        (Raising(cd.ArgumentError("mine")), "mine"),
        (itertools.repeat("a"), "has more than 100000 names"),
    ],
    ids=lambda item: type(item).__name__,
)
def test_messages_say_why_something_is_no_name(value: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=rf"^(outputs )?{message}$"):
        checks.names("outputs", value)


def test_reasons_of_any_length_are_cut() -> None:
    with pytest.raises(cd.ArgumentError) as caught:
        checks.names("outputs", Raising(ValueError("x" * 10_000)))
    reason = str(caught.value).split("(")[1]
    assert reason == "x" * 200 + ")"


@pytest.mark.parametrize(
    "kind", [dict, OrderedDict, UserDict, MappingProxyType], ids=lambda kind: kind.__name__
)
def test_mappings_become_new_dictionaries(kind: Callable[[object], object]) -> None:
    given = kind({np.str_("b"): 1, "a": [2]})
    found = checks.mapping("held", given)
    assert found == {"b": 1, "a": [2]}
    assert list(found) == ["b", "a"]
    assert type(found) is dict and found is not given
    assert all(type(key) is str for key in found)


def test_no_mapping_at_all_is_an_empty_one() -> None:
    assert checks.mapping("held", None) == {}


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([("a", 1)], "held is of type list, expected a mapping of names to values"),
        (3, "held is 3, expected a mapping of names to values"),
        ({1: 2}, "a key of held is 1, expected a string"),
        (ExplodingMapping(a=1), r"held is not a mapping of names to values \(no items\)"),
    ],
    ids=lambda item: type(item).__name__,
)
def test_no_mappings(value: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=f"^{message}$"):
        checks.mapping("held", value)


@pytest.mark.parametrize(
    "value",
    [[1, 2], (1.0, 2.0), np.array([1, 2], np.uint8), np.array([1, 2], np.float16)],
    ids=lambda item: type(item).__name__,
)
def test_numbers_are_doubles_in_memory_of_their_own(value: object) -> None:
    found = checks.numbers("speed", value)
    assert found.dtype == float
    assert found.tolist() == [1.0, 2.0]
    double = np.array([1.0, 2.0])
    assert not np.shares_memory(checks.numbers("speed", double), double)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (None, r"is not an array of real numbers \(it is None\)"),
        (True, r"is not an array of real numbers \(it is True\)"),
        ("1", r"is not an array of real numbers \(it is '1'\)"),
        (b"1", r"is not an array of real numbers \(it is b'1'\)"),
        (bytearray(b"1"), r"is not an array of real numbers \(it is of type bytearray\)"),
        ([1j], r"is not an array of real numbers \(its elements are of type complex128\)"),
        ([True], r"is not an array of real numbers \(its elements are of type bool\)"),
        ([[1.0], [1.0, 2.0]], r"is not an array of real numbers \(.*inhomogeneous.*\)"),
        (Raising(ValueError("no array")), r"is not an array of real numbers \(no array\)"),
        (
            np.ma.masked_array([1.0, 2.0], [False, True]),
            r"is not an array of real numbers \(some are masked\)",
        ),
        (np.nan, "is not finite"),
        ([[1.0, 2.0], [np.inf, np.nan]], r"is not finite at index \[1, 0\]"),
        (np.array(["1", "1e4000"], np.longdouble), r"is not finite at index \[1\]"),
    ],
    ids=lambda item: type(item).__name__,
)
def test_messages_say_why_something_is_no_array_of_numbers(value: object, message: str) -> None:
    with pytest.raises(cd.ArgumentError, match=f"^speed {message}$"):
        checks.numbers("speed", value)


def test_masked_arrays_without_masked_numbers_are_arrays() -> None:
    masked = np.ma.masked_array([1.0, 2.0], [False, False])
    assert checks.numbers("speed", masked).tolist() == [1.0, 2.0]


def test_another_thread_may_have_begun_to_import_masked_arrays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Then their module is there, without what it is about to hold."""
    monkeypatch.setitem(sys.modules, "numpy.ma", ModuleType("numpy.ma"))
    assert checks.numbers("speed", [1.0, 2.0]).tolist() == [1.0, 2.0]


@pytest.mark.parametrize("value", [3, 3.0, np.int64(3), np.float32(3.0), np.array(3.0)], ids=repr)
def test_single_numbers_are_plain_floats(value: object) -> None:
    for check in (checks.number, checks.positive):
        found = check("play", value)
        assert type(found) is float
        assert found == 3.0


@pytest.mark.parametrize("check", [checks.number, checks.positive])
@pytest.mark.parametrize("value", [np.nan, -np.inf, "1", None, True, [1.0], 1j], ids=repr)
def test_no_single_numbers(check: Callable[[str, object], float], value: object) -> None:
    with pytest.raises(
        cd.ArgumentError, match=r"^play (is not|has shape \(1,\), expected a number)"
    ):
        check("play", value)


def test_numbers_that_are_too_small() -> None:
    assert checks.number("play", -1e300) == -1e300
    assert checks.number("play", 0.5, least=0.5) == 0.5
    with pytest.raises(cd.ArgumentError, match=r"^play is 0\.4; it is not less than 0\.5$"):
        checks.number("play", 0.4, least=0.5)
    assert checks.positive("play", 5e-324) == 5e-324
    for value in (0.0, -0.0, -2.0):
        with pytest.raises(cd.ArgumentError, match=r"^play is -?[02], expected a positive number$"):
            checks.positive("play", value)


@pytest.mark.parametrize("check", [checks.several, checks.positives])
def test_several_numbers_are_a_vector(check: Callable[[str, object], np.ndarray]) -> None:
    assert check("orders", 2).tolist() == [2.0]
    assert check("orders", (2, 4.0)).tolist() == [2.0, 4.0]
    for value, shape in (([], r"\(0,\)"), ([[1.0, 2.0]], r"\(1, 2\)")):
        with pytest.raises(cd.ArgumentError, match=rf"^orders has shape {shape}, expected a numb"):
            check("orders", value)
    for value in ("two", None, [1.0, np.nan]):
        with pytest.raises(cd.ArgumentError, match=r"^orders is not"):
            check("orders", value)


def test_positive_ones_among_several() -> None:
    assert checks.several("orders", [1.0, -2.0]).tolist() == [1.0, -2.0]
    for value in ([1.0, -2.0], -2.0):
        with pytest.raises(cd.ArgumentError, match=r"^orders holds -2, expected positive numbers$"):
            checks.positives("orders", value)


def test_vectors() -> None:
    assert checks.vector("gravity", (0, 0, -1), 3).tolist() == [0.0, 0.0, -1.0]
    for value, shape in ((1.0, r"\(\)"), ([1.0, 2.0], r"\(2,\)"), ([[1, 2, 3]], r"\(1, 3\)")):
        with pytest.raises(
            cd.ArgumentError, match=rf"^gravity has shape {shape}, expected \(3,\)$"
        ):
            checks.vector("gravity", value, 3)


@pytest.mark.parametrize("ended", [KeyboardInterrupt, OSError("no space left")])
def test_a_file_is_all_or_as_it_was(tmp_path: Path, ended: BaseException) -> None:
    target = tmp_path / "result.json"
    with checks.writing(target) as part:
        part.write_text("whole", encoding="utf-8")
    target.chmod(0o640)
    with pytest.raises((KeyboardInterrupt, cd.ArgumentError)), checks.writing(target) as part:
        part.write_text("ha", encoding="utf-8")
        raise ended
    assert target.read_text(encoding="utf-8") == "whole"
    assert part.suffix == ".json"  # By which others know a format.
    with checks.writing(target) as part:
        part.write_text("new", encoding="utf-8")
    assert target.read_text(encoding="utf-8") == "new"
    assert target.stat().st_mode & 0o777 == 0o640
    assert list(tmp_path.iterdir()) == [target]


def test_links_and_what_is_no_file_are_written_through(tmp_path: Path) -> None:
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    link.symlink_to(target)
    with checks.writing(link) as part:
        part.write_text("1", encoding="utf-8")
    assert link.is_symlink() and target.read_text(encoding="utf-8") == "1"
    with checks.writing(Path("/dev/null")) as part:
        assert part == Path("/dev/null")
    with checks.writing(tmp_path) as part:
        assert part == tmp_path
    # No name for a part is left beside the longest ones.
    longest = tmp_path / ("a" * 251 + ".csv")
    with checks.writing(longest) as part:
        part.write_text("2", encoding="utf-8")
    assert longest.read_text(encoding="utf-8") == "2"


def test_messages_name_the_file_that_was_asked_for(tmp_path: Path) -> None:
    missing = tmp_path / "none" / "result.csv"
    with (
        pytest.raises(cd.ArgumentError, match=r"result\.csv: cannot be written") as found,
        checks.writing(missing) as part,
    ):
        part.write_text("1", encoding="utf-8")
    assert ".part" not in str(found.value)
