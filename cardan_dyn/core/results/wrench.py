"""Wrench: force and moment in a joint, split along and across its axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import numbers, vector
from ...kit.errors import ArgumentError, ModelError
from ...kit.frozen import Hinting, Record, read_only
from ...kit.quantities import amount

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

WITHOUT_AXIS = frozenset({"spherical", "floating", "fixed"})
"""Types of joints that have no axis: what a description says of one means nothing."""
_Direction = tuple[tuple[int, float], ...]
"""A constant vector: the axes along which it has a component, with the components."""


class Components(Protocol):
    """Where a wrench takes its components from: 0 … 2 of the force, 3 … 5 of the moment."""

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        ...

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        ...

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        ...


class StoredComponents(NamedTuple):
    """Components that were computed before.

    Attributes:
        values: `(N, 6)`.
    """

    values: Array

    def component(self, index: int) -> Array:
        """Return a component `(N,)`."""
        return self.values[..., index]

    def vector(self, first: int) -> Array:
        """Return three components, from the `first` on, `(N, 3)`."""
        return self.values[..., first : first + 3]

    def vanishes(self, index: int) -> bool:
        """Return whether a component is zero throughout."""
        return not np.count_nonzero(self.values[..., index])


class Magnitude(NamedTuple):
    """Sizes of a force and a moment, in any axes.

    Attributes:
        force: `(N,)` [N].
        moment: `(N,)` [N·m].
    """

    force: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class BearingForces(Record):
    """Forces of two bearings along a joint's axis **on the child**, that make up its wrench.

    Bearings carry force across the axis and no moment; what acts along the axis is carried by
    either of them. `sweep.wrench("bearing_out", "parent").bearing_forces((0.05, 0.25))`.

    Attributes:
        positions: of bearings a and b, along the axis from the joint's origin [m].
        frame: axes of the vectors, those of the wrench.
        force_a, force_b: `(N, 3)` across the axis [N].
        axial: `(N,)` force along the axis, that a and b carry together [N].
        torsion: `(N,)` moment about the axis, which no bearing carries: drive, load or friction
            [N·m].
        unique_a, unique_b: `(3,)` whether each component follows from the laws of motion alone.
        unique_axial: whether the axial force does.
    """

    positions: tuple[float, float]
    frame: str
    force_a: Array
    force_b: Array
    axial: Array
    torsion: Array
    unique_a: Array
    unique_b: Array
    unique_axial: bool

    @property
    def radial_a(self) -> Array:
        """Radial load of bearing a `(N,)` [N]."""
        return lengths(self.force_a)

    @property
    def radial_b(self) -> Array:
        """Radial load of bearing b `(N,)` [N]."""
        return lengths(self.force_b)

    def __repr__(self) -> str:
        loads = (
            f"at {place:g} m {_up_to(size, 'N')}{_not(unique)}"
            for place, size, unique in zip(
                self.positions,
                (self.radial_a, self.radial_b),
                (np.all(self.unique_a), np.all(self.unique_b)),
                strict=True,
            )
        )
        axial = f"axial {_up_to(np.abs(self.axial), 'N')}"
        return (
            f"<BearingForces on the child, {self.frame} axes: {', '.join(loads)}, "
            f"{axial}{_not(self.unique_axial)}{lost(self.axial)}>"
        )


def _not(unique: object) -> str:
    return "" if unique else " (not unique)"


def _up_to(sizes: Array, unit: str) -> str:
    known = sizes[~np.isnan(sizes)]
    if sizes.size > known.size == 0:
        return "not known"
    return f"up to {amount(float(np.max(known, initial=0.0)), unit)}"


def lost(values: Array) -> str:
    """Return at how many samples `(N,)` nothing is known, as near singular configurations."""
    count = int(np.isnan(values).sum())
    return f", not known at {count} of {values.size}" if count else ""


@dataclass(frozen=True, eq=False, repr=False)
class JointWrench(Hinting):
    """The wrench **exerted by the parent link on the child link**, at the joint origin.

    The parent of a loop's joint is its predecessor, the child its successor. Loads and drive
    efforts at the joint are part of it, but for what accelerates its rotors (`armature`).

    Attributes:
        joint: name of the joint.
        frame: axes of all components: `joint` (fixed in the child), `parent` (fixed in the parent
            and equal to `joint` at coordinate zero), `world`, or those of the link of that name.
        point: the point about which the moment is taken, from the joint's origin in these axes,
            `(3,)` or `(N, 3)` [m]; None where it is that origin. See `at`.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "torque torques tau moments m": ".moment `(N, 3)`, .torsion along the axis, .bending "
        "across",
        "forces f": ".force `(N, 3)`",
        "fx fy fz x y z": ".force[..., 0] and so on, in the axes of .frame",
        "mx my mz": ".moment[..., 0] and so on, in the axes of .frame",
        "norm size resultant abs total": ".magnitude.force and .magnitude.moment",
        "radial transverse lateral": ".shear is the size of the force across the axis",
        "thrust tension normal": ".axial is the force along the axis",
        "bend bending_moment": ".bending",
        "twist torsional": ".torsion",
        "bearings supports": ".bearing_forces((a, b))",
        "translate shift move about": ".at(point) is the same wrench about another point",
        "rotate in_frame to_frame world in_world to_world parent": "sweep.wrench(joint, 'world') "
        "has other axes: parent, world or those of a link",
        "plot": "sweep.plot('joint')",
        "values data array to_numpy to_array": ".force and .moment are arrays",
        "to_dataframe to_xarray to_csv save": "sweep.to_dataframe() and the like hold all joints",
        "max maximum peak": "np.max(wrench.magnitude.moment), and the like",
    }

    joint: str
    frame: str
    _components: Components
    _axis: Array | None
    _flags: Callable[[], Array]
    _sweep: Any
    point: Array | None = None

    @property
    def has_axis(self) -> bool:
        """Whether the joint has an axis: balls, floating and fixed joints have none."""
        return self._axis is not None

    @property
    def axis(self) -> Array:
        """Unit axis of the joint in these axes, `(3,)`.

        It is `(N, 3)` where it turns: in `world`, and in `parent` for `universal` joints.

        Raises:
            ModelError: the joint has no axis: it is a ball, floats or is fixed.
        """
        if self._axis is None:
            raise ModelError(
                f"joint {self.joint!r} has no axis, so that nothing is along or across it; use "
                ".force and .moment, or name the axes that are meant: "
                f"sweep.wrench({self.joint!r}, 'parent')",
                name=self.joint,
            )
        return self._axis

    @cached_property
    def unique(self) -> Array:
        """Whether each component follows from the equations of motion alone, `(6,)`.

        Force, then moment, in the axes of `frame`, at every position. Where it is False, the value
        is the one of least norm, or least elastic energy, among those that satisfy them; or a
        coupling does not say which forces it exerts (`Sweep.left_open`), and the value is what
        moments about the axes of its joints cause.
        """
        return self._flags()

    def __repr__(self) -> str:
        shape = " × ".join(str(size) for size in self.moment.shape[:-1])
        from .left_open import named_components  # Imported here: few are shown.

        force, moment = self.magnitude
        acts = f"force {_up_to(force, 'N')}{self._unique_parts('force')}"
        acts += f", moment {_up_to(moment, 'N·m')}{self._unique_parts('moment')}{lost(force)}"
        is_unique = bool(np.all(self.unique))
        if self.moment.size and is_unique and not (np.any(force) or np.any(moment)):
            acts = "nothing acts"
        about = "" if self.point is None else " about another point"
        chosen = ""
        if not is_unique:
            why = self._sweep.left_open.why(self.joint)
            chosen = f", not unique: {named_components(~self.unique)}, {why}"
        if told := self._sweep.near_singular(self):
            chosen += f", {told}"
        return (
            f"<JointWrench of {self.joint!r} in {self.frame} axes{about}, of the parent on the "
            f"child: {shape} samples, {acts}{chosen}>"
        )

    def _unique_parts(self, what: str) -> str:
        """Return in brackets which part of a `force` or `moment` is unique though it is not."""
        from ...figures.wrenches import known_part, together  # Imported here: few are shown.

        part = known_part(self, what)
        if part == what:
            return ""
        force, moment = (float(np.nanmax(size, initial=0.0)) for size in self.magnitude)
        whole = together(force, moment, self._sweep.mechanism.characteristic_length)
        greatest = float(np.nanmax(np.abs(getattr(self, part)), initial=0.0))
        acts = greatest > 1e-9 * whole["N" if what == "force" else "N·m"]
        unit = "N" if what == "force" else "N·m"
        return f" ({part} up to {amount(greatest, unit)} unique)" if acts else ""

    @property
    def magnitude(self) -> Magnitude:
        """Sizes of force and moment: `wrench.magnitude.force` [N], `.moment` [N·m], `(N,)` each."""
        return Magnitude(lengths(self.force), lengths(self.moment))

    def at(self, point: ArrayLike | Any) -> JointWrench:
        """Return the same wrench about another point: its moment is taken about that.

        Args:
            point: `(3,)` or `(N, 3)` from the joint's origin in the axes of `frame` [m]; or what
                `Sweep.point` returned, wherever that is.

        Raises:
            ArgumentError: no such vectors, or a point of another number of samples.
        """
        samples, sweep = self.force.shape, self._sweep
        position = getattr(point, "position", None)
        if position is None:
            place = numbers("point", point)
            if place.shape not in ((3,), samples):
                raise ArgumentError(
                    f"point has shape {place.shape}, expected (3,) or {samples}, from the origin "
                    f"of joint {self.joint!r} in {self.frame} axes"
                )
        elif np.shape(position) != samples:
            raise ArgumentError(
                f"point has the samples {np.shape(position)[:-1]}, expected {samples[:-1]}: take "
                "it of the same sweep"
            )
        else:
            place = position - sweep.origin(self.joint)
            if self.frame != "world":
                own = np.swapaxes(sweep.rotation(self.joint), -1, -2) @ place[..., None]
                place = (sweep._rotation_from_joint(self.joint, self.frame) @ own)[..., 0]
        before = np.zeros(3) if self.point is None else self.point
        moment = self.moment - np.cross(place - before, self.force)
        values = StoredComponents(np.concatenate([self.force, moment], axis=-1))
        about = replace(self, _components=values, point=read_only(place))
        return replace(about, _flags=partial(about._flags_about, self._flags))

    def _flags_about(self, flags: Callable[[], Array]) -> Array:
        """Return which components are unique about `point`, from those about the origin."""
        if np.all(flags()):
            return flags()
        return read_only(self._unique_sums(np.eye(6), np.repeat([True, False], 3)))

    def _unique_sums(self, factors: Array, are_forces: Array) -> Array:
        """Return which sums are unique, see `Sweep._unique_sums`.

        Args:
            factors: `(..., k, 6)` on force and moment about `point`, in the axes of `frame`.
            are_forces: `(k,)` which of them are forces.
        """
        turn = self._sweep._rotation_from_joint(self.joint, self.frame)
        arm = np.zeros(3) if self.point is None else self.point
        maps = np.zeros((*np.broadcast_shapes(turn.shape[:-2], arm.shape[:-1]), 6, 6))
        maps[..., :3, :3] = maps[..., 3:, 3:] = turn
        maps[..., 3:, :3] = -_cross_matrix(arm) @ turn
        found: Array = self._sweep._unique_sums(self.joint, factors @ maps, are_forces)
        return found

    def bearing_forces(self, bearings: tuple[float, float]) -> BearingForces:
        """Return the forces of two bearings behind the joint, that together are its wrench.

        Both stand on the joint's axis and carry no moment. They are those of the parent on the
        child, as the wrench is; in `parent` axes they stand still with a bearing's housing.

        Args:
            bearings: positions a and b along the axis, from the joint's origin, or from `point`
                [m]; negative ones against the axis.

        Raises:
            ArgumentError: no two numbers, or both bearings are at one place.
            ModelError: the joint has no axis.

        Source: statics of a beam on two supports; catalogues of cardan shafts print the same for
            their shafts, see `analytic.support_forces`.
        """
        a, b = vector("bearings", bearings, 2).tolist()
        if a == b:
            raise ArgumentError(
                f"bearings are both at {a:g} m: two bearings carry a moment only if they stand at "
                "different places along the axis"
            )
        axis, span = self.axis, b - a
        # e × M, which turns the moment across the axis by a right angle.
        turned = np.cross(axis, self.moment)
        shear = self.shear_vector
        force_a, force_b = (b * shear + turned) / span, -(a * shear + turned) / span
        flags = np.ones(7, dtype=bool)
        if not np.all(self.unique):
            across = np.eye(3) - axis[..., :, None] * axis[..., None, :]
            turning, along = _cross_matrix(axis), axis[..., None, :]
            both = [np.concatenate([place * across, turning], axis=-1) for place in (b, a)]
            alone = np.concatenate([along, np.zeros_like(along)], axis=-1)
            are_forces = np.repeat([False, True], [6, 1])
            flags = self._unique_sums(np.concatenate([*both, alone], axis=-2), are_forces)
        return BearingForces(
            (a, b),
            self.frame,
            np.asarray(force_a),
            np.asarray(force_b),
            np.asarray(self.axial),
            np.asarray(self.torsion),
            flags[:3],
            flags[3:6],
            bool(flags[6]),
        )

    @cached_property
    def force(self) -> Array:
        """Force `(N, 3)` [N]."""
        return read_only(self._components.vector(0))

    @cached_property
    def moment(self) -> Array:
        """Moment `(N, 3)` [N·m]."""
        return read_only(self._components.vector(3))

    @property
    def torsion(self) -> Array:
        """Moment along the joint axis `(N,)` [N·m], positive in the coordinate's sense."""
        return self._along(3)

    @property
    def axial(self) -> Array:
        """Force along the joint axis `(N,)` [N], positive in the sense of the axis.

        It is the axial load of a bearing.
        """
        return self._along(0)

    @property
    def bending(self) -> Array:
        """Size of the moment across the joint axis `(N,)` [N·m]."""
        return self._size_across(3)

    @property
    def shear(self) -> Array:
        """Size of the force across the joint axis `(N,)` [N]: the radial load of a bearing."""
        return self._size_across(0)

    @property
    def bending_vector(self) -> Array:
        """Moment across the joint axis `(N, 3)` [N·m], in the axes of `frame`."""
        return self._across(self.moment)

    @property
    def shear_vector(self) -> Array:
        """Force across the joint axis `(N, 3)` [N], in the axes of `frame`."""
        return self._across(self.force)

    def _along(self, first: int) -> Array:
        """Return the component along the axis, of the force (`first` 0) or the moment (3)."""
        if self.axis.ndim == 1:
            return np.asarray(self._sum(first, _components_of(self.axis)))
        vectors = self.moment if first else self.force
        return np.asarray(np.einsum("...i,...i->...", vectors, self.axis))

    def _across(self, vectors: Array) -> Array:
        """Return the part of vectors across the axis."""
        # a × (v × a) loses no digits where v is almost parallel to the axis a.
        return np.asarray(np.cross(self.axis, np.cross(vectors, self.axis)))

    def _size_across(self, first: int) -> Array:
        """Return the size across the axis, of the force (`first` 0) or the moment (3)."""
        axis = self.axis
        if axis.ndim > 1:
            return lengths(self._across(self.moment if first else self.force))
        directions, acting = _directions_across(*axis.tolist()), tuple[Array, ...]()
        for direction in directions:
            for index, _ in direction:
                # In a Cardan joint one of the two components is zero throughout, which spares its
                # evaluation and the square root.
                if not self._components.vanishes(first + index):
                    acting = (*acting, self._sum(first, direction))
                    break
        if len(acting) == 2:
            return np.asarray(np.hypot(*acting))
        return np.asarray(np.abs(acting[0] if acting else self._sum(first, directions[0])))

    def _sum(self, first: int, direction: _Direction) -> Array:
        """Return the component along a constant direction; most directions are frame axes."""
        total: Array | None = None
        for axis, factor in direction:
            values = self._components.component(first + axis)
            term = values if factor == 1.0 else values * factor  # Frame axes need no product.
            total = term if total is None else total + term
        return total  # type: ignore[return-value]


def _components_of(vector: Array) -> _Direction:
    """Return the axes along which a vector `(3,)` has a component, with the components."""
    return tuple((axis, value) for axis, value in enumerate(vector.tolist()) if value)


@lru_cache(maxsize=1024)
def _directions_across(x: float, y: float, z: float) -> tuple[_Direction, _Direction]:
    """Return two unit vectors across an axis and each other."""
    axis = np.array([x, y, z])
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    return _components_of(across), _components_of(np.cross(axis, across))


def _cross_matrix(vectors: Array) -> Array:
    """Return `(..., 3, 3)` matrices that take the cross product with vectors `(..., 3)`."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    none = np.zeros_like(x)
    rows = [[none, -z, y], [z, none, -x], [-y, x, none]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def lengths(vectors: Array) -> Array:
    """Return lengths `(...)` of vectors `(..., 3)`, whose squares may overflow or vanish."""
    scale = np.abs(vectors).max(axis=-1, initial=0.0)
    safe = np.where(scale > 0.0, scale, 1.0)
    squares = (vectors / safe[..., None]) ** 2
    return np.asarray(safe * np.sqrt(squares.sum(axis=-1)) * (scale > 0.0))
