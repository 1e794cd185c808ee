"""Tables: all results of a sweep as an xarray Dataset or as a pandas DataFrame, with units.

Both hold the same variables. The dimensions of a Dataset are

- `sample`, or `sample_0`, `sample_1` … where a response was evaluated on a grid,
- `joint`: the outputs, with wrenches in the joints' own axes,
- `component`: x, y, z, and `wrench_component`: the six flags of `unique`,
- `drive`, where there are several, `held` and `coupling`,
- `moving_joint`: joints with one coordinate.

`position`, `speed`, `acceleration`, and loads and gravity that vary, are coordinates. What the
outputs of a scene leave out is missing, or NaN for the motion of single joints. Every variable has
the attributes `units` and `long_name`. Where rotations and slides stand side by side, `units` names
both, and the coordinates `drive_unit`, `held_unit`, `coupling_unit` (of the efforts) and `unit` (of
the coordinates of moving joints; velocities are per s, accelerations per s²) tell them apart.

A DataFrame has a row per sample (of a grid: in C order, with an index per dimension), and a flat
column per value. Flat names select by `frame.filter(like=".bending")`, plot by
`frame.plot("position", "bearing_out.bending")`, and go through any file format:

- `position`, `speed`, `acceleration`, `drive_effort`, `condition`; with several drives
  `leg_1.drive_position`, `leg_1.drive_effort` and so on,
- `bearing_out.force_x` … `bearing_out.moment_z`, `.torsion`, `.bending`, `.axial`, `.shear`,
- `joint_angle.holding_effort`, `mesh.coupling_moment`, `load_bearing_out` where a load varies,
- `pin_in.position`, `pin_in.velocity`, `pin_in.acceleration`.

Its `attrs` hold `units` (column to unit), `unique` and `coupling_unique`, and the attributes of a
Dataset.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._version import __version__
from ..arrays import Array
from ..dynamics.problem_solver import COMPONENTS
from ..errors import MissingExtraError, ModelError
from ..forces.link_loads import Wrench
from .sweep_data import SweepData

if TYPE_CHECKING:
    import pandas
    import xarray


AXES = ("x", "y", "z")
_VECTORS = {"force": ("N", "force"), "moment": ("N·m", "moment")}
_SCALARS = {
    "torsion": ("N·m", "moment along the joint axis"),
    "bending": ("N·m", "size of the moment across the joint axis"),
    "axial": ("N", "force along the joint axis"),
    "shear": ("N", "size of the force across the joint axis"),
}
_RATES = {"position": "", "speed": "/s", "acceleration": "/s²"}
_MOTIONS = {"position": "", "velocity": "/s", "acceleration": "/s²"}
_RESIDUALS = ("loop_residual", "balance_residual", "power_residual", "rate_residual")


class Variable(NamedTuple):
    """Values with names for their dimensions.

    Attributes:
        dims: names of the dimensions.
        values: an array of these.
        units: one for all values, or one per entry of the last dimension.
        long_name: what they are.
        is_coordinate: whether they tell what a sample is, and are no result.
    """

    dims: tuple[str, ...]
    values: Array
    units: str | tuple[str, ...]
    long_name: str
    is_coordinate: bool = False

    @property
    def unit(self) -> str:
        """All units that occur, in one text."""
        units = (self.units,) if isinstance(self.units, str) else self.units
        return " or ".join(dict.fromkeys(units))


def dataset(sweep: SweepData, *, motion: bool) -> xarray.Dataset:
    """Return a sweep as a Dataset; see `Sweep.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise _missing("xarray") from error
    variables = dict(_variables(sweep, motion))
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
        for name, names in _labels(sweep).items()
        if any(name in variable.dims for variable in variables.values())
    }
    labels |= {
        name: (dim, list(units), {"long_name": f"unit along {dim}"})
        for name, dim, units in _unit_labels(sweep)
        if dim in labels
    }
    unique, coupling_unique = _flags(sweep)
    flags: dict[str, Any] = {}
    if sweep.outputs:
        labels["wrench_component"] = ("wrench_component", list(COMPONENTS))
        flags["unique"] = (("joint", "wrench_component"), unique, _FLAG_ATTRIBUTES)
    if coupling_unique.size:
        flags["coupling_unique"] = (("coupling",), coupling_unique, _FLAG_ATTRIBUTES)
    return xarray.Dataset(
        {name: array for name, array in arrays.items() if name not in coordinates} | flags,
        {name: array for name, array in arrays.items() if name in coordinates} | labels,
        _attributes(sweep),
    )


def dataframe(sweep: SweepData, *, motion: bool) -> pandas.DataFrame:
    """Return a sweep as a DataFrame; see `Sweep.to_dataframe`."""
    try:
        import pandas
    except ImportError as error:
        raise _missing("pandas") from error
    dims, labels = _sample_dims(sweep), _labels(sweep)
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name, variable in _variables(sweep, motion):
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


def _missing(package: str) -> MissingExtraError:
    return MissingExtraError(f'this table needs {package}: pip install "cardan-dyn[study]"')


_FLAG_ATTRIBUTES = {
    "units": "1",
    "long_name": "whether it follows from the laws of motion alone",
}


def _flags(sweep: SweepData) -> tuple[Array, Array]:
    """Return which components `(k, 6)`, and moments of which couplings, are unique."""
    return np.array(sweep.unique), np.array(list(sweep.coupling_unique.values()), dtype=bool)


def _variables(sweep: SweepData, motion: bool) -> Iterator[tuple[str, Variable]]:
    """Return all variables of a sweep with their names, coordinates first."""
    yield from _rates(sweep)
    yield from _loads(sweep)
    yield from _wrenches(sweep)
    yield from _efforts(sweep)
    if motion:
        yield from _motion(sweep)
    over_samples = sweep.condition.shape == sweep.shape
    dims = _sample_dims(sweep) if over_samples else ()
    condition = sweep.condition if over_samples else sweep.condition[0]
    yield "condition", Variable(dims, condition, "1", "condition number of the wrenches")


def _rates(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return position, speed and acceleration of the drives."""
    units = [_unit(sweep, name) for name in sweep.drives]
    several = len(units) > 1
    drive = "drive" if several else f"drive {sweep.drives[0]}"
    for name, per_time in _RATES.items():
        values = getattr(sweep, name)
        if several:
            dims: tuple[str, ...] = (*_sample_dims(sweep), "drive")
            unit: str | tuple[str, ...] = tuple(unit + per_time for unit in units)
        else:
            dims, values = _own_dims(values, sweep)
            unit = units[0] + per_time
        yield name, Variable(dims, values, unit, f"{name} of the {drive}", True)


def _loads(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return loads and gravity that vary."""
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            for part, (unit, _) in _VECTORS.items():
                vectors = np.asarray(getattr(load, part))
                if len(vectors) > 1:
                    dims = (*_sample_dims(sweep), "component")
                    label = f"{part} on link {name}, in {load.frame} axes"
                    yield f"load_{name}_{part}", Variable(dims, vectors, unit, label, True)
        elif load.ndim:
            dims, values = _own_dims(load, sweep)
            unit = _effort_unit(sweep, name)
            yield f"load_{name}", Variable(dims, values, unit, f"load on joint {name}", True)
    if sweep.gravity.ndim > 1:
        dims, values = _own_dims(sweep.gravity, sweep, trailing=1)
        label = "acceleration of free fall, in world axes"
        yield "gravity", Variable((*dims, "component"), values, "m/s²", label, True)


def _wrenches(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return the wrenches of the outputs in their joints' axes."""
    if not sweep.outputs:
        return
    dims, wrenches = _sample_dims(sweep), [wrench for _, wrench in sweep.items()]
    for name, (unit, label) in _VECTORS.items():
        vectors = np.stack([getattr(wrench, name) for wrench in wrenches], axis=-2)
        long_name = f"{label} of the parent on the child, in the joint's axes"
        yield name, Variable((*dims, "joint", "component"), vectors, unit, long_name)
    for name, (unit, label) in _SCALARS.items():
        values = np.stack([getattr(wrench, name) for wrench in wrenches], axis=-1)
        yield name, Variable((*dims, "joint"), values, unit, label)


def _efforts(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return what drives, held joints and couplings exert, as far as it was solved."""
    dims = _sample_dims(sweep)
    units = tuple(_effort_unit(sweep, name) for name in sweep.drives)
    try:
        effort = sweep.drive_effort
    except ModelError:  # The outputs leave it out.
        effort = None
    if effort is not None and len(units) > 1:
        yield "drive_effort", Variable((*dims, "drive"), effort, units, "effort of the drives")
    elif effort is not None:
        yield "drive_effort", Variable(dims, effort, units[0], f"effort of {sweep.drives[0]}")
    if sweep.holding_effort:
        values = np.stack(list(sweep.holding_effort.values()), axis=-1)
        units = tuple(_effort_unit(sweep, name) for name in sweep.holding_effort)
        yield "holding_effort", Variable((*dims, "held"), values, units, "effort that holds it")
    if len(sweep.coupling_moment):
        values = np.stack(list(sweep.coupling_moment.values()), axis=-1)
        units = tuple(_coupling_unit(sweep, name) for name in sweep.coupling_moment)
        label = "effort on the joint of the coupling's successor"
        yield "coupling_moment", Variable((*dims, "coupling"), values, units, label)


def _motion(sweep: SweepData) -> Iterator[tuple[str, Variable]]:
    """Return the motion of all joints with one coordinate."""
    joints = _moving_joints(sweep)
    for name, per_time in _MOTIONS.items():
        # A motion is flat where a response was evaluated on a grid.
        values = [getattr(sweep.motion, name)(joint).reshape(sweep.shape) for joint in joints]
        units = tuple(_unit(sweep, joint) + per_time for joint in joints)
        dims = (*_sample_dims(sweep), "moving_joint")
        long_name = f"{name} of the joint's coordinate"
        yield f"joint_{name}", Variable(dims, np.stack(values, axis=-1), units, long_name)


def _sample_dims(sweep: SweepData) -> tuple[str, ...]:
    """Return the names of the dimensions of the operating points."""
    count = len(sweep.shape)
    return ("sample",) if count == 1 else tuple(f"sample_{index}" for index in range(count))


def _own_dims(values: Array, sweep: SweepData, trailing: int = 0) -> tuple[tuple[str, ...], Array]:
    """Return the dimensions along which something was given, and the values along these.

    A sweep over one dimension has all along it; on a grid coordinates would become as large as
    the grid.

    Args:
        values: `(..., trailing)`, to be broadcast with the operating points.
        sweep: of the operating points.
        trailing: number of dimensions that are not those of the operating points.
    """
    names, rest = _sample_dims(sweep), values.shape[values.ndim - trailing :]
    if len(names) == 1:
        return names, np.broadcast_to(values, (*sweep.shape, *rest))
    missing = len(names) + trailing - values.ndim
    padded = values.reshape((1,) * missing + values.shape)
    kept = [axis for axis, size in enumerate(padded.shape[: len(names)]) if size > 1]
    dims = tuple(names[axis] for axis in kept)
    return dims, padded.reshape([*(padded.shape[axis] for axis in kept), *rest])


def _labels(sweep: SweepData) -> dict[str, Sequence[str]]:
    """Return the names along each dimension that is not one of the operating points."""
    return {
        "joint": sweep.outputs,
        "component": AXES,
        "drive": sweep.drives,
        "held": tuple(sweep.holding_effort),
        "coupling": tuple(sweep.coupling_moment),
        "moving_joint": _moving_joints(sweep),
    }


def _unit_labels(sweep: SweepData) -> list[tuple[str, str, list[str]]]:
    """Return coordinates of units: name, dimension and the units along it."""
    return [
        ("drive_unit", "drive", [_effort_unit(sweep, name) for name in sweep.drives]),
        ("held_unit", "held", [_effort_unit(sweep, name) for name in sweep.holding_effort]),
        (
            "coupling_unit",
            "coupling",
            [_coupling_unit(sweep, name) for name in sweep.coupling_moment],
        ),
        ("unit", "moving_joint", [_unit(sweep, name) for name in _moving_joints(sweep)]),
    ]


def _moving_joints(sweep: SweepData) -> tuple[str, ...]:
    """Return the names of the joints with one coordinate."""
    return tuple(joint.name for joint in sweep.mechanism.joints.values() if joint.nv == 1)


def _unit(sweep: SweepData, joint: str) -> str:
    """Return the unit of a joint's only coordinate."""
    return "m" if sweep.mechanism.joints[joint].parts[0].kind == "prismatic" else "rad"


def _effort_unit(sweep: SweepData, joint: str) -> str:
    """Return the unit of an effort along a joint's only coordinate."""
    return "N" if _unit(sweep, joint) == "m" else "N·m"


def _coupling_unit(sweep: SweepData, name: str) -> str:
    """Return the unit of what a coupling exerts on its successor's joint, a slide or a rotation."""
    mechanism = sweep.mechanism
    (coupling,) = (item for item in mechanism.couplings if item.name == name)
    # A successor that no joint moves has no unit of its own: it is that of a ratio without unit.
    column = (coupling.successor_columns or coupling.predecessor_columns)[0]
    columns = mechanism.coordinates.velocity_columns
    (joint,) = (joint for joint, span in columns.items() if span.start == column)
    return _effort_unit(sweep, joint)


def _over_samples(variable: Variable, dims: tuple[str, ...], shape: tuple[int, ...]) -> Array:
    """Return values `(*shape, ...)` of a variable that may vary along some samples only."""
    own = [dim for dim in variable.dims if dim in dims]
    rest = variable.values.shape[len(own) :]
    sizes = dict(zip(own, variable.values.shape, strict=False))
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
        if dim == "component":
            quantity = f"{quantity}_{name}"
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
        "drives": ", ".join(sweep.drives),
        "held": json.dumps(dict(sweep.held), ensure_ascii=False),
        "loads": json.dumps(
            {name: _constant(name, load) for name, load in sweep.loads.items()},
            ensure_ascii=False,
        ),
        "gravity": gravity,
        **residuals,
        "unproven": ", ".join(sweep.unproven),
        "cardan_dyn_version": __version__,
    }


def _constant(name: str, load: Array | Wrench) -> Any:
    """Return a load as JSON holds it; the name of its coordinate if it varies."""
    if isinstance(load, Wrench):
        vectors = {part: np.asarray(getattr(load, part)) for part in _VECTORS}
        values = {
            part: vector[0].tolist() if len(vector) == 1 else f"see coordinate load_{name}_{part}"
            for part, vector in vectors.items()
        }
        return {**values, "frame": load.frame}
    return f"see coordinate load_{name}" if load.ndim else float(load)
