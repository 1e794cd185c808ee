"""Row tables: rows by column as a table, with what each column is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..._version import __version__
from ...core.results.table import Table, Variable

COMPONENTS = {"component": "xyz", "orbit_component": "12"}

_COLUMNS = {
    "position": ("rad", "position of the drive"),
    "speed": ("rad/s", "speed of the drive"),
    "force_slope": ("N/s", "how fast the force grows at its reversal"),
    "reduced_mass": ("kg", "mass that the force moves"),
    "stiffness": ("N/m", "stiffness of the contact"),
    "damping": ("N s/m", "damper of the contact"),
    "contact_time": ("s", "time from the reversal to the impact"),
    "impact_speed": ("m/s", "speed of the impact in the two-mass model"),
    "strike_speed": ("m/s", "speed of the hardest strike, normal to the wall"),
    "tau": ("1", "characteristic number"),
    "peak": ("N", "greatest force of all that is known, with clearance and without"),
    "peak_position": ("rad", "position of the drive at the peak"),
    "two_mass_peak": ("N", "greatest force after the impact in the two-mass model"),
    "rigid": ("N", "force without clearance"),
    "added": ("N", "part of an undamped peak that the clearance adds"),
    "turn_through": ("1", "least force as a fraction of what the ramp gains over the flight"),
    "flown": ("1", "angle of the flight as a fraction of that to the next greatest force"),
    "mass_change": ("1", "change of the reduced mass over the flight"),
    "deviation": ("rad", "angle between the force and the motion that it causes"),
    "slope_growth": ("1", "power of the drive's speed by which the slope grows"),
    "way": ("rad", "that the drive turns until the next reversal"),
    "rigid_ahead": ("N", "greatest force without clearance until the next reversal"),
    "split": ("1", "part of the clearance that cannot close in all bearings at once"),
    "least": ("N", "lower end of the interval of the force until the next reversal"),
    "greatest": ("N", "upper end of the interval of the force until the next reversal"),
    "energy": ("J", "kinetic energy of the impact"),
    "simulated": ("N", "greatest force until the next reversal, simulated"),
    "simulated_least": ("N", "least of these greatest forces of all turns"),
    "simulated_greatest": ("N", "greatest of these greatest forces of all turns"),
    "estimate": ("N", "greatest force until the next reversal as far as a line tells"),
    "error": ("1", "estimate over the mean of the simulated forces, less 1"),
    "rigid_peak": ("N", "greatest force without clearance"),
    "impacts_per_turn": ("1", "impacts in a turn of the drive"),
    "impact_power": ("W", "kinetic energy of all impacts, per time"),
    "start": ("s", "when the pin begins to press the wall"),
    "end": ("s", "when it no longer does"),
    "peak_time": ("s", "when the force is greatest"),
    "direction": ("1", "of the force, in the world"),
    "joint": ("", "name of the joint"),
    "bearing": ("", "name of the joint, or of one of its bearings"),
    "verdict": ("", "whether the theory applies"),
    "doubts": ("", "why the estimate may be wrong"),
}
"""Columns to their units and what they are."""
_GIVEN = ("joint", "bearing", "position", "start", "speed")


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
    variables = []
    for name in rows[0] if rows else ():
        values = np.array([row[name] for row in rows])
        dims = (dim, "component")[: values.ndim]
        own = (told or {}).get(name)
        variables.append(variable(name, values, *dims, told=own, given=name in _GIVEN))
    return Table(
        variables,
        {dim: len(rows)},
        labels=COMPONENTS,
        attributes={**attributes, "cardan_dyn_version": __version__},
    )
