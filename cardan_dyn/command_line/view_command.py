"""What `cardan-dyn view` does with its options: a scene to be shown from a name and numbers."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import click

from ..mechanism.mechanism import Mechanism, load
from ..scene.usual_motion import UsualMotion, usual_motion
from ..viewer.commands import meshcat
from ..viewer.viewing import View
from ..viewer.viewing import view as draw
from .quantities import efforts, positions


class MotionOptions(NamedTuple):
    """How a mechanism is moved.

    Attributes:
        drive: driven joints, or coordinates `joint.coordinate`; those of the preset if empty.
        held: held joints and positions, as `quantities.positions` reads them.
        loads: joints and efforts, as `quantities.efforts` reads them; those of the preset if empty.
        speed: of a drive that turns [rad/s]; that of the preset if None.
        gravity: acceleration of free fall [m/s²]; that of the preset if None.
        samples: count of positions.
    """

    drive: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    loads: tuple[str, ...] = ()
    speed: float | None = None
    gravity: tuple[float, float, float] | None = None
    samples: int = 721

    def motion(self, mechanism: Mechanism) -> UsualMotion:
        """Return how a mechanism moves.

        Raises:
            CardanError: as `usual_motion` does.
        """
        return usual_motion(
            mechanism,
            drive=self.drive,
            held=positions(mechanism, self.held),
            loads=efforts(mechanism, self.loads) or None,
            gravity=self.gravity,
            samples=self.samples,
        )


def scene_of(
    source: str,
    motion: MotionOptions,
    joints: tuple[str, ...],
    hidden: Collection[str],
    duration: float | None,
    strict: bool,
) -> View:
    """Return the scene of a mechanism.

    Args:
        source: name of a bundled description, or a path.
        motion: how it moves.
        joints: which joints are drawn; all if empty.
        hidden: what is left out: `visuals`, `moments`, `forces`, `axes`, `traces`, `labels`.
        duration: of one sweep [s]; its own time, or 8 s, if None.
        strict: refuse physically inconsistent inertias.

    Raises:
        MissingExtraError: meshcat is not installed.
        CardanError: as `load`, `usual_motion`, `Scene.sweep` and `view` do.
    """
    meshcat()  # A missing extra is reported before anything is computed.
    moved = motion.motion(load(source, strict=strict))
    click.echo(f"{moved.scene.mechanism.name}: {moved.said}", err=True)
    return draw(
        moved.sweep(motion.speed),
        joints=joints or None,
        duration=duration,
        frames=motion.samples,
        visuals="visuals" not in hidden,
        moments="moments" not in hidden,
        forces="forces" not in hidden,
        axes="axes" not in hidden,
        traces="traces" not in hidden,
        labels="labels" not in hidden,
    )
