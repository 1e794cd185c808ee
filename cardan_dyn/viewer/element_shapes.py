"""Element shapes of the viewer: springs as coils that stretch, bushings as balls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..elements.bushing import Bushing
from ..elements.link_motions import LinkMotions
from ..elements.point_spring import PointSpring
from ..results.sweep import Sweep
from . import shapes as forms
from .commands import Color, Drawing, Pose, mesh, meshcat, node_name

SPRING = Color.of("#d17b00")
BUSHING = Color.of("#8d6e63", opacity=0.8, on_top=True, layer=2)

# Lengths in the drawing are fractions of the radius of the scene, chosen for legibility.
_COIL_RADIUS, _WIRE_RADIUS, _BALL_RADIUS = 0.03, 0.005, 0.035
_WINDINGS, _STEPS, _STRAIGHT = 8, 12, 0.15
"""Windings of a coil, steps of a winding, and the part of its length that is straight at each end:
a spring that everybody knows as one."""
_LEAST_LENGTH = 1e-5
"""Least length of a coil, as a fraction of that radius; a scale of zero has no inverse."""


class Drawn(NamedTuple):
    """What was drawn of elements.

    Attributes:
        legend: CSS colour and meaning.
        points: `(n, 3)` what the camera has to see [m].
    """

    legend: list[tuple[str, str]]
    points: Array


def draw_elements(drawing: Drawing, sweep: Sweep, samples: Array, radius: float) -> Drawn:
    """Draw the point springs and bushings of a sweep; other elements have no place.

    Args:
        drawing: what they are drawn on.
        sweep: over one dimension.
        samples: `(n,)` indices of the samples that are shown.
        radius: of the scene [m].
    """
    elements = sweep.elements
    motions = LinkMotions(sweep.mechanism, {link for item in elements for link in item.links})
    rows = sweep.motion.rows[samples]
    links = motions.at(rows, np.zeros((len(rows), sweep.mechanism.model.nv)))
    legend: dict[str, str] = {}
    points = [np.zeros((0, 3))]

    def point(link: str, place: Array) -> Array:
        """Return where a point `(3,)` of a link is, `(n, 3)` [m]."""
        at = links[link].rotation @ place + links[link].position + motions.corner
        return np.broadcast_to(at, (len(rows), 3))

    for index, element in enumerate(elements):
        path = f"/elements/{node_name(element.name or str(index))}"
        if isinstance(element, PointSpring):
            start = point(element.link_a, element.point_a)
            span = point(element.link_b, element.point_b) - start
            points += [start, start + span]
            _draw_coil(drawing, path, start, span, radius)
            legend[SPRING.css] = "spring between two points"
        elif isinstance(element, Bushing):
            middle = point(element.link_a, element.origin[:3, 3])
            points.append(middle)
            drawing.place(path, Pose.of(middle))
            drawing.add(path, meshcat().geometry.Sphere(_BALL_RADIUS * radius), BUSHING)
            legend[BUSHING.css] = "bushing"
    return Drawn(list(legend.items()), np.concatenate(points))


def _draw_coil(drawing: Drawing, path: str, start: Array, span: Array, radius: float) -> None:
    """Draw a coil from points `(n, 3)` along vectors `(n, 3)` [m]."""
    direction, length = forms.filled(span, _LEAST_LENGTH * radius)
    scale = np.ones((len(span), 3))
    scale[:, 2] = np.maximum(length, _LEAST_LENGTH * radius)
    # The coil has the length 1: only that is stretched. Its wire is as thick across as it is wide.
    wire = forms.path(coil(_COIL_RADIUS * radius), _WIRE_RADIUS * radius)
    drawing.place(path, Pose.of(start, forms.towards(direction), scale))
    drawing.add(path, mesh(wire), SPRING)


def coil(radius: float) -> Array:
    """Return the points `(n, 3)` of a coil of length 1 along z, with straight ends on its axis.

    Args:
        radius: of the windings.
    """
    turn = np.linspace(0.0, 2.0 * np.pi * _WINDINGS, _WINDINGS * _STEPS + 1)
    height = np.linspace(_STRAIGHT, 1.0 - _STRAIGHT, len(turn))
    windings = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
    low, high = [[0.0, 0.0, 0.0], [0.0, 0.0, _STRAIGHT]], [[0.0, 0.0, 1.0 - _STRAIGHT], [0, 0, 1]]
    return np.concatenate([low, windings, high])
