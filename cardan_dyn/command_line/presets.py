"""Presets: what `cardan-dyn view` shows of a mechanism unless its options say otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..errors import MobilityError
from ..mechanism.mechanism import Mechanism
from ..results.sweep import Sweep
from ..scene.scene import Scene

_SLIDE_SWING = 0.05
"""How far a slide without limits moves to both sides, as a fraction of the mechanism's length."""
_ANGLE_SWING = 0.5
"""How far an angle without limits moves to both sides [rad]: clearly visible, and less than most
mechanisms allow."""
_NO_LIMIT = 1e3
"""Range of a coordinate [rad or m] from which on its limits count as none: descriptions write
such numbers where the format requires a limit."""
_SINGLE_SWING = 0.45
"""Amplitude of a single drive, as a fraction of its range: it stays 5 % of the range away from the
dead points at both ends, where the scene would be refused."""
_JOINT_SWING = 0.3
"""Amplitude of each of several drives, as a fraction of its limits: these say nothing of which
combinations of positions the loops allow, so it stays well inside."""
_TURN = (0.0, 2.0 * np.pi)
"""Range of a drive that turns without end [rad]."""


@dataclass(frozen=True)
class Preset:
    """Drive, held joints and loads of a bundled description.

    Attributes:
        drive: driven joints.
        held_deg: joint angles [deg].
        loads: joint to effort [N·m or N].
        gravity: acceleration of free fall [m/s²].
        speed: of a single drive [rad/s].
    """

    drive: tuple[str, ...] = ("bearing_in",)
    held_deg: Mapping[str, float] = field(default_factory=dict)
    loads: Mapping[str, float] = field(default_factory=dict)
    gravity: tuple[float, float, float] | None = None
    speed: float = 0.0


_OUT = {"bearing_out": -100.0}
PRESETS: Mapping[str, Preset] = {
    "universal_joint": Preset(held_deg={"joint_angle": 35.0}, loads=_OUT),
    "ring_joint": Preset(held_deg={"joint_angle": 35.0}, loads=_OUT),
    "thoma_rig": Preset(held_deg={"joint_angle": 8.5}, speed=100.0),
    "elastic_thoma_rig": Preset(
        held_deg={"joint_angle": 8.5, "tilt_z": 0.0, "tilt_y": 0.0}, speed=100.0
    ),
    "torsional_line_front": Preset(held_deg={"joint_angle": 20.0, "twist_in": 0.0}, speed=100.0),
    "torsional_line_behind": Preset(held_deg={"joint_angle": 20.0, "twist_out": 0.0}, speed=100.0),
    "torsional_line_both": Preset(
        held_deg={"joint_angle": 20.0, "twist_in": 0.0, "twist_out": 0.0}, speed=100.0
    ),
    "elastic_double_shaft": Preset(
        held_deg={"joint_angle_1": 20.0, "joint_angle_2": 20.0, "twist_middle": 0.0}, speed=100.0
    ),
    "double_shaft_z": Preset(held_deg={"joint_angle_1": 30.0, "joint_angle_2": 30.0}, loads=_OUT),
    "double_shaft_w": Preset(held_deg={"joint_angle_1": 20.0, "joint_angle_2": 20.0}, loads=_OUT),
    "double_shaft_spatial": Preset(
        # Bild 19 of the catalogue of cardan shafts, as the description's header gives it.
        held_deg={
            "joint_angle_1_h": 7.0,
            "joint_angle_1_v": 14.8932,
            "joint_angle_2_h": 12.0,
            "joint_angle_2_v": -11.2552,
        },
        loads=_OUT,
    ),
    "drive_line": Preset(
        held_deg={"joint_angle_1": 8.0, "joint_angle_2": -12.0, "joint_angle_3": 10.0}, loads=_OUT
    ),
    "four_bar": Preset(("crank_bearing",), loads={"rocker_bearing": -60.0}),
    "slider_crank": Preset(("crank_bearing",), loads={"piston_guide": -1000.0}),
    "needle_drive": Preset(("main_shaft",), speed=200.0),
    "stewart_platform": Preset(
        tuple(f"leg_{index}" for index in range(1, 7)), gravity=(0.0, 0.0, -9.81)
    ),
}
"""By the name of the bundled description; others are driven at their `independent_joints`."""


def default_sweep(
    mechanism: Mechanism,
    *,
    drive: tuple[str, ...] = (),
    held: Mapping[str, float] | None = None,
    loads: Mapping[str, float] | None = None,
    gravity: ArrayLike | None = None,
    speed: float | None = None,
    samples: int = 721,
) -> Sweep:
    """Move a mechanism through its range, as given or else as its preset says.

    A single drive turns once, or swings through the range that it has; several swing out of phase,
    each within its limits.

    Args:
        mechanism: from `load`.
        drive: driven joints.
        held: joints to positions [rad or m].
        loads: joints to efforts [N·m or N].
        gravity: `(3,)` [m/s²].
        speed: of a single drive [rad/s or m/s].
        samples: count of positions.

    Raises:
        CardanError: as `Scene` and `Scene.sweep` do.
    """
    scene = default_scene(mechanism, drive=drive, held=held, loads=loads, gravity=gravity)
    drives = scene.drives
    if len(drives) > 1:
        return scene.sweep(_out_of_phase(mechanism, drives, samples))
    low, high = _range(scene, mechanism, drives[0])
    if (low, high) != _TURN:
        # A swing reverses its direction, which a constant speed does not.
        return scene.sweep(_swing(low, high, samples), speed=0.0)
    turn = np.linspace(low, high, samples)
    return scene.sweep(turn, speed=preset_of(mechanism).speed if speed is None else speed)


def preset_of(mechanism: Mechanism) -> Preset:
    """Return the preset of a mechanism; of others than the bundled ones, what it says itself."""
    own = Preset(mechanism.independent_coordinates)
    preset = PRESETS.get(mechanism.name, own)
    if all(name in mechanism.drivable for name in (*preset.drive, *preset.held_deg)):
        return preset
    return own  # It shares only its name with the bundled one.


def default_scene(
    mechanism: Mechanism,
    *,
    drive: tuple[str, ...] = (),
    held: Mapping[str, float] | None = None,
    loads: Mapping[str, float] | None = None,
    gravity: ArrayLike | None = None,
) -> Scene:
    """Return the scene of a mechanism, as given or else as its preset says.

    Args:
        mechanism: from `load`.
        drive: driven joints.
        held: joints to positions [rad or m].
        loads: joints to efforts [N·m or N].
        gravity: `(3,)` [m/s²].

    Raises:
        CardanError: as `Scene` does.
    """
    preset = preset_of(mechanism)
    drives = tuple(drive) or preset.drive
    preset_held = {name: np.deg2rad(angle) for name, angle in preset.held_deg.items()}
    return Scene(
        mechanism,
        drive=list(drives),
        held={
            name: float(value)
            for name, value in {**preset_held, **(held or {})}.items()
            if name not in drives
        },
        loads=preset.loads if loads is None else loads,
        gravity=preset.gravity if gravity is None else gravity,
    )


def _range(scene: Scene, mechanism: Mechanism, drive: str) -> tuple[float, float]:
    """Return the range of a single drive; one turn if it has no end."""
    if slides(mechanism, drive):
        return _limits(mechanism, drive)
    try:
        low, high = scene.motion_range()
    except MobilityError:
        return _TURN
    if np.isfinite(low) and np.isfinite(high):
        return float(low), float(high)
    return _TURN


def _limits(mechanism: Mechanism, joint: str) -> tuple[float, float]:
    """Return the limits of a coordinate, or a small swing about zero if it has none."""
    model = mechanism.model
    record = mechanism.joints[joint] if joint in mechanism else None
    if record is not None and record.type in ("revolute", "prismatic"):
        column = model.idx_qs[record.id]
        low = float(model.lowerPositionLimit[column])
        high = float(model.upperPositionLimit[column])
        if np.isfinite(low + high) and high - low < _NO_LIMIT:
            return low, high
    is_slide = slides(mechanism, joint)
    reach = _SLIDE_SWING * mechanism.characteristic_length if is_slide else _ANGLE_SWING
    return -reach, reach


def slides(mechanism: Mechanism, name: str) -> bool:
    """Return whether the coordinate of a joint, or `joint.coordinate`, is a slide.

    Raises:
        ModelError: there is none of this name.
    """
    if name not in mechanism.drivable:
        mechanism.joint(name)
        return False  # It has no single coordinate, which the scene reports.
    return mechanism.drivable[name].slides


def _out_of_phase(mechanism: Mechanism, drives: tuple[str, ...], samples: int) -> Array:
    """Return positions `(samples, d)` of d drives that swing one after the other."""
    turn = np.linspace(0.0, 2.0 * np.pi, samples)
    columns = []
    for index, name in enumerate(drives):
        low, high = _limits(mechanism, name)
        phase = 2.0 * np.pi * index / len(drives)
        columns.append((low + high) / 2.0 + _JOINT_SWING * (high - low) * np.sin(turn + phase))
    return np.stack(columns, axis=1)


def _swing(low: float, high: float, samples: int) -> Array:
    """Return positions that go there and back, clear of the dead points at both ends."""
    turn = np.linspace(0.0, 2.0 * np.pi, samples)
    return np.asarray((low + high) / 2.0 + _SINGLE_SWING * (high - low) * np.sin(turn))
