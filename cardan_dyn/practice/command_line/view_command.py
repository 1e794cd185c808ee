"""What `cardan-dyn view` does with its options: a scene to be shown from a name and numbers."""

from __future__ import annotations

from typing import Any

import click

from ...core.mechanics.exact import load
from ...kit.errors import ArgumentError
from ...scene.usual_motion import usual_motion
from ..viewer.commands import meshcat
from ..viewer.viewing import View
from ..viewer.viewing import view as draw
from .options import HIDDEN, Words
from .quantities import of_scene


def scene_of(
    source: str,
    *,
    speed: float | None = None,
    samples: int = 721,
    joints: Words = (),
    hide: Words = (),
    duration: float | None = None,
    strict: bool = True,
    **given: Any,
) -> View:
    """Return the scene of a mechanism; what of its motion is not given is as usual.

    Args:
        source: name of a bundled description, or a path.
        speed: of a drive that turns [rad/s].
        samples: count of positions.
        joints: which joints are drawn; all if empty.
        hide: what is left out, of `HIDDEN`.
        duration: of one sweep [s]; its own time, or 8 s, if None.
        strict: refuse physically inconsistent inertias.
        given: what drives and acts, see `quantities.of_scene`.

    Raises:
        MissingExtraError: meshcat is not installed.
        CardanError: as `load`, `usual_motion`, `Scene.sweep` and `view` do.
    """
    meshcat()  # A missing extra is reported before anything is computed.
    mechanism = load(source, strict=strict)
    acting = of_scene(mechanism, **given)
    moved = usual_motion(mechanism, samples=samples, **acting | {"loads": acting["loads"] or None})
    if speed and not moved.turns:
        raise ArgumentError(
            f"--speed is of a drive that turns, and {moved.said}: leave it out, or name one that "
            "turns: --drive"
        )
    click.echo(f"{moved.scene.mechanism.name}: {moved.said}", err=True)
    shown: dict[str, Any] = {part: part not in hide for part in HIDDEN}
    return draw(
        moved.sweep(speed),
        joints=joints or None,
        duration=duration,
        frames=samples,
        **shown,
    )
