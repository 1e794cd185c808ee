"""Random bushings through many turns, followed along their way by quaternions of their own.

A chain of hinges, alone or closed to a parallelogram, is driven along a straight line of angles.
Rotations are products of quaternions, their vectors are followed in small steps from zero, and
efforts are slopes of the energy. Nothing of the package is used but what it answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from chains import Builder, placed, rotation, skew, turn, unit

Array = np.ndarray

TURNS = 10.0
"""Whole turns up to which drives are turned."""
SURE = 3.1
"""Rotation [rad] about a changing axis up to which a bushing has to answer."""
STEP = 0.2
"""Greatest angle [rad] between points on the way at which rotations are followed."""


@dataclass(frozen=True, eq=False)
class Wound:
    """A chain of hinges with a bushing between two of its links.

    Attributes:
        text: description.
        axes: `(d, 3)` of the hinges, in world axes at zero.
        links: names of the links, from the world outwards.
        ends: indices of both links of the bushing.
        frame, frame_b: `(3, 3)` its axes in the world at zero, on the first and second link.
        origin, origin_b: `(4, 4)` likewise in the links' frames.
        stiffness: `(6, 6)`, without translation.
        targets: `(N, d)` angles.
    """

    text: str
    axes: Array
    links: tuple[str, ...]
    ends: tuple[int, int]
    frame: Array
    frame_b: Array
    origin: Array
    origin_b: Array
    stiffness: Array
    targets: Array

    def energy(self, turned: Array) -> float:
        """Return the energy at a rotation vector."""
        return float(0.5 * turned @ self.stiffness[3:, 3:] @ turned)

    def vectors(self, angles: Array) -> Array:
        """Return the shortest rotation vectors `(S, 3)` at angles `(S, d)`."""
        first, second = self.ends
        between = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
        for index in range(min(first, second), max(first, second)):
            # Rodrigues, for all angles at once.
            cross, angle = skew(self.axes[index]), angles[:, index, None, None]
            about = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
            between = between @ about
        if first > second:
            between = between.transpose(0, 2, 1)
        return np.array([shortest(item) for item in self.frame.T @ between @ self.frame_b])

    def followed(self, target: Array) -> tuple[Array, bool]:
        """Return the rotation vector that a way in small steps leads to, and whether it is sure.

        It is sure unless the rotation nears half a turn about an axis that changes.
        """
        shares = np.linspace(0.0, 1.0, 2 + int(np.ceil(np.sum(np.abs(target)) / STEP)))
        shorter = self.vectors(shares[:, None] * target)
        vector, greatest = shorter[0], 0.0
        for item in shorter:
            vector = nearest(item, vector)
            greatest = max(greatest, float(np.linalg.norm(vector)))
        long = shorter[np.linalg.norm(shorter, axis=1) > 1e-3]
        spread = np.linalg.norm(np.cross(long, long[:1]), axis=1) if len(long) else np.zeros(1)
        return vector, bool(greatest < SURE or np.max(spread) < 1e-4)

    def efforts(self, target: Array, vector: Array) -> Array:
        """Return the slopes `(d,)` of the energy at the end `vector` of a way."""
        steps = 1e-5 * np.eye(len(target))
        sides = [
            [self.energy(nearest(item, vector)) for item in self.vectors(target + sign * steps)]
            for sign in (1.0, -1.0)
        ]
        return (np.array(sides[0]) - sides[1]) / 2e-5


def nearest(shorter: Array, vector: Array) -> Array:
    """Return, of all vectors of the rotation of a shortest one, the one that is nearest another."""
    size = np.linalg.norm(shorter)
    direction = shorter / size if size > 1e-9 else vector / max(np.linalg.norm(vector), 1e-300)
    count = np.round((vector @ direction - size) / (2.0 * np.pi))
    return shorter + 2.0 * np.pi * count * direction


def shortest(rotated: Array) -> Array:
    """Return the shortest rotation vector of a rotation, by the axis that it leaves as it is."""
    sine = 0.5 * np.array(
        [
            rotated[2, 1] - rotated[1, 2],
            rotated[0, 2] - rotated[2, 0],
            rotated[1, 0] - rotated[0, 1],
        ]
    )
    cosine = 0.5 * (np.trace(rotated) - 1.0)
    angle = np.arctan2(np.linalg.norm(sine), cosine)
    if np.linalg.norm(sine) > 1e-6 or cosine > 0.0:
        return sine * (angle / np.linalg.norm(sine) if np.any(sine) else 1.0)
    axis = np.linalg.eigh(rotated + rotated.T)[1][:, -1]
    return angle * axis * (1.0 if axis @ sine >= 0.0 else -1.0)


def wound(seed: int) -> Wound:
    """Return the chain of a seed."""
    rng = np.random.default_rng([seed, 27])
    builder = Builder()
    count = int(rng.integers(1, 4))
    first = unit(rng.normal(size=3)) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    axes, links = [], ["world"]
    parallel = rng.random() < 0.6
    for index in range(count):
        axis = first * rng.choice([-1.0, 1.0]) if parallel else unit(rng.normal(size=3))
        name = f"b{index}"
        frame = placed(rotation(rng.uniform(-1.5, 1.5, 3)), rng.uniform(-1.0, 1.0, 3))
        builder.link(name, 1.0)
        kind = str(rng.choice(["revolute", "continuous"]))
        builder.joint(f"j{index}", kind, links[-1], name, frame, frame[:3, :3].T @ axis)
        axes.append(axis)
        links.append(name)
    ends = tuple(int(k) for k in rng.choice(count + 1, 2, replace=False))
    about = axes[min(ends)]
    # The bushing's frame lies along the axis, or any way.
    if rng.random() < 0.7:
        across = unit(np.cross(about, np.eye(3)[np.argmin(np.abs(about))]))
        world = np.stack([across, np.cross(about, across), about], axis=1)
    else:
        world = rotation(rng.uniform(-1.5, 1.5, 3))
    turned = world
    if rng.random() < 0.3:
        angle = rng.uniform(-3.0, 3.0)
        is_about = rng.random() < 0.7
        turned = (turn(about, angle) if is_about else rotation(rng.uniform(-1.0, 1.0, 3))) @ world
    stiffness = np.zeros((6, 6))
    stiffness[3:, 3:] = np.diag(rng.uniform(0.5, 2.0, 3))
    if rng.random() < 0.3:
        root = rng.uniform(-1.0, 1.0, (3, 3))
        stiffness[3:, 3:] = root @ root.T
    reach = 2.0 * np.pi * (TURNS if rng.random() < 0.7 else 0.6)
    line = rng.uniform(-1.0, 1.0, count) * reach
    targets = np.sort(rng.uniform(0.0, 1.0, 3))[:, None] * line
    origins = (
        placed(builder.at[links[end]][:3, :3].T @ axes_at_zero, np.zeros(3))
        for end, axes_at_zero in zip(ends, (world, turned), strict=True)
    )
    return Wound(
        builder.chain().text,
        np.array(axes),
        tuple(links),
        (ends[0], ends[1]),
        world,
        turned,
        *origins,
        stiffness,
        targets,
    )
