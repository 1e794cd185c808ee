"""Build of a reduced model: its samples, how many nodes and which degrees it needs, its error."""

from __future__ import annotations

import numpy as np

from ....kit.arrays import ROUNDED, Array, generic
from ....kit.errors import AccuracyError, ArgumentError, ModelError
from ....kit.periodic import (
    MOST_NODES,
    amplitudes,
    interpolation,
    next_size,
    nodes,
    resampled,
    tail,
)
from .efforts import FreeEfforts, Terms
from .polynomials import polynomials, size_of
from .reduced_model import ReducedModel
from .rotating_scene import RotatingScene

_GOOD_ERROR = 1e-10
"""Error from which on rounding may be what is left, so that higher degrees bring nothing."""
_LINE_DEGREES = (6, 20, 44, 92)
"""Degrees that are tried along a line, whose Chebyshev coefficients tell which one is enough."""
_PART, _STUCK = 8, 2
"""Degrees of several coordinates together rise by one such part of them, at least by 1, until so
many steps have brought nothing."""
_LOW = 2
"""Degree up to which it is worth looking whether a coordinate acts alone."""
_FALLS, _CAREFUL, _MOST_HIGHER = 1e-2, 0.95, 1.5
"""Error of polynomials from which on it tells how much higher degrees have to be, as a part of what
it tells, and how much higher at most."""
_MOST_POLYNOMIALS = 1000
"""More polynomials would take minutes to be sampled."""
_CHECKS = 24
"""Places of the range at which polynomials are compared with the terms, and positions of the drive
between the nodes at which a model is."""
FINE = 1e-13
"""Error of the terms at which the polynomials have converged."""
ROUGH = 1e-5
"""Error of a rough model, in which motions are searched."""
WORST_ERROR = 1e-9
"""Error of the terms with which no model but a rough one is returned."""
_MOST_EXCESS = 300.0
"""By how much the error of a model may exceed what was wanted."""
_PROBES = 3
"""Points of the range at which waves along the drive's position are looked at, its middle first."""
_WAVES, _MORE = 127, 1.4
"""Nodes over the mechanism's period with which the search begins; and with which later ones do, as
a multiple of what others took."""
_MASSLESS = 1e-14
"""Share of the mass matrix that is rounding."""


class TermSamples:
    """Samples the terms of the efforts of one rotating scene, as columns.

    Attributes:
        rotating: the scene.
        efforts: of its free coordinates.
        free: their number n.
    """

    def __init__(self, rotating: RotatingScene) -> None:
        self.rotating, self.efforts = rotating, FreeEfforts(rotating)
        self.free = len(rotating.free)

    def at(self, drive: Array, q: Array) -> Array:
        """Return terms `(N, F)` at drive positions `(N,)` and free coordinates `(N, n)`."""
        return self.efforts.terms(np.column_stack([drive, q])).flat()

    def about(self, drive: Array, centre: Array, ways: Array) -> Array:
        """Return terms `(K, P, F)` at drive positions `(K,)`, at ways `(P, n)` from `(K, n)`."""
        q = (centre[:, None] + ways).reshape(-1, self.free)
        return self.at(np.repeat(drive, len(ways)), q).reshape(len(drive), len(ways), -1)

    def kinds(self, values: Array) -> Array:
        """Return the greatest of each kind of terms, as columns `(F,)`, of terms `(..., F)`."""
        terms = Terms.of_flat(values.reshape(-1, values.shape[-1]), self.free)
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
        mass = Terms.of_flat(columns, self.free).mass
        least = np.max(mass, axis=1)
        floor = Terms(
            np.broadcast_to(least[:, None], mass.shape)[None],
            np.broadcast_to(least[:, None, None], scales.quadratic.shape[1:])[None],
            np.full((1, *scales.linear.shape[1:]), 1e-300),
            np.full((1, self.free), 1e-300),
        )
        return np.maximum(columns, floor.flat()[0])


def needed_degrees(
    samples: TermSamples, drive: Array, centre: Array, half: Array, wanted: float
) -> tuple[tuple[int, ...], float]:
    """Return degrees in each free coordinate, and the error that they leave.

    Args:
        samples: of the terms.
        drive: some positions of the drive `(K,)`.
        centre: middles of the ranges there `(K, n)`.
        half: half widths of the ranges `(n,)`.
        wanted: error at which degrees are enough; if it cannot be had, the least is returned.
    """
    single, error = _along(samples, drive, centre, half, wanted)
    if len(half) == 1:
        return single, error
    inside = generic(_CHECKS, len(half))
    exact, alone = _alone(samples, drive, centre, half, np.array(single) <= _LOW, wanted)
    kinds = samples.kinds(exact)
    # Points of lower degrees are among those of higher ones.
    known: dict[tuple[int, ...], Array] = {}
    degrees, best, least, stuck = single, single, np.inf, 0
    while size_of(degrees) <= _MOST_POLYNOMIALS:
        basis = polynomials(degrees)
        new = [row for row, power in enumerate(basis.names) if power not in known]
        sampled = samples.about(drive, centre, half * basis.nodes[new])
        known |= zip((basis.names[row] for row in new), np.moveaxis(sampled, 1, 0), strict=True)
        terms = np.stack([known[power] for power in basis.names], axis=1)
        found = basis.values(inside).T @ basis.coefficients(terms)
        error = float(np.max(np.abs(found - exact) / kinds))
        # Rounding does not fall any more.
        stuck = stuck + 1 if error > 0.5 * least and least < _GOOD_ERROR else 0
        if error < least:
            best, least = degrees, error
        if error <= wanted or stuck == _STUCK:
            break
        degrees = _higher(degrees, alone, error, wanted)
    return best, least


def _higher(degrees: tuple[int, ...], alone: Array, error: float, wanted: float) -> tuple[int, ...]:
    """Return degrees above others, but of coordinates that are alone.

    Errors fall with a power of the degrees, so that one says how many it takes; there is at least a
    step.
    """
    together = [degree for degree, is_alone in zip(degrees, alone, strict=True) if not is_alone]
    if not together:
        return tuple(degree + 1 for degree in degrees)
    most = max(together)
    needed = np.log(wanted) / np.log(error) if error < _FALLS else 1.0
    factor = max(1.0 + max(1, most // _PART) / most, min(_CAREFUL * needed, _MOST_HIGHER))
    return tuple(
        degree if is_alone else max(int(np.ceil(factor * degree - 1e-9)), min(degree + 1, 2))
        for degree, is_alone in zip(degrees, alone, strict=True)
    )


def _alone(
    samples: TermSamples, drive: Array, centre: Array, half: Array, asked: Array, wanted: float
) -> tuple[Array, Array]:
    """Return terms at the places of checks, and of which coordinates they depend alike everywhere.

    Returns:
        terms `(K, C, F)`, and of which of some coordinates `(n,)` terms depend alike wherever the
        others are.
    """
    count, places = len(half), generic(_CHECKS, len(half))
    (indices,) = np.nonzero(asked)
    # Steps of one coordinate, with the others here and in the middle.
    own = np.eye(count)[indices][:, None] * places
    ways = np.concatenate([places, *(places - own), *own, np.zeros((1, count))])
    terms = samples.about(drive, centre, half * ways)
    parts = np.split(terms[:, :-1], 1 + 2 * len(indices), axis=1)
    here, found = parts[0], np.zeros(count, dtype=bool)
    for row, index in enumerate(indices.tolist()):
        without, there = parts[1 + row], parts[1 + len(indices) + row]
        gap = (here - without) - (there - terms[:, -1:])
        found[index] = np.max(np.abs(gap) / samples.kinds(terms)) <= max(wanted, ROUNDED)
    return here, found


def _along(
    samples: TermSamples, drive: Array, centre: Array, half: Array, wanted: float
) -> tuple[tuple[int, ...], float]:
    """Return degrees of the terms in each free coordinate, the others elsewhere, and the error."""
    count = len(half)
    degrees, least, left = np.ones(count, dtype=int), np.full(count, np.inf), list(range(count))
    for size in _LINE_DEGREES:
        if not left:
            break
        basis = polynomials((size,))
        places = np.concatenate([_line(drive, centre, half, index, basis.nodes) for index in left])
        drives = np.tile(np.repeat(drive, size + 1), len(left))
        every = samples.at(drives, places.reshape(-1, count))
        lines, left = every.reshape(len(left), len(drive), size + 1, -1), left.copy()
        for index, terms in zip(left.copy(), lines, strict=True):
            sizes = np.max(np.abs(basis.coefficients(terms / samples.kinds(terms))), axis=(0, 2))
            rounding = float(np.max(sizes[-max(2, size // 4) :]))
            if rounding > 0.1 * least[index] and least[index] < _GOOD_ERROR:
                left.remove(index)
                continue
            least[index] = rounding
            above = np.nonzero(sizes > max(0.3 * wanted, 2.0 * rounding))[0]
            degrees[index] = max(1, int(np.max(above, initial=0)))
            if rounding <= 0.3 * wanted:
                left.remove(index)
    return tuple(degrees.tolist()), float(np.max(least))


def _line(drive: Array, centre: Array, half: Array, index: int, nodes: Array) -> Array:
    """Return places `(K, P, n)` along one coordinate, the others elsewhere."""
    inside = generic(len(drive), len(half))
    inside[:, index] = 0.0
    return (centre + half * inside)[:, None] + nodes * (half * np.eye(len(half))[index])


class ModelBuild:
    """Builds reduced models of one rotating scene, for different ranges."""

    def __init__(self, rotating: RotatingScene) -> None:
        self._rotating = rotating
        self._samples = TermSamples(rotating)
        self.efforts = self._samples.efforts
        self._free = len(rotating.free)
        self._checked_period = False
        self._waves_known: float = _WAVES / _MORE

    def model(
        self, centre: Array, half: Array, divisor: int | None = None, wanted: float = FINE
    ) -> ReducedModel:
        """Return the model within ranges of the free coordinates.

        Args:
            centre: middle of the ranges `(n,)`.
            half: their half width `(n,)`.
            divisor: how many periods of the terms are in that of the mechanism, 1 or 2; found
                if None.
            wanted: error of the terms.

        Raises:
            AccuracyError: the terms are too uneven.
            ArgumentError: they do not repeat.
            ModelError: nothing that has mass moves with a free coordinate.
            CardanError: as `Scene.sweep`.
        """
        count, found = self._waves(centre, half, wanted)
        divisor = found if divisor is None else min(divisor, found)
        middle = np.tile(centre, (next_size(count / divisor), 1))
        degrees, _ = self._degrees(middle, half, divisor, wanted)
        model = self._built(middle, half, degrees, divisor)
        self._refuse_uneven(middle, half, degrees, model.error, wanted)
        return model

    def along(self, q: Array, half: Array, divisor: int) -> ReducedModel:
        """Return the model within ranges about a motion.

        Args:
            q: the motion `(N, n)` at the nodes of a period of the terms.
            half: half width of the ranges `(n,)`.
            divisor: how many periods of the terms are in that of the mechanism.

        Raises:
            AccuracyError: the terms are too uneven.
            CardanError: as `Scene.sweep`.
        """
        degrees, left = self._degrees(q, half, divisor, FINE)
        while True:
            model = self._built(q, half, degrees, divisor)
            # No number of nodes takes away what the degrees leave.
            if model.error <= max(ROUNDED, 2.0 * left) or len(q) == MOST_NODES:
                break
            q = resampled(q, next_size(len(q) + 1))
        self._refuse_uneven(q, half, degrees, model.error, FINE)
        return model

    def _degrees(
        self, centre: Array, half: Array, divisor: int, wanted: float
    ) -> tuple[tuple[int, ...], float]:
        """Return degrees for terms about places `(N, n)` at a period's nodes, and their error."""
        period = self._rotating.period / divisor
        # A few drive positions tell the degree.
        drive = period * (0.5 + 0.5 * generic(_PROBES, 1)[:, 0])
        middle = interpolation(drive, len(centre), period) @ centre
        degrees, error = needed_degrees(self._samples, drive, middle, half, wanted)
        self._refuse_uneven(centre, half, degrees, error, wanted)
        return degrees, error

    def _refuse_uneven(
        self, centre: Array, half: Array, degrees: tuple[int, ...], error: float, wanted: float
    ) -> None:
        """Refuse polynomials whose error is too large."""
        worst = max(WORST_ERROR, _MOST_EXCESS * wanted)
        if error <= worst:
            return
        found = f"polynomials of degrees {degrees} leave an error of {error:.1e}"
        if error == np.inf:
            found = f"they would take {size_of(degrees)} polynomials, more than are tried"
        raise AccuracyError(
            f"within ±{half.tolist()} of {np.mean(centre, axis=0).tolist()}, the efforts of "
            f"{', '.join(self._rotating.free)} are no smooth functions of the free coordinates, "
            f"or of too many: {found}. Look for smaller motions, by `max_amplitude`, or let fewer "
            "be free: hold the stiffest at zero",
            residual=error,
            tolerance=worst,
        )

    def _waves(self, centre: Array, half: Array, wanted: float) -> tuple[int, int]:
        """Return how many nodes the mechanism's period needs, and how many periods it holds."""
        inside = generic(_PROBES, self._free)
        inside[0] = 0.0
        # Other ranges take hardly more nodes than known ones.
        count, period = next_size(_MORE * self._waves_known), self._rotating.period
        while True:
            drive = nodes(count, period)
            q = np.repeat(centre + half * inside, count, axis=0)
            terms = self._samples.at(np.tile(drive, _PROBES), q)
            kinds = self._samples.kinds(terms)
            values = (terms / kinds).reshape(_PROBES, count, -1)
            if not self._checked_period:
                _refuse_massless(self._rotating, Terms.of_flat(terms, self._free).mass)
                self._refuse_unperiodic(drive[:_PROBES], centre, values[0], kinds)
            if float(np.max(tail(values, 1) * np.max(np.abs(values), axis=1))) <= 10.0 * wanted:
                break
            if count >= MOST_NODES:
                raise AccuracyError(
                    f"{count} positions of {self._rotating.drive} do not resolve the efforts of "
                    f"{', '.join(self._rotating.free)} over its period",
                )
            count = next_size(count + 1)
        sizes = np.max(np.abs(amplitudes(values, 1)), axis=(0, 2))
        odd = float(np.max(sizes[1::2], initial=0.0))
        needed = int(np.max(np.nonzero(sizes > 0.1 * wanted)[0], initial=0))
        if wanted <= FINE:
            self._waves_known = min(self._waves_known, 2 * needed + 5)
        return 2 * needed + 5, 2 if odd <= ROUNDED else 1

    def _refuse_unperiodic(self, drive: Array, centre: Array, values: Array, kinds: Array) -> None:
        """Refuse terms that differ after a period.

        Args:
            drive: some positions.
            centre: of the free coordinates.
            values: terms at these positions first, in units of `kinds`.
            kinds: greatest terms.
        """
        q = np.repeat(centre[None], len(drive), axis=0)
        later = self._samples.at(drive + self._rotating.period, q) / kinds
        gap = float(np.max(np.abs(later - values[: len(drive)])))
        if gap > 1e-8:
            raise ArgumentError(
                f"after a period of {self._rotating.drive}, {self._rotating.period:g} rad, the "
                f"efforts of {', '.join(self._rotating.free)} differ by {gap:.1e} of their size, "
                "so that there is no periodic motion; does a spring wind up on a coordinate that "
                "turns on and on?"
            )
        self._checked_period = True

    def _built(
        self, centre: Array, half: Array, degrees: tuple[int, ...], divisor: int
    ) -> ReducedModel:
        """Return a model with its error; see `model`.

        Args:
            centre: of the ranges `(N, n)`.
            half: of the ranges.
            degrees: of the polynomials.
            divisor: number of periods.
        """
        basis = polynomials(degrees)
        period = self._rotating.period / divisor
        # Positions of the drive between the nodes, and free coordinates there, tell the error.
        spread = generic(_CHECKS, 1 + self._free)
        position, inside = 0.5 * period * (1.0 + spread[:, 0]), spread[:, 1:]
        weights = interpolation(position, len(centre), period)
        drive = np.repeat(nodes(len(centre), period), len(basis.nodes))
        q = (centre[:, None] + half * basis.nodes).reshape(-1, self._free)
        every = self._samples.at(
            np.concatenate([drive, position]),
            np.concatenate([q, weights @ centre + half * inside]),
        )
        terms, exact = np.split(every, [len(drive)])
        coefficients = basis.coefficients(terms.reshape(len(centre), len(basis.nodes), -1))
        values = basis.values(inside)
        found = np.einsum("kn,npf,pk->kf", weights, coefficients, values, optimize=True)
        error = float(np.max(np.abs(found - exact) / self._samples.kinds(exact)))
        return ReducedModel(self._free, period, divisor, centre, half, basis, coefficients, error)


def _refuse_massless(rotating: RotatingScene, mass: Array) -> None:
    """Refuse free coordinates, or ways in which several move together, that move no mass.

    Args:
        rotating: the scene.
        mass: M at some positions `(K, n, n)`.
    """
    scaled = mass * np.outer(rotating.units, rotating.units)
    own = np.diagonal(scaled, axis1=1, axis2=2)
    light = np.min(own, axis=0) <= _MASSLESS * np.max(own)
    advice = (
        "what has no mass does not vibrate, but follows its springs at once. Give the links that "
        "move mass and inertia, or hold a coordinate instead of letting it free"
    )
    if np.any(light):
        named = " and ".join(
            repr(name) for name, is_light in zip(rotating.free, light, strict=True) if is_light
        )
        raise ModelError(f"no mass moves with the free coordinate {named} alone: {advice}")
    size = np.sqrt(own)
    alike = scaled / (size[:, :, None] * size[:, None, :])
    if np.min(np.linalg.eigvalsh(alike)) <= _MASSLESS:
        raise ModelError(
            f"{', '.join(rotating.free)} can move together so that no mass moves: {advice}"
        )
