"""A line of shafts with universal joints, from the directions of shafts and pins alone.

A joint's two pins and its cross are vectors: the driving pin turns with its shaft, the driven pin
is normal to it and to the next shaft, and the massless cross passes on a moment normal to both
(D. Thoma, Schweizerische Bauzeitung 75, 1920). No formula of a joint's motion is used, and nothing
here knows the package under test. Vectors are arrays `(N, 3)` in world axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


def unit(vectors: Array) -> Array:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def dot(a: Array, b: Array) -> Array:
    return np.sum(a * b, axis=-1)


def across(vectors: Array, axis: Array) -> Array:
    """Return the part of vectors normal to a unit axis."""
    return vectors - dot(vectors, axis)[..., None] * axis


def turned(vectors: Array, axis: Array, angle: Array) -> Array:
    """Return vectors that are normal to a unit axis, turned about it."""
    angle = np.asarray(angle)[..., None]
    return np.cos(angle) * vectors + np.sin(angle) * np.cross(axis, vectors)


def about(axis: str, angle: float) -> Array:
    """Return the rotation about a coordinate axis x, y or z."""
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    result = np.eye(3)
    result[first, first] = result[second, second] = np.cos(angle)
    result[second, first], result[first, second] = np.sin(angle), -np.sin(angle)
    return result


@dataclass(frozen=True)
class ShaftLine:
    """Pins of all joints of a line over the rotation of its input.

    Attributes:
        shafts: `(n + 1, 3)` unit vectors of the shafts along the power flow.
        driving, driven: per joint `(N, 3)` unit vectors of both pins.
    """

    shafts: Array
    driving: list[Array]
    driven: list[Array]

    @classmethod
    def turn(
        cls, shafts: Array, pin: Array, rotation: Array, offsets: tuple[float, ...] = ()
    ) -> ShaftLine:
        """Turn a line of shafts.

        Args:
            shafts: `(n + 1, 3)` unit vectors along the power flow.
            pin: `(3,)` driving pin of joint 1 at rotation zero, normal to the first shaft.
            rotation: `(N,)` of the input shaft [rad].
            offsets: angles from each driven pin to the next joint's driving pin on their common
                shaft, in the sense of rotation [rad].
        """
        here = turned(pin, shafts[0], rotation)
        driving, driven = [], []
        for number, shaft in enumerate(shafts[1:]):
            driving.append(here)
            # Nearest to where the pin stands in a straight joint, a quarter turn ahead.
            driven.append(unit(np.cross(shaft, here)))
            if number < len(offsets):
                here = turned(driven[-1], shaft, np.array(offsets[number]))
        return cls(shafts, driving, driven)

    @property
    def normals(self) -> list[Array]:
        """Normals of the crosses `(N, 3)`, along which they pass on their moments."""
        return [unit(np.cross(a, b)) for a, b in zip(self.driving, self.driven, strict=True)]

    def moments(self, output_torque: Array | float) -> list[Array]:
        """Return the moment `(N, 3)` of each cross on the next shaft.

        Args:
            output_torque: torque about the last shaft that the last cross exerts on it [N·m].
        """
        moments: list[Array] = []
        torque = output_torque
        for normal, shaft, before in zip(
            reversed(self.normals), self.shafts[:0:-1], self.shafts[-2::-1], strict=True
        ):
            moment = np.asarray(torque / dot(normal, shaft))[..., None] * normal
            moments.insert(0, moment)
            torque = dot(moment, before)
        return moments

    def output_rotation(self, zero: Array, sideways: Array) -> Array:
        """Return the rotation `(N,)` of the last shaft [rad], continuous along the samples.

        Args:
            zero: `(3,)` where the last driven pin points at rotation zero.
            sideways: `(3,)` where it points a quarter turn later.
        """
        pin = self.driven[-1]
        # A pin looks the same after half a turn.
        return np.unwrap(np.arctan2(dot(pin, sideways), dot(pin, zero)), period=np.pi)


def single_joint(beta: float, rotation: Array, *, normal: bool = False) -> Array:
    """Return the output rotation of one joint, tan φ₂ = tan φ₁ / cos β, over any turns.

    Args:
        beta: joint angle [rad].
        rotation: of the input, counted from where its pin lies in the plane of the shafts, or
            normal to it.
    """
    cosine = 1.0 / np.cos(beta) if normal else np.cos(beta)
    turns = np.round(rotation / np.pi)
    rest = rotation - np.pi * turns
    return np.arctan2(np.sin(rest), cosine * np.cos(rest)) + np.pi * turns


def single_ratio(beta: float, rotation: Array, *, normal: bool = False) -> Array:
    """Return dφ₂/dφ₁ of one joint, cos β / (cos²β cos²φ₁ + sin²φ₁) with the pin in the plane."""
    cosine, sine = (np.sin, np.cos) if normal else (np.cos, np.sin)
    return np.cos(beta) / ((np.cos(beta) * cosine(rotation)) ** 2 + sine(rotation) ** 2)
