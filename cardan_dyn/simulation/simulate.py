"""Simulate: choose a method for a scene, run it, and return its trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..checks import described
from ..dynamics.problem_solver import ProblemSolver
from ..errors import ArgumentError, choices
from .energy_functions import NotSuitableError
from .methods import by_quadrature, by_response, in_all_coordinates
from .setup import Asked, Setup, setup_of, with_all_loops
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
    setup = setup_of(with_all_loops(solver), asked)
    if method is not None:
        try:
            return _METHODS[method](setup)
        except NotSuitableError as error:
            raise ArgumentError(f"method {method!r} does not suit the scene: {error}") from None
    for candidate in _candidates(setup):
        try:
            return candidate(setup)
        except NotSuitableError:
            continue
    return in_all_coordinates(setup)


def _candidates(setup: Setup) -> list[Callable[[Setup], Trajectory]]:
    """Return the methods that may suit one free coordinate, the fastest first."""
    if not setup.is_one_coordinate or setup.step is not None:
        return []
    return [by_quadrature, by_response] if setup.forces.is_constant else [by_response]
