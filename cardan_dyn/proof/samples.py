"""Samples: a claim as scalars, which the proof computes with whatever they are.

Of one sample they are floats. Of several they are arrays `(N,)`, side by side; what is the same for
all of them is a float. What is zero everywhere is the float 0.0, so that nothing is computed with
what does not act.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from ..arrays import Array
from ..tape import Scalar, is_zero
from .placing import WORLD_AXES, Fixed, Frame
from .screws import Screw, in_world
from .vectors import ZERO, Vector

if TYPE_CHECKING:
    from ..mechanism.frames import Frames
    from .element_loads import ElementLoads
    from .residuals import Claim

Scalars: TypeAlias = Sequence[Scalar]


class Push(NamedTuple):
    """A load that acts on a body.

    Attributes:
        body: index of it.
        place: of its link and the point at which it acts, in the body's frame; None for what is
            about the corner and in world axes.
        in_world: whether force and moment are in world axes all the same.
        wrench: force [N], and moment about the point [N·m].
    """

    body: int
    place: Fixed | None
    in_world: bool
    wrench: Screw

    def on(self, placed: Sequence[Frame]) -> Screw:
        """Return the wrench about the corner in world axes, with the frames of motions placed."""
        if self.place is None:
            return self.wrench
        frame = self.place.on(placed[self.place.motion])
        if self.in_world:
            frame = frame._replace(axes=WORLD_AXES)
        return in_world(self.wrench, frame)


class Sample(NamedTuple):
    """A claim of one sample, or of all side by side; see `Claim` for what its fields are.

    Attributes:
        moves: whether `v` and `a` count; at rest they are zero.
        ratios: per drive, all joint velocities at unit speed of this drive.
        wrenches: of the claimed joints, each in its frame.
        pushes: what acts on bodies: loads on links, elements.
    """

    x: Scalars
    turns: Scalars
    moves: bool
    v: Scalars
    a: Scalars
    positions: Scalars
    speeds: Scalars
    accelerations: Scalars
    held: Scalars
    ratios: Sequence[Scalars]
    wrenches: Sequence[Screw]
    exerted: Scalars
    couplings: Scalars
    loads: Scalars
    pushes: Sequence[Push]
    gravity: Vector
    inertia: Mapping[str, Scalar]


def sample_of(claim: Claim, frames: Frames, elements: ElementLoads | None) -> Sample:
    """Return a claim as scalars.

    Args:
        claim: of N samples.
        frames: of the description.
        elements: what they exert at these samples.
    """
    loads = claim.loads if elements is None else claim.loads + elements.efforts.T
    still = [0.0] * claim.v.shape[1]
    pushes = []
    for link, load in claim.link_loads.items():
        body, placement = frames.links[link]
        place = placement.copy()
        place[:3, 3] += placement[:3, :3] @ load.point
        (force,), (moment,) = _vectors(load.force), _vectors(load.moment)
        fixed = Fixed.of(frames.last[body], place)
        pushes.append(Push(body, fixed, load.in_world, (force, moment)))
    for body, pushed in () if elements is None else elements.wrenches:
        force, moment = _vectors(pushed.reshape(6, -1).T)
        pushes.append(Push(body, None, True, (force, moment)))
    vectors = _vectors(claim.wrenches)
    ratios, drives = _columns(claim.velocity_ratios), claim.velocity_ratios.shape[2]
    (gravity,) = _vectors(claim.gravity)
    return Sample(
        x=_columns(claim.x),
        turns=_columns(claim.turns),
        moves=claim.has_rates,
        v=_columns(claim.v) if claim.has_rates else still,
        a=_columns(claim.a) if claim.has_rates else still,
        positions=_columns(claim.positions),
        speeds=_columns(claim.speeds),
        accelerations=_columns(claim.accelerations),
        held=_columns(claim.held),
        ratios=[ratios[drive::drives] for drive in range(drives)],
        wrenches=list(zip(vectors[::2], vectors[1::2], strict=True)),
        exerted=_columns(claim.exerted),
        couplings=_columns(claim.couplings),
        loads=_columns(loads),
        pushes=pushes,
        gravity=gravity,
        inertia={link: _columns(factor)[0] for link, factor in claim.inertia.items()},
    )


def _columns(values: Array) -> list[Scalar]:
    """Return `(N, …)` numbers, or `(1, …)` that hold for all samples, as scalars in a row."""
    if len(values) == 1:
        return values.ravel().tolist()
    columns: Array = np.ascontiguousarray(
        values.reshape(len(values), math.prod(values.shape[1:])).T
    )
    acting: list[bool] = np.any(columns, axis=1).tolist()
    return [column if acts else 0.0 for column, acts in zip(columns, acting, strict=True)]


def _vectors(values: Array) -> list[Vector]:
    """Return the same as vectors, of each three in a row."""
    row = _columns(values)
    vectors = []
    for start in range(0, len(row), 3):
        x, y, z = row[start : start + 3]
        vectors.append(ZERO if is_zero(x) and is_zero(y) and is_zero(z) else (x, y, z))
    return vectors
