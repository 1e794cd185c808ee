"""Periodic motions of small systems over speed, past folds, by collocation and arclength.

Systems are those of `shooting`, made by a function of the speed; here they take all nodes of a
period at a time, `phi` `(N,)` with `q` and `rate` `(n, N)`. Nothing here knows the package under
test.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from shooting import Acceleration

Array = np.ndarray
System = Callable[[float], Acceleration]
_STEP = 1e-30
"""Complex step."""
_FINE = 24
"""Places between two neighbours of an extremum, whose parabola then tells."""


@dataclass(frozen=True)
class Curve:
    """Motions along a branch.

    Attributes:
        speed: `(P,)`.
        q: `(P, n, N)` at the nodes of a period.
        period: in the rotation of the drive.
    """

    speed: Array
    q: Array
    period: float

    def order(self, number: float) -> Array:
        """Return complex amplitudes `(P, n)` of an order of the drive's rotation."""
        wave = round(number * self.period / (2.0 * np.pi))
        count = self.q.shape[-1]
        return 2.0 * np.fft.rfft(self.q, axis=-1)[..., wave] / count

    @property
    def folds(self) -> list[int]:
        """Where speed turns back."""
        steps = np.sign(np.diff(self.speed))
        return (np.nonzero(steps[1:] * steps[:-1] < 0.0)[0] + 1).tolist()


class Branch:
    """Solves R(q, Ω) = q'' - f(φ, q, q'; Ω) = 0 at all nodes."""

    def __init__(self, system: System, free: int, period: float, nodes: int, size: float) -> None:
        """Know the system.

        Args:
            system: of the speed.
            free: number of coordinates.
            period: in the rotation of the drive.
            nodes: odd.
            size: that motions have, in which their changes count.
        """
        self._system, self._free, self._period = system, free, period
        self._phi = period * np.arange(nodes) / nodes
        waves = 2.0j * np.pi / period * np.fft.fftfreq(nodes, 1.0 / nodes)
        spectrum = np.fft.fft(np.eye(nodes), axis=0)
        self._first = np.fft.ifft(waves[:, None] * spectrum, axis=0).real
        self._second = self._first @ self._first
        self._size = size

    def _residual(self, q: Array, speed: float) -> Array:
        rate = q @ self._first.T
        return q @ self._second.T - self._system(speed)(self._phi, q, rate)

    def _jacobian(self, q: Array, speed: float) -> Array:
        n, count = q.shape
        rate = q @ self._first.T
        right = self._system(speed)
        matrix = np.zeros((n, count, n, count))
        own = np.arange(count)
        for column in range(n):
            moved = q.astype(complex)
            moved[column] += 1j * _STEP
            by_place = right(self._phi, moved, rate.astype(complex)).imag / _STEP
            moved = rate.astype(complex)
            moved[column] += 1j * _STEP
            by_rate = right(self._phi, q.astype(complex), moved).imag / _STEP
            for row in range(n):
                block = -by_rate[row][:, None] * self._first
                block[own, own] -= by_place[row]
                matrix[row, :, column] = block + (self._second if row == column else 0.0)
        return matrix.reshape(n * count, n * count)

    def _by_speed(self, q: Array, speed: float) -> Array:
        step = 1e-5 * speed
        return (self._residual(q, speed + step) - self._residual(q, speed - step)) / (2.0 * step)

    def solved(self, q: Array, speed: float) -> Array:
        """Return the motion at a speed near a guess `(n, N)`."""
        for _ in range(40):
            change = np.linalg.solve(self._jacobian(q, speed), -self._residual(q, speed).ravel())
            q = q + change.reshape(q.shape)
            if np.max(np.abs(change)) <= 1e-13 * max(1e-3 * self._size, np.max(np.abs(q))):
                return q
        raise RuntimeError(f"no motion near the guess at {speed}")

    def _across(self, q: Array, speed: float, way: Array, scale: Array) -> Array | None:
        """Return the point `(n N + 1,)` on the plane through a guess across a way."""
        point = np.append(q.ravel(), speed)
        for _ in range(10):
            q, speed = point[:-1].reshape(self._free, -1), float(point[-1])
            matrix = np.zeros((point.size, point.size))
            matrix[:-1, :-1] = self._jacobian(q, speed)
            matrix[:-1, -1] = self._by_speed(q, speed)
            matrix[-1] = way / scale**2
            change = np.linalg.solve(matrix, np.append(-self._residual(q, speed).ravel(), 0.0))
            point = point + change
            if np.max(np.abs(change / scale)) <= 1e-11:
                return point
        return None

    def follow(self, first: float, last: float, step: float = 0.02) -> Curve:
        """Return the branch from the motion at one speed, from rest, to another."""
        count = len(self._phi)
        scale = np.append(np.full(self._free * count, self._size * np.sqrt(count)), last - first)
        scale = np.abs(scale)
        begin = self.solved(np.zeros((self._free, count)), first)
        near = first + 1e-4 * (last - first)
        point = np.append(begin.ravel(), first)
        way = np.append(self.solved(begin, near).ravel(), near) - point
        points, length = [point], step
        while (points[-1][-1] - last) * (last - first) < 0.0:
            point, ahead = points[-1], way / np.linalg.norm(way / scale)
            guess = point + length * ahead
            found = self._across(guess[:-1].reshape(self._free, -1), float(guess[-1]), way, scale)
            gap = np.inf if found is None else np.linalg.norm((found - guess) / scale)
            if gap > 0.1 * length:
                length /= 2.0
                if length < 1e-6 * step:
                    raise RuntimeError(f"the branch is lost at {point[-1]}")
                continue
            way = found - point
            points.append(found)
            length = min(step, 1.5 * length)
            if len(points) > 20_000:
                raise RuntimeError("the branch does not end")
        every = np.array(points)
        q = every[:, :-1].reshape(len(every), self._free, count)
        return Curve(every[:, -1], q, self._period)

    def extremum(
        self, curve: Curve, index: int, value: Callable[[Curve], Array]
    ) -> tuple[float, float]:
        """Return speed and value `(P,)` of the greatest beside an inner point of a curve."""
        ends = [np.append(curve.q[at].ravel(), curve.speed[at]) for at in (index - 1, index + 1)]
        way = ends[1] - ends[0]
        count = len(self._phi)
        size = np.full(self._free * count, self._size * np.sqrt(count))
        scale = np.append(size, abs(curve.speed[-1] - curve.speed[0]))
        found = []
        for share in np.linspace(0.0, 1.0, _FINE + 1):
            guess = ends[0] + share * way
            point = self._across(guess[:-1].reshape(self._free, -1), float(guess[-1]), way, scale)
            if point is None:
                raise RuntimeError("no motion across the branch")
            found.append(point)
        every = np.array(found)
        fine = Curve(every[:, -1], every[:, :-1].reshape(-1, self._free, count), curve.period)
        values = value(fine)
        top = int(np.clip(np.argmax(values), 2, _FINE - 2))
        part = slice(top - 2, top + 3)
        ways = np.arange(-2.0, 3.0)
        shape, speeds = np.polyfit(ways, values[part], 4), np.polyfit(ways, fine.speed[part], 4)
        roots = np.roots(np.polyder(shape))
        real = roots[np.abs(roots.imag) < 1e-6].real
        at = float(real[np.argmin(np.abs(real))])
        return float(np.polyval(speeds, at)), float(np.polyval(shape, at))
