"""Result: what every result has in common: its tables and its files."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import os

    import pandas
    import xarray

    from .table import Table


class Result:
    """Something that was computed, and that can be written down as a table.

    A class says what is in its table; everything else is written once, in `results.table`.
    """

    @abstractmethod
    def table(self) -> Table:
        """Return what is known, with names for dimensions, and units."""

    def to_xarray(self) -> xarray.Dataset:
        """Return all results as a dataset; every variable has `units` and a `long_name`.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        return self.table().to_xarray()

    def to_dataframe(self) -> pandas.DataFrame:
        """Return all results, a column per value; `frame.attrs["units"]` maps them to their units.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        return self.table().to_dataframe()

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write all results to a file, and return its path.

        Args:
            path: its suffix decides: `.csv` (units in the names of its columns), `.json`
                or `.nc` (NetCDF).

        Raises:
            ArgumentError: another suffix.
            MissingExtraError: pandas or xarray is not installed.
            OSError: the file cannot be written.
        """
        return self.table().save(path)
