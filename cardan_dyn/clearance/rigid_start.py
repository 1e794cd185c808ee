"""Rigid start: where a simulation of play begins, by the mechanism without play."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..errors import ArgumentError
from .arguments import period_of, pins_of, single, speed_of
from .force_source import across, what_is_open
from .opened_joint import OpenedJoint
from .opened_scene import Opened, Play

if TYPE_CHECKING:
    from ..mechanism.mechanism import Mechanism
    from ..scene.scene import Scene

_SEARCHED = 180
"""Positions over a period among which it begins."""
_STEP = 1e-4
"""Way of the drive [rad] over which the motion of pins along their walls is differentiated."""
_DEEPEST = 1e3
"""Greatest depth, as a multiple of the play, at which a wall is looked for that bears the force."""


class RigidStart:
    """The mechanism without play, as it moves where a simulation begins.

    Attributes:
        joints: names of the joints that have play.
        speed: of the drive [rad/s].
        position: of the drive [rad].
    """

    def __init__(
        self, scene: Scene, speed: Any, joints: str | Collection[str], position: Any = None
    ) -> None:
        """Check what is asked for.

        Args:
            scene: with one drive.
            speed: of it [rad/s].
            joints: that have play.
            position: of the drive [rad]; where all forces are far from a reversal if None.

        Raises:
            ArgumentError: the speed is zero, there are several drives, or no joints.
            ModelError: a joint has no pin.
        """
        self._scene, self.speed = scene, speed_of(speed)
        self._period = period_of(scene._solver)
        self.joints, _ = pins_of(scene._problem, joints)
        if not self.joints:
            raise ArgumentError("joints is empty; name those that have play")
        if len(set(self.joints)) < len(self.joints):
            raise ArgumentError("joints names a joint twice")
        self.position = self._steady() if position is None else single("position", position)

    def _steady(self) -> float:
        """Position of the drive at which all forces are far from a reversal [rad]."""
        positions = self._period / _SEARCHED * np.arange(_SEARCHED)
        sweep = self._scene.sweep(positions, self.speed)
        least = np.ones(_SEARCHED)
        for name in self.joints:
            if not what_is_open(sweep, name):
                sizes = np.linalg.norm(across(sweep, name), axis=1)
                least = np.minimum(least, sizes / (np.max(sizes) or 1.0))
        return float(positions[np.argmax(least)])

    def reduced_mass(self, name: str) -> float:
        """Return the mass that moves when the force of a joint does, its drive prescribed [kg]."""
        scene = self._scene
        coordinates = scene.mechanism.coordinates
        fixed = coordinates.rates_of([*scene.drives, *scene.held])
        sweep = scene.sweep(np.array([self.position]), self.speed)
        mobility = OpenedJoint(scene.mechanism, name, fixed, {}).mobility(sweep.motion._x[0])
        force = across(sweep, name)[0]
        direction = force if np.any(force) else mobility.axes[0]
        return mobility.reduced_mass(direction)

    def state(self, opened: Opened, plays: Sequence[Play], *, is_free: bool) -> dict[str, Any]:
        """Return where and how fast a simulation begins, as `Scene.simulate` takes it.

        Args:
            opened: the scene with open joints.
            plays: of the joints.
            is_free: whether nobody moves the drive.
        """
        begun = self._slides(opened.scene.mechanism, plays)
        free = {name: begun[name] for name in opened.scene.drives if name != opened.drive}
        positions = {opened.drive: self.position, **{name: at for name, (at, _) in free.items()}}
        speeds = {name: rate for name, (_, rate) in free.items()}
        if is_free:
            return {"position": positions, "speed": {opened.drive: self.speed, **speeds}}
        return {"position": positions, "speed": speeds, "motion": {opened.drive: self.speed}}

    def _slides(self, opened: Mechanism, plays: Sequence[Play]) -> dict[str, tuple[float, float]]:
        """Return positions and speeds of the slides and tilts of open joints by name.

        Those whose force is not unique, and pins with two bearings, begin in the middle of the
        play, at rest.

        Args:
            opened: the mechanism with open joints.
            plays: of the joints.
        """
        sweep = self._scene.sweep(self.position + _STEP * np.array([-1.0, 0.0, 1.0]), self.speed)
        result: dict[str, tuple[float, float]] = {}
        for item in plays:
            slides = [f"{item.joint}.slide_1", f"{item.joint}.slide_2"]
            result.update(dict.fromkeys(opened.joint(item.joint).coordinates[:-1], (0.0, 0.0)))
            if item.reach is not None or what_is_open(sweep, item.joint):
                continue
            force = across(sweep, item.joint)
            places = self._offsets(sweep, opened, item, force)
            rates = (places[2] - places[0]) * (self.speed / (2.0 * _STEP))
            moving = zip(places[1].tolist(), rates.tolist(), strict=True)
            result.update(zip(slides, moving, strict=True))
        return result

    @staticmethod
    def _offsets(sweep: Any, opened: Mechanism, play: Play, force: Array) -> Array:
        """Return the places `(N, 2)` of a pin along its slides at which the wall bears forces."""
        sizes = np.linalg.norm(force, axis=1)
        if not np.all(sizes > 0.0):
            return np.zeros((len(force), 2))
        # The wall pushes the pin back, into the middle.
        away = -force / sizes[:, None]
        depths = np.array([_depth(play, size) for size in sizes.tolist()])
        offsets = away * (0.5 * play.play + depths)[:, None]
        parts = opened.joint(play.joint).parts
        axis, angles = parts[-1].axis, np.asarray(sweep.motion.position(play.joint))
        child = np.asarray(sweep.rotation(play.joint))
        result = np.empty((len(force), 2))
        for k in range(len(force)):
            parent = child[k] @ _turn(axis, -float(angles[k]))
            result[k] = [offsets[k] @ (parent @ part.axis) for part in parts[:2]]
        return result


def _depth(play: Play, force: float) -> float:
    """Return how deep a force presses a pin into its wall [m]."""
    from scipy.optimize import brentq

    def excess(depth: float) -> float:
        return float(play.law.force(depth, 0.0, np.inf)) - force

    deepest = play.play
    while excess(deepest) < 0.0:
        deepest *= 2.0
        if deepest > _DEEPEST * play.play:
            raise ArgumentError(
                f"joint {play.joint!r}: its force of {force:.3g} N presses the pin farther into "
                f"the wall than {_DEEPEST:g} times the play; its contact is too soft"
            )
    return float(brentq(excess, 0.0, deepest, xtol=1e-18))


def _turn(axis: Array, angle: float) -> Array:
    """Return the rotation about a unit axis."""
    x, y, z = axis.tolist()
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * (skew @ skew))
