"""A universal joint with clearance in space: a free cross between two forks, by Newton and Euler.

Nothing here knows of the package. Fork 1 turns at constant speed about x, shaft 2 turns freely
about an axis at the angle beta in the plane z = 0, and the cross is a free body that touches both
forks in four bearings. A bearing is a bush of radial clearance, whose wall is a linear spring with
a damper, or it is tight: a stiff spring without clearance, whose damper has the same relaxation
time. Pins are held along their axes by such springs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

NAMES = ("pin_in+", "pin_in-", "pin_out+", "pin_out-")
OF, ENDS = [0, 0, 1, 1], np.array([[1.0], [-1.0], [1.0], [-1.0]])
"""Pin of each bearing, and its end of the pin."""
LEFT = 1e-10
"""Gap from which on a bearing counts as left [m]."""


@dataclass(frozen=True)
class CrossInSpace:
    """The rig.

    Attributes:
        beta: angle of the shafts [rad].
        speed: of shaft 1 [rad/s].
        inertia: of shaft 2 about its axis [kg m²].
        mass: of the cross [kg].
        cross_inertia: principal moments of the cross along pin 1, pin 2 and their normal [kg m²].
        radius: of all bearings [m].
        half_play: s of each bearing, in the order of `NAMES`; 0 is tight [m].
        stiffness: of a bearing with play [N/m].
        damping: of it [N s/m].
        tight: stiffness of a tight bearing, and of pins along their axes [N/m].
        load: torque on shaft 2 [N m].
    """

    beta: float
    speed: float
    inertia: float
    mass: float
    cross_inertia: tuple[float, float, float]
    radius: float
    half_clearance: tuple[float, float, float, float]
    stiffness: float
    damping: float
    tight: float = 1e9
    load: float = 0.0

    def forks(self, time: float, phi_2: float) -> tuple[np.ndarray, np.ndarray]:
        """Pins of both forks, unit vectors `(2, 3)`, and the axis of shaft 2."""
        phi_1 = self.speed * time
        sine, cosine = np.sin(self.beta), np.cos(self.beta)
        axis = np.array([cosine, sine, 0.0])
        across = np.array([-sine, cosine, 0.0])
        return np.array(
            [
                [0.0, np.cos(phi_1), np.sin(phi_1)],
                np.array([0.0, 0.0, np.cos(phi_2)]) - np.sin(phi_2) * across,
            ]
        ), axis

    def bearings(self, time: float, y: np.ndarray) -> tuple[np.ndarray, ...]:
        """Ways, rates `(4, 3)` of the cross in its bushes, arms on the cross, pins and axis."""
        pins, axis = self.forks(time, y[13])
        turn = rotation(y[3:7])
        spin = turn @ y[10:13]
        ends = ENDS * self.radius
        arms = ends * turn.T[OF]
        along = pins[OF]
        places = y[:3] + arms
        # Relative to the bush, in axes that turn with its fork.
        ways = places - ends * along
        rates = y[7:10] - arms @ skew(spin)
        rates[:2] += places[:2] @ skew(np.array([self.speed, 0.0, 0.0]))
        rates[2:] += places[2:] @ skew(y[14] * axis)
        ways = ways - along * np.sum(ways * along, axis=1, keepdims=True)
        rates = rates - along * np.sum(rates * along, axis=1, keepdims=True)
        return ways, rates, arms, pins, axis, turn

    def pressures(self, ways: np.ndarray, rates: np.ndarray) -> tuple[np.ndarray, ...]:
        """Forces `(4,)` of bushes with play, unclipped, depths, and directions `(4, 3)`."""
        sizes = np.linalg.norm(ways, axis=1)
        outward = ways / np.maximum(sizes, 1e-300)[:, None]
        closing = np.sum(rates * outward, axis=1)
        depth = sizes - np.array(self.half_clearance)
        return self.stiffness * depth + self.damping * closing, depth, outward

    def forces(self, time: float, y: np.ndarray) -> np.ndarray:
        """Forces of the bushes on the cross `(4, 3)`."""
        ways, rates, *_ = self.bearings(time, y)
        return self._forces(ways, rates)

    def _forces(self, ways: np.ndarray, rates: np.ndarray) -> np.ndarray:
        pressure, depth, outward = self.pressures(ways, rates)
        has_play = np.array(self.half_clearance) > 0.0
        free = -(np.maximum(pressure, 0.0) * (depth > 0.0))[:, None] * outward
        stuck = -self.tight * ways - self.tight * self.damping / self.stiffness * rates
        return np.where(has_play[:, None], free, stuck)

    def rates(self, time: float, y: np.ndarray) -> np.ndarray:
        """Newton and Euler for the cross, Euler for shaft 2 about its axis.

        `y` is the cross's place, quaternion (x, y, z, w), velocity, angular velocity in its own
        axes, and angle and speed of shaft 2.
        """
        ways, rates, arms, pins, axis, turn = self.bearings(time, y)
        forces = self._forces(ways, rates)
        total = forces.sum(axis=0)
        holding = self.tight * self.damping / self.stiffness
        for pin in pins:
            total = total - pin * (self.tight * (pin @ y[:3]) + holding * (pin @ y[7:10]))
        moment = moment_of(arms, forces)
        inertia, own = np.array(self.cross_inertia), y[10:13]
        # Bearings push on fork 2 where the cross is, so that both couples are equal.
        torque = -axis @ moment_of(y[:3] + arms[2:], forces[2:]) + self.load
        result = np.empty(15)
        result[:3] = y[7:10]
        result[3:7] = 0.5 * quaternion_rate(y[3:7], own)
        result[7:10] = total / self.mass
        result[10:13] = (turn.T @ moment + inertia * own @ skew(own)) / inertia
        result[13:] = y[14], torque / self.inertia
        return result

    def start(self, phi_1: float, moment: Callable[[float], float]) -> np.ndarray:
        """State at an angle of shaft 1 where the joint passes on a moment, springs following it.

        Each pin gives way by its play and by what its springs need; how fast, by differences.
        """
        step = 1e-5
        (before, earlier), (now, turn), (after, later) = (
            self._resting(phi, moment) for phi in (phi_1 - step, phi_1, phi_1 + step)
        )
        rate = self.speed / (2.0 * step)
        spin = turn.T @ (later - earlier) * rate
        y = np.zeros(15)
        y[3:7] = quaternion(turn)
        y[10:13] = 0.5 * np.array(
            [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]
        )
        y[13:] = now, (after - before) * rate
        return y

    def _resting(self, phi_1: float, moment: Callable[[float], float]) -> tuple[float, np.ndarray]:
        """Angle of shaft 2 and rotation of the cross, where a moment presses all bearings in."""
        phi_2 = np.arctan2(np.sin(phi_1), np.cos(self.beta) * np.cos(phi_1))
        pins, axis = self.forks(phi_1 / self.speed, phi_2)
        # Dampers let springs lag behind the force.
        force = moment(phi_1 - self.speed * self.damping / self.stiffness) / (2.0 * self.radius)
        gives = [
            np.sign(force) * clearance + force / (self.stiffness if clearance else self.tight)
            for clearance in (self.half_clearance[0], self.half_clearance[2])
        ]
        phi_2 -= sum(gives) / self.radius / (axis @ np.cross(*pins))
        # Both pins of the cross stand in the plane of the forks' pins, where nothing tilts it.
        pins, _ = self.forks(phi_1 / self.speed, phi_2)
        normal = np.cross(*pins)
        normal /= np.linalg.norm(normal)
        first = turned(-gives[0] / self.radius * normal) @ pins[0]
        return phi_2, np.array([first, np.cross(normal, first), normal]).T

    def run(
        self,
        phi_1: float,
        moment: Callable[[float], float],
        end: float,
        step: float = 4e-6,
        rtol: float = 1e-7,
    ) -> Run:
        """Simulate from one angle of shaft 1 to another, every contact located as an event."""
        time, y = phi_1 / self.speed, self.start(phi_1, moment)
        last = end / self.speed
        with_play = np.nonzero(np.array(self.half_clearance) > 0.0)[0]
        inside = self._depths(time, y) > 0.0
        times, states, found, touches = [], [], [], 0
        while time < last:
            part = solve_ivp(
                self.rates,
                (time, last),
                y,
                method="DOP853",
                rtol=rtol,
                atol=1e-4 * rtol,
                events=[self._event(index, bool(inside[index])) for index in with_play],
                dense_output=True,
                max_step=1e-4,
            )
            inner = np.linspace(time, part.t[-1], 2 + int((part.t[-1] - time) / step))
            for moment_in, state in zip(inner, part.sol(inner).T, strict=True):
                times.append(moment_in)
                states.append(state)
                found.append(self.forces(moment_in, state))
            time, y = float(part.t[-1]), part.y[:, -1].copy()
            y[3:7] /= np.linalg.norm(y[3:7])
            for index, hits in zip(with_play, part.t_events, strict=True):
                if len(hits):
                    inside[index] = not inside[index]
                    touches += int(inside[index])
        return Run(np.array(times), np.array(states), np.array(found), touches)

    def _depths(self, time: float, y: np.ndarray) -> np.ndarray:
        ways, rates, *_ = self.bearings(time, y)
        return self.pressures(ways, rates)[1]

    def _event(self, index: int, is_inside: bool) -> Callable[[float, np.ndarray], float]:
        """A touch, where the damper's force jumps; or that the next one can be looked for."""

        def event(time: float, y: np.ndarray) -> float:
            return float(self._depths(time, y)[index]) + (LEFT if is_inside else 0.0)

        event.terminal = True  # type: ignore[attr-defined]
        event.direction = -1.0 if is_inside else 1.0  # type: ignore[attr-defined]
        return event


@dataclass(frozen=True)
class Run:
    """What a simulation found.

    Attributes:
        time: `(N,)` [s].
        states: `(N, 15)`, see `CrossInSpace.rates`.
        forces: of the bushes on the cross `(N, 4, 3)` [N], in the order of `NAMES`.
        touches: how often a bearing with play was touched.
    """

    time: np.ndarray
    states: np.ndarray
    forces: np.ndarray
    touches: int


def skew(spin: np.ndarray) -> np.ndarray:
    """Matrix S of a vector ω, with v S = v × ω: rows of vectors at once, faster than NumPy's."""
    x, y, z = spin
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def moment_of(arms: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Sum of the cross products of rows."""
    k = arms.T @ forces
    return np.array([k[1, 2] - k[2, 1], k[2, 0] - k[0, 2], k[0, 1] - k[1, 0]])


def rotation(q: np.ndarray) -> np.ndarray:
    """Rotation matrix of a quaternion (x, y, z, w), whose length need not be quite one."""
    x, y, z, w = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(turn: np.ndarray) -> np.ndarray:
    """Quaternion (x, y, z, w) of a rotation matrix: the eigenvector of Bar-Itzhack's matrix."""
    k = np.empty((4, 4))
    k[:3, :3] = turn + turn.T - np.trace(turn) * np.eye(3)
    k[:3, 3] = k[3, :3] = [
        turn[2, 1] - turn[1, 2],
        turn[0, 2] - turn[2, 0],
        turn[1, 0] - turn[0, 1],
    ]
    k[3, 3] = np.trace(turn)
    return np.asarray(np.linalg.eigh(k)[1][:, -1])


def quaternion_rate(q: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Product of a quaternion and an angular velocity in the body's own axes."""
    x, y, z, w = q
    a, b, c = spin
    return np.array(
        [
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
            -x * a - y * b - z * c,
        ]
    )


def turned(vector: np.ndarray) -> np.ndarray:
    """Rotation matrix of a rotation vector."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    return rotation(np.append(vector / angle * np.sin(angle / 2), np.cos(angle / 2)))
