"""Rods: the force along a link between two balls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kit.arrays import Array
from ...kit.errors import ModelError
from ...kit.frozen import Record
from .wrench import lost

_ENDS = ("spherical", "universal")
"""Types of joints at the ends of a rod: what they pass on goes through their centre."""


@dataclass(frozen=True, eq=False)
class RodForce(Record):
    """The force along a rod between two balls, **positive where it is in tension**.

    Both ends differ by what the rod's inertia, its weight and loads on it make up along its line.
    How the rod spins about its line plays no part.

    Attributes:
        link: name of the rod.
        joints: names of the joints at its two ends.
        tension: `(N,)` mean of both ends [N]: in the middle of a uniform rod.
        ends: `(N, 2)` tension at each of the joints [N].
        length: `(N,)` distance of the joints [m].
        unique: whether both ends follow from the laws of motion alone.
    """

    link: str
    joints: tuple[str, str]
    tension: Array
    ends: Array
    length: Array
    unique: bool

    def __repr__(self) -> str:
        known = self.tension[~np.isnan(self.tension)]
        told = f"{known.min():.4g} to {known.max():.4g} N" if known.size else "nothing known"
        return (
            f"<RodForce of {self.link!r} between {' and '.join(map(repr, self.joints))}, tension "
            f"positive: {told}{'' if self.unique else ', not unique'}{lost(self.tension)}>"
        )


def rod_force(sweep: Any, link: str) -> RodForce:
    """Return the force along a rod; see `Sweep.rod_force`."""
    mechanism, frames = sweep.mechanism, sweep.mechanism.frames
    mechanism.link(link)
    body, _ = frames.links[link]
    kinds = {item.name: item.type for item in mechanism.description.joints_and_loops}
    # A floating joint only says where the rod is.
    signs = {
        name: 1.0 if frames.children[index] == body else -1.0
        for index, name in enumerate(frames.joints)
        if body >= 0
        and body in (frames.children[index], frames.parents[index])
        and kinds[name] != "floating"
    }
    listed = ", ".join(f"{name} ({kinds[name]})" for name in signs) or "none"
    if len(signs) != 2 or not all(kinds[name] in _ENDS for name in signs):
        raise ModelError(
            f"link {link!r} is no rod between two balls; its joints: {listed}. Forces of other "
            f"links are those of their joints: sweep.wrench(joint, {link!r}).force",
            name=link,
        )
    first, second = signs
    line = sweep.origin(second) - sweep.origin(first)
    length = np.linalg.norm(line, axis=-1)
    if not np.all(length > 0.0):
        raise ModelError(
            f"link {link!r} has no line: its joints {first!r} and {second!r} are at one point",
            name=link,
        )
    line = line / length[..., None]
    ends, unique = [], True
    for name, outwards in ((first, -line), (second, line)):
        along = signs[name] * np.sum(sweep.wrench(name, "world").force * outwards, axis=-1)
        ends.append(along)
        own = np.swapaxes(sweep.rotation(name), -1, -2) @ outwards[..., None]
        maps = np.concatenate([own, np.zeros_like(own)], axis=-2)[..., 0][..., None, :]
        unique = unique and bool(np.all(sweep._unique_sums(name, maps, np.ones(1, dtype=bool))))
    both = np.stack(ends, axis=-1)
    return RodForce(link, (first, second), np.mean(both, axis=-1), both, length, unique)
