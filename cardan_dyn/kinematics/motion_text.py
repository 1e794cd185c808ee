"""Motion text: which links a motion moves and how, in words for messages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio

from ..arrays import Array
from ..errors import choices
from ..mechanism.mechanism import Mechanism
from .structure import displacement, unit_twists

_SAME = 1e-6
"""Difference of twists, relative to the fastest link of a motion, up to which links move alike, or
rest. Rates of closed configurations are exact to 1e-9 and better where messages describe them."""
_MOST_SETS = 3
"""Sets of links that move alike which a message describes unless it has others to describe."""
_DIGITS = 3
"""Digits of points and directions in a message: enough to find them in a drawing."""


class _Alike(NamedTuple):
    """Links that move as one rigid body.

    Attributes:
        names: of the links.
        twist: `(6,)` linear part at the world's origin, then angular part, in world axes.
        origin: `(3,)` of the first link, in the world.
    """

    names: list[str]
    twist: Array
    origin: Array


def motion_text(mechanism: Mechanism, x: Array, motion: Array, most: int | None = None) -> str:
    """Return in words which links a motion moves, and how.

    Args:
        mechanism: the mechanism.
        x: `(size,)` closed coordinates.
        motion: `(nv,)` joint rates, slides in lengths of the mechanism.
        most: how many sets of links that move alike are described; the others are counted.
    """
    most = most or _MOST_SETS
    sets = sorted(_alike(mechanism, x, motion), key=lambda item: -len(item.names))
    texts = [_text(item, mechanism.characteristic_length) for item in sets[:most]]
    others = sum(len(item.names) for item in sets[most:])
    if others:
        texts.append(f"{others} more {'link' if others == 1 else 'links'} with them")
    return ", ".join(texts) if texts else "no link"


def _alike(mechanism: Mechanism, x: Array, motion: Array) -> list[_Alike]:
    """Return the links that a motion moves, those together that move alike."""
    poses, twists = _bodies(mechanism, x, motion)
    weights = np.repeat([1.0 / mechanism.characteristic_length, 1.0], 3)
    sets: list[_Alike] = []
    moving = []
    for name, (body, placement) in mechanism.links.items():
        origin = np.array((poses[body] * placement).translation)
        # Speeds of the link's own origin: about the world's, rest could not be told from motion
        # where a mechanism is far away.
        twist = twists[body].copy()
        twist[:3] += np.cross(twist[3:], origin)
        moving.append((name, body, origin, np.max(np.abs(twist * weights))))
    fastest = max((speed for *_, speed in moving), default=0.0)
    for name, body, origin, speed in moving:
        if speed <= _SAME * fastest:
            continue
        for item in sets:
            difference = twists[body] - item.twist
            difference[:3] += np.cross(difference[3:], item.origin)
            if np.max(np.abs(difference * weights)) <= _SAME * fastest:
                item.names.append(name)
                break
        else:
            sets.append(_Alike([name], twists[body], origin))
    return sets


def _bodies(
    mechanism: Mechanism, x: Array, motion: Array
) -> tuple[list[pinocchio.SE3], list[Array]]:
    """Return placements and twists `(6,)` of all bodies, by plain forward kinematics."""
    model, coordinates = mechanism.model, mechanism.coordinates
    poses, twists = [pinocchio.SE3.Identity()], [np.zeros(6)]
    for part, start in sorted(
        zip(coordinates.parts, coordinates.starts, strict=True), key=lambda item: item[0].id
    ):
        parent, first = model.parents[part.id], model.idx_vs[part.id]
        moved = displacement(part, x[start : start + 4])
        pose = poses[parent] * model.jointPlacements[part.id] * moved
        units = unit_twists(part, mechanism.characteristic_length)
        own = pose.action @ (units.T @ motion[first : first + part.nv])
        poses.append(pose)
        twists.append(twists[parent] + own)
    return poses, twists


def _text(item: _Alike, length: float) -> str:
    """Return how a set of links moves."""
    several = len(item.names) > 1
    who = f"links {choices(item.names)}" if several else f"link {item.names[0]!r}"
    linear, angular = item.twist[:3], item.twist[3:]
    at_origin = linear + np.cross(angular, item.origin)
    rate = float(np.linalg.norm(angular))
    if rate * length <= _SAME * float(np.linalg.norm(at_origin)):
        return f"{who} {'slide' if several else 'slides'} along {_direction(at_origin)}"
    axis = angular / rate
    # The point of the axis that is nearest to the link's origin.
    point = item.origin + np.cross(axis, at_origin) / rate
    text = f"{who} {'turn' if several else 'turns'} about {_direction(axis)} through "
    text += _vector(point, length)
    if abs(float(axis @ at_origin)) > _SAME * rate * length:
        text += f" and {'slide' if several else 'slides'} along it"
    return text


def _direction(vector: Array) -> str:
    """Return the direction of a line, which has no sign: its greatest component is positive."""
    greatest = vector[int(np.argmax(np.abs(vector) > 0.999 * np.max(np.abs(vector))))]
    return _vector(vector / np.copysign(np.linalg.norm(vector), greatest), 1.0)


def _vector(vector: Array, scale: float) -> str:
    cleaned = np.where(np.abs(vector) < _SAME * scale, 0.0, vector)
    return "(" + ", ".join(f"{value:.{_DIGITS}g}" for value in cleaned) + ")"
