"""Result: what all results of the vibration have in common."""

from __future__ import annotations

import os
from collections.abc import Mapping
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

_NAMES = ("drive", "free")
"""Under which names of coordinates are stored."""


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

    def _stored(self) -> dict[str, Any]:
        """Return what `save` writes, by its name in the file."""
        stored: dict[str, Any] = {}
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, (np.ndarray, float, int, str)):
                stored[field.name] = np.asarray(value)
            elif isinstance(value, tuple) and all(
                isinstance(item, (str, int, float)) for item in value
            ):
                stored[field.name] = np.array(value)
            elif field.name == "missed":
                stored["missed.speed"] = np.array(list(value), dtype=float)
                stored["missed.reason"] = np.array(list(value.values()), dtype=str)
            elif isinstance(value, Mapping):
                stored |= {f"{field.name}.{key}": np.asarray(item) for key, item in value.items()}
            elif isinstance(value, VibrationResult):
                # Its coordinates are those of the whole.
                own = {key: item for key, item in value._stored().items() if key not in _NAMES}
                stored |= {f"{field.name}.{key}": item for key, item in own.items()}
            elif field.name == "scene":
                # Columns of arrays are in the order of the free coordinates.
                names = np.asarray(value.drives[0]), np.array(value.free)
                stored |= dict(zip(_NAMES, names, strict=True))
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
