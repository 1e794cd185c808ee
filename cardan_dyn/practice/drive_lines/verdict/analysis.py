"""Analysis: motion of a drive line and what acts along it, over positions and designs.

`(…)` stands for the samples: positions, or designs × positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...._version import __version__
from ....core.results.plot import Plot, own_options
from ....core.results.result import Result
from ....core.results.table import Table, Variable
from ....kit.arrays import Array
from ....kit.frozen import FrozenDict, Record, read_only
from .variants import Adjustable

if TYPE_CHECKING:
    from ....figures.style import Figure

_MOTION: tuple[tuple[str, str, str, str], ...] = (
    ("rotation", "shaft", "rad", "rotation about the axis"),
    ("angle_error", "shaft", "rad", "lead over the input, without its mean"),
    ("ratio", "shaft", "1", "speed over that of the input shaft"),
    ("acceleration", "shaft", "rad/s²", "angular acceleration about the axis"),
    ("slip", "spline", "m", "by how much the spline is drawn out"),
)
_FORCES: tuple[tuple[str, str, str, str], ...] = (
    ("torsion_in", "joint", "N·m", "torque in the shaft before the joint"),
    ("torsion_out", "joint", "N·m", "torque in the shaft behind the joint"),
    ("bending_in", "joint", "N·m", "bending moment of the shaft before the joint"),
    ("bending_out", "joint", "N·m", "bending moment of the shaft behind the joint"),
    ("holding_moment", "joint", "N·m", "moment that keeps the joint angle"),
    ("bearing_radial", "bearing", "N", "force across the shaft"),
    ("bearing_axial", "bearing", "N", "force of the bearing along the shaft"),
    ("spline_friction", "spline", "N", "friction force on the rear piece"),
    ("spline_torque", "spline", "N·m", "torque through the spline"),
    ("spline_bending", "spline", "N·m", "bending moment in the spline"),
    (
        "moment_in",
        "joint component",
        "N·m",
        "moment of the shaft before the joint on the cross",
    ),
    (
        "moment_out",
        "joint component",
        "N·m",
        "moment of the cross on the shaft behind the joint",
    ),
    ("bearing_force", "bearing bearing_component", "N", "force of the bearing on its shaft"),
    ("centring", "coupling_piece", "N", "force in the centring of a coupling piece"),
    ("drive_torque", "", "N·m", "torque that drives the input shaft"),
    ("load_torque", "", "N·m", "torque on the output shaft"),
)
"""What tables hold: attribute, dimensions besides the samples, unit, and what it is."""


class LineForces(NamedTuple):
    """Moments and forces along a line.

    Attributes:
        moment_in: `(…, n, 3)` moment of the shaft before each joint on the cross, at its centre
            [N·m], in axes that turn with this shaft: x along it, y along the driving pin of the
            straight joint.
        moment_out: `(…, n, 3)` moment of the cross on the shaft behind it [N·m], in axes that turn
            with that shaft: x along it, z along the driven pin.
        bearing_force: `(…, m, 3)` force of each bearing on its shaft [N]: along the shaft, to the
            left, and upwards across it, as the shaft lies by slopes, joint angles and planes;
            misalignments do not turn these axes. The bearing feels the opposite.
        spline_force: `(…, s, 3)` force of the front piece on the rear piece at each spline [N], in
            axes that turn with the shaft; x is its friction. In
            all designs a spline is at the distance from the front joint that the data say.
        spline_moment: `(…, s, 3)` moment likewise [N·m]; x is the torque through it.
        centring_force: `(…, c, 3)` force of the centring of each coupling piece on the shaft that
            its ball is fixed to, of a disc on the shaft behind the piece [N], in axes that turn
            with the shaft that the ball slides along, or with the piece.
        holding_moment: `(…, n)` moment that keeps each joint angle, positive if it acts on what
            lies behind the joint in the sense in which its angle grows [N·m].
        drive_torque: `(…)` torque that drives the input shaft [N·m].
        load_torque: `(…)` torque that acts on the output shaft, negative where it resists [N·m].
    """

    moment_in: Array
    moment_out: Array
    bearing_force: Array
    spline_force: Array
    spline_moment: Array
    centring_force: Array
    holding_moment: Array
    drive_torque: Array
    load_torque: Array

    @property
    def torsion_in(self) -> Array:
        """Torque in the shaft before each joint, positive if it drives the joint `(…, n)` [N·m]."""
        return self.moment_in[..., 0]

    @property
    def torsion_out(self) -> Array:
        """Torque in the shaft behind each joint `(…, n)` [N·m]."""
        return self.moment_out[..., 0]

    @property
    def bending_in(self) -> Array:
        """Bending moment of the shaft before each joint `(…, n)` [N·m]."""
        return _across(self.moment_in)

    @property
    def bending_out(self) -> Array:
        """Bending moment of the shaft behind each joint `(…, n)` [N·m]."""
        return _across(self.moment_out)

    @property
    def bearing_radial(self) -> Array:
        """Size of each bearing's force across its shaft `(…, m)` [N]."""
        return _across(self.bearing_force)

    @property
    def bearing_axial(self) -> Array:
        """Force of each bearing along its shaft `(…, m)` [N]."""
        return self.bearing_force[..., 0]

    @property
    def spline_friction(self) -> Array:
        """Friction force of each spline, with its sign on the rear piece `(…, s)` [N]."""
        return self.spline_force[..., 0]

    @property
    def spline_torque(self) -> Array:
        """Torque through each spline `(…, s)` [N·m]."""
        return self.spline_moment[..., 0]

    @property
    def spline_bending(self) -> Array:
        """Bending moment at the middle of each spline `(…, s)` [N·m]."""
        return _across(self.spline_moment)

    @property
    def centring(self) -> Array:
        """Size of the force in the centring of each coupling piece `(…, c)` [N]."""
        return np.asarray(np.linalg.norm(self.centring_force, axis=-1))

    def times(self, factor: Array) -> LineForces:
        """Return these forces times a factor `(…)`; what acts on a line without inertia is so."""
        return LineForces(
            *(
                values * factor.reshape(factor.shape + (1,) * (values.ndim - factor.ndim))
                for values in self
            )
        )

    def plus(self, other: LineForces) -> LineForces:
        """Return the sum of what acts for two reasons; forces follow linearly from what acts."""
        return LineForces(*(one + two for one, two in zip(self, other, strict=True)))


def _across(vectors: Array) -> Array:
    return np.hypot(vectors[..., 1], vectors[..., 2])


class LinePlot(Plot):
    """Draws an analysis: `analysis.plot()`, or columns of its table as `Plot` does."""

    def __call__(self, *columns: Any, **options: Any) -> Figure:
        """Draw columns over the rotation of the input shaft; of none, all along the line.

        That is, from above: the angle error of every shaft behind a joint, its speed ratio, the
        bending moments before and behind each joint, and the bearings' forces across their shafts,
        with inertia and weight, in the units of most data of the line.

        Args:
            columns: see `Plot`.
            options: `title` (the name of the line unless given), `ax` (four axes) and `figsize`;
                of columns, see `Plot`.

        Raises:
            ArgumentError: no such column, or the analysis is of many designs.
            MissingExtraError: matplotlib is not installed.
        """
        if columns:
            return super().__call__(*columns, **options)
        from ..drawing import over_angle  # Imported here: few scripts draw.

        return over_angle(self._result, **own_options(options))

    def _draw(self, at: Any, drawn: Mapping[str, Any], known: Any, **options: Any) -> Figure:
        from ..drawing import open_note

        are_forces = any(unit in ("N", "N·m") for _, unit in drawn.values())
        note = open_note(self._result) if are_forces else ""
        return super()._draw(at, drawn, known, **{**options, "note": note})


@dataclass(frozen=True, eq=False, repr=False)
class Analysis(Result, Record):
    """Motion of a line of n joints, and what acts along it.

    `(…)` stands for `(P,)` positions, or `(D, P)` for D designs. Arrays cannot be written to.

    Attributes:
        name: of the line.
        shafts: names of its n + 1 shafts.
        joints: names of its n joints.
        bearings: names of its m bearings; `bearing_in` and `bearing_out` are those at the joints
            of end shafts without bearings of their own.
        splines: names of the s shafts that have a spline.
        centrings: names of the c coupling pieces of centred double joints.
        speed: of the input shaft [rad/s].
        position: `(P,)` of the input shaft [rad], 0 where its fork's pin is horizontal.
        moved: adjustable joints to their positions `(D,)` in each design [rad or m]; empty
            without variants.
        rotation: `(…, n + 1)` rotation of each shaft about its axis [rad]. All count from where
            they would be if the joints were straight, from shaft to shaft by the shortest swing.
        ratio: `(…, n + 1)` speed of each shaft over that of the input shaft.
        acceleration: `(…, n + 1)` angular acceleration of each shaft about its axis [rad/s²].
        static: forces without inertia and weight: from the torque, and the friction of splines.
        inertial: what inertia and weight add, the friction of splines under the torque that they
            make included; None if there are none.
        slip: `(…, s)` by how much each spline is drawn out against the data [m].
        mean_lead: `(n + 1,)`, or `(D, n + 1)` of designs: mean of each shaft's rotation minus that
            of the input shaft, over a turn of this [rad].
        indeterminate: what statics leaves open; forces there are the ones of least norm.
        loop_residual: worst closure error; see `Sweep`.
        balance_residual: worst imbalance of a body; see `Sweep`. NaN where nothing acts.
        power_residual: worst imbalance of power; see `Sweep`.
        units: in which it is drawn, `si` or `imperial`: those of most data of the line.
    """

    name: str
    shafts: tuple[str, ...]
    joints: tuple[str, ...]
    bearings: tuple[str, ...]
    splines: tuple[str, ...]
    centrings: tuple[str, ...]
    speed: float
    position: Array
    moved: Mapping[Adjustable, Array]
    rotation: Array
    ratio: Array
    acceleration: Array
    static: LineForces
    inertial: LineForces | None
    slip: Array
    mean_lead: Array
    indeterminate: tuple[str, ...]
    loop_residual: float
    balance_residual: float
    power_residual: float
    units: str = "si"

    def __post_init__(self) -> None:
        super().__post_init__()
        for array in (*self.static, *(self.inertial or ()), *self.moved.values()):
            read_only(array)

    @property
    def designs(self) -> FrozenDict[str, Array]:
        """Names of adjustable joints to their positions `(D,)` in each design [rad or m]."""
        return FrozenDict({joint.name: values for joint, values in self.moved.items()})

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the samples."""
        return self.rotation.shape[:-1]

    @property
    def total(self) -> LineForces:
        """Forces with inertia and weight."""
        return self.static if self.inertial is None else self.static.plus(self.inertial)

    @property
    def angle_error(self) -> Array:
        """Lead of each shaft over the input shaft, without its mean over a turn `(…, n + 1)` [rad].

        Whatever positions there are.
        """
        mean = self.mean_lead if len(self.shape) == 1 else self.mean_lead[:, None]
        return self.rotation - self.rotation[..., :1] - mean

    @property
    def plot(self) -> LinePlot:
        """Figures: `analysis.plot()` of all along the line, or of columns of its table."""
        return LinePlot(self)

    def table(self) -> Table:
        """Return all results, with names for dimensions, and units.

        The dimensions are

        - `position`, of the input shaft [rad], and `design` where there are variants,
        - `shaft`, `joint`, `bearing`, `spline` and `coupling_piece`, with their names,
        - `component`: x, y, z of moments in axes of the shafts, and `bearing_component`: along,
          left, up.

        `rotation`, `angle_error`, `ratio` and `acceleration` are those of every shaft. Moments,
        torsion and bending have names that end in `_in` for the shaft before a joint, and in `_out`
        for the one behind it. All forces are with inertia and weight; those without have names that
        begin with `static_`, and are there where it makes a difference. The adjustable joints that
        differ from design to design are coordinates.
        """
        return Table(
            variables=list(self._variables()),
            samples=dict(zip(self._samples, self.shape, strict=True)),
            labels={
                "shaft": self.shafts,
                "joint": self.joints,
                "bearing": self.bearings,
                "spline": self.splines,
                "coupling_piece": self.centrings,
                "component": "xyz",
                "bearing_component": ("along", "left", "up"),
            },
            attributes={
                "line": self.name,
                "speed": self.speed,
                "indeterminate": "; ".join(self.indeterminate),
                "loop_residual": self.loop_residual,
                "balance_residual": self.balance_residual,
                "power_residual": self.power_residual,
                "cardan_dyn_version": __version__,
            },
        )

    @property
    def _samples(self) -> tuple[str, ...]:
        return ("design", "position")[-len(self.shape) :]

    def _variables(self) -> Iterator[tuple[str, Variable]]:
        samples = self._samples
        for name, dims, unit, text in _MOTION:
            yield name, Variable((*samples, *dims.split()), getattr(self, name), unit, text)
        both = {"": self.total, **({} if self.inertial is None else {"static_": self.static})}
        for prefix, forces in both.items():
            for name, dims, unit, text in _FORCES:
                values = getattr(forces, name)
                yield prefix + name, Variable((*samples, *dims.split()), values, unit, text)
        yield "position", Variable(("position",), self.position, "rad", "of the input shaft", True)
        for joint, values in self.moved.items():
            text = f"position of {joint.name}"
            yield joint.name, Variable(("design",), values, joint.unit, text, True)

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return (
            f"<Analysis of {self.name!r}: {' × '.join(map(str, self.shape))} samples, "
            f"{len(self.joints)} joints, {len(self.bearings)} bearings>"
        )
