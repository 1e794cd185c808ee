"""Exact: the closed chain that a description with rounded numbers means.

A loop with more closure equations than its joints need, such as a planar one of hinges, closes over
its whole motion only where axes are exactly parallel, concurrent or in line. Numbers of six digits
miss that by a millionth: then the loop cannot be closed, or is locked, or is closed by equations
that only the last digit of the file makes independent, whose forces mean nothing.

Where that is so, the geometry that the file means is the nearest one whose loops close all along
the motion. At a position of the chain let J be the closure rows by joint coordinates, P those by
displacements ξ of the frames of joints and of the ends of loops, and e the errors. Combinations N
of rows with Nᵀ J = 0, self-stresses, tell what no motion of the joints makes up for. So

    Nᵀ (e + P ξ) = 0    at all positions of the motion,

which is solved by the least ξ at positions enough (Gauss and Newton's method; rank of J up to the
tolerance), until the loops close to rounding there and at other positions.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio

from ...kit.arrays import EPS, Array, generic
from ...kit.checks import mapping, number
from ...kit.errors import choices
from ..description.description import IDENTITY
from ..description.description import ROUNDING as _CLOSED
from ..description.read import read
from ..mechanism.mechanism import Mechanism
from . import closure
from .bodies import Tree, tree_of
from .placements import Placed, placed, stepped
from .vectors import UNTURNED, Rotation, Vector, added, cross, less, product, turned

if TYPE_CHECKING:
    from ..description.description import Description

_SINGLE_PRECISION = float(np.finfo(np.float32).eps)
"""Error of numbers that many programs write however many digits they give."""
_MOST_ROUNDED = 1e-3
"""Greatest error of numbers that counts as rounding: that of four digits."""
_WAYS, _STEPS = 6, 4
"""Ways from zero, and steps on each, to positions of the motion at which loops are made to close,
and to as many at which that is tried."""
_STEP = 0.3
"""Length of a step [rad, or lengths of the mechanism, all joints together]."""
_MOST_STEPS = 30
_LEVERS = 10.0
"""How many times as much as frames errors and rows may be off: they are some lengths apart."""
_ROUNDS = 3
"""Sets of positions that are taken in turn, each where the one before did not suffice."""


def load(
    source: str | os.PathLike[str],
    *,
    strict: bool = True,
    closure_tolerance: float | None = None,
    model: str | None = None,
    forces: Mapping[str, str] | None = None,
) -> Mechanism:
    """Load a mechanism with closed loops.

    Loops with more closure equations than their joints need close over their whole motion only
    where axes are exactly parallel, concurrent or in line, which numbers of some digits miss. Then
    the frames of joints are displaced to the nearest geometry that the numbers may mean, and
    `Mechanism.warnings` says by what.

    Args:
        source: name of a bundled description, path of a URDF, MJCF or SDF file, or their text.
            Loops may be written in URDF+, as Isaac's `<loop_joint>`, ROS' `<constraint>`, joints
            of SDF in `<gazebo>` or closing frames, in Gepetto's YAML file or `loop_closures.yaml`
            beside the URDF, as `<equality>` in MJCF, or as joints of SDF that do not belong to its
            tree.
        strict: refuse what is probably wrong: inertias that no body can have, misspelled words of a
            URDF or SDF file, forces in an MJCF or SDF file that no wrench considers. Many published
            robots have some: with False they are accepted, such as an inertia without mass, and
            listed in `Mechanism.warnings`. A negative mass is refused in any case.
        closure_tolerance: how far the numbers may be off [rad, or characteristic lengths]; as their
            digits say if None, and that of single precision at least. With zero, all stay as they
            are written.
        model: name of the one to load of an SDF file that has several.
        forces: names of couplings to what these exert, `none` or `mesh`, see `CouplingDescription`,
            for files whose notation cannot say it; of a mesh, with the usual pressure angle.

    Raises:
        ArgumentError: the tolerance is negative, or no number; `model` is given for a text that
            has only one; or `forces` names no coupling.
        ModelError: the description is missing, malformed or impossible.
    """
    return made(read(source, strict, model), closure_tolerance, forces)


def made(
    description: Description,
    closure_tolerance: float | None,
    forces: Mapping[str, str] | None = None,
) -> Mechanism:
    """Return the mechanism of a description, its geometry made exact, see `load`."""
    if forces is not None:
        from ..description.coupled_forces import with_stated_forces  # Few descriptions need it.

        description = with_stated_forces(description, mapping("forces", forces))
    described = Mechanism(description)
    tolerance, length = closure_tolerance, described.characteristic_length
    if tolerance is not None:
        tolerance = number("closure_tolerance", tolerance, 0.0)
    if not described.loops or tolerance == 0.0:
        return described
    limit = _LEVERS * max(tolerance or 0.0, _MOST_ROUNDED)
    chains = (_Chain(described, items) for items in _in_doubt(described, limit))
    doubtful = [chain for chain in chains if not chain.is_exact(limit)]
    if not doubtful:
        return described
    if tolerance is None:
        from ..description.digits import precision_of  # Most loops are exact.

        precision = precision_of(description)
        stated = max(precision.angle, precision.length / length)
        # A place has three numbers, each of which may be off by that.
        tolerance = min(max(np.sqrt(3.0) * stated, _SINGLE_PRECISION), _MOST_ROUNDED)
    displacements: dict[tuple[str, bool], Array] = {}
    greatest, held = 0.0, list[str]()
    for part in doubtful:
        is_held = part.is_held(_LEVERS * tolerance)  # Asked before it is displaced.
        nearest = part.made_exact(_LEVERS * tolerance)
        if (nearest is None or not nearest.displacements) and tolerance < _MOST_ROUNDED:
            nearest = part.made_exact(_LEVERS * _MOST_ROUNDED)  # Only to be told of.
        if nearest is not None:
            displacements |= nearest.displacements
            greatest = max(greatest, nearest.greatest)
        elif is_held:
            held += part.loops
    if held:
        remedy = (
            f"the last digits of its numbers may be all that keeps {choices(held)} from moving; "
            "no exact geometry was found beside them: write more digits"
        )
        description = replace(description, remedy=remedy)
    if not displacements:
        return Mechanism(description) if held else described
    displaced = description.displaced(displacements)
    if greatest <= tolerance:
        return Mechanism(displaced)
    listed = "; ".join(map(str, displaced.displacements))
    remedy = (
        f"loops would close all along their motion with {listed}; that is more than its numbers "
        f"are rounded by, {tolerance:.2g} rad or {tolerance * length:.2g} m: change them, or "
        f"accept it by load(..., closure_tolerance={1.1 * greatest:.1e})"
    )
    return Mechanism(replace(description, remedy=remedy))


def _in_doubt(mechanism: Mechanism, tolerance: float) -> list[list[int]]:
    """Return loops and couplings whose equations are not independent by more than the tolerance.

    And those that do not close. They are in parts that have no joint on loops in common, by their
    indices one behind the other.
    """
    model, coordinates, zero = mechanism.model, mechanism.coordinates, mechanism.zero
    length, scale = mechanism.characteristic_length, coordinates.rate_scale
    data, known = model.createData(), pinocchio.StdVec_RigidConstraintData()
    known.extend([item.createData() for item in mechanism.constraint_models])
    pinocchio.computeJointJacobians(model, data, coordinates.configuration(zero[None])[0])
    rows = pinocchio.getConstraintsJacobian(model, data, mechanism.constraint_models, known)
    blocks, errors = list((rows * scale).reshape(-1, 6, model.nv)), []
    for block, loop in zip(blocks, mechanism.loops, strict=True):
        start = data.oMi[loop.predecessor] * loop.predecessor_placement
        gap = (
            start.actInv(data.oMi[loop.successor] * loop.successor_placement).homogeneous - IDENTITY
        )
        block[:3] /= length
        gap[:3, 3] /= length
        errors.append(np.abs(gap).max())
    for coupling in mechanism.couplings:
        row, slip = np.zeros((1, model.nv)), coupling.offset
        for columns, factor in (
            (coupling.predecessor_columns, coupling.ratio),
            (coupling.successor_columns, -1.0),
        ):
            row[0, list(columns)] = factor
            slip += factor * zero[coordinates.column_of(np.array(columns))].sum()
        unit = scale[coupling.successor_columns[0]] if coupling.successor_columns else 1.0
        blocks.append(row * scale / unit)
        errors.append(abs(slip) / unit)
    parts: list[tuple[set[int], set[int]]] = []  # Items, and the coordinates that move them.
    for index, block in enumerate(blocks):
        moving = np.flatnonzero((np.abs(block) > _CLOSED).any(axis=0))
        joined, shared = {index}, set(moving.tolist())
        for part in [part for part in parts if part[1] & shared]:
            parts.remove(part)
            joined, shared = joined | part[0], shared | part[1]
        parts.append((joined, shared))
    result = []
    for joined, shared in parts:
        matrix = np.concatenate([blocks[index] for index in joined])[:, sorted(shared)]
        sizes = np.linalg.svd(matrix, compute_uv=False)
        # Those with equations to spare may close at zero alone, unless all their joints move in one
        # plane or about one point, and in every way that can be.
        regular = sizes.min() > tolerance and len(sizes) == len(matrix)
        if not regular and max(joined) < len(mechanism.loops):
            ways = sizes[: 3 * len(joined)]
            regular = len(ways) == 3 * len(joined) and bool(np.all(ways > tolerance))
            regular = regular and all(_keeps_together(blocks[index]) for index in joined)
        if not regular or max(errors[index] for index in joined) > _CLOSED:
            result.append(sorted(joined))
    return result


def _keeps_together(screws: Array) -> bool:
    """Return whether motions `(6, n)` of a loop's joints are in one plane or about one point."""
    linear, angular = screws[:3], screws[3:]
    sides, sizes, _ = np.linalg.svd(angular)
    if sizes[1] <= _CLOSED:
        return bool(np.abs(sides[:, 0] @ linear).max() <= _CLOSED)
    # Velocities about a point p are p × ω.
    x, y, z = angular
    nothing = np.zeros_like(x)
    rows = np.stack([[nothing, z, -y], [-z, nothing, x], [y, -x, nothing]])
    matrix, values = rows.transpose(2, 0, 1).reshape(-1, 3), linear.T.ravel()
    point = np.linalg.lstsq(matrix, values)[0]
    return bool(np.abs(matrix @ point - values).max() <= _CLOSED)


class Nearest(NamedTuple):
    """The exact geometry next to a description.

    Attributes:
        displacements: of frames, see `Description.displaced`.
        greatest: of them [rad, or lengths of the mechanism].
    """

    displacements: dict[tuple[str, bool], Array]
    greatest: float


class _Positions(NamedTuple):
    """K positions of a chain.

    Attributes:
        x: column to coordinates `(K,)`.
        at: where its bodies are.
        errors: `(K, R)` of the closure rows.
        left, sizes, right: singular value decomposition of the closure rows `(K, R, n)`.
    """

    x: Mapping[int, Array]
    at: Placed
    errors: Array
    left: Array
    sizes: Array
    right: Array

    @property
    def error(self) -> Array:
        """The greatest error at each position `(K,)`."""
        return np.asarray(np.abs(self.errors).max(axis=1, initial=0.0))


class _Chain:
    """The loops of a mechanism, whose geometry can be displaced."""

    def __init__(self, mechanism: Mechanism, items: Sequence[int]) -> None:
        """Begin with the geometry that is described.

        Args:
            mechanism: the mechanism.
            items: indices of the loops and couplings that count, one behind the other.
        """
        count = len(mechanism.loops)
        loops = [index for index in items if index < count]
        couplings = [index - count for index in items if index >= count]
        self._original = self._tree = tree_of(mechanism, (), loops, couplings, massive=())
        self._offsets = [item.offset for item in self._tree.couplings]
        # First the frames of joints, by their first bodies, then the ends of loops.
        on_loops: set[int] = set()
        for loop in self._tree.loops:
            start, end = (
                set(self._tree.path(end.body)) for end in (loop.predecessor, loop.successor)
            )
            on_loops |= start ^ end
        self._frames = [
            (name, joint.parts[0].id - 1)
            for name, joint in mechanism.joints.items()
            if joint.parts and joint.parts[0].id - 1 in on_loops
        ]
        self._parts = [
            [part.id - 1 for part in mechanism.joints[name].parts] for name, _ in self._frames
        ]
        self.loops = [mechanism.loops[index].joint for index in loops]
        count = len(self._frames) + len(self.loops)
        self.displacements = [pinocchio.SE3.Identity() for _ in range(count)]
        scaled = mechanism.zero / self._tree.coordinate_units(len(mechanism.zero))
        self._zero = {column: np.array([value]) for column, value in enumerate(scaled.tolist())}

    def at(self, x: Mapping[int, Array]) -> _Positions:
        """Return what is known at positions."""
        tree = self._tree
        at = placed(tree, x)
        errors, _ = closure.errors(tree, at, self._offsets)
        rows = closure.rows(tree, at, range(len(tree.units)))
        count = len(next(iter(x.values())))
        matrix = np.zeros((count, len(rows), len(tree.units)))
        for index, row in enumerate(rows):
            for rate, entry in row.items():
                matrix[:, index, rate] = entry
        by_row = np.stack([np.broadcast_to(error, count) for error in errors], axis=1)
        return _Positions(x, at, by_row, *np.linalg.svd(matrix))

    def closed(self, x: Mapping[int, Array], rank: int | None, tolerance: float) -> _Positions:
        """Return positions near some, closed as far as so many rows can.

        Args:
            x: of K positions.
            rank: of the rows; None if it is that of the tolerance at each position.
            tolerance: singular values that count as none.
        """
        for _ in range(_MOST_STEPS):
            here = self.at(x)
            step = self._step(here, rank, tolerance)
            longest = np.abs(step).max(initial=0.0)
            if longest < _CLOSED:
                return here
            x = self.moved(x, step * min(1.0, 0.5 / max(longest, EPS)))
        return self.at(x)

    def _step(self, here: _Positions, rank: int | None, tolerance: float) -> Array:
        """Return Newton's step `(K, n)` with so many rows."""
        count = here.sizes.shape[1]
        taken = here.sizes > tolerance if rank is None else np.arange(count) < rank
        inverse = np.divide(1.0, here.sizes, out=np.zeros_like(here.sizes), where=taken)
        along = np.einsum("krs,kr->ks", here.left[:, :, :count], here.errors) * inverse
        return -np.einsum("ksn,ks->kn", here.right[:, :count], along)

    def moved(self, x: Mapping[int, Array], step: Array) -> dict[int, Array]:
        """Return coordinates after small steps `(K, n)` of the velocity coordinates."""
        by_rate = dict(enumerate(step.T))
        result = dict(x)
        for body in self._tree.bodies:
            result.update(stepped(body, x, by_rate))
        return result

    def is_exact(self, tolerance: float) -> bool:
        """Return whether loops close, with no equation independent by less than the tolerance.

        At zero, and beside it: some files take what closes their loops from there.
        """

        def are_exact(here: _Positions) -> bool:
            in_doubt = (here.sizes > _CLOSED) & (here.sizes < tolerance)
            return bool(np.all(here.error <= _CLOSED) and not in_doubt.any())

        zero = self.closed(self._zero, None, _CLOSED)
        return are_exact(zero) and are_exact(self._around(zero, 0, tolerance, 1))

    def is_held(self, tolerance: float) -> bool:
        """Return whether loops close at zero by an equation independent by less than so much."""
        here = self.at(self._zero)
        in_doubt = (here.sizes > _CLOSED) & (here.sizes < tolerance)
        return bool(here.error[0] <= _CLOSED and in_doubt.any())

    def made_exact(self, tolerance: float) -> Nearest | None:
        """Return the nearest exact geometry; None if there is none around.

        Of what is nearly planar it is a plane one, if frames have to be displaced by no more than
        numbers are off, though axes that meet far away may be nearer: there, loops would open as
        soon as a length changes.
        """
        start = self.closed(self._zero, None, tolerance)
        if start.error[0] > tolerance:
            return None
        untouched = list(self.displacements), self._tree
        if self._flattened(start, tolerance) and self.is_exact(tolerance):
            nearest = self._nearest()
            if nearest.greatest <= tolerance / _LEVERS:
                return nearest
        self.displacements, self._tree = untouched
        taken: list[_Positions] = []
        for round_ in range(_ROUNDS):
            around = self._around(start, round_, tolerance)
            if not len(around.error):
                return None
            rank = int((around.sizes > tolerance).sum(axis=1).max())
            if taken and around.error.max() <= _LEVERS * _CLOSED:
                return self._nearest()
            taken.append(around)
            x = {column: np.concatenate([item.x[column] for item in taken]) for column in start.x}
            if not self._displaced(x, rank, tolerance):
                return None
        return None

    def _around(
        self, start: _Positions, round_: int, tolerance: float, steps: int = _STEPS
    ) -> _Positions:
        """Return positions all along the motion, closed as far as rows of the tolerance's rank can.

        They are reached on ways that go on as they begin, as far as motions allow.
        """
        rank = int((start.sizes > tolerance).sum())
        # What moves no loop is left where it is.
        free = start.right[0, rank:] * np.any(np.abs(start.right[0, :rank]) > _CLOSED, axis=0)
        ways = generic((round_ + 1) * _WAYS, max(len(free), 1))[-_WAYS:]
        ahead = ways[:, : len(free)] @ free
        x = {column: np.repeat(value, _WAYS) for column, value in start.x.items()}
        found = []
        for _ in range(steps):
            ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), _CLOSED)
            there = self.closed(self.moved(x, _STEP * ahead), None, tolerance)
            free = there.right.copy()
            free[:, : there.sizes.shape[1]][there.sizes > tolerance] = 0.0
            ahead = np.einsum("kin,kim,km->kn", free, free, ahead)
            x = dict(there.x)
            found.append(there)
        ranks = np.concatenate([(item.sizes > tolerance).sum(axis=1) for item in found])
        errors = np.concatenate([item.error for item in found])
        kept = (ranks == ranks.max()) & (errors <= tolerance)
        return self.at(
            {column: np.concatenate([item.x[column] for item in found])[kept] for column in x}
        )

    def _displaced(self, x: Mapping[int, Array], rank: int, tolerance: float) -> bool:
        """Displace frames so that loops close at positions; return whether they do."""
        # Conditions that depend on others do so but for the error. What counts as independent lies
        # halfway, in digits, between that and size one, and nearer where the error does not fall.
        # Where bars are in line, conditions are squares of how far numbers are off, which steps
        # halve. What asks for more than the tolerance is no matter of rounding.
        before, cut = np.inf, 1.0
        for _ in range(_MOST_STEPS):
            here = self.closed(x, rank, tolerance)
            error = float(here.error.max())
            if error <= 1e-2 * _CLOSED or 0.5 * before < error <= _CLOSED:
                return True
            cut = min(0.1 * cut if error > 0.5 * before else cut, np.sqrt(error))
            before = error
            null = here.left[:, :, rank:]
            growth = np.einsum("krs,krf->ksf", null, self._growth(here.at))
            left, sizes, right = np.linalg.svd(
                growth.reshape(-1, growth.shape[-1]), full_matrices=False
            )
            asked = -np.einsum("krs,kr->ks", null, here.errors).ravel() @ left
            least = max(cut, _LEVERS * error) * sizes.max(initial=0.0)
            taken = (sizes > least) & (np.abs(asked) <= tolerance * sizes)
            change = (asked[taken] / sizes[taken]) @ right[taken]
            for index, own in enumerate(change.reshape(-1, 6)):
                self.displacements[index] = self.displacements[index] * pinocchio.exp6(own)
            self._tree = self._displaced_tree()
            x = here.x
        return bool(self.closed(x, rank, tolerance).error.max() <= _CLOSED)

    def _flattened(self, start: _Positions, tolerance: float) -> bool:
        """Displace frames so that all axes are parallel; return whether they nearly are."""
        bodies, x, loops = self._tree.bodies, start.x, range(len(self._tree.loops))
        kinds = [[bodies[part].kind for part in parts] for parts in self._parts]
        every = {kind for joint in kinds for kind in joint}
        if "spherical" in every or "revolute" not in every:
            return False
        # A turn stands for its joint, a slide where there is none.
        stand = [
            parts["revolute" in joint and joint.index("revolute")]
            for parts, joint in zip(self._parts, kinds, strict=True)
        ]
        ways = [[self._axes(start.at, part)[1] for part in parts] for parts in self._parts]
        first = next(
            way
            for joint, found in zip(kinds, ways, strict=True)
            for kind, way in zip(joint, found, strict=True)
            if kind == "revolute"
        )
        normal, carriers, on_loops = np.zeros(3), set[int](), {body for _, body in self._frames}
        for parts, found in zip(self._parts, ways, strict=True):
            for part, way in zip(parts, found, strict=True):
                turns, along = bodies[part].kind == "revolute", first @ way
                if (np.linalg.norm(np.cross(first, way)) if turns else abs(along)) > tolerance:
                    return False
                # What stands where all loops do decides the normal; the others are turned to it.
                if turns and bodies[parts[0]].parent not in on_loops:
                    normal += np.sign(along) * way
                    carriers.add(bodies[parts[0]].parent)
        normal = normal / np.linalg.norm(normal) if normal.any() else first
        for body in carriers:  # Lengths are along its axes, one of which the numbers may mean.
            own = self._tree.axes.T if body < 0 else _columns(start.at.rotations[body])
            meant = own @ np.rint(normal @ own)
            normal = meant if np.abs(meant - normal).max() <= tolerance / _LEVERS else normal
        for place, ((_, body), part) in enumerate(zip(self._frames, stand, strict=True)):
            at = placed(self._tree, x)
            way, axes = self._axes(at, part)[1], self._axes(at, body)[0]
            turn = np.sign(way @ normal) * np.cross(way, normal)
            if bodies[part].kind == "prismatic":
                turn = (way @ normal) * np.cross(normal, way)
            self._displace(place, np.zeros(3), axes.T @ turn)
        for index in loops:
            (_, axes), (_, own) = self._ends(index, x)
            turn = np.cross(axes.T @ normal, own.T @ normal)
            self._displace(len(self._frames) + index, np.zeros(3), turn)
        # Along the normal, all frames share what is left.
        at, moves = placed(self._tree, x), np.zeros((len(loops), len(self.displacements)))
        for index in loops:
            start_path, end_path = (
                self._tree.path(end.body) for end in self._tree.loops[index][:2]
            )
            for place, (_, body) in enumerate(self._frames):
                moves[index, place] = (body in end_path) - (body in start_path)
            moves[index, len(self._frames) + index] = 1.0
        ends = [self._ends(index, x) for index in loops]
        gaps = [normal @ (point - other) for (point, _), (other, _) in ends]
        axes_of = [self._axes(at, body)[0] for _, body in self._frames] + [
            end[1][1] for end in ends
        ]
        for place, slide in enumerate(np.linalg.lstsq(moves, np.array(gaps))[0]):
            self._displace(place, slide * normal @ axes_of[place], np.zeros(3))
        return True

    def _axes(self, at: Placed, body: int) -> tuple[Array, Array]:
        """Return the axes of a joint's frame, as columns, and its direction, in the world."""
        axes = _columns(self._frame(at, body)[0])
        return axes, axes @ self._tree.bodies[body].directions[0]

    def _ends(self, index: int, x: Mapping[int, Array]) -> list[tuple[Array, Array]]:
        """Return points and axes, as columns, of both ends of a loop, in the world."""
        at, found = placed(self._tree, x), []
        for end in self._tree.loops[index][:2]:
            axes, lever = at.end(end)
            found.append((_columns([added(at.point(end.body), lever)])[:, 0], _columns(axes)))
        return found

    def _displace(self, place: int, slide: Array, turn: Array) -> None:
        """Displace a frame more, in its own axes."""
        own = pinocchio.exp6(np.concatenate([slide, turn]))
        self.displacements[place] = self.displacements[place] * own
        self._tree = self._displaced_tree()

    def _growth(self, at: Placed) -> Array:
        """Return `(K, R, 6 F)` how errors grow with displacements of frames, slides first."""
        tree = self._tree
        count = max(np.size(value) for rotation in at.rotations for value in rotation[0])
        result = np.zeros(
            (count, 6 * len(tree.loops) + len(tree.couplings), 6 * len(self.displacements))
        )
        for index, loop in enumerate(tree.loops):
            rows = slice(6 * index, 6 * index + 6)
            ends = loop.predecessor, loop.successor
            paths = [tree.path(end.body) for end in ends]
            for end, own, other, sign in zip(ends, paths, paths[::-1], (1.0, -1.0), strict=True):
                rotation, lever = at.end(end)
                point = added(at.point(end.body), lever)
                for place, (_, body) in enumerate(self._frames):
                    if body in own and body not in other:
                        self._add(result[:, rows], place, sign, *self._frame(at, body), point)
            place = len(self._frames) + index
            self._add(result[:, rows], place, -1.0, rotation, point, point)
        return result

    @staticmethod
    def _add(
        result: Array, place: int, sign: float, rotation: Rotation, origin: Vector, point: Vector
    ) -> None:
        """Write how a point and its axes move with a frame."""
        for axis, direction in enumerate(rotation):
            column = 6 * place + axis
            for row, (slides, turns) in enumerate(
                zip(direction, cross(direction, less(point, origin)), strict=True)
            ):
                result[:, row, column] = sign * slides
                result[:, row, column + 3] = sign * turns
                result[:, row + 3, column + 3] = sign * slides

    def _frame(self, at: Placed, body: int) -> tuple[Rotation, Vector]:
        """Return where the frame of a body's joint is before the joint moves."""
        own = self._tree.bodies[body]
        carrier = UNTURNED if own.parent < 0 else at.rotations[own.parent]
        return product(carrier, own.rotation), added(
            at.point(own.parent), turned(carrier, own.translation)
        )

    def _displaced_tree(self) -> Tree:
        """Return the tree with displaced frames."""
        bodies, loops = list(self._original.bodies), list(self._original.loops)
        frames = len(self._frames)
        for (_, body), displacement in zip(self._frames, self.displacements[:frames], strict=True):
            bodies[body] = _displaced(bodies[body], displacement)
        for index, displacement in enumerate(self.displacements[frames:]):
            end = _displaced(loops[index].successor, displacement)
            loops[index] = loops[index]._replace(successor=end)
        return self._original._replace(bodies=tuple(bodies), loops=tuple(loops))

    def _nearest(self) -> Nearest:
        """Return what was changed."""
        names = [(name, False) for name, _ in self._frames] + [(name, True) for name in self.loops]
        displacements, greatest = {}, 0.0
        for name, item in zip(names, self.displacements, strict=True):
            vector = pinocchio.log6(item).vector
            size = float(max(np.linalg.norm(vector[:3]), np.linalg.norm(vector[3:])))
            greatest = max(greatest, size)
            if size > _CLOSED:
                displacements[name] = item.homogeneous
                displacements[name][:3, 3] *= self._tree.length
        return Nearest(displacements, greatest)


def _columns(vectors: Sequence[Vector]) -> Array:
    """Return vectors at one position as columns `(3, n)`."""
    return np.array([[np.ravel(entry)[0] for entry in vector] for vector in vectors]).T


def _displaced(item: Any, displacement: pinocchio.SE3) -> Any:
    """Return a body or an end whose frame is displaced in its own axes."""
    frame = pinocchio.SE3(np.array(item.rotation).T, np.array(item.translation)) * displacement
    rotation = tuple(map(tuple, frame.rotation.T.tolist()))
    return item._replace(rotation=rotation, translation=tuple(frame.translation.tolist()))
