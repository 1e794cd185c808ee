"""Critical bending speeds by makers' constants, lengths they allow, and lines of shafts as beams.

`shaft_design.critical_speed` is the single beam on rigid supports. SI units; all arguments
broadcast, but those of `line_bending`, which takes one line.

References:
    AE-7 p. 267; Elbe and Dana catalogues; S. Timoshenko: Vibration Problems in Engineering.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._checks import FloatArray, not_negative, positive, refuse, same_shape
from .shaft_design import critical_speed

__all__ = [
    "LineBearing",
    "LineBending",
    "critical_speed_by_constant",
    "elastic_bearing_factor",
    "greatest_length",
    "line_bending",
    "on_elastic_bearing",
]

_ELEMENTS = 16
"""Elements of each shaft: the first critical speed is then 2e-6 of it too high."""
_LOOSE = 1e-10
"""Pivot of the stiffness relative to its diagonal at which a line is not held: rounding is 1e-12,
and a bearing as soft as this would hold nothing."""


class LineBearing(NamedTuple):
    """A bearing of a line: index of its shaft, place from that shaft's front [m], stiffness [N/m].

    An infinite stiffness is a rigid bearing.
    """

    shaft: int
    distance: float
    stiffness: float


class LineBending(NamedTuple):
    """Critical speeds of a line of m shafts, and where the energy of its modes lies.

    Attributes:
        speeds: `(q,)` critical speeds, the lowest first [rad/s].
        kinetic: `(q, m)` shares of the shafts in the kinetic energy; the joints have the rest.
        strain: `(q, m)` shares of the shafts in the strain energy; springs have the rest. A mode
            whose energy lies in springs is that of rigid shafts that bounce.
    """

    speeds: FloatArray
    kinetic: FloatArray
    strain: FloatArray

    @property
    def speed(self) -> float:
        """The lowest critical speed [rad/s]."""
        return float(self.speeds[0])


_BISECTIONS = 60
"""Halvings of (0, pi): beyond the digits of a float."""


def critical_speed_by_constant(
    outer_diameter: ArrayLike, inner_diameter: ArrayLike, length: ArrayLike, constant: ArrayLike
) -> FloatArray:
    """First critical bending speed by a maker's constant, omega = C sqrt(D^2 + d^2) / L^2.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L between the joints [m], greater than 0.
        constant: C [rad m/s], greater than 0; `limits.CRITICAL_CONSTANTS` has those of makers.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        AE-7 p. 267, Elbe, IMS, which differ in C.

    >>> from cardan_dyn.analytic.limits import CRITICAL_CONSTANTS
    >>> tube = np.array([3.5, 3.26, 60.0]) * 0.0254
    >>> speed = critical_speed_by_constant(*tube, CRITICAL_CONSTANTS["ae_7"].value)
    >>> round(float(speed * 30 / np.pi))
    6251
    """
    length, constant = positive("length", length), positive("constant", constant)
    size = _size(outer_diameter, inner_diameter, length=length, constant=constant)
    return constant * size / length**2


def greatest_length(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    speed: ArrayLike,
    constant: ArrayLike,
    share: ArrayLike = 0.75,
) -> FloatArray:
    """Greatest length at which a speed is this share of the critical one.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        speed: greatest speed of rotation [rad/s], greater than 0.
        constant: C [rad m/s], greater than 0, as in `critical_speed_by_constant`.
        share: of the critical speed, greater than 0.

    Returns:
        L = sqrt(share C sqrt(D^2 + d^2) / omega) [m], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        Inverse of `critical_speed_by_constant`; shares as in `limits.LIMITS`.
    """
    speed, constant = positive("speed", speed), positive("constant", constant)
    share = positive("share", share)
    size = _size(outer_diameter, inner_diameter, speed=speed, constant=constant, share=share)
    return np.sqrt(share * constant * size / speed)


def elastic_bearing_factor(softness: ArrayLike) -> FloatArray:
    """Critical speed of a tube with one end on an elastic bearing, over that with rigid ends.

    With z^4 = mu omega^2 L^4 / (E I), the boundary conditions (no moment at either end, the
    bearing's force at one) give z^3 (coth z - cot z) = 2 k L^3 / (E I); the factor is (z / pi)^2.

    Args:
        softness: E I / (k L^3), stiffness of the beam over that of the bearing, not negative; 0 is
            rigid.

    Returns:
        The factor, at most 1, in the shape of `softness`. For a soft bearing it tends to the rod
        that swings about the other end, sqrt(3 / softness) / pi^2.

    Raises:
        ValueError: an argument out of range.

    Source:
        Euler-Bernoulli beam; Dana states that elastic bearings lower the critical speed. The
        bearing carries no mass of its own here.
    """
    softness = not_negative("softness", softness)
    low, high = np.zeros_like(softness), np.full_like(softness, np.pi)
    # The left side rises from 0 at z = 0 to infinity at pi.
    for _ in range(_BISECTIONS):
        z = (low + high) / 2.0
        below = softness * _bearing_number(z) < 1.0
        low, high = np.where(below, z, low), np.where(below, high, z)
    z = np.where(softness == 0.0, np.pi, np.where(np.isnan(softness), np.nan, (low + high) / 2.0))
    return ((z / np.pi) ** 2)[()]


def on_elastic_bearing(
    outer_diameter: ArrayLike,
    inner_diameter: ArrayLike,
    length: ArrayLike,
    stiffness: ArrayLike,
    modulus: ArrayLike = 2.1e11,
    density: ArrayLike = 7850.0,
) -> FloatArray:
    """First critical bending speed of a tube with one end on an elastic centre bearing.

    Args:
        outer_diameter: D [m], greater than 0.
        inner_diameter: d [m], 0 <= d < D.
        length: L from the joint to the bearing [m], greater than 0.
        stiffness: k of the bearing and its bracket across the shaft [N/m], greater than 0.
        modulus: Young's modulus E [Pa], greater than 0.
        density: rho [kg/m^3], greater than 0.

    Returns:
        omega [rad/s], in the broadcast shape.

    Raises:
        ValueError: an argument out of range or shapes that do not match.

    Source:
        `shaft_design.critical_speed` and `elastic_bearing_factor`.
    """
    stiffness = positive("stiffness", stiffness)
    rigid = critical_speed(outer_diameter, inner_diameter, length, modulus, density)
    same_shape(shaft=rigid, stiffness=stiffness)
    outer, inner, length, modulus = (
        np.asarray(value, dtype=float)
        for value in (outer_diameter, inner_diameter, length, modulus)
    )
    bending = modulus * (np.pi / 64.0) * (outer - inner) * (outer + inner) * (outer**2 + inner**2)
    return rigid * elastic_bearing_factor(bending / (stiffness * length**3))


def line_bending(
    lengths: ArrayLike,
    rigidities: ArrayLike,
    line_masses: ArrayLike,
    joint_masses: ArrayLike,
    ends: ArrayLike = np.inf,
    bearings: Sequence[LineBearing] = (),
    elements: int = _ELEMENTS,
) -> LineBending:
    """Critical bending speeds of shafts in a row with joints between them.

    Shafts are Euler-Bernoulli beams, joints are hinges with a point mass. The first and the last
    joint stand on the end shafts, and centre bearings anywhere on the shafts; all shafts bend
    together. Supports are alike in all directions, so that the critical speed is the natural
    frequency at rest.

    Args:
        lengths: `(m,)` of the shafts between their joints [m], greater than 0.
        rigidities: `(m,)` E I [N m^2], greater than 0.
        line_masses: `(m,)` mass per length [kg/m], greater than 0.
        joint_masses: `(m + 1,)` of the joints [kg], not negative.
        ends: `(2,)` or one stiffness of both supports at the first and the last joint [N/m]; 0 is
            free, infinite is rigid.
        bearings: on the shafts.
        elements: of each shaft; between bearings there is one at least.

    Returns:
        As many speeds as the elements have displacements; those of long waves are exact, see
        `elements`.

    Raises:
        ValueError: an argument out of range, shapes that do not match, or a line that is not held.

    Source:
        Finite elements with cubic deflection and consistent mass. Shear, and the gyroscopic moment
        of discs, do not count: they are 1 % at a length of 10 diameters.

    >>> found = line_bending([1.5], [1e5], [8.0], [0.0, 0.0])
    >>> round(found.speed / float((np.pi / 1.5) ** 2 * np.sqrt(1e5 / 8.0)), 5)
    1.0
    """
    size, bend, heavy = (
        np.atleast_1d(positive(name, value))
        for name, value in (
            ("lengths", lengths),
            ("rigidities", rigidities),
            ("line_masses", line_masses),
        )
    )
    shape = same_shape(lengths=size, rigidities=bend, line_masses=heavy)
    size, bend, heavy = (np.broadcast_to(value, shape) for value in (size, bend, heavy))
    count = shape[0]
    for item in bearings:
        inside = 0 <= item.shaft < count and 0.0 <= item.distance <= size[item.shaft]
        if not (inside and item.stiffness > 0.0):
            raise ValueError(
                f"bearing = {item} is not in the valid range: on one of {count} shafts, within its "
                "length, with a stiffness in (0, inf]"
            )
    points = np.broadcast_to(not_negative("joint_masses", joint_masses), (count + 1,))
    held = np.array(np.broadcast_to(np.asarray(ends, dtype=float), (2,)))
    refuse("ends", held, ~(held >= 0.0), "[0, inf]")
    # Displacements of the joints come first; then, shaft by shaft, all others.
    springs = {0: held[0], count: held[1]}
    total = count + 1
    parts: list[tuple[list[int], FloatArray, int]] = []
    for k in range(count):
        of_shaft = [item for item in bearings if item.shaft == k]
        places = _mesh(float(size[k]), [item.distance for item in of_shaft], elements)
        nodes = len(places)
        inner = list(range(total, total + nodes - 2))
        slopes = list(range(total + nodes - 2, total + 2 * nodes - 2))
        total += 2 * nodes - 2
        shift = [k, *inner, k + 1]
        parts.append(([i for pair in zip(shift, slopes, strict=True) for i in pair], places, k))
        for item in of_shaft:
            at = shift[int(np.argmin(np.abs(places - item.distance)))]
            springs[at] = springs.get(at, 0.0) + item.stiffness
    bends, masses = np.zeros((2, count, total, total))
    for index, places, k in parts:
        for e, step in enumerate(np.diff(places)):
            block = np.ix_(index[2 * e : 2 * e + 4], index[2 * e : 2 * e + 4])
            bends[k][block] += bend[k] * _element_bending(step)
            masses[k][block] += heavy[k] * _element_mass(step)
    fixed = [i for i, value in springs.items() if np.isinf(value)]
    stiff = np.zeros(total)
    stiff[list(springs)] = [0.0 if np.isinf(value) else value for value in springs.values()]
    keep = np.setdiff1d(np.arange(total), fixed)
    free = np.ix_(np.arange(count), keep, keep)
    bends, masses = bends[free], masses[free]
    K, M = bends.sum(axis=0) + np.diag(stiff[keep]), masses.sum(axis=0)
    M[np.diag_indices(len(keep))] += np.append(points, np.zeros(total - count - 1))[keep]
    modes, inverse_squares = _modes(K, M)
    kinetic, strain = (np.sum(modes * (of @ modes), axis=1).T for of in (masses, bends))
    in_springs = stiff[keep] @ modes**2
    return LineBending(
        1.0 / np.sqrt(inverse_squares),
        kinetic / np.sum(modes * (M @ modes), axis=0)[:, None],
        strain / (strain.sum(axis=1) + in_springs)[:, None],
    )


def _mesh(length: float, places: Sequence[float], elements: int) -> FloatArray:
    """Places of the nodes of a shaft, with all bearings among them."""
    stops = np.unique([0.0, length, *places])
    counts = np.maximum(np.rint(elements * np.diff(stops) / length), 1).astype(int)
    steps = [
        np.linspace(start, end, number, endpoint=False)
        for start, end, number in zip(stops[:-1], stops[1:], counts, strict=True)
    ]
    return np.append(np.concatenate(steps), length)


def _element_bending(h: float) -> FloatArray:
    rows = [
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h],
    ]
    return np.array(rows) / h**3


def _element_mass(h: float) -> FloatArray:
    rows = [
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
    ]
    return np.array(rows) * (h / 420.0)


def _modes(K: FloatArray, M: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Modes in columns and 1 / omega^2, the lowest frequency first, from M x = K x / omega^2.

    The greatest eigenvalues of the flexible side keep the digits that stiff springs would take.
    """
    scale = 1.0 / np.sqrt(np.diag(K))
    try:
        root = np.linalg.cholesky(K * scale * scale[:, None])
    except np.linalg.LinAlgError:
        root = np.zeros_like(K)
    if np.min(np.diag(root)) ** 2 <= _LOOSE:
        raise ValueError(
            "bearings of the line do not hold it across its axis: valid is a line whose joints all "
            "stand on supports or on shafts that are held at two places"
        )
    back = np.linalg.solve(root, np.diag(scale))
    values, vectors = np.linalg.eigh(back @ M @ back.T)
    return (back.T @ vectors)[:, ::-1], values[::-1]


def _bearing_number(z: FloatArray) -> FloatArray:
    """z^3 (coth z - cot z) / 2, by its series for small z, where the difference cancels."""
    small = np.minimum(z, 0.05)
    # coth z - cot z = 2 (z/3 + 2 z^5/945 + ...)
    series = small**4 / 3.0 * (1.0 + 2.0 * small**4 / 315.0)
    large = np.maximum(z, 0.05)
    return np.where(z < 0.05, series, large**3 * (1.0 / np.tanh(large) - 1.0 / np.tan(large)) / 2.0)


def _size(outer_diameter: ArrayLike, inner_diameter: ArrayLike, **others: FloatArray) -> FloatArray:
    """Root of D^2 + d^2, checked."""
    outer = positive("outer_diameter", outer_diameter)
    inner = not_negative("inner_diameter", inner_diameter)
    same_shape(outer_diameter=outer, inner_diameter=inner, **others)
    full, wide = np.broadcast_arrays(inner, outer)
    refuse("inner_diameter", full, full >= wide, "[0, outer_diameter)")
    return np.hypot(outer, inner)
