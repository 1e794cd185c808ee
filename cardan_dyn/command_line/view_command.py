"""What `cardan-dyn view` does with its options: a scene to be shown from a name and numbers."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from ..errors import ArgumentError
from ..mechanism.mechanism import Mechanism, load
from ..results.sweep import Sweep
from ..viewer.commands import meshcat
from ..viewer.viewing import View
from ..viewer.viewing import view as draw
from .presets import default_sweep, slides

_RAD_PER_S = np.pi / 30.0
"""One revolution per minute [rad/s]."""


class MotionOptions(NamedTuple):
    """How a mechanism is moved, in the units of the command line.

    Attributes:
        drive: driven joints, or coordinates `joint.coordinate`; those of the preset if empty.
        held: held joints to angles [°], slides to positions [m].
        loads: joints to efforts [N·m, slides: N]; those of the preset if None.
        speed_rpm: of a drive that turns [1/min]; that of the preset if None.
        gravity: acceleration of free fall [m/s²]; that of the preset if None.
        samples: count of positions.
    """

    drive: tuple[str, ...]
    held: Mapping[str, float]
    loads: Mapping[str, float] | None = None
    speed_rpm: float | None = None
    gravity: tuple[float, float, float] | None = None
    samples: int = 721

    def sweep(self, mechanism: Mechanism) -> Sweep:
        """Return the sweep of a mechanism.

        Raises:
            CardanError: as `default_sweep` does.
        """
        held = {
            name: value if slides(mechanism, name) else float(np.deg2rad(value))
            for name, value in self.held.items()
        }
        return default_sweep(
            mechanism,
            drive=self.drive,
            held=held,
            loads=self.loads,
            gravity=self.gravity,
            speed=None if self.speed_rpm is None else self.speed_rpm * _RAD_PER_S,
            samples=self.samples,
        )


def scene_of(
    source: str,
    motion: MotionOptions,
    joints: tuple[str, ...],
    hidden: Collection[str],
    duration: float,
    strict: bool,
) -> View:
    """Return the scene of a mechanism.

    Args:
        source: name of a bundled description, or a path.
        motion: how it moves.
        joints: which joints are drawn; all if empty.
        hidden: what is left out: `visuals`, `moments`, `forces`, `axes`, `traces`, `labels`.
        duration: of one sweep [s].
        strict: refuse physically inconsistent inertias.

    Raises:
        MissingExtraError: meshcat is not installed.
        CardanError: as `load`, `default_sweep` and `view` do.
    """
    meshcat()  # A missing extra is reported before anything is computed.
    return draw(
        motion.sweep(load(source, strict=strict)),
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


def parsed_assignments(
    pairs: tuple[str, ...], option: str, form: str = "JOINT=VALUE, as joint_angle=30"
) -> dict[str, float]:
    """Return names and values from `NAME=VALUE`.

    Raises:
        ArgumentError: a pair has another form; `option` and `form` are named in the message.
    """
    values: dict[str, float] = {}
    for pair in pairs:
        name, separator, value = pair.rpartition("=")
        try:
            values[name] = float(value)
        except ValueError:
            separator = ""
        if not separator or not name:
            raise ArgumentError(f"{option} {pair!r} is not {form}")
    return values
