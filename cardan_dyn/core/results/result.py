"""Result: what every result has in common: its tables and its files."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, Any

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

    @property
    def plot(self) -> Any:
        """Figures: `result.plot()`, or `result.plot("name of a column")`; needs the extra `viz`.

        Without a name it draws what is asked of such a result first; its methods draw the rest. See
        `results.plot`, also for what all of them take.
        """
        from .plot import plot_of  # Imported here: few scripts draw.

        return plot_of(self)

    def to_csv(self, path: str | os.PathLike[str], *, header: bool = True) -> Path:
        """Write all results to a text file for people and spreadsheets, and return its path.

        `pandas.read_csv(path, comment="#", index_col=0)` reads the same numbers back (before
        pandas 3, with `float_precision="round_trip"`).

        Args:
            path: of the file.
            header: whether lines that begin with # stand above the names of the columns, with
                what the result knows of itself: mechanism, drives, loads, residuals, the sign of
                wrenches, and what of them is not unique and by which rule it was chosen. Without
                them it is what `save` writes.

        Raises:
            ArgumentError: no path, or the file cannot be written.
        """
        return self.table().to_csv(path, header=header)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write all results to a file, and return its path.

        Args:
            path: its suffix decides: `.csv` (units in the names of its columns; `to_csv` writes
                more), `.json` (numbers that are missing are null, infinite ones texts that `float`
                reads), `.parquet` (with pyarrow) or `.nc` (NetCDF; what has no entries is left
                out).

        Raises:
            ArgumentError: no path, another suffix, or the file cannot be written.
            MissingExtraError: pandas, xarray or pyarrow is not installed.
        """
        return self.table().save(path)
