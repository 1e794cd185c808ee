"""Samples: a claim as scalars, which the proof computes with whatever they are.

Its numbers stand in rows. Of one sample they become floats, of several, arrays `(N,)`, but floats
where they are the same for all; while a text is traced, they are variables. What is zero everywhere
is the float 0.0, so that nothing is computed with what does not act.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from ...kit.arrays import Array
from ..tape import Scalar, Trace, is_zero
from .placing import WORLD_AXES, Fixed, Frame
from .screws import Screw, in_world
from .vectors import ZERO, Vector, add, combine, total

if TYPE_CHECKING:
    from ..mechanism.frames import Frames
    from .element_loads import ElementLoads
    from .residuals import Claim

Scalars: TypeAlias = Sequence[Scalar]

_BY_CHANCE = {"x", "turns", "positions", "held", "wrenches"}
"""Rows that are zero at some samples and not at others, so that it is of no use to know."""
_OF_LOAD = "point", "force", "moment"
"""Rows of a load on a link."""


class Push(NamedTuple):
    """A load that acts on a body.

    Attributes:
        body: index of it.
        place: of its link; None for what is about the corner and in world axes.
        point: at which it acts, in the link's frame.
        in_world: whether force and moment are in world axes all the same.
        wrench: force [N], and moment about the point [N·m].
    """

    body: int
    place: Fixed | None
    point: Vector
    in_world: bool
    wrench: Screw

    def on(self, placed: Sequence[Frame]) -> Screw:
        """Return the wrench about the corner in world axes, with the frames of motions placed."""
        if self.place is None:
            return self.wrench
        axes, origin = self.place.on(placed[self.place.motion])
        point = add(origin, combine(axes, self.point))
        return in_world(self.wrench, Frame(WORLD_AXES if self.in_world else axes, point))


class Sample(NamedTuple):
    """A claim of one sample, or of all side by side; see `Claim` for what its fields are.

    Attributes:
        moves: whether anything does; if not, `v` and `a` have to be zero.
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


class Rows:
    """The numbers of a claim in rows.

    Attributes:
        kind: all that decides which rows there are, beside the description: claims of one kind have
            the same. First, whether anything moves.
        count: number of samples.
        ratios: number of velocity ratios of each.
        parts: arrays `(k, N)` of rows, or `(k, 1)` where they are the same for all samples.
    """

    def __init__(self, claim: Claim, elements: ElementLoads | None) -> None:
        """Take a claim apart.

        Args:
            claim: of N samples.
            elements: what they exert at these samples.
        """
        self.count = count = len(claim.x)
        _, rates, self._drives = claim.velocity_ratios.shape
        self.ratios = rates * self._drives
        given = [claim.speeds, claim.accelerations, claim.held, claim.loads, claim.gravity]
        links, pushed = [], []
        for link, load in claim.link_loads.items():
            links.append((link, load.in_world))
            given += load.point[None], load.force, load.moment
        given += [factor[:, None] for factor in claim.inertia.values()]
        # Of one sample, all that may be the same for several counts as if it were.
        same = [len(array) == 1 for array in given]
        own = [
            claim.x,
            claim.turns,
            claim.positions,
            claim.velocity_ratios.reshape(count, self.ratios),
            claim.wrenches.reshape(count, 6 * claim.wrenches.shape[1]),
            claim.exerted,
            claim.couplings,
            claim.v,
            claim.a,
        ]
        if elements is not None:
            own.append(elements.efforts.T)
            for body, wrench in elements.wrenches:
                pushed.append(body)
                own.append(wrench.reshape(6, count).T)
        has_elements = elements is not None
        what = has_elements, (*same,), (*links,), (*pushed,), (*claim.inertia,)
        self.kind: tuple[Any, ...] = claim.has_rates, *what
        self.parts = [array.T for array in (*given, *own)]

    @property
    def names(self) -> list[Hashable]:
        """What each part is of."""
        _, has_elements, _, links, pushed, factors = self.kind
        names: list[Hashable] = ["speeds", "accelerations", "held", "loads", "gravity"]
        names += [(part, *link) for link in links for part in _OF_LOAD]
        names += [("inertia", link) for link in factors]
        names += ["x", "turns", "positions", "ratios", "wrenches", "exerted", "couplings"]
        names += ["v", "a"]
        names += ["efforts", *[("element", *k) for k in enumerate(pushed)]] if has_elements else []
        return names

    @property
    def scalars(self) -> list[Scalar]:
        """The rows as numbers and arrays."""
        scalars: list[Scalar] = []
        for part in self.parts:
            if part.shape[1] == 1:
                scalars += part[:, 0].tolist()
            else:
                acts = np.asarray(part.any(axis=1)).tolist()
                rows = zip(np.ascontiguousarray(part), acts, strict=True)
                scalars += [row if acts else 0.0 for row, acts in rows]
        return scalars

    def acting(self) -> Array:
        """Return which rows are not zero at all samples, or are so by chance alone."""
        parts = zip(self.names, self.parts, strict=True)
        acting = [part.any(axis=1) | (name in _BY_CHANCE) for name, part in parts]
        return np.concatenate(acting)

    def variables(self, trace: Trace) -> list[Scalar]:
        """Return the rows as inputs of a trace."""
        same = dict(zip(self.names, self.kind[2], strict=False))
        variables: list[Scalar] = []
        for name, part in zip(self.names, self.parts, strict=True):
            for _ in part:
                is_uniform = same.get(name, False)
                # No decision is taken by shadows.
                variables.append(trace.input(str(len(variables)), 0.0, uniform=is_uniform))
        return variables

    def sample(self, scalars: Scalars, frames: Frames) -> Sample:
        """Return a claim of which all rows are scalars.

        Args:
            scalars: one for each row.
            frames: of the description.
        """
        moves, given = self.kind[0], iter(scalars)
        rows: dict[Any, list[Scalar]] = {
            name: list(islice(given, len(part)))
            for name, part in zip(self.names, self.parts, strict=True)
        }
        loads = rows["loads"]
        if "efforts" in rows:
            loads = [total(both) for both in zip(loads, rows["efforts"], strict=True)]
        pushes, inertia = [], {}
        for name, row in rows.items():
            if name[0] == "element":
                force, moment = _vectors(row)
                pushes.append(Push(name[2], None, ZERO, True, (force, moment)))
            elif name[0] == "inertia":
                (inertia[name[1]],) = row
            elif name[0] == "point":
                _, link, is_in_world = name
                body, placement = frames.link_frames[link]
                of_load = (_vectors(rows[part, link, is_in_world]) for part in _OF_LOAD)
                (point,), (force,), (moment,) = of_load
                place = Fixed.of(frames.last[body], placement)
                pushes.append(Push(body, place, point, is_in_world, (force, moment)))
        vectors = _vectors(rows["wrenches"])
        (gravity,) = _vectors(rows["gravity"])
        return Sample(
            x=rows["x"],
            turns=rows["turns"],
            moves=moves,
            v=rows["v"],
            a=rows["a"],
            positions=rows["positions"],
            speeds=rows["speeds"],
            accelerations=rows["accelerations"],
            held=rows["held"],
            ratios=[rows["ratios"][drive :: self._drives] for drive in range(self._drives)],
            wrenches=list(zip(vectors[::2], vectors[1::2], strict=True)),
            exerted=rows["exerted"],
            couplings=rows["couplings"],
            loads=loads,
            pushes=pushes,
            gravity=gravity,
            inertia=inertia,
        )


def _vectors(row: Scalars) -> list[Vector]:
    """Return scalars as vectors, of each three in a row."""
    vectors = []
    for start in range(0, len(row), 3):
        x, y, z = row[start : start + 3]
        vectors.append(ZERO if is_zero(x) and is_zero(y) and is_zero(z) else (x, y, z))
    return vectors
