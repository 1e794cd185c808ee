"""Build a response: solve its columns at doubled numbers of positions until they reach rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .errors import AccuracyError, ArgumentError, CardanError
from .kinematics import ClosedMechanism
from .pipeline import Block, Inputs, joined
from .reactions import UNIQUE_TOLERANCE, LoadCase, Reactions, superposed
from .response import GRAVITY, Proof, Response
from .series import Series

if TYPE_CHECKING:
    from .scene import Scene

_FIRST = 128
_MOST = 2**15
_CHECKS = 32
_EPS = float(np.finfo(float).eps)


def build(scene: Scene, tolerance: float, low: float | None, high: float | None) -> Response:
    """Return the response of a scene; see `Scene.response`."""
    if len(scene.drives) != 1:
        raise ArgumentError(f"a response needs one drive, not {list(scene.drives)}")
    if not 1e-15 <= tolerance < 1.0:
        raise ArgumentError(f"tolerance is {tolerance}, expected 1e-15 … 1")
    for name, load in scene.link_loads.items():
        if max(len(load.force), len(load.moment)) > 1:
            raise ArgumentError(
                f"the wrench on {name!r} changes from sample to sample; a response needs one that "
                "stays the same"
            )
    origin, length, periodic = _domain(scene, low, high)
    columns = Columns(scene)
    count, worst_before = _FIRST, np.inf
    nodes, checks = Series.nodes(origin, length, periodic, count), _checks(origin, length, periodic)
    # One call costs less than two, and the positions in between prove the result.
    values, proven = columns.prove(np.concatenate([nodes, checks]))
    values, direct = values[:, : len(nodes)], values[:, len(nodes) :]
    while True:
        series = Series(values, origin, length, periodic)
        scale = columns.scales(values)
        empty = columns.empty(values)
        tails = np.where(empty, 0.0, series.tail() / scale)
        worst = float(np.max(tails, initial=0.0))
        stalled = worst < 1e-8 and worst > 0.5 * worst_before
        # What depends on speed alone is what is left of inertial terms, and so is its rounding.
        hidden = columns.rounding(direct, proven)
        # Coefficients do not fall below the rounding of what they are made of.
        if worst <= tolerance or (
            stalled and np.all(tails <= tolerance * columns.condition + hidden)
        ):
            break
        if stalled or count >= _MOST:
            raise AccuracyError(
                f"the response reaches {worst:.1e} with {count} samples, not {tolerance:.0e}: the "
                f"closure equations have condition {columns.condition:.1e}; ask for a greater "
                "tolerance, or for a range farther from dead points",
                residual=worst,
                tolerance=tolerance,
                position=None,
            )
        worst_before = worst
        count *= 2
        # Every other position is one of the last round's.
        finer = np.empty((len(values), 2 * values.shape[1] - (not periodic)))
        finer[:, ::2] = values
        finer[:, 1::2] = columns.solve(Series.nodes(origin, length, periodic, count)[1::2])
        values = finer
    errors = np.max(np.abs(series.summed(checks) - direct) / scale[:, None], axis=1)
    errors[empty] = 0.0
    if not np.all(errors <= max(10.0 * tolerance, 1e-12 * columns.condition) + hidden):
        raise AccuracyError(
            f"the response deviates by {np.max(errors):.1e} from directly solved positions, "
            f"more than {tolerance:.0e} allows",
            residual=float(np.max(errors)),
            tolerance=tolerance,
            position=None,
        )
    proof = Proof(
        tolerance=tolerance,
        error=max(float(np.max(errors, initial=0.0)), _EPS * columns.condition),
        condition=columns.condition,
        cancellation=columns.cancellation(direct, proven),
        loop_residual=float(np.max(proven.closure)),
        balance_residual=proven.residuals.balance,
        power_residual=proven.residuals.power,
    )
    # What is not above rounding is left out, what does not change is not transformed.
    noise = max(2e-15, 0.01 * tolerance) * scale
    zero = empty | (np.max(np.abs(values), axis=1) <= noise)
    constant = np.ptp(values, axis=1) <= noise
    unique = (columns.influence < UNIQUE_TOLERANCE)[columns.numbers]
    return Response(
        scene,
        tuple(columns.names),
        series,
        zero,
        constant & ~zero,
        unique,
        proof,
    )


def _domain(scene: Scene, low: float | None, high: float | None) -> tuple[float, float, bool]:
    if (low is None) != (high is None):
        raise ArgumentError("give both low and high, or neither")
    if low is not None and high is not None:
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise ArgumentError(f"the range from {low} to {high} is empty or not finite")
        return 0.5 * (low + high), 0.5 * (high - low), False
    period = scene.assembly.period()
    if period is None:
        raise CardanError(
            f"{scene.mechanism.name}: drive {scene.drives[0]!r} does not come back to where it was "
            "within a few turns; give the range: response(low=..., high=...)"
        )
    # A period begins where the scene starts.
    drive = scene.coordinates.columns[scene.drives[0]].start
    return float(scene.assembly.start[drive]), period, True


class Columns:
    """Solves wrenches and efforts for unit speed, acceleration, loads and gravity.

    Attributes:
        names: of the columns.
        numbers: places of the outputs among the wrenches.
        condition: greatest condition number met.
        influence: see `Reactions.influence`.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.names: list[str] = []
        if scene.heavy:
            self.names += ["speed²", "acceleration"]
        self.names += [*scene.joint_loads, *scene.link_loads]
        if scene.heavy and np.any(scene.gravity):
            self.names += list(GRAVITY)
        self.numbers = [scene.place(name) for name in scene.outputs]
        self.condition = 1.0
        self.influence = np.zeros((scene.reactions.bodies + len(scene.reactions.fixed), 6))
        velocities = scene.coordinates.velocities
        self._outside = [velocities[name].start for name in (*scene.drives, *scene.held)]
        self._weights = np.repeat([scene.mechanism.length, 1.0], 3)

    def solve(self, positions: Array) -> Array:
        """Return all functions `(C, M)` at drive positions `(M,)`."""
        here = self._closed(positions)
        rates = self._rates(here)
        return self._stacked(self._reactions(here, rates), rates[1])

    def prove(self, positions: Array) -> tuple[Array, Block]:
        """Return all functions, and the scene's own loads at unit rates with their residuals.

        The latter are the sum of the columns, so their residuals prove the columns.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        scene = self._scene
        here = self._closed(positions)
        rates = transmission, v, a = self._rates(here)
        cases = self._reactions(here, rates)
        factors = [self._factor(name) for name in self.names] or [1.0]
        loads = sum(
            (factor * self._loads(name) for factor, name in zip(factors, self.names, strict=False)),
            start=self._loads(""),
        )
        ones = np.ones((len(positions), 1))
        turns = np.zeros_like(here.x)
        inputs = Inputs(ones, ones, loads, scene.link_loads, turns, moving=True)
        together = superposed(cases, factors)
        block = scene.pipeline.proven(here, inputs, (transmission, v, a + v), together)
        block = joined([block], positions[:, None])
        scene.pipeline.prove_flags(block)
        return self._stacked(cases, v), block

    def greatest(self, values: Array) -> dict[str, float]:
        """Return the greatest wrench or effort of each column, forces times the length."""
        sizes, efforts = self._sizes(values)
        overall = np.max(np.concatenate([sizes, efforts], axis=1), axis=1, initial=0.0)
        return dict(zip(self.names, overall.tolist(), strict=True))

    def scales(self, values: Array) -> Array:
        """Return `(C,)` what errors of each function are relative to."""
        sizes, efforts = self._sizes(values)
        overall = np.array([size or 1.0 for size in self.greatest(values).values()])
        scales = np.maximum(sizes, 0.1 * overall[:, None])[:, :, None] / self._weights
        rest = np.maximum(efforts, 0.1 * overall[:, None])
        return np.concatenate([scales.ravel(), rest.ravel()])

    def empty(self, values: Array) -> Array:
        """Return `(C,)` which functions are nothing but the rounding of weights or inertia."""
        mechanism = self._scene.mechanism
        mass = sum(float(inertia.mass) for inertia in mechanism.model.inertias)
        terms = {"speed²": mass * mechanism.length**2, "acceleration": mass * mechanism.length**2}
        terms |= dict.fromkeys(GRAVITY, mass * mechanism.length)
        sizes, efforts = self._sizes(values)
        floor = _EPS * np.array([terms.get(name, 0.0) for name in self.names])[:, None]
        return np.concatenate([np.repeat((sizes <= floor).ravel(), 6), (efforts <= floor).ravel()])

    def cancellation(self, values: Array, proven: Block) -> float:
        """Return by how much inertial terms exceed what is left of them at constant speed."""
        greatest = self.greatest(values).get("speed²", 0.0)
        return 1.0 + (float(np.max(proven.residuals.inertia)) / greatest if greatest else 0.0)

    def rounding(self, values: Array, proven: Block) -> Array:
        """Return `(C,)` what rounding of inertial terms adds to each function, by its scale."""
        cancellation = self.cancellation(values, proven)
        return 10.0 * _EPS * self.condition * cancellation * self._of("speed²")

    def _of(self, name: str) -> Array:
        """Return `(C,)` which functions belong to a column."""
        belongs = np.array([other == name for other in self.names], dtype=bool)
        wrenches, efforts = 6 * len(self.numbers), len(self._outside)
        return np.concatenate([np.repeat(belongs, wrenches), np.repeat(belongs, efforts)])

    def _sizes(self, values: Array) -> tuple[Array, Array]:
        """Return greatest wrenches of the outputs and efforts by columns."""
        outputs, count = len(self.numbers), len(self.names)
        greatest = np.max(np.abs(values), axis=1)
        wrenches = greatest[: 6 * outputs * count].reshape(count, outputs, 6)
        efforts = greatest[6 * outputs * count :].reshape(count, len(self._outside))
        return np.max(wrenches * self._weights, axis=2, initial=0.0), efforts

    def _closed(self, positions: Array) -> ClosedMechanism:
        assembly = self._scene.assembly
        return assembly.close(assembly.guesses(positions[:, None]), positions[:, None])

    def _rates(self, here: ClosedMechanism) -> tuple[Array, Array, Array]:
        """Return transmission, velocities and accelerations at constant unit speed."""
        ones = np.ones((len(here.x), 1))
        rates = self._scene.pipeline.rates(here, ones, 0.0 * ones)
        condition = self._scene.pipeline.condition(here, rates[0])
        self.condition = max(self.condition, float(np.max(condition)))
        return rates

    def _reactions(
        self, here: ClosedMechanism, rates: tuple[Array, Array, Array]
    ) -> list[Reactions]:
        """Return the reactions of every column, those of rest if there is none."""
        _, v, a = rates
        still = np.zeros_like(v)
        dynamics = {"speed²": (v, a), "acceleration": (still, v)}
        dynamics |= dict.fromkeys(GRAVITY, (still, still))
        links = self._scene.link_loads
        cases = [
            LoadCase(
                dynamics.get(name),
                self._loads(name),
                [links[name]] if name in links else [],
                np.eye(3)[GRAVITY.index(name)] if name in GRAVITY else np.zeros(3),
            )
            for name in self.names or [""]
        ]
        found = self._scene.reactions.solve(here, cases)
        self.influence = np.maximum(self.influence, found[0].influence)
        return found

    def _loads(self, name: str) -> Array:
        """Return the unit load `(1, nv)` of a column."""
        loads = np.zeros((1, self._scene.mechanism.model.nv))
        if name in self._scene.joint_loads:
            loads[:, self._scene.coordinates.velocities[name].start] = 1.0
        return loads

    def _factor(self, name: str) -> float:
        """Return what the scene multiplies a column with at unit speed and acceleration."""
        if name in GRAVITY:
            return float(self._scene.gravity[GRAVITY.index(name)])
        given = self._scene.joint_loads.get(name)
        # A load that changes from sample to sample is as good as one that does not.
        return 1.0 if given is None or given.ndim else float(given)

    def _stacked(self, cases: list[Reactions], v: Array) -> Array:
        """Return wrenches and efforts of all columns as functions `(C, M)`."""
        count = len(v)
        wrenches, efforts = [np.zeros((0, count))], [np.zeros((0, count))]
        for name, reactions in zip(self.names, cases, strict=False):
            wrenches.append(reactions.wrenches[:, self.numbers].reshape(count, -1).T)
            effort = self._scene.pipeline.efforts(reactions) - self._loads(name)
            if self._scene.assembly.needed.efforts_alone:
                # Without closure forces virtual work gives the drive's effort.
                effort[:, self._outside[0]] = np.sum(effort * v, axis=1)
                effort[:, self._outside[1:]] = 0.0
            efforts.append(effort[:, self._outside].T)
        return np.concatenate([*wrenches, *efforts])


def _checks(origin: float, length: float, periodic: bool) -> Array:
    """Return positions between the samples, spread by the golden section."""
    share = (np.arange(1.0, _CHECKS + 1.0) * (0.5 * np.sqrt(5.0) - 0.5)) % 1.0
    if periodic:
        return origin + share * length
    return origin + (2.0 * share - 1.0) * length
