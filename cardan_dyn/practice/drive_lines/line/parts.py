"""Parts: what a drive line is made of, as plain data in SI units and radians.

Shafts are numbered 0 … n along the power flow, joints 1 … n: joint k stands between shafts k - 1
and k. Shafts 0 and n are the end shafts. Angles about a shaft are positive by the right-hand rule
about the power flow, which is the sense of rotation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ....kit.errors import ModelError
from .fields import day, flag, part, parts, point, positive, quantity, refuse, settle, text


@dataclass(frozen=True, kw_only=True)
class Tube:
    """The tube of a shaft; a solid shaft has a wall of half its outer diameter.

    Attributes:
        outer_diameter: outer diameter D [m].
        wall: thickness of the wall [m].
        density: density [kg/m³], that of steel unless given.
        modulus: Young's modulus [Pa], that of steel unless given.
        shear_modulus: shear modulus [Pa], that of steel unless given.
        shear_limit: greatest shear stress that is allowed under torque [Pa].
    """

    outer_diameter: float = quantity("length", above=0.0, plausible=(1e-3, 2.0))
    wall: float = quantity("length", above=0.0, plausible=(1e-4, 1.0))
    density: float = quantity("density", 7850.0, above=0.0)
    modulus: float = quantity("modulus", 2.1e11, above=0.0, plausible=(1e9, 1e12))
    shear_modulus: float = quantity("modulus", 8.08e10, above=0.0, plausible=(5e8, 5e11))
    shear_limit: float | None = positive("modulus")

    def __post_init__(self) -> None:
        settle(self)
        if self.wall > self.outer_diameter / 2:
            raise refuse(
                self, "wall", f"exceeds half the outer diameter {self.outer_diameter:.12g} m"
            )

    @property
    def inner_diameter(self) -> float:
        """Inner diameter d [m], 0 if solid."""
        return max(self.outer_diameter - 2.0 * self.wall, 0.0)

    @property
    def area(self) -> float:
        """Cross section [m²]."""
        return math.pi * self.wall * (self.outer_diameter - self.wall)

    @property
    def polar_moment(self) -> float:
        """Polar second moment of area, π (D⁴ - d⁴) / 32 [m⁴]."""
        return self.area * (self.outer_diameter**2 + self.inner_diameter**2) / 8.0

    @property
    def diameters(self) -> tuple[float, float]:
        """Outer and inner diameter [m]."""
        return self.outer_diameter, self.inner_diameter

    def torsional_stiffness(self, length: float) -> float:
        """Return G π (D⁴ - d⁴) / (32 L) of a length [m] of the tube [N·m/rad]."""
        return self.shear_modulus * self.polar_moment / length


@dataclass(frozen=True, kw_only=True)
class Spline:
    """A slip in a shaft, which passes on torque and bending but no axial force beyond its friction.

    Attributes:
        distance: distance from the joint at the shaft's front [m]; the middle of the shaft unless
            given.
        friction: coefficient μ; about 0.11 for greased steel, 0.08 for coated splines. Unless given
            analyses count with none, and forces of bearings pass no verdict.
        radius: mean radius r_m of the spline [m], which friction needs.
        travel: length over which it can slip, L_a [m].
        compressed: length of the shaft between its joints with the spline pushed in, L_z [m].
        profile: length of the profiles that overlap with the spline pushed in [m].
        shortest: least length of the shaft in operation [m]; that of the shaft unless given.
        longest: greatest length of the shaft in operation [m]; likewise.
    """

    distance: float | None = quantity("length", None, least=0.0)
    friction: float | None = quantity("number", None, least=0.0, plausible=(1e-3, 1.0))
    radius: float | None = positive("length", plausible=(1e-3, 1.0))
    travel: float | None = positive("length")
    compressed: float | None = positive("length")
    profile: float | None = positive("length")
    shortest: float | None = positive("length")
    longest: float | None = positive("length")

    def __post_init__(self) -> None:
        settle(self)
        if self.friction and self.radius is None:
            raise refuse(self, "friction", "needs the mean radius of the spline; give radius")


@dataclass(frozen=True, kw_only=True)
class Bearing:
    """A support bearing: it carries force across its shaft, and no moment.

    Attributes:
        distance: distance from its joint [m], along the shaft: on the input shaft against the power
            flow from joint 1, on any other along the flow from the joint at its front.
        name: its name; unless given A (far) and B (near the joint) on the input shaft, E (near) and
            F (far) on the output shaft, C1, C2, … on intermediate shafts.
        locating: whether it carries axial force too. Unless given, the bearing of an end shaft that
            is next to its joint does, and as many centre bearings as fix what lies between two
            splines.
        stiffness: stiffness across the shaft, with its bracket [N/m]; rigid unless given. Critical
            speeds count with it.
        radial_limit: greatest force that it bears across the shaft [N].
        axial_limit: greatest force that it bears along the shaft [N].
    """

    distance: float = quantity("length", above=0.0)
    name: str = text()
    locating: bool | None = flag()
    stiffness: float | None = positive("rigidity")
    radial_limit: float | None = positive("force")
    axial_limit: float | None = positive("force")

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, kw_only=True)
class Centring:
    """What keeps both halves of a centred double joint (wide-angle joint) at equal angles.

    A coupling piece between two joints with a cross has it instead of a bearing. Where the piece
    lies follows from the shafts before and behind it, whose axes meet in the centring; it presses
    them apart with a force that no bearing of the line takes.

    Attributes:
        kind: `disc`, which floats in the middle plane of the piece and which studs of both shafts
            reach into: both angles are equal, and the force lies in that plane; or `ball`, fixed to
            one of the shafts and sliding along the other: the angles are equal at one angle, and
            the force is normal to the other shaft.
        equal_at: of a ball, angle between both shafts at which the joint angles are equal, besides
            0 [rad]; that of the line unless given.
        fixed_to: of a ball, the shaft that it is fixed to: `rear` or `front`.
        force_limit: greatest force that it bears [N].
    """

    kind: str = text("disc", ("disc", "ball"))
    equal_at: float | None = quantity("angle", None, least=0.0, below=math.pi)
    fixed_to: str = text("rear", ("rear", "front"))
    force_limit: float | None = positive("force")

    def __post_init__(self) -> None:
        settle(self)
        if self.kind == "disc" and self.equal_at is not None:
            raise refuse(self, "equal_at", "is that of a ball; a disc makes all angles equal")


@dataclass(frozen=True, kw_only=True)
class ShaftJoint:
    """A joint between two shafts: a universal joint with a cross, or one of constant velocity.

    A joint of constant velocity (Rzeppa, other ball joints, tripod) is the ideal one: both shafts
    turn alike at any angle, and the moment between them lies in the plane that halves the angle
    between their normals. That a tripod lets its shaft orbit, and what rubs, does not count. A
    centred double joint is two joints with a cross, and a `Centring` in the piece between them.

    Attributes:
        name: name for messages and tables.
        kind: `cross` or `constant_velocity`.
        size: its size by a catalogue.
        cross_mass: mass of the cross [kg].
        cross_span: length of the cross over its pins [m]: two crossed rods of half the mass each
            give its inertia. Without it the mass is that of a point.
        rated_torque: T_D, with which its bearings live for 5000 h at n β = 300, n in 1/min and β in
            degrees [N·m].
        capacity: capacity factor L_C of its bearings, for torques in kN·m.
        torque_limit: T_CS, greatest torque that it stands without permanent deformation [N·m].
        pulsating_limit: T_DSch, greatest torque of one sense that it stands for ever [N·m].
        reversing_limit: T_DW, greatest torque of changing sense that it stands for ever [N·m].
        largest_angle: greatest joint angle that it allows [rad].
        largest_speed: greatest speed that it allows [rad/s].
        largest_n_beta: greatest product of speed and joint angle that it allows [rad²/s].
        din_808: bearings of a precision joint, `plain` or `needle`; empty for any other joint.
        table_torque: rated torque of a precision joint in its maker's table [N·m].
        pin_radius: radius of its pins [m], for its efficiency.
        pin_friction: coefficient of friction of its pin bearings.
    """

    name: str = text()
    kind: str = text("cross", ("cross", "constant_velocity"))
    size: str = text()
    cross_mass: float = quantity("mass", 0.0, least=0.0)
    cross_span: float = quantity("length", 0.0, least=0.0, plausible=(1e-3, 3.0))
    rated_torque: float | None = positive("torque")
    capacity: float | None = positive("number")
    torque_limit: float | None = positive("torque")
    largest_angle: float | None = positive("angle", below=math.pi / 2)
    largest_speed: float | None = positive("speed")
    pulsating_limit: float | None = positive("torque")
    reversing_limit: float | None = positive("torque")
    largest_n_beta: float | None = positive("n_beta")
    din_808: str = text(known=("", "plain", "needle"))
    table_torque: float | None = positive("torque")
    pin_radius: float | None = positive("length", plausible=(1e-4, 1.0))
    pin_friction: float | None = quantity("number", None, least=0.0)

    def __post_init__(self) -> None:
        settle(self)
        if self.kind != "cross":
            for field in ("cross_span", "rated_torque", "capacity", "pin_radius", "pin_friction"):
                if getattr(self, field):
                    raise refuse(self, field, f"is that of a cross, and its kind is {self.kind!r}")


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """A shaft: where it lies, how its forks stand, what it weighs and what carries it.

    Where it lies is given by its slopes, seen with x along the power flow, or by the points where
    its ends are; intermediate shafts end at the centres of their joints.

    Attributes:
        name: name for messages, tables and links.
        length: length of an intermediate shaft between the centres of its joints, of an end shaft
            from its joint to its other end [m].
        slope_side: slope in the side view, positive where the shaft rises along the flow [rad].
        slope_plan: slope in the plan view, positive where it leads to the left [rad].
        start: point `(3,)` where the shaft begins along the flow: x forward, y left, z up [m].
        end: point `(3,)` where it ends [m].
        fork_offset: angle from the fork at the front joint to that at the rear joint, about the
            flow; 0 if they are in line [rad]. Of intermediate shafts.
        tube: what the shaft is made of.
        spline: the slip in it.
        centring: centring of the coupling piece of a centred double joint, which has no slopes,
            points, bearings and spline of its own.
        bearings: bearings: two on an end shaft, or none if its support shall be one bearing at its
            joint; centre bearings on an intermediate shaft.
        mass: mass [kg]; that of the tube unless given, 0 without a tube.
        inertia: moment of inertia about its axis [kg·m²]; that of the tube unless given.
        transverse_inertia: moment of inertia across its axis about its centre of mass [kg·m²]; that
            of a rod of its length, or as little as its inertia allows, unless given.
        centre: distance of its centre of mass, counted like that of a `Bearing` [m]; half its
            length unless given.
        torsional_stiffness: torsional stiffness between its ends [N·m/rad]; that of the tube unless
            given.
    """

    name: str = text()
    length: float | None = positive("length")
    slope_side: float | None = quantity("angle", None, above=-math.pi / 2, below=math.pi / 2)
    slope_plan: float | None = quantity("angle", None, above=-math.pi / 2, below=math.pi / 2)
    start: tuple[float, float, float] | None = point()
    end: tuple[float, float, float] | None = point()
    fork_offset: float = quantity("angle", 0.0)
    tube: Tube | None = part(Tube)
    spline: Spline | None = part(Spline)
    centring: Centring | None = part(Centring)
    bearings: tuple[Bearing, ...] = parts(Bearing)
    mass: float | None = quantity("mass", None, least=0.0)
    inertia: float | None = quantity("inertia", None, least=0.0)
    transverse_inertia: float | None = quantity("inertia", None, least=0.0)
    centre: float | None = quantity("length", None, plausible=(0.0, 30.0))
    torsional_stiffness: float | None = positive("stiffness")

    def __post_init__(self) -> None:
        settle(self)
        slopes = [name for name in ("slope_side", "slope_plan") if getattr(self, name) is not None]
        if self.end is not None and slopes:
            raise refuse(
                self, slopes[0], "goes with a length, not with points; give slopes or points"
            )
        if self.start is not None and self.end is None:
            raise refuse(self, "start", "needs the other end of the shaft; give end")
        if self.centring is not None:
            for name in (*slopes, "start", "end", "spline", "bearings"):
                if getattr(self, name) not in (None, ()):
                    raise ModelError(
                        f"{name} of a Shaft with a centring: the shafts beside it say where it "
                        "lies, and they carry it; leave it out"
                    )
        heavy = self.mass or (self.mass is None and self.tube is not None)
        for name in ("inertia", "transverse_inertia"):
            if getattr(self, name) and not heavy:
                raise refuse(self, name, "needs a mass, as no body is without; give mass or tube")
        if self.inertia and self.transverse_inertia is not None:
            least = self.inertia / 2.0
            if self.transverse_inertia < least:
                raise refuse(
                    self,
                    "transverse_inertia",
                    f"is less than half the inertia about its axis, {least:.12g} kg·m², which no "
                    "body has",
                )

    def mass_at(self, length: float) -> float:
        """Return its mass [kg] with a length between its ends [m]; see `mass`."""
        if self.mass is not None:
            return self.mass
        return self.tube.density * self.tube.area * length if self.tube else 0.0


@dataclass(frozen=True, kw_only=True)
class DutyPoint:
    """A share of the time in which a line runs at a speed and a torque.

    Attributes:
        share: share of the time; the sum of all is 1.
        speed: speed of the input shaft [rad/s].
        torque: torque of the input shaft [N·m].
        name: name for tables.
    """

    share: float = quantity("number", above=0.0, most=1.0)
    speed: float = quantity("speed")
    torque: float = quantity("torque")
    name: str = text()

    def __post_init__(self) -> None:
        settle(self)


@dataclass(frozen=True, kw_only=True)
class TitleBlock:
    """What a report says at its head of where it belongs; a file of a line has it as `[report]`.

    Attributes:
        project: what the report is for.
        customer: whom it is for.
        author: who answers for it.
        revision: of the report.
        date: day of the report as YYYY-MM-DD; that on which it is written unless given.
    """

    project: str = text()
    customer: str = text()
    author: str = text()
    revision: str = text()
    date: str = day()

    def __post_init__(self) -> None:
        settle(self)
