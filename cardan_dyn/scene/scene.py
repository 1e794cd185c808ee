"""Scene: a mechanism with its drive, held joints, loads and gravity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..checks import flag, whole
from ..dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..mechanism.mechanism import Mechanism
from ..problem.arguments import checked
from ..results.sweep import Sweep
from .arguments import replaced
from .simulating import SceneSimulations
from .solving import Asked, assembled, swept

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..arrays import Array
    from ..elements.element import Element
    from ..mechanism.configuration import Configuration


class Scene(SceneSimulations):
    """A mechanism whose motion is prescribed, with what acts on it.

    A scene cannot be changed. It may be used by several threads at the same time; copies and
    pickles are made anew from its arguments.

    Args:
        mechanism: from `load`.
        drive: name of the joint whose motion is prescribed, or a list of names: as many as
            the mechanism has mobility once the held joints are held. If not given, the joints
            that the description calls independent, as far as they are not held. Of a joint with
            several coordinates, here and in `held`, `loads` and `start`, the name of one of them,
            `joint.coordinate`; `Mechanism.drivable` lists them. To name an angle of a ball makes
            it three turns, see `Mechanism.variant`, in `Scene.mechanism` as well.
        held: joints whose position the scene fixes, to their coordinates [rad or m]. The moment
            or force that holds them is a result.
        loads: what acts on the mechanism. A joint's name with an effort of any shape [N·m or N],
            positive in the sense of the joint's coordinate; a link's name with a `Wrench`, or with
            `(..., 6)`: force and moment about the link's origin in the link's axes.
        gravity: `(3,)` acceleration of free fall in world axes [m/s²]; none unless given.
        outputs: names of the joints whose wrenches are results; all joints if not given. Loops
            that they do not need are not solved. Drive efforts and what holds joints are among
            the results if the joint is; the empty list asks for the drive efforts alone, which
            then come without a balance of the bodies.
        compliance: joints to their compliance in the axes that stay with the parent: 6 values, or
            a symmetric `(6, 6)`, force first [m/N, rad/(N·m)]. What the laws of motion leave open
            is then what makes the elastic energy least, instead of the least norm.
        strict: refuse to choose what the laws of motion leave open.
        start: joints to positions [rad or m] at which the scene begins, up to a complete
            configuration, or a `Configuration`; together with `held` they have to close the loops.
            They are followed there from the description's zero; where that leads past a dead
            point or through open loops, the mechanism is assembled there.
        branch: name of the assembly mode, from `branches`; `A` is that of the description.
        elements: springs, dampers, bushings, friction and actuators: `JointSpring`,
            `JointFriction`, `PointSpring`, `Bushing`, `Actuator`. Like a load, an effort of theirs
            is part of the wrench at its joint.

    Raises:
        ModelError: unknown joint or link.
        ArgumentError: a value is not finite or has the wrong shape.
        MobilityError: the drives do not match the mobility.
        SingularConfigurationError: the scene starts in a dead point of its drives.
        AssemblyError: the loops cannot be closed at the held positions, or not in this
            assembly mode.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        *,
        drive: str | Sequence[str] | None = None,
        held: Mapping[str, float] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
        outputs: Sequence[str] | None = None,
        compliance: Mapping[str, ArrayLike] | None = None,
        strict: bool = False,
        start: Configuration | Mapping[str, float | Array] | None = None,
        branch: str = "A",
        elements: Sequence[Element] | None = None,
    ) -> None:
        problem = checked(
            mechanism,
            drive=drive,
            held=held,
            loads=loads,
            gravity=gravity,
            outputs=outputs,
            compliance=compliance,
            strict=strict,
            start=start,
            branch=branch,
            elements=elements,
        )
        self._take(ProblemSolver(problem))

    def _take(self, solver: ProblemSolver) -> None:
        self._solver = solver
        self._problem = solver.problem
        self._freeze()

    @classmethod
    def _of(cls, solver: ProblemSolver) -> Scene:
        scene = cls.__new__(cls)
        scene._take(solver)
        return scene

    def __reduce__(self) -> tuple[object, ...]:
        return Scene._of, (self._solver,)

    def replace(self, **changes: Any) -> Scene:
        """Return a scene that differs in some arguments; what they do not concern is kept.

        A scene with other loads, gravity, compliances or strictness keeps all that was learned
        about the motion. `held` and `loads` replace the values of the joints and links that they
        name, and keep the others; None as a value takes a joint or link out, and None instead of
        a mapping takes all of them out. Drives stay drives: to hold one of them, or to drive a
        held joint, change `drive` and `held` together.

        Args:
            changes: arguments of `Scene`.

        Raises:
            TypeError: no such argument.
            CardanError: as `Scene` does.
        """
        problem = checked(**replaced(self, changes))
        return Scene._of(ProblemSolver(problem, like=self._solver))

    def sweep(
        self,
        position: ArrayLike | AssembledPositions,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | None = None,
        inertia: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
        workers: int = 1,
        time: ArrayLike = 0.0,
    ) -> Sweep:
        """Solve motion and reactions at given drive positions.

        All arguments broadcast: their common shape is that of the results. With positions `(P,)`
        and held positions `(D, 1)`, D designs are swept over P positions each.

        The configuration at a sample is the one that is reached from where the scene starts,
        whatever the other samples and their order are: held joints first move to their positions
        along a straight line, then the drives to theirs. Where a drive brings the mechanism back
        to itself by turning alone, from there, whole turns are taken off first; if the rest of the
        way is not open, the drives move along the whole straight line.

        `<limit>` elements of the description are not regarded. Results are reproducible to rounding
        times `Sweep.condition`, not bit for bit: earlier sweeps give later ones nearer guesses.

        Beside its arguments and results, a sweep of any size takes some 20 MB of memory for each
        worker; of mechanisms with very many joints its blocks alone hold up to 48 MB.

        Args:
            position: drive positions of any shape [rad or m], in any order; for d drives
                `(..., d)`, or a number for all; or what `assemble` made of them.
            speed: drive speeds [rad/s or m/s], like `position`. The mechanism is quasi-static
                where it is zero.
            acceleration: drive accelerations [rad/s² or m/s²], like `position`.
            held: joints that the scene holds, to other positions [rad or m].
            loads: joints and links to what acts on them instead of in the scene: efforts of any
                shape [N·m or N], wrenches `(..., 6)`.
            gravity: `(..., 3)` [m/s²] instead of the scene's.
            inertia: links to factors on their mass and inertia.
            along_path: whether the positions of several drives are points of a path, such as the
                trajectory of a robot: every sample, in C order, is then followed from the one
                before it. Unless path and straight line pass a singular configuration on different
                sides, both lead to the same one; a path may reach what the line does not.
            workers: processes that share the work of many samples, where the platform can fork
                them; results are the same to the last bit.
            time: at which actuators act, of any shape [s].

        Raises:
            ArgumentError: a value is not finite, shapes do not broadcast, or a joint is not held.
            ModelError: unknown joint or link.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
            AccuracyError: a result missed its tolerance.
            IndeterminateError: a component of an output is not unique, in a strict scene.
        """
        along_path, workers = flag("along_path", along_path), whole("workers", workers)
        given = position, speed, acceleration, held, loads, gravity, inertia
        return swept(self._solver, Asked(*given, along_path, workers, time))

    def assemble(
        self,
        position: ArrayLike,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
    ) -> AssembledPositions:
        """Close the loops at given drive positions, for several sweeps over them.

        What depends on the position alone is kept, some kilobytes per sample, so that a sweep
        with another speed or acceleration has only the rest to do.

        Args:
            position: see `sweep`.
            held: see `sweep`.
            along_path: see `sweep`.

        Raises:
            ArgumentError: a value is not finite, shapes do not broadcast, or a joint is not held.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
        """
        return assembled(
            self._solver, Asked(position, held=held, along_path=flag("along_path", along_path))
        )
