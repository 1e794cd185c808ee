"""Left open: what of wrenches does not follow from the laws of motion, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..arrays import Array
from ..dynamics.reactions import UNIQUE_TOLERANCE
from ..mechanism.undescribed import Undescribed, greatest_changes
from .wrench import named_components


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
    def rows(self) -> list[str]:
        """What the rule has chosen: joints with their components in brackets, and couplings."""
        return _listed(self.chosen)

    @property
    def told(self) -> str:
        """Which couplings say nothing, and of which components; empty if none."""
        if not self.silent:
            return ""
        said = "; ".join(item.told() for item in self.couplings)
        return f"{said}: {', '.join(_listed(self.silent))}"

    @property
    def text(self) -> str:
        """All that is open in one line; empty if nothing is."""
        chosen = f"chosen by {self.rule}: {', '.join(self.rows)}" if self.chosen else ""
        return "; ".join(filter(None, (chosen, self.told)))

    def why(self, joint: str) -> str:
        """Return why components of a joint's wrench are open; empty if none is."""
        parts = [f"chosen by {self.rule}"] if joint in self.chosen else []
        if joint in self.silent:
            parts += [item.told() for item in self.couplings if joint in item.changes]
        return "; ".join(parts)


def _listed(opened: dict[str, str]) -> list[str]:
    return [f"{name} ({parts})" if parts else name for name, parts in opened.items()]
