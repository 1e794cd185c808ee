"""Data of a response: its functions, and how accurate they are."""

from __future__ import annotations

from dataclasses import dataclass

from ...kit.arrays import Array
from ...kit.frozen import FrozenDict, Record
from ..proof.residuals import Proven
from .columns import Layout
from .series import Series


@dataclass(frozen=True)
class Proof(Proven):
    """How accurate a response is.

    Attributes:
        tolerance: the error that was allowed.
        error: greatest error of the functions, relative to the greatest wrench of the joint (or a
            tenth of the greatest of all joints): the greater of what the series leave out, added
            up from how their coefficients fall off, and of the deviation from directly solved
            positions between the samples; at least the rounding of solved positions, eps times
            `condition`.
        condition: greatest condition number of the solved positions, see `Sweep`.
        cancellation: by how much inertial terms exceed the greatest wrench of the column `speed²`.

    Its residuals are the worst of the first samples and of the positions between them.
    """

    tolerance: float
    error: float
    condition: float
    cancellation: float


@dataclass(frozen=True, eq=False, repr=False)
class ResponseData(Record):
    """The functions of a response of one design. Nothing in it can be changed.

    Attributes:
        layout: what wrenches are proportional to, and the order of the functions in `series`.
        series: the functions.
        zero: `(C,)` which of them vanish.
        constant: `(C,)` which of the others do not change.
        unique: `(k, 6)` see `JointWrench.unique`.
        coupling_unique: see `Sweep.coupling_unique`.
        proof: how accurate they are.
    """

    layout: Layout
    series: Series
    zero: Array
    constant: Array
    unique: Array
    coupling_unique: FrozenDict[str, bool]
    proof: Proof
