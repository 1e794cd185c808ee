"""Result: what all results of the vibration have in common."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.results.result import Result
from ....core.results.table import SUFFIXES, Table, Variable
from ....kit.checks import file_path, writing
from ....kit.frozen import Record

if TYPE_CHECKING:
    from ....scene.scene import Scene


class VibrationResult(Record, Result):
    """Base of frozen dataclasses that hold results of the vibration.

    Attributes:
        scene: whose drive turns at constant speed.
    """

    scene: Scene

    @property
    def drive(self) -> str:
        """Name of the coordinate that turns at constant speed."""
        return self.scene.drives[0]

    def _without(self, count: int) -> str:
        """Return what a headline says of speeds without a motion, of which there may be none."""
        return f", {count} of them without a motion" if count else ""

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free coordinates."""
        return self.scene.free

    def _records(self) -> dict[str, tuple[str, Sequence[str], Sequence[tuple[Any, ...]]]]:
        """Return attributes that hold records: how files call them, their fields, and they."""
        return {}

    def _stored(self) -> dict[str, Any]:
        """Return what `save` writes, by its name in the file."""
        stored: dict[str, Any] = {}
        records = self._records()
        for field in fields(self):  # type: ignore[arg-type]
            name, value = field.name, getattr(self, field.name)
            if name == "scene":
                # Columns of arrays are in the order of the free coordinates.
                stored |= {"drive": np.asarray(self.drive), "free": np.array(self.free)}
                continue
            if name in records:
                name, columns, rows = records[name]
                of = zip(*rows, strict=True) if rows else [()] * len(columns)
                value = dict(zip(columns, of, strict=True))
            elif name == "missed":
                reasons = np.array(list(value.values()), dtype=str)
                value = {"speed": np.array(list(value), dtype=float), "reason": reasons}
            elif isinstance(value, VibrationResult):
                # Its coordinates are those of the whole.
                own = value._stored().items()
                value = {key: item for key, item in own if key not in ("drive", "free")}
            if isinstance(value, Mapping):
                stored |= {f"{name}.{key}": np.asarray(item) for key, item in value.items()}
            elif np.asarray(value).dtype != object:
                stored[name] = np.asarray(value)
        return stored

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the table, or all arrays, numbers and names, to a file, and return its path.

        What ends with `.csv`, `.json` or `.nc` holds the table; any other file all there is, for
        `numpy.load`. Names in it are those of the attributes, with a dot before what belongs to
        one, such as `campbell.frequency`; `drive` and `free` are the names of the coordinates::

            result.save("response.npz")
            with np.load("response.npz") as stored:
                stored.files, stored["free"], stored["amplitude"]

        `pickle` keeps the whole result, the scene included.

        Args:
            path: of the file, as it is; `.npz` for all there is.

        Raises:
            ArgumentError: no path, or the file cannot be written.
        """
        target = file_path("path", path)
        if target.suffix in SUFFIXES:
            return super().save(target)
        with writing(target) as part, part.open("wb") as file:
            np.savez_compressed(file, **self._stored())
        return target


def table_of(columns: Mapping[str, tuple[Any, str]], chosen: Any = ...) -> Table:
    """Return arrays as columns of a table.

    Args:
        columns: name to values, of shapes that go together, and their unit.
        chosen: which of them, in C order; all unless given.
    """
    values = np.broadcast_arrays(*(of for of, _ in columns.values()))
    variables = [
        (name, Variable(("row",), of[chosen].ravel(), unit, name.replace("_", " ")))
        for (name, (_, unit)), of in zip(columns.items(), values, strict=True)
    ]
    return Table(variables, {"row": len(variables[0][1].values)})


def unit_of(scene: Scene, name: str | None = None) -> str:
    """Return the unit of a coordinate, or of all but the first drive of a scene if None."""
    drivable = scene.mechanism.drivable
    units = {drivable[item].unit for item in (scene.free if name is None else [name])}
    return "rad or m" if len(units) > 1 else units.pop()
