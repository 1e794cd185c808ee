"""Build a response: solve its functions at more and more positions until they reach rounding."""

from __future__ import annotations

from itertools import takewhile

import numpy as np

from ..arrays import Array
from ..checks import described, numbers
from ..dynamics.inverse_dynamics import Solution
from ..dynamics.problem_solver import ProblemSolver
from ..errors import AccuracyError, ArgumentError, CardanError
from ..frozen import frozen
from .data import Proof, ResponseData
from .sampling import FunctionSampler
from .series import Series

_FIRST = 128
"""Positions to begin with: enough for a Cardan joint at 50°, and little more work than 64."""
_MOST = 2**15
"""Positions to end with. A range that stops 1e-4 of itself short of its dead points takes 2049 for
1e-12, a Cardan joint at 89° 8192 for 1e-13."""
_CHECKS = 32
"""Positions anywhere between the samples at which functions are compared with direct solutions."""
_PLATEAU = 1e-8
"""Errors above are no rounding that more samples cannot lower, however slowly they fall."""
_GAIN = 0.5
"""What a doubling lowers errors to at least, unless they have reached rounding, which stays what it
is: coefficients that fall off geometrically have their ratio squared."""
_NOISE = 1e-12
"""Rounding of samples, and so of what they deviate by, per condition number. Measured: 2e-15 in a
Cardan joint, 2e-14 in a double shaft, 4e-14 in a line of three joints."""
_VANISHING = 2e-15
"""What is smaller than this part of its scale is nothing but rounding, and is left out."""
_EPS = float(np.finfo(float).eps)


def build(solver: ProblemSolver, tolerance: object, interval: object) -> ResponseData:
    """Return the functions of a response; see `Scene.response`."""
    problem = solver.problem
    wanted = _number("tolerance", tolerance)
    if len(problem.drives) != 1:
        raise ArgumentError(f"a response needs one drive, not {list(problem.drives)}")
    if not 1e-15 <= wanted < 1.0:
        raise ArgumentError(f"tolerance is {wanted:g}, expected 1e-15 … 1")
    for name, load in problem.link_loads.items():
        if max(len(load.force), len(load.moment)) > 1:
            raise ArgumentError(
                f"the wrench on {name!r} changes from sample to sample; a response needs one that "
                "stays the same"
            )
    domain = _domain(solver, interval)
    functions = FunctionSampler(solver)
    nodes, checks = Series.nodes(*domain, _FIRST), _checks(*domain)
    # One call costs less than two, and the positions in between prove the result.
    values, proven = functions.prove(np.concatenate([nodes, checks]))
    values, direct = values[:, : len(nodes)], values[:, len(nodes) :]
    # What is open at a few positions is so at all: no need to solve more of them.
    solver.refuse_indeterminate(functions.unique)
    series, error = _refined(functions, wanted, Series(values, *domain), checks, direct, proven)
    solver.refuse_indeterminate(functions.unique)
    values, scale = series.values, functions.scales(series.values)
    size, change = np.max(np.abs(values), axis=1) / scale, np.ptp(values, axis=1) / scale
    empty = functions.empty(values)
    zero = empty | (size <= _VANISHING)
    constant = (change <= _VANISHING) & ~zero
    dropped = max(
        float(np.max(size, where=zero & ~empty, initial=0.0)),
        float(np.max(change, where=constant, initial=0.0)),
    )
    proof = Proof(
        tolerance=wanted,
        error=max(error, dropped, _EPS * functions.condition),
        condition=functions.condition,
        cancellation=functions.cancellation(direct, proven),
        loop_residual=float(np.max(proven.loop_error)),
        balance_residual=proven.residuals.balance,
        power_residual=proven.residuals.power,
        rate_residual=proven.residuals.rate,
        unproven=tuple(solver.inverse_dynamics.bodies.unproven),
    )
    couplings = problem.mechanism.couplings
    coupling_unique = {
        coupling.name: number not in functions.indeterminate_couplings
        for number, coupling in enumerate(couplings)
        if coupling.name in functions.layout.couplings
    }
    return ResponseData(
        functions.layout,
        series,
        zero,
        constant,
        functions.unique,
        frozen(coupling_unique),
        proof,
    )


def _refined(
    functions: FunctionSampler,
    tolerance: float,
    series: Series,
    checks: Array,
    direct: Array,
    proven: Solution,
) -> tuple[Series, float]:
    """Double the samples of a series until both its rest and its deviations are small enough.

    Args:
        functions: what is sampled.
        tolerance: relative to the scale of each function.
        series: at the first number of samples.
        checks: positions between them.
        direct: `(C, checks)` the functions at these.
        proven: what else was found there.

    Returns:
        The series and its greatest error.

    Raises:
        AccuracyError: the tolerance is out of reach.
    """
    before = missed = np.inf
    while True:
        values = series.values
        count = values.shape[1] - (not series.periodic)
        scale, empty = functions.scales(values), functions.empty(values)
        hidden = functions.rounding(direct, proven)
        condition = functions.condition
        rounding = _NOISE * condition + hidden
        rest = np.where(empty, 0.0, series.remainder(rounding * scale) / scale)
        worst = float(np.max(rest, initial=0.0))
        # Coefficients do not fall below the rounding of what they are made of.
        stalled = _GAIN * before < worst < _PLATEAU
        rounded = stalled and bool(np.all(rest <= rounding))
        deviation = 0.0
        if worst <= tolerance or rounded:
            found = np.abs(series.summed(checks) - direct) / scale[:, None]
            deviations = np.where(empty, 0.0, np.max(found, axis=1))
            deviation = float(np.max(deviations, initial=0.0))
            if np.all(deviations <= np.maximum(tolerance, rounding)):
                return series, max(worst, deviation)
            # What deviates for another reason than few samples goes on to do so.
            stalled = stalled or deviation > _GAIN * missed
            missed = deviation
        if stalled or count >= _MOST:
            raise _out_of_reach(tolerance, count, condition, max(worst, deviation))
        before = worst
        # Every other position is one of the last round's.
        finer = np.empty((len(values), 2 * values.shape[1] - (not series.periodic)))
        domain = series.origin, series.length, series.periodic
        finer[:, ::2] = values
        finer[:, 1::2] = functions.solve(Series.nodes(*domain, 2 * count)[1::2])
        series = Series(finer, *domain)


def _out_of_reach(tolerance: float, count: int, condition: float, reached: float) -> AccuracyError:
    return AccuracyError(
        f"the response reaches {reached:.1e} with {count} samples, not {tolerance:.0e}: the "
        f"closure equations have condition {condition:.1e}; ask for a greater tolerance, or for a "
        "range farther from dead points",
        residual=reached,
        tolerance=tolerance,
        position=None,
    )


def _domain(solver: ProblemSolver, interval: object) -> tuple[float, float, bool]:
    """Return origin, length and periodicity of a series, see `Series`."""
    problem = solver.problem
    if interval is not None:
        first, last = _pair(interval)
        origin, length = 0.5 * first + 0.5 * last, 0.5 * last - 0.5 * first
        if not length > 1e3 * _EPS * abs(origin):
            raise ArgumentError(f"the interval from {first:.9g} to {last:.9g} is empty")
        return origin, length, False
    period = solver.assembly.period()
    if period is None:
        raise CardanError(
            f"{problem.mechanism.name}: drive {problem.drives[0]!r} does not come back to where it "
            "was within a few turns; give the interval: response(interval=(low, high))"
        )
    # A period begins where the scene starts.
    drive = problem.mechanism.coordinates.columns[problem.drives[0]].start
    return float(solver.assembly.start[drive]), period, True


def _pair(interval: object) -> tuple[float, float]:
    if not isinstance(interval, (tuple, list, np.ndarray)) or len(interval) != 2:
        raise ArgumentError(f"interval is {described(interval)}, expected (low, high)")
    return _number("interval[0]", interval[0]), _number("interval[1]", interval[1])


def _number(name: str, value: object) -> float:
    array = numbers(name, value)
    if array.ndim:
        raise ArgumentError(f"{name} has shape {array.shape}, expected a number")
    return float(array)


def _checks(origin: float, length: float, periodic: bool) -> Array:
    """Return positions between the samples, spread by the golden section.

    On a range they lie closer towards its ends, as its samples do. There what a series leaves out
    adds up, so that further ones lie in the middle between the last two samples of every round.
    """
    share = (np.arange(1.0, _CHECKS + 1.0) * (0.5 * np.sqrt(5.0) - 0.5)) % 1.0
    if periodic:
        return origin + share * length
    rounds = takewhile(lambda count: count <= _MOST, (_FIRST * 2**k for k in range(64)))
    ends = 0.5 / np.array(list(rounds))
    # As in `Series.nodes`.
    share = np.concatenate([share, ends, 1.0 - ends])
    return origin + length * np.sin(0.5 * np.pi * (1.0 - 2.0 * share))
