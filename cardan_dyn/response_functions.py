"""Functions of a response: wrenches and efforts for unit speed, acceleration, loads and gravity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .coordinates import Array
from .kinematics import ClosedMechanism
from .loads import LinkLoad
from .pipeline import Block, Inputs, joined
from .plan import solved_couplings
from .reactions import UNIQUE_TOLERANCE, LoadCase, Reactions, superposed
from .response_columns import ACCELERATION, AXES, GRAVITY, SPEED_SQUARED, Column, Kind, Layout

if TYPE_CHECKING:
    from .scene import Scene

_EPS = float(np.finfo(float).eps)
_ROUNDED = 10.0
"""Rounding of inertial terms in units of eps, per condition number and cancellation. Measured: up
to 3, at bend angles from 1° to 85° and in a line of three joints."""


def layout_of(scene: Scene) -> Layout:
    """Return which functions the response of a scene has, and where they stand."""
    columns = [SPEED_SQUARED, ACCELERATION] if scene.heavy else []
    columns += [Column(Kind.JOINT_LOAD, name) for name in scene.joint_loads]
    columns += [Column(Kind.LINK_LOAD, name) for name in scene.link_loads]
    if scene.heavy and np.any(scene.gravity):
        columns += GRAVITY
    assembly = scene.assembly
    solved = solved_couplings(assembly.groups, assembly.needed)
    couplings = tuple(scene.mechanism.couplings[number].name for number in solved)
    return Layout(tuple(columns), scene.outputs, (*scene.drives, *scene.held), couplings)


class Functions:
    """Solves the functions of a response at drive positions, and keeps what was met there.

    Attributes:
        layout: which functions there are.
        condition: greatest condition number met.
        open_couplings: numbers of the couplings whose moment is not unique.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.layout = layout_of(scene)
        self.condition = 1.0
        self.open_couplings: set[int] = set()
        self._numbers = [scene.place(name) for name in scene.outputs]
        self._influence = np.zeros((scene.reactions.bodies + len(scene.reactions.fixed), 6))
        velocities = scene.coordinates.velocities
        names = [coupling.name for coupling in scene.mechanism.couplings]
        loops = len(scene.mechanism.loops)
        self._gears = [loops + names.index(name) for name in self.layout.couplings]
        self._outside = [velocities[name].start for name in self.layout.efforts]
        self._weights = np.repeat([scene.mechanism.length, 1.0], 3)

    @property
    def unique(self) -> Array:
        """Which components of the outputs follow from the laws of motion alone, `(k, 6)`."""
        return (self._influence < UNIQUE_TOLERANCE)[self._numbers]

    def solve(self, positions: Array) -> Array:
        """Return all functions `(C, M)` at drive positions `(M,)`."""
        here, _ = self._closed(positions)
        rates = self._rates(here)
        return self._stacked(self._reactions(here, rates), rates[1])

    def prove(self, positions: Array) -> tuple[Array, Block]:
        """Return all functions, and the scene's own loads at unit rates with their residuals.

        The latter are the sum of the columns, so their residuals prove the columns.

        Raises:
            AccuracyError: a residual misses its tolerance.
        """
        scene, columns = self._scene, self.layout.columns
        here, turns = self._closed(positions)
        rates = transmission, v, a = self._rates(here)
        cases = self._reactions(here, rates)
        factors = [self._factor(column) for column in columns]
        loads = self._loads(None)
        for factor, column in zip(factors, columns, strict=True):
            loads += factor * self._loads(column)
        ones = np.ones((len(positions), 1))
        placed = positions[:, None]
        inputs = Inputs(placed, ones, ones, loads, scene.link_loads, turns, moving=True)
        together = superposed(cases, factors or [1.0])
        block = scene.pipeline.proven(here, inputs, (transmission, v, a + v), together)
        block = joined([block], placed)
        scene.pipeline.prove_flags(block)
        return self._stacked(cases, v), block

    def scales(self, values: Array) -> Array:
        """Return `(C,)` what errors of each function are relative to."""
        sizes, singles = self._sizes(values)
        least = 0.1 * np.where(self._greatest(values) > 0.0, self._greatest(values), 1.0)[:, None]
        scales = np.maximum(sizes, least)[:, :, None] / self._weights
        return self.layout.joined(scales, np.maximum(singles, least))

    def empty(self, values: Array) -> Array:
        """Return `(C,)` which functions are nothing but the rounding of weights or inertia."""
        mechanism = self._scene.mechanism
        mass = sum(float(inertia.mass) for inertia in mechanism.model.inertias)
        terms = dict.fromkeys((SPEED_SQUARED, ACCELERATION), mass * mechanism.length**2)
        terms |= dict.fromkeys(GRAVITY, mass * mechanism.length)
        sizes, singles = self._sizes(values)
        floor = _EPS * np.array([terms.get(name, 0.0) for name in self.layout.columns])[:, None]
        return self.layout.joined(np.repeat((sizes <= floor)[:, :, None], 6, 2), singles <= floor)

    def cancellation(self, values: Array, proven: Block) -> float:
        """Return by how much inertial terms exceed what is left of them at constant speed."""
        sizes = dict(zip(self.layout.columns, self._greatest(values).tolist(), strict=True))
        greatest = sizes.get(SPEED_SQUARED, 0.0)
        return 1.0 + (float(np.max(proven.residuals.inertia)) / greatest if greatest else 0.0)

    def rounding(self, values: Array, proven: Block) -> Array:
        """Return `(C,)` what rounding of inertial terms adds to each function, by its scale.

        What depends on speed alone is what is left of inertial terms, and so is its rounding.
        """
        size = _ROUNDED * _EPS * self.condition * self.cancellation(values, proven)
        belongs = [column == SPEED_SQUARED for column in self.layout.columns]
        return self.layout.spread(size * np.array(belongs, dtype=float))

    def _greatest(self, values: Array) -> Array:
        """Return the greatest wrench or effort of each column, forces times the length."""
        sizes = np.concatenate(self._sizes(values), axis=1)
        return np.asarray(np.max(sizes, axis=1, initial=0.0))

    def _sizes(self, values: Array) -> tuple[Array, Array]:
        """Return greatest wrenches of the outputs, and greatest singles, by columns."""
        wrenches, singles = self.layout.parted(np.max(np.abs(values), axis=1))
        return np.max(wrenches * self._weights, axis=2, initial=0.0), singles

    def _closed(self, positions: Array) -> tuple[ClosedMechanism, Array]:
        """Return closed positions, and the whole turns that their angles lack."""
        guess = self._scene.assembly.guesses(positions[:, None])
        return self._scene.assembly.close(guess, positions[:, None]), guess.turns

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
        dynamics = {SPEED_SQUARED: (v, a), ACCELERATION: (still, v)}
        dynamics |= dict.fromkeys(GRAVITY, (still, still))
        cases = [LoadCase(None, self._loads(None), [], np.zeros(3))]
        if self.layout.columns:
            cases = [
                LoadCase(
                    dynamics.get(column),
                    self._loads(column),
                    self._links(column),
                    self._pull(column),
                )
                for column in self.layout.columns
            ]
        found = self._scene.reactions.solve(here, cases)
        self._influence = np.maximum(self._influence, found[0].influence)
        self.open_couplings |= found[0].open_couplings
        return found

    def _links(self, column: Column) -> list[LinkLoad]:
        return [self._scene.link_loads[column.name]] if column.kind is Kind.LINK_LOAD else []

    def _pull(self, column: Column) -> Array:
        """Return the unit gravity `(3,)` of a column."""
        return np.eye(3)[AXES.index(column.name)] if column.kind is Kind.GRAVITY else np.zeros(3)

    def _loads(self, column: Column | None) -> Array:
        """Return the unit load `(1, nv)` of a column."""
        loads = np.zeros((1, self._scene.mechanism.model.nv))
        if column is not None and column.kind is Kind.JOINT_LOAD:
            loads[:, self._scene.coordinates.velocities[column.name].start] = 1.0
        return loads

    def _factor(self, column: Column) -> float:
        """Return what the scene multiplies a column with at unit speed and acceleration."""
        if column.kind is Kind.GRAVITY:
            return float(self._scene.gravity[AXES.index(column.name)])
        if column.kind is Kind.JOINT_LOAD:
            given = self._scene.joint_loads[column.name]
            # A load that changes from sample to sample is as good as one that does not.
            return 1.0 if given.ndim else float(given)
        return 1.0

    def _stacked(self, cases: list[Reactions], v: Array) -> Array:
        """Return all functions `(C, M)` of the reactions of all columns."""
        count, layout = len(v), self.layout
        wrenches = np.zeros((len(layout.columns), len(layout.outputs), 6, count))
        efforts = np.zeros((len(layout.columns), len(layout.efforts), count))
        moments = np.zeros((len(layout.columns), len(layout.couplings), count))
        # Without any column there is one case, that of rest.
        for place, (column, reactions) in enumerate(zip(layout.columns, cases, strict=False)):
            wrenches[place] = reactions.wrenches[:, self._numbers].transpose(1, 2, 0)
            effort = self._scene.pipeline.efforts(reactions) - self._loads(column)
            if self._scene.assembly.needed.efforts_alone:
                # Without closure forces virtual work gives the drive's effort.
                efforts[place, 0] = np.sum(effort * v, axis=1)
            else:
                efforts[place] = effort[:, self._outside].T
            for number, gear in enumerate(self._gears):
                moments[place, number] = reactions.closure[gear][:, 0]
        return layout.joined(wrenches, np.concatenate([efforts, moments], axis=1))
