"""Scanned: the joints of a mechanism by how hard they would hammer if they had clearance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ModelError, choices
from .compared import Comparison
from .joint_scan import JointScan
from .pin_geometry import PinGeometry

if TYPE_CHECKING:
    import pandas


class Scan(Mapping[str, JointScan]):
    """Joints by name, with what play would do in each; `print` shows a table.

    Attributes:
        speed: of the drive [rad/s].
        left_out: joints that were not scanned to why.
        verified: reversals beside simulations of the whole mechanism; None if that was not asked.
        unverified: joints of which a simulation came to nothing, to why.
        made_of: what the forces depend on, each with its hash: `compare` asks for the same.
    """

    def __init__(
        self,
        joints: Mapping[str, JointScan],
        speed: float,
        left_out: Mapping[str, str],
        verified: Comparison | None = None,
        unverified: Mapping[str, str] | None = None,
        made_of: Mapping[str, str] | None = None,
    ) -> None:
        self._joints = dict(joints)
        self.speed, self.left_out = speed, dict(left_out)
        self.verified, self.unverified = verified, dict(unverified or {})
        self.made_of = dict(made_of or {})

    def __getitem__(self, joint: str) -> JointScan:
        if joint in self.left_out:
            raise ModelError(f"joint {joint!r} was not scanned: {self.left_out[joint]}")
        if joint not in self._joints:
            raise ModelError(f"no joint {joint!r} was scanned; {choices(self._joints, joint)}")
        return self._joints[joint]

    def __iter__(self) -> Iterator[str]:
        return iter(self._joints)

    def __len__(self) -> int:
        return len(self._joints)

    @property
    def ranking(self) -> list[str]:
        """Names of the joints by severity: the greatest force of an impact first.

        Impacts where a force turns through count by what is left of them. Joints in which nothing
        strikes follow by their greatest force without play.
        """

        def key(name: str) -> tuple[float, float]:
            joint = self._joints[name]
            return -max(joint.severity, joint.partial_severity), -joint.rigid_peak

        return sorted(self._joints, key=key)

    @property
    def notes(self) -> tuple[str, ...]:
        """What concerns whole joints, beside the doubts on single reversals."""
        bare = [
            name
            for name in self.ranking
            for law in {item.model.stiffness for item in self._joints[name].reversals}
            if isinstance(law, PinGeometry) and law.seat_stiffness is None
        ]
        notes = [f"{name}: not verified, {reason}" for name, reason in self.unverified.items()]
        if bare:
            notes.append(
                f"{', '.join(bare)}: the stiffness is that of a line contact alone, which "
                "overstates what pin, bush and seat have in series about a hundredfold; give "
                "seat_stiffness"
            )
        return tuple(notes)

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each reversal, by column, SI units, in the order of the ranking.

        `simulated` is the mean greatest force until the next reversal, if that was verified.
        """
        beside = {(item.joint, item.reversal.position): item for item in self.verified or ()}
        rows = []
        for name in self.ranking:
            for item in self._joints[name].reversals:
                row = {"joint": name, **item.row()}
                if self.verified is not None:
                    found = beside.get((name, item.position))
                    row["simulated"] = float(np.mean(found.simulated)) if found else np.nan
                rows.append(row)
        return rows

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each reversal, SI units, in the order of the ranking.

        Columns `exponent_...` say by which powers of speed, slope, play, mass and stiffness the
        peak grows; see `Reversal.exponents`.
        """
        import pandas

        return pandas.DataFrame(self.rows())

    def __str__(self) -> str:
        lines = [f"clearance at {self.speed:g} rad/s"]
        lines += [f"- {name}: {self._joints[name].summary}" for name in self.ranking]
        lines += str(self.verified).splitlines()[1:] if self.verified else []
        lines += [f"- {name}: not scanned, {reason}" for name, reason in self.left_out.items()]
        return "\n".join([*lines, *(f"- note: {note}" for note in self.notes)])

    __repr__ = __str__
