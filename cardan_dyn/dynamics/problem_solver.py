"""Problem solver: closed positions, motion, wrenches and their proof, for a problem's positions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError, IndeterminateError
from ..forces.link_loads import WRENCH_COMPONENTS
from ..frozen import Frozen, read_only
from ..kinematics.all_groups import ClosedState, Kinematics
from ..kinematics.assembly import Assembly
from ..kinematics.needs import solved_couplings
from ..problem.problem import Problem
from .indeterminate import IndeterminacyRule, LeastEnergy, LeastNorm
from .inverse_dynamics import Inputs, InverseDynamics, Solution, joined
from .reactions import ReactionSolver, wrenches_in_norm

_BLOCK_SIZE = 768
"""Greatest number of samples worked on at a time, so that their arrays stay in the cache."""
_BLOCK_NUMBERS = 6_000_000
"""About how many numbers (48 MB) the arrays of a block hold: of large mechanisms, a block has fewer
samples, so that memory does not grow with the mechanism."""
_NUMBERS_PER_COORDINATE = 100
"""Numbers of a sample that a joint coordinate adds to these arrays, 72 of them in action matrices
and their products; a velocity ratio per drive comes on top."""
_DECIDE_ASSEMBLY = frozenset(
    {"mechanism", "drives", "held", "start", "start_balls", "branch", "outputs", "all_outputs"}
)
"""Attributes of a problem that decide how its loops are closed."""


@dataclass(frozen=True, eq=False, repr=False)
class AssembledPositions:
    """Drive positions with their loops closed; `Scene.assemble` makes them for `Scene.sweep`.

    `len()` is the number of positions.

    Attributes:
        solver: the solver that closed the loops.
        positions: of the drives `(N, d)`.
        turns: whole turns `(N, size)` to be added to the angles of the blocks' coordinates.
        spans: samples of each block.
        blocks: the closed state of each block: a list, or an iterator that closes block by block
            and can be read only once.
        kinematics: the kinematics that the loops are closed with.
        along_path: whether every sample was followed from the one before it.
    """

    solver: ProblemSolver
    positions: Array
    turns: Array
    spans: list[slice]
    blocks: Iterable[ClosedState]
    kinematics: Kinematics
    along_path: bool

    def __post_init__(self) -> None:
        read_only(self.positions)
        read_only(self.turns)

    def __len__(self) -> int:
        return len(self.positions)

    def __reduce__(self) -> tuple[object, ...]:
        # Closing them again takes less than storing all that was computed.
        return self.solver.assemble, (self.positions, self.along_path)

    def __repr__(self) -> str:
        return f"<{len(self)} assembled positions of {self.solver.problem.mechanism.name!r}>"


class ProblemSolver(Frozen):
    """Solves a problem at any drive positions.

    It does not change, except that its assembly keeps what it learns about the motion; threads may
    share it.

    Attributes:
        problem: the problem that it solves.
        assembly: closes the loops.
        reactions: computes the wrenches at closed positions.
        inverse_dynamics: computes motion, wrenches and residuals at closed positions.

    Raises:
        ArgumentError, AssemblyError, MobilityError, SingularConfigurationError: see `Assembly`.
    """

    def __init__(self, problem: Problem, like: ProblemSolver | None = None) -> None:
        """Make the solver.

        Args:
            problem: the problem to solve.
            like: solver of a similar problem. Its assembly, with all that it has learned about the
                motion, is shared if the problems differ in nothing that the motion depends on.
        """
        self.problem = problem
        mechanism = problem.mechanism
        if like is not None and not problem.differs_from(like.problem) & _DECIDE_ASSEMBLY:
            self.assembly: Assembly = like.assembly
        else:
            self.assembly = Assembly(problem)
        kinematics, needed = self.assembly.kinematics, self.assembly.needed
        counted = wrenches_in_norm(mechanism)
        rule: IndeterminacyRule = LeastNorm(mechanism.characteristic_length, counted)
        if problem.compliance:
            compliances = {
                problem.wrench_index(name): value for name, value in problem.compliance.items()
            }
            rule = LeastEnergy(mechanism.characteristic_length, counted, compliances)
        # Of all groups, `kinematics` has only those whose motion is needed, so indices differ.
        active = {solved for solved, index in enumerate(needed.motion) if index in needed.forces}
        self.reactions = ReactionSolver(mechanism, kinematics, active, rule)
        self.inverse_dynamics = InverseDynamics(
            problem, kinematics, self.reactions, needed, self.assembly.decided
        )
        self._freeze()

    def __reduce__(self) -> tuple[object, ...]:
        return ProblemSolver, (self.problem,)

    @property
    def has_mass(self) -> bool:
        """Whether any body has mass."""
        return self.inverse_dynamics.has_mass

    @property
    def couplings(self) -> dict[int, str]:
        """Indices and names of the couplings whose moments are solved."""
        indices = solved_couplings(self.assembly.groups, self.assembly.needed)
        return {index: self.problem.mechanism.couplings[index].name for index in indices}

    def knows_effort(self, joint: str) -> bool:
        """Return whether what acts along a driven or held coordinate is solved."""
        needed, mechanism = self.assembly.needed, self.problem.mechanism
        if needed.efforts_alone:
            return joint in self.problem.drives
        return mechanism.joints[mechanism.drivable[joint].joint].id - 1 in needed.known_bodies

    def assemble(self, positions: Array, along_path: bool = False) -> AssembledPositions:
        """Return drive positions `(N, d)` with all their loops closed, to be used again.

        Args:
            positions: [rad or m].
            along_path: see `Scene.sweep`.

        Raises:
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        assembled = self.assembled_in_turn(positions, along_path)
        return replace(assembled, blocks=list(assembled.blocks))

    def assembled_in_turn(self, positions: Array, along_path: bool = False) -> AssembledPositions:
        """Return drive positions `(N, d)` whose blocks are closed one by one as they are read.

        So only one block's arrays are in memory at a time. Arguments and errors as of `assemble`;
        the latter are raised while the blocks are read.
        """
        guess = self.assembly.guesses(positions, along_path)
        # Blocks of equal size: a small last one would cost almost as much as a large one.
        numbers = self.problem.mechanism.model.nv * (_NUMBERS_PER_COORDINATE + positions.shape[1])
        block_size = max(1, min(_BLOCK_SIZE, _BLOCK_NUMBERS // numbers))
        count = max(1, -(-len(positions) // block_size))
        ends = np.linspace(0, len(positions), count + 1).astype(int).tolist()
        spans = [slice(*span) for span in pairwise(ends)]
        blocks = (self.assembly.close(guess.block(span), positions[span]) for span in spans)
        return AssembledPositions(
            self, positions, guess.turns, spans, blocks, guess.kinematics, along_path
        )

    def current(self, assembled: AssembledPositions) -> AssembledPositions:
        """Return assembled positions that suit what is known of the motion now.

        They are closed again if since then other rows of the closure equations were found to be
        redundant.

        Raises:
            ArgumentError: they were assembled by another scene.
        """
        if assembled.solver is not self:
            raise ArgumentError(
                "these positions were assembled by another scene; assemble them again"
            )
        used, known = assembled.kinematics.reductions, self.assembly.kinematics.reductions
        # By identity, since reductions hold arrays, which `==` does not compare as a whole.
        if any(first is not second for first, second in zip(used, known, strict=True)):
            return self.assembled_in_turn(assembled.positions, assembled.along_path)
        return assembled

    def solve(self, assembled: AssembledPositions, speeds: Array, accelerations: Array) -> Solution:
        """Return all that is solved and proven at assembled positions.

        Args:
            assembled: N positions of this solver.
            speeds: of the drives `(N, d)` [rad/s or m/s].
            accelerations: of the drives `(N, d)` [rad/s² or m/s²].

        Raises:
            ArgumentError: a load has another number of samples.
            AccuracyError: a residual exceeds its tolerance, or flags of uniqueness are wrong.
            IndeterminateError: a component of an output is not unique, and the problem is strict.
        """
        problem, count = self.problem, len(assembled)
        loads, link_loads = problem.joint_loads_at(count), problem.link_loads_at(count)
        has_rates = bool(np.any(speeds) or np.any(accelerations))
        blocks: list[Solution] = []
        for span, state in zip(assembled.spans, assembled.blocks, strict=True):
            inputs = Inputs(
                assembled.positions[span],
                speeds[span],
                accelerations[span],
                loads[span if len(loads) > 1 else slice(None)],
                {name: load.of_samples(span) for name, load in link_loads.items()},
                assembled.turns[span],
                has_rates,
            )
            blocks.append(self.inverse_dynamics.solve(state, inputs))
        solution = joined(blocks, assembled.positions)
        self.inverse_dynamics.prove_flags(solution)
        self.refuse_indeterminate(solution.unique[problem.output_indices])
        return solution

    def refuse_indeterminate(self, unique: Array) -> None:
        """Refuse statically indeterminate outputs if the problem is strict and has no compliances.

        Args:
            unique: `(k, 6)` which components of the outputs are unique.

        Raises:
            IndeterminateError: the problem is strict and wants a component that is not unique.
        """
        problem = self.problem
        if not problem.strict or problem.compliance or np.all(unique):
            return
        components = {
            name: [label for label, flag in zip(WRENCH_COMPONENTS, row, strict=True) if not flag]
            for name, row in zip(problem.outputs, unique, strict=True)
            if not np.all(row)
        }
        listed = "; ".join(f"{name}: {', '.join(labels)}" for name, labels in components.items())
        raise IndeterminateError(
            f"{problem.mechanism.name}: the laws of motion leave open: {listed}. Give compliances, "
            "change the mechanism (a slide, a ball) or leave strict out to have the least norm",
            components=components,
        )
