"""TOML reader: a drive line from a file, field by field."""

from __future__ import annotations

from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ..checks import described
from ..errors import ModelError, choices
from .examples import example_path, examples
from .fields import Entry, entries, items, number
from .units import Unit, keys
from .units import read as read_text


def read(source: str | PathLike[str], kind: Any) -> Any:
    """Return a dataclass made of a file; see `DriveLine.from_toml`."""
    text, where = _text(source)
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        table = tomlkit.parse(text).unwrap()
    except TOMLKitError as error:
        raise ModelError(f"{where} is no TOML: {error}") from error
    if not table:
        raise ModelError(f"{where} is empty; a drive line needs shafts, see the schema")
    try:
        return _dataclass(table, kind, "")
    except ModelError as error:
        raise ModelError(f"{where}: {error}") from error


def _text(source: str | PathLike[str]) -> tuple[str, str]:
    """Return the text of a source, and how messages call it."""
    if isinstance(source, str) and ("\n" in source or "=" in source or not source.strip()):
        return source, "the text"
    if not isinstance(source, (str, PathLike)):
        raise ModelError(f"the source is {described(source)}, expected a path or TOML text")
    path = Path(source)
    bundled = example_path(source) if isinstance(source, str) and not path.exists() else None
    try:
        return (bundled or path).read_text(encoding="utf-8-sig"), str(fspath(source))
    except (OSError, UnicodeDecodeError, ValueError) as error:
        bundle = "" if path.suffix else f"; lines of the package: {choices(examples(), str(path))}"
        raise ModelError(f"{path} cannot be read: {error}{bundle}") from error


def _dataclass(table: object, kind: Any, at: str) -> Any:
    """Return a dataclass made of a table."""
    if not isinstance(table, dict):
        raise ModelError(f"{at} is {_shown(table)}, expected a table of fields")
    prefix = f"{at}." if at else ""
    fields = entries(kind)
    places: dict[str, tuple[str, Unit | None]] = {}
    for name, (_, entry) in fields.items():
        places[name] = name, None
        if entry.kind in ("quantity", "point"):
            places |= {key: (name, unit) for key, unit in keys(name, entry.dimension).items()}
    values: dict[str, Any] = {}
    sources: dict[str, str] = {}
    for key, value in table.items():
        if key not in places:
            known = [
                next(iter(keys(name, item[1].dimension)), name) for name, item in fields.items()
            ]
            raise ModelError(
                f"{prefix}{key} is no field of a {kind.__name__}; fields, also in other units: "
                f"{choices(known, key, most=len(known))}"
            )
        name, unit = places[key]
        if name in values:
            raise ModelError(f"{prefix}{key} says the same as {sources[name]}; keep one")
        values[name] = _value(value, fields[name][1], unit, name, f"{prefix}{key}")
        sources[name] = key
    for name, (item, _) in fields.items():
        if name not in values and item.default is item.default_factory:  # Both missing.
            raise ModelError(f"{prefix}{name} is missing: {fields[name][1].meaning}")
    try:
        return kind(**values)
    except ModelError as error:
        raise ModelError(f"{at}: {error}" if at else str(error)) from error


def _value(value: object, entry: Entry, unit: Unit | None, name: str, at: str) -> Any:
    """Return the value of a field, in SI units."""
    if entry.kind == "quantity":
        return _quantity(value, entry, unit, name, at)
    if entry.kind == "point":
        listed = items(value, at, "three lengths") if not isinstance(value, str) else [value]
        if len(listed) != 3:
            raise ModelError(f"{at} has {len(listed)} entries, expected three lengths")
        return tuple(
            _quantity(item, entry, unit, name, f"{at}[{axis}]") for axis, item in enumerate(listed)
        )
    if entry.kind == "part":
        return _dataclass(value, entry.type, at)
    if entry.kind == "parts":
        if not isinstance(value, list):
            raise ModelError(f"{at} is {_shown(value)}, expected tables [[{at}]]")
        return [_dataclass(item, entry.type, f"{at}[{i}]") for i, item in enumerate(value)]
    expected: tuple[type, str] = (
        (str, "a text") if entry.kind == "text" else (bool, "true or false")
    )
    if not isinstance(value, expected[0]):
        raise ModelError(f"{at} is {_shown(value)}, expected {expected[1]}")
    return value


def _quantity(value: object, entry: Entry, unit: Unit | None, name: str, at: str) -> float:
    """Return a quantity in SI units."""
    if unit is None and entry.dimension != "number":
        if isinstance(value, str):
            found = read_text(value, entry.dimension, at)
            if not entry.holds(found):
                raise ModelError(f"{at} is {value!r}, expected {entry.allowed()}")
            return found
        valid = keys(name, entry.dimension)
        first, example = next(iter(valid.items()))
        raise ModelError(
            f"{at} = {_shown(value)} has no unit; write {first} = …, or a text like "
            f'"1.5 {example.spellings[0]}". Fields: {choices(valid)}'
        )
    bare = Entry("quantity", "")
    try:
        plain = number(value, bare, at)
    except ModelError:
        raise ModelError(f"{at} is {_shown(value)}, expected {entry.allowed(unit)}") from None
    result = unit.to_si(plain) if unit else plain
    if not entry.holds(result):
        raise ModelError(f"{at} is {plain:.12g}, expected {entry.allowed(unit)}")
    return result


def _shown(value: object) -> str:
    """Return a value of a file for a message."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return described(value)
