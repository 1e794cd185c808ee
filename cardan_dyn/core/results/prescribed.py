"""Prescribed: what a scene and its results have in common, and results over samples of a motion."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from ...kit.frozen import Frozen
from ..mechanism.mechanism import Mechanism
from ..problem.problem import Problem
from .result import Result

if TYPE_CHECKING:
    import pandas
    import xarray
    from numpy.typing import ArrayLike

    from ...kit.arrays import Array
    from ..elements.element import Element
    from .motion import Motion
    from .plot import MotionPlot
    from .point_motion import PointMotion, Points
    from .table import Table


class Prescribed(Frozen):
    """Something that belongs to a scene."""

    _problem: Problem

    @property
    def problem(self) -> Problem:
        """The checked arguments of the scene: for what is built on scenes and their results."""
        return self._problem

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with those balls as turns of which the scene names an angle."""
        return self._problem.mechanism

    @property
    def drives(self) -> tuple[str, ...]:
        """Names of the driven joints and coordinates, whose motion is prescribed."""
        return self._problem.drives

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free joints and coordinates, whose motion is found."""
        return self._problem.free

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the driven, then of the free ones: columns of positions, speeds and efforts."""
        return self._problem.independent

    @property
    def held(self) -> Mapping[str, float]:
        """Held joints and coordinates, and their positions [rad or m]."""
        return self._problem.held

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the joints whose wrenches are results."""
        return self._problem.outputs

    @property
    def elements(self) -> tuple[Element, ...]:
        """Springs, dampers, bushings, friction and actuators."""
        return self._problem.elements


class MotionResult(Result, Prescribed):
    """A result over samples of the motion of a scene, whose tables may leave the motion out."""

    _meant: ClassVar[Mapping[str, str]] = {
        "run solve": "it is a result already; take its joints: result['joint'].force",
        "dof dofs ndof mobility": "cd.describe(result.mechanism) tells it",
        "force forces f": "result['joint'].force, `(N, 3)`; .magnitude.force is its size",
        "torque torques moment moments tau m": "result['joint'].moment, .torsion, .bending; what "
        "the drive exerts is result.drive_effort",
        "torsion bending axial shear": "result['joint'] has it: result['bearing_out'].torsion",
        "wrenches reactions reaction": "result['joint'] or result.wrench('joint', frame)",
        "q v a qd qdd x dq ddq": "result.motion has .q, .v and .a of all joints, and "
        ".position('joint')",
        "velocity velocities accelerations": "of drives .speed and .acceleration, of joints "
        ".motion.velocity('joint'), of points .point('link').velocity",
        "positions angle angles phi theta": "of drives .position, of joints "
        ".motion.position('joint')",
        "t times": ".time",
        "joints joint_names": "result.outputs are the joints with wrenches; all of them are in "
        "result.mechanism.joints",
        "links": "result.mechanism.links; result.point('link') tells how one moves",
        "df dataframe to_pandas frame": ".to_dataframe()",
        "dataset xarray to_dataset": ".to_xarray()",
        "export write to_file csv": ".save(path), whose suffix says what is written",
        "residual residuals error errors": ".loop_residual, .balance_residual, .power_residual "
        "and .rate_residual",
        "show view animate display render": "cd.view(result) draws it; result.plot('joint') is a "
        "figure",
        "draw figure": ".plot('joint')",
        "trajectory path coupler_curve": ".point('link', (x, y, z)).position",
        "energy energies": "a Trajectory has .kinetic_energy and .potential_energy",
        "power": "drive_effort times speed is what a drive gives",
        "jacobian sensitivity sensitivities derivatives": "a Sweep has "
        ".derivative('crank_bearing', 'mass:rod', 'origin:pin.x'), and of a weighted sum "
        ".gradient(weights, 'mass:*')",
    }

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""

    @property
    @abstractmethod
    def motion(self) -> Motion:
        """Positions, speeds and accelerations of all joints."""

    @property
    def joint_coordinates(self) -> Array:
        """Coordinates `(N, size)` of all samples in one dimension, see `Motion.x`."""
        return self.motion.x

    @property
    def joint_velocities(self) -> Array:
        """Velocities `(N, nv)` of all joints, of all samples in one dimension."""
        return self.motion.v.reshape(len(self.motion.x), -1)

    @property
    def joint_accelerations(self) -> Array:
        """Accelerations `(N, nv)`, likewise."""
        return self.motion.a.reshape(len(self.motion.x), -1)

    @abstractmethod
    def given(self) -> Table:
        """Return what was given, drive positions and the like, as a table without results."""

    @abstractmethod
    def table(self, *, motion: bool = True, points: Points = ()) -> Table:
        """Return what is known, with names for dimensions, and units.

        Args:
            motion: whether to include the motion of the joints.
            points: see `to_dataframe`.
        """

    def _with_points(self, table: Table, points: Points) -> Table:
        """Return a table with the motions of some points besides."""
        if not points:
            return table
        from .point_motion import with_points  # Imported here: most tables have none.

        return with_points(table, self, points)

    def point(self, link: str, xyz: ArrayLike = (0.0, 0.0, 0.0)) -> PointMotion:
        """Return where a point of a link is and how it moves, in world axes.

        Args:
            link: name of a link; or else of a `fixed` joint, of a site of MJCF or a frame of SDF,
                which move with their link.
            xyz: `(3,)` the point, from the origin of that and in its axes [m].

        Raises:
            ModelError: unknown link, or one whose motion the outputs leave out.
            ArgumentError: `xyz` is no `(3,)` of finite numbers.
        """
        from .point_motion import PointMotion  # Imported here: many scripts ask for no points.

        return PointMotion(self, link, xyz)

    def orientation(self, link: str) -> Array:
        """Return rotations `(N, 3, 3)` that take components in a link's axes to world axes.

        How it turns is the `angular_velocity` of any `point` of it.

        Args:
            link: see `point`.

        Raises:
            ModelError: see `point`.
        """
        return self.point(link).orientation

    @property
    def plot(self) -> MotionPlot:
        """Figures: `sweep.plot("bearing_out")`, or `sweep.plot.polar("bearing_out")`."""
        from .plot import MotionPlot  # Imported here: few scripts draw.

        return MotionPlot(self)

    def to_xarray(self, *, motion: bool = True, points: Points = ()) -> xarray.Dataset:
        """Return all results as a dataset; every variable has `units` and a `long_name`.

        Args:
            motion: whether to include the motion of the joints. A `Response` solves it directly,
                which may take longer than all the rest.
            points: see `to_dataframe`.

        Raises:
            MissingExtraError: xarray is not installed.
        """
        return self.table(motion=motion, points=points).to_xarray()

    def to_dataframe(self, *, motion: bool = True, points: Points = ()) -> pandas.DataFrame:
        """Return all results, a row per sample and a column per value.

        Columns are called `drive_effort`, `bearing_out.bending`, `bearing_out.force_x` and so on.
        `frame.attrs["units"]` maps them to their units.

        Args:
            motion: see `to_xarray`.
            points: links whose motion is included, as `coupler.position_x` and so on; or names of
                columns to links, `(link, xyz)` or what `point` returned:
                `points={"tip": ("coupler", (0.3, 0.0, 0.0))}`.

        Raises:
            MissingExtraError: pandas is not installed.
            ModelError, ArgumentError: of points, see `point`.
        """
        return self.table(motion=motion, points=points).to_dataframe()
