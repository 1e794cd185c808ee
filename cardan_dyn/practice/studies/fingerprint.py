"""Fingerprint: what decides the results of a function, part by part, so that a change has a name.

A function is its code without comments and docstrings, its defaults, what it encloses, and what it
takes from its module: other functions and classes of that module, numbers, mechanisms. What it
imports from elsewhere is known by name alone; a study records versions besides.
"""

from __future__ import annotations

import dataclasses
import dis
import hashlib
import pickle
from collections.abc import Iterator, Mapping
from enum import EnumMeta
from functools import cached_property, partial
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from ...core.description.write import to_urdf
from ...core.mechanism.mechanism import Mechanism
from ...kit.errors import ModelError
from ...scene.scene import Scene, TaskScene


def fingerprint(function: object) -> dict[str, str]:
    """Return the parts that decide what a function returns, each with its hash."""
    parts: dict[str, str] = {}
    _Walk(parts).add("the function", function)
    return parts


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Return the parts that two fingerprints do not have in common."""
    return sorted(name for name in {*before, *now} if before.get(name) != now.get(name))


def descriptions(function: object) -> dict[str, str]:
    """Return the mechanisms that a function holds: their names, and their descriptions' texts."""
    parts: dict[str, str] = {}
    walk = _Walk(parts)
    walk.add("the function", function)
    return {mechanism.name: text_of(mechanism) for mechanism in walk.mechanisms}


def text_of(mechanism: Mechanism) -> str:
    """Return the description of a mechanism as text, as URDF+ where that can say it."""
    try:
        return to_urdf(mechanism.description)
    except ModelError:  # URDF+ cannot say it: then all that was read.
        return repr(_contents(mechanism.description))


def _contents(item: object) -> object:
    """Return what a description holds and is compared by, numbers with all their digits."""
    if dataclasses.is_dataclass(item):
        fields = (field for field in dataclasses.fields(item) if field.compare)
        return {field.name: _contents(getattr(item, field.name)) for field in fields}
    if isinstance(item, Mapping):
        return {key: _contents(value) for key, value in item.items()}
    if isinstance(item, tuple):
        return tuple(map(_contents, item))
    return item.tolist() if isinstance(item, np.ndarray) else item


_WITHOUT_CODE: tuple[type, ...] = (BuiltinFunctionType, np.ufunc)
"""What can be called and has no code to look at."""


_VALUES = (str, bytes, int, float, complex, list, tuple, np.ndarray)
"""What has a value besides its attributes, where a class is made from it, as named tuples are."""


class _Walk:
    """Goes through objects, and writes the hash of each part that has a name of its own."""

    def __init__(self, parts: dict[str, str]) -> None:
        self.parts = parts
        self.mechanisms: list[Mechanism] = []
        self._seen: dict[int, tuple[object, str]] = {}
        self._modules: set[str] = set()
        self._globals: set[tuple[int, str]] = set()

    def add(self, name: str, item: object) -> None:
        """Write an object, and what it refers to, under a name."""
        if id(item) in self._seen:
            # Which of several objects a name stands for decides as well.
            self._put(name, f"the same as {self._seen[id(item)][1]}")
            return
        self._seen[id(item)] = item, name
        if isinstance(item, partial):
            self.add(name, item.func)
            self.add(f"arguments of {name}", (item.args, dict(item.keywords)))
        elif isinstance(item, MethodType):
            self.add(name, item.__func__)
            self.add(f"self of {name}", item.__self__)
        elif isinstance(item, FunctionType):
            self._function(name, item)
        elif isinstance(item, type):
            self._class(name, item)
        elif isinstance(item, Mechanism):
            self.mechanisms.append(item)
            self._put(f"the description of {item.name!r}", _digest(text_of(item)))
        elif isinstance(item, Scene):
            self.add(name, item.solver.problem)
            if isinstance(item, TaskScene):
                own = item.task, item.actuated, dict(item.effort_weights)
                self.add(f"task of {name}", own)
        elif isinstance(item, Mapping):
            for key, value in item.items():
                self.add(f"{name}[{key!r}]", value)
            self._put(f"keys of {name}", _digest(repr(list(item))))
        elif isinstance(item, (list, tuple)) and not _is_plain(item):
            for index, value in enumerate(item):
                self.add(f"{name}[{index}]", value)
            self._put(f"length of {name}", str(len(item)))
        elif dataclasses.is_dataclass(item):
            self.add(f"the class of {name}", type(item))
            for field in dataclasses.fields(item):
                self.add(f"{field.name} of {name}", getattr(item, field.name))
        elif isinstance(item, (set, frozenset)):
            self._put(name, _digest(_constant(item)))
        elif self._has_code(item):
            self.add(f"the class of {name}", type(item))
            self.add(f"attributes of {name}", _attributes(item))
            if isinstance(item, _VALUES):
                self._put(name, _digest(item))
        else:
            # Numbers of one value are one object or two: those without a name are not `seen`.
            self._seen.pop(id(item), None)
            self._put(name, _digest(item))

    def _put(self, name: str, digest: str) -> str:
        """Write a part, under a name of its own: several functions may have one name."""
        label, number = name, 2
        while label in self.parts:
            label, number = f"{name} ({number})", number + 1
        self.parts[label] = digest
        return label

    def _has_code(self, item: object) -> bool:
        """Return whether an object is of a class whose code decides results."""
        if isinstance(item, _WITHOUT_CODE):
            return False
        return callable(item) or type(item).__module__ in self._modules

    def _function(self, name: str, function: FunctionType) -> None:
        if _is_ours(function.__module__):
            self._put(name, f"{function.__module__}.{function.__qualname__}")
            return
        self._modules.add(function.__module__)
        label = self._put(f"the code of {function.__qualname__}", _digest(_code(function.__code__)))
        self._put(name, label)
        self.add(f"defaults of {function.__qualname__}", function.__defaults__ or ())
        self.add(f"defaults of {function.__qualname__}", function.__kwdefaults__ or {})
        for free, cell in zip(
            function.__code__.co_freevars, function.__closure__ or (), strict=True
        ):
            try:
                self.add(free, cell.cell_contents)
            except ValueError:  # Not assigned yet, such as a function that is still being defined.
                continue
        for used in sorted(set(_names(function.__code__))):
            place = id(function.__globals__), used
            if used in function.__globals__ and place not in self._globals:
                self._globals.add(place)
                value = function.__globals__[used]
                if isinstance(value, ModuleType):
                    continue
                inner = getattr(value, "__module__", None)
                if isinstance(value, (FunctionType, type)) and inner != function.__module__:
                    self._put(used, f"{inner}.{value.__qualname__}")
                else:
                    self.add(used, value)

    def _class(self, name: str, kind: type) -> None:
        label = self._put(name, f"{kind.__module__}.{kind.__qualname__}")
        if _is_ours(kind.__module__) or kind.__module__ == "builtins":
            return
        self._seen[id(kind)] = kind, label
        self._modules.add(kind.__module__)
        for base in kind.__bases__:
            if base.__module__ in self._modules:
                self.add(base.__qualname__, base)
            else:
                self._put(
                    f"a base of {kind.__qualname__}", f"{base.__module__}.{base.__qualname__}"
                )
        if isinstance(kind, EnumMeta):
            members: Mapping[str, Any] = kind.__members__
            members = {key: item.value for key, item in members.items()}
            self.add(f"members of {kind.__qualname__}", members)
        for key, member in vars(kind).items():
            plain = _unwrapped(member)
            if isinstance(plain, FunctionType):
                if plain.__module__ == kind.__module__:
                    self.add(f"{kind.__qualname__}.{key}", plain)
            elif not (key.startswith("__") or key == "_abc_impl" or isinstance(kind, EnumMeta)):
                self.add(f"{kind.__qualname__}.{key}", plain)


def _unwrapped(member: object) -> object:
    """Return the function that a member of a class stands for, or the member."""
    if isinstance(member, (staticmethod, classmethod)):
        return member.__func__
    if isinstance(member, property):
        return member.fget
    return member.func if isinstance(member, cached_property) else member


def _attributes(item: object) -> dict[str, object]:
    """Return the attributes of an object, those in slots included."""
    found: dict[str, object] = {}
    for kind in type(item).__mro__:
        slots = vars(kind).get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if name not in ("__dict__", "__weakref__") and hasattr(item, name):
                found[name] = getattr(item, name)
    return found | getattr(item, "__dict__", {})


def _is_ours(module: str | None) -> bool:
    """Return whether code is this package's, whose version a study records."""
    return (module or "").partition(".")[0] in ("cardan_dyn", "analytic")


def _code(code: CodeType) -> tuple[Any, ...]:
    """Return code as it runs, without docstrings and where it was written.

    Not its source: that of an edited file is no longer what runs, and that of a decorated function
    is not what is called.
    """
    steps = tuple((step.opname, _constant(step.argval)) for step in dis.get_instructions(code))
    counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount
    names = code.co_varnames, code.co_freevars
    return steps, code.co_exceptiontable.hex(), code.co_flags & _KIND, counts, names


_KIND = 0xFF
"""Flags of code that say what it is, generators and so on; others say how it was compiled."""


def _constant(item: object) -> Any:
    """Return what an instruction works on as a text that is the same in all processes."""
    if isinstance(item, CodeType):
        return _code(item)
    if isinstance(item, (set, frozenset)):
        return ("set", *sorted(map(repr, item)))
    return repr(item)


def _names(code: CodeType) -> Iterator[str]:
    """Iterate over the globals that code looks up, those of inner functions included."""
    for step in dis.get_instructions(code):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS"):
            yield step.argval
    for item in code.co_consts:
        if isinstance(item, CodeType):
            yield from _names(item)


def _is_plain(item: object) -> bool:
    """Return whether a value is numbers and words throughout, whose text says all of it."""
    if isinstance(item, (list, tuple)):
        return all(_is_plain(entry) for entry in item)
    return item is None or isinstance(item, (str, bytes, bool, int, float, complex))


def _digest(item: object) -> str:
    """Return the hash of a value without parts of its own."""
    if isinstance(item, np.ndarray) and item.dtype.kind in "biufc":
        data = f"{item.dtype.str}{item.shape}".encode() + np.ascontiguousarray(item).tobytes()
    elif _is_plain(item) or isinstance(item, np.generic):
        data = f"{type(item).__name__}{item!r}".encode()
    else:
        try:
            data = pickle.dumps(item, protocol=4)
        except Exception:  # Then it cannot be sent to a worker either, which is said there.
            data = f"{type(item).__module__}.{type(item).__qualname__}".encode()
    return hashlib.sha256(data).hexdigest()[:16]
