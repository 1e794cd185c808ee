"""Simulate: choose a method for a scene, run it, and return its trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio

from ...core.dynamics.problem_solver import ProblemSolver
from ...core.elements.pin_contact import PinContact
from ...core.kinematics.loops.idle_rods import rods_of
from ...kit.arrays import EPS, NOTHING
from ...kit.checks import described
from ...kit.errors import ArgumentError, ModelError, choices
from .energy_functions import NotSuitableError
from .forces import Forces
from .methods import by_quadrature, by_response, in_all_coordinates
from .setup import Setup, forces_of, setup_of
from .trajectory import Trajectory

_METHODS: Mapping[str, Callable[[Setup], Trajectory]] = {
    "quadrature": by_quadrature,
    "response": by_response,
    "DOP853": in_all_coordinates,
    "Radau": in_all_coordinates,
}


def simulated(solver: ProblemSolver, *, method: Any = None, **asked: Any) -> Trajectory:
    """Return a simulation; see `Scene.simulate`, whose arguments these are."""
    if method is not None and (not isinstance(method, str) or method not in _METHODS):
        raise ArgumentError(
            f"method {described(method)} is unknown; methods: {choices(_METHODS, method)}"
        )
    if not _has_mass(solver):
        raise ModelError(
            f"{solver.problem.mechanism.name}: no body has mass, so that no motion follows from "
            "what acts; give links an <inertial>, or prescribe the motion: Scene.sweep"
        )
    _refuse_weightless_spins(solver)
    setup = setup_of(solver, method=method, **asked)
    against = _reasons_against(
        setup.solver,
        setup.forces,
        prescribed=bool(setup.motions),
        given_steps=setup.step is not None,
    )
    # Steps of a given length are those of the general method.
    first = ("quadrature", "response") if setup.step is None else ()
    for candidate in first if method is None else (method,):
        try:
            if against[candidate]:
                raise NotSuitableError(against[candidate])
            return _METHODS[candidate](setup)
        except NotSuitableError as error:
            if method is not None:
                raise ArgumentError(f"method {method!r} does not suit the scene: {error}") from None
            if error.note:
                setup = replace(setup, notes=(*setup.notes, error.note))
    return in_all_coordinates(setup)


def _has_mass(solver: ProblemSolver) -> bool:
    """Return whether anything that moves has inertia, whatever the outputs of the scene need."""
    mechanism = solver.problem.mechanism
    return any(mechanism.model.armature) or any(
        inertia.toDynamicParameters().any() and body not in mechanism.auxiliary_bodies
        for body, inertia in enumerate(mechanism.model.inertias)
        if body
    )


def _refuse_weightless_spins(solver: ProblemSolver) -> None:
    """Refuse rods that may spin about their lines and have no inertia about them.

    Raises:
        ModelError: there is one.
    """
    problem = solver.problem
    if not (rods := rods_of(problem)):
        return
    mechanism, start = problem.mechanism, solver.assembly.start[None, :]
    model, layout = mechanism.model, mechanism.coordinates
    masses = pinocchio.crba(model, model.createData(), layout.configuration(start)[0])
    masses = np.triu(masses) + np.triu(masses, 1).T
    least = EPS * pinocchio.computeTotalMass(model) * mechanism.characteristic_length**2
    for group in solver.assembly.kinematics.evaluate(start).groups:
        rates = np.zeros(model.nv)
        for spin in group.inverse[0, group.error.shape[1] :]:
            rates[group.group.passives] = spin
            if rates @ masses @ rates <= least:
                moving = {*np.flatnonzero(np.abs(rates) > NOTHING).tolist()}
                joints = {mechanism.drivable[name].joint for name in layout.names_of(moving)}
                rod = max(rods, key=lambda names: len(joints.intersection(names)))
                raise ModelError(
                    f"{mechanism.name}: the rod between {choices(rod)} may spin about its line and "
                    "has no inertia about it, so that nothing says how it spins: give its link an "
                    "<inertial>, or a universal joint in place of one of its balls",
                    name=rod[0],
                )


def _reasons_against(
    solver: ProblemSolver, forces: Forces, *, prescribed: bool, given_steps: bool = False
) -> dict[str, str]:
    """Return methods to what they would leave out of what is asked for; empty if nothing."""
    problem = solver.problem
    if any(isinstance(element, PinContact) for element in problem.elements):
        struck = "pins with clearance strike: every touch is located by the steps of DOP853"
        return {"quadrature": struck, "response": struck, "DOP853": "", "Radau": struck}
    several = integral = ""
    if prescribed or len(problem.independent) != 1:
        several = "it takes one free coordinate and no drive"
    elif rods_of(problem):
        several = "rods that spin about their lines are further free coordinates"
    if not forces.is_constant:
        integral = "it takes constant loads and springs without damping alone"
    steps = "it takes no steps of a given length" if given_steps else ""
    return {
        "quadrature": several or integral or steps,
        "response": several,
        "DOP853": "",
        "Radau": steps,
    }


def planned(solver: ProblemSolver) -> str:
    """Return by which methods a scene is simulated if nothing else is asked for, in words."""
    if not _has_mass(solver):
        return "nothing, no body has mass"
    if not solver.problem.free:
        return "nothing, no coordinate is free"
    try:
        forces = forces_of(solver)
    except ArgumentError as error:
        return f"nothing without other loads: {error}"
    against = _reasons_against(solver, forces, prescribed=bool(solver.problem.drives))
    if against["Radau"]:
        return f"DOP853 in all coordinates ({against['Radau']})"
    general = "DOP853 in all coordinates, Radau from where it is stiff"
    if against["response"]:
        return f"{general} (no quadrature or response: {against['response']})"
    first = "quadrature, else response"
    if against["quadrature"]:
        first = f"response (no quadrature: {against['quadrature']})"
    return f"{first}; where {solver.problem.independent[0]} does not turn through, {general}"
