"""Arguments of scans: numbers in range, joints that have a pin, what a drive is."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Set
from typing import TYPE_CHECKING, Any

from cardan_dyn.analytic.impact import Start

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.problem import Problem
from ...core.response.identity import forces_identity
from ...kit.checks import described, mapping, names, number, positive
from ...kit.errors import ArgumentError, ModelError, choices
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    from ...scene.scene import Scene


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
    checked: Start = start  # type: ignore[assignment]
    return checked


def scene_of(given: Any) -> Scene:
    """Return a scene."""
    from ...scene.scene import Scene

    if not isinstance(given, Scene):
        raise ArgumentError(
            f"scene is {described(given)}, expected a scene: joints are opened in its mechanism, "
            "which a response no longer has"
        )
    return given


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


def stiffness_of(given: Any, name: str) -> float | PinGeometry:
    """Return the stiffness of a joint, given for all joints or by name."""
    label, value = of_joint("stiffness", given, name)
    return value if isinstance(value, PinGeometry) else positive(label, value)


def of_joint(label: str, given: Any, name: str) -> tuple[str, Any]:
    """Return what is given for a joint, and how messages call it."""
    if not isinstance(given, Mapping):
        return label, given
    if name not in mapping(label, given):
        raise ArgumentError(f"{label} has no value for joint {name!r}; it has {choices(given)}")
    return f"{label}[{name!r}]", given[name]


def refuse_unknown(joints: Collection[str], **given: Any) -> None:
    """Refuse values by name of joints that a mechanism does not have.

    Args:
        joints: names of its joints.
        given: arguments; those that are no mappings hold for all joints.
    """
    for label, values in given.items():
        for name in values if isinstance(values, Mapping) else ():
            if name not in joints:
                raise ArgumentError(
                    f"{label} names {described(name)}, which is no joint; {choices(joints, name)}"
                )


def joint_names(asked: Any) -> tuple[str, ...]:
    """Return names of joints, each once; of a set, any order will do."""
    found = names("joints", list(asked) if isinstance(asked, Set) else asked)
    if len(set(found)) < len(found):
        raise ArgumentError("joints names a joint twice")
    return found


def pins_of(
    problem: Problem, asked: str | Collection[str] | None
) -> tuple[list[str], dict[str, str]]:
    """Return the joints that turn about one axis, and why others are left out."""
    pins, left_out = [], {}
    wanted = tuple(problem.mechanism.joints) if asked is None else joint_names(asked)
    if not wanted:
        raise ArgumentError("joints is empty; name those that have clearance")
    for name in wanted:
        parts = problem.mechanism.joint(name).parts
        if len(parts) == 1 and parts[0].kind == "revolute" and name in problem.outputs:
            pins.append(name)
            continue
        reason = "it has no pin: it does not turn about one axis"
        if name not in problem.outputs:
            reason = "it is no output of the scene"
        if asked is not None:
            raise ModelError(f"joint {name!r}: {reason}")
        left_out[name] = reason
    return pins, left_out


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


def drive_of(problem: Problem, rotor: Any) -> tuple[list[int], dict[int, float]]:
    """Return velocity coordinates that are fixed, and those of rotors with their inertias.

    Args:
        problem: with one drive.
        rotor: inertia that turns with the drive; None if its motion is prescribed.
    """
    coordinates = problem.mechanism.coordinates
    drive, held = coordinates.named[problem.independent[0]].rate, coordinates.rates_of(problem.held)
    if rotor is None:
        return [drive, *held], {}
    return held, {drive: number("rotor", rotor, least=0.0)}


def made_of(problem: Problem, rotor: Any) -> dict[str, str]:
    """Return what the forces of a mechanism without clearance depend on, each with its hash.

    Two that differ in one of these have other forces.

    Args:
        problem: of the scene.
        rotor: inertia that turns with the drive; None if its motion is prescribed.
    """
    return forces_identity(problem, rotor=None if rotor is None else float(rotor))
