"""Result: what all results of the vibration have in common."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..checks import described
from ..errors import ArgumentError, CardanError, MissingExtraError
from ..frozen import read_only

if TYPE_CHECKING:
    import pandas


class Result:
    """Base of frozen dataclasses that hold results: arrays are read-only, in copies as well."""

    def __post_init__(self) -> None:
        for value in self.__dict__.values():
            if isinstance(value, np.ndarray):
                read_only(value)

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        Result.__post_init__(self)

    def stored(self) -> dict[str, Any]:
        """Return what `save` writes; of the scene, the names of its drives."""
        stored: dict[str, Any] = {}
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if isinstance(value, (np.ndarray, float, int, str)):
                stored[field.name] = np.asarray(value)
            elif isinstance(value, tuple) and all(
                isinstance(item, (str, int, float)) for item in value
            ):
                stored[field.name] = np.array(value)
            elif field.name == "scene" and value is not None:
                stored["drives"] = np.array(value.drives)
            elif isinstance(value, Mapping):
                stored |= {f"{field.name}.{key}": np.asarray(item) for key, item in value.items()}
        return stored

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all arrays, numbers and names to a file that `numpy.load` reads.

        Args:
            path: of the file, whose name commonly ends with `.npz`.

        Raises:
            ArgumentError: no path.
            CardanError: the file cannot be written.
        """
        if not isinstance(path, (str, os.PathLike)):
            raise ArgumentError(f"path is {described(path)}, expected a path")
        try:
            with Path(path).open("wb") as file:
                np.savez_compressed(file, **self.stored())
        except OSError as error:
            raise CardanError(f"{path}: cannot be written ({error})") from error


def frame_of(rows: list[dict[str, Any]], units: Mapping[str, str]) -> pandas.DataFrame:
    """Return rows as a table, with the units of its columns in `attrs`.

    Raises:
        MissingExtraError: pandas is not installed.
    """
    try:
        import pandas
    except ImportError as error:
        raise MissingExtraError(
            'this table needs pandas: pip install "cardan-dyn[study]"'
        ) from error
    frame = pandas.DataFrame(rows, columns=None if rows else list(units))
    frame.attrs["units"] = dict(units)
    return frame
