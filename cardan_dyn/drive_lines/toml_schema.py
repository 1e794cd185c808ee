"""TOML schema: what a file of a drive line may hold, as a JSON schema made from the dataclasses."""

from __future__ import annotations

from typing import Any

from .fields import Entry, entries
from .line_data import LineData
from .units import SI, Unit, keys, spellings

_NUMBER = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?"


def toml_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of files that `DriveLine.from_toml` reads.

    Editors complete and check such files by it, once they are told of it.
    """
    definitions: dict[str, Any] = {}
    root = _definition(LineData, definitions)
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
    for name, (item, entry) in entries(kind).items():
        found = _properties(name, entry, definitions)
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


def _properties(name: str, entry: Entry, definitions: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of each key that gives a field."""
    if entry.kind in ("quantity", "point"):
        units = keys(name, entry.dimension)
        if not units:
            return {name: _number(entry, None) | {"description": entry.meaning}}
        found = {
            key: _shaped(_number(entry, unit), entry)
            | {"description": f"{entry.meaning} [{unit.spellings[0]}]"}
            for key, unit in units.items()
        }
        text = _shaped({"type": "string", "pattern": _pattern(entry.dimension)}, entry)
        measure = f"{entry.meaning}, with its unit [{SI[entry.dimension]} in Python]"
        return found | {name: text | {"description": measure}}
    if entry.kind in ("part", "parts"):
        title = entry.type.__name__
        if title not in definitions:
            definitions[title] = _definition(entry.type, definitions)
        reference: dict[str, Any] = {"$ref": f"#/$defs/{title}"}
        schema = {"type": "array", "items": reference} if entry.kind == "parts" else reference
        return {name: {**schema, "description": entry.meaning}}
    kind = "string" if entry.kind == "text" else "boolean"
    return {name: {"type": kind, "description": entry.meaning}}


def _number(entry: Entry, unit: Unit | None) -> dict[str, Any]:
    """Return the schema of a number in a unit, with its limits."""
    factor = unit.divisor / unit.multiplier if unit else 1.0
    limits = {
        "minimum": entry.least,
        "exclusiveMinimum": entry.above,
        "maximum": entry.most,
        "exclusiveMaximum": entry.below,
    }
    stated = {key: limit * factor for key, limit in limits.items() if limit is not None}
    return {"type": "number", **stated}


def _shaped(schema: dict[str, Any], entry: Entry) -> dict[str, Any]:
    """Return the schema of a quantity, or of three for a point."""
    if entry.kind == "quantity":
        return schema
    return {"type": "array", "items": schema, "minItems": 3, "maxItems": 3}


def _pattern(dimension: str) -> str:
    """Return the pattern of a number with a unit, in which dots and blanks may stand."""
    plain = [
        r"[ ·*^]*".join(
            {"2": "[2²]", "3": "[3³]", "/": "/"}.get(letter, letter) for letter in spelling
        )
        for spelling in spellings(dimension)
    ]
    return f"{_NUMBER}\\s*({'|'.join(plain)})\\s*$"
