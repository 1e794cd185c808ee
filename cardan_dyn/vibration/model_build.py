"""Build of a reduced model: how many nodes and which degree it needs, and what its error is."""

from __future__ import annotations

import numpy as np

from ..arrays import Array, generic
from ..errors import AccuracyError, ArgumentError
from .efforts import FreeEfforts, Terms
from .periodic_grid import MOST_NODES, amplitudes, interpolation, next_size, nodes, tail
from .polynomials import polynomials, size_of
from .reduced_model import ReducedModel
from .rotating_scene import RotatingScene

_ERROR = 1e-13
"""Error of the terms at which the polynomials have converged."""
_WORST_ERROR = 1e-9
"""Error of the terms with which no model is returned."""
_GOOD_ERROR = 1e-10
"""Error from which on rounding may be what is left, so that higher degrees bring nothing."""
_LINE_DEGREES = (20, 44, 92)
"""Degrees that are tried along a line, whose Chebyshev coefficients tell which one is enough."""
_MOST_FACTOR = 2.0
"""By how much the degrees of several coordinates together may exceed those of each alone."""
_MOST_POLYNOMIALS = 300
"""More polynomials would take minutes to be sampled."""
_PROBES = 3
"""Points of the range at which waves along the drive's position are looked at, its middle first."""
_CHECKS = 24
"""Positions between the nodes at which a model is compared with its scene."""
_WAVES = 127
"""Nodes over the mechanism's period with which the search begins."""
_SILENT = 1e-12
"""Odd orders, as a fraction of the greatest term, that count as rounding."""


class ModelBuild:
    """Builds reduced models of one rotating scene, for different ranges."""

    def __init__(self, rotating: RotatingScene) -> None:
        self._rotating = rotating
        self.efforts = FreeEfforts(rotating)
        self._free = len(rotating.free)
        self._start = rotating.start
        self._checked_period = False

    def model(self, centre: Array, half: Array, divisor: int | None = None) -> ReducedModel:
        """Return the model within ranges of the free coordinates.

        Args:
            centre: middle of the ranges `(n,)`.
            half: their half width `(n,)`.
            divisor: how many periods of the terms are in that of the mechanism, 1 or 2; found
                if None.

        Raises:
            AccuracyError: the terms are too uneven.
            ArgumentError: they do not repeat.
            CardanError: as `Scene.sweep`.
        """
        count, found = self._waves(centre, half)
        divisor = found if divisor is None else min(divisor, found)
        period = self._rotating.period / divisor
        size = next_size(count / divisor)
        # A few drive positions tell the degree.
        drive = period * (0.5 + 0.5 * generic(_PROBES, 1)[:, 0])
        degrees, error = self._degrees(drive, centre, half)
        if error <= _WORST_ERROR:
            model = self._built(centre, half, size, degrees, divisor)
            error = model.error
        if error > _WORST_ERROR:
            raise AccuracyError(
                f"within ±{half.tolist()} of {centre.tolist()}, the efforts of "
                f"{', '.join(self._rotating.free)} are no smooth functions of the free "
                f"coordinates: polynomials of degrees {degrees} leave an error of "
                f"{error:.1e}",
                residual=error,
                tolerance=_WORST_ERROR,
            )
        return model

    def _terms(self, drive: Array, q: Array) -> Terms:
        """Return terms at drive positions `(N,)` and free coordinates `(N, n)`."""
        return self.efforts.terms(np.column_stack([drive, q]))

    def _kinds(self, values: Array) -> Array:
        """Return the greatest of each kind of terms, as columns `(F,)`."""
        terms = Terms.of_flat(values, self._free)
        # Speeds of the drive and of free coordinates differ in size: each has its own scale.
        scales = Terms(
            *(np.maximum(np.max(np.abs(item), axis=0, keepdims=True), 1e-300) for item in terms)
        )
        greatest = Terms(
            np.broadcast_to(np.max(scales.mass, axis=(2,), keepdims=True), scales.mass.shape),
            np.broadcast_to(
                np.max(scales.quadratic, axis=(2, 3), keepdims=True), scales.quadratic.shape
            ),
            np.broadcast_to(np.max(scales.linear, axis=2, keepdims=True), scales.linear.shape),
            scales.static,
        )
        columns = greatest.flat()[0]
        # What the mass matrix measures in is the least that velocity terms are compared with.
        mass = Terms.of_flat(columns, self._free).mass
        least = np.max(mass, axis=1)
        floor = Terms(
            np.broadcast_to(least[:, None], mass.shape)[None],
            np.broadcast_to(least[:, None, None], scales.quadratic.shape[1:])[None],
            np.full((1, *scales.linear.shape[1:]), 1e-300),
            np.full((1, self._free), 1e-300),
        )
        return np.maximum(columns, floor.flat()[0])

    def _waves(self, centre: Array, half: Array) -> tuple[int, int]:
        """Return how many nodes the mechanism's period needs, and how many periods it holds.

        Raises:
            AccuracyError: the terms are too uneven.
            ArgumentError: they do not repeat.
        """
        inside = generic(_PROBES, self._free)
        inside[0] = 0.0
        count, period = _WAVES, self._rotating.period
        while True:
            drive = nodes(count, period)
            q = np.repeat(centre + half * inside, count, axis=0)
            terms = self._terms(np.tile(drive, _PROBES), q).flat()
            kinds = self._kinds(terms)
            values = (terms / kinds).reshape(_PROBES, count, -1)
            if not self._checked_period:
                self._refuse_unperiodic(drive[:_PROBES], centre, values[0], kinds)
            if float(np.max(tail(values, 1) * np.max(np.abs(values), axis=1))) <= _ERROR * 10:
                break
            if count >= MOST_NODES:
                raise AccuracyError(
                    f"{count} positions of {self._rotating.drive} do not resolve the efforts of "
                    f"{', '.join(self._rotating.free)} over its period",
                )
            count = next_size(count + 1)
        sizes = np.max(np.abs(amplitudes(values, 1)), axis=(0, 2))
        odd = float(np.max(sizes[1::2], initial=0.0))
        needed = int(np.max(np.nonzero(sizes > 0.1 * _ERROR)[0], initial=0))
        return 2 * needed + 5, 2 if odd <= _SILENT else 1

    def _refuse_unperiodic(self, drive: Array, centre: Array, values: Array, kinds: Array) -> None:
        """Refuse terms that differ after a period.

        Args:
            drive: some positions.
            centre: of the free coordinates.
            values: terms at these positions first, in units of `kinds`.
            kinds: greatest terms.
        """
        q = np.repeat(centre[None], len(drive), axis=0)
        later = self._terms(drive + self._rotating.period, q).flat() / kinds
        gap = float(np.max(np.abs(later - values[: len(drive)])))
        if gap > 1e-8:
            raise ArgumentError(
                f"after a period of {self._rotating.drive}, {self._rotating.period:g} rad, the "
                f"efforts of {', '.join(self._rotating.free)} differ by {gap:.1e} of their size, "
                "so that there is no periodic motion; does a spring wind up on a coordinate that "
                "turns on and on?"
            )
        self._checked_period = True

    def _checks(self, centre: Array, half: Array, period: float) -> tuple[Array, Array]:
        """Return drive positions `(K,)` and free coordinates `(K, n)` between the nodes."""
        spread = generic(_CHECKS, 1 + self._free)
        return 0.5 * period * (1.0 + spread[:, 0]), centre + half * spread[:, 1:]

    def _degrees(self, drive: Array, centre: Array, half: Array) -> tuple[tuple[int, ...], float]:
        """Return degrees and error of the terms at drive positions `(K,)`."""
        lines = [self._along(drive, centre, half, index) for index in range(self._free)]
        single, error = tuple(degree for degree, _ in lines), max(error for _, error in lines)
        if self._free == 1 or error > _WORST_ERROR:
            return single, error
        factor, best, least = 1.0, single, np.inf
        while factor <= _MOST_FACTOR:
            degrees = tuple(int(np.ceil(factor * max(degree, 2))) for degree in single)
            if size_of(degrees) > _MOST_POLYNOMIALS:
                break
            error = self._error(drive, centre, half, degrees)
            is_rounding = error > 0.5 * least and least < _GOOD_ERROR
            if error < least:
                best, least = degrees, error
            if error <= _ERROR or is_rounding:
                break
            factor *= 1.25
        return best, least

    def _along(self, drive: Array, centre: Array, half: Array, index: int) -> tuple[int, float]:
        """Return degree and error of the terms in one free coordinate, the others elsewhere."""
        inside = generic(len(drive), self._free)
        inside[:, index] = 0.0
        way = half * np.eye(self._free)[index]
        degree, least = 1, np.inf
        for size in _LINE_DEGREES:
            basis = polynomials((size,))
            terms = self._on_lines(drive, centre + half * inside, way, basis.nodes)
            values = (terms / self._kinds(terms)).reshape(len(drive), len(basis.nodes), -1)
            sizes = np.max(np.abs(basis.coefficients(values)), axis=(0, 2))
            rounding = float(np.max(sizes[-(size // 4) :]))
            if rounding > 0.1 * least and least < _GOOD_ERROR:
                break
            least = rounding
            above = np.nonzero(sizes > max(0.3 * _ERROR, 2.0 * rounding))[0]
            degree = max(1, int(np.max(above, initial=0)))
            if rounding <= 0.3 * _ERROR:
                break
        return degree, least

    def _on_lines(self, drive: Array, middle: Array, way: Array, places: Array) -> Array:
        """Return terms `(K P, F)` at drive positions `(K,)`, at places `(P, 1)` on lines."""
        q = middle[:, None] + places * way
        return self._terms(np.repeat(drive, len(places)), q.reshape(-1, self._free)).flat()

    def _error(self, drive: Array, centre: Array, half: Array, degrees: tuple[int, ...]) -> float:
        """Return the error of polynomials of given degrees at drive positions `(K,)`."""
        inside = generic(_CHECKS, self._free)
        basis = polynomials(degrees)
        exact, terms = (
            self._terms(
                np.repeat(drive, len(places)), np.tile(centre + half * places, (len(drive), 1))
            ).flat()
            for places in (inside, basis.nodes)
        )
        coefficients = basis.coefficients(terms.reshape(len(drive), len(basis.nodes), -1))
        found = (basis.values(inside) @ coefficients).reshape(exact.shape)
        return float(np.max(np.abs(found - exact) / self._kinds(exact)))

    def _built(
        self, centre: Array, half: Array, size: int, degrees: tuple[int, ...], divisor: int
    ) -> ReducedModel:
        """Return a model of given size with its error; see `model`.

        Args:
            centre: of the ranges.
            half: of the ranges.
            size: number of nodes.
            degrees: of the polynomials.
            divisor: number of periods.
        """
        basis = polynomials(degrees)
        period = self._rotating.period / divisor
        places = centre + half * basis.nodes
        drive = np.repeat(nodes(size, period), len(places))
        terms = self._terms(drive, np.tile(places, (size, 1))).flat()
        coefficients = basis.coefficients(terms.reshape(size, len(places), -1))
        position, q = self._checks(centre, half, period)
        exact = self._terms(position, q).flat()
        weights = interpolation(position, size, period)
        values = basis.values((q - centre) / half)
        found = np.einsum("kn,npf,kp->kf", weights, coefficients, values, optimize=True)
        error = float(np.max(np.abs(found - exact) / self._kinds(exact)))
        return ReducedModel(self._free, period, divisor, centre, half, basis, coefficients, error)
