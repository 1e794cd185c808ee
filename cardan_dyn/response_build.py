"""Build a response: solve its columns at doubled numbers of positions until they reach rounding."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .errors import AccuracyError, ArgumentError, CardanError
from .kinematics import ClosedMechanism
from .reactions import UNIQUE_TOLERANCE
from .response import GRAVITY, Proof, Response
from .series import Series

if TYPE_CHECKING:
    from .scene import Scene

_FIRST = 64
_MOST = 2**15
_CHECKS = 64
_EPS = float(np.finfo(float).eps)


def build(scene: Scene, tolerance: float, low: float | None, high: float | None) -> Response:
    """Return the response of a scene; see `Scene.response`."""
    if len(scene.drives) != 1:
        raise ArgumentError(f"a response needs one drive, not {list(scene.drives)}")
    if not 1e-15 <= tolerance < 1.0:
        raise ArgumentError(f"tolerance is {tolerance}, expected 1e-15 … 1")
    origin, length, periodic = _domain(scene, low, high)
    columns = Columns(scene)
    count, values, worst_before = _FIRST, None, np.inf
    while True:
        positions = Series.nodes(origin, length, periodic, count)
        if values is None:
            values = columns.solve(positions)
        else:
            # Every other position is one of the last round's.
            finer = np.empty((len(values), len(positions)))
            finer[:, ::2] = values
            finer[:, 1::2] = columns.solve(positions[1::2])
            values = finer
        series = Series(values, origin, length, periodic)
        scale = columns.scales(values)
        worst = float(np.max(series.tail() / scale, initial=0.0))
        stalled = worst < 1e-8 and worst > 0.5 * worst_before
        # Coefficients do not fall below the rounding of what they are made of.
        if worst <= tolerance or (stalled and worst <= tolerance * columns.condition):
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
    proof, errors = _measured(scene, columns, series, scale, tolerance)
    allowed = np.full(len(errors), max(10.0 * tolerance, 1e-12 * columns.condition))
    # What depends on speed alone is what is left of inertial terms, and so is its rounding.
    allowed[columns.of("speed²")] += 10.0 * _EPS * columns.condition * proof.cancellation
    if not np.all(errors <= allowed):
        raise AccuracyError(
            f"the response deviates by {np.max(errors):.1e} from directly solved positions, "
            f"more than {tolerance:.0e} allows",
            residual=float(np.max(errors)),
            tolerance=tolerance,
            position=None,
        )
    # What is not above rounding is left out, what does not change is not transformed.
    noise = max(2e-15, 0.01 * tolerance) * scale
    zero = np.max(np.abs(values), axis=1) <= noise
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
    return scene.assembly.branch_start(), period, True


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
        self._loads = np.zeros((1, scene.mechanism.model.nv))
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
        scene, assembly = self._scene, self._scene.assembly
        guesses, turns = assembly.guesses(positions[:, None])
        here = assembly.close(guesses, turns, positions[:, None])
        kinematics = assembly.kinematics
        ones = np.ones((len(positions), 1))
        v = kinematics.rates(here, ones)
        condition = scene.pipeline.condition(here, v[:, :, None])
        self.condition = max(self.condition, float(np.max(condition)))
        none = np.zeros_like(v)
        wrenches, efforts = [], []
        gravity = scene.gravity
        try:
            for name in self.names:
                axis = GRAVITY.index(name) if name in GRAVITY else None
                kinematics.pull(np.zeros(3) if axis is None else np.eye(3)[axis])
                dynamics = None
                if name == "speed²":
                    dynamics = (v, kinematics.accelerations(here, v, 0.0 * ones))
                elif name == "acceleration":
                    dynamics = (none, v)
                elif axis is not None:
                    dynamics = (none, none)
                found, effort = self._column(here, name, dynamics, v)
                wrenches.append(found)
                efforts.append(effort)
        finally:
            kinematics.pull(gravity)
        count = len(positions)
        return np.concatenate(
            [np.array(wrenches).reshape(-1, count), np.array(efforts).reshape(-1, count)]
        )

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

    def of(self, name: str) -> Array:
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

    def _column(
        self, here: ClosedMechanism, name: str, dynamics: tuple[Array, Array] | None, v: Array
    ) -> tuple[Array, Array]:
        """Return wrenches `(k, 6, M)` and efforts `(e, M)` of one column."""
        scene = self._scene
        loads = self._loads.copy()
        if name in scene.joint_loads:
            loads[:, scene.coordinates.velocities[name].start] = 1.0
        links = [scene.link_loads[name]] if name in scene.link_loads else []
        reactions = scene.reactions.solve(here, dynamics, loads, links)
        self.influence = np.maximum(self.influence, reactions.influence)
        efforts = scene.pipeline.efforts(reactions) - loads
        if not scene.assembly.needed.complete:
            # Without closure forces virtual work gives the drive's effort.
            efforts[:, self._outside[0]] = np.sum(efforts * v, axis=1)
            efforts[:, self._outside[1:]] = 0.0
        kept = reactions.wrenches[:, self.numbers].transpose(1, 2, 0)
        return kept, efforts[:, self._outside].T


def _measured(
    scene: Scene, columns: Columns, series: Series, scale: Array, tolerance: float
) -> tuple[Proof, Array]:
    """Compare with positions between the samples; return their proof and the errors `(C,)`."""
    rng = np.random.default_rng(1939)
    share = rng.uniform(0.02, 0.98, _CHECKS)
    start = series.origin - (0.0 if series.periodic else series.length)
    positions = start + share * series.length * (1.0 if series.periodic else 2.0)
    direct = columns.solve(positions)
    found = series.summed(positions)
    errors = np.max(np.abs(found - direct) / scale[:, None], axis=1)
    ones = np.ones((_CHECKS, 1))
    block, _ = scene.solved(positions[:, None], ones, ones)
    greatest = columns.greatest(direct)["speed²"] if "speed²" in columns.names else 0.0
    inertia = float(np.max(block.residuals.inertia))
    proof = Proof(
        tolerance=tolerance,
        error=max(float(np.max(errors, initial=0.0)), _EPS * columns.condition),
        condition=columns.condition,
        cancellation=1.0 + (inertia / greatest if greatest else 0.0),
        loop_residual=float(np.max(block.closure)),
        balance_residual=block.residuals.balance,
        power_residual=block.residuals.power,
    )
    return proof, errors
