"""Solutions of linear equations change as these say: beside derivatives through the elimination."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from cardan_dyn.core.dynamics.implicit import Implicit
from cardan_dyn.core.mechanics.elimination import Eliminated, chosen, eliminated
from cardan_dyn.core.tape import Differential, Program, Scalar, Trace, derivatives

ROWS, COLUMNS, AT = 5, 3, 0.3


def matrix(rng: np.random.Generator, p: Scalar) -> list[dict[int, Scalar]]:
    """Return rows that change with p, of which two follow from the others."""
    own = [[a + p * b for a, b in rng.normal(size=(COLUMNS, 2)).tolist()] for _ in range(COLUMNS)]
    others = [
        [
            sum((p * factor * own[r][k] for r, factor in enumerate(of)), own[0][k])
            for k in range(COLUMNS)
        ]
        for of in rng.normal(size=(ROWS - COLUMNS, COLUMNS)).tolist()
    ]
    return [dict(enumerate(row)) for row in [*own, *others]]


def made_of(factors: Eliminated, rows: list[dict[int, Scalar]], p: Scalar) -> list[Scalar]:
    """Return numbers that are made of what is solved with factors, one after the other."""
    x = factors.solve([p * (k + 1.0) for k in range(ROWS)])
    again = factors.solve([x[0] * -x[1] + p * k for k in range(ROWS)])
    dependent = factors.dependence(factors.redundant[0])

    def found(y: Mapping[int, Scalar]) -> dict[int, Scalar]:
        return {row: p * p * y.get(row, 0.0) for row in range(ROWS)}

    def lacking(of: Mapping[int, Scalar]) -> dict[int, Scalar]:
        left = {k: again[k] + x[0] for k in range(COLUMNS)}
        for row, entries in enumerate(rows):
            for k, entry in entries.items():
                left[k] = left[k] - entry * of[row] / (p * p)
        return left

    balanced = factors.balanced(found, lacking)
    worth = sum((value * value for value in balanced.values()), x[2])
    return [*x.values(), *again.values(), *dependent.values(), worth]


@pytest.mark.parametrize("seed", range(4))
def test_solutions_change_as_their_equations_say(seed: int) -> None:
    values = matrix(np.random.default_rng(seed), AT)
    order = chosen([{k: np.array([x]) for k, x in row.items()} for row in values])
    trace = Trace()
    p = trace.input("p", AT)
    off = [trace.input(f"e{row}", 0.0) for row in range(ROWS)]
    marks = [trace.input(name, 1.0) for name in ("found", "held")]
    rows = matrix(np.random.default_rng(seed), p)
    plain = eliminated(rows, order)
    implicit = Implicit.of(plain, rows, off, marks)
    outputs = [made_of(factors, rows, p) for factors in (plain, implicit)]
    differential = Differential(trace)
    changes = {p: differential.free()}
    implicit.differentiated(differential, changes)
    ways = differential.tangents(outputs[1], changes)
    program, places = differential.forwards([{changes[p]: 1.0}], ways)
    given = {"p": AT, "found": 1.0, "held": 1.0, **{f"e{row}": 0.0 for row in range(ROWS)}}
    slopes = np.append(program.run_on_arrays(given, 1)[:, 0], 0.0)[places[0]]
    through = Program(trace, [row[0] for row in derivatives(outputs[0], [p])])
    expected = through.run_on_arrays(given, 1)[:, 0]
    np.testing.assert_allclose(slopes, expected, rtol=1e-11, atol=1e-11)
    assert np.count_nonzero(expected) >= len(expected) - 1  # Of what is one in its own row.
