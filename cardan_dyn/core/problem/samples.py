"""Samples: what a sweep prescribes at each of its samples, from arguments that broadcast.

Positions, rates, held positions, loads, gravity and factors on inertia may each have a shape of
their own; together they span the shape of the sweep. Within, samples are counted in C order.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array, flat, part
from ...kit.checks import mapping, numbers, shortened
from ...kit.errors import ArgumentError, choices
from ...kit.frozen import FrozenDict, frozen
from ..mechanism.mechanism import Mechanism
from .acting import AT_ZERO, Acting
from .arguments import by_coordinate, check_distance, of_description, split_loads
from .coordinate_names import check_single
from .problem import Problem

_COARSE = 2.0**46
"""Positions [rad, or lengths of the mechanism] from which on numbers are 1/64 apart: farther than
guesses may be off that are taken to end in the same assembly mode."""


class Targets(NamedTuple):
    """Positions at which the loops are closed, N in all.

    They are kept as they were given: what is spread over all samples is made when it is asked for,
    and for some samples only where these are all that is needed.

    Attributes:
        shape: of the samples.
        given: positions of the drives, `(..., d)` [rad or m], which broadcast with `shape`.
        held: held joints whose positions are not those of the scene, and these [rad or m], which
            broadcast with `shape` unless there are `chosen` designs.
        chosen: `(N,)` the design (index) of each sample; None where `held` says it.
    """

    shape: tuple[int, ...]
    given: Array
    held: FrozenDict[str, Array] = frozen({})
    chosen: Array | None = None

    @staticmethod
    def of_positions(positions: Array, shape: tuple[int, ...] | None = None) -> Targets:
        """Return the targets that are positions `(N, d)` of the drives alone."""
        shape = shape or (len(positions),)
        return Targets(shape, positions.reshape(*shape, -1))

    @property
    def size(self) -> int:
        """Number of samples."""
        return math.prod(self.shape)

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of the held joints whose positions are not those of the scene."""
        return tuple(self.held)

    @property
    def positions(self) -> Array:
        """Positions of the drives `(N, d)` [rad or m]."""
        if self.given.shape[:-1] == self.shape and self.given.ndim == 2:
            return self.given
        return flat(self.given, self.shape, trailing=1)

    @property
    def designs(self) -> Array:
        """Positions of the varied joints as rows `(D, h)` [rad or m]."""
        if not self.held:
            return np.zeros((1, 0))
        rows = np.stack(np.broadcast_arrays(*self.held.values()), axis=-1)
        return rows.reshape(-1, len(self.held))

    @property
    def design_of(self) -> Array:
        """The design (index) of each sample, `(N,)`."""
        if self.chosen is not None:
            return self.chosen
        if not self.held:
            return np.zeros(self.size, dtype=int)
        own = np.broadcast_shapes(*(values.shape for values in self.held.values()))
        return flat(np.arange(math.prod(own)).reshape(own), self.shape)

    @property
    def prescribed(self) -> Array:
        """Positions of the drives, then of the varied joints, `(N, d + h)`."""
        if not self.held:
            return self.positions
        if self.chosen is not None:
            return np.concatenate([self.positions, self.designs[self.chosen]], axis=1)
        held = [flat(values, self.shape)[:, None] for values in self.held.values()]
        return np.concatenate([self.positions, *held], axis=1)

    def at(self, positions: Array) -> Targets:
        """Return the same with other positions `(N, d)` of the drives."""
        return self._replace(given=positions.reshape(*self.shape, -1))

    def held_at(self, positions: Mapping[str, Array]) -> Targets:
        """Return the same with held joints at one position each for all samples."""
        return self._replace(held=frozen(positions), chosen=None)

    def of_samples(self, samples: Array) -> Targets:
        """Return the targets of some samples, by their indices `(K,)`."""
        chosen = self.design_of[samples] if self.held else None
        return Targets(samples.shape, self.positions[samples], self.held, chosen=chosen)

    def block(self, span: slice) -> Targets:
        """Return the targets of samples that follow each other."""
        if self.shape == (span.stop,) and span.start == 0:
            return self
        given, held = part(self.given, self.shape, span, trailing=1), self.held
        if self.chosen is not None:
            return Targets((len(given),), given, held, chosen=self.chosen[span])
        if held:
            held = frozen({name: part(item, self.shape, span) for name, item in held.items()})
        return Targets((len(given),), given, held)

    def expanded(self, shape: tuple[int, ...]) -> Targets:
        """Return the targets of a shape with which theirs broadcasts."""
        if shape == self.shape:
            return self
        chosen = self.chosen
        if chosen is not None:
            chosen = flat(chosen.reshape(self.shape), shape)
        return self._replace(shape=shape, chosen=chosen)


def targets_of(
    problem: Problem,
    position: object,
    held: object = None,
) -> Targets:
    """Return the positions that a sweep asks for.

    Args:
        problem: of the scene.
        position: of its d drives, see `drive_values`.
        held: held joint to positions of any shape, instead of those of the scene.

    Raises:
        ArgumentError: not finite, empty, shapes that do not broadcast, or a joint that is not held.
        ModelError: no such joint.
    """
    driven = drive_values("position", position, problem)
    _check_fine(problem, driven)
    if held is None:
        # A single position as samples have it, so that nobody has to spread it again.
        driven = driven if driven.ndim > 1 else driven[None]
        return Targets(driven.shape[:-1], driven)
    every = _held(problem, held)
    varied = {
        name: values for name, values in every.items() if np.any(values != problem.held[name])
    }
    shapes = {"position": driven.shape[:-1]}
    shapes |= {f"held[{name!r}]": values.shape for name, values in every.items()}
    shape = common_shape(shapes) or (1,)
    return Targets(shape, driven, frozen(varied))


def acting_on(
    problem: Problem,
    speed: object = 0.0,
    acceleration: object = 0.0,
    loads: object = None,
    gravity: object = None,
    inertia: object = None,
    time: object = 0.0,
) -> Acting:
    """Return how fast a sweep moves and what acts in it.

    Args:
        problem: of the scene.
        speed: of its d drives, see `drive_values`.
        acceleration: likewise.
        loads: joints and links to what acts on them; all others keep what the scene has there.
        gravity: `(..., 3)` or `"description"` instead of the scene's.
        inertia: link to the factor on its mass and inertia.
        time: of any shape [s].

    Raises:
        ArgumentError: not finite, empty, of a wrong shape, or a factor below zero.
        ModelError: no such joint or link.
    """
    # Sweeps of one position take as long as the calls that they make: what most arguments are left
    # at is seen without any.
    is_left = loads is None and gravity is None and inertia is None
    is_left = is_left and type(speed) is type(acceleration) is type(time) is float
    if is_left and speed == acceleration == time == 0.0:
        return problem.acting
    efforts, wrenches = split_loads(problem.mechanism, loads)
    for name in efforts:
        if name not in problem.mechanism.coordinates.named:
            raise ArgumentError(
                f"loads[{name!r}]: the scene solves this joint as a ball; give the scene itself a "
                "load on one of its coordinates"
            )
    gravities = problem.gravity
    if gravity is not None:
        gravities = numbers("gravity", of_description(problem.mechanism, gravity))
    if gravities.shape[-1:] != (3,) or not gravities.size:
        raise ArgumentError(f"gravity has shape {gravities.shape}, expected (..., 3)")
    # Few sweeps give times, and all of them would pay for reading them.
    times = AT_ZERO if isinstance(time, float) and time == 0.0 else numbers("time", time)
    if not times.size:
        raise ArgumentError("time is empty")
    return Acting(
        drive_values("speed", speed, problem),
        drive_values("acceleration", acceleration, problem),
        frozen({**problem.joint_loads, **efforts}) if efforts else problem.joint_loads,
        frozen({**problem.link_loads, **wrenches}) if wrenches else problem.link_loads,
        gravities,
        frozen(_factors(problem.mechanism, inertia)),
        times,
    )


def spanned(targets: Targets, acting: Acting, problem: Problem) -> Targets:
    """Return targets in the shape that they span together with what acts.

    Raises:
        ArgumentError: they do not broadcast.
    """
    if acting is problem.acting and problem.acting_everywhere is not None:
        return targets
    return targets.expanded(common_shape({"position": targets.shape, **acting.shapes}))


def common_shape(shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Return the shape that arguments span together.

    Args:
        shapes: of the arguments, by the names that messages use.

    Raises:
        ArgumentError: they do not broadcast.
    """
    different = {shape for shape in shapes.values() if shape}
    if len(different) <= 1:  # Most sweeps have one argument that varies.
        return different.pop() if different else ()
    try:
        return np.broadcast_shapes(*different)
    except ValueError as error:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise ArgumentError(
            f"shapes do not broadcast: {listed}; for a grid, give each argument an axis of its "
            "own, as values[:, None] does, or values[:, None, :] where the last axis is that of "
            "several drives or rows of a task"
        ) from error


def drive_values(name: str, value: object, problem: Problem) -> Array:
    """Return positions, speeds or accelerations of the drives as `(..., d)`.

    Args:
        name: how messages call the argument.
        value: of any shape for one drive, `(..., 1)` if it was named in a list; a number for all
            of d drives, or `(..., d)`.
        problem: of the scene.
    """
    array = numbers(name, value)
    if not array.size:
        raise ArgumentError(f"{name} is empty")
    drives = len(problem.independent)
    if drives == 1:
        has_axis = problem.listed and array.ndim > 1 and array.shape[-1] == 1
        return array if has_axis else array[..., None]
    if not array.ndim:
        return array.repeat(drives)
    if array.shape[-1] != drives:
        raise ArgumentError(
            f"{name} has shape {array.shape}, expected a number or (..., {drives}), a column for "
            "each drive"
        )
    return array


def _check_fine(problem: Problem, positions: Array) -> None:
    """Refuse positions `(..., d)` so great that they do not say where a drive is."""
    mechanism = problem.mechanism
    # In one call: every sweep asks, and hardly any is refused.
    most = np.maximum.reduce(np.abs(positions), axis=None)
    if most < _COARSE and most < _COARSE * mechanism.characteristic_length:
        return
    for name, values in zip(problem.independent, np.moveaxis(positions, -1, 0), strict=True):
        greatest, slides = (
            float(values.flat[np.abs(values).argmax()]),
            mechanism.drivable[name].slides,
        )
        if abs(greatest) >= _COARSE * (mechanism.characteristic_length if slides else 1.0):
            unit, advice = ("m", "") if slides else ("rad", "; take whole turns off")
            raise ArgumentError(
                f"position: {greatest:g} {unit} of {name!r} does not say where it is, since "
                f"numbers of that size are {np.spacing(abs(greatest)):.2g} apart{advice}"
            )


def _held(problem: Problem, held: object) -> dict[str, Array]:
    """Return the positions of held joints, in the order of the scene."""
    varied = {}
    given = by_coordinate(problem.mechanism, "held", held)
    # In the order of the scene, so that one set of joints is one family of designs.
    order = {name: index for index, name in enumerate(problem.held)}
    for name in sorted(given, key=lambda name: order.get(name, len(order))):
        value = given[name]
        check_single(problem.mechanism, name, "held joint")
        label = f"held[{shortened(repr(name))}]"
        if name not in problem.held:
            raise ArgumentError(
                f"{label}: the scene does not hold this joint; held: "
                f"{choices(problem.held, name)}. Hold it in the scene, at any position near these"
            )
        values = numbers(label, value)
        if not values.size:
            raise ArgumentError(f"{label} is empty")
        farthest = values.flat[np.argmax(np.abs(values))]
        check_distance(problem.mechanism, name, label, float(farthest))
        varied[name] = values
    return varied


def _factors(mechanism: Mechanism, inertia: object) -> dict[str, Array]:
    """Return the factors on mass and inertia of links."""
    factors = {}
    for name, value in mapping("inertia", inertia).items():
        body, _ = mechanism.link(name)
        label = f"inertia[{shortened(repr(name))}]"
        if body == 0:
            raise ArgumentError(f"{label}: the link is fixed to the world; its mass does not count")
        factor = numbers(label, value)
        if not factor.size:
            raise ArgumentError(f"{label} is empty")
        if np.any(factor < 0.0):
            raise ArgumentError(f"{label} is {float(np.min(factor)):g}; factors are not negative")
        factors[name] = factor
    return factors
