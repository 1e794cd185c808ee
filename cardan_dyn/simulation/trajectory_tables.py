"""Trajectory tables: all results of a trajectory as a Dataset over time or as a DataFrame.

They hold what tables of sweeps do, see `results.sweep`, at the times of the trajectory, and

- `kinetic_energy` of all bodies [J],
- `potential_energy` of the weight and of springs together [J]; `elastic_energy` is the part of
  springs, where there are elements,
- `work` of loads, actuators and prescribed drives since time 0, less what dampers and friction took
  [J]: it is the change of both energies, but for `energy_residual`.

`time` is the dimension of a Dataset, and the first column of a DataFrame. The attributes tell the
`method`, `effort_residual`, `energy_residual`, the `reason` for which it ended before its time, its
`notes` and `events`, the latter two as JSON.
"""

from __future__ import annotations

import json
from abc import abstractmethod
from typing import TYPE_CHECKING, Any

from ..arrays import Array
from .along_sweep import AlongSweep
from .events import Happened

if TYPE_CHECKING:
    import pandas
    import xarray

_ENERGIES = {
    "kinetic_energy": "kinetic energy of all bodies",
    "potential_energy": "potential energy of the weight and of springs",
    "work": "work of all but weight and springs since time 0",
}
_FIRST = ("time", "position", "speed", "acceleration")
"""Columns that stand before the energies, as far as there are any."""


class Tabled(AlongSweep):
    """A trajectory that can be written as a table; see `Trajectory`."""

    method: str
    reason: str
    events: tuple[Happened, ...]

    @property
    @abstractmethod
    def notes(self) -> tuple[str, ...]:
        """What one should know of it."""

    @property
    @abstractmethod
    def kinetic_energy(self) -> Array:
        """Kinetic energy of all bodies `(N,)` [J]."""

    @property
    @abstractmethod
    def potential_energy(self) -> Array:
        """Potential energy of the weight and of springs `(N,)` [J]."""

    @property
    @abstractmethod
    def work(self) -> Array:
        """Work `(N,)` that all but weight and springs has done since time 0 [J]."""

    @property
    @abstractmethod
    def effort_residual(self) -> float:
        """Greatest effort of a free coordinate, relative to the greatest that anything needs."""

    @property
    @abstractmethod
    def energy_residual(self) -> float:
        """Greatest change of energy less work, relative to the greatest of both."""

    def to_xarray(self, *, motion: bool = True) -> xarray.Dataset:
        """Return all results as a dataset over `time`, energies and work included.

        Args:
            motion: whether to include the motion of the joints.

        Raises:
            MissingExtraError: xarray is not installed.
            CardanError: as `sweep`.
        """
        table = self.sweep.to_xarray(motion=motion).swap_dims(sample="time")
        added = {
            name: ("time", getattr(self, name).copy(), {"units": "J", "long_name": label})
            for name, label in _ENERGIES.items()
        }
        return table.assign(added).assign_attrs(self._told())

    def to_dataframe(self, *, motion: bool = True) -> pandas.DataFrame:
        """Return all results with times in the first column, `time`, energies and work included.

        Args:
            motion: whether to include the motion of the joints.

        Raises:
            MissingExtraError: pandas is not installed.
            CardanError: as `sweep`.
        """
        frame = self.sweep.to_dataframe(motion=motion)
        import pandas

        first = [name for name in _FIRST if name in frame]
        energies = pandas.DataFrame(
            {name: getattr(self, name) for name in _ENERGIES}, index=frame.index
        )
        result = pandas.concat([frame[first], energies, frame.drop(columns=first)], axis=1)
        units = {**frame.attrs["units"], **dict.fromkeys(_ENERGIES, "J")}
        result.attrs = {**frame.attrs, "units": units, **self._told()}
        return result

    def _told(self) -> dict[str, Any]:
        """Return attributes of a whole table: numbers and texts, which any file format takes."""
        return {
            "method": self.method,
            "reason": self.reason,
            "notes": json.dumps(self.notes, ensure_ascii=False),
            "events": json.dumps([[name, float(time)] for name, time in self.events]),
            "effort_residual": self.effort_residual,
            "energy_residual": self.energy_residual,
        }
