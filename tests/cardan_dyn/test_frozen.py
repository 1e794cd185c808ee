"""Frozen objects, mappings and arrays refuse every change, and can be copied and pickled."""

from __future__ import annotations

import copy
import inspect
import pickle
import traceback
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pytest

from cardan_dyn.kit import errors
from cardan_dyn.kit.errors import ImmutableError
from cardan_dyn.kit.frozen import Frozen, FrozenDict, frozen, read_only


class Point(Frozen):
    def __init__(self, x: float) -> None:
        self.x = x
        self.x += 1.0
        self._freeze()


def test_attributes_can_be_set_until_the_object_is_frozen() -> None:
    point = Point(1.0)
    assert point.x == 2.0
    with pytest.raises(
        ImmutableError, match=r"^x of a Point cannot be changed; make another Point"
    ):
        point.x = 3.0
    with pytest.raises(ImmutableError, match=r"^y of a Point cannot be changed"):
        point.y = 3.0
    with pytest.raises(ImmutableError, match=r"^x of a Point cannot be changed"):
        del point.x
    assert vars(point) == {"x": 2.0, "_is_frozen": True}


@pytest.mark.parametrize(
    "duplicate",
    [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))],
    ids=["copy", "deepcopy", "pickle"],
)
def test_copies_are_frozen_too(duplicate: Callable[[object], object]) -> None:
    point = duplicate(Point(1.0))
    assert isinstance(point, Point)
    assert point.x == 2.0
    with pytest.raises(ImmutableError):
        point.x = 3.0
    mapping = duplicate(FrozenDict({"a": [1.0]}))
    assert mapping == {"a": [1.0]}
    assert isinstance(mapping, FrozenDict)
    with pytest.raises(ImmutableError):
        mapping["a"] = 2.0


def unite(mapping: dict[str, float]) -> None:
    mapping |= {"b": 2.0}


CHANGES: dict[str, Callable[[dict[str, float]], object]] = {
    "set": lambda mapping: mapping.__setitem__("a", 2.0),
    "delete": lambda mapping: mapping.__delitem__("a"),
    "clear": lambda mapping: mapping.clear(),
    "pop": lambda mapping: mapping.pop("a"),
    "pop a missing key": lambda mapping: mapping.pop("b", None),
    "pop an item": lambda mapping: mapping.popitem(),
    "set a default": lambda mapping: mapping.setdefault("b", 2.0),
    "update": lambda mapping: mapping.update(b=2.0),
    "update with nothing": lambda mapping: mapping.update(),
    "unite": unite,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES.keys())
def test_no_method_changes_a_frozen_mapping(change: Callable[[dict[str, float]], object]) -> None:
    mapping = FrozenDict({"a": 1.0})
    with pytest.raises(ImmutableError, match=r"this mapping cannot be changed; copy it with dict"):
        change(mapping)
    assert mapping == {"a": 1.0}


def test_all_methods_that_change_a_dictionary_are_tested() -> None:
    """Every method of `dict` is either harmless or refused by `FrozenDict`."""
    harmless = {"copy", "fromkeys", "get", "items", "keys", "values"}
    methods = {name for name in vars(dict) if not name.startswith("_")} - harmless
    assert methods == {"clear", "pop", "popitem", "setdefault", "update"}
    for name in (*methods, "__setitem__", "__delitem__", "__ior__"):
        assert getattr(FrozenDict, name) is not getattr(dict, name), name


def test_a_deep_copy_shares_the_mapping() -> None:
    mapping = FrozenDict({"a": np.zeros(2)})
    assert copy.deepcopy(mapping) is mapping
    assert dict(mapping) is not mapping
    dict(mapping)["a"] = 1.0  # A plain copy may be changed.


def test_frozen_copies_the_mapping_and_protects_its_arrays() -> None:
    array = np.zeros(2)
    given = {"a": array, "b": 1.0}
    mapping = frozen(given)
    given["c"] = 2.0
    assert list(mapping) == ["a", "b"]
    assert mapping["a"] is array
    with pytest.raises(ValueError, match="read-only"):
        mapping["a"][0] = 1.0


def test_read_only_returns_the_same_array() -> None:
    array = np.zeros(2)
    assert read_only(array) is array
    with pytest.raises(ValueError, match="read-only"):
        array += 1.0


def test_arrays_of_a_copied_mapping_are_read_only() -> None:
    mapping = pickle.loads(pickle.dumps(frozen({"a": np.zeros(3)})))
    with pytest.raises(ValueError, match="read-only"):
        mapping["a"][0] = 1.0


class Guessed(Frozen):
    """With a property that fails, and a name that people try."""

    _meant: ClassVar[dict[str, str]] = {"run solve": "call start()"}

    def __init__(self) -> None:
        self.value = 1
        self._freeze()

    @property
    def broken(self) -> int:
        raise AttributeError("of its own")

    @cached_property
    def kept(self) -> int:
        return self.nothing  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("run", "Guessed has no attribute 'run'; call start()"),
        ("SOLVE", "Guessed has no attribute 'SOLVE'; call start()"),
        ("brokn", "Guessed has no attribute 'brokn' (did you mean 'broken'?)"),
        ("xyzxyz", "Guessed has no attribute 'xyzxyz'; see dir()"),
        ("broken", "of its own"),
        ("kept", "Guessed has no attribute 'nothing'; see dir()"),
    ],
)
def test_attributes_that_do_not_exist_are_told_what_is_meant(name: str, told: str) -> None:
    with pytest.raises(AttributeError) as caught:
        getattr(Guessed(), name)
    assert str(caught.value) == told
    shown = "".join(traceback.format_exception_only(caught.value))
    assert shown.count("did you mean") <= 1
    assert "Did you mean" not in shown


def test_protocols_find_only_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Copies, pickles and probes of notebooks ask for names that are none, and get no message."""
    messages: list[str] = []
    monkeypatch.setattr(errors, "guessed", lambda *given: messages.append(given[0]) or "")
    item = Guessed()
    for name in ("__array__", "_repr_html_", "_ipython_canary_method_should_not_exist_", "shape"):
        assert not hasattr(item, name)
    for again in (copy.copy(item), copy.deepcopy(item), pickle.loads(pickle.dumps(item))):
        assert again.value == 1
    assert {"broken", "kept", "value"} <= set(dir(item))
    assert messages == []
    error = pickle.loads(pickle.dumps(errors.NoAttributeError(Guessed, "run")))
    assert error.name == "run"
    assert error.kind is Guessed


def test_unknown_arguments_are_told_what_is_meant() -> None:
    @errors.hinting({"rpm turns": "speeds are in rad/s"})
    def move(position: float, *, speed: float = 0.0) -> float:
        """Move."""
        if speed < 0.0:
            raise TypeError("its own")
        return position + speed

    assert move(1.0, speed=2.0) == 3.0
    assert move.__doc__ == "Move."
    assert list(inspect.signature(move).parameters) == ["position", "speed"]
    wrong: Any = move
    for given, told in (
        ({"rpm": 3.0}, r"move has no argument 'rpm'; speeds are in rad/s"),
        (
            {"sped": 3.0},
            r"'sped'; arguments: position, speed \(did you mean 'speed'",
        ),
    ):
        with pytest.raises(TypeError, match=told):
            wrong(1.0, **given)
    with pytest.raises(TypeError, match="its own"):
        move(1.0, speed=-1.0)
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'position'"):
        wrong()
