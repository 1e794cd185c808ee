"""Load shapes of the viewer: what acts on joints and links from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...core.elements.link_loads import Wrench
from ...core.results.sweep import Sweep
from ...figures.wrenches import PARTS
from ...kit.arrays import NOTHING, Array
from . import shapes as forms
from .commands import Color, Drawing, node_name
from .places import Places
from .vectors import Vectors, greatest

LOAD = Color.of("#b71c1c", layer=7)
DRIVE = Color.of("#00695c", opacity=0.5, layer=2)
GRAVITY = Color.of("#455a64", layer=2)
_ARC = 0.17
"""Radius of the arc of a turn that is driven and of the greatest moment, in radii of the scene."""
_LEAST = 0.35
"""Least size of an arc or arrow, as a fraction of the greatest, so that its sense is seen."""


def draw_loads(drawing: Drawing, sweep: Sweep, places: Places) -> None:
    """Draw the loads of a sweep; forces end where they act, moments go about their axes.

    The nodes are `/loads/NAME force` and `/loads/NAME moment`. Forces have a scale of their own,
    as moments have: a load of another kind than what joints carry need not be seen beside it.

    Args:
        drawing: what they are drawn on.
        sweep: over one dimension.
        places: of the sweep.
    """
    radius = drawing.size
    acting, means = _acting(sweep, places), "load, not to the scale of the others"
    for kind in ("force", "moment"):
        drawn = [(name, at, vector) for name, what, at, vector in acting if what == kind]
        most = max((greatest(vector) for _, _, vector in drawn), default=0.0)
        for name, at, vector in drawn:
            if not greatest(vector) > 0.0:
                continue
            direction, size = forms.filled(vector, 1e-9 * most)
            share = np.where(size > 0.0, np.maximum(size / most, _LEAST), 0.0)
            path, shown = f"/loads/{node_name(name)} {kind}", share[:, None] * radius * direction
            if kind == "force":
                drawing.arrow(path, at - forms.ARROW * shown, forms.ARROW * shown, LOAD, means)
            else:
                drawing.arrow(path, at, _ARC * shown, LOAD, means, forms.arc_arrow())


def without_loads(vectors: list[Vectors], sweep: Sweep, places: Places) -> list[Vectors]:
    """Return vectors without the parts that are nothing but a load, which is drawn as such."""
    loads = {
        (sweep.mechanism.drivable[name].joint, PARTS[kind][0]): acting
        for name, kind, _, acting in _acting(sweep, places)
        if not isinstance(sweep.loads[name], Wrench)
    }

    def is_load(joint: str, kind: str, part: Array) -> bool:
        load = loads.get((joint, kind))
        return load is not None and greatest(part - load) <= NOTHING * greatest(load)

    return [
        item._replace(
            parts={
                kind: part
                for kind, part in item.parts.items()
                if not is_load(item.name, kind, part)
            },
        )
        for item in vectors
    ]


def draw_drives(drawing: Drawing, places: Places, drives: Sequence[str]) -> None:
    """Draw the sense in which some drives grow: an arc about its axis, or an arrow along it.

    The nodes are `/drive/NAME`. Arcs keep clear of each other, as far as their sense is still seen.
    """
    radius, means = drawing.size, "drive: sense in which it grows"
    known = {name: axis for name in drives if (axis := places.axis(name)) is not None}
    for name, axis in known.items():
        path, at = f"/drive/{node_name(name)}", axis.origin
        if axis.slides:
            # Half as long as the greatest arrow: it says nothing but a direction.
            drawing.arrow(path, at, 0.5 * forms.ARROW * radius * axis.direction, DRIVE, means)
            continue
        arcs = [other.origin for key, other in known.items() if key != name and not other.slides]
        gaps = [np.min(np.linalg.norm(at - other, axis=-1)) for other in arcs]
        size = np.clip(0.5 * min(gaps, default=radius), _LEAST * _ARC * radius, _ARC * radius)
        drawing.arrow(path, at, size * axis.direction, DRIVE, means, forms.arc_arrow())


def draw_gravity(drawing: Drawing, gravity: Array, points: Array) -> None:
    """Draw gravity as one arrow beside a mechanism, at `/loads/gravity`.

    Args:
        drawing: what it is drawn on.
        gravity: `(3,)` [m/s²].
        points: `(n, 3)` between which the mechanism moves [m].
    """
    down = gravity / np.linalg.norm(gravity)
    beside = np.min(points, axis=0) - [0.15 * drawing.size, 0.0, 0.0]
    # From as high as the mechanism reaches: scales cover the lower corner of the picture.
    tail = beside + (np.min(points @ down) - beside @ down) * down
    shown = 0.5 * forms.ARROW * drawing.size * down
    drawing.arrow("/loads/gravity", tail[None], shown[None], GRAVITY, "gravity: its direction")


def _acting(sweep: Sweep, places: Places) -> list[tuple[str, str, Array, Array]]:
    """Return name, kind, place `(n, 3)` [m] and vector `(n, 3)` of loads in world axes.

    None of a load on something whose motion the sweep leaves out.
    """
    found = []
    for name, load in sweep.loads.items():
        if isinstance(load, Wrench):
            at = places.point(name, np.asarray(load.point))
            for kind, values in (("force", load.force), ("moment", load.moment)):
                vector = _of_samples(np.asarray(values), places.samples, trailing=1)
                if load.frame != "world":
                    vector = np.einsum("...ij,...j->...i", places.link(name).rotation, vector)
                if np.all(np.isfinite(at)):
                    found.append((name, kind, at, np.broadcast_to(vector, at.shape)))
        elif axis := places.axis(name):
            kind = "force" if axis.slides else "moment"
            size = _of_samples(load, places.samples)[..., None]
            found.append((name, kind, axis.origin, size * axis.direction))
    return found


def _of_samples(values: Array, samples: Array, trailing: int = 0) -> Array:
    """Return values `(..., trailing)` at samples, or those of all samples."""
    varies = values.ndim > trailing and len(values) > 1
    return np.asarray(values[samples] if varies else values)
