"""Branches: the assembly modes of a scene, as its user looks at them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..errors import ArgumentError, choices
from ..frozen import Frozen, frozen
from ..kinematics.assembly_modes import AssemblyModes, mode_name, positions_of
from ..mechanism.mechanism import Mechanism


class Branches(Frozen, Mapping[str, Mapping[str, float]]):
    """The assembly modes of a scene, by name: the positions of all joints with one coordinate.

    A mapping of the poses. Joints whose axes intersect, like those of yokes and wrists, can flip
    without anything else being moved, and a rod or shaft can be turned by half a turn about the
    line of its joints: such variants of a pose, in which all joint axes lie on the same lines and
    all centres of balls at the same points, are not counted. `branches["A2"]` gives them as well,
    and `Scene(branch="A2")` starts in one.

    Positions are in rad, between -π and π for passive joints, or m.

    Attributes:
        variants: pose to the names of its variants that were found, its own first.
        starts: number of random starts from which modes were searched.
        last_new: number of starts after which the last of the poses had been found.
        is_complete: whether the search ended since three times as many starts brought no further
            pose. It proves nothing, but a pose that is missing is one that few starts lead to.
    """

    def __init__(self, mechanism: Mechanism, drives: tuple[str, ...], modes: AssemblyModes) -> None:
        """Name modes.

        Args:
            mechanism: the mechanism.
            drives: names of its drives, whose positions keep their whole turns.
            modes: of a scene.
        """
        self._positions = frozen(
            {
                name: frozen(positions_of(mechanism, drives, state))
                for name, state in modes.named().items()
            }
        )
        self.variants = frozen(
            {
                mode_name(pose): tuple(mode_name(pose, index) for index in range(len(states)))
                for pose, states in enumerate(modes.poses)
            }
        )
        self.starts, self.last_new = modes.starts, modes.last_new
        self.is_complete = modes.is_complete
        self._freeze()

    def __getitem__(self, name: str) -> Mapping[str, float]:
        if name not in self._positions:
            listed = choices(self._positions, name)
            raise ArgumentError(f"branch {name!r} does not exist; branches: {listed}")
        return self._positions[name]

    def get(self, name: str, default: Any = None) -> Any:
        """Return the positions of a branch, or something else if there is no such branch."""
        return self._positions.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._positions

    def __iter__(self) -> Iterator[str]:
        return iter(self.variants)

    def __len__(self) -> int:
        return len(self.variants)

    def __repr__(self) -> str:
        count = len(self._positions)
        poses = f"{len(self)} pose{'s' * (len(self) != 1)}"
        variants = f" in {count} variants" if count > len(self) else ""
        found = f"{self.starts} starts, of which those after {self.last_new} brought no new one"
        ended = "" if self.is_complete else "; the search was ended before it was complete"
        return f"<Branches: {poses}{variants}, from {found}{ended}>"
