"""Assembly modes: the ways in which the loops can be closed with the drives where they start.

Joints with intersecting axes have two positions for the same direction, and a rod may be turned by
half a turn about the line between its ends. Such modes are variants of one pose: in all of them the
axes of all joints lie on the same lines, and the centres of balls at the same points.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from string import ascii_uppercase
from typing import NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import Array
from ..mechanism.mechanism import Mechanism
from .closing.all_groups import Kinematics
from .closing.group_solver import MOST_STEPS
from .loops.idle_rods import JointEdge, JointGraph, common_point
from .tolerances import CLOSURE_TOLERANCE, MOVES, SINGULAR_CONDITION

_STARTS = 100
"""Random starts per round. The bundled four-bar has two modes, which one round finds. With all legs
of the bundled Stewart platform driven, the first round finds the 8 poses of the platform; 4 rounds
find 200 variants of them, 8 rounds 357."""
_MORE = 3
"""The search goes on until there have been this many times as many starts as when it found its last
new pose. A pose to which as few starts lead as to that one is missed by one search in e³ = 20;
most poses are found by many starts."""
_MOST_ROUNDS = 32
"""Rounds after which the search ends in any case, and says that it was not complete."""


class AssemblyModes(NamedTuple):
    """The assembly modes that a search found.

    Attributes:
        poses: for each pose its variants, closed coordinates `(size,)`: first the pose of the given
            mode, with this mode first, then the others by their distance from it.
        starts: number of starts of the search.
        last_new: number of starts after which the last new pose had been found.
        is_complete: whether the search ended since new starts brought no new pose.
    """

    poses: list[list[Array]]
    starts: int
    last_new: int
    is_complete: bool

    def named(self) -> dict[str, Array]:
        """Return all modes by their names, see `mode_name`."""
        return {
            mode_name(pose, variant): state
            for pose, variants in enumerate(self.poses)
            for variant, state in enumerate(variants)
        }


def assembly_modes(
    mechanism: Mechanism,
    kinematics: Kinematics,
    passives: Array,
    first: Array,
    idle: Collection[str] = (),
) -> AssemblyModes:
    """Search for assembly modes until new starts bring no new pose.

    Args:
        mechanism: the mechanism.
        kinematics: with all rows that open loops can reach.
        passives: velocity coordinates that the loops decide.
        first: `(size,)` closed coordinates of the description's own mode.
        idle: joints at the ends of idle rods, which may have any position in every mode.
    """
    coordinates, in_balls = mechanism.coordinates, hinges_in_balls(mechanism)
    # Of each pose its outline, and its modes with their shapes.
    outlines: list[Array] = []
    poses: list[list[tuple[Array, Array]]] = []
    # The same starts at every call, so that a mode has the same name every time.
    generator = np.random.default_rng(1)
    starts = last_new = 0
    while starts < _MOST_ROUNDS * _STARTS and starts <= _MORE * last_new:
        step = generator.uniform(-np.pi, np.pi, (_STARTS, len(passives)))
        # Slides start within a length.
        step[:, coordinates.moves(passives).slides] /= np.pi
        x = coordinates.displaced(first, passives, step)
        if not starts:
            x[0] = first
        with np.errstate(all="ignore"):  # Starts that do not converge may overflow.
            state = kinematics.close(x, most=MOST_STEPS)
        x = state.x[(state.residual < CLOSURE_TOLERANCE) & (state.condition < SINGULAR_CONDITION)]
        starts += _STARTS
        shapes, found = _shapes(mechanism, x, first, idle), _outlines(mechanism, x, in_balls, idle)
        for row, shape, outline in zip(x, shapes, found, strict=True):
            pose = _index_of(outline, outlines)
            if pose == len(outlines):
                outlines.append(outline)
                poses.append([])
                last_new = starts
            if _index_of(shape, [known for known, _ in poses[pose]]) == len(poses[pose]):
                poses[pose].append((shape, row))
    for modes in poses:
        modes.sort(key=_rank)
    poses.sort(key=lambda modes: _rank(modes[0]))
    rows = [[row for _, row in modes] for modes in poses]
    return AssemblyModes(rows, starts, last_new, starts > _MORE * last_new)


def _shapes(mechanism: Mechanism, x: Array, first: Array, idle: Collection[str]) -> Array:
    """Return rows that are equal for equal modes: spins of idle rods make no difference."""
    x = x.copy()
    for name in idle:
        columns = mechanism.coordinates.columns[name]
        x[:, columns] = first[columns]
    return mechanism.coordinates.apart(x, first)


def _outlines(
    mechanism: Mechanism, x: Array, in_balls: Collection[int], idle: Collection[str]
) -> Array:
    """Return rows `(K, s)` that are equal for equal poses: lines and points of all joints."""
    frames, length = mechanism.frames, mechanism.characteristic_length
    parts = []
    for motion, frame in zip(frames.motions, frames.placed(x), strict=True):
        point = frame[3] / length
        is_idle = frames.joints[motion.joint] in idle
        if motion.kind == "ball" or motion.rate in in_balls or is_idle:
            parts.append(point)
            continue
        axis = np.einsum("c,cin->in", motion.axis, frame[:3])
        # A line has no sense: the axis is seen by its products only.
        parts += [axis[0] * axis, axis[1] * axis, axis[2] * axis]
        if motion.kind == "turn":
            parts.append(point - np.sum(point * axis, axis=0) * axis)
    # A coupling counts how far joints have turned, so their flips move what it couples.
    coupled = x[:, _coupled_columns(mechanism)].T
    return np.concatenate([*parts, np.cos(coupled), np.sin(coupled)]).T


def _coupled_columns(mechanism: Mechanism) -> list[int]:
    """Return the columns of a row that couplings count."""
    rates = {
        rate
        for item in mechanism.couplings
        for rate in (*item.predecessor_columns, *item.successor_columns)
    }
    return mechanism.coordinates.column_of(np.array(sorted(rates), dtype=int)).tolist()


def _rank(mode: tuple[Array, Array]) -> tuple[float, ...]:
    """Return by what a mode comes before or behind others: first how far off the first mode it is.

    Those as far off come in the order of their joints; rounding decides nothing.
    """
    shape, _ = mode
    return tuple(np.rint(np.append(np.linalg.norm(shape), shape) / MOVES).tolist())


def _index_of(row: Array, known: list[Array]) -> int:
    """Return the index of the row in a list that a row is equal to, or the length of the list."""
    if not known:
        return 0
    near = np.linalg.norm(np.array(known) - row, axis=1) <= MOVES
    return int(np.argmax(near)) if np.any(near) else len(known)


def mode_name(pose: int, variant: int = 0) -> str:
    """Return the name of an assembly mode.

    Poses are A … Z for the indices 0 … 25, then AA, AB …; a number tells their variants from the
    second one on, A2, A3 ….
    """
    name = ""
    pose += 1
    while pose:
        pose, letter = divmod(pose - 1, len(ascii_uppercase))
        name = ascii_uppercase[letter] + name
    return f"{name}{variant + 1}" if variant else name


def positions_of(mechanism: Mechanism, drives: tuple[str, ...], state: Array) -> dict[str, float]:
    """Return the positions of all coordinates that turn or slide [m, or rad between -π and π].

    Args:
        mechanism: the mechanism.
        drives: coordinates that count whole turns; those that couplings count do so as well.
        state: `(size,)` coordinates.
    """
    state = without_turns(mechanism, drives, state)
    named = mechanism.coordinates.named
    return {name: float(state[coordinate.column]) for name, coordinate in named.items()}


def without_turns(mechanism: Mechanism, kept: Iterable[str], state: Array) -> Array:
    """Return coordinates `(size,)` whose angles are between -π and π, as far as turns do not count.

    Args:
        mechanism: the mechanism.
        kept: coordinates whose whole turns count; those that couplings count are kept as well.
        state: `(size,)` coordinates.
    """
    coordinates, result = mechanism.coordinates, state.copy()
    counting = {*coordinates.columns_of(kept), *_coupled_columns(mechanism)}
    free = [column for column in coordinates.angle_columns if column not in counting]
    result[free] -= 2.0 * np.pi * np.rint(result[free] / (2.0 * np.pi))
    return result


def hinges_in_balls(mechanism: Mechanism) -> set[int]:
    """Return the velocity coordinates of all hinges of which three make up a ball."""
    graph = JointGraph(mechanism, set(range(mechanism.model.nv)))
    centres = {
        body: centre
        for body, edges in graph.edges.items()
        if body != graph.world and (centre := _centre(edges, graph.tolerance)) is not None
    }
    result: set[int] = set()
    done: set[int] = set()
    for body in centres:
        if body not in done:
            links = _links_around(graph, centres, body)
            done |= links
            hinges = {edge.columns[0] for link in links for edge in graph.edges[link]}
            if (len(links), len(hinges)) == (2, 3):
                result |= hinges
    return result


def _centre(edges: list[JointEdge], tolerance: float) -> Array | None:
    """Return the point in which the axes of the two hinges of a link meet; None if they do not."""
    if [edge.kind for edge in edges] != ["revolute", "revolute"]:
        return None
    lines = [(edge.frame.translation, edge.frame.rotation @ edge.axis) for edge in edges]
    return common_point(lines, tolerance)


def _links_around(graph: JointGraph, centres: dict[int, Array], body: int) -> set[int]:
    """Return the links that follow a link and each other, and whose hinges meet in its centre."""
    links, waiting = {body}, [body]
    while waiting:
        link = waiting.pop()
        for edge in graph.edges[link]:
            if edge.other in centres and edge.other not in links:
                here = _in_joint(edge.frame, centres[link])
                there = _in_joint(edge.other_frame, centres[edge.other])
                # Both lie on the hinge's axis, so that the hinge's angle makes no difference.
                if np.linalg.norm(here - there) < graph.tolerance:
                    links.add(edge.other)
                    waiting.append(edge.other)
    return links


def _in_joint(frame: pinocchio.SE3, point: Array) -> Array:
    """Return a point `(3,)` of a body in the frame of one of its joints."""
    return np.asarray(frame.actInv(np.asarray(point)))
