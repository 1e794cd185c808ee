"""Tape: the equations of a scene's samples, traced once and run for many of them side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..kinematics.tolerances import REGULAR_CONDITION
from ..mechanics.bodies import Tree
from ..mechanics.elimination import MOST_GROWTH, Pivot
from ..mechanics.placements import placed
from ..mechanics.sample import Given, LinkForce, Roles, Solved, openings, solved
from ..mechanics.vectors import Rotation, Vector, times, turned
from ..tape import Program, Scalar, Trace, absolute, greater, is_zero, select
from .inverse_dynamics import Inputs
from .reactions import UNIQUE_TOLERANCE

_ROUNDING = float(np.finfo(float).eps)
_EXACT = float(np.sqrt(_ROUNDING))
"""Newton step that leaves rounding: its square."""
_FAR = 1e-3
"""Newton step [rad, or lengths] that is left to the general path, which knows how far off a guess
may be: between dense samples, guesses are off by 1e-6."""


class LinkKind(NamedTuple):
    """What a tape knows of a wrench on a link.

    Attributes:
        body: index of the body that carries the link.
        rotation: of the link in the body; None where the wrench is in world axes.
        lever: from the body's frame to the point at which the force acts, in the tree's unit.
    """

    body: int
    rotation: Rotation | None
    lever: Vector


class Kind(NamedTuple):
    """Samples that a tape is traced for.

    Attributes:
        moves: whether drives have speeds or accelerations.
        links: of the wrenches on links.
        factored: links with factors on their mass.
        moves_alone: whether the motion is wanted without forces.
    """

    moves: bool
    links: tuple[LinkKind, ...]
    factored: tuple[str, ...]
    moves_alone: bool


class Prescribed:
    """What is prescribed for samples, in rows as a tape takes them.

    Attributes:
        parts: arrays `(k, n)` of rows, or `(k, 1)` where they are the same for all samples.
    """

    def __init__(self, parts: Sequence[Array]) -> None:
        """Keep rows."""
        self.parts = parts

    @staticmethod
    def of(
        inputs: Inputs, links: Sequence[tuple[Array, Array]], offsets: Array, kind: Kind
    ) -> Prescribed:
        """Return the rows of samples but for their coordinates.

        Args:
            inputs: what is prescribed.
            links: force and moment `(n, 3)` or `(1, 3)` on each link of the kind.
            offsets: of couplings, `(c, n)`.
            kind: of the samples.
        """
        factors = (inputs.inertia[name][:, None] for name in kind.factored)
        given = [inputs.speeds, inputs.accelerations, inputs.gravity, inputs.loads]
        given += [vector for pair in links for vector in pair]
        return Prescribed([*(array.T for array in (*given, *factors)), offsets])

    def acting(self) -> Array:
        """Return which rows are not zero at some sample."""
        return np.concatenate([part.any(axis=1) for part in self.parts])

    def of_lanes(self, lanes: Array, count: int) -> Prescribed:
        """Return the rows of some of so many samples, by their indices."""
        return Prescribed(
            [part[:, lanes] if part.shape[1] == count else part for part in self.parts]
        )


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
        condition: `(n,)` narrowness of the elimination, see `Eliminated`, or a condition number.
    """

    x: Array
    v: Array
    a: Array
    ratios: Array
    wrenches: Array
    efforts: Array
    couplings: Array
    error: Array
    condition: Array

    def write(self, samples: Array, others: Sequence[Array]) -> None:
        """Write what was found of some samples, by their indices, in the order of the fields."""
        for own, other in zip(self, others, strict=True):
            own[samples] = other


class Judged(NamedTuple):
    """What a tape says of itself at n samples. It holds where the first three are at most 1.

    Attributes:
        instability: `(n,)` of the elimination, and a guess that is far off; infinite where the tape
            leaves out what acts.
        inexactness: `(n,)` Newton's last step and the closure error, beside rounding.
        left_out: `(n,)` zero where the tape considers all that acts.
        error, narrowness: `(n,)` see `Solved`.
    """

    instability: Array
    inexactness: Array
    left_out: Array
    error: Array
    narrowness: Array


class Tape:
    """The equations of a scene for one kind of samples, with one order of elimination.

    Attributes:
        acting: which rows of samples it considers; others have to be zero.
    """

    def __init__(
        self,
        tree: Tree,
        roles: Roles,
        kind: Kind,
        sizes: tuple[int, int],
        wrenches: Sequence[int],
        order: Sequence[Pivot],
        shadows: Mapping[int, Array],
        varied: Sequence[int],
        acting: Array,
    ) -> None:
        """Trace the equations.

        Args:
            tree: the mechanism.
            roles: of its coordinates.
            kind: what is traced.
            sizes: numbers of all wrenches and couplings of the mechanism.
            wrenches: indices of those that are wanted: of bodies, then of `fixed` loops.
            order: of the elimination.
            shadows: column of coordinate rows to values `(S,)` at which orders are chosen, in the
                units of the tree.
            varied: columns of held joints that differ from sample to sample.
            acting: see the attribute.

        Raises:
            UnsuitableError: samples do not tell which self-stresses are independent.
        """
        self._tree, self._roles, self._kind, self._order = tree, roles, kind, order
        self._shadows, self._sizes, self.acting = shadows, sizes, acting
        points = placed(tree, shadows).points
        farthest = max((np.abs(value).max() for point in points for value in point), default=0.0)
        # Loops count as closed up to the error of as many sums of lengths as there are bodies.
        rounding = len(tree.bodies) * _ROUNDING * max(1.0, float(farthest))
        moving = {*roles.passives, *roles.drives}
        per_sample = {
            column
            for body in tree.bodies
            if moving.issuperset(body.rates)
            for column in body.columns
        } | set(varied)
        self._size = len(shadows)
        self._per_sample = sorted(per_sample)
        self._uniform = [column for column in range(self._size) if column not in per_sample]
        self._spans = []
        with Trace() as trace:
            given, x, left_out = self._traced(trace)
            found = solved(tree, roles, given, order)
            error = found.error / tree.norm_length
            # Exactly 1 at the greatest that is allowed.
            unstable = greater(found.growth / MOST_GROWTH, found.narrowness / REGULAR_CONDITION)
            outputs = [
                select(left_out, np.inf, greater(unstable, found.step / _FAR)),
                greater(found.step / _EXACT, error / rounding),
                *(left_out, error, found.narrowness),
            ]
            for quantity in self._quantities(found, x, () if kind.moves_alone else wrenches):
                values = list(quantity)
                self._spans.append(slice(len(outputs), len(outputs) + len(values)))
                outputs += values
            self._program = Program(trace, outputs, keeps_inputs=True)

    def _traced(self, trace: Trace) -> tuple[Given, list[Scalar], Scalar]:
        """Return what is given at a sample, its coordinates in SI units, and what is left out.

        Prescribed become inputs in their order, those of coordinates behind them.
        """
        tree, roles, kind = self._tree, self._roles, self._kind
        length, units = tree.length, tree.units.tolist()
        left_out: Scalar = 0.0
        every: list[Scalar] = []
        for index, acts in enumerate(self.acting.tolist()):
            value = trace.input(f"r{index}", 1.0)
            every.append(value if acts else 0.0)
            left_out = left_out if acts else greater(left_out, absolute(value))
        rows = iter(every)

        def vector(unit: float) -> Vector:
            """Return the next three rows, in the tree's unit."""
            return times(tuple(islice(rows, 3)), 1.0 / unit)

        def in_tree(of: Vector) -> Vector:
            """Return a vector in world axes in those of the tree."""
            return turned(tuple(map(tuple, tree.axes.tolist())), of)

        speeds, accelerations = (
            [next(rows) * (1.0 / units[rate]) for rate in roles.drives] for _ in range(2)
        )
        gravity = in_tree(vector(length))
        efforts = tree.effort_units.tolist()
        loads = {rate: next(rows) * (1.0 / unit) for rate, unit in enumerate(efforts)}
        forces = []
        for link in kind.links:
            force, moment = vector(length), vector(length**2)
            if link.rotation is None:
                force, moment = in_tree(force), in_tree(moment)
            forces.append(LinkForce(*link, force, moment))
        factors = dict(zip(kind.factored, rows, strict=False))
        offsets = list(islice(rows, len(tree.couplings)))
        x: list[Scalar] = [0.0] * self._size
        of_columns = tree.coordinate_units(self._size).tolist()
        in_units: dict[int, Scalar] = {}
        for columns, is_uniform in (self._per_sample, False), (self._uniform, True):
            for column in columns:
                unit = of_columns[column]
                shadow = self._shadows[column] * unit
                x[column] = trace.input(f"x{column}", shadow, uniform=is_uniform)
                in_units[column] = x[column] * (1.0 / unit)
        loads = {rate: load for rate, load in loads.items() if not is_zero(load)}
        given = Given(in_units, speeds, accelerations, gravity, loads, forces, factors, offsets)
        return given, x, left_out

    def _quantities(
        self, found: Solved, x: list[Scalar], wrenches: Sequence[int]
    ) -> Iterator[Iterator[Scalar]]:
        """Yield the first fields of `Found` in SI units; forces are zero where none is wanted."""
        tree, roles = self._tree, self._roles
        length, units, rates = tree.length, tree.units.tolist(), range(len(tree.units))
        closed, of_columns = set(roles.columns(tree)), tree.coordinate_units(len(x)).tolist()
        yield (
            found.x[column] * of_columns[column] if column in closed else value
            for column, value in enumerate(x)
        )
        yield (found.v.get(rate, 0.0) * units[rate] for rate in rates)
        yield (found.a.get(rate, 0.0) * units[rate] for rate in rates)
        drives = [(ratios, units[r]) for ratios, r in zip(found.ratios, roles.drives, strict=True)]
        yield (of.get(r, 0.0) * (units[r] / unit) for r in rates for of, unit in drives)
        wanted = set(wrenches)
        yield (
            component
            for index in range(self._sizes[0])
            for component in _in_si(found, index if index in wanted else -1, length)
        )
        efforts = tree.effort_units.tolist()
        has_efforts = wanted or (roles.efforts_alone and not self._kind.moves_alone)
        yield (found.exerted.get(r, 0.0) * efforts[r] if has_efforts else 0.0 for r in rates)
        moments = [0.0] * self._sizes[1]
        for coupling, moment in zip(tree.couplings, found.couplings, strict=True):
            joint = coupling.successors[:1]
            unit = efforts[joint[0]] if joint else length**2
            moments[coupling.number] = moment * unit if wanted else 0.0
        yield iter(moments)

    def run(self, rows: Prescribed, x: Array) -> tuple[Found, Judged]:
        """Solve n samples.

        Args:
            rows: what is given.
            x: `(size, n)` coordinates near closed ones.
        """
        outputs = self._program.run_rows(self._with_x(rows, x), x.shape[1])
        fields = (outputs[span].T for span in self._spans)
        judged = Judged(*outputs[: len(Judged._fields)])
        return Found._make([*fields, judged.error, judged.narrowness]), judged

    def openings(self, rows: Prescribed, x: Array) -> tuple[Array, set[int]]:
        """Return what statics leaves open at closed samples.

        Arguments as of `run`.

        Returns:
            `(b, 6)` the greatest influence of self-stresses on each component, see
            `Solution.influence`; and the couplings (index) whose moments are not unique.
        """
        influence, loose = np.zeros((self._sizes[0], 6)), set[int]()
        if self._roles.efforts_alone:
            return influence, loose
        program, wrenches, couplings = self._opened
        if program.outputs:
            shares = program.run_rows(self._with_x(rows, x), x.shape[1])
            found = np.sqrt(np.abs(shares).max(axis=1))
            influence.ravel()[wrenches] = found[: len(wrenches)]
            open_ones = found[len(wrenches) :] > UNIQUE_TOLERANCE
            loose = {index for index, is_open in zip(couplings, open_ones, strict=True) if is_open}
        return influence, loose

    @cached_property
    def _opened(self) -> tuple[Program, list[int], list[int]]:
        """What is open as a program; which components its outputs are, and then which couplings."""
        tree = self._tree
        with Trace() as trace:
            wrenches, couplings = openings(tree, self._roles, self._traced(trace)[0], self._order)
            named = {
                6 * index + component: value
                for index, values in wrenches.items()
                for component, value in enumerate(values)
                if not is_zero(value)
            }
            of_couplings = {
                item.number: value
                for item, value in zip(tree.couplings, couplings or (), strict=bool(couplings))
                if not is_zero(value)
            }
            outputs = [*named.values(), *of_couplings.values()]
            return Program(trace, outputs, keeps_inputs=True), list(named), list(of_couplings)

    def _with_x(self, rows: Prescribed, x: Array) -> list[Array]:
        """Return rows with those of coordinates `(size, n)` behind them."""
        return [*rows.parts, x[self._per_sample], x[self._uniform, :1]]


def _in_si(found: Solved, index: int, length: float) -> Iterator[Scalar]:
    """Yield the components of a wrench in SI units; zeros of one that is not wanted."""
    if index < 0:
        yield from [0.0] * 6
        return
    force, moment = (found.fixed if index in found.fixed else found.wrenches)[index]
    yield from times(force, length)
    yield from times(moment, length**2)
