"""Suitable: which methods of simulation may be tried for a scene, and what rules the others out."""

from __future__ import annotations

from typing import NamedTuple

from ..dynamics.problem_solver import ProblemSolver
from ..elements.pin_contact import PinContact
from ..kinematics.loops.idle_rods import rods_by_name
from .forces import Forces


class Traits(NamedTuple):
    """What decides which methods may be tried.

    Attributes:
        is_one_coordinate: whether one drive moves freely and the motion of no other is prescribed.
        has_idle_rods: whether rods may spin about their lines, which no drive decides.
        is_constant: whether no load or element depends on time or speed.
        has_given_steps: whether steps have a given length.
        has_contacts: whether pins with play strike their bushes.
    """

    is_one_coordinate: bool
    has_idle_rods: bool
    is_constant: bool
    has_given_steps: bool
    has_contacts: bool = False


def traits(
    solver: ProblemSolver, forces: Forces, *, prescribed: bool = False, given_steps: bool = False
) -> Traits:
    """Return what decides which methods may be tried.

    Args:
        solver: of the scene.
        forces: what acts.
        prescribed: whether the motion of a drive is prescribed.
        given_steps: whether steps have a given length.
    """
    problem = solver.problem
    rods = rods_by_name(problem.mechanism, set(problem.passive_columns.tolist()))
    is_one = len(problem.independent) == 1 and not prescribed
    contacts = any(isinstance(element, PinContact) for element in problem.elements)
    return Traits(is_one, bool(rods), forces.is_constant, given_steps, contacts)


def reason_against(method: str, found: Traits) -> str:
    """Return what a method would leave out of what is asked for; empty if nothing."""
    if method != "DOP853" and found.has_contacts:
        return "pins with play strike: every touch is located by the steps of DOP853"
    if method in ("quadrature", "response") and not found.is_one_coordinate:
        return "it takes one free coordinate and no drive"
    if method in ("quadrature", "response") and found.has_idle_rods:
        return "rods that spin about their lines are further free coordinates"
    if method == "quadrature" and not found.is_constant:
        return "it takes constant loads and springs without damping alone"
    if method in ("quadrature", "Radau") and found.has_given_steps:
        return "it takes no steps of a given length"
    return ""


def in_words(found: Traits, drive: str) -> str:
    """Return which methods are tried in turn, and why others are not.

    Args:
        found: what decides.
        drive: name of the first coordinate.
    """
    if found.has_contacts:
        return f"DOP853 in all coordinates ({reason_against('response', found)})"
    general = "DOP853 in all coordinates, Radau from where it is stiff"
    against = {method: reason_against(method, found) for method in ("quadrature", "response")}
    if against["response"]:
        return f"{general} (no quadrature or response: {against['response']})"
    first = "quadrature, else response"
    if against["quadrature"]:
        first = f"response (no quadrature: {against['quadrature']})"
    return f"{first}; where {drive} does not turn through, {general}"
