"""Joint arguments: which joints and bearings are scanned, and what their contacts are."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Set
from typing import Any

import numpy as np

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.problem.problem import Problem
from ...kit.arrays import Array
from ...kit.checks import names as checked_names
from ...kit.checks import positive
from ...kit.errors import ArgumentError, ModelError, choices
from .arguments import clearance_of, joint_names, of_joint, pins_of, refuse_unknown, stiffness_of
from .opened_joint import Bearing, OpenedJoint
from .pin_geometry import PinGeometry
from .universal_joint import PinAxis, is_universal, universal_pins

Lengths = float | Mapping[str, float]
"""One of all joints, or by name [m]."""
Stiffnesses = float | PinGeometry | Mapping[str, float | PinGeometry]
"""One of all contacts [N/m], or by name; a geometry decides it by the force."""

_SIGNS = {"+": 1.0, "-": -1.0}
_LONGEST = 1e6
"""Ratio of a radius and the mechanism's length, either way, up to which rounding spares both."""


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
    wanted = () if joints is None else joint_names(joints)
    crosses = {
        name: _pins(problem, name)
        for name in wanted
        if is_universal(mechanism, name) or (name not in mechanism.joints and radius is not None)
    }
    if not crosses:
        for label, value in (("radius", radius), ("bearings", bearings)):
            if value is not None:
                raise ArgumentError(
                    f"{label} belongs to universal joints; name one of type universal, or the link "
                    "that is its cross, in joints"
                )
    simple = [name for name in wanted if name not in crosses]
    left_out: dict[str, str] = {}
    if simple or not crosses:
        simple, left_out = pins_of(problem, None if joints is None else simple)
    known = [*mechanism.joints, *(pin.name for pins in crosses.values() for pin in pins)]
    refuse_unknown(known, clearance=clearance, stiffness=stiffness, radius=radius)
    length = mechanism.characteristic_length
    found = {
        name: OpenedJoint(
            solver,
            rotor,
            name,
            clearances=np.array([clearance_of(clearance, name, length)]),
            laws=[stiffness_of(stiffness, name)],
        )
        for name in simple
    }
    chosen = _bearings(crosses, bearings)
    for name, pins in crosses.items():
        radii = _radii(radius, pins, chosen[name], length)
        of = [pins[item.pin].name for item in chosen[name]]
        clearances = np.array([clearance_of(clearance, pin, length) for pin in of])
        for item, value in zip(chosen[name], clearances.tolist(), strict=True):
            if not value < radii[item.pin]:
                raise ArgumentError(
                    f"clearance is {value:g} m, no less than the radius of {radii[item.pin]:g} m "
                    "at which it is"
                )
        laws = [stiffness_of(stiffness, pin) for pin in of]
        found[name] = OpenedJoint(solver, rotor, name, pins, chosen[name], clearances, laws, radii)
    # In the order in which they were asked for.
    return {name: found[name] for name in (wanted or found)}, left_out


def _pins(problem: Problem, name: str) -> tuple[PinAxis, PinAxis]:
    """Return the pins of a universal joint."""
    pins = universal_pins(problem.mechanism, name)
    for pin in pins:
        if pin.joint not in problem.outputs:
            raise ModelError(f"joint {pin.joint!r} is no output of the scene; name it there")
    return pins


def _bearings(
    crosses: Mapping[str, tuple[PinAxis, PinAxis]], asked: Any
) -> dict[str, tuple[Bearing, ...]]:
    """Return the open bearings of each universal joint, in the order of its pins."""
    ends = {
        name: {
            f"{pin.name}{sign}": Bearing(f"{pin.name}{sign}", index, value)
            for index, pin in enumerate(pins)
            for sign, value in _SIGNS.items()
        }
        for name, pins in crosses.items()
    }
    if asked is None:
        return {name: tuple(every.values()) for name, every in ends.items()}
    both = {
        pin.name: {f"{pin.name}{sign}" for sign in _SIGNS}
        for pins in crosses.values()
        for pin in pins
    }
    known = [end for every in ends.values() for end in every]
    wanted: set[str] = set()
    for name in checked_names("bearings", list(asked) if isinstance(asked, Set) else asked):
        if name not in known and name not in both:
            raise ModelError(f"no bearing {name!r}; {choices([*both, *known], name)}")
        wanted |= both.get(name, {name})
    found = {
        name: tuple(bearing for end, bearing in every.items() if end in wanted)
        for name, every in ends.items()
    }
    for name, every in found.items():
        if not every:
            raise ArgumentError(
                f"bearings names none of {name!r}; leave it out for all four of each joint"
            )
    return found


def _radii(
    given: Any, pins: tuple[PinAxis, ...], bearings: tuple[Bearing, ...], length: float
) -> Array:
    """Return the radii of the pins that have open bearings, NaN of others [m]."""
    if given is None:
        raise ArgumentError(
            f"radius is None; give the distance of the bearings of {pins[0].name!r} and "
            f"{pins[1].name!r} from the joint's centre"
        )
    found, low, high = np.full(len(pins), np.nan), length / _LONGEST, length * _LONGEST
    for index in {item.pin for item in bearings}:
        label, value = of_joint("radius", given, pins[index].name)
        radius = positive(label, value)
        if not low <= radius <= high:
            raise ArgumentError(
                f"{label} is {radius:g} m; in a mechanism of {length:.3g} m it lies from {low:.3g} "
                f"to {high:.3g} m"
            )
        found[index] = radius
    return found
