"""Tape: the equations of a scene's samples, traced once and run for many of them side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..mechanics.bodies import Tree
from ..mechanics.elimination import Pivot
from ..mechanics.placements import placed
from ..mechanics.sample import Given, LinkForce, Roles, Solved, solved
from ..mechanics.vectors import Rotation, Vector
from ..tape import Program, Scalar, Trace, is_zero


class LinkKind(NamedTuple):
    """What a tape knows of a wrench on a link.

    Attributes:
        body: index of the body that carries the link.
        rotation: of the link in the body; None where the wrench is in the tree's axes.
        lever: from the body's frame to the point at which the force acts.
        force, moment: which components may act.
    """

    body: int
    rotation: Rotation | None
    lever: Vector
    force: tuple[bool, ...]
    moment: tuple[bool, ...]


class Kind(NamedTuple):
    """Samples that a tape is traced for: what vanishes at all of them falls away.

    Attributes:
        speeds, accelerations: which drives have one.
        gravity: which components act, in the tree's axes.
        loads: loaded velocity coordinates.
        links: of the wrenches on links.
        factored: links with factors on their mass.
    """

    speeds: tuple[bool, ...]
    accelerations: tuple[bool, ...]
    gravity: tuple[bool, ...]
    loads: tuple[int, ...]
    links: tuple[LinkKind, ...]
    factored: tuple[str, ...]


class Found(NamedTuple):
    """What a tape finds of n samples.

    Attributes:
        x: `(n, size)` coordinates.
        v, a: velocities and accelerations `(n, nv)`.
        ratios: `(n, nv d)` velocity ratios.
        wrenches: `(n, 6 b)`.
        efforts: `(n, nv)` what drives and held joints exert.
        couplings: `(n, G)` moments.
        error: `(n,)` closure error, see `Sweep.loop_residual`.
    """

    x: Array
    v: Array
    a: Array
    ratios: Array
    wrenches: Array
    efforts: Array
    couplings: Array
    error: Array

    def write(self, samples: Array, others: Sequence[Array]) -> None:
        """Write what was found of some samples, by their indices, in the order of the fields."""
        for own, other in zip(self, others, strict=True):
            own[samples] = other


class _Rows:
    """Where the quantities of one kind stand among the outputs of a program.

    Those that vanish everywhere are no outputs.
    """

    def __init__(self, size: int, outputs: list[Scalar]) -> None:
        """Begin with none of `size` quantities, for outputs that others share."""
        self._size, self._outputs = size, outputs
        self._indices: list[int] = []
        self._rows: list[int] = []

    def put(self, index: int, value: Scalar, unit: float = 1.0) -> None:
        """Make a quantity an output, in SI units."""
        if not is_zero(value):
            self._indices.append(index)
            self._rows.append(len(self._outputs))
            self._outputs.append(value if unit == 1.0 else value * unit)

    def read(self, outputs: Array, rest: Array | None = None) -> Array:
        """Return all quantities `(n, size)`; those that are no outputs are zero, or as in `rest`.

        Args:
            outputs: `(rows, n)`.
            rest: `(size, n)`.
        """
        if self._indices == list(range(self._size)) and self._size:
            return outputs[self._rows[0] : self._rows[0] + self._size].T
        result = np.zeros((self._size, outputs.shape[1])) if rest is None else np.array(rest)
        result[self._indices] = outputs[self._rows]
        return result.T


class Tape:
    """The equations of a scene for one kind of samples, with one order of elimination.

    Attributes:
        rounding: closure error up to which loops count as closed: that of as many sums of lengths
            as there are bodies.
    """

    def __init__(
        self,
        tree: Tree,
        roles: Roles,
        kind: Kind,
        wrenches: Sequence[int],
        order: Sequence[Pivot],
        shadows: Mapping[int, Array],
        varied: Sequence[int],
    ) -> None:
        """Trace the equations.

        Args:
            tree: the mechanism.
            roles: of its coordinates.
            kind: what is traced.
            wrenches: indices of those that are wanted: of bodies, then of `fixed` loops.
            order: of the elimination.
            shadows: column of coordinate rows to values `(S,)` at which orders are chosen, in the
                units of the tree.
            varied: columns of held joints that differ from sample to sample.

        Raises:
            UnsuitableError: samples do not tell which self-stresses are independent.
        """
        self._tree = tree
        points = placed(tree, shadows).points
        farthest = max((np.abs(value).max() for point in points for value in point), default=0.0)
        self.rounding = len(tree.bodies) * float(np.finfo(float).eps) * max(1.0, float(farthest))
        moving = {*roles.passives, *roles.drives}
        self._per_sample = {
            column
            for body in tree.bodies
            if moving.issuperset(body.rates)
            for column in body.columns
        } | set(varied)
        trace = Trace()
        found = solved(tree, roles, self._traced(trace, kind, shadows), order)
        self._lay_out(trace, roles, found, wrenches)

    def _traced(self, trace: Trace, kind: Kind, shadows: Mapping[int, Array]) -> Given:
        """Return what is given at a sample, as inputs of a trace."""

        def given(name: str, acts: Sequence[bool]) -> list[Scalar]:
            return [
                trace.input(f"{name}{index}", 1.0) if is_given else 0.0
                for index, is_given in enumerate(acts)
            ]

        return Given(
            x={
                column: trace.input(f"x{column}", value, uniform=column not in self._per_sample)
                for column, value in shadows.items()
            },
            speeds=given("v", kind.speeds),
            accelerations=given("a", kind.accelerations),
            gravity=given("g", kind.gravity),
            loads={rate: trace.input(f"l{rate}", 1.0) for rate in kind.loads},
            link_forces=[
                LinkForce(
                    *(link.body, link.rotation, link.lever),
                    given(f"f{index}_", link.force),
                    given(f"m{index}_", link.moment),
                )
                for index, link in enumerate(kind.links)
            ],
            factors={name: trace.input(f"i{name}", 1.5) for name in kind.factored},
            offsets=[trace.input(f"o{index}", 0.0) for index in range(len(self._tree.couplings))],
        )

    def _lay_out(self, trace: Trace, roles: Roles, found: Solved, wrenches: Sequence[int]) -> None:
        """Make a program whose outputs are what is found."""
        tree, drives = self._tree, len(roles.drives)
        length, units, nv = tree.length, tree.units, len(tree.units)
        judged = found.step, found.error / tree.norm_length, found.growth, found.narrowness
        outputs: list[Scalar] = list(judged)
        size = max((body.columns.stop for body in tree.bodies), default=0)
        fixed = dict(enumerate(found.fixed, len(tree.bodies)))
        sizes = (
            size,
            nv,
            nv,
            nv * drives,
            6 * (len(tree.bodies) + len(fixed)),
            nv,
            len(tree.couplings),
        )
        self._rows = [_Rows(size, outputs) for size in sizes]
        x, v, a, ratios, of_wrenches, efforts, couplings = self._rows
        passives = set(roles.passives)
        for body in tree.bodies:
            if passives.issuperset(body.rates):
                for column in body.columns:
                    x.put(column, found.x[column], length if body.kind == "prismatic" else 1.0)
        # Those of a kind one after the other, so that all of them are read as one slice.
        for rate in range(nv):
            v.put(rate, found.v.get(rate, 0.0), units[rate])
        for rate in range(nv):
            a.put(rate, found.a.get(rate, 0.0), units[rate])
        for rate, drive in product(range(nv), range(drives)):
            ratio = found.ratios[drive].get(rate, 0.0)
            ratios.put(rate * drives + drive, ratio, units[rate] / units[roles.drives[drive]])
        for rate in range(nv):
            efforts.put(rate, found.exerted.get(rate, 0.0), tree.effort_units[rate])
        for index in wrenches:
            force, moment = fixed[index] if index in fixed else found.wrenches[index]
            for component in range(3):
                of_wrenches.put(6 * index + component, force[component], length)
            for component in range(3):
                of_wrenches.put(6 * index + 3 + component, moment[component], length**2)
        for index, (coupling, moment) in enumerate(
            zip(tree.couplings, found.couplings, strict=True)
        ):
            joint = coupling.successors[:1]
            couplings.put(index, moment, tree.effort_units[joint[0]] if joint else length**2)
        self._program = Program(trace, outputs)

    def run(self, given: Mapping[str, Any], x: Array) -> tuple[Found, Array]:
        """Solve n samples.

        Args:
            given: inputs but for coordinates, in the units of the tree.
            x: `(size, n)` coordinates near closed ones.

        Returns:
            What is found; and `(4, n)` step, error, growth and narrowness, see `Solved`.
        """
        inputs = dict(given)
        for body in self._tree.bodies:
            unit = self._tree.length if body.kind == "prismatic" else 1.0
            for column in body.columns:
                row = x[column] if column in self._per_sample else x[column, 0]
                inputs[f"x{column}"] = row / unit if unit != 1.0 else row
        outputs = self._program.run(inputs, x.shape[1])
        coordinates, *rest = self._rows
        found = coordinates.read(outputs, x), *(rows.read(outputs) for rows in rest)
        return Found(*found, outputs[1]), outputs[:4]
