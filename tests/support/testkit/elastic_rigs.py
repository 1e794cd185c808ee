"""Descriptions of idealised elastic rigs with universal joints, by the numbers of their theory.

All turn about x along the power flow; `bearing_in` is driven, at zero its pin lies in the plane of
the shafts, whose normal is z. Bend angles are joints that a scene holds: `joint_angle`, or
`joint_angle_1` and `joint_angle_2`. Crosses have no mass. Springs and dampers are part of the
description, for `cd.described_elements`.
"""

from __future__ import annotations

from collections.abc import Sequence

import cardan_dyn as cd

_FAR = '<limit lower="-9" upper="9" effort="1e4" velocity="10"/>'
_QUARTER = '<limit lower="-1.57" upper="1.57" effort="1e4" velocity="10"/>'

_PLAY = '<limit lower="-0.01" upper="0.01" effort="1e6" velocity="10"/>'


def elastic_rig(
    polar: float = 0.1,
    diametral: float = 1.0,
    stiffness: float = 1.0,
    damping_ratio: float = 0.01,
) -> str:
    """Shaft 2 tilts about the joint's centre on springs; its free coordinates are both tilts.

    The bearing of shaft 2 tilts by `tilt_z` in the plane of the shafts, then by `tilt_y` across it.

    Args:
        polar: moment of inertia of shaft 2 about its axis.
        diametral: that across its axis about the joint's centre.
        stiffness: c of both tilts; ω_n² = c / diametral.
        damping_ratio: ζ of both tilts, damping 2 ζ √(c diametral).
    """
    dynamics = _spring(stiffness, 2.0 * damping_ratio * (stiffness * diametral) ** 0.5)
    return _robot(
        "elastic_rig",
        _link("base"),
        _link("shaft_in", 1.0),
        _link("cross"),
        _link("frame"),
        _link("tilted"),
        _link("housing_out"),
        _link("shaft_out", polar, diametral),
        _joint("bearing_in", "base", "shaft_in"),
        _joint("pin_in", "shaft_in", "cross", axis="0 1 0"),
        _joint("joint_angle", "base", "frame", "revolute", "0 0 1", inside=_QUARTER),
        _joint("tilt_z", "frame", "tilted", axis="0 0 1", inside=dynamics),
        _joint("tilt_y", "tilted", "housing_out", axis="0 1 0", inside=dynamics),
        _joint("bearing_out", "housing_out", "shaft_out"),
        _pin_out("pin_out", "cross", "shaft_out"),
    )


def torsional_line(
    inertia_in: float = 0.5,
    inertia_out: float = 0.5,
    stiffness_in: float | None = 1.0,
    stiffness_out: float | None = None,
    damping_in: float = 0.0,
    damping_out: float = 0.0,
    fork_inertia: float = 0.0,
) -> str:
    """A joint between shafts of which one or both are elastic: `twist_in`, `twist_out`.

    Args:
        inertia_in: J₁ of the input fork, behind the elastic shaft in front of the joint.
        inertia_out: J₂ of the flywheel, behind the elastic shaft at the output.
        stiffness_in: of the shaft in front of the joint; None for a rigid one.
        stiffness_out: of the shaft behind the joint; None for a rigid one.
        damping_in: damping coefficient of the shaft in front.
        damping_out: of the shaft behind.
        fork_inertia: of the output fork, where the shaft behind it is elastic.
    """
    parts = [_link(name) for name in ("base", "cross", "housing_out")]
    before, after = "shaft_in", "shaft_out"
    parts.append(_link("shaft_in", inertia_in))
    if stiffness_in is not None:
        before = "shaft_driven"
        parts += [
            _link("shaft_driven", 1.0),
            _joint("twist_in", before, "shaft_in", inside=_spring(stiffness_in, damping_in)),
        ]
    if stiffness_out is not None:
        after = "flywheel"
        parts += [
            _link("shaft_out", fork_inertia),
            _joint("twist_out", "shaft_out", after, inside=_spring(stiffness_out, damping_out)),
        ]
    return _robot(
        "torsional_line",
        *parts,
        _link(after, inertia_out),
        _joint("bearing_in", "base", before),
        _joint("pin_in", "shaft_in", "cross", axis="0 1 0"),
        _joint("joint_angle", "base", "housing_out", "revolute", "0 0 1", inside=_QUARTER),
        _joint("bearing_out", "housing_out", "shaft_out"),
        _pin_out("pin_out", "cross", "shaft_out"),
    )


def double_joint(
    inertia_out: float = 1.0,
    stiffness: float = 1.0,
    damping: float = 0.0,
    inertia_middle: float = 0.0,
) -> str:
    """A double joint in Z or W, forks in phase, whose middle shaft is elastic: `twist_middle`.

    With equal angles it is phased: the output turns uniformly as long as nothing vibrates.

    Args:
        inertia_out: of the output shaft.
        stiffness: of the middle shaft.
        damping: its damping coefficient.
        inertia_middle: of the middle shaft, half of it at either end.
    """
    return _robot(
        "double_joint",
        *(_link(name) for name in ("base", "cross_1", "cross_2", "carrier", "housing_out")),
        _link("shaft_in", 1.0),
        _link("middle_1", inertia_middle / 2.0),
        _link("middle_2", inertia_middle / 2.0),
        _link("shaft_out", inertia_out),
        _joint("bearing_in", "base", "shaft_in"),
        _joint("pin_1_in", "shaft_in", "cross_1", axis="0 1 0"),
        _joint("joint_angle_1", "base", "carrier", "revolute", "0 0 1", inside=_QUARTER),
        _joint("bearing_middle", "carrier", "middle_1"),
        _joint("twist_middle", "middle_1", "middle_2", inside=_spring(stiffness, damping)),
        _joint("pin_2_in", "middle_2", "cross_2", axis="0 0 1", origin="1 0 0"),
        _joint("joint_angle_2", "carrier", "housing_out", "revolute", "0 0 1", "1 0 0", _QUARTER),
        _joint("bearing_out", "housing_out", "shaft_out"),
        _pin_out("pin_1_out", "cross_1", "middle_1"),
        _pin_out("pin_2_out", "cross_2", "shaft_out", axis="0 1 0"),
    )


def sliding_rotor(
    mass: float = 1.7,
    reach: float = 0.3,
    polar: float = 0.4,
    diametral: float = 0.7,
    stiffness: Sequence[float] = (100.0, 130.0),
) -> str:
    """A rotor without a joint, whose housing slides along `x`, `y` and `z` and tilts by `yaw`.

    Args:
        mass: of the rotor.
        reach: of its centre of mass along its axis, from where the housing slides and tilts.
        polar: moment of inertia about its axis.
        diametral: that across it, about the centre of mass.
        stiffness: of the springs of `y` and `z`; the other coordinates have none.
    """
    slide = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    across, up = (slide + _spring(value, 0.0) for value in stiffness)
    return _robot(
        "sliding_rotor",
        *(_link(name) for name in ("base", "along", "across", "up", "housing")),
        f'<link name="rotor"><inertial><origin xyz="{reach!r} 0 0"/><mass value="{mass!r}"/>'
        f'<inertia ixx="{polar!r}" iyy="{diametral!r}" izz="{diametral!r}" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link>',
        _joint("x", "base", "along", "prismatic", "1 0 0", inside=slide),
        _joint("y", "along", "across", "prismatic", "0 1 0", inside=across),
        _joint("z", "across", "up", "prismatic", "0 0 1", inside=up),
        _joint("yaw", "up", "housing", axis="0 0 1"),
        _joint("turn", "housing", "rotor"),
    )


def rotor(
    mass: float = 20.0,
    offset: float = 1e-4,
    stiffness: tuple[float, float] = (2e6, 2e6),
    damping: float = 250.0,
) -> str:
    """A disc between springs: it slides across its axis along `y` and `z`, and spins.

    Args:
        mass: of the disc [kg].
        offset: of its centre of mass, along y at zero [m].
        stiffness: along y and z [N/m].
        damping: along either [N·s/m].
    """
    along_y, along_z = (_spring(value, damping) for value in stiffness)
    disc = (
        f'<link name="disc"><inertial><origin xyz="0 {offset!r} 0"/><mass value="{mass!r}"/>'
        '<inertia ixx="0.25" iyy="0.13" izz="0.13" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    return _robot(
        "rotor",
        *(_link(name) for name in ("base", "slide", "carrier")),
        disc,
        _joint("y", "base", "slide", "prismatic", "0 1 0", inside=_PLAY + along_y),
        _joint("z", "slide", "carrier", "prismatic", "0 0 1", inside=_PLAY + along_z),
        _joint("bearing_in", "carrier", "disc"),
    )


def unbalanced_rotor(mass: float = 1.0, length: float = 1.0) -> str:
    """An unbalanced rotor, driven by `turn`, on a carriage that slides by `slide_y` and tilts.

    Args:
        mass: of the rotor; inertias are in units of mass and length squared.
        length: distance of the carriage from the base.
    """
    size = mass * length**2
    return _robot(
        "unbalanced_rotor",
        *(_link(name) for name in ("base", "slider", "carriage")),
        f'<link name="rotor"><inertial><origin xyz="{0.1 * length!r} {0.003 * length!r} 0"/>'
        f'<mass value="{mass!r}"/><inertia ixx="{0.3 * size!r}" iyy="{0.5 * size!r}" '
        f'izz="{0.45 * size!r}" ixy="{0.01 * size!r}" ixz="{0.02 * size!r}" iyz="0"/></inertial>'
        "</link>",
        _joint("slide_y", "base", "slider", "prismatic", "0 1 0", f"{length!r} 0 0", _FAR),
        _joint("tilt", "slider", "carriage", "revolute", "0 0 1", inside=_QUARTER),
        _joint("turn", "carriage", "rotor"),
    )


def unbalanced_scene(mass: float = 1.0, length: float = 1.0) -> cd.Scene:
    """Return a scene of `unbalanced_rotor`, its springs and dampers in its units, weight."""
    size = mass * length**2
    springs = [
        cd.JointSpring("slide_y", 30.0 * mass, 0.5 * mass),
        cd.JointSpring("tilt", 12.0 * size, 0.3 * size),
    ]
    return cd.Scene(
        cd.load(unbalanced_rotor(mass, length)),
        drive="turn",
        free=["slide_y", "tilt"],
        elements=springs,
        gravity=[0.0, -0.2 * length, 0.0],
    )


def elastic_crank(
    inertia: float = 0.05, stiffness: float = 0.1, damping: float = 0.002, radius: float = 0.3
) -> str:
    """A slider-crank whose crank sits behind an elastic shaft: `twist`. The slider has 1 kg.

    Args:
        inertia: of the crank.
        stiffness: of the shaft.
        damping: its damping coefficient.
        radius: of the crank; the rod, without mass, is 1 m long.
    """
    slider = '<link name="slider"><inertial><mass value="1"/>'
    slider += '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    crank = '<link name="crank"><inertial><mass value="1"/>'
    crank += (
        f'<inertia ixx="1" iyy="1" izz="{inertia!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    across = "0 0 1"
    return _robot(
        "elastic_crank",
        *(_link(name) for name in ("base", "shaft", "rod")),
        crank,
        slider,
        _joint("bearing_in", "base", "shaft", axis=across),
        _joint("twist", "shaft", "crank", axis=across, inside=_spring(stiffness, damping)),
        _joint("crank_pin", "crank", "rod", axis=across, origin=f"{radius!r} 0 0"),
        _joint("slide", "base", "slider", "prismatic", origin=f"{1.0 + radius!r} 0 0", inside=_FAR),
        '<loop name="piston_pin" type="continuous"><predecessor link="rod"><origin xyz="1 0 0"/>'
        f'</predecessor><successor link="slider"/><axis xyz="{across}"/></loop>',
    )


def scene(urdf: str, beta: float, free: Sequence[str] | None = None, **options: object) -> cd.Scene:
    """Return a scene of one of these rigs: `bearing_in` driven, its springs, its bend angles held.

    Args:
        urdf: the description.
        beta: bend angle of every joint [rad].
        free: the free coordinates; all joints that have a spring unless given.
        options: further arguments of the scene.
    """
    mechanism = cd.load(urdf)
    elements = cd.described_elements(mechanism)
    angles = [name for name in mechanism.joints if name.startswith("joint_angle")]
    return cd.Scene(
        mechanism,
        drive="bearing_in",
        free=list(mechanism.joint_springs if free is None else free),
        held=dict.fromkeys(angles, beta),
        elements=elements,
        **options,
    )


def _robot(name: str, *parts: str) -> str:
    return f'<robot name="{name}">{"".join(parts)}</robot>'


def _link(name: str, polar: float = 0.0, diametral: float | None = None) -> str:
    """A link with its centre of mass in its origin, which lies on its axis of rotation."""
    if not polar:
        return f'<link name="{name}"/>'
    across = polar if diametral is None else diametral
    return (
        f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="{polar!r}" '
        f'iyy="{across!r}" izz="{across!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _spring(stiffness: float, damping: float) -> str:
    return f'<dynamics spring_stiffness="{stiffness!r}" damping="{damping!r}"/>'


def _joint(
    name: str,
    parent: str,
    child: str,
    kind: str = "continuous",
    axis: str = "1 0 0",
    origin: str = "0 0 0",
    inside: str = "",
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{origin}"/><axis xyz="{axis}"/>{inside}</joint>'
    )


def _pin_out(name: str, cross: str, shaft: str, axis: str = "0 0 1") -> str:
    return (
        f'<loop name="{name}" type="continuous"><predecessor link="{cross}"/>'
        f'<successor link="{shaft}"/><axis xyz="{axis}"/></loop>'
    )
