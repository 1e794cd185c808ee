"""Element loads: what springs, bushings and friction exert, computed once more for the proof.

Links are placed and moved by `Twists`, and each law is written in another way than where results
come from: directions as unit vectors, rotations by quaternions, moments of bushings by solving
with the left Jacobian of rotations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import EPS, Array, cross, inverse
from ...kit.errors import ArgumentError
from ..elements.bushing import Bushing
from ..elements.element import Element
from ..elements.joint_elements import Actuator, JointElement, JointFriction, JointSpring
from ..elements.law import Given, Law
from ..elements.pin_contact import PinContact
from ..elements.point_actuator import PointActuator
from ..elements.point_spring import COINCIDENT, PointSpring
from ..mechanism.frames import ElementaryMotion
from .named_motions import named_motions
from .placing import Fixed, Frame, constant, stacked
from .screws import NOTHING, Screw, Screws
from .vectors import combine

_WOUND = 3.1
"""Rotation [rad] beyond which a bushing turns about an axis that stays."""
_PARALLEL = 1e-5
"""Angle [rad] between axes that counts as none; of what differs, a rotation is by half a turn."""


class ElementLoads(NamedTuple):
    """What all elements exert.

    Attributes:
        efforts: `(nv, N)` along the joint coordinates [N·m, N].
        wrenches: per wrench the index of its body, and `(2, 3, N)` in world axes about
            `Frames.corner`; those on the world are left out.
        terms: `(N,)` size of the terms [N·m] whose differences the forces are.
    """

    efforts: Array
    wrenches: list[tuple[int, Array]]
    terms: Array


class _Moving(NamedTuple):
    """A frame that moves with a link, about `Frames.corner` in world axes.

    Attributes:
        body: index of its body, -1 for the world.
        axes: `(3, 3, N)`, the first index counts the axes.
        origin: `(3, N)` [m].
        velocity: `(3, N)` of the body's point at the corner [m/s].
        spin: `(3, N)` [rad/s].
    """

    body: int
    axes: Array
    origin: Array
    velocity: Array
    spin: Array

    def speed(self, point: Array) -> Array:
        """Return the velocity `(3, N)` of the link's point that is there."""
        return self.velocity + cross(self.spin, point)


class ProvenElements:
    """The elements of a scene on the frames of its description.

    Attributes:
        act_on_links: whether any does; others need no frames.
    """

    def __init__(self, screws: Screws, elements: Sequence[Element], zero: Array, length: float):
        """Find what the elements act on.

        Args:
            screws: of the description's joints.
            elements: the elements.
            zero: `(size,)` coordinates of the description's zero.
            length: characteristic length [m].
        """
        self._frames = frames = screws.frames
        self._placing, self._elements, self._length = screws.placing, elements, length
        self._zero = zero
        self._named: dict[str, ElementaryMotion] = {}
        if any(element.joints for element in elements):
            self._named = named_motions(frames)
        self._ends = {
            index: self._ends_of(element, zero)
            for index, element in enumerate(elements)
            if element.links
        }
        self.act_on_links = bool(self._ends)

    def on(
        self,
        placed: Sequence[Frame],
        velocities: Sequence[Screw] | None,
        x: Array,
        v: Array,
        time: Array,
    ) -> ElementLoads:
        """Return what the elements exert.

        Args:
            placed: frames of all motions, of arrays `(N,)`, where any acts on links.
            velocities: twists of the motions' frames; None at rest.
            x: `(N, size)` coordinates, whole turns counted.
            v: `(N, nv)` joint velocities.
            time: `(N,)` or `(1,)` [s].
        """
        efforts, terms = np.zeros((v.shape[1], len(x))), np.zeros(len(x))
        wrenches: list[tuple[int, Array]] = []
        for index, element in enumerate(self._elements):
            if isinstance(element, JointElement):
                motion = self._named[element.joint]
                unit = self._length if motion.kind == "slide" else 1.0
                effort, term = _effort(element, x[:, motion.column], v[:, motion.rate], time, unit)
                efforts[motion.rate] += effort
                terms += term * unit
                continue
            first, second = (
                self._placed(placed, velocities, link, placement, len(x))
                for link, placement in zip(element.links, self._ends[index], strict=True)
            )
            if isinstance(element, PointSpring):
                on_second, term = self._of_spring(element, first, second)
            elif isinstance(element, PointActuator):
                on_second, term = self._of_thrust(element, first, second, time)
            elif isinstance(element, PinContact):
                on_second, term = self._of_contact(element, first, second, time)
            elif isinstance(element, Bushing):
                on_second, term = self._of_bushing(element, first, second, placed, x)
            else:
                raise _unknown_law(element)
            terms += term
            wrenches += [
                (frame.body, sign * on_second)
                for frame, sign in ((first, -1.0), (second, 1.0))
                if frame.body >= 0
            ]
        return ElementLoads(efforts, wrenches, terms)

    def _ends_of(self, element: Element, zero: Array) -> tuple[Array, Array]:
        """Return the `(4, 4)` placements of both ends of an element in their links."""
        if isinstance(element, Bushing):
            return element.origin, self._end(element, zero)
        if not isinstance(element, (PointSpring, PointActuator, PinContact)):
            raise _unknown_law(element)
        first, second = np.eye(4), np.eye(4)
        first[:3, 3], second[:3, 3] = element.point_a, element.point_b
        return first, second

    def _placed(
        self,
        placed: Sequence[Frame],
        velocities: Sequence[Screw] | None,
        link: str,
        placement: Array,
        count: int,
    ) -> _Moving:
        """Return a frame of a link, by its `(4, 4)` placement there, at that many samples."""
        body, in_body = self._frames.link_frames[link]
        motion = self._frames.last[body] if body >= 0 else -1
        axes, origin = self._placing.at(placed, Fixed.of(motion, in_body @ placement))
        velocity, spin = NOTHING if body < 0 or velocities is None else velocities[motion]
        rows = stacked((*axes, origin, velocity, spin), count)
        return _Moving(body, rows[:3], *rows[3:])

    def _end(self, element: Bushing, zero: Array) -> Array:
        """Return the `(4, 4)` placement of a bushing's frame in `link_b`."""
        if element.origin_b is not None:
            return element.origin_b
        placed = self._placing.placed(zero.tolist())
        ends = []
        for link in element.links:
            frame = self._placed(placed, None, link, np.eye(4), 1)
            end = np.eye(4)
            end[:3, :3], end[:3, 3] = frame.axes[:, :, 0].T, frame.origin[:, 0]
            ends.append(end)
        return np.asarray(inverse(ends[1]) @ ends[0] @ element.origin)

    def _of_spring(
        self, element: PointSpring, first: _Moving, second: _Moving
    ) -> tuple[Array, Array]:
        """Return the wrench `(2, 3, N)` of a spring on `link_b`, and the size of its terms."""
        distance, direction, seen, reach = _line(first, second)
        rate = np.einsum("in,in->n", direction, seen)
        pull = element.stiffness * (distance - element.length) + element.damping * rate
        # Points that coincide: a spring of length zero pulls nowhere, its damper in any direction.
        apart = distance > COINCIDENT * self._length
        force = np.where(apart, -direction * pull, -element.damping * seen)
        pace = _norm(first.speed(first.origin)) + _norm(second.speed(second.origin))
        terms = element.stiffness * (reach + element.length) + element.damping * pace
        return _at(second.origin, force), self._length * terms

    def _of_thrust(
        self, element: PointActuator, first: _Moving, second: _Moving, time: Array
    ) -> tuple[Array, Array]:
        """Return the wrench `(2, 3, N)` of a thrust on `link_b`, and the size of its terms."""
        length, direction, seen, reach = _line(first, second)
        places = {
            "time": np.broadcast_to(time, length.shape),
            "length": length,
            "rate": np.einsum("in,in->n", direction, seen),
        }
        thrust, terms = _of_law(element.thrust, element.law.of, places, length=reach)
        return _at(second.origin, thrust * direction), self._length * terms

    def _of_contact(
        self, element: PinContact, first: _Moving, second: _Moving, time: Array
    ) -> tuple[Array, Array]:
        """Return the wrench `(2, 3, N)` of a pin contact on `link_b`, and the size of its terms."""
        axis = np.einsum("c,cin->in", element.axis_a, first.axes)
        beside = cross(axis, second.origin - first.origin)
        distance = _norm(beside)
        along = np.divide(beside, distance, out=np.zeros_like(beside), where=distance > 0.0)
        away = cross(along, axis)
        seen = second.speed(second.origin) - first.speed(second.origin)
        growth, moved = (np.einsum("in,in->n", way, seen) for way in (away, along))
        turning = np.einsum("in,in->n", axis, second.spin - first.spin)
        slip = (moved + element.radius * turning) / element.transition
        depth = distance - element.clearance / 2.0
        # What a law returns is given, not solved.
        pressure = element.pressure(depth, growth, np.broadcast_to(time, depth.shape))
        sideways = element.friction * pressure * slip / np.sqrt(1.0 + slip * slip)
        force = -(pressure * away + sideways * along)
        inside = np.maximum(depth, 0.0)
        steepness = np.divide(pressure, inside, out=np.zeros_like(inside), where=inside > 0.0)
        reach = _norm(first.origin) + _norm(second.origin) + element.clearance
        wrench = _at(second.origin + element.radius * away, force)
        return wrench, self._length * (steepness * reach + pressure)

    def _of_bushing(
        self,
        element: Bushing,
        first: _Moving,
        second: _Moving,
        placed: Sequence[Frame],
        x: Array,
    ) -> tuple[Array, Array]:
        """Return the wrench `(2, 3, N)` of a bushing on `link_b`, and the size of its terms."""
        span, count = second.origin - first.origin, second.origin.shape[-1]
        turn = _rotation_vectors(np.einsum("cin,din->ncd", first.axes, second.axes))
        wound = self._wound(element, turn, first, placed, x)
        seen = np.einsum("cin,in->cn", first.axes, span)
        gradient = element.stiffness @ np.concatenate([seen, wound.T])
        # The gradient with respect to the rotation vector, by the rate at which it changes.
        jacobians = _left_jacobians(turn)
        # About an axis that stays, a wound rotation vector changes like the angle.
        jacobians[np.einsum("ni,ni->n", wound, wound) > _WOUND**2] = np.eye(3)
        moment = np.linalg.solve(jacobians.transpose(0, 2, 1), gradient[3:].T[:, :, None])
        gradient[3:] = moment[:, :, 0].T
        # Of the points of both links that are where the second origin is.
        speeds = first.speed(second.origin), second.speed(second.origin)
        rates = np.stack([speeds[1] - speeds[0], second.spin - first.spin])
        rates = np.einsum("cin,kin->kcn", first.axes, rates).reshape(6, count)
        damping = np.zeros((6, 6)) if element.damping is None else element.damping
        in_axes = -(gradient + damping @ rates).reshape(2, 3, count)
        wrench = np.einsum("cin,kcn->kin", first.axes, in_axes)
        wrench[1] += cross(second.origin, wrench[0])
        reach = _norm(first.origin) + _norm(second.origin)
        extents = reach, np.pi + np.linalg.norm(wound, axis=1)
        paces = sum(map(_norm, speeds)), _norm(first.spin) + _norm(second.spin)
        weights = np.array([self._length, 1.0])
        terms = np.zeros(count)
        for matrix, sizes in ((element.stiffness, extents), (damping, paces)):
            blocks = np.abs(matrix).reshape(2, 3, 2, 3).max(axis=(1, 3))
            terms += weights @ blocks @ sizes
        return wrench, terms

    def _wound(
        self, element: Bushing, turn: Array, first: _Moving, placed: Sequence[Frame], x: Array
    ) -> Array:
        """Return rotation vectors `(N, 3)` with the whole turns that the joints have made.

        Of joints whose axes are parallel in the world at every sample, the angles add up to the
        rotation but for what it is at zero, which is less than half a turn. The shortest rotation
        vectors `turn` are in the axes of the bushing's first frame.
        """
        for angles, direction in self._sums(element, placed, x):
            axis = np.einsum("cin,in->nc", first.axes, direction)
            along = np.einsum("ni,ni->n", turn, axis)
            if np.max(np.linalg.norm(turn - along[:, None] * axis, axis=1)) > _PARALLEL:
                continue
            at_zero = along[0] - angles[0]
            whole = angles + np.arctan2(np.sin(at_zero), np.cos(at_zero))
            if np.all(np.isfinite(whole)):
                is_far = np.abs(whole) > _WOUND
                return np.where(is_far[:, None], whole[:, None] * axis, turn)
        return turn

    def _sums(
        self, element: Bushing, placed: Sequence[Frame], x: Array
    ) -> Iterator[tuple[Array, Array]]:
        """Yield angles `(N,)` by which joints turn a bushing's links from zero, and their axis."""
        frames, moved = self._frames, x - self._zero
        start, goal = (frames.link_frames[link][0] for link in element.links)
        around: dict[int, list[tuple[int, int, float]]] = {}
        for joint, (parent, child) in enumerate(zip(frames.parents, frames.children, strict=True)):
            around.setdefault(parent, []).append((joint, child, 1.0))
            around.setdefault(child, []).append((joint, parent, -1.0))
        motions: dict[int, list[int]] = {}
        for index, motion in enumerate(frames.motions):
            motions.setdefault(motion.joint, []).append(index)
        none = np.zeros((3, len(x)))
        waiting = [(start, np.zeros(len(x)), none)]
        seen = {start: [none]}
        while waiting:
            body, angles, direction = waiting.pop(0)
            if body == goal and np.any(direction):
                yield angles, direction
                continue
            for joint, other, sign in around.get(body, []):
                total, axis, follows = angles, direction, True
                for index in motions.get(joint, []):
                    motion = frames.motions[index]
                    if motion.kind == "slide":
                        continue
                    own = stacked([combine(placed[index].axes, constant(motion.axis))], len(x))[0]
                    axis = axis if np.any(axis) else own
                    follows &= motion.kind == "turn"
                    follows &= bool(np.max(_norm(cross(axis, own))) <= _PARALLEL)
                    total = (
                        total + sign * np.einsum("in,in->n", axis, own) * moved[:, motion.column]
                    )
                known = seen.setdefault(other, [])
                if follows and not any(np.allclose(axis, one, atol=_PARALLEL) for one in known):
                    known.append(axis)
                    waiting.append((other, total, axis))


def _effort(
    element: JointElement, x: Array, v: Array, time: Array, unit: float
) -> tuple[Array, Array]:
    """Return the efforts `(N,)` of an element along its coordinate, and the size of its terms.

    Positions are rounded in proportion to the unit of the coordinate, however small they are.
    """
    sizes = unit + np.abs(x)
    if isinstance(element, JointSpring):
        effort = element.stiffness * element.rest - element.stiffness * x - element.damping * v
        terms = element.stiffness * (sizes + abs(element.rest)) + element.damping * np.abs(v)
        return effort, terms
    if isinstance(element, JointFriction):
        slip = v / element.transition
        return -element.effort * slip / np.sqrt(1.0 + slip * slip), np.full(len(x), element.effort)
    if not isinstance(element, Actuator):
        raise _unknown_law(element)
    places = {"time": np.broadcast_to(time, x.shape), "position": x}
    return _of_law(element.effort, element.law.of, places, position=sizes)


def _of_law(
    given: Given, of: Sequence[str], places: Mapping[str, Array], **sizes: Array
) -> tuple[Array, Array]:
    """Return the values `(N,)` of a law at places `(N,)`, and the size of its terms.

    Args:
        given: see `Law`.
        of: see `Law`.
        places: by their names.
        sizes: of the terms of a place, by its name: where it is rounded, the law changes.
    """

    def at(**places: Array) -> Array:
        if isinstance(given, np.ndarray) and len(of) == 1:
            return np.interp(places[of[0]], *given.T)
        if isinstance(given, np.ndarray):
            return _of_two(given, *(places[name] for name in of))
        # What a function returns is given, not solved.
        return Law(given, tuple(of)).at("an actuator", **places)

    values = at(**places)
    if sizes.keys().isdisjoint(of):
        return values, np.abs(values)
    rounded = at(**{**places, **{name: places[name] + EPS * sizes[name] for name in sizes}})
    return values, np.abs(values) + np.abs(rounded - values) / EPS


def _of_two(table: Array, first: Array, second: Array) -> Array:
    """Return values `(N,)` of a table of two things, each weighed by hats over its places."""
    weights = [
        np.array([np.interp(at, places, hat) for hat in np.eye(len(places))])
        for at, places in ((first, table[1:, 0]), (second, table[0, 1:]))
    ]
    return np.einsum("in,ij,jn->n", weights[0], table[1:, 1:], weights[1])


def _unknown_law(element: Element) -> ArgumentError:
    return ArgumentError(
        f"the proof does not know the law of {type(element).__name__}, so that its forces could "
        "not be checked; write it once more in proof/element_loads.py"
    )


def _line(first: _Moving, second: _Moving) -> tuple[Array, Array, Array, Array]:
    """Return how far apart two origins are, in what direction, and how fast they part.

    And the size of the terms that their distance is a difference of.
    """
    span = second.origin - first.origin
    distance = _norm(span)
    with np.errstate(invalid="ignore", divide="ignore"):
        direction = span / distance
    seen = second.speed(second.origin) - first.speed(first.origin)
    return distance, direction, seen, _norm(first.origin) + _norm(second.origin)


def _at(point: Array, force: Array) -> Array:
    """Return the wrench `(2, 3, N)` of a force at a point."""
    return np.stack([force, cross(point, force)])


def _norm(vectors: Array) -> Array:
    """Return the lengths `(N,)` of vectors `(3, N)`."""
    return np.asarray(np.sqrt(np.einsum("in,in->n", vectors, vectors)))


def _rotation_vectors(rotations: Array) -> Array:
    """Return rotation vectors `(N, 3)` of rotations `(N, 3, 3)` by way of unit quaternions."""
    # Rows of 4 q qᵀ, of which the greatest one loses no digits.
    r, diagonal = rotations, np.einsum("nii->ni", rotations)
    trace = diagonal.sum(axis=1)
    outer = np.empty((len(r), 4, 4))
    outer[:, 0, 0] = 1.0 + trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        outer[:, 1 + i, 1 + i] = 1.0 + 2.0 * diagonal[:, i] - trace
        outer[:, 0, 1 + i] = outer[:, 1 + i, 0] = r[:, k, j] - r[:, j, k]
        outer[:, 1 + i, 1 + j] = outer[:, 1 + j, 1 + i] = r[:, i, j] + r[:, j, i]
    largest = np.argmax(np.einsum("nii->ni", outer), axis=1)
    q = outer[np.arange(len(r)), largest]
    q *= np.where(q[:, :1] < 0.0, -1.0, 1.0)
    size = np.linalg.norm(q[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(size, q[:, 0])
    factor = np.divide(angle, size, out=np.full(len(r), 0.0), where=size > 0.0)
    return np.asarray(q[:, 1:] * factor[:, None])


def _left_jacobians(turn: Array) -> Array:
    """Return the left Jacobians `(N, 3, 3)` of rotation vectors `(N, 3)`.

    J = 1 + (1 - cos θ)/θ² K + (θ - sin θ)/θ³ K², where K is the cross product with the vector.
    """
    angle = np.linalg.norm(turn, axis=1)
    skew = np.zeros((len(turn), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        skew[:, k, j], skew[:, j, k] = turn[:, i], -turn[:, i]
    first = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    rest = 1.0 - np.sinc(angle / np.pi)
    # Where the angle is small, so is the square that the quotient is multiplied with.
    second = np.divide(rest, angle**2, out=np.full(len(turn), 1.0 / 6.0), where=angle > 1e-6)
    return np.asarray(
        np.eye(3) + first[:, None, None] * skew + second[:, None, None] * (skew @ skew)
    )
