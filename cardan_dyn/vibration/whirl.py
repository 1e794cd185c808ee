"""Whirl: whether a mode turns with the shafts that it moves, or against them."""

from __future__ import annotations

import numpy as np

from ..arrays import Array
from ..elements.link_motions import LinkMotions
from .periodic_grid import nodes
from .rotating_scene import RotatingScene

_POSITIONS = 16
_TURNS = 1e-3
"""Speed of a link [rad/s per rad/s of the drive] below which it does not turn."""
_ROUNDING = 1e-10
"""Motion across the axes of rotation, as a fraction of all motion, that is none."""


class WhirlSense:
    """Says how the modes of a rotating scene whirl.

    A mode moves each link's centre along an ellipse, and so does the tip of its small rotation.
    The areas of these ellipses, seen along the axis about which the link turns with the drive,
    are weighed with mass and with moment of inertia. Links that do not turn count for nothing.
    """

    def __init__(self, rotating: RotatingScene, q: Array, sense: float) -> None:
        """Look at how links move.

        Args:
            rotating: the scene.
            q: `(n,)` positions of the free coordinates.
            sense: +1 or -1, in which the drive turns.
        """
        mechanism, free = rotating.scene.mechanism, len(rotating.free)
        bodies = {body: name for name, (body, _) in mechanism.links.items() if body}
        self._inertia = [mechanism.model.inertias[body] for body in bodies]
        links = LinkMotions(mechanism, bodies.values())
        drive = nodes(_POSITIONS, rotating.period)
        places = np.column_stack([drive, np.repeat(q[None], len(drive), axis=0)])
        scene = rotating.scene
        # All joints, whatever the outputs are: links are placed by their motion.
        if scene.outputs != tuple(scene.mechanism.joints):
            scene = scene.replace(outputs=None)
        moved = []
        for unit in np.eye(1 + free):
            motion = scene.sweep(places, unit).motion
            found = links.at(np.asarray(motion._x), np.asarray(motion.v))
            moved.append([found[name] for name in bodies.values()])
        shape = (len(bodies), _POSITIONS, 3)
        self._axis = np.zeros(shape)
        self._spin = np.zeros((*shape, free))
        self._velocity = np.zeros((*shape, free))
        for index, inertia in enumerate(self._inertia):
            arm = moved[0][index].rotation @ inertia.lever
            spin = sense * moved[0][index].spin
            size = np.linalg.norm(spin, axis=-1, keepdims=True)
            self._axis[index] = np.where(size > _TURNS, spin / np.maximum(size, _TURNS), 0.0)
            for column in range(free):
                link = moved[1 + column][index]
                self._spin[index, :, :, column] = link.spin
                self._velocity[index, :, :, column] = link.velocity + np.cross(link.spin, arm)

    def of(self, shapes: Array) -> Array:
        """Return the sense `(m,)` of mode shapes `(n, m)`: from -1, backward, to +1, forward."""
        forward, size, whole = np.zeros((3, shapes.shape[1]))
        for index, inertia in enumerate(self._inertia):
            # Housings have no sense of rotation of their own, however heavy they are.
            turns = np.any(self._axis[index], axis=-1)[:, None]
            weights = (float(np.trace(inertia.inertia)) / 3.0, float(inertia.mass))
            for weight, moved in zip(weights, (self._spin, self._velocity), strict=True):
                # The part of the swing along the link's own axis is no whirl.
                ends = np.einsum("kin,nm->kmi", moved[index], shapes)
                whole += weight * np.mean(np.sum(np.abs(ends) ** 2, axis=-1), axis=0)
                axis = self._axis[index][:, None, :]
                ends = ends - np.sum(ends * axis, axis=-1, keepdims=True) * axis
                turned = np.cross(ends.real, -ends.imag)
                forward += weight * np.mean(2.0 * np.sum(turned * axis, axis=-1), axis=0)
                size += weight * np.mean(turns * np.sum(np.abs(ends) ** 2, axis=-1), axis=0)
        is_there = size > _ROUNDING**2 * whole
        return np.where(is_there, forward / np.where(is_there, size, 1.0), 0.0)


def sense_name(sense: float) -> str:
    """Return the word for a sense: `forward`, `backward`, or `planar`."""
    if abs(sense) < 0.1:
        return "planar"
    return "forward" if sense > 0.0 else "backward"
