"""Modes of the linear equation with its mean coefficients, and how they whirl."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....core.elements.link_motions import LinkMotions
from ....kit.arrays import EPS, NOTHING, ROUNDED, Array
from ....kit.periodic import nodes
from .efforts import with_drive
from .motion_equation import LocalEquation
from .rotating_scene import RotatingScene

_TURNS = 1e-3
"""Speed of a link [rad/s per rad/s of the drive] below which it does not turn."""
_PLANAR = 0.1
"""Sense below which an ellipse is so thin that its mode counts as swinging in a plane."""


class Modes(NamedTuple):
    """Modes of S linear equations of n coordinates, by ascending frequency.

    Attributes:
        value: complex eigenvalues `(S, n)` [1/s], imaginary part not negative: those that swing,
            then real ones, of which the greater of each coordinate's pair is kept.
        shape: complex mode shapes `(S, n, n)`, a column for each, greatest entry 1.
    """

    value: Array
    shape: Array

    @property
    def frequency(self) -> Array:
        """Natural angular frequencies, damped `(S, n)` [rad/s]; 0 where a mode does not swing."""
        return np.asarray(self.value.imag)

    @property
    def log_decrement(self) -> Array:
        """Logarithm of the ratio of two swings that follow each other `(S, n)`."""
        swings = self.frequency > 0.0
        frequency = np.where(swings, self.frequency, 1.0)
        return np.where(swings, -2.0 * np.pi * self.value.real / frequency, np.nan)

    @property
    def amplification(self) -> Array:
        """Amplification factor Q = 1/(2ζ) `(S, n)`; infinite without damping, NaN for creeping."""
        size = np.abs(self.value)
        is_damped = -self.value.real > ROUNDED * size
        factor = size / np.where(is_damped, -2.0 * self.value.real, 1.0)
        # A real eigenvalue alone says nothing of ζ, for which the other one of its pair is needed.
        swings = self.frequency > 0.0
        return np.where(swings, np.where(is_damped, factor, np.inf), np.nan)


def averaged(equation: LocalEquation) -> tuple[Array, Array, Array]:
    """Return mass, damping and stiffness `(S, n, n)` of S motions, averaged over their period."""
    return tuple(
        np.mean(item, axis=1) for item in (equation.mass, equation.damping, equation.stiffness)
    )


def modes(mass: Array, damping: Array, stiffness: Array) -> Modes:
    """Return the modes of M ẍ + D ẋ + K x = 0, by the eigenvalues of its first-order form.

    Args:
        mass: M `(S, n, n)`, regular.
        damping: D, likewise.
        stiffness: K, likewise.
    """
    count, free, _ = mass.shape
    matrix = np.zeros((count, 2 * free, 2 * free))
    matrix[:, :free, free:] = np.eye(free)
    matrix[:, free:, :free] = -np.linalg.solve(mass, stiffness)
    matrix[:, free:, free:] = -np.linalg.solve(mass, damping)
    values, vectors = np.linalg.eig(matrix)
    size = np.abs(values)
    # One mode may be faster than another by far: rounding is that of the fastest, and as many
    # times as the matrix has entries.
    none = NOTHING * size + EPS * matrix[0].size * np.max(size, axis=1, keepdims=True)
    is_real = np.abs(values.imag) <= none
    # Of each complex pair the upper one, of each real pair the greater: there λ² M + λ D + K rises.
    x = vectors[:, :free]
    rise = 2.0 * values[:, None, :] * (mass @ x) + damping @ x
    is_greater = np.sum(x.conj() * rise, axis=1).real > 0.0
    rank = np.where(is_real, np.where(is_greater, 1.0, 2.0), np.where(values.imag > 0.0, 0.0, 3.0))
    key = np.where(is_real, -values.real, values.imag)
    order = np.lexsort((key, rank), axis=1)[:, :free]
    chosen = np.take_along_axis(values, order, axis=1)
    real = np.take_along_axis(is_real, order, axis=1)
    chosen = np.where(real, chosen.real + 0.0j, chosen)
    shapes = np.take_along_axis(vectors[:, :free], order[:, None, :], axis=2)
    largest = np.argmax(np.abs(shapes), axis=1)[:, None, :]
    return Modes(chosen, shapes / np.take_along_axis(shapes, largest, axis=1))


class WhirlSense:
    """Says how the modes of a rotating scene whirl.

    A mode moves each link's centre along an ellipse, and so does the tip of its small rotation.
    The areas of these ellipses, seen along the axis about which the link turns with the drive,
    are weighed with mass and with moment of inertia. Links that do not turn count for nothing.
    """

    def __init__(self, rotating: RotatingScene, q: Array, sense: float, count: int) -> None:
        """Look at how links move.

        Args:
            rotating: the scene.
            q: `(n,)` positions of the free coordinates.
            sense: +1 or -1, in which the drive turns.
            count: number of drive positions over a period at which ellipses are looked at.
        """
        mechanism, free = rotating.scene.mechanism, len(rotating.free)
        bodies = {body: name for name, (body, _) in mechanism.links.items() if body}
        links = LinkMotions(mechanism, bodies.values())
        places = with_drive(nodes(count, rotating.period), np.repeat(q[None], count, axis=0))
        scene = rotating.driven
        # All joints, whatever the outputs are: links are placed by their motion.
        if scene.outputs != tuple(scene.mechanism.joints):
            scene = scene.replace(outputs=None)
        units = np.repeat(np.eye(1 + free), count, axis=0)
        motion = scene.sweep(np.tile(places, (1 + free, 1)), units).motion
        found = links.at(np.asarray(motion.x), np.asarray(motion.v))
        inertias = [mechanism.model.inertias[body] for body in bodies]
        moved = [
            (found[name].spin, found[name].velocity, found[name].rotation @ of.lever)
            for name, of in zip(bodies.values(), inertias, strict=True)
        ]
        # By coordinates, the drive first, by links, positions and axes.
        shape = 1 + free, count, 3
        spin, velocity, arms = (
            np.stack([np.broadcast_to(of, (len(units), 3)).reshape(shape) for of in item], axis=1)
            for item in zip(*moved, strict=True)
        )
        arm = arms[0]
        size = np.linalg.norm(spin[0], axis=-1, keepdims=True)
        axis = np.where(size > _TURNS, sense * spin[0] / np.maximum(size, _TURNS), 0.0)
        weights = [[np.trace(of.inertia) / 3.0, of.mass] for of in inertias]
        ways = np.stack([spin[1:], velocity[1:] + np.cross(spin[1:], arm)])
        ways *= np.sqrt(np.array(weights, dtype=float).T[:, None, :, None, None] / count)
        # The part of the swing along the link's own axis is no whirl. Housings have no sense of
        # rotation of their own, however heavy they are.
        across = ways - np.sum(ways * axis, axis=-1, keepdims=True) * axis
        across *= np.any(axis, axis=-1, keepdims=True)
        whole, rows = (np.moveaxis(item, 1, -1).reshape(-1, free) for item in (ways, across))
        # Squares of R x lose nothing where motions of several coordinates cancel.
        self._whole = np.linalg.qr(whole)[1]
        basis, self._across = np.linalg.qr(rows)
        turned = np.cross(axis[..., None], basis.reshape(2, *axis.shape, free), axis=-2)
        # Of e = a + i b, the axis times a × (-b), twice: -i e* · (axis × e).
        self._around = -1j * basis.T @ turned.reshape(-1, free)

    def of(self, shapes: Array) -> Array:
        """Return the sense `(..., m)` of mode shapes `(..., n, m)`.

        It is from -1, backward, to +1, forward.
        """
        forward, size, whole = (
            np.diagonal(form, axis1=-2, axis2=-1).real for form in self._forms(shapes)
        )
        is_there = size > ROUNDED**2 * whole
        return np.where(is_there, forward / np.where(is_there, size, 1.0), 0.0)

    def parted(self, value: Array, shapes: Array) -> Array:
        """Return mode shapes of which those of one frequency whirl apart, forward and backward.

        Where eigenvalues coincide, as those of a disc between equal springs, any combination of
        their shapes is a mode, and what an order excites is shared out among them by chance. Of
        those that whirl most, an unbalance excites one alone.

        Args:
            value: eigenvalues `(n,)` [1/s].
            shapes: mode shapes `(n, n)`, a column for each.
        """
        result = shapes.copy()
        for first, number in enumerate(value.tolist()):
            (group,) = np.nonzero(np.abs(value - number) <= NOTHING * abs(number))
            if group[0] < first or len(group) == 1 or not number.imag > 0.0:
                continue
            basis = shapes[:, group]
            forward, size, whole = self._forms(basis)
            least = np.linalg.eigvalsh(size)[0]
            if not least > ROUNDED**2 * np.trace(whole).real:
                continue  # Not all of them move anything across its axis of rotation.
            inverse = np.linalg.inv(np.linalg.cholesky(size))
            senses, ways = np.linalg.eigh(inverse @ forward @ inverse.conj().T)
            if np.max(np.abs(senses)) < _PLANAR:
                continue
            found = basis @ (inverse.conj().T @ ways)
            largest = np.argmax(np.abs(found), axis=0)
            result[:, group] = found / found[largest, np.arange(len(group))]
        return result

    def _forms(self, shapes: Array) -> tuple[Array, Array, Array]:
        """Return Hermitian forms `(…, m, m)` of combinations of shapes `(…, n, m)`.

        Returns:
            areas of the ellipses in the sense of rotation; squares of their axes, so that the sense
            is the first by the second; and squares of all motion, along the axes of rotation and
            of links that do not turn as well.
        """
        ends, whole = self._across @ shapes, self._whole @ shapes
        adjoint = np.swapaxes(ends.conj(), -1, -2)
        of_whole = np.swapaxes(whole.conj(), -1, -2) @ whole
        return adjoint @ self._around @ ends, adjoint @ ends, of_whole


def sense_name(sense: float) -> str:
    """Return the word for a sense: `forward`, `backward`, or `planar`; none for NaN."""
    if np.isnan(sense):
        return ""
    return {-1.0: "backward", 0.0: "planar", 1.0: "forward"}[float(clear_senses(np.array(sense)))]


def clear_senses(senses: Array) -> Array:
    """Return +1 for forward, -1 for backward, 0 for planar, of senses of any shape."""
    return np.where(np.abs(senses) < _PLANAR, 0.0, np.sign(senses))
