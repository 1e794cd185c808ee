"""Sweeps: what a study wants of a scene, so that a whole chunk of cases is one call of the engine.

What a sweep broadcasts (positions and rates of drives, held joints, loads, gravity, factors on
inertia, time) is varied by the names of parameters: `held.joint_angle`, `loads.bearing_out`,
`inertia.cross`, `gravity.z`, `position`, `speed`. All other parameters are arguments of the
function that makes the scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.results.sweep import Sweep
from ...figures.wrenches import QUANTITIES, determined
from ...kit.arrays import Array
from ...kit.checks import described, flag, numbers, text
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import Frozen, FrozenDict, frozen, read_only
from ...kit.units import plain
from ...scene.scene import Scene
from .outcomes import Outcome, Outcomes, Schema
from .parameters import Parameters

_RATES = ("position", "speed", "acceleration")
_WORDS = (*_RATES, "time")
_GROUPS = ("held", "loads", "inertia", "gravity", *_RATES)
_AXES = ("x", "y", "z")
_TURNS_OR_SLIDES = {
    "position": ("rad", "m"),
    "speed": ("rad/s", "m/s"),
    "acceleration": ("rad/s²", "m/s²"),
    "held": ("rad", "m"),
    "near": ("rad", "m"),
    "loads": ("N·m", "N"),
}
_UNITS = {**_TURNS_OR_SLIDES, "time": ("s",), "inertia": ("1",), "gravity": ("m/s²",)}
"""What each parameter of a sweep is in; nothing is converted."""


_OVER: Mapping[str, Callable[[Array], Array]] = {
    "max": lambda values: np.max(values, axis=-1),
    "min": lambda values: np.min(values, axis=-1),
    "mean": lambda values: np.mean(values, axis=-1),
    "range": lambda values: np.ptp(values, axis=-1),
    "greatest": lambda values: np.max(np.abs(values), axis=-1),
    "rms": lambda values: np.sqrt(np.mean(np.square(values), axis=-1)),
}
"""What can be taken over the positions of a case."""


class Sweeps(Frozen):
    """A function of parameters that sweeps a scene, for `cardan_dyn.study`.

    Parameters called `position`, `speed`, `acceleration` (of one of several drives:
    `position.leg_1`), `time`, `held.JOINT`, `loads.JOINT`, `inertia.LINK` and `gravity.x`, `.y`,
    `.z` go to the sweep, which takes those of all cases of a chunk at once. All others are
    arguments of the function that makes the scene, which is called once for each of their values.
    Those of the sweep are in SI units and radians; a parameter that names another unit is refused.

    Args:
        scene: a scene, or a function of parameters that returns one.
        wanted: names of columns of the sweep's table (`bearing_out.bending`, `drive_effort`,
            `pin_in.position`), and `JOINT.force` or `JOINT.moment` for their sizes; or names of
            results to columns, or to pairs of a column and what is taken of it over the positions
            of a case: `max`, `min`, `mean`, `range`, `greatest` (of the absolute values), `rms`.
        position: drive positions `(P,)` of every case [rad or m], `(P, d)` for d drives; without
            them a case is one position, and `position` is a parameter.
        speed: drive speed of every case [rad/s or m/s].
        acceleration: drive acceleration of every case [rad/s² or m/s²].
        response: evaluate responses (`Scene.responses`) instead: of many positions per case, of
            scenes with one drive and no elements.

    Raises:
        ArgumentError: nothing is wanted, an unknown way to take something over positions, or
            positions that are not `(P,)` or `(P, d)`.
    """

    def __init__(
        self,
        scene: Scene | Callable[..., Scene],
        wanted: str | Sequence[str] | Mapping[str, Any],
        *,
        position: ArrayLike | None = None,
        speed: float = 0.0,
        acceleration: float = 0.0,
        response: bool = False,
    ) -> None:
        if not isinstance(scene, Scene) and not callable(scene):
            raise ArgumentError(
                f"scene is {described(scene)}, expected a Scene or a function that returns one"
            )
        at = None if position is None else read_only(numbers("position", position))
        if at is not None and (at.ndim not in (1, 2) or not at.size):
            raise ArgumentError(f"position has shape {at.shape}, expected (P,) or (P, d)")
        self._freeze(
            scene=scene,
            wanted=frozen(_wanted(wanted, at is not None)),
            position=at,
            speed=float(numbers("speed", speed)),
            acceleration=float(numbers("acceleration", acceleration)),
            response=flag("response", response),
        )

    scene: Scene | Callable[..., Scene]
    wanted: FrozenDict[str, tuple[str, str]]
    position: Array | None
    speed: float
    acceleration: float
    response: bool

    def __repr__(self) -> str:
        return f"<Sweeps: {choices(self.wanted)}>"

    def swept(self, names: Sequence[str]) -> list[str]:
        """Return which parameters go to the sweep."""
        return [name for name in names if _is_swept(name)]

    def refuse_unknown(self, names: Iterable[str]) -> None:
        """Refuse parameters that nothing takes.

        Raises:
            ArgumentError: one is no argument of a sweep, and the scene is made already.
        """
        built = [name for name in names if not _is_swept(name)]
        if built and isinstance(self.scene, Scene):
            raise ArgumentError(
                f"{choices(built)}: no argument of a sweep; those are {', '.join(_WORDS)}, "
                "held.JOINT, loads.JOINT, inertia.LINK, gravity.x. For others, give Sweeps a "
                "function that makes the scene of them"
            )

    def refuse_units(self, units: Mapping[str, str]) -> None:
        """Raise an error for a parameter in another unit than the sweep takes it in.

        Args:
            units: names of parameters to their units, empty where none is said.

        Raises:
            ArgumentError: there is one.
        """
        of_start = [name for name in units if name.startswith("near.")]
        for name in [*self.swept(list(units)), *of_start]:
            taken = self._units_of(name)
            if units[name] and plain(units[name]) not in map(plain, taken):
                raise ArgumentError(
                    f"{name} is in {units[name]}, and a sweep takes it in {' or '.join(taken)}: "
                    "give its values in that unit"
                )

    def _units_of(self, name: str) -> tuple[str, ...]:
        """Return in which unit a parameter of a sweep is, both where the joint is not known."""
        stem, _, rest = name.partition(".")
        if stem in _TURNS_OR_SLIDES and isinstance(self.scene, Scene):
            drives = self.scene.drives
            joint = self.scene.mechanism.drivable.get(rest or drives[0] if drives else rest)
            if joint is not None:
                return (_UNITS[stem][int(joint.slides)],)
        return _UNITS[stem]

    def plan(self, parameters: Parameters, chunk: Sequence[int]) -> str:
        """Return how a chunk is computed, in words."""
        names = [name for block in parameters.blocks for name in block.units]
        built = [name for name in names if not _is_swept(name)]
        sizes = zip(parameters.blocks, chunk, strict=True)
        calls = int(
            np.prod([size for block, size in sizes if set(block.units) & set(built)] or [1])
        )
        kind = "responses" if self.response else "sweep"
        text = "one call" if calls == 1 else f"{calls} calls"
        varied = f", which broadcasts {choices(self.swept(names))}" if self.swept(names) else ""
        made = f"; a scene is made for each {choices(built)}" if built else ""
        return f"{text} of {kind}{varied}{made}"

    def __call__(self, **parameters: Any) -> Outcomes:
        """Return what is wanted, for parameters that broadcast.

        Args:
            parameters: names to numbers, or to arrays that broadcast with each other.

        Raises:
            ArgumentError: there is no such column or parameter.
            CardanError: as the scene, its sweep or its responses do.
        """
        mesh = {name: np.asarray(values) for name, values in parameters.items()}
        shape = np.broadcast_shapes(*(values.shape for values in mesh.values()))
        built = [name for name in mesh if not _is_swept(name)]
        if not built:
            scene = self.scene if isinstance(self.scene, Scene) else self.scene()
            return self._of(scene, mesh, shape)
        self.refuse_unknown(mesh)
        return self._of_several(mesh, built, shape)

    def _of_several(
        self, mesh: Mapping[str, Array], built: list[str], shape: tuple[int, ...]
    ) -> Outcomes:
        """Return results over scenes, each of which is made once."""
        mesh = {
            name: values.reshape((1,) * (len(shape) - values.ndim) + values.shape)
            for name, values in mesh.items()
        }
        made = np.broadcast_shapes(*(mesh[name].shape for name in built))
        collected: dict[str, Array] = {}
        for place in np.ndindex(*made):
            # Along these axes the scenes differ, along the others a sweep goes.
            here = tuple(
                slice(at, at + 1) if size > 1 else slice(None)
                for at, size in zip(place, made, strict=True)
            )
            part = {}
            for name, values in mesh.items():
                sizes = zip(here, values.shape, strict=True)
                part[name] = values[tuple(at if size > 1 else slice(None) for at, size in sizes)]
            scene = self._made_of({name: part.pop(name).item() for name in built})
            swept = tuple(1 if own > 1 else size for own, size in zip(made, shape, strict=True))
            found = self._of(scene, part, swept)
            for name, item in found.variables.items():
                rest = item.values.shape[len(shape) :]
                whole = collected.setdefault(name, np.empty((*shape, *rest), item.values.dtype))
                whole[here] = item.values
        variables = {
            name: item._replace(values=collected[name]) for name, item in found.variables.items()
        }
        return found._replace(variables=variables)

    def _made_of(self, arguments: Mapping[str, Any]) -> Scene:
        scene = self.scene(**arguments)  # type: ignore[operator]
        if not isinstance(scene, Scene):
            raise ArgumentError(
                f"the function that makes the scene returned {described(scene)}, no Scene"
            )
        return scene

    def _of(self, scene: Scene, mesh: Mapping[str, Array], shape: tuple[int, ...]) -> Outcomes:
        """Return what is wanted of one scene."""
        trailing = 0 if self.position is None else 1
        arguments = _arguments(scene, mesh, trailing, len(shape))
        for name in _RATES:
            own = getattr(self, name)
            if name not in arguments and own is not None:
                arguments[name] = own
        if "position" not in arguments:
            raise ArgumentError(
                "no position is given: Sweeps(..., position=…) for all cases, or a parameter "
                "called position"
            )
        if trailing and any(name.partition(".")[0] == "position" for name in mesh):
            raise ArgumentError("position is a parameter and an argument of Sweeps: give one")
        sweep = self._swept(scene, arguments)
        axes = (1,) * (len(shape) + trailing)
        variables = {}
        # What they are is asked of the first case alone.
        is_first = math.prod(shape) == 1
        units = _columns(sweep) if is_first else {}
        for name, (column, way) in self.wanted.items():
            values = np.asarray(_values(sweep, column))
            # Axes along which nothing varies.
            values = np.broadcast_to(values, np.broadcast_shapes(values.shape, axes))
            dims: tuple[str, ...] = ("position",) if trailing else ()
            if way:
                values, dims = _OVER[way](values), ()
            cases = (*shape, *values.shape[len(shape) :])
            label = f"{column}, {way} over positions" if way else column
            attributes = {"units": units.get(column, ""), "long_name": label}
            if is_first and not _is_determined(sweep, column):
                attributes[OPEN] = f"chosen by {sweep.rule}"
            variables[name] = Outcome(dims, np.broadcast_to(values, cases), attributes)
        return Outcomes(variables, self._coordinates(scene))

    def _swept(self, scene: Scene, arguments: dict[str, Any]) -> Sweep:
        """Return the sweep, or the responses' values, of arguments that broadcast."""
        if not self.response:
            return scene.sweep(**arguments)
        held = arguments.pop("held", None)
        if refused := set(arguments) & {"inertia", "time"}:
            raise ArgumentError(f"responses do not vary {choices(refused)}: response=False")
        if held:
            return scene.responses(held).sweep(**arguments)
        return scene.response().sweep(**arguments)

    def _coordinates(self, scene: Scene) -> Schema:
        if self.position is None or self.position.ndim > 1:
            return Schema({}, {}, {})
        unit = scene.mechanism.drivable[scene.drives[0]].unit
        attributes = {"units": unit, "long_name": f"position of the drive {scene.drives[0]}"}
        return Schema({}, {"position": (("position",), self.position.tolist(), attributes)}, {})


def _wanted(given: object, has_positions: bool) -> dict[str, tuple[str, str]]:
    """Return names of results to a column and what is taken of it over positions."""
    if isinstance(given, str):
        given = [given]
    if isinstance(given, Mapping):
        items = list(given.items())
    elif isinstance(given, Sequence):
        items = [(name, name) for name in given]
    else:
        items = []
    found = {}
    for name, what in items:
        label = text("a key of wanted", name)
        column, way = (what, "") if isinstance(what, str) else _pair(label, what)
        if way and way not in _OVER:
            raise ArgumentError(f"wanted[{label!r}]: {way!r} is none of {choices(_OVER, way)}")
        if way and not has_positions:
            raise ArgumentError(
                f"wanted[{label!r}]: nothing to take the {way} over; give Sweeps a position"
            )
        found[label] = (text(f"wanted[{label!r}]", column), way)
    if not found:
        raise ArgumentError("nothing is wanted; name columns such as 'bearing_out.bending'")
    return found


def _pair(label: str, what: object) -> tuple[str, str]:
    if isinstance(what, (tuple, list)) and len(what) == 2 and all(isinstance(w, str) for w in what):
        return what[0], what[1]
    raise ArgumentError(
        f"wanted[{label!r}] is {described(what)}, expected a column or a pair of a column and one "
        f"of {choices(_OVER)}"
    )


def _is_swept(name: str) -> bool:
    stem, dot, rest = name.partition(".")
    return name in _WORDS or bool(dot and rest and stem in _GROUPS)


def _arguments(scene: Scene, mesh: Mapping[str, Array], trailing: int, ndim: int) -> dict[str, Any]:
    """Return the arguments of a sweep for parameters by their names."""
    found: dict[str, Any] = {}
    vectors: dict[str, dict[str, Array]] = {}
    for name, given in mesh.items():
        # Axes for all cases, so that those which nothing varies along stay in the results.
        values = given.reshape((1,) * (ndim - given.ndim) + given.shape + (1,) * trailing)
        stem, dot, rest = name.partition(".")
        if not dot:
            several = name in _RATES and len(scene.drives) > 1
            found[name] = np.stack([values] * len(scene.drives), -1) if several else values
            if name in _RATES and not several and scene.solver.problem.listed:
                found[name] = values[..., None]
        elif stem in ("held", "loads", "inertia"):
            found.setdefault(stem, {})[rest] = values
        else:
            vectors.setdefault(stem, {})[rest] = values
    for stem, parts in vectors.items():
        names = _AXES if stem == "gravity" else scene.drives
        if unknown := set(parts) - set(names):
            raise ArgumentError(f"{stem}.{min(unknown)}: it is one of {choices(names)}")
        if stem != "gravity" and set(parts) != set(names):
            raise ArgumentError(f"{stem}: give it for every drive: {choices(names)}")
        own = dict(zip(_AXES, np.asarray(scene.gravity), strict=True)) if stem == "gravity" else {}
        columns = np.broadcast_arrays(
            *(np.asarray(parts.get(name, own.get(name))) for name in names)
        )
        found[stem] = np.stack(columns, axis=-1)
    return found


def _values(sweep: Sweep, column: str) -> Array:
    """Return the values of a column over the samples of a sweep."""
    if column in ("condition", "elastic_energy") or (
        column == "drive_effort" and len(sweep.coordinates) == 1
    ):
        return np.asarray(getattr(sweep, column))
    owner, _, quantity = column.rpartition(".")
    if quantity in ("position", "velocity", "acceleration") and owner:
        return np.asarray(getattr(sweep.motion, quantity)(owner))
    if quantity == "holding_effort":
        return np.asarray(sweep.holding_effort[owner])
    if quantity == "coupling_moment":
        return np.asarray(sweep.coupling_moment[owner])
    if quantity == "drive_effort" and owner in sweep.coordinates:
        return np.asarray(sweep.drive_effort[..., sweep.coordinates.index(owner)])
    if owner in sweep:
        wrench = sweep[owner]
        if quantity in ("force", "moment"):
            return np.asarray(np.linalg.norm(getattr(wrench, quantity), axis=-1))
        vector, _, axis = quantity.partition("_")
        if vector in ("force", "moment") and axis in _AXES:
            return np.asarray(getattr(wrench, vector)[..., _AXES.index(axis)])
        if quantity in ("torsion", "bending", "axial", "shear"):
            return np.asarray(getattr(wrench, quantity))
    # What takes less than a table of all wrenches was found above.
    columns = sweep.table(motion=False).columns()
    if column in columns:
        return columns[column][0].reshape(sweep.shape)
    raise ArgumentError(f"no column {column!r}; columns: {choices(_columns(sweep), column)}")


OPEN = "not_determined"
"""Attribute of what statics leaves open, which says by what rule its values are chosen."""


def _is_determined(sweep: Sweep, column: str) -> bool:
    """Return whether a column follows from the equations of motion alone."""
    owner, _, quantity = column.rpartition(".")
    vector, _, axis = quantity.partition("_")
    if owner in sweep and vector in QUANTITIES:
        return determined(sweep[owner], vector, [_AXES.index(axis)] if axis in _AXES else (0, 1, 2))
    return quantity != "coupling_moment" or sweep.coupling_unique.get(owner, True)


def _columns(sweep: Sweep) -> dict[str, str]:
    """Return the columns of a sweep's table, and their units."""
    known = {name: unit for name, (_, unit) in sweep.table().columns().items()}
    known |= {f"{name}.{kind}": unit for name in sweep for kind, unit in _SIZES.items()}
    return known


_SIZES = {"force": "N", "moment": "N·m"}
