"""Tables: all results of a sweep as an xarray Dataset or as a pandas DataFrame, with units.

Both hold the same variables. The dimensions of a Dataset are

- `sample`, or `sample_0`, `sample_1` … where a response was evaluated on a grid,
- `joint`: the outputs, with wrenches in the joints' own axes,
- `component`: x, y, z, and `wrench_component`: the six flags of `unique`,
- `drive`, where there are several, `held` and `coupling`,
- `moving_joint`: joints with one coordinate, and the coordinates of others that turn or slide
  (`joint.turn_1`),
- `element`: force elements by name, `elements[0]` where one has none; those along coordinates
  (`joint_element`, with `element_effort`), between points (`point_spring`, with `element_tension`,
  `element_length`, `element_force`) and `bushing` (`element_wrench` by `wrench_component`,
  `element_deformation` by `deformation_component`) once more by themselves.

`position`, `speed`, `acceleration`, and times, loads and gravity that vary, are coordinates. What
the outputs of a scene leave out is missing, or NaN for the motion of single joints. Every variable
has the attributes `units` and `long_name`. Where rotations and slides stand side by side, `units`
names both, and the coordinates `drive_unit`, `held_unit`, `coupling_unit` (of the efforts),
`effort_unit` (of joint elements) and `unit` (of the coordinates of moving joints; velocities are
per s, accelerations per s²) tell them apart.

A DataFrame has a row per sample (of a grid: in C order, with an index per dimension), and a flat
column per value. Flat names select by `frame.filter(like=".bending")`, plot by
`frame.plot("position", "bearing_out.bending")`, and go through any file format:

- `position`, `speed`, `acceleration`, `drive_effort`, `condition`; with several drives
  `leg_1.drive_position`, `leg_1.drive_effort` and so on,
- `bearing_out.force_x` … `bearing_out.moment_z`, `.torsion`, `.bending`, `.axial`, `.shear`,
- `joint_angle.holding_effort`, `mesh.coupling_moment`, `load_bearing_out` where a load varies,
- `spring.element_tension`, `motor.element_effort`, `rubber.element_wrench_force_x`,
  `spring.element_energy`, `spring.element_dissipation`, and `elastic_energy` of all,
- `pin_in.position`, `pin_in.velocity`, `pin_in.acceleration`.

Those of a trajectory have its times, and its energies, besides: see `simulation.trajectory_tables`.

Its `attrs` hold `units` (column to unit), `unique` and `coupling_unique`, and the attributes of a
Dataset.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..arrays import Array
from ..errors import MissingExtraError, ModelError, choices
from ..forces.link_loads import WRENCH_COMPONENTS, Wrench
from .sweep_data import SweepData
from .table_variables import labels_of, sample_dims, unit_labels, variables_of
from .variable import Variable
from .wrench import named_components

if TYPE_CHECKING:
    import pandas
    import xarray

_RESIDUALS = ("loop_residual", "balance_residual", "power_residual", "rate_residual")
_FLAG_ATTRIBUTES = {
    "units": "1",
    "long_name": "whether it follows from the laws of motion alone",
}


def dataset(sweep: SweepData, *, motion: bool) -> xarray.Dataset:
    """Return a sweep as a Dataset; see `Sweep.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise _missing("xarray") from error
    listed = list(variables_of(sweep, motion))
    _check_unique([name for name, _ in listed])
    variables = dict(listed)
    arrays = {
        name: (
            variable.dims,
            np.array(variable.values),
            {"units": variable.unit, "long_name": variable.long_name},
        )
        for name, variable in variables.items()
    }
    coordinates = {name for name, variable in variables.items() if variable.is_coordinate}
    labels: dict[str, Any] = {
        name: (name, list(names))
        for name, names in labels_of(sweep).items()
        if any(name in variable.dims for variable in variables.values())
    }
    labels |= {
        name: (dim, list(units), {"long_name": f"unit along {dim}"})
        for name, dim, units in unit_labels(sweep)
        if dim in labels
    }
    unique, coupling_unique = _flags(sweep)
    flags: dict[str, Any] = {}
    if sweep.outputs:
        labels["wrench_component"] = ("wrench_component", list(WRENCH_COMPONENTS))
        flags["unique"] = (("joint", "wrench_component"), unique, _FLAG_ATTRIBUTES)
    if coupling_unique.size:
        flags["coupling_unique"] = (("coupling",), coupling_unique, _FLAG_ATTRIBUTES)
    return xarray.Dataset(
        {name: array for name, array in arrays.items() if name not in coordinates} | flags,
        {name: array for name, array in arrays.items() if name in coordinates} | labels,
        _attributes(sweep),
    )


def _check_unique(names: list[str]) -> None:
    """Refuse names of variables that occur twice, of which one would be lost.

    Raises:
        ModelError: a link `a` and a joint `a_force` both have loads that vary.
    """
    repeated = {name for name in names if names.count(name) > 1}
    if repeated:
        raise ModelError(
            f"a table cannot hold two variables of the name {choices(repeated)}: rename the joint "
            "or the link in the description"
        )


def dataframe(sweep: SweepData, *, motion: bool) -> pandas.DataFrame:
    """Return a sweep as a DataFrame; see `Sweep.to_dataframe`."""
    try:
        import pandas
    except ImportError as error:
        raise _missing("pandas") from error
    dims, labels = sample_dims(sweep), labels_of(sweep)
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, variable in variables_of(sweep, motion):
        values = _over_samples(variable, dims, sweep.shape)
        for suffix, index in _entries(variable, dims, labels):
            column = _column_name(name, *suffix)
            selected: Any = (..., *index)
            columns[column] = values[selected].ravel()
            units[column] = (
                variable.units if isinstance(variable.units, str) else variable.units[index[-1]]
            )
    index = pandas.RangeIndex(len(sweep), name="sample")
    if len(dims) > 1:
        index = pandas.MultiIndex.from_product(map(range, sweep.shape), names=dims)
    frame = pandas.DataFrame(columns, index=index)
    unique, coupling_unique = _flags(sweep)
    frame.attrs = {
        "units": units,
        "unique": dict(zip(sweep.outputs, unique.tolist(), strict=True)),
        "coupling_unique": dict(zip(sweep.coupling_unique, coupling_unique.tolist(), strict=True)),
        **_attributes(sweep),
    }
    return frame


def _not_unique(sweep: SweepData) -> str:
    """Return what statics leaves open and by which rule it was chosen; empty if nothing is."""
    opened = [
        f"{name} ({named_components(~row)})"
        for name, row in zip(sweep.outputs, sweep.unique, strict=True)
        if not np.all(row)
    ]
    opened += [name for name, unique in sweep.coupling_unique.items() if not unique]
    return f"chosen by {sweep.rule}: {', '.join(opened)}" if opened else ""


def _missing(package: str) -> MissingExtraError:
    return MissingExtraError(f'this table needs {package}: pip install "cardan-dyn[study]"')


def _flags(sweep: SweepData) -> tuple[Array, Array]:
    """Return which components `(k, 6)`, and moments of which couplings, are unique."""
    return np.array(sweep.unique), np.array(list(sweep.coupling_unique.values()), dtype=bool)


def _over_samples(variable: Variable, dims: tuple[str, ...], shape: tuple[int, ...]) -> Array:
    """Return values `(*shape, ...)` of a variable that may vary along some samples only."""
    varying = [dim for dim in variable.dims if dim in dims]
    rest = variable.values.shape[len(varying) :]
    sizes = dict(zip(varying, variable.values.shape, strict=False))
    padded = np.reshape(variable.values, (*(sizes.get(dim, 1) for dim in dims), *rest))
    return np.broadcast_to(padded, (*shape, *rest))


def _entries(
    variable: Variable, dims: tuple[str, ...], labels: dict[str, Sequence[str]]
) -> Iterator[tuple[tuple[tuple[str, str], ...], tuple[int, ...]]]:
    """Return names, each with its dimension, and indices of all entries beyond the samples."""
    rest = [dim for dim in variable.dims if dim not in dims]
    for index in np.ndindex(*(len(labels[dim]) for dim in rest)):
        pairs = zip(rest, index, strict=True)
        yield tuple((dim, labels[dim][position]) for dim, position in pairs), index


def _column_name(variable: str, *names: tuple[str, str]) -> str:
    """Return the name of a column, `name.quantity` if it belongs to something with a name."""
    quantity = variable
    owner = ""
    for dim, name in names:
        if dim.endswith("component"):
            quantity = f"{quantity}_{name.replace(' ', '_')}"
        else:
            owner = name
            if dim == "drive" and not quantity.startswith("drive_"):
                quantity = f"drive_{quantity}"
            if dim == "moving_joint":
                quantity = quantity.removeprefix("joint_")
    return f"{owner}.{quantity}" if owner else quantity


def _attributes(sweep: SweepData) -> dict[str, Any]:
    """Return attributes of a whole table: numbers and texts, so that any file format takes them."""
    residuals = {name: float(getattr(sweep, name)) for name in _RESIDUALS}
    gravity = sweep.gravity.tolist() if sweep.gravity.ndim == 1 else "see coordinate gravity"
    return {
        "mechanism": sweep.mechanism.name,
        "drives": ", ".join(sweep.coordinates),
        "held": json.dumps(
            {
                name: f"see coordinate held_{name}" if np.ndim(value) else float(value)
                for name, value in sweep.held.items()
            },
            ensure_ascii=False,
        ),
        "loads": json.dumps(
            {name: _constant(name, load) for name, load in sweep.loads.items()},
            ensure_ascii=False,
        ),
        "gravity": gravity,
        "not_unique": _not_unique(sweep),
        **residuals,
        "unproven": ", ".join(sweep.unproven),
        "cardan_dyn_version": __version__,
    }


def _constant(name: str, load: Array | Wrench) -> Any:
    """Return a load as JSON holds it; the name of its coordinate if it varies."""
    if isinstance(load, Wrench):
        vectors = {"force": np.asarray(load.force), "moment": np.asarray(load.moment)}
        values = {
            quantity: samples.tolist()
            if samples.ndim == 1
            else f"see coordinate load_{name}_{quantity}"
            for quantity, samples in vectors.items()
        }
        return {**values, "frame": load.frame}
    return f"see coordinate load_{name}" if load.ndim else float(load)
