"""Assembling: closed configurations of a mechanism, and files in which one of them is zero."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..core.description.write import write as write_description
from ..core.dynamics.problem_solver import ProblemSolver
from ..core.kinematics.assembly_modes import without_turns
from ..core.kinematics.closing.far import assembled_near
from ..core.kinematics.closing.group_solver import GroupSolver
from ..core.kinematics.closing.nearest import nearest_to
from ..core.kinematics.loops.groups import independent_groups
from ..core.kinematics.loops.structure import Structure
from ..core.kinematics.tolerances import CLOSURE_TOLERANCE
from ..core.mechanism.configuration import Configuration
from ..core.mechanism.mechanism import Mechanism
from ..core.mechanism.rezero import is_closed, rezeroed
from ..core.problem.arguments import keyframe, near_positions, with_named
from ..kit.arrays import Array
from ..kit.checks import mapping
from ..kit.errors import ArgumentError, AssemblyError, MobilityError

_STEP = 0.1
"""Greatest part of a turn [rad], or of the characteristic length, by which the joints of `near`
move at once: so that the rest can follow without a jump to another assembly mode."""


def assemble(
    mechanism: Mechanism, near: Mapping[str, ArrayLike] | str | None = None
) -> Configuration:
    """Return a configuration in which all loops of a mechanism are closed.

    It is the one nearest to the description's zero that a damped method finds while all joints may
    move. `Scene.configuration` returns the one in which a scene starts, in any assembly mode.

    Args:
        mechanism: from `load`.
        near: positions of joints [rad or m], up to all of them, a configuration, or the name of a
            keyframe of MJCF or of a reference configuration of a `pin.Model`. The other joints
            follow on their way there, so that the assembly mode stays the same unless the way leads
            through a singular configuration. Positions at which all loops are closed are taken as
            they are; those of more joints than decide where the mechanism is mean the assembly
            nearest to them, see `Scene`.

    Raises:
        ModelError: no such joint.
        ArgumentError: no mechanism, no such keyframe, or a position is no number.
        AssemblyError: the loops cannot be closed; `residual` is the least error found.
    """
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(
            f"assemble needs a mechanism from load(), not {type(mechanism).__name__}"
        )
    near = mapping("near", keyframe(mechanism, near))
    mechanism = with_named(mechanism, near)
    structure = Structure(mechanism)
    zero = mechanism.zero
    zero_residual = closure_error(structure, zero)
    wanted, balls = near_positions(mechanism, near)
    given = zero.copy()
    for name, value in wanted.items():
        given[mechanism.coordinates.named[name].column] = value
    for name, quaternion in balls.items():
        columns = mechanism.coordinates.columns[name]
        given[columns.stop - 4 : columns.stop] = quaternion
    given = mechanism.fitted(given, mechanism.coordinates.rates_of((*wanted, *balls)))
    if (wanted or balls) and closure_error(structure, given) < CLOSURE_TOLERANCE:
        return Configuration(mechanism, given, closure_error(structure, given), zero_residual)
    if balls:
        x = without_turns(mechanism, wanted, _closed(structure, given, wanted))
        return Configuration(mechanism, x, closure_error(structure, x), zero_residual)
    x = _closed(structure, zero, {})
    try:
        for share in _shares(mechanism, x, wanted):
            x = _closed(structure, x, wanted, share)
    except AssemblyError:
        try:
            # A singular configuration may lie on the way, and the start beyond it.
            x = _closed(structure, given, wanted)
        except AssemblyError as error:
            every = np.arange(mechanism.model.nv)
            x = nearest_to(structure, given, wanted, every, every, error)
    x = without_turns(mechanism, wanted, x)
    return Configuration(mechanism, x, closure_error(structure, x), zero_residual)


def write(
    mechanism: Mechanism,
    path: str | os.PathLike[str],
    *,
    at: Mapping[str, object] | str | None = None,
) -> Path:
    """Write the description of a mechanism to a file, which `load` reads back; without visuals.

    A file that exists is replaced. A warning names what the notation has no word for.

    Args:
        mechanism: from `load`.
        path: file whose suffix says in which notation: `.urdf` for URDF+, as `Mechanism.to_urdf`
            returns it; `.xml` or `.mjcf` for MJCF, see `formats.mjcf.writer` for what it
            becomes there. `load` reads MJCF back whose bodies are nested up to 300 deep.
        at: closed configuration that becomes the zero of the written coordinates, or its
            `positions`: name of every moving joint, loops included, to its position. Limits are
            counted from there as well. A keyframe by name is closed by `assemble`. Without it the
            zero stays if its loops are closed, otherwise `assemble` finds a configuration near it.

    Returns:
        The path.

    Raises:
        ArgumentError: unknown suffix, no such directory, or `at` is incomplete, malformed or not
            closed.
        ModelError: the notation cannot say something of the description.
        AssemblyError: the loops are open at zero and cannot be closed near it; `to_urdf` returns
            the description as it is.
    """
    if not isinstance(mechanism, Mechanism):
        raise ArgumentError(f"write needs a mechanism from load(), not {type(mechanism).__name__}")
    description, length = mechanism.description, mechanism.characteristic_length
    if isinstance(at, str) or (at is None and not is_closed(description, length)):
        at = assemble(mechanism, at)
    return write_description(description if at is None else rezeroed(description, at, length), path)


def configuration_of(solver: ProblemSolver) -> Configuration:
    """Return the configuration in which a scene starts, of its solver.

    Raises:
        AssemblyError: loops that the scene leaves out cannot be closed.
    """
    problem, assembly = solver.problem, solver.assembly
    mechanism, x = problem.mechanism, assembly.start
    structure = Structure(mechanism)
    zero_residual = closure_error(structure, mechanism.zero)
    left_out = np.setdiff1d(problem.passive_columns, assembly.decided)
    if left_out.size:
        try:
            x = assembly.with_all_loops(problem.branch).start
        except MobilityError:  # What nothing decides may be closed anywhere near.
            x, _ = assembled_near(structure, x, left_out, left_out)
    x = without_turns(mechanism, (*problem.independent, *problem.held, *problem.near), x)
    residual = closure_error(structure, x)
    if not residual < CLOSURE_TOLERANCE:
        from ..core.kinematics.diagnosis.reach import (
            unclosed,  # Imported here: only errors need it.
        )

        raise unclosed(mechanism, residual)
    return Configuration(mechanism, x, residual, zero_residual, problem.branch)


def closure_error(structure: Structure, x: Array) -> float:
    """Return the closure error of all loops and couplings at coordinates `(size,)`."""
    mechanism, worst = structure.mechanism, 0.0
    for group in independent_groups(structure, np.arange(mechanism.model.nv)):
        _, _, residual = GroupSolver(mechanism, group).linearised(x[None, :])
        worst = max(worst, float(residual[0]))
    return worst


def _shares(mechanism: Mechanism, x: Array, wanted: Mapping[str, float]) -> list[float]:
    """Return which part of what is left of the way to wanted positions each step takes."""
    coordinates = mechanism.coordinates
    columns = coordinates.columns_of(wanted)
    ways = np.abs(np.array(list(wanted.values())) - x[columns]) * coordinates.scale[columns]
    count = max(int(np.ceil(np.max(ways, initial=0.0) / _STEP)), bool(wanted))
    return [1.0 / left for left in range(count, 0, -1)]


def _closed(
    structure: Structure, x: Array, wanted: Mapping[str, float], share: float = 1.0
) -> Array:
    """Return closed coordinates `(size,)` near others, where some joints went a share of their way.

    They move towards the positions that are wanted of them, and are kept there.
    """
    mechanism = structure.mechanism
    coordinates = mechanism.coordinates
    every = np.arange(mechanism.model.nv)
    moved = x.copy()
    pinned = []
    for name, value in wanted.items():
        column = coordinates.named[name].column
        # The last step ends at the very number that was given.
        moved[column] = value if share == 1.0 else x[column] + share * (value - x[column])
        pinned.append(coordinates.named[name].rate)
    closed, residual = assembled_near(structure, moved, np.setdiff1d(every, pinned), every)
    if not residual < CLOSURE_TOLERANCE:
        from ..core.kinematics.diagnosis.reach import (
            unclosed,  # Imported here: only errors need it.
        )

        raise unclosed(mechanism, residual, wanted)
    return closed
