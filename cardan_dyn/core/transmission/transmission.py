"""Transmission: how actuated coordinates move joints through loops, and what motors feel of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...kit.arrays import Array
from ...kit.checks import names, whole
from ...kit.errors import ArgumentError, MobilityError, ModelError, choices
from ..description.description import Limits
from ..dynamics.problem_solver import ProblemSolver
from ..kinematics.loops.idle_rods import idle_rods
from ..mechanism.mechanism import Mechanism
from ..problem.arguments import checked, near_positions, with_named
from ..problem.coordinate_names import check_single, each_coordinate
from ..problem.problem import Problem
from .maps import Maps
from .way import Side, SolvedWay

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .borders import Border
    from .fitted import FittedTransmission
    from .reduced import ReducedTree
    from .workspace import Workspace


class Transmission(Maps):
    """Maps between actuated coordinates and the joints that they move; `Scene.transmission`.

    Both ways start where the scene does, and keep its assembly mode: actuated positions are reached
    along the straight line of actuated coordinates, joints along that of joints. Loads, gravity and
    elements of the scene play no part. `fitted` makes functions of it that take microseconds.
    """

    _meant: ClassVar[Mapping[str, str]] = {
        "forward fk forward_kinematics to_joints": "transmission.joints_of(actuated)",
        "inverse ik inverse_kinematics to_motors motors_of": "transmission.actuated_of(joints)",
        "limits polygon": "transmission.speed_limits(actuated), effort_limits(actuated)",
        "condition singularities": "transmission.singular_values(actuated), borders(start, end)",
        "reach reachable envelope": "transmission.workspace(ranges)",
        "armature": "transmission.reduced().armature",
        "inertia mass_matrix": "transmission.reflected_inertia(actuated)",
        "fit compile": "transmission.fitted(), transmission.write_c(path)",
    }

    _forward: SolvedWay
    _backward: SolvedWay
    _made_of: tuple[Any, ...]

    def __init__(
        self,
        solver: ProblemSolver,
        start: Mapping[str, Any],
        actuated: str | Sequence[str],
        joints: str | Sequence[str],
    ) -> None:
        """Make both ways.

        Args:
            solver: of the scene.
            start: the configuration in which it starts, positions by joints.
            actuated: see `Scene.transmission`.
            joints: likewise.
        """
        problem = solver.problem
        given = {"actuated": actuated, "joints": joints}
        named = {
            role: _coordinates(problem.mechanism, role, item, problem.independent)
            for role, item in given.items()
        }
        moving = (*problem.independent, *problem.held)
        both = (*named["actuated"], *named["joints"])
        mechanism = with_named(problem.mechanism, (*moving, *both), moving)
        motors, moved = (
            _side(mechanism, role, every, not isinstance(given[role], str))
            for role, every in named.items()
        )
        places, _ = near_positions(mechanism, start)
        near = {**start, **{name: places[name] for name in both}, **problem.held}
        drivable = mechanism.drivable
        outputs = tuple(dict.fromkeys(drivable[name].joint for name in both))
        of_actuated, of_joints = (
            checked(
                mechanism,
                drive=side.names,
                held=problem.held,
                near=near,
                outputs=outputs,
            )
            for side in (motors, moved)
        )
        _refuse_spins(of_actuated, moved)
        _refuse_spins(of_joints, motors)
        forward = SolvedWay(motors, moved, of_actuated).begun()
        self._freeze(
            _forward=forward,
            _backward=SolvedWay(moved, motors, of_joints, forward),
            _made_of=(solver, start, actuated, joints),
        )

    def __reduce__(self) -> tuple[object, ...]:
        return Transmission, self._made_of

    def __repr__(self) -> str:
        return (
            f"<Transmission of {self._forward.problem.mechanism.name!r}: "
            f"{', '.join(self.actuated)} -> {', '.join(self.joints)}>"
        )

    def jacobian_rate(self, actuated: ArrayLike, speed: ArrayLike) -> Array:
        """Return how fast `jacobian` changes, dJ/dt `(..., n, n)`.

        Joints accelerate by J · acceleration + dJ/dt · speed of the actuated.

        Args:
            actuated: their positions [rad or m].
            speed: their speeds [rad/s or m/s].

        Raises:
            CardanError: as `joints_of`.
        """
        side = self._forward.given
        at, rates = side.rows("actuated", actuated), side.rows("speed", speed)
        # Accelerations q(v) are quadratic in speeds: dJ/dt e = (q(v + s e) - q(v - s e)) / 4 s, of
        # which no digit is lost where s is as great as v.
        size = np.max(np.abs(rates) / side.units, axis=-1, initial=0.0)
        steps = np.where(size > 0.0, size, 1.0)[..., None] * side.units
        ways = steps[..., None] * np.eye(len(side.names))
        moved = (rates[..., None, :] + sign * ways for sign in (1.0, -1.0))
        more, less = (self._forward.accelerations(at[..., None, :], item) for item in moved)
        return np.swapaxes((more - less) / (4.0 * steps[..., None]), -1, -2)

    def reflected_inertia(self, actuated: ArrayLike) -> Array:
        """Return the inertia that motors feel `(..., n, n)`, couplings between them included.

        It is that of all bodies and rotors of the mechanism: at rest, efforts of motors are this
        matrix times their accelerations [kg·m², kg·m, kg]. What motors right at the joints would
        feel is J⁻ᵀ · inertia · J⁻¹.

        Args:
            actuated: positions of the actuated coordinates [rad or m].

        Raises:
            CardanError: as `joints_of`.
        """
        return self._forward.inertia(self._actuated(actuated))

    def borders(self, start: ArrayLike, end: ArrayLike, *, samples: int = 129) -> list[Border]:
        """Return where the transmission is singular on a straight line of actuated positions.

        They are found to rounding; ends of reach to 1e-8 of the line where both kinds meet. Places
        where det J touches zero without passing through it, and pairs that lie between two samples,
        are not found.

        Args:
            start: positions of the actuated coordinates [rad or m].
            end: likewise.
            samples: number of positions at which the line is looked at.

        Returns:
            The borders from start to end.

        Raises:
            ArgumentError: nothing of the line can be reached, or see `joints_of`.
        """
        from .borders import Border, borders
        from .chart import Chart

        side = self._forward.given
        first, last = side.rows("start", start), side.rows("end", end)
        chart = Chart(self._forward.solver, self.joints)
        found = borders(chart, first, last, whole("samples", samples, 2))
        return [
            Border(kind, side.shown(first + part * (last - first)), part) for kind, part in found
        ]

    def workspace(
        self,
        ranges: Mapping[str, ArrayLike],
        at: Mapping[str, ArrayLike] | None = None,
        *,
        condition: float | None = None,
        every_mode: bool = False,
        samples: int = 49,
    ) -> Workspace:
        """Return where two joints can be, and by what that is bordered.

        Borders are ends of reach, where motors lose hold, limits of all joints in the description,
        and a bound of the condition number; `.plot()` draws them. Grid lines of both joints are
        followed as far as loops close; where they meet borders is found to rounding. What a border
        does within a cell of the grid, and one that passes an edge twice, is not seen.

        Args:
            ranges: two of the joints to their least and greatest positions [rad or m].
            at: others to a position at which they rest [rad or m], or to several, each of which
                makes a section; where the scene starts if left out.
            condition: bound of the ratio of singular values, see `singular_values`; none if None.
            every_mode: whether all working modes are looked for, in which motors and other joints
                can be while the joints are where the scene starts; else it is that of the scene.
            samples: positions of each range.

        Raises:
            ArgumentError: not two ranges, or names of other coordinates.
            AssemblyError: nothing of them is reached.
            CardanError: as of a scene that the joints drive.
        """
        from .chart import Chart
        from .workspace import Rows, workspace

        way = self._backward
        rows = Rows(self.joints, way.start, np.asarray)
        asked = ranges, at, samples, condition, every_mode
        return workspace(Chart(way.solver, self.actuated), rows, *asked)

    def reduced(self, joints: ArrayLike | None = None) -> ReducedTree:
        """Return the tree that is left without motors, rods and loops, with joints driven directly.

        It keeps the links that the joints of the transmission, held and fixed ones carry, from the
        root on. The inertia of all else along each joint becomes its armature, and the greatest
        effort and speed that motors give to it its limits, where its own are no less: together,
        joints have those of `effort_limits` and `speed_limits` alone.

        Args:
            joints: their positions at which it does [rad or m]; where the scene starts if None.

        Raises:
            ArgumentError: several positions are given.
            ModelError: a joint is no joint of the tree, or a ball.
            CardanError: as `actuated_of`.
        """
        from .reduced import ReducedTree

        side = self._backward.given
        at = self._backward.start if joints is None else side.rows("joints", joints)
        if at.ndim != 1:
            raise ArgumentError(
                f"joints are several positions, of shape {at.shape}; a tree has one set of "
                f"armatures: give one position of {choices(self.joints)}"
            )
        return ReducedTree(self._backward, at)

    def fitted(
        self,
        actuated: Mapping[str, ArrayLike] | None = None,
        joints: Mapping[str, ArrayLike] | None = None,
    ) -> FittedTransmission:
        """Return functions that do the same within ranges, in microseconds a call.

        Args:
            actuated: actuated coordinates to their least and greatest positions [rad or m]; what is
                left out has the limits of the description.
            joints: likewise the joints.

        Raises:
            ModelError: no such coordinate.
            ArgumentError: a range is missing, or is none.
            AccuracyError: Newton's method does not lead everywhere in the ranges.
            CardanError: as `joints_of` and `actuated_of`, somewhere in the ranges.
        """
        from .fitted import fitted

        name = self._forward.problem.mechanism.name
        return fitted(name, (self._forward, self._backward), (actuated, joints))

    def write_c(
        self,
        path: str | os.PathLike[str],
        name: str = "transmission",
        *,
        actuated: Mapping[str, ArrayLike] | None = None,
        joints: Mapping[str, ArrayLike] | None = None,
    ) -> Path:
        """Write both ways as a file of C99, see `fitted` and `FittedTransmission.write_c`."""
        from .fitted import write_c

        return write_c(path, name, lambda: self.fitted(actuated, joints))


def _coordinates(
    mechanism: Mechanism, role: str, given: object, independent: Sequence[str]
) -> tuple[str, ...]:
    """Return the coordinates of a side, as many as decide the motion.

    Raises:
        ModelError: no such joint.
        ArgumentError: a name stands for no coordinate.
        MobilityError: there are more or fewer.
    """
    found = each_coordinate(mechanism, names(role, given))
    for name in found:
        check_single(mechanism, name, role)
    if len(set(found)) != len(independent):
        raise MobilityError(
            f"{role} names {len(set(found))} coordinates, and {len(independent)} decide where the "
            f"mechanism is; name as many as the scene has ({choices(independent)}), and hold what "
            "is no part of the transmission: scene.replace(held={...})",
            mobility=len(independent),
        )
    return found


def _refuse_spins(problem: Problem, found: Side) -> None:
    """Refuse coordinates that depend on how a rod has spun, which the other side does not decide.

    Raises:
        ModelError: there is one.
    """
    mechanism = problem.mechanism
    columns = mechanism.coordinates.rates_of(found.names)
    for rod in idle_rods(mechanism, set(problem.passive_columns.tolist())):
        for name, column in zip(found.names, columns, strict=True):
            if column in rod.ruled:
                raise ModelError(
                    f"{name!r} belongs to a rod that spins idly about its line: it turns there by "
                    "a rule, not as its speed says, and has no Jacobian; name coordinates of other "
                    "joints, or hold the spin",
                    name=name,
                )


def _side(mechanism: Mechanism, role: str, every: tuple[str, ...], listed: bool) -> Side:
    """Return a side of named coordinates; a single name of a joint of several is like a list."""
    drivable = [mechanism.drivable[name] for name in every]
    length = mechanism.characteristic_length
    slides = tuple(item.slides for item in drivable)
    units = np.where(slides, length, 1.0)
    joints = {joint.name: joint for joint in mechanism.description.joints}
    limits = [joints[item.joint].limits if item.joint in joints else Limits() for item in drivable]
    return Side(role, every, listed or len(every) > 1, slides, units, tuple(limits))
