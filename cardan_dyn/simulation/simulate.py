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
    # Steps of a given length are those of the general method.
    first = ("quadrature", "response") if setup.step is None else ()
    for candidate in first if method is None else (method,):
        try:
            _refuse_unsuitable(setup, candidate)
            return _METHODS[candidate](setup)
        except NotSuitableError as error:
            if method is not None:
                raise ArgumentError(f"method {method!r} does not suit the scene: {error}") from None
    return in_all_coordinates(setup)


def _refuse_unsuitable(setup: Setup, method: str) -> None:
    """Refuse a method that would leave out what is asked for.

    Raises:
        NotSuitableError: it would.
    """
    if method in ("quadrature", "response") and not setup.is_one_coordinate:
        raise NotSuitableError("it takes one drive that moves freely")
    if method in ("quadrature", "response") and setup.has_idle_rods:
        raise NotSuitableError("rods that spin about their lines are further free coordinates")
    if method == "quadrature" and not setup.forces.is_constant:
        raise NotSuitableError("it takes constant loads and springs without damping alone")
    if method in ("quadrature", "Radau") and setup.step is not None:
        raise NotSuitableError("it takes no steps of a given length")
