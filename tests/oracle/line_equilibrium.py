"""Drive lines by the equilibrium of all their bodies in motion, each cut free.

Shafts, their two pieces where there is a spline, and crosses are bodies; contacts pass on what
their freedoms leave. Nothing is taken from the package but the data of a line, directions and
centres. Forces come back after half a turn, so that positions over this half determine them.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from testkit.line_statics import meeting, pins

from cardan_dyn.drive_lines import DriveLine
from cardan_dyn.practice.drive_lines.line.supports import supports

Array = np.ndarray
Key = tuple[str, str]
FALL = np.array([0.0, 0.0, -9.81])


def derivative(values: Array) -> Array:
    """Derivative by the rotation of what comes back after half a turn, by its Fourier series."""
    waves = np.fft.rfft(values, axis=0)
    order = 2j * np.arange(len(waves)).reshape(-1, *[1] * (values.ndim - 1))
    return np.fft.irfft(order * waves, n=len(values), axis=0)


class Equilibrium:
    """Forces of a line at equal steps of half a turn of its input shaft.

    Attributes:
        count: number of positions.
        is_decided: whether the balances of all bodies decide all forces.
        slides: shafts whose splines have friction.
    """

    def __init__(self, line: DriveLine, count: int = 96) -> None:
        self.line, self.count = line, count
        self.axes, self.centres = line.geometry.directions, line.geometry.centres
        self._turn()
        self.bodies: list[tuple[str, int, int]] = []
        self.columns: list[tuple[Key, list[tuple[int, Array, Array, Array]]]] = []
        self.slides = [k for k, s in enumerate(line.shafts) if s.spline and s.spline.friction]
        self._cut()
        size = 6 * len(self.bodies)
        matrix = np.zeros((count, size, len(self.columns)))
        for column, (_, acting) in enumerate(self.columns):
            for body, force, point, moment in acting:
                self._add(matrix[..., column], body, force, point, moment)
        self.matrix = matrix
        values = np.linalg.svd(matrix[0], compute_uv=False)
        self.is_decided = size == len(self.columns) and values[-1] > 1e-9 * values[0]
        self.inverse = np.linalg.inv(matrix) if self.is_decided else np.linalg.pinv(matrix)

    def _turn(self) -> None:
        """Turn all pins, and follow speeds over that of the input and their changes."""
        line, steps = self.line, np.arange(self.count) * (np.pi / self.count)
        found = [pins(line, float(position)) for position in steps]
        self.pins = [
            None
            if found[0][k] is None
            else tuple(np.stack([item[k][side] for item in found]) for side in (0, 1))
            for k in range(line.count)
        ]
        self.ratio = [np.ones(self.count)]
        for k, pair in enumerate(self.pins):
            ratio = self.ratio[-1]
            if pair is not None:
                normal = np.cross(*pair)
                ratio = ratio * (normal @ self.axes[k]) / (normal @ self.axes[k + 1])
            self.ratio.append(ratio)
        self.change = [derivative(ratio) for ratio in self.ratio]

    def _body(self, kind: str, index: int, piece: int = 0) -> int:
        return self.bodies.index((kind, index, piece))

    def _of_shaft(self, k: int, distance: float) -> tuple[int, Array]:
        """The piece of shaft k at a distance from its joint, and the point there."""
        if k == 0:
            return self._body("shaft", 0), self.centres[0] - distance * self.axes[0]
        behind = self.line.shafts[k].spline is not None and distance > self.cut[k]
        point = self.centres[k - 1] + distance * self.axes[k]
        return self._body("shaft", k, int(behind)), point

    def _cut(self) -> None:
        line, axes = self.line, self.axes
        lengths = line.geometry.lengths
        self.cut = {}
        for k, shaft in enumerate(line.shafts):
            self.bodies.append(("shaft", k, 0))
            if shaft.spline is not None:
                self.bodies.append(("shaft", k, 1))
                given = shaft.spline.distance
                self.cut[k] = float(lengths[k]) / 2 if given is None else given
        self.bodies += [("cross", k, 0) for k, pair in enumerate(self.pins) if pair is not None]
        space = np.eye(3)
        for k, pair in enumerate(self.pins):
            front = self._body("shaft", k, int(k in self.cut))
            rear, at, where = self._body("shaft", k + 1), self.centres[k], str(k)
            if pair is None:
                halves = axes[k] + axes[k + 1]
                for force in space:
                    self._contact(("force", where), front, rear, at, force=force)
                self._contact(("even", where), front, rear, at, moment=halves)
                continue
            cross = self._body("cross", k)
            for side, (one, two) in enumerate(((front, cross), (cross, rear))):
                for force in space:
                    self._contact(("force", where), one, two, at, force=force)
                pin = pair[side]
                across = [np.broadcast_to(axes[k + side], pin.shape), np.cross(axes[k + side], pin)]
                for moment in across:
                    self._contact((("in", "out")[side], where), one, two, at, moment=moment)
        for k in self.cut:
            one, two = self._body("shaft", k), self._body("shaft", k, 1)
            at, along = self.centres[k - 1] + self.cut[k] * axes[k], axes[k]
            for force in self._across(along):
                self._contact(("spline", str(k)), one, two, at, force=force)
            for moment in (along, *self._across(along)):
                self._contact(("spline", str(k)), one, two, at, moment=moment)
        for k in line.centred:
            at = meeting(line, k)
            one, two = (
                self._body("shaft", k - 1, int(k - 1 in self.cut)),
                self._body("shaft", k + 1),
            )
            # A disc that floats in the middle plane of the piece presses on both shafts within it.
            for force in self._across(axes[k]):
                self._contact(("centring", line.shaft_names[k]), one, two, at, force=force)
        self._bearings()
        self.columns.append((("drive", ""), [(0, np.zeros(3), self.centres[0], axes[0])]))

    def _bearings(self) -> None:
        line = self.line
        for end, name in ((0, "bearing_in"), (line.count, "bearing_out")):
            if not line.shafts[end].bearings:
                # A single bearing at the joint stands for two: it bears all but the torque.
                body, at = self._of_shaft(end, 0.0)
                for force in self._across(self.axes[end]):
                    self.columns.append((("across", name), [(body, force, at, np.zeros(3))]))
                    self.columns.append((("tilt", name), [(body, np.zeros(3), at, force)]))
                along = [(body, self.axes[end], at, np.zeros(3))]
                self.columns.append((("along", name), along))
        for item in supports(line).bearings:
            body, at = self._of_shaft(item.shaft, item.distance)
            for force in self._across(self.axes[item.shaft]):
                self.columns.append((("across", item.name), [(body, force, at, np.zeros(3))]))
            if item.locating:
                along = [(body, self.axes[item.shaft], at, np.zeros(3))]
                self.columns.append((("along", item.name), along))

    @staticmethod
    def _across(axis: Array) -> tuple[Array, Array]:
        left = np.cross([0.0, 0.0, 1.0], axis)
        left /= np.linalg.norm(left)
        return left, np.cross(axis, left)

    def _contact(
        self, key: Key, one: int, two: int, at: Array, *, force: Array = 0.0, moment: Array = 0.0
    ) -> None:
        """Add an unknown that one body exerts on the other one."""
        force, moment = np.zeros(3) + force, np.zeros(3) + moment
        self.columns.append((key, [(two, force, at, moment), (one, -force, at, -moment)]))

    def _add(self, rows: Array, body: int, force: Array, at: Array, moment: Array) -> None:
        """Add a wrench at a point to the balances of a body, about the world's origin."""
        rows[:, 6 * body : 6 * body + 3] += force
        rows[:, 6 * body + 3 : 6 * body + 6] += moment + np.cross(at, force)

    def parts(self) -> dict[str, Array]:
        """Unknowns per torque, square of speed, acceleration, weight, and push of a spline."""
        line, nothing = self.line, np.zeros(3)
        causes = {name: np.zeros((self.count, 6 * len(self.bodies))) for name in CAUSES}
        last = self._body("shaft", line.count)
        resisting = -(1.0 / self.ratio[-1])[:, None] * self.axes[-1]
        self._add(causes["torque"], last, nothing, self.centres[-1], resisting)
        for body, k, mass, inertia, at in self._masses():
            self._add(causes["weight"], body, mass * FALL, at, nothing)
            for name, change in (("speed", self.change), ("rate", self.ratio)):
                own = change[k] * (self.ratio[0] if name == "rate" else 1.0)
                moment = -(inertia * own)[:, None] * self.axes[k]
                self._add(causes[name], body, nothing, at, moment)
        for k, pair in enumerate(self.pins):
            joint = line.joints[k]
            if pair is None or not joint.cross_mass:
                continue
            body, at = self._body("cross", k), self.centres[k]
            self._add(causes["weight"], body, joint.cross_mass * FALL, at, nothing)
            momentum = self._momentum(k, *pair)
            self._add(causes["speed"], body, nothing, at, -derivative(momentum))
            self._add(causes["rate"], body, nothing, at, -momentum)
        for k in self.slides:
            own = np.zeros_like(causes["torque"])
            at = self.centres[k - 1] + self.cut[k] * self.axes[k]
            self._add(own, self._body("shaft", k, 1), -self.axes[k], at, nothing)
            self._add(own, self._body("shaft", k, 0), self.axes[k], at, nothing)
            causes[f"push {k}"] = own
        return {
            name: -np.einsum("pij,pj->pi", self.inverse, acting) for name, acting in causes.items()
        }

    def _masses(self) -> Iterable[tuple[int, int, float, float, Array]]:
        """Bodies of shafts: number, shaft, mass, moment of inertia, centre of mass."""
        lengths = self.line.geometry.lengths
        for k, shaft in enumerate(self.line.shafts):
            length, tube = float(lengths[k]), shaft.tube
            mass, inertia = shaft.mass, shaft.inertia
            if tube is not None:
                radii = tube.outer_diameter / 2, tube.outer_diameter / 2 - tube.wall
                area = np.pi * (radii[0] ** 2 - radii[1] ** 2)
                mass = tube.density * area * length if mass is None else mass
                own = mass * (radii[0] ** 2 + radii[1] ** 2) / 2
                inertia = own if inertia is None else inertia
            if not mass:
                continue
            middle = length / 2 if shaft.centre is None else shaft.centre
            pieces = [(0.0, length)] if k not in self.cut else [(0.0, self.cut[k])]
            pieces += [(self.cut[k], length)] if k in self.cut else []
            for piece, (start, end) in enumerate(pieces):
                share = (end - start) / length if k in self.cut else 1.0
                place = (start + end) / 2 if k in self.cut else middle
                at = self.centres[0] - place * self.axes[0]
                if k:
                    at = self.centres[k - 1] + place * self.axes[k]
                body = self._body("shaft", k, piece)
                yield body, k, mass * share, (inertia or 0.0) * share, at

    def _momentum(self, k: int, one: Array, two: Array) -> Array:
        """Angular momentum of a cross about its centre, per speed of the input."""
        before, behind = (self.ratio[i][:, None] * self.axes[i] for i in (k, k + 1))
        # The cross turns about its driving pin against the shaft before it: that turn is what is
        # left along this pin of the difference of both shafts, as the other pin is normal to it.
        turn = np.sum((behind - before) * one, axis=1, keepdims=True)
        spin, joint = before + turn * one, self.line.joints[k]
        rods = joint.cross_mass * joint.cross_span**2
        normal = np.cross(one, two)
        shares = ((one, rods / 24), (two, rods / 24), (normal, rods / 12))
        return sum(
            size * np.sum(spin * axis, axis=1, keepdims=True) * axis for axis, size in shares
        )

    def courses(self) -> dict[str, dict[Key, Array]]:
        """Vectors `(P, 3)` of all forces and moments of each part, finely over half a turn."""
        found = {}
        for name, unknowns in self.parts().items():
            own: dict[Key, Array] = {}
            for column, (key, acting) in enumerate(self.columns):
                size = unknowns[:, column, None]
                _, force, _, moment = acting[0]
                is_force = bool(np.any(force))
                full = key if key[0] in ("across", "along", "centring", "drive", "tilt") else (
                    f"{key[0]} {'force' if is_force else 'moment'}", key[1])  # fmt: skip
                own[full] = own.get(full, 0.0) + size * (force if is_force else moment)
            load = (1.0 / self.ratio[-1])[:, None] * self.axes[-1] * (name == "torque")
            own["load", ""] = load
            found[name] = {key: finely(values) for key, values in own.items()}
        return found


CAUSES = ("torque", "speed", "rate", "weight")
_FINER = 16


def finely(values: Array) -> Array:
    """The course at so many times as many positions, by its Fourier series."""
    count = len(values)
    return np.fft.irfft(np.fft.rfft(values, axis=0), n=_FINER * count, axis=0) * _FINER
