"""Row tables: rows by column as a table, with what each column is."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.results.table import Table, Variable

COMPONENTS = {"component": "xyz", "orbit_component": "12"}

_COLUMNS = tomllib.loads(Path(__file__).with_name("columns.toml").read_text(encoding="utf-8"))
"""Columns to their units and what they are."""


def variable(
    name: str, values: Any, *dims: str, told: tuple[str, str] | None = None, given: bool = False
) -> tuple[str, Variable]:
    """Return a variable of a table.

    Args:
        name: of the column.
        values: of it.
        dims: along which they vary.
        told: its unit and what it is; by its name if None.
        given: whether it is a coordinate.
    """
    unit, text = told or _COLUMNS.get(name) or ("1", name.replace("_", " "))
    return name, Variable(dims, np.asarray(values), unit, text, is_coordinate=given)


def row_table(
    rows: Sequence[Mapping[str, Any]],
    dim: str,
    told: Mapping[str, tuple[str, str]] | None = None,
    **attributes: Any,
) -> Table:
    """Return rows as a table along one dimension.

    Args:
        rows: values by column: numbers, texts, or vectors `(3,)`.
        dim: name of the dimension.
        told: units and meanings of columns that mean something else here.
        attributes: of the whole table.
    """
    columns = {name: np.array([row[name] for row in rows]) for name in (rows[0] if rows else ())}
    variables = [
        variable(
            name,
            values,
            *(dim, "component")[: values.ndim],
            told=(told or {}).get(name),
            given=name in ("joint", "bearing", "position", "start", "speed"),
        )
        for name, values in columns.items()
    ]
    return Table(
        variables,
        {dim: len(rows)},
        labels=COMPONENTS,
        attributes={**attributes, "cardan_dyn_version": __version__},
    )
