"""Left open: what of wrenches does not follow from the laws of motion, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...kit.arrays import Array
from ..dynamics.inverse_dynamics import UNIQUE_TOLERANCE
from ..mechanism.undescribed import Undescribed, greatest_changes


class LeftOpen(NamedTuple):
    """What of the outputs of a sweep is not unique.

    Attributes:
        rule: by which rule is chosen what statics leaves open.
        chosen: joints to the names of the components that it has chosen, and couplings, whose
            moment it has chosen, to nothing.
        silent: joints to the names of the components of which couplings say nothing.
        couplings: these couplings.
    """

    rule: str
    chosen: dict[str, str]
    silent: dict[str, str]
    couplings: tuple[Undescribed, ...]

    @staticmethod
    def of(
        rule: str,
        couplings: Sequence[Undescribed],
        unique: Mapping[str, Array],
        coupling_unique: Mapping[str, bool],
    ) -> LeftOpen:
        """Return what is open.

        Args:
            rule: see the attribute.
            couplings: those of the mechanism that say nothing of their forces.
            unique: outputs to `(6,)` which components of their wrenches are unique.
            coupling_unique: couplings to whether their moments are.
        """
        chosen: dict[str, str] = {}
        silent: dict[str, str] = {}
        by_couplings = greatest_changes(couplings, unique) > UNIQUE_TOLERANCE
        for (name, row), is_silent in zip(unique.items(), by_couplings, strict=True):
            for opened, found in ((~row & ~is_silent, chosen), (~row & is_silent, silent)):
                if opened.any():
                    found[name] = named_components(opened)
        chosen |= {name: "" for name, is_unique in coupling_unique.items() if not is_unique}
        heard = tuple(item for item in couplings if silent.keys() & item.changes.keys())
        return LeftOpen(rule, chosen, silent, heard)

    @property
    def text(self) -> str:
        """All that is open in one line; empty if nothing is."""
        parts = [self._chosen(_listed(self.chosen))] if self.chosen else []
        if self.silent:
            said = "; ".join(item.told() for item in self.couplings)
            parts.append(f"{said}: {', '.join(_listed(self.silent))}")
        return "; ".join(parts)

    @property
    def brief(self) -> str:
        """What is open, by the first few names alone; empty if nothing is."""
        names, parts = [*self.chosen], []
        if names:
            more = f" and {len(names) - 3} more" if len(names) > 3 else ""
            parts.append(f"{self._chosen(names[:3])}{more}")
        if self.couplings:
            more = f" (nor of {len(self.couplings) - 1} more)" if len(self.couplings) > 1 else ""
            parts.append(f"{self.couplings[0].told()}{more}")
        return "; ".join(parts)

    def why(self, *names: str) -> str:
        """Return why some joints' wrenches or couplings' moments are open; empty if none is."""
        parts = [f"chosen by {self.rule}"] if self.chosen.keys() & set(names) else []
        silent = self.silent.keys() & set(names)
        parts += [item.told() for item in self.couplings if silent & item.changes.keys()]
        return "; ".join(parts)

    def _chosen(self, names: Sequence[str]) -> str:
        return f"not determined by statics, chosen by {self.rule}: {', '.join(names)}"


def _listed(opened: dict[str, str]) -> list[str]:
    """Return the names, those that are open alike before what is open of them."""
    alike: dict[str, list[str]] = {}
    for name, parts in opened.items():
        alike.setdefault(parts, []).append(name)
    return [
        f"{', '.join(names)} ({parts})" if parts else ", ".join(names)
        for parts, names in alike.items()
    ]


def named_components(flags: Array) -> str:
    """Return flagged components `(6,)` as text, for example `force z, moment xy`."""
    vectors = [
        f"{name} {''.join(axis for axis, flag in zip('xyz', flagged, strict=True) if flag)}"
        for name, flagged in (("force", flags[:3]), ("moment", flags[3:]))
        if np.any(flagged)
    ]
    return ", ".join(vectors)
