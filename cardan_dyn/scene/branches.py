"""Branches: the assembly modes of a scene, as its user looks at them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..core.kinematics.assembly_modes import AssemblyModes, mode_name, positions_of
from ..core.mechanism.mechanism import Mechanism
from ..kit.errors import ArgumentError, choices
from ..kit.frozen import Frozen, frozen


class Branches(Frozen, Mapping[str, Mapping[str, float]]):
    """The assembly modes of a scene, by name: the positions of all joints with one coordinate.

    A mapping of the poses. Joints whose axes intersect, like those of yokes and wrists, can flip
    without anything else being moved, and a rod or shaft can be turned by half a turn about the
    line of its joints: such variants of a pose, in which all joint axes lie on the same lines and
    all centres of balls at the same points, are not counted. `branches.variants["A"]["A2"]` is one
    of them, and `Scene(branch="A2")` starts in it.

    Positions are in rad, between -π and π for passive joints, or m.

    Attributes:
        variants: pose to its variants that were found, the pose as it is listed first: name to
            positions.
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
        self.variants = frozen(
            {
                mode_name(pose): frozen(
                    {
                        mode_name(pose, variant): frozen(positions_of(mechanism, drives, state))
                        for variant, state in enumerate(states)
                    }
                )
                for pose, states in enumerate(modes.poses)
            }
        )
        self.starts, self.last_new = modes.starts, modes.last_new
        self.is_complete = modes.is_complete
        self._freeze()

    def __getitem__(self, name: str) -> Mapping[str, float]:
        if name not in self.variants:
            raise ArgumentError(
                f"branch {name!r} is no pose; poses: {choices(self.variants, name)}; their "
                "variants are in `variants`"
            )
        return self.variants[name][name]

    def get(self, name: str, default: Any = None) -> Any:
        """Return the positions of a pose, or something else if there is no such pose."""
        return self.variants[name][name] if name in self.variants else default

    def __contains__(self, name: object) -> bool:
        return name in self.variants

    def __iter__(self) -> Iterator[str]:
        return iter(self.variants)

    def __len__(self) -> int:
        return len(self.variants)

    def __str__(self) -> str:
        names = list(next(iter(self.variants.values()))[next(iter(self.variants))])
        rows = [("pose", "variants", *names)]
        rows += [
            (pose, str(len(self.variants[pose])), *(f"{self[pose][name]:.4g}" for name in names))
            for pose in self
        ]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = (
            "  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True))
            for row in rows
        )
        return "\n".join([repr(self)[1:-1], *lines])

    def __repr__(self) -> str:
        count = sum(map(len, self.variants.values()))
        poses = f"{len(self)} pose{'s' * (len(self) != 1)}"
        variants = f" ({count} variants were met)" if count > len(self) else ""
        found = f"{self.starts} starts, of which those after {self.last_new} brought no new one"
        ended = "" if self.is_complete else "; the search was ended before it was complete"
        return f"<Branches: {poses}{variants}, from {found}{ended}>"
