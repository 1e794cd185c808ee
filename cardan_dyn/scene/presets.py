"""Presets: how the bundled mechanisms are driven, held and loaded unless something else is said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..core.mechanism.mechanism import Mechanism


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
"""By the name of the bundled description."""


def preset_of(mechanism: Mechanism) -> Preset | None:
    """Return the preset of a bundled mechanism; None for others."""
    preset = PRESETS.get(mechanism.name)
    if preset is None or not all(
        name in mechanism.drivable for name in (*preset.drive, *preset.held_deg)
    ):
        return None  # It shares at most its name with the bundled one.
    return preset
