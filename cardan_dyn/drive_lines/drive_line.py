"""Drive line: the public face of its data, its description, its scenes and its analysis."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import ModelError, choices
from .line_data import LineData

if TYPE_CHECKING:
    from os import PathLike


@dataclass(frozen=True, kw_only=True)
class DriveLine(LineData):
    """A line of n universal joints between n + 1 shafts.

    It cannot be changed: `replace` makes another one. Lines are equal if their data are.

    Attributes:
        shafts: n + 1 shafts along the power flow, the input shaft first.
        joints: n joints; plain ones unless given.
        name: of the line.
        speed: of the input shaft [rad/s].
        torque: of the input shaft, positive if it drives the line in the sense of rotation [N·m].
        duty_cycle: shares of the time with their speeds and torques.

    Raises:
        ModelError: the field, its value and what is valid: see `Shaft` and the others; shafts that
            cannot be put together.
    """

    @classmethod
    def from_toml(cls, source: str | PathLike[str]) -> DriveLine:
        """Read a line from a TOML file; `toml_schema` lists its fields.

        Args:
            source: path of the file, or the text itself.

        Raises:
            ModelError: the file cannot be read, or which of its fields is wrong, its value and what
                is valid.
        """
        from .toml_reader import read  # Imported here: lines made in Python need no reader.

        line: DriveLine = read(source, cls)
        return line

    def to_toml(self, path: str | PathLike[str] | None = None) -> str:
        """Return the line as TOML text, which `from_toml` reads as an equal line.

        Args:
            path: file to write it to; none unless given.
        """
        from .toml_writer import write  # Imported here: as above.

        return write(self, path)

    def replace(self, **changes: Any) -> DriveLine:
        """Return a line that differs in some fields.

        Raises:
            ModelError: no such field, or what is wrong with a line like that.
        """
        known = {item.name for item in dataclasses.fields(self)}
        for name in changes.keys() - known:
            raise ModelError(
                f"a DriveLine has no field {name!r}; fields: {choices(known, name)}", name=name
            )
        return dataclasses.replace(self, **changes)
