"""Opened joint: a joint whose bearings have clearance, what they carry, and how they give way.

A joint that turns about one axis has one bearing: a bush in which its pin stays parallel. A
universal joint has two on each pin of its cross, at ± a radius from its centre: it passes a moment
on, and hardly a force, so that not its centre is loaded, but they are, in pairs.

W = J [M⁻¹ − M⁻¹Aᵀ(A M⁻¹ Aᵀ)⁻¹A M⁻¹] Jᵀ, with the rows J of the open bearings and A of all that
stays closed, is computed by the directions that A leaves, so that redundant equations do no harm.
All bearings stand below each other, along axes in which their motion is known: those of the world,
or of a cross two that are fixed in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.mechanism.joints import Part
from ...core.mechanism.undescribed import REMEDY
from ...core.problem.samples import Targets
from ...core.results.collect import motion_at
from ...kit.arrays import NOTHING, ROUNDED, Array, cross
from ...kit.checks import number
from ...kit.errors import ModelError
from ...kit.periodic import Fourier
from .opened_mechanism import OpenedMechanism, across
from .pin_geometry import PinGeometry, StiffnessLaw, in_series

if TYPE_CHECKING:
    from ...core.results.motion import Motion
    from ...core.results.sweep import Sweep

_PUSHED = float(np.sqrt(ROUNDED))
"""Part of a force that motion does not decide, or that pushes what has no mass, as a fraction, that
counts as none."""
_PARALLEL = 0.1
"""Sine of the angle between two pins below which they make no cross."""


def mean_positions(period: float) -> Array:
    """Return positions of the drive over a period, of which mean masses are taken [rad]."""
    return period * np.arange(8) / 8


class PinAxis(NamedTuple):
    """A pin.

    Attributes:
        name: of the joint, or `joint.coordinate` of a joint of type `universal`.
        joint: that carries its wrench.
        part: its turn in the mechanism's model.
    """

    name: str
    joint: str
    part: Part


def normal_of(pins: Sequence[PinAxis], axes: Sequence[Array]) -> Array:
    """Return the cross product of the axes of both pins of a cross; refuse parallel ones."""
    first, second = axes
    normal = cross(first, second)
    if np.sqrt(normal @ normal) < _PARALLEL:
        names = " and ".join(repr(pin.name) for pin in pins)
        raise ModelError(f"{names} are parallel, and make no cross")
    return normal


class Bearing(NamedTuple):
    """An open bearing.

    Attributes:
        name: of the joint; of a cross that of the pin, with `+` or `-`: the end to which its axis
            points, or the other.
        of: name of the pin.
        pin: its index.
        sign: +1 or -1; 0 of a bush in which the pin stays parallel.
    """

    name: str
    of: str
    pin: int
    sign: float


class Mobility(NamedTuple):
    """How `B` bearings give way at one position, along `d` axes each.

    Attributes:
        axes: `(k, B d)` orthonormal directions in which sides that have mass can be pushed apart.
        matrix: `(k, k)` W: acceleration of one side relative to the other per force between them,
            along these axes [1/kg].
        movable: `(B d, f)` orthonormal motions that the rest of the mechanism leaves: what is
            normal to them are forces that loops leave open.
        frames: `(B, d, 3)` axes of each bearing in the world.
    """

    axes: Array
    matrix: Array
    movable: Array
    frames: Array

    def reduced_mass(self, direction: Array) -> float:
        """Return the mass that forces along a direction `(B d,)` have to move [kg].

        The sides are free to move across it.
        """
        along = self._along(direction)
        return 1.0 / float(along @ self.matrix @ along)

    def deviation(self, direction: Array) -> float:
        """Return the angle between a force along a direction and the motion it causes [rad]."""
        along = self._along(direction)
        moved = self.matrix @ along
        part = float(along @ moved)
        beside = moved - part * along
        return float(np.arctan2(np.sqrt(beside @ beside), part))

    def _along(self, direction: Array) -> Array:
        along = self.axes @ direction
        return np.asarray(along / np.sqrt(along @ along))


class Plane(NamedTuple):
    """How a pin moves in its bush, at `N` equidistant positions of the drive over a period.

    All along two directions of the bush that are normal to its axis and to each other.

    Attributes:
        mobility: `(N, 2, 2)` inverse of M [1/kg].
        gyration: `(N, 2, 2)` C [kg/rad].
        force: `(N, 2)` F without clearance, on the pin [N].
        period: after which they repeat [rad].
    """

    mobility: Array
    gyration: Array
    force: Array
    period: float


class BearingForces(NamedTuple):
    """What `B` bearings carry over `N` positions.

    Attributes:
        world: `(N, B, 3)` across the pins, on their child links, in the world [N].
        local: `(N, B, d)` the same along the axes of `Mobility`.
        open_for: why they are not known; empty if they are.
    """

    world: Array
    local: Array
    open_for: str


class OpenedJoint:
    """A mechanism in which one joint's bearings have clearance.

    What loops leave open of the forces in a cross, such as one through its centre between two
    shafts in fixed bearings, is no part of them: clearance sets it free.

    Attributes:
        name: of the joint, or of the link that is the cross.
        pins: one, or both of a cross.
        bearings: that are open.
        clearances: `(B,)` differences 2 s of the diameters of bush and pin [m].
        laws: stiffness of each bearing's contact [N/m], or a geometry that decides it.
        radii: `(2,)` from the centre of a cross to the bearings of each pin [m], None of one bush.
        is_cross: whether it is a universal joint.
    """

    def __init__(
        self,
        solver: ProblemSolver,
        rotor: float | None,
        name: str,
        pins: tuple[PinAxis, ...] | None = None,
        bearings: tuple[Bearing, ...] | None = None,
        clearances: Array | None = None,
        laws: Sequence[float | PinGeometry] = (),
        radii: Array | None = None,
    ) -> None:
        """Open a joint; a single bush if only its name is given.

        Args:
            solver: of the scene.
            rotor: inertia that turns with the drive [kg m²]; None if its motion is prescribed.
            name: see above, as all that follows.
            pins: see above.
            bearings: see above.
            clearances: see above.
            laws: see above.
            radii: see above.
        """
        self._solver, self._mechanism = solver, solver.problem.mechanism
        problem, coordinates = solver.problem, self._mechanism.coordinates
        drive = coordinates.named[problem.independent[0]].rate
        held = coordinates.rates_of(problem.held)
        # Velocity coordinates that are fixed, and those of rotors with their inertias.
        self._moved: tuple[list[int], dict[int, float]] = [drive, *held], {}
        if rotor is not None:
            self._moved = held, {drive: number("rotor", rotor, least=0.0)}
        self._length = self._mechanism.characteristic_length
        self.name, self.is_cross = name, radii is not None
        self.pins = pins or (PinAxis(name, name, self._mechanism.joint(name).parts[0]),)
        self.bearings = bearings or (Bearing(name, name, 0, 0.0),)
        self.clearances = np.full(len(self.bearings), np.nan) if clearances is None else clearances
        self.laws, self.radii = tuple(laws), radii
        of = {item.pin for item in self.bearings}
        self._basis = {pin: np.array(across(self.pins[pin].part.axis)) for pin in sorted(of)}
        # What positions alone decide, and every speed has the same.
        self._turns: dict[int, tuple[Array, Array]] = {}
        self._means: dict[int, Mobility] = {}

    @cached_property
    def _start(self) -> Motion:
        return motion_at(self._solver, Targets.of_positions(np.zeros((1, 1))))

    @cached_property
    def _offsets(self) -> Array:
        """From the origin of each pin's joint to its centre in a cross, along the axis `(2,)` [m].

        Where the axes do not meet, the centres are the feet of their common normal.
        """
        if self.radii is None:
            return np.zeros(1)
        closed = OpenedMechanism(self._mechanism, {}, *self._moved)
        closed.ways(self._start.rows[0])
        (first, second), skew = self._axes(closed)
        origins = [closed.centre(pin.part) for pin in self.pins]
        between, skew = origins[1] - origins[0], skew / (skew @ skew)
        # Of the lines o₁ + d₁ a₁ and o₂ + d₂ a₂ the points nearest to each other.
        return np.array([np.cross(between, second) @ skew, np.cross(between, first) @ skew])

    def _axes(self, opened: OpenedMechanism) -> tuple[list[Array], Array]:
        """Return the axes of both pins of a cross in the world, and their cross product."""
        axes = [opened.axis(pin.part) for pin in self.pins]
        return axes, normal_of(self.pins, axes)

    def _end(self, pin: int, sign: float) -> Array:
        """Return how a bearing moves `(2, k)` with the two slides, and two tilts of a cross."""
        if self.radii is None:
            return np.eye(2)
        at = self._offsets[pin] + sign * self.radii[pin]
        return np.array([[1.0, 0.0, 0.0, at], [0.0, 1.0, -at, 0.0]])

    @cached_property
    def _opened(self) -> OpenedMechanism:
        kinds = ("prismatic", "revolute") if self.is_cross else ("prismatic",)
        freedoms, closed = {}, {}
        for pin, basis in self._basis.items():
            body = self.pins[pin].part.id
            freedoms[body] = [(kind, axis) for kind in kinds for axis in basis]
            signs = {item.sign for item in self.bearings if item.pin == pin}
            for sign in {1.0, -1.0} - signs if self.is_cross else ():
                closed[body] = self._end(pin, sign)
        return OpenedMechanism(self._mechanism, freedoms, *self._moved, closed)

    @cached_property
    def at_start(self) -> Mobility:
        """How it gives way where the drive is at 0."""
        return self.mobility(self._start.rows[0])

    @cached_property
    def inertia(self) -> float:
        """What makes forces of inertia with the square of the drive's speed [N s²].

        0 of a bush, whose forces are measured by those of other joints.
        """
        if self.radii is None:
            return 0.0
        heaviest = 1.0 / float(np.linalg.eigvalsh(self.at_start.matrix)[0])
        return heaviest * float(np.nanmax(self.radii))

    def mobility(self, x: Array) -> Mobility:
        """Return how the bearings give way.

        Args:
            x: `(size,)` closed coordinates of the mechanism.
        """
        ways, frames, movable, along = self._placed(x)
        if not len(along):
            raise ModelError(
                f"with clearance in {self._names} alone nothing can move, since all other bearings "
                "are tight; open both bearings of a pin, or some on each of both pins"
            )
        inertia, rounding = self._opened.inertia(x, ways)
        if np.min(np.linalg.eigvalsh(inertia), initial=np.inf) > rounding:
            # Beside a great inertia, small ones stay exact here.
            matrix = along @ np.linalg.solve(inertia, along.T)
            return Mobility(movable.T, matrix, movable, frames)
        if not self.is_cross:
            raise ModelError(
                f"joint {self.name!r}: where it is open, something without mass is free to move; "
                "give all links between it and the drive a mass"
            )
        inertias, principal = np.linalg.eigh(inertia)
        is_light, along = inertias <= rounding, along @ principal
        kept, sizes, _ = np.linalg.svd(along[:, is_light])
        count = int(np.count_nonzero(sizes > NOTHING * np.linalg.norm(along)))
        axes, heavy = kept[:, count:].T @ movable.T, kept[:, count:].T @ along[:, ~is_light]
        if not len(axes):
            raise ModelError(
                f"{self._names}: what would move there has no mass; give the links on both sides a "
                "mass"
            )
        return Mobility(axes, (heavy / inertias[~is_light]) @ heavy.T, movable, frames)

    @cached_property
    def _turning(self) -> tuple[list[int], Array, Array]:
        """Of each bearing the turn of its pin among the open ones, freedoms, and what these do.

        That is `(B, k)`, and `(B, 2, k)` as `_end` has it.
        """
        of, added = list(self._basis), self._opened.added
        rates = [added[self.pins[item.pin].part.id] for item in self.bearings]
        ends = [self._end(item.pin, item.sign) for item in self.bearings]
        return [of.index(item.pin) for item in self.bearings], np.array(rates), np.array(ends)

    def _placed(self, x: Array) -> tuple[Array, Array, Array, Array]:
        """Return the ways it can move, axes of bearings, and what they can do together.

        That is `(B d, m)`, and how much of it per way `(m, f)`.
        """
        ways, frames = self._opened.ways(x), self._frames()
        of, rates, ends = self._turning
        slides = np.array([self._slides(pin).T for pin in self._basis])
        parts = frames @ slides[of] @ (ends @ ways[rates])
        left, sizes, right = np.linalg.svd(np.concatenate(parts), full_matrices=False)
        rank = int(np.count_nonzero(sizes > NOTHING * self._length))
        return ways, frames, left[:, :rank], sizes[:rank, None] * right[:rank]

    @property
    def _names(self) -> str:
        return ", ".join(item.name for item in self.bearings)

    def _frames(self) -> Array:
        """Return the axes of each bearing in the world `(B, d, 3)`, where `ways` was asked last.

        Of a cross t across the pin and the normal, and n along the normal, along which it passes
        its moment on; both are fixed in it.
        """
        if not self.is_cross:
            return np.eye(3)[None]
        axes, normal = self._axes(self._opened)
        normal = normal / np.sqrt(normal @ normal)
        frames = np.array([(cross(normal, axis), normal) for axis in axes])
        return frames[[item.pin for item in self.bearings]]

    def _slides(self, pin: int) -> Array:
        """Return both slides of a pin `(2, 3)` in the world, where `ways` was asked last."""
        return np.asarray(self._basis[pin] @ self._opened.rotation(self.pins[pin].part.id).T)

    def gives_way(self, x: Array) -> bool:
        """Return whether a single bush can move along both slides."""
        return self._placed(x)[2].shape[1] == 2

    def forces(self, sweep: Sweep, motion: Motion) -> BearingForces:
        """Return what the bearings carry, F± = f/2 ± (m × a)/(2 r), or f in a single bush.

        Args:
            sweep: over `N` positions, with all pins among its outputs.
            motion: at the same positions.

        Source:
            Own derivation: a pin held at two places by forces across it.
        """
        if self.radii is None:
            force = across_pin(sweep, motion, self.name)[:, None]
            return BearingForces(force, force, what_is_open(self._solver, sweep, self.name))
        count = len(motion.rows)
        if count not in self._turns:
            found = [self._placed(x)[1:3] for x in motion.rows]
            decided_by = [movable @ movable.T for _, movable in found]
            self._turns[count] = np.array([one for one, _ in found]), np.array(decided_by)
        frames, projectors = self._turns[count]
        world = []
        for index, (*_, pin, sign) in enumerate(self.bearings):
            axis, joint = np.cross(frames[:, index, 0], frames[:, index, 1]), self.pins[pin].joint
            rotation = motion.joint_placement(joint)[0]
            wrench = sweep[joint]
            force, moment = (_turned(rotation, part) for part in (wrench.force, wrench.moment))
            moment = moment - self._offsets[pin] * np.cross(axis, force)
            pair = np.cross(moment, axis) / (2.0 * self.radii[pin])
            world.append(0.5 * force + sign * pair)
        local = _turned(frames, np.stack(world, axis=1))
        decided = (projectors @ local.reshape(count, -1, 1)).reshape(local.shape)
        back = np.moveaxis(frames, -1, -2)
        return BearingForces(_turned(back, decided), decided, self._open_pair(local, decided))

    def _open_pair(self, forces: Array, decided: Array) -> str:
        """Return which moment across a pin loops leave open, as the force of its pair shows."""
        missing = forces - decided
        for pin in self._basis:
            pair = [place for place, item in enumerate(self.bearings) if item.pin == pin]
            if len(pair) < 2:
                continue
            open_part = np.max(np.abs(missing[:, pair[0]] - missing[:, pair[1]]))
            if open_part > _PUSHED * np.max(np.abs(forces)):
                return (
                    f"its moment across the pin {self.pins[pin].name!r} is statically "
                    "indeterminate: other parts hold the joint where its bearings have clearance; "
                    "free the mechanism of what holds it twice"
                )
        return ""

    def check_mass(self, mobility: Mobility, direction: Array, position: float) -> None:
        """Refuse forces in a cross along a direction that push what has no mass."""
        if self.is_cross and np.linalg.norm(mobility.axes @ direction) < 1.0 - _PUSHED:
            raise ModelError(
                f"{self.name!r}: at {position:g} rad the forces of its bearings push something "
                "without mass; give the links of the joint a mass"
            )

    def shares(self, direction: Array) -> Array:
        """Return sizes `(B,)` of the bearings' forces along a unit direction `(B d,)`."""
        return np.asarray(np.linalg.norm(direction.reshape(len(self.bearings), -1), axis=1))

    def clearance(self, direction: Array) -> float:
        """Return the clearance 2 s of all bearings for forces along a direction `(B d,)` [m].

        Forces that are in equilibrium do the same work as one in the bearing that carries most:
        the ways of bearings one behind the other add up, those beside each other are one.
        """
        if len(self.bearings) == 1:
            return float(self.clearances[0])
        shares = self.shares(direction)
        return float(np.max(shares) * (shares @ self.clearances))

    def stiffness(self, direction: Array) -> float | StiffnessLaw:
        """Return the stiffness of all bearings for forces along a direction `(B d,)` [N/m].

        As a function of the greatest of their forces, where geometries decide it.
        """
        if len(self.laws) == 1:
            return self.laws[0]
        shares = self.shares(direction)
        return in_series(self.laws, shares, self.clearances, self.clearance(direction))

    def split(self, direction: Array, movable: Array) -> float:
        """Return the part of the clearance, as a fraction, that cannot close in all bearings.

        Args:
            direction: of the forces `(B d,)`; a bearing counts as much as it carries.
            movable: `(B d, f)` motions that the bearings can make together.
        """
        sizes = self.shares(direction)
        weight = np.repeat(sizes, len(direction) // len(sizes))
        closing = np.repeat(self.clearances, len(direction) // len(sizes)) * direction
        closing = closing / np.where(weight > 0.0, weight, 1.0)
        wanted = weight * (closing / np.max(np.abs(closing)))
        ways = weight[:, None] * movable
        found = np.linalg.lstsq(ways, wanted, rcond=NOTHING)[0]
        return float(np.linalg.norm(ways @ found - wanted) / np.linalg.norm(wanted))

    def mean_mass(self, states: Array, force: Array) -> float:
        """Return the mass by which a damping ratio is meant [kg], one number of the joint.

        The geometric mean of the reduced masses along the force without clearance, where a force
        counts as much as it is great.

        Args:
            states: `(N, size)` closed coordinates of the mechanism, at `mean_positions`.
            force: `(N, B d)` of the bearings there [N].
        """
        sizes = np.linalg.norm(force, axis=1)
        kept = sizes > NOTHING * np.max(sizes, initial=0.0)
        masses = []
        for index in np.flatnonzero(kept).tolist():
            if index not in self._means:
                self._means[index] = self.mobility(states[index])
            masses.append(self._means[index].reduced_mass(force[index]))
        return float(np.exp(np.sum(sizes[kept] * np.log(masses)) / np.sum(sizes)))

    def plane(self, states: Array, velocities: Array, force: Array, period: float) -> Plane:
        """Return how the pin of a bush moves in it over a period, the drive's motion prescribed.

        Args:
            states: `(N, size)` closed coordinates of the mechanism, at equidistant positions of the
                drive from 0.
            velocities: `(N, nv)` of the mechanism per unit of the drive's rate.
            force: `(N, 3)` without clearance, on the pin's link, in the world [N].
            period: of the drive [rad].
        """
        count, opened = len(states), self._opened
        body, slides = self.pins[0].part.id, np.empty((count, 2, 3))
        mass, ways = np.empty((count, 2, 2)), np.empty((count, opened.size, 2))
        for k, x in enumerate(states):
            found = opened.ways(x)
            apart = found[opened.added[body]]
            if apart.shape[1] != 2 or np.linalg.matrix_rank(apart, tol=NOTHING * self._length) < 2:
                raise ModelError(f"joint {self.name!r} does not move in both ways across its axis")
            turned = np.linalg.inv(apart)
            ways[k], mass[k] = found @ turned, turned.T @ opened.inertia(x, found)[0] @ turned
            slides[k] = self._slides(0)
        changes = Fourier.of(ways.reshape(count, -1).T, period).derivative()
        moved = changes(period / count * np.arange(count)).T.reshape(ways.shape)
        along = opened.velocity(velocities)
        gyration = np.array(
            [
                way.T @ opened.coriolis(x, v, way, change)
                for x, v, way, change in zip(states, along, ways, moved, strict=True)
            ]
        )
        return Plane(np.linalg.inv(mass), gyration, _turned(slides, force), period)


def _turned(rotations: Array, vectors: Array) -> Array:
    """Return vectors `(..., j)` turned by matrices `(..., i, j)`."""
    return np.asarray((rotations @ vectors[..., None])[..., 0])


def across_pin(sweep: Sweep, motion: Motion, name: str) -> Array:
    """Return the force across the pin of a joint that turns about one axis `(N, 3)` [N].

    Args:
        sweep: with its wrench.
        motion: at the same positions.
        name: of the joint.
    """
    axis = sweep.mechanism.joint(name).parts[0].axis
    force = np.asarray(sweep[name].force)
    force = force - np.outer(force @ axis, axis)
    return _turned(motion.joint_placement(name)[0], force)


def what_is_open(solver: ProblemSolver, sweep: Sweep, name: str) -> str:
    """Return why the force across the pin of a bush is not known; empty if it is.

    Flags of uniqueness belong to the components along a joint's frame. Where the pin's axis is
    along none of these, a force along the pin that is open makes all of them open, and what decides
    is whether the pin gives way once its joint is open: a force is unique if what it presses can
    move. Where it is not, compliances may decide the force, but rigid links leave no mass that it
    moves.

    Args:
        solver: of the scene.
        sweep: of it, with the joint among its outputs.
        name: of a joint that turns about one axis.
    """
    for item in sweep.mechanism.undescribed:
        if name in item.changes:
            return f"its force is not known: {item.told()}; {REMEDY}"
    axis = np.abs(sweep.mechanism.joint(name).parts[0].axis)
    is_open = ~np.asarray(sweep[name].unique[:3]) & (axis < 1.0 - NOTHING)
    if not np.any(is_open):
        return ""
    if np.count_nonzero(axis > NOTHING) > 1:
        chosen = np.linspace(0, len(sweep) - 1, min(len(sweep), 12)).astype(int)
        motion = motion_at(solver, Targets.of_positions(np.asarray(sweep.position)[chosen, None]))
        joint = OpenedJoint(solver, None, name)
        if all(joint.gives_way(x) for x in motion.rows):
            return ""
    letters = "".join(letter for letter, bad in zip("xyz", is_open, strict=True) if bad)
    return (
        f"its force {letters} is statically indeterminate: other joints hold its pin there, "
        "whatever its clearance; free the mechanism of what holds it twice"
    )
