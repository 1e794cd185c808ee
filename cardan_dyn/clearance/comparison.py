"""Comparison: the estimate of a scan beside the simulation of the whole mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError
from .contact_simulation import ContactSimulation
from .joint_scan import JointScan, Reversal
from .pin_scan import PinScan
from .scan import Scan

if TYPE_CHECKING:
    import pandas

_PER_STEP = 8
"""Times at which the force is looked at between two steps of a simulation."""


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
                f"{item.rigid:.4g}{'; ' + doubts if doubts else ''}"
            )
        return "\n".join(lines)

    __repr__ = __str__


def compare(scan: Scan | PinScan, simulation: ContactSimulation) -> Comparison:
    """Compare the estimate of a scan with a simulation.

    What is compared is the greatest force from one reversal to the next: the greater of the
    estimated peak and of the force without play. The first reversal of the simulation is left out,
    before which it had not yet settled.

    Args:
        scan: with a damping ratio as the simulation has it; of pin bearings, each is compared.
        simulation: of the same mechanism, speed, play and contact, over two turns or more.

    Raises:
        ArgumentError: they have no joint in common, their speeds differ, or the simulation is too
            short.
    """
    scans: Mapping[str, JointScan] = scan.by_bearing() if isinstance(scan, PinScan) else scan
    joints = [name for name in simulation if name in list(scans)]
    if not joints:
        raise ArgumentError("no joint of the simulation was scanned")
    if abs(scan.speed - simulation.speed) > 1e-12 * abs(scan.speed):
        raise ArgumentError(
            f"the scan is of {scan.speed:g} rad/s, the simulation of {simulation.speed:g} rad/s"
        )
    steps = simulation.steps
    parts = np.linspace(0.0, 1.0, _PER_STEP, endpoint=False)
    times = (steps[:-1, None] + np.diff(steps)[:, None] * parts).ravel()
    fine = simulation.at(np.concatenate([times, steps[-1:]]))
    result = []
    for name in joints:
        course = fine[name]
        result += _of_joint(scans[name], course.position, course.force, float(np.sign(scan.speed)))
    return Comparison(result)


def _of_joint(scan: JointScan, position: Array, force: Array, sense: float) -> list[Compared]:
    """Return the reversals of a joint.

    Args:
        scan: of the joint.
        position: of the drive `(N,)` in the simulation [rad].
        force: `(N,)` in it [N].
        sense: in which the drive turns.
    """
    count = len(scan.position)
    period = float(scan.position[1] - scan.position[0]) * count
    starts = [item.position for item in scan.reversals]
    rigid = np.linalg.norm(scan.force, axis=1)
    found = []
    for index, item in enumerate(scan.reversals):
        after = starts[(index + int(sense)) % len(starts)]
        way = (sense * (after - item.position)) % period or period
        since = (sense * (scan.position - item.position)) % period
        greatest = float(np.max(rigid[since <= way], initial=0.0))
        passed = sense * (position - item.position)
        turns, within = np.floor(passed / period).astype(int), passed % period
        begun, ended = sense * position[0], sense * position[-1]
        whole = [
            turn
            for turn in range(int(np.min(turns)), int(np.max(turns)) + 1)
            if begun < sense * item.position + turn * period - 0.25 * period
            and sense * item.position + turn * period + way <= ended
        ]
        if not whole:
            raise ArgumentError(
                f"the simulation is too short for the reversal of joint {scan.name!r} at "
                f"{item.position:.3g} rad; simulate more turns"
            )
        peaks = [float(np.max(force[(turns == turn) & (within <= way)])) for turn in whole]
        peak = item.peak if item.strikes else 0.0
        estimate = max(peak, greatest)
        found.append(Compared(scan.name, item, greatest, estimate, np.array(peaks)))
    return found
