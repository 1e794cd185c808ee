"""Closed directions: accelerations of a chain along the directions that its closed loops leave.

Where closure equations are redundant or links have no mass, neither the equations nor the inertia
matrix have an inverse; along these directions inertia has one, unless they move no mass at all.
Which equations are independent is told by singular values, of which double precision leaves ten
digits: their squares, eigenvalues of J M⁻¹ Jᵀ, would leave five.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio
from numpy.polynomial import polynomial

from ...core.kinematics.tolerances import CLOSURE_TOLERANCE
from ...kit.arrays import EPS, NOTHING, ROUNDED, Array
from ...kit.differences import displacements, slopes
from ...kit.errors import SingularConfigurationError


class CouplingRows:
    """The couplings of a chain, each a polynomial of the motion of predecessors less successors."""

    def __init__(
        self,
        first: Array,
        last: Array | float = 0.0,
        powers: Array | None = None,
        columns: Array | None = None,
    ) -> None:
        """Make them.

        Args:
            first: `(k, nv)` the motion of predecessors by velocity coordinates.
            last: that of successors, likewise.
            powers: `(n, k)` coefficients of the polynomials, ascending; the motion itself if None.
            columns: `(nv,)` coordinates of velocity coordinates, -1 of those of balls; if None,
                couplings hold wherever they are asked.
        """
        count, size = first.shape
        self._first, self._last = first, last
        self._powers = np.repeat([[0.0], [1.0]], count, axis=1) if powers is None else powers
        self._columns = np.full(size, -1) if columns is None else columns

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._first)

    def _of(self, x: Array, order: int) -> Array:
        """Return the polynomials' derivatives of an order at a configuration `(k,)`."""
        powers = polynomial.polyder(self._powers, order, axis=0)
        return np.asarray(polynomial.polyval(self._first @ self._moved(x), powers, tensor=False))

    def _moved(self, x: Array) -> Array:
        return np.where(self._columns < 0, 0.0, x[self._columns])

    def at(self, x: Array) -> Array:
        """Return the rows `(k, nv)` at a configuration: what vanishes where couplings hold."""
        return np.asarray(self._of(x, 1)[:, None] * self._first - self._last)

    def gaps(self, x: Array) -> Array:
        """Return by how much they are off `(k,)`, as rows count it."""
        return np.asarray(np.dot(self._last, self._moved(x)) - self._of(x, 0))

    def drift(self, x: Array, v: Array) -> Array:
        """Return how fast the rows' products with constant rates change `(k,)`."""
        return np.asarray(self._of(x, 2) * (self._first @ v) ** 2)


class ClosedDirections:
    """Accelerations of a chain by the directions that its closed loops leave.

    Not for several threads at once: it has one set of Pinocchio's data.

    Attributes:
        model: `pin.Model` of the chain.
        free: velocity coordinates `(f,)` that are not prescribed.
        loop_rows: number of rows of the loops, the first ones.
    """

    def __init__(
        self,
        model: Any,
        constraints: Any,
        couplings: CouplingRows,
        prescribed: Array,
        rank: int,
        data: Any = None,
        lent: float = 0.0,
    ) -> None:
        """Make it.

        Args:
            model: `pin.Model` of the chain.
            constraints: Pinocchio's constraints that close its loops.
            couplings: its couplings.
            prescribed: velocity coordinates `(p,)` that are driven or held.
            rank: of the closure equations where loops are closed, along free coordinates.
            data: Pinocchio's, to work in with others, as it is great; its own if None.
            lent: inertia that every joint is lent where displacements are measured.
        """
        self.model, self._lent = model, lent
        self._data = self.model.createData() if data is None else data
        self._loops = [(item, item.createData()) for item in constraints]
        self._couplings = couplings
        self._prescribed, self._rank = prescribed, rank
        self.free = np.delete(np.arange(model.nv), prescribed)
        self.loop_rows = 6 * len(self._loops)

    def accelerations(self, x: Array, v: Array, efforts: Array, prescribed: Array) -> Array:
        """Return the accelerations `(nv,)` that efforts cause.

        Args:
            x: configuration, closed up to a small drift.
            v: velocities `(nv,)`.
            efforts: along all coordinates `(nv,)`.
            prescribed: accelerations of the prescribed coordinates `(p,)`.

        Raises:
            SingularConfigurationError: efforts push along a direction that moves no mass.
        """
        free, a, inertia = self.free, np.zeros(self.model.nv), self._inertia(x)
        resisting = pinocchio.nonLinearEffects(self.model, self._data, x, v)
        a[self._prescribed] = prescribed
        pushing = (efforts - resisting - inertia @ a)[free]
        if not np.all(np.isfinite(pushing)):
            # A step that was too long: the integration takes a shorter one.
            return np.full(self.model.nv, np.nan)
        rows = self.jacobian(x)
        solve = self._along_directions if self._lent else self._forced
        gains = -self._drift(x, v) - rows @ a
        a[free] = solve(inertia[np.ix_(free, free)], pushing, rows[:, free], gains)
        return a

    def _along_directions(self, inertia: Array, pushing: Array, rows: Array, gains: Array) -> Array:
        """Return accelerations `(f,)` that are sums of the directions which closures leave."""
        left, values, right = np.linalg.svd(rows)
        rank = min(self._rank, rank_of(values))
        a = right[:rank].T @ ((left[:, :rank].T @ gains) / values[:rank])
        ways = _graded(right[rank:].T, np.sqrt(np.abs(np.diag(inertia))))
        missing = pushing - inertia @ a
        own, terms = ways.T @ inertia @ ways, np.abs(ways.T) @ np.abs(missing)
        return np.asarray(a + ways @ _accelerated(own, ways.T @ missing, terms))

    def _forced(self, inertia: Array, pushing: Array, rows: Array, gains: Array) -> Array:
        """Return accelerations `(f,)` that follow from the forces which close loops.

        These do no work, however weak an equation is, where a direction between equations of very
        different strength keeps few digits.
        """
        try:
            inverse = np.linalg.inv(np.linalg.cholesky(inertia))
        except np.linalg.LinAlgError:
            # So far away that rounding decides the inertia: the step that looks there is too long.
            return np.full(len(pushing), np.nan)
        left, values, _ = np.linalg.svd(rows @ inverse.T, full_matrices=False)
        rank = min(self._rank, rank_of(values))
        left, values = left[:, :rank], values[:rank]
        forces, lacks, lacked = np.zeros(len(rows)), np.inf, np.inf
        while True:
            a = inverse.T @ (inverse @ (pushing + rows.T @ forces))
            missing = left.T @ (gains - rows @ a)
            lacked, lacks = lacks, float(np.max(np.abs(missing), initial=0.0))
            if not lacks < 0.5 * lacked:
                return np.asarray(a)
            forces += left @ (missing / values**2)

    def closed(self, x: Array, v: Array, *, strong_alone: bool = False) -> tuple[Array, Array]:
        """Return the nearest state with closed loops, in the metric of the kinetic energy.

        What is prescribed stays where it is, and keeps its speed. Close to a singular configuration
        the weak equation is told apart by its gap: rounding of it would be a displacement.

        Args:
            x: configuration, not far from closed.
            v: velocities `(nv,)`.
            strong_alone: whether the weakest equations are left out.
        """
        free = self.free
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(v)) and free.size):
            return x, v
        last = widest = np.inf
        while True:
            rows, (gaps, size) = self.jacobian(x), self.gaps(x)
            root = np.linalg.cholesky(self.metric(x))
            weighted = np.linalg.solve(root, rows[:, free].T).T
            left, values, right = np.linalg.svd(weighted, full_matrices=False)
            rank = min(self._rank, rank_of(values))
            if strong_alone:
                rank = _strong(values[: self._rank])
            missing = left[:, :rank].T @ gaps
            # What is rounding no step closes, and a weak equation would make a displacement of it.
            missing[np.abs(missing) <= 4.0 * EPS * size] = 0.0
            # Far away, one step of Newton's method may open what the next one closes.
            before, last, widest = last, widest, float(np.max(np.abs(missing), initial=0.0))
            if not 0.0 < widest < before:
                break
            x = self._moved(x, np.linalg.solve(root.T, right[:rank].T @ (missing / values[:rank])))
        refuse_open(widest / size)
        opening = left[:, :rank].T @ (rows @ v)
        v = v.copy()
        v[free] -= np.linalg.solve(root.T, right[:rank].T @ (opening / values[:rank]))
        return x, v

    def rounding(self, x: Array) -> float:
        """Return which part of the speeds rounding decides at a configuration.

        A gap by rounding moves weak joints by its inverse, and turns by that the direction in which
        they may go.
        """
        if not self._rank:
            return 0.0
        values = self.singular_values(x)
        least = max(float(values[self._rank - 1]), NOTHING * float(values[0]))
        return float(EPS * (values[0] / least) ** 2)

    def singular_gap(self, x: Array) -> float:
        """Return the greatest closure error in the singular configuration near one.

        There what the weak equations are off by is stationary along all directions that the strong
        ones leave.
        """
        free = self.free
        longest = np.inf
        # Newton's method, until the next step would be rounding, or leads nowhere.
        while longest > np.sqrt(EPS):
            x, _ = self.closed(x, np.zeros(self.model.nv), strong_alone=True)
            rows = self.jacobian(x)[:, free]
            root = np.linalg.cholesky(self.metric(x))
            left, values, right = np.linalg.svd(np.linalg.solve(root, rows.T).T)
            rank = self._rank
            strong = _strong(values[:rank])
            weak = left[:, strong:rank]
            ways = np.linalg.solve(root.T, right[strong:].T)
            stationary = weak.T @ rows @ ways
            units = 1.0 / np.maximum(np.max(np.abs(ways), axis=0), 1e-300)
            beside = [self._moved(x, ways @ way) for way in displacements(units)]
            moved = np.array([weak.T @ self.jacobian(at)[:, free] @ ways for at in beside])
            bends = slopes(moved, units).reshape(stationary.size, -1)
            factors, *_ = np.linalg.lstsq(bends, -stationary.ravel(), rcond=1e-8)
            step = ways @ factors
            before, longest = longest, float(np.max(np.abs(step)))
            if not longest < before:
                break
            x = self._moved(x, step)
        x, _ = self.closed(x, np.zeros(self.model.nv), strong_alone=True)
        return float(np.max(np.abs(self.gaps(x)[0]), initial=0.0))

    def _moved(self, x: Array, step: Array) -> Array:
        """Return the configuration after a displacement `(f,)` of the free coordinates."""
        every = np.zeros(self.model.nv)
        every[self.free] = step
        return np.asarray(pinocchio.integrate(self.model, x, every))

    def gaps(self, x: Array) -> tuple[Array, float]:
        """Return closure errors of loops and couplings as the rows count them, and their sizes."""
        size, gaps = 1.0, np.empty(self.loop_rows + len(self._couplings))
        self._place(x)
        for index, (_, ends) in enumerate(self._loops):
            gaps[6 * index : 6 * index + 6] = pinocchio.log6(ends.c1Mc2).vector
            size = max(size, float(np.max(np.abs(ends.oMc1.translation))))
        gaps[self.loop_rows :] = self._couplings.gaps(x)
        return gaps, size

    def _inertia(self, x: Array) -> Array:
        """Return the inertia matrix `(nv, nv)`."""
        return np.array(pinocchio.crba(self.model, self._data, x))

    def metric(self, x: Array) -> Array:
        """Return the inertia matrix `(f, f)` along free coordinates, with what joints are lent."""
        free = self.free
        return np.asarray(self._inertia(x)[np.ix_(free, free)] + self._lent * np.eye(free.size))

    def rank(self, x: Array) -> int:
        """Return the rank of the closure equations along free coordinates at a configuration."""
        return rank_of(self.singular_values(x))

    def singular_values(self, x: Array) -> Array:
        """Return those of the closure equations along free coordinates at a configuration."""
        return np.asarray(np.linalg.svd(self.jacobian(x)[:, self.free], compute_uv=False))

    def jacobian(self, x: Array) -> Array:
        """Return the rows `(6 L + k, nv)` of loops and couplings at a configuration."""
        self._place(x)
        rows = [
            pinocchio.getConstraintJacobian(self.model, self._data, *loop) for loop in self._loops
        ]
        return np.concatenate([*rows, self._couplings.at(x)])

    def _place(self, x: Array) -> None:
        """Place all bodies, and on them the ends of loops."""
        pinocchio.computeJointJacobians(self.model, self._data, x)
        for loop, ends in self._loops:
            loop.calc(self.model, self._data, ends)

    def _drift(self, x: Array, v: Array) -> Array:
        """Return how fast the rows' products with constant rates change, `(6 L + k,)`."""
        model, data = self.model, self._data
        pinocchio.forwardKinematics(model, data, x, v, np.zeros(model.nv))
        result = np.empty(self.loop_rows + len(self._couplings))
        result[self.loop_rows :] = self._couplings.drift(x, v)
        for index, (loop, ends) in enumerate(self._loops):
            loop.calc(model, data, ends)
            first, second = (
                (place.actInv(data.v[joint]), place.actInv(data.a[joint]))
                for joint, place in (
                    (loop.joint1_id, loop.joint1_placement),
                    (loop.joint2_id, loop.joint2_placement),
                )
            )
            rate, change = (ends.c1Mc2.act(part) for part in second)
            # The second body's rate is seen in axes that move with the first.
            result[6 * index : 6 * index + 6] = (first[1] - change + first[0].cross(rate)).vector
        return result


def refuse_open(error: float) -> None:
    """Refuse what some steps of Newton's method have not closed.

    Args:
        error: that is left, of positions [rad, or a fraction of the length] or relative of speeds.

    Raises:
        SingularConfigurationError: it is more than rounding.
    """
    if not error <= CLOSURE_TOLERANCE:
        raise SingularConfigurationError(
            f"the loops opened so far within one step that closing them leaves {error:.1e}; the "
            "mechanism is close to a singular configuration, or the tolerance is too wide: give a "
            "smaller rtol"
        )


def rank_of(values: Array) -> int:
    """Return how many singular values `(n,)`, in any order, are not zero."""
    return int(np.count_nonzero(values > NOTHING * np.max(values, initial=0.0)))


def _strong(values: Array) -> int:
    """Return how many singular values, descending, come before their greatest fall."""
    if len(values) < 2:
        return 0
    return 1 + int(np.argmax(values[:-1] / np.maximum(values[1:], 1e-300)))


def _graded(ways: Array, weights: Array) -> Array:
    """Return directions `(n, d)` of the same space, each of which moves one coordinate by itself.

    Coordinates with much inertia come first: so what moves little mass is not mixed with what moves
    much, of which rounding would hide it.

    Args:
        ways: orthonormal directions `(n, d)`.
        weights: of the coordinates `(n,)`.
    """
    from scipy.linalg import qr  # Few chains need it.

    if not ways.size:
        return ways
    weights = weights + 1e-8 * (np.max(weights, initial=0.0) or 1.0)
    _, order = qr((ways * weights[:, None]).T, mode="r", pivoting=True, check_finite=False)
    chosen = order[: ways.shape[1]]
    return np.asarray(np.linalg.solve(ways[chosen].T, ways.T).T)


def _accelerated(inertia: Array, efforts: Array, terms: Array) -> Array:
    """Return the accelerations `(d,)` along directions; none along those that nothing pushes."""
    own = np.diag(inertia)
    heavy = own > EPS * np.max(own, initial=0.0)
    root = np.sqrt(np.where(heavy, own, 1.0))
    values, axes = np.linalg.eigh(
        np.where(np.outer(heavy, heavy), inertia, 0.0) / root[:, None] / root
    )
    scaled, sizes = axes.T @ (efforts / root), np.abs(axes.T) @ (terms / root)
    moves = values > ROUNDED
    pushed = ~moves & (np.abs(scaled) > NOTHING * sizes)
    if np.any(pushed):
        raise SingularConfigurationError(
            "efforts push along a direction in which nothing that moves has mass, or less than "
            f"{EPS:.1g} of the greatest, so that its acceleration has no limit; give the links "
            "that move there an inertia, or hold or prescribe a joint that they move"
        )
    scaled = np.where(moves, scaled / np.where(moves, values, 1.0), 0.0)
    return np.asarray(axes @ scaled / root)
