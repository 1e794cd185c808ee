"""Files of drive lines: TOML that is read, written and described by the fields of the data.

A quantity `length` stands as `length_mm = 900` or as `length = "900 mm"`, see `units`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ....kit.checks import described, file_path, writing
from ....kit.errors import ModelError, choices
from ....kit.units import Unit, is_shorter_in_usa, keys, plain, si, spellings, written
from ....kit.units import read as read_unit
from .fields import Entry, entries, items, meanings, number

_EXAMPLES = Path(__file__).parent / "examples"
_NUMBER = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"


def examples() -> tuple[str, ...]:
    """Return the names of the lines that come with the package; `DriveLine.from_toml` reads them.

    Their dimensions are representative, and each file says where its figures are from.
    """
    return tuple(sorted(path.stem for path in _EXAMPLES.glob("*.toml")))


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


def units_of(line: Any) -> str:
    """Return in which units most quantities of a line are round, `si` or `imperial`."""
    return "imperial" if sum(_votes(line)) > 0 else "si"


def _votes(instance: Any) -> Iterator[int]:
    """Yield of all quantities whether units of the USA say them with fewer digits."""
    for name, (item, entry) in entries(type(instance)).items():
        value = getattr(instance, name)
        if value == item.default:
            continue
        if entry.kind in ("part", "parts"):
            for part in value if entry.kind == "parts" else (value,):
                yield from _votes(part)
        elif entry.kind in ("quantity", "point"):
            for number_of in value if entry.kind == "point" else (value,):
                yield is_shorter_in_usa(number_of, entry.dimension)


def _text(source: str | PathLike[str]) -> tuple[str, str]:
    """Return the text of a source, and how messages call it."""
    if isinstance(source, str) and ("\n" in source or "=" in source or not source.strip()):
        return source, "the text"
    if not isinstance(source, (str, PathLike)):
        raise ModelError(f"the source is {described(source)}, expected a path or TOML text")
    path = Path(source)
    is_example = source in examples() and not path.exists()
    try:
        return (_EXAMPLES / f"{source}.toml" if is_example else path).read_text(
            encoding="utf-8-sig"
        ), str(fspath(source))
    except (OSError, UnicodeDecodeError, ValueError) as error:
        bundle = "" if path.suffix else f"; lines of the package: {choices(examples(), str(path))}"
        raise ModelError(f"{path} cannot be read: {error}{bundle}") from error


def _dataclass(table: object, kind: Any, at: str) -> Any:
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
            if meant := _meant(key, fields):
                raise ModelError(f"{prefix}{key} is no field of a {kind.__name__}; write {meant}")
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
            raise ModelError(f"{prefix}{name} is missing: {meanings(kind).get(name, '')}")
    try:
        return kind(**values)
    except ModelError as error:
        raise ModelError(f"{at}: {error}" if at else str(error)) from error


def _meant(key: str, fields: dict[str, tuple[dataclasses.Field[Any], Entry]]) -> str:
    """Return a field with a unit that a key spells otherwise; empty if it spells none."""
    for name, (_, entry) in fields.items():
        spelled = plain(key.removeprefix(f"{name}_").replace("_", ""))
        for valid, unit in keys(name, entry.dimension).items():
            if key.startswith(f"{name}_") and spelled in map(plain, unit.spellings):
                return valid
    return ""


def _value(value: object, entry: Entry, unit: Unit | None, name: str, at: str) -> Any:
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
    expected = {"text": (str, "a text"), "flag": (bool, "true or false")}.get(entry.kind)
    if expected and not isinstance(value, expected[0]):
        raise ModelError(f"{at} is {_shown(value)}, expected {expected[1]}")
    return value  # Days are those of TOML, or texts.


def _quantity(value: object, entry: Entry, unit: Unit | None, name: str, at: str) -> float:
    if unit is None and entry.dimension != "number":
        if isinstance(value, str):
            found = read_unit(value, entry.dimension, at)
            if not entry.holds(found):
                raise ModelError(f"{at} is {value!r}, expected {entry.allowed()}")
            return found
        valid = keys(name, entry.dimension)
        first, example = next(iter(valid.items()))
        raise ModelError(
            f"{at} = {_shown(value)} has no unit; write {first} = …, or a text like "
            f'"1.5 {example.spellings[0]}". Fields: {choices(valid)}'
        )
    try:
        given = number(value, Entry("quantity"), at)
    except ModelError:
        raise ModelError(f"{at} is {_shown(value)}, expected {entry.allowed(unit)}") from None
    result = unit.to_si(given) if unit else given
    if not entry.holds(result):
        raise ModelError(f"{at} is {given:.12g}, expected {entry.allowed(unit)}")
    return result


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return described(value)


def write(line: Any, path: str | PathLike[str] | None = None) -> str:
    """Return the line as TOML text, which `from_toml` reads as an equal line.

    Args:
        line: the line.
        path: file to write it to; none unless given.

    Raises:
        ArgumentError: no path, or the file cannot be written.
    """
    import tomlkit

    text = tomlkit.dumps(_table(line, units_of(line) == "imperial"))
    if path is not None:
        target = file_path("path", path)
        with writing(target) as part:
            part.write_text(text, encoding="utf-8")
    return text


def _table(instance: Any, of_usa: bool) -> dict[str, Any]:
    """Return the fields of a dataclass that are not left at their defaults, as a file has them.

    Numbers and texts come before tables, since TOML would take them for fields of these.
    """
    plain: dict[str, Any] = {}
    nested: dict[str, Any] = {}
    for name, (item, entry) in entries(type(instance)).items():
        value = getattr(instance, name)
        if value == item.default:
            continue
        if entry.kind == "part":
            nested[name] = _table(value, of_usa)
        elif entry.kind == "parts":
            nested[name] = [_table(part, of_usa) for part in value]
        else:
            if entry.kind == "quantity":
                name, (value,) = written(name, [value], entry.dimension, of_usa=of_usa)
            elif entry.kind == "point":
                name, value = written(name, value, entry.dimension, of_usa=of_usa)
            plain[name] = value
    if "joints" in nested and not any(nested["joints"]):
        del nested["joints"]  # As many plain ones as there are joints.
    return plain | nested


def schema(kind: type) -> dict[str, Any]:
    """Return the JSON schema of files that hold a dataclass."""
    definitions: dict[str, Any] = {}
    root = _definition(kind, definitions)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Drive line",
        **root,
        "$defs": definitions,
    }


def _definition(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a dataclass, and add those of its parts to the definitions."""
    properties: dict[str, Any] = {}
    required: list[str] = []
    single: list[dict[str, Any]] = []
    told = meanings(kind)
    for name, (item, entry) in entries(kind).items():
        found = _properties(name, entry, told.get(name, ""), definitions)
        properties |= found
        choice = [{"required": [key]} for key in found]
        if item.default is item.default_factory:  # Both missing: it has to be given.
            if len(choice) == 1:
                required.append(name)
            else:
                single.append({"oneOf": choice})
        elif len(choice) > 1:
            single.append({"oneOf": [*choice, {"not": {"anyOf": choice}}]})
    result: dict[str, Any] = {
        "type": "object",
        "description": (kind.__doc__ or "").split("\n")[0],
        "properties": properties,
        "additionalProperties": False,
    }
    if required:
        result["required"] = required
    if single:
        result["allOf"] = single
    return result


def _properties(
    name: str, entry: Entry, meaning: str, definitions: dict[str, Any]
) -> dict[str, Any]:
    """Return the schema of each key that gives a field."""
    if entry.kind in ("quantity", "point"):
        units = keys(name, entry.dimension)
        if not units:
            return {name: _number(entry, None) | {"description": meaning}}
        found = {
            key: _shaped(_number(entry, unit), entry)
            | {"description": f"{meaning} [{unit.spellings[0]}]"}
            for key, unit in units.items()
        }
        text = _shaped({"type": "string", "pattern": _pattern(entry.dimension)}, entry)
        measure = f"{meaning}, with its unit [{si(entry.dimension)} in Python]"
        return found | {name: text | {"description": measure}}
    if entry.kind in ("part", "parts"):
        title = entry.type.__name__
        if title not in definitions:
            definitions[title] = _definition(entry.type, definitions)
        reference: dict[str, Any] = {"$ref": f"#/$defs/{title}"}
        schema = {"type": "array", "items": reference} if entry.kind == "parts" else reference
        return {name: {**schema, "description": meaning}}
    if entry.kind == "day":
        return {name: {"type": "string", "format": "date", "description": meaning}}
    schema = {"type": "string" if entry.kind == "text" else "boolean"}
    known = {"enum": list(entry.known)} if entry.known else {}
    return {name: {**schema, **known, "description": meaning}}


def _number(entry: Entry, unit: Unit | None) -> dict[str, Any]:
    """Return the schema of a number in a unit, with its limits."""
    return {"type": "number", **{key: limit for _, key, _, limit in entry.limits(unit)}}


def _shaped(schema: dict[str, Any], entry: Entry) -> dict[str, Any]:
    """Return the schema of a quantity, or of three for a point."""
    if entry.kind == "quantity":
        return schema
    return {"type": "array", "items": schema, "minItems": 3, "maxItems": 3}


def _pattern(dimension: str) -> str:
    """Return the pattern of a number with a unit, in which dots and blanks may stand."""
    patterns = [
        r"[ ·*^-]*".join(
            {"2": "[2²]", "3": "[3³]"}.get(letter, letter) for letter in plain(spelling)
        )
        for spelling in spellings(dimension)
    ]
    return f"{_NUMBER}\\s*({'|'.join(patterns)})\\s*$"
