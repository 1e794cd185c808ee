"""Compared: reversals as they were estimated, beside the simulation of the whole mechanism."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from .joint_scan import Reversal

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, eq=False)
class Compared:
    """A reversal as it was estimated, and as it was simulated.

    Attributes:
        joint: its name.
        reversal: the estimate.
        rigid: greatest force without play until the next reversal [N].
        estimate: the greater of this and the estimated peak [N].
        simulated: greatest forces of the simulation until the next reversal, of every whole turn
            after the first reversal `(K,)` [N].
    """

    joint: str
    reversal: Reversal
    rigid: float
    estimate: float
    simulated: Array

    @property
    def error(self) -> float:
        """Estimate over the mean of the simulated peaks, less 1."""
        return float(self.estimate / np.mean(self.simulated) - 1.0)

    @property
    def excess(self) -> float:
        """What is simulated beyond the rigid maximum, as a fraction of the estimate of it.

        NaN where nothing beyond it is estimated.
        """
        estimated = self.estimate - self.rigid
        if estimated <= 0.0:
            return np.nan
        return float((np.mean(self.simulated) - self.rigid) / estimated)

    def row(self) -> dict[str, Any]:
        """Return its numbers by name, and the doubts of the estimate as text."""
        item = self.reversal
        return {
            "joint": self.joint,
            "position": item.position,
            "rigid": self.rigid,
            "estimate": self.estimate,
            "simulated": float(np.mean(self.simulated)),
            "simulated_least": float(np.min(self.simulated)),
            "simulated_greatest": float(np.max(self.simulated)),
            "error": self.error,
            "excess": self.excess,
            "expected": item.expected,
            "least": item.least,
            "greatest": item.greatest,
            "turn_through": item.turn_through,
            "flown": item.flown,
            "tau": item.tau,
            "doubts": "; ".join(item.doubts),
        }


class Comparison(tuple[Compared, ...]):
    """Reversals as they were estimated and simulated, joint by joint; `print` shows a table."""

    __slots__ = ()

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each reversal, SI units."""
        import pandas

        return pandas.DataFrame([item.row() for item in self])

    def __str__(self) -> str:
        lines = ["estimate beside simulation [N]"]
        for item in self:
            doubts = "; ".join(item.reversal.doubts)
            lines.append(
                f"- {item.joint} at {item.reversal.position:.3f} rad: {item.estimate:.4g} beside "
                f"{np.mean(item.simulated):.4g} ({100.0 * item.error:+.1f} %), rigid "
                f"{item.rigid:.4g}{_interval(item)}{'; ' + doubts if doubts else ''}"
            )
        return "\n".join(lines)

    __repr__ = __str__


def _interval(item: Compared) -> str:
    """Return the interval of a reversal as text; empty if it has none."""
    found = item.reversal
    if found.passages is None:
        return ""
    return f", in the plane {found.least:.4g} to {found.greatest:.4g}"
