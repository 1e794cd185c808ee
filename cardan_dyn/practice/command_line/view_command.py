"""What `cardan-dyn view` does with its options: a scene to be shown from a name and numbers."""

from __future__ import annotations

import click

from ...core.mechanics.exact import load
from ...kit.errors import ArgumentError
from ...scene.usual_motion import usual_motion
from ..viewer.commands import meshcat
from ..viewer.viewing import View
from ..viewer.viewing import view as draw
from .quantities import efforts, positions
from .quantities import near as near_of


def scene_of(
    source: str,
    *,
    drive: tuple[str, ...] = (),
    held: tuple[str, ...] = (),
    near: tuple[str, ...] = (),
    loads: tuple[str, ...] = (),
    speed: float | None = None,
    gravity: tuple[float, float, float] | str | None = None,
    samples: int = 721,
    joints: tuple[str, ...] = (),
    hide: tuple[str, ...] = (),
    duration: float | None = None,
    strict: bool = True,
) -> View:
    """Return the scene of a mechanism; what of its motion is not given is as usual.

    Args:
        source: name of a bundled description, or a path.
        drive: driven joints, or coordinates `joint.coordinate`.
        held: held joints and positions, as `quantities.positions` reads them.
        near: where loops are closed first, as `quantities.near` reads it.
        loads: joints and efforts, as `quantities.efforts` reads them.
        speed: of a drive that turns [rad/s].
        gravity: acceleration of free fall [m/s²], or `description`.
        samples: count of positions.
        joints: which joints are drawn; all if empty.
        hide: what is left out: `visuals`, `moments`, `forces`, `axes`, `traces`, `labels`.
        duration: of one sweep [s]; its own time, or 8 s, if None.
        strict: refuse physically inconsistent inertias.

    Raises:
        MissingExtraError: meshcat is not installed.
        CardanError: as `load`, `usual_motion`, `Scene.sweep` and `view` do.
    """
    meshcat()  # A missing extra is reported before anything is computed.
    mechanism = load(source, strict=strict)
    moved = usual_motion(
        mechanism,
        drive=drive,
        held=positions(mechanism, held),
        near=near_of(mechanism, near),
        loads=efforts(mechanism, loads) or None,
        gravity=gravity,
        samples=samples,
    )
    if speed and not moved.turns:
        raise ArgumentError(
            f"--speed is of a drive that turns, and {moved.said}: leave it out, or name one that "
            "turns: --drive"
        )
    click.echo(f"{moved.scene.mechanism.name}: {moved.said}", err=True)
    return draw(
        moved.sweep(speed),
        joints=joints or None,
        duration=duration,
        frames=samples,
        visuals="visuals" not in hide,
        moments="moments" not in hide,
        forces="forces" not in hide,
        axes="axes" not in hide,
        traces="traces" not in hide,
        labels="labels" not in hide,
    )
