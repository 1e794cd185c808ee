"""TOML writer: a drive line as text that reads back as an equal line."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import ModelError
from .fields import Entry, entries
from .units import DIMENSIONS, written


def write(line: Any, path: str | PathLike[str] | None = None) -> str:
    """Return the line as TOML text, which `from_toml` reads as an equal line.

    Args:
        line: the line.
        path: file to write it to; none unless given.

    Raises:
        ModelError: the file cannot be written.
    """
    import tomlkit

    text = tomlkit.dumps(table_of(line))
    if path is not None:
        try:
            Path(path).write_text(text, encoding="utf-8")
        except OSError as error:
            raise ModelError(f"{path} cannot be written: {error}") from error
    return text


def table_of(instance: Any) -> dict[str, Any]:
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
            nested[name] = table_of(value)
        elif entry.kind == "parts":
            nested[name] = [table_of(part) for part in value]
        else:
            key, shown = _entry(name, value, entry)
            plain[key] = shown
    if "joints" in nested and not any(nested["joints"]):
        del nested["joints"]  # As many plain ones as there are joints.
    return plain | nested


def _entry(name: str, value: Any, entry: Entry) -> tuple[str, Any]:
    """Return the key and the value that a file has for a field."""
    if entry.kind == "quantity":
        return written(name, value, entry.dimension)
    if entry.kind == "point":
        # One unit for all three: the first that gives each of them exactly.
        for unit in DIMENSIONS[entry.dimension]:
            numbers = [unit.from_si(item) for item in value]
            if None not in numbers:
                return f"{name}_{unit.suffix}", numbers
    return name, value
