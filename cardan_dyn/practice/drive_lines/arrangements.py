"""Arrangements: the common drive lines in one line each, by the quantities of the catalogues.

Joint angles of the Z and W arrangement lie in the side view. Spatial arrangements are given by the
bends of both joints in the side view, V, and the plan view, H, along the power flow: V is positive
where the shaft behind the joint rises against the one before, H where it leads to the right. So the
catalogue's diagram (Bild 18), H to the right and V up, is what one sees along the power flow, and
its fork offset has the sign of `Shaft.fork_offset`: positive clockwise.

Source:
    Catalogue of cardan shafts, chapter 6 (Bild 14 to 20), exact where it is of first order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cardan_dyn.analytic import compound_angle

from ...kit.checks import vector
from ...kit.errors import ArgumentError, choices
from .design.fork_choice import halved
from .design.phasing import phasing, with_forks
from .drive_line import DriveLine
from .line.fields import Entry, number
from .line.parts import Bearing, Centring, Shaft, Spline

if TYPE_CHECKING:
    from ...figures.style import Figure

PARALLEL = ("common", "input", "output")
_BEND = Entry("quantity", "angle", above=-math.pi / 2, below=math.pi / 2)
_TURN = Entry("quantity", "angle", least=0.0, below=math.pi)
_SPAN = Entry("quantity", "length", above=0.0)


class GraphicalMethod(NamedTuple):
    """What the catalogue's diagram (Bild 18) tells about the forks of a common shaft.

    Attributes:
        beta_h: `(2,)` bends of both joints in the plan view [rad].
        beta_v: `(2,)` bends in the side view [rad].
        joint_angles: `(2,)` joint angles by the printed formula, from tangents [rad].
        drawn_angles: `(2,)` lengths of the lines in the diagram, which adds angles instead [rad].
        directions: `(2,)` of the bending planes, from V towards H [rad].
        fork_offset: by which the rear fork is to be turned against the front one, clockwise seen
            along the power flow; -π/2 < offset <= π/2 [rad].
    """

    beta_h: tuple[float, float]
    beta_v: tuple[float, float]
    joint_angles: tuple[float, float]
    drawn_angles: tuple[float, float]
    directions: tuple[float, float]
    fork_offset: float

    def plot(
        self, *, title: str = "", ax: Any = None, figsize: tuple[float, float] | None = None
    ) -> Figure:
        """Draw the catalogue's diagram, H to the right and V up.

        Args:
            title: of the figure; what it shows unless given.
            ax: axes to be drawn into instead of a new figure.
            figsize: width and height of a new figure [inch].

        Raises:
            MissingExtraError: matplotlib is not installed.
            ArgumentError: more than one axes.
        """
        from .drawing import bending_planes  # Imported here: few scripts draw.

        return bending_planes(self, title=title, ax=ax, figsize=figsize)


def graphical_method(
    beta_v1: float, beta_h1: float, beta_v2: float, beta_h2: float
) -> GraphicalMethod:
    """Return joint angles, bending planes and fork offset from the bends in two views.

    They are exact if the common shaft is parallel to both drawing planes, and of first order if
    another shaft is: see `spatial_arrangement`.

    Args:
        beta_v1: bend of joint 1 in the side view [rad], between -π/2 and π/2.
        beta_h1: bend of joint 1 in the plan view [rad].
        beta_v2: bend of joint 2 in the side view [rad].
        beta_h2: bend of joint 2 in the plan view [rad].

    Raises:
        ArgumentError: a bend is not finite or out of its range.

    Source:
        Catalogue 6.3, Bild 17 to 19.

    >>> found = graphical_method(*np.radians([15.0, 7.0, -11.5, 12.0]))
    >>> np.degrees(found.joint_angles).round(2), round(float(np.degrees(found.fork_offset)), 2)
    (array([16.42, 16.4 ]), -70.87)
    """
    h, v = _views(beta_v1, beta_h1, beta_v2, beta_h2)
    angles = compound_angle.compound_angle(np.array(h), np.array(v))
    planes = compound_angle.bending_plane(np.array(h), np.array(v))
    offset = compound_angle.fork_offset(h[0], v[0], h[1], v[1])
    return GraphicalMethod(
        h,
        v,
        (float(angles[0]), float(angles[1])),
        (math.hypot(h[0], v[0]), math.hypot(h[1], v[1])),
        (float(planes[0]), float(planes[1])),
        float(offset),
    )


def z_arrangement(
    beta_1: float,
    length: float,
    *,
    beta_2: float | None = None,
    spans: Sequence[float] | None = None,
    **fields: Any,
) -> DriveLine:
    """Return a double shaft in Z: the output shaft is parallel to the input shaft (Bild 15).

    The forks of the common shaft are in line. It has a spline in its middle.

    Args:
        beta_1: angle of joint 1 [rad]; the common shaft rises by it, or falls if it is negative.
        length: of the common shaft between the joints [m].
        beta_2: angle of joint 2, if it differs [rad].
        spans: a, b, e, f of the support bearings as in `analytic.support_forces`: B and E stand b
            and e from their joint, A and F another a and f further away [m]. None without bearings.
        fields: others of the `DriveLine`, as speed and torque.

    Raises:
        ArgumentError: an angle or a span is out of its range.
        ModelError: as `Shaft` and `DriveLine` do.
    """
    first = _bend(beta_1, "beta_1")
    second = first if beta_2 is None else _bend(beta_2, "beta_2")
    return _line([0.0, first, first - second], [0.0] * 3, [length], [0.0], spans, fields)


def w_arrangement(
    beta_1: float,
    length: float,
    *,
    beta_2: float | None = None,
    spans: Sequence[float] | None = None,
    **fields: Any,
) -> DriveLine:
    """Return a double shaft in W: both joints bend in the same sense (Bild 16).

    Arguments and errors are those of `z_arrangement`.
    """
    first = _bend(beta_1, "beta_1")
    second = first if beta_2 is None else _bend(beta_2, "beta_2")
    return _line([-first, 0.0, second], [0.0] * 3, [length], [0.0], spans, fields)


def spatial_arrangement(
    beta_v1: float,
    beta_h1: float,
    beta_v2: float,
    beta_h2: float,
    length: float,
    *,
    parallel: str = "common",
    fork_offset: float | None = None,
    spans: Sequence[float] | None = None,
    **fields: Any,
) -> DriveLine:
    """Return a double shaft that bends in two views (Bild 14, 17 to 19).

    The bends are differences of the slopes that the shafts have in the two views. Joint angles and
    the fork offset of `graphical_method` belong to a common shaft that is parallel to both drawing
    planes. If another shaft is, as the input shaft in a vehicle, they are of first order: in the
    example of Bild 19 joint 2 then has 16.55° instead of 16.40°, and the best fork offset is
    -72.30° instead of -70.87°. With the printed offset a residual angle of 3.79° is left, above the
    catalogue's 3°, with the best one 2.11°, since the joint angles differ. With the common shaft
    parallel 0.95° is left for that reason alone, and with the wrong sign of the offset 18.2°.

    Args:
        beta_v1: bend of joint 1 in the side view [rad], between -π/2 and π/2.
        beta_h1: bend of joint 1 in the plan view [rad].
        beta_v2: bend of joint 2 in the side view [rad].
        beta_h2: bend of joint 2 in the plan view [rad].
        length: of the common shaft between the joints [m].
        parallel: the shaft that is parallel to both drawing planes: `common`, `input` or `output`.
        fork_offset: of the common shaft [rad]; the exact best one unless given.
        spans: as in `z_arrangement`.
        fields: others of the `DriveLine`.

    Raises:
        ArgumentError: an argument is out of its range.
        ModelError: as `Shaft` and `DriveLine` do.
    """
    if parallel not in PARALLEL:
        raise ArgumentError(
            f"parallel = {parallel!r} is unknown; shafts: {choices(PARALLEL, parallel)}"
        )
    right, side = _views(beta_v1, beta_h1, beta_v2, beta_h2)
    level = ("input", "common", "output").index(parallel)
    slopes_side, slopes_left = (
        [float(slope) for slope in slopes - slopes[level]]
        for slopes in (np.cumsum([0.0, *side]), -np.cumsum([0.0, *right]))
    )
    line = _line(slopes_side, slopes_left, [length], [fork_offset or 0.0], spans, fields)
    if fork_offset is None:
        return with_forks(line, halved(line.geometry.plane_offsets[1:]))
    return line


def centred_double_joint(
    angle: float, arm: float, *, equal_at: float | None = None, **fields: Any
) -> DriveLine:
    """Return a centred double joint (wide-angle joint): two joints close to each other, in W.

    The centring holds the point in which input and output shaft meet. It is fixed to the output
    shaft and slides along the input shaft, so that the joint angles are equal at 0 and at one
    angle only, that the centring is made for.

    Args:
        angle: between input and output shaft [rad], 0 <= angle < π.
        arm: half the distance of the joints [m].
        equal_at: angle for which the centring is made, a ball fixed to the output shaft [rad];
            unless given a disc, which halves every angle.
        fields: others of the `DriveLine`.

    Raises:
        ArgumentError: an angle that is out of its range or cannot be reached.
        ModelError: as `Shaft` and `DriveLine` do.

    Source:
        Sine rule in the triangle of both joints and the centre, which stands a / cos(equal_at/2)
        from joint 2: sin beta_1 = sin(angle) / (2 cos(equal_at/2)). Elbe and SOREM describe the
        joint.
    """
    total = number(angle, _TURN, "angle", ArgumentError)
    made_for = total if equal_at is None else number(equal_at, _TURN, "equal_at", ArgumentError)
    kind = Centring()
    if equal_at is not None and math.sin(total) < 2.0 * math.cos(made_for / 2.0):
        kind = Centring(kind="ball", equal_at=made_for)
    elif equal_at is not None:
        raise ArgumentError(
            f"angle = {math.degrees(total):.6g}° is out of the reach of a centring made for "
            f"{math.degrees(made_for):.6g}°; give a smaller one"
        )
    coupling = Shaft(name="coupling", length=2.0 * arm, centring=kind)
    ends = (Shaft(slope_side=-total / 2.0), Shaft(slope_side=total / 2.0))
    return DriveLine(shafts=(ends[0], coupling, ends[1]), **fields)


def centre_bearing_line(
    slopes: Sequence[float],
    lengths: Sequence[float],
    bearing: float,
    *,
    slopes_plan: Sequence[float] = (0.0,) * 4,
    fork_offsets: Sequence[float] | None = None,
    spans: Sequence[float] | None = None,
    **fields: Any,
) -> DriveLine:
    """Return a line of three joints, whose first intermediate shaft has a centre bearing (Bild 20).

    The second one has a spline in its middle.

    Args:
        slopes: of the four shafts in the side view [rad].
        lengths: of the two shafts between the joints [m].
        bearing: distance of the centre bearing from joint 1 [m].
        slopes_plan: of the four shafts in the plan view, positive to the left [rad].
        fork_offsets: of the two shafts [rad]; unless given, those with the least residual angle at
            the output, see `DriveLine.phasing`.
        spans: as in `z_arrangement`.
        fields: others of the `DriveLine`.

    Raises:
        ArgumentError: not four slopes, two lengths and two offsets, or a span is out of its range.
        ModelError: as `Shaft` and `DriveLine` do.
    """
    side, plan = (
        vector("slopes", slopes, 4).tolist(),
        vector("slopes_plan", slopes_plan, 4).tolist(),
    )
    inner = vector("lengths", lengths, 2).tolist()
    offsets = vector(
        "fork_offsets", (0.0, 0.0) if fork_offsets is None else fork_offsets, 2
    ).tolist()
    line = _line(side, plan, inner, offsets, spans, fields, centre=bearing)
    return phasing(line).line if fork_offsets is None else line


def _line(
    side: Sequence[float],
    plan: Sequence[float],
    lengths: Sequence[float],
    offsets: Sequence[float],
    spans: Sequence[float] | None,
    fields: dict[str, Any],
    centre: float | None = None,
) -> DriveLine:
    """Return a line by slopes of all shafts, and lengths and fork offsets of those between joints.

    The last one of these has a spline, the first one has a bearing at a distance, if it is given.
    """
    last = len(lengths) + 1
    bearings: dict[int, tuple[Bearing, ...]] = {}
    if centre is not None:
        bearings[1] = (Bearing(distance=centre),)
    if spans is not None:
        a, b, e, f = vector("spans", spans, 4).tolist()
        for name, span in zip("abef", (a, b, e, f), strict=True):
            number(span, _SPAN, f"{name} of spans", ArgumentError)
        bearings[0] = Bearing(distance=b + a, name="A"), Bearing(distance=b, name="B")
        bearings[last] = Bearing(distance=e, name="E"), Bearing(distance=e + f, name="F")
    shafts = [
        Shaft(
            length=length,
            slope_side=side[k],
            slope_plan=plan[k],
            fork_offset=offset,
            spline=Spline() if k == last - 1 else None,
            bearings=bearings.get(k, ()),
        )
        for k, (length, offset) in enumerate(
            zip([None, *lengths, None], [0.0, *offsets, 0.0], strict=True)
        )
    ]
    return DriveLine(shafts=tuple(shafts), **fields)


def _views(v1: object, h1: object, v2: object, h2: object) -> list[tuple[float, float]]:
    """Return the bends of both joints in the plan view, and in the side view."""
    return [
        (_bend(one, f"beta_{view}1"), _bend(two, f"beta_{view}2"))
        for view, one, two in (("h", h1, h2), ("v", v1, v2))
    ]


def _bend(value: object, name: str) -> float:
    return number(value, _BEND, name, ArgumentError)
