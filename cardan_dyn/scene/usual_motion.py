"""Usual motion: how a mechanism is moved where its user does not say how."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..core.elements.link_loads import Wrench
from ..core.mechanism.mechanism import Mechanism
from ..core.problem.arguments import by_coordinate, keyframe
from ..core.problem.coordinate_names import each_coordinate
from ..core.results.limits import described_limits
from ..core.results.sweep import Sweep
from ..kit.arrays import NOTHING, Array
from ..kit.checks import mapping
from ..kit.errors import (
    AccuracyError,
    AssemblyError,
    MobilityError,
    SingularConfigurationError,
)
from ..kit.quantities import amount, span
from .drives import Drives, drives_of
from .presets import Preset, preset_of
from .scene import Scene

_SLIDE_SWING = 0.05
"""How far a slide without limits moves to both sides, as a fraction of the mechanism's length."""
_ANGLE_SWING = 0.5
"""How far an angle without limits moves to both sides [rad]: clearly visible, and less than most
mechanisms allow."""
_CLEAR = 0.05
"""Part of its range by which a drive stays away from the dead points at its ends, where the scene
would be refused; what is said tells of it. Limits within are gone to."""
_WAY = 100
"""Steps of a way at which it is asked whether loops still close."""


class UsualMotion(NamedTuple):
    """A scene, and positions over the whole range of its drives.

    Attributes:
        scene: the scene.
        positions: `(N,)` of its drive, `(N, d)` of d drives [rad or m].
        turns: whether its only drive turns once, so that its speed may be constant.
        speed: of a single drive that turns [rad/s], as the preset has it.
        said: what moves over which range and why, in one line.
        box: `(d, 2)` range of each drive.
    """

    scene: Scene
    positions: Array
    turns: bool
    speed: float
    said: str
    box: Array

    def sweep(self, speed: float | None = None) -> Sweep:
        """Return the sweep over the positions; a swing is quasi-static, as it reverses its sense.

        Args:
            speed: of a drive that turns [rad/s]; that of the preset if None.
        """
        if not self.turns:
            return self.scene.sweep(self.positions)
        return self.scene.sweep(self.positions, speed=self.speed if speed is None else speed)


def usual_motion(mechanism: Mechanism, *, samples: int = 721, **given: Any) -> UsualMotion:
    """Return how a mechanism moves through its range, as given or else as is usual.

    A single drive turns once, or swings through the range that it has. Several go through theirs
    all together, then each by itself while the others are where they start, as far as loops let
    them: a range is that of the description's limits; without them a turn, or a swing of a slide.

    Args:
        mechanism: from `load`.
        samples: count of positions.
        given: see `default_scene`.

    Raises:
        CardanError: as `Scene` does.
    """
    scene, why = _scene_and_why(mechanism, **given)
    mechanism, drives = scene.mechanism, scene.drives
    speed = (preset_of(mechanism) or Preset()).speed
    if len(drives) > 1:
        return _of_several(scene, samples, speed, why)
    (name,) = drives
    phase = np.linspace(0.0, 2.0 * np.pi, samples)
    found = _range(scene, name)
    if found is None:
        said, box = f"{name} turns once{why}", np.array([[0.0, 2.0 * np.pi]])
        return UsualMotion(scene, phase, True, speed, said, box)
    (low, high), dead = found
    swing = (low + high) / 2.0 + (high - low) / 2.0 * np.sin(phase)
    unit, size = ("m", 1.0) if slides(mechanism, name) else ("°", np.pi / 180.0)
    said = f"{name} moves between {span(low / size, high / size, unit, ' and ')}, there and back"
    if dead:
        points = " and ".join(amount(point / size, unit) for point in dead)
        said += (
            f", {_CLEAR:.0%} of its way short of where loops end it ({points}), towards which "
            "forces may grow without bound"
        )
    return UsualMotion(scene, swing, False, speed, f"{said}{why}", np.array([found[0]]))


def one_way(
    scene: Scene, position: Array, speed: float, efforts: Mapping[str, tuple[float, int]]
) -> dict[str, Array] | None:
    """Return loads `(N,)` of a sweep that act on joints while these move one way.

    Args:
        scene: without them.
        position: of its drives, `(N,)` or `(N, d)` [rad or m].
        speed: of a single drive [rad/s or m/s]; where it is 0, senses are those in which positions
            follow each other.
        efforts: joint to its effort [N·m or N], and whether it acts while the position grows, 1, or
            falls, -1. A joint that stands has no load.

    Returns:
        None if there are no efforts.
    """
    if not efforts:
        return None
    moving = scene.sweep(position, speed or np.gradient(position, axis=0)).motion
    coordinates = scene.mechanism.coordinates
    names = [*scene.drives, *efforts]
    units = coordinates.rate_scale[coordinates.rates_of(names)]
    rates = np.stack([moving.velocity(name) for name in names]) / units[:, None]
    # Beside the drives, the rounding of a speed at a dead point is none.
    still = NOTHING * np.abs(rates[: len(scene.drives)]).max()
    return {
        name: np.where(sense * rate > still, effort, 0.0)
        for (name, (effort, sense)), rate in zip(
            efforts.items(), rates[len(scene.drives) :], strict=True
        )
    }


def driving(swept: Sweep) -> list[str]:
    """Return in a sentence each which constant loads drive their joints over a part of a turn."""
    found = []
    for name, load in swept.loads.items():
        if isinstance(load, Wrench) or np.ptp(load) or not np.any(load):
            continue
        steps = np.diff(swept.motion.position(name))
        if steps.min() < -NOTHING * steps.max() < 0.0:
            against = "backward" if np.all(load > 0.0) else "forward"
            found.append(
                f"The load at {name} drives it on one of its ways; one that acts against it alone "
                f"is --load {name}=…@{against}, in Python a load for each sample."
            )
    return found


def default_scene(mechanism: Mechanism, **given: Any) -> Scene:
    """Return the scene of a mechanism, as given or else as is usual.

    Args:
        mechanism: from `load`.
        given: `drive`, driven joints; with what `held` and the preset hold, or the default of
            `Drives`. `held`, joints to positions [rad or m]. `loads`, joints to efforts [N·m or N]
            and `gravity` `(3,)` [m/s²]; those of the preset if None. `near`, see `Scene`.

    Raises:
        CardanError: as `Scene` does.
    """
    return _scene_and_why(mechanism, **given)[0]


def _scene_and_why(
    mechanism: Mechanism,
    *,
    drive: tuple[str, ...] = (),
    held: Mapping[str, ArrayLike] | None = None,
    loads: Mapping[str, float] | None = None,
    gravity: ArrayLike | str | None = None,
    near: Mapping[str, ArrayLike] | str | None = None,
) -> tuple[Scene, str]:
    """Return the scene, and why its drives were chosen, in brackets; nothing if they were given."""
    preset, why = preset_of(mechanism), ""
    positions, drives = by_coordinate(mechanism, "held", held), each_coordinate(mechanism, drive)
    if preset is not None:
        resting = {name: np.deg2rad(angle) for name, angle in preset.held_deg.items()}
        drives, positions = drives or preset.drive, {**resting, **positions}
    preset = preset or Preset()

    def scene_of() -> Scene:
        return Scene(
            mechanism,
            drive=list(drives),
            held={name: float(value) for name, value in positions.items() if name not in drives},
            loads=preset.loads if loads is None else loads,
            gravity=preset.gravity if gravity is None else gravity,
            near=near or None,
        )

    if drives:
        try:
            return scene_of(), why
        except MobilityError as error:
            if error.mobility is None or error.mobility <= len({*drives, *positions}):
                raise
    found = drives_of(mechanism)
    if not found.default:
        raise MobilityError(
            f"{mechanism.name}: {found.reason}; `cardan-dyn check` says more",
            mobility=found.mobility,
        )
    if not drives:
        why = f" ({found.reason.partition(':')[0]})"
    drives, positions = _completed(found, drives, positions)
    if found.is_moved:
        # What is held elsewhere is brought there from the start.
        start = found.start.positions.items()
        given = mapping("near", keyframe(mechanism, near))
        near = {name: value for name, value in start if name not in positions} | given
    return scene_of(), why


def _completed(
    found: Drives, drives: tuple[str, ...], held: Mapping[str, float]
) -> tuple[tuple[str, ...], dict[str, float]]:
    """Return drives, the default ones if none are given, and held joints, which decide the rest."""
    left = list(found.needed)
    for name in (*drives, *held):
        places = [name, *(found[name].instead_of if name in found else ())]
        place = next((item for item in places if item in left), None)
        if place is not None and (drives or [place] != [*found.default]):
            left.remove(place)
    drives = drives or tuple(name for name in found.default if name in left)
    return drives, {name: found[name].start for name in left if name not in drives} | {**held}


def _range(scene: Scene, drive: str) -> tuple[tuple[float, float], list[float]] | None:
    """Return where a single drive swings, and what ends it is kept clear of; None if it turns."""
    mechanism = scene.mechanism
    is_slide = slides(mechanism, drive)
    loops, limits = np.array(scene.motion_range()), np.array(described_limits(mechanism, drive))
    start = float(scene.solver.assembly.start[mechanism.coordinates.named[drive].column])
    low, high = np.array([max(loops[0], limits[0]), min(loops[1], limits[1])])
    if low >= high:  # A start beyond limits, where loops were closed, from which the way leads on.
        low, high = loops
    if not is_slide and not np.isfinite(low) and not np.isfinite(high):
        return None
    reach = _SLIDE_SWING * mechanism.characteristic_length if is_slide else _ANGLE_SWING
    if not np.isfinite(low):
        low = min(start, high) - reach
    if not np.isfinite(high):
        high = max(start, low) + reach
    ends, inward = np.array([low, high]), np.array([1.0, -1.0])
    clear = _CLEAR * (high - low)
    is_dead, is_near = ends == loops, np.abs(ends - loops) < clear
    if np.any(is_near & ~is_dead):
        try:
            scene.sweep(np.where(is_dead, ends + clear * inward, ends))
        except (AccuracyError, AssemblyError, SingularConfigurationError):
            is_dead = is_near
    low, high = np.where(is_dead, ends + clear * inward, ends).tolist()
    return (low, high), loops[is_dead].tolist()


def slides(mechanism: Mechanism, name: str) -> bool:
    """Return whether the coordinate of a joint, or `joint.coordinate`, is a slide.

    Raises:
        ModelError: there is none of this name.
    """
    if name not in mechanism.drivable:
        mechanism.joint(name)
        return False  # It has no single coordinate, which the scene reports.
    return mechanism.drivable[name].slides


def _of_several(scene: Scene, samples: int, speed: float, why: str) -> UsualMotion:
    """Return how several drives move."""
    mechanism, drives = scene.mechanism, scene.drives
    start = scene.solver.assembly.start[
        [mechanism.coordinates.named[name].column for name in drives]
    ]
    are_slides = np.array([slides(mechanism, name) for name in drives])
    reach = np.where(are_slides, _SLIDE_SWING * mechanism.characteristic_length, np.pi)
    limits = np.array([described_limits(mechanism, name) for name in drives])
    is_limited = np.isfinite(limits).all(axis=1)[:, None]
    box = np.where(is_limited, limits, start[:, None] + reach[:, None] * [-1.0, 1.0])
    # One way after the other: to the upper end, to the lower one, and back to the start.
    which = np.vstack([np.ones(len(drives)), np.eye(len(drives))])
    phase = (np.arange(samples) + 0.5) * len(which) / samples
    way = phase.astype(int)
    wave = np.sin(2.0 * np.pi * (phase - way))[:, None]
    down, up = (side[None] * which for side in (box.T - start))
    down, up = (side * _reached(scene, start, side)[:, None] for side in (down, up))
    positions = start + np.where(wave > 0.0, up[way], -down[way]) * wave
    share = (
        np.abs(up - down)[which > 0.0] / np.broadcast_to(np.ptp(box, axis=1), up.shape)[which > 0.0]
    )
    together, alone = float(share[: len(drives)].min()), float(share[len(drives) :].min())
    if len(drives) > 4:
        listed = f"{', '.join(drives[:3])} and {len(drives) - 3} others"
    else:
        listed = ", ".join(drives)
    said = (
        f"{listed} move there and back, all together over {together:.0%} of their ranges, then "
        f"each by itself over {alone:.0%} of its own at least{why}"
    )
    return UsualMotion(scene, positions, False, speed, said, box)


def _reached(scene: Scene, start: Array, ways: Array) -> Array:
    """Return `(n,)` which part of ways `(n, d)` from the start is clear of dead points."""
    parts = np.linspace(0.0, 1.0, _WAY + 1)
    closes = scene.reachable(start + parts[:, None, None] * ways)
    first = np.where(closes.all(axis=0), _WAY, closes.argmin(axis=0) - 1)
    return np.where(first < _WAY, (1.0 - _CLEAR) * np.maximum(first, 0), first) / _WAY
