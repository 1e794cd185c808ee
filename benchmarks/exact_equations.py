"""Linear equations of the exact evaluation, solved with its 50 and more digits."""

from __future__ import annotations

from mpmath import mp, mpf

from .vectors import Matrix, Vector, dot

_RANK = mpf("1e-60")
"""Relative size below which a number counts as zero. With 130 digits, of which second differences
cost 60, what is zero is some 1e-70, and what is not is far above."""


def least_squares(columns: list[Vector], right: Vector) -> Vector:
    """Return the least-squares solution for columns of full rank, by orthogonalising twice."""
    basis: list[Vector] = []
    upper: list[Vector] = []
    for column in columns:
        rest, coefficients = list(column), [mpf(0)] * len(columns)
        for _ in range(2):
            for index, unit in enumerate(basis):
                coefficient = dot(unit, rest)
                coefficients[index] += coefficient
                rest = [a - coefficient * b for a, b in zip(rest, unit, strict=True)]
        norm = mp.sqrt(dot(rest, rest))
        if norm < _RANK:
            raise ArithmeticError("the exact closure equations do not decide the motion")
        coefficients[len(basis)] = norm
        basis.append([a / norm for a in rest])
        upper.append(coefficients)
    result = [dot(unit, right) for unit in basis]
    for index in reversed(range(len(columns))):
        for later in range(index + 1, len(columns)):
            result[index] -= upper[later][index] * result[later]
        result[index] /= upper[index][index]
    return result


def unique_solution(rows: Matrix) -> list[mpf | None]:
    """Solve rows `[a … | b]`; components that the rows do not decide are None."""
    width = len(rows[0]) - 1
    rows = [[value / max(map(abs, row[:-1])) for value in row] for row in rows]
    # Sizes of columns, so that a pivot's size means something in any units.
    scale = [max(abs(row[k]) for row in rows) or mpf(1) for k in range(width)]
    pivots: dict[int, int] = {}
    used: set[int] = set()
    while len(used) < len(rows):
        best, pivot = mpf(0), (-1, -1)
        for r, row in enumerate(rows):
            if r in used:
                continue
            for k in range(width):
                if row[k] and k not in pivots and abs(row[k]) / scale[k] > best:
                    best, pivot = abs(row[k]) / scale[k], (r, k)
        if best < _RANK:
            break
        r, k = pivot
        pivots[k] = r
        used.add(r)
        entries = [(c, value / rows[r][k]) for c, value in enumerate(rows[r]) if value]
        for index, row in enumerate(rows):
            factor = row[k]
            if index == r or not factor:
                continue
            for c, value in entries:
                row[c] -= factor * value
            row[k] = mpf(0)
    result: list[mpf | None] = [None] * width
    for k, r in pivots.items():
        row = rows[r]
        free = [abs(row[c] / row[k]) for c in range(width) if c != k and c not in pivots]
        if not free or max(free) < _RANK:
            result[k] = row[width] / row[k]
    return result
