"""Scene: a mechanism, which of its coordinates are driven, free or held, and what acts on it."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from ..core.dynamics.problem_solver import AssembledPositions, ProblemSolver
from ..core.elements.link_loads import Wrench
from ..core.mechanism.mechanism import Mechanism
from ..core.problem.arguments import by_coordinate, checked, held_positions, held_there
from ..core.problem.coordinate_names import check_single, each_coordinate
from ..core.problem.problem import Problem
from ..core.problem.samples import acting_on, common_shape, spanned, targets_of
from ..core.results.prescribed import Prescribed
from ..kit.arrays import Array
from ..kit.checks import flag, mapping, names
from ..kit.errors import ArgumentError, MobilityError, choices, hinting
from ..kit.frozen import frozen

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..core.elements.element import Element
    from ..core.mechanism.configuration import Configuration
    from ..core.problem.acting import Acting
    from ..core.response.response import Response
    from ..core.results.jacobian import Jacobian
    from ..core.results.regressor import Regressor
    from ..core.results.sweep import Sweep
    from ..core.transmission.transmission import Transmission
    from ..core.transmission.workspace import Workspace
    from ..motion.simulation.equilibrium import Equilibrium
    from ..motion.simulation.trajectory import Trajectory
    from .branches import Branches
    from .linear_model import LinearModel
    from .plan import Plan
    from .task_motion import TaskMotion
    from .task_simulation import TaskTrajectory
    from .task_sweep import TaskSweep
    from .tasks import Task

_OVERFLOW: Any = {"over": "ignore", "invalid": "ignore"}
"""NumPy need not warn of numbers that overflow: results that contain them are refused."""

_ROLES = ("drive", "free", "held")
"""Arguments of which a coordinate is named by one at most."""


_OF_TASKS = frozenset({"task", "actuated", "effort_weights"})
"""Arguments of scenes with a task alone."""


class Scene(Prescribed):
    """A mechanism, what decides its motion, and what acts on it.

    A coordinate is driven, its motion being prescribed; free, its motion being found; held; or the
    loops decide it. A scene cannot be changed. It may be used by several threads at the same time;
    copies and pickles are made anew from its arguments.

    Args:
        mechanism: from `load`.
        drive: name of the joint whose motion is prescribed, or a list of names: by the positions
            of a sweep, or the motions of a simulation. With those that are free as many as the
            mechanism has mobility once the held joints are held. If neither is given, the joints
            that the description calls independent are driven, as far as they are not held. A
            joint with several coordinates stands for all of them, here and in `free`; one of them
            is called `joint.coordinate`, here and in `free`, `held`, `loads` and `near`, and
            `Mechanism.drivable` lists them. To name an
            angle of a ball makes it three turns, see `Mechanism.variant`, in `Scene.mechanism` as
            well.
        free: name of the joint whose motion is found, or a list of names: by `simulate`,
            `equilibrium` and `cardan_dyn.vibration`. Beside a task, what it says nothing of.
        held: joints whose position the scene fixes, to their coordinates [rad or m]; those of
            several to an array of theirs, a ball's also to a unit quaternion. Names of such
            joints alone, as of a floating base, are held where `near` says, or else at zero. The
            moment or force that holds them is a result. Any length or angle of the description,
            `origin:JOINT.x`, by how much it is greater, see `Mechanism.adjustable`.
        loads: what acts on the mechanism. A joint's name with an effort of any shape [N·m or N],
            positive in the sense of the joint's coordinate; a link's name with a `Wrench`, or with
            `(..., 6)`: force and moment about the link's origin in the link's axes. A `fixed`
            joint, a site of MJCF or a frame of SDF stands for a link that has its origin and axes,
            also in elements.
        gravity: `(3,)` acceleration of free fall in world axes [m/s²]; none unless given. Or
            `"description"`: that of the description, from `<option gravity>` of MJCF, the world of
            SDF, `pin.Model.gravity`. Where a description states one that a scene leaves out, a
            `UserWarning` says so once for a mechanism.
        outputs: names of the joints whose wrenches are results; all joints if not given. Loops
            that they do not need are not solved. Drive efforts and what holds joints are among
            the results if the joint is; the empty list asks for the drive efforts alone, which
            then come without a balance of the bodies.
        compliance: joints to their compliance in the axes that stay with the parent: 6 values, or
            a symmetric `(6, 6)`, force first [m/N, rad/(N·m)]. What the laws of motion leave open
            is then what makes the elastic energy least, instead of the least norm.
        strict: refuse to choose what the laws of motion leave open.
        near: joints to positions [rad or m] at which the scene begins, up to a complete
            configuration, a `Configuration`, or the name of a keyframe of MJCF or of a reference
            configuration of a `pin.Model`, of which joints that are held play no part; together
            with `held` they have to close the loops. They are followed there from the description's
            zero; where that leads past a dead point or through open loops, the mechanism is
            assembled there. Positions of more joints than decide where the mechanism is, such as
            those of encoders, mean the assembly nearest to them (least squares of angles, and of
            slides in lengths of the mechanism); what has none within 0.01 is refused.
        branch: name of the assembly mode, from `branches`; `A` is that of the description.
        elements: springs, dampers, bushings, friction and actuators: `JointSpring`,
            `JointFriction`, `PointSpring`, `PointActuator`, `Bushing`, `Actuator`. Like a
            load, an effort of theirs is part of the wrench at its joint.
        task: what moves as given instead of `drive`: a list of `PointTask`, `PoseTask`,
            `AngleTask`, `DirectionTask`, `DistanceTask` and names of coordinates, whose rows are
            what `sweep` takes as positions.
            The scene is then a `TaskScene`, its sweeps are each a `TaskSweep`, and simulations of
            what is free beside it each a `TaskTrajectory`.
        actuated: joints whose efforts make that motion, and which are the drives of the results;
            those that the description calls independent if not given. Without a task, `drive` moves
            as given, and these carry it.
        effort_weights: by how much the square of an actuated joint's effort counts, where more are
            actuated than decide the motion; their sum is least [1; of slides m²]. 1 if not given,
            of slides the square of the mechanism's characteristic length.

    Raises:
        ModelError: unknown joint or link.
        ArgumentError: a value is not finite or has the wrong shape.
        MobilityError: driven and free coordinates do not match the mobility.
        SingularConfigurationError: the scene starts where these do not decide the motion.
        AssemblyError: the loops cannot be closed at the held positions, or not in this
            assembly mode.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "run solve calculate compute evaluate inverse_dynamics kinematics": "scene.sweep("
        "positions) for a given motion, scene.simulate(duration, position=...) for a free one",
        "step integrate forward_dynamics dynamics": "scene.simulate(duration, position=...)",
        "statics static rest": "scene.sweep(positions) without a speed, or scene.equilibrium(near) "
        "of free coordinates",
        "plot show view draw display animate": "results show themselves: "
        "scene.sweep(positions).plot('joint'), or cd.view(scene.sweep(positions))",
        "dof dofs ndof mobility": "cd.describe(scene.mechanism) tells it; scene.drives and "
        "scene.free are what moves",
        "joints": "scene.mechanism.joints",
        "links": "scene.mechanism.links",
        "force forces torque torques wrench wrenches moment reactions tau": "they belong to "
        "results: scene.sweep(positions)['joint'].force; what acts on a scene is scene.loads",
        "q position positions x configuration_at": "scene.configuration() is where it starts; "
        "results have .position and .motion",
        "time t speed velocity": "results have it: scene.sweep(positions, speed=...) or "
        "scene.simulate(duration, ...)",
        "drive driven": "scene.drives",
        "load": "scene.loads",
        "set update change add_load set_drive": "a scene cannot be changed; scene.replace(...) "
        "makes another one",
        "range limits reach workspace": "scene.motion_range(), scene.reachable(positions)",
        "modes assembly_modes": "scene.branches()",
        "actuator_map motor_map": "scene.transmission(actuated, joints)",
        "task ik inverse_kinematics end_effector": "motion given at a link is "
        "Scene(mechanism, task=[cd.PointTask('link')], actuated=[...]); between motors and joints "
        "it is scene.transmission(actuated, joints)",
        "eigenvalues frequencies": "scene.equilibrium(near).frequencies, cd.vibration",
        "mass inertia inertia_matrix crba": "scene.mass_matrix(positions)",
        "nle coriolis non_linear_effects": "scene.bias(positions, speeds)",
        "linearize linearise linear_model state_space": "scene.linear(at)",
        "point orientation": "it belongs to results: scene.sweep(positions).point('link'), or "
        "scene.configuration().point('link')",
    }

    @hinting(
        {
            "drives driver driven input inputs motor": "the driven joints are drive=...",
            "fixed locked lock hold constraints": "joints that do not move are held={joint: "
            "position}",
            "load force forces torque torques moment wrench wrenches": "what acts is "
            "loads={'joint': effort, 'link': cd.Wrench(...)}",
            "g": "gravity=(0, 0, -9.81)",
            "springs dampers spring damper": "they are elements=[cd.JointSpring(...), ...]",
            "output joints": "joints whose wrenches are wanted are outputs=[...]",
            "q q0 start initial guess": "where it starts is near={joint: position}",
            "position positions speed speeds": "these belong to scene.sweep(positions, speed=...)",
            "mode assembly": "the assembly mode is branch=...",
            "tasks target targets tip": "what moves as given is task=[cd.PointTask('link')]",
            "actuators motors": "joints that carry the effort are actuated=[...]",
        }
    )
    def __init__(
        self,
        mechanism: Mechanism,
        *,
        drive: str | Sequence[str] | None = None,
        free: str | Sequence[str] | None = None,
        held: Mapping[str, ArrayLike] | str | Sequence[str] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | str | None = None,
        outputs: Sequence[str] | None = None,
        compliance: Mapping[str, ArrayLike] | None = None,
        strict: bool = False,
        near: Mapping[str, ArrayLike] | str | None = None,
        branch: str = "A",
        elements: Sequence[Element] | None = None,
        task: Task | Sequence[Task] | None = None,
        actuated: str | Sequence[str] | None = None,
        effort_weights: Mapping[str, float] | None = None,
    ) -> None:
        has_task = task is not None or actuated is not None
        if task is not None and drive is not None:
            raise ArgumentError(
                "drive and task both say what moves as given: name driven coordinates among the "
                "task, as in task=[cd.PointTask('tip'), 'slewing']"
            )
        if task is None and drive is None and actuated is not None:
            raise ArgumentError(
                "actuated says which joints carry the effort of a motion that is given elsewhere: "
                "say what moves as given, task=[...], or name the joints in drive"
            )
        if (
            has_task
            and actuated is None
            and (free or not getattr(mechanism, "independent_joints", True))
        ):
            raise MobilityError(
                f"{mechanism.name}: name the joints whose efforts make the motion of the task, "
                f"actuated=[...]; joints: {choices(mechanism.drivable)}"
            )
        problem = checked(
            mechanism,
            drive=actuated if has_task else drive,
            free=free,
            held=held,
            loads=loads,
            gravity=gravity,
            outputs=outputs,
            compliance=compliance,
            strict=strict,
            near=near,
            branch=branch,
            elements=elements,
        )
        if gravity is None:
            _tell_of_gravity(mechanism)
        if not has_task:
            self._take(ProblemSolver(problem))
            return
        self.__class__ = TaskScene
        TaskScene._follow(self, problem, drive if task is None else task, effort_weights)  # type: ignore[arg-type]

    def _take(self, solver: ProblemSolver) -> None:
        self._solver = solver
        self._problem = solver.problem
        self._freeze()

    @classmethod
    def _of(cls, solver: ProblemSolver) -> Scene:
        scene = cls.__new__(cls)
        scene._take(solver)
        return scene

    @property
    def solver(self) -> ProblemSolver:
        """What closes the loops and solves the reactions: for what is built on scenes."""
        return self._solver

    def __reduce__(self) -> tuple[object, ...]:
        return Scene._of, (self._solver,)

    def replace(self, **changes: Any) -> Scene:
        """Return a scene that differs in some arguments; what they do not concern is kept.

        A scene with other loads, gravity, compliances or strictness keeps all that was learned
        about the motion. `held` and `loads` replace the values of the joints and links that they
        name, and keep the others; None as a value takes a joint or link out, and None instead of
        a mapping takes all of them out. `drive` and `free` replace all names. What is named by one
        of `drive`, `free` and `held` is no longer named by the others: `replace(free="crank")`
        frees a drive, `replace(held={"crank": 0.3})` holds it.

        Args:
            changes: arguments of `Scene`.

        Raises:
            TypeError: no such argument.
            CardanError: as `Scene` does.
        """
        return Scene._of(self._solver.changed(self._changed(changes)))

    def _changed(self, changes: Mapping[str, Any]) -> Problem:
        """Return the problem of the scene that `replace` makes."""
        problem, held = self._problem, changes.get("held", ())
        if "held" in changes:
            held = held_there(self.mechanism, held, changes.get("near", self.near))
            changes = {**changes, "held": held}
        # Loops of a user hold a joint elsewhere again and again: nothing else is checked anew.
        known = isinstance(held, Mapping) and len(changes) == 1
        known = known and held.keys() <= problem.held.keys() - problem.near.keys()
        if known and not any(at is None for at in held.values()):
            return problem.holding(held_positions(self.mechanism, held, "held"))
        arguments = self._arguments()
        if unknown := set(changes) - set(arguments):
            listed = choices(arguments, min(unknown))
            raise TypeError(f"Scene has no argument {choices(unknown)}; arguments: {listed}")
        for name, value in changes.items():
            if name in ("held", "loads"):
                value = _merged(self.mechanism, name, arguments[name], value)
            arguments[name] = value
        asked = {role: _names(self.mechanism, role, changes.get(role)) for role in _ROLES}
        for role in _ROLES:
            # What is asked for stays, so that contradictions are refused.
            taken = set().union(*(asked[other] for other in _ROLES)) - asked[role]
            present = arguments[role]
            if role == "held":
                arguments[role] = {name: present[name] for name in present if name not in taken}
            elif role not in changes:
                arguments[role] = tuple(name for name in present if name not in taken)
        if "drive" not in changes and len(arguments["drive"]) == 1 and not self._problem.listed:
            arguments["drive"] = arguments["drive"][0]
        return checked(**arguments)

    def _arguments(self) -> dict[str, Any]:
        """Return the arguments of the scene by name, as `Scene` takes them."""
        problem = self._problem
        return {
            "mechanism": problem.mechanism,
            "drive": problem.drives,
            "free": problem.free,
            "held": problem.held,
            "loads": self.loads,
            "gravity": problem.gravity,
            # If all joints are outputs, so are all joints of another mechanism.
            "outputs": None if problem.all_outputs else problem.outputs,
            "compliance": problem.compliance,
            "strict": problem.strict,
            "near": self.near,
            "branch": problem.branch,
            "elements": problem.elements,
        }

    @hinting(
        {
            "q angle angles positions phi theta x": "drive positions are position=... [rad or m]",
            "v omega speeds velocity velocities qd dq w": "drive speeds are speed=... [rad/s or "
            "m/s]",
            "rpm": "speeds are in rad/s: speed=rpm * 2 * np.pi / 60",
            "a alpha accelerations qdd ddq": "drive accelerations are acceleration=...",
            "t times": "times are time=...",
            "load force forces torque torques": "what acts is loads={'joint': effort}",
            "g": "gravity=(0, 0, -9.81)",
            "drive drives free": "which joints are driven is said to the scene: "
            "scene.replace(drive=...)",
            "n_jobs workers processes threads parallel": "all cores are used",
        }
    )
    def sweep(
        self,
        position: ArrayLike | AssembledPositions,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | str | None = None,
        inertia: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
        time: ArrayLike = 0.0,
    ) -> Sweep:
        """Solve motion and reactions at given drive positions.

        All arguments broadcast: their common shape is that of the results, `(1,)` if all of them
        are numbers. Positions, speeds and accelerations of drives that a list names have a last
        axis of its length, which is not part of that shape and may be left out if it is 1. With
        positions `(P,)` and held positions `(D, 1)`, D designs are swept over P positions each.

        The configuration at a sample is the one that is reached from where the scene starts,
        whatever the other samples and their order are: held joints first move to their positions
        along a straight line, then the drives to theirs. Where a drive brings the mechanism back
        to itself by turning alone, from there, whole turns are taken off first; if the rest of the
        way is not open, the drives move along the whole straight line.

        `<limit>` elements of the description are not regarded. Whatever was asked before, results
        agree to 1e-15 times `Sweep.condition`, not bit for bit.

        Many samples are solved by threads on all cores that the process may use, as
        `os.sched_setaffinity` says, and so are functions of elements called. How many these are
        does not change a bit of the results. Beside its arguments and results, a sweep of any size
        takes some 20 MB of memory for each core; of mechanisms with very many joints its blocks
        alone hold up to 48 MB each. Of each sample it keeps coordinates, the wrenches of the
        outputs and what drives and held joints exert; where velocities, accelerations and velocity
        ratios take more than 32 MB, `motion` computes them when they are read.

        Args:
            position: drive positions of any shape [rad or m], in any order; for d drives
                `(..., d)`, or a number for all; or what `assemble` made of them.
            speed: drive speeds [rad/s or m/s], like `position`. The mechanism is quasi-static
                where it is zero.
            acceleration: drive accelerations [rad/s² or m/s²], like `position`.
            held: joints that the scene holds, to other positions [rad or m].
            loads: joints and links to what acts on them instead of in the scene: efforts of any
                shape [N·m or N], wrenches `(..., 6)`.
            gravity: `(..., 3)` [m/s²] or `"description"` instead of the scene's.
            inertia: links to factors on their mass and inertia.
            along_path: whether the positions of several drives are points of a path, such as the
                trajectory of a robot: every sample, in C order, is then followed from the one
                before it. Unless path and straight line pass a singular configuration on different
                sides, both lead to the same one; a path may reach what the line does not.
            time: at which actuators act, of any shape [s].

        Raises:
            ArgumentError: a value is not finite, shapes do not broadcast, a joint is not held, or
                the results do not fit into the memory of the machine.
            ModelError: unknown joint or link.
            AssemblyError: the loops cannot be closed at a position.
            SingularConfigurationError: a position is a dead point.
            AccuracyError: a result missed its tolerance.
            IndeterminateError: a component of an output is not unique, in a strict scene.
            MobilityError: a coordinate of the scene is free.
        """
        if along_path is not False:
            along_path = flag("along_path", along_path)
        solver, problem = self._solver, self._problem
        if problem.free:
            problem.refuse_free("a sweep")
        acting = acting_on(problem, speed, acceleration, loads, gravity, inertia, time)
        with np.errstate(**_OVERFLOW):
            if isinstance(position, AssembledPositions):
                positions = position
                _refuse(solver, position, held, along_path, acting.shapes)
            else:
                if type(position) is np.ndarray:  # Before it is copied.
                    solver.refuse_too_many(position.size // len(problem.independent))
                targets = spanned(targets_of(problem, position, held), acting, problem)
                if targets.held:
                    solver = solver.of_varied(targets.varied)
                solver.refuse_too_many(targets.size)
                positions = solver.assembled_in_turn(targets, along_path)
            return _collecting()(positions.solver, positions, acting)

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
            MobilityError: a coordinate of the scene is free.
        """
        along_path = flag("along_path", along_path)
        self._problem.refuse_free("assembling for a sweep")
        targets = targets_of(self._problem, position, held)
        with np.errstate(**_OVERFLOW):
            return self._solver.of_varied(targets.varied).assemble(targets, along_path)

    @property
    def loads(self) -> Mapping[str, Array | Wrench]:
        """Loaded joint to its effort, of any shape [N·m or N]; link to its `Wrench`."""
        links = {name: load.wrench for name, load in self._problem.link_loads.items()}
        return frozen({**self._problem.joint_loads, **links})

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall `(3,)` in world axes [m/s²]."""
        return self._problem.gravity

    @property
    def compliance(self) -> Mapping[str, Array]:
        """Joint to its `(6, 6)` compliance, force first [m/N, rad/(N·m)]."""
        return self._problem.compliance

    @property
    def strict(self) -> bool:
        """Whether statically indeterminate components are refused."""
        return self._problem.strict

    @property
    def near(self) -> Mapping[str, float | Array]:
        """What is brought to a position before anything moves [rad or m].

        Coordinates by name; joints with balls by all of theirs, with unit quaternions.
        """
        problem = self._problem
        result: dict[str, float | Array] = dict(problem.near)
        for joint, quaternion in problem.near_balls.items():
            scalars = [
                result.pop(name)
                for name in problem.mechanism.joints[joint].coordinates
                if name in result
            ]
            result[joint] = np.concatenate([np.array(scalars, dtype=float), quaternion])
        return frozen(result)

    @property
    def branch(self) -> str:
        """Name of the assembly mode."""
        return self._problem.branch

    def __repr__(self) -> str:
        arguments = [f"drives {', '.join(self.drives)}"] if self.drives else []
        if self.free:
            arguments.append(f"free {', '.join(self.free)}")
        if self.held:
            arguments.append(
                "held " + ", ".join(f"{name} {position:g}" for name, position in self.held.items())
            )
        if self.loads:
            arguments.append(f"loads on {', '.join(self.loads)}")
        if np.any(self.gravity):
            arguments.append(f"gravity {self.gravity.tolist()}")
        if self.elements:
            arguments.append(f"{len(self.elements)} element{'s' * (len(self.elements) > 1)}")
        return f"<Scene of {self.mechanism.name!r}: {'; '.join(arguments)}>"

    def plan(self) -> Plan:
        """Return what sweeps and simulations do, and what they leave out; `print` shows it."""
        from ..motion.simulation.simulate import planned
        from .plan import plan_of

        return plan_of(self._solver, planned(self._solver))

    def motion_range(self) -> tuple[float, float]:
        """Return between which positions the driven or free joint can move [rad or m].

        `<limit>` elements of the description are not regarded: a sweep may go beyond them.

        They are dead points of the joint or positions where assembly modes meet; ±inf where it
        turns through, or slides by more than ten lengths of the mechanism.

        Raises:
            MobilityError: the scene has several such joints.
        """
        independent = self._problem.independent
        if len(independent) > 1:
            raise MobilityError(
                f"the range of one joint depends on the positions of the others: "
                f"{choices(independent)}; hold all but one of them",
                mobility=len(independent),
            )
        return self._solver.assembly.motion_range()

    def reachable(
        self, position: ArrayLike, *, held: Mapping[str, ArrayLike] | None = None
    ) -> Array:
        """Return at which positions of driven and free joints the loops close: a workspace.

        A sweep refuses positions beyond a dead point, or where the loops cannot be closed on the
        way from the start.

        Args:
            position: see `Scene.sweep`.
            held: see `Scene.sweep`.

        Returns:
            Array of bool, in the common shape of the arguments.

        Raises:
            ArgumentError: a value is not finite, shapes do not broadcast, or a joint is not held.
            ModelError: no such joint.
            MobilityError: these joints do not decide the motion.
        """
        targets = targets_of(self._problem, position, held)
        with np.errstate(**_OVERFLOW):
            solver = self._solver.of_varied(targets.varied)
            return solver.assembly.reachable(targets).reshape(targets.shape)

    def configuration(self) -> Configuration:
        """Return the closed configuration in which the scene starts, of all loops."""
        from .assembling import configuration_of  # Most scenes show none.

        return configuration_of(self._solver)

    def branches(self) -> Branches:
        """Return the assembly modes with driven and free joints where the scene starts.

        `A` is that of the description, the others follow by their distance from it.
        """
        from .branches import Branches  # Most scenes need no other mode.

        return Branches(self.mechanism, self._problem.independent, self._solver.assembly.modes)

    def response(
        self, tolerance: float = 1e-13, *, interval: tuple[float, float] | None = None
    ) -> Response:
        """Return wrenches and efforts as functions of the drive's position.

        `responses` builds those of many designs together.

        Built from a few hundred solved positions, they hold everywhere to rounding, at any speed,
        acceleration, load and gravity, for nanoseconds per value.

        Args:
            tolerance: error of the functions relative to the greatest wrench of their joint, or a
                tenth of the greatest of all joints; where rounding stops short of it, times the
                condition number. `Response.error` is what was reached.
            interval: positions between which it is to hold [rad or m]; without, the drive has to
                come back to where it was.

        Raises:
            ArgumentError: the interval is empty, or the scene has several drives, elements, or
                gears whose teeth are described.
            AccuracyError: the tolerance cannot be reached; the message says what can.
            IndeterminateError: a component of an output is not unique, in a strict scene.
            CardanError: the drive does not turn through and no interval was given.
            MobilityError: a coordinate of the scene is free.
        """
        self._problem.refuse_free("a response")
        from ..core.response.build import build

        return build(self._solver, tolerance, interval)

    def responses(
        self,
        held: Mapping[str, ArrayLike],
        tolerance: float = 1e-13,
        *,
        interval: tuple[float, float] | None = None,
    ) -> Response:
        """Return the responses of many designs, built together.

        Args:
            held: joints that the scene holds, to positions of any shape; they broadcast, and their
                common shape is that of the designs.
            tolerance: see `response`; for every design.
            interval: see `response`; the same for every design.

        Raises:
            ArgumentError: shapes do not broadcast, or a joint is not held.
            ModelError: no such joint.
            CardanError: see `response`; the message names the design where it is that of one.
        """
        self._problem.refuse_free("a response")
        from ..core.response.build import build

        return build(self._solver, tolerance, interval, {} if held is None else held)

    def transmission(
        self, actuated: str | Sequence[str], joints: str | Sequence[str]
    ) -> Transmission:
        """Return how actuated coordinates move joints, and what each side exerts on the other.

        Either side has as many coordinates as the scene drives and frees; what else could move is
        held. The scene says where the transmission starts, and in which assembly mode.

        Args:
            actuated: name of the joint that a motor or a cylinder drives, or a list of names; a
                joint with several coordinates stands for all of them, see `Scene`.
            joints: likewise the joints that they move, such as those of an ankle: their positions,
                speeds and efforts are wanted, or given.

        Raises:
            ModelError: no such joint; or one that depends on how a rod has spun idly, which a rule
                decides.
            ArgumentError: a name stands for no coordinate, or for one that is held.
            MobilityError: these are more or fewer coordinates than decide the motion, or the
                actuated ones do not decide it. Whether the joints do is seen when they are given.
            CardanError: as of a scene that the actuated drive.
        """
        from ..core.transmission.transmission import Transmission

        return Transmission(self._solver, self.configuration(), actuated, joints)

    def load_response(self, path: str | os.PathLike[str]) -> Response:
        """Read the response of this scene, or of one like it, that `Response.save` wrote.

        Efforts at joints and the direction of gravity may have other values.

        Args:
            path: the file.

        Raises:
            ArgumentError: no path, or the scene has elements.
            CardanError: the file cannot be read, is damaged, or is the response of another scene.
        """
        self._problem.refuse_free("a response")
        from ..core.response.build import refuse_elements
        from ..core.response.file import read
        from ..core.response.response import Response

        refuse_elements(self._solver.problem)
        return Response(self._solver, (), frozen({}), (read(path, self._solver),))

    @hinting(
        {
            "t time t_end tmax t_final tspan end until": "how long is duration [s], the first "
            "argument",
            "q q0 x0 positions angle": "where it starts is position=...",
            "v v0 omega speeds velocity": "how fast it starts is speed=...",
            "dt timestep time_step h max_step": "steps have tolerances rtol= and atol=, or a "
            "length step=...; the result is known at any times: .at(times)",
            "solver integrator": "how it is solved is method=...",
            "tol tolerance": "tolerances are rtol=... and atol=...",
        }
    )
    def simulate(
        self,
        duration: float,
        *,
        position: ArrayLike | Mapping[str, ArrayLike] | None = None,
        speed: ArrayLike | Mapping[str, float] | None = None,
        motion: Mapping[str, Any] | None = None,
        loads: Mapping[str, Any] | None = None,
        rtol: float = 1e-10,
        atol: float | None = None,
        method: str | None = None,
        step: float | None = None,
        settle: bool = False,
        events: Any = (),
        max_touches: int = 100_000,
        progress: bool | Callable[[float], object] | None = None,
    ) -> Trajectory:
        """Simulate how the free coordinates of the scene move.

        Driven ones move as `motion` says, held joints hold. All loops stay closed to rounding, in
        positions and velocities.

        Args:
            duration: [s]; the simulation begins at time 0.
            position: at the start [rad or m]: a number or `(f,)` for the free coordinates, `(d,)`
                for driven and free ones, or names to numbers, of other joints as well; where the
                scene starts if None.
            speed: likewise [rad/s or m/s]; at rest if None.
            motion: each driven coordinate to its motion: a constant speed; a function of time that
                returns position, speed and acceleration; three functions; or times and positions.
                Where a function's acceleration jumps, steps end, and `events` has a `kink of` it.
            loads: joints and links to what acts there instead of in the scene: a value, or a
                function of `(time)` or `(time, position, speed)`, the latter two by joint names.
                What acts for less than 1/200 of the duration may be overlooked; a `step` that is
                shorter sees it. Where it jumps over the state, rounding of the state decides which
                of its sides holds at that very time: the same one for all results.
            rtol: relative tolerance of each step.
            atol: absolute tolerance [rad, fractions of the characteristic length, and of the
                greatest speed at the start]; like `rtol` if None.
            method: see `cardan_dyn.motion.simulation`; the first of them that suits if None.
            step: length of all steps [s], instead of tolerances.
            settle: start where the fast modes of stiff springs rest, near the given start.
            events: `Event`, or functions like those of loads that pass through zero.
            max_touches: touches of pins with clearance (`PinContact`) after which it ends.
            progress: whether to show how far it is; in terminals and notebooks if None. Or a
                function of the fraction done, or of that and of what is to be said, such as that
                steps are many and when they would end.

        Raises:
            ArgumentError: a value is not finite or out of range, start values that contradict each
                other, or a method that does not suit.
            ModelError: unknown joint or link, or no body has mass.
            MobilityError: nothing is free.
            AssemblyError: the loops cannot be closed at the start.
            SingularConfigurationError: driven and free coordinates do not decide the motion there.
            SimulationError: it could not go on; with the trajectory up to there.
        """
        from ..motion.simulation.simulate import simulated  # Most scripts simulate nothing.

        return simulated(
            self._solver,
            duration=duration,
            position=position,
            speed=speed,
            motion=motion,
            loads=loads,
            rtol=rtol,
            atol=atol,
            method=method,
            step=step,
            settle=settle,
            events=events,
            max_touches=max_touches,
            progress=progress,
        )

    def equilibrium(
        self,
        position: ArrayLike | Mapping[str, ArrayLike] | None = None,
        *,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | str | None = None,
    ) -> Equilibrium:
        """Find where the free coordinates rest, near a position.

        Newton's method on the efforts that they would need at rest finds stable and unstable
        equilibria alike; `Equilibrium.stability` tells which it is.

        Args:
            position: where to begin, see `simulate`; driven coordinates stay there.
            loads: joints and links to what acts on them instead of in the scene.
            gravity: `(3,)` [m/s²] or `"description"` instead of the scene's.

        Raises:
            ArgumentError: a value is not finite, or has a wrong shape.
            ModelError: unknown joint or link.
            EquilibriumError: none was found, or one at a kink of a force, where it has no
                stiffness.
            MobilityError: nothing is free.
            CardanError: as `sweep`, at the start.
        """
        from ..motion.simulation.equilibrium import equilibrium  # Most scripts ask for none.

        with np.errstate(over="ignore", invalid="ignore"):  # What overflows is no equilibrium.
            return equilibrium(self._solver, position, loads, gravity)

    def jacobian(
        self,
        link: str,
        point: ArrayLike = (0.0, 0.0, 0.0),
        *,
        position: ArrayLike,
        speed: ArrayLike | None = None,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
    ) -> Jacobian:
        """Return how a point and its link move per unit speed of each coordinate, loops closed.

        Args:
            link: name of a link, or of a frame fixed in one, see `Sweep.point`.
            point: `(3,)` of it, in its axes [m].
            position: of the driven, then of the free coordinates, see `sweep`.
            speed: likewise; with it, the `rate` of the result is known.
            held: see `sweep`.
            along_path: see `sweep`.

        Returns:
            `(..., 6, n)` in world axes: velocity of the point, then angular velocity, a column for
            each of `coordinates`. It stands for an array.

        Raises:
            ModelError: unknown link, or the rate of a rod that spins idly.
            CardanError: as `sweep`; a singular configuration has none.
        """
        from ..core.results.jacobian import jacobian_of  # Most scripts ask for none.

        return jacobian_of(self._solver, link, point, position, speed, held, along_path)

    def mass_matrix(
        self,
        position: ArrayLike,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
    ) -> Array:
        """Return the mass matrix M of the driven and free coordinates, rotors and gears included.

        `M @ acceleration + bias` is what the coordinates need: efforts of drives, those of springs
        and so on apart, and of loads by the transpose of velocity ratios or of a `jacobian`. Rods
        that spin idly do so as forces have it, and resist with what that leaves.

        Args:
            position: of the driven, then of the free coordinates, see `sweep`.
            held: see `sweep`.
            along_path: see `sweep`.

        Returns:
            `(..., n, n)`, by `coordinates` [kg·m², kg·m or kg].

        Raises:
            CardanError: as `sweep`.
        """
        from ..core.results.inertia import mass_matrix_of  # Most scripts ask for none.

        targets = targets_of(self._problem, position, held)
        return mass_matrix_of(self._solver, targets, flag("along_path", along_path))

    def bias(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
        time: ArrayLike = 0.0,
    ) -> Array:
        """Return what the coordinates need without acceleration and without loads.

        That is what speeds, weight and the elements of the scene ask for, see `mass_matrix`.

        Args:
            position: of the driven, then of the free coordinates, see `sweep`.
            speed: likewise.
            held: see `sweep`.
            along_path: see `sweep`.
            time: at which actuators act [s].

        Returns:
            `(..., n)`, by `coordinates` [N·m or N].

        Raises:
            CardanError: as `sweep`.
        """
        from ..core.results.inertia import bias_of  # Most scripts ask for none.

        return bias_of(self._solver, position, speed, held, time, along_path)

    def regressor(
        self,
        position: ArrayLike,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
    ) -> Regressor:
        """Return how what the coordinates need depends on masses, first moments and inertias.

        Linearly, at given motions with the scene's gravity, without loads and elements; of closed
        chains as of open ones. It is held against inverse dynamics. Rods that spin idly count with
        the motion that they have with the masses of the description.

        Args:
            position: of the driven, then of the free coordinates, see `sweep`.
            speed: likewise.
            acceleration: likewise.
            held: see `sweep`.
            along_path: see `sweep`.

        Returns:
            `(..., n, 10 k)` for k links; `base_parameters` tells what of it can be identified.

        Raises:
            CardanError: as `sweep`.
        """
        from ..core.results.regressor import regressor_of  # Most scripts ask for none.

        return regressor_of(self._solver, position, speed, acceleration, held, along_path)

    def linear(
        self,
        at: Equilibrium | Trajectory | Sweep,
        *,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        points: Mapping[str, str | tuple[str, ArrayLike]] | None = None,
    ) -> LinearModel:
        """Return the linear equation of small deviations, exactly: derivatives of inverse dynamics.

        Deviations are of the free coordinates, while drives move as given; if none is free, of all
        drives, which are then moved by efforts.

        Args:
            at: an `equilibrium`, a trajectory of `simulate`, or a sweep of this scene, all of whose
                coordinates are driven then: `scene.replace(drive=[*scene.coordinates], free=None)`.
            inputs: parameters as of `Sweep.derivative`, such as `load:JOINT`,
                `load:LINK.force_x` of a link with a load there, a drive, `speed:DRIVE`,
                `acceleration:DRIVE`; if None, a load along each coordinate that deviates.
            outputs: columns of tables: `JOINT.position` (or the coordinate's name), `.velocity`,
                `.acceleration`, `.force_x`, `.moment_x`, `.holding_effort`, `.drive_effort`,
                `.coupling_moment`, and `LINK.position_x`, `LINK.velocity_x` in world axes; if
                None, the coordinates that deviate.
            points: names to links or `(link, (x, y, z))`, whose positions may be outputs.

        Raises:
            ArgumentError: names that say nothing, or `at` is of another scene.
            ModelError: no such joint or link, or what deviates has no mass.
            IndeterminateError: an output is not unique.
        """
        from .linear_model import linear_model  # Most scripts ask for none.

        return linear_model(self._solver, at, inputs, outputs, points)


class TaskScene(Scene):
    """A scene with a task, which `Scene` makes: what moves as given are rows of the task.

    Its `drives` are the actuated joints, or as many of them as decide the motion.

    Attributes:
        task: the tasks.
        rows: names of their rows, in the order of positions, then of free coordinates.
        actuated: names of the joints that carry the effort.
        effort_weights: by how much the square of each one's effort counts [1; of slides m²].
        machine: the scene of the same mechanism driven by its `drives`, which answers what is not
            asked of the task.
    """

    task: tuple[Task, ...]
    rows: tuple[str, ...]
    actuated: tuple[str, ...]
    effort_weights: Mapping[str, float]
    machine: Scene
    _moved: TaskMotion

    def _follow(
        self,
        problem: Problem,
        task: object,
        weights: Mapping[str, float] | None,
        like: TaskMotion | None = None,
    ) -> None:
        """Take tasks, and a problem that all actuated joints drive."""
        from .task_motion import TaskMotion, listed, solvers  # Most scenes have no task.

        problem = replace(problem, listed=True)
        solver = next(solvers(problem, None if like is None else like.machine))
        tasks = listed(problem.mechanism, task)
        self._take_moved(TaskMotion(solver, tasks, problem.drives, weights, like))

    def _take_moved(self, moved: TaskMotion) -> None:
        self._moved, self.machine = moved, Scene._of(moved.machine)
        self.task, self.rows, self.actuated = moved.tasks, moved.rows, moved.actuated
        self.effort_weights = moved.weights
        self._take(moved.machine)

    def __reduce__(self) -> tuple[object, ...]:
        return _task_scene, (self._moved,)

    def __repr__(self) -> str:
        free = self._problem.free
        parts = [f"task {', '.join(self.rows[: len(self.rows) - len(free)])}"]
        parts += [f"free {', '.join(free)}"] * bool(free)
        parts.append(f"actuated {', '.join(self.actuated)}")
        return f"<TaskScene of {self.mechanism.name!r}: {'; '.join(parts)}>"

    def replace(self, **changes: Any) -> Scene:
        """Return a scene that differs in some arguments, see `Scene.replace`.

        With `task=None` it has none, and its `drives` move as given.
        """
        own: dict[str, Any] = {"task": self.task, "actuated": self.actuated}
        if not changes.keys() & {"actuated", "mechanism"}:
            own["effort_weights"] = self.effort_weights
        own |= {name: changes.pop(name) for name in _OF_TASKS & changes.keys()}
        if own["task"] is None or "drive" in changes:
            return self.machine.replace(**changes)
        problem = self.machine._changed({"drive": own["actuated"], **changes})
        scene = object.__new__(TaskScene)
        scene._follow(problem, own["task"], own.get("effort_weights"), self._moved)
        return scene

    def sweep(
        self,
        position: ArrayLike | AssembledPositions,
        speed: ArrayLike = 0.0,
        acceleration: ArrayLike = 0.0,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        loads: Mapping[str, object] | None = None,
        gravity: ArrayLike | str | None = None,
        inertia: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
        time: ArrayLike = 0.0,
    ) -> TaskSweep:
        """Solve motion and reactions where the rows of the task are as given.

        Arguments and errors as of `Scene.sweep`, with rows of the task in the place of drives:
        positions, speeds and accelerations are `(..., m)` for m rows. The configuration at a sample
        is the one that is reached from where the scene starts while rows move along straight
        lines; a link with a `PoseTask` turns along a straight line of its Cardan angles from there.

        Raises:
            AssemblyError: the task is out of reach; with the sample and the nearest rows.
            SingularConfigurationError: one of the first kind lies on the way or at a sample, or one
                of the second kind at a sample.
        """
        if isinstance(position, AssembledPositions):
            self.assemble(())
        along_path = flag("along_path", along_path)

        def acting(problem: Problem, speeds: object, accelerations: object) -> Acting:
            return acting_on(problem, speeds, accelerations, loads, gravity, inertia, time)

        with np.errstate(**_OVERFLOW):
            return self._moved.sweep(position, speed, acceleration, held, along_path, acting)

    def assemble(
        self,
        position: ArrayLike,
        *,
        held: Mapping[str, ArrayLike] | None = None,
        along_path: bool = False,
    ) -> AssembledPositions:
        """Refuse: how fast actuated joints move is found along with their positions."""
        raise ArgumentError(
            "rows of a task are not assembled: call sweep(position, speed, acceleration); for more "
            "sweeps at its rates scene.machine.assemble(sweep.position), and its sweep with "
            "sweep.speed and sweep.acceleration"
        )

    def reachable(
        self, position: ArrayLike, *, held: Mapping[str, ArrayLike] | None = None
    ) -> Array:
        """Return which rows of the task the mechanism reaches, see `Scene.reachable`."""
        with np.errstate(**_OVERFLOW):
            return self._moved.reachable(position, held)

    def workspace(
        self,
        ranges: Mapping[str, ArrayLike],
        at: Mapping[str, ArrayLike] | None = None,
        *,
        condition: float | None = None,
        every_mode: bool = False,
        samples: int = 49,
    ) -> Workspace:
        """Return where two rows of the task can be, and by what that is bordered.

        Arguments and errors as of `Transmission.workspace`, with rows in the place of joints; rows
        of a rotation vector may rest only. Of more actuated joints than needed, `drives` count.
        """
        return self._moved.workspace(ranges, at, samples, condition, every_mode)

    def motion_range(self) -> tuple[float, float]:
        """Return between which positions the only row of the task can move [rad or m].

        Raises:
            MobilityError: the task has several rows.
        """
        if len(self.rows) > 1:
            raise MobilityError(
                f"the range of one row depends on the positions of the others: "
                f"{choices(self.rows)}; scene.reachable(positions) tells what can be reached",
                mobility=len(self.rows),
            )
        return self._moved.range()

    def simulate(self, duration: float, *, motion: Any = None, **asked: Any) -> TaskTrajectory:
        """Simulate how free coordinates move while the task moves as given.

        Actuated joints exert what the task asks for, and free coordinates move as what acts on
        them, and the motion of the others, makes them.

        Args:
            duration: see `Scene.simulate`, as all other arguments.
            motion: each row of the task to its motion, see there.
            asked: other arguments of `Scene.simulate`.

        Raises:
            CardanError: as `Scene.simulate`; `SimulationError` also where the task ends its reach,
                or actuated joints cannot make it move.
        """
        from .task_simulation import simulate_task  # Most scripts simulate nothing.

        return simulate_task(self._moved, self.loads, motion, duration=duration, **asked)

    def _of_machine(self, *_: object, **__: object) -> NoReturn:
        """Refuse what is known of drives alone."""
        raise MobilityError(
            "this is known of drives alone, and here other joints are actuated than move as given: "
            "scene.machine is the same mechanism driven by its actuated joints, and a scene with "
            "drive= alone that of the coordinates themselves",
            mobility=len(self.drives),
        )

    equilibrium = response = responses = load_response = _of_machine
    jacobian = mass_matrix = bias = regressor = linear = transmission = _of_machine


def _task_scene(moved: TaskMotion) -> TaskScene:
    scene = object.__new__(TaskScene)
    scene._take_moved(moved)
    return scene


def _tell_of_gravity(mechanism: Mechanism) -> None:
    """Warn once of a gravity that a description states and a scene leaves out."""
    description = mechanism.description
    if not description.states_gravity or not np.any(description.gravity):
        return
    if not any(link.mass for link in description.links):
        return

    def warn() -> bool:
        listed = ", ".join(f"{value:g}" for value in np.asarray(description.gravity))
        warnings.warn(
            f"{mechanism.name}: the description's gravity ({listed}) m/s² is left out of a scene "
            'without one; gravity="description" takes it, gravity=(0, 0, 0) is none',
            stacklevel=6,  # The line that makes the scene.
        )
        return True

    mechanism.base.kept.of("told of gravity", (), warn)


def _merged(
    mechanism: Mechanism, name: str, present: Mapping[str, Any], changes: object
) -> dict[str, Any]:
    """Return a mapping with changes; names whose new value is None are taken out.

    None instead of changes takes all names out: it means none, as it does for `Scene`.
    """
    if changes is None:
        return {}
    given = mapping(name, changes)
    merged = {**present, **(by_coordinate(mechanism, name, given) if name == "held" else given)}
    for key, value in merged.items():
        if value is None and not (isinstance(key, str) and key in mechanism.link_frames):
            check_single(mechanism, key, f"a key of {name},")
    return {key: value for key, value in merged.items() if value is not None}


@cache
def _collecting() -> Callable[..., Sweep]:
    """Return what makes a sweep of a solution; scenes that are simulated do without."""
    from ..core.results.collect import sweep_of

    return sweep_of


def _names(mechanism: Mechanism, role: str, value: object) -> set[str]:
    """Return what an argument of a role names: coordinates that are driven, free or held."""
    if role == "held":
        given = by_coordinate(mechanism, role, value)
        return {name for name, place in given.items() if place is not None}
    return set() if value is None else set(each_coordinate(mechanism, names(role, value)))


def _refuse(
    solver: ProblemSolver,
    assembled: AssembledPositions,
    held: object,
    along_path: bool,
    shapes: Mapping[str, tuple[int, ...]],
) -> None:
    """Refuse positions that were assembled otherwise, or arguments that exceed their shape."""
    if along_path and not assembled.along_path:
        raise ArgumentError(
            "along_path: these positions were assembled along straight lines; write "
            "assemble(..., along_path=True)"
        )
    if held is not None:
        raise ArgumentError(
            "held: these positions were assembled with held joints where they are; write "
            "assemble(..., held=...)"
        )
    solver.refuse_others(assembled)
    if common_shape({"position": assembled.shape, **shapes}) != assembled.shape:
        listed = ", ".join(f"{name} {size}" for name, size in shapes.items() if size)
        raise ArgumentError(
            f"the positions were assembled in shape {assembled.shape}, which these exceed: "
            f"{listed}; give the positions an axis for each of theirs"
        )
