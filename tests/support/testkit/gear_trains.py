"""Random gear trains on parallel axes, and the equilibrium of each of their shafts.

Trains are made from pitch radii, from which places and ratios follow; forces of teeth by the rules
of thumb of machine elements: tangential by the torque, radial towards the own axis of an external
gear, axial by the thumb of the hand of its helix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

ARRAY = np.ndarray


def turn(axis: ARRAY, angle: float) -> ARRAY:
    """Return the rotation `(3, 3)` about a unit axis."""
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


@dataclass
class Shaft:
    """A shaft along ±z of the housing: where its joint is, and its mass and inertia about z."""

    place: ARRAY
    sense: float
    mass: float
    lever: float
    inertia: float


@dataclass
class Pair:
    """Teeth between a shaft and the next one: signed pitch radii along the line of centres."""

    radii: tuple[float, float]
    direction: ARRAY
    pressure: float
    helix: float
    height: float


class GearTrain:
    """A train of gears in a housing that a held hinge carries."""

    def __init__(self, rng: np.random.Generator, shafts: int, *, level: bool = False) -> None:
        """Draw a train; of a `level` one all joints and teeth lie in one plane."""
        self.shafts: list[Shaft] = []
        self.pairs: list[Pair] = []
        place = np.zeros(3)
        for index in range(shafts):
            if index:
                external = rng.random() < 0.6
                first, second = np.sort(rng.uniform(0.02, 0.2, 2) * (1.0, 1.5))
                if rng.random() < 0.5:
                    first, second = second, first
                angle = rng.uniform(0.0, 2.0 * np.pi)
                direction = np.array([np.cos(angle), np.sin(angle), 0.0])
                # The pitch point seen from both axes; inside the greater one of an internal pair.
                towards = 1.0 if external or first > second else -1.0
                radii = towards * first, -towards * second if external else towards * second
                place = place + (radii[0] - radii[1]) * direction
                pressure, helix = rng.uniform(0.2, 0.5), rng.uniform(-0.6, 0.6)
                height = 0.0 if level else rng.uniform(-0.1, 0.1)
                self.pairs.append(Pair(radii, direction, pressure, helix, height))
            place = place.copy()
            place[2] = 0.0 if level else rng.uniform(-0.1, 0.1)
            self.shafts.append(
                Shaft(
                    place,
                    float(rng.choice([-1.0, 1.0])),
                    rng.uniform(1.0, 5.0),
                    rng.uniform(-0.1, 0.1),
                    rng.uniform(0.001, 0.01),
                )
            )
        axis = rng.normal(size=3)
        self.axis = axis / np.linalg.norm(axis)
        self.held = float(rng.uniform(-2.0, 2.0))
        self.load = float(rng.uniform(-50.0, 50.0))
        self.force, self.point = rng.uniform(-100.0, 100.0, 3), rng.uniform(-0.1, 0.1, 3)
        self.gravity = rng.uniform(-10.0, 10.0, 3)
        self.speed, self.acceleration = rng.uniform(-5.0, 5.0, 2).tolist()
        self.forces = "mesh"

    def ratio(self, index: int) -> float:
        """Return the ratio of the joints' angles of a pair."""
        one, other = self.shafts[index : index + 2]
        first, second = self.pairs[index].radii
        return float(one.sense * other.sense * first / second)

    def urdf(self) -> str:
        """Return the description."""
        words = lambda values: " ".join(map(repr, map(float, values)))  # noqa: E731
        lines = [
            '<robot name="train"><link name="ground"/><link name="housing"/>',
            '<joint name="base" type="continuous"><parent link="ground"/><child link="housing"/>'
            f'<axis xyz="{words(self.axis)}"/></joint>',
        ]
        for k, shaft in enumerate(self.shafts):
            about = 0.6 * shaft.inertia
            lines.append(
                f'<link name="shaft_{k}"><inertial><origin xyz="0 0 {shaft.lever!r}"/>'
                f'<mass value="{shaft.mass!r}"/><inertia ixx="{about!r}" iyy="{about!r}" '
                f'izz="{shaft.inertia!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
                f'<joint name="j{k}" type="continuous"><parent link="housing"/>'
                f'<child link="shaft_{k}"/><origin xyz="{words(shaft.place)}"/>'
                f'<axis xyz="0 0 {shaft.sense!r}"/></joint>'
            )
        for k, pair in enumerate(self.pairs):
            along = float(self.shafts[k].sense * (pair.height - self.shafts[k].place[2]))
            stated = (
                f'forces="mesh" pressure_angle="{pair.pressure!r}" helix_angle="{pair.helix!r}" '
                f'along="{along!r}"'
            )
            lines.append(
                f'<coupling name="m{k}" {stated if self.forces == "mesh" else self.forces}>'
                f'<predecessor link="shaft_{k}"/><successor link="shaft_{k + 1}"/>'
                f'<ratio value="{self.ratio(k)!r}"/></coupling>'
            )
        return "\n".join([*lines, "</robot>"])

    def scene(self, cd: Any, **more: Any) -> Any:
        """Return the scene: the first shaft drives, the last one bears a torque and a force."""
        last = len(self.shafts) - 1
        loads = {
            f"j{last}": self.load,
            f"shaft_{last}": cd.Wrench(force=self.force, frame="world", point=self.point),
        }
        held = {"base": self.held}
        description = cd.load(self.urdf())
        return cd.Scene(
            description, drive="j0", held=held, loads=loads, gravity=self.gravity, **more
        )

    def wrenches(self, position: float) -> dict[str, ARRAY]:
        """Return joint to force and moment `(2, 3)` about its origin in world axes.

        All that the housing exerts on each shaft, and the ground on the housing; and by `m0` … the
        moments of the couplings on their successors' joints.
        """
        housing = turn(self.axis, self.held)
        z = np.array([0.0, 0.0, 1.0])
        gravity, force = housing.T @ self.gravity, housing.T @ self.force
        angles, alphas = (
            [position * self.shafts[0].sense],
            [self.acceleration * self.shafts[0].sense],
        )
        for pair in self.pairs:
            rolled = pair.radii[0] / pair.radii[1]
            angles.append(angles[-1] * rolled)
            alphas.append(alphas[-1] * rolled)
        found: dict[str, ARRAY] = {}
        # On each shaft: what it needs, less what acts; teeth from the last shaft to the first.
        passed = np.zeros((2, 3))  # By the teeth behind a shaft, about the housing's origin.
        last = len(self.shafts) - 1
        for k in range(last, -1, -1):
            shaft = self.shafts[k]
            centre = shaft.place + shaft.lever * z
            acting = np.array([shaft.mass * gravity, np.cross(centre, shaft.mass * gravity)])
            acting += passed
            torque = 0.0
            if k == last:
                at = shaft.place + turn(z, angles[k]) @ self.point
                acting += np.array([force, np.cross(at, force)])
                torque = shaft.sense * self.load
            needed = np.array([np.zeros(3), shaft.inertia * alphas[k] * z])
            if k:
                pair = self.pairs[k - 1]
                # Axial moments of these about the shaft's own axis, which bearings do not bear.
                about = acting[1] - np.cross(shaft.place, acting[0])
                on_shaft = float(needed[1] @ z - about @ z - torque)
                found[f"m{k - 1}"] = np.array(shaft.sense * on_shaft)
                teeth = self._teeth(k - 1, on_shaft)
                acting += teeth
                passed = -teeth
            total = needed - acting
            moment = total[1] - np.cross(shaft.place, total[0])
            found[f"j{k}"] = np.array([housing @ total[0], housing @ moment])
        everything = [
            (found[f"j{k}"], housing @ shaft.place) for k, shaft in enumerate(self.shafts)
        ]
        found["base"] = np.array(
            [
                sum(wrench[0] for wrench, _ in everything),
                sum(wrench[1] + np.cross(place, wrench[0]) for wrench, place in everything),
            ]
        )
        return found

    def _teeth(self, index: int, torque: float) -> ARRAY:
        """Return what the teeth of a pair exert on its second shaft, about the housing's origin."""
        pair, one = self.pairs[index], self.shafts[index]
        first, second = pair.radii
        z = np.array([0.0, 0.0, 1.0])
        point = np.array([*one.place[:2], pair.height]) + first * pair.direction
        tangential = torque / second * np.cross(z, pair.direction)
        size = abs(torque / second)
        # Of an external gear: the second one, unless it is the ring around the first one.
        is_ring = first * second > 0.0 and abs(second) > abs(first)
        own, torque_on, hand = second, torque, 1.0 if first * second > 0.0 else -1.0
        if is_ring:
            own, torque_on, hand = first, -torque * first / second, 1.0
        inwards = -np.sign(own) * pair.direction
        radial = size * np.tan(pair.pressure) / np.cos(pair.helix) * inwards
        # A right-hand helix that drives is pushed as the thumb of the right hand points.
        axial = -torque_on / abs(own) * np.tan(hand * pair.helix) * z
        if is_ring:
            radial, axial = -radial, -axial
        force = tangential + radial + axial
        return np.array([force, np.cross(point, force)])
