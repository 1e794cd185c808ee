"""Rigid start: where a simulation of clearance begins, by the mechanism without clearance."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array
from ..checks import mapping, number, positive
from ..errors import ArgumentError, IndeterminateError, choices
from .arguments import drive_of, period_of, pins_of, scene_of, speed_of
from .determinate import what_is_open
from .force_source import across
from .opened_joint import OpenedJoint, mean_positions
from .opened_scene import Opened, OpenPin

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
        reach: joints whose pin has two bearings to their distance from its origin [m].
    """

    def __init__(
        self,
        scene: Scene,
        speed: Any,
        joints: str | Collection[str],
        position: Any = None,
        bearings: Any = None,
        rotor: Any = None,
    ) -> None:
        """Check what is asked for.

        Args:
            scene: with one drive.
            speed: of it [rad/s].
            joints: that have play.
            position: of the drive [rad]; where all forces are far from a reversal if None.
            bearings: see `reach`.
            rotor: inertia that turns with the drive [kg m²]; None if its motion is prescribed.

        Raises:
            ArgumentError: the speed is zero, there are several drives, or no joints.
            ModelError: a joint has no pin.
        """
        self._scene, self._rotor, self.speed = scene_of(scene), rotor, speed_of(speed)
        self._period = period_of(scene.solver)
        if joints is None:
            raise ArgumentError("joints is None; name those that have clearance")
        self.joints, _ = pins_of(scene.problem, joints)
        self.reach = self._reach(bearings)
        self.position = self._steady() if position is None else number("position", position)

    def _reach(self, bearings: Any) -> dict[str, float]:
        """Return the distances of bearings from the origins of joints.

        Raises:
            ArgumentError: one is not positive, or of a joint that has no play.
        """
        given = mapping("bearings", bearings)
        for name in given:
            if name not in self.joints:
                raise ArgumentError(
                    f"bearings names joint {name!r}, which has no clearance; joints: "
                    f"{choices(self.joints)}"
                )
        return {name: positive(f"bearings[{name!r}]", value) for name, value in given.items()}

    def _steady(self) -> float:
        """Position of the drive at which all forces are far from a reversal [rad]."""
        positions = self._period / _SEARCHED * np.arange(_SEARCHED)
        sweep = self._scene.sweep(positions, self.speed)
        least = np.ones(_SEARCHED)
        for name in self.joints:
            sizes = np.linalg.norm(self._force(sweep, name, self.reach.get(name)), axis=1)
            if np.any(sizes > 0.0):
                least = np.minimum(least, sizes / np.max(sizes))
        return float(positions[np.argmax(least)])

    def reduced_mass(self, name: str) -> float:
        """Return the mass by which a scan means the damping ratio of a joint [kg].

        Raises:
            IndeterminateError: the force is statically indeterminate.
        """
        scene = self._scene
        fixed, rotors = drive_of(scene.problem, self._rotor)
        sweep = scene.sweep(mean_positions(self._period), self.speed)
        if reason := what_is_open(scene.solver, sweep, name):
            raise IndeterminateError(
                f"damping_ratio of joint {name!r}: {reason}, or give law=LinearContact(stiffness, "
                "damping) instead"
            )
        opened = OpenedJoint(scene.mechanism, name, fixed, rotors)
        return opened.mean_mass(sweep.motion._x, across(sweep, name))

    def state(self, opened: Opened, pins: Sequence[OpenPin], *, is_free: bool) -> dict[str, Any]:
        """Return where and how fast a simulation begins, as `Scene.simulate` takes it.

        Args:
            opened: the scene with open joints.
            pins: of the joints.
            is_free: whether nobody moves the drive.
        """
        begun = self._slides(opened.scene.mechanism, pins)
        free = {name: begun[name] for name in opened.scene.coordinates if name != opened.drive}
        positions = {opened.drive: self.position, **{name: at for name, (at, _) in free.items()}}
        speeds = {name: rate for name, (_, rate) in free.items()}
        if is_free:
            return {"position": positions, "speed": {opened.drive: self.speed, **speeds}}
        return {"position": positions, "speed": speeds, "motion": {opened.drive: self.speed}}

    def _slides(self, opened: Mechanism, pins: Sequence[OpenPin]) -> dict[str, tuple[float, float]]:
        """Return positions and speeds of the slides and tilts of open joints by name.

        Those whose force is not unique begin in the middle of the play, at rest.

        Args:
            opened: the mechanism with open joints.
            pins: of the joints.
        """
        sweep = self._scene.sweep(self.position + _STEP * np.array([-1.0, 0.0, 1.0]), self.speed)
        result: dict[str, tuple[float, float]] = {}
        for item in pins:
            places = self._places(sweep, opened, item)
            rates = (places[2] - places[0]) * (self.speed / (2.0 * _STEP))
            moving = zip(places[1].tolist(), rates.tolist(), strict=True)
            result.update(zip(opened.joint(item.joint).coordinates[:-1], moving, strict=True))
        return result

    def _places(self, sweep: Any, opened: Mechanism, pin: OpenPin) -> Array:
        """Return the places `(N, k)` of a pin along its slides and tilts where walls bear it."""
        force = self._force(sweep, pin.joint, pin.reach)
        sizes = np.linalg.norm(force, axis=1)
        parts = opened.joint(pin.joint).parts
        result = np.zeros((len(force), len(parts) - 1))
        if not np.all(sizes > 0.0):
            return result
        # The wall pushes the pin back, into the middle.
        away = -force / sizes[:, None]
        depths = np.array([_depth(pin, size) for size in sizes.tolist()])
        offsets = away * (0.5 * pin.clearance + depths)[:, None]
        axis, angles = parts[-1].axis, np.asarray(sweep.motion.position(pin.joint))
        child = np.asarray(sweep.rotation(pin.joint))
        for k in range(len(force)):
            bush = child[k] @ _turn(axis, -float(angles[k]))
            if pin.reach is None:
                result[k] = [offsets[k] @ (bush @ part.axis) for part in parts[:2]]
                continue
            tilt = np.cross(bush @ axis, offsets[k]) / pin.reach
            result[k, 2:] = [tilt @ (bush @ part.axis) for part in parts[2:4]]
        return result

    def _force(self, sweep: Any, name: str, reach: float | None) -> Array:
        """Return the force `(N, 3)` on a pin, or on its first bearing, in the world [N].

        Of two bearings, it is that of the moment that both exert, F = (m × a) / (2 r). Where it is
        not unique, it is zero.

        Args:
            sweep: without play.
            name: of the joint.
            reach: of its bearings, see `OpenPin`.
        """
        none = np.zeros((len(sweep), 3))
        if reach is None:
            return none if what_is_open(self._scene.solver, sweep, name) else across(sweep, name)
        joint = sweep.mechanism.joint(name)
        beside = np.abs(joint.parts[0].axis) < 1.0 - 1e-9
        if not np.all(sweep[name].unique[3:][beside]):
            return none
        axis = sweep.rotation(name) @ joint.parts[0].axis
        moment = np.asarray(sweep.wrench(name, "world").moment)
        return np.asarray(np.cross(moment, axis) / (2.0 * reach))


def _depth(pin: OpenPin, force: float) -> float:
    """Return how deep a force presses a pin into its wall [m]."""
    from scipy.optimize import brentq

    def excess(depth: float) -> float:
        return float(pin.law.force(depth, 0.0, np.inf)) - force

    deepest = pin.clearance
    while excess(deepest) < 0.0:
        deepest *= 2.0
        if deepest > _DEEPEST * pin.clearance:
            raise ArgumentError(
                f"joint {pin.joint!r}: its force of {force:.3g} N presses the pin farther "
                f"into the wall than {_DEEPEST:g} times the clearance; its contact is too soft"
            )
    return float(brentq(excess, 0.0, deepest, xtol=1e-18))


def _turn(axis: Array, angle: float) -> Array:
    """Return the rotation about a unit axis."""
    x, y, z = axis.tolist()
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * (skew @ skew))
