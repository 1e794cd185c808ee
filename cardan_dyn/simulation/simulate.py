"""Simulate: choose a method for a scene, run it, and return its trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..checks import described
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, ModelError, choices
from .energy_functions import NotSuitableError
from .methods import by_quadrature, by_response, in_all_coordinates
from .setup import Asked, Setup, forces_of, setup_of, with_all_loops, with_recorded_contacts
from .suitable import in_words, reason_against, traits
from .trajectory import Trajectory

_METHODS: Mapping[str, Callable[[Setup], Trajectory]] = {
    "quadrature": by_quadrature,
    "response": by_response,
    "DOP853": lambda setup: in_all_coordinates(setup, "DOP853"),
    "Radau": lambda setup: in_all_coordinates(setup, "Radau"),
}


def simulated(solver: ProblemSolver, asked: Asked) -> Trajectory:
    """Return a simulation; see `Scene.simulate`."""
    method = asked.method
    if method is not None and (not isinstance(method, str) or method not in _METHODS):
        raise ArgumentError(
            f"method {described(method)} is unknown; methods: {choices(_METHODS, method)}"
        )
    if not _has_mass(solver):
        raise ModelError(
            f"{solver.problem.mechanism.name}: no body has mass, so that no motion follows from "
            "what acts; give links an <inertial>, or prescribe the motion: Scene.sweep"
        )
    setup = setup_of(with_recorded_contacts(with_all_loops(solver)), asked)
    # Steps of a given length are those of the general method.
    first = ("quadrature", "response") if setup.step is None else ()
    for candidate in first if method is None else (method,):
        try:
            if reason := reason_against(candidate, setup.traits):
                raise NotSuitableError(reason)
            return _METHODS[candidate](setup)
        except NotSuitableError as error:
            if method is not None:
                raise ArgumentError(f"method {method!r} does not suit the scene: {error}") from None
            if error.note:
                setup = setup._replace(notes=(*setup.notes, error.note))
    return in_all_coordinates(setup)


def _has_mass(solver: ProblemSolver) -> bool:
    """Return whether any moving body has mass, whatever the outputs of the scene need."""
    mechanism = solver.problem.mechanism
    return any(
        inertia.mass > 0.0 and body not in mechanism.auxiliary_bodies
        for body, inertia in enumerate(mechanism.model.inertias)
        if body
    )


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
    found = traits(solver, forces, prescribed=bool(solver.problem.drives))
    return in_words(found, solver.problem.independent[0])
