"""Problem solver: closed positions, motion, wrenches and their proof, for a problem's positions."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...kit.arrays import LARGE_BLOCK, Array, flat
from ...kit.errors import ArgumentError, CardanError, IndeterminateError
from ...kit.frozen import Frozen, read_only
from ...kit.threads import in_threads
from ..elements.link_loads import WRENCH_COMPONENTS
from ..kinematics.assembly import Assembly
from ..kinematics.closing.all_groups import ClosedState, Kinematics
from ..kinematics.following.guesses import Guess
from ..kinematics.loops.needs import solved_couplings
from ..kinematics.tolerances import CLOSURE_TOLERANCE, REGULAR_CONDITION
from ..mechanism.kept import Kept
from ..problem.acting import Acting
from ..problem.arguments import wanted_outputs
from ..problem.problem import Problem
from ..problem.samples import Targets

if TYPE_CHECKING:
    from ..kinematics.loops.groups import Group
    from .inverse_dynamics import Inputs, InverseDynamics, Solution
    from .taped import TapedSolver
    from .velocity_ratios import VelocityRatios

_BLOCK_NUMBERS = 6_000_000
"""About how many numbers (48 MB) the arrays of a block hold: of large mechanisms, a block has fewer
samples, so that memory does not grow with the mechanism."""
_NUMBERS_PER_COORDINATE = 100
"""Numbers of a sample that a joint coordinate adds to these arrays, 72 of them in action matrices
and their products; a velocity ratio per drive comes on top."""
_MOST_RATES = 4_000_000
"""Velocities, accelerations and velocity ratios (32 MB) that a sweep of several blocks keeps. More
of them are computed from closed coordinates when they are asked for, in a third of its time."""

_LITTLE = 8.0 * _MOST_RATES
"""Memory [bytes] that is not asked for."""

# The GNU C library gives free memory at the end of its heap back once it exceeds twice the largest
# piece that was ever freed by itself, and a block would take all of it anew, page by page.
np.empty(_BLOCK_NUMBERS // 2)


@dataclass(frozen=True, eq=False, repr=False)
class AssembledPositions:
    """Drive positions with their loops closed; `Scene.assemble` makes them for `Scene.sweep`.

    `len()` is the number of samples.

    Attributes:
        solver: the solver that closed the loops.
        targets: what it closed them at.
        turns: whole turns `(N, size)` to be added to the angles of the blocks' coordinates.
        spans: samples of each block.
        blocks: the closed state of each block: a list, or `InTurn`.
        along_path: whether every sample was followed from the one before it.
    """

    solver: ProblemSolver
    targets: Targets
    turns: Array
    spans: list[slice]
    blocks: Sequence[ClosedState]
    along_path: bool

    def __post_init__(self) -> None:
        self.targets.given.setflags(write=False)
        self.turns.setflags(write=False)

    def __len__(self) -> int:
        return self.targets.size

    def __reduce__(self) -> tuple[object, ...]:
        # Closing them again takes less than storing all that was computed.
        return self.solver.assemble, (self.targets, self.along_path)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self.targets.shape

    def __repr__(self) -> str:
        return f"<{len(self)} assembled positions of {self.solver.problem.mechanism.name!r}>"


class InTurn(Sequence[ClosedState]):
    """Blocks that are closed whenever they are read, so that only one is in memory at a time.

    Attributes:
        spans: samples of each block.
    """

    def __init__(self, solver: ProblemSolver, targets: Targets, guess: Guess, spans: list[slice]):
        """Keep what closes them.

        Args:
            solver: its assembly closes the loops.
            targets: N samples.
            guess: near them.
            spans: see the attribute.
        """
        self.spans = spans
        self._solver, self._targets, self._guess = solver, targets, guess

    def __len__(self) -> int:
        return len(self.spans)

    def __getitem__(self, index: Any) -> Any:
        span = self.spans[index]
        positions = self._targets.block(span).positions
        return self._solver.assembly.close(self.guess(index), positions, span.start)

    def guess(self, index: int) -> Guess:
        """Return near what a block is closed."""
        span = self.spans[index]
        whole = span is self.spans[-1] and span.start == 0
        return self._guess if whole else self._guess.of_samples(span)

    def given_up(self) -> Array:
        """Return the guesses `(N, size)`: of a block that was read, they may be overwritten."""
        return self._guess.x


class ProblemSolver(Frozen):
    """Solves a problem at any drive positions.

    It does not change, except that its assembly keeps what it learns about the motion; threads may
    share it.

    Attributes:
        problem: the problem that it solves.
        varied: names of the held joints whose positions differ from sample to sample.

    Raises:
        ArgumentError, AssemblyError, MobilityError, SingularConfigurationError: see `Assembly`.
    """

    def __init__(
        self,
        problem: Problem,
        like: ProblemSolver | None = None,
        varied: tuple[str, ...] = (),
        in_turn: bool = False,
    ) -> None:
        """Make the solver.

        Args:
            problem: the problem to solve.
            like: solver of a similar problem. Its assembly, with all that it has learned about the
                motion, is shared if the problems differ in nothing that the motion depends on, and
                what it has made besides if they differ in what sweeps say anew.
            varied: see the attribute. With them, `like` solves the same problem without.
            in_turn: whether these joints move one after the other, as to the start of a scene.
        """
        self.problem, self.varied = problem, varied
        # How a copy is made, with what it shares; None for a solver that shares nothing.
        self._made_by: tuple[object, ...] | None = None
        # Whose design it is, if it is one.
        self._family: ProblemSolver | None = None
        if like is not None and varied:
            self._made_by = ProblemSolver.of_varied, (like, varied)
        self._of_varied: dict[tuple[tuple[str, ...], bool], ProblemSolver] = {}
        self._lock = threading.Lock()
        if like is not None and varied:
            self.assembly = Assembly(problem, varied, like.assembly, in_turn=in_turn)
        elif like is not None and problem.moves_like(like.problem):
            self._family = like._family
            made, known = self.__dict__, like.__dict__
            shared = {"assembly", "closing"}
            if problem.solved_like(like.problem):
                shared.add("_kinematics")
                for name in known.keys() & {"inverse_dynamics", "taped"}:
                    made[name] = known[name].of(problem)
            made.update((name, known[name]) for name in known.keys() & shared)
        else:
            self.assembly = Assembly(problem)
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return self._made_by or (ProblemSolver, (self.problem,))

    @cached_property
    def assembly(self) -> Assembly:
        """Closes the loops; of designs, whose sweeps do without, it is made where it is needed."""
        return Assembly(self.problem)

    @cached_property
    def closing(self) -> Assembly:
        """Closes the loops of sweeps: `assembly`, or that of the scene whose design this is."""
        return self.assembly

    @cached_property
    def _kinematics(self) -> Kinematics:
        """That of the assembly, for the drives alone."""
        kinematics = self.closing.kinematics
        if not self.varied:
            return kinematics
        # Held joints rest: nobody asks how fast others would move with them.
        drives = list(range(len(self.problem.independent)))
        return kinematics.part(drives, list(range(len(kinematics.solvers))))

    @cached_property
    def _groups(self) -> list[tuple[Group, bool]]:
        """The groups that are solved, and whether their forces are, too."""
        needed = self.closing.needed
        return [(self.closing.groups[index], index in needed.forces) for index in needed.motion]

    @cached_property
    def inverse_dynamics(self) -> InverseDynamics:
        """Proves what is found of samples."""
        # What is made only to be looked at needs none of this.
        from .inverse_dynamics import InverseDynamics

        assembly = self.closing
        bodies, decided = assembly.needed.known_bodies, assembly.decided
        of_groups = self._kinematics, self._groups, bodies, decided
        return InverseDynamics(self.problem, *of_groups, assembly.start)

    @cached_property
    def taped(self) -> TapedSolver:
        """Solves samples."""
        from .taped import TapedSolver

        return TapedSolver(
            self.problem,
            self.varied,
            self._groups,
            self.inverse_dynamics.claimed,
            self.closing,
            self.closing.needed.efforts_alone,
        )

    @cached_property
    def parameters(self) -> Kept:
        """What names of parameters say."""
        return Kept()

    def of_varied(
        self, names: tuple[str, ...], begun: Mapping[str, float] | None = None
    ) -> ProblemSolver:
        """Return the solver of the same problem for other positions of some held joints.

        Args:
            names: of these joints.
            begun: where all but the first of them are before they move one after the other, as on
                the way to the start of a scene. They move together if there are none.
        """
        if names == self.varied:
            return self
        with self._lock:
            key = names, bool(begun)
            if key not in self._of_varied:
                before = self.problem.holding(begun or {})
                like = self if before.held == self.problem.held else ProblemSolver(before)
                self._of_varied[key] = ProblemSolver(before, like, *key)
            return self._of_varied[key]

    def at_design(self, positions: Mapping[str, float]) -> ProblemSolver:
        """Return the solver of the problem that holds the varied joints at some positions.

        It shares all that is known here.

        Args:
            positions: of the varied joints [rad or m].
        """
        solver = ProblemSolver.__new__(ProblemSolver)
        solver.assembly = solver.closing = self.closing.at_design(positions)
        solver.problem, solver.varied, solver._family = self.problem.holding(positions), (), self
        solver._made_by = ProblemSolver.at_design, (self, dict(positions))
        solver._of_varied, solver._lock = {}, threading.Lock()
        shared = {"inverse_dynamics": self.inverse_dynamics, "taped": self.taped}
        solver._freeze(_kinematics=self._kinematics, **shared)
        return solver

    def changed(self, problem: Problem) -> ProblemSolver:
        """Return the solver of another problem; what does not differ is shared.

        Raises:
            CardanError: as `ProblemSolver` does.
        """
        design = None
        if moved := problem.held_elsewhere(self.problem):
            with suppress(CardanError):
                design = self._moving(moved)._led_to(problem)
        return design or ProblemSolver(problem, like=self)

    def _moving(self, moved: tuple[str, ...]) -> ProblemSolver:
        """Return the solver whose designs hold some joints anywhere, on the way of new scenes.

        That way is the same up to the first of them. What moves behind it moves anew.
        """
        family, held = self._family, self.problem.held
        wanted = {*moved, *(family.varied if family else ())}
        if family and len(wanted) == len(family.varied):
            return family
        columns = self.problem.mechanism.coordinates.columns_of(held)
        begun = dict(zip(held, self.closing.begun[columns].tolist(), strict=True))
        names = list(held)
        names = names[min(map(names.index, wanted)) :]
        varied = tuple(name for name in names if name in wanted or held[name] != begun[name])
        return self.of_varied(varied, {name: begun[name] for name in varied[1:]})

    def _led_to(self, problem: Problem) -> ProblemSolver | None:
        """Return the solver of a problem that holds the varied joints elsewhere.

        None where its start leaves doubts, which a solver of its own tells.
        """
        columns = problem.mechanism.coordinates.columns_of(problem.independent)
        drives = self.closing.start[columns][None, :]
        design = self.at_design({name: problem.held[name] for name in self.varied})
        # One of its own is made where sweeps do not suffice, and by copies.
        design.__dict__.pop("assembly")
        design.__dict__["_made_by"] = None
        start = design.closing.guesses(Targets.of_positions(drives))
        state = design.closing.kinematics.evaluate(start.x)
        is_closed = state.residual[0] < CLOSURE_TOLERANCE
        return design if is_closed and state.condition[0] < REGULAR_CONDITION else None

    @cached_property
    def complete(self) -> ProblemSolver:
        """The solver of the scene with all joints as outputs, that chooses what is left open."""
        problem = self.problem
        if problem.all_outputs and not problem.strict:
            return self
        outputs = wanted_outputs(problem.mechanism, None)
        every = replace(problem, outputs=outputs, all_outputs=True, strict=False)
        return ProblemSolver(every, like=self)

    @cached_property
    def without_elements(self) -> ProblemSolver:
        """The solver of the same scene without force elements."""
        if not self.problem.elements:
            return self
        return ProblemSolver(replace(self.problem, elements=()), like=self)

    @property
    def has_mass(self) -> bool:
        """Whether any body has mass, or a joint a rotor."""
        return self.inverse_dynamics.has_mass

    @cached_property
    def couplings(self) -> dict[int, str]:
        """Indices and names of the couplings whose moments are solved."""
        indices = solved_couplings(self.closing.groups, self.closing.needed)
        return {index: self.problem.mechanism.couplings[index].name for index in indices}

    def knows_effort(self, joint: str) -> bool:
        """Return whether what acts along a driven or held coordinate is solved."""
        needed, mechanism = self.closing.needed, self.problem.mechanism
        if needed.efforts_alone:
            return joint in self.problem.independent
        return mechanism.joints[mechanism.drivable[joint].joint].id - 1 in needed.known_bodies

    @cached_property
    def knows_drive_efforts(self) -> bool:
        """Whether what acts along all driven coordinates is solved."""
        return all(map(self.knows_effort, self.problem.independent))

    @cached_property
    def known_holding_efforts(self) -> dict[str, int]:
        """Names of the held coordinates whose efforts are solved, to their columns."""
        held = enumerate(self.problem.held, len(self.problem.independent))
        return {name: column for column, name in held if self.knows_effort(name)}

    @cached_property
    def unsolved(self) -> list[int]:
        """Velocity coordinates of passive joints whose motion is not solved, ascending."""
        passives = set(self.problem.passive_columns.tolist())
        return sorted(passives - set(self.closing.decided.tolist()))

    def assemble(self, targets: Targets, along_path: bool = False) -> AssembledPositions:
        """Return targets with all their loops closed, to be used again.

        Args:
            targets: N samples; the joints that they vary are those of this solver.
            along_path: see `Scene.sweep`.

        Raises:
            ArgumentError: there are too many for the memory of the machine.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        self.refuse_too_many(targets.size, kept_closed=True)
        assembled = self.assembled_in_turn(targets, along_path)
        return replace(assembled, blocks=list(assembled.blocks))

    def assembled_in_turn(self, targets: Targets, along_path: bool = False) -> AssembledPositions:
        """Return targets whose blocks are closed one by one whenever they are read, see `InTurn`.

        Arguments and errors as of `assemble`; the latter are raised while the blocks are read.
        """
        # A branch of its own, once it is followed, serves many samples better.
        if self._family and not along_path and targets.size <= self._block_size(targets):
            with suppress(CardanError):  # An assembly of its own says what it is about this scene.
                return self._in_blocks(targets, self.closing.guesses(targets), False)
        return self._in_blocks(targets, self.assembly.guesses(targets, along_path), along_path)

    def assembled_near(self, targets: Targets, x: Array, turns: Array) -> AssembledPositions:
        """Return targets that are closed near given coordinates, see `assembled_in_turn`.

        Args:
            targets: N samples of the drives.
            x: `(N, size)` closed coordinates up to rounding, exact in the drives; `solve` may
                overwrite them with its own.
            turns: `(N, size)` whole turns that the angles in `x` lack.
        """
        return self._in_blocks(targets, Guess(x, turns, is_closed=True), True)

    def assembled_at(self, targets: Targets, near: Mapping[str, Array]) -> AssembledPositions:
        """Return what `assembled_in_turn` does, where positions of the joints are known already.

        Nothing is followed from the start: the loops are closed from there, and proven as always.

        Args:
            targets: N samples.
            near: joints to their coordinates up to rounding, in a shape that broadcasts with that
                of the samples, of balls with a last axis; others stand as at the start.

        Raises:
            ArgumentError: there are too many for the memory of the machine.
        """
        self.refuse_too_many(targets.size)
        coordinates = self.problem.mechanism.coordinates
        x = np.tile(self.closing.start, (targets.size, 1))
        for name, values in near.items():
            columns = coordinates.columns[name]
            is_ball = columns.stop - columns.start > 1
            every = flat(values, targets.shape, trailing=int(is_ball))
            x[:, columns] = every.reshape(targets.size, -1)
        turns = np.zeros_like(x)
        angles = np.setdiff1d(coordinates.angle_columns, self.problem.mechanism.curving_columns)
        turns[:, angles] = np.rint(x[:, angles] / (2.0 * np.pi))
        x -= 2.0 * np.pi * turns
        given = coordinates.columns_of((*self.problem.independent, *self.varied))
        x[:, given], turns[:, given] = targets.prescribed, 0.0
        return self._in_blocks(targets, Guess(x, turns), False)

    def _in_blocks(self, targets: Targets, guess: Guess, along_path: bool) -> AssembledPositions:
        """Return targets whose blocks are closed from a guess whenever they are read."""
        count = targets.size
        spans = [slice(0, count)]
        if count > 1:
            block_size = self._block_size(targets)
            # Blocks of equal size: a small last one would cost almost as much as a large one.
            blocks_needed = -(-count // block_size)
            ends = [count * block // blocks_needed for block in range(blocks_needed + 1)]
            spans = [slice(*span) for span in pairwise(ends)]
        blocks = InTurn(self, targets, guess, spans)
        return AssembledPositions(self, targets, guess.turns, spans, blocks, along_path)

    def _block_size(self, targets: Targets) -> int:
        """Return how many samples are worked on at a time."""
        of_each = _NUMBERS_PER_COORDINATE + targets.given.shape[-1]
        numbers = self.problem.mechanism.model.nv * of_each
        return max(1, min(LARGE_BLOCK, _BLOCK_NUMBERS // numbers))

    def refuse_others(self, assembled: AssembledPositions) -> None:
        """Refuse positions that another scene assembled.

        Raises:
            ArgumentError: it did.
        """
        solver = assembled.solver
        if solver is not self and self._of_varied.get((solver.varied, False)) is not solver:
            raise ArgumentError(
                "these positions were assembled by another scene; assemble them again"
            )

    def solve(self, assembled: AssembledPositions, acting: Acting) -> Solution:
        """Return all that is solved and proven at assembled positions.

        Args:
            assembled: N samples of this solver. Those whose blocks are closed in turn are used up.
            acting: how fast the drives move and what acts; it broadcasts with the samples.

        Raises:
            AccuracyError: a residual exceeds its tolerance, or flags of uniqueness are wrong.
            IndeterminateError: a component of an output is not unique, and the problem is strict.
        """
        work = Work(self, assembled, acting)
        if len(assembled.spans) == 1:
            solution = work.block(0)
            solution.prove(assembled.targets.positions)
        else:
            solution = work.all()
        self.inverse_dynamics.prove_flags(solution)
        if self.problem.strict:
            self.refuse_indeterminate(solution.unique[self.problem.output_indices])
        return solution

    def moved(
        self, assembled: AssembledPositions, acting: Acting, rates: Array
    ) -> tuple[Array, Array, Array]:
        """Return coordinates `(N, size)`, and velocities and accelerations `(N, k)` of some rates.

        Loops are closed to rounding; nothing else is proven.

        Args:
            assembled: N samples of this solver, used up as by `solve`.
            acting: how fast the drives move; it broadcasts with the samples.
            rates: `(k,)` velocity coordinates.

        Raises:
            AccuracyError: numbers overflow.
        """
        work, blocks, count = Work(self, assembled, acting), assembled.blocks, len(assembled)
        # Coordinates take the place of the guesses that they are found from.
        x = blocks.given_up() if isinstance(blocks, InTurn) else np.empty(assembled.turns.shape)
        v, a = np.empty((2, count, len(rates)))

        def put(index: int) -> None:
            span, found = assembled.spans[index], self.taped.moved(*work.given(index))
            # What is found has a row for each coordinate, which is gathered as a whole.
            x[span], v[span], a[span] = found.x, found.v.T[rates].T, found.a.T[rates].T

        in_threads(put, range(len(assembled.spans)))
        self.inverse_dynamics.refuse_overflown({"x": x, "v": v, "a": a})
        return x, v, a

    def sought(self, assembled: AssembledPositions, acting: Acting) -> tuple[Array, Array]:
        """Return wrenches `(N, k, 6)` and efforts `(N, p)`, see `Solution`; none is proven.

        For what looks for a place and has only that one proven; arguments as of `solve`.

        Raises:
            AccuracyError: numbers overflow.
        """
        work, columns = Work(self, assembled, acting), self.problem.prescribed_columns
        every = [self.taped.found(*work.given(k))[0] for k in range(len(assembled.spans))]
        efforts = np.concatenate([found.efforts.take(columns, 1) for found in every])
        wrenches = np.concatenate([found.wrenches for found in every])
        wrenches = wrenches.reshape(len(efforts), -1, 6)[:, self.problem.output_indices]
        self.inverse_dynamics.refuse_overflown({"wrenches": wrenches, "efforts": efforts})
        return wrenches, efforts

    def keeps_rates(self, count: int) -> bool:
        """Return whether a sweep of several blocks, of that many samples, keeps its rates."""
        # The accelerations of rods that spin idly depend on forces.
        is_idle = self.closing.kinematics.idle_columns.size > 0
        return is_idle or count * self._rates_of_sample <= _MOST_RATES

    @property
    def _rates_of_sample(self) -> int:
        """Number of velocities, accelerations and velocity ratios of a sample."""
        nv, depends = self.problem.mechanism.model.nv, self.closing.kinematics.depends
        return int(2 * nv + (nv if depends is None else np.count_nonzero(depends)))

    def refuse_too_many(self, count: int, kept_closed: bool = False) -> None:
        """Refuse to compute what does not fit into the memory of the machine.

        Args:
            count: number of samples.
            kept_closed: whether all that is known of their closed positions is kept.

        Raises:
            ArgumentError: the samples keep more.
        """
        if count * self.problem.mechanism.model.nv < _MOST_RATES:
            return  # Few sweeps are so large, and most would pay for the question.
        problem = self.problem
        coordinates, hint = problem.mechanism.coordinates, "; take fewer at a time"
        numbers = 2 * coordinates.size
        if kept_closed:
            numbers += _NUMBERS_PER_COORDINATE * coordinates.model.nv
        else:
            numbers += 6 * len(problem.outputs) + len(problem.prescribed_columns) + 1
            numbers += len(problem.mechanism.couplings)
            if self.keeps_rates(count):
                numbers += self._rates_of_sample
            hint += ", or fewer outputs" if len(problem.outputs) > 1 else ""
            if len(problem.independent) == 1 and not (problem.elements or self.varied):
                hint += ", or sweep Scene.response(), which computes what is read of it alone"
            hint += ", or let a study of studies.Sweeps keep what is wanted of them on disk"
        refuse_beyond_memory(count, numbers, hint)

    def rates_at(
        self, assembled: AssembledPositions, x: Array, acting: Acting
    ) -> tuple[Array, Array, VelocityRatios]:
        """Return velocities and accelerations `(N, nv)` and velocity ratios of a solution.

        Args:
            assembled: its N positions.
            x: `(N, size)` its closed coordinates.
            acting: how fast the drives move.
        """
        from .collected import Rows  # Few sweeps leave their rates out.
        from .velocity_ratios import VelocityRatios

        rows = Rows(len(x))
        for span in assembled.spans:
            given = acting.flat(assembled.shape, span)
            state = assembled.solver.closing.kinematics.evaluate(x[span])
            rates = self.inverse_dynamics.joint_rates(state, given.speeds, given.accelerations)
            ratios = VelocityRatios.of(rates.velocity_ratios, rates.depends)
            rows.put(span, {"v": rates.v, "a": rates.a, "ratios": ratios.values})
        values = read_only(rows.arrays["ratios"])
        return rows.arrays["v"], rows.arrays["a"], ratios._replace(values=values)

    def magnification_at(self, assembled: AssembledPositions, x: Array) -> Array:
        """Return `(N,)` by how much rounding is magnified, see `InverseDynamics.condition`.

        Arguments as of `rates_at`.
        """
        found = []
        for span in assembled.spans:
            state = assembled.solver.closing.kinematics.evaluate(x[span])
            ratios = self._kinematics.velocity_ratios(state)
            found.append(self.inverse_dynamics.condition(state, ratios))
        return np.concatenate(found)

    def refuse_indeterminate(self, unique: Array) -> None:
        """Refuse outputs that are not unique if the problem is strict.

        Compliances decide what statics leaves open, but not which forces a coupling exerts.

        Args:
            unique: `(k, 6)` which components of the outputs are unique.

        Raises:
            IndeterminateError: the problem is strict and wants a component that is not unique.
        """
        problem = self.problem
        if not problem.strict or np.all(unique):
            return
        from ..mechanism.undescribed import REMEDY, greatest_changes
        from .inverse_dynamics import UNIQUE_TOLERANCE

        silent = problem.mechanism.undescribed
        if problem.compliance:
            unique = greatest_changes(silent, problem.outputs) < UNIQUE_TOLERANCE
            if np.all(unique):
                return
        components = {
            name: [label for label, flag in zip(WRENCH_COMPONENTS, row, strict=True) if not flag]
            for name, row in zip(problem.outputs, unique, strict=True)
            if not np.all(row)
        }
        listed = "; ".join(f"{name}: {', '.join(labels)}" for name, labels in components.items())
        told = [item.told() for item in silent if components.keys() & item.changes.keys()]
        advice = (
            f"{'; '.join(told)}: {REMEDY}"
            if told
            else "Give compliances, change the mechanism (a slide, a ball) or leave strict out to "
            "have the least norm"
        )
        raise IndeterminateError(
            f"{problem.mechanism.name}: the laws of motion leave open: {listed}. "
            f"{advice[0].upper()}{advice[1:]}",
            components=components,
        )


class Work:
    """Blocks of a sweep to be solved."""

    def __init__(self, solver: ProblemSolver, assembled: AssembledPositions, acting: Acting):
        """Begin with none; arguments as of `ProblemSolver.solve`."""
        self._solver, self._assembled, self._acting = solver, assembled, acting
        problem, self._has_rates = solver.problem, None
        self._everywhere = problem.acting_everywhere if acting is problem.acting else None
        if self._everywhere is not None:
            self._has_rates = False
        elif len(assembled.spans) > 1:
            self._has_rates = acting.has_rates

    def block(self, index: int) -> Solution:
        """Return what is kept of a block."""
        solver = self._solver
        return solver.taped.solution(solver.inverse_dynamics, *self.given(index))

    def given(self, index: int) -> tuple[Array, Inputs, Callable[[Array], ClosedState]]:
        """Return what samples of a block are solved from, see `TapedSolver.solution`."""
        assembled, solver = self._assembled, self._solver
        span, turns = assembled.spans[index], assembled.turns
        targets, dynamics = assembled.targets, solver.inverse_dynamics
        if len(assembled.spans) > 1:
            targets, turns = targets.block(span), turns[span]
        acting = self._everywhere or self._acting.flat(assembled.shape, span)
        blocks = assembled.blocks
        guess = blocks.guess(index) if isinstance(blocks, InTurn) else None
        x, is_closed = (blocks[index].x, True) if guess is None else (guess.x, guess.is_closed)
        given = targets, acting, turns, self._has_rates, is_closed
        inputs = dynamics.inputs_of(solver.problem, *given)

        def close(samples: Array) -> ClosedState:
            if guess is None:
                return solver.closing.kinematics.evaluate(x[samples])
            closing = guess.of_samples(samples), inputs.positions[samples]
            return solver.assembly.close(*closing, span.start)

        return x, inputs, close

    def all(self) -> Solution:
        """Return what is kept of all blocks, see `collected`."""
        from .collected import collected  # Many sweeps are a single block.

        assembled = self._assembled

        def positions_of(index: int) -> Array:
            return assembled.targets.block(assembled.spans[index]).positions

        # Coordinates take the place of the guesses that they were found from.
        guesses = assembled.blocks.given_up() if isinstance(assembled.blocks, InTurn) else None
        keeps_rates = self._solver.keeps_rates(len(assembled))
        return collected(assembled.spans, self.block, positions_of, guesses, keeps_rates)


def refuse_beyond_memory(count: int, numbers: int, hint: str) -> None:
    """Refuse samples of so many numbers each; what to do follows the message.

    Raises:
        ArgumentError: they do not fit into the memory of the machine.
    """
    needed = 8.0 * count * numbers
    if needed < _LITTLE:  # Most would pay for the question.
        return
    memory = _memory()
    if needed > memory:
        raise ArgumentError(
            f"{count} samples keep {needed / 1e9:.3g} GB, more than the {memory / 1e9:.3g} GB "
            f"of memory of this machine{hint}"
        )


def _memory() -> float:
    """Return the memory of the machine [bytes], infinity where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return math.inf
