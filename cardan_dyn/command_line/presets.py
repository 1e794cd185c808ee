"""What `cardan-dyn view` shows when nothing else is asked for."""

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

_SWING = 0.05
"""How far a slide without limits moves, as a fraction of the mechanism's length."""


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
        tuple(f"leg_{number}" for number in range(1, 7)), gravity=(0.0, 0.0, -9.81)
    ),
}
"""Bundled descriptions; any other one is driven where its author says."""


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
    """Move a mechanism through its range, with what is given or else what suits it.

    One drive turns once, or swings through the range that it has; several move in turn, each
    within its limits.

    Args:
        mechanism: from `load`.
        drive: driven joints.
        held: joints to positions [rad or m].
        loads: joints to efforts [N·m or N].
        gravity: `(3,)` [m/s²].
        speed: of a single drive [rad/s or m/s].
        samples: number of positions.

    Raises:
        CardanError: as `Scene` and `Scene.sweep` do.
    """
    preset = PRESETS.get(mechanism.name, Preset(mechanism.independent_joints))
    if not all(name in mechanism.joints for name in (*preset.drive, *preset.held_deg)):
        preset = Preset(mechanism.independent_joints)  # Another mechanism of the same name.
    chosen = tuple(drive) or preset.drive
    known = {name: np.deg2rad(angle) for name, angle in preset.held_deg.items()}
    positions_held = {
        name: float(value)
        for name, value in {**known, **(held or {})}.items()
        if name not in chosen
    }
    scene = Scene(
        mechanism,
        drive=list(chosen),
        held=positions_held,
        loads=preset.loads if loads is None else loads,
        gravity=preset.gravity if gravity is None else gravity,
    )
    if len(chosen) == 1:
        low, high = _range(scene, mechanism, chosen[0])
        positions = _swing(low, high, samples)
        if low == 0.0 and high == 2.0 * np.pi:
            positions = np.linspace(low, high, samples)
        else:
            speed = 0.0  # A swing turns round, which a constant speed does not.
        return scene.sweep(positions, speed=preset.speed if speed is None else speed)
    columns = []
    for number, name in enumerate(chosen):
        low, high = _limits(mechanism, name)
        phase = 2.0 * np.pi * number / len(chosen)
        turn = np.linspace(0.0, 2.0 * np.pi, samples)
        middle, half = (low + high) / 2.0, 0.3 * (high - low)
        columns.append(middle + half * np.sin(turn + phase))
    return scene.sweep(np.stack(columns, axis=1))


def _range(scene: Scene, mechanism: Mechanism, drive: str) -> tuple[float, float]:
    if mechanism.joints[drive].type == "prismatic":
        return _limits(mechanism, drive)
    try:
        low, high = scene.motion_range()
    except MobilityError:
        return 0.0, 2.0 * np.pi
    if np.isfinite(low) and np.isfinite(high):
        return float(low), float(high)
    return 0.0, 2.0 * np.pi


def _limits(mechanism: Mechanism, joint: str) -> tuple[float, float]:
    """Return the limits of a joint's coordinate, or a small swing about zero if it has none."""
    record, model = mechanism.joint(joint), mechanism.model
    column = model.idx_qs[record.id]
    low = float(model.lowerPositionLimit[column])
    high = float(model.upperPositionLimit[column])
    reach = 0.5 if record.type != "prismatic" else _SWING * mechanism.characteristic_length
    if record.type == "continuous" or not (np.isfinite(low + high) and high - low < 1e3):
        return -reach, reach
    return low, high


def _swing(low: float, high: float, samples: int) -> Array:
    """Return positions that go forth and back, clear of the dead points at both ends."""
    turn = np.linspace(0.0, 2.0 * np.pi, samples)
    return np.asarray((low + high) / 2.0 + 0.45 * (high - low) * np.sin(turn))
