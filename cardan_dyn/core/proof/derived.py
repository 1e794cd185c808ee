"""Derived: whether balances hold for derivatives of a result, too.

The text of the proof is differentiated along the derivatives that are claimed. A number of the
description or of an element besides changes it itself, of which nodes and weights are known.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np

from ...kit.arrays import Array
from ...kit.differences import slope
from ..tape import Program, Scalar, Trace, tangents
from .element_loads import ElementLoads
from .free_bodies import FreeBodies
from .residuals import Claim
from .samples import Rows, Sample

Placed = Callable[[float], FreeBodies]
"""Returns the bodies of a description in which a length or an angle is greater by some amount."""


def derived_errors(
    bodies: FreeBodies,
    claim: Claim,
    rates: Claim,
    others: Sequence[tuple[FreeBodies, float]],
    along: tuple[Array, Array] | None = None,
    placed: Placed | None = None,
) -> tuple[float, float]:
    """Return the greatest rates at which what should be zero grows: of positions, of wrenches.

    Args:
        bodies: of the description.
        claim: a result.
        rates: how it is claimed to change, in arrays of the same shapes.
        others: bodies of other numbers, and weights, with which what they are off by at the same
            result adds up to the derivative by a number.
        along: `(N,)` where elements act, how fast samples go, and how great what moves is, in units
            of all there is.
        placed: if the number is a length or an angle, on which it depends what elements exert,
            which is of no such degree: bodies where it is greater.
    """
    exerted = bodies.exerted(claim)
    change = None
    if exerted is not None and along is not None:
        change = _changed(bodies, claim, rates, exerted, along, placed)
    rows, changes = Rows(claim, exerted), Rows(rates, change)
    acting = rows.acting() | changes.acting()
    (moved,) = acting.nonzero()
    with Trace() as trace:
        variables = rows.variables(trace)
        own = [x if acts else 0.0 for x, acts in zip(variables, acting, strict=True)]
        errors = _errors(bodies, rows.sample(own, bodies.frames))
        ways = {variables[k]: trace.input(f"by {k}", 0.0) for k in moved}
        sizes = [len(each) for each in errors]
        program = Program(trace, tangents([*chain(*errors)], ways), keeps_inputs=True)
    shape = rows.count
    every = np.concatenate([np.broadcast_to(part, (len(part), shape)) for part in changes.parts])
    result = program.run_rows([*rows.parts, every[moved]], shape)
    for other, weight in others:
        of = Rows(claim, exerted if placed else other.exerted(claim))
        found = chain(*_errors(other, of.sample(of.scalars, other.frames)))
        for row, value in zip(result, found, strict=True):
            row += weight * value
    openings, imbalances = np.split(np.abs(result), sizes[:1])
    return float(openings.max(initial=0.0)), float(imbalances.max(initial=0.0))


def _errors(bodies: FreeBodies, sample: Sample) -> tuple[list[Scalar], list[Scalar]]:
    return bodies.openings(sample), bodies.imbalances(sample)


def _changed(
    bodies: FreeBodies,
    claim: Claim,
    rates: Claim,
    exerted: ElementLoads,
    along: tuple[Array, Array],
    placed: Placed | None,
) -> ElementLoads:
    """Return how what elements exert changes, see `derived_errors`."""
    far, size = along

    def exerted_at(place: float) -> Array:
        by, of = (place / far)[:, None], placed(place / float(far[0])) if placed else bodies
        found = of.exerted(claim._replace(x=claim.x + by * rates.x, v=claim.v + by * rates.v))
        assert found is not None
        every = [wrench.reshape(6, -1) for _, wrench in found.wrenches]
        return np.concatenate([found.efforts, *every])

    change = slope(lambda places: np.stack([*map(exerted_at, places.tolist())]), size) * far
    count = len(exerted.efforts)
    wrenches = change[count:].reshape(len(exerted.wrenches), 2, 3, len(far))
    own = zip([body for body, _ in exerted.wrenches], wrenches, strict=True)
    return ElementLoads(change[:count], list(own), exerted.terms)
