"""Equilibrium: where free coordinates rest, and whether they stay there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.acting import Acting
from ...core.problem.samples import Targets, acting_on
from ...core.results.collect import sweep_of
from ...core.results.inertia import mass_matrix_of
from ...core.results.limits import exceeded
from ...core.results.prescribed import Prescribed
from ...core.results.sweep import Sweep
from ...kit.arrays import EPS, NOTHING, ROUNDED, Array
from ...kit.differences import displacements, kinks, slopes
from ...kit.errors import CardanError, EquilibriumError, MobilityError, ModelError, choices
from ...kit.frozen import read_only
from .start_state import drive_positions

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_FINER = (1.0, 1e-2, 1e-4, 1e-6)
"""Units of differences [rad, or as a fraction of the characteristic length]: the first has errors
of 1e-13 of the forces. The others are for laws with kinks, and for places beside the end of a
table."""
_UNEVEN = 1e-5
"""What is left of a kink, as a fraction of the greatest stiffness or force, from which on a step is
too long: a curve leaves the square of the first step."""
_MOST_STEPS = 200
_LONGEST = 0.3
"""Longest step of Newton's method [rad, or as a fraction of the characteristic length]: longer ones
end at equilibria farther away."""
_TURN = math.ceil(math.tau / _LONGEST)
"""Steps of a turn, after which forces of what goes round repeat: if they fell by less than it takes
to end within the steps that are left, nothing ahead does."""


class Equilibrium(Prescribed):
    """Positions at which the f free coordinates need no effort to rest.

    Attributes:
        position: of the free coordinates `(f,)` [rad or m].
        stiffness: `(f, f)` effort along a free coordinate per displacement of one, at rest
            [N·m/rad, N/m and so on].
        inertia: `(f, f)` effort along a free coordinate per acceleration of one, from rest.
        stability: `stable`, `unstable` or `indifferent`, of small motions without damping; unstable
            as well where they flutter under loads that turn with their links.
        frequencies: angular frequencies `(k,)` of small undamped motions, ascending [rad/s], of the
            directions that swing.
        sweep: the scene at rest there: wrenches, holding efforts, residuals.
    """

    def __init__(self, statics: _Statics, place: _Place) -> None:
        self._problem, self._statics = statics.problem, statics
        self.position, self.stiffness = read_only(place.x), read_only(place.stiffness)
        self._scale = read_only(statics.scale)
        greatest = float(np.max(np.abs(place.stiffness * self._scale[:, None] * self._scale)))
        # Differences of efforts that are rounded like wrenches leave a tenth of it.
        noise = ROUNDED / place.unit * statics.wrench
        self._noise = max(noise, ROUNDED * greatest, float(np.finfo(float).tiny))
        self._freeze()

    def __repr__(self) -> str:
        places = ", ".join(
            f"{name} {value:g}" for name, value in zip(self.free, self.position, strict=True)
        )
        told = "".join(f"; {line}" for line in exceeded(self.sweep))
        return f"<Equilibrium of {self.mechanism.name!r}: {self.stability} at {places}{told}>"

    def point(self, link: str, xyz: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Return where a point of a link rests in the world `(3,)` [m]; see `Sweep.point`.

        Raises:
            ModelError: unknown link, or one whose motion the outputs leave out.
            ArgumentError: `xyz` is no `(3,)` of finite numbers.
        """
        return self.sweep.point(link, xyz).position[0]

    def orientation(self, link: str) -> Array:
        """Return the rotation `(3, 3)` that takes components in a link's axes to world axes.

        Raises:
            ModelError: see `point`.
        """
        return self.sweep.orientation(link)[0]

    @cached_property
    def sweep(self) -> Sweep:
        """The scene at rest there; see the class."""
        return self._statics.sweep(self.position[None, :])

    @cached_property
    def inertia(self) -> Array:
        """Generalised inertia; see the class."""
        return read_only(self._statics.inertia(self.position))

    @cached_property
    def _small(self) -> SmallMotions:
        """What becomes of small displacements, with lengths in units of the characteristic one."""
        units = self._scale[:, None] * self._scale
        return small_motions(self.stiffness * units, self.inertia * units, self._noise)

    @property
    def stability(self) -> str:
        """Whether the coordinates come back after small displacements, without damping."""
        return self._small.stability

    @property
    def frequencies(self) -> Array:
        """Angular frequencies of small motions; see the class."""
        return read_only(self._small.frequencies)


def equilibrium(
    solver: ProblemSolver, position: Any, loads: Mapping[str, object] | None, gravity: Any
) -> Equilibrium:
    """Return the equilibrium near a position; see `Scene.equilibrium`."""
    acting = acting_on(solver.problem, loads=loads, gravity=gravity)
    if not solver.problem.free:
        raise MobilityError(
            "an equilibrium is where free coordinates rest, and the scene drives all it has: "
            f"{choices(solver.problem.drives)}; name those that are free: scene.replace(free=...)",
            mobility=0,
        )
    driven, x = np.split(drive_positions(solver, position), [len(solver.problem.drives)])
    if not solver.knows_drive_efforts:
        raise ModelError(
            "what the free coordinates need to rest was not asked for; add their joints to the "
            f"outputs, which are: {choices(solver.problem.outputs)}"
        )
    statics = _Statics(solver, acting, driven)
    place, sizes = statics.place(x), list[float]()
    is_there, left = False, _MOST_STEPS
    while not is_there:
        sizes.append(statics.size(place.effort))
        pace = math.inf if len(sizes) <= _TURN else (sizes[-1 - _TURN] - sizes[-1]) / _TURN
        if not left or sizes[-1] > pace * left:
            raise EquilibriumError(
                f"no equilibrium was found near the start; after {_MOST_STEPS - left} steps these "
                f"still need {place.effort.tolist()} at {place.x.tolist()}; start nearer to one"
                f"{statics.refused}",
                position=place.x,
                effort=place.effort,
            )
        place, is_there = _moved(statics, place)
        left -= 1
        if statics.is_slowed:  # Narrow valleys are slow, and lead on.
            sizes.clear()
    if not place.is_proven:
        place = statics.place(place.x, is_proven=True)
    if place.is_at_kink:
        raise EquilibriumError(
            f"{place.x.tolist()} is an equilibrium at a kink of a force, which has another "
            "stiffness on either side of it, such as a row of a table: move that row, or sweep the "
            "scene there",
            position=place.x,
            effort=place.effort,
        )
    return Equilibrium(statics, place)


class _Place(NamedTuple):
    """What free coordinates need to rest at a place.

    Attributes:
        x: `(f,)` their positions [rad or m].
        effort: `(f,)` along them.
        stiffness: `(f, f)` its derivatives.
        unit: of the differences that they are [rad, or as a fraction of the characteristic length].
        is_at_kink: whether no step was short enough for them.
        is_proven: whether efforts at all positions that these are made of are proven.
    """

    x: Array
    effort: Array
    stiffness: Array
    unit: float
    is_at_kink: bool
    is_proven: bool


def _moved(statics: _Statics, place: _Place) -> tuple[_Place, bool]:
    """Return a place at which less effort is needed, and whether it is the last one."""
    x, scale = place.x, statics.scale
    size = statics.size(place.effort)
    if size <= EPS * statics.wrench:
        return place, True
    step, *_ = np.linalg.lstsq(place.stiffness, -place.effort, rcond=1e-12)
    length = float((np.abs(step) / scale).max())
    if length > _LONGEST:
        step, length = step * (_LONGEST / length), _LONGEST
    whole = length
    shortest = 4.0 * EPS * (1.0 + float(np.abs(x).max()))
    statics.refused = ""
    while length > shortest:
        # About the square of a step is left behind it.
        is_near = length <= EPS ** (1.0 / 3.0)
        try:
            # Where a step was cut, others mostly are, which one position tells.
            left = statics.needed(x + step) if statics.is_cut else 0.0
            if left < size:
                found = statics.place(x + step, is_near)
                left = statics.size(found.effort)
        except CardanError as error:
            # A dead point, a gap or the end of a table lies on the way.
            statics.refused = f". Beyond, {error}"
        else:
            if left < size:
                statics.is_cut = length < whole
                statics.is_slowed = statics.is_cut and not statics.refused
                return found, left <= 4.0 * EPS * max(statics.greatest, statics.wrench)
            if size <= 1e-11 * statics.greatest:  # Rounding is all that is left.
                return place, True
        statics.is_cut, step, length = True, 0.25 * step, 0.25 * length
    if size <= max(NOTHING * statics.greatest, ROUNDED * statics.wrench):
        return place, True
    raise EquilibriumError(
        f"no equilibrium was found; from {x.tolist()} on, the effort needed grows in every "
        f"direction; start elsewhere{statics.refused}",
        position=x,
        effort=place.effort,
    )


class _Statics:
    """Efforts that free coordinates need to rest, where the driven ones stand.

    Attributes:
        problem: of the scene.
        scale: `(f,)` units of the free coordinates: 1 rad, or the characteristic length.
        greatest: greatest effort seen [N·m].
        wrench: greatest moment, or force by the characteristic length, seen in a joint [N·m].
        is_cut: whether the last step was shortened.
        is_slowed: whether it was since more effort is needed beyond, and for nothing else.
        refused: why places farther on that step were not taken.
    """

    def __init__(self, solver: ProblemSolver, acting: Acting, driven: Array) -> None:
        self._solver, self._acting, self._driven = solver, acting, driven
        self.problem = solver.problem
        coordinates = solver.problem.mechanism.coordinates
        self.scale = coordinates.rate_scale[coordinates.rates_of(solver.problem.free)]
        self._stencil = np.vstack([np.zeros_like(self.scale), displacements(self.scale)])
        self.greatest = self.wrench = 0.0
        self.is_cut = self.is_slowed = False
        self.refused = ""

    def sweep(self, positions: Array) -> Sweep:
        """Return the scene at rest at positions `(N, f)`."""
        assembled = self._solver.assembled_in_turn(self._targets(positions))
        return sweep_of(self._solver, assembled, self._acting)

    def _targets(self, positions: Array) -> Targets:
        driven = self._driven[None, :].repeat(len(positions), axis=0)
        return Targets.of_positions(np.concatenate([driven, positions], axis=1))

    def _efforts(self, positions: Array, is_proven: bool) -> Array:
        """Return the efforts `(N, f)` along the free coordinates."""
        assembled = self._solver.assembled_in_turn(self._targets(positions))
        if is_proven:
            solution = self._solver.solve(assembled, self._acting)
            wrenches, efforts = solution.wrenches, solution.efforts
        else:
            wrenches, efforts = self._solver.sought(assembled, self._acting)
        size = np.abs(wrenches)
        size[..., :3] *= self.problem.mechanism.characteristic_length
        self.wrench = max(self.wrench, float(size.max(initial=0.0)))
        found = efforts[:, len(self._driven) : len(self.problem.independent)]
        self.greatest = max(self.greatest, float(np.abs(found * self.scale).max()))
        return found

    def size(self, effort: Array) -> float:
        """Return the size of efforts `(f,)` [N·m]."""
        return math.hypot(*effort * self.scale)

    def needed(self, x: Array) -> float:
        """Return the size of what is needed at a position `(f,)`."""
        return self.size(self._efforts(x[None, :], False)[0])

    def place(self, x: Array, is_proven: bool = False) -> _Place:
        """Return what is needed at positions `(f,)`.

        Derivatives are taken with the longest step that leaves kinks outside.
        """
        for unit in _FINER:
            units = unit * self.scale
            try:
                efforts = self._efforts(x + unit * self._stencil, is_proven)
            except CardanError as error:
                # Finer steps do not bring the place itself within reach.
                if unit == _FINER[-1] or getattr(error, "sample", None) == 0:
                    raise
                continue
            derivative, size = slopes(efforts[1:], units), self.scale[:, None] * self.scale
            most = max(self.wrench, float(np.abs(derivative * size).max()))
            left = kinks(efforts[1:], efforts[0], units) * size
            is_at_kink = bool(left.max() > _UNEVEN * most)
            if not is_at_kink:
                break
        return _Place(x, efforts[0], derivative, unit, is_at_kink, is_proven)

    def inertia(self, x: Array) -> Array:
        """Return the generalised inertia `(f, f)` at a position."""
        (every,) = mass_matrix_of(self._solver, self._targets(x[None, :]))
        free = slice(len(self._driven), None)
        return np.ascontiguousarray(every[free, free])


class SmallMotions(NamedTuple):
    """What becomes of small displacements.

    Attributes:
        stability: `stable`, `unstable` or `indifferent`.
        frequencies: angular frequencies `(k,)` of directions that swing, ascending [rad/s].
    """

    stability: str
    frequencies: Array


def small_motions(stiffness: Array, inertia: Array, noise: float) -> SmallMotions:
    """Return what becomes of small displacements x, without damping: M ẍ + K x = 0.

    Efforts that no potential has, such as those of a force that turns with its link, make K
    unsymmetric. Two squares of frequencies may then meet and part as complex ones: flutter, whose
    swings grow.

    Args:
        stiffness: K `(d, d)`, of coordinates with one unit.
        inertia: M `(d, d)`, of the same.
        noise: error of the stiffness along any direction.

    Source: Ziegler, Die Stabilitätskriterien der Elastomechanik, Ing.-Arch. 20 (1952).
    """
    inertia = 0.5 * (inertia + inertia.T)
    if np.max(np.abs(stiffness - stiffness.T)) <= 2.0 * noise:
        stiffness = 0.5 * (stiffness + stiffness.T)
    weights, axes = np.linalg.eigh(inertia)
    is_heavy = weights > ROUNDED * np.max(np.abs(weights))
    turned = axes.T @ stiffness @ axes
    heavy, light = np.ix_(is_heavy, is_heavy), np.ix_(~is_heavy, ~is_heavy)
    # What has no inertia follows the rest as its springs want it.
    own = turned[light]
    across = turned[np.ix_(is_heavy, ~is_heavy)], turned[np.ix_(~is_heavy, is_heavy)]
    condensed = turned[heavy] - across[0] @ np.linalg.pinv(own, rcond=1e-10) @ across[1]
    root = np.sqrt(weights[is_heavy])
    squares, vectors = _spectrum(condensed / root[:, None] / root)
    errors = noise * np.sum(np.abs(vectors / root[:, None]) ** 2, axis=0)
    # Rounding parts two that are equal by the root of its size.
    flutters = np.abs(squares.imag) > np.maximum(errors, np.sqrt(NOTHING) * np.abs(squares))
    swings = (squares.real > errors) & ~flutters
    idle = _spectrum(own)[0].real
    least = np.concatenate([squares.real / np.where(errors > 0.0, errors, 1e-300), idle / noise])
    if np.any(flutters) or np.any(least < -1.0):
        stability = "unstable"
    else:
        stability = "stable" if np.all(least > 1.0) else "indifferent"
    return SmallMotions(stability, np.sort(np.sqrt(squares.real[swings])))


def _spectrum(matrix: Array) -> tuple[Array, Array]:
    """Return complex eigenvalues `(d,)` and eigenvectors of length 1, a column for each."""
    solve = np.linalg.eigh if np.array_equal(matrix, matrix.T) else np.linalg.eig
    values, vectors = solve(matrix)
    return values.astype(complex), vectors
