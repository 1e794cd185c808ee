"""Free balls: three turns in a row whose axes meet in one point, integrated as a rotation.

A ball that a scene names by its angles, a floating base or three hinges without mass between them
have a configuration in which the first and the last axis coincide: there rates of angles are
infinite, whatever the body does. Its rotation knows nothing of this. It is integrated as a unit
quaternion, and the angles are read off.

With axes a, b, c, of which b is normal to a and to c, turns by x, y, z are turns about a, b, a by
x, y + λ, z but for a constant, λ being the angle from a to c (Shuster and Markley: Generalization
of the Euler angles, J. Astronautical Sciences 51 (2003)). With h = (y + λ)/2 the quaternion has
two complex parts, cos h · exp(i (x + z)/2) and sin h · exp(i (x − z)/2): where one of them passes
through zero, the axes coincide. Angles are continuous as the phases of both are; a part that misses
zero turns by half a turn beside it, one that meets it changes its sign.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Collection, Iterable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import pinocchio

from ...core.mechanism.coordinates import Coordinates
from ...core.mechanism.joints import Joint, Part
from ...core.mechanism.mechanism import Mechanism
from ...kit.arrays import EPS, NOTHING, ROUNDED, Array, quaternion_product

_CUBIC_ERROR = 1.0 / 40.0
"""Error of the cubic over the fourth power of half of the rotation: ten times that of a circle. So
none is followed over a rotation by which a part could be anywhere."""

State: TypeAlias = tuple[Array, Array]
"""Coordinates and velocities that are integrated."""

COINCIDE = math.sqrt(EPS)
"""Sine of the angle between first and last axis up to which they coincide: half of the digits."""
NEARLY = 1e-4
"""The same up to which speeds of the angles lose so many digits that they are no results."""


class FreeBall(NamedTuple):
    """Three turns that are integrated as one rotation.

    Attributes:
        column: of the first angle in a row of the mechanism; the others follow.
        ball: first column of the quaternion in a row that is integrated.
        rate: first velocity coordinate, of both.
        hinge: index of the first turn's joint in the mechanism's model.
        lead: λ, see above [rad].
        to_parts: `(4, 4)`: the quaternion's product with it is (Re, Im) of the first part, then of
            the second.
        axes: `(3, 3)`: rows are the axes a, b, a × b turned by λ, in the body's frame.
        before, after: `pin.SE3`: the first turn's placement is the rotation between both where
            the angles are those of `regular`.
    """

    column: int
    ball: int
    rate: int
    hinge: int
    lead: float
    to_parts: Array
    axes: Array
    before: pinocchio.SE3
    after: pinocchio.SE3

    @property
    def columns(self) -> slice:
        """Columns of the angles in a row of the mechanism."""
        return slice(self.column, self.column + 3)

    @property
    def rates_of(self) -> slice:
        """Velocity coordinates, of both."""
        return slice(self.rate, self.rate + 3)

    @property
    def regular(self) -> Array:
        """Angles `(3,)` at which the axes are normal to each other."""
        return np.array([0.0, 0.5 * math.pi - self.lead, 0.0])

    def quaternion(self, angles: Array) -> Array:
        """Return the quaternion `(4,)` (x, y, z, w) of angles `(3,)`."""
        x, y, z = angles.tolist()
        half = 0.5 * (y + self.lead)
        first = cmath.rect(math.cos(half), 0.5 * (x + z))
        second = cmath.rect(math.sin(half), 0.5 * (x - z))
        return np.array([first.real, first.imag, second.real, second.imag]) @ self.to_parts

    def nearest(self, row: Array, near: Array) -> Array:
        """Return the angles `(3,)` of a row which are nearest to others."""
        x, y, z = near.tolist()
        phases = 0.5 * (x + z), 0.5 * (x - z)
        return self._angles(
            self.parts_of(row[self.ball : self.ball + 4]), phases, 0.5 * (y + self.lead)
        )

    def _angles(
        self, parts: tuple[complex, complex], phases: tuple[float, float], half: float
    ) -> Array:
        """Return angles whose phases are nearest to some, whichever sign the parts then have."""
        (first, second), (total, difference) = parts, phases
        total = _nearest_phase(first, total)
        difference = _nearest_phase(second, difference)
        cosine = (first * cmath.rect(1.0, -total)).real
        sine = (second * cmath.rect(1.0, -difference)).real
        found = math.atan2(sine, cosine)
        half = found + 2.0 * math.pi * round((half - found) / (2.0 * math.pi))
        return np.array([total + difference, 2.0 * half - self.lead, total - difference])

    def followed(
        self,
        near: Array,
        ends: tuple[float, float],
        states: tuple[State, State],
        way: Callable[[float], State],
    ) -> Array:
        """Return the angles `(3,)` at the end of an interval into which they go on continuously.

        Args:
            near: angles at its start.
            ends: of the interval [s].
            states: at them.
            way: the state at any time between them.
        """
        angles, pending = near, [(*ends, *states)]
        while pending:
            start, end, first, last = pending.pop()
            found = self._turned(angles, (first, last), end - start)
            middle = 0.5 * (start + end)
            if found is None and start < middle < end:
                between = way(middle)
                pending += [(middle, end, between, last), (start, middle, first, between)]
                continue
            angles = self.nearest(last[0], angles) if found is None else found
        return angles

    def _turned(self, near: Array, states: tuple[State, State], span: float) -> Array | None:
        """Return what `followed` does, from the ends of an interval alone; None if they leave it.

        Both parts of the quaternion go round zero as their chords do, unless these come so near to
        it that the parts may pass on the other side.
        """
        x, y, z = near.tolist()
        phases, half = [0.5 * (x + z), 0.5 * (x - z)], 0.5 * (y + self.lead)
        spins = [rates[self.rates_of] for _, rates in states]
        turned = 0.5 * span * max(float(np.linalg.norm(spin)) for spin in spins)
        turns = [row[self.ball : self.ball + 4] for row, _ in states]
        before, after = map(self.parts_of, turns)
        slopes = (self.parts_of(span * _spun(*pair)) for pair in zip(turns, spins, strict=True))
        for index, (one, other, *both) in enumerate(zip(before, after, *slopes, strict=True)):
            # So far a cubic with these slopes may be from the chord.
            off = 4.0 / 27.0 * sum(abs(slope - (other - one)) for slope in both)
            rests = max(map(abs, (one, other, *both))) <= NOTHING
            if not rests and _distance(one, other) <= off + _CUBIC_ERROR * turned**4 + ROUNDED:
                return None
            phases[index] = _next_phase(phases[index], one, other)
        return self._angles(after, (phases[0], phases[1]), half)

    def rates(self, angles: Array, spin: Array, gain: Array) -> tuple[Array, Array, bool]:
        """Return rates and accelerations of the angles, `(3,)` each, and whether they exist.

        Where first and last axis coincide, only the sum of both turns is decided by the motion at
        that time. Rates have limits if the rotation passes there along the middle axis; if they
        have none, what is returned moves the body about the axes that are left.

        Args:
            angles: `(3,)`.
            spin: angular velocity in the body's frame `(3,)`.
            gain: its rate `(3,)`.
        """
        sine, cosine = self._sines(angles)
        sin, cos = math.sin(angles[2]), math.cos(angles[2])
        along, second, third = (self.axes @ spin).tolist()
        along_gain, second_gain, third_gain = (self.axes @ gain).tolist()
        tilt = cos * second - sin * third
        across = sin * second + cos * third
        pushed, exists, is_apart = sin * second_gain + cos * third_gain, True, abs(sine) > COINCIDE
        if is_apart:
            first = across / sine
        else:
            size = math.hypot(along, second, third)
            passes = abs(across) <= 1e-6 * size < abs(tilt)
            exists = passes or size == 0.0
            first = 0.5 * cosine * (along + (pushed / tilt if passes else 0.0))
        last = along - first * cosine
        across_gain = pushed + tilt * (last - first * cosine)
        tilt_gain = cos * second_gain - sin * third_gain - first * sine * last
        first_gain = across_gain / sine if is_apart else 0.5 * cosine * along_gain
        last_gain = along_gain - first_gain * cosine + first * tilt * sine
        rates, gains = [first, tilt, last], [first_gain, tilt_gain, last_gain]
        return np.array(rates), np.array(gains), exists

    def apart(self, x: Array) -> float:
        """Return the sine of the angle between the outer axes at coordinates of the mechanism."""
        return abs(self._sines(x[self.columns])[0])

    def spin(self, angles: Array, rates: Array) -> Array:
        """Return the angular velocity `(3,)` in the body's frame of rates of the angles."""
        sine, cosine = self._sines(angles)
        first, tilt, last = rates.tolist()
        return self._turned_back(angles, first * cosine + last, first * sine, tilt)

    def moment(self, angles: Array, efforts: Array) -> Array:
        """Return the moment `(3,)` in the body's frame of efforts along the angles `(3,)`.

        Without effort about the outer axes it is finite wherever they are.
        """
        sine, cosine = self._sines(angles)
        first, tilt, last = efforts.tolist()
        across = first - last * cosine
        if across != 0.0:
            across /= sine if abs(sine) > EPS else math.copysign(EPS, sine)
        return self._turned_back(angles, last, across, tilt)

    def _turned_back(self, angles: Array, along: float, across: float, tilt: float) -> Array:
        """Return a vector in the body's frame that has parts about the last and the middle axis."""
        sin, cos = math.sin(angles[2]), math.cos(angles[2])
        return np.array([along, across * sin + tilt * cos, across * cos - tilt * sin]) @ self.axes

    def _sines(self, angles: Array) -> tuple[float, float]:
        """Return sine and cosine of the angle between the first and the last axis."""
        between = float(angles[1]) + self.lead
        return math.sin(between), math.cos(between)

    def parts_of(self, quaternion: Array) -> tuple[complex, complex]:
        """Return both parts of a quaternion `(4,)`, or of its rate."""
        a, b, c, d = (self.to_parts @ quaternion).tolist()
        return complex(a, b), complex(c, d)


def _spun(quaternion: Array, spin: Array) -> Array:
    """Return the rate of a quaternion `(4,)` for an angular velocity in the body's frame."""
    return quaternion_product(quaternion[None], np.array([[*(0.5 * spin), 0.0]]))[0]


def _nearest_phase(part: complex, near: float) -> float:
    """Return the phase of a part or of its negative [rad], whichever is nearer to another one."""
    if abs(part) <= NOTHING:
        return near
    phase = cmath.phase(part)
    return phase + math.pi * round((near - phase) / math.pi)


def _next_phase(phase: float, before: complex, after: complex) -> float:
    """Return the phase after a straight way; of the negative part if it has a negative one."""
    if abs(before) <= NOTHING or abs(after) <= NOTHING:
        return _nearest_phase(after, phase)
    return _nearest_phase(after, phase + cmath.phase(after / before))


def _distance(one: complex, other: complex) -> float:
    """Return the distance of a straight way from zero."""
    way = other - one
    if way == 0.0:
        return abs(one)
    part = min(max(-(one * way.conjugate()).real / abs(way) ** 2, 0.0), 1.0)
    return abs(one + part * way)


class WithBalls:
    """A mechanism whose free balls are balls, whatever its own coordinates are.

    It has what a simulation takes of a `Mechanism`; velocity coordinates keep their places.

    Attributes:
        source: the mechanism.
        balls: what is integrated as a rotation.
        model: Pinocchio's, without the bodies between the turns.
        coordinates: its layout.
        loops, couplings: see `Mechanism`.
        auxiliary_bodies, characteristic_length: see `Mechanism`.
        kept: what simulations find out about it, with the mechanism.
    """

    def __init__(self, source: Mechanism, hinges: Collection[int]) -> None:
        """Make it.

        Args:
            source: the mechanism.
            hinges: indices in its model of the first turns of the balls.
        """
        self.source, self._hinges = source, tuple(hinges)
        self.kept = source.kept.part(self._hinges)
        self.characteristic_length = source.characteristic_length
        self.couplings = source.couplings
        old, model = source.model, pinocchio.Model()
        parts = source.coordinates.parts
        starts = dict(zip((part.id for part in parts), source.coordinates.starts, strict=True))
        axes = {part.id: part.axis for part in parts}
        centres = {hinge + 2: _meeting(old, hinge, axes) for hinge in hinges}
        moved = {0: pinocchio.SE3.Identity()}
        own = {0: 0}
        joints, balls = [], []
        for part in parts:
            index = part.id
            if any(hinge <= index < hinge + 2 for hinge in hinges):
                continue
            kind, first = part.kind, index
            moved[index] = pinocchio.SE3.Identity()
            placement, joint = old.jointPlacements[index], old.joints[index]
            if index in centres:
                kind, first = "spherical", index - 2
                at_first, at_last, *_ = centres[index]
                moved[index] = pinocchio.SE3(np.eye(3), -at_last)
                placement, joint = old.jointPlacements[first], pinocchio.JointModelSpherical()
                zero = old.jointPlacements[first + 1] * old.jointPlacements[index]
                placement = placement * pinocchio.SE3(zero.rotation, at_first)
            parent = old.parents[first]
            placement = moved[parent] * placement
            own[index] = model.addJoint(own[parent], joint, placement, old.names[index])
            model.inertias[own[index]] = moved[index].act(old.inertias[index])
            part = Part(kind, part.axis, own[index])
            joints.append(Joint(old.names[index], kind, part.axis, (part,)))
        # Velocity coordinates keep their places, and balls that were turns have none.
        model.armature = old.armature
        self.model = model
        self.coordinates = Coordinates(model, joints, source.characteristic_length)
        placed = dict(zip(range(1, model.njoints), self.coordinates.starts, strict=True))
        for index in centres:
            columns = starts[index - 2], placed[own[index]]
            balls.append(_free_ball(old, index - 2, axes, moved[index], columns))
        self.balls = tuple(balls)
        self.loops = tuple(
            loop._replace(
                predecessor=own[loop.predecessor],
                predecessor_placement=moved[loop.predecessor] * loop.predecessor_placement,
                successor=own[loop.successor],
                successor_placement=moved[loop.successor] * loop.successor_placement,
            )
            for loop in source.loops
        )
        self.auxiliary_bodies = tuple(own[index] for index in source.auxiliary_bodies)
        # Columns of everything else, in the mechanism and here.
        angles = {ball.column + k for ball in balls for k in range(3)}
        quaternions = {ball.ball + k for ball in balls for k in range(4)}
        self._columns = np.array(
            [column for column in range(source.coordinates.size) if column not in angles], dtype=int
        )
        self._own_columns = np.array(
            [column for column in range(self.coordinates.size) if column not in quaternions],
            dtype=int,
        )

    def __reduce__(self) -> tuple[object, ...]:
        return WithBalls, (self.source, self._hinges)

    def row(self, x: Array) -> Array:
        """Return the row that is integrated for a row of the mechanism `(size,)`."""
        row = np.empty(self.coordinates.size)
        row[self._own_columns] = x[self._columns]
        for ball in self.balls:
            row[ball.ball : ball.ball + 4] = ball.quaternion(x[ball.columns])
        return row

    def turns(self, x: Array, turns: Array) -> Array:
        """Return turns `(own size,)` of the row for `x`, see `System.turns`."""
        result = np.zeros(self.coordinates.size)
        result[self._own_columns] = turns[self._columns]
        for ball in self.balls:
            span = ball.columns
            result[ball.ball : ball.ball + 3] = x[span] / (2.0 * np.pi) + turns[span]
        return result

    def velocities(self, x: Array, v: Array) -> Array:
        """Return velocities that are integrated for a state of the mechanism."""
        v = v.copy()
        for ball in self.balls:
            span = ball.rates_of
            v[span] = ball.spin(x[ball.columns], v[span])
        return v

    def positions(self, row: Array, turns: Array) -> Array:
        """Return the mechanism's coordinates `(size,)`, all turns counted, of a row.

        Args:
            row: that is integrated.
            turns: of the row; of balls, angles near which they are.
        """
        x = np.empty(self.source.coordinates.size)
        x[self._columns] = (row + 2.0 * np.pi * turns)[self._own_columns]
        for ball in self.balls:
            near = 2.0 * np.pi * turns[ball.ball : ball.ball + 3]
            x[ball.columns] = ball.nearest(row, near)
        return x

    def rates(self, x: Array, v: Array, a: Array) -> tuple[Array, Array, Array]:
        """Return velocities and accelerations of the mechanism, and which of them exist `(nv,)`.

        Args:
            x: its coordinates `(size,)`.
            v: velocities that are integrated `(nv,)`.
            a: accelerations that are.
        """
        v, a, exist = v.copy(), a.copy(), np.ones(len(v), dtype=bool)
        for ball in self.balls:
            span, angles = ball.rates_of, x[ball.columns]
            v[span], a[span], exists = ball.rates(angles, v[span], a[span])
            exist[[ball.rate, ball.rate + 2]] = exists
        return v, a, exist

    def followed(
        self,
        turns: Array,
        ends: tuple[float, float],
        states: tuple[State, State],
        way: Callable[[float], State],
    ) -> Array:
        """Return the turns at the end of a part of a step, of which those at its start are known.

        Args:
            turns: at its start.
            ends: [s].
            states: at them.
            way: the state at any time between them.
        """
        turns = turns.copy()
        for ball in self.balls:
            span = slice(ball.ball, ball.ball + 3)
            angles = ball.followed(2.0 * np.pi * turns[span], ends, states, way)
            turns[span] = angles / (2.0 * np.pi)
        return turns

    def efforts(self, x: Array, efforts: Array) -> Array:
        """Return efforts `(nv,)` along what is integrated, of those along the coordinates `x`."""
        efforts = efforts.copy()
        for ball in self.balls:
            span = ball.rates_of
            efforts[span] = ball.moment(x[ball.columns], efforts[span])
        return efforts

    def regular(self, model: Any, x: Array, row: Array, v: Array) -> tuple[Array, Array]:
        """Return a configuration and velocities of the mechanism's model in which axes differ.

        Its balls are placed so that their bodies are where they are, with other angles.

        Args:
            model: Pinocchio's, of the mechanism; first turns of balls are placed anew.
            x: coordinates `(size,)`.
            row: that is integrated.
            v: velocities that are integrated.
        """
        x, v = x.copy(), v.copy()
        for ball in self.balls:
            turn = pinocchio.Quaternion(row[ball.ball : ball.ball + 4]).matrix()
            rotation = pinocchio.SE3(turn, np.zeros(3))
            model.jointPlacements[ball.hinge] = ball.before * rotation * ball.after
            x[ball.columns] = ball.regular
            v[ball.rates_of] = (ball.axes @ v[ball.rates_of])[::-1]
        return x, v

    def regular_moments(self, efforts: Array) -> Array:
        """Return efforts along what is integrated, of those at a `regular` configuration."""
        efforts = efforts.copy()
        for ball in self.balls:
            span = ball.rates_of
            efforts[span] = efforts[span][::-1] @ ball.axes
        return efforts


def with_free_balls(
    mechanism: Mechanism, prescribed: Iterable[int], loaded: Collection[int] = ()
) -> Mechanism | WithBalls:
    """Return a mechanism with its free balls as balls; itself if it has none.

    Args:
        mechanism: the mechanism.
        prescribed: velocity coordinates that are driven or held.
        loaded: bodies of the model on which forces act.
    """
    hinges = _first_turns(mechanism, set(prescribed), loaded)
    return WithBalls(mechanism, hinges) if hinges else mechanism


def _first_turns(mechanism: Mechanism, fixed: set[int], loaded: Collection[int]) -> list[int]:
    """Return the first turns of three in a row that are a free ball, as indices in the model."""
    model = mechanism.model
    fixed |= {
        column
        for item in mechanism.couplings
        for column in (*item.predecessor_columns, *item.successor_columns)
    }
    # What resists along a turn by itself does not along a rotation.
    fixed |= set(np.flatnonzero(model.armature).tolist())
    tied = {*loaded}.union(*((loop.predecessor, loop.successor) for loop in mechanism.loops))
    # The tilts of a pin with play are as small as the play is.
    fixed |= {
        rate
        for joint in mechanism.joints.values()
        if joint.type == "loose"
        for rate in range(model.nv)[mechanism.coordinates.velocity_columns[joint.name]]
    }
    parts = mechanism.coordinates.parts
    turning = {part.id: part.axis for part in parts if part.kind == "revolute"}
    children = list(model.parents)
    result: list[int] = []
    for index in range(1, model.njoints - 2):
        own = index, index + 1, index + 2
        if result and index <= result[-1] + 2:
            continue
        if not turning.keys() >= set(own) or fixed & {model.idx_vs[item] for item in own}:
            continue
        if any(model.parents[item + 1] != item for item in own[:2]):
            continue
        if any(
            item in tied or children.count(item) > 1 or np.any(model.inertias[item].matrix())
            for item in own[:2]
        ):
            continue
        *_, askew, apart = _meeting(model, index, turning)
        if askew <= ROUNDED and apart <= ROUNDED * mechanism.characteristic_length:
            result.append(index)
    return result


def _meeting(
    model: pinocchio.Model, hinge: int, axes: dict[int, Array]
) -> tuple[Array, Array, float, float]:
    """Return where three axes meet, in the frames of the first and of the last turn.

    Args:
        model: of the mechanism.
        hinge: first turn.
        axes: of the turns, in their frames.

    Returns:
        Both places, the greatest cosine of the angle between the middle axis and another, and the
        greatest distance of an axis from the first place [m].
    """
    second, third = (model.jointPlacements[hinge + k] for k in (1, 2))
    zero = second * third
    a, b = axes[hinge], second.rotation @ axes[hinge + 1]
    c = zero.rotation @ axes[hinge + 2]
    askew = max(abs(float(a @ b)), abs(float(b @ c)))
    # The middle axis meets each of the others at right angles: along both, the foot is at a.
    to_middle, to_last = second.translation, zero.translation
    centre = a * float(a @ to_middle)
    on_last = float(c @ (centre - to_last))
    gaps = [
        (centre - to_middle) - b * float(b @ (centre - to_middle)),
        (centre - to_last) - c * on_last,
    ]
    apart = max(float(np.linalg.norm(gap)) for gap in gaps)
    return centre, axes[hinge + 2] * on_last, askew, apart


def _free_ball(
    model: pinocchio.Model,
    hinge: int,
    axes: dict[int, Array],
    moved: pinocchio.SE3,
    columns: tuple[int, int],
) -> FreeBall:
    """Return a ball."""
    second, third = (model.jointPlacements[hinge + k] for k in (1, 2))
    zero = second * third
    a = zero.rotation.T @ axes[hinge]
    b = third.rotation.T @ axes[hinge + 1]
    c = axes[hinge + 2]
    across = np.cross(a, b)
    # The turn about b that leads from a to c; across x b = -a.
    lead = math.atan2(-float(c @ across), float(c @ a))
    turn = np.array([*(math.sin(0.5 * lead) * b), math.cos(0.5 * lead)])
    led = quaternion_product(np.eye(4), turn[None])
    basis = np.array([a, b, across])
    to_parts = np.vstack([led[:, 3], basis @ led[:, :3].T])
    rotation = pinocchio.Quaternion(turn).matrix()
    before = model.jointPlacements[hinge] * pinocchio.SE3(
        zero.rotation, _meeting(model, hinge, axes)[0]
    )
    middle = 0.5 * math.pi - lead
    quarter = np.array([*(math.sin(0.5 * middle) * axes[hinge + 1]), math.cos(0.5 * middle)])
    tilted = pinocchio.SE3(pinocchio.Quaternion(quarter).matrix(), np.zeros(3))
    after = moved * (second * tilted * third).inverse()
    return FreeBall(
        columns[0],
        columns[1],
        model.idx_vs[hinge],
        hinge,
        lead,
        to_parts,
        basis @ rotation.T,
        before,
        after,
    )
