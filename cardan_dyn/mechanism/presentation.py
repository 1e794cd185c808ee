"""Presentation: how a mechanism shows itself, and the files that it is written to."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ..frozen import Frozen, FrozenDict
from .couplings import Coupling, shown
from .joints import Joint

if TYPE_CHECKING:
    from ..description.description import Description, JointDescription, LoopDescription
    from .configuration import Configuration
    from .welds import Loop


class Presentation(Frozen):
    """The part of a `Mechanism` that shows and writes it; see there for the attributes."""

    name: str
    description: Description
    notation: str
    joints: Mapping[str, Joint]
    loops: tuple[Loop, ...]
    couplings: tuple[Coupling, ...]
    characteristic_length: float

    @cached_property
    def joint_dynamics(self) -> FrozenDict[str, tuple[float, float]]:
        """Coordinates to the damping [N·m·s/rad, N·s/m] and friction [N·m, N] described for them.

        `<dynamics>` in URDF and SDF, `damping` and `frictionloss` in MJCF; of a joint with several
        coordinates, those of each. Joints with a ball are left out. No wrench considers them unless
        a scene is given `described_elements`.
        """
        return FrozenDict(
            {
                name: (item.damping, item.friction)
                for name, item in self._described_coordinates()
                if item.damping or item.friction
            }
        )

    @cached_property
    def joint_springs(self) -> FrozenDict[str, tuple[float, float]]:
        """Coordinates to stiffness [N·m/rad, N/m] and rest of the springs described for them.

        The rest is the position [rad or m] without effort. `spring_stiffness` and
        `spring_reference` of `<dynamics>` in SDF and URDF+, `stiffness` and `springref` in MJCF;
        otherwise as `joint_dynamics`.
        """
        return FrozenDict(
            {
                name: (item.stiffness, item.rest)
                for name, item in self._described_coordinates()
                if item.stiffness
            }
        )

    def _described_coordinates(self) -> Iterator[tuple[str, JointDescription | LoopDescription]]:
        """Iterate over coordinates of joints without a ball, and what describes their joints."""
        described: list[JointDescription | LoopDescription] = [
            *self.description.joints,
            *self.description.loops,
        ]
        for item in described:
            if item.name in self.joints and not self.joints[item.name].has_ball:
                for name in self.joints[item.name].coordinates:
                    # What is called like a coordinate of another joint is that joint.
                    if name == item.name or name not in self.joints:
                        yield name, item

    def to_urdf(self) -> str:
        """Return the description as URDF+ text, which `load` reads back; without visuals."""
        from ..description.write import to_urdf

        return to_urdf(self.description)

    def write(
        self,
        path: str | os.PathLike[str],
        *,
        at: Configuration | Mapping[str, object] | None = None,
    ) -> Path:
        """Write the description to a file, which `load` reads back; without visuals.

        A file that exists is replaced.

        Args:
            path: file whose suffix says in which notation: `.urdf` for URDF+, as `to_urdf` returns
                it; `.xml` or `.mjcf` for MJCF, see `description.mjcf.writer` for what it becomes
                there. `load` reads MJCF back whose bodies are nested up to 300 deep.
            at: closed configuration that becomes the zero of the written coordinates, or its
                `positions`: name of every moving joint, loops included, to its position.
                Limits are counted from there as well. Without it the zero stays if its loops are
                closed, otherwise `assembled` finds a configuration near it.

        Returns:
            The path.

        Raises:
            ArgumentError: unknown suffix, no such directory, or `at` is incomplete, malformed or
                not closed.
            ModelError: the notation cannot say something of the description.
            AssemblyError: the loops are open at zero and cannot be closed near it; `to_urdf`
                returns the description as it is.
        """
        from ..description.files import write
        from .configuration import Configuration
        from .rezero import is_closed, rezeroed

        if at is None and not is_closed(self.description):
            at = self.assembled().positions
        if isinstance(at, Configuration):
            at = at.positions
        description = self.description if at is None else rezeroed(self.description, at)
        return write(description, path)

    @property
    def warnings(self) -> tuple[str, ...]:
        """See `Mechanism.warnings`."""
        raise NotImplementedError

    def assembled(self) -> Configuration:
        """See `Mechanism.assembled`."""
        raise NotImplementedError

    def __repr__(self) -> str:
        loops = ", ".join(loop.joint for loop in self.loops) or "none"
        return f"<Mechanism {self.name!r}: {len(self.joints)} joints, loops: {loops}>"

    def _repr_html_(self) -> str:
        from ..markup import table  # Imported here: only notebooks show it.

        rows = [
            ("notation", self.notation),
            ("characteristic length", f"{self.characteristic_length:.4g} m"),
            ("joints", "\n".join(f"{joint.name}: {joint.type}" for joint in self.joints.values())),
            ("loops", ", ".join(loop.joint for loop in self.loops) or "none"),
            ("couplings", "\n".join(map(shown, self.couplings)) or "none"),
            ("warnings", "\n".join(self.warnings) or "none"),
        ]
        return table(("property", "value"), rows, caption=self.name)
