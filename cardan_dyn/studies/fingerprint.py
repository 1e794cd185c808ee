"""Fingerprint: what decides the results of a function, part by part, so that a change has a name.

A function is its code without comments and docstrings, its defaults, what it encloses, and what it
takes from its module: other functions and classes of that module, numbers, mechanisms. What it
imports from elsewhere is known by name alone; a study records versions besides.
"""

from __future__ import annotations

import ast
import builtins
import dataclasses
import dis
import hashlib
import inspect
import pickle
import textwrap
from collections.abc import Iterator, Mapping
from functools import partial
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from ..description.write import to_urdf
from ..errors import ModelError
from ..mechanism.mechanism import Mechanism
from ..scene.scene import Scene


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


class _Walk:
    """Goes through objects, and writes the hash of each part that has a name of its own."""

    def __init__(self, parts: dict[str, str]) -> None:
        self.parts = parts
        self.mechanisms: list[Mechanism] = []
        self._seen: dict[int, object] = {}
        self._modules: set[str] = set()

    def add(self, name: str, item: object) -> None:
        """Write an object, and what it refers to, under a name."""
        if id(item) in self._seen:
            return
        self._seen[id(item)] = item
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
            self.parts[f"the description of {item.name!r}"] = _digest(text_of(item))
        elif isinstance(item, Scene):
            self.add(name, item.solver.problem)
        elif isinstance(item, Mapping):
            for key, value in item.items():
                self.add(f"{name}[{key!r}]", value)
            self.parts[f"keys of {name}"] = _digest(repr(list(item)))
        elif isinstance(item, (list, tuple)) and not _is_plain(item):
            for index, value in enumerate(item):
                self.add(f"{name}[{index}]", value)
            self.parts[f"length of {name}"] = str(len(item))
        elif dataclasses.is_dataclass(item):
            self._class(f"{type(item).__name__}", type(item))
            for field in dataclasses.fields(item):
                self.add(f"{field.name} of {name}", getattr(item, field.name))
        elif isinstance(item, (set, frozenset)):
            self.parts[name] = _digest(repr(sorted(map(repr, item))))
        elif self._has_code(item):
            self._class(type(item).__name__, type(item))
            self.add(
                f"attributes of {name}", vars(item) if hasattr(item, "__dict__") else repr(item)
            )
        else:
            # Numbers of one value are one object or two: those without a name are not `seen`.
            self._seen.pop(id(item), None)
            self.parts[name] = _digest(item)

    def _has_code(self, item: object) -> bool:
        """Return whether an object is of a class whose code decides results."""
        if isinstance(item, _WITHOUT_CODE):
            return False
        return callable(item) or type(item).__module__ in self._modules

    def _function(self, name: str, function: FunctionType) -> None:
        if _is_ours(function.__module__):
            self.parts[name] = f"{function.__module__}.{function.__qualname__}"
            return
        self._modules.add(function.__module__)
        self.parts[f"the code of {function.__qualname__}"] = _code(function)
        self.add(f"defaults of {function.__qualname__}", function.__defaults__ or ())
        self.add(f"defaults of {function.__qualname__}", function.__kwdefaults__ or {})
        for free, cell in zip(
            function.__code__.co_freevars, function.__closure__ or (), strict=True
        ):
            try:
                self.add(free, cell.cell_contents)
            except ValueError:  # Not assigned yet, such as a function that is still being defined.
                continue
        for used in sorted(_names(function.__code__)):
            if used in function.__globals__ and not hasattr(builtins, used):
                value = function.__globals__[used]
                if isinstance(value, ModuleType):
                    continue
                inner = getattr(value, "__module__", None)
                if isinstance(value, (FunctionType, type)) and inner != function.__module__:
                    self.parts[used] = f"{inner}.{value.__qualname__}"
                else:
                    self.add(used, value)

    def _class(self, name: str, kind: type) -> None:
        if _is_ours(kind.__module__) or kind.__module__ == "builtins":
            self.parts[f"the class of {name}"] = f"{kind.__module__}.{kind.__qualname__}"
            return
        for key, member in vars(kind).items():
            plain = member.__func__ if isinstance(member, (staticmethod, classmethod)) else member
            if isinstance(plain, FunctionType) and plain.__module__ == kind.__module__:
                self.add(f"{kind.__qualname__}.{key}", plain)


def _is_ours(module: str | None) -> bool:
    """Return whether code is this package's, whose version a study records."""
    return (module or "").partition(".")[0] in ("cardan_dyn", "analytic")


def _code(function: FunctionType) -> str:
    """Return the hash of a function's code, without comments, docstrings and line numbers."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return _digest(_plain(function.__code__))
    if function.__name__ == "<lambda>":  # Its source is the whole statement around it.
        return _digest(_plain(function.__code__))
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                node.body = node.body[1:] or [ast.Pass()]
    return _digest(ast.dump(tree))


def _plain(code: CodeType) -> tuple[Any, ...]:
    """Return code as it runs, without where it was written."""
    constants = tuple(
        _plain(item) if isinstance(item, CodeType) else repr(item) for item in code.co_consts
    )
    return code.co_code.hex(), constants, code.co_names, code.co_varnames, code.co_freevars


def _names(code: CodeType) -> Iterator[str]:
    """Iterate over the globals that code looks up, those of inner functions included."""
    for step in dis.get_instructions(code):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
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
