"""Rotating scene: a scene with one drive at constant speed, and free coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ....core.elements.element import Element
from ....core.elements.link_loads import Wrench
from ....kit.arrays import Array
from ....kit.checks import described, several
from ....kit.errors import ArgumentError, CardanError, MobilityError, ModelError, choices
from ....scene.scene import Scene


@dataclass(frozen=True, eq=False)
class RotatingScene:
    """A scene whose drive turns at constant speed while its free coordinates vibrate.

    Attributes:
        scene: with one drive.
        driven: the same with all coordinates driven, the drive first, so that efforts can be solved
            at any state.
        period: way of the drive after which the mechanism repeats, its free coordinates at rest
            [rad].
    """

    scene: Scene
    driven: Scene
    period: float

    @property
    def drive(self) -> str:
        """Name of the coordinate that turns at constant speed."""
        return self.scene.drives[0]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free coordinates."""
        return self.scene.free

    @property
    def units(self) -> Array:
        """Units of the free coordinates `(n,)`: 1 rad, or the characteristic length [m]."""
        mechanism = self.scene.mechanism
        return np.array(
            [
                mechanism.characteristic_length if mechanism.coordinates.named[name].slides else 1.0
                for name in self.free
            ]
        )

    @property
    def start(self) -> Array:
        """Positions `(1 + n,)` of drive and free coordinates at which the scene starts."""
        mechanism, x = self.scene.mechanism, self.scene.solver.assembly.start
        return np.asarray(x[mechanism.coordinates.columns_of(self.scene.coordinates)])

    @property
    def damping(self) -> list[Element]:
        """Elements that exert what depends on speeds."""
        return [element for element in self.scene.elements if element.damps]


def all_driven(scene: Scene) -> Scene:
    """Return a scene in which free coordinates are driven, after the others."""
    return scene.replace(drive=scene.coordinates)


def rotating_scene(scene: Scene) -> RotatingScene:
    """Return a scene as one that rotates.

    Args:
        scene: with one drive, which turns at constant speed, and free coordinates.

    Raises:
        ArgumentError: no scene, nothing periodic, dry friction, an actuator that
            follows a function of time, or loads of several values.
        MobilityError: nothing is free, or there is not exactly one drive.
        ModelError: no body has mass.
    """
    from ....scene.scene import Scene  # Known to who has one.

    if not isinstance(scene, Scene):
        raise ArgumentError(
            f"scene is {described(scene)}, expected a Scene that says what turns and what is free: "
            "Scene(mechanism, drive=…, free=[…], elements=springs)"
        )
    if not scene.free:
        raise MobilityError(
            f"nothing is free to vibrate; driven: {choices(scene.drives)}. Name what is free, and "
            "one drive that turns: Scene(mechanism, drive=…, free=[…])",
            mobility=0,
        )
    if len(scene.drives) != 1:
        driven = choices(scene.drives) if scene.drives else "none"
        raise MobilityError(
            f"a vibration takes one drive, which turns at constant speed; driven: {driven}; free: "
            f"{choices(scene.free)}. Hold the others, or leave them free",
            mobility=len(scene.drives),
        )
    for element in scene.elements:
        _refuse(element)
    for name, load in scene.loads.items():
        sizes = (
            (np.size(load.force), np.size(load.moment))
            if isinstance(load, Wrench)
            else (3 * np.size(load), 3)
        )
        if sizes != (3, 3):
            raise ArgumentError(f"loads[{name!r}] has several values; a vibration takes one")
    if not scene.solver.has_mass:
        raise ModelError(f"{scene.mechanism.name}: no body has mass, so that nothing vibrates")
    return RotatingScene(scene, all_driven(scene), _period(scene))


def _period(scene: Scene) -> float:
    """Return the way of the drive after which the mechanism repeats [rad]."""
    drive = scene.drives[0]
    advice = "a vibration takes a drive that turns through, as a shaft does"
    columns = scene.mechanism.coordinates.columns_of(scene.free)
    places = scene.solver.assembly.start[columns].tolist()
    rest = dict(zip(scene.free, places, strict=True))
    alone = scene.replace(
        held=rest,
        near={name: value for name, value in scene.near.items() if name not in rest},
    )
    try:
        period = alone.solver.assembly.period()
    except CardanError as error:
        raise ArgumentError(f"drive {drive!r} has no period ({error}); {advice}") from error
    if period is None:
        raise ArgumentError(f"drive {drive!r} does not come back to itself; {advice}")
    return float(period)


def speeds_of(value: Any) -> tuple[Array, bool]:
    """Return speeds `(S,)` of the drive, and whether a single number was given.

    Raises:
        ArgumentError: not numeric, not finite, zero, or of more than one dimension.
    """
    if callable(value):
        raise ArgumentError(
            "speed is a function; a periodic motion needs a drive that is held at constant speed. "
            "vibration.run_up and Scene.simulate(motion=…) follow a drive that speeds up"
        )
    speeds = several("speed", value)
    if np.any(speeds == 0.0):
        raise ArgumentError(
            "speed is 0; at rest, Scene.equilibrium says what a scene does. Let a range begin a "
            "little above"
        )
    return speeds, not np.ndim(value)


def _refuse(element: Element) -> None:
    """Refuse elements whose efforts are not smooth, or depend on time."""
    if element.jump:
        raise ArgumentError(element.jump)
    if element.follows_time:
        where = " and ".join(map(repr, element.joints or element.links))
        raise ArgumentError(
            f"the effort of the actuator at {where} is a function of time; a vibration takes a "
            "constant one, or one that follows the position of its joint (of='position') or the "
            "distance of its points (of='length'). Use Scene.simulate for functions of time"
        )
