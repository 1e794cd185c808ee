"""Arguments of scans and simulations: numbers in range, joints that have pins, their bearings."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Set
from typing import TYPE_CHECKING, Any

import numpy as np

from cardan_dyn.analytic.impact import Start

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.problem import Problem
from ...kit.arrays import ROUNDED, Array
from ...kit.checks import described, mapping, names, number, positive
from ...kit.errors import ArgumentError, ModelError, choices
from .opened_joint import Bearing, OpenedJoint, PinAxis
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    from ...core.mechanism.mechanism import Mechanism
    from ...scene.scene import Scene

Lengths = float | Mapping[str, float]
"""One of all joints, or by name [m]."""
Stiffnesses = float | PinGeometry | Mapping[str, float | PinGeometry]
"""One of all contacts [N/m], or by name; a geometry decides it by the force."""


def damping_ratio_of(ratio: Any) -> float:
    """Return a damping ratio."""
    found = number("damping_ratio", ratio)
    if not 0.0 <= found < 1.0:
        raise ArgumentError(f"damping_ratio is {found:g}; it lies from 0 to below 1")
    return found


def start_of(start: Any) -> Start:
    """Return how flights start."""
    if not isinstance(start, str) or start not in ("release", "rest"):
        raise ArgumentError(f"start is {described(start)}; it is 'release' or 'rest'")
    return start  # type: ignore[return-value]


def scene_of(given: Any) -> Scene:
    """Return a scene."""
    from ...scene.scene import Scene

    if not isinstance(given, Scene):
        raise ArgumentError(
            f"scene is {described(given)}, expected a scene: joints are opened in its mechanism, "
            "which a response no longer has"
        )
    return given


def speed_of(value: Any) -> float:
    """Return the speed of the drive."""
    speed = number("speed", value)
    if speed * speed == 0.0:
        raise ArgumentError(
            f"speed is {speed:g}, and so are inertia forces; joints reverse their forces by "
            "inertia: give a speed"
        )
    return speed


def period_of(solver: ProblemSolver) -> float:
    """Return the drive's way after which the motion repeats [rad]."""
    problem = solver.problem
    problem.refuse_free("clearance in joints")
    if len(problem.independent) > 1:
        raise ArgumentError("the scene has several drives; hold all but one of them")
    if not solver.has_mass:
        raise ModelError(f"{problem.mechanism.name}: no body has mass, so that nothing can strike")
    period = solver.assembly.period()
    if period is None:
        raise ArgumentError(
            f"{problem.independent[0]} does not come back to itself: there is no period"
        )
    return float(period)


def of_joint(label: str, given: Any, name: str) -> tuple[str, Any]:
    """Return what is given for a joint, for all joints or by name, and how messages call it."""
    if not isinstance(given, Mapping):
        return label, given
    if name not in mapping(label, given):
        raise ArgumentError(f"{label} has no value for joint {name!r}; it has {choices(given)}")
    return f"{label}[{name!r}]", given[name]


def clearance_of(given: Any, name: str, length: float) -> float:
    """Return the clearance of a joint, given for all joints or by name.

    Args:
        given: of all joints or by name.
        name: of the joint.
        length: of the mechanism [m].
    """
    label, value = of_joint("clearance", given, name)
    clearance = positive(label, value)
    if not clearance < length:
        raise ArgumentError(
            f"{label} is {clearance:g} m, no less than the mechanism of {length:.3g} m; "
            "clearances are in m"
        )
    return clearance


def refuse_unknown(joints: Collection[str], what: str = "is no joint", /, **given: Any) -> None:
    """Refuse values by name of joints that are none of some.

    Args:
        joints: names of these.
        what: is wrong with others.
        given: arguments; those that are no mappings hold for all joints.
    """
    for label, values in given.items():
        for name in values if isinstance(values, Mapping) else ():
            if name not in joints:
                raise ArgumentError(
                    f"{label} names {described(name)}, which {what}; {choices(joints, name)}"
                )


def joint_names(asked: Any) -> tuple[str, ...]:
    """Return names of joints, each once; of a set, any order will do."""
    found = names("joints", list(asked) if isinstance(asked, Set) else asked)
    if not found:
        raise ArgumentError("joints is empty; name those that have clearance")
    if len(set(found)) < len(found):
        raise ArgumentError("joints names a joint twice")
    return found


def pins_of(problem: Problem, asked: Collection[str] | None) -> tuple[list[str], dict[str, str]]:
    """Return the joints that turn about one axis, and why others are left out."""
    pins, left_out = [], {}
    for name in problem.mechanism.joints if asked is None else asked:
        joint = problem.mechanism.joint(name)
        reason = ""
        if name not in problem.outputs:
            reason = "it is no output of the scene"
        elif joint.type == "universal":
            reason = (
                "its cross has no mass that could strike. A scan takes it with radius=; for a "
                "simulation, describe the cross as a link with mass between two turning joints"
            )
        elif len(joint.parts) > 1 or joint.parts[0].kind != "revolute":
            reason = "it has no pin: it does not turn about one axis"
        if reason and asked is not None:
            raise ModelError(f"joint {name!r}: {reason}")
        if reason:
            left_out[name] = reason
        else:
            pins.append(name)
    return pins, left_out


def universal_pins(mechanism: Mechanism, name: str) -> tuple[PinAxis, PinAxis]:
    """Return both pins of a universal joint.

    Args:
        mechanism: that has it.
        name: of a joint of type `universal`, or of the link that is the cross.
    """
    if name in mechanism.joints:
        joint = mechanism.joints[name]
        if joint.type != "universal":
            raise ModelError(
                f"joint {name!r} is of type {joint.type}; name a joint of type universal, or the "
                "link that is the cross"
            )
        pins = [
            PinAxis(coordinate, name, part)
            for coordinate, part in zip(joint.coordinates, joint.parts, strict=True)
        ]
        return pins[0], pins[1]
    if name not in mechanism.links:
        raise ModelError(f"no link or joint {name!r}; {choices(mechanism.links, name)}")
    description = mechanism.description
    ends = {item.name: (item.parent, item.child) for item in description.joints}
    ends.update({loop.name: (loop.predecessor, loop.successor) for loop in description.loops})
    pins = [
        PinAxis(joint.name, joint.name, joint.parts[0])
        for joint in mechanism.joints.values()
        if name in ends[joint.name] and len(joint.parts) == 1 and joint.parts[0].kind == "revolute"
    ]
    if len(pins) != 2:
        raise ModelError(
            f"link {name!r} is no cross: {len(pins)} joints that turn about one axis hold it, "
            "not two"
        )
    return pins[0], pins[1]


def opened_joints(
    solver: ProblemSolver,
    rotor: Any,
    joints: str | Collection[str] | None,
    bearings: str | Collection[str] | None,
    clearance: Any,
    stiffness: Any,
    radius: Any,
) -> tuple[dict[str, OpenedJoint], dict[str, str]]:
    """Return the joints that are scanned, by name, and why others are left out; see `scan`."""
    problem, mechanism = solver.problem, solver.problem.mechanism
    wanted = None if joints is None else joint_names(joints)
    crosses = {
        name: universal_pins(mechanism, name)
        for name in wanted or ()
        if (
            mechanism.joints[name].type == "universal"
            if name in mechanism.joints
            else name in mechanism.links or radius is not None
        )
    }
    pins = {pin.name: pin for two in crosses.values() for pin in two}
    for pin in pins.values():
        if pin.joint not in problem.outputs:
            raise ModelError(f"joint {pin.joint!r} is no output of the scene; name it there")
    if not crosses:
        for label, value in (("radius", radius), ("bearings", bearings)):
            if value is not None:
                raise ArgumentError(
                    f"{label} belongs to universal joints; name one of type universal, or the link "
                    "that is its cross, in joints"
                )
    simple = None if wanted is None else [name for name in wanted if name not in crosses]
    found, left_out = pins_of(problem, simple)
    refuse_unknown(
        [*mechanism.joints, *pins], clearance=clearance, stiffness=stiffness, radius=radius
    )
    every = [Bearing(name, name, 0, 0.0) for name in found]
    for two in crosses.values():
        every += [
            Bearing(f"{pin.name}{sign}", pin.name, index, float(f"{sign}1"))
            for index, pin in enumerate(two)
            for sign in "+-"
        ]
    if bearings is not None:
        ends = [item.name for item in every if item.sign]
        asked = names("bearings", list(bearings) if isinstance(bearings, Set) else bearings)
        for name in asked:
            if name not in ends and name not in pins:
                raise ModelError(f"no bearing {name!r}; {choices([*pins, *ends], name)}")
        every = [item for item in every if not item.sign or {item.name, item.of} & set(asked)]
    length, opened = mechanism.characteristic_length, {}
    # In the order in which they were asked for.
    for name in wanted or found:
        both: tuple[PinAxis, ...] = crosses.get(name) or ()
        own = tuple(item for item in every if item.of in [name, *(pin.name for pin in both)])
        if not own:
            raise ArgumentError(
                f"bearings names none of {name!r}; leave it out for all four of each joint"
            )
        radii = _radii(radius, own, length) if both else None
        clearances = [clearance_of(clearance, item.of, length) for item in own]
        laws = []
        for item, value in zip(own, clearances, strict=True):
            if radii is not None and not value < radii[item.pin]:
                raise ArgumentError(
                    f"clearance is {value:g} m, no less than the radius of {radii[item.pin]:g} m "
                    "at which it is"
                )
            label, law = of_joint("stiffness", stiffness, item.of)
            laws.append(law if isinstance(law, PinGeometry) else positive(label, law))
        opened[name] = OpenedJoint(
            solver, rotor, name, both, own, np.array(clearances), laws, radii
        )
    return opened, left_out


def _radii(given: Any, bearings: tuple[Bearing, ...], length: float) -> Array:
    """Return the radii of both pins of a cross, NaN of one without open bearings [m]."""
    # Within such a ratio to the mechanism's length, either way, rounding spares both.
    found, far = np.full(2, np.nan), float(np.sqrt(ROUNDED))
    low, high = far * length, length / far
    for item in bearings:
        if given is None:
            raise ArgumentError(
                f"radius is None; give the distance of the bearings of {item.of!r} from the centre "
                "of the joint"
            )
        label, value = of_joint("radius", given, item.of)
        found[item.pin] = positive(label, value)
        if not low <= found[item.pin] <= high:
            raise ArgumentError(
                f"{label} is {found[item.pin]:g} m; in a mechanism of {length:.3g} m it lies from "
                f"{low:.3g} to {high:.3g} m"
            )
    return found
